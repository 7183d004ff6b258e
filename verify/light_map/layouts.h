// The decode of each light-map layout. MapDecoder (map_decoder.h) hides which it is. Private to verify/.
//
// Each layout is a struct that names its row of formats/light_map_layout.h as kLayout. Number of layers, degree and stage names come from
// that row; the struct adds the shader's constants and functions:
//   decode(texels)                          the shader's decode of one sample
//   decodeStages(texels, reference, out)    the coefficients after each stage, the last of which is the decode, if the layout has more
//                                           than one; an early stage may have coefficients of the reference
//   at(x, y)                                learned layouts: the decode of one texel, whose constants differ from cluster to cluster
//   at(x, y), at(cluster)                   layouts in tangent space: the decode in the tangent frame of one texel
//
// To add a layout: a struct here and its place in the variant `Layout`, readConstants() in layouts.cpp, deviationOf() in deviation.h and
// CoarseBoundsOf in coarse_bound.h. A layout of an existing family is one alias: the ratio family, say, needs `using X = RatioDecode<...>`.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "formats/light_map.h"
#include "formats/light_map_layout.h"
#include "shaders/lightcook_cpp.h"
#include "verify/light_map.h"
#include "verify/light_map/rnm_residual.h"

namespace lightcook::verify::layouts {

using formats::LightMapLayout;

/// Filtered texels of every layer, in the order of the layout's textures.
template <std::size_t kLayers>
using Texels = std::array<glm::vec4, kLayers>;

/// Returns the texels as the shader's struct. Fails to compile if the table and the struct disagree on the number of layers.
template <class ShaderTexels, std::size_t kLayers>
ShaderTexels shaderTexels(const Texels<kLayers>& texels) {
    static_assert(sizeof(ShaderTexels) == sizeof(texels));
    ShaderTexels out;
    std::memcpy(&out, texels.data(), sizeof(out));
    return out;
}

/// Members that follow from the layout's row in the table.
template <LightMapLayout kId>
struct LayoutRow {
    static constexpr LightMapLayout kLayout = kId;
    static constexpr auto kLayers = static_cast<std::size_t>(formats::info(kId).layerCount());
    /// Degree of the decode as a polynomial of the filtered texels; for curved layouts 1: that of the bilinear blend which they are near
    /// to.
    static constexpr int kDegree = std::max(formats::info(kId).decodeDegree, 1);
    static constexpr std::size_t kStages = formats::info(kId).stages.size();
    /// Light after each stage.
    using Stages = std::array<shaders::LcSh, kStages>;
};

/// Sets the stages of a layout whose first texture is coefficient 0: that with the reference's higher coefficients, and the decode.
inline void setStages(const shaders::LcSh& decoded, const shaders::LcSh& reference, std::array<shaders::LcSh, 2>& out) {
    out = {reference, decoded};
    out[0].c[0] = decoded.c[0];
}

struct Raw : LayoutRow<LightMapLayout::Raw> {
    shaders::LcRawConstants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const { return shaders::lcLightMapRaw(shaderTexels<shaders::LcRawTexels>(t), k); }
};

/// Decoded as the constant environment with this exit radiance: coefficient 0 alone.
struct Flat : LayoutRow<LightMapLayout::Flat> {
    /// Constant of Y_00 as in sh.glsl: one unit in the last place below lighting::kShConstant as a float.
    static constexpr float kY0 = 0.28209479f;
    shaders::LcFlatConstants k{};
    /// The scene shades the texel's own normal alone, so that the reference is its exit radiance. Otherwise it is the whole bake, and what
    /// a flat map lacks counts as error.
    bool isOwnNormalOnly = true;

    shaders::LcSh decode(const Texels<kLayers>& t) const {
        shaders::LcSh sh{};
        sh.c[0] = shaders::lcLightMapFlat(t[0], k) / kY0;
        return sh;
    }
};

struct Flat2 : LayoutRow<LightMapLayout::Flat2> {
    shaders::LcFlat2Constants k{};
    bool isOwnNormalOnly = true;  ///< as that of Flat

