#include "verify/texture/astc_endpoints.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace lightcook::verify {
namespace {

using Colour = std::array<int, 4>;

constexpr int kHdrOne = 0x780;  // 1.0 in the logarithmic space

Colour blueContract(const Colour& c) {
    return {(c[0] + c[2]) >> 1, (c[1] + c[2]) >> 1, c[2], c[3]};
}

Colour clampTo(Colour c, int most) {
    for (int& v : c) v = std::clamp(v, 0, most);
    return c;
}

/// Moves the top bit of an offset to its base, which leaves a signed offset of six bits.
struct BaseAndOffset {
    int base, offset;
};
BaseAndOffset transferBit(int base, int offset) {
    const int moved = (base >> 1) | (offset & 0x80);
    int rest = offset >> 1 & 0x3f;
    if ((rest & 0x20) != 0) rest -= 0x40;
    return {moved, rest};
}

// ---- LDR ----

AstcEndpoints luminanceBaseOffset(std::span<const int> v) {
    const int low = (v[0] >> 2) | (v[1] & 0xc0), high = std::min(low + (v[1] & 0x3f), 255);
    return {{low, low, low, 255}, {high, high, high, 255}};
}

AstcEndpoints luminanceAlphaBaseOffset(std::span<const int> v) {
    const BaseAndOffset l = transferBit(v[0], v[1]), a = transferBit(v[2], v[3]);
    const int high = l.base + l.offset;
    return {clampTo({l.base, l.base, l.base, a.base}, 255), clampTo({high, high, high, a.base + a.offset}, 255)};
}

AstcEndpoints rgbBaseScale(std::span<const int> v, int alphaLow, int alphaHigh) {
    return {{v[0] * v[3] >> 8, v[1] * v[3] >> 8, v[2] * v[3] >> 8, alphaLow}, {v[0], v[1], v[2], alphaHigh}};
}

/// Storing the darker endpoint second selects blue contraction.
AstcEndpoints rgbDirect(std::span<const int> v, int alphaLow, int alphaHigh) {
    const Colour a = {v[0], v[2], v[4], alphaLow}, b = {v[1], v[3], v[5], alphaHigh};
    if (b[0] + b[1] + b[2] >= a[0] + a[1] + a[2]) return {a, b};
    return {blueContract(b), blueContract(a)};
}

AstcEndpoints rgbBaseOffset(std::span<const int> v, const BaseAndOffset& alpha) {
    const BaseAndOffset r = transferBit(v[0], v[1]), g = transferBit(v[2], v[3]), b = transferBit(v[4], v[5]);
    const Colour base = {r.base, g.base, b.base, alpha.base};
    const Colour sum = {r.base + r.offset, g.base + g.offset, b.base + b.offset, alpha.base + alpha.offset};
    if (r.offset + g.offset + b.offset >= 0) return {clampTo(base, 255), clampTo(sum, 255)};
    return {clampTo(blueContract(sum), 255), clampTo(blueContract(base), 255)};
}

// ---- HDR ----

AstcEndpoints hdrLuminance(int low, int high) {
    return {{low, low, low, kHdrOne}, {high, high, high, kHdrOne}, true, true};
}

AstcEndpoints hdrLuminanceLargeRange(std::span<const int> v) {
    if (v[1] >= v[0]) return hdrLuminance(v[0] << 4, v[1] << 4);
    return hdrLuminance((v[1] << 4) + 8, (v[0] << 4) - 8);
}

AstcEndpoints hdrLuminanceSmallRange(std::span<const int> v) {
    const bool isFine = (v[0] & 0x80) == 0;
    const int low = isFine ? (v[1] & 0xf0) << 4 | (v[0] & 0x7f) << 1 : (v[1] & 0xe0) << 4 | (v[0] & 0x7f) << 2;
    const int offset = isFine ? (v[1] & 0x0f) << 1 : (v[1] & 0x1f) << 2;
    return hdrLuminance(low, std::min(low + offset, 0xfff));
}

void swapMajor(Colour& c, int major) {
    if (major != 0) std::swap(c[0], c[static_cast<std::size_t>(major)]);
}

/// Mode 7. Six layouts assign the spare bits x0..x6 to different components. A mask holds the layouts that do so.
AstcEndpoints hdrRgbBaseScale(std::span<const int> v) {
    const int head = (v[0] & 0xc0) >> 6 | (v[1] & 0x80) >> 5 | (v[2] & 0x80) >> 4;
    int major = 0, mode = 5;
    if ((head & 0xc) != 0xc) {
        major = head >> 2;
        mode = head & 3;
    } else if (head != 0xf) {
        major = head & 3;
        mode = 4;
    }
    int red = v[0] & 0x3f, green = v[1] & 0x1f, blue = v[2] & 0x1f, scale = v[3] & 0x1f;
    const int x0 = v[1] >> 6 & 1, x1 = v[1] >> 5 & 1, x2 = v[2] >> 6 & 1, x3 = v[2] >> 5 & 1;
    const int x4 = v[3] >> 7 & 1, x5 = v[3] >> 6 & 1, x6 = v[3] >> 5 & 1;
    const int layout = 1 << mode;
    if ((layout & 0x30) != 0) green |= x0 << 6;
    if ((layout & 0x3a) != 0) green |= x1 << 5;
    if ((layout & 0x30) != 0) blue |= x2 << 6;
    if ((layout & 0x3a) != 0) blue |= x3 << 5;
    if ((layout & 0x3d) != 0) scale |= x6 << 5;
    if ((layout & 0x2d) != 0) scale |= x5 << 6;
    if ((layout & 0x04) != 0) scale |= x4 << 7;
    if ((layout & 0x3b) != 0) red |= x4 << 6;
    if ((layout & 0x04) != 0) red |= x3 << 6;
    if ((layout & 0x10) != 0) red |= x5 << 7;
    if ((layout & 0x0f) != 0) red |= x2 << 7;
    if ((layout & 0x05) != 0) red |= x1 << 8;
    if ((layout & 0x0a) != 0) red |= x0 << 8;
    if ((layout & 0x05) != 0) red |= x0 << 9;
    if ((layout & 0x02) != 0) red |= x6 << 9;
    if ((layout & 0x01) != 0) red |= x3 << 10;
    if ((layout & 0x02) != 0) red |= x5 << 10;
    static constexpr std::array<int, 6> kShifts = {1, 1, 2, 3, 4, 5};
    const int shift = kShifts[static_cast<std::size_t>(mode)];
    red <<= shift;
    green <<= shift;
    blue <<= shift;
    scale <<= shift;
    if (mode != 5) {
        green = red - green;
        blue = red - blue;
    }
    Colour high = {red, green, blue, kHdrOne};
    swapMajor(high, major);
    const Colour low = {high[0] - scale, high[1] - scale, high[2] - scale, kHdrOne};
    return {clampTo(low, 0xfff), clampTo(high, 0xfff), true, true};
}

int signExtend(int value, int bits) {
    const int sign = 1 << (bits - 1);
    return ((value & ((1 << bits) - 1)) ^ sign) - sign;
}

/// Decodes mode 11, and the colours of modes 14 and 15.
AstcEndpoints hdrRgbDirect(std::span<const int> v) {
    const int major = (v[4] & 0x80) >> 7 | (v[5] & 0x80) >> 6;
    if (major == 3)
        return {{v[0] << 4, v[2] << 4, (v[4] & 0x7f) << 5, kHdrOne}, {v[1] << 4, v[3] << 4, (v[5] & 0x7f) << 5, kHdrOne}, true, true};
    const int mode = (v[1] & 0x80) >> 7 | (v[2] & 0x80) >> 6 | (v[3] & 0x80) >> 5;
    static constexpr std::array<int, 8> kOffsetBits = {7, 6, 7, 6, 5, 6, 5, 6};
    const int offsetBits = kOffsetBits[static_cast<std::size_t>(mode)];
    int a = v[0] | (v[1] & 0x40) << 2, c = v[1] & 0x3f, b0 = v[2] & 0x3f, b1 = v[3] & 0x3f;
    const int d0 = signExtend(v[4] & 0x7f, offsetBits), d1 = signExtend(v[5] & 0x7f, offsetBits);
    const int x0 = v[2] >> 6 & 1, x1 = v[3] >> 6 & 1, x2 = v[4] >> 6 & 1, x3 = v[5] >> 6 & 1, x4 = v[4] >> 5 & 1, x5 = v[5] >> 5 & 1;
    const int layout = 1 << mode;
    if ((layout & 0xa4) != 0) a |= x0 << 9;
    if ((layout & 0x08) != 0) a |= x2 << 9;
    if ((layout & 0x50) != 0) a |= x4 << 9;
    if ((layout & 0x50) != 0) a |= x5 << 10;
    if ((layout & 0xa0) != 0) a |= x1 << 10;
    if ((layout & 0xc0) != 0) a |= x2 << 11;
    if ((layout & 0x04) != 0) c |= x1 << 6;
    if ((layout & 0xe8) != 0) c |= x3 << 6;
    if ((layout & 0x20) != 0) c |= x2 << 7;
    if ((layout & 0x5b) != 0) {
        b0 |= x0 << 6;
        b1 |= x1 << 6;
    }
    if ((layout & 0x12) != 0) {
        b0 |= x2 << 7;
        b1 |= x3 << 7;
    }
    const int scale = 1 << ((mode >> 1) ^ 3);  // a product, as d0 and d1 may be negative
    Colour high = {a * scale, (a - b0) * scale, (a - b1) * scale, kHdrOne};
    Colour low = {(a - c) * scale, (a - b0 - c - d0) * scale, (a - b1 - c - d1) * scale, kHdrOne};
    high = clampTo(high, 0xfff);
    low = clampTo(low, 0xfff);
    swapMajor(high, major);
    swapMajor(low, major);
    return {low, high, true, true};
}

/// Decodes the alpha of mode 15.
void hdrAlpha(int v6, int v7, AstcEndpoints& ends) {
    const int mode = (v6 >> 7 & 1) | (v7 >> 6 & 2);
    v6 &= 0x7f;
    v7 &= 0x7f;
    if (mode == 3) {
        ends.low[3] = v6 << 5;
        ends.high[3] = v7 << 5;
        return;
    }
    const int base = (v6 | (v7 << (mode + 1) & 0x780)) << (4 - mode);
    const int offset = ((v7 & (0x3f >> mode)) ^ (0x20 >> mode)) - (0x20 >> mode);
    ends.low[3] = base;
    ends.high[3] = std::clamp(base + offset * (1 << (4 - mode)), 0, 0xfff);
}

}  // namespace

