#include "verify/rsrm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <random>

#include "fit/rsrm.h"
#include "lighting/radiometry.h"
#include "lighting/sh.h"

namespace lightcook::verify {
namespace {

std::vector<glm::vec3> sky(std::size_t zones) {
    std::vector<glm::vec3> gradient;
    for (std::size_t i = 0; i < zones; ++i) {
        const float z = 1 - (2 * static_cast<float>(i) + 1) / static_cast<float>(zones);
        gradient.emplace_back(0.5f + 0.4f * z, std::abs(z), z > 0.8f ? 30.0f : 0.1f);
    }
    return gradient;
}

/// Returns a plain sum over the sphere: fine latitudes within zones, even longitudes over half a turn.
glm::dvec3 bySphere(const std::vector<glm::vec3>& gradient, double exponent, double z) {
    constexpr int kCuts = 400, kLongitudes = 180;
    const double step = 2.0 / (static_cast<double>(gradient.size()) * kCuts), sine = std::sqrt(1 - z * z);
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < gradient.size() * kCuts; ++i) {
        const double height = 1 - (static_cast<double>(i) + 0.5) * step;
        double lobe = 0;
        for (int j = 0; j < kLongitudes; ++j) {
            const double cosine = z * height + sine * std::sqrt(1 - height * height) * std::cos(std::numbers::pi * (j + 0.5) / kLongitudes);
            if (cosine > 0) lobe += std::pow(cosine, exponent);
        }
        sum += lobe * step * 2 * std::numbers::pi / kLongitudes * glm::dvec3(gradient[i / kCuts]);
    }
    return (exponent + 1) / (2 * std::numbers::pi) * sum;
}

/// Returns the map of the references, rounded to codes.
CookedRsrm quantized(const std::vector<glm::vec3>& gradient, int width, std::vector<double> exponents) {
    CookedRsrm map;
    map.exponents = std::move(exponents);
    map.texels = formats::Image<glm::vec4>(width, static_cast<int>(map.exponents.size()), glm::vec4(0, 0, 0, 1));
    formats::Image<glm::dvec3> values(width, map.texels.height());
    glm::dvec3 color(0);
    for (int y = 0; y < values.height(); ++y)
        for (int x = 0; x < width; ++x) {
            values.at(x, y) = convolvePhong(gradient, map.exponents[static_cast<std::size_t>(y)], 1 - (2.0 * x + 1) / width);
            color = glm::max(color, values.at(x, y));
        }
    map.color = glm::vec3(color);
    for (int y = 0; y < values.height(); ++y)
        for (int x = 0; x < width; ++x)
            for (int channel = 0; channel < 3; ++channel)
                if (color[channel] > 0)
                    map.texels.at(x, y)[channel] = static_cast<float>(std::round(values.at(x, y)[channel] / color[channel] * 255)) / 255.0f;
    return map;
}

std::vector<StageError> verifyAll(const CookedRsrm& map, const std::vector<glm::vec3>& gradient, int between = 1,
                                  const std::optional<Viewing>& viewing = std::nullopt) {
    std::vector<RsrmRow> rows;
    for (int row = 0; row < map.texels.height(); ++row) rows.push_back(compareRsrmRow(map, {gradient}, row, between));
    return rsrmStages(map, {gradient}, rows, lighting::kRec709Luminance, viewing);
}

TEST(ConvolvePhong, AgreesWithASumOverTheSphere) {
    const auto gradient = sky(32);
    for (const double exponent : {1.0, 33.5, 256.0})
        for (const double z : {-1.0, -0.3, 0.8, 0.98, 1.0}) {
            const glm::dvec3 expected = bySphere(gradient, exponent, z), found = convolvePhong(gradient, exponent, z);
            for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(found[channel], expected[channel], 2e-4 * 30) << exponent << " " << z;
        }
}

/// Returns random zones of every brightness from 0.2 to 1: no two neighbours are alike.
std::vector<glm::vec3> randomZones(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0.2f, 1);
    std::vector<glm::vec3> gradient;
    for (std::size_t i = 0; i < count; ++i) gradient.emplace_back(unit(random), unit(random), unit(random));
    return gradient;
}