    shaders::LcSh decode(const Texels<kLayers>& t) const {
        shaders::LcSh sh{};
        sh.c[0] = shaders::lcLightMapFlat2(t[0], t[1], k) / Flat::kY0;
        return sh;
    }
    /// The first stage is the decode of the first texture alone.
    void decodeStages(const Texels<kLayers>& t, const shaders::LcSh&, Stages& out) const {
        out = {shaders::LcSh{}, decode(t)};
        out[0].c[0] = shaders::lcLightMapFlat(t[0], {k.range}) / Flat::kY0;
    }
};

/// Layouts of exit radiance.
template <class Layout>
concept FlatFamily = formats::info(Layout::kLayout)
.isFlat();

/// Two texels for each coefficient, [first..., second...].
struct Halo3 : LayoutRow<LightMapLayout::Halo3> {
    shaders::LcHalo3Constants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const { return shaders::lcLightMapHalo3(shaderTexels<shaders::LcHalo3Texels>(t), k); }
    /// The first stage is the decode of the first texture alone.
    void decodeStages(const Texels<kLayers>& t, const shaders::LcSh&, Stages& out) const {
        out = {shaders::lcLightMapHalo3First(shaderTexels<shaders::LcHalo3Texels>(t), k), decode(t)};
    }
};

/// Layouts that store coefficient 0 and ratios of others to it: [l0, ratio...].
template <class Layout>
concept RatioFamily = requires {
    Layout::kRatioCount;
};

/// Layouts of the ratio family: kDecode is the shader's decode of all coefficients.
template <LightMapLayout kId, class ShaderTexels, class Constants, auto kDecode>
struct RatioDecode : LayoutRow<kId> {
    using LayerTexels = Texels<LayoutRow<kId>::kLayers>;
    static constexpr std::size_t kRatioCount = LayoutRow<kId>::kLayers - 1;
    static_assert(std::extent_v<decltype(Constants::scale)> == kRatioCount && std::extent_v<decltype(Constants::bias)> == kRatioCount);
    Constants k{};

    shaders::LcSh decode(const LayerTexels& t) const { return kDecode(shaderTexels<ShaderTexels>(t), k); }
    /// Ideal ratios would restore the reference's higher coefficients, which the first stage has.
    void decodeStages(const LayerTexels& t, const shaders::LcSh& reference, typename LayoutRow<kId>::Stages& out) const {
        setStages(decode(t), reference, out);
    }
};

using Ratio = RatioDecode<LightMapLayout::Ratio, shaders::LcRatioTexels, shaders::LcRatioConstants, shaders::lcLightMapRatio>;

using Sh4 = RatioDecode<LightMapLayout::Sh4, shaders::LcSh4Texels, shaders::LcSh4Constants, shaders::lcLightMapSh4>;

/// Layouts of exit radiance as a linear function of the normal, without constants (families godot and bakery): L0, and L1 over it as
/// numbers u in [0, 1]:
/// c_0 = kFirst L0, c_i = kSlope L0 (u_i - 1/2). The layout's unit(t, i) picks u_i, i = 1 .. 3, from its texels.
template <class Layout>
concept LinearExitLayout = requires {
    Layout::kSlope;
};

/// Members of every such layout. kExtent is |L1| / L0 at u = 1; kDecode is the shader's decode.
template <LightMapLayout kId, class ShaderTexels, auto kDecode, int kExtent>
struct LinearExitRow : LayoutRow<kId> {
    using LayerTexels = Texels<LayoutRow<kId>::kLayers>;
    /// The shader's factors, rounded up.
    static constexpr float kFirst = 3.544908f, kSlope = 2 * kExtent * 3.069981f;

