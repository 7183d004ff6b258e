// A quad's decode as a polynomial of the position, in Bernstein form. Private to verify/.
//
// Filtered texels are bilinear in the position (u, v) of the quad, and the decode is a polynomial of degree n of them. The decoded
// coefficients are therefore a polynomial of degree n along each axis, given by its values at (n + 1)^2 nodes. In Bernstein form,
//   p(u, v) = sum_ij B_i(u) B_j(v) b_ij,   B_i >= 0,   sum_i B_i = 1,
// every value is a weighted mean of the control vectors b_ij, so a convex condition that holds for all b_ij holds everywhere in the quad.
#pragma once

#include <array>
#include <span>

#include "verify/light_map/bound.h"
#include "verify/light_map/map_decoder.h"
#include "verify/light_map/rows.h"
#include "verify/light_map/shading.h"

namespace lightcook::verify::lightmap {

/// A square part of a quad.
struct Part {
    float u = 0, v = 0, size = 1;
};

/// Control vectors of a decode over a part of a quad.
class QuadControls {
public:
    static constexpr std::size_t kMostControls = (kMostDegree + 1) * (kMostDegree + 1);
    /// Control vectors of each channel as errors, each paired with that of the reference.
    struct Pairs {
        std::array<std::array<ErrorPair, kMostControls>, kChannels> all;
        std::size_t count;
        std::span<const ErrorPair> operator[](std::size_t channel) const { return {all[channel].data(), count}; }
    };

    /// Returns the control vectors of decode - filtered reference.
    static QuadControls ofErrors(const MapDecoder& decoder, std::size_t cluster, const QuadTexels& texels, const QuadReferences& references,
                                 const Part& part) {
        QuadControls out(decoder, cluster, texels, references, part);
        for (std::size_t k = 0; k < out.count(); ++k) out.values_[k] = difference(out.values_[k], out.filtered_[k]);
        out.toControls();
        return out;
    }
    /// Returns the control vectors of the decode itself.
    static QuadControls ofDecode(const MapDecoder& decoder, std::size_t cluster, const QuadTexels& texels, const QuadReferences& references,
                                 const Part& part) {
        QuadControls out(decoder, cluster, texels, references, part);
        out.toControls();
        return out;
    }

    /// Returns the number of control vectors along each axis.
    std::size_t nodes() const { return nodes_; }
    std::size_t count() const { return nodes_ * nodes_; }
    std::span<LcSh> values() { return {values_.data(), count()}; }
    std::span<const LcSh> values() const { return {values_.data(), count()}; }
    /// Returns those of the filtered reference.
    std::span<const LcSh> filtered() const { return {filtered_.data(), count()}; }
    Pairs pairs() const {
        Pairs pairs;
        pairs.count = count();
        for (std::size_t k = 0; k < count(); ++k) {
            const Channels error = channelsOf(values_[k]), reference = channelsOf(filtered_[k]);
            for (std::size_t c = 0; c < kChannels; ++c) pairs.all[c][k] = {error[c], reference[c]};
        }
        return pairs;
    }

private:
    /// Evaluates decode and filtered reference at the nodes. The filtered reference is bilinear: its control vectors of any degree are its
    /// values at the nodes.
    QuadControls(const MapDecoder& decoder, std::size_t cluster, const QuadTexels& texels, const QuadReferences& references,
                 const Part& part)
        : nodes_(decoder.nodes()) {
        const std::size_t layers = decoder.layers();
        const auto place = [&](float from, std::size_t node) {
            return from + part.size * static_cast<float>(node) / static_cast<float>(decoder.degree());
        };
        for (std::size_t v = 0; v < nodes_; ++v) {
            const float fv = place(part.v, v);
            const FilteredTexels left = blend(texels[0], texels[2], fv, layers), right = blend(texels[1], texels[3], fv, layers);
            const LcSh leftReference = blend(*references[0], *references[2], fv),
                       rightReference = blend(*references[1], *references[3], fv);
            for (std::size_t u = 0; u < nodes_; ++u) {
                const float fu = place(part.u, u);
                const std::size_t node = v * nodes_ + u;
                filtered_[node] = blend(leftReference, rightReference, fu);
                values_[node] = decoder.decode(blend(left.data(), right.data(), fu, layers).data(), cluster);
            }
        }
    }
    void toControls() { controlsFromNodes(values(), nodes_); }

    std::size_t nodes_;
    std::array<LcSh, kMostControls> values_, filtered_;
};

}  // namespace lightcook::verify::lightmap
