// Bounds of quads for zonal layouts, whose band 2 follows the axis of their filtered band 1. Private to verify/.
//
// Band 2 is z(p) Y(a(p)): z is a polynomial of the position p, a(p) the unit axis of another polynomial, Y the unit zonal band 2 about an
// axis. This is no polynomial, so it is bounded as the polynomial z(p) Y(a0) with one axis a0 for a part of the quad, with
//   |z| |Y(a) - Y(a0)| <= |z| sqrt(3) sin(angle of a and a0)
// as slack (axisCone in bound.h). If this slack is much of the error and the part may exceed the maximum, the part is split into quarters,
// in which axes turn less, up to three times.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>

#include "verify/light_map/controls.h"
#include "verify/light_map/part_split.h"
#include "verify/light_map/tolerance.h"

namespace lightcook::verify::lightmap {

template <layouts::Zonal Layout>
class ZonalBounds {
public:
    using Quad = QuadControls<Layout>;
    using Controls = typename Quad::Controls;
    using QuadTexels = typename Quad::QuadTexels;
    using QuadReferences = typename Quad::QuadReferences;

    ZonalBounds(const MapRows<Layout>& rows, const SamplerTolerance<Layout>& tolerance, const BoundEvaluator& evaluator)
        : rows_(rows), tolerance_(tolerance), evaluator_(evaluator) {}

    /// Raises the maximum to the bound of quad (x, y).
    void bound(const QuadTexels& texels, const QuadReferences& references, int x, int y, LargestBounds& largest) const {
        boundPart({texels, references, x, y, toleranceOf(texels, references, x, y)}, {}, 0, largest);
    }

private:
    static constexpr int kNodes = Quad::kNodes;

    /// Deviation of bands() and of the axis vector by the sampler tolerance.
    struct Tolerance {
        ChannelSlack slack{};
        double axis = 0;
    };
    struct Place {
        const QuadTexels& texels;
        const QuadReferences& references;
        int x, y;
        Tolerance tolerance;
    };

    Quad controlsOf(const QuadTexels& texels, const QuadReferences& references, const Part& part) const {
        return Quad(texels, references, part, [&](const auto& t, const LcSh&) { return bandsAndAxis(t); });
    }
    /// Returns bands(), with the zonal coefficient in c[4] and the axis vector in c[5]: both are polynomials.
    LcSh bandsAndAxis(const typename MapRows<Layout>::LayerTexels& t) const {
        LcSh sh = scaled(rows_.layout().bands(t), rows_.perKey());
        const glm::vec3& weights = rows_.layout().k.luminance;
        sh.c[5] = {glm::dot(weights, sh.c[3]), glm::dot(weights, sh.c[1]), glm::dot(weights, sh.c[2])};
        return sh;
    }

    Tolerance toleranceOf(const QuadTexels& texels, const QuadReferences& references, int x, int y) const {
        Tolerance out;
        if (tolerance_.isNone()) return out;
        const LcSh off = scaled(tolerance_.quadDeviation(texels, x, y, 0).absolute, rows_.perKey());
        addLengths(out.slack, off, 1);
        const Quad quad = controlsOf(texels, references, {});
        const glm::vec3 weights = glm::abs(rows_.layout().k.luminance);
        out.axis = kOutward * static_cast<double>(glm::length(
                                  glm::vec3(glm::dot(weights, off.c[3]), glm::dot(weights, off.c[1]), glm::dot(weights, off.c[2]))));
        // Like SamplerTolerance::addFilterFractions, from the differences of the control vectors; c[5] is the axis vector.
        for (int axis = 0; axis < 2; ++axis) addStep(quad.values, axis, out);
        return out;
    }
    static void addStep(const Controls& bands, int axis, Tolerance& out) {
        const int step = axis == 0 ? 1 : kNodes;
        ChannelSlack largest{};
        double axisStep = 0;
        for (int k = 0; k < static_cast<int>(bands.size()); ++k) {
            if ((axis == 0 ? k % kNodes : k / kNodes) == kNodes - 1) continue;
            LcSh moved = difference(bands[static_cast<std::size_t>(k + step)], bands[static_cast<std::size_t>(k)]);
            axisStep = std::max(axisStep, static_cast<double>(glm::length(moved.c[5])));
            moved.c[5] = glm::vec3(0);
            ChannelSlack lengths{};
            addLengths(lengths, moved, 1);
            for (std::size_t c = 0; c < kChannels; ++c)
                for (std::size_t l = 0; l < 3; ++l) largest[c][l] = std::max(largest[c][l], lengths[c][l]);
        }
        constexpr double kSteepest = kOutward * kFractionTolerance * Layout::kDegree;
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t l = 0; l < 3; ++l) out.slack[c][l] += kSteepest * largest[c][l];
        out.axis += kSteepest * axisStep;
    }

    void boundPart(const Place& place, const Part& part, int depth, LargestBounds& largest) const {
        Quad quad = controlsOf(place.texels, place.references, part);
        Controls& bands = quad.values;
        const AxisCone cone = coneOf(bands, place.tolerance.axis);
        std::array<double, kChannels> axisSlack{};
        for (LcSh& sh : bands)
            for (std::size_t c = 0; c < kChannels; ++c)
                axisSlack[c] = std::max(axisSlack[c], cone.deviation * static_cast<double>(std::abs(sh.c[4][static_cast<int>(c)])));
        for (std::size_t k = 0; k < bands.size(); ++k) bands[k] = difference(shaders::lcZonalBand2(bands[k], cone.axis), quad.filtered[k]);
        ChannelSlack slack = place.tolerance.slack;
        const Squares squares = largestSquares(bands);
        addRounding(slack, squares, referenceSquares(place.references));
        for (std::size_t c = 0; c < kChannels; ++c) slack[c][2] += axisSlack[c];
        if (evaluator_.cannotExceed(largest, squares, slack)) return;
        const auto pairs = quad.pairs();
        std::array<double, kChannels> axisExit{};
        for (std::size_t c = 0; c < kChannels; ++c) axisExit[c] = kExitNorm[2] * axisSlack[c];
        if (depth < kPartDepth && isWorthSplitting(evaluator_, pairs, slack, axisExit, largest)) {
            forEachQuarter(part, [&](const Part& quarter) { boundPart(place, quarter, depth + 1, largest); });
            return;
        }
        for (std::size_t c = 0; c < kChannels; ++c)
            evaluator_.raise(largest, pairs[c], slack[c],
                             {place.x + static_cast<double>(part.u), place.y + static_cast<double>(part.v), static_cast<double>(part.size),
                              static_cast<std::size_t>(kNodes), static_cast<int>(c)});
    }

    static AxisCone coneOf(const Controls& bands, double tolerance) {
        std::array<glm::vec3, std::tuple_size_v<Controls>> vectors;
        double largest = 0;
        for (std::size_t k = 0; k < bands.size(); ++k) {
            vectors[k] = bands[k].c[5];
            for (int i = 1; i < 4; ++i) largest = std::max(largest, static_cast<double>(glm::length(bands[k].c[i])));
        }
        return axisCone(vectors, kControlRounding * largest + tolerance);
    }

    const MapRows<Layout>& rows_;
    const SamplerTolerance<Layout>& tolerance_;
    const BoundEvaluator& evaluator_;
};

}  // namespace lightcook::verify::lightmap
