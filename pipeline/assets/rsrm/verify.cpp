#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "fit/azimuthal_average.h"
#include "pipeline/assets/preview.h"
#include "pipeline/assets/rsrm/rsrm.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/assets/verification.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/block_errors.h"
#include "verify/rsrm.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::PixelFormat;
using formats::Result;

/// Reads a cooked map from its files and its manifest entry.
Result<verify::CookedRsrm> readMap(const ActionContext& context, const CookedAsset& asset) {
    const auto constants = fromJson<RsrmConstants>(asset.constants.value_or(Json()), asset.name + ", constants");
    if (!constants) return tl::make_unexpected(constants.error());
    const auto texture = openTexture(context.upstreamFolder, asset, "rsrm");
    if (!texture) return tl::make_unexpected(texture.error());
    const PixelFormat format = texture->shape().format;
    auto image = verify::decodeImage(*texture, {});
    if (!image) return tl::make_unexpected(image.error());
    verify::CookedRsrm map;
    map.color = constants->color;
    map.exponents = constants->exponents;
    map.texels = std::move(*image);
    map.tolerance = verify::toleranceOf(format);
    if (map.tolerance.hasSpans()) {
        const auto blocks = texture->readImage({});
        if (!blocks) return tl::make_unexpected(blocks.error());
        map.spans = verify::blockSpans(format, *blocks, texture->shape().width);
    }
    map.isGrey = format == PixelFormat::Bc4;
    if (format != PixelFormat::Rgba8Unorm)
        map.codes = verify::RsrmCodes::Blocks;
    else if (asset.dither.value_or(false))
        map.codes = verify::RsrmCodes::Dithered;
    if (map.texels.height() != static_cast<int>(map.exponents.size()))
        return failure(ErrorCode::Verification, context.action.asset,
                       fmt::format("found {} rows, expected {} as there are exponents", map.texels.height(), map.exponents.size()));
    if (const int channels = constants->channels.value_or(3); channels != (map.isGrey ? 1 : 3))
        return failure(ErrorCode::Verification, context.action.asset,
                       fmt::format("found constants/channels {}, expected {} of a texture in {}", channels, map.isGrey ? 1 : 3,
                                   formats::info(format).name));
    return map;
}

/// The source as the verifier reads it, and the measures of an environment's average.
struct VerifiedSource {
    verify::RsrmSource source;
    Json measures = Json::object();
};

Result<VerifiedSource> loadVerified(const ActionContext& context, const AssetSource& source) {
    const std::filesystem::path& file = context.action.inputs.at("source");
    const formats::EnvironmentOptions options = environmentOptions(source, context.action);
    VerifiedSource verified;
    if (!source.axis) {
        auto painted = formats::loadGradient(file, options, encodingOf(source.encoding.value_or("auto")));
        if (!painted) return tl::make_unexpected(painted.error());
        verified.source.gradient = std::move(*painted);
        return verified;
    }
    const auto loaded = formats::loadEnvironment(file, options);
    if (!loaded) return tl::make_unexpected(loaded.error());
    const int zones = source.zones.value_or(0);
    if (auto usable = fit::checkAzimuthalAverage(*source.axis, zones); !usable)
        return failure(ErrorCode::Verification, context.action.asset, usable.error().line());
    verify::AxialGradient found = verify::axialGradient(loaded->environment, *source.axis, zones);
    float largest = 0;
    for (const glm::vec3& zone : found.gradient) largest = std::max({largest, zone.x, zone.y, zone.z});
    const double uncertainty = std::max({found.uncertainty.x, found.uncertainty.y, found.uncertainty.z});
    verified.measures = {{"asymmetric_energy", found.asymmetricEnergy},
                         {"gradient_uncertainty", largest > 0 ? uncertainty / static_cast<double>(largest) : 0.0}};
    verified.source = {std::move(found.gradient), found.uncertainty};
    return verified;
}

/// Returns the texel and channel with the largest error in a part of the map.
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

/// Returns the faults of a map: a code that rounding does not explain, or a block that is too far off.
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

/// Draws each row of the map a few pixels high, so that a map of eight rows can be seen.
Preview drawRows(const verify::CookedRsrm& map, const std::vector<verify::RsrmRow>& rows, const glm::vec3& luminanceWeights) {
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
    return preview;
}

}  // namespace

Result<ActionOutcome> verifyRsrm(const ActionContext& context) {
    const Stopwatch watch;
    const auto asset = upstreamAsset(context);
    if (!asset) return tl::make_unexpected(asset.error());
    const auto maxError = maxErrorOf(context);
    if (!maxError) return tl::make_unexpected(maxError.error());
    const auto verified = loadVerified(context, asset->source);
    if (!verified) return tl::make_unexpected(verified.error());
    const verify::RsrmSource& source = verified->source;
    const auto colors = formats::linearConversion(environmentOptions(asset->source, context.action).colors);
    if (!colors) return tl::make_unexpected(colors.error());
    const glm::vec3 luminanceWeights = colors->luminanceWeights;
    const auto map = readMap(context, *asset);
    if (!map) return tl::make_unexpected(map.error());

    std::vector<verify::RsrmRow> rows(map->exponents.size());
    if (!forEachIndex(rows.size(), context, "verify " + context.action.asset,
                      [&](std::size_t row) { rows[row] = verify::compareRsrmRow(*map, source, static_cast<int>(row)); }))
        return interrupted(context);
    VerifyResult result =
        judged(verify::rsrmStages(*map, source, rows, luminanceWeights), *maxError, watch, violationsOf(*map, source, rows, *maxError));
    const verify::RsrmBanding banding = verify::rsrmBanding(*map, rows, luminanceWeights);
    result.measures = {{"code_error", banding.codeError},
                       {"step_codes", banding.stepCodes},
                       {"step_contrast", banding.stepContrast},
                       {"band_codes", banding.bandCodes}};
    result.measures->update(verified->measures);
    return outcomeWithPreview(std::move(result), drawRows(*map, rows, luminanceWeights), context);
}

}  // namespace lightcook::pipeline
