#include "pipeline/assets/rsrm/rsrm.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "fit/azimuthal_average.h"
#include "fit/rsrm.h"
#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/assets/preview.h"
#include "pipeline/assets/textures.h"
#include "pipeline/assets/verdict.h"
#include "pipeline/assets/verification.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/block_errors.h"
#include "verify/rsrm.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Image;
using formats::PixelFormat;
using formats::Result;

formats::GradientEncoding encodingOf(const std::string& name) {
    if (name == "linear") return formats::GradientEncoding::Linear;
    return name == "srgb" ? formats::GradientEncoding::Srgb : formats::GradientEncoding::Auto;
}

glm::dvec3 axisOf(const Json& description) {
    const Json& axis = description.at("axis");
    return {axis.at(0).get<double>(), axis.at(1).get<double>(), axis.at(2).get<double>()};
}

/// What an action reads its source by, for the manifest and for the verification.
Json sourceDescription(const Json& parameters) {
    Json source;
    for (const char* key : {"colors", "repair", "encoding", "axis", "zones"})
        if (parameters.contains(key)) source[key] = parameters.at(key);
    return source;
}

struct Gradient {
    std::vector<glm::vec3> zones;
    std::int64_t repairedTexels = 0;
    std::string place;  ///< of a zone, for messages
};

Result<Gradient> loadSource(const std::filesystem::path& file, const Json& description, const Action& action) {
    const formats::EnvironmentOptions options = environmentOptions(description, action);
    if (!description.contains("axis")) {
        auto painted = formats::loadGradient(file, options, encodingOf(description.value("encoding", "auto")));
        if (!painted) return tl::make_unexpected(painted.error());
        return Gradient{std::move(*painted), 0, file.string()};
    }
    const auto loaded = formats::loadEnvironment(file, options);
    if (!loaded) return tl::make_unexpected(loaded.error());
    const glm::dvec3 axis = axisOf(description);
    const int zoneCount = description.at("zones").get<int>();
    if (auto usable = fit::checkAzimuthalAverage(axis, zoneCount); !usable) return tl::make_unexpected(usable.error());
    return Gradient{fit::averageAroundAxis(loaded->environment, axis, zoneCount).gradient, loaded->repairedTexels,
                    file.string() + ", averaged"};
}

std::vector<std::byte> encodeMap(const fit::Rsrm& map, PixelFormat format, const TextureSettings& settings) {
    const int width = map.codes.width(), height = map.codes.height();
    if (format == PixelFormat::Rgba8Unorm) {
        Image<glm::u8vec4> texels(width, height);
        for (std::size_t i = 0; i < texels.texels().size(); ++i) texels.texels()[i] = glm::u8vec4(map.codes.texels()[i], 255);
        return bytesOf(texels);
    }
    Image<glm::vec4> texels = toRgba(fit::scaledValues(map).view());
    // One channel: the largest, since all are multiples of it but for those that are black.
    if (format == PixelFormat::Bc4)
        for (glm::vec4& texel : texels.texels()) texel = glm::vec4(std::max({texel.x, texel.y, texel.z}), 0, 0, 1);
    compress::EncodeReport report;
    return encodeImage(format, texels.view(), {}, settings.encodeOptions(), report);
}

PixelFormat formatOf(const std::string& name) {
    if (name == "bc7") return PixelFormat::Bc7;
    return name == "bc4" ? PixelFormat::Bc4 : PixelFormat::Rgba8Unorm;
}

/// The cooked map as its files and its manifest entry have it.
Result<verify::CookedRsrm> readMap(const ActionContext& context, const Json& asset) {
    const auto texture = openTexture(context.upstreamFolder, asset, "rsrm");
    if (!texture) return tl::make_unexpected(texture.error());
    auto image = verify::decodeImage(*texture, {});
    if (!image) return tl::make_unexpected(image.error());
    const Json& constants = asset.at("constants");
    verify::CookedRsrm map;
    for (std::size_t channel = 0; channel < 3; ++channel)
        map.color[static_cast<int>(channel)] = constants.at("color").at(channel).get<float>();
    map.exponents = constants.at("exponents").get<std::vector<double>>();
    map.texels = std::move(*image);
    map.tolerance = verify::toleranceOf(texture->shape().format);
    if (map.tolerance.hasSpans()) {
        const auto blocks = texture->readImage({});
        if (!blocks) return tl::make_unexpected(blocks.error());
        map.spans = verify::blockSpans(texture->shape().format, *blocks, texture->shape().width);
    }
    map.isGrey = texture->shape().format == PixelFormat::Bc4;
    if (texture->shape().format != PixelFormat::Rgba8Unorm)
        map.codes = verify::RsrmCodes::Blocks;
    else if (asset.value("dither", false))
        map.codes = verify::RsrmCodes::Dithered;
    if (map.texels.height() != static_cast<int>(map.exponents.size()))
        return failure(ErrorCode::Verification, context.action.asset,
                       fmt::format("found {} rows, expected {} as there are exponents", map.texels.height(), map.exponents.size()));
    if (constants.value("channels", 3) != (map.isGrey ? 1 : 3))
        return failure(ErrorCode::Verification, context.action.asset,
                       fmt::format("found constants/channels {}, expected {} of a texture in {}", constants.value("channels", 3),
                                   map.isGrey ? 1 : 3, formats::info(texture->shape().format).name));
    return map;
}

