// The decode of each layout, as the verifier's templates see it: which texels, of which degree, by which shader function, and what stages
// lie before the last. Where the constants differ from chart to chart, at(x, y) gives the decode of a texel. Private to verify/.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/vec4.hpp>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "shaders/lightcook_cpp.h"
#include "verify/light_map.h"

namespace lightcook::verify::layouts {

/// Filtered texels of every layer, in the order of the layout's textures.
template <std::size_t kLayers>
using Texels = std::array<glm::vec4, kLayers>;

template <class ShaderTexels, std::size_t kLayers>
ShaderTexels shaderTexels(const Texels<kLayers>& texels) {
    static_assert(sizeof(ShaderTexels) == sizeof(texels));
    ShaderTexels out;
    std::memcpy(&out, texels.data(), sizeof(out));
    return out;
}

struct Raw {
    static constexpr std::size_t kLayers = 9;
    static constexpr int kDegree = 1;
    static constexpr std::array<const char*, 0> kEarlyStages = {};
    static constexpr const char* kFinalStage = "half";
    shaders::LcRawConstants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const { return shaders::lcLightMapRaw(shaderTexels<shaders::LcRawTexels>(t), k); }
};

/// Told as the constant environment that has this exit radiance: then coefficient 0 is all that there is, for the reference too.
struct Flat {
    static constexpr std::size_t kLayers = 1;
    static constexpr int kDegree = 1;
    static constexpr std::array<const char*, 0> kEarlyStages = {};
    static constexpr const char* kFinalStage = "exit";
    shaders::LcFlatConstants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const {
        shaders::LcSh sh{};
        sh.c[0] = shaders::lcLightMapFlat(t[0], k) / kY0;
        return sh;
    }
    static constexpr float kY0 = 0.28209479f;
};

struct Luvw {
    static constexpr std::size_t kLayers = 18;
    static constexpr int kDegree = 3;
    static constexpr std::array<const char*, 1> kEarlyStages = {"stage 1"};
    static constexpr const char* kFinalStage = "stage 2";
    shaders::LcLuvwConstants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const { return shaders::lcLightMapLuvw(shaderTexels<shaders::LcLuvwTexels>(t), k); }
    /// What the first texture gives alone.
    shaders::LcSh decodeEarly(std::size_t, const Texels<kLayers>& t, const shaders::LcSh&) const {
        return shaders::lcLightMapLuvwFirst(shaderTexels<shaders::LcLuvwTexels>(t), k);
    }
};

struct Ratio {
    static constexpr std::size_t kLayers = 9;
    static constexpr int kDegree = 2;
    static constexpr std::array<const char*, 1> kEarlyStages = {"l0"};
    static constexpr const char* kFinalStage = "ratio";
    shaders::LcRatioConstants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const { return shaders::lcLightMapRatio(shaderTexels<shaders::LcRatioTexels>(t), k); }
    /// The error of L0 by itself: the higher coefficients are the reference's, which ideal ratios to the decoded L0 would restore.
    shaders::LcSh decodeEarly(std::size_t, const Texels<kLayers>& t, const shaders::LcSh& reference) const {
        shaders::LcSh sh = reference;
        sh.c[0] = decode(t).c[0];
        return sh;
    }
};

/// Layouts whose band 2 follows the axis of their filtered band 1 are not polynomials. bands() is what the textures say as it is, a
/// polynomial of degree kDegree: bands 0 and 1, and the zonal coefficient in c[4]; decode is lcZonalBand2 of it.
template <class Layout>
concept Zonal = requires(const Layout& layout) {
    layout.bands(Texels<Layout::kLayers>{});
};

struct LuvwLinear {
    static constexpr std::size_t kLayers = 10;
    static constexpr int kDegree = 3;
    static constexpr std::array<const char*, 1> kEarlyStages = {"stage 1"};
    static constexpr const char* kFinalStage = "stage 2";
    shaders::LcLuvwLinearConstants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const {
        return shaders::lcLightMapLuvwLinear(shaderTexels<shaders::LcLuvwLinearTexels>(t), k);
    }
    shaders::LcSh bands(const Texels<kLayers>& t) const {
        return shaders::lcLuvwLinearBands(shaderTexels<shaders::LcLuvwLinearTexels>(t), k);
    }
    /// What the first texture gives alone.
    shaders::LcSh decodeEarly(std::size_t, const Texels<kLayers>& t, const shaders::LcSh&) const {
        return shaders::lcLightMapLuvwLinearFirst(shaderTexels<shaders::LcLuvwLinearTexels>(t), k);
    }
};

struct Zh3 {
    static constexpr std::size_t kLayers = 5;
    static constexpr int kDegree = 2;
    static constexpr std::array<const char*, 2> kEarlyStages = {"l0", "ratio"};
    static constexpr const char* kFinalStage = "zonal";
    shaders::LcZh3Constants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const { return shaders::lcLightMapZh3(shaderTexels<shaders::LcZh3Texels>(t), k); }
    shaders::LcSh bands(const Texels<kLayers>& t) const { return shaders::lcZh3Bands(shaderTexels<shaders::LcZh3Texels>(t), k); }
    /// The error of L0, then of L0 and band 1, by themselves: what is higher is the reference's.
    shaders::LcSh decodeEarly(std::size_t stage, const Texels<kLayers>& t, const shaders::LcSh& reference) const {
        const shaders::LcSh decoded = bands(t);
        shaders::LcSh sh = reference;
        for (int i = 0; i < (stage == 0 ? 1 : 4); ++i) sh.c[i] = decoded.c[i];
        return sh;
    }
};

/// Tables of layouts "basis-K", by cluster.
struct BasisTables {
    std::vector<shaders::LcBasisFirst3> first3;                   ///< [cluster], or:
    std::vector<shaders::LcBasisFirst4> first4;                   ///< [cluster]
    std::vector<std::vector<shaders::LcBasisResidual>> residual;  ///< [layer][cluster]
    std::vector<std::uint8_t> index;                              ///< [4 x 4 block], row by row
    int blocksAcross = 0;
    float range = 1, neutral = 0;

