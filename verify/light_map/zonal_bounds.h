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
#include <span>

#include "verify/light_map/controls.h"
#include "verify/light_map/part_split.h"
#include "verify/light_map/tolerance.h"

namespace lightcook::verify::lightmap {

class ZonalBounds {
public:
    ZonalBounds(const MapRows& rows, const SamplerTolerance& tolerance, const BoundEvaluator& evaluator)
        : decoder_(rows.decoder()), tolerance_(tolerance), evaluator_(evaluator) {}

    /// Raises the maximum to the bound of quad (x, y).
    void bound(const QuadTexels& texels, const QuadReferences& references, int x, int y, LargestBounds& largest) const {
        boundPart({texels, references, x, y, toleranceOf(texels, references, x, y)}, {}, 0, largest);
    }

private:
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

    Tolerance toleranceOf(const QuadTexels& texels, const QuadReferences& references, int x, int y) const {
        Tolerance out;
        if (tolerance_.isNone()) return out;
        const LcSh off = scaled(tolerance_.quadDeviation(texels, x, y, 0).absolute, decoder_.perKey());
        addLengths(out.slack, off, 1);
        const QuadControls quad = QuadControls::ofDecode(decoder_, 0, texels, references, {});
        const glm::vec3 weights = glm::abs(decoder_.luminance());
        out.axis = kOutward * static_cast<double>(glm::length(
                                  glm::vec3(glm::dot(weights, off.c[3]), glm::dot(weights, off.c[1]), glm::dot(weights, off.c[2]))));
        // Like SamplerTolerance::addFilterFractions, from the differences of the control vectors; c[5] is the axis vector.
        for (int axis = 0; axis < 2; ++axis) addStep(quad, axis, out);
        return out;
    }
    void addStep(const QuadControls& quad, int axis, Tolerance& out) const {
        const std::span<const LcSh> bands = quad.values();
        const std::size_t nodes = quad.nodes(), step = axis == 0 ? 1 : nodes;
        ChannelSlack largest{};
        double axisStep = 0;
        for (std::size_t k = 0; k < bands.size(); ++k) {
            if ((axis == 0 ? k % nodes : k / nodes) == nodes - 1) continue;
            LcSh moved = difference(bands[k + step], bands[k]);
            axisStep = std::max(axisStep, static_cast<double>(glm::length(moved.c[5])));
            moved.c[5] = glm::vec3(0);
            ChannelSlack lengths{};
            addLengths(lengths, moved, 1);
            for (std::size_t c = 0; c < kChannels; ++c)
                for (std::size_t l = 0; l < 3; ++l) largest[c][l] = std::max(largest[c][l], lengths[c][l]);
        }
        const double steepest = kOutward * kFractionTolerance * decoder_.degree();
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t l = 0; l < 3; ++l) out.slack[c][l] += steepest * largest[c][l];
        out.axis += steepest * axisStep;
    }

    void boundPart(const Place& place, const Part& part, int depth, LargestBounds& largest) const {
        QuadControls quad = QuadControls::ofDecode(decoder_, 0, place.texels, place.references, part);
        const std::span<LcSh> bands = quad.values();
        const AxisCone cone = coneOf(bands, place.tolerance.axis);
        std::array<double, kChannels> axisSlack{};
        for (const LcSh& sh : bands)
            for (std::size_t c = 0; c < kChannels; ++c)
                axisSlack[c] = std::max(axisSlack[c], cone.deviation * static_cast<double>(std::abs(sh.c[4][static_cast<int>(c)])));
        for (std::size_t k = 0; k < bands.size(); ++k)
            bands[k] = difference(shaders::lcZonalBand2(bands[k], cone.axis), quad.filtered()[k]);
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
                              quad.nodes(), static_cast<int>(c)});
    }

    static AxisCone coneOf(std::span<const LcSh> bands, double tolerance) {
        std::array<glm::vec3, QuadControls::kMostControls> vectors;
        double largest = 0;
        for (std::size_t k = 0; k < bands.size(); ++k) {
            vectors[k] = bands[k].c[5];
            for (int i = 1; i < 4; ++i) largest = std::max(largest, static_cast<double>(glm::length(bands[k].c[i])));
        }
        return axisCone({vectors.data(), bands.size()}, kControlRounding * largest + tolerance);
    }

    const MapDecoder& decoder_;
    const SamplerTolerance& tolerance_;
    const BoundEvaluator& evaluator_;
};

}  // namespace lightcook::verify::lightmap
