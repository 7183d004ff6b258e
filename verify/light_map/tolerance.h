// Sampler tolerance of a cooked map as slack: lengths of what a conforming sampler may add to the error of a texel or a quad.
// Private to verify/.
#pragma once

#include <algorithm>
#include <vector>

#include "verify/light_map/bound_evaluator.h"
#include "verify/light_map/rows.h"

namespace lightcook::verify::lightmap {

class SamplerTolerance {
public:
    /// formats  tolerance of each layer; empty: an ideal sampler
    SamplerTolerance(const MapRows& rows, const std::vector<FormatTolerance>& formats) : rows_(rows), formats_(formats) {
        for (const auto& texture : rows.texels().spans)
            for (const formats::Image<glm::vec4>& image : texture) spans_.push_back(&image);
    }
    const std::vector<FormatTolerance>& formats() const { return formats_; }
    bool isNone() const { return formats_.empty(); }
    /// Returns true if equal texels of two blocks may have different tolerances.
    bool isOfBlocks() const { return !spans_.empty() && std::ranges::any_of(formats_, &FormatTolerance::hasSpans); }

    /// Returns the slack at the centre of texel (x, y).
    ChannelSlack centreSlack(LayerTexels texels, int x, int y) const {
        if (isNone()) return {};
        LayerBoxes boxes;
        bool hasTolerance = false;
        for (std::size_t layer = 0; layer < layers(); ++layer) {
            boxes[layer] = {texels[layer], glm::vec4(0), decodedTolerance(layer, x, y, 0)};
            hasTolerance = hasTolerance || boxes[layer].tolerance != glm::vec4(0);
        }
        return hasTolerance ? lengthsOf(deviation(boxes, rows_.decoder().clusterAt(x, y)), true) : ChannelSlack{};
    }
    /// Returns the deviation of the decode of the texel at `corner`, anywhere in the quad at (x, y).
    Deviation quadDeviation(const QuadTexels& texels, int x, int y, int corner) const {
        return deviation(quadBoxes(texels, x, y), rows_.decoder().clusterAt(x + corner % 2, y + corner / 2));
    }
    /// Returns the deviation of the decode of a cluster in a part of the quad at (x, y).
    /// ends  filtered texels at the corners of the part
    Deviation partDeviation(const QuadTexels& texels, const QuadTexels& ends, int x, int y, std::size_t cluster) const {
        LayerBoxes boxes = quadBoxes(ends, x, y);
        const LayerBoxes whole = quadBoxes(texels, x, y);
        // The tolerance is that of the texels, which may be brighter than what is filtered from them.
        for (std::size_t layer = 0; layer < layers(); ++layer) boxes[layer].tolerance = whole[layer].tolerance;
        return deviation(boxes, cluster);
    }
    /// Returns the band lengths of a deviation. A convex function of factors in [-1, 1] has its maximum where each is +-1, so the exact
    /// length of a group is the largest over all choices of signs. Not exact: the sum of the vectors' lengths, which is larger and faster.
    ChannelSlack lengthsOf(const Deviation& off, bool isExact) const {
        ChannelSlack slack{};
        const auto perKey = static_cast<double>(rows_.perKey());
        addLengths(slack, off.absolute, perKey);
        for (const std::array<LcSh, 4>& group : off.groups) {
            if (!isExact) {
                for (const LcSh& vector : group) addLengths(slack, vector, perKey);
                continue;
            }
            addLargestLengths(slack, signedSumsOf(group), perKey);
        }
        return slack;
    }
    /// Adds the effect of inexact filter fractions, which move a sample by up to kFractionTolerance texels along each axis. A polynomial in
    /// Bernstein form changes by at most its degree times the largest difference of neighbouring control vectors. For the reference these
    /// are the texels; differences of errors are at most twice the largest error.
    void addFilterFractions(ChannelSlack& slack, const QuadReferences& references, const Squares& error) const {
        const auto steps = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
            const std::array<LcSh, 2> edges = {difference(*references[a], *references[b]), difference(*references[c], *references[d])};
            return largestSquares(edges);
        };
        const Squares across = steps(1, 0, 3, 2), down = steps(2, 0, 3, 1);
        const double errorFactor = 4.0 * rows_.decoder().degree();  // 2 axes, each degree * 2 |error|
        for (std::size_t l = 0; l < 3; ++l) {
            for (std::size_t c = 0; c < kChannels; ++c) {
                const auto length = [&](const Squares& squares) { return outwardLength(squares[l][static_cast<int>(c)]); };
                slack[c][l] += kFractionTolerance * (length(across) + length(down) + errorFactor * length(error));
            }
        }
    }

