// The decode of each layout, as the verifier's templates see it: which texels, of which degree, by which shader function. Private to
// verify/.
#pragma once

#include <array>
#include <cmath>
#include <cstring>
#include <glm/vec4.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "shaders/lightcook_cpp.h"
#include "verify/light_map.h"

namespace verify::layouts {

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
    static constexpr const char* kEarlyStage = nullptr;
    static constexpr const char* kFinalStage = "half";
    shaders::LcRawConstants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const { return shaders::lcLightMapRaw(shaderTexels<shaders::LcRawTexels>(t), k); }
};

/// Told as the constant environment that has this exit radiance: then coefficient 0 is all that there is, for the reference too.
struct Flat {
    static constexpr std::size_t kLayers = 1;
    static constexpr int kDegree = 1;
    static constexpr const char* kEarlyStage = nullptr;
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
    static constexpr const char* kEarlyStage = "stage 1";
    static constexpr const char* kFinalStage = "stage 2";
    shaders::LcLuvwConstants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const { return shaders::lcLightMapLuvw(shaderTexels<shaders::LcLuvwTexels>(t), k); }
    /// What the first texture gives alone.
    shaders::LcSh decodeEarly(const Texels<kLayers>& t, const shaders::LcSh&) const {
        return shaders::lcLightMapLuvwFirst(shaderTexels<shaders::LcLuvwTexels>(t), k);
    }
};

struct Ratio {
    static constexpr std::size_t kLayers = 9;
    static constexpr int kDegree = 2;
    static constexpr const char* kEarlyStage = "l0";
    static constexpr const char* kFinalStage = "ratio";
    shaders::LcRatioConstants k{};

    shaders::LcSh decode(const Texels<kLayers>& t) const { return shaders::lcLightMapRatio(shaderTexels<shaders::LcRatioTexels>(t), k); }
    /// The error of L0 by itself: the higher coefficients are the reference's, which ideal ratios to the decoded L0 would restore.
    shaders::LcSh decodeEarly(const Texels<kLayers>& t, const shaders::LcSh& reference) const {
        shaders::LcSh sh = reference;
        sh.c[0] = decode(t).c[0];
        return sh;
    }
};

using Layout = std::variant<Raw, Flat, Luvw, Ratio>;

/// Refuses unknown layouts, missing constants, wrong counts and values that are not finite.
formats::Result<Layout> layoutOf(const CookedLightMap& map);
std::vector<LightMapVerifier::TextureNeed> texturesOf(const Layout& layout);

}  // namespace verify::layouts
