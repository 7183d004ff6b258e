#include "compress/light_map.h"
#include "compress/light_map_context.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/compress/light_map/synthetic_plan.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using formats::Target;
using synthetic::fast;
using synthetic::kHeight;
using synthetic::Kind;
using synthetic::kWidth;
using synthetic::planOf;

/// Returns all layers of all textures, one after the other, encoded in strips of stripRows.
std::vector<std::vector<std::byte>> encode(Kind kind, const compress::LightMapPlan& plan, int stripRows, float outside = 0,
                                           compress::EncodeReport* report = nullptr) {
    std::vector<std::vector<std::byte>> layers;
    for (int row = 0; row < kHeight; row += stripRows) {
        const int count = std::min(stripRows, kHeight - row);
        const formats::LightMapStrip band = synthetic::makeBandWithContext(kind, kWidth, kHeight, row, count, plan.contextRows(), outside);
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

TEST(EncodeLightMapSoak, CutsBetweenBlockRowsGiveTheSameBytes) {
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts())
        for (const Target target : {Target::Bc, Target::Astc, Target::Float}) {
            const compress::LightMapPlan plan = planOf(Kind::Gradient, layout.id, target);
            const auto whole = encode(Kind::Gradient, plan, kHeight);
            std::size_t bytes = 0;
            for (const auto& layer : whole) bytes += layer.size();
            EXPECT_EQ(bytes + plan.tableBytes() + plan.indexBytes() + plan.coverageBytes(), plan.gpuBytes());
            EXPECT_EQ(encode(Kind::Gradient, plan, std::max(4, plan.blockHeight())), whole) << layout.name;
            EXPECT_EQ(encode(Kind::Gradient, plan, 16), whole) << layout.name;
        }
}

TEST(EncodeLightMap, TexelsOutsideChartsHaveNoEffect) {
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts()) {
        const compress::LightMapPlan plan = planOf(Kind::Gradient, layout.id, Target::Bc);
        EXPECT_EQ(encode(Kind::Gradient, plan, kHeight, 1e9f), encode(Kind::Gradient, plan, kHeight, -1));
    }
}

/// "auto" takes the error of hdr from the first stage of hdr-2.
TEST(EncodeLightMap, TheFirstTextureOfHdr2IsHdr) {
    for (const Kind kind : {Kind::Gradient, Kind::Night, Kind::Spikes}) {
        const compress::LightMapPlan one = planOf(kind, LightMapLayout::Hdr, Target::Bc),
                                     two = planOf(kind, LightMapLayout::Hdr2, Target::Bc);
        EXPECT_EQ(one.constants.at("range"), two.constants.at("range"));
        EXPECT_EQ(one.constants.at("bias"), two.constants.at("bias"));
        auto layers = encode(kind, two, kHeight);
        layers.resize(9);
        EXPECT_EQ(encode(kind, one, kHeight), layers);
    }
}

TEST(EncodeLightMap, TheFirstTextureOfFlat2IsFlat) {
    for (const Kind kind : {Kind::Gradient, Kind::Night, Kind::Spikes})
        for (const Target target : {Target::Bc, Target::Astc, Target::Float}) {
            auto layers = encode(kind, planOf(kind, LightMapLayout::Flat2, target), kHeight);
            ASSERT_EQ(layers.size(), 2u);
            layers.resize(1);
            EXPECT_EQ(encode(kind, planOf(kind, LightMapLayout::Flat, target), kHeight), layers);
        }
}

TEST(EncodeLightMap, ValuesThatDoNotFitAreCounted) {
    compress::EncodeReport fits, ratios;
    encode(Kind::Gradient, planOf(Kind::Gradient, LightMapLayout::Halo3, Target::Bc), kHeight, 0, &fits);
    EXPECT_EQ(fits.clampedHigh + fits.clampedNegative, 0);
    encode(Kind::NegativeBands, planOf(Kind::NegativeBands, LightMapLayout::Ratio, Target::Bc), kHeight, 0, &ratios);
    EXPECT_GT(ratios.clampedHigh, 0);
    EXPECT_GT(ratios.clampedNegative, 0);

    // Unsigned BC6H cannot hold a negative exit radiance; a half can.
    compress::EncodeReport flat, half;
    encode(Kind::NegativeBands, planOf(Kind::NegativeBands, LightMapLayout::Flat, Target::Bc), kHeight, 0, &flat);
    encode(Kind::NegativeBands, planOf(Kind::NegativeBands, LightMapLayout::Flat, Target::Float), kHeight, 0, &half);
    EXPECT_GT(flat.clampedNegative, 0);
    EXPECT_EQ(half.clampedNegative, 0);
}

}  // namespace
}  // namespace lightcook