/// Returns a sum over the sphere in long double: 2^15 latitudes or a few more, and 512 longitudes.
/// exponent  a power of two
glm::dvec3 byFineSphere(const std::vector<glm::vec3>& gradient, int exponent, double z) {
    constexpr int kLongitudes = 512;
    const auto lobeAt = [exponent](long double cosine) {
        long double lobe = std::max(cosine, 0.0L);
        for (int power = 1; power < exponent; power *= 2) lobe *= lobe;
        return lobe;
    };
    const std::size_t cuts = (32768 + gradient.size() - 1) / gradient.size(), rows = cuts * gradient.size();
    const long double sine = std::sqrt(1.0L - static_cast<long double>(z) * z), step = 2.0L / static_cast<long double>(rows);
    std::vector<long double> turns;
    for (int j = 0; j < kLongitudes; ++j) turns.push_back(std::cos(std::numbers::pi_v<long double> * (j + 0.5L) / kLongitudes));
    std::array<long double, 3> sums = {0, 0, 0};
    for (std::size_t i = 0; i < rows; ++i) {
        const long double height = 1 - (static_cast<long double>(i) + 0.5L) * step, radius = sine * std::sqrt(1 - height * height);
        if (lobeAt(z * height + radius) < 1e-11L) continue;
        long double lobe = 0;
        for (const long double turn : turns) lobe += lobeAt(z * height + radius * turn);
        for (int channel = 0; channel < 3; ++channel)
            sums[static_cast<std::size_t>(channel)] += lobe * static_cast<long double>(gradient[i / cuts][channel]);
    }
    const long double scale = (exponent + 1) * step / kLongitudes;
    return {static_cast<double>(scale * sums[0]), static_cast<double>(scale * sums[1]), static_cast<double>(scale * sums[2])};
}

TEST(ConvolvePhong, IsExactForGradientsOfManyDifferentZones) {
    for (const std::size_t zones : {16u, 256u, 1000u, 4096u}) {
        const auto gradient = randomZones(zones, 11);
        for (const auto& [exponent, z] : {std::pair(1, -0.3456), std::pair(1, 0.9987), std::pair(4, 0.61), std::pair(256, -0.85)}) {
            const glm::dvec3 expected = byFineSphere(gradient, exponent, z), found = convolvePhong(gradient, exponent, z);
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_NEAR(found[channel], expected[channel], 1e-5) << zones << " zones, exponent " << exponent << ", z " << z;
        }
    }
}

TEST(VerifyRsrm, RoundedCodesOfManyDifferentZonesAreWithinHalfACode) {
    for (const std::size_t zones : {256u, 512u, 700u, 1000u, 4096u}) {
        const auto gradient = randomZones(zones, 11);
        fit::RsrmOptions options;
        options.exponents = {1, 4, 256};
        const auto values = fit::convolveGradient(gradient, options);
        CookedRsrm map;
        map.exponents = options.exponents;
        map.color = glm::vec3(1);
        map.texels = formats::Image<glm::vec4>(values.width(), values.height());
        for (int y = 0; y < values.height(); ++y)
            for (int x = 0; x < values.width(); ++x) map.texels.at(x, y) = glm::vec4(glm::round(values.at(x, y) * 255.0) / 255.0, 1);
        std::vector<RsrmRow> rows;
        for (int row = 0; row < values.height(); ++row) rows.push_back(compareRsrmRow(map, {gradient}, row, 0));
        EXPECT_LE(rsrmCodeError(map, {gradient}, rows).codes, 0) << zones << " zones";
        map.texels.at(100, 1).y += 1.0f / 255;
        rows[1] = compareRsrmRow(map, {gradient}, 1, 0);
        const RsrmCodeError wrong = rsrmCodeError(map, {gradient}, rows);
        EXPECT_GT(wrong.codes, 0) << zones << " zones";
        EXPECT_EQ(glm::ivec2(wrong.column, wrong.row), glm::ivec2(100, 1)) << zones << " zones";
    }
}

