// Strips of a light map at the size of smaller textures, for dominant lights that have fewer texels than their light map.
//
// Shaders sample both with the same UVs, so texel i of n spans [i / n, (i + 1) / n) of the map. Where n does not divide the map's size, a
// texel of the map lies under two texels of the texture, and counts in each by the part that is under it.
#pragma once

#include <glm/vec2.hpp>

#include "formats/light_map.h"

namespace lightcook::pipeline {

/// Returns the size of a map at 1 / divisor of its width and height, rounded up.
inline glm::ivec2 reducedSize(const glm::ivec2& size, int divisor) {
    return (size + glm::ivec2(divisor - 1)) / divisor;
}

/// Some rows of a map.
struct MapRows {
    int first = 0, count = 0;
};
/// Returns the rows of a map that lie under some rows of a texture.
MapRows rowsUnder(int firstRow, int rowCount, int mapHeight, int textureHeight);

/// Returns rows [firstRow, firstRow + rowCount) of a map at the size of a texture that is not larger. A texel has the mean coefficients and
/// the mean normal of the covered texels under it, by their areas, and is covered if one of them is. Its chart is theirs; kAnyChart if they
/// are of several, since surfaces of each then lie beside it.
/// strip  holds rowsUnder() these rows
formats::LightMapStrip reducedStrip(const formats::LightMapStrip& strip, int mapHeight, const glm::ivec2& textureSize, int firstRow,
                                    int rowCount);

}  // namespace lightcook::pipeline
