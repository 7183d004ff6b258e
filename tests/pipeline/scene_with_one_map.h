// A scene in memory with one asset of each source, whose files do not exist.
#pragma once

#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns a scene with the light map "map", the probe "probe" and the gradient "sky".
inline Scene sceneWithOneMap() {
    Scene scene;
    scene.name = "s";
    scene.output.lightMapLayout = "ratio";
    LightMapEntry map;
    map.name = "map";
    map.file = "map.exr";
    map.dominantLayout = "full";
    scene.lightMaps.push_back(map);
    scene.probes.push_back({"probe", "probe.exr", std::nullopt});
    scene.gradients.push_back({"sky", "sky.exr", {1, 16}});
    return scene;
}

}  // namespace lightcook::pipeline
