// Access to rows, texels and quads of a cooked map together with its reference. A quad is the square between four neighbouring texel
// centres. Private to verify/.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <span>
#include <utility>
#include <vector>

#include "lighting/sphere.h"
#include "verify/light_map.h"
#include "verify/light_map/map_decoder.h"
#include "verify/light_map/vectors.h"

namespace lightcook::verify::lightmap {

inline std::size_t index(int x) {
    return static_cast<std::size_t>(x);
}

/// References of the corners of a quad, in the order of its texels.
using QuadReferences = std::array<const LcSh*, 4>;

/// Returns filtered texels between two places.
inline FilteredTexels blend(LayerTexels a, LayerTexels b, float weight, std::size_t layers) {
    FilteredTexels out;
    for (std::size_t i = 0; i < layers; ++i) out[i] = (1 - weight) * a[i] + weight * b[i];
    return out;
}
/// Returns filtered texels at a place of a quad, in fractions of it.
inline FilteredTexels blend(const QuadTexels& t, const glm::vec2& place, std::size_t layers) {
    FilteredTexels out;
    for (std::size_t i = 0; i < layers; ++i) {
        const glm::vec4 above = (1 - place.x) * t[0][i] + place.x * t[1][i], below = (1 - place.x) * t[2][i] + place.x * t[3][i];
        out[i] = (1 - place.y) * above + place.y * below;
    }
    return out;
}

/// A cooked map and its reference.
class MapRows {
public:
    /// isBounded  false: what decoders of blocks may differ by is left out of mixed light
    MapRows(const MapDecoder& decoder, const CookedLightMap& map, const DecodedLightMapRows& texels,
            const formats::LightMapStrip& reference, bool isBounded = true)
        : decoder_(decoder), map_(map), texels_(texels), reference_(reference) {
        for (std::size_t texture = 0; texture < texels_.textures.size(); ++texture)
            for (const formats::Image<glm::vec4>& image : texels_.textures[texture]) {
                layers_.push_back(&image);
                sides_.push_back(decoder.info().textures[texture].side);
            }
        if (!decoder.isMixed()) return;
        if (isBounded) tolerances_ = tolerancesOf(map.formats, texels_.textures);
        if (decoder.ofDetail() == nullptr) return;
        for (const auto& texture : texels_.detail.textures)
            for (const formats::Image<glm::vec4>& image : texture) detailLayers_.push_back(&image);
        if (isBounded) detailTolerances_ = tolerancesOf(map.detail->formats, texels_.detail.textures);
    }

    const MapDecoder& decoder() const { return decoder_; }
    int width() const { return map_.width; }
    int height() const { return map_.height; }
    float perKey() const { return decoder_.perKey(); }
    const DecodedLightMapRows& texels() const { return texels_; }
    /// Returns the last row that texels and reference both hold.
    int lastRow() const {
        return std::min(texels_.firstRow + texels_.textures.front().front().height(), reference_.firstRow + reference_.sh.height()) - 1;
    }
    bool hasCharts() const { return reference_.chart.width() > 0; }
    /// Returns a right-handed frame of texel (x, y) with its normal as z; that of its tangent where the layout is in tangent space.
    glm::dmat3 frameAt(int x, int y) const {
        const glm::dvec3 normal(normalAt(x, y));
        if (!decoder_.isInTangentSpace()) return lighting::worldFromTangentFrame(normal);
        const glm::dvec3 tangent(glm::vec3(reference_.tangent.at(x, y - reference_.firstRow)));
        return {tangent, glm::cross(normal, tangent), normal};
    }
    const glm::vec3& normalAt(int x, int y) const { return reference_.normal.at(x, y - reference_.firstRow); }

    /// One row of the map; light in units of the key.
    struct Row {
        std::vector<std::uint8_t> covered;
        std::vector<std::uint32_t> chart;   ///< empty as in the reference
        std::vector<std::uint8_t> repeats;  ///< the texel has all that decides its light from its left neighbour
        std::vector<LcSh> reference;
        std::size_t layers = 0;
        std::vector<glm::vec4> texels;  ///< [column][layer]
        LayerTexels texelsAt(std::size_t i) const { return texels.data() + layers * i; }
    };
    struct Corners {
        QuadTexels texels;
        QuadReferences references;
    };
    static Corners cornersOf(const Row& above, const Row& below, int x) {
        const std::size_t i = index(x);
        return {{above.texelsAt(i), above.texelsAt(i + 1), below.texelsAt(i), below.texelsAt(i + 1)},
                {&above.reference[i], &above.reference[i + 1], &below.reference[i], &below.reference[i + 1]}};
    }

