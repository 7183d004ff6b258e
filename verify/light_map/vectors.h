// Vector arithmetic of the bounds of light maps: nine RGB coefficients, and the lengths of their SH bands by channel. Lengths are rounded
// up, so that sums of them are upper bounds. Private to verify/.
#pragma once

#include <array>
#include <cmath>
#include <cstring>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>

#include "lighting/radiometry.h"
#include "lighting/sh.h"
#include "shaders/lightcook_cpp.h"
#include "verify/light_map/rounding.h"

namespace lightcook::verify::lightmap {

using shaders::LcSh;

inline constexpr std::size_t kChannels = 3, kCoefficients = lighting::kShCount;
/// Floor of local errors (docs/theory/error.md). All light here is in units of the key.
inline constexpr double kFloor = lighting::kLocalErrorFloor;

using Channels = std::array<lighting::Sh, kChannels>;
/// Slack by channel: upper bounds, for each band, of the length of what is added to an error (rounding, sampler tolerance).
using ChannelSlack = std::array<lighting::ShBands, kChannels>;
/// Squared lengths: [band][channel].
using Squares = std::array<glm::vec3, 3>;

inline LcSh difference(const LcSh& a, const LcSh& b) {
    LcSh out;
    for (std::size_t i = 0; i < kCoefficients; ++i) out.c[i] = a.c[i] - b.c[i];
    return out;
}

inline LcSh scaled(const LcSh& sh, float factor) {
    LcSh out;
    for (std::size_t i = 0; i < kCoefficients; ++i) out.c[i] = factor * sh.c[i];
    return out;
}

inline LcSh blend(const LcSh& a, const LcSh& b, float weight) {
    LcSh out;
    for (std::size_t i = 0; i < kCoefficients; ++i) out.c[i] = (1 - weight) * a.c[i] + weight * b.c[i];
    return out;
}

/// Converts the values of a polynomial at i / degree, i = 0 .. degree, to its Bernstein coefficients, in place.
/// nodes  the degree + 1 values; degrees 1 to 4
inline void bernsteinFromNodes(std::span<LcSh* const> nodes) {
    const auto forEachCoefficient = [](auto&& work) {
        for (std::size_t i = 0; i < kCoefficients; ++i) work(i);
    };
    switch (nodes.size()) {
        case 3:
            return forEachCoefficient(
                [&](std::size_t i) { nodes[1]->c[i] = 2.0f * nodes[1]->c[i] - 0.5f * (nodes[0]->c[i] + nodes[2]->c[i]); });
        case 4:
            return forEachCoefficient([&](std::size_t i) {
                const glm::vec3 p0 = nodes[0]->c[i], p1 = nodes[1]->c[i], p2 = nodes[2]->c[i], p3 = nodes[3]->c[i];
                nodes[1]->c[i] = (-5.0f * p0 + 18.0f * p1 - 9.0f * p2 + 2.0f * p3) / 6.0f;
                nodes[2]->c[i] = (2.0f * p0 - 9.0f * p1 + 18.0f * p2 - 5.0f * p3) / 6.0f;
            });
        case 5:
            return forEachCoefficient([&](std::size_t i) {
                const glm::vec3 p0 = nodes[0]->c[i], p1 = nodes[1]->c[i], p2 = nodes[2]->c[i], p3 = nodes[3]->c[i], p4 = nodes[4]->c[i];
                nodes[1]->c[i] = (-13.0f * p0 + 48.0f * p1 - 36.0f * p2 + 16.0f * p3 - 3.0f * p4) / 12.0f;
                nodes[2]->c[i] = (13.0f * p0 - 64.0f * p1 + 120.0f * p2 - 64.0f * p3 + 13.0f * p4) / 18.0f;
                nodes[3]->c[i] = (-3.0f * p0 + 16.0f * p1 - 36.0f * p2 + 48.0f * p3 - 13.0f * p4) / 12.0f;
            });
        default:  // degree 1: the values are the coefficients
            return;
    }
}

/// Converts the values of a polynomial in two variables at nodes x nodes places, row by row, to its control vectors, in place.
inline void controlsFromNodes(std::span<LcSh> values, std::size_t nodes) {
    std::array<LcSh*, 5> line;
    const auto convert = [&](std::size_t first, std::size_t step) {
        for (std::size_t i = 0; i < nodes; ++i) line[i] = &values[first + i * step];
        bernsteinFromNodes({line.data(), nodes});
    };
    for (std::size_t row = 0; row < nodes; ++row) convert(row * nodes, 1);
    for (std::size_t column = 0; column < nodes; ++column) convert(column, nodes);
}

/// Returns the largest squared length of each band and channel among these vectors.
inline Squares largestSquares(std::span<const LcSh> each) {
    // Plain floats, so that the compiler vectorizes the sums: they are the hottest of the bounds.
    constexpr std::size_t kFloats = kCoefficients * kChannels;
    static_assert(sizeof(LcSh) == kFloats * sizeof(float));
    std::array<float, 3 * kChannels> largest{};
    for (const LcSh& sh : each) {
        std::array<float, kFloats> square;
        std::memcpy(square.data(), &sh, sizeof(sh));
        for (float& value : square) value *= value;
        std::array<float, 3 * kChannels> sums;
        for (std::size_t c = 0; c < kChannels; ++c) {
            const auto at = [&](std::size_t i) { return square[kChannels * i + c]; };
            sums[c] = at(0);
            sums[kChannels + c] = at(1) + at(2) + at(3);
            sums[2 * kChannels + c] = at(4) + at(5) + at(6) + at(7) + at(8);
        }
        // Written so that NaN stays: every comparison with it is false.
        for (std::size_t i = 0; i < sums.size(); ++i) largest[i] = sums[i] <= largest[i] ? largest[i] : sums[i];
    }
    Squares out;
    std::memcpy(&out, largest.data(), sizeof(out));
    return out;
}

/// Returns an upper bound of the root of a float sum of squares.
inline double outwardLength(float square) {
    return square == 0 ? 0 : kOutward * std::sqrt(static_cast<double>(square)) + kUnderflow;
}

/// Upper bounds of lengths, [3 band + channel], padded to whole vectors.
inline constexpr std::size_t kBandLanes = 12;
using BandLengths = std::array<float, kBandLanes>;
/// Returns the largest length of each band and channel.
inline BandLengths largestLengths(std::span<const LcSh> each) {
    const Squares squares = largestSquares(each);
    BandLengths out{};
    std::memcpy(out.data(), &squares, sizeof(squares));
    for (float& value : out) value = kOutwardFloat * std::sqrt(value) + static_cast<float>(kUnderflow);
    return out;
}
inline BandLengths bandLengths(const LcSh& sh) {
    return largestLengths({&sh, 1});
}

/// Returns the square of the exit radiance of a white surface, summed over channels and over all normals: the sum of its squared
/// coefficients.
inline double diffuseSquare(const LcSh& sh) {
    const Squares squares = largestSquares({&sh, 1});
    double sum = 0;
    for (std::size_t l = 0; l < 3; ++l)
        for (int c = 0; c < 3; ++c)
            sum += lighting::kExitRadianceBands[l] * lighting::kExitRadianceBands[l] * static_cast<double>(squares[l][c]);
    return sum;
}

/// Adds factor times the largest length of each band to `slack`.
inline void addLargestLengths(ChannelSlack& slack, std::span<const LcSh> each, double factor) {
    const Squares squares = largestSquares(each);
    for (std::size_t c = 0; c < kChannels; ++c)
        for (std::size_t l = 0; l < 3; ++l) slack[c][l] += factor * outwardLength(squares[l][static_cast<int>(c)]);
}
inline void addLengths(ChannelSlack& slack, const LcSh& sh, double factor) {
    addLargestLengths(slack, {&sh, 1}, factor);
}
inline ChannelSlack sumOf(const ChannelSlack& a, const ChannelSlack& b) {
    ChannelSlack out = a;
    for (std::size_t c = 0; c < kChannels; ++c)
        for (std::size_t l = 0; l < 3; ++l) out[c][l] += b[c][l];
    return out;
}

/// Returns the sums of four vectors for every choice of signs, up to the sign of the whole sum.
inline constexpr std::size_t kSigns = 8;
inline std::array<LcSh, kSigns> signedSumsOf(const std::array<LcSh, 4>& group) {
    std::array<LcSh, kSigns> sums;
    for (std::size_t signs = 0; signs < sums.size(); ++signs)
        for (std::size_t i = 0; i < kCoefficients; ++i) {
            glm::vec3 sum = group[3].c[i];
            for (std::size_t j = 0; j < 3; ++j) sum += (signs >> j & 1) == 0 ? group[j].c[i] : -group[j].c[i];
            sums[signs].c[i] = sum;
        }
    return sums;
}

/// Returns the largest squared lengths of the corners. A bilinear reference is nowhere longer than at a corner.
inline Squares referenceSquares(const std::array<const LcSh*, 4>& references) {
    const std::array<LcSh, 4> each = {*references[0], *references[1], *references[2], *references[3]};
    return largestSquares(each);
}
/// Adds the rounding error of control vectors to `slack`.
inline void addRounding(ChannelSlack& slack, const Squares& error, const Squares& reference) {
    for (std::size_t c = 0; c < kChannels; ++c)
        for (std::size_t l = 0; l < 3; ++l)
            slack[c][l] +=
                kControlRounding * (outwardLength(error[l][static_cast<int>(c)]) + outwardLength(reference[l][static_cast<int>(c)]));
}

}  // namespace lightcook::verify::lightmap
