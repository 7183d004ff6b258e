// The public scenes and the layouts that tests of bounds cook them in.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

#include "formats/light_map_layout.h"

namespace lightcook::test {

inline constexpr auto kPublicScenes = {"cornell", "interior", "outdoor", "zdm2_sun"};

/// Returns the light map of a public scene. It may not be there: the shared data are not part of the repository.
inline std::filesystem::path lightMapOf(const std::string& scene) {
    return std::filesystem::path(LIGHTCOOK_SHARED_DATA) / "scenes" / (scene + "_lightmap.exr");
}

using SceneAndLayout = std::tuple<const char*, formats::LightMapLayout>;

inline std::string nameOfSceneAndLayout(const testing::TestParamInfo<SceneAndLayout>& tested) {
    std::string name = std::string(std::get<0>(tested.param)) + "_" + std::string(formats::info(std::get<1>(tested.param)).name);
    std::ranges::replace(name, '-', '_');
    return name;
}

inline double medianOf(std::vector<double> values) {
    std::ranges::sort(values);
    return values.empty() ? 0 : values[values.size() / 2];
}

}  // namespace lightcook::test
