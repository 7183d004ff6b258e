#include "pipeline/assets/textures.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::PixelFormat;
using formats::Result;

/// Rows of blocks that one task encodes: small enough to spread a 256 x 256 texture over a few threads.
constexpr int kBlockRowsPerTask = 8;

}  // namespace

Json TextureSettings::toJson() const {
    return {{"container", container == formats::Container::Dds ? "dds" : "ktx2"}, {"zstd", zstd}, {"effort", effort}, {"rdo", rdo}};
}

TextureSettings TextureSettings::fromJson(const Json& json) {
    return {json.at("container") == "dds" ? formats::Container::Dds : formats::Container::Ktx2, json.at("zstd").get<bool>(),
            json.at("effort").get<int>(), json.at("rdo").get<double>()};
}

compress::EncodeOptions TextureSettings::encodeOptions() const {
    compress::EncodeOptions options;
    options.effort = effort;
    options.rdo = static_cast<float>(rdo);
    return options;
}

PixelFormat hdrFormat(const std::string& target) {
    if (target == "float") return PixelFormat::Rgba16f;
    return target == "astc" ? PixelFormat::Astc4x4Hdr : PixelFormat::Bc6hUf16;
}

Json textureEntry(const std::string& role, const std::string& file, const formats::TextureShape& shape, std::size_t fileBytes,
                  const Sampler& sampler) {
    return {{"role", role},
            {"file", file},
            {"format", std::string(formats::info(shape.format).name)},
            {"width", shape.width},
            {"height", shape.height},
            {"mips", shape.mipCount},
            {"layers", shape.layerCount},
            {"faces", shape.faceCount},
            {"bytes_gpu", shape.gpuBytes()},
            {"bytes_disk", fileBytes},
            {"sampler", {{"filter", sampler.filter}, {"wrap", sampler.wrap}}}};
}

std::vector<std::byte> encodeImage(PixelFormat format, formats::ImageView<const glm::vec4> texels,
                                   formats::ImageView<const float> significance, const compress::EncodeOptions& options,
                                   compress::EncodeReport& report) {
    const int blockHeight = formats::info(format).blockHeight;
    const int blockRows = formats::blocksDown(format, texels.height);
    const std::size_t rowBytes = formats::bytesPerBlockRow(format, texels.width);
    std::vector<std::byte> bytes(rowBytes * static_cast<std::size_t>(blockRows));
    const int taskCount = (blockRows + kBlockRowsPerTask - 1) / kBlockRowsPerTask;
    std::vector<compress::EncodeReport> reports(static_cast<std::size_t>(taskCount));
    tbb::parallel_for(0, taskCount, [&](int task) {
        const int firstBlockRow = task * kBlockRowsPerTask;
        const int rowsOfBlocks = std::min(kBlockRowsPerTask, blockRows - firstBlockRow);
        const int firstRow = firstBlockRow * blockHeight;
        const int rowCount = std::min(rowsOfBlocks * blockHeight, texels.height - firstRow);
        const auto weights = significance.texels == nullptr ? significance : significance.rows(firstRow, rowCount);
        const std::span<std::byte> out(bytes.data() + static_cast<std::size_t>(firstBlockRow) * rowBytes,
                                       static_cast<std::size_t>(rowsOfBlocks) * rowBytes);
        reports[static_cast<std::size_t>(task)] = compress::encodeRows(format, texels.rows(firstRow, rowCount), weights, options, out, {});
    });
    for (const compress::EncodeReport& each : reports) report.add(each);
    return bytes;
}

std::vector<std::vector<std::byte>> encodeFaces(PixelFormat format, formats::ImageView<const glm::vec3> strip, float range,
                                                const compress::EncodeOptions& options, compress::EncodeReport& report) {
    formats::Image<glm::vec4> rgba = toRgba(strip);
    for (glm::vec4& texel : rgba.texels()) texel /= range;
    std::vector<std::vector<std::byte>> faces;
    for (int face = 0; face < 6; ++face)
        faces.push_back(encodeImage(format, rgba.view().rows(face * strip.width, strip.width), {}, options, report));
    return faces;
}

