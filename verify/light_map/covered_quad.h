// Quads with at least one covered texel: all places where a surface may read a map, rims of charts included. Private to verify/.
//
// The filter of a GPU reaches all four cooked texels; filter "decoded" mixes the light of the covered ones alone. So does the reference:
// with bilinear weights w_i over them, R = (sum of w_i r_i) / (sum of w_i).
// A quad that holds no surface (formats::mayHoldSurface) counts as not covered.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec2.hpp>

#include "verify/light_map/rows.h"

namespace lightcook::verify::lightmap {

struct CoveredQuad {
    int x = 0, y = 0;                 ///< of texel (0, 0), which may lie one texel outside of the map: texels are repeated there
    int mapWidth = 0, mapHeight = 0;  ///< [texels]
    std::size_t layers = 0;
    bool isMixed = false;  ///< MapDecoder::isMixed
    MapRows::Corners corners;
    std::array<bool, 4> covered{};

    /// above, below  rows y and y + 1, clamped to the map, from column firstX on
    CoveredQuad(const MapRows& rows, const MapRows::Row& above, const MapRows::Row& below, int quadX, int quadY, int firstX = 0)
        : x(quadX), y(quadY), mapWidth(rows.width()), mapHeight(rows.height()), layers(above.layers), isMixed(rows.decoder().isMixed()) {
        std::array<std::uint32_t, 4> charts{};
        for (int corner = 0; corner < 4; ++corner) {
            const MapRows::Row& row = corner < 2 ? above : below;
            const std::size_t at = index(texelX(corner) - firstX), i = index(corner);
            corners.texels[i] = row.texelsAt(at);
            corners.references[i] = &row.reference[at];
            covered[i] = row.covered[at] != 0;
            if (!row.chart.empty()) charts[i] = row.chart[at];
        }
        if (!above.chart.empty() && !formats::mayHoldSurface(charts)) covered = {};
    }

    int coveredCount() const { return covered[0] + covered[1] + covered[2] + covered[3]; }
    bool isCovered() const { return coveredCount() == 4; }
    int texelX(int corner) const { return std::clamp(x + corner % 2, 0, mapWidth - 1); }
    int texelY(int corner) const { return std::clamp(y + corner / 2, 0, mapHeight - 1); }
    /// Returns true if the corner is a texel of the map and not its repetition beyond the edge.
    bool isOwn(int corner) const { return texelX(corner) == x + corner % 2 && texelY(corner) == y + corner / 2; }
    /// Returns true if all four corners are covered texels of the map.
    bool isInside() const { return isCovered() && isOwn(0) && isOwn(3); }
    /// Returns true if the quarter nearest to a corner belongs to a covered texel.
    bool hasQuarter(int corner) const { return covered[index(corner)] && isOwn(corner); }

    /// Returns true if a corner is covered, and no earlier one that is has the same decode.
    bool isNewDecode(const MapRows& rows, int corner) const {
        if (!covered[index(corner)]) return false;
        for (int before = 0; before < corner; ++before)
            if (covered[index(before)] && rows.hasSameDecode(x, y, before, corner)) return false;
        return true;
    }

    // Places are fractions of the quad.
    FilteredTexels texelsAt(const glm::vec2& place) const {
        if (!isMixed || isCovered()) return blend(corners.texels, place, layers);
        const std::array<float, 4> weights = coveredWeights(place);
        FilteredTexels out;
        for (std::size_t layer = 0; layer < layers; ++layer) {
            out[layer] = glm::vec4(0);
            for (std::size_t i = 0; i < 4; ++i)
                if (covered[i]) out[layer] += weights[i] * corners.texels[i][layer];
        }
        return out;
    }
    /// Returns the bilinear weights of covered texels over their sum.
    std::array<float, 4> coveredWeights(const glm::vec2& p, float* sumOfAll = nullptr) const {
        std::array<float, 4> weights = {(1 - p.x) * (1 - p.y), p.x * (1 - p.y), (1 - p.x) * p.y, p.x * p.y};
        for (std::size_t i = 0; i < 4; ++i)
            if (!covered[i]) weights[i] = 0;
        const float sum = weights[0] + weights[1] + weights[2] + weights[3];
        for (float& weight : weights) weight /= sum;
        if (sumOfAll != nullptr) *sumOfAll = sum;
        return weights;
    }
    /// Returns the filtered reference and the sum of the weights of covered texels.
    std::pair<LcSh, float> referenceAt(const glm::vec2& p) const {
        const auto& r = corners.references;
        if (isCovered()) return {blend(blend(*r[0], *r[1], p.x), blend(*r[2], *r[3], p.x), p.y), 1.0f};
        float sum = 0;
        const std::array<float, 4> weights = coveredWeights(p, &sum);
        LcSh out{};
        for (std::size_t i = 0; i < 4; ++i)
            if (covered[i])
                for (std::size_t k = 0; k < kCoefficients; ++k) out.c[k] += weights[i] * r[i]->c[k];
        return {out, sum};
    }
    /// Returns a place of the quad in the map [texels]: beyond the edge the light is that at the edge.
    glm::dvec2 inMap(const glm::dvec2& place) const {
        return {std::clamp(x + place.x, 0.0, mapWidth - 1.0), std::clamp(y + place.y, 0.0, mapHeight - 1.0)};
    }
};

/// Calls work(quad) for the quads with a covered texel that begin in these rows, and those that reach over the edges of the map there.
template <class Work>
void forEachCoveredQuad(const MapRows& rows, int firstRow, int rowCount, Work&& work) {
    MapRows::Row above, below;
    const int first = firstRow == 0 ? -1 : firstRow;
    for (int y = first; y < firstRow + rowCount; ++y) {
        if (y == first) rows.load(0, rows.width(), std::max(y, 0), above);
        rows.load(0, rows.width(), std::min(y + 1, rows.height() - 1), below);
        for (int x = -1; x < rows.width(); ++x) {
            const CoveredQuad quad(rows, above, below, x, y);
            if (quad.coveredCount() > 0) work(quad);
        }
        std::swap(above, below);
    }
}

/// Calls work(quad) for the quad at (x, y).
template <class Work>
void withCoveredQuad(const MapRows& rows, int x, int y, Work&& work) {
    MapRows::Row above, below;
    const int firstX = std::max(x, 0), count = std::min(x + 1, rows.width() - 1) - firstX + 1;
    rows.load(firstX, count, std::max(y, 0), above);
    rows.load(firstX, count, std::min(y + 1, rows.height() - 1), below);
    work(CoveredQuad(rows, above, below, x, y, firstX));
}

}  // namespace lightcook::verify::lightmap
