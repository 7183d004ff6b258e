#include "pipeline/command/compare.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "formats/gpu_texture.h"
#include "formats/plain_image.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/command/command.h"
#include "pipeline/command/compare_light_maps.h"
#include "pipeline/command/converter.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/printing.h"
#include "pipeline/command/texture_file.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Sums over texels and channels.
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

/// Fails if one of some channels of an image is not finite: no figure says how far off it is.
Result<void> checkFinite(const formats::PlainImage& image, std::span<const int> channels, const std::filesystem::path& file) {
    const auto& texels = image.texels;
    for (int y = 0; y < texels.height(); ++y)
        for (int x = 0; x < texels.width(); ++x)
            for (const int c : channels)
                if (const float value = texels.at(x, y)[c]; !std::isfinite(value))
                    return failure(ErrorCode::ValueNotFinite,
                                   formats::Subject(file).at(fmt::format("channel {}, texel ({}, {})", "RGBA"[c], x, y)),
                                   fmt::format("found {}, expected a finite value", value));
    return {};
}

/// Images of a file: the mips and layers of a texture, or one.
struct ImageCount {
    int mips = 1, layers = 1;
    bool isSrgb = false;  ///< a texture whose colours are under the sRGB curve
    bool isBc1 = false;
};
Result<ImageCount> imagesIn(const std::filesystem::path& file) {
    if (!isTextureFile(file)) return ImageCount{};
    return formats::TextureReader::open(file).map([](const formats::TextureReader& reader) {
        const formats::TextureShape& shape = reader.shape();
        return ImageCount{shape.mipCount, shape.layerCount, shape.format == formats::PixelFormat::Rgba8Srgb,
                          shape.format == formats::PixelFormat::Bc1};
    });
}

/// Reads an image of a file.
/// isSrgb  a picture of integers holds sRGB colours, as the texture that it is compared with
Result<formats::PlainImage> readCompared(const std::filesystem::path& file, int mip, int layer, bool isSrgb) {
    auto image = readAnyImage(file, mip, layer);
    if (image && isSrgb && formats::isPictureFile(file)) decodeSrgb(*image);
    return image;
}

/// Numbers of channels of two images.
struct ChannelCounts {
    int first = 0, second = 0;
    bool isAlphaCompared = false;
    int colours = 0;  ///< that are compared: of R, G, B in this order

    int common() const { return colours + (isAlphaCompared ? 1 : 0); }
};

/// Returns the channels that are compared: the colours that both images have, and alpha if both have it. Transparent texels of BC1 are
/// compared with any image: one without alpha is opaque.
/// isBc1  one of the images with alpha is BC1
ChannelCounts comparedChannels(const formats::PlainImage& first, const formats::PlainImage& second, bool isBc1) {
    const auto coloursOf = [](const formats::PlainImage& image) { return std::clamp(image.channelCount - (image.hasAlpha ? 1 : 0), 0, 3); };
    ChannelCounts counts{first.channelCount, second.channelCount};
    counts.colours = std::min(coloursOf(first), coloursOf(second));
    counts.isAlphaCompared = (first.hasAlpha && second.hasAlpha) || isBc1;
    return counts;
}

/// Adds the errors of an image of both files, in the channels of comparedChannels(), which it returns.
Result<ChannelCounts> addImage(const std::filesystem::path& a, const std::filesystem::path& b, int mip, int layer,
                               const std::array<ImageCount, 2>& files, ImageError& error) {
    const bool isSrgb = files[0].isSrgb || files[1].isSrgb;
    LC_TRY(first, readCompared(a, mip, layer, isSrgb), second = readCompared(b, mip, layer, isSrgb));
    if (!second) return tl::make_unexpected(second.error());
    if (first->texels.width() != second->texels.width() || first->texels.height() != second->texels.height())
        return failure(ErrorCode::WrongShape, b,
                       fmt::format("found {} x {} texels, expected {} x {} as in {}", second->texels.width(), second->texels.height(),
                                   first->texels.width(), first->texels.height(), a.string()));
    const ChannelCounts counts =
        comparedChannels(*first, *second, (files[0].isBc1 && first->hasAlpha) || (files[1].isBc1 && second->hasAlpha));
    std::vector<int> channels;
    for (int c = 0; c < counts.colours; ++c) channels.push_back(c);
    if (counts.isAlphaCompared) channels.push_back(3);
    for (const auto& [image, file] : {std::pair(&*first, a), std::pair(&*second, b)}) LC_CHECK(checkFinite(*image, channels, file));
    for (std::size_t i = 0; i < first->texels.texels().size(); ++i)
        for (const int c : channels)
            error.add(static_cast<double>(first->texels.texels()[i][c]), static_cast<double>(second->texels.texels()[i][c]));
    return counts;
}

