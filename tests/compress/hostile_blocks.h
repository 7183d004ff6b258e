// Hostile blocks: huge, denormal and negative values, bright light sources beside zeros, weights of any size; and the properties that every
// encoded block must have.
#pragma once

#include "compress/block/highway_targets.h"
//
#include <gtest/gtest.h>

#include <hwy/targets.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <sstream>

#include "compress/block/block.h"
#include "compress/texel/packed_texels.h"
#include "tests/compress/codec_images.h"
#include "verify/texture_unit.h"

namespace lightcook::compress::test {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Returns a float of random bits, finite.
inline float anyFinite(Random& random) {
    while (true) {
        const float value = std::bit_cast<float>(random.bits());
        if (std::isfinite(value)) return value;
    }
}

inline float hostileValue(Random& random) {
    constexpr std::array<float, 24> kValues = {0,      -0.0f,     1,         -1,         65504,    65519.996f,   65520,         1e30f,
                                               -1e30f, 1e-30f,    0x1p-24f,  0x1p-25f,   0x1p-14f, 0x1.ffcp-15f, -0x1p-24f,     0.5f,
                                               32768,  0.999999f, 1.000001f, 1 / 255.0f, 60000,    -65504,       3.4028235e38f, 1e-45f};
    return kValues[static_cast<std::size_t>(random.below(static_cast<int>(kValues.size())))];
}

/// Writes one 4x4 block of a random kind. A third of the blocks has no negative value.
inline void makeHostileBlock(Random& random, TexelImage& image, int left, int top) {
    const int kind = random.below(12);
    const bool keepSign = random.below(3) != 0;
    const float level = std::exp2(random.unit() * 46 - 30), slope = random.unit() * 2 - 1;
    glm::vec4 colours[2];
    for (glm::vec4& colour : colours)
        for (int c = 0; c < 4; ++c) colour[c] = random.below(2) ? hostileValue(random) : level * random.unit();
    for (int t = 0; t < kTexelCount; ++t)
        for (int c = 0; c < 4; ++c) {
            const int column = t % 4, row = t / 4;
            float value = 0;
            switch (kind) {
                case 0:
                    value = random.unit();
                    break;
                case 1:  // smooth
                    value = level * (1 + 0.05f * slope * static_cast<float>(column) + 0.02f * static_cast<float>(row + c));
                    break;
                case 2:
                    value = hostileValue(random);
                    break;
                case 3:  // half and float denormals
                    value = std::ldexp(random.unit(), random.below(2) ? -14 - random.below(12) : -126 - random.below(24));
                    break;
                case 4:  // lamps beside nothing
                    value = random.below(4) ? 0.0f : 60000 * random.unit();
                    break;
                case 5:  // constant
                    value = colours[0][c];
                    break;
                case 6:  // two colours
                    value = colours[(t * 7 + random.below(2)) % 2][c];
                    break;
                case 7:  // every scale
                    value = std::exp2(random.unit() * 50 - 30);
                    break;
                case 8:
                    value = anyFinite(random);
                    break;
                case 9:  // signs
                    value = level * (random.unit() - 0.5f);
                    break;
                case 10:  // eighths, as bytes of masks have them
                    value = static_cast<float>(random.below(9)) / 8;
                    break;
                default:  // nearly constant: the last bits
                    value = level * (1 + 1e-6f * random.unit());
            }
            image.at(left + column, top + row)[c] = keepSign ? value : std::abs(value);
        }
}

inline void makeHostileWeights(Random& random, formats::Image<float>& significance, int left, int top) {
    const int kind = random.below(8), only = random.below(kTexelCount);
    for (int t = 0; t < kTexelCount; ++t) {
        float weight = 1;
        switch (kind) {
            case 0:
                weight = static_cast<float>(random.below(2));
                break;
            case 1:
                weight = std::ldexp(random.unit(), random.below(80) - 40);
                break;
            case 2:
                weight = 0;
                break;
            case 3:
                weight = t == only ? 1.0f : 0.0f;
                break;
            case 4:
                weight = random.below(3) ? 1e30f : random.below(2) ? 1e-30f : 0.0f;
                break;
            case 5:
                weight = 1e-30f * static_cast<float>(random.below(3));
                break;
            default:
                break;
        }
        significance.at(left + t % 4, top + t / 4) = weight;
    }
}

struct HostileImage {
    TexelImage texels;
    formats::Image<float> significance;
    EncodeOptions options;
};

inline EncodeOptions hostileOptions(Random& random, int level) {
    constexpr std::array<float, 4> kScales = {1, 1e-6f, 0.05f, 65504};
    constexpr std::array<std::array<float, 4>, 4> kWeights = {{{1, 1, 1, 1}, {1, 1, 1, 1}, {1, 0, 0, 0}, {1, 0.25f, 1e-3f, 0.01f}}};
    EncodeOptions options = effort(level);
    options.hdrMetric =
        std::array{HdrMetric::Log, HdrMetric::Log, HdrMetric::Linear, HdrMetric::Relative}[static_cast<std::size_t>(random.below(4))];
    options.hdrScale = random.below(2) ? 1.0f : kScales[static_cast<std::size_t>(random.below(4))];
    options.channelWeights = kWeights[static_cast<std::size_t>(random.below(4))];
    return options;
}

/// Returns blockCount blocks in rows of 64; the last row may be shorter.
inline HostileImage makeHostileImage(Random& random, int blockCount, int level) {
    const int across = std::min(blockCount, 64), down = (blockCount + across - 1) / across;
    HostileImage image{TexelImage(4 * across, 4 * down), formats::Image<float>(4 * across, 4 * down), hostileOptions(random, level)};
    for (int y = 0; y < down; ++y)
        for (int x = 0; x < across; ++x) {
            makeHostileBlock(random, image.texels, 4 * x, 4 * y);
            makeHostileWeights(random, image.significance, 4 * x, 4 * y);
        }
    return image;
}

/// Returns the 4x4 texels around (x, y) in hexadecimal, to reproduce a failure.
inline std::string describeBlock(const HostileImage& image, formats::PixelFormat format, int x, int y) {
    std::ostringstream text;
    text << formats::info(format).name << " effort " << image.options.effort << " metric " << static_cast<int>(image.options.hdrMetric)
         << " scale " << image.options.hdrScale << " weights";
    for (const float weight : image.options.channelWeights) text << ' ' << weight;
    text << std::hexfloat;
    for (int t = 0; t < kTexelCount; ++t) {
        const int u = x / 4 * 4 + t % 4, v = y / 4 * 4 + t / 4;
        const glm::vec4& texel = image.texels.at(u, v);
        text << "\n  {" << texel.r << ", " << texel.g << ", " << texel.b << ", " << texel.a << "}, weight " << image.significance.at(u, v);
    }
    return text.str();
}

/// Returns the defect of a decoded value, or null.
inline const char* wrongWith(formats::PixelFormat format, int channel, float ours, float theirs) {
    const formats::PixelFormatInfo& info = formats::info(format);
    if (!std::isfinite(ours) || !std::isfinite(theirs)) return "not finite";
    if (channel < info.channelCount) {
        const float largest = rangeOf(format).high[channel], least = info.isSigned ? -largest : 0.0f;
        if (theirs < least || theirs > largest) return "out of the format's range";
    }
    const bool isAstc = info.name.starts_with("astc");
    // BC1 to BC5 are real-valued in both decoders; ASTC goes through halfs in one and through 16 bits in the other.
    const float tolerance = isAstc ? 2e-3f * std::max(1.0f, std::abs(theirs)) : info.isFloat ? 0.0f : 1e-6f;
    return std::abs(ours - theirs) <= tolerance ? nullptr : "the encoder's decoder and the verifier's disagree";
}

/// Encodes with the narrowest and the widest instruction set and compares the bytes, and the decoded texels with the decoder of verify/. At
/// the first defect, adds a test failure that describes the block and returns false.
inline bool expectSound(formats::PixelFormat format, const HostileImage& image) {
    const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
    hwy::GetChosenTarget().Update(targets.front());
    const Encoded first = encode(format, image.texels, image.options, image.significance.view());
    hwy::GetChosenTarget().Update(targets.back());
    const Encoded last = encode(format, image.texels, image.options, image.significance.view());
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());

    const int width = image.texels.width(), height = image.texels.height();
    if (first.bytes != last.bytes) {
        const auto at =
            static_cast<std::size_t>(std::mismatch(first.bytes.begin(), first.bytes.end(), last.bytes.begin()).first - first.bytes.begin());
        const int block = static_cast<int>(at / static_cast<std::size_t>(formats::info(format).bytesPerBlock));
        const int across = formats::blocksAcross(format, width);
        ADD_FAILURE() << "instruction sets disagree: "
                      << describeBlock(image, format, block % across * formats::info(format).blockWidth,
                                       block / across * formats::info(format).blockHeight);
        return false;
    }
    TexelImage read(width, height);
    verify::decodeRows(format, first.bytes, read.view());
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 4; ++c) {
                const float ours = first.decoded.at(x, y)[c], theirs = read.at(x, y)[c];
                const char* wrong = wrongWith(format, c, ours, theirs);
                if (!wrong) continue;
                ADD_FAILURE() << wrong << ", channel " << c << " of (" << x % 4 << ", " << y % 4 << "): " << ours << " and " << theirs
                              << "; " << describeBlock(image, format, x, y);
                return false;
            }
    return true;
}

}  // namespace lightcook::compress::test