    /// Returns the tolerance of a layer's filtered texels in the quad at (x, y), without the part that is relative to the value.
    glm::vec4 toleranceAt(std::size_t layer, int x, int y) const { return decodedTolerance(layer, x, y, 1) + formats_[layer].absolute; }

private:
    /// Boxes of the layers; those beyond the layers of the layout are not used.
    using LayerBoxes = std::array<TexelBox, kMostLayers>;

    std::size_t layers() const { return formats_.size(); }
    /// Returns the tolerance of a layer's decoded texels (x, y) to (x + reach, y + reach), by the largest span of their blocks.
    glm::vec4 decodedTolerance(std::size_t layer, int x, int y, int reach) const {
        const FormatTolerance& format = formats_[layer];
        if (!format.hasSpans() || spans_.empty()) return format.decoded;
        const int firstRow = rows_.texels().firstRow;
        glm::vec4 span(0);
        // A quad may reach over the edge of the map by one texel.
        const int lastX = std::min(x + reach, rows_.width() - 1), lastY = std::min(y + reach, rows_.lastRow());
        for (int blockY = std::max(y - firstRow, 0) / 4; blockY <= (lastY - firstRow) / 4; ++blockY)
            for (int blockX = std::max(x, 0) / 4; blockX <= lastX / 4; ++blockX) span = glm::max(span, spans_[layer]->at(blockX, blockY));
        return format.decoded + format.perSpan * span;
    }
    Deviation deviation(const LayerBoxes& boxes, std::size_t cluster) const {
        return rows_.decoder().deviation({boxes.data(), layers()}, cluster);
    }
    LayerBoxes quadBoxes(const QuadTexels& texels, int x, int y) const {
        LayerBoxes boxes;
        for (std::size_t layer = 0; layer < layers(); ++layer) {
            const auto at = [&](std::size_t corner) -> const glm::vec4& { return texels[corner][layer]; };
            const glm::vec4 low = glm::min(glm::min(at(0), at(1)), glm::min(at(2), at(3))),
                            high = glm::max(glm::max(at(0), at(1)), glm::max(at(2), at(3)));
            TexelBox& box = boxes[layer];
            box.centre = 0.5f * (low + high);
            box.half = kOutwardFloat * (0.5f * (high - low));
            const FormatTolerance& format = formats_[layer];
            box.tolerance = decodedTolerance(layer, x, y, 1) + format.absolute + format.relative * glm::max(glm::abs(low), glm::abs(high));
        }
        return boxes;
    }

    const MapRows& rows_;
    const std::vector<FormatTolerance>& formats_;
    std::vector<const formats::Image<glm::vec4>*> spans_;  ///< [layer]
};

/// Adds light that no coefficient has, anywhere between these corners: what a layout in tangent space shows beside them, and what decoders
/// of blocks differ by where texels are decoded before they are filtered.
inline void addBesideSh(ChannelSlack& slack, const MapDecoder& decoder, const QuadTexels& corners) {
    if (decoder.isMixed()) {
        const BandLengths lengths = decoder.decodersDiffer(corners);
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t l = 0; l < 3; ++l) slack[c][l] += kOutward * static_cast<double>(lengths[3 * l + c]);
    }
    if (!decoder.isInTangentSpace()) return;
    const glm::vec3 beside = decoder.besideSh(corners);
    for (std::size_t c = 0; c < kChannels; ++c)
        slack[c][0] += kOutward * static_cast<double>(decoder.perKey() * beside[static_cast<int>(c)]);
}

/// Tolerance of the layers in one quad.
class QuadTolerance {
public:
    QuadTolerance(const SamplerTolerance& tolerance, int x, int y) : tolerance_(tolerance), x_(x), y_(y) {}
    glm::vec4 at(std::size_t layer) const { return tolerance_.toleranceAt(layer, x_, y_); }

private:
    const SamplerTolerance& tolerance_;
    int x_, y_;
};

}  // namespace lightcook::verify::lightmap
