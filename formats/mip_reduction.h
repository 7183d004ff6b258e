// A mip level of a light map: each texel is the mean of the covered texels that it stands for, in linear light.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/light_map.h"

namespace lightcook::formats {

/// Averages texels of a map into rows of a level. A texel of level k stands for 2^k x 2^k texels of the map, and is covered if any of them
/// is. Its coefficients are the mean of the covered ones: of the light that surfaces show, not of the black beside charts. Its normal is
/// that of their mean; that of the first covered one, by row and column, if normals cancel out.
class MipReduction {
public:
    /// width                of the level [texels]
    /// firstRow, rowCount   of the level
    MipReduction(int width, int firstRow, int rowCount, int level);
    /// Adds the rows of a strip of the map that belong to these rows, and none of others. Strips come in the order of their rows.
    void add(const LightMapStrip& strip);
    /// Returns the rows of the level. Their repairs and coverage count nothing: the map's own strips did.
    LightMapStrip finish() const;

private:
    struct Texel {
        std::array<glm::dvec3, lighting::kShCount> sh{};  ///< sum
        glm::dvec3 normal{0};                             ///< sum
        glm::vec3 firstNormal{0, 0, 1};
        std::int64_t covered = 0;
    };
    int width_, firstRow_, rowCount_, level_;
    std::vector<Texel> texels_;  ///< row by row
};

}  // namespace lightcook::formats
