// Recognises the files of a user for `init`: light maps, meshes, environments and gradients. Bakes are recognised as `info` and `cook` do.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/assets/light_map/bake_reading.h"

namespace lightcook::pipeline {

struct DraftLightMap {
    std::filesystem::path file;
    BakeReading reading;
    bool hasDirections = true;                    ///< false: exit radiance alone
    bool hasCoverage = true;                      ///< false: the file does not say which texels lie inside charts
    bool isGuess = false;                         ///< nothing but the file's shape or name says that it is a light map
    std::optional<std::filesystem::path> mesh{};  ///< that it lies on
    bool hasMaterials = false;                    ///< all of the mesh have one
    double gaps = 0;                              ///< share of the texels that coverage = "light" calls gaps; 0 with coverage or mesh
};
struct DraftProbe {
    std::filesystem::path file;
    std::optional<std::filesystem::path> sh{};  ///< JSON that states the SH of this file
};
/// A file that no part of the scene names, and why.
struct LeftOut {
    std::filesystem::path file;
    std::string why;
};
struct DraftInputs {
    std::vector<DraftLightMap> lightMaps;
    std::vector<DraftProbe> probes;
    std::vector<std::filesystem::path> gradients;
    std::vector<LeftOut> leftOut;
};

/// Recognises files. A folder stands for the files that lie in it directly.
/// Fails for a path that does not exist, for a named file that cannot be read, and if nothing could be cooked.
formats::Result<DraftInputs> findInputs(const std::vector<std::filesystem::path>& paths);

}  // namespace lightcook::pipeline
