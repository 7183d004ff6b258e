// Stated errors of fits over the whole range of floats, searched against long double.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "fit/cubemap.h"
#include "fit/dominant_light.h"
#include "fit/environment_sh.h"
#include "fit/irradiance.h"
#include "fit/light_search.h"
#include "fit/pre_divide.h"
#include "lighting/cube.h"
#include "tests/lighting/real_sh.h"
#include "tests/lighting/worst_search.h"

namespace lightcook {
namespace {

using test::Real;
using test::realBasis;
using test::RealSh;
using test::SearchBudget;
using test::SearchRange;
using Kind = SearchRange::Kind;
using Input = std::vector<double>;

constexpr double kMostFloat = 3.4028234663852886e38;
constexpr Real kPi = test::kRealPi;

/// Points and weights of Gauss and Legendre on [0, 1].
struct Rule {
    static constexpr int kCount = 20;
    std::array<Real, kCount> points, weights;
    Rule() {
        for (int i = 0; i < kCount; ++i) {
            Real x = std::cos(kPi * (i + 0.75L) / (kCount + 0.5L)), slope = 1;
            for (int step = 0; step < 60; ++step) {
                Real before = 1, value = x;
                for (int k = 2; k <= kCount; ++k) {
                    const Real next = ((2 * k - 1) * x * value - (k - 1) * before) / k;
                    before = value;
                    value = next;
                }
                slope = kCount * (x * value - before) / (x * x - 1);
                x -= value / slope;
            }
            points[static_cast<std::size_t>(i)] = (1 - x) / 2;
            weights[static_cast<std::size_t>(i)] = 1 / ((1 - x * x) * slope * slope);
        }
    }
};
const Rule& rule() {
    static const Rule kRule;
    return kRule;
}

// ---- projection

/// The integrals of the basis over each texel, row by row.
std::vector<RealSh> texelIntegrals(bool isStrip, int width, int height) {
    std::vector<RealSh> out(static_cast<std::size_t>(width * height));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (std::size_t i = 0; i < Rule::kCount; ++i)
                for (std::size_t j = 0; j < Rule::kCount; ++j) {
                    const Real u = rule().points[i], v = rule().points[j], weight = rule().weights[i] * rule().weights[j];
                    RealSh basis;
                    Real area;
                    if (isStrip) {
                        const int face = y / width;
                        const Real a = 2 * (x + u) / width - 1, b = 2 * (y % width + v) / width - 1, r = std::sqrt(1 + a * a + b * b);
                        const std::array<std::array<Real, 3>, 6> faces = {
                            {{1, -b, -a}, {-1, -b, a}, {a, 1, b}, {a, -1, -b}, {a, -b, 1}, {-a, -b, -1}}};
                        const auto& d = faces[static_cast<std::size_t>(face)];
                        basis = realBasis(d[0] / r, d[1] / r, d[2] / r);
                        area = 4 / (static_cast<Real>(width) * width * r * r * r);
                    } else {
                        const Real theta = kPi * (y + v) / height, psi = 2 * kPi * ((x + u) / width - 0.5L);
                        basis = realBasis(std::sin(theta) * std::sin(psi), std::cos(theta), -std::sin(theta) * std::cos(psi));
                        area = 2 * kPi * kPi / (static_cast<Real>(width) * height) * std::sin(theta);
                    }
                    RealSh& sum = out[static_cast<std::size_t>(y * width + x)];
                    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += weight * area * basis[k];
                }
    return out;
}
formats::Environment environmentOf(const Input& in, bool isStrip, int width, int height) {
    formats::Environment environment;
    environment.projection = isStrip ? formats::Environment::Projection::CubeStrip : formats::Environment::Projection::Equirectangular;
    environment.texels = formats::Image<glm::vec3>(width, height);
    for (std::size_t i = 0; i < in.size() && i < static_cast<std::size_t>(width * height); ++i)
        environment.texels.at(static_cast<int>(i) % width, static_cast<int>(i) / width) =
            glm::vec3(static_cast<float>(in[i]), static_cast<float>(in[in.size() - 1 - i]), 0);
    return environment;
}
void expectProjection(const SearchBudget& budget, bool isStrip) {
    const int width = isStrip ? 2 : 8, height = isStrip ? 12 : 4;
    const std::vector<RealSh> integrals = texelIntegrals(isStrip, width, height);
    const std::vector<SearchRange> ranges(integrals.size(), {1e-45, kMostFloat});
    test::expectHolds("projectEnvironment, a float's rounding and 1e-9 of what all texels give", ranges, budget, [&](const Input& in) {
        const formats::Environment environment = environmentOf(in, isStrip, width, height);
        const lighting::ShRgb found = fit::projectEnvironment(environment);
        Real worst = 0;
        for (std::size_t k = 0; k < found.size(); ++k)
            for (int channel = 0; channel < 2; ++channel) {
                Real truth = 0, size = 0;
                for (std::size_t i = 0; i < integrals.size(); ++i) {
                    const Real light =
                        static_cast<Real>(environment.texels.at(static_cast<int>(i) % width, static_cast<int>(i) / width)[channel]);
                    truth += light * integrals[i][k];
                    size += light * integrals[i][0];
                }
                const Real most = static_cast<Real>(kMostFloat), clamped = std::clamp(truth, -most, most);
                worst = std::max(worst, std::abs(static_cast<Real>(found[k][channel]) - clamped) /
                                            (0x1p-24L * std::abs(clamped) + 0x1p-150L + 1e-9L * size));
            }
        return worst;
    });
}

// ---- kernels

/// Zonal factors: pieces that halve towards the peak, c = 1, and towards the horizon.
std::array<Real, 3> bandsOf(fit::PrefilterKernel kernel, Real m) {
    const auto shape = [&](Real versine) {
        const Real c = 1 - versine, half = versine / 2, NoH2 = 1 - half;
        switch (kernel) {
            case fit::PrefilterKernel::Beckmann:
                return std::exp(-half / (NoH2 * m * m)) / (NoH2 * NoH2) * c;
            case fit::PrefilterKernel::Ggx: {
                const Real ratio = m * m / (m * m + half * (1 - m * m));
                return ratio * ratio * c;
            }
            case fit::PrefilterKernel::Phong:
                return std::exp((1 / (m * m) + 1) / 2 * std::log1p(-versine));
        }
        return Real(0);
    };
    std::array<Real, 3> moments{};
    const auto add = [&](Real from, Real to) {
        for (std::size_t i = 0; i < Rule::kCount; ++i) {
            const Real versine = from + (to - from) * rule().points[i];
            const Real value = (to - from) * rule().weights[i] * shape(versine);
            moments[0] += value;
            moments[1] += value * versine;                         // 1 - P1
            moments[2] += value * versine * (3 - 1.5L * versine);  // 1 - P2
        }
    };
    const Real factor = 1 / 1.5L;
    for (Real to = 0.5L; to > 0;) {
        const Real from = to > 1e-9L * m * m ? to * factor : 0;
        add(from, to);
        to = from;
    }
    for (Real left = 0.5L; left > 0;) {  // c in [from, left]
        const Real from = left > 1e-12L ? left * factor : 0;
        add(1 - left, 1 - from);
        left = from;
    }
    return {1, 1 - moments[1] / moments[0], 1 - moments[2] / moments[0]};
}
void expectKernels(const SearchBudget& budget) {
    for (const auto kernel : {fit::PrefilterKernel::Beckmann, fit::PrefilterKernel::Ggx, fit::PrefilterKernel::Phong}) {
        const std::array<SearchRange, 1> ranges = {{{1e-16, 1}}};
        test::expectHolds("prefilterKernelBands, within 1e-9", ranges, budget, [&](const Input& in) {
            const lighting::ShBands found = fit::prefilterKernelBands(kernel, in[0]);
            const auto truth = bandsOf(kernel, static_cast<Real>(in[0]));
            Real worst = 0;
            for (std::size_t l = 0; l < 3; ++l) {
                const Real off = std::abs(static_cast<Real>(found[l]) - truth[l]) / (1e-9L * std::abs(truth[l]));
                if (!(off <= worst)) worst = off;
            }
            return worst;
        });
    }
}

// ---- light searches

lighting::ShRgb incidentOf(const Input& in) {
    lighting::ShRgb out;
    for (std::size_t i = 0; i < 27; ++i) out[i / 3][static_cast<int>(i % 3)] = static_cast<float>(in[i]);
    return out;
}
std::vector<SearchRange> incidentRanges(double low, double high) {
    return std::vector<SearchRange>(27, {low, high, Kind::Signed});
}
/// The share of energy that a light leaves.
Real unexplainedBy(const lighting::ShRgb& incident, const fit::LightFit& light, bool hasAmbient) {
    const RealSh basis =
        realBasis(static_cast<Real>(light.direction.x), static_cast<Real>(light.direction.y), static_cast<Real>(light.direction.z));
    Real error = 0, energy = 0;
    for (std::size_t i = 0; i < incident.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const Real value = static_cast<Real>(incident[i][c]);
            const Real ambient = i == 0 && hasAmbient ? static_cast<Real>(light.ambient[c]) * 2 * std::sqrt(kPi) : 0;
            const Real rest = value - static_cast<Real>(light.intensity[c]) * basis[i] - ambient;
            error += rest * rest;
            energy += value * value;
        }
    return energy == 0 ? Real(0) : error / energy;
}
void expectLights(const SearchBudget& budget, bool hasAmbient) {
    test::expectHolds("bestLight: unexplained, within 1e-12", incidentRanges(1e-45, kMostFloat), budget, [&](const Input& in) {
        const lighting::ShRgb incident = incidentOf(in);
        const fit::LightFit light = fit::bestLight(incident, {0, 0, 1}, hasAmbient);
        return std::abs(static_cast<Real>(light.unexplained) - unexplainedBy(incident, light, hasAmbient)) / 1e-12L;
    });
    test::expectHolds("leastUnexplained, below any light by up to 1e-12", incidentRanges(1e-45, kMostFloat), budget, [&](const Input& in) {
        const lighting::ShRgb incident = incidentOf(in);
        const Real least = static_cast<Real>(fit::leastUnexplained(incident, hasAmbient));
        return (least - unexplainedBy(incident, fit::bestLight(incident, {0, 0, 1}, hasAmbient), hasAmbient)) / 1e-12L;
    });
}
void expectDominant(const SearchBudget& budget) {
    for (const auto kind :
         {fit::DominantFit::Closed, fit::DominantFit::Refined, fit::DominantFit::Explained, fit::DominantFit::RefinedAmbient})
        test::expectHolds("dominantLight, in the unit ball and not above largestIntensity, within 1e-6", incidentRanges(1e-45, kMostFloat),
                          budget, [&](const Input& in) {
                              const lighting::ShRgb incident = incidentOf(in);
                              fit::DominantLightOptions options;
                              options.fit = kind;
                              const fit::DominantLight light = fit::dominantLight(incident, {0, 0, 1}, options);
                              const Real most = static_cast<Real>(fit::largestIntensity(incident)) * (1 + 1e-6L);
                              Real worst = glm::length(glm::dvec3(light.direction)) / (1 + 1e-6L);
                              for (int c = 0; c < 3; ++c) {
                                  if (!(light.intensity[c] >= 0)) return Real(HUGE_VAL);
                                  if (light.intensity[c] > 0)
                                      worst = std::max(worst, static_cast<Real>(light.intensity[c]) / (most + 1e-45L));
                              }
                              return worst;
                          });
}

// ---- pre-division

void expectWindow(const SearchBudget& budget, double low, double high) {
    std::vector<SearchRange> ranges = incidentRanges(low, high);
    ranges.insert(ranges.end(), 3, {1e-6, 1, Kind::Signed});  // direction
    ranges.push_back({0.01, 1});                              // m
    test::expectHolds("makePreDivide, at least epsilon of the mean, within 1e-5", ranges, budget, [](const Input& in) {
        lighting::ShRgb incident = incidentOf(in);
        fit::PreDivideOptions options;
        const lighting::ShBands bands = fit::prefilterKernelBands(fit::PrefilterKernel::Ggx, in[30]);
        const fit::PreDivide found = fit::makePreDivide(incident, {{1, 1, 1}, bands}, options);
        const Real x = static_cast<Real>(in[27]), y = static_cast<Real>(in[28]), z = static_cast<Real>(in[29]) + 1e-7L,
                   length = std::sqrt(x * x + y * y + z * z);
        const RealSh basis = realBasis(x / length, y / length, z / length);
        Real worst = 0;
        for (int c = 0; c < 3; ++c) {
            Real sum = 0;
            for (std::size_t i = 0; i < basis.size(); ++i) sum += basis[i] * static_cast<Real>(found.windowedSh[i][c]);
            const Real mean = basis[0] * static_cast<Real>(found.windowedSh[0][c]);
            worst = std::max(worst, sum > 0 ? static_cast<Real>(options.epsilon) * mean / sum / (1 + 1e-5L) : Real(HUGE_VAL));
        }
        return worst;
    });
}

// ---- filters

void expectFilters(const SearchBudget& budget) {
    std::vector<SearchRange> ranges(32, {1e-45, kMostFloat});
    const auto largest = [](const formats::Image<glm::vec3>& image, int channel) {
        Real out = 0;
        for (const glm::vec3& texel : image.texels()) {
            if (!(texel[channel] >= 0)) return Real(HUGE_VAL);
            out = std::max(out, static_cast<Real>(texel[channel]));
        }
        return out;
    };
    test::expectHolds("irradianceCubemap, from 0 to the brightest, within 1e-6", ranges, budget, [&](const Input& in) {
        const formats::Environment environment = environmentOf(in, false, 8, 4);
        const auto strip = fit::irradianceCubemap(environment, {2, 0, 4}).value();
        return largest(strip, 0) / (largest(environment.texels, 0) * (1 + 1e-6L));
    });
    test::expectHolds("CubemapPrefilter, from 0 to the brightest, within 1e-6", ranges, budget, [&](const Input& in) {
        const formats::Environment environment = environmentOf(in, false, 8, 4);
        fit::CubemapOptions options;
        options.size = 4;
        const auto filter = fit::CubemapPrefilter::create(environment, options);
        Real worst = 0;
        for (int mip = 0; mip < filter->mipCount(); ++mip)
            for (int channel = 0; channel < 2; ++channel)
                worst = std::max(worst, largest(filter->filterMip(mip), channel) / (largest(environment.texels, channel) * (1 + 1e-6L)));
        return worst;
    });
}

TEST(FitNumbers, Projection) {
    expectProjection({1500}, false);
    expectProjection({1500}, true);
}
TEST(FitNumbers, Kernels) {
    expectKernels({60});
}
TEST(FitNumbers, Lights) {
    expectLights({1500}, false);
    expectLights({1500}, true);
}
TEST(FitNumbers, Dominant) {
    expectDominant({2000});
}
TEST(FitNumbers, Window) {
    expectWindow({1000}, 1e-45, kMostFloat);
}
TEST(FitNumbers, Filters) {
    expectFilters({30});
}
TEST(FitNumbersSoak, Projection) {
    expectProjection(test::soakBudget(2), false);
    expectProjection(test::soakBudget(2), true);
}
TEST(FitNumbersSoak, Kernels) {
    expectKernels(test::soakBudget(3));
}
TEST(FitNumbersSoak, Lights) {
    expectLights(test::soakBudget(4), false);
    expectLights(test::soakBudget(4), true);
}
TEST(FitNumbersSoak, Dominant) {
    expectDominant(test::soakBudget(4));
}
TEST(FitNumbersSoak, Window) {
    expectWindow(test::soakBudget(), 1e-45, kMostFloat);
}
TEST(FitNumbersSoak, Filters) {
    expectFilters(test::soakBudget(2));
}

}  // namespace
}  // namespace lightcook
