#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

#include "pipeline/assets/dominant/cooked_dominant.h"
#include "pipeline/assets/dominant/dominant.h"
#include "pipeline/assets/light_map/ground_truth.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/assets/preview.h"
#include "pipeline/assets/verification.h"
#include "pipeline/graph/parallel_for.h"
#include "shaders/lightcook_cpp.h"
#include "verify/dominant.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Returns the exit radiance of a white Lambert surface under one dominant light.
glm::vec3 litBy(const glm::vec3& direction, const glm::vec3& intensity, const glm::vec3& normal) {
    const float cosine = std::max(glm::dot(normal, shaders::lcDominantDirection(direction, normal)), 0.0f);
    return cosine / std::numbers::pi_v<float> * intensity;
}

glm::dvec3 unitOf(const glm::dvec3& v) {
    return glm::length(v) > 0 ? glm::normalize(v) : v;
}

/// Squared errors of directions, without and with the residual texture. Lengths do not count, as the shader normalises, nor do texels whose
/// direction was turned for the filter, which neither texture has.
struct ResidualGain {
    double coarse = 0, fine = 0;
    void add(const glm::dvec3& truth, const glm::dvec3& first, const glm::dvec3& both) {
        const auto squared = [&](const glm::dvec3& seen) {
            const glm::dvec3 off = unitOf(seen) - unitOf(truth);
            return glm::dot(off, off);
        };
        constexpr double kTurned = 0.1;
        const double without = squared(first), with = squared(both);
        if (std::min(without, with) > kTurned * kTurned) return;
        coarse += without;
        fine += with;
    }
    void merge(const ResidualGain& other) {
        coarse += other.coarse;
        fine += other.fine;
    }
};

/// Errors of some strips.
struct DominantPart {
    verify::DominantErrors errors;
    ResidualGain gain;
    std::vector<verify::DominantTruthPlace> truthPlaces;
    void merge(const DominantPart& other) {
        errors.merge(other.errors);
        gain.merge(other.gain);
        truthPlaces.insert(truthPlaces.end(), other.truthPlaces.begin(), other.truthPlaces.end());
    }
};

/// Compares a cooked dominant light with the bake, strip by strip.
class DominantComparison {
public:
    DominantComparison(LightMapSource& bake, const CookedDominantReader& cooked, const verify::DominantShading& shading,
                       const GroundTruth& groundTruth, double key, const verify::Viewing& viewing)
        : bake_(bake),
          cooked_(cooked),
          groundTruth_(groundTruth),
          key_(key),
          verifier_(cooked.map(), shading, bake.luminanceWeights(), key, viewing),
          preview_(bake.width(), bake.height(), key) {}

    Result<DominantPart> compare(const ActionContext& context) {
        DominantPart whole{verify::DominantErrors(key_), {}, {}};
        const auto compared = foldInOrder<DominantPart>(
            bake_.stripCount(), context, "verify " + context.action.asset, [&](int index) { return compareStrip(index); },
            [&](const DominantPart& part) { whole.merge(part); });
        if (!compared) return tl::make_unexpected(compared.error());
        return whole;
    }
    const Preview& preview() const { return preview_; }

private:
    Result<DominantPart> compareStrip(int index) {
        const int firstRow = bake_.stripFirstRow(index), rowCount = bake_.stripRows(index);
        DominantPart part{verify::DominantErrors(key_), {}, {}};
        LC_TRY(reference, bake_.stripWithMargin(index, 0, 1));
        LC_TRY(cooked, cooked_.read(firstRow, rowCount));
        for (int y = 0; y < rowCount; ++y)
            for (int x = 0; x < bake_.width(); ++x)
                if (isCompared(*reference, x, y, firstRow)) compareTexel(*reference, *cooked, x, y, firstRow, part);
        part.errors = verifier_.verifyRows(cooked->whole, *reference, firstRow, rowCount);
        LC_TRY(traced, groundTruth_.within(*reference, firstRow, rowCount));
        part.truthPlaces = dominantPlaces(
            bakedPlaces(*traced, *reference), verifier_, cooked_.map().fit == verify::DominantFit::RefinedAmbient,
            [&](const verify::LightMapTruthPlace& place) { return verifier_.decode(cooked->whole, place.value.x, place.value.y); });
        return part;
    }

