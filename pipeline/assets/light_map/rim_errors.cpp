#include "pipeline/assets/light_map/rim_errors.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/texel_squares.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Errors far below the key of the map are no reason to prefer a place.
constexpr double kDark = 0.1;

/// A place at a rim, with the light that its error counts beside.
struct RimError {
    double error = 0, light = 0;
};

/// Calls work(sh, normal) for each covered texel next to a texel, which may be outside of the strip.
template <class Work>
void forEachCoveredBeside(const formats::LightMapStrip& strip, const glm::ivec2& texel, Work&& work) {
    for (int y = texel.y - 1; y <= texel.y + 1; ++y)
        for (int x = texel.x - 1; x <= texel.x + 1; ++x) {
            const int row = y - strip.firstRow;
            if (x < 0 || row < 0 || x >= strip.sh.width() || row >= strip.sh.height() || strip.covered.at(x, row) == 0) continue;
            work(strip.sh.at(x, row), strip.normal.at(x, row));
        }
}

/// Returns the square of the brightest covered texel next to a texel.
double brightestBeside(const formats::LightMapStrip& strip, const glm::ivec2& texel, bool isFlat) {
    double brightest = 0;
    forEachCoveredBeside(strip, texel, [&](const lighting::ShRgb& sh, const glm::vec3& normal) {
        brightest = std::max(brightest, squaresOf(sh, sh, normal, isFlat).reference);
    });
    return brightest;
}

/// Returns the mean over colours of the exit radiance of a white surface.
double exitOf(const lighting::ShRgb& sh, const glm::vec3& normal) {
    const glm::dvec3 exit(lighting::lambertExitRadiance(sh, normal, glm::vec3(1)).value);
    return (exit.x + exit.y + exit.z) / 3;
}

/// Returns the share of light that the texel outside lacks, from 0 to 1: beside the darkest covered texel next to it, and beside what the
/// covered one of the place shows, which a lossy layout may have darkened.
/// normal  of the covered texel
/// dark    light that counts as dark
double lossAt(const verify::RimPlace& place, const formats::LightMapStrip& around, const glm::vec3& normal, double dark) {
    double expected = exitOf(place.inside, normal);
    forEachCoveredBeside(around, place.outside, [&](const lighting::ShRgb& sh, const glm::vec3& of) {  //
        expected = std::min(expected, exitOf(sh, of));
    });
    if (!(expected > 0)) return 0;
    const double lacking = (expected - exitOf(place.found, normal)) / (place.weight * (expected + dark));
    return lacking >= 0 ? std::min(lacking, 1.0) : 0;
}

}  // namespace

Result<void> RimErrors::add(LightMapSource& bake, const CookedLightMapReader& cooked, const CookedStrip& strip, bool isFlat, double key) {
    const auto places = cooked.verifier().rimPlaces({strip.texels, strip.reference}, strip.firstRow, strip.rowCount);
    if (places.empty()) return {};
    const int first = std::max(0, strip.firstRow - 2), end = std::min(bake.height(), strip.firstRow + strip.rowCount + 3);
    const auto around = bake.rows(first, end - first);
    if (!around) return tl::make_unexpected(around.error());
    addErrors(places, *around, strip, isFlat, key);
    addLosses(places, *around, key);
    return {};
}

void RimErrors::addErrors(const std::vector<verify::RimPlace>& places, const formats::LightMapStrip& around, const CookedStrip& strip,
                          bool isFlat, double key) {
    constexpr int kBlock = verify::BlockErrors::kSize;
    const double dark = kDark * 3 * key * key;
    const int across = (around.sh.width() + kBlock - 1) / kBlock, down = (strip.rowCount + kBlock - 1) / kBlock;
    std::vector<RimError> worst(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
    const int last = strip.firstRow + strip.rowCount - 1;
    for (const verify::RimPlace& place : places) {
        const glm::vec3& normal = around.normal.at(place.covered.x, place.covered.y - around.firstRow);
        const RimError found{squaresOf(place.reference, place.found, normal, isFlat).error, brightestBeside(around, place.outside, isFlat)};
        const int y = std::min(place.covered.y, last) - strip.firstRow;
        RimError& most = worst[static_cast<std::size_t>(y / kBlock) * static_cast<std::size_t>(across) +
                               static_cast<std::size_t>(place.covered.x / kBlock)];
        if (!(found.error * (most.light + dark) <= most.error * (found.light + dark)) || most.light == 0) most = found;
    }
    for (std::size_t i = 0; i < worst.size(); ++i) {
        if (worst[i].error == 0 && worst[i].light == 0) continue;
        const int index = static_cast<int>(i);
        blocks_.add(index % across * kBlock, strip.firstRow + index / across * kBlock, worst[i].error, worst[i].light);
    }
}

void RimErrors::addLosses(const std::vector<verify::RimPlace>& places, const formats::LightMapStrip& around, double key) {
    for (const verify::RimPlace& place : places) {
        const glm::vec3& normal = around.normal.at(place.covered.x, place.covered.y - around.firstRow);
        Losses& losses = darkTiles_[{place.outside.y / kTile * kTile, place.outside.x / kTile * kTile}];
        losses.sum += lossAt(place, around, normal, kDark * key);
        ++losses.places;
    }
}

void RimErrors::merge(const RimErrors& other) {
    blocks_.merge(other.blocks_);
    for (const auto& [tile, losses] : other.darkTiles_) {
        Losses& all = darkTiles_[tile];
        all.sum += losses.sum;
        all.places += losses.places;
    }
}

void RimErrors::check(const std::string& image, double maxError, std::vector<verify::Violation>& violations) const {
    // Correct cooks stay below 1.1 (docs/lab/experiments.md). A texel of eight times the light beside it is above 3.
    constexpr double kAllowed = 3;
    const double allowed = std::max(kAllowed, verify::BlockErrors::allowed(maxError));
    if (const auto worst = blocks_.worst(); worst && worst->error > allowed)
        violations.push_back({fmt::format("{}rim of a chart in the block of texel ({}, {})", image, worst->x, worst->y),
                              fmt::format("an error of {:.3g} of the light beside it", worst->error),
                              fmt::format("at most {:.3g}", allowed)});
    // Correct cooks stay below 0.5 (docs/lab/experiments.md). Black beside charts as bright as the key is 0.91.
    constexpr double kAllowedLoss = 0.65;
    constexpr int kLeastPlaces = 6;
    std::pair<int, int> darkest;
    double loss = 0;
    for (const auto& [tile, losses] : darkTiles_)
        if (losses.places >= kLeastPlaces && losses.sum > loss * losses.places) {
            darkest = tile;
            loss = losses.sum / losses.places;
        }
    if (loss > kAllowedLoss)
        violations.push_back(
            {fmt::format("{}rim of a chart in the {} x {} texels from ({}, {}) on", image, kTile, kTile, darkest.second, darkest.first),
             fmt::format("texels outside charts that lack {:.3g} of the light beside them, which a filter mixes in", loss),
             fmt::format("at most {:.3g}: padding that continues the charts", kAllowedLoss)});
}

}  // namespace lightcook::pipeline
