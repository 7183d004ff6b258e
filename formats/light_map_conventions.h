// Conventions of the numbers in a light map file: sign, frame, axes, quantity, units, encoding. A convention is a property of a file;
// inside the program all coefficients are canonical (the first row of each table). The axes, which are no table, are in bake_axes.h.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

#include "formats/bake_axes.h"
#include "formats/vocabulary.h"

namespace lightcook::formats {

/// Sign convention of the real SH basis: scene key `phase`.
enum class ShPhase { None, CondonShortley };
/// Frame of the coefficients: scene key `frame`.
enum class ShFrame { World, Tangent };
/// Quantity that the coefficients expand: scene key `quantity`.
enum class ShQuantity { Radiance, Irradiance };
/// Units of the light sources of the bake: scene key `light_units`.
enum class LightUnits { Radiometric, Game };
/// Encoding of the colours of a picture of 8 or 16 bits: scene key `encoding`. Auto: the file is no such picture.
enum class LightEncoding { Auto, None, Rgbm, Dldr, Srgb };
/// Sources of the texels that lie inside charts: scene key `coverage`.
enum class CoverageSource { File, Mesh, Light };

template <class Enum>
struct ConventionInfo {
    Enum id;
    std::string_view name;     ///< as in the scene file and on the command line
    std::string_view caption;  ///< for help texts and documents
};

inline constexpr std::array kShPhases = {
    ConventionInfo<ShPhase>{ShPhase::None, "none", "no Condon-Shortley signs"},
    ConventionInfo<ShPhase>{ShPhase::CondonShortley, "condon-shortley", "coefficients 1, 3, 5 and 7 are negated"},
};
static_assert(isCompleteTable(kShPhases, ShPhase::CondonShortley));

inline constexpr std::array kShFrames = {
    ConventionInfo<ShFrame>{ShFrame::World, "world", "world axes"},
    ConventionInfo<ShFrame>{ShFrame::Tangent, "tangent", "the tangent frame of each texel's normal (Duff and others 2017)"},
};
static_assert(isCompleteTable(kShFrames, ShFrame::Tangent));

inline constexpr std::array kShQuantities = {
    ConventionInfo<ShQuantity>{ShQuantity::Radiance, "radiance", "incident radiance"},
    ConventionInfo<ShQuantity>{ShQuantity::Irradiance, "irradiance", "convolved with the clamped cosine, [pi, 2 pi / 3, pi / 4] by band"},
};
static_assert(isCompleteTable(kShQuantities, ShQuantity::Irradiance));

inline constexpr std::array kLightUnits = {
    ConventionInfo<LightUnits>{LightUnits::Radiometric, "radiometric", "radiometric units"},
    ConventionInfo<LightUnits>{LightUnits::Game, "game", "light sources without their pi: pi times the stored value is radiometric"},
};
static_assert(isCompleteTable(kLightUnits, LightUnits::Game));

inline constexpr std::array kLightEncodings = {
    ConventionInfo<LightEncoding>{LightEncoding::Auto, "auto", "HDR values as stored; pictures of 8 or 16 bits are refused"},
    ConventionInfo<LightEncoding>{LightEncoding::None, "none", "values as stored, scene-linear: v / 255 of 8 bits, v / 65535 of 16 bits"},
    ConventionInfo<LightEncoding>{LightEncoding::Rgbm, "rgbm", "Unity's RGBM: the sRGB curve of R, G, B times (5 A)^2.2"},
    ConventionInfo<LightEncoding>{LightEncoding::Dldr, "dldr", "Unity's double LDR: the sRGB curve of R, G, B times 4.59, which is 2^2.2"},
    ConventionInfo<LightEncoding>{LightEncoding::Srgb, "srgb", "the sRGB curve of R, G, B: light as a display shows it"},
};
static_assert(isCompleteTable(kLightEncodings, LightEncoding::Srgb));

inline constexpr std::array kCoverageSources = {
    ConventionInfo<CoverageSource>{CoverageSource::File, "file", "channel coverage.Y, or alpha of a picture; without either all texels"},
    ConventionInfo<CoverageSource>{CoverageSource::Mesh, "mesh", "the triangles of the mesh, which give normals too if the file has none"},
    ConventionInfo<CoverageSource>{CoverageSource::Light, "light",
                                   "texels with light, and black ones between such: other black texels are gaps"},
};
static_assert(isCompleteTable(kCoverageSources, CoverageSource::Light));

/// Returns the table of a convention: `conventions<ShPhase>()`.
template <class Enum>
constexpr std::span<const ConventionInfo<Enum>> conventions();
template <>
constexpr std::span<const ConventionInfo<ShPhase>> conventions<ShPhase>() {
    return kShPhases;
}
template <>
constexpr std::span<const ConventionInfo<ShFrame>> conventions<ShFrame>() {
    return kShFrames;
}
template <>
constexpr std::span<const ConventionInfo<ShQuantity>> conventions<ShQuantity>() {
    return kShQuantities;
}
template <>
constexpr std::span<const ConventionInfo<LightUnits>> conventions<LightUnits>() {
    return kLightUnits;
}
template <>
constexpr std::span<const ConventionInfo<LightEncoding>> conventions<LightEncoding>() {
    return kLightEncodings;
}

template <>
constexpr std::span<const ConventionInfo<CoverageSource>> conventions<CoverageSource>() {
    return kCoverageSources;
}

template <class Enum>
constexpr std::string_view nameOfConvention(Enum convention) {
    return conventions<Enum>()[static_cast<std::size_t>(convention)].name;
}

template <class Enum>
constexpr std::optional<Enum> conventionFromName(std::string_view name) {
    const ConventionInfo<Enum>* row = findByName(conventions<Enum>(), name);
    return row == nullptr ? std::nullopt : std::optional(row->id);
}

}  // namespace lightcook::formats
