#include "fit/rsrm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <glm/common.hpp>
#include <limits>

#include "shaders/lightcook_cpp.h"
#include "tests/fit/brute_force.h"
#include "tests/lighting/worst_search.h"
#include "tests/soak/soak.h"

namespace lightcook {
namespace {

using truth::kLongPi;

/// Tanh-sinh quadrature: converges exponentially, also with singularities at the ends. 45 points give 1e-11 on the integrands here.
template <class Function>
long double integrate(long double begin, long double end, const Function& function) {
    struct Node {
        long double x, weight;
    };
    static const std::vector<Node> nodes = [] {
        const long double step = 0.14L;
        std::vector<Node> result;
        for (int k = -22; k <= 22; ++k) {
            const long double inner = kLongPi / 2 * std::sinh(step * k), cosh = std::cosh(inner);
            result.push_back({0.5L + 0.5L * std::tanh(inner), step * kLongPi / 4 * std::cosh(step * k) / (cosh * cosh)});
        }
        return result;
    }();
    long double sum = 0;
    for (const Node& node : nodes) sum += function(begin + (end - begin) * node.x) * node.weight;
    return sum * (end - begin);
}

/// Returns the mean over azimuth of the lobe at height z around an axis at height zo, ignoring values below 1e-18 of its peak.
long double azimuthMean(long double z, long double zo, long double exponent) {
    const long double a = z * zo, b = std::sqrt(std::max(0.0L, 1 - z * z)) * std::sqrt(std::max(0.0L, 1 - zo * zo));
    if (a + b <= 0) return 0;
    const long double smallest = (a + b) * std::pow(1e-18L, 1 / exponent);
    const long double reach = b == 0 || (smallest - a) / b <= -1 ? kLongPi : std::acos(std::min(1.0L, (smallest - a) / b));
    return integrate(0, reach, [&](long double phi) { return std::pow(std::max(0.0L, a + b * std::cos(phi)), exponent); }) / kLongPi;
}

/// Returns one texel of the map by its definition, zone by zone, in long double. Zones far outside the lobe are skipped.
std::array<long double, 3> reference(const std::vector<glm::vec3>& gradient, long double zo, long double exponent) {
    const int zoneCount = static_cast<int>(gradient.size());
    const long double reachAngle = std::min(kLongPi / 2, std::acos(std::pow(1e-17L, 1 / exponent)));
    const long double theta = std::acos(zo);
    const long double highest = std::cos(std::max(0.0L, theta - reachAngle)), lowest = std::cos(std::min(kLongPi, theta + reachAngle));
    // The integrand has a kink at the horizon of the lobe and a peak at its centre.
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

/// The same without the shortcut for constants: one zone differs slightly.
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
                // Relative to the value as well as to the row: only rounding of the series' sum is allowed on top.
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
    // Two zones, seen from the equator: half of each.
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

/// Compares one texel with the definition for each exponent: relative to the value, plus the rounding of the sum relative to the row.
void checkExponents(int first, int step, std::uint64_t seed) {
    truth::Random random(seed);
    const auto gradient = roughGradient(32);
    fit::RsrmOptions options;
    options.width = 64;
    double worst = 0;
    int count = 0;
    for (int exponent = first; exponent <= 65536; exponent += step, ++count) {
        options.exponents = {static_cast<double>(exponent)};
        const auto values = fit::convolveGradient(gradient, options);
        const int x = random.below(options.width);
        const auto expected = reference(gradient, 1 - (2.0L * x + 1) / options.width, exponent);
        for (int channel = 0; channel < 3; ++channel) {
            const double value = static_cast<double>(expected[static_cast<std::size_t>(channel)]);
            ASSERT_NEAR(values.at(x, 0)[channel], value, 1e-6 * value + 2e-9) << "exponent " << exponent << " texel " << x;
            if (value > 1e-3) worst = std::max(worst, std::abs(values.at(x, 0)[channel] / value - 1));
        }
    }
    std::printf("[ figures  ] RSRM of %d exponents up to 65536: at most %.1e of the value off before quantization\n", count, worst);
}

TEST(Rsrm, MatchesTheDefinitionForExponentsAllOverTheRange) {
    checkExponents(1, 769, 1);
}

/// The worst of light from 1e-45 to the largest float in eight zones, exponents and widths.
void searchMaps(const test::SearchBudget& budget) {
    std::vector<test::SearchRange> ranges(8, {1e-45, 3.4028234663852886e38});
    ranges.push_back({1, 65536});
    ranges.push_back({1, 256});
    ranges.push_back({0, 1, test::SearchRange::Kind::Linear});
    test::expectHolds("convolveGradient, within 1e-6 of the brightest zone", ranges, budget, [](const std::vector<double>& in) {
        std::vector<glm::vec3> gradient;
        for (std::size_t i = 0; i < 8; ++i) gradient.emplace_back(static_cast<float>(in[i]));
        fit::RsrmOptions options;
        options.exponents = {in[8]};
        options.width = static_cast<int>(in[9]);
        const auto values = fit::convolveGradient(gradient, options);
        const auto largest = std::max_element(in.begin(), in.begin() + 8);
        const int x = static_cast<int>(std::lround(in[10] * (options.width - 1)));
        const auto expected = reference(gradient, 1 - (2.0L * x + 1) / options.width, in[8])[0];
        return std::abs(static_cast<long double>(values.at(x, 0).x) - expected) / (1e-6L * static_cast<long double>(*largest));
    });
}

TEST(RsrmNumbersSoak, AnyLightHasTheStatedError) {
    searchMaps(test::soakBudget());
}

TEST(RsrmNumbers, AnyLightHasTheStatedError) {
    searchMaps({40});
}

/// 1024 rounds have every exponent from 1 to 65536.
TEST(RsrmSoak, MatchesTheDefinitionForExponentsAllOverTheRange) {
    test::repeatInSoak("random cases", 64, [](std::uint64_t seed) { checkExponents(1 + static_cast<int>(seed % 1024), 1024, seed); });
}

/// Random gradients of any length and magnitude; every texel is a case. Values lie within the gradient's range, codes within half a code.
void checkTexels(std::uint64_t seed, std::int64_t texelCount) {
    truth::Random random(seed);
    const double magnitudes[] = {1e-45, 1e-40, 1e-20, 1, 1e6, 1e30, 3e38};
    for (std::int64_t done = 0; done < texelCount;) {
        std::vector<glm::vec3> gradient(static_cast<std::size_t>(1 + random.below(random.below(20) == 0 ? 400 : 40)));
        const double magnitude = magnitudes[random.below(7)], other = magnitudes[random.below(7)];
        for (glm::vec3& zone : gradient)
            for (int channel = 0; channel < 3; ++channel)
                zone[channel] = static_cast<float>((random.below(5) == 0 ? other : magnitude) * random.uniform());
        fit::RsrmOptions options;
        options.width = 1 + random.below(512);
        options.exponents = {std::exp2(16 * random.uniform()), std::exp2(8 * random.uniform())};
        options.dither = random.below(2) == 0;
        ASSERT_TRUE(fit::checkRsrm(gradient, options));
        const fit::Rsrm map = fit::makeRsrm(gradient, options);
        glm::vec3 low = gradient[0], high = gradient[0];
        for (const glm::vec3& zone : gradient) low = glm::min(low, zone), high = glm::max(high, zone);
        for (int row = 0; row < map.codes.height(); ++row) {
            glm::dvec3 sum(0);
            for (int x = 0; x < map.codes.width(); ++x, ++done)
                for (int channel = 0; channel < 3; ++channel) {
                    const double value = map.values.at(x, row)[channel], color = map.color[channel];
                    ASSERT_TRUE(value >= static_cast<double>(low[channel]) && value <= static_cast<double>(high[channel])) << seed;
                    ASSERT_TRUE(std::isfinite(color) && color >= value);
                    if (color == 0) continue;
                    const double error = map.codes.at(x, row)[channel] - value / color * 255;
                    sum[channel] += error;
                    ASSERT_LE(std::abs(error), options.dither ? 1.0000001 : 0.5000001) << "of a colour of " << color;
                    ASSERT_LE(options.dither ? std::abs(sum[channel]) : 0, 0.5000001) << "of a colour of " << color;
                }
        }
    }
}

TEST(Rsrm, ManyTexelsAreBetweenTheirSourcesEndsAndWithinTheirCodes) {
    checkTexels(11, 100000);
}

TEST(RsrmSoak, TexelsAreBetweenTheirSourcesEndsAndWithinTheirCodes) {
    test::repeatInSoak("random cases", 100000, [](std::uint64_t seed) { checkTexels(seed, 100000); });
}

/// Blends as the shader does, after decoding. Convolution is linear, so the error of a blend is the blend of the errors. A case is one
/// texel of a blend.
void checkBlends(std::uint64_t seed, std::int64_t caseCount) {
    truth::Random random(seed);
    for (std::int64_t done = 0; done < caseCount;) {
        std::vector<glm::vec3> day(static_cast<std::size_t>(1 + random.below(64))), night(day.size()), both(day.size());
        const auto anyWeight = [&random] {
            return random.below(8) == 0 ? static_cast<float>(random.below(2)) : static_cast<float>(random.uniform());
        };
        const float firstWeight = anyWeight();
        for (std::size_t zone = 0; zone < day.size(); ++zone) {
            day[zone] = 100.0f * glm::vec3(random.uniform(), random.uniform(), random.uniform());
            night[zone] = 0.1f * glm::vec3(random.uniform(), random.uniform(), random.uniform());
            both[zone] = glm::vec3(glm::mix(glm::dvec3(day[zone]), glm::dvec3(night[zone]), static_cast<double>(firstWeight)));
        }
        fit::RsrmOptions options;
        options.exponents = {1, std::exp2(16 * random.uniform())};
        const fit::Rsrm first = fit::makeRsrm(day, options), second = fit::makeRsrm(night, options);
        const auto blended = fit::convolveGradient(both, options);
        for (int weighing = 0; weighing < 16; ++weighing) {
            const float weight = weighing == 0 ? firstWeight : anyWeight();
            const glm::dvec3 code = glm::mix(glm::dvec3(first.color), glm::dvec3(second.color), static_cast<double>(weight)) / 255.0;
            for (std::size_t i = 0; i < blended.texels().size(); ++i, ++done) {
                const glm::dvec3 mixed = glm::mix(first.values.texels()[i], second.values.texels()[i], static_cast<double>(weight)),
                                 expected = weighing == 0 ? blended.texels()[i] : mixed;
                const glm::vec3 shaded =
                    shaders::lcRsrmBlend(shaders::lcRsrm(glm::vec3(first.codes.texels()[i]) / 255.0f, first.color),
                                         shaders::lcRsrm(glm::vec3(second.codes.texels()[i]) / 255.0f, second.color), weight);
                for (int channel = 0; channel < 3; ++channel)
                    ASSERT_NEAR(shaded[channel], expected[channel],
                                0.501 * code[channel] + 1e-7 * static_cast<double>(first.color[channel]))
                        << "weight " << weight;
            }
        }
    }
}

TEST(Rsrm, ManyBlendsAreAsGoodAsTheirMaps) {
    checkBlends(21, 100000);
}

TEST(RsrmSoak, BlendsAreAsGoodAsTheirMaps) {
    test::repeatInSoak("random cases", 100000, [](std::uint64_t seed) { checkBlends(seed, 100000); });
}

TEST(Rsrm, OneChannelHoldsGradientsOfOneColourOnly) {
    std::vector<glm::vec3> gradient;
    for (int i = 0; i < 64; ++i) gradient.push_back(std::sin(0.1f * static_cast<float>(i + 1)) * glm::vec3(3, 0, 0.01f));
    for (glm::vec3& zone : gradient) zone = glm::abs(zone);
    EXPECT_FALSE(fit::firstZoneOfAnotherHue(gradient));
    gradient[40].z *= 1.01f;
    EXPECT_EQ(fit::firstZoneOfAnotherHue(gradient), 40u);
    EXPECT_FALSE(fit::firstZoneOfAnotherHue(std::vector<glm::vec3>(5, glm::vec3(0))));
}

TEST(Rsrm, SixteenThousandZonesAreNoDifferentFromTheirMeans) {
    // 128 equal zones in a row, and one zone for each run.
    std::vector<glm::vec3> coarse, fine;
    truth::Random random(31);
    for (int i = 0; i < 128; ++i) {
        coarse.emplace_back(static_cast<float>(random.uniform()), static_cast<float>(random.below(2)),
                            1e30f * static_cast<float>(random.uniform()));
        fine.insert(fine.end(), 128, coarse.back());
    }
    ASSERT_EQ(fine.size(), 16384u);
    const auto expected = fit::convolveGradient(coarse, {}), found = fit::convolveGradient(fine, {});
    for (std::size_t i = 0; i < expected.texels().size(); ++i)
        for (int channel = 0; channel < 3; ++channel)
            ASSERT_NEAR(found.texels()[i][channel], expected.texels()[i][channel], channel == 2 ? 1e20 : 1e-9);
}

TEST(Rsrm, DefaultMapTakesUnderTenMilliseconds) {
    const auto gradient = roughGradient(256);
    double best = 1e9;
    for (int run = 0; run < 8; ++run) {
        const std::clock_t begin = std::clock();
        const auto map = fit::makeRsrm(gradient, {});
        best = std::min(best, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
        ASSERT_GT(map.color.x, 0);
    }
    RecordProperty("cpu_seconds", std::to_string(best));
    std::printf("[ figures  ] RSRM 256 -> 256 x 8: %.1f ms CPU\n", 1e3 * best);
    EXPECT_LT(best, 0.01);
}

}  // namespace
}  // namespace lightcook
