#include "pipeline/assets/light_map/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>

#include "compress/light_map.h"
#include "compress/light_map_context.h"
#include "formats/light_map_layout.h"
#include "pipeline/assets/light_map/decoded_rows.h"
#include "pipeline/assets/light_map/joint_trial.h"
#include "pipeline/assets/light_map/mips.h"
#include "pipeline/assets/light_map/planner.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/light_map/whole_trial.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Maps of more texels are tried on a part.
constexpr std::int64_t kTrialTexels = std::int64_t{1} << 20;
/// Layouts that the scene's list lacks are measured on maps of at most this many texels.
constexpr std::int64_t kExcludedTexels = std::int64_t{1} << 18;

formats::LightMapLayout trialOf(const formats::LightMapLayoutInfo& layout) {
    return layout.trialLayout.value_or(layout.id);
}

/// A layout to measure.
struct Trial {
    const formats::LightMapLayoutInfo* layout;
    bool isExcluded;
};

/// Returns the layouts to measure, in the order of the table. A joint trial may name the only one.
std::vector<Trial> trialsOf(const TrialParameters& parameters, const std::optional<JointTrial>& joint, std::int64_t texels) {
    if (joint && joint->layout) return {{&formats::info(*formats::lightMapLayoutFromName(*joint->layout)), false}};
    std::vector<Trial> trials;
    std::set<formats::LightMapLayout> measured;
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts()) {
        const bool isUsual = layout.trialLayout || (layout.isFlat() && parameters.isFlatTried);
        const bool isTaken = parameters.layouts.empty() ? isUsual : formats::mayTake(parameters.layouts, layout);
        if (!parameters.decode.allow(layout) || !(isTaken || isUsual)) continue;
        if (parameters.description.constantOf && layout.isLearned()) continue;  // its mesh would name clusters of the bake
        trials.push_back({&layout, !isTaken});
        if (isTaken) measured.insert(trialOf(layout));
    }
    const auto isFlat = [](const Trial& each) { return each.layout->isFlat(); };
    const auto mayBeNeeded = [&](const Trial& each) {
        const formats::TexelRole first = each.layout->textures.front().role;
        const bool isListed = !parameters.layouts.empty() && !each.isExcluded;
        if (isFlat(each) || isListed) return true;
        if (!parameters.hasDirections) return each.layout->refinesCoefficient0();
        // A layout that stores directions which no shading shows is better than `flat` only if its first texture is finer.
        return parameters.shading.needsDirections() || first == formats::TexelRole::Half || first == formats::TexelRole::HdrFine;
    };
    if (std::ranges::any_of(trials, [&](const Trial& each) { return isFlat(each) && !each.isExcluded; }))
        std::erase_if(trials, std::not_fn(mayBeNeeded));
    if (texels > kExcludedTexels)
        std::erase_if(trials, [&](const Trial& each) { return each.isExcluded && !measured.contains(trialOf(*each.layout)); });
    return trials;
}

/// Layouts that are measured on one plan: the planned one, or it without its last layers.
struct LayoutGroup {
    formats::LightMapLayout planned;
    formats::LightMapFilter filter;
    std::vector<Trial> layouts;
};

/// Returns the layouts to measure, by the plan that they share.
/// joint  empty for a trial of the light map alone
std::vector<LayoutGroup> layoutGroups(const TrialParameters& parameters, const std::optional<JointTrial>& joint, std::int64_t texels) {
    std::vector<LayoutGroup> groups;
    for (const Trial& trial : trialsOf(parameters, joint, texels)) {
        const formats::LightMapLayout planned = trialOf(*trial.layout);
        const formats::LightMapFilter filter = parameters.decode.filterOf(*trial.layout);
        if (groups.empty() || groups.back().planned != planned || groups.back().filter != filter) groups.push_back({planned, filter, {}});
        groups.back().layouts.push_back(trial);
    }
    return groups;
}

/// Returns a plan as a layout without its last layers sees it.
verify::CookedLightMap cookedAs(const formats::LightMapLayoutInfo& layout, const compress::LightMapPlan& plan) {
    verify::CookedLightMap map{std::string(layout.name), plan.constants, plan.width, plan.height};
    map.filter = plan.filter;
    const int planned = formats::info(plan.layout).residualCount();
    const auto residual = map.constants.find("residual");
    if (residual == map.constants.end() || layout.id == plan.layout || planned == 0) return map;
    residual->second.resize(residual->second.size() / static_cast<std::size_t>(planned) * static_cast<std::size_t>(layout.residualCount()));
    return map;
}

/// Removes the layers that a shorter layout does not have.
void shorten(verify::DecodedLightMapRows& rows, const formats::LightMapLayoutInfo& layout) {
    rows.textures.resize(layout.textures.size());
    for (std::size_t i = 0; i < rows.textures.size(); ++i) rows.textures[i].resize(static_cast<std::size_t>(layout.textures[i].layerCount));
}

