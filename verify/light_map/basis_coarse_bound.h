// Coarse bounds of the learned layouts (method: coarse_bound.h). The decode is L (1, P(code)) + L R(residual), with P quadratic and R
// linear. Private to verify/.
//
// Along an axis the second derivative of L P is 2 L' P' + L P'', where P' = sum_j code_j' dP/dcode_j and P'' = sum_jk code_j' code_k' d2P.
// The lengths of the derivatives are precomputed for each cluster: dP/dcode_j at code 1/2, and the second derivatives, which are constant.
// At another code the slope changes by at most |code - 1/2| times the second derivatives.
#pragma once

#include <limits>

#include "verify/light_map/coarse_bound.h"

namespace lightcook::verify::layouts {

/// Lengths of a cluster's derivatives.
template <int kCodes>
struct BasisNorms {
    std::array<BandLengths, kCodes> slope{};                       ///< [code], of dP/dcode at code 1/2
    std::array<std::array<BandLengths, kCodes>, kCodes> second{};  ///< [code][code], of the second derivatives
    std::vector<std::array<BandLengths, 4>> residual;              ///< [layer][channel], of R's derivatives
    BandLengths allSlopes{}, allSecond{};                          ///< sums over all of them, for codes anywhere in [0, 1]
    BandLengths unit{};                                            ///< deviation by the sampler tolerance for l0 = 1 and any codes

    BasisNorms(const BasisTables& tables, std::size_t cluster) : residual(tables.residual.size()) {
        addCodes(kCodes == 3 ? tables.first3[cluster].v : tables.first4[cluster].v);
        for (std::size_t layer = 0; layer < residual.size(); ++layer)
            for (std::size_t j = 0; j < 4; ++j) {
                shaders::LcSh factors{};
                for (std::size_t i = 0; i < 9; ++i) factors.c[i] = tables.residual[layer][cluster].v[9 * j + i];
                residual[layer][j] = detail::lengthsOf(factors);
            }
        addSums();
    }
    static constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }
    static void add(BandLengths& sum, float factor, const BandLengths& lengths) {
        for (std::size_t lane = 0; lane < kBandLanes; ++lane) sum[lane] += factor * lengths[lane];
    }

private:
    void addCodes(const glm::vec3* v) {
        for (int j = 0; j < kCodes; ++j) {
            shaders::LcSh first{};
            for (std::size_t i = 0; i < 8; ++i) first.c[i + 1] = v[8 * at(kLinearMonomial[j]) + i];
            for (int k = 0; k < kCodes; ++k) {
                shaders::LcSh product{};
                for (std::size_t i = 0; i < 8; ++i) {
                    product.c[i + 1] = (j == k ? 2.0f : 1.0f) * v[8 * at(kProductMonomial[j][k]) + i];
                    first.c[i + 1] += 0.5f * product.c[i + 1];
                }
                second[at(j)][at(k)] = detail::lengthsOf(product);
            }
            slope[at(j)] = detail::lengthsOf(first);
        }
    }
    void addSums() {
        for (int j = 0; j < kCodes; ++j) {
            add(allSlopes, 1, slope[at(j)]);
            for (int k = 0; k < kCodes; ++k) {
                add(allSlopes, 0.5f, second[at(j)][at(k)]);
                add(allSecond, 1, second[at(j)][at(k)]);
            }
        }
        for (const auto& layer : residual)
            for (const BandLengths& lengths : layer) add(allSlopes, 1, lengths);
    }
};

