// What the encoder of single channels searches at each effort, and what it finds.
#pragma once

#include <array>
#include <cstdint>

namespace lightcook::compress {

struct Bc4Search {
    int starts;            ///< of kBc4Starts, for the layout of eight steps
    int plainStarts;       ///< the same for that of six
    int nears;             ///< of kBc4Nears
    int nearStarts;        ///< the same between texels that are not near an extreme, for each of these
    int startsPerDescent;  ///< of so many, the best alone goes on
    int refits;            ///< least-squares steps from there
    int passes;            ///< of neighbours, at most
    int reach;             ///< how far a neighbour is [codes]
    bool polishEach;       ///< the last three for each group of the second layout, and not for the best of them alone
    bool sixSteps;         ///< also the layout with the least and the largest value exact
    bool exhaustive;       ///< every pair of ends in the end
};

/// What a texel's value is in codes: value * scale + offset, from 0 to the largest. The signed formats' bytes -127 .. 127 count from 0 too:
/// interpolation is linear, so whatever lies between two ends lies there still.
struct Bc4Codes {
    float scale, offset, largest;
};
inline constexpr Bc4Codes kBc4Unorm = {255, 0, 255}, kBc4Snorm = {127, 127, 254};

struct Bc4Result {
    int low = 0, high = 0;      ///< low <= high
    bool sixSteps = false;      ///< 6 values between them, and the least and the largest code
    float error = 0;            ///< squared, in codes
    std::uint64_t indices = 0;  ///< of the sixteen texels, three bits each, for these ends
    bool isConstant = false;    ///< all texels that count are alike
};

/// Shares of the range by which the low and the high end are drawn in at the start. Each is the one that lowers the error most after those
/// before it (of a hundred, over blocks of noise, narrow noise, slopes, and slopes of whole codes); the last eight fill gaps between.
inline constexpr std::array<std::array<float, 2>, 24> kBc4Starts = {
    {{0, 0},           {0.04f, 0.04f}, {-0.15f, 0.04f}, {0.08f, 0},       {0, 0.08f},    {0.04f, -0.15f}, {0.22f, 0.08f}, {-0.05f, 0},
     {0.08f, 0.22f},   {0, -0.05f},    {0.12f, 0.3f},   {0.08f, 0.08f},   {0.3f, 0.08f}, {0.04f, 0},      {0.3f, 0.22f},  {-0.1f, -0.05f},
     {-0.05f, -0.05f}, {-0.12f, 0},    {0, -0.12f},     {-0.15f, -0.15f}, {0.2f, 0.2f},  {0.2f, 0},       {0, 0.2f},      {0.12f, 0.12f}}};

/// How far from the least and the largest code texels may be that are left to them in the second layout [codes].
inline constexpr std::array<float, 4> kBc4Nears = {0.5f, 12, 4, 24};

const Bc4Search& bc4SearchOf(int effort);

}  // namespace lightcook::compress
