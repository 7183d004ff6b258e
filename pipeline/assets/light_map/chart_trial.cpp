#include "pipeline/assets/light_map/chart_trial.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace lightcook::pipeline {
namespace {

using atlas::Chart;
using atlas::ChartSet;

/// Calls visit(x, y) for each texel of the map that a filter inside a quad of the chart reads. Texels come up to four times.
template <class Visit>
void forEachRead(const Chart& chart, const glm::ivec2& size, Visit visit) {
    for (int y = 0; y < chart.quads.y; ++y)
        for (int x = 0; x < chart.quads.x; ++x)
            for (int corner = 0; chart.reaches(x, y) && corner < 4; ++corner) {
                const glm::ivec2 at = chart.first + glm::ivec2(x + corner % 2, y + corner / 2);
                if (at.x >= 0 && at.y >= 0 && at.x < size.x && at.y < size.y) visit(at.x, at.y);
            }
}

ChartSamples::Light samplesOf(const verify::ErrorAccumulator& errors, const verify::VisibleAccumulator& visible, double maxVisible) {
    const double light = errors.referenceRms(), relRms = errors.figures().relRms, squares = light * light;
    const auto count = static_cast<double>(errors.sampleCount());
    return {visible.sampleCount(), visible.countAbove(maxVisible), relRms * relRms * squares * count, squares * count};
}

/// Returns a strip like another, with texels of its own.
formats::LightMapStrip copyOf(const formats::LightMapStrip& strip) {
    formats::LightMapStrip copy;
    copy.firstRow = strip.firstRow;
    copy.sh = strip.sh.copy();
    copy.covered = strip.covered.copy();
    copy.normal = strip.normal.copy();
    copy.chart = strip.chart.copy();
    return copy;
}

}  // namespace

void ChartSamples::Light::add(const Light& other) {
    count += other.count;
    above += other.above;
    squaredError += other.squaredError;
    squaredLight += other.squaredLight;
}

void ChartSamples::add(const ChartSamples& other) {
    diffuse.add(other.diffuse);
    specular.add(other.specular);
}

ChartTrial::ChartTrial(const std::vector<Chart>& charts, int width, int height, double maxVisible)
    : groupOf_(width, height, ChartSet::kNoChart), maxVisible_(maxVisible) {
    const glm::ivec2 size(width, height);
    std::vector<std::int64_t> texels;
    formats::Image<std::uint32_t> counted(width, height, ChartSet::kNoChart);
    for (std::size_t i = 0; i < charts.size(); ++i) {
        std::int64_t& count = texels.emplace_back();
        forEachRead(charts[i], size, [&](int x, int y) {
            if (std::exchange(counted.at(x, y), static_cast<std::uint32_t>(i)) != i) ++count;
        });
    }
    std::vector<int> small;
    for (std::size_t i = 0; i < charts.size(); ++i) {
        const int chart = static_cast<int>(i);
        if (texels[i] >= kLeastTexels)
            addGroup(charts, std::span(&chart, 1), texels);
        else
            small.push_back(chart);
    }
    std::ranges::stable_sort(small, {}, [&](int chart) { return charts[static_cast<std::size_t>(chart)].first.y; });
    std::vector<int> members;
    std::int64_t sum = 0;
    for (const int chart : small) {
        members.push_back(chart);
        sum += texels[static_cast<std::size_t>(chart)];
        if (sum < kLeastTexels && chart != small.back()) continue;
        addGroup(charts, members, texels);
        members.clear();
        sum = 0;
    }
}

void ChartTrial::addGroup(const std::vector<Chart>& charts, std::span<const int> members, std::span<const std::int64_t> texels) {
    const auto index = static_cast<std::uint32_t>(groups_.size());
    ChartGroup& group = groups_.emplace_back();
    group.charts.assign(members.begin(), members.end());
    std::ranges::sort(group.charts);
    group.firstRow = std::numeric_limits<int>::max();
    for (const int member : members) {
        const Chart& chart = charts[static_cast<std::size_t>(member)];
        group.texels += texels[static_cast<std::size_t>(member)];
        group.firstRow = std::min(group.firstRow, std::max(chart.first.y, 0));
        group.rowsEnd = std::max(group.rowsEnd, std::min(chart.first.y + chart.texels().y, groupOf_.height()));
        forEachRead(chart, {groupOf_.width(), groupOf_.height()}, [&](int x, int y) { groupOf_.at(x, y) = index; });
    }
}

std::vector<std::vector<ChartSamples>> ChartTrial::measure(const verify::LightMapVerifier& verifier,
                                                           const verify::DecodedLightMapRows& texels,
                                                           const formats::LightMapStrip& reference, int firstRow, int rowCount) const {
    std::vector<std::vector<ChartSamples>> samples(verifier.noErrors().stages.size(), std::vector<ChartSamples>(groups_.size()));
    formats::LightMapStrip ofGroup = copyOf(reference);
    for (std::size_t i = 0; i < groups_.size(); ++i) {
        const ChartGroup& group = groups_[i];
        const int first = std::max(group.firstRow, firstRow), end = std::min(group.rowsEnd, firstRow + rowCount);
        if (first >= end) continue;
        for (int y = 0; y < ofGroup.covered.height(); ++y)
            for (int x = 0; x < ofGroup.covered.width(); ++x)
                ofGroup.covered.at(x, y) = groupOf_.at(x, reference.firstRow + y) == i ? reference.covered.at(x, y) : 0;
        const verify::LightMapErrors errors = verifier.verifyRows(texels, ofGroup, first, end - first);
        for (std::size_t stage = 0; stage < samples.size(); ++stage) {
            const verify::ShadedErrors& shaded = errors.stages[stage].errors;
            samples[stage][i] = {samplesOf(shaded.diffuse, shaded.visibleDiffuse, maxVisible_),
                                 samplesOf(shaded.specular, shaded.visibleSpecular, maxVisible_)};
        }
    }
    return samples;
}

}  // namespace lightcook::pipeline
