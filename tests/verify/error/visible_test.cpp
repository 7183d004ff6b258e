#include "verify/visible.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace lightcook::verify {
namespace {

constexpr std::size_t kSamples = 16;

/// Returns the differences of two batches of light, as DisplayTransform computes them.
std::vector<float> differencesOf(const DisplayTransform& transform, const std::vector<glm::dvec3>& reference,
                                 const std::vector<glm::dvec3>& found) {
    const auto shown = [&](const std::vector<glm::dvec3>& light) {
        std::vector<float> rgb(3 * kSamples), itp(3 * kSamples);
        for (std::size_t k = 0; k < light.size(); ++k)
            for (std::size_t c = 0; c < 3; ++c) rgb[c * kSamples + k] = static_cast<float>(light[k][static_cast<int>(c)]);
        transform.apply(rgb.data(), kSamples, itp.data());
        return itp;
    };
    std::vector<float> differences(kSamples);
    visibleDifferences(shown(reference).data(), shown(found).data(), kSamples, differences.data());
    return differences;
}

TEST(DisplayTransform, AgreesWithTheFormula) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> exponent(-14, 9), change(-1, 1);
    for (const double black : {lighting::kLeastBlack, 0.5, 5.0})
        for (const double unit : {1.0, 0.01, 300.0}) {
            lighting::DisplaySettings settings;
            settings.black = black;
            const Viewing viewing{settings.of(unit)};  // samples are in units of the key
            const DisplayTransform transform(viewing, unit);
            double largest = 0;
            for (int round = 0; round < 300; ++round) {
                std::vector<glm::dvec3> reference(kSamples), found(kSamples);
                for (std::size_t k = 0; k < kSamples; ++k)
                    for (int c = 0; c < 3; ++c) {
                        reference[k][c] = static_cast<float>(std::exp2(exponent(random)));
                        found[k][c] = static_cast<float>(reference[k][c] * (1 + std::pow(change(random), 3)));
                    }
                const std::vector<float> differences = differencesOf(transform, reference, found);
                for (std::size_t k = 0; k < kSamples; ++k) {
                    const double expected = lighting::visibleDifference(unit * reference[k], unit * found[k], viewing.display);
                    EXPECT_NEAR(static_cast<double>(differences[k]), expected, 0.002 + 2e-4 * expected);
                    largest = std::max(largest, expected);
                }
            }
            EXPECT_GT(largest, 20);
        }
}

TEST(DisplayTransform, TheLargestFloatsAreFinite) {
    const std::vector<glm::dvec3> light(kSamples, glm::dvec3(3.4e38));
    for (const float difference : differencesOf(DisplayTransform({}, 1), light, light)) EXPECT_EQ(difference, 0);
}

TEST(DisplayTransform, WhatIsNotFiniteIsTheLargest) {
    const DisplayTransform transform({}, 1);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const std::vector<glm::dvec3> one(kSamples, glm::dvec3(1));
    for (const double bad : {std::nan(""), kInfinity, -kInfinity})
        for (int c = 0; c < 3; ++c) {
            std::vector<glm::dvec3> found = one;
            found[3][c] = bad;
            const std::vector<float> differences = differencesOf(transform, one, found);
            EXPECT_EQ(differences[3], std::numeric_limits<float>::max());
            EXPECT_EQ(differences[2], 0);
        }
    std::vector<glm::dvec3> negative = one, none = one;
    negative[0] = {-3, 1, 1};
    none[0] = {0, 1, 1};
    EXPECT_EQ(differencesOf(transform, negative, none)[0], 0);
}

TEST(VisibleAccumulator, FiguresAreThoseOfTheSortedSamples) {
    std::mt19937 random(2);
    std::lognormal_distribution<float> distribution(0, 1.5f);
    std::vector<float> samples(20011);
    for (float& sample : samples) sample = distribution(random);
    VisibleAccumulator whole, first, second;
    whole.add(samples);
    first.add(std::span(samples).first(777));
    second.add(std::span(samples).subspan(777));
    first.merge(second);
    std::ranges::sort(samples);
    const auto quantile = [&](double share) {
        return static_cast<double>(samples[static_cast<std::size_t>(share * static_cast<double>(samples.size() - 1))]);
    };
    const VisibleFigures figures = whole.figures();
    EXPECT_NEAR(figures.p50, quantile(0.5), 0.005 * figures.p50);
    EXPECT_NEAR(figures.p95, quantile(0.95), 0.005 * figures.p95);
    EXPECT_NEAR(figures.p99, quantile(0.99), 0.01 * figures.p99);
    EXPECT_NEAR(figures.p999, quantile(0.999), 0.02 * figures.p999);
    EXPECT_EQ(figures.max, static_cast<double>(samples.back()));
    double squares = 0;
    for (const float sample : samples) squares += static_cast<double>(sample) * static_cast<double>(sample);
    EXPECT_NEAR(figures.rms, std::sqrt(squares / static_cast<double>(samples.size())), 1e-9);
    EXPECT_EQ(first.figures().p99, figures.p99);
    EXPECT_EQ(first.figures().max, figures.max);
}

TEST(VisibleAccumulator, HistogramCountsOctaves) {
    std::mt19937 random(3);
    std::lognormal_distribution<float> distribution(1, 2.5f);
    std::vector<float> samples(5000);
    for (float& sample : samples) sample = distribution(random);
    for (const float edge : {0.0f, 0.125f, 1.0f, 256.0f, 511.9f, 512.0f, 1e9f, std::numeric_limits<float>::max()}) samples.push_back(edge);
    VisibleAccumulator accumulator;
    accumulator.add(samples);
    std::vector<std::int64_t> expected(14);
    for (const float sample : samples) {
        std::size_t octave = 0;
        while (octave < 13 && sample >= std::ldexp(0.125f, static_cast<int>(octave))) ++octave;
        ++expected[octave];
    }
    EXPECT_EQ(accumulator.figures().histogram, expected);
    EXPECT_TRUE(VisibleAccumulator().figures().histogram.empty());
}

TEST(VisibleAccumulator, AnExactAssetHasNoError) {
    VisibleAccumulator accumulator;
    EXPECT_EQ(accumulator.figures().max, 0);
    const std::vector<float> zeros(100);
    accumulator.add(zeros);
    accumulator.addExact(50);
    EXPECT_EQ(accumulator.sampleCount(), 150);
    const VisibleFigures figures = accumulator.figures();
    EXPECT_EQ(figures.p999, 0);
    EXPECT_EQ(figures.max, 0);
    EXPECT_EQ(figures.rms, 0);
}

TEST(VisibleAccumulator, ABoundOfZeroIsKnown) {
    const float zero = 0;
    VisibleAccumulator without, exact;
    without.add({&zero, 1});
    exact.add({&zero, 1});
    exact.addBound(0, {});
    EXPECT_FALSE(without.figures().bound.has_value());
    EXPECT_EQ(exact.figures().bound, 0.0);
    without.merge(exact);
    EXPECT_EQ(without.figures().bound, 0.0);
    exact.addBound(std::numeric_limits<double>::quiet_NaN(), {});
    exact.addBound(2, {});
    exact.addBound(1, {});
    EXPECT_EQ(exact.figures().bound, 2.0);
}

TEST(VisibleAccumulator, OneSampleThatIsNotFiniteShows) {
    VisibleAccumulator accumulator;
    std::vector<float> samples(99, 1.0f);
    samples.push_back(std::numeric_limits<float>::max());
    accumulator.add(samples);
    EXPECT_EQ(accumulator.figures().max, static_cast<double>(std::numeric_limits<float>::max()));
}

}  // namespace
}  // namespace lightcook::verify
