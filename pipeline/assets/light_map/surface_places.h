// Places of the surface that a light map lights: some thousands, spread evenly over the footprints of covered texels, between texel centres
// as often as anywhere else. The light of a bake there is filtered between covered texels alone.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "formats/light_map.h"
#include "lighting/sh.h"

namespace lightcook::pipeline {

struct SurfacePlace {
    glm::dvec2 at{0};      ///< in texels of the map; integers are texel centres
    glm::vec3 normal{0};   ///< of the texel whose footprint holds the place
    lighting::ShRgb bake;  ///< filtered light
};

/// Returns a place of the footprint of a texel, from its centre: the first numbers of a sequence fill the square evenly (Roberts 2018, The
/// Unreasonable Effectiveness of Quasirandom Sequences: multiples of the plastic number's inverse powers).
glm::dvec2 placeInTexel(std::int64_t number);

/// Returns true if charts may meet at a place.
/// at  in texels of the map, whose rows the filter reads
bool mayCrossCharts(const formats::LightMapStrip& texels, const glm::dvec2& at);

class SurfacePlaces {
public:
    /// Size of a map [texels].
    SurfacePlaces(int width, int height);
    /// Returns the places of a strip, row by row. Its first and last rows have none, except at the ends of the map: a filter reads rows
    /// beyond them.
    /// texels  hold the strip
    std::vector<SurfacePlace> of(const formats::LightMapStrip& texels, int firstRow, int rowCount) const {
        return of(texels, firstRow, rowCount, firstRow, firstRow + rowCount);
    }
    /// Returns those of rows [from, end) of the strip: texels hold these and the rows beside them.
    std::vector<SurfacePlace> of(const formats::LightMapStrip& texels, int firstRow, int rowCount, int from, int end) const;

private:
    int width_, height_;
    int step_;  ///< between texels that have a place, along both axes
};

}  // namespace lightcook::pipeline
