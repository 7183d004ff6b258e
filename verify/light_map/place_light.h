// Control vectors of error and reference over a rectangle of a quad of which some texels may not be covered. Private to verify/.
//
// The filter of a GPU reaches all four cooked texels. The reference is that of the covered ones: with bilinear weights w_i and
// W = sum of w_i over them, R = (sum of w_i r_i) / W. In Bernstein form over a rectangle where W > 0, of degree d + 1 along each axis,
//   W D = sum_jk B_jk b_jk,  W = sum_jk B_jk W_jk,  W R = sum_jk B_jk W_jk R_jk,
// where W and W R are bilinear: W_jk and R_jk are their values at the nodes. Therefore D and R are means of b_jk / W_jk and of R_jk with
// the same weights, B_jk W_jk / W. Without uncovered texels W is 1, and the degree d is enough. Filter "decoded" mixes the covered texels
// alone, so that W D is bilinear, too.
#pragma once

#include <limits>

#include "verify/light_map/controls.h"
#include "verify/light_map/covered_quad.h"
#include "verify/light_map/tolerance.h"
#include "verify/light_map/visible_search.h"

namespace lightcook::verify::lightmap {

/// Light of the quarter of a quad that is nearest to one of its texels, under the decode of one of them.
class QuarterLight {
public:
    /// corner  the texel whose quarter it is
    /// decode  the texel whose decode it is
    QuarterLight(const MapRows& rows, const SamplerTolerance& tolerance, const CoveredQuad& quad, int corner, int decode,
                 const std::array<glm::vec3, 3>& frame)
        : decoder_(rows.decoder()), tolerance_(tolerance), quad_(quad), cluster_(rows.clusterOf(quad.x, quad.y, decode)), frame_(frame) {
        whole_.low = 0.5f * glm::vec2(corner % 2, corner / 2);
        whole_.size = glm::vec2(0.5f);
    }
    const PlaceRectangle& whole() const { return whole_; }
    /// Returns the control vectors along each axis of this quad: one more if some of its texels are not covered, and all are filtered.
    std::size_t nodes() const { return quad_.isCovered() || decoder_.isMixed() ? decoder_.nodes() : decoder_.nodes() + 1; }