Result<Json> compareImages(const std::filesystem::path& a, const std::filesystem::path& b) {
    LC_TRY(first, imagesIn(a), second = imagesIn(b));
    if (!second) return tl::make_unexpected(second.error());
    if (first->layers != second->layers)
        return failure(ErrorCode::WrongShape, b,
                       fmt::format("found {} layer(s), expected {} as in {}. `lightcook decode --layer N` takes one out", second->layers,
                                   first->layers, a.string()));
    const bool areTextures = isTextureFile(a) && isTextureFile(b);
    if (areTextures && first->mips != second->mips)
        return failure(ErrorCode::WrongShape, b,
                       fmt::format("found {} mip(s), expected {} as in {}", second->mips, first->mips, a.string()));
    const int mips = areTextures ? first->mips : 1;  // a picture is the first mip of a texture
    ImageError error;
    ChannelCounts channels;
    for (int mip = 0; mip < mips; ++mip)
        for (int layer = 0; layer < first->layers; ++layer) {
            LC_TRY(added, addImage(a, b, mip, layer, {*first, *second}, error));
            if (added->common() >= channels.common()) channels = *added;
        }
    Json json = error.toJson();
    json["channels"] = channels.common();
    json["alpha_compared"] = channels.isAlphaCompared;
    json["a_channels"] = channels.first;
    json["b_channels"] = channels.second;
    json["images"] = mips * first->layers;
    return json;
}

Json compared(const ReportRow& row) {
    Json figures = toJson(figuresOf(row));
    figures["bytes_disk"] = row.bytesDisk;
    return figures;
}

/// A cooked folder as it lies there now.
struct ComparedFolder {
    Report report;
    Manifest manifest;
    std::map<std::string, std::string> digests;  ///< of the manifest's files by name; empty for one that was changed since the cook
    std::vector<formats::Error> changed;         ///< an error for each file that was changed since the cook

    const CookedAsset* find(const std::string& name) const {
        const auto found = std::ranges::find(manifest.assets, name, &CookedAsset::name);
        return found == manifest.assets.end() ? nullptr : &*found;
    }
};

Result<ComparedFolder> readFolder(const std::filesystem::path& folder) {
    LC_TRY(report, loadReport(folder / kReportName));
    LC_TRY(manifest, loadManifest(folder));
    ComparedFolder read{std::move(*report), std::move(*manifest), {}, {}};
    for (const FileRecord& file : filesOf(read.manifest)) read.digests[file.name] = file.digest;
    read.changed = checkDigests(folder, read.manifest);
    for (const formats::Error& error : read.changed)
        for (auto& [name, digest] : read.digests)
            if (error.file == folder / name) digest.clear();
    return read;
}

/// Returns the files that do not have the same content in both folders, by name.
std::set<std::string> differentFiles(const ComparedFolder& first, const ComparedFolder& second) {
    std::set<std::string> different;
    for (const auto& [folder, other] : {std::pair(&first, &second), std::pair(&second, &first)})
        for (const auto& [name, digest] : folder->digests) {
            const auto found = other->digests.find(name);
            if (digest.empty() || found == other->digests.end() || found->second != digest) different.insert(name);
        }
    return different;
}

/// Returns true if an asset has the same constants and files in both folders.
bool hasSameContent(const CookedAsset* first, const CookedAsset* second, const std::set<std::string>& different) {
    if (first == nullptr || second == nullptr) return first == second;
    if (first->constants != second->constants) return false;
    for (const CookedAsset* asset : {first, second}) {
        if (asset->file && different.contains(*asset->file)) return false;
        for (const CookedTexture& texture : asset->textures)
            if (different.contains(texture.file)) return false;
    }
    return true;
}

