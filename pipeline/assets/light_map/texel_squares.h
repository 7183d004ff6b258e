// Squared errors of the texels of a light map, for the check of its blocks.
#pragma once

#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "lighting/radiometry.h"
#include "lighting/sh.h"

namespace lightcook::pipeline {

/// Sums of squares.
struct TexelSquares {
    double error = 0, reference = 0;
    void add(const glm::vec3& truth, const glm::vec3& seen) {
        const glm::dvec3 difference = glm::dvec3(seen) - glm::dvec3(truth);
        error += glm::dot(difference, difference);
        reference += glm::dot(glm::dvec3(truth), glm::dvec3(truth));
    }
};

/// Returns the squared error of a texel: of all nine coefficients, or for a flat map of the exit radiance at the texel's own normal.
inline TexelSquares squaresOf(const lighting::ShRgb& reference, const lighting::ShRgb& seen, const glm::vec3& normal, bool isFlat) {
    TexelSquares squares;
    const auto exit = [&](const lighting::ShRgb& sh) { return lighting::lambertExitRadiance(sh, normal, glm::vec3(1)).value; };
    if (isFlat)
        squares.add(exit(reference), exit(seen));
    else
        for (std::size_t i = 0; i < reference.size(); ++i) squares.add(reference[i], seen[i]);
    return squares;
}

}  // namespace lightcook::pipeline
