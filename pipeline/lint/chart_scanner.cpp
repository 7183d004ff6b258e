#include "pipeline/lint/chart_scanner.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lightcook::pipeline {
namespace {

constexpr int kBinsPerOctave = 4, kLowestOctave = -160, kOctaves = 290;
/// Ratio from which a texel is kept until the light of the whole map is known.
constexpr double kCandidateRatio = 4;
/// Number of candidates that are kept: the brightest.
constexpr std::size_t kMostCandidates = 65536;
constexpr double kFireflyOverBright = 4;

std::size_t binOf(double light) {
    const double octave = std::log2(std::max(light, 1e-40)) - kLowestOctave;
    return static_cast<std::size_t>(std::clamp(octave * kBinsPerOctave, 0.0, 1.0 * kBinsPerOctave * kOctaves - 1));
}

}  // namespace

ChartScanner::ChartScanner(int width, double fireflyLimit)
    : width_(static_cast<std::size_t>(width)),
      limit_(fireflyLimit),
      above_(width_, -1.0f),
      row_(width_, -1.0f),
      labels_(width_, -1),
      histogram_(static_cast<std::size_t>(kBinsPerOctave) * kOctaves, 0) {}

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

/// Labels the texels of a row with their charts, and closes the charts that end above it.
void ChartScanner::label(const std::vector<float>& light) {
    parents_.resize(open_.size());
    std::iota(parents_.begin(), parents_.end(), std::size_t{0});
    std::vector<int> labels(width_, -1);
    for (std::size_t x = 0; x < width_; ++x) {
        if (light[x] < 0) continue;
        const auto touch = [&](int neighbour) {
            if (neighbour < 0) return;
            if (labels[x] < 0)
                labels[x] = neighbour;
            else
                join(static_cast<std::size_t>(labels[x]), static_cast<std::size_t>(neighbour));
        };
        if (x > 0) {
            touch(labels[x - 1]);
            touch(labels_[x - 1]);
        }
        touch(labels_[x]);
        if (x + 1 < width_) touch(labels_[x + 1]);
        if (labels[x] < 0) {
            labels[x] = static_cast<int>(open_.size());
            parents_.push_back(open_.size());
            open_.emplace_back();
        }
        Chart& chart = open_[root(static_cast<std::size_t>(labels[x]))];
        ++chart.texels;
        chart.isLit = chart.isLit || light[x] > 0;
    }
    std::vector<int> renamed(open_.size(), -1);
    std::vector<Chart> stillOpen;
    for (int& name : labels) {
        if (name < 0) continue;
        const std::size_t chart = root(static_cast<std::size_t>(name));
        if (renamed[chart] < 0) {
            renamed[chart] = static_cast<int>(stillOpen.size());
            stillOpen.push_back(open_[chart]);
        }
        name = renamed[chart];
    }
    for (std::size_t i = 0; i < open_.size(); ++i)
        if (parents_[i] == i && renamed[i] < 0) close(open_[i]);
    open_ = std::move(stillOpen);
    labels_ = std::move(labels);
}

/// Keeps the texels of a row that have an uncovered neighbour and are much brighter than the covered ones.
void ChartScanner::lookForFireflies(const std::vector<float>& above, const std::vector<float>& row, const std::vector<float>& below,
                                    int y) {
    for (std::size_t x = 0; x < width_; ++x) {
        if (!(row[x] > 0)) continue;
        int covered = 0;
        float brightest = 0;
        for (std::size_t u = x == 0 ? 0 : x - 1; u <= std::min(x + 1, width_ - 1); ++u)
            for (const std::vector<float>* each : {&above, &row, &below}) {
                if ((each == &row && u == x) || (*each)[u] < 0) continue;
                ++covered;
                brightest = std::max(brightest, (*each)[u]);
            }
        constexpr int kAllNeighbours = 8;
        if (covered == 0 || covered == kAllNeighbours || !(row[x] > kCandidateRatio * brightest)) continue;
        candidates_.push_back({static_cast<int>(x), y, row[x], brightest});
    }
    if (candidates_.size() < 2 * kMostCandidates) return;
    std::ranges::stable_sort(candidates_, [](const RimFirefly& a, const RimFirefly& b) { return a.light > b.light; });
    candidates_.resize(kMostCandidates);
}

void ChartScanner::addRow(std::vector<float> light) {
    label(light);
    for (const float each : light) {
        if (each < 0) continue;
        ++histogram_[binOf(each)];
        ++covered_;
    }
    if (rows_ > 0) lookForFireflies(above_, row_, light, rows_ - 1);
    ++rows_;
    above_ = std::move(row_);
    row_ = std::move(light);
}

/// Returns the least light of a firefly: kFireflyOverBright times what 99 in 100 covered texels do not exceed. Edges of hard shadows have
/// bright texels beside dark ones too, but these are no brighter than others of the map.
double ChartScanner::firefliesFrom() const {
    std::int64_t count = 0;
    for (std::size_t bin = 0; bin < histogram_.size(); ++bin) {
        count += histogram_[bin];
        if (100 * count >= 99 * covered_)
            return kFireflyOverBright * std::exp2((static_cast<double>(bin) + 1) / kBinsPerOctave + kLowestOctave);
    }
    return HUGE_VAL;
}

ChartFacts ChartScanner::finish() {
    if (rows_ > 0) lookForFireflies(above_, row_, std::vector<float>(width_, -1.0f), rows_ - 1);
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
