#include "pipeline/assets/mesh/bit_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/mesh/quantization.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/mesh.h"

namespace lightcook::pipeline {
namespace {

using formats::DracoOptions;
using formats::Result;

/// Part of the limit on rel_rms that a mesh may use: its error adds to that of the light map.
constexpr double kShareOfLimit = 0.1;
/// Part of the limit on visible errors. A mesh is held to the whole of it.
constexpr double kShareOfVisible = 0.5;
/// Largest distance of a light-map UV, well inside its texel.
constexpr double kMostTexels = 0.25;
/// Visible errors are measured on evenly spread strips of larger maps.
constexpr std::int64_t kMeasuredTexels = std::int64_t{1} << 18;

/// Bits that the choice may take.
struct BitRange {
    int DracoOptions::*bits;
    int fewest, most;
};
constexpr BitRange kUvRange{&DracoOptions::lightMapUvBits, 8, kMostUvBits};
constexpr BitRange kNormalRange{&DracoOptions::normalBits, 6, 14};
constexpr BitRange kPositionRange{&DracoOptions::positionBits, DracoOptions().positionBits, 20};

/// Returns the bound of rel_rms for any bits.
Result<verify::MeshShiftBound> surveyShifts(LightMapSource& bake, const ActionContext& context) {
    const auto boundStrip = [&](int index) -> Result<verify::MeshShiftBound> {
        LC_TRY(strip, bake.stripWithMargin(index, 0, 1));
        verify::MeshShiftBound part;
        part.add(*strip, bake.stripFirstRow(index), bake.stripRows(index));
        return part;
    };
    verify::MeshShiftBound bound;
    const auto surveyed = foldInOrder<verify::MeshShiftBound>(bake.stripCount(), context, "survey " + context.action.asset, boundStrip,
                                                              [&](const verify::MeshShiftBound& part) { bound.merge(part); });
    if (!surveyed) return tl::make_unexpected(surveyed.error());
    return bound;
}

/// Chooses the bits of one mesh.
class BitChoice {
public:
    /// extent     of the scene, as GltfScene::errorOf() has it
    /// hasSeamLimit  true if the seams of the light map have a limit
    BitChoice(const formats::GltfScene& scene, const formats::MeshError& extent, LightMapSource& bake, const verify::MeshShiftBound& bound,
              bool hasSeamLimit, const ActionContext& context)
        : extent_(extent),
          bake_(bake),
          bound_(bound),
          context_(context),
          texels_(std::max(bake.width(), bake.height())),
          texelsPerUnit_(verify::texelsPerUnit(scene.triangleMeshes(), bake.width(), bake.height())),
          mostUvShift_(hasSeamLimit ? mostUvShiftAtSeams(extent.lightMapUvExtent * texels_) : kMostTexels) {}

    /// Returns the fewest bits of UVs and normals together whose bound keeps the limit; the finest lattice if none does.
    MeshBits within(double maxRelRms) const {
        MeshBits chosen;
        chosen.options.lightMapUvBits = kUvRange.most;
        chosen.options.normalBits = kNormalRange.most;
        chosen.bound = bound_.relRms(shiftOf(chosen.options));
        DracoOptions each;
        for (each.lightMapUvBits = kUvRange.fewest; each.lightMapUvBits <= kUvRange.most; ++each.lightMapUvBits)
            for (each.normalBits = kNormalRange.fewest; each.normalBits <= kNormalRange.most; ++each.normalBits) {
                const verify::MeshShift shift = shiftOf(each);
                const double found = bound_.relRms(shift);
                if (found > maxRelRms || shift.uTexels > mostUvShift_) continue;
                const int bits = each.lightMapUvBits + each.normalBits, fewest = chosen.options.lightMapUvBits + chosen.options.normalBits;
                if (bits < fewest || (bits == fewest && found < chosen.bound)) chosen = {each, found};
            }
        return chosen;
    }

    /// Adds bits, each where it helps most, until visible errors and their bound are within the limits, or there are no more.
    Result<void> refine(MeshBits& chosen, const VisibleParameters& visible) const {
        LC_TRY(survey, bake_.survey(context_));
        const verify::Viewing viewing = visible.viewing((*survey)->key.displayKey(), bake_.bt2020FromWorking());
        LC_TRY(found, visibleShare(chosen.options, visible, viewing));
        while (*found > 1) {
            std::optional<DracoOptions> best;
            for (const BitRange& range : {kUvRange, kNormalRange, kPositionRange}) {
                DracoOptions finer = chosen.options;
                if (++(finer.*range.bits) > range.most) continue;
                LC_TRY(error, visibleShare(finer, visible, viewing));
                if (best && *error >= *found) continue;
                best = finer;
                found = error;
            }
            if (!best) break;
            chosen.options = *best;
        }
        chosen.bound = bound_.relRms(shiftOf(chosen.options));
        return {};
    }

private:
    verify::MeshShift shiftOf(const DracoOptions& options) const {
        const double uv = extent_.lightMapUvExtent * texels_ * kUvSteps / latticeSteps(options.lightMapUvBits);
        return {uv, uv, kNormalSteps / latticeSteps(options.normalBits)};
    }

