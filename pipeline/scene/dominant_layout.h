// Layouts of the dominant light: whether it has textures, or the shader derives it.
#pragma once

#include <span>
#include <string_view>

namespace lightcook::pipeline {

struct DominantLayoutInfo {
    std::string_view name;  ///< value of `dominant_layout`
    std::string_view caption;
};

/// The layout that has textures, that whose light the shader takes from the light map's coefficients, and that without a dominant light.
inline constexpr std::string_view kStoredDominant = "full", kDerivedDominant = "derived", kNoDominant = "none";

/// Returns every layout, the largest first.
std::span<const DominantLayoutInfo> allDominantLayouts();
/// Returns the layout where the scene file names none. The shader derives the light if that is the light of the fit, and if it reads the
/// coefficients of the map: the textures of engines and flat ones have fewer.
/// lightMapLayout  its name, or kAutoLayout
std::string_view usualDominantLayout(std::string_view lightMapLayout, std::string_view fit);

}  // namespace lightcook::pipeline