TEST(ConvolvePhong, LambertOfALinearGradientIsKnown) {
    // L = 1 + z convolved with the clamped cosine is 1 + 2/3 z; zones quantize it in steps of 1/512.
    std::vector<glm::vec3> gradient;
    for (int i = 0; i < 1024; ++i) gradient.emplace_back(2 - (2 * static_cast<float>(i) + 1) / 1024);
    for (const double z : {-1.0, -0.6, 0.0, 0.25, 0.9, 1.0}) EXPECT_NEAR(convolvePhong(gradient, 1, z).x, 1 + 2.0 / 3 * z, 2e-4) << z;
}

TEST(ConvolvePhong, ConstantsStayConstantAndSharpLobesSeeOneZone) {
    const std::vector<glm::vec3> constant(17, glm::vec3(0.25f, 1, 7));
    for (const double exponent : {1.0, 1000.0, 65536.0})
        for (const double z : {-1.0, 0.1, 0.9999, 1.0}) EXPECT_NEAR(convolvePhong(constant, exponent, z).z, 7, 1e-10);
    const auto gradient = sky(16);
    EXPECT_NEAR(convolvePhong(gradient, 65536, 1 - 7.0 / 16).x, static_cast<double>(gradient[3].x), 1e-6);
}

TEST(VerifyRsrm, RoundedCodesAreWithinHalfACode) {
    const auto gradient = sky(64);
    const CookedRsrm map = quantized(gradient, 256, {1, 16, 256});
    const auto stages = verifyAll(map, gradient);
    ASSERT_EQ(stages.size(), 2u);
    EXPECT_EQ(stages[0].name, "quantize");
    EXPECT_EQ(stages[1].name, "total");
    EXPECT_GT(stages[0].diffuse.relRms, 1e-5);
    EXPECT_LT(stages[0].diffuse.relRms, 0.01);
    EXPECT_LT(stages[0].specular.relRms, 0.005);
    EXPECT_LT(stages[1].specular.relRms, 0.05);
    for (const StageError& stage : stages)
        for (const ErrorFigures& figures : {stage.diffuse, stage.specular}) EXPECT_GE(figures.maxBound, figures.maxSampled) << stage.name;
}

TEST(VerifyRsrm, TheBoundHoldsAtEveryPlaceBetweenTexels) {
    const auto gradient = sky(24);  // edges of zones fall between texels
    const CookedRsrm map = quantized(gradient, 20, {1, 8, 700, 16384});
    const StageError coarse = verifyAll(map, gradient, 1).back(), fine = verifyAll(map, gradient, 37).back();
    EXPECT_GT(fine.specular.maxSampled, coarse.specular.maxSampled);
    EXPECT_GE(coarse.specular.maxBound, fine.specular.maxSampled);
    EXPECT_GE(coarse.diffuse.maxBound, fine.diffuse.maxSampled);
    EXPECT_LT(coarse.diffuse.maxBound, 100 * fine.diffuse.maxSampled);
}

TEST(VerifyRsrm, TheBoundOfVisibleErrorsHoldsAtEveryPlaceBetweenTexels) {
    const auto gradient = sky(24);
    const Viewing viewing{lighting::DisplaySettings{}.of(rsrmDisplayKey(gradient, lighting::kRec709Luminance))};
    double good = 0;
    for (const bool isWrong : {false, true}) {
        CookedRsrm map = quantized(gradient, 20, {1, 8, 700, 16384});
        if (isWrong) map.texels.at(15, 0) *= 5.0f;
        const StageError coarse = verifyAll(map, gradient, 1, viewing).back(), fine = verifyAll(map, gradient, 37, viewing).back();
        for (const auto shading : {&StageError::diffuse, &StageError::specular}) {
            const VisibleFigures &bounded = (coarse.*shading).visible.value(), &sampled = (fine.*shading).visible.value();
            EXPECT_GE(bounded.bound.value(), sampled.max);
            EXPECT_GE(sampled.bound.value(), sampled.max);
            EXPECT_LE(*sampled.bound, *bounded.bound) << "narrower parts";
            EXPECT_TRUE(bounded.boundAt.isKnown());
        }
        const double bound = coarse.diffuse.visible->bound.value();
        EXPECT_GT(bound, good);
        good = 1.5 * bound;
    }
    EXPECT_FALSE(verifyAll(quantized(gradient, 20, {8}), gradient, 1, viewing)[0].specular.visible->bound.has_value()) << "texels alone";
}

