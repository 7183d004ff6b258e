// Light-map layouts: how the SH coefficients of a texel lie in GPU textures. The table below holds everything about a layout that can be
// said without encoding or decoding it; compress/ (encoder), verify/ (decoder) and shaders/ (GLSL) each add a function for it.
// docs/theory/layouts.md gives the decode of each as a formula.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/pixel_format.h"
#include "formats/target.h"
#include "formats/vocabulary.h"

namespace lightcook::formats {

enum class LightMapLayout {
    Raw,
    Flat,
    Ratio,
    Basis3,
    Basis4,
    Basis8,
    Basis12,
    Basis16,
    Basis20,
    Basis24,
    Sh4,
    Godot,
    MonoSh,
    Bakery,
    Hdr,
    Hdr2,
    Halo3,
    HdrRgb9e5,
    Flat2,
    UnrealHq,
    Rnm,
    Lit,
    LitHalf,
    LitQuarter
};

/// Layouts of one family share their encoder, their decoder and the shader source light_map_<family>.glsl.
enum class LightMapFamily { Raw, Flat, Ratio, Basis, Sh4, Godot, Bakery, Hdr, Halo3, Unreal, Rnm, Lit };

/// A filter makes the light between texels from that of the texels.
enum class LightMapFilter {
    Hardware,  ///< the sampler filters texels, the shader decodes the result
    Decoded    ///< the shader decodes the four texels around a place and mixes the light of those that are covered (shaders/filter.glsl)
};
struct LightMapFilterInfo {
    LightMapFilter id;
    std::string_view name;     ///< as in `[output] filter`, `--filter` and the manifest
    std::string_view caption;  ///< for help texts and documents
};
inline constexpr std::array kLightMapFilters = {
    LightMapFilterInfo{LightMapFilter::Hardware, "hardware", "the sampler filters texels, the shader decodes the result"},
    LightMapFilterInfo{LightMapFilter::Decoded, "decoded",
                       "the shader decodes the four texels around a place and mixes the light of those that are covered"}};
static_assert(isCompleteTable(kLightMapFilters, LightMapFilter::Decoded));

/// Selects the format of a target that holds the texels of a texture.
enum class TexelRole {
    Half,      ///< signed 16-bit floats on every target
    Hdr,       ///< TargetInfo::hdr
    HdrFine,   ///< TargetInfo::hdrFine
    Ldr,       ///< TargetInfo::ldr
    LdrRgb,    ///< TargetInfo::ldrRgb
    LdrAlpha,  ///< TargetInfo::ldrAlpha
};

struct LightMapTextureInfo {
    std::string_view name;  ///< in manifest and shader: "l0"
    int layerCount;         ///< of the 2-D array
    TexelRole role;
    int side = 1;  ///< of the square of the map's texels that read one of its texels [texels]
};

inline constexpr int kExtentStep = 4;  ///< of textures that are not as large as the map
/// Returns the size of a texture for a map of this size [texels]. One that is not that of the map is a multiple of a block's, as
/// graphics APIs demand of compressed textures.
/// side  LightMapTextureInfo::side
constexpr glm::ivec2 textureSize(int mapWidth, int mapHeight, int side) {
    const auto extentOf = [side](int map) { return ((map + side - 1) / side + kExtentStep - 1) / kExtentStep * kExtentStep; };
    return side == 1 ? glm::ivec2(mapWidth, mapHeight) : glm::ivec2(extentOf(mapWidth), extentOf(mapHeight));
}

/// Texels of the map in a texel of texture "coverage", a bit each: channel c has row c, its lowest bit the first column.
inline constexpr int kCoverageColumns = 8, kCoverageRows = 4;
/// Returns the size of that texture for a map of this size [texels].
constexpr glm::ivec2 coverageSize(int mapWidth, int mapHeight) {
    return {(mapWidth + kCoverageColumns - 1) / kCoverageColumns, (mapHeight + kCoverageRows - 1) / kCoverageRows};
}
/// Texture of a map whose filter is LightMapFilter::Decoded: which texels are covered.
inline constexpr std::string_view kCoverageRole = "coverage";

struct LightMapFamilyInfo {
    LightMapFamily id;
    std::string_view name;  ///< "basis", as in light_map_basis.glsl
};

struct LightMapLayoutInfo {
    LightMapLayout id;
    std::string_view name;  ///< as in `light_map_layout`, `--layout` and the manifest
    LightMapFamily family;
    std::string_view caption;                       ///< one line for help texts and documents
    std::span<const LightMapTextureInfo> textures;  ///< in the order in which encoder and decoder take them
    std::span<const std::string_view> stages;       ///< of compression, in order; the last is the whole layout
    int codeCount = 0;                              ///< numbers that the first stage of a learned layout stores; 0: not learned
    int decodeDegree;                               ///< of the decode as a polynomial of the filtered texels; 0: it is no polynomial
    int decodeOps;                                  ///< scalar multiply-adds of one decode in the shader: see operations()
    /// The layout whose trial measures this one's error; empty if "auto" does not choose this one
    std::optional<LightMapLayout> trialLayout = {};
    std::string_view trialStage = {};  ///< the stage of that trial; "total" is the last one
    /// Light of a bake that the decode cannot show; its loss counts as error where the materials need it. Empty: nothing
    std::string_view lacks = {};
    /// An engine reads the textures by its own formula. No other layout may stand in for this one.
    bool isForEngine = false;
    /// Light is stored relative to the tangents of a mesh: LightMapDescription::takesTangents.
    bool isInTangentSpace = false;
    /// Its texels hold no light that a sampler could filter: the layout has no filter but LightMapFilter::Decoded.
    bool isAlwaysDecoded = false;