    /// Calls work(row, x, y) for every covered texel of these rows.
    template <class Work>
    void forEachTexel(int firstRow, int rowCount, Work&& work) const {
        Row row;
        for (int y = firstRow; y < firstRow + rowCount; ++y) {
            loadRow(y, row);
            for (int x = 0; x < map_.width; ++x)
                if (row.covered[index(x)] != 0) work(row, x, y);
        }
    }
    /// Calls work(row, row below, y) for these rows, except the last row of the map.
    template <class Work>
    void forEachPairOfRows(int firstRow, int rowCount, Work&& work) const {
        Row above, below;
        loadRow(firstRow, above);
        for (int y = firstRow; y < std::min(firstRow + rowCount, map_.height - 1); ++y) {
            loadRow(y + 1, below);
            work(above, below, y);
            std::swap(above, below);
        }
    }
    static bool isQuad(const Row& above, const Row& below, int x) {
        const std::size_t i = index(x);
        if (above.covered[i] == 0 || above.covered[i + 1] == 0 || below.covered[i] == 0 || below.covered[i + 1] == 0) return false;
        return above.chart.empty() || formats::mayHoldSurface({above.chart[i], above.chart[i + 1], below.chart[i], below.chart[i + 1]});
    }
    /// Returns true if quad x has all that decides its light from its left neighbour, but for tolerances of blocks.
    static bool repeatsLeft(const Row& above, const Row& below, int x) {
        if (x < 1 || x + 1 >= static_cast<int>(above.repeats.size())) return false;
        const std::size_t i = index(x);
        return (above.repeats[i] & above.repeats[i + 1] & below.repeats[i] & below.repeats[i + 1]) != 0;
    }
    /// Calls work(corners, x, y) for every quad of covered texels that begins in these rows.
    template <class Work>
    void forEachQuad(int firstRow, int rowCount, Work&& work) const {
        forEachPairOfRows(firstRow, rowCount, [&](const Row& above, const Row& below, int y) {
            for (int x = 0; x + 1 < map_.width; ++x)
                if (isQuad(above, below, x)) work(cornersOf(above, below, x), x, y);
        });
    }
    /// Loads texels [firstX, firstX + count) of row y.
    void load(int firstX, int count, int y, Row& row) const { loadTexels(firstX, count, y, row); }
    /// Calls work(corners) for the quad whose top left texel is (x, y).
    template <class Work>
    void withQuad(int x, int y, Work&& work) const {
        Row above, below;
        loadTexels(x, 2, y, above);
        loadTexels(x, 2, y + 1, below);
        work(cornersOf(above, below, 0));
    }

    /// Returns true if corners i and j of the quad at (x, y) have the same decode.
    bool hasSameDecode(int x, int y, int i, int j) const {
        return !decoder_.hasClusters() || i == j || decoder_.hasSameDecode(clusterOf(x, y, i), clusterOf(x, y, j));
    }
    /// Returns the cluster of a corner of the quad at (x, y), which may reach over the edge of the map by one texel.
    std::size_t clusterOf(int x, int y, int corner) const {
        return decoder_.clusterAt(std::clamp(x + corner % 2, 0, map_.width - 1), std::clamp(y + corner / 2, 0, map_.height - 1));
    }
    /// Returns true if no earlier corner has the same decode. A quad is bounded under the decode of each corner, because a surface there
    /// may use any of them.
    bool isNewDecode(int x, int y, int corner) const {
        for (int before = 0; before < corner; ++before)
            if (hasSameDecode(x, y, before, corner)) return false;
        return true;
    }

