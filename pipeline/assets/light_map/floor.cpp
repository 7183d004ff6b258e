#include "pipeline/assets/light_map/floor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <vector>

#include "compress/light_map.h"
#include "compress/light_map_context.h"
#include "formats/light_map_layout.h"
#include "pipeline/assets/light_map/decoded_rows.h"
#include "pipeline/assets/light_map/surface_places.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

constexpr double kMostPlaces = 131072;
/// One in this many of the places without an error is shaded, for the RMS of the reference.
constexpr int kInnerStep = 16;

/// Places of some strips.
struct FloorPart {
    verify::ShadedErrors rims, inner;  ///< of the places that were shaded; the inner ones have no error
    std::int64_t rimCount = 0, innerCount = 0;
    void merge(const FloorPart& other) {
        rims.merge(other.rims);
        inner.merge(other.inner);
        rimCount += other.rimCount;
        innerCount += other.innerCount;
    }
};

/// Inputs of the measurement of every strip.
struct FloorMeter {
    LightMapSource& source;
    const compress::LightMapPlan& plan;  ///< of layout raw
    const verify::LightMapVerifier& verifier;
    const verify::LightMapScore& score;
    double key;
    int step;  ///< between texels that have a place, in the order of the map
};

/// Returns true if a filter reads a texel outside charts at a place. Texels beyond the map are those at its edge.
bool isAtRim(const formats::LightMapStrip& strip, const glm::dvec2& at) {
    const glm::ivec2 corner(glm::floor(at));
    for (int i = 0; i < 4; ++i) {
        const int x = std::clamp(corner.x + i % 2, 0, strip.sh.width() - 1),
                  row = std::clamp(corner.y + i / 2 - strip.firstRow, 0, strip.sh.height() - 1);
        if (strip.covered.at(x, row) == 0) return true;
    }
    return false;
}

Result<FloorPart> measureStrip(const FloorMeter& meter, int index) {
    const int firstRow = meter.source.stripFirstRow(index), end = firstRow + meter.source.stripRows(index);
    const int above = std::max(0, firstRow - 1), below = std::min(meter.source.height(), end + 1);
    LC_TRY(planned, planRows(meter.source, meter.plan, {}, above, below));
    const formats::LightMapStrip* const strip = &planned->texels;
    FloorPart part;
    std::vector<verify::LightMapScore::Place> rims, inner;
    std::array<lighting::ShRgb, 2> light;  // of the bake and of raw
    for (int y = firstRow; y < end; ++y)
        for (int x = 0; x < meter.source.width(); ++x) {
            const std::int64_t number = std::int64_t{y} * meter.source.width() + x;
            if (number % meter.step != 0 || strip->covered.at(x, y - strip->firstRow) == 0) continue;
            const glm::dvec2 at = glm::dvec2(x, y) + placeInTexel(number / meter.step);
            if (mayCrossCharts(*strip, at)) continue;
            const bool isRim = isAtRim(*strip, at);
            if (!isRim && ++part.innerCount % kInnerStep != 1) continue;
            if (!meter.verifier.lightAt(planned->decoded, *strip, at, light)) continue;
            if (isRim) ++part.rimCount;
            for (lighting::ShRgb& each : light)
                for (glm::vec3& coefficient : each) coefficient *= static_cast<float>(meter.key);
            (isRim ? rims : inner).push_back({at, light[0], light[isRim ? 1 : 0], strip->normal.at(x, y - strip->firstRow)});
        }
    part.rims = meter.score.score(rims);
    part.inner = meter.score.score(inner);
    return part;
}

/// Returns rel_rms of all places.
/// innerShare  inner places for each that was shaded
double relRmsOf(const verify::ErrorAccumulator& rims, const verify::ErrorAccumulator& inner, double innerShare) {
    const auto squares = [](const verify::ErrorAccumulator& each) {
        const double rms = each.referenceRms();
        return rms * rms * static_cast<double>(each.sampleCount());
    };
    const double error = rims.figures().relRms * rims.figures().relRms * squares(rims), light = squares(rims) + innerShare * squares(inner);
    return light > 0 ? std::sqrt(error / light) : 0;
}

/// Returns the 99th percentile of the visible errors of all places.
double visibleOf(verify::VisibleAccumulator rims, std::int64_t rimCount, std::int64_t innerCount) {
    if (rimCount == 0) return 0;
    rims.addExact(static_cast<std::size_t>(innerCount * (rims.sampleCount() / rimCount)));
    return rims.figures().p99;
}

LightMapFloor floorOf(const FloorPart& whole) {
    const auto& [rims, inner, rimCount, innerCount] = whole;
    LightMapFloor floor;
    if (rimCount == 0) return floor;
    const double share = static_cast<double>(innerCount) / std::max<double>(1, std::ceil(static_cast<double>(innerCount) / kInnerStep));
    floor.relRms = std::max(relRmsOf(rims.diffuse, inner.diffuse, share), relRmsOf(rims.specular, inner.specular, share));
    floor.visible = std::max(visibleOf(rims.visibleDiffuse, rimCount, innerCount), visibleOf(rims.visibleSpecular, rimCount, innerCount));
    const verify::VisiblePlace& at =
        (rims.visibleDiffuse.largest() > rims.visibleSpecular.largest() ? rims.visibleDiffuse : rims.visibleSpecular).maxAt();
    if (at.isKnown()) floor.texel = {at.x, at.y};
    floor.rimShare = static_cast<double>(rimCount) / static_cast<double>(rimCount + innerCount);
    return floor;
}

}  // namespace

Result<ActionOutcome> measureFloor(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<LightMapFloorParameters>(context));
    LC_TRY(opened, openLightMap(context, parameters->description));
    LightMapSource& source = **opened;
    LC_TRY(survey, source.survey(context));
    const verify::LightMapKey& keys = (*survey)->key;
    const compress::LightMapPlan plan =
        compress::planLightMap(formats::LightMapLayout::Raw, {formats::Target::Float, source.width(), source.height(), (*survey)->measure});
    const double key = keys.key();
    const verify::Viewing viewing{parameters->display.of(keys.displayKey()), source.bt2020FromWorking()};
    const auto verifier =
        verify::LightMapVerifier::create({std::string(formats::info(plan.layout).name), plan.constants, plan.width, plan.height},
                                         parameters->shading, {.figures = verify::LightMapFigures::Sampled}, key, viewing);
    if (!verifier) return tl::make_unexpected(verifier.error());
    LC_TRY(score, verify::LightMapScore::create(parameters->shading, key, viewing));
    // Odd, so that places fall on every column.
    const int step = static_cast<int>(std::ceil(static_cast<double>(keys.coveredTexels()) / kMostPlaces)) | 1;
    const FloorMeter meter{source, plan, *verifier, *score, key > 0 ? key : 1, step};
    FloorPart whole;
    const auto folded = foldInOrder<FloorPart>(
        source.stripCount(), context, "measure the floor of " + context.action.asset, [&](int index) { return measureStrip(meter, index); },
        [&](const FloorPart& part) { whole.merge(part); });
    if (!folded) return tl::make_unexpected(folded.error());
    return outcomeWith(floorOf(whole));
}

}  // namespace lightcook::pipeline