Result<Comparison> compareScenes(const std::filesystem::path& a, const std::filesystem::path& b) {
    LC_TRY(first, readFolder(a), second = readFolder(b));
    if (!second) return tl::make_unexpected(second.error());
    const std::set<std::string> different = differentFiles(*first, *second);
    std::map<std::string, std::pair<Json, Json>> rows;
    for (const ReportRow& row : first->report.assets) rows[row.name].first = compared(row);
    for (const ReportRow& row : second->report.assets) rows[row.name].second = compared(row);
    Json assets = Json::array();
    for (const auto& [name, row] : rows) {
        const bool isSame = row.first == row.second && hasSameContent(first->find(name), second->find(name), different);
        assets.push_back({{"name", name}, {"a", row.first}, {"b", row.second}, {"same", isSame}});
    }
    std::vector<formats::Error> changed = first->changed;
    if (a != b) changed.insert(changed.end(), second->changed.begin(), second->changed.end());
    Json lines = Json::array();
    for (const formats::Error& error : changed) lines.push_back(error.line());
    return Comparison{{{"a_bytes_gpu", first->report.budget.usedBytes},
                       {"b_bytes_gpu", second->report.budget.usedBytes},
                       {"assets", assets},
                       {"different_files", different},
                       {"changed_since_cook", lines}},
                      std::move(changed)};
}

/// Returns the figure that a name of --metric asks for; of light maps, which have it twice, the larger one. Empty: there is none.
std::optional<double> figureOf(const Json& differences, const std::string& metric) {
    if (differences.contains(metric)) return differences.at(metric).get<double>();
    if (!differences.contains("diffuse")) return std::nullopt;
    const auto figure = [&](const char* kind) -> std::optional<double> {
        const Json& figures = differences.at(kind);
        if (metric == "visible_p99") return figures.at("visible").at("p99").get<double>();
        return figures.contains(metric) ? std::optional(figures.at(metric).get<double>()) : std::nullopt;
    };
    return std::max(figure("diffuse"), figure("specular"));
}

/// Warns of images of which one has channels that the other lacks: nobody has looked at these.
void warnOfChannels(Terminal& terminal, const Json& differences, const std::filesystem::path& b) {
    if (!differences.contains("a_channels") || differences["a_channels"] == differences["b_channels"]) return;
    const int first = differences["a_channels"].get<int>(), second = differences["b_channels"].get<int>(),
              compared = differences["channels"].get<int>();
    if (compared == std::max(first, second)) return;  // alpha, against the opaque texels of the other
    terminal.warning(b.string(), fmt::format("found {} channels, expected {} as in the reference: only the first {} are compared", second,
                                             first, compared));
}

/// Values of --second.
constexpr const char *kSameConventions = "same", *kCanonicalConventions = "canonical";

/// Returns the error of a metric that what was compared does not have.
formats::Error unknownMetric(const Json& differences, const std::string& metric) {
    const auto [things, expected] = differences.contains("assets") ? std::pair("cooked scenes", "no --metric: --json has all figures")
                                    : differences.contains("diffuse")
                                        ? std::pair("light maps", "rel_rms or visible_p99")
                                        : std::pair("images and textures", "rmse, rel_rmse, log2_psnr_db or max_abs");
    return {ErrorCode::InvalidRequest, "--metric", fmt::format("found {}, which {} do not have, expected {}", metric, things, expected)};
}

/// Returns the first option with which conventions of two light maps differ from the default, which says nothing of other files. Empty:
/// there is none.
std::string conventionOption(const formats::LightMapDescription& ofA, const formats::LightMapDescription& ofB) {
    const Json usual = toJson(formats::LightMapDescription());
    for (const formats::LightMapDescription& each : {ofA, ofB}) {
        // Files are no part of the JSON.
        if (!each.mesh.empty()) return "--mesh";
        if (!each.lmbake.empty()) return "--lmbake";
        const Json stated = toJson(each);
        for (const auto& [key, value] : stated.items()) {
            if (usual.contains(key) && usual[key] == value) continue;
            std::string option = "--" + key;
            std::ranges::replace(option, '_', '-');
            return option;
        }
    }
    return "";
}

}  // namespace