    /// Returns the control vectors over a rectangle; of one without size, the light there.
    CellLight over(const PlaceRectangle& place) const { return place.size.x == 0 ? at(place.low) : overArea(place); }
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
    static constexpr std::size_t kMostNodes = kMostDegree + 2;

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
                   error = difference(decoder_.decode(quad_.texelsAt(place).data(), cluster_), reference);
        addVectors(out, error, reference);
        if (decoder_.isInTangentSpace()) out.directions.add(channelsOf(decoder_.directions(quad_.texelsAt(place).data(), cluster_)));
        addRoundingOf(out, {&error, 1}, {&reference, 1}, 1);
        addDecoders(out);
        addTolerance({place, glm::vec2(0)}, out);
        return out;
    }
    /// Returns the filtered texels at the corners of a rectangle.
    std::array<FilteredTexels, 4> cornersOf(const PlaceRectangle& place) const {
        std::array<FilteredTexels, 4> out;
        for (std::size_t i = 0; i < 4; ++i) out[i] = quad_.texelsAt(place.low + place.size * glm::vec2(i % 2, i / 2));
        return out;
    }
    static QuadTexels pointersTo(const std::array<FilteredTexels, 4>& corners) {
        return {corners[0].data(), corners[1].data(), corners[2].data(), corners[3].data()};
    }
    /// Adds the curvature over a rectangle with these corners.
    void addCurvature(const std::array<FilteredTexels, 4>& corners, double factor, CellLight& out) const {
        addLengths(out.errorSlack, decoder_.curvature(pointersTo(corners)), factor * static_cast<double>(decoder_.perKey()));
    }
    /// Returns a function that returns the decode, for fractions of a rectangle. In place of a curved decode that
    /// is the blend of its corners, and its curvature is added to `out`.
    auto decodeOver(const PlaceRectangle& place, CellLight& out) const {
        std::array<LcSh, 4> ends;
        if (decoder_.isCurved()) {
            const std::array<FilteredTexels, 4> corners = cornersOf(place);
            addCurvature(corners, 1, out);
            for (std::size_t i = 0; i < 4; ++i) ends[i] = decoder_.decode(corners[i].data(), cluster_);
        }
        return [this, place, ends](const glm::vec2& at) {
            if (decoder_.isCurved()) return blend(blend(ends[0], ends[1], at.x), blend(ends[2], ends[3], at.x), at.y);
            return decoder_.decode(quad_.texelsAt(place.low + place.size * at).data(), cluster_);
        };
    }
    /// Returns the control vectors over a rectangle with a size.
    CellLight overArea(const PlaceRectangle& place) const {
        const std::size_t nodes = this->nodes(), count = nodes * nodes;
        std::array<LcSh, kMostNodes * kMostNodes> allValues, allReferences;
        std::array<float, kMostNodes * kMostNodes> weights;
        const std::span<LcSh> values(allValues.data(), count), references(allReferences.data(), count);
        CellLight out;
        const auto decodeAt = decodeOver(place, out);
        for (std::size_t v = 0; v < nodes; ++v)
            for (std::size_t u = 0; u < nodes; ++u) {
                const glm::vec2 at = glm::vec2(u, v) / static_cast<float>(nodes - 1);
                const std::size_t k = v * nodes + u;
                std::tie(references[k], weights[k]) = quad_.referenceAt(place.low + place.size * at);
                values[k] = scaled(decodeAt(at), weights[k]);
            }
        controlsFromNodes(values, nodes);
        for (std::size_t k = 0; k < count; ++k) values[k] = scaled(values[k], 1 / weights[k]);
        addDecoders(out);
        addTolerance(place, out);
        for (std::size_t k = 0; k < count; ++k) values[k] = difference(values[k], references[k]);
        addRoundingOf(out, values, references, quad_.isCovered() ? 1 : kRimFactor);
        for (std::size_t k = 0; k < count; ++k) addVectors(out, values[k], references[k]);
        if (decoder_.isInTangentSpace()) addDirections(place, std::span(weights).first(count), out);
        return out;
    }
    /// Adds the light of the directions of a layout in tangent space, with the same weights as the other vectors.
    void addDirections(const PlaceRectangle& place, std::span<const float> weights, CellLight& out) const {
        const std::size_t nodes = this->nodes();
        std::array<LcSh, kMostNodes * kMostNodes> allValues;
        const std::span<LcSh> values(allValues.data(), weights.size());
        for (std::size_t k = 0; k < values.size(); ++k) {
            const glm::vec2 at = glm::vec2(k % nodes, k / nodes) / static_cast<float>(nodes - 1);
            values[k] = scaled(decoder_.directions(quad_.texelsAt(place.low + place.size * at).data(), cluster_), weights[k]);
        }
        controlsFromNodes(values, nodes);
        for (std::size_t k = 0; k < values.size(); ++k) out.directions.add(channelsOf(scaled(values[k], 1 / weights[k])));
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
    /// Adds what decoders of blocks differ by where texels are decoded before they are filtered.
    void addDecoders(CellLight& out) const {
        if (decoder_.isMixed()) addBesideSh(out.errorSlack, decoder_, quad_.corners.texels);
    }
    /// Adds the sampler tolerance over a rectangle and a filter fraction around it, as far as the quad reaches.
    void addTolerance(const PlaceRectangle& place, CellLight& out) const {
        if (tolerance_.isNone()) return;
        PlaceRectangle reach;
        reach.low = glm::max(place.low - kFractionTolerance, 0.0f);
        reach.size = glm::min(place.low + place.size + kFractionTolerance, 1.0f) - reach.low;
        const std::array<FilteredTexels, 4> ends = cornersOf(reach);
        const Deviation off = tolerance_.partDeviation(quad_.corners.texels, pointersTo(ends), quad_.x, quad_.y, cluster_);
        if (decoder_.isCurved()) addCurvature(ends, 2, out);  // of both places between which a fraction moves
        addLengths(out.errorSlack, off.absolute, static_cast<double>(decoder_.perKey()));
        for (const std::array<LcSh, 4>& group : off.groups)
            for (const LcSh& vector : group) {
                const LcSh moved = scaled(vector, decoder_.perKey());
                out.deviations.add(local(moved));
                addLengths(out.errorSlack, moved, kControlRounding);
            }
        addFractions(reach, out);
    }
    /// Adds what filter fractions off by kFractionTolerance do: along an axis, at most degree / size times the largest difference of
    /// neighbouring control vectors.
    void addFractions(const PlaceRectangle& reach, CellLight& out) const {
        const std::size_t nodes = decoder_.nodes();
        const auto degree = static_cast<float>(decoder_.degree());
        std::array<LcSh, kMostNodes * kMostNodes> allValues;
        const std::span<LcSh> values(allValues.data(), nodes * nodes);
        for (std::size_t k = 0; k < values.size(); ++k) {
            const glm::vec2 at = reach.low + reach.size * (glm::vec2(k % nodes, k / nodes) / degree);
            values[k] = decoder_.decode(quad_.texelsAt(at).data(), cluster_);
        }
        controlsFromNodes(values, nodes);
        for (int axis = 0; axis < 2; ++axis) {
            const double steepest = kOutward * static_cast<double>(kFractionTolerance / reach.size[axis]) * decoder_.degree();
            const std::size_t step = axis == 0 ? 1 : nodes;
            std::vector<LcSh> moved;
            for (std::size_t k = 0; k < values.size(); ++k) {
                if ((axis == 0 ? k % nodes : k / nodes) == nodes - 1) continue;
                moved.push_back(difference(values[k + step], values[k]));
            }
            addLargestLengths(out.errorSlack, moved, steepest);
        }
        if (decoder_.isInTangentSpace()) addMovedDirections(out);
    }

    /// Adds what such fractions change of the light that is shown beside the coefficients: that of the differences of the texels.
    void addMovedDirections(CellLight& out) const {
        for (const auto& [a, b, c, d] : {std::array<std::size_t, 4>{1, 0, 3, 2}, std::array<std::size_t, 4>{2, 0, 3, 1}}) {
            FilteredTexels step{};
            for (std::size_t layer = 0; layer < decoder_.layers(); ++layer) {
                const auto& t = quad_.corners.texels;
                step[layer] = glm::max(glm::abs(t[a][layer] - t[b][layer]), glm::abs(t[c][layer] - t[d][layer]));
            }
            const glm::vec3 beside = decoder_.besideSh({step.data(), step.data(), step.data(), step.data()});
            for (std::size_t channel = 0; channel < kChannels; ++channel)
                out.errorSlack[channel][0] +=
                    kOutward * static_cast<double>(kFractionTolerance * decoder_.perKey() * beside[static_cast<int>(channel)]);
        }
    }

    const MapDecoder& decoder_;
    const SamplerTolerance& tolerance_;
    const CoveredQuad& quad_;
    std::size_t cluster_;
    std::array<glm::vec3, 3> frame_;
    PlaceRectangle whole_;
};

}  // namespace lightcook::verify::lightmap