    shaders::LcSh decode(const LayerTexels& t) const { return kDecode(shaderTexels<ShaderTexels>(t)); }
    void decodeStages(const LayerTexels& t, const shaders::LcSh& reference, typename LayoutRow<kId>::Stages& out) const {
        setStages(decode(t), reference, out);
    }
};

struct Godot : LinearExitRow<LightMapLayout::Godot, shaders::LcGodotTexels, shaders::lcLightMapGodot, 4> {
    static glm::vec3 unit(const LayerTexels& t, std::size_t i) { return glm::vec3(t[i]); }
};

struct MonoSh : LinearExitRow<LightMapLayout::MonoSh, shaders::LcMonoShTexels, shaders::lcLightMapMonoSh, 2> {
    static glm::vec3 unit(const LayerTexels& t, std::size_t i) { return glm::vec3(t[1][static_cast<int>(i % 3)]); }
};

struct Bakery : LinearExitRow<LightMapLayout::Bakery, shaders::LcBakeryTexels, shaders::lcLightMapBakery, 2> {
    static glm::vec3 unit(const LayerTexels& t, std::size_t i) { return glm::vec3(t[1 + i % 3]); }
};

/// Layouts that store all coefficients as HDR colours: [sh..., second...].
template <class Layout>
concept HdrFamily = formats::info(Layout::kLayout)
.family == formats::LightMapFamily::Hdr;

struct Hdr : LayoutRow<LightMapLayout::Hdr> {
    shaders::LcHdrConstants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const { return shaders::lcLightMapHdr(shaderTexels<shaders::LcHdrTexels>(t), k); }
};

struct HdrRgb9e5 : LayoutRow<LightMapLayout::HdrRgb9e5> {
    shaders::LcHdrRgb9e5Constants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const {
        return shaders::lcLightMapHdrRgb9e5(shaderTexels<shaders::LcHdrRgb9e5Texels>(t), k);
    }
};

struct Hdr2 : LayoutRow<LightMapLayout::Hdr2> {
    shaders::LcHdr2Constants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const { return shaders::lcLightMapHdr2(shaderTexels<shaders::LcHdr2Texels>(t), k); }
    /// The first stage is the decode of the first texture alone.
    void decodeStages(const Texels<kLayers>& t, const shaders::LcSh&, Stages& out) const {
        out = {shaders::lcLightMapHdr2First(shaderTexels<shaders::LcHdr2Texels>(t), k), decode(t)};
    }
};

/// Layouts whose decode is no polynomial of the texels at all. In a part of a quad it is within curvatureOf() (curvature.h) of the bilinear
/// blend of its values at the corners of the part.
template <class Layout>
concept Curved = formats::info(Layout::kLayout)
.decodeDegree == 0;

/// Unreal: c_i = factor_i L(E) U(root) SH_i with E and SH linear in the texels, L = 2^E - kBlack and U = root^2 scale + add.
struct UnrealHq : LayoutRow<LightMapLayout::UnrealHq> {
    shaders::LcUnrealHqConstants k{};
    /// The shader's numbers; factors are rounded up. Component i of SH is that of coefficient (i + 1) % 4.
    static constexpr float kBlack = 0.01858136f, kFirst = 3.544908f, kLinear = 3.069981f;

    shaders::LcSh decode(const Texels<kLayers>& t) const {
        return shaders::lcLightMapUnrealHq(shaderTexels<shaders::LcUnrealHqTexels>(t), k);
    }
    /// The first stage has coefficient 0 of the first texture alone.
    void decodeStages(Texels<kLayers> t, const shaders::LcSh& reference, Stages& out) const {
        out = {reference, decode(t)};
        t[1].w = 0.5f;
        out[0].c[0] = decode(t).c[0];
    }
};

/// The tangent frames of a strip. Each of its texels is a cluster of its own.
struct TangentFrames {
    struct Frame {
        glm::vec3 tangent, bitangent, normal;
        friend bool operator==(const Frame&, const Frame&) = default;
    };
    const formats::LightMapStrip* strip = nullptr;  ///< with tangents

