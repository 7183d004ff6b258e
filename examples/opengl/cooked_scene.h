// A cooked folder in memory of the GPU: textures and meshes that cooked.json names.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace example {

/// A texture of OpenGL, and the target that it is bound to.
struct Texture {
    std::uint32_t name = 0, target = 0;
};

/// Vertices with attributes 0: position, 1: normal, 2: light-map UV, 3: cluster; all in world space.
struct Mesh {
    std::uint32_t vertexArray = 0;
    int indexCount = 0;
    bool isDoubleSided = false;  ///< back faces are drawn, too
};

/// Holds a light map and the meshes that it lights. Its OpenGL objects live as long as the context.
struct CookedScene {
    std::string include;                      ///< text of lightcook.glsl
    nlohmann::json lightMap;                  ///< its entry in the manifest
    std::map<std::string, Texture> textures;  ///< of the light map, by role
    std::vector<Mesh> meshes;
};

/// Loads the first light map of a cooked folder, and the meshes that it lights. Needs a current context.
/// Throws std::runtime_error that names the file.
CookedScene loadCookedScene(const std::filesystem::path& folder);

}  // namespace example
