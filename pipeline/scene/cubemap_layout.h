// Layouts of cubemaps: one table, from which the scene file, the command line, the cook and its verification derive.
#pragma once

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

}  // namespace lightcook::pipeline
