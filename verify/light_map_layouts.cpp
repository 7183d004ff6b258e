#include "verify/light_map_layouts.h"

#include <algorithm>
#include <span>

namespace verify::layouts {

namespace {

using formats::ErrorCode;

/// Copies a constant of exactly out.size() finite values; what is wrong with it otherwise.
std::optional<formats::Error> readConstant(const CookedLightMap& map, const std::string& name, std::span<float> out) {
    const std::string place = "light map layout " + map.layout + ", constant " + name;
    const auto found = map.constants.find(name);
    if (found == map.constants.end()) return formats::Error{ErrorCode::WrongShape, place, "not found, expected it in the manifest"};
    if (found->second.size() != out.size())
        return formats::Error{ErrorCode::WrongShape, place,
                              "found " + std::to_string(found->second.size()) + " values, expected " + std::to_string(out.size())};
    if (!std::ranges::all_of(found->second, [](float v) { return std::isfinite(v); }))
        return formats::Error{ErrorCode::ValueNotFinite, place, "found NaN or infinity, expected finite values"};
    std::ranges::copy(found->second, out.begin());
    return std::nullopt;
}

formats::Result<Layout> readLuvw(const CookedLightMap& map) {
    Luvw luvw;
    std::array<float, 4> neutral{};
    if (auto error = readConstant(map, "range", luvw.k.range)) return tl::make_unexpected(*error);
    if (auto error = readConstant(map, "span", luvw.k.span)) return tl::make_unexpected(*error);
    if (auto error = readConstant(map, "neutral", neutral)) return tl::make_unexpected(*error);
    if (auto error = readConstant(map, "root", std::span(&luvw.k.root, 1))) return tl::make_unexpected(*error);
    luvw.k.neutral = glm::vec4(neutral[0], neutral[1], neutral[2], neutral[3]);
    return luvw;
}

formats::Result<Layout> readRatio(const CookedLightMap& map) {
    Ratio ratio;
    if (auto error = readConstant(map, "range", std::span(&ratio.k.range, 1))) return tl::make_unexpected(*error);
    if (auto error = readConstant(map, "scale", ratio.k.scale)) return tl::make_unexpected(*error);
    if (auto error = readConstant(map, "bias", ratio.k.bias)) return tl::make_unexpected(*error);
    return ratio;
}

template <class RangeOnly>
formats::Result<Layout> readRangeOnly(const CookedLightMap& map) {
    RangeOnly layout;
    if (auto error = readConstant(map, "range", std::span(&layout.k.range, 1))) return tl::make_unexpected(*error);
    return layout;
}

}  // namespace

formats::Result<Layout> layoutOf(const CookedLightMap& map) {
    if (map.layout == "raw") return readRangeOnly<Raw>(map);
    if (map.layout == "flat") return readRangeOnly<Flat>(map);
    if (map.layout == "luvw") return readLuvw(map);
    if (map.layout == "ratio") return readRatio(map);
    return formats::failure(ErrorCode::WrongShape, "light map layout", "found \"" + map.layout + "\", expected raw, flat, luvw or ratio");
}

std::vector<LightMapVerifier::TextureNeed> texturesOf(const Layout& layout) {
    switch (layout.index()) {
        case 0:
            return {{"sh", 9}};
        case 1:
            return {{"exit", 1}};
        case 2:
            return {{"luvw_first", 9}, {"luvw_second", 9}};
        default:
            return {{"l0", 1}, {"ratio", 8}};
    }
}

}  // namespace verify::layouts
