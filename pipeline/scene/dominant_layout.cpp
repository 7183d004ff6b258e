#include "pipeline/scene/dominant_layout.h"

#include <array>

#include "formats/vocabulary.h"

namespace lightcook::pipeline {
namespace {

constexpr std::array kDominantLayouts = {
    DominantLayoutInfo{"full", "direction, its residual and intensity, as large as the light map", 1, true},
    DominantLayoutInfo{"full-coarse", "the same without the residual", 1, false},
    DominantLayoutInfo{"half", "the first at half the width and height", 2, true},
    DominantLayoutInfo{"half-coarse", "the second at half the width and height", 2, false},
    DominantLayoutInfo{"quarter", "the first at a quarter of the width and height", 4, true},
    DominantLayoutInfo{"quarter-coarse", "the second at a quarter of the width and height", 4, false},
    DominantLayoutInfo{"derived", "no textures: the shader derives the light from the light map's coefficients", 0, false, true},
    DominantLayoutInfo{"none", "no dominant light: all specular light is area specular", 0, false},
};

}  // namespace

std::span<const DominantLayoutInfo> allDominantLayouts() {
    return kDominantLayouts;
}

const DominantLayoutInfo* dominantLayoutFromName(std::string_view name) {
    return formats::findByName(allDominantLayouts(), name);
}

}  // namespace lightcook::pipeline
