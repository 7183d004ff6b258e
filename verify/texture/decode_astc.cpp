// ASTC, two-dimensional blocks, LDR and HDR. Source: Khronos Data Format 1.3, chapter 23; functions name that
// chapter's topics. Steps: mode -> weights and endpoints from their integer sequences -> endpoint colours -> partition and weight of each
// texel -> 16-bit value -> half float.
#include <algorithm>
#include <array>
#include <cassert>
#include <limits>
#include <utility>

#include "verify/texture/astc_endpoints.h"
#include "verify/texture/astc_sequences.h"
#include "verify/texture/decode.h"

namespace lightcook::verify {
namespace {

struct BlockMode {
    int gridWidth = 0, gridHeight = 0;
    bool isDualPlane = false;
    int weightLevels = 0;  ///< 0: the mode is reserved
};

/// Decodes the block mode, the lowest 11 bits. R selects one of six ranges, H the low or the high six.
BlockMode blockMode(std::uint32_t mode) {
    static constexpr std::array<std::array<int, 8>, 2> kLevels = {{{0, 0, 2, 3, 4, 5, 6, 8}, {0, 0, 10, 12, 16, 20, 24, 32}}};
    const int a = static_cast<int>(mode >> 5 & 3), b = static_cast<int>(mode >> 7 & 3);
    std::uint32_t r = mode >> 4 & 1, high = mode >> 9 & 1, dual = mode >> 10 & 1;
    BlockMode result;
    if ((mode & 3) != 0) {
        r |= (mode & 3) << 1;
        switch (mode >> 2 & 3) {
            case 0:
                result = {b + 4, a + 2};
                break;
            case 1:
                result = {b + 8, a + 2};
                break;
            case 2:
                result = {a + 2, b + 8};
                break;
            default:
                result = (b & 2) == 0 ? BlockMode{a + 2, (b & 1) + 6} : BlockMode{(b & 1) + 2, a + 2};
                break;
        }
    } else {
        if ((mode >> 2 & 3) == 0) return {};
        r |= (mode >> 2 & 3) << 1;
        switch (b) {
            case 0:
                result = {12, a + 2};
                break;
            case 1:
                result = {a + 2, 12};
                break;
            case 2:
                result = {a + 6, static_cast<int>(mode >> 9 & 3) + 6};
                high = dual = 0;  // their bits belong to the height
                break;
            default:
                if (a > 1) return {};
                result = a == 0 ? BlockMode{6, 10} : BlockMode{10, 6};
                break;
        }
    }
    result.isDualPlane = dual != 0;
    result.weightLevels = kLevels[high][r];
    return result;
}

/// The pseudo-random partition function of the specification.
std::uint32_t hash52(std::uint32_t p) {
    p ^= p >> 15;
    p -= p << 17;
    p += p << 7;
    p += p << 4;
    p ^= p >> 5;
    p += p << 16;
    p ^= p >> 7;
    p ^= p >> 3;
    p ^= p << 6;
    p ^= p >> 17;
    return p;
}

class PartitionFunction {
public:
    PartitionFunction(std::uint32_t seed, int partitionCount, bool isSmallBlock)
        : partitionCount_(partitionCount), scale_(isSmallBlock ? 2 : 1) {
        seed += static_cast<std::uint32_t>(partitionCount - 1) * 1024;
        random_ = hash52(seed);
        const int ofThree = partitionCount == 3 ? 6 : 5, ofSeed = (seed & 2) != 0 ? 4 : 5;
        const int shiftX = (seed & 1) != 0 ? ofSeed : ofThree, shiftY = (seed & 1) != 0 ? ofThree : ofSeed;
        for (int i = 0; i < 8; ++i) {
            const std::uint32_t nibble = random_ >> (4 * i) & 15;
            factors_[static_cast<std::size_t>(i)] = static_cast<int>(nibble * nibble >> (i % 2 == 0 ? shiftX : shiftY));
        }
    }

    int operator()(int x, int y) const {
        x *= scale_;
        y *= scale_;
        std::array<int, 4> sums{};
        for (int i = 0; i < partitionCount_; ++i) {
            const std::size_t f = 2 * static_cast<std::size_t>(i);
            sums[static_cast<std::size_t>(i)] = (factors_[f] * x + factors_[f + 1] * y + static_cast<int>(random_ >> (14 - 4 * i))) & 63;
        }
        // The first of the largest wins. Missing partitions have 0.
        return static_cast<int>(std::max_element(sums.begin(), sums.end()) - sums.begin());
    }

private:
    int partitionCount_, scale_;
    std::uint32_t random_ = 0;
    std::array<int, 8> factors_{};
};

/// Converts a 16-bit UNORM result to FP16, rounded towards zero; 65535 is 1.
std::uint16_t halfFromUnorm16(std::uint32_t value) {
    if (value == 65535) return 0x3c00;
    if (value == 0) return 0;
    const int top = std::bit_width(value) - 1;  // value / 65536 = 2^(top - 16) * 1.xxx
    const int exponent = top - 16 + 15;
    if (exponent <= 0) return static_cast<std::uint16_t>(value << 8);  // subnormal: value / 65536 in units of 2^-24; exact
    const std::uint32_t mantissa = top >= 10 ? value >> (top - 10) : value << (10 - top);
    return static_cast<std::uint16_t>(exponent << 10 | static_cast<int>(mantissa & 0x3ff));
}

/// Converts a value of the logarithmic HDR interpolation space to FP16.
std::uint16_t halfFromLns(std::uint32_t value) {
    const std::uint32_t exponent = value >> 11, mantissa = value & 0x7ff;
    std::uint32_t bent = 4 * mantissa - 512;
    if (mantissa < 512) bent = 3 * mantissa;
    if (mantissa >= 1536) bent = 5 * mantissa - 2048;
    return static_cast<std::uint16_t>(std::min<std::uint32_t>(exponent << 10 | bent >> 3, 0x7bff));
}

class Decoder {
public:
    Decoder(Block16 block, int width, int height, bool isHdrProfile, std::span<glm::vec4> out)
        : bits_(block), width_(width), height_(height), isHdrProfile_(isHdrProfile), out_(out) {}

