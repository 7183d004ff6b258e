// Objectives that learned layouts of light maps are fitted to.
#pragma once

#include <array>
#include <span>
#include <string_view>

namespace lightcook::formats {

enum class Objective { Visible, Energy };

struct ObjectiveInfo {
    Objective id;
    std::string_view name;     ///< as in `[output] objective` and `--objective`
    std::string_view caption;  ///< for help texts and documents
};

inline constexpr std::array kObjectives = {
    ObjectiveInfo{Objective::Visible, "visible", "differences that a display shows"},
    ObjectiveInfo{Objective::Energy, "energy", "squared differences of light, as rel_rms counts them"},
};
/// Returns every objective, the default first.
inline std::span<const ObjectiveInfo> allObjectives() {
    return kObjectives;
}

}  // namespace lightcook::formats
