// Control vectors of error and reference over a rectangle of a quad of which some texels may not be covered. Private to verify/.
//
// The filter of a GPU reaches all four cooked texels. The reference is that of the covered ones: with bilinear weights w_i and
// W = sum of w_i over them, R = (sum of w_i r_i) / W. In Bernstein form over a rectangle where W > 0, of degree d + 1 along each axis,
//   W D = sum_jk B_jk b_jk,  W = sum_jk B_jk W_jk,  W R = sum_jk B_jk W_jk R_jk,
// where W and W R are bilinear: W_jk and R_jk are their values at the nodes. Therefore D and R are means of b_jk / W_jk and of R_jk with
// the same weights, B_jk W_jk / W. Without uncovered texels W is 1, and the degree d is enough.
#pragma once

#include <limits>

#include "verify/light_map/controls.h"
#include "verify/light_map/covered_quad.h"
#include "verify/light_map/curvature.h"
#include "verify/light_map/tolerance.h"
#include "verify/light_map/visible_search.h"

namespace lightcook::verify::lightmap {

/// Light of the quarter of a quad that is nearest to one of its texels, under the decode of one of them.
template <class Layout>
class QuarterLight {
public:
    using Rows = MapRows<Layout>;
    using Quad = CoveredQuad<Layout>;
    using LayerTexels = typename Rows::LayerTexels;

    /// corner  the texel whose quarter it is
    /// decode  the texel whose decode it is
    QuarterLight(const Rows& rows, const SamplerTolerance<Layout>& tolerance, const Quad& quad, int corner, int decode,
                 const std::array<glm::vec3, 3>& frame)
        : rows_(rows), tolerance_(tolerance), quad_(quad), decode_(decode), frame_(frame) {
        whole_.low = 0.5f * glm::vec2(corner % 2, corner / 2);
        whole_.size = glm::vec2(0.5f);
    }
    const PlaceRectangle& whole() const { return whole_; }
    /// Control vectors along each axis of a quad of which some texels are not covered.
    static constexpr std::size_t kRimNodes = Layout::kDegree + 2;
    /// Returns the control vectors along each axis of this quad.
    std::size_t nodes() const { return quad_.isCovered() ? Layout::kDegree + 1 : kRimNodes; }

    /// Returns the control vectors over a rectangle; of one without size, the light there.
    CellLight over(const PlaceRectangle& place) const {
        if (place.size.x == 0) return at(place.low);
        return quad_.isCovered() ? over<Layout::kDegree>(place) : over<static_cast<int>(kRimNodes) - 1>(place);
    }
    /// Returns the largest band lengths of the error over the quarter, by channel.
    BandLengths errorLengths() const {
        const CellLight light = over(whole_);
        BandLengths out{};
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t l = 0; l < 3; ++l)
                out[3 * l + c] =
                    kOutwardFloat * static_cast<float>(light.errors.largest(c)[l] + light.errorSlack[c][l] +
                                                       static_cast<double>(light.deviations.count()) * light.deviations.largest(c)[l]);
        if (!light.isFinite) out.fill(std::numeric_limits<float>::infinity());
        return out;
    }

private:
    static constexpr bool kIsZonal = layouts::Zonal<Layout>, kIsCurved = layouts::Curved<Layout>;

    decltype(auto) decodeLayout() const { return rows_.decodeOf(quad_.x, quad_.y, decode_); }
    /// Returns the decode, or what of it is a polynomial: bands(), with the axis vector in c[5].
    LcSh polynomialOf(const LayerTexels& texels) const {
        if constexpr (kIsZonal) {
            LcSh sh = scaled(rows_.layout().bands(texels), rows_.perKey());
            const glm::vec3& weights = rows_.layout().k.luminance;
            sh.c[5] = {glm::dot(weights, sh.c[3]), glm::dot(weights, sh.c[1]), glm::dot(weights, sh.c[2])};
            return sh;
        } else {
            return scaled(decodeLayout().decode(texels), rows_.perKey());
        }
    }
    Channels local(const LcSh& sh) const { return channelsOf(shaders::lcLocalSh(sh, frame_[0], frame_[1], frame_[2])); }

