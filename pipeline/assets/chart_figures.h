// Charts of a light map as reports have them: how much memory each takes, and how visible its errors are.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

/// Memory and visible errors of one chart, or of several together.
struct ChartFigures {
    std::int64_t number = 0;     ///< 1 and on, in the order of the first triangles; 0: several charts
    std::array<int, 2> first{};  ///< lowest texel that the chart's triangles read: x and y
    std::array<int, 2> size{};   ///< of the box around these texels
    std::int64_t texels = 0;     ///< covered
    std::uint64_t bytes = 0;
    double visibleRms = 0, visibleP99 = 0, visibleMax = 0;
    std::array<int, 2> worst{};  ///< texel of visibleMax
};
template <class Fields, Is<ChartFigures> Self>
void describe(Fields& fields, Self& chart) {
    fields.required("number", chart.number, "1 and on, in the order of the charts' first triangles; 0: several charts");
    fields.required("first", chart.first, "x and y of the lowest texel of its box; 0 of several charts");
    fields.required("size", chart.size, "width and height of the box of texels that its triangles read; 0 of several charts");
    fields.required("texels", chart.texels, "covered texels");
    fields.required("bytes", chart.bytes, "their share of the light map's GPU memory");
    fields.required("visible_rms", chart.visibleRms, kFigure, "RMS of the visible errors at these texels, at their own normals");
    fields.required("visible_p99", chart.visibleP99, kFigure, "99th percentile of these errors");
    fields.required("visible_max", chart.visibleMax, kFigure, "largest of these errors");
    fields.required("worst", chart.worst, "x and y of the texel with the largest");
}

/// A chart of fewer than 16 texels that holds the place of a largest visible error.
struct FewTexels {
    std::string shading;
    double texels = 0;   ///< area of its triangles
    std::string advice;  ///< the same in every report and viewer
};
template <class Fields, Is<FewTexels> Self>
void describe(Fields& fields, Self& few) {
    fields.required("shading", few.shading, "diffuse or specular: whose largest visible error of the last stage lies there");
    fields.required("texels", few.texels, kFigure, "area of the chart's triangles [texels]");
    fields.presentIf(true, "advice", few.advice, "why no layout helps, and what does");
}

/// The charts of a light map that has a mesh.
struct ChartSummary {
    std::int64_t count = 0;
    std::vector<ChartFigures> largest;  ///< those of most texels first
    std::optional<ChartFigures> rest;   ///< all others together
    std::vector<FewTexels> few = {};    ///< of the last stage; none where charts were packed
};
template <class Fields, Is<ChartSummary> Self>
void describe(Fields& fields, Self& charts) {
    fields.required("count", charts.count, "charts");
    fields.required("largest", charts.largest, "the largest charts, those with most texels first");
    fields.optional("rest", charts.rest, "all other charts together");
    fields.presentIf(!charts.few.empty(), "few_texels", charts.few,
                     "charts of fewer than 16 texels that hold a largest visible error: filters read texels beside them, and no layout "
                     "lowers the error much");
}

}  // namespace lightcook::pipeline
