#include "pipeline/assets/dominant/rim_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "pipeline/assets/dominant/reduced_strip.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Intensity times direction of each channel.
using LightVectors = std::array<glm::dvec3, 3>;

double distance(const LightVectors& a, const LightVectors& b) {
    double sum = 0;
    for (std::size_t channel = 0; channel < a.size(); ++channel) {
        const glm::dvec3 difference = a[channel] - b[channel];
        sum += glm::dot(difference, difference);
    }
    return std::sqrt(sum);
}

/// Textures around some of their rows.
struct Rows {
    const verify::DominantVerifier& verifier;
    const verify::CookedDominant& map;
    const verify::DecodedDominantRows& texels;
    formats::LightMapStrip strip;  ///< the bake at the size of the textures

    bool isCovered(int x, int y) const {
        const int row = y - strip.firstRow;
        return x >= 0 && row >= 0 && x < strip.covered.width() && row < strip.covered.height() && strip.covered.at(x, row) != 0;
    }
    /// x, y  [texels of the textures] integers are texel centres
    LightVectors lightAt(double x, double y) const {
        const auto light =
            verifier.decode(texels, (x + 0.5) * map.width / map.textureWidth - 0.5, (y + 0.5) * map.height / map.textureHeight - 0.5);
        const double length = glm::length(light.direction);
        LightVectors vectors{};
        if (length > 0)
            for (int channel = 0; channel < 3; ++channel)
                vectors[static_cast<std::size_t>(channel)] = light.intensity[channel] / length * light.direction;
        return vectors;
    }
};

/// Calls work(x, y, weight) at the places of the rim beside a texel that is not covered: the middle between it and a covered one beside it,
/// and of four texels of which only the one across is covered.
/// weight  of the texel outside, in the filter
template <class Work>
void forEachPlace(const Rows& rows, int x, int y, Work&& work) {
    for (const int step : {-1, 1}) {
        if (rows.isCovered(x + step, y)) work(x + 0.5 * step, y, 0.5);
        if (rows.isCovered(x, y + step)) work(x, y + 0.5 * step, 0.5);
        for (const int stepY : {-1, 1})
            if (rows.isCovered(x + step, y + stepY) && !rows.isCovered(x + step, y) && !rows.isCovered(x, y + stepY))
                work(x + 0.5 * step, y + 0.5 * stepY, 0.25);
    }
}

}  // namespace

Result<void> DominantRimErrors::add(LightMapSource& bake, const CookedDominantReader& cooked, const verify::DominantVerifier& verifier,
                                    double key, int firstRow, int rowCount) {
    const verify::CookedDominant& map = cooked.map();
    const auto firstRowUnder = [&](int row) { return rowsUnder(row, 1, map.height, map.textureHeight).first; };
    int begin = firstRow * map.textureHeight / map.height;
    while (begin < map.textureHeight && firstRowUnder(begin) < firstRow) ++begin;
    int end = begin;
    while (end < map.textureHeight && firstRowUnder(end) < firstRow + rowCount) ++end;
    if (begin == end) return {};
    constexpr int kMargin = 2;
    const int first = std::max(0, begin - kMargin), count = std::min(map.textureHeight, end + kMargin) - first;
    const MapRows under = rowsUnder(first, count, map.height, map.textureHeight);
    auto strip = bake.rows(under.first, under.count);
    if (!strip) return tl::make_unexpected(strip.error());
    if (map.textureWidth != map.width || map.textureHeight != map.height)
        *strip = reducedStrip(*strip, map.height, {map.textureWidth, map.textureHeight}, first, count);
    const auto texels = cooked.read(under.first, under.count);
    if (!texels) return tl::make_unexpected(texels.error());
    const Rows rows{verifier, map, texels->whole, std::move(*strip)};
    // A light that alone gives a tenth of the key to a white surface that faces it, in each channel.
    const double dark = 0.1 * std::numbers::pi * std::numbers::sqrt3 * key;
    std::vector<LightVectors> beside;
    for (int y = begin; y < end; ++y)
        for (int x = 0; x < map.textureWidth; ++x) {
            if (rows.isCovered(x, y)) continue;
            beside.clear();
            double brightest = 0;
            for (int nearY = y - 1; nearY <= y + 1; ++nearY)
                for (int nearX = x - 1; nearX <= x + 1; ++nearX) {
                    if (!rows.isCovered(nearX, nearY)) continue;
                    beside.push_back(rows.lightAt(nearX, nearY));
                    brightest = std::max(brightest, distance(beside.back(), {}));
                }
            if (beside.empty()) continue;
            Mismatch& tile = tiles_[{y / kTile * kTile, x / kTile * kTile}];
            forEachPlace(rows, x, y, [&](double placeX, double placeY, double weight) {
                const LightVectors found = rows.lightAt(placeX, placeY);
                double nearest = std::numeric_limits<double>::infinity();
                for (const LightVectors& light : beside) nearest = std::min(nearest, distance(found, light));
                tile.error += std::min(brightest, nearest / weight);
                tile.light += brightest;
                tile.dark += dark;
            });
        }
    return {};
}

void DominantRimErrors::merge(const DominantRimErrors& other) {
    for (const auto& [tile, mismatch] : other.tiles_) {
        Mismatch& all = tiles_[tile];
        all.error += mismatch.error;
        all.light += mismatch.light;
        all.dark += mismatch.dark;
    }
}

std::optional<double> DominantRimErrors::median() const {
    std::vector<double> errors;
    for (const auto& [tile, mismatch] : tiles_)
        if (mismatch.light > mismatch.dark) errors.push_back(mismatch.error / mismatch.light);
    if (errors.size() < kLeastTiles) return {};
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::ranges::nth_element(errors, middle);
    return *middle;
}

void DominantRimErrors::check(std::vector<verify::Violation>& violations) const {
    // Correct cooks of the public scenes stay below 0.55 (docs/lab/experiments.md).
    constexpr double kAllowed = 0.65;
    const auto found = median();
    if (!found || *found <= kAllowed) return;
    violations.push_back({"rims of charts",
                          fmt::format("texels outside charts that miss {:.3g} of the light beside them, which a filter mixes in, at the "
                                      "median of {} x {} texels",
                                      *found, kTile, kTile),
                          fmt::format("at most {:.3g}: padding that continues the charts", kAllowed)});
}

}  // namespace lightcook::pipeline