    void addVectors(CellLight& out, const LcSh& error, const LcSh& reference) const {
        const Channels e = local(error), r = local(reference);
        Channels found = e;
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t i = 0; i < kCoefficients; ++i) found[c][i] += r[c][i];
        out.errors.add(e);
        out.references.add(r);
        out.found.add(found);
    }
    CellLight at(const glm::vec2& place) const {
        CellLight out;
        const LcSh reference = quad_.referenceAt(place).first,
                   error = difference(scaled(decodeLayout().decode(quad_.texelsAt(place)), rows_.perKey()), reference);
        addVectors(out, error, reference);
        addRoundingOf(out, {&error, 1}, {&reference, 1}, 1);
        addTolerance({place, glm::vec2(0)}, out);
        return out;
    }
    /// Returns the values of a polynomial at the nodes of a rectangle as control vectors.
    template <int kDegree>
    static void toControls(std::span<LcSh> values) {
        constexpr std::size_t kNodes = kDegree + 1;
        const auto convert = [&](std::size_t first, std::size_t step) {
            std::array<LcSh*, kNodes> nodes;
            for (std::size_t i = 0; i < kNodes; ++i) nodes[i] = &values[first + i * step];
            bernsteinFromNodes<kDegree>(nodes);
        };
        for (std::size_t line = 0; line < kNodes; ++line) convert(line * kNodes, 1);
        for (std::size_t line = 0; line < kNodes; ++line) convert(line, kNodes);
    }
    /// Returns the filtered texels at the corners of a rectangle.
    std::array<LayerTexels, 4> cornersOf(const PlaceRectangle& place) const {
        std::array<LayerTexels, 4> out;
        for (std::size_t i = 0; i < 4; ++i) out[i] = quad_.texelsAt(place.low + place.size * glm::vec2(i % 2, i / 2));
        return out;
    }
    /// Adds the curvature over a rectangle with these corners.
    void addCurvature([[maybe_unused]] const std::array<LayerTexels, 4>& corners, [[maybe_unused]] double factor,
                      [[maybe_unused]] CellLight& out) const {
        if constexpr (kIsCurved)
            addLengths(out.errorSlack, layouts::curvatureOf(rows_.layout(), {&corners[0], &corners[1], &corners[2], &corners[3]}),
                       factor * static_cast<double>(rows_.perKey()));
    }
    /// Returns a function that returns the decode, or what of it is a polynomial, for fractions of a rectangle. In place of a curved decode
    /// that is the blend of its corners, and its curvature is added to `out`.
    auto decodeOver(const PlaceRectangle& place, [[maybe_unused]] CellLight& out) const {
        if constexpr (kIsCurved) {
            const std::array<LayerTexels, 4> corners = cornersOf(place);
            addCurvature(corners, 1, out);
            std::array<LcSh, 4> ends;
            for (std::size_t i = 0; i < 4; ++i) ends[i] = polynomialOf(corners[i]);
            return [ends](const glm::vec2& at) { return blend(blend(ends[0], ends[1], at.x), blend(ends[2], ends[3], at.x), at.y); };
        } else {
            return [this, place](const glm::vec2& at) { return polynomialOf(quad_.texelsAt(place.low + place.size * at)); };
        }
    }
    template <int kDegree>
    CellLight over(const PlaceRectangle& place) const {
        constexpr std::size_t kNodes = kDegree + 1, kControls = kNodes * kNodes;
        std::array<LcSh, kControls> values, references;
        std::array<float, kControls> weights;
        CellLight out;
        const auto decodeAt = decodeOver(place, out);
        for (std::size_t v = 0; v < kNodes; ++v)
            for (std::size_t u = 0; u < kNodes; ++u) {
                const glm::vec2 at = glm::vec2(u, v) / static_cast<float>(kDegree);
                const std::size_t k = v * kNodes + u;
                std::tie(references[k], weights[k]) = quad_.referenceAt(place.low + place.size * at);
                values[k] = scaled(decodeAt(at), weights[k]);
            }
        toControls<kDegree>(values);
        for (std::size_t k = 0; k < kControls; ++k) values[k] = scaled(values[k], 1 / weights[k]);
        takeZonal(values, addTolerance(place, out), out);
        for (std::size_t k = 0; k < kControls; ++k) values[k] = difference(values[k], references[k]);
        addRoundingOf(out, values, references, quad_.isCovered() ? 1 : kRimFactor);
        for (std::size_t k = 0; k < kControls; ++k) addVectors(out, values[k], references[k]);
        return out;
    }
    /// Turns bands() into coefficients about one axis, and adds how far other axes are.
    void takeZonal([[maybe_unused]] std::span<LcSh> values, [[maybe_unused]] double axisTolerance, [[maybe_unused]] CellLight& out) const {
        if constexpr (kIsZonal) {
            std::vector<glm::vec3> vectors;
            double largest = 0;
            for (const LcSh& sh : values) {
                vectors.push_back(sh.c[5]);
                for (int i = 1; i < 4; ++i) largest = std::max(largest, static_cast<double>(glm::length(sh.c[i])));
            }
            const AxisCone cone = axisCone(vectors, kRimFactor * kControlRounding * largest + axisTolerance);
            std::array<double, kChannels> zonal{};
            for (LcSh& sh : values) {
                for (std::size_t c = 0; c < kChannels; ++c)
                    zonal[c] = std::max(zonal[c], static_cast<double>(std::abs(sh.c[4][static_cast<int>(c)])));
                sh = shaders::lcZonalBand2(sh, cone.axis);
            }
            for (std::size_t c = 0; c < kChannels; ++c) out.errorSlack[c][2] += cone.deviation * zonal[c];
        }
    }
    static void addRoundingOf(CellLight& out, std::span<const LcSh> errors, std::span<const LcSh> references, double factor) {
        // The evaluation rounds, and so does the rotation to the frame of the texel.
        const Squares error = largestSquares(errors), reference = largestSquares(references);
        for (std::size_t l = 0; l < 3; ++l)
            for (std::size_t c = 0; c < kChannels; ++c) {
                const auto at = static_cast<int>(c);
                const double e = outwardLength(error[l][at]), r = outwardLength(reference[l][at]);
                out.errorSlack[c][l] += (factor * kControlRounding + kRotationRounding) * (e + r);
                out.referenceSlack[c][l] += kRotationRounding * r;
                out.isFinite = out.isFinite && std::isfinite(e) && std::isfinite(r);
            }
    }
    /// Adds the sampler tolerance over a rectangle and a filter fraction around it, as far as the quad reaches. Returns the length by which
    /// it moves the axis vector of a zonal layout.
    double addTolerance(const PlaceRectangle& place, CellLight& out) const {
        if (tolerance_.isNone()) return 0;
        PlaceRectangle reach;
        reach.low = glm::max(place.low - kFractionTolerance, 0.0f);
        reach.size = glm::min(place.low + place.size + kFractionTolerance, 1.0f) - reach.low;
        const std::array<LayerTexels, 4> ends = cornersOf(reach);
        const typename Rows::QuadTexels pointers = {&ends[0], &ends[1], &ends[2], &ends[3]};
        const auto off = tolerance_.partDeviation(quad_.corners.texels, pointers, quad_.x, quad_.y, decodeLayout());
        addCurvature(ends, 2, out);  // of both places between which a fraction moves
        addLengths(out.errorSlack, off.absolute, static_cast<double>(rows_.perKey()));
        for (const std::array<LcSh, 4>& group : off.groups)
            for (const LcSh& vector : group) {
                const LcSh moved = scaled(vector, rows_.perKey());
                out.deviations.add(local(moved));
                addLengths(out.errorSlack, moved, kControlRounding);
            }
        double axis = addFractions(reach, out);
        if constexpr (kIsZonal) {
            const glm::vec3 weights = glm::abs(rows_.layout().k.luminance);
            const LcSh moved = scaled(off.absolute, rows_.perKey());
            axis += kOutward * static_cast<double>(glm::length(
                                   glm::vec3(glm::dot(weights, moved.c[3]), glm::dot(weights, moved.c[1]), glm::dot(weights, moved.c[2]))));
        }
        return axis;
    }
    /// Adds what filter fractions off by kFractionTolerance do: along an axis, at most degree / size times the largest difference of
    /// neighbouring control vectors.
    double addFractions(const PlaceRectangle& reach, CellLight& out) const {
        double axisTolerance = 0;
        constexpr std::size_t kNodes = Layout::kDegree + 1;
        std::array<LcSh, kNodes * kNodes> values;
        for (std::size_t k = 0; k < values.size(); ++k)
            values[k] = polynomialOf(
                quad_.texelsAt(reach.low + reach.size * (glm::vec2(k % kNodes, k / kNodes) / static_cast<float>(Layout::kDegree))));
        toControls<Layout::kDegree>(values);
        for (int axis = 0; axis < 2; ++axis) {
            const double steepest = kOutward * static_cast<double>(kFractionTolerance / reach.size[axis]) * Layout::kDegree;
            const std::size_t step = axis == 0 ? 1 : kNodes;
            std::vector<LcSh> moved;
            double axisStep = 0;
            for (std::size_t k = 0; k < values.size(); ++k) {
                if ((axis == 0 ? k % kNodes : k / kNodes) == kNodes - 1) continue;
                moved.push_back(difference(values[k + step], values[k]));
                if constexpr (kIsZonal) {
                    axisStep = std::max(axisStep, static_cast<double>(glm::length(moved.back().c[5])));
                    moved.back().c[5] = glm::vec3(0);
                }
            }
            addLargestLengths(out.errorSlack, moved, steepest);
            axisTolerance += steepest * axisStep;
        }
        return axisTolerance;
    }

    const Rows& rows_;
    const SamplerTolerance<Layout>& tolerance_;
    const Quad& quad_;
    int decode_;
    std::array<glm::vec3, 3> frame_;
    PlaceRectangle whole_;
};

}  // namespace lightcook::verify::lightmap
