// Second moments of light and of specular kernels: from them follows the error that specular tables cause under the light of a real map.
//
// In the frame of a view (z along the normal, the view above x) area specular is T . c, with T of the tables (f0 C + (1 - f0) D, nothing at
// coefficients 1, 4, 5) and c the incident coefficients. Over views all around the normal, its mean square is a sum of ten products: of
// the second moments of T, and those of c averaged over the azimuth, under which only coefficients of one |m| stay related.
#pragma once

#include <array>
#include <glm/vec3.hpp>

#include "lighting/sh.h"
#include "pipeline/graph/action.h"
#include "verify/lut.h"

namespace lightcook::pipeline {

/// Means of the products 00, 22, 66, 02, 06, 26, 33, 77, 37, 88 of coefficients.
using Moments = std::array<double, 10>;

/// Moments of the light around normals, averaged over azimuth and colour channels.
class LightMoments {
public:
    /// incident  world frame; normal: unit
    void add(const lighting::ShRgb& incident, const glm::vec3& normal);
    void merge(const LightMoments& other);
    Moments moments() const;  ///< zeros of nothing
    double texels() const { return texels_; }

private:
    Moments sums_{};
    double texels_ = 0;
};

/// Moments of the kernels of some tables, and of the errors of these kernels.
struct TableMoments {
    Moments reference{}, error{};
};
TableMoments tableMoments(const std::vector<verify::LutResult>& kernels, const std::vector<double>& f0);

/// Returns the mean square of T . c.
double meanSquare(const Moments& table, const Moments& light);

}  // namespace lightcook::pipeline
