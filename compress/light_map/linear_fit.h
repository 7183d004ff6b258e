// The linear function of the normal that shows light best: E(n) = constant + n . linear is all that an engine with four SH coefficients can
// show of a white surface. Private to compress/.
//
// Dropping band 2 gives the best function over all normals, but a surface has only normals of its own hemisphere, where a linear function
// follows much of band 2. Here the integral of the squared error over that hemisphere is minimized. With N the surface's normal, z = n . N
// uniform over [0, 1]: E[1] = 1, E[z] = 1/2, E[z^2] = E[x^2] = 1/3, so that the function (a, b) has the form a^2 + a (b . N) + |b|^2 / 3.
//
// Band 2 shows f(n) / 4 with f(n) = n' A n, A symmetric and of trace 0. Its zonal part is f(N) (3 z^2 - 1) / 2, and 3/2 z - 3/4 is the best
// linear function to it; with t = A N - f(N) N its slope across N is 2 z (t . n), and 3/4 (t . n) is the best to that. The rest of A is
// orthogonal to linear functions.
#pragma once

#include <glm/vec3.hpp>
#include <span>

namespace lightcook::compress::rows {

/// E(n) = constant + n . linear: exit radiance of one channel.
struct LinearExit {
    double constant = 0;
    glm::dvec3 linear{0};
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

private:
    double product(const LinearExit& a, const LinearExit& b) const;
    glm::dvec3 normal_;
};

}  // namespace lightcook::compress::rows
