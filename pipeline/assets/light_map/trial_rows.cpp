#include "pipeline/assets/light_map/trial_rows.h"

#include <algorithm>
#include <array>

namespace lightcook::pipeline {
namespace {

/// Margins of a sample of 8 to 15 bands, and of one of twice as many.
constexpr std::array kMargins = {0.35, 0.25};

/// Bands of the first level lie in the middle of what they stand for; those of later levels between them.
bool hasBand(int band, int level, int distance) {
    return band % distance == (level == 0 ? distance / 2 : 0);
}

}  // namespace

TrialLevels::TrialLevels(const LightMapSource& source) : source_(source), bands_((source.height() + kRowAlignment - 1) / kRowAlignment) {
    int distance = 1;
    while (bands_ / (2 * distance) >= kFirstBands) distance *= 2;
    levels_.push_back(distance);
    if (distance == 1) return;
    levels_.push_back(distance / 2);
    const std::int64_t texels = static_cast<std::int64_t>(source.width()) * source.height();
    int finest = 1;
    while (texels > finest * kTrialTexels) finest *= 2;
    if (finest < levels_.back()) levels_.push_back(finest);
}

std::vector<TrialRows> TrialLevels::rows(int first, int end) const {
    std::vector<TrialRows> rows;
    for (int band = 0; band < bands_; ++band) {
        const auto isOf = [&](int level) { return hasBand(band, level, levels_[static_cast<std::size_t>(level)]); };
        int level = 0;
        while (level < end && !isOf(level)) ++level;
        if (level < first || level == end) continue;
        const int firstRow = band * kRowAlignment, rowCount = std::min(kRowAlignment, source_.height() - firstRow);
        int strip = rows.empty() ? 0 : rows.back().strip;
        while (firstRow >= source_.stripFirstRow(strip) + source_.stripRows(strip)) ++strip;
        if (!rows.empty() && rows.back().strip == strip && rows.back().firstRow + rows.back().rowCount == firstRow)
            rows.back().rowCount += rowCount;
        else
            rows.push_back({strip, firstRow, rowCount});
    }
    return rows;
}

double TrialLevels::share(int level) const {
    int count = 0;
    for (const TrialRows& each : rows(0, level + 1)) count += each.rowCount;
    return static_cast<double>(count) / source_.height();
}

double TrialLevels::margin(int level) const {
    return level == last() ? 0 : kMargins[static_cast<std::size_t>(level)];
}

}  // namespace lightcook::pipeline