    /// Returns the light that texel (x, y) decodes from filtered texels.
    LcSh decoded(LayerTexels texels, int x, int y) const { return decoder_.decode(texels, decoder_.clusterAt(x, y)); }

private:
    void loadRow(int y, Row& row) const { loadTexels(0, map_.width, y, row); }
    void loadTexels(int firstX, int count, int y, Row& row) const {
        row.covered.resize(index(count));
        row.reference.resize(index(count));
        row.layers = decoder_.layers();
        row.texels.resize(row.layers * index(count));
        const int stripRow = y - reference_.firstRow, texelRow = y - texels_.firstRow;
        if (reference_.chart.width() > 0) {
            const std::uint32_t* const charts = reference_.chart.view().row(stripRow) + firstX;
            row.chart.assign(charts, charts + count);
        }
        // Filters of the hardware reach uncovered texels too.
        for (std::size_t layer = 0; layer < row.layers && !decoder_.isMixed(); ++layer) {
            const glm::vec4* const texels = layers_[layer]->view().row(texelRow) + firstX;
            for (std::size_t i = 0; i < index(count); ++i) row.texels[row.layers * i + layer] = texels[i];
        }
        for (int i = 0; i < count; ++i) {
            const int x = firstX + i;
            row.covered[index(i)] = reference_.covered.at(x, stripRow);
            const auto texels = std::span(row.texels).subspan(row.layers * index(i), row.layers);
            if (row.covered[index(i)] == 0) {
                if (decoder_.isMixed()) std::ranges::fill(texels, glm::vec4(0));
                continue;
            }
            row.reference[index(i)] = referenceAt(x, stripRow);
            if (decoder_.isMixed()) decodeTexel(x, y, row.reference[index(i)], texels);
        }
        row.repeats.assign(index(count), 0);
        for (int i = 1; i < count; ++i) row.repeats[index(i)] = isLikeLeft(row, i, firstX + i, y) ? 1 : 0;
    }
    /// Returns true if texel i of a row, (x, y) of the map, has all that decides its light from its left neighbour.
    bool isLikeLeft(const Row& row, int i, int x, int y) const {
        const std::size_t at = index(i), left = at - 1;
        if (row.covered[at] != row.covered[left] || (!row.chart.empty() && row.chart[at] != row.chart[left])) return false;
        if (!std::equal(row.texelsAt(at), row.texelsAt(at) + row.layers, row.texelsAt(left))) return false;
        if (row.covered[at] == 0) return true;
        const int stripRow = y - reference_.firstRow;
        if (!std::ranges::equal(row.reference[at].c, row.reference[left].c) || normalAt(x, y) != normalAt(x - 1, y)) return false;
        if (decoder_.isInTangentSpace() && reference_.tangent.at(x, stripRow) != reference_.tangent.at(x - 1, stripRow)) return false;
        return !decoder_.hasClusters() || decoder_.hasSameDecode(decoder_.clusterAt(x, y), decoder_.clusterAt(x - 1, y));
    }
    /// Returns what decoders of blocks differ by, of each layer. Empty: nothing
    static std::vector<glm::vec4> tolerancesOf(const std::vector<formats::PixelFormat>& formats,
                                               const std::vector<std::vector<formats::Image<glm::vec4>>>& textures) {
        std::vector<glm::vec4> out;
        for (std::size_t texture = 0; texture < formats.size(); ++texture)
            out.insert(out.end(), textures[texture].size(), toleranceOf(formats[texture]).decoded);
        if (std::ranges::all_of(out, [](const glm::vec4& each) { return each == glm::vec4(0); })) out.clear();
        return out;
    }
    /// Sets the layers of mixedDecoder() for texel (x, y).
    void decodeTexel(int x, int y, const LcSh& reference, std::span<glm::vec4> out) const {
        const MapDecoder& decoder = *decoder_.ofTexels();
        const int row = y - texels_.firstRow;
        FilteredTexels texel;
        for (std::size_t layer = 0; layer < layers_.size(); ++layer)
            texel[layer] = layers_[layer]->at(x / sides_[layer], row / sides_[layer]);
        std::array<LcSh, kMostStages> light;
        const std::size_t cluster = decoder.clusterAt(x, y);
        decoder.decodeStages(texel.data(), reference, cluster, light);
        const bool isDetail = decoder_.ofDetail() != nullptr && texels_.detail.has.at(x, row) != 0;
        if (isDetail) {
            for (std::size_t layer = 0; layer < detailLayers_.size(); ++layer) texel[layer] = detailLayers_[layer]->at(x, row);
            light[decoder.stages() - 1] = decoder_.ofDetail()->decode(texel.data(), 0);
        }
        auto layer = out.begin();
        for (std::size_t stage = decoder.stages(); stage-- > 0;)
            for (const glm::vec3& coefficient : light[stage].c) *layer++ = glm::vec4(coefficient, 0);
        std::fill(layer, out.end(), glm::vec4(0));
        const std::vector<glm::vec4>& tolerances = isDetail ? detailTolerances_ : tolerances_;
        if (tolerances.empty()) return;
        std::array<TexelBox, kMostLayers> boxes;
        for (std::size_t i = 0; i < tolerances.size(); ++i) boxes[i] = {texel[i], glm::vec4(0), tolerances[i]};
        const std::span<const TexelBox> box(boxes.data(), tolerances.size());
        const Deviation off = isDetail ? decoder_.ofDetail()->deviation(box, 0) : decoder.deviation(box, cluster);
        BandLengths lengths = bandLengths(scaled(off.absolute, perKey()));
        for (const std::array<LcSh, 4>& group : off.groups)
            for (const LcSh& vector : group) {
                const BandLengths more = bandLengths(scaled(vector, perKey()));
                for (std::size_t i = 0; i < lengths.size(); ++i) lengths[i] += more[i];
            }
        for (std::size_t l = 0; l < 3; ++l) *layer++ = glm::vec4(lengths[3 * l], lengths[3 * l + 1], lengths[3 * l + 2], 0);
    }
    LcSh referenceAt(int x, int stripRow) const {
        LcSh out{};
        const lighting::ShRgb& sh = reference_.sh.at(x, stripRow);
        for (std::size_t i = 0; i < kCoefficients; ++i) out.c[i] = perKey() * sh[i];
        if (!decoder_.isOwnNormalOnly()) return out;
        LcSh flat{};
        flat.c[0] = shaders::lcExitRadiance(out, reference_.normal.at(x, stripRow)) / layouts::Flat::kY0;
        return flat;
    }

    const MapDecoder& decoder_;
    const CookedLightMap& map_;
    const DecodedLightMapRows& texels_;
    const formats::LightMapStrip& reference_;
    std::vector<const formats::Image<glm::vec4>*> layers_;
    std::vector<int> sides_;  ///< [layer], of their textures
    std::vector<const formats::Image<glm::vec4>*> detailLayers_;
    std::vector<glm::vec4> tolerances_, detailTolerances_;  ///< [layer] of light that is mixed: what decoders differ by; empty: nothing
};

}  // namespace lightcook::verify::lightmap
