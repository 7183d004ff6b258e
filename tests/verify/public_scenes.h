// The public scenes and the layouts that tests of bounds cook them in.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

#include "formats/light_map.h"
#include "formats/light_map_layout.h"

namespace lightcook::test {

inline constexpr auto kPublicScenes = {"cornell", "interior", "outdoor", "zdm2_sun"};

/// Returns the light map of a public scene. It may not be there: the shared data are not part of the repository.
inline std::filesystem::path lightMapOf(const std::string& scene) {
    return std::filesystem::path(LIGHTCOOK_SHARED_DATA) / "scenes" / (scene + "_lightmap.exr");
}

/// Returns how the light map of a public scene is read for a layout: on its mesh, if the layout is in tangent space.
inline formats::LightMapDescription descriptionFor(const std::string& scene, formats::LightMapLayout layout) {
    formats::LightMapDescription description;
    if (!formats::info(layout).isInTangentSpace) return description;
    description.mesh = lightMapOf(scene).parent_path() / (scene + ".glb");
    description.takesTangents = true;
    return description;
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
