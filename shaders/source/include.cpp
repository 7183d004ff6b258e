#include "shaders/include.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace lightcook::shaders {

// Defined in sources.cpp, which the build writes from the .glsl files (embed.cmake).
extern const std::array<ShaderSource, 11> kShaderSources;

std::span<const ShaderSource> allSources() {
    return kShaderSources;
}

std::string shaderInclude(std::span<const std::string> layouts) {
    constexpr std::string_view kLayoutPrefix = "light_map_";
    constexpr std::string_view kSuffix = ".glsl";
    const auto layoutOf = [&](std::string_view name) {
        if (!name.starts_with(kLayoutPrefix)) return std::string_view{};
        return name.substr(kLayoutPrefix.size(), name.size() - kLayoutPrefix.size() - kSuffix.size());
    };
    // A family of layouts has one source: "basis-4" is in light_map_basis.glsl, "luvw-linear" in light_map_luvw.glsl.
    const auto familyOf = [](const std::string& layout) { return std::string_view(layout).substr(0, layout.find('-')); };
    for ([[maybe_unused]] const std::string& layout : layouts)
        assert(std::ranges::any_of(kShaderSources, [&](const ShaderSource& s) { return layoutOf(s.name) == familyOf(layout); }));

    std::string text;
    for (const ShaderSource& source : kShaderSources) {
        const std::string_view layout = layoutOf(source.name);
        if (!layout.empty() && std::ranges::find(layouts, layout, familyOf) == layouts.end()) continue;
        if (!text.empty()) text += '\n';
        text += source.text;
    }
    return text;
}

}  // namespace lightcook::shaders