    std::size_t clusterAt(int x, int y) const {
        return static_cast<std::size_t>(y - strip->firstRow) * static_cast<std::size_t>(strip->normal.width()) +
               static_cast<std::size_t>(x);
    }
    Frame at(std::size_t cluster) const {
        const glm::vec3& normal = strip->normal.texels()[cluster];
        const glm::vec4& tangent = strip->tangent.texels()[cluster];
        return {glm::vec3(tangent), tangent.w * glm::cross(normal, glm::vec3(tangent)), normal};
    }
};

/// Layouts in tangent space. The decode to coefficients has what specular light takes; diffuse light is the engine's own function of the
/// normal, which no coefficients have. Over the hemisphere it is within kResidual R_i of what they show, summed over the directions
/// (rnm_residual.h).
template <class Layout>
concept InTangentSpace = formats::info(Layout::kLayout)
.isInTangentSpace;

struct Rnm : LayoutRow<LightMapLayout::Rnm> {
    using LayerTexels = Texels<kLayers>;
    static constexpr auto kResidual = static_cast<float>(RnmResidual::kLargest);
    TangentFrames frames;

    struct Decode {
        TangentFrames::Frame frame;

        shaders::LcSh decode(const LayerTexels& t) const {
            return shaders::lcLightMapRnm(shaderTexels<shaders::LcRnmTexels>(t), frame.tangent, frame.bitangent, frame.normal);
        }
        /// Returns what a white surface with a normal in world axes shows.
        glm::vec3 exitRadiance(const LayerTexels& t, const glm::vec3& n) const {
            const glm::vec3 inTangents(glm::dot(frame.tangent, n), glm::dot(frame.bitangent, n), glm::dot(frame.normal, n));
            return shaders::lcRnmExitRadiance(shaderTexels<shaders::LcRnmTexels>(t), inTangents);
        }
    };
    Decode at(std::size_t cluster) const { return {frames.at(cluster)}; }
    Decode at(int x, int y) const { return at(frames.clusterAt(x, y)); }
};

/// Layouts of one light and the rest: [l0, light, direction, rest...]. Their texels are decoded before they are mixed.
template <LightMapLayout kId>
struct LitDecode : LayoutRow<kId> {
    using LayerTexels = Texels<LayoutRow<kId>::kLayers>;
    shaders::LcLitConstants k{};

    shaders::LcSh decode(const LayerTexels& t) const { return shaders::lcLightMapLit(shaderTexels<shaders::LcLitTexels>(t), k); }
    /// The first stage has the decoded coefficient 0 and the reference's higher coefficients, the second one those of the light in their
    /// place.
    void decodeStages(const LayerTexels& t, const shaders::LcSh& reference, typename LayoutRow<kId>::Stages& out) const {
        const shaders::LcLitConstants lightAlone{k.range, {}, {}};
        out = {reference, shaders::lcLightMapLit(shaderTexels<shaders::LcLitTexels>(t), lightAlone), decode(t)};
        out[0].c[0] = out[1].c[0];
    }
};
/// Layouts whose texels are decoded before they are mixed.
template <class Layout>
concept DecodedBeforeFilter = formats::info(Layout::kLayout)
.isAlwaysDecoded;

/// Constants of the learned layouts "basis-K".
struct BasisTables {
    std::vector<shaders::LcBasisFirst3> first3;                   ///< [cluster], for three codes; or
    std::vector<shaders::LcBasisFirst4> first4;                   ///< [cluster], for four codes
    std::vector<std::vector<shaders::LcBasisResidual>> residual;  ///< [layer][cluster]
    std::vector<std::uint8_t> index;                              ///< cluster of each block, row by row
    int blockSide = 4, blocksAcross = 0;
    float range = 1, neutral = 0;

    std::size_t clusterAt(int x, int y) const {
        return index[static_cast<std::size_t>(y / blockSide) * static_cast<std::size_t>(blocksAcross) +
                     static_cast<std::size_t>(x / blockSide)];
    }
};

/// The learned layouts: coefficient 0, kCodeCount codes, then kResidualCount layers of four linear numbers: [l0, code, residual...].
template <LightMapLayout kId>
struct Basis : LayoutRow<kId> {
    static constexpr int kCodeCount = formats::info(kId).codeCount;
    static constexpr auto kResidualCount = static_cast<std::size_t>(formats::info(kId).residualCount());
    static_assert(kCodeCount == 3 || kCodeCount == 4);
    static_assert(LayoutRow<kId>::kLayers == 2 + kResidualCount && LayoutRow<kId>::kStages == 2 + kResidualCount);
    using LayerTexels = Texels<LayoutRow<kId>::kLayers>;
    std::shared_ptr<const BasisTables> tables;

