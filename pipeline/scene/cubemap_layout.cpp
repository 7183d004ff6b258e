#include "pipeline/scene/cubemap_layout.h"

#include <array>

#include "formats/vocabulary.h"

namespace lightcook::pipeline {
namespace {

constexpr std::array kCubemapLayouts = {
    CubemapLayoutInfo{CubemapLayout::PreDivided, "pre-divided",
                      "divided by the probe's own area specular; the shader multiplies by that of the pixel (`lcEnvironment`)",
                      "prefiltered radiance over its own area specular"},
    CubemapLayoutInfo{CubemapLayout::Prefiltered, "prefiltered", "prefiltered radiance as it is (`lcPrefiltered`)", "prefiltered radiance"},
};
static_assert(formats::isCompleteTable(kCubemapLayouts, CubemapLayout::Prefiltered));

}  // namespace

std::span<const CubemapLayoutInfo> allCubemapLayouts() {
    return kCubemapLayouts;
}

const CubemapLayoutInfo& info(CubemapLayout layout) {
    return kCubemapLayouts.at(static_cast<std::size_t>(layout));
}

const CubemapLayoutInfo* cubemapLayoutFromName(std::string_view name) {
    return formats::findByName(allCubemapLayouts(), name);
}

}  // namespace lightcook::pipeline
