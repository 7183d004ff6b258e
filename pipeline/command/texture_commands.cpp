#include "pipeline/command/texture_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "formats/environment.h"
#include "formats/gltf_scene.h"
#include "formats/nearest.h"
#include "pipeline/assets/textures.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"
#include "pipeline/scene/scene.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Image;
using formats::PixelFormat;
using formats::Result;

/// Beyond these a half has nothing to tell apart.
constexpr float kLeastMetricScale = 1e-6f, kLargestMetricScale = 65504;

std::string lowerExtension(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return std::tolower(c); });
    return extension;
}

bool isTextureFile(const std::filesystem::path& file) {
    return lowerExtension(file) == ".ktx2" || lowerExtension(file) == ".dds";
}

Result<PixelFormat> formatFromName(const std::string& name) {
    if (const auto format = formats::pixelFormatFromName(name)) return *format;
    std::vector<std::string> known;
    for (const formats::PixelFormatInfo& each : formats::allPixelFormats()) known.emplace_back(each.name);
    return failure(
        ErrorCode::InvalidRequest, "--format",
        fmt::format("found '{}', expected one of: {}; nearest is '{}'", name, fmt::join(known, " "), formats::nearestName(name, known)));
}

/// Refuses, or with `repair` mends and counts, what the format cannot mean.
Result<std::int64_t> checkTexels(Image<glm::vec4>& texels, const std::filesystem::path& file, const formats::PixelFormatInfo& format,
                                 bool repair) {
    std::int64_t repaired = 0;
    const int channels = std::min(format.channelCount, 4);
    for (int y = 0; y < texels.height(); ++y)
        for (int x = 0; x < texels.width(); ++x)
            for (int c = 0; c < channels; ++c) {
                float& value = texels.at(x, y)[c];
                const bool isBroken = !std::isfinite(value), isNegative = value < 0 && !format.isSigned;
                if (!isBroken && !isNegative) continue;
                if (!repair)
                    return failure(
                        isBroken ? ErrorCode::ValueNotFinite : ErrorCode::ValueOutOfRange,
                        fmt::format("{}, channel {}, texel ({}, {})", file.string(), "RGBA"[c], x, y),
                        isBroken ? fmt::format("found {}, expected a finite value (--repair makes it zero)", value)
                                 : fmt::format("found {}, expected no negative value in {} (--repair makes it zero)", value, format.name));
                value = 0;
                ++repaired;
            }
    return repaired;
}

/// Weights of texels from the first channel of an image, the largest 1.
Result<Image<float>> readSignificance(const std::filesystem::path& file, int width, int height) {
    const auto image = formats::readImage(file);
    if (!image) return tl::make_unexpected(image.error());
    const Image<glm::vec4>& texels = image->texels;
    if (texels.width() != width || texels.height() != height)
        return failure(ErrorCode::WrongShape, file.string(),
                       fmt::format("found {} x {} texels, expected {} x {} as in the image to encode", texels.width(), texels.height(),
                                   width, height));
    float largest = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float weight = texels.at(x, y)[0];
            if (!std::isfinite(weight) || weight < 0)
                return failure(std::isfinite(weight) ? ErrorCode::ValueOutOfRange : ErrorCode::ValueNotFinite,
                               fmt::format("{}, texel ({}, {})", file.string(), x, y),
                               fmt::format("found a significance of {}, expected a finite one of at least 0", weight));
            largest = std::max(largest, weight);
        }
    Image<float> significance(width, height);
    // Only ratios count, and squares of huge weights would not be finite.
    for (std::size_t i = 0; i < significance.texels().size(); ++i)
        significance.texels()[i] = largest > 0 ? texels.texels()[i][0] / largest : 0.0f;
    return significance;
}

