// The error of the whole shading as one number: the errors of all assets as radiance, and the share of each asset.
//
// A pixel shows the sum of four kinds of light, on a white surface with the scene's own roughness and F0:
//   diffuse    exit radiance of the light map
//   area       area specular of the light map, S, through the tables
//   analytic   highlight of the dominant light
//   environment  R S: a pre-divided cubemap, R, times the pixel's area specular; a pixel sees one of several cubemaps, each with the same
//   probability
// Each asset's error is its rel_rms times the RMS of the light that it is a part of. docs/theory/error.md explains the sums.
#pragma once

#include <string>
#include <vector>

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Computes the whole error from the rows of a report (reportAsset). Null if no light map has its RMS of light.
/// {"rel_rms", "rel_rms_bound", "light_rms",
///  "lights": {"diffuse", "area_specular", "analytic_specular", "environment"},                    RMS of each
///  "parts": [{"asset", "kind", "shading", "share", "rel_rms", "light_rms", "stages": [{"name", "share"}]}],   largest first
///  "light_maps": [{"name", "weight", and all of the above}],    if there are several; weight: share of the covered texels
///  "apart": [{"asset", "kind", "rel_rms"}]}                     assets that no light map's pixels show
/// A figure that is not finite is null, as are the sums that contain it. Shares are of the squared error: they add up to 1, or are all 0 if
/// there is no error. The share of a stage is the one that it would have alone, so the shares of stages do not add up.
Json wholeError(const std::vector<Json>& assets);

/// Returns a sentence that names the part with the largest share and how to reduce it; or that there is no error, or no finite one.
std::string adviceOf(const Json& whole);
/// Returns one line with the number, its bound and the advice.
std::string lineOf(const Json& whole);

}  // namespace lightcook::pipeline
