// How far the control vectors of a quad can be from the bilinear ones of its corners, and what a sampler is free to do there, in a fraction
// of the time that they take to make: by lengths alone. Private to verify/.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <vector>

#include "verify/light_map/deviation.h"
#include "verify/light_map/vectors.h"

namespace lightcook::verify::layouts {

using lightmap::BandLengths;
using lightmap::kBandLanes;

/// Texels (0, 0), (1, 0), (0, 1), (1, 1) of a quad.
template <std::size_t kLayers>
using Corners = std::array<const Texels<kLayers>*, 4>;

/// Of a quad, light in the units of its texels.
struct Glance {
    BandLengths bend{};     ///< of control vectors, beside the corners' means
    BandLengths freedom{};  ///< of what a sampler may be off
};

// Where a decode is a product of factors, each bilinear over the quad, its control vectors of degree n differ from the bilinear ones of its
// corners, along an axis, by at most K max |second derivative|: 1/4 for n = 2, 1/6 for n = 3 (b_1 - (b_0 + b_2) / 2 is half a second
// difference of the controls; of a cubic it is a third of one and two thirds of the other; the second derivative at the ends is n (n - 1)
// times them). Control vectors of products are means of products of the factors' corners: the factors at their largest are a bound of
// theirs too. Both axes add up.
namespace detail {

constexpr float kBend2 = 1.0f / 4, kBend3 = 1.0f / 6;

/// Largest differences along an axis, 0 or 1, of values at the corners.
template <class Value>
auto step(const std::array<Value, 4>& at, int axis) {
    return axis == 0 ? glm::max(glm::abs(at[1] - at[0]), glm::abs(at[3] - at[2]))
                     : glm::max(glm::abs(at[2] - at[0]), glm::abs(at[3] - at[1]));
}
template <class Value>
Value largestOf(const std::array<Value, 4>& at) {
    return glm::max(glm::max(glm::abs(at[0]), glm::abs(at[1])), glm::max(glm::abs(at[2]), glm::abs(at[3])));
}
template <std::size_t kLayers>
std::array<glm::vec4, 4> layerAt(const Corners<kLayers>& t, std::size_t layer) {
    return {(*t[0])[layer], (*t[1])[layer], (*t[2])[layer], (*t[3])[layer]};
}
/// Of the most that an array of coefficients can be.
inline BandLengths lengthsOf(const shaders::LcSh& most) {
    return lightmap::bandLengths(most);
}

}  // namespace detail

/// Of each layout.
template <class Layout>
class Glances;

/// The most that a sampler may be off in a layer of numbers in [0, 1], of whatever block.
inline glm::vec4 mostFreedom(const FormatFreedom& format) {
    return format.decoded + format.perSpan + format.absolute + format.relative;
}
/// Light that a sampler errs in by a part of itself.
inline bool isRelative(const FormatFreedom& format) {
    return format.absolute == 0 && format.decoded == glm::vec4(0) && format.perSpan == glm::vec4(0);
}
/// Numbers in [0, 1]; signed formats are off by more.
inline bool isUnsigned(const FormatFreedom& format) {
    return format.relative == 0 && format.absolute < 3.0f / 255;
}

/// Decodes that are linear: their corners are their control vectors.
template <class Layout>
requires(Layout::kDegree == 1) class Glances<Layout> {
public:
    Glances(const Layout&, const std::vector<FormatFreedom>& freedom) : free_(freedom) {}
    bool isKnown() const { return true; }
    template <class FreedomAt>
    Glance of(const Layout& layout, const Corners<Layout::kLayers>& t, FreedomAt&&) const {
        if (free_.empty()) return {};
        Boxes<Layout::kLayers> boxes;
        for (std::size_t layer = 0; layer < boxes.size(); ++layer) {
            const FormatFreedom& format = free_[layer];
            // Ends of signed blocks are up to 2 apart.
            boxes[layer].freedom =
                format.decoded + 2.0f * format.perSpan + format.absolute + format.relative * detail::largestOf(detail::layerAt(t, layer));
        }
        return {{}, detail::lengthsOf(deviationOf(layout, boxes))};
    }

private:
    std::vector<FormatFreedom> free_;
};

/// L (1, ratios): coefficient 0 and kCount more.
template <class Layout, std::size_t kCount>
class RatioGlances {
public:
    RatioGlances(const Layout& layout, const std::vector<FormatFreedom>& freedom) : k_(layout.k) {
        if (freedom.empty()) return;
        Boxes<Layout::kLayers> boxes;
        for (std::size_t layer = 0; layer < boxes.size(); ++layer) {
            isKnown_ = isKnown_ && (layer == 0 ? isRelative(freedom[layer]) : isUnsigned(freedom[layer]));
            boxes[layer] = {glm::vec4(0.5f), glm::vec4(0.5f), mostFreedom(freedom[layer])};
        }
        unit_ = detail::lengthsOf(deviationOf(layout, boxes));
    }
    bool isKnown() const { return isKnown_; }
    template <class FreedomAt>
    Glance of(const Layout&, const Corners<Layout::kLayers>& t, FreedomAt&&) const {
        using detail::layerAt;
        using detail::step;
        const auto l0 = layerAt(t, 0);
        const glm::vec4 across = step(l0, 0), down = step(l0, 1), light = detail::largestOf(l0);
        shaders::LcSh bend{};
        for (std::size_t i = 0; i < kCount; ++i) {
            const auto ratio = layerAt(t, 1 + i);
            const glm::vec4 second = across * step(ratio, 0) + down * step(ratio, 1);
            bend.c[i + 1] = std::abs(2 * detail::kBend2 * k_.range * k_.scale[i]) * glm::vec3(second);
        }
        Glance out{detail::lengthsOf(bend), unit_};
        for (std::size_t l = 0; l < 3; ++l)
            for (std::size_t c = 0; c < 3; ++c) out.freedom[3 * l + c] *= light[static_cast<int>(c)];
        return out;
    }

private:
    decltype(Layout::k) k_;
    bool isKnown_ = true;
    BandLengths unit_{};  ///< of light 1
};

template <>
class Glances<Ratio> : public RatioGlances<Ratio, 8> {
    using RatioGlances::RatioGlances;
};
/// Of bands(): the zonal coefficient is all of band 2.
template <>
class Glances<Zh3> : public RatioGlances<Zh3, 4> {
    using RatioGlances::RatioGlances;
};

/// a0 a1 uvw, of kCount coefficients.
template <class Layout, std::size_t kCount>
class LuvwGlances {
public:
    LuvwGlances(const Layout& layout, const std::vector<FormatFreedom>& freedom) : k_(layout.k), isIdeal_(freedom.empty()) {
        for (const FormatFreedom& format : freedom) isKnown_ = isKnown_ && isUnsigned(format);
    }
    bool isKnown() const { return isKnown_; }
    template <class FreedomAt>
    Glance of(const Layout&, const Corners<Layout::kLayers>& t, FreedomAt&& freedomAt) const {
        shaders::LcSh bend{}, freedom{};
        for (std::size_t i = 0; i < kCount; ++i)
            if (isIdeal_)
                addCoefficient(t, i, glm::vec4(0), glm::vec4(0), bend.c[i], freedom.c[i]);
            else
                addCoefficient(t, i, freedomAt(i), freedomAt(kCount + i), bend.c[i], freedom.c[i]);
        if constexpr (Zonal<Layout>) {
            // As lcLuvwLinearBands, rounded up.
            bend.c[4] *= 0.63078314f;
            freedom.c[4] *= 0.63078314f;
        }
        return {detail::lengthsOf(bend), detail::lengthsOf(freedom)};
    }

private:
    void addCoefficient(const Corners<Layout::kLayers>& t, std::size_t i, const glm::vec4& free0, const glm::vec4& free1, glm::vec3& bend,
                        glm::vec3& freedom) const {
        using detail::step;
        const auto first = detail::layerAt(t, i), second = detail::layerAt(t, kCount + i);
        const float span = std::abs(2 * k_.span[i]), range = std::abs(k_.range[i]);
        // Of colours in xyz and factors in w: at their largest, and their steps. As a box has the colours, for the sampler's sake.
        const glm::vec4 low0 = glm::min(glm::min(first[0], first[1]), glm::min(first[2], first[3])),
                        high0 = glm::max(glm::max(first[0], first[1]), glm::max(first[2], first[3])),
                        low1 = glm::min(glm::min(second[0], second[1]), glm::min(second[2], second[3])),
                        high1 = glm::max(glm::max(second[0], second[1]), glm::max(second[2], second[3]));
        const glm::vec4 middle = (low0 + high0) - 1.0f + k_.span[i] * ((low1 + high1) - 2.0f * k_.neutral);
        const glm::vec4 uvw = glm::abs(middle) + (high0 - low0) + 0.5f * span * (high1 - low1);
        const float a0 = std::max(std::abs(low0.w), std::abs(high0.w)), a1 = std::max(std::abs(low1.w), std::abs(high1.w));
        for (int axis = 0; axis < 2; ++axis) {
            const glm::vec4 step0 = step(first, axis), step1 = step(second, axis);
            const glm::vec4 turn = 2.0f * step0 + span * step1;
            bend += 2 * detail::kBend3 * range * (step0.w * step1.w * glm::vec3(uvw) + (step0.w * a1 + a0 * step1.w) * glm::vec3(turn));
        }
        const glm::vec3 off = 2.0f * glm::vec3(free0) + span * glm::vec3(free1);
        freedom = range *
                  ((a0 + free0.w) * (a1 + free1.w) * off + ((a0 + free0.w) * free1.w + (a1 + free1.w) * free0.w) * (glm::vec3(uvw) + off));
    }

