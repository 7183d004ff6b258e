// Bounds of quads whose band 2 follows the axis of their filtered band 1. Private to verify/.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>

#include "verify/light_map/controls.h"
#include "verify/light_map/tolerance.h"

namespace lightcook::verify::lightmap {

/// A layout whose band 2 is z(p) Y(a(p)), z a polynomial and a(p) the axis of another, is bounded as the polynomial z(p) Y(a0) with one
/// axis a0 for the part, and at most |z| |Y(a) - Y(a0)| beside it (axisCone). Where that is much of the error and could be the map's
/// worst, the part is looked at in quarters: axes turn less in them.
template <layouts::Zonal Layout>
class ZonalBounds {
public:
    using Quad = QuadControls<Layout>;
    using Controls = typename Quad::Controls;
    using QuadTexels = typename Quad::QuadTexels;
    using QuadReferences = typename Quad::QuadReferences;

    ZonalBounds(const MapRows<Layout>& rows, const Liberties<Layout>& liberties, const BoundJudge& judge)
        : rows_(rows), liberties_(liberties), judge_(judge) {}

    /// Takes the quad at (x, y) into the worst so far.
    void bound(const QuadTexels& texels, const QuadReferences& references, int x, int y, Worst& worst) const {
        boundPart({texels, references, x, y, freedomOf(texels, references, x, y)}, {}, 0, worst);
    }

private:
    static constexpr int kNodes = Quad::kNodes, kDepth = 3;
    static constexpr double kShare = 0.05;

    /// What a sampler's freedom does to bands() and to the vector of the axis.
    struct Freedom {
        ChannelSlack slack{};
        double axis = 0;
    };
    struct Place {
        const QuadTexels& texels;
        const QuadReferences& references;
        int x, y;
        Freedom freedom;
    };

    Quad controlsOf(const QuadTexels& texels, const QuadReferences& references, const Part& part) const {
        return Quad(texels, references, part, [&](const auto& t, const LcSh&) { return bandsAndAxis(t); });
    }
    /// bands(), and beside the zonal coefficient in c[4] the vector of the axis in c[5]: both are polynomials.
    LcSh bandsAndAxis(const typename MapRows<Layout>::LayerTexels& t) const {
        LcSh sh = scaled(rows_.layout().bands(t), rows_.perKey());
        const glm::vec3& weights = rows_.layout().k.luminance;
        sh.c[5] = {glm::dot(weights, sh.c[3]), glm::dot(weights, sh.c[1]), glm::dot(weights, sh.c[2])};
        return sh;
    }

    Freedom freedomOf(const QuadTexels& texels, const QuadReferences& references, int x, int y) const {
        Freedom out;
        if (liberties_.isNone()) return out;
        const LcSh off = scaled(liberties_.ofQuad(texels, x, y, 0).absolute, rows_.perKey());
        addLengths(out.slack, off, 1);
        const Quad quad = controlsOf(texels, references, {});
        const glm::vec3 weights = glm::abs(rows_.layout().k.luminance);
        out.axis = kOutwardLength * static_cast<double>(glm::length(
                                        glm::vec3(glm::dot(weights, off.c[3]), glm::dot(weights, off.c[1]), glm::dot(weights, off.c[2]))));
        // As in addFractions, from the controls themselves: lengths of the axis' vector are in c[5].
        for (int axis = 0; axis < 2; ++axis) addStep(quad.values, axis, out);
        return out;
    }
    static void addStep(const Controls& bands, int axis, Freedom& out) {
        const int step = axis == 0 ? 1 : kNodes;
        ChannelSlack largest{};
        double turned = 0;
        for (int k = 0; k < static_cast<int>(bands.size()); ++k) {
            if ((axis == 0 ? k % kNodes : k / kNodes) == kNodes - 1) continue;
            LcSh moved = difference(bands[static_cast<std::size_t>(k + step)], bands[static_cast<std::size_t>(k)]);
            turned = std::max(turned, static_cast<double>(glm::length(moved.c[5])));
            moved.c[5] = glm::vec3(0);
            ChannelSlack lengths{};
            addLengths(lengths, moved, 1);
            for (std::size_t c = 0; c < kChannels; ++c)
                for (std::size_t l = 0; l < 3; ++l) largest[c][l] = std::max(largest[c][l], lengths[c][l]);
        }
        constexpr double kSteepest = kOutwardLength * kFractionFreedom * Layout::kDegree;
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t l = 0; l < 3; ++l) out.slack[c][l] += kSteepest * largest[c][l];
        out.axis += kSteepest * turned;
    }

