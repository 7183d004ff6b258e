#include "pipeline/assets/light_map/chart_split.h"

#include <algorithm>
#include <deque>
#include <glm/common.hpp>
#include <limits>
#include <map>
#include <numeric>

#include "formats/disjoint_sets.h"
#include "formats/gltf_scene.h"
#include "pipeline/assets/light_map/chart_places.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/light_map/tile_groups.h"
#include "pipeline/assets/mesh/mesh.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;
using verify::ShadedSums;

/// Part of the samples that may be above a limit on the 99th percentile.
constexpr double kShareAbove = 0.01;

/// Judges sums of errors against a share of each limit.
class SplitJudge {
public:
    explicit SplitJudge(const SplitLimits& limits) : limits_(limits) {}

    bool keeps(const ShadedSums& sums) const { return keeps(sums.diffuse) && keeps(sums.specular); }

    /// Returns the largest part of a limit on the whole map that some groups use beyond their own share. Negative: they keep the limits.
    double excess(const ShadedSums& sums, const ShadedSums& whole) const {
        return std::max(excess(sums.diffuse, whole.diffuse), excess(sums.specular, whole.specular));
    }

private:
    double allowedAbove(const ShadedSums::Light& light) const { return limits_.share * kShareAbove * static_cast<double>(light.count); }
    double allowedError(const ShadedSums::Light& light) const {
        const double limit = limits_.share * limits_.maxError;
        return limit * limit * light.squaredLight;
    }
    bool keeps(const ShadedSums::Light& light) const {
        const bool isVisible = limits_.maxVisible && static_cast<double>(light.above) > allowedAbove(light);
        return !isVisible && light.squaredError <= allowedError(light);
    }
    double excess(const ShadedSums::Light& light, const ShadedSums::Light& whole) const {
        double most = -std::numeric_limits<double>::infinity();
        if (limits_.maxVisible && whole.count > 0)
            most = (static_cast<double>(light.above) - allowedAbove(light)) / std::max(allowedAbove(whole), 1.0);
        if (allowedError(whole) > 0) most = std::max(most, (light.squaredError - allowedError(light)) / allowedError(whole));
        return most;
    }

    SplitLimits limits_;
};

double bitsOf(const CandidateByGroup& candidate) {
    return candidate.whole.bitsPerTexel;
}

ShadedSums sumOf(const std::vector<ShadedSums>& sums, std::span<const std::size_t> groups) {
    ShadedSums sum;
    for (const std::size_t group : groups) sum.merge(sums[group]);
    return sum;
}

/// Returns the candidate of fewest bits that keeps the limits on some groups; if none does, that of most bits.
const CandidateByGroup& cheapestFor(std::span<const CandidateByGroup> candidates, std::span<const std::size_t> groups,
                                    const SplitJudge& judge) {
    const CandidateByGroup* best = nullptr;
    for (const CandidateByGroup& each : candidates)
        if (judge.keeps(sumOf(each.sums, groups)) && (best == nullptr || bitsOf(each) < bitsOf(*best))) best = &each;
    return best != nullptr ? *best : *std::ranges::max_element(candidates, {}, bitsOf);
}

/// Returns some groups in the order in which they are left out: those first that take the candidate furthest from the limits.
std::vector<std::size_t> orderOfLeavingOut(const CandidateByGroup& candidate, std::span<const std::size_t> groups,
                                           std::span<const std::int64_t> texels, const SplitJudge& judge) {
    const ShadedSums whole = sumOf(candidate.sums, groups);
    std::vector<std::pair<double, std::size_t>> excess;  // of each group
    for (const std::size_t group : groups)
        excess.emplace_back(judge.excess(candidate.sums[group], whole) / static_cast<double>(std::max<std::int64_t>(texels[group], 1)),
                            group);
    std::ranges::sort(excess, [](const auto& a, const auto& b) { return a.first != b.first ? a.first > b.first : a.second < b.second; });
    std::vector<std::size_t> order;
    for (const auto& each : excess) order.push_back(each.second);
    return order;
}

