#include "pipeline/assets/light_map/chart_split.h"

#include <algorithm>
#include <glm/common.hpp>
#include <limits>
#include <numeric>

#include "formats/gltf_scene.h"
#include "pipeline/assets/light_map/chart_trial.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/mesh/mesh.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Part of the samples that may be above a limit on the 99th percentile.
constexpr double kShareAbove = 0.01;

/// Judges samples against a share of each limit.
class SplitJudge {
public:
    explicit SplitJudge(const SplitLimits& limits) : limits_(limits) {}

    bool keeps(const ChartSamples& samples) const { return keeps(samples.diffuse) && keeps(samples.specular); }

    /// Returns the largest part of a limit on the whole map that some charts use beyond their own share. Negative: they keep the limits.
    double excess(const ChartSamples& samples, const ChartSamples& whole) const {
        return std::max(excess(samples.diffuse, whole.diffuse), excess(samples.specular, whole.specular));
    }

private:
    double allowedAbove(const ChartSamples::Light& light) const { return limits_.share * kShareAbove * static_cast<double>(light.count); }
    double allowedError(const ChartSamples::Light& light) const {
        const double limit = limits_.share * limits_.maxError;
        return limit * limit * light.squaredLight;
    }
    bool keeps(const ChartSamples::Light& light) const {
        const bool isVisible = limits_.maxVisible && static_cast<double>(light.above) > allowedAbove(light);
        return !isVisible && light.squaredError <= allowedError(light);
    }
    double excess(const ChartSamples::Light& light, const ChartSamples::Light& whole) const {
        double most = -std::numeric_limits<double>::infinity();
        if (limits_.maxVisible && whole.count > 0)
            most = (static_cast<double>(light.above) - allowedAbove(light)) / std::max(allowedAbove(whole), 1.0);
        if (allowedError(whole) > 0) most = std::max(most, (light.squaredError - allowedError(light)) / allowedError(whole));
        return most;
    }

    SplitLimits limits_;
};

double bitsOf(const CandidateByChart& candidate) {
    return candidate.whole.bitsPerTexel;
}

ChartSamples sumOf(const std::vector<ChartSamples>& samples, std::span<const std::size_t> groups) {
    ChartSamples sum;
    for (const std::size_t group : groups) sum.add(samples[group]);
    return sum;
}

/// Returns the candidate of fewest bits that keeps the limits on some groups; if none does, that of most bits.
const CandidateByChart& cheapestFor(std::span<const CandidateByChart> candidates, std::span<const std::size_t> groups,
                                    const SplitJudge& judge) {
    const CandidateByChart* best = nullptr;
    for (const CandidateByChart& each : candidates)
        if (judge.keeps(sumOf(each.samples, groups)) && (best == nullptr || bitsOf(each) < bitsOf(*best))) best = &each;
    return best != nullptr ? *best : *std::ranges::max_element(candidates, {}, bitsOf);
}

/// Returns the groups that have to be left out so that the rest keep the limits, those first that take the candidate furthest from them.
std::vector<std::size_t> groupsToLeaveOut(const CandidateByChart& candidate, std::span<const std::size_t> all,
                                          std::span<const std::int64_t> texels, const SplitJudge& judge) {
    const ChartSamples whole = sumOf(candidate.samples, all);
    std::vector<double> excess;
    for (const std::size_t group : all)
        excess.push_back(judge.excess(candidate.samples[group], whole) / static_cast<double>(std::max<std::int64_t>(texels[group], 1)));
    std::vector<std::size_t> order(all.begin(), all.end());
    std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t group) { return excess[group]; });
    for (std::size_t count = 0; count < order.size(); ++count)
        if (judge.keeps(sumOf(candidate.samples, std::span(order).subspan(count))))
            return {order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count)};
    return order;
}

std::int64_t sumOf(std::span<const std::int64_t> texels, std::span<const std::size_t> groups) {
    std::int64_t sum = 0;
    for (const std::size_t group : groups) sum += texels[group];
    return sum;
}

/// Returns true if the charts of a packed map lie where they were packed, in the order that they have in the bake. The first texel of a
/// chart with fewer texels may come out one lower: it is found with a tolerance in texels, which are larger there.
bool areAtPlaces(const std::vector<atlas::Chart>& charts, std::span<const int> places) {
    if (places.size() != 4 * charts.size()) return false;
    for (std::size_t i = 0; i < charts.size(); ++i) {
        const glm::ivec2 off = glm::abs(charts[i].first - glm::ivec2(places[4 * i + 2], places[4 * i + 3]));
        if (off.x > 1 || off.y > 1) return false;
    }
    return true;
}

}  // namespace

