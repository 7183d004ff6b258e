// One number for the whole shading: the errors of all assets in one unit, light, and what share of the whole each of them has.
//
// What a pixel shows is the sum of four kinds of light, on a white surface with the scene's own roughness and F0:
//   diffuse    exit radiance of the light map
//   area       area specular of the light map, S, through the tables
//   analytic   highlight of the dominant light
//   environment  R S: a pre-divided cubemap, R, times the pixel's area specular; of several cubemaps a pixel sees one, each as likely
// Each asset's error is its rel_rms times the RMS of the light that it is a part of. docs/terms.md tells what the sums mean.
#pragma once

#include <string>
#include <vector>

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// From the rows of a report (reportAsset). Null where no light map says how much light it holds.
/// {"rel_rms", "rel_rms_bound", "light_rms",
///  "lights": {"diffuse", "area_specular", "analytic_specular", "environment"},                    RMS of each
///  "parts": [{"asset", "kind", "shading", "share", "rel_rms", "light_rms", "stages": [{"name", "share"}]}],   largest first
///  "light_maps": [{"name", "weight", and all of the above}],    where there are several; weight: share of the covered texels
///  "apart": [{"asset", "kind", "rel_rms"}]}                     no part of what a light map's pixels show
/// A figure that is not finite is null, and with it whatever it is a part of. Shares are of the squared error: they add up to 1, or are all
/// 0 where there is no error. A stage's share is what it would have alone, so that stages do not add up.
Json wholeError(const std::vector<Json>& assets);

/// Names the part with the largest share and what less of it costs; says so where there is no error, or none that can be told.
std::string adviceOf(const Json& whole);
/// One line: the number, its bound and the advice.
std::string lineOf(const Json& whole);

}  // namespace lightcook::pipeline