    struct Decode {
        const BasisTables* tables;
        std::size_t cluster;
        shaders::LcSh first(const LayerTexels& t) const {
            if constexpr (kCodeCount == 3) return shaders::lcLightMapBasis3(t[0], t[1], tables->first3[cluster], tables->range);
            return shaders::lcLightMapBasis4(t[0], t[1], tables->first4[cluster], tables->range);
        }
        shaders::LcSh add(const shaders::LcSh& sh, const LayerTexels& t, std::size_t layer) const {
            return shaders::lcLightMapBasisAdd(sh, t[0], t[2 + layer], tables->residual[layer][cluster], tables->range, tables->neutral);
        }
        shaders::LcSh decode(const LayerTexels& t) const {
            shaders::LcSh sh = first(t);
            for (std::size_t layer = 0; layer < kResidualCount; ++layer) sh = add(sh, t, layer);
            return sh;
        }
        /// The first stage has the decoded coefficient 0 and the reference's higher coefficients, the second one no residual, and each one
        /// after it a layer more.
        void decodeStages(const LayerTexels& t, const shaders::LcSh& reference, typename LayoutRow<kId>::Stages& out) const {
            out[0] = reference;
            out[1] = first(t);
            out[0].c[0] = out[1].c[0];
            for (std::size_t layer = 0; layer < kResidualCount; ++layer) out[2 + layer] = add(out[1 + layer], t, layer);
        }
        friend bool operator==(const Decode&, const Decode&) = default;
    };
    Decode at(int x, int y) const { return {tables.get(), tables->clusterAt(x, y)}; }
};

/// One alternative for each layout, in the order of the enumeration.
using Layout = std::variant<Raw, Flat, Ratio, Basis<LightMapLayout::Basis3>, Basis<LightMapLayout::Basis4>, Basis<LightMapLayout::Basis8>,
                            Basis<LightMapLayout::Basis12>, Basis<LightMapLayout::Basis16>, Basis<LightMapLayout::Basis20>,
                            Basis<LightMapLayout::Basis24>, Sh4, Godot, MonoSh, Bakery, Hdr, Hdr2, Halo3, HdrRgb9e5, Flat2, UnrealHq, Rnm,
                            LitDecode<LightMapLayout::Lit>, LitDecode<LightMapLayout::LitHalf>, LitDecode<LightMapLayout::LitQuarter>>;

/// Returns true if the variant has one alternative for each row of the table, in its order.
template <std::size_t... kIndices>
constexpr bool hasEveryLayout(std::index_sequence<kIndices...>) {
    return sizeof...(kIndices) == formats::allLightMapLayouts().size() &&
           (... && (std::variant_alternative_t<kIndices, Layout>::kLayout == formats::allLightMapLayouts()[kIndices].id));
}
static_assert(hasEveryLayout(std::make_index_sequence<std::variant_size_v<Layout>>()));

/// Returns the row of a layout in the table.
inline const formats::LightMapLayoutInfo& infoOf(const Layout& layout) {
    return formats::allLightMapLayouts()[layout.index()];
}

/// Returns the decode of the texel at (x, y).
template <class AnyLayout>
decltype(auto) decodeAt(const AnyLayout& layout, int x, int y) {
    if constexpr (requires { layout.at(x, y); })
        return layout.at(x, y);
    else
        return (layout);
}

/// Returns the layout that the map names, with its constants. Fails for unknown layouts, and for constants that are missing, of wrong size
/// or not finite.
formats::Result<Layout> layoutOf(const CookedLightMap& map);
/// Returns the textures of a layout.
std::vector<LightMapVerifier::TextureNeed> texturesOf(const Layout& layout);

}  // namespace lightcook::verify::layouts