    /// Returns true for texels of the pictures and, of a map with a residual, for every second one of every second row: a refined reference
    /// costs a search for each.
    bool isCompared(const formats::LightMapStrip& reference, int x, int y, int firstRow) const {
        if (reference.covered.at(x, y) == 0) return false;
        return preview_.shows(x, firstRow + y) || (cooked_.hasResidual() && x % 2 == 0 && y % 2 == 0);
    }

    void compareTexel(const formats::LightMapStrip& reference, const CookedDominantReader::Rows& cooked, int x, int y, int firstRow,
                      DominantPart& part) {
        const glm::vec3 normal = reference.normal.at(x, y);
        const auto seen = verifier_.decode(cooked.whole, x, firstRow + y);
        const auto truth = verifier_.reference(reference.sh.at(x, y), glm::dvec3(normal), seen);
        part.gain.add(truth.direction, verifier_.decode(cooked.coarse, x, firstRow + y).direction, seen.direction);
        const glm::vec3 lit = litBy(glm::vec3(truth.direction), glm::vec3(truth.intensity), normal);
        const glm::vec3 litAsSeen = litBy(glm::vec3(seen.direction), glm::vec3(seen.intensity), normal);
        preview_.set(x, firstRow + y, lit, litAsSeen);
    }

    LightMapSource& bake_;
    const CookedDominantReader& cooked_;
    const GroundTruth& groundTruth_;
    double key_;
    verify::DominantVerifier verifier_;
    Preview preview_;
};

/// Returns the faults of a comparison: a residual texture that makes directions worse.
std::vector<verify::Violation> violationsOf(const DominantPart& whole, bool hasResidual) {
    std::vector<verify::Violation> violations;
    const ResidualGain& gain = whole.gain;
    // The second texture adds its own rounding, also to a first one that is exact.
    constexpr double kRounding = 1e-8;
    if (hasResidual && gain.fine > 1.05 * gain.coarse + kRounding)
        violations.push_back({"texture residual", fmt::format("a squared error of directions of {:.3g}", gain.fine),
                              fmt::format("no more than without it ({:.3g}): it belongs to something else", gain.coarse)});
    return violations;
}

}  // namespace

Result<ActionOutcome> verifyDominant(const ActionContext& context) {
    const Stopwatch watch;
    LC_TRY(asset, upstreamAsset(context));
    LC_TRY(parameters, parametersOf<DominantVerifyParameters>(context));
    LC_TRY(description, descriptionOf(*asset));
    LC_TRY(source, openLightMap(context, *description));
    LightMapSource& bake = **source;
    LC_TRY(cooked, CookedDominantReader::open(context.upstreamFolder, *asset, {bake.width(), bake.height()}));
    LC_TRY(survey, bake.survey(context));
    const double key = (*survey)->key.key();
    LC_TRY(groundTruth, GroundTruth::open(context, bake, description->colors));

    const verify::LightMapShading& materials = parameters->view.shading;
    const verify::DominantShading shading{materials.m, materials.f0, materials.viewCount,
                                          verify::dominantStride(bake.width(), bake.height()), materials.lobe};
    const verify::Viewing viewing{parameters->view.display.of((*survey)->key.displayKey()), bake.bt2020FromWorking()};
    DominantComparison comparison(bake, *cooked, shading, *groundTruth, key, viewing);
    LC_TRY(whole, comparison.compare(context));

    const verify::DominantErrors& errors = whole->errors;
    VerifyResult result = judged(errors.stages(), parameters->limits, watch, violationsOf(*whole, cooked->hasResidual()));
    result.key = key;
    result.light.emplace().specularRms = errors.referenceRms();
    if (!whole->truthPlaces.empty()) result.groundTruth = toJson(verify::dominantTruth(whole->truthPlaces, materials.lobe, viewing));
    result.measures = {{note_keys::kDirectionErrorDegreesMean, errors.meanDirectionError()},
                       {note_keys::kDirectionErrorDegreesMax, errors.maxDirectionError()},
                       {note_keys::kUnexplainedEnergyStored, errors.unexplainedStored()},
                       {note_keys::kUnexplainedEnergyReference, errors.unexplainedReference()},
                       {note_keys::kShadedEveryTexels, shading.stride}};
    return outcomeWithPreview(std::move(result), comparison.preview(), context);
}

}  // namespace lightcook::pipeline
