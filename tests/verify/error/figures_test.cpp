#include "verify/figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "lighting/radiometry.h"

namespace lightcook::verify {
namespace {

struct Samples {
    std::vector<float> reference, error;
};

Samples makeSamples(int count, unsigned seed) {
    std::mt19937 random(seed);
    std::lognormal_distribution<float> light(0, 2), relative(-4, 3);
    Samples samples;
    for (int i = 0; i < count; ++i) {
        samples.reference.push_back(light(random) * (random() % 16 == 0 ? -1.0f : 1.0f));
        samples.error.push_back(random() % 5 == 0 ? 0.0f : samples.reference.back() * relative(random));
    }
    return samples;
}

TEST(ErrorAccumulator, FiguresAreThoseOfTheSortedSamples) {
    for (const double key : {0.0, 0.7})
        for (const int count : {1, 7, 99, 100, 101, 5000}) {
            const Samples samples = makeSamples(count, static_cast<unsigned>(count));
            ErrorAccumulator accumulator(key);
            std::vector<double> locals;
            double squaredError = 0, squaredReference = 0;
            for (std::size_t i = 0; i < samples.reference.size(); ++i) {
                const double reference = samples.reference[i], result = reference + samples.error[i];
                accumulator.add(reference, result);
                const double error = std::abs(result - reference);
                locals.push_back(error == 0 ? 0 : error / (std::abs(reference) + lighting::kLocalErrorFloor * key));
                squaredError += error * error;
                squaredReference += reference * reference;
            }
            std::sort(locals.begin(), locals.end());
            const double quantile = locals[static_cast<std::size_t>(std::ceil(0.99 * count)) - 1];
            const ErrorFigures figures = accumulator.figures();
            EXPECT_EQ(accumulator.sampleCount(), count);
            EXPECT_NEAR(figures.relRms, std::sqrt(squaredError / squaredReference), 1e-12 * figures.relRms);
            EXPECT_EQ(figures.maxSampled, locals.back());
            EXPECT_GE(figures.p99, quantile);
            EXPECT_LE(figures.p99, quantile * (1 + 1.0 / 256) + 1e-12);
            EXPECT_LE(figures.p99, figures.maxSampled);
        }
}

TEST(ErrorAccumulator, BatchesAndMergesGiveTheFiguresOfSingleSamples) {
    const Samples samples = makeSamples(10000, 3);
    ErrorAccumulator single(0.5), batch(0.5), merged(0.5);
    for (std::size_t i = 0; i < samples.reference.size(); ++i)
        single.add(samples.reference[i], static_cast<double>(samples.reference[i]) + static_cast<double>(samples.error[i]));
    batch.addErrors(samples.reference, samples.error);
    for (std::size_t first = 0; first < 10000; first += 2500) {
        ErrorAccumulator part(0.5);
        part.addErrors(std::span(samples.reference).subspan(first, 2500), std::span(samples.error).subspan(first, 2500));
        part.addBound(static_cast<double>(first));
        merged.merge(part);
    }
    for (const ErrorAccumulator& other : {batch, merged}) {
        EXPECT_EQ(other.sampleCount(), 10000);
        EXPECT_NEAR(other.figures().relRms, single.figures().relRms, 1e-9 * single.figures().relRms);
        EXPECT_NEAR(other.figures().p99, single.figures().p99, 1e-9);
        EXPECT_NEAR(other.figures().maxSampled, single.figures().maxSampled, 1e-6 * single.figures().maxSampled);
    }
    EXPECT_EQ(merged.figures().maxBound, 7500);
}

TEST(ErrorAccumulator, NothingAndNoErrorAreZero) {
    EXPECT_EQ(ErrorAccumulator().figures().relRms, 0);
    ErrorAccumulator black;
    for (int i = 0; i < 200; ++i) black.add(0, 0);
    EXPECT_EQ(black.figures().relRms, 0);
    EXPECT_EQ(black.figures().p99, 0);
    EXPECT_EQ(black.figures().maxSampled, 0);
}

TEST(ErrorAccumulator, DarkSamplesCountLikeOthers) {
    const Samples samples = makeSamples(500, 3);
    ErrorAccumulator dark(1), zeros(1);
    dark.addErrors(samples.reference, samples.error);
    zeros.addErrors(samples.reference, samples.error);
    dark.addDark(1500);
    for (int i = 0; i < 1500; ++i) zeros.add(0, 0);
    EXPECT_EQ(dark.sampleCount(), 2000);
    EXPECT_EQ(dark.figures().relRms, zeros.figures().relRms);
    EXPECT_EQ(dark.figures().p99, zeros.figures().p99);
    EXPECT_EQ(dark.referenceRms(), zeros.referenceRms());
}

/// Reference plus floor beyond all floats would make every local error 0.
TEST(ErrorAccumulator, ALocalErrorOfTheLargestLightIsNotLost) {
    ErrorAccumulator errors(3e38);
    errors.addErrors(std::vector<float>{3.4e38f}, std::vector<float>{-3.4e38f});
    EXPECT_NEAR(errors.figures().maxSampled, 1, 0.02);
}

/// An infinite reference would make every relative error 0.
TEST(ErrorAccumulator, AnInfiniteReferenceExceedsEveryLimit) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    ErrorAccumulator errors(1);
    const std::vector<float> references = {1.0f, kInfinity}, wrong = {0.01f, std::numeric_limits<float>::quiet_NaN()};
    errors.addErrors(references, wrong);
    EXPECT_EQ(errors.figures().relRms, std::numeric_limits<double>::max());
    ErrorAccumulator lost(1);
    lost.addErrors(std::vector<float>{kInfinity}, std::vector<float>{1.0f});
    EXPECT_EQ(lost.figures().relRms, std::numeric_limits<double>::max());
}

/// A NaN figure would be below every limit.
TEST(ErrorAccumulator, ANonFiniteErrorExceedsEveryLimit) {
    for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        ErrorAccumulator single(1), batch(1);
        single.add(1, wrong);
        single.addBound(wrong);
        const float reference = 1, error = static_cast<float>(wrong);
        batch.addErrors(std::span(&reference, 1), std::span(&error, 1));
        for (const ErrorAccumulator& accumulator : {single, batch}) {
            EXPECT_GT(accumulator.figures().relRms, 1e100);
            EXPECT_GT(accumulator.figures().p99, 1e100);
            EXPECT_GT(accumulator.figures().maxSampled, 1e100);
        }
        EXPECT_GT(single.figures().maxBound, 1e100);
    }
    ErrorAccumulator nothing;
    nothing.add(0, 1e-300);
    EXPECT_GT(nothing.figures().maxSampled, 1e100);  // light in place of black
}

TEST(ErrorAccumulator, ReferenceRmsIsTheDenominatorOfRelRms) {
    EXPECT_EQ(ErrorAccumulator().referenceRms(), 0);
    ErrorAccumulator first(1), second(1);
    first.add(3, 3.1);
    first.add(-4, -4);
    EXPECT_NEAR(first.referenceRms(), std::sqrt(12.5), 1e-14);
    second.addErrors(std::vector<float>{1, 2}, std::vector<float>{0.5f, 0});
    first.merge(second);
    EXPECT_NEAR(first.referenceRms(), std::sqrt(30.0 / 4), 1e-14);
    EXPECT_NEAR(first.figures().relRms * first.referenceRms(), std::sqrt((0.01 + 0.25) / 4), 1e-9);
}

}  // namespace
}  // namespace lightcook::verify
