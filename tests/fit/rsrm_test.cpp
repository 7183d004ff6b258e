#include "fit/rsrm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <glm/common.hpp>
#include <limits>

#include "tests/fit/brute_force.h"

namespace {

constexpr long double kPi = 3.14159265358979323846264338327950288L;

/// Tanh-sinh quadrature: converges exponentially, whatever happens at the ends. 45 points give 1e-11 on the integrands here.
template <class Function>
long double integrate(long double begin, long double end, const Function& function) {
    struct Node {
        long double x, weight;
    };
    static const std::vector<Node> nodes = [] {
        const long double step = 0.14L;
        std::vector<Node> result;
        for (int k = -22; k <= 22; ++k) {
            const long double inner = kPi / 2 * std::sinh(step * k), cosh = std::cosh(inner);
            result.push_back({0.5L + 0.5L * std::tanh(inner), step * kPi / 4 * std::cosh(step * k) / (cosh * cosh)});
        }
        return result;
    }();
    long double sum = 0;
    for (const Node& node : nodes) sum += function(begin + (end - begin) * node.x) * node.weight;
    return sum * (end - begin);
}

/// Mean over azimuth of the lobe at height z around an axis at height zo, over those azimuths where it is more than 1e-18 of its peak.
long double azimuthMean(long double z, long double zo, long double exponent) {
    const long double a = z * zo, b = std::sqrt(std::max(0.0L, 1 - z * z)) * std::sqrt(std::max(0.0L, 1 - zo * zo));
    if (a + b <= 0) return 0;
    const long double smallest = (a + b) * std::pow(1e-18L, 1 / exponent);
    const long double reach = b == 0 || (smallest - a) / b <= -1 ? kPi : std::acos(std::min(1.0L, (smallest - a) / b));
    return integrate(0, reach, [&](long double phi) { return std::pow(std::max(0.0L, a + b * std::cos(phi)), exponent); }) / kPi;
}

/// The definition of the map at one texel, zone by zone, in long double. What lies far outside the lobe is skipped.
std::array<long double, 3> reference(const std::vector<glm::vec3>& gradient, long double zo, long double exponent) {
    const int zoneCount = static_cast<int>(gradient.size());
    const long double reachAngle = std::min(kPi / 2, std::acos(std::pow(1e-17L, 1 / exponent)));
    const long double theta = std::acos(zo);
    const long double highest = std::cos(std::max(0.0L, theta - reachAngle)), lowest = std::cos(std::min(kPi, theta + reachAngle));
    // The integrand bends where the back side of the lobe begins, and peaks at its middle.
    const long double bend = std::sqrt(1 - zo * zo);
    std::vector<long double> cuts = {highest, lowest, bend, -bend, zo};
    for (int zone = 0; zone <= zoneCount; ++zone) cuts.push_back(1 - 2.0L * zone / zoneCount);
    for (int piece = 1; piece < 12; ++piece) cuts.push_back(lowest + (highest - lowest) * piece / 12);
    std::sort(cuts.begin(), cuts.end());
    std::array<long double, 3> sum{};
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        const long double bottom = std::max(lowest, cuts[i]), top = std::min(highest, cuts[i + 1]);
        if (top <= bottom) continue;
        const int zone = std::clamp(static_cast<int>((1 - 0.5L * (top + bottom)) / 2 * zoneCount), 0, zoneCount - 1);
        // (s + 1) / 2pi times 2pi times the mean over azimuth.
        const long double weight = (exponent + 1) * integrate(bottom, top, [&](long double z) { return azimuthMean(z, zo, exponent); });
        for (int channel = 0; channel < 3; ++channel) {
            sum[static_cast<std::size_t>(channel)] += weight * gradient[static_cast<std::size_t>(zone)][channel];
        }
    }
    return sum;
}