    void decode() {
        if ((field(0, 9)) == 0x1fc)
            decodeVoidExtent();
        else if (!readLayout())
            fillWithError();
        else
            decodeTexels();
    }

private:
    std::uint32_t field(int first, int count) const { return astcBits(bits_, first, count); }

    void fillWithError() const {
        const float nan = std::numeric_limits<float>::quiet_NaN();
        std::fill(out_.begin(), out_.end(), isHdrProfile_ ? glm::vec4(nan) : glm::vec4(1.0f, 0.0f, 1.0f, 1.0f));
    }

    /// Decodes a void-extent block: a single colour. The extents must be all ones or form a box.
    void decodeVoidExtent() const {
        const bool isHalf = field(9, 1) != 0;
        const std::uint32_t sLow = field(12, 13), sHigh = field(25, 13), tLow = field(38, 13), tHigh = field(51, 13);
        const bool isUnbounded = (sLow & sHigh & tLow & tHigh) == 0x1fff;
        if (field(10, 2) != 3 || (isHalf && !isHdrProfile_) || (!isUnbounded && (sLow >= sHigh || tLow >= tHigh))) return fillWithError();
        glm::vec4 colour;
        for (int c = 0; c < 4; ++c) {
            const std::uint32_t value = field(64 + 16 * c, 16);
            colour[c] = floatFromHalf(isHalf ? static_cast<std::uint16_t>(value) : halfFromUnorm16(value));
        }
        std::fill(out_.begin(), out_.end(), colour);
    }

    /// Reads mode, partitions, endpoint modes and both integer sequences. Returns false for an illegal block.
    bool readLayout() {
        mode_ = blockMode(field(0, 11));
        partitionCount_ = static_cast<int>(field(11, 2)) + 1;
        if (mode_.weightLevels == 0 || mode_.gridWidth > width_ || mode_.gridHeight > height_) return false;
        const int weightCount = mode_.gridWidth * mode_.gridHeight * (mode_.isDualPlane ? 2 : 1);
        if (weightCount > 64 || (mode_.isDualPlane && partitionCount_ == 4)) return false;
        const int weightBits = astcSequenceBits(weightCount, mode_.weightLevels);
        if (weightBits < 24 || weightBits > 96) return false;
        int end = 128 - weightBits;
        readEndpointModes(end);
        if (mode_.isDualPlane) {
            end -= 2;
            secondPlaneChannel_ = static_cast<int>(field(end, 2));
        }
        if (!readEndpoints(partitionCount_ == 1 ? 17 : 29, end)) return false;
        // Weights are stored from the block's last bit downwards.
        std::array<std::uint8_t, 64> stored{};
        const std::span<std::uint8_t> weights = std::span(stored).first(static_cast<std::size_t>(weightCount));
        astcReadSequence(astcReversed(bits_), 0, mode_.weightLevels, weights);
        for (std::size_t i = 0; i < weights.size(); ++i)
            weights_[mode_.isDualPlane ? i % 2 : 0][mode_.isDualPlane ? i / 2 : i] = astcUnquantizeWeight(weights[i], mode_.weightLevels);
        return true;
    }

    /// Reads the endpoint modes: one for all partitions, or a base class, and for each partition a class bit and two mode bits, which
    /// continue below the weights.
    void readEndpointModes(int& end) {
        if (partitionCount_ == 1) {
            endpointModes_[0] = static_cast<int>(field(13, 4));
            return;
        }
        const std::uint32_t low = field(23, 6), selector = low & 3;
        if (selector == 0) {
            endpointModes_.fill(static_cast<int>(low >> 2));
            return;
        }
        const int extraBits = 3 * partitionCount_ - 4;
        end -= extraBits;
        const std::uint32_t all = low >> 2 | field(end, extraBits) << 4;
        for (int i = 0; i < partitionCount_; ++i) {
            const std::uint32_t endpointClass = selector - 1 + (all >> i & 1);
            endpointModes_[static_cast<std::size_t>(i)] = static_cast<int>(endpointClass << 2 | (all >> (partitionCount_ + 2 * i) & 3));
        }
    }

