// Layouts of cubemaps: one table, from which the scene file, the command line, the cook and its verification derive.
#pragma once

#include <bit>
#include <span>
#include <string_view>

namespace lightcook::pipeline {

enum class CubemapLayout { PreDivided, Prefiltered };

struct CubemapLayoutInfo {
    CubemapLayout id;
    std::string_view name;      ///< value of `layout` and `cubemap --layout`, and `layout` of the manifest
    std::string_view caption;   ///< for help and documents
    std::string_view quantity;  ///< of the manifest
};

/// Returns every layout, in the order of the enumeration.
std::span<const CubemapLayoutInfo> allCubemapLayouts();
const CubemapLayoutInfo& info(CubemapLayout layout);
/// Returns the layout of a name; nullptr for other names.
const CubemapLayoutInfo* cubemapLayoutFromName(std::string_view name);

/// Returns the level of one texel a face of a chain of levels.
/// size  of a face at level 0 [texels], a power of two
constexpr int lastCubemapLevel(int size) {
    return static_cast<int>(std::bit_width(static_cast<unsigned>(size))) - 1;
}

}  // namespace lightcook::pipeline
