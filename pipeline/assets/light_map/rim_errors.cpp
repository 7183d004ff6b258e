#include "pipeline/assets/light_map/rim_errors.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/texel_squares.h"

namespace lightcook::pipeline {
namespace {

/// A place at a rim, with the light that its error counts beside.
struct RimError {
    double error = 0, light = 0;
};

/// Returns the square of the brightest covered texel next to a texel, which may be outside of the strip.
double brightestBeside(const formats::LightMapStrip& strip, const glm::ivec2& texel, bool isFlat) {
    double brightest = 0;
    for (int y = texel.y - 1; y <= texel.y + 1; ++y)
        for (int x = texel.x - 1; x <= texel.x + 1; ++x) {
            const int row = y - strip.firstRow;
            if (x < 0 || row < 0 || x >= strip.sh.width() || row >= strip.sh.height() || strip.covered.at(x, row) == 0) continue;
            const lighting::ShRgb& sh = strip.sh.at(x, row);
            brightest = std::max(brightest, squaresOf(sh, sh, strip.normal.at(x, row), isFlat).reference);
        }
    return brightest;
}

}  // namespace

formats::Result<void> addRimErrors(LightMapSource& bake, const CookedLightMapReader& cooked, const CookedStrip& strip, bool isFlat,
                                   double key, verify::BlockErrors& rims) {
    constexpr int kBlock = verify::BlockErrors::kSize;
    const auto places = cooked.verifier().rimPlaces({strip.texels, strip.reference}, strip.firstRow, strip.rowCount);
    if (places.empty()) return {};
    const int first = std::max(0, strip.firstRow - 2), end = std::min(bake.height(), strip.firstRow + strip.rowCount + 3);
    const auto around = bake.rows(first, end - first);
    if (!around) return tl::make_unexpected(around.error());
    // Errors far below the key of the map are no reason to prefer a place.
    constexpr double kDark = 0.1;
    const double dark = kDark * 3 * key * key;
    const int across = (bake.width() + kBlock - 1) / kBlock, down = (strip.rowCount + kBlock - 1) / kBlock;
    std::vector<RimError> worst(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
    const int last = strip.firstRow + strip.rowCount - 1;
    for (const verify::RimPlace& place : places) {
        const glm::vec3& normal = around->normal.at(place.covered.x, place.covered.y - first);
        const RimError found{squaresOf(place.reference, place.found, normal, isFlat).error,
                             brightestBeside(*around, place.outside, isFlat)};
        const int y = std::min(place.covered.y, last) - strip.firstRow;
        RimError& most = worst[static_cast<std::size_t>(y / kBlock) * static_cast<std::size_t>(across) +
                               static_cast<std::size_t>(place.covered.x / kBlock)];
        if (!(found.error * (most.light + dark) <= most.error * (found.light + dark)) || most.light == 0) most = found;
    }
    for (std::size_t i = 0; i < worst.size(); ++i) {
        if (worst[i].error == 0 && worst[i].light == 0) continue;
        const int index = static_cast<int>(i);
        rims.add(index % across * kBlock, strip.firstRow + index / across * kBlock, worst[i].error, worst[i].light);
    }
    return {};
}

void checkRims(const verify::BlockErrors& rims, const std::string& image, double maxError, std::vector<verify::Violation>& violations) {
    const auto worst = rims.worst();
    // Correct cooks stay below 1.1 (docs/lab/experiments.md). A texel of eight times the light beside it is above 3.
    constexpr double kAllowed = 3;
    const double allowed = std::max(kAllowed, verify::BlockErrors::allowed(maxError));
    if (!worst || worst->error <= allowed) return;
    violations.push_back({fmt::format("{}rim of a chart in the block of texel ({}, {})", image, worst->x, worst->y),
                          fmt::format("an error of {:.3g} of the light beside it", worst->error), fmt::format("at most {:.3g}", allowed)});
}

}  // namespace lightcook::pipeline
