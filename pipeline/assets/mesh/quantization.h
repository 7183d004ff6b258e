// Quantization of meshes: how far a lattice moves vertices.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "verify/seams.h"

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

/// The most bits of a light-map UV: two of them fill the four bytes of a vertex.
inline constexpr int kMostUvBits = 16;

/// Largest distance that a light-map UV may move [texels].
inline constexpr double kMostUvTexels = 0.5;

/// Returns the largest distance that light-map UVs may move where the seams of their map have a limit: places so close read the same
/// texels, as edges inside charts do (SeamFinder). On maps of over 1024 texels it is that of the finest lattice [texels].
/// extentTexels  largest extent of the UVs [texels]
inline double mostUvShiftAtSeams(double extentTexels) {
    return std::max(verify::SeamFinder::kSameTexels, extentTexels * kUvSteps / latticeSteps(kMostUvBits));
}

}  // namespace lightcook::pipeline
