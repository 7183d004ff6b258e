// Plots for report.html: error against memory or run time of each layout that was tried.
#pragma once

#include <string>
#include <vector>

#include "pipeline/report/html.h"

namespace lightcook::pipeline {

enum class CurveUnit {
    RelRms,  ///< shown in percent
    Visible  ///< just noticeable differences
};

enum class CurveCost {
    BitsPerTexel,  ///< tables included
    Operations,    ///< scalar multiply-adds of a sample's decode
    Fetches        ///< texture fetches of a sample
};

struct CurvePoint {
    std::string name;
    double cost = 0;                   ///< above 0
    double diffuse = 0, specular = 0;  ///< errors
    bool isChosen = false;
};

/// Returns an SVG of error against cost on logarithmic axes. Each layout is a dot (diffuse) and a ring (specular) with a line between them.
/// A horizontal rule marks the limit if it is above 0. Points that are not finite and positive are left out; with fewer than two points the
/// result is empty.
Html errorCurve(const std::vector<CurvePoint>& points, double limit, CurveUnit unit, CurveCost cost);

}  // namespace lightcook::pipeline
