// The error metric of learned layouts: the cost of an error in nine SH coefficients, as the shading of a surface shows it. Private to
// compress/.
#pragma once

#include <array>
#include <glm/vec3.hpp>

#include "lighting/sh.h"

namespace lightcook::compress {

/// A symmetric matrix M in world coordinates: an error e of the coefficients costs e' M e. Sum of two mean squares, each relative to its
/// value for constant light: exit radiance over the normals of the hemisphere, and area specular over views and materials.
struct Metric {
    std::array<std::array<float, lighting::kShCount>, lighting::kShCount> matrix{};
    /// The upper triangle U with U'U = M for coefficients 1 to 8, by columns: |U e|^2 is the cost of their error.
    std::array<std::array<float, 8>, 8> higherRoot{};

    const std::array<float, lighting::kShCount>& operator[](std::size_t row) const { return matrix[row]; }
};

class ShadingMetric {
public:
    /// Returns the metric of surfaces around a unit normal. Caches the last one, since charts are mostly flat.
    const Metric& at(const glm::vec3& normal);

private:
    glm::vec3 normal_{0};
    Metric metric_{};
};

}  // namespace lightcook::compress
