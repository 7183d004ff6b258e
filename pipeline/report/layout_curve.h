// A picture for report.html: what each layout that was tried costs and loses.
#pragma once

#include <string>
#include <vector>

#include "pipeline/report/html.h"

namespace lightcook::pipeline {

struct CurvePoint {
    std::string name;
    double bits = 0;                   ///< a texel, tables included
    double diffuse = 0, specular = 0;  ///< rel_rms
    bool isChosen = false;
};

/// An SVG of error against bits, both by octaves: a dot for diffuse, a ring for specular, a line between them; a rule at the limit where
/// there is one (above 0). Points that are not finite and above 0 are left out; empty where fewer than two are left.
Html errorCurve(const std::vector<CurvePoint>& points, double limit);

}  // namespace lightcook::pipeline