std::map<std::string, std::string> textureMetadata(const Json& facts) {
    return {{"io.lightcook", facts.dump()}};
}

Result<formats::TextureWriter> createTexture(const std::filesystem::path& file, const formats::TextureShape& shape,
                                             const TextureSettings& settings, const std::map<std::string, std::string>& metadata) {
    formats::TextureFileOptions options;
    options.container = settings.container;
    options.zstd = settings.zstd;
    options.metadata = metadata;
    return formats::TextureWriter::create(file, shape, options);
}

Result<void> writeTexture(const std::filesystem::path& file, const formats::TextureShape& shape, const TextureSettings& settings,
                          const std::map<std::string, std::string>& metadata, const std::vector<std::vector<std::byte>>& images) {
    auto writer = createTexture(file, shape, settings, metadata);
    if (!writer) return tl::make_unexpected(writer.error());
    std::size_t index = 0;
    for (int mip = 0; mip < shape.mipCount; ++mip)
        for (int layer = 0; layer < shape.layerCount; ++layer)
            for (int face = 0; face < shape.faceCount; ++face)
                if (auto written = writer->writeBlockRows({mip, layer, face}, 0, images.at(index++)); !written) return written;
    return writer->commit();
}

Result<Json> packTexture(const ActionContext& context, const WholeTexture& texture, const TextureSettings& settings, const Json& facts,
                         ActionOutcome& outcome) {
    const std::string file = texture.name + std::string(settings.extension());
    const std::filesystem::path path = context.folder / file;
    if (auto written = writeTexture(path, texture.shape, settings, textureMetadata(facts), texture.images); !written)
        return tl::make_unexpected(written.error());
    outcome.files.push_back(file);
    return textureEntry(texture.role, file, texture.shape, std::filesystem::file_size(path), texture.sampler);
}

Result<formats::TextureReader> openTexture(const std::filesystem::path& folder, const Json& asset, const std::string& role) {
    for (const Json& entry : asset.at("textures")) {
        if (entry.at("role") != role) continue;
        const std::filesystem::path file = folder / entry.at("file").get<std::string>();
        auto reader = formats::TextureReader::open(file);
        if (!reader) return reader;
        const formats::TextureShape& shape = reader->shape();
        const auto disagree = [&](const char* what, const std::string& found, const std::string& expected) {
            return failure(ErrorCode::Verification, file.string(),
                           fmt::format("found {} {}, expected {} as in the manifest", what, found, expected));
        };
        if (formats::info(shape.format).name != entry.at("format").get<std::string>())
            return disagree("format", std::string(formats::info(shape.format).name), entry.at("format").get<std::string>());
        for (const auto& [key, value] : std::initializer_list<std::pair<const char*, int>>{{"width", shape.width},
                                                                                           {"height", shape.height},
                                                                                           {"mips", shape.mipCount},
                                                                                           {"layers", shape.layerCount},
                                                                                           {"faces", shape.faceCount}})
            if (entry.at(key).get<int>() != value) return disagree(key, std::to_string(value), std::to_string(entry.at(key).get<int>()));
        return reader;
    }
    return failure(ErrorCode::Verification, asset.at("name").get<std::string>(),
                   fmt::format("found no texture '{}' in the manifest, expected one", role));
}

float hdrRange(float largest) {
    return largest > 0 ? std::exp2(std::max(std::ceil(std::log2(largest)) - 10.0f, -120.0f)) : 1.0f;
}

formats::Image<glm::vec4> toRgba(formats::ImageView<const glm::vec3> image) {
    formats::Image<glm::vec4> rgba(image.width, image.height);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) rgba.at(x, y) = glm::vec4(image.at(x, y), 1.0f);
    return rgba;
}

}  // namespace lightcook::pipeline
