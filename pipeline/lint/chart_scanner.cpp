#include "pipeline/lint/chart_scanner.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>

namespace lightcook::pipeline {
namespace {

constexpr int kBinsPerOctave = 4, kLowestOctave = -160, kOctaves = 290;
constexpr std::size_t kBins = std::size_t{kBinsPerOctave} * kOctaves;
/// Ratio from which a texel is kept until the light of the whole map is known.
constexpr double kCandidateRatio = 4;
/// Number of candidates that are kept: the brightest.
constexpr std::size_t kMostCandidates = 65536;
constexpr double kFireflyOverBright = 4;

std::size_t binOf(double light) {
    const double octave = std::log2(std::max(light, 1e-40)) - kLowestOctave;
    return static_cast<std::size_t>(std::clamp(octave * kBinsPerOctave, 0.0, 1.0 * kBins - 1));
}

/// Adds the texels of row y that have an uncovered neighbour and are much brighter than the covered ones.
void findCandidates(const std::vector<float>& above, const std::vector<float>& row, const std::vector<float>& below, int y,
                    std::vector<RimFirefly>& candidates) {
    for (std::size_t x = 0; x < row.size(); ++x) {
        if (!(row[x] > 0)) continue;
        int covered = 0;
        float brightest = 0;
        for (std::size_t u = x == 0 ? 0 : x - 1; u <= std::min(x + 1, row.size() - 1); ++u)
            for (const std::vector<float>* each : {&above, &row, &below}) {
                if ((each == &row && u == x) || (*each)[u] < 0) continue;
                ++covered;
                brightest = std::max(brightest, (*each)[u]);
            }
        constexpr int kAllNeighbours = 8;
        if (covered == 0 || covered == kAllNeighbours || !(row[x] > kCandidateRatio * brightest)) continue;
        candidates.push_back({static_cast<int>(x), y, row[x], brightest});
    }
}

}  // namespace

void ChartRows::addRow(std::vector<float> light) {
    histogram_.resize(kBins);
    std::vector<Run>& runs = runs_.emplace_back();
    const int width = static_cast<int>(light.size());
    for (int x = 0; x < width; ++x) {
        const float each = light[static_cast<std::size_t>(x)];
        if (each < 0) continue;
        ++histogram_[binOf(each)];
        if (runs.empty() || runs.back().end < x) runs.push_back({x, x, false});
        runs.back().end = x + 1;
        runs.back().isLit = runs.back().isLit || each > 0;
    }
    if (last_.size() == 2) {
        findCandidates(last_[0], last_[1], light, static_cast<int>(runs_.size()) - 2, candidates_);
        last_.erase(last_.begin());
    }
    if (first_.size() < 2) first_.push_back(light);
    last_.push_back(std::move(light));
}

ChartScanner::ChartScanner(int width, double fireflyLimit)
    : limit_(fireflyLimit),
      above_(static_cast<std::size_t>(width), -1.0f),
      row_(static_cast<std::size_t>(width), -1.0f),
      histogram_(kBins, 0) {}

std::size_t ChartScanner::root(std::size_t label) {
    while (parents_[label] != label) label = parents_[label] = parents_[parents_[label]];
    return label;
}

void ChartScanner::join(std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    if (a == b) return;
    parents_[b] = a;
    open_[a].texels += open_[b].texels;
    open_[a].isLit = open_[a].isLit || open_[b].isLit;
}

void ChartScanner::close(const Chart& chart) {
    ++facts_.charts;
    if (chart.isLit) return;
    ++facts_.blackCharts;
    facts_.blackTexels += chart.texels;
}

/// Labels the runs of a row with their charts, and closes the charts that end above it.
void ChartScanner::label(const std::vector<ChartRows::Run>& runs) {
    parents_.resize(open_.size());
    std::iota(parents_.begin(), parents_.end(), std::size_t{0});
    std::vector<std::size_t> labels;
    std::size_t above = 0;
    for (const ChartRows::Run& run : runs) {
        // Runs touch by a corner, too.
        while (above < runs_.size() && runs_[above].end < run.first) ++above;
        std::optional<std::size_t> chart;
        for (std::size_t each = above; each < runs_.size() && runs_[each].first <= run.end; ++each) {
            if (chart) join(*chart, labels_[each]);
            if (!chart) chart = labels_[each];
        }
        if (!chart) {
            chart = open_.size();
            parents_.push_back(open_.size());
            open_.emplace_back();
        }
        Chart& joined = open_[root(*chart)];
        joined.texels += run.end - run.first;
        joined.isLit = joined.isLit || run.isLit;
        labels.push_back(*chart);
    }
    std::vector<std::optional<std::size_t>> renamed(open_.size());
    std::vector<Chart> stillOpen;
    for (std::size_t& name : labels) {
        const std::size_t chart = root(name);
        if (!renamed[chart]) {
            renamed[chart] = stillOpen.size();
            stillOpen.push_back(open_[chart]);
        }
        name = *renamed[chart];
    }
    for (std::size_t i = 0; i < open_.size(); ++i)
        if (parents_[i] == i && !renamed[i]) close(open_[i]);
    open_ = std::move(stillOpen);
    labels_ = std::move(labels);
    runs_ = runs;
}

/// Looks for fireflies in the row above this one.
void ChartScanner::lookAbove(const std::vector<float>& light) {
    if (rows_ > 0) findCandidates(above_, row_, light, rows_ - 1, candidates_);
    ++rows_;
    above_ = std::move(row_);
    row_ = light;
}

void ChartScanner::add(const ChartRows& rows) {
    for (const auto& runs : rows.runs_) label(runs);
    for (std::size_t bin = 0; bin < rows.histogram_.size(); ++bin) histogram_[bin] += rows.histogram_[bin];
    const int firstRow = rows_, count = static_cast<int>(rows.runs_.size());
    for (const std::vector<float>& light : rows.first_) lookAbove(light);
    for (RimFirefly candidate : rows.candidates_) {
        candidate.y += firstRow;
        candidates_.push_back(candidate);
    }
    if (count > 2) {
        rows_ = firstRow + count;
        above_ = rows.last_[0];
        row_ = rows.last_[1];
    }
    if (candidates_.size() < 2 * kMostCandidates) return;
    std::ranges::stable_sort(candidates_, std::ranges::greater(), &RimFirefly::light);
    candidates_.resize(kMostCandidates);
}

/// Returns the least light of a firefly: kFireflyOverBright times what 99 in 100 covered texels do not exceed. Edges of hard shadows have
/// bright texels beside dark ones too, but these are no brighter than others of the map.
double ChartScanner::firefliesFrom() const {
    const std::int64_t covered = std::accumulate(histogram_.begin(), histogram_.end(), std::int64_t{0});
    std::int64_t count = 0;
    for (std::size_t bin = 0; bin < histogram_.size(); ++bin) {
        count += histogram_[bin];
        if (100 * count >= 99 * covered)
            return kFireflyOverBright * std::exp2((static_cast<double>(bin) + 1) / kBinsPerOctave + kLowestOctave);
    }
    return HUGE_VAL;
}

ChartFacts ChartScanner::finish() {
    lookAbove(std::vector<float>(row_.size(), -1.0f));
    for (const Chart& chart : open_) close(chart);
    open_.clear();
    const double from = firefliesFrom();
    for (const RimFirefly& each : candidates_) {
        if (each.light <= from) continue;
        if (each.brightest > 0) facts_.worstRimRatio = std::max(facts_.worstRimRatio, each.light / each.brightest);
        if (limit_ <= 0 || each.light <= limit_ * each.brightest) continue;
        ++facts_.rimFireflies;
        if (each.light > facts_.worst.light) facts_.worst = each;
    }
    return facts_;
}

}  // namespace lightcook::pipeline
