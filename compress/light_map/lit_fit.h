// One directional light and the ratios of the rest, solved for the rows of a map (family lit). Private to compress/.
#pragma once

#include <array>
#include <glm/vec3.hpp>

#include "compress/light_map/rows.h"
#include "lighting/sh.h"

namespace lightcook::compress::rows {

/// A texel decodes to lambda_0 = dc, lambda_i = rest q_i + I Y_i(d) with rest = dc - I Y_0. Intensity I of a texel is linear given the
/// ratios q of its texel of "rest", and the other way round: each is solved by weighted least squares, in turns. Parts that are coded are
/// replaced by what they decode to, and those after them solved again.
class LitFit {
public:
    static constexpr std::size_t kHigher = lighting::kShCount - 1;  ///< coefficients 1 to 8

    /// Starts with the axis of band 1 as the direction.
    /// range    unit of the light, a power of two near the largest: squares of it are finite
    /// side     of the squares of texels that share ratios [texels]
    /// largest  of each ratio, in both signs
    LitFit(const Source& source, float range, int side, const std::array<float, kHigher>& largest);

    /// Solves ratios, directions and intensities in turns. With fixed directions, ratios and intensities.
    void solve(bool isDirectionFixed);
    void solveIntensities();
    void solveRatios();

    // The parts, in units of the range. A caller replaces them by what they decode to. They mean nothing at texels that are not covered.
    formats::Image<glm::vec3>& dc() { return dc_; }
    formats::Image<glm::vec3>& intensity() { return intensity_; }
    const glm::vec3& directionAt(int x, int y) const { return direction_.at(x, y); }
    void setDirection(int x, int y, const glm::vec3& direction);
    glm::vec3 restAt(int x, int y) const;
    /// Returns the sum of squares of the change of the coefficients under a unit of intensity, by channel.
    glm::vec3 changeSquare(int x, int y) const;

    // Texels of "rest".
    int across() const { return ratios_.width(); }
    int down() const { return ratios_.height(); }
    const glm::vec3& ratio(std::size_t i, int u, int v) const { return ratios_.at(u, v)[i]; }

    template <class Visit>
    void forEachCovered(Visit visit) const {
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x)
                if (source_.coverage.at(x, y) > 0) visit(x, y);
    }

private:
    glm::vec3 coefficient(std::size_t i, int x, int y) const { return perRange_ * source_.values[i].at(x, y); }
    const std::array<glm::vec3, kHigher>& ratiosAt(int x, int y) const { return ratios_.at(x / side_, y / side_); }
    glm::vec3 limited(const glm::vec3& intensity, int x, int y) const;
    glm::vec3 linearAxis(int x, int y) const;
    glm::vec3 projectedIntensity(int x, int y) const;
    glm::vec3 changeOf(std::size_t i, int x, int y) const;
    float errorUnder(const lighting::Sh& basis, int x, int y) const;
    void turnDirection(int x, int y);
    void solveRatiosOf(int u, int v);

    const Source& source_;
    float perRange_;
    int side_;
    std::array<float, kHigher> largest_;
    formats::Image<glm::vec3> dc_, intensity_, direction_;
    formats::Image<lighting::Sh> basis_;  ///< basis functions at the direction
    formats::Image<std::array<glm::vec3, kHigher>> ratios_;
};

}  // namespace lightcook::compress::rows