std::vector<glm::vec3> roughGradient(int count) {
    truth::Random random(7);
    std::vector<glm::vec3> gradient;
    for (int i = 0; i < count; ++i) {
        gradient.emplace_back(static_cast<float>(random.uniform()), i == count / 5 ? 1.0f : 0.0f, i < count / 2 ? 1.0f : 0.125f);
    }
    return gradient;
}

TEST(Rsrm, ConstantStaysConstantForEveryExponent) {
    fit::RsrmOptions options;
    options.exponents.clear();
    for (int power = 0; power <= 16; ++power) options.exponents.push_back(std::pow(2.0, power));
    options.exponents.push_back(3.5);
    const auto values = fit::convolveGradient(std::vector<glm::vec3>(256, glm::vec3(0.5f, 0.7f, 1e6f)), options);
    for (const glm::dvec3& value : values.texels()) {
        EXPECT_NEAR(value.x, 0.5, 0.5e-6);
        EXPECT_NEAR(value.y, 0.7f, 0.7e-6);
        EXPECT_NEAR(value.z, 1e6, 1);
    }
}

/// The same, without the shortcut for constants: one zone differs by a hair.
TEST(Rsrm, NearlyConstantStaysNearlyConstant) {
    std::vector<glm::vec3> gradient(256, glm::vec3(0.5f));
    gradient[100] = glm::vec3(0.5000001f);
    const auto values = fit::convolveGradient(gradient, {});
    for (const glm::dvec3& value : values.texels()) EXPECT_NEAR(value.x, 0.5, 5e-7);
}

TEST(Rsrm, MatchesTheDefinitionInLongDoubleFromExponent1To65536) {
    const auto gradient = roughGradient(64);
    fit::RsrmOptions options;
    options.width = 48;
    options.exponents = {1, 2, 3, 7.5, 16, 64, 255, 1024, 4096, 16384, 65536};
    const auto values = fit::convolveGradient(gradient, options);
    for (int row = 0; row < values.height(); ++row) {
        glm::dvec3 largest(0);
        for (int x = 0; x < options.width; ++x) largest = glm::max(largest, values.at(x, row));
        const double exponent = options.exponents[static_cast<std::size_t>(row)];
        for (int x = 0; x < options.width; x += 5) {
            const auto expected = reference(gradient, 1 - (2.0L * x + 1) / options.width, exponent);
            for (int channel = 0; channel < 3; ++channel) {
                const double value = static_cast<double>(expected[static_cast<std::size_t>(channel)]);
                // Relative to the value as well as to the row: only the rounding of the series' sum may come on top.
                EXPECT_NEAR(values.at(x, row)[channel], value, 1e-6 * value + 2e-9 * largest[channel])
                    << "exponent " << exponent << " texel " << x << " channel " << channel;
            }
        }
    }
}

TEST(Rsrm, Exponent1IsLambertExitRadianceOfAHemisphere) {
    std::vector<glm::vec3> sky(256, glm::vec3(0));
    std::fill(sky.begin(), sky.begin() + 128, glm::vec3(1));
    fit::RsrmOptions options;
    options.exponents = {1};
    const auto values = fit::convolveGradient(sky, options);
    for (int x = 0; x < 256; ++x) {
        const double z = 1 - (2.0 * x + 1) / 256;
        EXPECT_NEAR(values.at(x, 0).x, (1 + z) / 2, 2e-9) << x;  // form factor of the sky dome
    }
}

TEST(Rsrm, HighExponentReturnsTheSource) {
    std::vector<glm::vec3> gradient;
    for (int i = 0; i < 16; ++i) gradient.emplace_back(static_cast<float>(i % 4));
    fit::RsrmOptions options;
    options.width = 16;
    options.exponents = {65536};
    const auto values = fit::convolveGradient(gradient, options);
    for (int x = 1; x < 15; ++x) EXPECT_NEAR(values.at(x, 0).x, gradient[static_cast<std::size_t>(x)].x, 1e-6) << x;
}

