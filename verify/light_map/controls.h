// A quad's decode as a polynomial: what it is at nodes, turned into Bernstein control vectors. Private to verify/.
#pragma once

#include "verify/light_map/bound.h"
#include "verify/light_map/rows.h"
#include "verify/light_map/shading.h"

namespace lightcook::verify::lightmap {

/// A square part of a quad.
struct Part {
    float u = 0, v = 0, size = 1;
};

/// Of a decode of degree Layout::kDegree.
template <class Layout>
struct QuadControls {
    static constexpr int kNodes = Layout::kDegree + 1;
    static constexpr std::size_t kControls = static_cast<std::size_t>(kNodes) * kNodes;
    using Controls = std::array<LcSh, kControls>;
    using Pairs = std::array<std::array<ErrorPair, kControls>, kChannels>;
    using QuadTexels = typename MapRows<Layout>::QuadTexels;
    using QuadReferences = typename MapRows<Layout>::QuadReferences;

    Controls values, filtered;

    /// value(filtered texels, filtered reference) at the (degree + 1)^2 nodes of a part of the quad, turned into Bernstein control vectors:
    /// its value at every position is a mean of them. The filtered reference is bilinear: its form of the same degree has its values at the
    /// nodes themselves for controls.
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

    /// Of values as errors, by channel.
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
