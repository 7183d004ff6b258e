#include "compress/light_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string_view>

#include "compress/parallel.h"
#include "tests/compress/light_map/synthetic_plan.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using formats::Target;
using synthetic::Kind;
using synthetic::measureOf;
using synthetic::planOf;

TEST(LightMapPlan, SizesFollowFromTheLayout) {
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Halo3, Target::Bc).bitsPerTexel(), 144);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Ratio, Target::Bc).bitsPerTexel(), 72);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Ratio, Target::Astc).bitsPerTexel(), 72);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Sh4, Target::Bc).bitsPerTexel(), 32);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Hdr, Target::Bc).bitsPerTexel(), 72);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Hdr2, Target::Astc).bitsPerTexel(), 144);
    for (const Target target : {Target::Bc, Target::Astc})
        EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::HdrRgb9e5, target).bitsPerTexel(), 288);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Flat, Target::Bc).bitsPerTexel(), 8);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::UnrealHq, Target::Bc).bitsPerTexel(), 16);
    EXPECT_DOUBLE_EQ(planOf(Kind::Gradient, LightMapLayout::Rnm, Target::Bc).bitsPerTexel(), 24);
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

void loopFromTheEnd(std::size_t count, const std::function<void(std::size_t)>& work) {
    for (std::size_t index = count; index-- > 0;) work(index);
}

TEST(LightMapPlan, LoopsOfTheCallerGiveTheSamePlan) {
    const compress::LightMapPlan own = planOf(Kind::Gradient, LightMapLayout::Basis8, Target::Bc);
    compress::setParallelLoop(loopFromTheEnd);
    const compress::LightMapPlan called = planOf(Kind::Gradient, LightMapLayout::Basis8, Target::Bc);
    compress::setParallelLoop(nullptr);
    EXPECT_EQ(called.constants, own.constants);
    EXPECT_EQ(planOf(Kind::Gradient, LightMapLayout::Basis8, Target::Bc).constants, own.constants);
}

/// The cook of a layout takes the tables that a trial learned for a longer one.
TEST(LightMapPlan, AShortenedPlanIsThatOfTheShorterLayout) {
    const formats::LightMapStrip band = synthetic::makeBand(Kind::Gradient, synthetic::kWidth, 0, synthetic::kHeight);
    const compress::LightMapPlan longest = planOf(Kind::Gradient, LightMapLayout::Basis24, Target::Bc);
    for (const LightMapLayout layout : {LightMapLayout::Basis4, LightMapLayout::Basis8, LightMapLayout::Basis20, LightMapLayout::Basis24}) {
        const compress::LightMapPlan shortened = longest.shortenedTo(layout), own = planOf(Kind::Gradient, layout, Target::Bc);
        EXPECT_EQ(shortened.constants, own.constants);
        EXPECT_EQ(shortened.tableTexels(), own.tableTexels());
        EXPECT_EQ(shortened.gpuBytes(), own.gpuBytes());
        EXPECT_EQ(longest.gpuBytesAs(layout), own.gpuBytes());
        const auto encodedBy = [&](const compress::LightMapPlan& plan) {
            return compress::encodeLightMapRows(plan, band, 0, synthetic::kHeight, synthetic::fast()).textures;
        };
        const auto a = encodedBy(shortened), b = encodedBy(own);
        ASSERT_EQ(a.size(), b.size());
        for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].layers, b[i].layers) << formats::info(layout).name << ", texture " << i;
    }
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

/// The engine's black point is a number, but the unit of the luminance follows the map: only the colours know the unit of its light.
TEST(LightMapPlan, ConstantsOfUnrealHqFollowTheUnitOfTheMap) {
    const formats::LightMapStrip band = synthetic::makeBand(Kind::Gradient, synthetic::kWidth, 0, synthetic::kHeight);
    const auto constants = synthetic::planOf(LightMapLayout::UnrealHq, Target::Bc, band, synthetic::fast()).constants;
    for (const float factor : {0x1p-12f, 0x1p10f}) {
        formats::LightMapStrip other = synthetic::makeBand(Kind::Gradient, synthetic::kWidth, 0, synthetic::kHeight);
        for (lighting::ShRgb& sh : other.sh.texels())
            for (glm::vec3& coefficient : sh) coefficient *= factor;
        const auto scaled = synthetic::planOf(LightMapLayout::UnrealHq, Target::Bc, other, synthetic::fast()).constants;
        for (const char* name : {"scale0", "add0", "scale1", "add1"})
            for (std::size_t i = 0; i < 4; ++i) {
                const bool isColor = std::string_view(name).ends_with('0') && i < 3;
                EXPECT_EQ(scaled.at(name)[i], (isColor ? factor : 1) * constants.at(name)[i]) << name << ' ' << i;
            }
    }
    // Black shows nothing, whatever the textures hold; light from everywhere needs no texture.
    const auto black = planOf(Kind::Black, LightMapLayout::UnrealHq, Target::Bc).constants,
               grey = planOf(Kind::Grey, LightMapLayout::UnrealHq, Target::Bc).constants;
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(black.at("scale0")[i], 0);
        EXPECT_EQ(black.at("add0")[i], 0);
    }
    EXPECT_EQ(grey.at("scale0")[3], 0);
    EXPECT_NEAR((std::exp2(grey.at("add0")[3]) - 0.01858136f) * grey.at("add0")[1] * grey.at("add1")[3], 0.5f, 1e-5f);
}

}  // namespace
}  // namespace lightcook