ChartSplit chooseSplit(std::span<const CandidateByChart> candidates, std::span<const std::int64_t> texels, const SplitLimits& limits) {
    ChartSplit best;
    if (candidates.empty() || texels.empty()) return best;
    const SplitJudge judge(limits);
    std::vector<std::size_t> all(texels.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    const CandidateByChart& one = cheapestFor(candidates, all, judge);
    best.layout = best.fineLayout = one.whole.layout;
    best.bits = best.bitsOfOne = bitsOf(one);
    const auto total = static_cast<double>(std::max<std::int64_t>(sumOf(texels, all), 1));
    for (const CandidateByChart& each : candidates) {
        if (bitsOf(each) >= bitsOf(one)) continue;
        std::vector<std::size_t> fine = groupsToLeaveOut(each, all, texels, judge);
        if (fine.size() == all.size()) continue;
        const CandidateByChart& other = cheapestFor(candidates, fine, judge);
        if (!judge.keeps(sumOf(other.samples, fine))) continue;
        const double share = static_cast<double>(sumOf(texels, fine)) / total;
        const double bits = (1 - share) * bitsOf(each) + share * bitsOf(other);
        if (bits >= best.bits || bits > (1 - kLeastSplitSaving) * best.bitsOfOne) continue;
        best.layout = each.whole.layout;
        best.fineLayout = other.whole.layout;
        best.bits = bits;
        best.fine = std::move(fine);
    }
    return best;
}

Result<ActionOutcome> splitCharts(const ActionContext& context) {
    const auto parameters = parametersOf<SplitParameters>(context);
    if (!parameters) return tl::make_unexpected(parameters.error());
    const auto source = openLightMap(context, parameters->trial.description);
    if (!source) return tl::make_unexpected(source.error());
    const std::string mesh = context.action.inputs.at(kMeshRole).string();
    const auto scene = formats::GltfScene::load(mesh);
    if (!scene) return tl::make_unexpected(scene.error());
    const auto meshes = scene->triangleMeshes();
    const std::vector<std::string> names(meshes.size(), mesh);
    const auto found = atlas::findCharts(meshes, names, (*source)->width(), (*source)->height());
    if (!found) return tl::make_unexpected(found.error());
    if (!areAtPlaces(found->charts, parameters->places))
        return formats::failure(formats::ErrorCode::Internal, mesh, "found charts that lie elsewhere than where they were packed");
    const auto key = surveyKey(**source, context);
    if (!key) return tl::make_unexpected(key.error());
    const double unlimited = std::numeric_limits<float>::max();
    const ChartTrial charts(found->charts, (*source)->width(), (*source)->height(), parameters->maxVisible.value_or(unlimited));
    auto tried = tryLayoutsByChart(parameters->trial, charts, context);
    if (!tried) return tl::make_unexpected(tried.error());

    std::vector<std::int64_t> texels;
    for (const ChartGroup& group : charts.groups()) texels.push_back(group.texels);
    SplitResult result{{}, key->displayKey(), {}};
    for (const double share : kSplitShares) {
        const ChartSplit split = chooseSplit(*tried, texels, {parameters->maxError, parameters->maxVisible, share});
        if (split.fine.empty()) continue;
        TriedSplit made{{}, {}, split.layout, split.fineLayout, split.bits, split.bitsOfOne};
        for (std::size_t i = 0; i < charts.groups().size(); ++i) {
            std::vector<int>& to = std::ranges::find(split.fine, i) != split.fine.end() ? made.fineCharts : made.charts;
            to.insert(to.end(), charts.groups()[i].charts.begin(), charts.groups()[i].charts.end());
        }
        std::ranges::sort(made.charts);
        std::ranges::sort(made.fineCharts);
        if (std::ranges::find(result.splits, made.fineCharts, &TriedSplit::fineCharts) == result.splits.end())
            result.splits.push_back(std::move(made));
    }
    for (CandidateByChart& each : *tried) result.one.candidates.push_back(std::move(each.whole));
    return outcomeWith(result);
}

}  // namespace lightcook::pipeline