/// Returns, for each count, whether a candidate keeps the limits on that many groups from the first on.
std::vector<std::uint8_t> keepsFirst(const CandidateByGroup& candidate, std::span<const std::size_t> groups, const SplitJudge& judge) {
    std::vector<std::uint8_t> keeps = {1};
    ShadedSums sum;
    for (const std::size_t group : groups) {
        sum.merge(candidate.sums[group]);
        keeps.push_back(judge.keeps(sum) ? 1 : 0);
    }
    return keeps;
}

/// Returns the fewest groups to leave out so that one candidate keeps the limits on the rest, and another one on them. Empty: there are
/// none. With more of them, the other candidate only takes more bits.
/// restKeeps  of keepsFirst() for the first candidate, from the end of the order on
/// fineKeeps  likewise for the other one, from the beginning on
std::optional<std::size_t> fewestLeftOut(const std::vector<std::uint8_t>& restKeeps, const std::vector<std::uint8_t>& fineKeeps) {
    const std::size_t groups = restKeeps.size() - 1;
    for (std::size_t count = 1; count < groups; ++count)
        if (restKeeps[groups - count] != 0 && fineKeeps[count] != 0) return count;
    return std::nullopt;
}

double sumOf(std::span<const std::int64_t> texels, std::span<const std::size_t> groups) {
    std::int64_t sum = 0;
    for (const std::size_t group : groups) sum += texels[group];
    return static_cast<double>(sum);
}

/// Groups divided among maps, and the memory of all their texels [bits].
struct Division {
    double bits;
    std::vector<SplitPart> parts;
};

/// Searches for the division of fewest bits.
class SplitSearch {
public:
    /// texels   of each group
    /// padding  texels of a finer map for each texel of its groups
    SplitSearch(std::span<const CandidateByGroup> candidates, std::span<const std::int64_t> texels, const SplitJudge& judge, double padding)
        : texels_(texels), judge_(judge), padding_(padding) {
        for (const CandidateByGroup& each : candidates) candidates_.push_back(&each);
        std::ranges::stable_sort(candidates_, {}, [](const CandidateByGroup* each) { return bitsOf(*each); });
    }

    /// Returns the best division into two maps that takes less than some bits. Empty: there is none.
    std::optional<Division> inTwo(std::span<const std::size_t> groups, double limit) const { return inTwo(groups, 0, 1, limit); }

    /// The same with three maps.
    std::optional<Division> inThree(std::span<const std::size_t> groups, double limit) const {
        std::optional<Division> best;
        for (std::size_t coarse = 0; coarse + 2 < candidates_.size(); ++coarse) {
            const CandidateByGroup& candidate = *candidates_[coarse];
            if (bitsOf(candidate) * sumOf(texels_, groups) >= limit) break;
            const std::vector<std::size_t> order = orderOfLeavingOut(candidate, groups, texels_, judge_);
            const std::vector<std::uint8_t> restKeeps = keepsFirst(candidate, std::vector(order.rbegin(), order.rend()), judge_);
            const std::size_t step = std::max<std::size_t>(1, groups.size() / kCountsTried);
            std::size_t count = 2;
            while (count < groups.size() && restKeeps[groups.size() - count] == 0) ++count;
            for (; count < groups.size(); count += step) {
                if (restKeeps[groups.size() - count] == 0) continue;
                const auto moved = std::span(order).first(count), rest = std::span(order).subspan(count);
                const double restBits = bitsOf(candidate) * sumOf(texels_, rest);
                if (restBits + padding_ * bitsOf(*candidates_[coarse + 1]) * sumOf(texels_, moved) >= limit) break;
                auto finer = inTwo(moved, coarse + 1, padding_, limit - restBits);
                if (!finer) continue;
                limit = restBits + finer->bits;
                finer->parts.insert(finer->parts.begin(), partOf(candidate, rest));
                best = Division{limit, std::move(finer->parts)};
            }
        }
        return best;
    }

private:
    /// Numbers of groups, evenly spread, that are moved from the coarsest of three maps.
    static constexpr std::size_t kCountsTried = 32;