TEST(VerifyRsrm, AMapOfOneLightHasATightBoundOfVisibleErrorsAndLightThatIsNotFiniteNone) {
    const std::vector<glm::vec3> gradient(16, glm::vec3(0.3f, 0.5f, 0.9f));
    const Viewing viewing{lighting::DisplaySettings{}.of(rsrmDisplayKey(gradient, lighting::kRec709Luminance))};
    CookedRsrm map = quantized(gradient, 16, {1, 64});
    for (const StageError& stage : {verifyAll(map, gradient, 1, viewing).back()})
        for (const ErrorFigures& figures : {stage.diffuse, stage.specular}) EXPECT_LT(figures.visible->bound.value(), 0.1);
    map.texels.at(3, 1).y = NAN;
    EXPECT_EQ(verifyAll(map, gradient, 1, viewing).back().specular.visible->bound, HUGE_VAL);
}

/// Samples are displaced by 1/256 texel along the row and across rows, and texels and filters changed within the format's tolerance.
TEST(VerifyRsrm, TheBoundHoldsForAnySamplerWithinTheTolerance) {
    const auto gradient = sky(64);
    CookedRsrm map = quantized(gradient, 20, {1, 8, 700, 16384});
    const auto ideal = verifyAll(map, gradient);
    for (const formats::PixelFormat format : {formats::PixelFormat::Rgba8Unorm, formats::PixelFormat::Bc7, formats::PixelFormat::Bc4}) {
        map.isGrey = format == formats::PixelFormat::Bc4;
        map.tolerance = toleranceOf(format);
        if (map.tolerance.hasSpans()) map.spans = formats::Image<glm::vec4>(5, 1, glm::vec4(0.5f, 0, 0, 0));
        const auto stages = verifyAll(map, gradient);
        EXPECT_TRUE(map.isGrey || stages.back().specular.maxBound > ideal.back().specular.maxBound);
        std::mt19937 random(3);
        std::uniform_real_distribution<double> unit(-1, 1);
        for (int row = 0; row < 4; ++row) {
            const std::vector<RsrmRow> rows = {compareRsrmRow(map, {gradient}, row, 0)};
            for (int i = 0; i < 5000; ++i) {
                const double z = unit(random);
                // Each texel is changed within its tolerance; the mean of four is changed by no more.
                const glm::dvec2 place = {std::clamp(0.5 * (1 - z) * 20 - 0.5 + unit(random) / 256, 0.0, 19.0),
                                          std::clamp(row + unit(random) / 256, 0.0, 3.0)};
                const int x = std::min(static_cast<int>(place.x), 18), y = std::min(static_cast<int>(place.y), 2);
                const glm::dvec2 f = place - glm::dvec2(x, y);
                glm::dvec4 seen(0);
                for (int corner = 0; corner < 4; ++corner)
                    seen += (corner % 2 == 1 ? f.x : 1 - f.x) * (corner / 2 == 1 ? f.y : 1 - f.y) *
                            glm::dvec4(map.texels.at(x + corner % 2, y + corner / 2));
                const FormatTolerance& tolerance = map.tolerance;
                const double span = map.isGrey ? 0.5 : 0.0;
                for (int channel = 0; channel < 4; ++channel)
                    seen[channel] +=
                        (unit(random) < 0 ? -1 : 1) * (static_cast<double>(tolerance.decoded[channel]) + span * tolerance.perSpan[channel] +
                                                       static_cast<double>(tolerance.absolute));
                // The nearest centres on either side.
                const double position = 0.5 * (1 - z) * 20 - 0.5;
                const auto& points = rows[0].points;
                const std::size_t left = 1 + static_cast<std::size_t>(std::clamp(std::floor(position), 0.0, 19.0)),
                                  right = 1 + static_cast<std::size_t>(std::clamp(std::floor(position) + 1, 0.0, 19.0));
                for (int channel = 0; channel < 3; ++channel) {
                    const double light = static_cast<double>(map.color[channel]) * seen[map.isGrey ? 0 : channel];
                    const double slack =
                        std::max(points[left].tolerance[channel], points[right].tolerance[channel]) + 1e-6 * std::abs(light);
                    ASSERT_GE(light, std::min(points[left].cooked[channel], points[right].cooked[channel]) - slack);
                    ASSERT_LE(light, std::max(points[left].cooked[channel], points[right].cooked[channel]) + slack);
                }
            }
        }
    }
}

