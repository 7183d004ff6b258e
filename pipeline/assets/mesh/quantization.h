// Quantization of meshes: how far a lattice moves vertices.
#pragma once

#include <cmath>
#include <numbers>

namespace lightcook::pipeline {

/// Returns the steps of a lattice with so many bits a component.
inline double latticeSteps(int bits) {
    return std::exp2(bits) - 1;
}

// Largest distances that quantization moves a vertex, in steps of the lattice: half a step of each component, and rounding.
inline constexpr double kRoundingSlack = 1.01;
inline constexpr double kPositionSteps = kRoundingSlack * 0.5 * std::numbers::sqrt3;
inline constexpr double kUvSteps = kRoundingSlack * 0.5 * std::numbers::sqrt2;
/// The octahedral map stretches the steps of its square unevenly: normals of the public scenes stay under 4.2 of them [radians].
inline constexpr double kNormalSteps = kRoundingSlack * 6;

}  // namespace lightcook::pipeline