Result<Comparison> compareFiles(const std::filesystem::path& a, const std::filesystem::path& b, const RunState& state,
                                const formats::LightMapDescription& ofA, const formats::LightMapDescription& ofB) {
    std::error_code code;
    const bool isFirst = std::filesystem::is_directory(a, code), isSecond = std::filesystem::is_directory(b, code);
    if (isFirst != isSecond) {
        const auto &folder = isFirst ? a : b, &other = isFirst ? b : a;
        return failure(ErrorCode::FileUnreadable, other,
                       fmt::format("found {}, expected a cooked folder as {} is",
                                   std::filesystem::exists(other, code) ? "a file" : "no such folder", folder.string()));
    }
    const ComparedMap first{a, ofA}, second{b, ofB};
    const bool areMaps = !isFirst && (isCertainLightMap(first) || isCertainLightMap(second));
    if (const std::string option = conventionOption(ofA, ofB); !areMaps && !option.empty())
        return failure(ErrorCode::InvalidRequest, a,
                       fmt::format("found {} with {}, expected light maps{}", isFirst ? "cooked folders" : "images or textures", option,
                                   isFirst ? "" : ": name the bake format of a picture that is one, as --bake flat"));
    if (isFirst) return compareScenes(a, b);
    const auto figures = areMaps ? compareLightMaps(first, second, state) : compareImages(a, b);
    return figures.map([](const Json& json) { return Comparison{json, {}}; });
}

CommandFunction defineCompare(CLI::App& app) {
    struct Options {
        std::filesystem::path a, b;
        std::string metric, second = kSameConventions;
        GivenKeys given;
        JsonOutput json;
    };
    const auto options = std::make_shared<Options>();
    addFileOption(app, "a", options->a, "The reference: an image, a texture, a light map (a bake) or an output folder of cook")->required();
    addFileOption(app, "b", options->b, "The one to compare with it")->required();
    app.add_option("--metric", options->metric,
                   "Print only this figure. Images and textures have rmse, rel_rmse, log2_psnr_db and max_abs; light maps have rel_rms and "
                   "visible_p99, the larger one of diffuse and specular")
        ->check(CLI::IsMember({"rmse", "rel_rmse", "log2_psnr_db", "max_abs", "rel_rms", "visible_p99"}));
    addKeyOptions(app, options->given, conventionOptions());
    app.add_option("--second", options->second,
                   "Conventions of the second light map (same: those of the first; canonical: those of what reconstruct and repack write)")
        ->check(CLI::IsMember({kSameConventions, kCanonicalConventions}))
        ->capture_default_str();
    options->json.add(app, "the differences");
    app.footer("A file of a cooked scene that does not match its manifest is an error: exit code 4.");
    return [options](Session& session) {
        options->json.prepare(session);
        const auto ofA = describeBake(options->a, options->given);
        const auto ofB = options->second == kSameConventions ? describeBake(options->b, options->given) : formats::LightMapDescription();
        for (const auto* of : {&ofA, &ofB})
            if (!*of) return options->json.finish(session, {}, {of->error()});
        const auto compared = compareFiles(options->a, options->b, session.state, *ofA, *ofB);
        if (!compared) return options->json.finish(session, {}, {compared.error()});
        const auto& [differences, changed] = *compared;
        if (options->second != kSameConventions && !differences.contains("diffuse"))
            return options->json.finish(session, {},
                                        {{ErrorCode::InvalidRequest, "--second",
                                          fmt::format("found {} beside files that are no light maps, expected none", options->second)}});
        warnOfChannels(session.terminal, differences, options->b);
        const auto figure = options->metric.empty() ? std::nullopt : figureOf(differences, options->metric);
        if (!options->metric.empty() && !figure)
            return options->json.finish(session, differences, {unknownMetric(differences, options->metric)});
        if (options->json.isStandardOutput()) return options->json.finish(session, differences, changed);
        if (figure)
            session.terminal.say(fmt::format("{}", *figure));
        else
            printJson(session.terminal, differences);
        return options->json.finish(session, differences, changed);
    };
}

}  // namespace lightcook::pipeline