Result<compress::EncodeOptions> optionsOf(const EncodeCommand& command, const formats::PixelFormatInfo& format) {
    compress::EncodeOptions options;
    options.effort = command.effort;
    options.hdrMetric = command.metric;
    options.hdrScale = command.metricScale;
    if (!(command.metricScale >= kLeastMetricScale && command.metricScale <= kLargestMetricScale))
        return failure(ErrorCode::InvalidRequest, "--metric-scale",
                       fmt::format("found {}, expected {} to {}", command.metricScale, kLeastMetricScale, kLargestMetricScale));
    float largest = 0;
    bool areValid = true;
    for (std::size_t c = 0; c < 4; ++c) {
        const float weight = command.channelWeights[c];
        areValid = areValid && std::isfinite(weight) && weight >= 0;
        if (static_cast<int>(c) < format.channelCount) largest = std::max(largest, weight);
    }
    if (!areValid || !(largest > 0))
        return failure(ErrorCode::InvalidRequest, "--weights",
                       fmt::format("found {}, expected four finite numbers of at least 0, one of the {} that {} has above 0",
                                   fmt::join(command.channelWeights, ","), format.channelCount, format.name));
    for (std::size_t c = 0; c < 4; ++c)
        options.channelWeights[c] = static_cast<int>(c) < format.channelCount ? command.channelWeights[c] / largest : 1.0f;
    if (!(command.rdo >= 0 && command.rdo <= kLargestRdo))
        return failure(ErrorCode::InvalidRequest, "--rdo", fmt::format("found {}, expected 0 to {}", command.rdo, kLargestRdo));
    if (command.rdo > 0 && !compress::supportsRdo(format.format))
        return failure(ErrorCode::InvalidRequest, "--rdo",
                       fmt::format("found format {}, expected one of BC1 to BC7: only their blocks repeat", format.name));
    options.rdo = static_cast<float>(command.rdo);
    return options;
}

struct ImageError {
    double squared = 0, squaredReference = 0, squaredLog = 0, largest = 0;
    std::int64_t count = 0;

    void add(double a, double b) {
        squared += (b - a) * (b - a);
        squaredReference += a * a;
        const double difference = std::log2(1 + std::max(b, 0.0)) - std::log2(1 + std::max(a, 0.0));
        squaredLog += difference * difference;
        largest = std::max(largest, std::abs(b - a));
        ++count;
    }
    Json toJson() const {
        const double n = static_cast<double>(std::max<std::int64_t>(count, 1));
        const double logRms = std::sqrt(squaredLog / n);
        return {{"rmse", std::sqrt(squared / n)},
                {"rel_rmse", squaredReference > 0 ? std::sqrt(squared / squaredReference)
                                                  : (squared > 0 ? std::numeric_limits<double>::infinity() : 0.0)},
                {"log2_psnr_db", logRms > 0 ? 20 * std::log10(1 / logRms) : std::numeric_limits<double>::infinity()},
                {"max_abs", largest}};
    }
};

/// One image of anything that we read: the first mip and layer of a texture, faces of a cubemap one under the other.
Result<formats::PlainImage> readAnyImage(const std::filesystem::path& file, int mip = 0, int layer = 0) {
    if (!isTextureFile(file)) return formats::readImage(file);
    const auto texture = formats::TextureReader::open(file);
    if (!texture) return tl::make_unexpected(texture.error());
    const formats::TextureShape& shape = texture->shape();
    if (mip < 0 || mip >= shape.mipCount || layer < 0 || layer >= shape.layerCount)
        return failure(ErrorCode::InvalidRequest, file.string(),
                       fmt::format("found mip {} and layer {} asked for, expected mip 0 to {} and layer 0 to {}", mip, layer,
                                   shape.mipCount - 1, shape.layerCount - 1));
    const int width = shape.mipWidth(mip), height = shape.mipHeight(mip);
    formats::PlainImage image{Image<glm::vec4>(width, height * shape.faceCount), formats::info(shape.format).channelCount};
    for (int face = 0; face < shape.faceCount; ++face) {
        const auto decoded = verify::decodeImage(*texture, {mip, layer, face});
        if (!decoded) return tl::make_unexpected(decoded.error());
        for (int y = 0; y < height; ++y) std::copy_n(decoded->view().row(y), width, image.texels.view().row(face * height + y));
    }
    return image;
}

Result<Json> compareImages(const std::filesystem::path& a, const std::filesystem::path& b) {
    const auto first = readAnyImage(a), second = readAnyImage(b);
    if (!first) return tl::make_unexpected(first.error());
    if (!second) return tl::make_unexpected(second.error());
    if (first->texels.width() != second->texels.width() || first->texels.height() != second->texels.height())
        return failure(ErrorCode::WrongShape, b.string(),
                       fmt::format("found {} x {} texels, expected {} x {} as in {}", second->texels.width(), second->texels.height(),
                                   first->texels.width(), first->texels.height(), a.string()));
    const int channels = std::min({first->channelCount, second->channelCount, 4});
    ImageError error;
    for (std::size_t i = 0; i < first->texels.texels().size(); ++i)
        for (int c = 0; c < channels; ++c)
            error.add(static_cast<double>(first->texels.texels()[i][c]), static_cast<double>(second->texels.texels()[i][c]));
    return error.toJson();
}

