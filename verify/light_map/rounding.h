// Rounding allowances of the bounds of light maps: what each covers, and why it is large enough. A float operation errs by at most
// u = 2^-24 = 6e-8 of its result. Those of the PQ curve are in visible_metric.cpp. Private to verify/.
#pragma once

namespace lightcook::verify::lightmap {

/// Error of a control vector over the lengths of error and reference. Covers the float evaluation of the decode at the nodes and the
/// conversion to Bernstein form, which magnifies rounding by at most 6 for each axis up to degree 3: 36 times nine roundings of u.
inline constexpr double kControlRounding = 2e-5;
/// Factor of kControlRounding at rims of charts (place_light.h), where the degree is one more and control vectors are divided by the weight
/// of the covered texels. Covers the conversion, which magnifies rounding by 5.7 for each axis at degree 3 and by 15.3 at degree 4, and a
/// weight of at least 1/4: 4 (15.3 / 5.7)^2 = 28.8.
inline constexpr double kRimFactor = 32;

/// Error of light shaded in floats, over the product of the lengths of kernel and light. Covers sums of nine products, since each term
/// passes at most ten roundings of u, and as much again for kernels and radii that are rounded to floats.
inline constexpr double kShadingRounding = 2e-6;

/// Error of a band that lcLocalSh() rotates in floats, over its length. Covers five coefficients, each of which passes about ten roundings:
/// 10 sqrt(5) u = 1.4e-6.
inline constexpr double kRotationRounding = 2e-6;

/// Factors that round a length up, in doubles and in floats. They cover up to 160 float operations between non-negative numbers: a sum of
/// squares, its root, and sums of such lengths.
inline constexpr double kOutward = 1 + 1e-5;
inline constexpr float kOutwardFloat = 1 + 1e-5f;

/// Factor that rounds a factor of Unreal's decode up (deviation.h). Covers its few float operations, which are fewer than 16, and the
/// rounding of an exponent E below 128 in 2^E: 2.7e-6, half a unit in the last place of E times ln 2.
/// UnrealFactors::exponentialRounding() covers the errors of the decode's own 2^E and E.
inline constexpr float kOutwardUnreal = 1 + 5e-6f;

/// Added to a length whose square may underflow: floats below 2^-63 = 1.1e-19 have squares that are subnormal or 0, and five of them have a
/// length of at most 2.5e-19.
inline constexpr double kUnderflow = 1e-18;

}  // namespace lightcook::verify::lightmap
