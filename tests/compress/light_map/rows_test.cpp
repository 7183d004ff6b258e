#include "compress/light_map/rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

namespace lightcook::compress {
namespace {

constexpr float kFirstRing = 0x1p-8f, kSolvedRing = 0x1p-9f, kSecondRing = 0x1p-16f;

rows::Source sourceOf(int width, int height) {
    rows::Source source;
    source.width = width;
    source.height = height;
    source.values.emplace_back(width, height, glm::vec3(0));
    source.coverage = formats::Image<float>(width, height, 0);
    source.importance = formats::Image<float>(width, height, 0);
    return source;
}

void set(rows::Source& source, int x, int y, float light, float coverage) {
    source.values[0].at(x, y) = glm::vec3(light);
    source.coverage.at(x, y) = source.importance.at(x, y) = coverage;
}

/// Padding of the second ring loses its weight beside light that is more than 8 times away, and only in the same block.
TEST(DropFarPadding, TakesTheWeightOfTheSecondRingAlone) {
    rows::Source source = sourceOf(8, 4);
    set(source, 0, 0, 1000, 1);
    set(source, 1, 0, 900, kFirstRing);
    set(source, 2, 0, 0.01f, kFirstRing);   // beside a dark chart: a filter reads it
    set(source, 3, 0, 0.01f, kSolvedRing);  // solved for the filter, in a layout that divides by coefficient 0
    set(source, 0, 3, 0.01f, kSecondRing);
    set(source, 1, 3, 130, kSecondRing);
    set(source, 2, 3, 120, kSecondRing);
    set(source, 3, 3, 9000, kSecondRing);
    set(source, 4, 3, 0.01f, kSecondRing);  // a block that holds nothing nearer
    rows::dropFarPadding(source, 4);
    EXPECT_EQ(source.coverage.at(0, 0), 1);
    EXPECT_EQ(source.coverage.at(1, 0), kFirstRing);
    EXPECT_EQ(source.coverage.at(2, 0), kFirstRing);
    EXPECT_EQ(source.coverage.at(3, 0), kSolvedRing);
    EXPECT_EQ(source.coverage.at(0, 3), 0);
    EXPECT_EQ(source.importance.at(0, 3), 0);
    EXPECT_EQ(source.coverage.at(1, 3), kSecondRing);
    EXPECT_EQ(source.coverage.at(2, 3), 0);
    EXPECT_EQ(source.coverage.at(3, 3), 0);
    EXPECT_EQ(source.coverage.at(4, 3), kSecondRing);
}

/// Effort 0 does not find the range of every block of large corrections. Those blocks decode to the first texture alone.
TEST(EncodeSecond, NoBlockIsWorseThanTheFirstTextureAlone) {
    constexpr int kSide = 64, kBlock = 4;
    constexpr formats::PixelFormat kFormat = formats::PixelFormat::Bc6hUf16;
    std::mt19937 random(5);
    const auto fraction = [&] { return static_cast<float>(random()) * 0x1p-32f; };
    rows::Source source = sourceOf(kSide, kSide);
    formats::Image<glm::vec4> wanted(kSide, kSide);
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            set(source, x, y, 1, 1);
            wanted.at(x, y) = glm::vec4(std::exp(fraction()), std::exp(fraction()), std::exp(fraction()), 1);
        }
    LightMapPlan plan;
    plan.textures = {{"sh", kFormat, 1}, {"second", kFormat, 1}};
    plan.constants["share"] = {rows::kSecondShare};
    EncodeOptions options;
    options.effort = 0;
    EncodeReport report;
    formats::Image<glm::vec4> texels = wanted.copy();
    const rows::Layer first = rows::encodeLayer(kFormat, texels, rows::linearSignificance(source), options, true, report);
    const rows::Layer second = rows::encodeSecond(plan, source, wanted, first.bytes, first.decoded, options, report);
    int kept = 0, better = 0;
    for (int top = 0; top < kSide; top += kBlock)
        for (int left = 0; left < kSide; left += kBlock) {
            float alone = 0, mixed = 0;
            for (int y = top; y < top + kBlock; ++y)
                for (int x = left; x < left + kBlock; ++x) {
                    const glm::vec4 without = first.decoded.at(x, y), with = glm::mix(without, second.decoded.at(x, y), rows::kSecondShare);
                    alone += glm::dot(without - wanted.at(x, y), without - wanted.at(x, y));
                    mixed += glm::dot(with - wanted.at(x, y), with - wanted.at(x, y));
                }
            EXPECT_LE(mixed, alone * 1.00001f);
            const std::size_t block = static_cast<std::size_t>(top / kBlock * (kSide / kBlock) + left / kBlock) * 16;
            const bool isKept = std::equal(first.bytes.begin() + static_cast<std::ptrdiff_t>(block),
                                           first.bytes.begin() + static_cast<std::ptrdiff_t>(block) + 16,
                                           second.bytes.begin() + static_cast<std::ptrdiff_t>(block));
            ++(isKept ? kept : better);
        }
    EXPECT_GT(kept, 0);
    EXPECT_GT(better, 0);
}

}  // namespace
}  // namespace lightcook::compress