    static SplitPart partOf(const CandidateByGroup& candidate, std::span<const std::size_t> groups) {
        return {candidate.whole.layout, {groups.begin(), groups.end()}};
    }

    /// first          index of the coarsest candidate
    /// coarsePadding  padding of the map with the coarser layout
    std::optional<Division> inTwo(std::span<const std::size_t> groups, std::size_t first, double coarsePadding, double limit) const {
        std::optional<Division> best;
        const double texels = sumOf(texels_, groups);
        for (std::size_t coarse = first; coarse < candidates_.size(); ++coarse) {
            const CandidateByGroup& candidate = *candidates_[coarse];
            if (coarsePadding * bitsOf(candidate) * texels >= limit) break;
            const std::vector<std::size_t> order = orderOfLeavingOut(candidate, groups, texels_, judge_);
            const std::vector<std::uint8_t> restKeeps = keepsFirst(candidate, std::vector(order.rbegin(), order.rend()), judge_);
            for (std::size_t fine = coarse + 1; fine < candidates_.size(); ++fine) {
                const CandidateByGroup& other = *candidates_[fine];
                if (bitsOf(other) <= bitsOf(candidate)) continue;
                const auto count = fewestLeftOut(restKeeps, keepsFirst(other, order, judge_));
                if (!count) continue;
                const auto moved = std::span(order).first(*count), rest = std::span(order).subspan(*count);
                const double bits =
                    coarsePadding * bitsOf(candidate) * sumOf(texels_, rest) + padding_ * bitsOf(other) * sumOf(texels_, moved);
                if (bits >= limit) continue;
                limit = bits;
                best = Division{bits, {partOf(candidate, rest), partOf(other, moved)}};
            }
        }
        return best;
    }

    std::vector<const CandidateByGroup*> candidates_;  ///< by bits
    std::span<const std::int64_t> texels_;
    const SplitJudge& judge_;
    double padding_;
};

/// Returns true if the charts of a packed map lie where they were packed, in the order that they have in the bake. The first texel of a
/// chart with fewer texels may come out one lower: it is found with a tolerance in texels, which are larger there.
bool areAtPlaces(const std::vector<atlas::Chart>& charts, const SplitParameters& parameters) {
    const std::vector<ChartPlace> places = placesOf(parameters.places);
    if (places.size() != charts.size() || parameters.boxes.size() != parameters.places.size()) return false;
    for (std::size_t i = 0; i < charts.size(); ++i) {
        const glm::ivec2 off = glm::abs(charts[i].first - places[i].texel);
        if (off.x > 1 || off.y > 1) return false;
    }
    return true;
}

/// Returns true if the triangles of a scene can be cut: the joints of a skin cannot be interpolated.
bool canBeCut(const formats::GltfScene& scene) {
    return std::ranges::none_of(scene.triangleMeshes(), [](const auto* mesh) { return mesh->find("JOINTS_0") != nullptr; });
}

/// Groups of tiles that are chosen together.
using Grouping = std::vector<std::vector<std::size_t>>;

/// Returns each group alone.
Grouping eachAlone(const std::vector<TileGroup>& groups) {
    Grouping grouping;
    for (std::size_t i = 0; i < groups.size(); ++i) grouping.push_back({i});
    return grouping;
}
/// Returns the groups of each chart together, and of charts that share a group.
Grouping byChart(const std::vector<TileGroup>& groups, const atlas::Tiles& tiles) {
    std::vector<std::uint32_t> firstOfTile(static_cast<std::size_t>(tiles.count()));  // the first tile of the same chart
    for (std::size_t chart = 0; chart < tiles.chartCount(); ++chart) {
        const glm::ivec2 grid = tiles.gridOf(chart);
        const int first = tiles.at(chart, {0, 0});
        std::fill_n(firstOfTile.begin() + first, grid.x * grid.y, static_cast<std::uint32_t>(first));
    }
    formats::DisjointSets sets(static_cast<std::uint32_t>(tiles.count()));
    for (const TileGroup& group : groups)
        for (const int tile : group.tiles)
            sets.join(firstOfTile[static_cast<std::size_t>(group.tiles.front())], firstOfTile[static_cast<std::size_t>(tile)]);
    std::map<std::uint32_t, std::vector<std::size_t>> members;
    for (std::size_t i = 0; i < groups.size(); ++i)
        members[sets.find(firstOfTile[static_cast<std::size_t>(groups[i].tiles.front())])].push_back(i);
    Grouping grouping;
    for (auto& [set, each] : members) grouping.push_back(std::move(each));
    return grouping;
}