    decltype(Layout::k) k_;
    bool isIdeal_, isKnown_ = true;
};

template <>
class Glances<Luvw> : public LuvwGlances<Luvw, 9> {
    using LuvwGlances::LuvwGlances;
};
/// Of bands(): the zonal coefficient is all of band 2.
template <>
class Glances<LuvwLinear> : public LuvwGlances<LuvwLinear, 5> {
    using LuvwGlances::LuvwGlances;
};

/// L (1, P(code)), P quadratic, and L times a linear function of each residual. Of P's derivatives the lengths are known by cluster.
template <int kCodes, std::size_t kResiduals>
class Glances<Basis<kCodes, kResiduals>> {
public:
    using Layout = Basis<kCodes, kResiduals>;
    Glances(const Layout& layout, const std::vector<FormatFreedom>& freedom)
        : range_(std::abs(layout.tables->range)), isUnit_(!freedom.empty()) {
        Boxes<Layout::kLayers> boxes;
        for (std::size_t layer = 0; layer < freedom.size(); ++layer) {
            isKnown_ = isKnown_ && (layer == 0 ? isRelative(freedom[layer]) : isUnsigned(freedom[layer]));
            boxes[layer] = {glm::vec4(0.5f), glm::vec4(0.5f), mostFreedom(freedom[layer])};
        }
        const BasisTables& tables = *layout.tables;
        const std::size_t count = std::max(tables.first3.size(), tables.first4.size());
        for (std::size_t cluster = 0; cluster < count; ++cluster) {
            clusters_.push_back(normsOf(tables, cluster));
            if (!freedom.empty()) clusters_.back().unit = freeLengths(deviationOf<kCodes, kResiduals>({&tables, cluster}, boxes));
        }
    }
    bool isKnown() const { return isKnown_; }
    /// Quicker, and further off: codes in [0, 1], all of them turning as far as the one that turns most, along both axes.
    Glance roughly(const typename Layout::Decode& decode, const Corners<Layout::kLayers>& t) const {
        const Norms& norms = clusters_[decode.cluster];
        std::array<float, 4> light{}, dark{};
        float turn = 0;
        for (std::size_t layer = 0; layer < Layout::kLayers; ++layer)
            for (int c = 0; c < 4; ++c) {
                const auto at = [&](std::size_t corner) { return (*t[corner])[layer][c]; };
                const float low = std::min(std::min(at(0), at(1)), std::min(at(2), at(3))),
                            high = std::max(std::max(at(0), at(1)), std::max(at(2), at(3)));
                if (layer > 0) {
                    turn = std::max(turn, high - low);
                    continue;
                }
                light[static_cast<std::size_t>(c)] = std::max(std::abs(low), std::abs(high));
                dark[static_cast<std::size_t>(c)] = high - low;
            }
        // Were the codes not known to be there, nothing would be known.
        const float scale = isUnit_ ? 2 * detail::kBend3 * range_ : std::numeric_limits<float>::infinity();
        Glance out;
        for (std::size_t l = 0; l < 3; ++l)
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t lane = 3 * l + c;
                out.bend[lane] = scale * turn * (2 * dark[c] * norms.allSlopes[lane] + light[c] * turn * norms.allSecond[lane]);
                out.freedom[lane] = light[c] * norms.unit[lane];
            }
        return out;
    }
    template <class FreedomAt>
    Glance of(const typename Layout::Decode& decode, const Corners<Layout::kLayers>& t, FreedomAt&&) const {
        const Norms& norms = clusters_[decode.cluster];
        const auto l0 = detail::layerAt(t, 0), code = detail::layerAt(t, 1);
        const glm::vec4 light = detail::largestOf(l0);
        const glm::vec4 far = glm::max(glm::max(glm::abs(code[0] - 0.5f), glm::abs(code[1] - 0.5f)),
                                       glm::max(glm::abs(code[2] - 0.5f), glm::abs(code[3] - 0.5f)));
        std::array<BandLengths, kCodes> slope = norms.slope;
        for (int j = 0; j < kCodes; ++j)
            for (int k = 0; k < kCodes; ++k) add(slope[at(j)], far[k], norms.second[at(j)][at(k)]);
        Glance out;
        for (int axis = 0; axis < 2; ++axis) {
            const glm::vec4 dark = detail::step(l0, axis), turn = detail::step(code, axis);
            BandLengths first{}, second{};
            for (int j = 0; j < kCodes; ++j) {
                add(first, turn[j], slope[at(j)]);
                for (int k = 0; k < kCodes; ++k) add(second, turn[j] * turn[k], norms.second[at(j)][at(k)]);
            }
            for (std::size_t layer = 0; layer < kResiduals; ++layer) {
                const glm::vec4 residual = detail::step(detail::layerAt(t, 2 + layer), axis);
                for (int j = 0; j < 4; ++j) add(first, residual[j], norms.residual[layer][at(j)]);
            }
            for (std::size_t l = 0; l < 3; ++l)
                for (std::size_t c = 0; c < 3; ++c)
                    out.bend[3 * l + c] +=
                        detail::kBend3 * range_ *
                        (2 * dark[static_cast<int>(c)] * first[3 * l + c] + light[static_cast<int>(c)] * second[3 * l + c]);
        }
        for (std::size_t l = 0; l < 3; ++l)
            for (std::size_t c = 0; c < 3; ++c) out.freedom[3 * l + c] = light[static_cast<int>(c)] * norms.unit[3 * l + c];
        return out;
    }

private:
    struct Norms {
        std::array<BandLengths, kCodes> slope{};                        ///< [code] of P's derivative at code 1/2
        std::array<std::array<BandLengths, kCodes>, kCodes> second{};   ///< of the second ones, which are constant
        std::array<std::array<BandLengths, 4>, kResiduals> residual{};  ///< [layer][channel]
        BandLengths allSlopes{}, allSecond{};                           ///< the sums of all of them, slopes anywhere in [0, 1]
        BandLengths unit{};                                             ///< freedom of light 1, codes anywhere
    };
    static constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }
    static void add(BandLengths& sum, float factor, const BandLengths& lengths) {
        for (std::size_t lane = 0; lane < kBandLanes; ++lane) sum[lane] += factor * lengths[lane];
    }
    static Norms normsOf(const BasisTables& tables, std::size_t cluster) {
        const glm::vec3* v = kCodes == 3 ? tables.first3[cluster].v : tables.first4[cluster].v;
        // Where the factors of the products of codes j and k lie; see lcBasisMonomials.
        constexpr int kSquare[4][4] = {{4, 5, 6, 11}, {5, 7, 8, 12}, {6, 8, 9, 13}, {11, 12, 13, 14}};
        constexpr int kLinear[4] = {1, 2, 3, 10};
        Norms norms;
        for (int j = 0; j < kCodes; ++j) {
            shaders::LcSh slope{};
            for (std::size_t i = 0; i < 8; ++i) slope.c[i + 1] = v[8 * at(kLinear[j]) + i];
            for (int k = 0; k < kCodes; ++k) {
                shaders::LcSh second{};
                for (std::size_t i = 0; i < 8; ++i) {
                    second.c[i + 1] = (j == k ? 2.0f : 1.0f) * v[8 * at(kSquare[j][k]) + i];
                    slope.c[i + 1] += 0.5f * second.c[i + 1];
                }
                norms.second[at(j)][at(k)] = detail::lengthsOf(second);
            }
            norms.slope[at(j)] = detail::lengthsOf(slope);
        }
        for (std::size_t layer = 0; layer < kResiduals; ++layer)
            for (std::size_t j = 0; j < 4; ++j) {
                shaders::LcSh residual{};
                for (std::size_t i = 0; i < 9; ++i) residual.c[i] = tables.residual[layer][cluster].v[9 * j + i];
                norms.residual[layer][j] = detail::lengthsOf(residual);
            }
        addSums(norms);
        return norms;
    }
    static void addSums(Norms& norms) {
        for (int j = 0; j < kCodes; ++j) {
            add(norms.allSlopes, 1, norms.slope[at(j)]);
            for (int k = 0; k < kCodes; ++k) {
                add(norms.allSlopes, 0.5f, norms.second[at(j)][at(k)]);
                add(norms.allSecond, 1, norms.second[at(j)][at(k)]);
            }
        }
        for (const auto& layer : norms.residual)
            for (const BandLengths& lengths : layer) add(norms.allSlopes, 1, lengths);
    }
    template <std::size_t kGroups>
    static BandLengths freeLengths(const Deviation<kGroups>& off) {
        BandLengths out = detail::lengthsOf(off.absolute);
        for (const std::array<shaders::LcSh, 4>& group : off.groups) {
            const BandLengths largest = lightmap::largestLengths(lightmap::signedSumsOf(group));
            for (std::size_t lane = 0; lane < kBandLanes; ++lane) out[lane] += largest[lane];
        }
        return out;
    }

    float range_;
    bool isUnit_;  ///< codes are known to lie in [0, 1]
    bool isKnown_ = true;
    std::vector<Norms> clusters_;
};

}  // namespace lightcook::verify::layouts