TEST(VerifyRsrm, FindsAWrongColourAndAMapUpsideDown) {
    const auto gradient = sky(64);
    CookedRsrm map = quantized(gradient, 128, {1, 4});
    map.color *= 1.2f;
    const auto brighter = verifyAll(map, gradient);
    EXPECT_NEAR(brighter.back().diffuse.relRms, 0.2, 0.01);
    EXPECT_NEAR(brighter.back().specular.relRms, 0.2, 0.01);
    CookedRsrm flipped = quantized(gradient, 128, {1, 4});
    for (int x = 0; x < 64; ++x) std::swap(flipped.texels.at(x, 1), flipped.texels.at(127 - x, 1));
    const auto stages = verifyAll(flipped, gradient);
    EXPECT_GT(stages.back().specular.relRms, 0.5);
    EXPECT_LT(stages.back().diffuse.relRms, 0.01);  // row 0 is unchanged
}

std::vector<RsrmRow> rowsOf(const CookedRsrm& map, const std::vector<glm::vec3>& gradient) {
    std::vector<RsrmRow> rows;
    for (int row = 0; row < map.texels.height(); ++row) rows.push_back(compareRsrmRow(map, {gradient}, row));
    return rows;
}

TEST(VerifyRsrm, BandingReportsStepsThatTheLightDoesNotHave) {
    const auto gradient = sky(64);
    CookedRsrm map = quantized(gradient, 64, {1, 16});
    const RsrmBanding honest = rsrmBanding(map, rowsOf(map, gradient), lighting::kRec709Luminance);
    EXPECT_LT(honest.codeError, 0.56);  // and the error of the reference
    EXPECT_LT(honest.stepCodes, 1.11);
    EXPECT_LT(honest.bandCodes, 0.56);
    EXPECT_GT(honest.stepContrast, 0);
    map.texels.at(30, 0).y += 17.0f / 255;
    const RsrmBanding stepped = rsrmBanding(map, rowsOf(map, gradient), lighting::kRec709Luminance);
    EXPECT_NEAR(stepped.codeError, 17, 0.56);
    EXPECT_NEAR(stepped.stepCodes, 17, 1.11);
    EXPECT_GE(stepped.stepContrast, honest.stepContrast);
}

TEST(VerifyRsrm, BandCodesAreTheMeanErrorOfEightTexels) {
    // Light that hardly changes, with a value between two codes: rounding has the same error everywhere.
    std::vector<glm::vec3> gradient(64, glm::vec3(100.4f / 255));
    gradient[63] = glm::vec3(1);
    CookedRsrm map;
    map.color = glm::vec3(1);
    map.exponents = {65536};
    map.texels = formats::Image<glm::vec4>(64, 1, glm::vec4(100.0f / 255));
    map.texels.at(63, 0) = glm::vec4(1);
    EXPECT_NEAR(rsrmBanding(map, rowsOf(map, gradient), lighting::kRec709Luminance).bandCodes, 0.4, 0.01);
    for (int x = 0; x < 63; x += 5) map.texels.at(x, 0) = map.texels.at(x + 2, 0) = glm::vec4(101.0f / 255);  // two of five
    const RsrmBanding dithered = rsrmBanding(map, rowsOf(map, gradient), lighting::kRec709Luminance);
    EXPECT_LT(dithered.bandCodes, 0.13);
    EXPECT_NEAR(dithered.stepContrast, 1 / (101 + lighting::kLocalErrorFloor * 102), 1e-4)
        << "a step of one code, the light there 101 codes";
}

