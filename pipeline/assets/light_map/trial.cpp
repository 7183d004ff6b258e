#include "pipeline/assets/light_map/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "compress/light_map.h"
#include "formats/light_map_layout.h"
#include "pipeline/assets/light_map/planner.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/light_map.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Maps of more texels are tried on a part.
constexpr std::int64_t kTrialTexels = std::int64_t{1} << 20;

/// Returns every n-th strip, from the middle of the first n on.
std::vector<int> trialStrips(const LightMapSource& source) {
    const std::int64_t texels = static_cast<std::int64_t>(source.width()) * source.height();
    const int step = static_cast<int>(std::max<std::int64_t>(1, (texels + kTrialTexels - 1) / kTrialTexels));
    std::vector<int> strips;
    for (int strip = (step - 1) / 2; strip < source.stripCount(); strip += step) strips.push_back(strip);
    return strips;
}

/// Decodes an encoded strip with the verifier's own decoders.
verify::DecodedLightMapRows decodedRows(const compress::LightMapPlan& plan, const compress::EncodedLightMapRows& rows, int firstRow,
                                        int rowCount) {
    verify::DecodedLightMapRows out;
    out.firstRow = firstRow;
    for (std::size_t texture = 0; texture < plan.textures.size(); ++texture) {
        out.textures.emplace_back();
        for (const auto& bytes : rows.textures[texture].layers) {
            out.textures.back().emplace_back(plan.width, rowCount);
            verify::decodeRows(plan.textures[texture].format, bytes, out.textures.back().back().view());
        }
    }
    return out;
}

/// Returns the errors of every stage of a plan on the surface of some strips.
Result<std::vector<verify::StageError>> tryPlan(LightMapSource& source, const compress::LightMapPlan& plan, const std::vector<int>& strips,
                                                const compress::EncodeOptions& options, const verify::LightMapShading& shading,
                                                const verify::Viewing& viewing, const ActionContext& context) {
    const std::string layout(formats::info(plan.layout).name);
    verify::LightMapSampling sampling;
    sampling.isForTrial = true;
    sampling.bounds = false;
    const auto verifier =
        verify::LightMapVerifier::create({layout, plan.constants, plan.width, plan.height}, shading, sampling, plan.key, viewing);
    if (!verifier) return tl::make_unexpected(verifier.error());
    verify::LightMapErrors errors = verifier->noErrors();
    const auto verified = foldInOrder<verify::LightMapErrors>(
        static_cast<int>(strips.size()), context, fmt::format("try {} on {}", layout, context.action.asset),
        [&](int index) -> Result<verify::LightMapErrors> {
            const int strip = strips[static_cast<std::size_t>(index)], firstRow = source.stripFirstRow(strip),
                      rowCount = source.stripRows(strip);
            // Places below the last row are filtered from the next one too.
            const int encodedRows = std::min(rowCount + plan.blockHeight(), plan.height - firstRow);
            const auto texels =
                source.stripWithMargin(strip, compress::kLightMapPaddingRows, compress::kLightMapPaddingRows + encodedRows - rowCount);
            if (!texels) return tl::make_unexpected(texels.error());
            const auto rows = compress::encodeLightMapRows(plan, *texels, firstRow, encodedRows, options);
            return verifier->verifyRows(decodedRows(plan, rows, firstRow, encodedRows), *texels, firstRow, rowCount);
        },
        [&](const verify::LightMapErrors& part) { errors.merge(part); });
    if (!verified) return tl::make_unexpected(verified.error());
    return errors.figures();
}

/// Returns the candidate of a layout from the trial of the layout that it is a part of: basis-4, -8 and -12 have the bits of basis-16
/// without the last stages of its residual.
TrialCandidate candidateOf(const formats::LightMapLayoutInfo& layout, const compress::LightMapPlan& plan,
                           const std::vector<verify::StageError>& stages) {
    const std::uint64_t bytes = plan.gpuBytesAs(layout.id);
    const std::string_view last = layout.trialLayout ? layout.trialStage : layout.stages.back();
    const verify::StageError& error = *std::ranges::find(stages, last, &verify::StageError::name);
    return {std::string(layout.name),
            bytes,
            8.0 * static_cast<double>(bytes) / (static_cast<double>(plan.width) * plan.height),
            error.diffuse.relRms,
            error.specular.relRms,
            error.diffuse.visible->p99,
            error.specular.visible ? error.specular.visible->p99 : 0,
            layout.tapCount(),
            layout.decodeOps,
            plan.tableBytesAs(layout.id)};
}

}  // namespace

Result<ActionOutcome> tryLightMap(const ActionContext& context) {
    const auto parameters = parametersOf<TrialParameters>(context);
    if (!parameters) return tl::make_unexpected(parameters.error());
    const auto source = openLightMap(context, parameters->description);
    if (!source) return tl::make_unexpected(source.error());
    const auto measured = measureLightMap(**source, context);
    if (!measured) return tl::make_unexpected(measured.error());
    const verify::Viewing viewing{parameters->display.of(measured->key.displayKey()), (*source)->bt2020FromWorking()};
    std::optional<compress::LightMapObjective> objective;
    if (parameters->objective == formats::Objective::Visible)
        objective = objectiveFor({parameters->shading, parameters->display}, measured->key.displayKey(), (*source)->bt2020FromWorking());
    LightMapPlanner planner(**source, parameters->target, parameters->textures, measured->measure, objective, context);
    const std::vector<int> strips = trialStrips(**source);
    const compress::EncodeOptions options = parameters->textures.encodeOptions();
    TrialResult result;
    std::optional<compress::LightMapPlan> plan;
    std::optional<formats::LightMapLayout> tried;
    std::vector<verify::StageError> stages;
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts()) {
        const bool isFlat = layout.id == formats::LightMapLayout::Flat;
        if (!layout.trialLayout && !(isFlat && parameters->isFlatTried)) continue;
        if (!parameters->decode.allow(layout)) continue;
        const formats::LightMapLayout whole = layout.trialLayout.value_or(layout.id);
        if (tried != whole) {
            auto planned = planner.plan(std::string(formats::info(whole).name));
            if (!planned) return tl::make_unexpected(planned.error());
            plan = std::move(*planned);
            tried = whole;
            auto errors = tryPlan(**source, *plan, strips, options, parameters->shading, viewing, context);
            if (!errors) return tl::make_unexpected(errors.error());
            stages = std::move(*errors);
        }
        result.candidates.push_back(candidateOf(layout, *plan, stages));
    }
    std::ranges::stable_sort(result.candidates, {}, &TrialCandidate::bytesGpu);
    result.share = static_cast<double>(strips.size()) / (*source)->stripCount();
    return outcomeWith(result);
}

}  // namespace lightcook::pipeline