    /// The textures hold exit radiance at the texel's own normal.
    constexpr bool isFlat() const { return family == LightMapFamily::Flat; }
    /// Each texel has one directional light of its own, beside which no dominant light is needed.
    constexpr bool holdsLight() const { return family == LightMapFamily::Lit; }
    /// The decode is fitted to the map.
    constexpr bool isLearned() const { return codeCount > 0; }
    /// The encoder has an objective to minimize: visible errors or energy.
    constexpr bool hasObjective() const { return isLearned() || family == LightMapFamily::Ratio; }
    /// Coefficient 0 is stored more exactly than in one texture of TargetInfo::hdr, which is what `flat` has.
    constexpr bool refinesCoefficient0() const {
        const TexelRole first = textures.front().role;
        const bool hasSecondHdr = textures.size() > 1 && textures[1].role == TexelRole::Hdr && !holdsLight();
        return first == TexelRole::Half || first == TexelRole::HdrFine || hasSecondHdr || residualCount() > 0;
    }
    /// Layers of all textures.
    constexpr int layerCount() const {
        int layers = 0;
        for (const LightMapTextureInfo& texture : textures) layers += texture.layerCount;
        return layers;
    }
    /// Returns the filter that the layout has where one is asked for.
    constexpr LightMapFilter filterFor(LightMapFilter asked) const { return isAlwaysDecoded ? LightMapFilter::Decoded : asked; }
    /// Returns true if the layout can be decoded so. The shaders of engines filter first.
    constexpr bool mayHave(LightMapFilter asked) const {
        return asked == LightMapFilter::Hardware ? !isAlwaysDecoded : !isForEngine && !isInTangentSpace;
    }
    /// Returns the filter where none is asked for. A sampler filters the factors of a decode that is not linear, and errs at hard edges.
    constexpr LightMapFilter usualFilter() const {
        const bool isLinear = decodeDegree == 1;
        return filterFor(!isLinear && mayHave(LightMapFilter::Decoded) ? LightMapFilter::Decoded : LightMapFilter::Hardware);
    }
    /// Texture fetches of a sample: one a layer, or one a layer and one of the coverage for each of four texels.
    constexpr int fetchCount(LightMapFilter asked = LightMapFilter::Hardware) const {
        return filterFor(asked) == LightMapFilter::Hardware ? layerCount() : 4 * (layerCount() + 1);
    }
    /// Scalar multiply-adds of the decode of a sample: those of decodeOps, or the weights, four decodes and the mix. Learned layouts mix
    /// first (lcMixBasis4 of shaders/light_map_basis.glsl): the light of four texels, their monomials of degree 2, and sums of four RGB
    /// products, also for the four numbers of each residual less `neutral`; then each factor counts once.
    constexpr int operations(LightMapFilter asked = LightMapFilter::Hardware) const {
        constexpr int kWeights = 16, kLight = 16, kSum = 4 * 3, kMix = 9 * kSum, kFirstSum = 3 * 3;
        if (filterFor(asked) == LightMapFilter::Hardware) return decodeOps;
        if (!isLearned()) return kWeights + 4 * decodeOps + kMix;
        const int monomials = codeFactors() / 8, squares = monomials - 1 - codeCount;
        return kWeights + kLight + 4 * squares + kFirstSum + (monomials - 1) * kSum + residualCount() * 4 * (4 + kSum) + 3 * tableFactors();
    }
    /// RGB factors of one cluster of charts, each a texel of texture "tables" of a learned layout: first quadratic polynomials of the codes
    /// for eight coefficients, then four directions of nine coefficients for each residual layer.
    constexpr int codeFactors() const { return isLearned() ? (codeCount + 1) * (codeCount + 2) / 2 * 8 : 0; }
    static constexpr int kResidualFactors = 4 * 9;
    constexpr int tableFactors() const { return codeFactors() + kResidualFactors * residualCount(); }
    /// Size of these factors as texels of RGBA16F [bytes].
    constexpr int clusterTableBytes() const { return 8 * tableFactors(); }
    /// Layers after the code of a learned layout.
    constexpr int residualCount() const { return isLearned() && textures.size() > 2 ? textures[2].layerCount : 0; }
};

inline constexpr std::array kLightMapFamilies = {
    LightMapFamilyInfo{LightMapFamily::Raw, "raw"},       LightMapFamilyInfo{LightMapFamily::Flat, "flat"},
    LightMapFamilyInfo{LightMapFamily::Ratio, "ratio"},   LightMapFamilyInfo{LightMapFamily::Basis, "basis"},
    LightMapFamilyInfo{LightMapFamily::Sh4, "sh4"},       LightMapFamilyInfo{LightMapFamily::Godot, "godot"},
    LightMapFamilyInfo{LightMapFamily::Bakery, "bakery"}, LightMapFamilyInfo{LightMapFamily::Hdr, "hdr"},
    LightMapFamilyInfo{LightMapFamily::Halo3, "halo3"},   LightMapFamilyInfo{LightMapFamily::Unreal, "unreal"},
    LightMapFamilyInfo{LightMapFamily::Rnm, "rnm"},       LightMapFamilyInfo{LightMapFamily::Lit, "lit"},
};
static_assert(isCompleteTable(kLightMapFamilies, LightMapFamily::Lit));

namespace layout_tables {

using Texture = LightMapTextureInfo;

inline constexpr std::array kRaw = {Texture{"sh", 9, TexelRole::Half}};
inline constexpr std::array kFlat = {Texture{"exit", 1, TexelRole::Hdr}};
inline constexpr std::array kFlat2 = {Texture{"exit", 1, TexelRole::Hdr}, Texture{"second", 1, TexelRole::Hdr}};
inline constexpr std::array kHalo3 = {Texture{"luvw_first", 9, TexelRole::LdrAlpha}, Texture{"luvw_second", 9, TexelRole::LdrAlpha}};
inline constexpr std::array kRatio = {Texture{"l0", 1, TexelRole::Hdr}, Texture{"ratio", 8, TexelRole::Ldr}};
inline constexpr std::array kSh4 = {Texture{"l0", 1, TexelRole::Hdr}, Texture{"ratio", 3, TexelRole::Ldr}};
inline constexpr std::array kGodot = {Texture{"sh", 4, TexelRole::Hdr}};
inline constexpr std::array kMonoSh = {Texture{"l0", 1, TexelRole::Hdr}, Texture{"l1", 1, TexelRole::Ldr}};
inline constexpr std::array kBakery = {Texture{"l0", 1, TexelRole::Hdr}, Texture{"l1x", 1, TexelRole::Ldr},
                                       Texture{"l1y", 1, TexelRole::Ldr}, Texture{"l1z", 1, TexelRole::Ldr}};
inline constexpr std::array kHdr = {Texture{"sh", 9, TexelRole::Hdr}};
inline constexpr std::array kHdr2 = {Texture{"sh", 9, TexelRole::Hdr}, Texture{"second", 9, TexelRole::Hdr}};
inline constexpr std::array kHdrFine = {Texture{"sh", 9, TexelRole::HdrFine}};
inline constexpr std::array kUnrealHq = {Texture{"lightmap0", 1, TexelRole::LdrAlpha}, Texture{"lightmap1", 1, TexelRole::LdrAlpha}};
inline constexpr std::array kRnm = {Texture{"rnm0", 1, TexelRole::Hdr}, Texture{"rnm1", 1, TexelRole::Hdr},
                                    Texture{"rnm2", 1, TexelRole::Hdr}};
template <int kSide>
inline constexpr std::array kLit = {Texture{"l0", 1, TexelRole::Hdr}, Texture{"light", 1, TexelRole::Hdr},
                                    Texture{"direction", 1, TexelRole::Ldr}, Texture{"rest", 8, TexelRole::Ldr, kSide}};
inline constexpr std::array kBasis3 = {Texture{"l0", 1, TexelRole::Hdr}, Texture{"code", 1, TexelRole::LdrRgb}};
inline constexpr std::array kBasis4 = {Texture{"l0", 1, TexelRole::Hdr}, Texture{"code", 1, TexelRole::Ldr}};
template <int kResiduals>
inline constexpr std::array kBasisResidual = {Texture{"l0", 1, TexelRole::Hdr}, Texture{"code", 1, TexelRole::Ldr},
                                              Texture{"residual", kResiduals, TexelRole::Ldr}};

inline constexpr std::array<std::string_view, 1> kRawStages = {"half"};
inline constexpr std::array<std::string_view, 1> kFlatStages = {"exit"};
inline constexpr std::array<std::string_view, 2> kTwoStages = {"stage 1", "stage 2"};
inline constexpr std::array<std::string_view, 2> kRatioStages = {"l0", "ratio"};
inline constexpr std::array<std::string_view, 2> kBandStages = {"l0", "l1"};  // bands 0 and 1
inline constexpr std::array<std::string_view, 1> kRnmStages = {"rnm"};
inline constexpr std::array<std::string_view, 3> kLitStages = {"l0", "light", "rest"};
inline constexpr std::array<std::string_view, 7> kBasisStages = {"l0",         "code",       "residual 1", "residual 2",
                                                                 "residual 3", "residual 4", "residual 5"};

}  // namespace layout_tables

inline constexpr std::array kLightMapLayouts = {
    LightMapLayoutInfo{.id = LightMapLayout::Raw,
                       .name = "raw",
                       .family = LightMapFamily::Raw,
                       .caption = "the coefficients as 16-bit floats, to compare with",
                       .textures = layout_tables::kRaw,
                       .stages = layout_tables::kRawStages,
                       .decodeDegree = 1,
                       .decodeOps = 27,
                       .trialLayout = LightMapLayout::Raw,
                       .trialStage = "total"},
    LightMapLayoutInfo{.id = LightMapLayout::Flat,
                       .name = "flat",
                       .family = LightMapFamily::Flat,
                       .caption = "exit radiance at the texel's own normal: no normal maps, no specular",
                       .textures = layout_tables::kFlat,
                       .stages = layout_tables::kFlatStages,
                       .decodeDegree = 1,
                       .decodeOps = 3,
                       .lacks = "directions: normal maps see one radiance a texel, specular light a grey sky"},
    LightMapLayoutInfo{.id = LightMapLayout::Ratio,
                       .name = "ratio",
                       .family = LightMapFamily::Ratio,
                       .caption = "coefficient 0 as HDR colour, the others divided by it",
                       .textures = layout_tables::kRatio,
                       .stages = layout_tables::kRatioStages,
                       .decodeDegree = 2,
                       .decodeOps = 51,
                       .trialLayout = LightMapLayout::Ratio,
                       .trialStage = "total"},
    LightMapLayoutInfo{.id = LightMapLayout::Basis3,
                       .name = "basis-3",
                       .family = LightMapFamily::Basis,
                       .caption = "coefficient 0 and three numbers under a learned quadratic decode",
                       .textures = layout_tables::kBasis3,
                       .stages = std::span(layout_tables::kBasisStages).first(2),
                       .codeCount = 3,
                       .decodeDegree = 3,
                       .decodeOps = 249,
                       .trialLayout = LightMapLayout::Basis3,
                       .trialStage = "total"},
    LightMapLayoutInfo{.id = LightMapLayout::Basis4,
                       .name = "basis-4",
                       .family = LightMapFamily::Basis,
                       .caption = "coefficient 0 and four numbers under a learned quadratic decode",
                       .textures = layout_tables::kBasis4,
                       .stages = std::span(layout_tables::kBasisStages).first(2),
                       .codeCount = 4,
                       .decodeDegree = 3,
                       .decodeOps = 373,
                       .trialLayout = LightMapLayout::Basis24,
                       .trialStage = "code"},
    LightMapLayoutInfo{.id = LightMapLayout::Basis8,
                       .name = "basis-8",
                       .family = LightMapFamily::Basis,
                       .caption = "basis-4 and four linear numbers of what it left",
                       .textures = layout_tables::kBasisResidual<1>,
                       .stages = std::span(layout_tables::kBasisStages).first(3),
                       .codeCount = 4,
                       .decodeDegree = 3,
                       .decodeOps = 515,
                       .trialLayout = LightMapLayout::Basis24,
                       .trialStage = "residual 1"},
    LightMapLayoutInfo{.id = LightMapLayout::Basis12,
                       .name = "basis-12",
                       .family = LightMapFamily::Basis,
                       .caption = "basis-8 and four more linear numbers",
                       .textures = layout_tables::kBasisResidual<2>,
                       .stages = std::span(layout_tables::kBasisStages).first(4),
                       .codeCount = 4,
                       .decodeDegree = 3,
                       .decodeOps = 657,
                       .trialLayout = LightMapLayout::Basis24,
                       .trialStage = "residual 2"},
    LightMapLayoutInfo{.id = LightMapLayout::Basis16,
                       .name = "basis-16",
                       .family = LightMapFamily::Basis,
                       .caption = "basis-12 and four more linear numbers",
                       .textures = layout_tables::kBasisResidual<3>,
                       .stages = std::span(layout_tables::kBasisStages).first(5),
                       .codeCount = 4,
                       .decodeDegree = 3,
                       .decodeOps = 799,
                       .trialLayout = LightMapLayout::Basis24,
                       .trialStage = "residual 3"},
    LightMapLayoutInfo{.id = LightMapLayout::Basis20,
                       .name = "basis-20",
                       .family = LightMapFamily::Basis,
                       .caption = "basis-16 and four more linear numbers",
                       .textures = layout_tables::kBasisResidual<4>,
                       .stages = std::span(layout_tables::kBasisStages).first(6),
                       .codeCount = 4,
                       .decodeDegree = 3,
                       .decodeOps = 941,
                       .trialLayout = LightMapLayout::Basis24,
                       .trialStage = "residual 4"},
    LightMapLayoutInfo{.id = LightMapLayout::Basis24,
                       .name = "basis-24",
                       .family = LightMapFamily::Basis,
                       .caption = "basis-20 and four more linear numbers",
                       .textures = layout_tables::kBasisResidual<5>,
                       .stages = std::span(layout_tables::kBasisStages).first(7),
                       .codeCount = 4,
                       .decodeDegree = 3,
                       .decodeOps = 1083,
                       .trialLayout = LightMapLayout::Basis24,
                       .trialStage = "total"},
    LightMapLayoutInfo{.id = LightMapLayout::Sh4,
                       .name = "sh4",
                       .family = LightMapFamily::Sh4,
                       .caption = "coefficient 0 and the ratios of band 1, for engines with four coefficients",
                       .textures = layout_tables::kSh4,
                       .stages = layout_tables::kRatioStages,
                       .decodeDegree = 2,
                       .decodeOps = 21,
                       .lacks = "band 2"},
    LightMapLayoutInfo{.id = LightMapLayout::Godot,
                       .name = "godot",
                       .family = LightMapFamily::Godot,
                       .caption = "the light maps of Godot 4.4 and later: L0 and L1 by colour, four HDR slices",
                       .textures = layout_tables::kGodot,
                       .stages = layout_tables::kBandStages,
                       .decodeDegree = 2,
                       .decodeOps = 21,
                       .lacks = "band 2",
                       .isForEngine = true},
    LightMapLayoutInfo{.id = LightMapLayout::MonoSh,
                       .name = "mono-sh",
                       .family = LightMapFamily::Bakery,
                       .caption = "the MonoSH light maps of Bakery for Unity: L0, and one L1 that the colours share",
                       .textures = layout_tables::kMonoSh,
                       .stages = layout_tables::kBandStages,
                       .decodeDegree = 2,
                       .decodeOps = 15,
                       .lacks = "band 2",
                       .isForEngine = true},
    LightMapLayoutInfo{.id = LightMapLayout::Bakery,
                       .name = "bakery",
                       .family = LightMapFamily::Bakery,
                       .caption = "the SH light maps of Bakery for Unity: L0, and three maps of L1 by colour",
                       .textures = layout_tables::kBakery,
                       .stages = layout_tables::kBandStages,
                       .decodeDegree = 2,
                       .decodeOps = 21,
                       .lacks = "band 2",
                       .isForEngine = true},
    LightMapLayoutInfo{.id = LightMapLayout::Hdr,
                       .name = "hdr",
                       .family = LightMapFamily::Hdr,
                       .caption = "each coefficient as HDR colour, raised by a multiple of coefficient 0: linear in its texels",
                       .textures = layout_tables::kHdr,
                       .stages = std::span(layout_tables::kTwoStages).first(1),
                       .decodeDegree = 1,
                       .decodeOps = 51,
                       .trialLayout = LightMapLayout::Hdr2,
                       .trialStage = "stage 1"},
    LightMapLayoutInfo{.id = LightMapLayout::Hdr2,
                       .name = "hdr-2",
                       .family = LightMapFamily::Hdr,
                       .caption = "hdr and a second texture of what the first one misses",
                       .textures = layout_tables::kHdr2,
                       .stages = layout_tables::kTwoStages,
                       .decodeDegree = 1,
                       .decodeOps = 105,
                       .trialLayout = LightMapLayout::Hdr2,
                       .trialStage = "total"},
    LightMapLayoutInfo{.id = LightMapLayout::Halo3,
                       .name = "halo3",
                       .family = LightMapFamily::Halo3,
                       .caption = "length and signed colour of each coefficient in two stages, as Halo 3 codes them (Hu 2008)",
                       .textures = layout_tables::kHalo3,
                       .stages = layout_tables::kTwoStages,
                       .decodeDegree = 3,
                       .decodeOps = 135,
                       .isForEngine = true},
    LightMapLayoutInfo{.id = LightMapLayout::HdrRgb9e5,
                       .name = "hdr-rgb9e5",
                       .family = LightMapFamily::Hdr,
                       .caption = "hdr in texels of their own, nine bits a channel and an exponent, in place of blocks",
                       .textures = layout_tables::kHdrFine,
                       .stages = std::span(layout_tables::kTwoStages).first(1),
                       .decodeDegree = 1,
                       .decodeOps = 51,
                       .trialLayout = LightMapLayout::HdrRgb9e5,
                       .trialStage = "total"},
    LightMapLayoutInfo{.id = LightMapLayout::Flat2,
                       .name = "flat-2",
                       .family = LightMapFamily::Flat,
                       .caption = "flat and a second texture of what the first one misses",
                       .textures = layout_tables::kFlat2,
                       .stages = layout_tables::kTwoStages,
                       .decodeDegree = 1,
                       .decodeOps = 9,
                       .lacks = "directions: normal maps see one radiance a texel, specular light a grey sky"},
    LightMapLayoutInfo{
        .id = LightMapLayout::UnrealHq,
        .name = "unreal-hq",
        .family = LightMapFamily::Unreal,
        .caption = "the high-quality light maps of Unreal: colour times log luminance, and one direction that the colours share",
        .textures = layout_tables::kUnrealHq,
        .stages = layout_tables::kBandStages,
        .decodeDegree = 0,
        .decodeOps = 28,
        .lacks = "band 2",
        .isForEngine = true},
    LightMapLayoutInfo{.id = LightMapLayout::Rnm,
                       .name = "rnm",
                       .family = LightMapFamily::Rnm,
                       .caption = "the RNM light maps of Bakery: light of the three directions of Half-Life 2 in tangent space",
                       .textures = layout_tables::kRnm,
                       .stages = layout_tables::kRnmStages,
                       .decodeDegree = 1,
                       .decodeOps = 18,
                       .lacks = "directions other than the three of its basis",
                       .isForEngine = true,
                       .isInTangentSpace = true},
    LightMapLayoutInfo{.id = LightMapLayout::Lit,
                       .name = "lit",
                       .family = LightMapFamily::Lit,
                       .caption = "coefficient 0, one light, and the ratios of the rest: decoded at the texels, then filtered",
                       .textures = layout_tables::kLit<1>,
                       .stages = layout_tables::kLitStages,
                       .decodeDegree = 1,
                       .decodeOps = 110,
                       .trialLayout = LightMapLayout::Lit,
                       .trialStage = "total",
                       .isAlwaysDecoded = true},
    LightMapLayoutInfo{.id = LightMapLayout::LitHalf,
                       .name = "lit-half",
                       .family = LightMapFamily::Lit,
                       .caption = "lit with the rest at half the size: decoded at the texels, then filtered",
                       .textures = layout_tables::kLit<2>,
                       .stages = layout_tables::kLitStages,
                       .decodeDegree = 1,
                       .decodeOps = 110,
                       .trialLayout = LightMapLayout::LitHalf,
                       .trialStage = "total",
                       .isAlwaysDecoded = true},
    LightMapLayoutInfo{.id = LightMapLayout::LitQuarter,
                       .name = "lit-quarter",
                       .family = LightMapFamily::Lit,
                       .caption = "lit with the rest at a quarter of the size: decoded at the texels, then filtered",
                       .textures = layout_tables::kLit<4>,
                       .stages = layout_tables::kLitStages,
                       .decodeDegree = 1,
                       .decodeOps = 110,
                       .trialLayout = LightMapLayout::LitQuarter,
                       .trialStage = "total",
                       .isAlwaysDecoded = true},
};
static_assert(isCompleteTable(kLightMapLayouts, LightMapLayout::LitQuarter));

/// Returns every layout, in the order of the enumeration.
constexpr std::span<const LightMapLayoutInfo> allLightMapLayouts() {
    return kLightMapLayouts;
}

constexpr const LightMapLayoutInfo& info(LightMapLayout layout) {
    return kLightMapLayouts[static_cast<std::size_t>(layout)];
}

constexpr std::optional<LightMapLayout> lightMapLayoutFromName(std::string_view name) {
    const LightMapLayoutInfo* row = findByName(allLightMapLayouts(), name);
    return row == nullptr ? std::nullopt : std::optional(row->id);
}

constexpr std::span<const LightMapFilterInfo> allLightMapFilters() {
    return kLightMapFilters;
}

/// Returns true for the name of a layout of exit radiance.
constexpr bool isFlat(std::string_view layout) {
    const auto id = lightMapLayoutFromName(layout);
    return id && info(*id).isFlat();
}

constexpr std::string_view nameOf(LightMapFamily family) {
    return kLightMapFamilies[static_cast<std::size_t>(family)].name;
}

/// Returns true for the name of a layout in tangent space.
constexpr bool isInTangentSpace(std::string_view layout) {
    const auto id = lightMapLayoutFromName(layout);
    return id && info(*id).isInTangentSpace;
}

/// Returns the names of the families of layouts, for shaders::shaderInclude(). Names that are no layout are left out.
inline std::vector<std::string> lightMapFamilies(std::span<const std::string> layouts) {
    std::vector<std::string> families;
    for (const std::string& name : layouts)
        if (const auto layout = lightMapLayoutFromName(name)) families.emplace_back(nameOf(info(*layout).family));
    return families;
}

/// Returns the format that a target has for a role.
constexpr PixelFormat formatFor(TexelRole role, const TargetInfo& target) {
    switch (role) {
        case TexelRole::Half:
            return PixelFormat::Rgba16f;
        case TexelRole::Hdr:
            return target.hdr;
        case TexelRole::HdrFine:
            return target.hdrFine;
        case TexelRole::Ldr:
            return target.ldr;
        case TexelRole::LdrRgb:
            return target.ldrRgb;
        case TexelRole::LdrAlpha:
            break;
    }
    return target.ldrAlpha;
}

/// Returns the GPU memory of a texel of the map in a layout's textures, without tables and what names the clusters [bits].
inline int textureBits(const LightMapLayoutInfo& layout, const TargetInfo& target) {
    int bits = 0;
    for (const LightMapTextureInfo& texture : layout.textures) {
        const PixelFormatInfo& format = info(formatFor(texture.role, target));
        bits += 8 * texture.layerCount * format.bytesPerBlock / (format.blockWidth * format.blockHeight * texture.side * texture.side);
    }
    if (layout.usualFilter() == LightMapFilter::Decoded) ++bits;  // of the coverage
    return bits;
}

}  // namespace lightcook::formats