    std::size_t clusterAt(int x, int y) const {
        return index[static_cast<std::size_t>(y / 4) * static_cast<std::size_t>(blocksAcross) + static_cast<std::size_t>(x / 4)];
    }
};

/// The learned layouts: kCodes numbers of the first stage, kResiduals layers of four after it.
template <int kCodes, std::size_t kResiduals>
struct Basis {
    static constexpr std::size_t kLayers = 2 + kResiduals;
    static constexpr int kDegree = 3;
    static constexpr int kCodeCount = kCodes;
    static constexpr std::size_t kResidualCount = kResiduals;
    /// Each stage but the last: "l0", "code", "residual 1" ...
    static constexpr std::array<const char*, 5> kStageNames = {"l0", "code", "residual 1", "residual 2", "residual 3"};
    static constexpr auto kEarlyStages = [] {
        std::array<const char*, 1 + kResiduals> early{};
        for (std::size_t i = 0; i < early.size(); ++i) early[i] = kStageNames[i];
        return early;
    }();
    static constexpr const char* kFinalStage = kStageNames[1 + kResiduals];
    std::shared_ptr<const BasisTables> tables;

    struct Decode {
        const BasisTables* tables;
        std::size_t cluster;
        shaders::LcSh first(const Texels<kLayers>& t) const {
            if constexpr (kCodes == 3) return shaders::lcLightMapBasis3(t[0], t[1], tables->first3[cluster], tables->range);
            return shaders::lcLightMapBasis4(t[0], t[1], tables->first4[cluster], tables->range);
        }
        shaders::LcSh decode(const Texels<kLayers>& t, std::size_t layers = kResiduals) const {
            shaders::LcSh sh = first(t);
            for (std::size_t layer = 0; layer < layers; ++layer)
                sh = shaders::lcLightMapBasisAdd(sh, t[0], t[2 + layer], tables->residual[layer][cluster], tables->range, tables->neutral);
            return sh;
        }
        /// Stage 0: the error of L0 by itself. Then the code, and one layer of the residual more each.
        shaders::LcSh decodeEarly(std::size_t stage, const Texels<kLayers>& t, const shaders::LcSh& reference) const {
            if (stage > 0) return decode(t, stage - 1);
            shaders::LcSh sh = reference;
            sh.c[0] = first(t).c[0];
            return sh;
        }
        friend bool operator==(const Decode&, const Decode&) = default;
    };
    Decode at(int x, int y) const { return {tables.get(), tables->clusterAt(x, y)}; }
};

using Layout = std::variant<Raw, Flat, Luvw, LuvwLinear, Ratio, Zh3, Basis<3, 0>, Basis<4, 0>, Basis<4, 1>, Basis<4, 2>, Basis<4, 3>>;

/// The decode of the texel at (x, y).
template <class AnyLayout>
decltype(auto) decodeAt(const AnyLayout& layout, int x, int y) {
    if constexpr (requires { layout.at(x, y); })
        return layout.at(x, y);
    else
        return (layout);
}

/// Refuses unknown layouts, missing constants, wrong counts and values that are not finite.
formats::Result<Layout> layoutOf(const CookedLightMap& map);
std::vector<LightMapVerifier::TextureNeed> texturesOf(const Layout& layout);

}  // namespace lightcook::verify::layouts