/// Coarse bounds of the learned layouts with kCodes codes and any number of residual layers. The degree is 3.
template <int kCodes>
class BasisCoarseBounds final : public CoarseBounds {
public:
    BasisCoarseBounds(const BasisTables& tables, const std::vector<FormatTolerance>& formats)
        : range_(std::abs(tables.range)), isUnit_(!formats.empty()) {
        std::vector<TexelBox> boxes;
        for (std::size_t layer = 0; layer < formats.size(); ++layer) {
            isKnown_ = isKnown_ && (layer == 0 ? isRelative(formats[layer]) : isUnsigned(formats[layer]));
            boxes.push_back({glm::vec4(0.5f), glm::vec4(0.5f), largestTolerance(formats[layer])});
        }
        const std::size_t count = std::max(tables.first3.size(), tables.first4.size());
        for (std::size_t cluster = 0; cluster < count; ++cluster) {
            clusters_.emplace_back(tables, cluster);
            if (!formats.empty()) clusters_.back().unit = toleranceLengths(deviationOf<kCodes>(tables, cluster, boxes));
        }
    }
    bool isKnown() const override { return isKnown_; }
    /// Assumes codes anywhere in [0, 1], and takes the largest step of all codes and residuals for each, on both axes.
    std::optional<CoarseBound> quickBound(const QuadTexels& t, std::size_t cluster) const override {
        const Norms& norms = clusters_[cluster];
        std::array<float, 4> light{}, lightStep{};
        float codeStep = 0;
        for (std::size_t layer = 0; layer < 2 + norms.residual.size(); ++layer)
            for (int c = 0; c < 4; ++c) {
                const auto at = [&](std::size_t corner) { return t[corner][layer][c]; };
                const float low = std::min(std::min(at(0), at(1)), std::min(at(2), at(3))),
                            high = std::max(std::max(at(0), at(1)), std::max(at(2), at(3)));
                if (layer > 0) {
                    codeStep = std::max(codeStep, high - low);
                    continue;
                }
                light[static_cast<std::size_t>(c)] = std::max(std::abs(low), std::abs(high));
                lightStep[static_cast<std::size_t>(c)] = high - low;
            }
        // Without known formats codes may be outside [0, 1], where this bound does not hold.
        const float scale = isUnit_ ? 2 * detail::kCurvature3 * range_ : std::numeric_limits<float>::infinity();
        CoarseBound out;
        for (std::size_t l = 0; l < 3; ++l)
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t lane = 3 * l + c;
                out.curvature[lane] =
                    scale * codeStep * (2 * lightStep[c] * norms.allSlopes[lane] + light[c] * codeStep * norms.allSecond[lane]);
                out.tolerance[lane] = light[c] * norms.unit[lane];
            }
        return out;
    }
    CoarseBound bound(const QuadTexels& t, std::size_t cluster, const QuadTolerance&) const override {
        const Norms& norms = clusters_[cluster];
        const auto l0 = detail::layerAt(t, 0), code = detail::layerAt(t, 1);
        const glm::vec4 light = detail::largestOf(l0);
        const glm::vec4 fromMiddle = glm::max(glm::max(glm::abs(code[0] - 0.5f), glm::abs(code[1] - 0.5f)),
                                              glm::max(glm::abs(code[2] - 0.5f), glm::abs(code[3] - 0.5f)));
        std::array<BandLengths, kCodes> slope = norms.slope;
        for (int j = 0; j < kCodes; ++j)
            for (int k = 0; k < kCodes; ++k) Norms::add(slope[at(j)], fromMiddle[k], norms.second[at(j)][at(k)]);
        CoarseBound out;
        for (int axis = 0; axis < 2; ++axis) {
            const glm::vec4 lightStep = detail::step(l0, axis), codeStep = detail::step(code, axis);
            BandLengths first{}, second{};
            for (int j = 0; j < kCodes; ++j) {
                Norms::add(first, codeStep[j], slope[at(j)]);
                for (int k = 0; k < kCodes; ++k) Norms::add(second, codeStep[j] * codeStep[k], norms.second[at(j)][at(k)]);
            }
            for (std::size_t layer = 0; layer < norms.residual.size(); ++layer) {
                const glm::vec4 residual = detail::step(detail::layerAt(t, 2 + layer), axis);
                for (int j = 0; j < 4; ++j) Norms::add(first, residual[j], norms.residual[layer][at(j)]);
            }
            for (std::size_t l = 0; l < 3; ++l)
                for (std::size_t c = 0; c < 3; ++c)
                    out.curvature[3 * l + c] +=
                        detail::kCurvature3 * range_ *
                        (2 * lightStep[static_cast<int>(c)] * first[3 * l + c] + light[static_cast<int>(c)] * second[3 * l + c]);
        }
        for (std::size_t l = 0; l < 3; ++l)
            for (std::size_t c = 0; c < 3; ++c) out.tolerance[3 * l + c] = light[static_cast<int>(c)] * norms.unit[3 * l + c];
        return out;
    }

private:
    using Norms = BasisNorms<kCodes>;
    static constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

    static BandLengths toleranceLengths(const lightmap::Deviation& off) {
        BandLengths out = detail::lengthsOf(off.absolute);
        for (const std::array<shaders::LcSh, 4>& group : off.groups) {
            const BandLengths largest = lightmap::largestLengths(lightmap::signedSumsOf(group));
            for (std::size_t lane = 0; lane < kBandLanes; ++lane) out[lane] += largest[lane];
        }
        return out;
    }

    float range_;
    bool isUnit_;  ///< codes are known to be in [0, 1]
    bool isKnown_ = true;
    std::vector<Norms> clusters_;
};

}  // namespace lightcook::verify::layouts
