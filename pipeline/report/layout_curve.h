// A plot for report.html: error against memory of each layout that was tried.
#pragma once

#include <string>
#include <vector>

#include "pipeline/report/html.h"

namespace lightcook::pipeline {

enum class CurveUnit {
    RelRms,  ///< shown in percent
    Visible  ///< just noticeable differences
};

struct CurvePoint {
    std::string name;
    double bits = 0;                   ///< a texel, tables included
    double diffuse = 0, specular = 0;  ///< errors
    bool isChosen = false;
};

/// Returns an SVG of error against bits on logarithmic axes. Each layout is a dot (diffuse) and a ring (specular) with a line between them.
/// A horizontal rule marks the limit if it is above 0. Points that are not finite and positive are left out; with fewer than two points the
/// result is empty.
Html errorCurve(const std::vector<CurvePoint>& points, double limit, CurveUnit unit);

}  // namespace lightcook::pipeline