/// The source as the verifier finds it, and what it has to tell of an environment.
struct VerifiedSource {
    verify::RsrmSource source;
    Json measures = Json::object();
};
Result<VerifiedSource> loadVerified(const ActionContext& context, const Json& description) {
    const std::filesystem::path& file = context.action.inputs.at("source");
    const formats::EnvironmentOptions options = environmentOptions(description, context.action);
    VerifiedSource verified;
    if (!description.contains("axis")) {
        auto painted = formats::loadGradient(file, options, encodingOf(description.value("encoding", "auto")));
        if (!painted) return tl::make_unexpected(painted.error());
        verified.source.gradient = std::move(*painted);
        return verified;
    }
    const auto loaded = formats::loadEnvironment(file, options);
    if (!loaded) return tl::make_unexpected(loaded.error());
    const glm::dvec3 axis = axisOf(description);
    const int zoneCount = description.at("zones").get<int>();
    if (auto usable = fit::checkAzimuthalAverage(axis, zoneCount); !usable)
        return failure(ErrorCode::Verification, context.action.asset, usable.error().line());
    verify::AxialGradient found = verify::axialGradient(loaded->environment, axis, zoneCount);
    float largest = 0;
    for (const glm::vec3& zone : found.gradient) largest = std::max({largest, zone.x, zone.y, zone.z});
    const double uncertainty = std::max({found.uncertainty.x, found.uncertainty.y, found.uncertainty.z});
    verified.measures = {{"asymmetric_energy", found.asymmetricEnergy},
                         {"gradient_uncertainty", largest > 0 ? uncertainty / static_cast<double>(largest) : 0.0}};
    verified.source = {std::move(found.gradient), found.uncertainty};
    return verified;
}

/// The texel of a part of the map, and the channel, that are farthest off.
verify::ErrorPlace worstOf(const std::vector<verify::RsrmRow>& rows, const glm::ivec2& first, const glm::ivec2& size) {
    verify::ErrorPlace worst;
    for (int y = first.y; y < std::min(first.y + size.y, static_cast<int>(rows.size())); ++y) {
        int column = 0;
        for (const verify::RsrmRow::Point& point : rows[static_cast<std::size_t>(y)].points) {
            if (!point.isCentre) continue;
            const int x = column++;
            if (x < first.x || x >= first.x + size.x) continue;
            for (int channel = 0; channel < 3; ++channel) {
                const double error = std::abs(point.cooked[channel] - point.reference[channel]);
                if (worst.isKnown() && error <= std::abs(worst.found - worst.reference)) continue;
                worst.x = x;
                worst.y = y;
                worst.channel = channel;
                worst.normal = {std::sqrt(std::max(0.0, 1 - point.z * point.z)), 0, point.z};
                worst.reference = point.reference[channel];
                worst.found = point.cooked[channel];
            }
        }
    }
    return worst;
}

std::vector<verify::Violation> violationsOf(const verify::CookedRsrm& map, const verify::RsrmSource& source,
                                            const std::vector<verify::RsrmRow>& rows, double maxError) {
    std::vector<verify::Violation> violations;
    const verify::RsrmCodeError off = verify::rsrmCodeError(map, source, rows);
    if (off.codes > 0)
        violations.push_back({fmt::format("row {}, texel {}", off.row, off.column),
                              fmt::format("an error of {:.3g} codes beyond rounding", off.codes),
                              map.codes == verify::RsrmCodes::Dithered ? "at most one code in all" : "at most half a code in all",
                              worstOf(rows, {off.column, off.row}, {1, 1})});
    if (map.codes != verify::RsrmCodes::Blocks) return violations;
    verify::BlockErrors blocks(map.texels.width(), map.texels.height());
    for (std::size_t row = 0; row < rows.size(); ++row) {
        int column = 0;
        for (const verify::RsrmRow::Point& point : rows[row].points) {
            if (!point.isCentre) continue;
            const glm::dvec3 error = point.cooked - point.reference;
            blocks.add(column++, static_cast<int>(row), glm::dot(error, error), glm::dot(point.reference, point.reference));
        }
    }
    if (const auto block = checkBlocks(blocks, "", maxError, violations))
        violations.back().at = worstOf(rows, {block->x, block->y}, glm::ivec2(verify::BlockErrors::kSize));
    return violations;
}