TEST(VerifyRsrm, EachKindOfCodesHasItsOwnLimit) {
    const auto gradient = sky(64);
    CookedRsrm map = quantized(gradient, 64, {1, 16});
    EXPECT_LE(rsrmCodeError(map, {gradient}, rowsOf(map, gradient)).codes, 0);
    map.texels.at(9, 1).y += 1.2f / 255;
    const RsrmCodeError off = rsrmCodeError(map, {gradient}, rowsOf(map, gradient));
    EXPECT_GT(off.codes, 0);
    EXPECT_EQ(off.row, 1);
    EXPECT_EQ(off.column, 9);
    map.texels.at(9, 1).y += 0.9f / 255;
    map.codes = RsrmCodes::Dithered;
    EXPECT_GT(rsrmCodeError(map, {gradient}, rowsOf(map, gradient)).codes, 0);
    EXPECT_LE(rsrmCodeError(map, {gradient, glm::dvec3(0.01)}, rowsOf(map, gradient)).codes, 0) << "an uncertain gradient";
    map.codes = RsrmCodes::Blocks;
    EXPECT_LE(rsrmCodeError(map, {gradient}, rowsOf(map, gradient)).codes, 0);
}

TEST(VerifyRsrm, CodesThatAreCalledDitheredAreDithered) {
    const auto gradient = sky(64);
    CookedRsrm map = quantized(gradient, 256, {1, 16});
    EXPECT_LE(rsrmDitherError(map, {gradient}, rowsOf(map, gradient)).codes, 0) << "it is not called so";
    map.codes = RsrmCodes::Dithered;
    EXPECT_LE(rsrmCodeError(map, {gradient}, rowsOf(map, gradient)).codes, 0) << "texel by texel it could be";
    EXPECT_GT(rsrmDitherError(map, {gradient}, rowsOf(map, gradient)).codes, 0);
    EXPECT_LE(rsrmDitherError(map, {gradient, glm::dvec3(0.5)}, rowsOf(map, gradient)).codes, 0) << "an uncertain gradient";

    for (int y = 0; y < 2; ++y) {
        glm::dvec3 carried(0);
        for (int x = 0; x < 256; ++x) {
            const double z = 1 - (2.0 * x + 1) / 256;
            const glm::dvec3 value = convolvePhong(gradient, map.exponents[static_cast<std::size_t>(y)], z) / glm::dvec3(map.color);
            const glm::dvec3 wanted = 255.0 * value + carried, code = glm::clamp(glm::floor(wanted + 0.5), 0.0, 255.0);
            carried = wanted - code;
            map.texels.at(x, y) = glm::vec4(code / 255.0, 1);
        }
    }
    EXPECT_LE(rsrmDitherError(map, {gradient}, rowsOf(map, gradient)).codes, 0);
    map.texels.at(200, 1).y += 2.0f / 255;
    EXPECT_EQ(rsrmDitherError(map, {gradient}, rowsOf(map, gradient)).row, 1);
}

/// Rounds each channel to a multiple of a step.
void roundTo(CookedRsrm& map, const std::function<glm::dvec3(const glm::vec3&)>& stepOf) {
    for (glm::vec4& texel : map.texels.texels()) {
        const glm::dvec3 step = stepOf(glm::vec3(texel));
        for (int channel = 0; channel < 3; ++channel)
            texel[channel] = static_cast<float>(std::round(static_cast<double>(texel[channel]) / step[channel]) * step[channel]);
    }
}

