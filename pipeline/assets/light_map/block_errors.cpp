#include "pipeline/assets/light_map/block_errors.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/assets/light_map/lit_row.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {

double allowedOfBlock(double maxError, const std::optional<double>& maxVisible) {
    constexpr double kUsual = 100, kOfVisible = 10, kOfError = 1000;
    return std::max({kUsual, kOfVisible * maxVisible.value_or(0), maxError < kNoErrorLimit ? kOfError * maxError : 0});
}

void VisibleBlocks::add(int x, int y, float visible) {
    float& texel = texels_.at(x, y - firstRow_);
    texel = std::max(texel, visible);
}

void VisibleBlocks::addRims(const CookedLightMapReader& cooked, const CookedStrip& strip, const verify::Viewing& viewing) {
    const auto places = cooked.verifier().rimPlaces({strip.texels, strip.reference}, strip.firstRow, strip.rowCount);
    LitRow lit(static_cast<int>(places.size()), viewing);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const glm::ivec2& texel = places[i].covered;
        lit.set(static_cast<int>(i), places[i].reference, places[i].found,
                strip.reference.normal.at(texel.x, texel.y - strip.reference.firstRow));
    }
    lit.compare();
    for (std::size_t i = 0; i < places.size(); ++i) {
        // The quads of a strip reach into the row below, whose texels are those of the next strip.
        const int row = std::min(places[i].covered.y, strip.firstRow + strip.rowCount - 1);
        add(places[i].covered.x, row, lit.visible(static_cast<int>(i)));
    }
}

void WorstBlock::merge(const VisibleBlocks& rows) {
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
    if (other.figures_.visible > figures_.visible || !figures_.isKnown()) figures_ = other.figures_;
}

void WorstBlock::check(const std::string& image, double allowed, std::vector<verify::Violation>& violations) const {
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