Json assetRow(const Json& asset) {
    const Json& error = asset.at("stages").back().at("error");
    return {{"bytes_gpu", asset.at("bytes_gpu")},
            {"bytes_disk", asset.at("bytes_disk")},
            {"diffuse_rel_rms", error.at("diffuse").at("rel_rms")},
            {"specular_rel_rms", error.at("specular").at("rel_rms")},
            {"passed", asset.at("passed")}};
}

Result<Json> compareScenes(const std::filesystem::path& a, const std::filesystem::path& b) {
    const auto first = readReport(a / kReportName), second = readReport(b / kReportName);
    if (!first) return tl::make_unexpected(first.error());
    if (!second) return tl::make_unexpected(second.error());
    std::map<std::string, std::pair<Json, Json>> rows;
    for (const Json& asset : first->at("assets")) rows[asset.at("name").get<std::string>()].first = assetRow(asset);
    for (const Json& asset : second->at("assets")) rows[asset.at("name").get<std::string>()].second = assetRow(asset);
    Json assets = Json::array();
    for (const auto& [name, row] : rows)
        assets.push_back({{"name", name}, {"a", row.first}, {"b", row.second}, {"same", row.first == row.second}});
    return Json{
        {"a_bytes_gpu", first->at("budget").at("used_bytes")}, {"b_bytes_gpu", second->at("budget").at("used_bytes")}, {"assets", assets}};
}

Json describeTexture(const formats::TextureReader& texture) {
    const formats::TextureShape& shape = texture.shape();
    return {{"container", texture.container() == formats::Container::Dds ? "dds" : "ktx2"},
            {"format", std::string(formats::info(shape.format).name)},
            {"width", shape.width},
            {"height", shape.height},
            {"mips", shape.mipCount},
            {"layers", shape.layerCount},
            {"faces", shape.faceCount},
            {"zstd", texture.isZstd()},
            {"bytes_gpu", shape.gpuBytes()},
            {"bytes_disk", texture.fileBytes()},
            {"metadata", texture.metadata()}};
}

Json describeImage(const formats::PlainImage& image) {
    const float infinity = std::numeric_limits<float>::infinity();
    float low = infinity, high = -infinity;
    std::int64_t notFinite = 0, negative = 0;
    const int channels = std::min(image.channelCount, 4);
    for (const glm::vec4& texel : image.texels.texels())
        for (int c = 0; c < channels; ++c) {
            if (!std::isfinite(texel[c])) {
                ++notFinite;
                continue;
            }
            low = std::min(low, texel[c]);
            high = std::max(high, texel[c]);
            negative += texel[c] < 0 ? 1 : 0;
        }
    return {{"width", image.texels.width()},
            {"height", image.texels.height()},
            {"channels", image.channelCount},
            {"minimum", low},
            {"maximum", high},
            {"not_finite", notFinite},
            {"negative", negative}};
}

Json describeScene(const Scene& scene) {
    Json json = {{"scene", scene.name},
                 {"target", std::string(nameOf(scene.output.target))},
                 {"light_map_layout", layoutAsked(scene.output)},
                 {"max_error", scene.output.maxError}};
    for (const auto& entry : scene.lightMaps) json["light_maps"].push_back(entry.name);
    for (const auto& entry : scene.probes) json["probes"].push_back(entry.name);
    for (const auto& entry : scene.gradients) json["gradients"].push_back(entry.name);
    return json;
}

Result<Json> describeFolder(const std::filesystem::path& folder) {
    const auto manifest = readManifest(folder);
    if (!manifest) return tl::make_unexpected(manifest.error());
    Json json = {
        {"scene", manifest->at("scene")}, {"tool", manifest->at("tool")}, {"target", manifest->at("target")}, {"assets", Json::array()}};
    for (const Json& asset : manifest->at("assets"))
        json["assets"].push_back({{"name", asset.at("name")},
                                  {"kind", asset.at("kind")},
                                  {"layout", asset.at("layout")},
                                  {"width", asset.at("width")},
                                  {"height", asset.at("height")},
                                  {"textures", asset.at("textures").size()}});
    return json;
}

}  // namespace