/// Shades the places of a joint trial under every layout of a group.
class GroupShader {
public:
    static Result<GroupShader> create(const LayoutGroup& group, const compress::LightMapPlan& plan, const verify::LightMapShading& shading,
                                      const WholeTrial* trial) {
        GroupShader shader(group, trial, plan.key);
        if (trial == nullptr) return shader;
        verify::LightMapSampling sampling;
        sampling.placesPerTexel = 0;
        sampling.figures = verify::LightMapFigures::Sampled;
        for (const Trial& each : group.layouts) {
            LC_TRY(verifier, verify::LightMapVerifier::create(cookedAs(*each.layout, plan), shading, sampling, plan.key));
            shader.verifiers_.push_back(std::move(*verifier));
        }
        return shader;
    }
    /// Returns the samples of a strip by layout; nothing without a trial.
    std::vector<std::vector<float>> shade(verify::DecodedLightMapRows rows, const formats::LightMapStrip& texels, int strip) const {
        std::vector<std::vector<float>> samples(verifiers_.size());
        for (std::size_t i = verifiers_.size(); i-- > 0;) {  // the longest last in the table
            shorten(rows, *group_->layouts[i].layout);
            samples[i] = trial_->shadeLightMap(verifiers_[i], key_, rows, texels, strip);
        }
        return samples;
    }

private:
    GroupShader(const LayoutGroup& group, const WholeTrial* trial, double key) : group_(&group), trial_(trial), key_(key) {}
    const LayoutGroup* group_;
    const WholeTrial* trial_;
    double key_;
    std::vector<verify::LightMapVerifier> verifiers_;
};

/// A light map, and the part of it that trials measure.
struct TriedMap {
    LightMapSource& source;
    std::vector<int> strips;
    const TrialParameters& parameters;
    verify::Viewing viewing;
};

/// Returns the index of the last stage of a layout among those of the trial that it is a part of. "total" comes after them and has the
/// figures of the last.
std::size_t lastStageOf(const formats::LightMapLayoutInfo& layout, const std::vector<verify::StageError>& stages) {
    const std::string_view last = layout.trialLayout ? layout.trialStage : layout.stages.back();
    return static_cast<std::size_t>(std::ranges::find(stages, last, &verify::StageError::name) - stages.begin());
}

/// Errors of every stage of a plan, and the light of its layouts.
struct TriedPlan {
    std::vector<verify::StageError> stages;
    std::vector<std::vector<float>> samples;  ///< [layout of the group]
};
struct TriedStrip {
    verify::LightMapErrors errors;
    std::vector<std::vector<float>> samples;
};

/// Returns the errors of every stage of a plan on the surface of a map.
Result<TriedPlan> tryPlan(const TriedMap& map, const compress::LightMapPlan& plan, const GroupShader& shader,
                          const ActionContext& context) {
    const std::string layout(formats::info(plan.layout).name);
    const compress::EncodeOptions options = map.parameters.textures.encodeOptions();
    verify::LightMapSampling sampling;
    sampling.figures = verify::LightMapFigures::Trial;
    LC_TRY(verifier, verify::LightMapVerifier::create(cookedAs(formats::info(plan.layout), plan), map.parameters.shading, sampling,
                                                      plan.key, map.viewing));
    verify::LightMapErrors errors = verifier->noErrors();
    TriedPlan tried;
    const auto verified = foldInOrder<TriedStrip>(
        static_cast<int>(map.strips.size()), context, fmt::format("try {} on {}", layout, context.action.asset),
        [&](int index) -> Result<TriedStrip> {
            const int strip = map.strips[static_cast<std::size_t>(index)], firstRow = map.source.stripFirstRow(strip),
                      rowCount = map.source.stripRows(strip);
            // Places below the last row are filtered from the next one too.
            const int encodedRows = std::min(rowCount + plan.blockHeight(), plan.height - firstRow);
            const auto texels =
                map.source.stripWithMargin(strip, compress::kLightMapContextRows, compress::kLightMapContextRows + encodedRows - rowCount);
            if (!texels) return tl::make_unexpected(texels.error());
            const auto rows = compress::encodeLightMapRows(plan, *texels, firstRow, encodedRows, options);
            verify::DecodedLightMapRows decoded = decodedRows(plan, rows, firstRow, encodedRows);
            TriedStrip result{verifier->verifyRows(decoded, *texels, firstRow, rowCount), {}};
            result.samples = shader.shade(std::move(decoded), *texels, strip);
            return result;
        },
        [&](const TriedStrip& part) {
            errors.merge(part.errors);
            tried.samples.resize(part.samples.size());
            for (std::size_t i = 0; i < part.samples.size(); ++i)
                tried.samples[i].insert(tried.samples[i].end(), part.samples[i].begin(), part.samples[i].end());
        });
    if (!verified) return tl::make_unexpected(verified.error());
    tried.stages = errors.figures();
    return tried;
}