AstcEndpoints astcDecodeEndpoints(int mode, std::span<const int> v) {
    assert(v.size() >= static_cast<std::size_t>(astcEndpointValueCount(mode)));
    constexpr BaseAndOffset kOpaque = {255, 0};
    switch (mode) {
        case 0:
            return {{v[0], v[0], v[0], 255}, {v[1], v[1], v[1], 255}};
        case 1:
            return luminanceBaseOffset(v);
        case 2:
            return hdrLuminanceLargeRange(v);
        case 3:
            return hdrLuminanceSmallRange(v);
        case 4:
            return {{v[0], v[0], v[0], v[2]}, {v[1], v[1], v[1], v[3]}};
        case 5:
            return luminanceAlphaBaseOffset(v);
        case 6:
            return rgbBaseScale(v, 255, 255);
        case 7:
            return hdrRgbBaseScale(v);
        case 8:
            return rgbDirect(v, 255, 255);
        case 9:
            return rgbBaseOffset(v, kOpaque);
        case 10:
            return rgbBaseScale(v, v[4], v[5]);
        case 11:
            return hdrRgbDirect(v);
        case 12:
            return rgbDirect(v, v[6], v[7]);
        case 13:
            return rgbBaseOffset(v, transferBit(v[6], v[7]));
        default:
            break;
    }
    AstcEndpoints ends = hdrRgbDirect(v);
    if (mode == 14) {
        ends.low[3] = v[6];
        ends.high[3] = v[7];
        ends.isHdrAlpha = false;
    } else {
        hdrAlpha(v[6], v[7], ends);
    }
    return ends;
}

}  // namespace lightcook::verify