    bool readEndpoints(int first, int end) {
        int valueCount = 0;
        for (int i = 0; i < partitionCount_; ++i) valueCount += astcEndpointValueCount(endpointModes_[static_cast<std::size_t>(i)]);
        if (valueCount > 18) return false;
        const int levels = astcColourLevels(valueCount, end - first);
        if (levels == 0) return false;
        std::array<std::uint8_t, 18> stored{};
        astcReadSequence(bits_, first, levels, std::span(stored).first(static_cast<std::size_t>(valueCount)));
        std::array<int, 18> values{};
        for (std::size_t i = 0; i < static_cast<std::size_t>(valueCount); ++i) values[i] = astcUnquantizeColour(stored[i], levels);
        std::size_t next = 0;
        for (std::size_t i = 0; i < static_cast<std::size_t>(partitionCount_); ++i) {
            endpoints_[i] = astcDecodeEndpoints(endpointModes_[i], std::span(values).subspan(next));
            next += static_cast<std::size_t>(astcEndpointValueCount(endpointModes_[i]));
        }
        return true;
    }

    /// Returns the weight of a texel in one plane: bilinear from the weight grid, in sixteenths.
    int weightAt(int x, int y, std::size_t plane) const {
        const std::array<std::uint8_t, 64>& weights = weights_[plane];
        const int stepX = (1024 + width_ / 2) / (width_ - 1), stepY = (1024 + height_ / 2) / (height_ - 1);
        const int gridX = (stepX * x * (mode_.gridWidth - 1) + 32) >> 6, gridY = (stepY * y * (mode_.gridHeight - 1) + 32) >> 6;
        const int fractionX = gridX & 15, fractionY = gridY & 15;
        const int first = (gridX >> 4) + (gridY >> 4) * mode_.gridWidth;
        const int w11 = (fractionX * fractionY + 8) >> 4, w10 = fractionY - w11, w01 = fractionX - w11;
        const int w00 = 16 - fractionX - fractionY + w11;
        // A neighbour outside the grid has weight 0 and is not read.
        const auto at = [&](int index, int weight) { return weight == 0 ? 0 : weights[static_cast<std::size_t>(index)] * weight; };
        return (at(first, w00) + at(first + 1, w01) + at(first + mode_.gridWidth, w10) + at(first + mode_.gridWidth + 1, w11) + 8) >> 4;
    }

    void decodeTexels() const {
        const PartitionFunction partition(field(13, 10), partitionCount_, width_ * height_ < 31);
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x) {
                const AstcEndpoints& ends = endpoints_[static_cast<std::size_t>(partitionCount_ == 1 ? 0 : partition(x, y))];
                glm::vec4& texel = out_[static_cast<std::size_t>(y * width_ + x)];
                // In the LDR profile, a partition with an HDR endpoint pair has the error colour.
                if (!isHdrProfile_ && (ends.isHdrRgb || ends.isHdrAlpha)) {
                    texel = {1.0f, 0.0f, 1.0f, 1.0f};
                    continue;
                }
                const int weight = weightAt(x, y, 0), second = mode_.isDualPlane ? weightAt(x, y, 1) : weight;
                for (int c = 0; c < 4; ++c)
                    texel[c] = channelValue(ends, c, mode_.isDualPlane && c == secondPlaneChannel_ ? second : weight);
            }
    }

    static float channelValue(const AstcEndpoints& ends, int channel, int weight) {
        const bool isHdr = channel < 3 ? ends.isHdrRgb : ends.isHdrAlpha;
        // 8 bits are extended to 16 by repetition, the 12 bits of HDR by four zeros.
        const auto widen = [&](int value) { return static_cast<std::uint32_t>(isHdr ? value << 4 : value * 257); };
        const std::uint32_t a = widen(ends.low[static_cast<std::size_t>(channel)]), b = widen(ends.high[static_cast<std::size_t>(channel)]);
        const std::uint32_t w = static_cast<std::uint32_t>(weight), value = (a * (64 - w) + b * w + 32) >> 6;
        return floatFromHalf(isHdr ? halfFromLns(value) : halfFromUnorm16(value));
    }

    const AstcBits bits_;
    const int width_, height_;
    const bool isHdrProfile_;
    const std::span<glm::vec4> out_;

    BlockMode mode_;
    int partitionCount_ = 1, secondPlaneChannel_ = 0;
    std::array<int, 4> endpointModes_{};
    std::array<AstcEndpoints, 4> endpoints_{};
    std::array<std::array<std::uint8_t, 64>, 2> weights_{};
};

}  // namespace

void decodeAstc(Block16 block, int width, int height, bool isHdrProfile, std::span<glm::vec4> out) {
    assert(width >= 4 && width <= 12 && height >= 4 && height <= 12 && out.size() >= static_cast<std::size_t>(width * height));
    Decoder(block, width, height, isHdrProfile, out.first(static_cast<std::size_t>(width * height))).decode();
}

}  // namespace lightcook::verify
