// Blocks of one and two colours for the tests that compare the encoders with the least possible error of a format.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "compress/block/block.h"
#include "tests/compress/codec_images.h"

namespace lightcook::compress::test {

/// Returns a 4 x 4 image of one colour.
inline TexelImage coloured(const glm::vec4& colour) {
    return imageOf(4, 4, [&](int, int) { return colour; });
}

/// Sixteen texels of one or two colours, and the significance of each.
struct FewColours {
    std::array<glm::dvec4, 2> colour;
    std::uint32_t second = 0;  ///< bit t: texel t has the second colour
    TexelImage image = TexelImage(4, 4);
    formats::Image<float> significance = formats::Image<float>(4, 4, 1.0f);

    double weightOf(int which) const {
        double sum = 0;
        for (int t = 0; t < kTexelCount; ++t)
            if (static_cast<int>(second >> t & 1) == which) sum += static_cast<double>(significance.at(t % 4, t / 4));
        return sum;
    }
    void paint() {
        for (int t = 0; t < kTexelCount; ++t) image.at(t % 4, t / 4) = glm::vec4(colour[second >> t & 1]);
    }
};

/// Returns a block of two colours: 8-bit values, arbitrary ones, similar ones or extremes. Every other block has weights.
inline FewColours twoUnitColours(Random& random, int number) {
    FewColours block;
    const auto any = [&] { return static_cast<double>(random.unit()); };
    for (int c = 0; c < 4; ++c) {
        double a = any(), b = number % 4 == 1 ? std::clamp(a + (any() - 0.5) * 0.1, 0.0, 1.0) : any();
        if (number % 4 == 2) a = std::nearbyint(a * 255) / 255, b = std::nearbyint(b * 255) / 255;
        if (number % 4 == 3) a = random.below(3) / 2.0, b = random.below(3) / 2.0;
        block.colour[0][c] = static_cast<double>(static_cast<float>(a));
        block.colour[1][c] = static_cast<double>(static_cast<float>(b));
    }
    // Straight edges, checks, single texels, anything.
    constexpr std::array<std::uint32_t, 6> kPatterns = {0xCCCC, 0xFF00, 0xA5A5, 0x8000, 0xFFFE, 0x8CEF};
    block.second = number % 3 ? random.bits() & 0xFFFF : kPatterns[static_cast<std::size_t>(random.below(6))];
    block.second = block.second == 0 || block.second == 0xFFFF ? 0x00F0 : block.second;
    if (number % 2)
        for (float& weight : block.significance.texels()) weight = 0.25f * static_cast<float>(1 + random.below(8));
    block.paint();
    return block;
}

inline double weightedError(const FewColours& block, const TexelImage& decoded, int firstChannel, int endChannel) {
    double sum = 0;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
            for (int c = firstChannel; c < endChannel; ++c) {
                const double miss = static_cast<double>(decoded.at(x, y)[c]) - static_cast<double>(block.image.at(x, y)[c]);
                sum += static_cast<double>(block.significance.at(x, y)) * miss * miss;
            }
    return sum;
}
inline TexelImage decodedOf(formats::PixelFormat format, const FewColours& block, int level) {
    return encode(format, block.image, effort(level), block.significance.view()).decoded;
}

/// Returns the tolerance above the least error if the values of encoder and decoder are floats with an error of up to `away` each:
/// sum w (m + a)^2 - sum w m^2 <= 2 a sqrt(sum w sum w m^2) + a^2 sum w.
inline double roundingOf(double least, double weight, double away) {
    return 2 * away * std::sqrt(least * weight) + away * away * weight;
}

}  // namespace lightcook::compress::test