TEST(Rsrm, OneBrightZoneKeepsItsEnergyInEveryRow) {
    std::vector<glm::vec3> gradient(256, glm::vec3(0));
    gradient[37] = glm::vec3(1e6f);
    fit::RsrmOptions options;
    options.width = 4096;
    options.exponents = {1, 16, 256, 4096, 65536};
    const auto values = fit::convolveGradient(gradient, options);
    for (int row = 0; row < values.height(); ++row) {
        double mean = 0;
        for (int x = 0; x < options.width; ++x) mean += values.at(x, row).x / options.width;
        EXPECT_NEAR(mean, 1e6 / 256, 1e-4 * 1e6 / 256) << options.exponents[static_cast<std::size_t>(row)];
    }
}

TEST(Rsrm, CodesTimesColourAreWithinHalfACode) {
    const auto map = fit::makeRsrm(roughGradient(256), {});
    for (std::size_t texel = 0; texel < map.codes.texels().size(); ++texel) {
        for (int channel = 0; channel < 3; ++channel) {
            const double decoded = map.codes.texels()[texel][channel] / 255.0 * map.color[channel];
            EXPECT_NEAR(decoded, map.values.texels()[texel][channel], 0.5001 / 255 * map.color[channel]);
        }
    }
}

TEST(Rsrm, BlackAndHugeGradientsStayFinite) {
    std::vector<glm::vec3> gradient(256, glm::vec3(0));
    const auto black = fit::makeRsrm(gradient, {});
    EXPECT_EQ(black.color, glm::vec3(0));
    for (const auto& code : black.codes.texels()) EXPECT_EQ(code, glm::u8vec3(0));
    gradient[3] = glm::vec3(std::numeric_limits<float>::max());
    const auto huge = fit::makeRsrm(gradient, {});
    for (const auto& value : huge.values.texels()) EXPECT_TRUE(std::isfinite(value.x) && value.x >= 0);
    EXPECT_TRUE(std::isfinite(huge.color.x));
}

TEST(Rsrm, OneZoneAndOneTexelAreConstants) {
    fit::RsrmOptions options;
    options.width = 1;
    const auto values = fit::convolveGradient({glm::vec3(2)}, options);
    for (const auto& value : values.texels()) EXPECT_EQ(value.x, 2);
    options.exponents = {1};
    // Two zones seen from the equator: half of each.
    EXPECT_NEAR(fit::convolveGradient({glm::vec3(1), glm::vec3(0)}, options).at(0, 0).x, 0.5, 1e-9);
}

TEST(Rsrm, BadRequestsAreRefusedByName) {
    fit::RsrmOptions options;
    EXPECT_FALSE(fit::checkRsrm({}, options));
    EXPECT_FALSE(fit::checkRsrm({glm::vec3(1, -1, 0)}, options));
    const auto nan = fit::checkRsrm({glm::vec3(1), glm::vec3(0, std::nanf(""), 0)}, options);
    ASSERT_FALSE(nan);
    EXPECT_EQ(nan.error().subject, "gradient, zone 1, channel G");
    options.exponents = {0.5};
    EXPECT_FALSE(fit::checkRsrm({glm::vec3(1)}, options));
    options.exponents = {70000};
    EXPECT_FALSE(fit::checkRsrm({glm::vec3(1)}, options));
    options.exponents = {1};
    options.width = 0;
    EXPECT_FALSE(fit::checkRsrm({glm::vec3(1)}, options));
}

TEST(Rsrm, DefaultMapTakesUnderAHundredMilliseconds) {
    const auto gradient = roughGradient(256);
    double best = 1e9;
    for (int run = 0; run < 3; ++run) {
        const std::clock_t begin = std::clock();
        const auto map = fit::makeRsrm(gradient, {});
        best = std::min(best, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
        ASSERT_GT(map.color.x, 0);
    }
    RecordProperty("cpu_seconds", std::to_string(best));
    std::printf("[ figures  ] RSRM 256 -> 256 x 8: %.1f ms CPU\n", 1e3 * best);
    EXPECT_LT(best, 0.1);
}

}  // namespace
