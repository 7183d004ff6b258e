// A quad's decode as a polynomial of the position, in Bernstein form. Private to verify/.
//
// Filtered texels are bilinear in the position (u, v) of the quad, and the decode is a polynomial of degree n of them. The decoded
// coefficients are therefore a polynomial of degree n along each axis, given by its values at (n + 1)^2 nodes. In Bernstein form,
//   p(u, v) = sum_ij B_i(u) B_j(v) b_ij,   B_i >= 0,   sum_i B_i = 1,
// every value is a weighted mean of the control vectors b_ij, so a convex condition that holds for all b_ij holds everywhere in the quad.
#pragma once

#include "verify/light_map/bound.h"
#include "verify/light_map/rows.h"
#include "verify/light_map/shading.h"

namespace lightcook::verify::lightmap {

/// A square part of a quad.
struct Part {
    float u = 0, v = 0, size = 1;
};

/// Control vectors of a decode of degree Layout::kDegree over a part of a quad.
template <class Layout>
struct QuadControls {
    static constexpr int kNodes = Layout::kDegree + 1;
    static constexpr std::size_t kControls = static_cast<std::size_t>(kNodes) * kNodes;
    using Controls = std::array<LcSh, kControls>;
    using Pairs = std::array<std::array<ErrorPair, kControls>, kChannels>;
    using QuadTexels = typename MapRows<Layout>::QuadTexels;
    using QuadReferences = typename MapRows<Layout>::QuadReferences;

    Controls values;    ///< of value()
    Controls filtered;  ///< of the filtered reference

    /// Evaluates value(filtered texels, filtered reference) at the nodes and converts the values to control vectors. The filtered reference
    /// is bilinear: its control vectors of any degree are its values at the nodes.
    template <class Value>
    QuadControls(const QuadTexels& texels, const QuadReferences& references, const Part& part, Value&& value) {
        for (int v = 0; v < kNodes; ++v) {
            const float fv = part.v + part.size * static_cast<float>(v) / Layout::kDegree;
            const auto left = blend(*texels[0], *texels[2], fv), right = blend(*texels[1], *texels[3], fv);
            const LcSh leftReference = blend(*references[0], *references[2], fv),
                       rightReference = blend(*references[1], *references[3], fv);
            for (int u = 0; u < kNodes; ++u) {
                const float fu = part.u + part.size * static_cast<float>(u) / Layout::kDegree;
                const auto node = static_cast<std::size_t>(v * kNodes + u);
                filtered[node] = blend(leftReference, rightReference, fu);
                values[node] = value(blend(left, right, fu), filtered[node]);
            }
        }
        if constexpr (Layout::kDegree > 1) {
            for (int line = 0; line < kNodes; ++line) convertLine(line * kNodes, 1);
            for (int line = 0; line < kNodes; ++line) convertLine(line, kNodes);
        }
    }

    /// Returns, by channel, each control vector as an error, paired with that of the reference.
    Pairs pairs() const {
        Pairs pairs;
        for (std::size_t k = 0; k < kControls; ++k) {
            const Channels error = channelsOf(values[k]), reference = channelsOf(filtered[k]);
            for (std::size_t c = 0; c < kChannels; ++c) pairs[c][k] = {error[c], reference[c]};
        }
        return pairs;
    }

private:
    void convertLine(int first, int step) {
        std::array<LcSh*, static_cast<std::size_t>(kNodes)> line;
        for (int i = 0; i < kNodes; ++i) line[static_cast<std::size_t>(i)] = &values[static_cast<std::size_t>(first + i * step)];
        bernsteinFromNodes<Layout::kDegree>(line);
    }
};

}  // namespace lightcook::verify::lightmap
