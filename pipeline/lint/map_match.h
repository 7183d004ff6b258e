// Compares the texels that a mesh reads with those of its light map that hold something: light, or coverage where the file has it.
//
// Bakers let the light of a chart grow over its rim: by no texel, by a margin of some, or until the map is full. So a texel outside the
// mesh may hold light, at a distance from a chart at which most texels do. `margin` is the largest m such that, at each distance 1 .. m
// from texels that the mesh reads and that hold light, at least kOfMargin of the texels outside the mesh hold some. Distances are those of
// the 8-neighbourhood; margins that grow by 4 neighbours or by circles reach further along axes than this counts, by less than a factor of
// 2. Light beyond 2 margin + 1 texels from the mesh is that of charts which the mesh does not read (`unread`). The one texel is that of
// bakers which take each texel that a chart touches.
#pragma once

#include <cstdint>

#include "pipeline/document/json_fields.h"
#include "pipeline/lint/uv_raster.h"

namespace lightcook::pipeline {

struct MapMatch {
    std::int64_t read = 0;    ///< texels whose centre lies in a triangle
    std::int64_t empty = 0;   ///< of these, texels without light
    std::int64_t marked = 0;  ///< texels with light
    std::int64_t unread = 0;  ///< of these, texels outside the mesh and its margin
    int margin = 0;           ///< [texels]
};
template <class Fields, Is<MapMatch> Self>
void describe(Fields& fields, Self& match) {
    fields.required("read", match.read, "texels whose centre lies in a triangle");
    fields.required("empty", match.empty, "of these, texels without light");
    fields.required("marked", match.marked, "texels with light");
    fields.required("unread", match.unread, "of these, texels outside the mesh and its margin");
    fields.required("margin", match.margin, "width of the margin of charts [texels]");
}

/// Share of the texels at one distance that have to hold light for this distance to be of the margin.
inline constexpr double kOfMargin = 0.75;

/// marked  texels that hold light, in a map of the raster's size
MapMatch matchOf(const UvRaster& raster, const TexelSet& marked);

}  // namespace lightcook::pipeline
