#include "shaders/include.h"

#include <algorithm>
#include <cassert>

namespace lightcook::shaders {
namespace {

/// Returns "ratio" for "light_map_ratio.glsl", and nothing for a source that is not of a light map.
std::string_view familyOf(const ShaderSource& source) {
    constexpr std::string_view kPrefix = "light_map_", kSuffix = ".glsl";
    if (!source.name.starts_with(kPrefix)) return {};
    return source.name.substr(kPrefix.size(), source.name.size() - kPrefix.size() - kSuffix.size());
}

}  // namespace

bool hasLightMapFamily(std::string_view family) {
    return !family.empty() && std::ranges::find(allSources(), family, familyOf) != allSources().end();
}

std::string shaderInclude(std::span<const std::string> families, Distribution distribution) {
    assert(std::ranges::all_of(families, hasLightMapFamily));
    std::string text;
    if (distribution == Distribution::Ggx)
        text = "// The specular lobe of this scene, for lcDistribution.\n#ifndef LIGHTCOOK_GGX\n#define LIGHTCOOK_GGX\n#endif\n";
    for (const ShaderSource& source : allSources()) {
        const std::string_view family = familyOf(source);
        if (!family.empty() && std::ranges::find(families, family) == families.end()) continue;
        if (!text.empty()) text += '\n';
        text += source.text;
    }
    return text;
}

}  // namespace lightcook::shaders