    /// Returns the share of its limit that the visible error of some bits takes, or its bound, whichever takes more.
    Result<double> visibleShare(const DracoOptions& options, const VisibleParameters& visible, const verify::Viewing& viewing) const {
        // A bound is that of all strips.
        std::vector<int> strips = spreadStrips(bake_, kMeasuredTexels);
        const bool isBoundLimited = visible.limits[Limit::VisibleBound].has_value();
        if (isBoundLimited) {
            strips.resize(static_cast<std::size_t>(bake_.stripCount()));
            std::iota(strips.begin(), strips.end(), 0);
        }
        const double position = extent_.positionExtent * kPositionSteps / latticeSteps(options.positionBits);
        const auto measure = [&](int i) -> Result<verify::VisiblePairs> {
            const int index = strips[static_cast<std::size_t>(i)];
            LC_TRY(strip, bake_.stripWithMargin(index, 1, 2));
            verify::VisiblePairs part(viewing);
            const int firstRow = bake_.stripFirstRow(index), rowCount = bake_.stripRows(index);
            verify::addMeshShiftVisible(*strip, firstRow, rowCount, shiftOf(options), position * texelsPerUnit_, part);
            if (isBoundLimited)
                verify::addMeshShiftVisibleBound(*strip, firstRow, rowCount, shiftOf(options), position * texelsPerUnit_, viewing, part);
            return part;
        };
        verify::VisiblePairs errors(viewing);
        const auto done =
            foldInOrder<verify::VisiblePairs>(static_cast<int>(strips.size()), context_, "fit bits of " + context_.action.asset, measure,
                                              [&](const verify::VisiblePairs& part) { errors.merge(part); });
        if (!done) return tl::make_unexpected(done.error());
        const auto figures = errors.figures();
        if (!figures) return 0;
        return mostUsedShare(
            judge({{Limit::Visible, figures->p99 / kShareOfVisible, "", ""}, {Limit::VisibleBound, figures->bound.value_or(0), "", ""}},
                  visible.limits));
    }

    formats::MeshError extent_;
    LightMapSource& bake_;
    verify::MeshShiftBound bound_;
    const ActionContext& context_;
    double texels_, texelsPerUnit_;
    double mostUvShift_;  ///< [texels]
};

/// Refuses light-map UVs of a range that the finest lattice does not tell apart.
Result<void> checkUvExtent(const formats::MeshError& extent, const LightMapSource& bake, const ActionContext& context) {
    const double most = kMostUvTexels / std::max(bake.width(), bake.height()) * latticeSteps(kMostUvBits) / kUvSteps;
    if (extent.lightMapUvExtent <= most) return {};
    return formats::failure(formats::ErrorCode::ValueOutOfRange, context.action.inputs.at(kMeshRole),
                            fmt::format("found light-map UVs over a range of {:.3g}, expected at most {:.3g}, beyond which {} bits move a "
                                        "vertex by more than {} texels: a light map does not repeat",
                                        extent.lightMapUvExtent, most, kMostUvBits, kMostUvTexels));
}

}  // namespace

Result<MeshBits> chooseMeshBits(const formats::GltfScene& scene, const MeshParameters& parameters, const ActionContext& context) {
    LC_TRY(opened, openLightMap(context, parameters.description));
    LC_TRY(extent, scene.errorOf(scene));
    LC_CHECK(checkUvExtent(*extent, **opened, context));
    LC_TRY(bound, surveyShifts(**opened, context));
    const BitChoice choice(scene, *extent, **opened, *bound, parameters.visible.limits[Limit::Seam].has_value(), context);
    MeshBits chosen = choice.within(kShareOfLimit * parameters.visible.limits[Limit::Error].value_or(kNoErrorLimit));
    if (!parameters.visible.limits[Limit::Visible] && !parameters.visible.limits[Limit::VisibleBound]) return chosen;
    LC_CHECK(choice.refine(chosen, parameters.visible));
    return chosen;
}

}  // namespace lightcook::pipeline
