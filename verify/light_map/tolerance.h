// What a sampler is free to do with the texels of a cooked map, as lengths beside its errors. Private to verify/.
#pragma once

#include <algorithm>
#include <vector>

#include "verify/light_map/deviation.h"
#include "verify/light_map/rows.h"
#include "verify/light_map/worst.h"

namespace lightcook::verify::lightmap {

template <class Layout>
class Liberties {
public:
    using LayerTexels = typename MapRows<Layout>::LayerTexels;
    using QuadTexels = typename MapRows<Layout>::QuadTexels;
    using QuadReferences = typename MapRows<Layout>::QuadReferences;

    /// freedom  of each layer; empty: an ideal sampler
    Liberties(const MapRows<Layout>& rows, const std::vector<FormatFreedom>& freedom) : rows_(rows), freedom_(freedom) {
        for (const auto& texture : rows.texels().spans)
            for (const formats::Image<glm::vec4>& image : texture) spans_.push_back(&image);
    }
    const std::vector<FormatFreedom>& formats() const { return freedom_; }
    bool isNone() const { return freedom_.empty(); }

    /// At the centre of a texel.
    ChannelSlack ofCentre(const LayerTexels& texels, int x, int y) const {
        if (isNone()) return {};
        layouts::Boxes<Layout::kLayers> boxes;
        bool isFree = false;
        for (std::size_t layer = 0; layer < boxes.size(); ++layer) {
            boxes[layer] = {texels[layer], glm::vec4(0), decodeFreedom(layer, x, y, 0)};
            isFree = isFree || boxes[layer].freedom != glm::vec4(0);
        }
        return isFree ? lengthsOf(deviation(boxes, x, y), true) : ChannelSlack{};
    }
    /// What the decode of the texel at `corner` may be off in the quad at (x, y).
    auto ofQuad(const QuadTexels& texels, int x, int y, int corner) const {
        return deviation(quadBoxes(texels, x, y), x + corner % 2, y + corner / 2);
    }
    /// Its band lengths, quickly, by the lengths of every vector, or exactly, by the sums with every choice of signs: the longest are among
    /// them. Lengths do not ask for a whole group's sign, which halves the choices.
    template <std::size_t kGroups>
    ChannelSlack lengthsOf(const layouts::Deviation<kGroups>& off, bool isExact) const {
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
    /// What the filter's fractions move the light of a decode of degree kDegree: a polynomial in Bernstein form changes by at most its
    /// degree times the difference of neighbouring controls; of the reference those are the texels themselves.
    static void addFractions(ChannelSlack& slack, const QuadReferences& references, const Squares& error) {
        const auto steps = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
            const std::array<LcSh, 2> edges = {difference(*references[a], *references[b]), difference(*references[c], *references[d])};
            return largestSquares(edges);
        };
        const Squares across = steps(1, 0, 3, 2), down = steps(2, 0, 3, 1);
        constexpr double kBend = 4.0 * Layout::kDegree;
        for (std::size_t l = 0; l < 3; ++l) {
            for (std::size_t c = 0; c < kChannels; ++c) {
                const auto length = [&](const Squares& squares) { return outwardLength(squares[l][static_cast<int>(c)]); };
                slack[c][l] += kFractionFreedom * (length(across) + length(down) + kBend * length(error));
            }
        }
    }

    /// Of a layer between the corners of the quad at (x, y); but for what is a part of the light.
    glm::vec4 freedomAt(std::size_t layer, int x, int y) const { return decodeFreedom(layer, x, y, 1) + freedom_[layer].absolute; }

private:
    /// Of one layer at texels (x, y) to (x + reach, y + reach): between them, or at one of them alone.
    glm::vec4 decodeFreedom(std::size_t layer, int x, int y, int reach) const {
        const FormatFreedom& format = freedom_[layer];
        if (!format.hasSpans() || spans_.empty()) return format.decoded;
        const int firstRow = rows_.texels().firstRow;
        glm::vec4 span(0);
        for (int blockY = (y - firstRow) / 4; blockY <= (y + reach - firstRow) / 4; ++blockY)
            for (int blockX = x / 4; blockX <= (x + reach) / 4; ++blockX) span = glm::max(span, spans_[layer]->at(blockX, blockY));
        return format.decoded + format.perSpan * span;
    }
    /// What the decode of texel (x, y) may be off, over boxes of texels.
    auto deviation(const layouts::Boxes<Layout::kLayers>& boxes, int x, int y) const {
        if constexpr (requires { Layout::kCodeCount; })
            return layouts::deviationOf<Layout::kCodeCount, Layout::kResidualCount>(rows_.layout().at(x, y), boxes);
        else
            return layouts::Deviation<0>{layouts::deviationOf(rows_.layout(), boxes), {}};
    }
    layouts::Boxes<Layout::kLayers> quadBoxes(const QuadTexels& texels, int x, int y) const {
        layouts::Boxes<Layout::kLayers> boxes;
        for (std::size_t layer = 0; layer < boxes.size(); ++layer) {
            const auto at = [&](std::size_t corner) -> const glm::vec4& { return (*texels[corner])[layer]; };
            const glm::vec4 low = glm::min(glm::min(at(0), at(1)), glm::min(at(2), at(3))),
                            high = glm::max(glm::max(at(0), at(1)), glm::max(at(2), at(3)));
            TexelBox& box = boxes[layer];
            box.centre = 0.5f * (low + high);
            box.half = kOutward * (0.5f * (high - low));
            const FormatFreedom& format = freedom_[layer];
            box.freedom = decodeFreedom(layer, x, y, 1) + format.absolute + format.relative * glm::max(glm::abs(low), glm::abs(high));
        }
        return boxes;
    }

    const MapRows<Layout>& rows_;
    const std::vector<FormatFreedom>& freedom_;
    std::vector<const formats::Image<glm::vec4>*> spans_;  ///< [layer]
};

}  // namespace lightcook::verify::lightmap