/// The layouts on groups of tiles, with what the choice of splits needs beside them.
struct SplitChoice {
    const std::vector<TileGroup>& groups;
    const std::vector<CandidateByGroup>& candidates;
    const atlas::Tiles& tiles;
    const SplitParameters& parameters;
};

/// Gives tiles without texels the map of the nearest tile of their chart that has some, so that no triangle is cut between them.
void fillUnmeasured(const SplitChoice& choice, std::vector<std::uint8_t>& mapOf) {
    std::vector<std::uint8_t> isKnown(mapOf.size(), 0);
    for (const TileGroup& group : choice.groups)
        for (const int tile : group.tiles) isKnown[static_cast<std::size_t>(tile)] = 1;
    for (std::size_t chart = 0; chart < choice.tiles.chartCount(); ++chart) {
        const glm::ivec2 grid = choice.tiles.gridOf(chart);
        std::deque<glm::ivec2> known;
        const auto tileAt = [&](const glm::ivec2& place) { return static_cast<std::size_t>(choice.tiles.at(chart, place)); };
        for (int y = 0; y < grid.y; ++y)
            for (int x = 0; x < grid.x; ++x)
                if (isKnown[tileAt({x, y})] != 0) known.emplace_back(x, y);
        for (; !known.empty(); known.pop_front())
            for (const glm::ivec2 step : {glm::ivec2(-1, 0), glm::ivec2(1, 0), glm::ivec2(0, -1), glm::ivec2(0, 1)}) {
                const glm::ivec2 next = known.front() + step;
                if (next.x < 0 || next.y < 0 || next.x >= grid.x || next.y >= grid.y || isKnown[tileAt(next)] != 0) continue;
                isKnown[tileAt(next)] = 1;
                mapOf[tileAt(next)] = mapOf[tileAt(known.front())];
                known.push_back(next);
            }
    }
}

/// Adds a split, unless it divides the tiles as another one does.
/// texels  of each set of the grouping
void addSplit(const SplitChoice& choice, const Grouping& grouping, const ChartSplit& split, std::span<const std::int64_t> texels,
              std::vector<TriedSplit>& splits) {
    TriedSplit made{choice.tiles.side(), {}, split.bits, split.bitsOfOne};
    std::vector<std::uint8_t> mapOf(static_cast<std::size_t>(choice.tiles.count()), 0);
    const auto all = static_cast<double>(std::accumulate(texels.begin(), texels.end(), std::int64_t{0}));
    for (std::size_t map = 0; map < split.parts.size(); ++map) {
        const SplitPart& part = split.parts[map];
        made.maps.push_back({part.layout, {}, sumOf(texels, part.groups) / all});
        for (const std::size_t set : part.groups)
            for (const std::size_t group : grouping[set])
                for (const int tile : choice.groups[group].tiles) mapOf[static_cast<std::size_t>(tile)] = static_cast<std::uint8_t>(map);
    }
    fillUnmeasured(choice, mapOf);
    for (std::size_t tile = 0; tile < mapOf.size(); ++tile) made.maps[mapOf[tile]].tiles.push_back(static_cast<int>(tile));
    const auto isSame = [&](const TriedSplit& other) {
        return std::ranges::equal(other.maps, made.maps, {}, &SplitMap::tiles, &SplitMap::tiles);
    };
    if (std::ranges::none_of(splits, isSame)) splits.push_back(std::move(made));
}