/// Rows a few pixels high, so that a map of eight can be seen.
Result<void> drawPreview(const ActionContext& context, const verify::CookedRsrm& map, const std::vector<verify::RsrmRow>& rows,
                         const glm::vec3& luminanceWeights, ActionOutcome& outcome) {
    double light = 0;
    for (const verify::RsrmRow& row : rows)
        for (const verify::RsrmRow::Point& point : row.points) light += glm::dot(point.reference, glm::dvec3(luminanceWeights));
    const int rowCount = static_cast<int>(rows.size()), pixels = std::clamp(128 / rowCount, 1, 16);
    const double places = static_cast<double>(rows.size() * rows[0].points.size());
    Preview preview(map.texels.width(), rowCount * pixels, light / places);
    for (int row = 0; row < rowCount; ++row) {
        int column = 0;
        for (const verify::RsrmRow::Point& point : rows[static_cast<std::size_t>(row)].points) {
            if (!point.isCentre) continue;
            for (int y = row * pixels; y < (row + 1) * pixels; ++y)
                if (preview.shows(column, y)) preview.set(column, y, glm::vec3(point.reference), glm::vec3(point.cooked));
            ++column;
        }
    }
    return preview.write(context.folder, context.action.asset, outcome);
}

}  // namespace

Result<ActionOutcome> cookRsrm(const ActionContext& context) {
    const Json& parameters = context.action.parameters;
    const TextureSettings settings = TextureSettings::fromJson(parameters.at("textures"));
    const auto& source = context.action.inputs.at("source");
    const Json description = sourceDescription(parameters);
    const auto gradient = loadSource(source, description, context.action);
    if (!gradient) return tl::make_unexpected(gradient.error());
    fit::RsrmOptions options;
    options.width = parameters.at("width").get<int>();
    options.exponents = parameters.at("exponents").get<std::vector<double>>();
    options.dither = parameters.at("dither").get<bool>();
    if (auto usable = fit::checkRsrm(gradient->zones, options); !usable) {
        formats::Error error = usable.error();
        error.subject = gradient->place + ", " + error.subject;
        return tl::make_unexpected(error);
    }
    formats::TextureShape shape;
    shape.format = formatOf(parameters.at("format").get<std::string>());
    shape.width = options.width;
    shape.height = static_cast<int>(options.exponents.size());
    if (shape.format == PixelFormat::Bc4)
        if (const auto zone = fit::firstZoneOfAnotherHue(gradient->zones))
            return failure(ErrorCode::ValueOutOfRange, fmt::format("{}, zone {}", gradient->place, *zone),
                           "found a colour of its own, expected one colour for format \"bc4\" (or format \"bc7\")");
    const fit::Rsrm map = fit::makeRsrm(gradient->zones, options);

    Json constants = {{"color", {map.color.x, map.color.y, map.color.z}}, {"exponents", options.exponents}};
    if (shape.format == PixelFormat::Bc4) constants["channels"] = 1;
    ActionOutcome outcome;
    const WholeTexture texture{"rsrm", context.action.asset, shape, {encodeMap(map, shape.format, settings)}, {}};
    const auto packed = packTexture(context, texture, settings, {{"layout", "rsrm"}, {"constants", constants}}, outcome);
    if (!packed) return tl::make_unexpected(packed.error());
    outcome.result["asset"] = {{"name", context.action.asset},
                               {"kind", "rsrm"},
                               {"layout", "rsrm"},
                               {"width", shape.width},
                               {"height", shape.height},
                               {"quantity", "exit radiance by Phong exponent (rows) over the angle to the axis (columns, north to south)"},
                               {"units", "radiometric"},
                               {"dither", options.dither},
                               {"constants", constants},
                               {"textures", Json::array({*packed})},
                               {"source", description}};
    outcome.result["bytes_in"] = std::filesystem::file_size(source);
    outcome.result["notes"] = {{"zones", gradient->zones.size()}};
    if (description.contains("axis")) outcome.result["notes"]["repaired_texels"] = gradient->repairedTexels;
    return outcome;
}

Result<ActionOutcome> verifyRsrm(const ActionContext& context) {
    const Stopwatch watch;
    const Json& asset = context.upstream.at(0)->result.at("asset");
    const Json& description = asset.at("source");
    const auto verified = loadVerified(context, description);
    if (!verified) return tl::make_unexpected(verified.error());
    const verify::RsrmSource& source = verified->source;
    const auto colors = formats::linearConversion(environmentOptions(description, context.action).colors);
    if (!colors) return tl::make_unexpected(colors.error());
    const auto map = readMap(context, asset);
    if (!map) return tl::make_unexpected(map.error());

    std::vector<verify::RsrmRow> rows(map->exponents.size());
    if (!forEachPiece(rows.size(), context, "verify " + context.action.asset,
                      [&](std::size_t row) { rows[row] = verify::compareRsrmRow(*map, source, static_cast<int>(row)); }))
        return interrupted(context);
    ActionOutcome outcome = outcomeOf(verify::rsrmStages(*map, source, rows, colors->luminanceWeights), context, watch,
                                      violationsOf(*map, source, rows, maxErrorOf(context)));
    const verify::RsrmBanding banding = verify::rsrmBanding(*map, rows, colors->luminanceWeights);
    outcome.result["measures"] = {{"code_error", banding.codeError},
                                  {"step_codes", banding.stepCodes},
                                  {"step_contrast", banding.stepContrast},
                                  {"band_codes", banding.bandCodes}};
    outcome.result["measures"].update(verified->measures);
    if (auto written = drawPreview(context, *map, rows, colors->luminanceWeights, outcome); !written)
        return tl::make_unexpected(written.error());
    return outcome;
}

}  // namespace lightcook::pipeline
