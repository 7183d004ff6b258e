#include "compress/light_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "lighting/radiometry.h"
#include "tests/compress/light_map/synthetic_plan.h"

namespace lightcook {
namespace {

using synthetic::kHeight;
using synthetic::Kind;
using synthetic::kWidth;
using synthetic::measureOf;

TEST(LightMapMeasure, DoesNotDependOnTheCutNorOnTexelsOutsideCharts) {
    const compress::LightMapMeasure whole = measureOf(Kind::Gradient);
    compress::LightMapMeasure merged;
    for (const int row : {24, 0, 12, 36}) {
        compress::LightMapMeasure part;
        const int count = std::min(12, kHeight - row);
        part.add(synthetic::makeBandWithContext(Kind::Gradient, kWidth, kHeight, row, count, 2, 1e9f), row, count);
        merged.merge(part);
    }
    EXPECT_EQ(merged.key(), whole.key());
    EXPECT_EQ(merged.coveredTexels(), whole.coveredTexels());
    EXPECT_EQ(merged.maximumExit(), whole.maximumExit());
    for (int i = 0; i < lighting::kShCount; ++i) {
        EXPECT_EQ(merged.maximumAbsolute(i), whole.maximumAbsolute(i));
        EXPECT_EQ(merged.minimumRatio(i), whole.minimumRatio(i));
        EXPECT_EQ(merged.maximumRatio(i), whole.maximumRatio(i));
    }
    for (const float least : {0.0f, 0.5f * static_cast<float>(whole.key())}) {
        const compress::SharedExitRange found = merged.sharedExitRange(least), expected = whole.sharedExitRange(least);
        EXPECT_EQ(found.lowestLight, expected.lowestLight);
        EXPECT_EQ(found.highestLight, expected.highestLight);
        EXPECT_EQ(found.lowestChroma, expected.lowestChroma);
        EXPECT_EQ(found.highestChroma, expected.highestChroma);
        EXPECT_EQ(found.lowestSlope, expected.lowestSlope);
        EXPECT_EQ(found.highestSlope, expected.highestSlope);
    }
}

/// Ranges of colours and slopes are those of the texels that are bright enough, and light is that of all.
TEST(LightMapMeasure, DarkTexelsDoNotWidenTheRangesOfBrighterOnes) {
    formats::LightMapStrip band = synthetic::makeBand(Kind::Grey, kWidth, 0, kHeight);
    band.sh.at(20, 20) = synthetic::constantLight(glm::vec3(0.001f, 0, 0));
    band.covered.at(20, 20) = 1;
    compress::LightMapMeasure measure;
    measure.add(band);
    const compress::SharedExitRange all = measure.sharedExitRange(0), bright = measure.sharedExitRange(0.25f);
    EXPECT_NEAR(all.lowestLight, 0.001f, 1e-6f);
    EXPECT_NEAR(all.highestLight, 0.5f, 1e-6f);
    EXPECT_NEAR(all.lowestChroma.y, 0, 1e-6f);
    EXPECT_NEAR(bright.lowestChroma.y, 1, 1e-6f);
    EXPECT_NEAR(bright.highestChroma.y, 1, 1e-6f);
    EXPECT_NEAR(glm::length(bright.highestSlope), 0, 1e-6f);
    EXPECT_TRUE(measure.sharedExitRange(2).isEmpty());
}

TEST(LightMapMeasure, KeyIsTheLogAverageOfExitLuminance) {
    const formats::LightMapStrip band = synthetic::makeBand(Kind::Gradient, kWidth, 0, kHeight);
    double sum = 0;
    int count = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            if (band.covered.at(x, y) == 0) continue;
            const glm::vec3 exit = lighting::lambertExitRadiance(band.sh.at(x, y), band.normal.at(x, y), glm::vec3(1)).value;
            sum += std::log(std::max(static_cast<double>(glm::dot(exit, lighting::kRec709Luminance)), 1e-12));
            ++count;
        }
    EXPECT_NEAR(measureOf(Kind::Gradient).key(), std::exp(sum / count), 1e-6 * std::exp(sum / count));
    EXPECT_NEAR(measureOf(Kind::Grey).key(), 0.5, 1e-6);
    EXPECT_NEAR(measureOf(Kind::Black).key(), 1e-12, 1e-18);
    EXPECT_EQ(compress::LightMapMeasure().key(), 0);
}

TEST(LightMapMeasure, RatiosOfNonNegativeLightKeepTheirBoundsAndOthersAreCounted) {
    const compress::LightMapMeasure light = measureOf(Kind::Gradient);
    EXPECT_EQ(light.beyondPositiveBounds(), 0);
    for (int i = 1; i < lighting::kShCount; ++i) {
        const float bound = i < 4 ? std::sqrt(3.0f) : std::sqrt(5.0f);
        EXPECT_LE(light.maximumRatio(i), bound * 1.0001f);
        EXPECT_GE(light.minimumRatio(i), -bound * 1.0001f);
    }
    EXPECT_GT(measureOf(Kind::NegativeBands).beyondPositiveBounds(), 100);
}

}  // namespace
}  // namespace lightcook
