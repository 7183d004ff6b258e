// Light maps of many kinds of light, made for benchmarks and for tests of right work: cooking any of them must be quick, pass, and be
// warned of nowhere.
//
// The surfaces are those of a room from (-1, -1, -1) to (1, 1, 1) with a pillar, Y up. The map is a grid of square charts; each shows a
// part of a wall, a sixth of them a part of a round one. Light is a sum of sources that are nowhere negative: even light, a sky, a sun,
// point lights, and light from the middle of the room. It is projected over the hemisphere of each normal, so that it is possible
// light, whatever the kind: up to the rounding of halves, in kinds that store halves.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace lightcook::bench {

struct LightKind {
    std::string_view name;     ///< in lower case, words joined by hyphens
    std::string_view content;  ///< describes the light in a phrase
};

/// Returns all kinds, in the order of tables.
std::span<const LightKind> lightKinds();

/// Writes a light map of size x size texels as an OpenEXR file without compression: channels sh00.R .. sh08.B (kind "four-coefficients": up
/// to sh03.B), coverage.Y and normal.X, Y and Z, in the conventions of bake format sh9. The same arguments give the same bytes.
/// kind  name of one of lightKinds()
/// size  at least 1
/// Throws std::runtime_error for another name, and if the file cannot be written.
void writeLightKind(const std::filesystem::path& file, std::string_view kind, int size, std::uint32_t seed = 0);

/// Writes the same light as Unity bakes it, without directions above order 1: <stem>_light.exr (halves) and <stem>_dir.png (8 bits), bake
/// format unity-directional. Uncovered texels are black in the first file; the second has alpha everywhere.
void writeUnityLightKind(const std::filesystem::path& folder, std::string_view stem, std::string_view kind, int size,
                         std::uint32_t seed = 0);

}  // namespace lightcook::bench
