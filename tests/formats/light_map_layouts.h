// Lists of light-map layouts that tests run over.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "formats/light_map_layout.h"

namespace lightcook::test {

/// Every layout, in the order of the table.
inline constexpr auto kEveryLayout = [] {
    std::array<formats::LightMapLayout, formats::kLightMapLayouts.size()> layouts{};
    for (std::size_t i = 0; i < layouts.size(); ++i) layouts[i] = formats::kLightMapLayouts[i].id;
    return layouts;
}();

/// Returns the layouts with a property, in the order of the table.
/// has  called with the row of each
template <class Has>
std::vector<formats::LightMapLayout> layoutsWhere(Has has) {
    std::vector<formats::LightMapLayout> layouts;
    for (const formats::LightMapLayoutInfo& row : formats::allLightMapLayouts())
        if (has(row)) layouts.push_back(row.id);
    return layouts;
}

/// Returns the layouts that hold coefficients of light from several directions.
inline std::vector<formats::LightMapLayout> directionalLayouts() {
    return layoutsWhere([](const formats::LightMapLayoutInfo& row) { return !row.isFlat() && !row.isInTangentSpace; });
}

/// The first layout of each family, and the first with residual layers: each has a decoder of its own. ./dev soak takes all.
inline std::vector<formats::LightMapLayout> layoutsOfEveryFamily() {
    std::vector<formats::LightMapLayout> first;
    std::set<std::pair<formats::LightMapFamily, bool>> seen;
    for (const formats::LightMapLayoutInfo& layout : formats::kLightMapLayouts)
        if (seen.emplace(layout.family, layout.residualCount() > 0).second) first.push_back(layout.id);
    return first;
}

/// Returns the names of layouts.
inline std::vector<std::string> namesOf(const std::vector<formats::LightMapLayout>& layouts) {
    std::vector<std::string> names;
    for (const formats::LightMapLayout layout : layouts) names.emplace_back(formats::info(layout).name);
    return names;
}

/// Returns the name of a parameterised test; GoogleTest takes letters, digits and underscores only.
inline std::string nameOfLayout(const testing::TestParamInfo<formats::LightMapLayout>& tested) {
    std::string name(formats::info(tested.param).name);
    std::ranges::replace(name, '-', '_');
    return name;
}

}  // namespace lightcook::test
