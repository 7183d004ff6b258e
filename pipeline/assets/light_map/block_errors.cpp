#include "pipeline/assets/light_map/block_errors.h"

#include <fmt/format.h>

#include <algorithm>

#include "lighting/radiometry.h"
#include "pipeline/assets/light_map/checked_light_map.h"
#include "pipeline/assets/light_map/lit_row.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {

using formats::Result;

double allowedOfBlock(const Limits& limits, const verify::StageError& total) {
    constexpr double kUsual = 100, kOfVisible = 10, kOfError = 1000, kOfMap = 3;
    return std::max({kUsual, kOfVisible * limits[Limit::Visible].value_or(0), kOfError * limits[Limit::Error].value_or(0),
                     kOfMap * visibleP99(total).value_or(0)});
}

void VisibleBlocks::add(int x, int y, float visible) {
    float& texel = texels_.at(x, y - firstRow_);
    texel = std::max(texel, visible);
}

namespace {

/// Returns the mean over colours of the exit radiance of a white surface.
double exitOf(const lighting::ShRgb& sh, const glm::vec3& normal) {
    const glm::dvec3 exit(lighting::lambertExitRadiance(sh, normal, glm::vec3(1)).value);
    return (exit.x + exit.y + exit.z) / 3;
}

/// Returns the exit radiance of the brightest covered texel next to a texel.
double brightestBeside(const formats::LightMapStrip& around, const glm::ivec2& texel) {
    double brightest = 0;
    for (int y = std::max(texel.y - 1, around.firstRow); y <= std::min(texel.y + 1, around.firstRow + around.sh.height() - 1); ++y)
        for (int x = std::max(texel.x - 1, 0); x <= std::min(texel.x + 1, around.sh.width() - 1); ++x)
            if (const int row = y - around.firstRow; around.covered.at(x, row) != 0)
                brightest = std::max(brightest, exitOf(around.sh.at(x, row), around.normal.at(x, row)));
    return brightest;
}

}  // namespace

Result<void> VisibleBlocks::addRims(LightMapSource& bake, const CookedLightMapReader& cooked, const CookedStrip& strip,
                                    const verify::Viewing& viewing, double key) {
    if (cooked.hasCoverage()) return {};  // covered texels alone are mixed
    constexpr double kDark = 0.1;         // of the key: light that counts as dark
    const auto places = cooked.verifier().rimPlaces({strip.texels, strip.reference}, strip.firstRow, strip.rowCount);
    if (places.empty()) return {};
    const int first = std::max(0, strip.firstRow - kRowsAbove), end = std::min(bake.height(), strip.firstRow + strip.rowCount + kRowsBelow);
    LC_TRY(around, bake.rows(first, end - first));
    LitRow lit(static_cast<int>(places.size()), viewing);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const glm::ivec2& texel = places[i].covered;
        const glm::vec3& normal = around->normal.at(texel.x, texel.y - around->firstRow);
        lit.set(static_cast<int>(i), places[i].reference, places[i].found, normal);
        const double above = exitOf(places[i].found, normal) - exitOf(places[i].reference, normal);
        const double beside = brightestBeside(*around, places[i].outside) + kDark * key;
        if (above > 0 && beside > 0) glare_.merge({above / beside, {texel.x, texel.y}});
    }
    lit.compare();
    for (std::size_t i = 0; i < places.size(); ++i) {
        // The quads of a strip reach into the row below, whose texels are those of the next strip.
        const int row = std::min(places[i].covered.y, strip.firstRow + strip.rowCount - 1);
        add(places[i].covered.x, row, lit.visible(static_cast<int>(i)));
    }
    return {};
}

void WorstBlock::merge(const VisibleBlocks& rows) {
    glare_.merge(rows.glare());
    const auto texels = rows.texels();
    for (int top = 0; top < texels.height; top += VisibleBlocks::kSize)
        for (int left = 0; left < texels.width; left += VisibleBlocks::kSize) {
            double sum = 0;
            float largest = -1;
            WorstBlock block;
            for (int y = top; y < std::min(top + VisibleBlocks::kSize, texels.height); ++y)
                for (int x = left; x < std::min(left + VisibleBlocks::kSize, texels.width); ++x) {
                    const float visible = texels.at(x, y);
                    sum += std::max(visible, 0.0f);
                    if (!(visible > largest)) continue;
                    largest = visible;
                    block.figures_.texel = {x, y + rows.firstRow()};
                }
            if (largest < 0) continue;
            block.figures_.block = {left, top + rows.firstRow()};
            block.figures_.visible = sum / (VisibleBlocks::kSize * VisibleBlocks::kSize);
            merge(block);
        }
}

void WorstBlock::merge(const WorstBlock& other) {
    glare_.merge(other.glare_);
    if (other.figures_.visible > figures_.visible || !figures_.isKnown()) figures_ = other.figures_;
}

Result<void> checkBlocks(CheckedLightMap& map) {
    map.texels.shown.block.check("", map.parameters.limits, map.total(), map.violations());
    return {};
}

void WorstBlock::check(const std::string& image, const Limits& limits, const verify::StageError& total,
                       std::vector<verify::Violation>& violations) const {
    // Correct cooks stay below 28 (docs/lab/verify.md).
    constexpr double kAllowedGlare = 100;
    if (glare_.excess > kAllowedGlare)
        violations.push_back({fmt::format("{}rim of a chart at texel ({}, {})", image, glare_.texel[0], glare_.texel[1]),
                              fmt::format("{:.3g} times the light of the brightest texel beside it too much", glare_.excess),
                              fmt::format("at most {:.3g}: a filter mixes in a texel outside the chart", kAllowedGlare)});
    const double allowed = allowedOfBlock(limits, total);
    if (!figures_.isKnown() || figures_.visible <= allowed) return;
    verify::Violation violation{fmt::format("{}block of texel ({}, {})", image, figures_.block[0], figures_.block[1]),
                                fmt::format("a mean visible error of {:.3g}", figures_.visible),
                                fmt::format("at most {:.3g}: a block that lost its light. Cook again with a finer layout, or raise "
                                            "max_visible to {:.3g} if the map may err so",
                                            allowed, figures_.visible / 10)};
    violation.at.x = figures_.texel[0];
    violation.at.y = figures_.texel[1];
    violation.at.channel.reset();
    violations.push_back(std::move(violation));
}

}  // namespace lightcook::pipeline