/// Adds the splits of a grouping that are expected to take fewer bits than one map.
void addSplits(const SplitChoice& choice, const Grouping& grouping, double padding, std::vector<TriedSplit>& splits) {
    std::vector<std::int64_t> texels;
    std::vector<CandidateByGroup> candidates;
    for (const CandidateByGroup& each : choice.candidates) candidates.push_back({each.whole, {}});
    for (const std::vector<std::size_t>& members : grouping) {
        std::int64_t& sum = texels.emplace_back();
        for (const std::size_t group : members) sum += choice.groups[group].texels;
        for (std::size_t i = 0; i < candidates.size(); ++i) candidates[i].sums.push_back(sumOf(choice.candidates[i].sums, members));
    }
    for (const double share : kSplitShares)
        for (std::size_t mostMaps = 2; mostMaps <= kMostMaps; ++mostMaps) {
            const SplitLimits limits{choice.parameters.limits[Limit::Error].value_or(kNoErrorLimit),
                                     choice.parameters.limits[Limit::Visible], share};
            const ChartSplit split = chooseSplit(candidates, texels, limits, padding, mostMaps);
            if (split.parts.size() == mostMaps) addSplit(choice, grouping, split, texels, splits);
        }
}

}  // namespace

ChartSplit chooseSplit(std::span<const CandidateByGroup> candidates, std::span<const std::int64_t> texels, const SplitLimits& limits,
                       double padding, std::size_t mostMaps) {
    ChartSplit best;
    if (candidates.empty() || texels.empty()) return best;
    std::vector<std::size_t> all(texels.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    SplitLimits whole = limits;
    whole.share = 1;
    const CandidateByGroup& one = cheapestFor(candidates, all, SplitJudge(whole));
    best.bits = best.bitsOfOne = bitsOf(one);
    best.parts = {{one.whole.layout, all}};
    const double total = std::max(sumOf(texels, all), 1.0);
    const SplitJudge judge(limits);
    const SplitSearch search(candidates, texels, judge, padding);
    for (std::size_t maps = 2; maps <= mostMaps; ++maps) {
        const double limit = (1 - kLeastSplitSaving) * best.bits * total;
        if (auto found = maps == 2 ? search.inTwo(all, limit) : search.inThree(all, limit)) {
            best.parts = std::move(found->parts);
            best.bits = found->bits / total;
        }
    }
    return best;
}

Result<ActionOutcome> splitCharts(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<SplitParameters>(context));
    LC_TRY(source, openLightMap(context, parameters->trial.description));
    const std::filesystem::path& mesh = context.action.inputs.at(kMeshRole);
    LC_TRY(scene, formats::GltfScene::load(mesh));
    LC_TRY(found, chartsOf(*scene, mesh, {(*source)->width(), (*source)->height()}));
    if (!areAtPlaces(found->charts, *parameters))
        return formats::failure(formats::ErrorCode::Internal, mesh, "found charts that lie elsewhere than where they were packed");
    LC_TRY(key, surveyKey(**source, context));
    const std::vector<atlas::ChartBox> boxes = boxesOf(parameters->boxes);
    const atlas::Tiles tiles(boxes, canBeCut(*scene) ? kTileSide : 0);
    PackedTiles packed{tiles};
    const std::vector<ChartPlace> places = placesOf(parameters->places);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        packed.steps.push_back(places[i].step);
        packed.firsts.push_back(boxes[i].first + (found->charts[i].first - places[i].texel) * places[i].step);
    }
    const TileGroups grouped = groupTiles(found->charts, packed, (*source)->width(), (*source)->height());
    LC_TRY(tried, tryLayoutsByGroup(parameters->trial, grouped.places(parameters->limits[Limit::Visible]), context));

    SplitResult result{{}, key->displayKey(), {}};
    const SplitChoice choice{grouped.groups, *tried, tiles, *parameters};
    addSplits(choice, byChart(grouped.groups, tiles), 1, result.splits);
    if (tiles.side() > 0) addSplits(choice, eachAlone(grouped.groups), kTilePadding, result.splits);
    std::ranges::stable_sort(result.splits, {}, &TriedSplit::bits);
    for (CandidateByGroup& each : *tried) result.one.candidates.push_back(std::move(each.whole));
    return outcomeWith(result);
}

}  // namespace lightcook::pipeline
