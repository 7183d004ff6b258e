// Layouts of the dominant light: size and number of its textures. One table, from which the cook, its trial and the allocation of memory
// derive.
#pragma once

#include <span>
#include <string_view>

namespace lightcook::pipeline {

struct DominantLayoutInfo {
    std::string_view name;  ///< value of `dominant_layout` and `dominant --layout`; in parameters of actions and in the report
    std::string_view caption;
    int divisor = 1;          ///< of the light map's width and height, rounded up; 0: no textures
    bool hasResidual = true;  ///< under targets that have a residual texture
    bool isDerived = false;   ///< the shader takes the light from the light map's coefficients
};

/// The layout without a dominant light.
inline constexpr std::string_view kNoDominant = "none";

/// Returns every layout, the largest first.
std::span<const DominantLayoutInfo> allDominantLayouts();
/// Returns nullptr for names that are not in the table.
const DominantLayoutInfo* dominantLayoutFromName(std::string_view name);

}  // namespace lightcook::pipeline
