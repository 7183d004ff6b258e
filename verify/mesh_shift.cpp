#include "verify/mesh_shift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "lighting/radiometry.h"
#include "lighting/sphere.h"

namespace verify {
namespace {

using lighting::ShRgb;

struct Quad {
    std::array<const ShRgb*, 4> corners;  ///< 00, 10, 01, 11

    ShRgb at(double s, double t) const {
        const std::array<double, 4> weights = {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
        ShRgb result{};
        for (std::size_t corner = 0; corner < 4; ++corner)
            for (std::size_t i = 0; i < lighting::kShCount; ++i) result[i] += static_cast<float>(weights[corner]) * (*corners[corner])[i];
        return result;
    }
};

glm::vec3 exitRadiance(const ShRgb& sh, const glm::vec3& normal) {
    return lighting::lambertExitRadiance(sh, normal, glm::vec3(1)).value;
}

/// Sum over bands of factor_l times the norm of the band's coefficients, one channel.
double bandSum(const ShRgb& sh, int channel, const lighting::ShBands& factors) {
    std::array<double, 3> squares{};
    for (std::size_t i = 0; i < lighting::kShCount; ++i) {
        const double value = static_cast<double>(sh[i][channel]);
        squares[static_cast<std::size_t>(lighting::kShBand[i])] += value * value;
    }
    return factors[0] * std::sqrt(squares[0]) + factors[1] * std::sqrt(squares[1]) + factors[2] * std::sqrt(squares[2]);
}

lighting::ShBands valueFactors() {
    lighting::ShBands factors{};
    for (std::size_t l = 0; l < 3; ++l)
        factors[l] = lighting::kExitRadianceBands[l] * std::sqrt((2.0 * static_cast<double>(l) + 1) / (4 * std::numbers::pi));
    return factors;
}

lighting::ShBands gradientFactors() {
    lighting::ShBands factors = valueFactors();
    for (std::size_t l = 0; l < 3; ++l) factors[l] *= std::sqrt(static_cast<double>(l * (l + 1)));
    return factors;
}

double boundOf(const Quad& quad, int channel, const MeshShift& shift, double key) {
    static const lighting::ShBands value = valueFactors(), gradient = gradientFactors();
    const auto difference = [&](std::size_t a, std::size_t b) {
        ShRgb result;
        for (std::size_t i = 0; i < lighting::kShCount; ++i) result[i] = (*quad.corners[a])[i] - (*quad.corners[b])[i];
        return bandSum(result, channel, value);
    };
    const double across = std::max(difference(1, 0), difference(3, 2)), down = std::max(difference(2, 0), difference(3, 1));
    double steepest = 0;
    for (const ShRgb* corner : quad.corners) steepest = std::max(steepest, bandSum(*corner, channel, gradient));
    const double largest = shift.uTexels * across + shift.vTexels * down + shift.normalRadians * steepest;
    return largest > 0 ? largest / (0.02 * key) : 0.0;
}

}  // namespace

void addMeshShiftErrors(const formats::LightMapBand& band, int firstRow, int rowCount, const MeshShift& shift, double key,
                        ErrorAccumulator& errors) {
    const int lastRow = std::min(firstRow + rowCount, band.firstRow + band.sh.height() - 1);
    const double s = std::min(shift.uTexels, 0.5), t = std::min(shift.vTexels, 0.5);
    for (int row = firstRow; row < lastRow; ++row) {
        const int y = row - band.firstRow;
        for (int x = 0; x + 1 < band.sh.width(); ++x) {
            if (!(band.covered.at(x, y) && band.covered.at(x + 1, y) && band.covered.at(x, y + 1) && band.covered.at(x + 1, y + 1)))
                continue;
            const Quad quad{{&band.sh.at(x, y), &band.sh.at(x + 1, y), &band.sh.at(x, y + 1), &band.sh.at(x + 1, y + 1)}};
            const glm::dvec3 normal(band.normal.at(x, y));
            const glm::dmat3 frame = lighting::worldFromTangentFrame(normal);
            const glm::vec3 reference = exitRadiance(quad.at(0.5, 0.5), glm::vec3(normal));
            for (int corner = 0; corner < 4; ++corner) {
                const double signS = corner % 2 == 0 ? -1 : 1, signT = corner < 2 ? -1 : 1;
                const glm::dvec3 turned =
                    glm::normalize(normal + std::tan(shift.normalRadians) * (signS * frame[0] + signT * frame[1]) / std::numbers::sqrt2);
                const glm::vec3 result = exitRadiance(quad.at(0.5 + signS * s, 0.5 + signT * t), glm::vec3(turned));
                for (int channel = 0; channel < 3; ++channel)
                    errors.add(static_cast<double>(reference[channel]), static_cast<double>(result[channel]));
            }
            for (int channel = 0; channel < 3; ++channel) errors.addBound(boundOf(quad, channel, shift, key));
        }
    }
}

}  // namespace verify
