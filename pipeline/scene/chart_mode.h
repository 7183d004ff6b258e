// Choices for the charts of a light map: kept or packed. One table, from which scene file, command line and documents derive.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/vocabulary.h"
#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

enum class ChartMode { Keep, Pack };

struct ChartModeInfo {
    ChartMode id;
    std::string_view name;     ///< value of `charts` and `--charts`
    std::string_view caption;  ///< for help texts and documents
};

inline constexpr std::array kChartModes = {
    ChartModeInfo{ChartMode::Keep, "keep", "the light-map UVs of the mesh stay as they are"},
    ChartModeInfo{ChartMode::Pack, "pack", "charts are packed anew, and the cooked mesh gets the UVs that go with it"},
};
static_assert(formats::isCompleteTable(kChartModes, ChartMode::Pack));

/// Returns every mode, the default first.
inline std::span<const ChartModeInfo> allChartModes() {
    return kChartModes;
}

template <>
struct EnumNames<ChartMode> {
    static std::vector<std::string> all() { return formats::namesOf(allChartModes()); }
};

}  // namespace lightcook::pipeline