/// Returns the candidate of a layout from the trial of the layout that it is a part of: basis-4 to -20 have the bits of basis-24
/// without the last stages of its residual.
TrialCandidate candidateOf(const Trial& trial, const compress::LightMapPlan& plan, const std::vector<verify::StageError>& stages) {
    const formats::LightMapLayoutInfo& layout = *trial.layout;
    const std::uint64_t bytes = plan.gpuBytesAs(layout.id);
    const verify::StageError& error = stages[lastStageOf(layout, stages)];
    return {std::string(layout.name),
            bytes,
            8.0 * static_cast<double>(bytes) / (static_cast<double>(plan.width) * plan.height),
            error.diffuse.relRms,
            error.specular.relRms,
            error.diffuse.visible->p99,
            error.specular.visible ? error.specular.visible->p99 : 0,
            layout.fetchCount(plan.filter),
            layout.operations(plan.filter),
            plan.tableBytesAs(layout.id),
            trial.isExcluded};
}

/// Shades the reference and the dominant lights of a joint trial. Empty for a trial of the light map alone.
Result<std::optional<WholeTrial>> startJointTrial(const TriedMap& map, const std::optional<JointTrial>& joint,
                                                  const ActionContext& context) {
    if (!joint) return std::optional<WholeTrial>();
    const auto& [source, strips, parameters, viewing] = map;
    LC_TRY(trial, WholeTrial::create(source, strips, parameters.shading, viewing));
    const std::optional<DominantTrial>& dominant = joint->dominant;
    const DominantParameters dominantParameters{parameters.description, dominant ? dominant->fit : "", parameters.target,
                                                parameters.textures};
    LC_CHECK(trial->tryDominants(dominant, dominantParameters, context));
    return std::optional(std::move(*trial));
}

/// Returns the objective of learned layouts in a trial. Empty: energy.
std::optional<compress::LightMapObjective> objectiveOf(const TrialParameters& parameters, const LightMapSource& source, double displayKey) {
    if (parameters.objective != formats::Objective::Visible) return std::nullopt;
    return objectiveFor({parameters.shading, parameters.display}, displayKey, source.bt2020FromWorking());
}

/// Tries the layouts of a light map, with `joint` those of its dominant light too.
Result<JointTrialResult> tryLayouts(const TrialParameters& parameters, const std::optional<JointTrial>& joint,
                                    const ActionContext& context) {
    LC_TRY(source, openLightMap(context, parameters.description));
    const std::vector<LayoutGroup> groups =
        layoutGroups(parameters, joint, static_cast<std::int64_t>((*source)->width()) * (*source)->height());
    const bool hasSharedExit =
        std::ranges::any_of(groups, [](const LayoutGroup& group) { return compress::needsSharedExit(group.planned); });
    LC_TRY(measured, measureLightMap(**source, hasSharedExit, context));
    const double displayKey = measured->key.displayKey();
    const TriedMap map{
        **source, spreadStrips(**source, kTrialTexels), parameters, {parameters.display.of(displayKey), (*source)->bt2020FromWorking()}};
    LC_TRY(mipCount, mipCountOf(**source, parameters.mips, context));
    LightMapPlanner planner(**source, parameters.target, parameters.textures, measured->measure,
                            objectiveOf(parameters, **source, displayKey), *mipCount, context);
    LC_TRY(whole, startJointTrial(map, joint, context));
    JointTrialResult result;
    for (const LayoutGroup& group : groups) {
        LC_TRY(plan, planner.plan(std::string(formats::info(group.planned).name), group.filter));
        LC_TRY(shader, GroupShader::create(group, *plan, parameters.shading, *whole ? &**whole : nullptr));
        LC_TRY(tried, tryPlan(map, *plan, *shader, context));
        for (std::size_t i = 0; i < group.layouts.size(); ++i) {
            const auto& [layout, isExcluded] = group.layouts[i];
            result.trial.candidates.push_back(candidateOf(group.layouts[i], *plan, tried->stages));
            if (*whole && !isExcluded) (*whole)->add(std::string(layout->name), std::move(tried->samples[i]));
        }
    }
    if (*whole) {
        result.dominants = (*whole)->dominants();
        result.whole = (*whole)->pairs(context);
    }
    if (context.state.interrupted) return interrupted(context);
    std::ranges::stable_sort(result.trial.candidates, {}, &TrialCandidate::bytesGpu);
    result.trial.share = static_cast<double>(map.strips.size()) / (*source)->stripCount();
    return result;
}

}  // namespace

Result<ActionOutcome> tryLightMap(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<TrialParameters>(context));
    LC_TRY(result, tryLayouts(*parameters, std::nullopt, context));
    return outcomeWith(result->trial);
}

Result<ActionOutcome> tryJointly(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<JointTrialParameters>(context));
    LC_TRY(result, tryLayouts(parameters->trial, parameters->joint, context));
    return outcomeWith(*result);
}

Result<JointTrialResult> trialIn(const ActionRecord& record) {
    if (record.result.contains("whole")) return fromJson<JointTrialResult>(record.result, record.id);
    LC_TRY(trial, fromJson<TrialResult>(record.result, record.id));
    return JointTrialResult{std::move(*trial), {}, {}};
}

}  // namespace lightcook::pipeline
