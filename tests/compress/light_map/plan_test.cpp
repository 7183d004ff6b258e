#include "compress/light_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/compress/light_map/synthetic_plan.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using formats::Target;
using synthetic::Kind;
using synthetic::measureOf;
using synthetic::planOf;

TEST(LightMapPlan, SizesFollowFromTheLayout) {
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Luvw, Target::Bc).bitsPerTexel(), 144);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Ratio, Target::Bc).bitsPerTexel(), 72);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Ratio, Target::Astc).bitsPerTexel(), 72);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::LuvwLinear, Target::Bc).bitsPerTexel(), 80);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Zh3, Target::Bc).bitsPerTexel(), 40);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Sh4, Target::Bc).bitsPerTexel(), 32);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Hdr, Target::Bc).bitsPerTexel(), 72);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Hdr2, Target::Astc).bitsPerTexel(), 144);
    for (const Target target : {Target::Bc, Target::Astc})
        EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::HdrRgb9e5, target).bitsPerTexel(), 288);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Flat, Target::Bc).bitsPerTexel(), 8);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Raw, Target::Float).bitsPerTexel(), 576);
    const compress::LightMapPlan ratio = planOf(Kind::Gradient, LightMapLayout::Ratio, Target::Bc);
    EXPECT_EQ(ratio.gpuBytes(), 9u * 12 * 10 * 16);
    EXPECT_EQ(ratio.blockHeight(), 4);
}

TEST(LightMapPlan, BytesOfAShorterLayoutAreThoseOfItsOwnPlan) {
    for (const Target target : {Target::Bc, Target::Astc, Target::Float})
        EXPECT_EQ(planOf(Kind::Gradient, LightMapLayout::Hdr2, target).gpuBytesAs(LightMapLayout::Hdr),
                  planOf(Kind::Gradient, LightMapLayout::Hdr, target).gpuBytes());
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

}  // namespace
}  // namespace lightcook
