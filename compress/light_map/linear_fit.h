// The best linear function of the normal for the exit radiance of a white surface: E(n) = constant + n . linear is all that an engine with
// four SH coefficients can show. Private to compress/.
//
// Dropping band 2 gives the best function over all normals, but a surface has only normals of its own hemisphere, where a linear function
// follows much of band 2. Here the integral of the squared error over that hemisphere is minimized. With N the surface's normal, z = n . N
// uniform over [0, 1]: E[1] = 1, E[z] = 1/2, E[z^2] = E[x^2] = 1/3, so that the function (a, b) has the form a^2 + a (b . N) + |b|^2 / 3.
//
// Band 2 shows f(n) / 4 with f(n) = n' A n, A symmetric and of trace 0. Its zonal part is f(N) (3 z^2 - 1) / 2, and 3/2 z - 3/4 is the best
// linear function to it; with t = A N - f(N) N its slope across N is 2 z (t . n), and 3/4 (t . n) is the best to that. The rest of A is
// orthogonal to linear functions.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <span>

#include "compress/light_map/rows.h"

namespace lightcook::compress::rows {

/// E(n) = constant + n . linear: exit radiance of one channel.
struct LinearExit {
    double constant = 0;
    glm::dvec3 linear{0};
};

/// The functions of three colours, by channel.
using LinearExits = std::array<LinearExit, 3>;

/// E(n) = constant (1 + n . slope): the functions of three colours that share a slope.
struct SharedExit {
    glm::dvec3 constant{0};
    glm::dvec3 slope{0};
};
/// Limit of the slopes that family unreal stores, along an axis. Light from one direction has 2 by its bands 0 and 1, and more by the fit;
/// a larger range makes the steps of the direction coarser (docs/lab/compress-light-maps.md).
inline constexpr double kLargestSharedSlope = 3;
/// Least and largest shared slope, along each axis.
struct SlopeRange {
    glm::dvec3 low, high;
};

/// The best linear functions for a surface around one normal.
class LinearFit {
public:
    /// normal  unit; 0 for a surface whose normal is not known: bands 0 and 1 stay as they are
    explicit LinearFit(const glm::vec3& normal) : normal_(normal) {}

    /// Returns the function that shows a channel of nine coefficients with the least error.
    LinearExit best(std::span<const glm::vec3> light, int channel) const;
    /// Returns the function nearest to `best` among those with |linear_i| <= extent constant for each axis.
    LinearExit within(const LinearExit& best, double extent) const;
    /// Returns the linear part nearest to `best` for a given constant.
    glm::dvec3 linearFor(const LinearExit& best, double constant) const;
    /// Returns the constant >= 0 nearest to `best` among functions (1 + n . slope) constant.
    double constantFor(const LinearExit& best, const glm::dvec3& slope) const;
    /// Returns the best functions of all channels.
    LinearExits best(std::span<const glm::vec3> light) const { return {best(light, 0), best(light, 1), best(light, 2)}; }
    /// Returns the slope that the colours share, within `range` along each axis, nearest to `best` for given constants.
    glm::dvec3 sharedSlope(const LinearExits& best, const glm::dvec3& constant, const SlopeRange& range) const;
    /// Returns the functions nearest to `best` that share a slope. Slope and constants are solved in turns.
    /// start  the constants to begin with
    SharedExit shared(const LinearExits& best, const glm::dvec3& start, const SlopeRange& range, int rounds = kSharedRounds) const;
    static constexpr int kSharedRounds = 4;  ///< further rounds change the error by about 0.1 %

private:
    double product(const LinearExit& a, const LinearExit& b) const;
    glm::dvec3 normal_;
};

/// Returns the fit of a texel of a source: that of the normal of its owner.
/// strip  the rows that `source` was made of
LinearFit fitAt(const formats::LightMapStrip& strip, const Source& source, int x, int y);

}  // namespace lightcook::compress::rows
