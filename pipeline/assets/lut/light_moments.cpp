#include "pipeline/assets/lut/light_moments.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <numbers>

namespace lightcook::pipeline {
namespace {

/// T of a view and F0: coefficients 0, 2, 3, 6, 7, 8.
struct Kernel {
    double c0, c2, c3, c6, c7, c8;
};
Kernel kernelOf(const verify::SpecularKernelEntries& e, double f0) {
    const auto mixed = [&](std::size_t c, std::size_t d) { return f0 * e[c] + (1 - f0) * e[d]; };
    return {mixed(0, 4), mixed(1, 5), mixed(2, 6), mixed(3, 7), mixed(8, 10), mixed(9, 11)};
}
Kernel minus(const Kernel& a, const Kernel& b) {
    return {a.c0 - b.c0, a.c2 - b.c2, a.c3 - b.c3, a.c6 - b.c6, a.c7 - b.c7, a.c8 - b.c8};
}
void addTo(Moments& sums, const Kernel& t, double weight) {
    const Moments products = {t.c0 * t.c0, t.c2 * t.c2, t.c6 * t.c6, t.c0 * t.c2, t.c0 * t.c6,
                              t.c2 * t.c6, t.c3 * t.c3, t.c7 * t.c7, t.c3 * t.c7, t.c8 * t.c8};
    for (std::size_t i = 0; i < products.size(); ++i) sums[i] += weight * products[i];
}

}  // namespace

void LightMoments::add(const lighting::ShRgb& incident, const glm::vec3& normal) {
    // No rotation is needed: around n, band 1 is a vector and band 2 the quadratic form of a traceless matrix Q.
    const double k = 0.5 * std::sqrt(15 / std::numbers::pi), zonal = 0.25 * std::sqrt(5 / std::numbers::pi);
    const glm::dvec3 n(normal);
    for (int channel = 0; channel < 3; ++channel) {
        const auto c = [&](std::size_t i) { return static_cast<double>(incident[i][channel]); };
        const glm::dvec3 band1(c(3), c(1), c(2));
        const double xx = -zonal * c(6) + 0.5 * k * c(8), yy = -zonal * c(6) - 0.5 * k * c(8), zz = 2 * zonal * c(6);
        const double xy = 0.5 * k * c(4), yz = 0.5 * k * c(5), xz = 0.5 * k * c(7);
        const glm::dvec3 turned(xx * n.x + xy * n.y + xz * n.z, xy * n.x + yy * n.y + yz * n.z, xz * n.x + yz * n.y + zz * n.z);
        const double c2 = glm::dot(band1, n), c6 = glm::dot(n, turned) / (2 * zonal);
        const glm::dvec3 across1 = band1 - c2 * n, across2 = 2 / k * (turned - glm::dot(n, turned) * n);
        const double squares2 = c(4) * c(4) + c(5) * c(5) + c(6) * c(6) + c(7) * c(7) + c(8) * c(8);
        const double squared1 = glm::dot(across1, across1), squared2 = glm::dot(across2, across2);
        const double rest = std::max(0.0, squares2 - c6 * c6 - squared2);
        const Moments products = {
            c(0) * c(0), c2 * c2, c6 * c6, c(0) * c2, c(0) * c6, c2 * c6, 0.5 * squared1, 0.5 * squared2, 0.5 * glm::dot(across1, across2),
            0.5 * rest};
        for (std::size_t i = 0; i < products.size(); ++i) sums_[i] += products[i];
    }
    texels_ += 1;
}

void LightMoments::merge(const LightMoments& other) {
    for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += other.sums_[i];
    texels_ += other.texels_;
}

Moments LightMoments::moments() const {
    Moments means = sums_;
    for (double& each : means) each = texels_ > 0 ? each / (3 * texels_) : 0;
    return means;
}

TableMoments tableMoments(const std::vector<verify::LutResult>& kernels, const std::vector<double>& f0) {
    TableMoments moments;
    const double weight = 1 / static_cast<double>(std::max<std::size_t>(1, kernels.size() * f0.size()));
    for (const verify::LutResult& each : kernels)
        for (const double f : f0) {
            const Kernel reference = kernelOf(each.reference, f);
            addTo(moments.reference, reference, weight);
            addTo(moments.error, minus(kernelOf(each.cooked, f), reference), weight);
        }
    return moments;
}

double meanSquare(const Moments& table, const Moments& light) {
    constexpr Moments kTimes = {1, 1, 1, 2, 2, 2, 1, 1, 2, 1};
    double sum = 0;
    for (std::size_t i = 0; i < table.size(); ++i) sum += kTimes[i] * table[i] * light[i];
    return sum;
}

}  // namespace lightcook::pipeline
