#include "pipeline/assets/textures.h"

#include <gtest/gtest.h>

#include <limits>

#include "compress/encode.h"

namespace lightcook::pipeline {
namespace {

using formats::Image;

Image<glm::vec4> ramp(int width, int height) {
    Image<glm::vec4> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            image.at(x, y) = glm::vec4((x + 0.5f) / static_cast<float>(width), (y + 0.5f) / static_cast<float>(height), 0.25f, 0.75f);
    return image;
}

TEST(EncodeImage, DoesNotDependOnTheDistributionOfRows) {
    const Image<glm::vec4> image = ramp(64, 200);
    compress::EncodeReport report;
    const auto spread = encodeImage(formats::PixelFormat::Bc7, image.view(), {}, {}, report);
    std::vector<std::byte> whole(spread.size());
    compress::encodeRows(formats::PixelFormat::Bc7, image.view(), {}, {}, whole, {});
    EXPECT_EQ(spread, whole);
}

TEST(HdrRange, BringsTheLargestUnderATopThatHalvesHoldWell) {
    for (const float largest : {1e-30f, 1e-5f, 0.9f, 1.0f, 3.0f, 65504.0f, 1e20f}) {
        const float stored = largest / hdrRange(largest);
        EXPECT_GT(stored, 511.0f) << largest;
        EXPECT_LE(stored, 1024.0f) << largest;
    }
    EXPECT_EQ(hdrRange(0), 1.0f);
    EXPECT_GT(hdrRange(std::numeric_limits<float>::denorm_min()), 0.0f);
}

}  // namespace
}  // namespace lightcook::pipeline