Result<Json> encodeTexture(const EncodeCommand& command, int threads) {
    const auto format = formatFromName(command.format);
    if (!format) return tl::make_unexpected(format.error());
    if (!isTextureFile(command.output))
        return failure(ErrorCode::InvalidRequest, command.output.string(),
                       fmt::format("found the extension '{}', expected .ktx2 or .dds", command.output.extension().string()));
    const auto options = optionsOf(command, formats::info(*format));
    if (!options) return tl::make_unexpected(options.error());
    auto image = formats::readImage(command.input);
    if (!image) return tl::make_unexpected(image.error());
    Image<glm::vec4>& texels = image->texels;
    const formats::PixelFormatInfo& facts = formats::info(*format);
    const auto repaired = checkTexels(texels, command.input, facts, command.repair);
    if (!repaired) return tl::make_unexpected(repaired.error());
    if (command.cube && texels.height() != 6 * texels.width())
        return failure(ErrorCode::WrongShape, command.input.string(),
                       fmt::format("found {} x {} texels, expected a vertical strip of six square faces", texels.width(), texels.height()));

    formats::TextureShape shape;
    shape.format = *format;
    shape.width = texels.width();
    shape.faceCount = command.cube ? 6 : 1;
    shape.height = texels.height() / shape.faceCount;
    TextureSettings settings;
    settings.container = lowerExtension(command.output) == ".dds" ? formats::Container::Dds : formats::Container::Ktx2;
    settings.zstd = command.zstd;
    formats::Image<float> significance;
    if (!command.significance.empty()) {
        auto read = readSignificance(command.significance, texels.width(), texels.height());
        if (!read) return tl::make_unexpected(read.error());
        significance = std::move(*read);
    }
    compress::EncodeReport report;
    std::vector<std::vector<std::byte>> images;
    const auto start = std::chrono::steady_clock::now();
    for (int face = 0; face < shape.faceCount; ++face) {
        const int top = face * shape.height;
        formats::ImageView<const float> weights = std::as_const(significance).view();
        if (weights.texels != nullptr) weights = weights.rows(top, shape.height);
        images.push_back(encodeImage(*format, texels.view().rows(top, shape.height), weights, *options, report));
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (auto written = writeTexture(command.output, shape, settings, {}, images); !written) return tl::make_unexpected(written.error());
    return Json{{"width", shape.width},
                {"height", shape.height},
                {"mips", shape.mipCount},
                {"layers", shape.layerCount},
                {"faces", shape.faceCount},
                {"format", std::string(facts.name)},
                {"bytes", shape.gpuBytes()},
                {"encode_seconds", seconds},
                {"threads", threads},
                {"clamped_high", report.clampedHigh},
                {"clamped_negative", report.clampedNegative},
                {"repaired", *repaired}};
}

Result<void> decodeTexture(const DecodeCommand& command) {
    if (!isTextureFile(command.input))
        return failure(ErrorCode::InvalidRequest, command.input.string(),
                       fmt::format("found the extension '{}', expected .ktx2 or .dds", command.input.extension().string()));
    const auto image = readAnyImage(command.input, command.mip, command.layer);
    if (!image) return tl::make_unexpected(image.error());
    return formats::writeExr(command.output, image->texels.view(), image->channelCount == 4 ? 4 : 3);
}

Result<Json> compareFiles(const std::filesystem::path& a, const std::filesystem::path& b) {
    std::error_code code;
    const bool areFolders = std::filesystem::is_directory(a, code) && std::filesystem::is_directory(b, code);
    return areFolders ? compareScenes(a, b) : compareImages(a, b);
}

Result<Json> describeFile(const std::filesystem::path& file) {
    std::error_code code;
    if (std::filesystem::is_directory(file, code)) return describeFolder(file);
    const std::string extension = lowerExtension(file);
    if (isTextureFile(file)) return formats::TextureReader::open(file).map(describeTexture);
    if (extension == ".toml") return readScene(file).map(describeScene);
    if (extension == ".glb" || extension == ".gltf")
        return formats::GltfScene::load(file).map([](const formats::GltfScene& scene) {
            Json json = {
                {"vertices", scene.vertexCount()}, {"triangles", scene.triangleCount()}, {"light_map_uvs", scene.hasLightMapUvs()}};
            for (const auto& material : scene.materials()) json["materials"].push_back(material.name);
            return json;
        });
    if (extension == ".exr") {
        if (const auto map = formats::LightMapReader::open(file, {}))
            return Json{{"light_map", "sh9"}, {"width", map->width()}, {"height", map->height()}, {"normals", map->hasNormals()}};
    }
    return formats::readImage(file).map(describeImage);
}

}  // namespace lightcook::pipeline
