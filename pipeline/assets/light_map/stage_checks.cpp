// Checks of the stages of a cooked light map, as figures of the whole map.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "formats/light_map_layout.h"
#include "pipeline/assets/light_map/checked_light_map.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Returns true if a stage of a layout encodes what the stage before it leaves.
bool isResidual(std::string_view stage) {
    return stage == "stage 2" || stage.starts_with("residual ");
}

/// Returns the error that the codes of a residual stage have beside a first stage that is exact. No code of halo3's second texture leaves
/// the first one as it is: the nearest to 1/2 are half a step of 8 bits away, of a residual from -1 to 1 in units of coefficient 0. Over
/// all directions, nine coefficients of an orthonormal basis that are off by half a step each miss by three of them.
double roundingOfResidual(const std::string& name) {
    const auto layout = formats::lightMapLayoutFromName(name);
    const bool isHalo3 = layout && formats::info(*layout).family == formats::LightMapFamily::Halo3;
    constexpr double kHalfStep = 1.0 / 255;
    constexpr double kFirstStage = kHalfStep;  // that is not exact: light of one colour has 0.0122 where 3 half steps are 0.0118
    return isHalo3 ? 3 * kHalfStep + kFirstStage : 0;
}

/// Returns true if stage `after` was measured on the surface, and does not add to the error of stage `before` there: a residual that is
/// fitted to the places between texels need not be right at texel centres.
bool isRightOnSurface(const std::vector<verify::LightMapErrors::Stage>& stages, const std::string& before, const std::string& after) {
    const auto first = std::ranges::find(stages, before, &verify::LightMapErrors::Stage::name);
    const auto second = std::ranges::find(stages, after, &verify::LightMapErrors::Stage::name);
    if (first == stages.end() || second == stages.end() || !(second->surface.reference > 0)) return false;
    return !addsError(first->surface.relRms(), second->surface.relRms());
}

}  // namespace

/// A residual may add to the error at texel centres, or on the surface, but not in both.
Result<void> checkResiduals(CheckedLightMap& map) {
    const std::vector<verify::StageError>& stages = map.result.verdict.stages;
    for (std::size_t i = 1; i < stages.size(); ++i) {
        const std::string &before = stages[i - 1].name, &after = stages[i].name;
        if (isResidual(after) && !isRightOnSurface(map.texels.errors.stages, before, after))
            checkStage(stages, before, after, roundingOfResidual(map.asset.layout), map.violations());
    }
    return {};
}

Result<void> checkLayout(CheckedLightMap& map) {
    const auto layout = formats::lightMapLayoutFromName(map.asset.layout);
    const std::vector<Figure> errors = {{Limit::Error, std::max(map.total().diffuse.relRms, map.total().specular.relRms), "", ""}};
    if (!layout || areKept(judge(errors, map.parameters.limits)) || !map.parameters.shading.needsDirections()) return {};
    const std::string lacks(formats::info(*layout).lacks);
    if (lacks.empty()) return {};
    map.violations().insert(map.violations().begin(),
                            {fmt::format("layout {}", map.asset.layout), fmt::format("a layout without {}", lacks),
                             "a layout that has it, or materials that do not need it (normal_map = false, specular = false)"});
    return {};
}

}  // namespace lightcook::pipeline