TEST(VerifyRsrm, CodesOfFloatsAreTheirSteps) {
    const auto gradient = sky(64);
    const auto exact = [&] {
        CookedRsrm map = quantized(gradient, 64, {1, 16});
        for (int y = 0; y < 2; ++y)
            for (int x = 0; x < 64; ++x) {
                const double exponent = map.exponents[static_cast<std::size_t>(y)];
                map.texels.at(x, y) = glm::vec4(convolvePhong(gradient, exponent, 1 - (2.0 * x + 1) / 64), 1);
            }
        map.color = glm::vec3(1);
        return map;
    };
    const auto power = [](float value, int bits) { return std::ldexp(1.0, std::ilogb(value) - bits); };
    CookedRsrm halves = exact();
    roundTo(halves, [&](const glm::vec3& texel) { return glm::dvec3(power(texel.x, 10), power(texel.y, 10), power(texel.z, 10)); });
    halves.codes = RsrmCodes::Halves;
    EXPECT_LE(rsrmCodeError(halves, {gradient}, rowsOf(halves, gradient)).codes, 0);
    for (const float value : {NAN, HUGE_VALF}) {
        CookedRsrm broken = exact();
        broken.codes = RsrmCodes::Halves;
        broken.texels.at(2, 1).y = value;
        EXPECT_GT(rsrmCodeError(broken, {gradient}, rowsOf(broken, gradient)).codes, 1e100);
    }
    EXPECT_NEAR(rsrmCodeSize(halves, {1.5, 0.75, 30}).x, 0x1p-10, 1e-12);
    EXPECT_NEAR(rsrmCodeSize(halves, {1.5, 0.75, 30}).z, 0x1p-6, 1e-12);
    CookedRsrm shared = exact();
    roundTo(shared, [&](const glm::vec3& texel) { return glm::dvec3(power(std::max({texel.x, texel.y, texel.z}), 8)); });
    shared.codes = RsrmCodes::SharedExponent;
    EXPECT_LE(rsrmCodeError(shared, {gradient}, rowsOf(shared, gradient)).codes, 0);
    EXPECT_NEAR(rsrmCodeSize(shared, {1.5, 0.75, 30}).x, 0x1p-4, 1e-12);
    shared.codes = RsrmCodes::Halves;
    EXPECT_GT(rsrmCodeError(shared, {gradient}, rowsOf(shared, gradient)).codes, 0) << "coarser than halves";
    shared.codes = RsrmCodes::SharedExponent;
    shared.texels.at(1, 1).z *= 1.03f;
    const RsrmCodeError off = rsrmCodeError(shared, {gradient}, rowsOf(shared, gradient));
    EXPECT_GT(off.codes, 0);
    EXPECT_EQ(off.column, 1);
}

TEST(VerifyRsrm, AGreyMapIsReadByItsFirstChannel) {
    std::vector<glm::vec3> gradient;
    for (int i = 0; i < 32; ++i) gradient.push_back(static_cast<float>(i) / 31.0f * glm::vec3(4, 2, 0.5f));
    CookedRsrm map = quantized(gradient, 64, {1, 16});
    for (glm::vec4& texel : map.texels.texels()) texel = glm::vec4(texel.x, 0, 0, 1);
    EXPECT_GT(rsrmCodeError(map, {gradient}, rowsOf(map, gradient)).codes, 100);
    map.isGrey = true;
    EXPECT_LE(rsrmCodeError(map, {gradient}, rowsOf(map, gradient)).codes, 0);
}

TEST(VerifyRsrm, TwoMapsBlendAsTheirLightDoes) {
    const auto day = sky(64);
    std::vector<glm::vec3> night;
    for (int i = 0; i < 64; ++i) night.emplace_back(0.01f * static_cast<float>(i % 7), 0.002f, 0.03f);
    const CookedRsrm first = quantized(day, 96, {1, 8, 128}), second = quantized(night, 96, {1, 8, 128});
    double before = 1;
    for (const double weight : {0.0, 0.25, 0.5, 0.99, 1.0}) {
        const RsrmBlend blend = compareRsrmBlend(first, day, second, night, weight);
        EXPECT_LT(blend.codeError, 0.56) << weight;  // half a code of both, and the error of the references
        EXPECT_LT(blend.figures.relRms, 0.05) << weight;
        before = blend.figures.relRms;
    }
    EXPECT_GT(before, 0);
    CookedRsrm wrong = quantized(night, 96, {1, 8, 128});
    wrong.color *= 1.5f;
    EXPECT_GT(compareRsrmBlend(first, day, wrong, night, 0.9).codeError, 3);
}

TEST(VerifyRsrm, BlackIsExact) {
    const std::vector<glm::vec3> black(8, glm::vec3(0));
    const auto stages = verifyAll(quantized(black, 16, {1, 64}), black);
    EXPECT_EQ(stages.back().diffuse.maxSampled, 0);
    EXPECT_EQ(stages.back().specular.relRms, 0);
}

}  // namespace
}  // namespace lightcook::verify
