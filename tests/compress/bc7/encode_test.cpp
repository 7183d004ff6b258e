// BC7: blocks of one colour.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/compress/few_colours.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;

TEST(Bc7, OneColourIsExactFor8BitValuesAndNearestForOthers) {
    Random random(32);
    for (int i = 0; i < 2000; ++i) {
        glm::vec4 colour(random.unit(), random.unit(), random.unit(), random.unit());
        if (i < 256) colour = glm::vec4(i, 255 - i, (i * 7) % 256, (i * 31) % 256) / 255.0f;
        const glm::vec4 decoded = encode(PixelFormat::Bc7, coloured(colour)).decoded.at(1, 3);
        for (int c = 0; c < 4; ++c) ASSERT_NEAR(decoded[c] * 255, colour[c] * 255, i < 256 ? 1e-4 : 0.5001) << i;
    }
}

/// BC7 decodes to 8-bit values in every mode, so the nearest 8-bit value of each channel is the least error.
TEST(Bc7, OneColourIsTheNearestByteAtEveryEffort) {
    Random random(97);
    for (int i = 0; i < 300; ++i) {
        FewColours block = twoUnitColours(random, i);
        block.colour[1] = block.colour[0];
        block.paint();
        double least = 0;
        const double weight = block.weightOf(0) + block.weightOf(1);
        for (int c = 0; c < 4; ++c) least += weight * std::pow(std::nearbyint(block.colour[0][c] * 255) / 255 - block.colour[0][c], 2);
        for (int level = 0; level <= 9; ++level)
            ASSERT_LE(weightedError(block, decodedOf(PixelFormat::Bc7, block, level), 0, 4), least + roundingOf(least, 4 * weight, 2e-7))
                << i << " effort " << level;
    }
}

}  // namespace
}  // namespace lightcook::compress::test
