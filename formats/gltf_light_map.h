// A glTF scene with a baked light map bound to its nodes: root extension LIGHTCOOK_light_map, and for viewers that do not know it a flat
// picture as MOZ_lightmap and an environment as EXT_lights_image_based. docs/guide/into-an-engine.md describes the extension.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "lighting/sh.h"

namespace lightcook::formats {

inline constexpr const char* kLightMapExtension = "LIGHTCOOK_light_map";

/// A cooked light map, its picture for viewers that do not know it, and the environment of a glTF scene.
struct GltfLightMap {
    using Png = std::vector<std::byte>;
    std::string name;
    std::string description;  ///< JSON of the map: an element of the extension's `maps`
    /// Irradiance over fallbackIntensity, linear, of the whole map. TEXCOORD_1 reads it.
    Png fallback;
    double fallbackIntensity = 1;

    struct Environment {
        std::string name;
        lighting::ShRgb irradiance{};            ///< SH coefficients of the irradiance
        int size = 0;                            ///< of a face of the first level [texels]
        std::vector<std::array<Png, 6>> levels;  ///< RGBD, +X -X +Y -Y +Z -Z
    };
    std::optional<Environment> environment;
};

/// Writes a GLB with the light map bound to every node whose mesh has light-map UVs (TEXCOORD_1). The materials get the flat picture;
/// primitives without a material share a new one. Lines and points without these UVs have materials without the picture. A scene that has
/// an image-based light keeps it.
/// scene   a GLB without external buffers, as GltfScene::writePlain() writes it
///
/// Returns the size of the written file [bytes].
Result<std::uint64_t> bindLightMap(const std::filesystem::path& scene, const std::filesystem::path& file, const GltfLightMap& lightMap);

/// Returns the light maps that a glTF binds, as the JSON text of a list: the extension's `maps`, or "[]".
Result<std::string> boundLightMaps(const std::filesystem::path& file);

/// Returns the first node whose binding is another one than bindLightMap() writes, with what was expected; nothing if all are right.
Result<std::optional<std::string>> wrongBinding(const std::filesystem::path& file);

}  // namespace lightcook::formats
