#include "pipeline/scene/dominant_layout.h"

#include <array>

#include "formats/light_map_layout.h"
#include "pipeline/scene/dominant_fit.h"

namespace lightcook::pipeline {
namespace {

constexpr std::array kDominantLayouts = {
    DominantLayoutInfo{kStoredDominant, "textures of direction, its residual and intensity, as large as the light map"},
    DominantLayoutInfo{kDerivedDominant, "no textures: the shader derives the light from the light map's coefficients"},
    DominantLayoutInfo{kNoDominant, "no dominant light: all specular light is area specular"},
};

}  // namespace

std::span<const DominantLayoutInfo> allDominantLayouts() {
    return kDominantLayouts;
}

std::string_view usualDominantLayout(std::string_view lightMapLayout, std::string_view fit) {
    const auto layout = formats::lightMapLayoutFromName(lightMapLayout);
    const bool hasCoefficients = !layout || (!formats::info(*layout).isForEngine && formats::info(*layout).lacks.empty());
    return isDerivable(fit) && hasCoefficients ? kDerivedDominant : kStoredDominant;
}

}  // namespace lightcook::pipeline
