// The light maps that benchmarks cook: those of the shared data, or the one that ships with the program.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <string>

namespace lightcook::bench {

/// Returns the light maps of the shared data by the names of their scenes; without shared data, the map that ships with the program.
/// part  only scenes whose name contains this
inline std::map<std::string, std::filesystem::path> sceneFiles(const std::filesystem::path& data, const std::string& part) {
    const std::string ending = "_lightmap.exr";
    std::map<std::string, std::filesystem::path> scenes;
    if (std::filesystem::is_directory(data / "scenes")) {
        for (const auto& entry : std::filesystem::directory_iterator(data / "scenes")) {
            const std::string name = entry.path().filename();
            if (name.ends_with(ending)) scenes[name.substr(0, name.size() - ending.size())] = entry.path();
        }
    } else {
        fmt::print("no scenes in {}: only the example's light map\n\n", data.string());
        scenes["cornell (half)"] = std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "examples/cornell/cornell_lightmap.exr";
    }
    std::erase_if(scenes, [&](const auto& scene) { return scene.first.find(part) == std::string::npos; });
    return scenes;
}

}  // namespace lightcook::bench
