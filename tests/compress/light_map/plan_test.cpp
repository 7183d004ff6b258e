#include "compress/light_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "lighting/radiometry.h"
#include "tests/compress/light_map_plan.h"
#include "tests/compress/synthetic_light_map.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using formats::Target;
using synthetic::Kind;

constexpr int kWidth = 46, kHeight = 38;  // not multiples of a block

compress::LightMapMeasure measureOf(Kind kind) {
    compress::LightMapMeasure measure;
    measure.add(synthetic::makeBand(kind, kWidth, 0, kHeight));
    return measure;
}

compress::LightMapPlan planOf(Kind kind, LightMapLayout layout, Target target) {
    compress::EncodeOptions options;
    options.effort = 1;
    return synthetic::planOf(layout, target, synthetic::makeBand(kind, kWidth, 0, kHeight), options);
}

compress::EncodeOptions fast() {
    compress::EncodeOptions options;
    options.effort = 1;
    return options;
}

/// All layers of all textures one after the other, encoded in bands of bandRows.
std::vector<std::vector<std::byte>> encode(Kind kind, const compress::LightMapPlan& plan, int bandRows, float outside = 0,
                                           compress::EncodeReport* report = nullptr) {
    std::vector<std::vector<std::byte>> layers;
    for (int row = 0; row < kHeight; row += bandRows) {
        const int count = std::min(bandRows, kHeight - row);
        const formats::LightMapStrip band =
            synthetic::makeBandWithContext(kind, kWidth, kHeight, row, count, compress::kLightMapPaddingRows, outside);
        const compress::EncodedLightMapRows rows = compress::encodeLightMapRows(plan, band, row, count, fast());
        if (report != nullptr) report->add(rows.report);
        std::size_t next = 0;
        for (const auto& texture : rows.textures)
            for (const auto& bytes : texture.layers) {
                if (layers.size() <= next) layers.emplace_back();
                layers[next].insert(layers[next].end(), bytes.begin(), bytes.end());
                ++next;
            }
    }
    return layers;
}

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
    EXPECT_EQ(merged.maximumIntensity(), whole.maximumIntensity());
    EXPECT_EQ(merged.minimumZonal(), whole.minimumZonal());
    EXPECT_EQ(merged.maximumZonal(), whole.maximumZonal());
    EXPECT_GT(whole.maximumZonal(), 0);
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

TEST(LightMapPlan, SizesAreThoseOfTheLayouts) {
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Luvw, Target::Bc).bitsPerTexel(), 144);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Ratio, Target::Bc).bitsPerTexel(), 72);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Ratio, Target::Astc).bitsPerTexel(), 72);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::LuvwLinear, Target::Bc).bitsPerTexel(), 80);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Zh3, Target::Bc).bitsPerTexel(), 40);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Flat, Target::Bc).bitsPerTexel(), 8);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Raw, Target::Float).bitsPerTexel(), 576);
    const compress::LightMapPlan ratio = planOf(Kind::Gradient, LightMapLayout::Ratio, Target::Bc);
    EXPECT_EQ(ratio.gpuBytes(), 9u * 12 * 10 * 16);
    EXPECT_EQ(ratio.blockHeight(), 4);
}

TEST(LightMapPlan, HalfRangesUseTheUpperOctavesInAnyUnit) {
    for (const Kind kind : {Kind::Gradient, Kind::Night, Kind::Spikes}) {
        const compress::LightMapMeasure measure = measureOf(kind);
        const float range = planOf(kind, LightMapLayout::Ratio, Target::Bc).constants.at("range")[0];
        EXPECT_GT(measure.maximumAbsolute(0) / range, 8192);
        EXPECT_LE(measure.maximumAbsolute(0) / range, 16384);
        EXPECT_EQ(std::exp2(std::round(std::log2(range))), range);
    }
    EXPECT_EQ(planOf(Kind::Black, LightMapLayout::Ratio, Target::Bc).constants.at("range")[0], 1);
}

TEST(EncodeLightMap, CutsBetweenBlockRowsGiveTheSameBytes) {
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts())
        for (const Target target : {Target::Bc, Target::Astc, Target::Float}) {
            const compress::LightMapPlan plan = planOf(Kind::Gradient, layout.id, target);
            const auto whole = encode(Kind::Gradient, plan, kHeight);
            std::size_t bytes = 0;
            for (const auto& layer : whole) bytes += layer.size();
            EXPECT_EQ(bytes + plan.tableBytes(), plan.gpuBytes());
            EXPECT_EQ(encode(Kind::Gradient, plan, 4), whole) << layout.name;
            EXPECT_EQ(encode(Kind::Gradient, plan, 16), whole) << layout.name;
        }
}

TEST(EncodeLightMap, TexelsOutsideChartsAreNeverLookedAt) {
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts()) {
        const compress::LightMapPlan plan = planOf(Kind::Gradient, layout.id, Target::Bc);
        EXPECT_EQ(encode(Kind::Gradient, plan, kHeight, 1e9f), encode(Kind::Gradient, plan, kHeight, -1));
    }
}

TEST(EncodeLightMap, WhatDoesNotFitIsCounted) {
    compress::EncodeReport fits, ratios;
    encode(Kind::Gradient, planOf(Kind::Gradient, LightMapLayout::Luvw, Target::Bc), kHeight, 0, &fits);
    EXPECT_EQ(fits.clampedHigh + fits.clampedNegative, 0);
    encode(Kind::NegativeBands, planOf(Kind::NegativeBands, LightMapLayout::Ratio, Target::Bc), kHeight, 0, &ratios);
    EXPECT_GT(ratios.clampedHigh, 0);
    EXPECT_GT(ratios.clampedNegative, 0);

    // A negative exit radiance has no place in unsigned BC6H, but a half holds it.
    compress::EncodeReport flat, half;
    encode(Kind::NegativeBands, planOf(Kind::NegativeBands, LightMapLayout::Flat, Target::Bc), kHeight, 0, &flat);
    encode(Kind::NegativeBands, planOf(Kind::NegativeBands, LightMapLayout::Flat, Target::Float), kHeight, 0, &half);
    EXPECT_GT(flat.clampedNegative, 0);
    EXPECT_EQ(half.clampedNegative, 0);
}

}  // namespace
}  // namespace lightcook