    void boundPart(const Place& place, const Part& part, int depth, Worst& worst) const {
        Quad quad = controlsOf(place.texels, place.references, part);
        Controls& bands = quad.values;
        const AxisCone cone = coneOf(bands, place.freedom.axis);
        std::array<double, kChannels> turned{};
        for (LcSh& sh : bands)
            for (std::size_t c = 0; c < kChannels; ++c)
                turned[c] = std::max(turned[c], cone.deviation * static_cast<double>(std::abs(sh.c[4][static_cast<int>(c)])));
        for (std::size_t k = 0; k < bands.size(); ++k) bands[k] = difference(shaders::lcZonalBand2(bands[k], cone.axis), quad.filtered[k]);
        ChannelSlack slack = place.freedom.slack;
        const Squares squares = largestSquares(bands);
        addRounding(slack, squares, referenceSquares(place.references));
        for (std::size_t c = 0; c < kChannels; ++c) slack[c][2] += turned[c];
        if (judge_.isCertainlyWithin(worst, squares, slack)) return;
        const auto pairs = quad.pairs();
        if (depth < kDepth && isWorthSplitting(pairs, slack, turned, worst)) {
            const float half = 0.5f * part.size;
            for (const float v : {0.0f, half})
                for (const float u : {0.0f, half}) boundPart(place, {part.u + u, part.v + v, half}, depth + 1, worst);
            return;
        }
        for (std::size_t c = 0; c < kChannels; ++c)
            judge_.raise(worst, pairs[c], slack[c],
                         {place.x + static_cast<double>(part.u), place.y + static_cast<double>(part.v), static_cast<double>(part.size),
                          static_cast<std::size_t>(kNodes), static_cast<int>(c)});
    }

    static AxisCone coneOf(const Controls& bands, double freedom) {
        std::array<glm::vec3, std::tuple_size_v<Controls>> vectors;
        double largest = 0;
        for (std::size_t k = 0; k < bands.size(); ++k) {
            vectors[k] = bands[k].c[5];
            for (int i = 1; i < 4; ++i) largest = std::max(largest, static_cast<double>(glm::length(bands[k].c[i])));
        }
        return axisCone(vectors, kRounding * largest + freedom);
    }
    /// turned: what of the slack is due to the axis
    bool isWorthSplitting(const typename Quad::Pairs& pairs, const ChannelSlack& slack, const std::array<double, kChannels>& turned,
                          const Worst& worst) const {
        for (std::size_t c = 0; c < kChannels; ++c) {
            double error = 0;
            for (const ErrorPair& pair : pairs[c]) error = std::max(error, bandSum(bandNorms(pair.error), kExitNorm));
            if (kExitNorm[2] * turned[c] <= kShare * error) continue;
            if (!staysWithin(pairs[c], {&kExitResponse, 1}, kFloor, slack[c], worst.diffuse.bound)) return true;
            if (!staysWithin(pairs[c], judge_.setup().responses, kFloor, slack[c], worst.specular.bound)) return true;
        }
        return false;
    }

    const MapRows<Layout>& rows_;
    const Liberties<Layout>& liberties_;
    const BoundJudge& judge_;
};

}  // namespace lightcook::verify::lightmap
