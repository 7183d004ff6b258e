#include <algorithm>
#include <cmath>

#include "fit/cubemap.h"
#include "formats/png.h"
#include "lighting/radiometry.h"
#include "pipeline/assets/gltf/gltf.h"
#include "pipeline/assets/source_colors.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

constexpr int kSize = 64, kLevels = 3;

/// Returns a colour as RGBD: rgb = (colour D)^(1/2.2), D = floor(255 / largest channel) / 255, from 1/255 to 1. Babylon.js decodes it so;
/// the extension leaves the curve open.
glm::u8vec4 rgbd(const glm::vec3& color) {
    const float largest = std::max({color.x, color.y, color.z, 1e-7f});
    const float d = std::clamp(std::floor(std::max(255 / largest, 1.0f)) / 255, 0.0f, 1.0f);
    glm::u8vec4 texel(0, 0, 0, static_cast<std::uint8_t>(255 * d + 0.5f));
    for (int c = 0; c < 3; ++c) texel[c] = static_cast<std::uint8_t>(255 * std::pow(std::clamp(color[c] * d, 0.0f, 1.0f), 1 / 2.2f) + 0.5f);
    return texel;
}

}  // namespace

Result<formats::GltfLightMap::Environment> environmentOf(const GltfProbe& probe, bool repair, const ActionContext& context) {
    AssetSource read;
    read.colors = probe.colors;
    read.repair = repair;
    LC_TRY(loaded, formats::loadEnvironment(context.action.inputs.at(kProbeSourceRole), environmentOptions(read, context.action)));
    const auto stored = context.action.inputs.find(kProbeShRole);
    LC_TRY(sh, stored == context.action.inputs.end() ? Result<lighting::ShRgb>(fit::projectEnvironment(loaded->environment))
                                                     : formats::loadProbeSh(stored->second, probe.file));
    formats::GltfLightMap::Environment light;
    light.name = probe.name;
    light.irradiance = lighting::convolve(*sh, lighting::kIrradianceBands);
    light.size = kSize;
    const auto filter = fit::CubemapPrefilter::create(
        loaded->environment, {.size = kSize, .mipCount = kLevels, .kernel = fit::PrefilterKernel::Ggx, .roughness = {}});
    if (!filter) return tl::make_unexpected(filter.error());
    for (int level = 0; level < kLevels; ++level) {
        const formats::Image<glm::vec3> strip = filter->filterMip(level);
        const int size = strip.width();
        auto& faces = light.levels.emplace_back();
        for (int face = 0; face < 6; ++face) {
            // The extension's faces are mirrored left to right.
            formats::Image<glm::u8vec4> texels(size, size);
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x) texels.at(x, y) = rgbd(strip.at(size - 1 - x, face * size + y));
            LC_TRY(png, formats::encodePng(texels.view()));
            faces[static_cast<std::size_t>(face)] = std::move(*png);
        }
    }
    return light;
}

}  // namespace lightcook::pipeline
