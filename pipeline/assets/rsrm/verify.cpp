#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "fit/azimuthal_average.h"
#include "formats/vocabulary.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/assets/preview.h"
#include "pipeline/assets/rsrm/comparison.h"
#include "pipeline/assets/rsrm/rsrm.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/assets/verification.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/rsrm.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Reads a cooked map from its files and its manifest entry.
Result<verify::CookedRsrm> readMap(const ActionContext& context, const CookedAsset& asset) {
    LC_TRY(constants, fromJson<RsrmConstants>(asset.constants.value_or(Json()), asset.name + ", constants"));
    LC_TRY(texture, openTexture(context.upstreamFolder, asset, "rsrm"));
    const formats::TextureShape& shape = texture->shape();
    const RsrmFormatInfo* const format = rsrmFormatOf(shape.format);
    if (format == nullptr)
        return failure(ErrorCode::Verification, context.action.asset,
                       fmt::format("found a texture in {}, expected a format of reflection maps: {}", formats::info(shape.format).name,
                                   formats::listOfNames(allRsrmFormats())));
    LC_TRY(bytes, texture->readImage({}));
    const auto rows = static_cast<std::size_t>(shape.height);
    if (rows != constants->exponents.size())
        return failure(ErrorCode::Verification, context.action.asset,
                       fmt::format("found {} rows, expected {} as there are exponents", rows, constants->exponents.size()));
    const int expected = format->id == RsrmFormat::Bc4 ? 1 : 3;
    if (const int channels = constants->channels.value_or(3); channels != expected)
        return failure(ErrorCode::Verification, context.action.asset,
                       fmt::format("found constants/channels {}, expected {} of a texture in {}", channels, expected,
                                   formats::info(shape.format).name));
    if (asset.dither.value_or(false) && format->codes != verify::RsrmCodes::Rounded)
        return failure(ErrorCode::Verification, asset.name + ", dither",
                       fmt::format("found true of a texture in {}, expected false: the codes of {} alone are dithered",
                                   formats::info(shape.format).name, info(RsrmFormat::Rgba8).name));
    return decodedRsrm(*format, asset.dither.value_or(false), *constants, *bytes, shape.width);
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
        LC_TRY(painted, formats::loadPaintedGradient(file, options, encodingOf(source.encoding.value_or("auto"))));
        verified.source.gradient = std::move(painted->zones);
        return verified;
    }
    LC_TRY(loaded, formats::loadEnvironment(file, options));
    const int zones = source.zones.value_or(0);
    if (auto usable = fit::checkAzimuthalAverage(*source.axis, zones); !usable)
        return failure(ErrorCode::Verification, context.action.asset, usable.error().line());
    verify::AxialGradient found = verify::axialGradient(loaded->environment, *source.axis, zones);
    float largest = 0;
    for (const glm::vec3& zone : found.gradient) largest = std::max({largest, zone.x, zone.y, zone.z});
    const double uncertainty = std::max({found.uncertainty.x, found.uncertainty.y, found.uncertainty.z});
    verified.measures = {{note_keys::kAsymmetricEnergy, found.asymmetricEnergy},
                         {note_keys::kGradientUncertainty, largest > 0 ? uncertainty / static_cast<double>(largest) : 0.0}};
    verified.source = {std::move(found.gradient), found.uncertainty};
    return verified;
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
    LC_TRY(asset, upstreamAsset(context));
    LC_TRY(visible, parametersOf<VisibleParameters>(context));
    LC_TRY(verified, loadVerified(context, asset->source));
    const verify::RsrmSource& source = verified->source;
    LC_TRY(colors, formats::linearConversion(environmentOptions(asset->source, context.action).colors));
    const glm::vec3 luminanceWeights = colors->luminanceWeights;
    LC_TRY(map, readMap(context, *asset));

    const verify::Viewing viewing = visible->viewing(verify::rsrmDisplayKey(source.gradient, luminanceWeights), colors->bt2020FromWorking);
    auto comparison = compareRsrm(*map, source, luminanceWeights, context, "verify " + context.action.asset, viewing);
    if (!comparison) return interrupted(context);
    const std::vector<verify::RsrmRow>& rows = comparison->rows;
    VerifyResult result = judged(std::move(comparison->stages), visible->limits, watch, std::move(comparison->violations));
    const verify::RsrmBanding banding = verify::rsrmBanding(*map, rows, luminanceWeights);
    result.measures = {{note_keys::kCodeError, banding.codeError},
                       {note_keys::kStepCodes, banding.stepCodes},
                       {note_keys::kStepContrast, banding.stepContrast},
                       {note_keys::kBandCodes, banding.bandCodes}};
    result.measures->update(verified->measures);
    return outcomeWithPreview(std::move(result), drawRows(*map, rows, luminanceWeights), context);
}

}  // namespace lightcook::pipeline
