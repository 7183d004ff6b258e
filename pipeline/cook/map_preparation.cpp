#include "pipeline/cook/map_preparation.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/cook/contents.h"
#include "pipeline/graph/files.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// A split that takes more than this many times its expected bytes has not got the layouts that were expected: the next one is tried.
constexpr double kHeldExpectation = 1.05;

/// Returns true if the maps of a split, of these bytes, are smaller than one. Empty: no layout is within the limits.
bool areSmaller(const std::optional<std::uint64_t>& bytes, const std::optional<std::uint64_t>& bytesOfOne) {
    return bytes && (!bytesOfOne || *bytes < *bytesOfOne);
}

/// Writes the report's note on a split: the share of the texels that the further maps have, and the bytes of all maps and of one.
std::string splitWords(const LightMapEntry& entry, const TriedSplit& split, const std::optional<std::uint64_t>& bytes,
                       const std::optional<std::uint64_t>& bytesOfOne) {
    const auto size = [](const std::optional<std::uint64_t>& of) {
        return of ? fmt::format("{:.1f} KiB", static_cast<double>(*of) / 1024) : "no layout within the limits";
    };
    const auto names = splitNamesOf(entry.name);
    const bool hasTwo = split.maps.size() == 2;
    std::string shares, further;
    for (std::size_t i = 1; i < split.maps.size(); ++i) {
        shares += fmt::format("{}{:.1f}", i > 1 ? " and " : "", 100 * split.maps[i].share);
        further += fmt::format(", '{}'", names[i]);
    }
    const std::string words =
        fmt::format("{} % of the texels in {}: {} maps take {}, one takes {}", shares, hasTwo ? "a map of their own" : "maps of their own",
                    hasTwo ? "two" : "three", size(bytes), size(bytesOfOne));
    return areSmaller(bytes, bytesOfOne) ? words + further : "no, " + words;
}

/// Puts the maps of a split in the place of the light map, if the scene has it. A manifest may have any number of maps.
void putSplit(const std::string& lightMap, const ChosenSplit& chosen, Scene& scene) {
    const auto place = std::ranges::find(scene.lightMaps, lightMap, &LightMapEntry::name);
    if (place == scene.lightMaps.end() || chosen.split.maps.empty() || chosen.split.maps.size() > kMostMaps) return;
    const std::vector<LightMapEntry> parts = partsOf(*place, chosen.split, chosen.displayKey);
    *place = parts.front();
    scene.lightMaps.insert(place + 1, parts.begin() + 1, parts.end());
}

}  // namespace

ExecutionResult MapPreparation::run(const std::vector<Action>& graph, const std::filesystem::path& folder) {
    ExecutionResult result = run_(graph, folder);
    result_.errors.insert(result_.errors.end(), result.errors.begin(), result.errors.end());
    result_.actionsRun += result.actionsRun;
    result_.actionsReused += result.actionsReused;
    return result;
}

Result<Scene> MapPreparation::prepare(Scene& scene, const Needs& needs) {
    LC_CHECK(split(scene, needs));
    Scene wanted = scene;
    std::erase_if(wanted.lightMaps, [&](const LightMapEntry& entry) { return !isAnyWanted(scene, options_, entry); });
    graph_ = packActions(wanted);
    return pack(scene, graph_, folder_ / "packed");
}

/// Returns the actions that pack the light maps of a scene, as far as it asks for that.
std::vector<Action> MapPreparation::packActions(const Scene& scene) const {
    std::vector<Action> graph;
    for (const LightMapEntry& entry : scene.lightMaps)
        if (isPacked(scene.output, entry)) graph.push_back(packAction(entry, chartsMaxVisible(scene.output, entry), options_.repair));
    return graph;
}

Result<Scene> MapPreparation::pack(const Scene& scene, const std::vector<Action>& graph, const std::filesystem::path& folder) {
    Scene packedScene = scene;
    if (isStopped() || graph.empty()) return packedScene;
    LC_CHECK(makeFolder(folder));
    const ExecutionResult result = run(graph, folder);
    for (const Action& action : graph) {
        const auto record = result.records.find(action.id);
        const auto entry = std::ranges::find(packedScene.lightMaps, action.asset, &LightMapEntry::name);
        if (record == result.records.end()) {
            packedScene.lightMaps.erase(entry);
            continue;
        }
        LC_TRY(packed, packedLightMap(action, record->second, folder));
        *entry = packedEntry(std::move(*entry), *packed);
        options_.packed[action.asset] = std::move(*packed);
    }
    return packedScene;
}

/// Returns the needs with the contents of packed maps. Its actions do not count as run or reused: they make nothing.
Result<Needs> MapPreparation::withContents(const Scene& packed, Needs needs) {
    const ExecutionResult contents = run_(planContents(packed, needs, options_), {});
    result_.errors.insert(result_.errors.end(), contents.errors.begin(), contents.errors.end());
    LC_CHECK(addContents(contents, needs));
    return needs;
}

/// Puts two or three maps in place of each light map whose charts are to be split, where that takes fewer bytes.
Result<void> MapPreparation::split(Scene& scene, const Needs& needs) {
    if (options_.assets) {
        for (LightMapEntry& entry : scene.lightMaps)
            if (isSplit(scene.output, entry)) entry.charts.mode = ChartMode::Pack;
        for (const auto& [lightMap, chosen] : options_.decisions.splits) putSplit(lightMap, chosen, scene);
        return {};
    }
    const Scene maps = onlyMapsToSplit(scene, options_);
    if (maps.lightMaps.empty()) return {};
    LC_TRY(whole, pack(maps, packActions(maps), folder_ / "whole"));
    if (isStopped()) return {};
    LC_TRY(known, withContents(*whole, needs));
    std::vector<Action> splits;
    for (const LightMapEntry& entry : whole->lightMaps)
        if (auto action = splitAction(*whole, *known, entry, options_.packed.at(entry.name), options_.repair))
            splits.push_back(std::move(*action));
    if (isStopped()) return {};
    const ExecutionResult result = run(splits);
    for (const LightMapEntry& entry : maps.lightMaps) {
        std::ranges::find(scene.lightMaps, entry.name, &LightMapEntry::name)->charts.mode = ChartMode::Pack;
        const auto record = result.records.find(actionId(ActionStep::Split, entry.name));
        if (record == result.records.end() || isStopped()) continue;
        LC_TRY(chosen, fromJson<SplitResult>(record->second.result, record->first));
        LC_CHECK(trySplits(scene, maps, entry, *chosen, needs));
    }
    return {};
}

/// Tries splits of a light map, and puts the maps of the smallest in its place if they take fewer bytes than one.
Result<void> MapPreparation::trySplits(Scene& scene, const Scene& maps, const LightMapEntry& entry, const SplitResult& found,
                                       const Needs& needs) {
    const ChartPacking packing = options_.packed.at(entry.name).bake.packing;
    const auto bytesOfOne = leastBytes(found.one, packing, scene, needs, entry);
    const TriedSplit* best = nullptr;
    std::optional<std::uint64_t> least;
    for (const TriedSplit& split : found.splits) {
        const double expected = split.bits / split.bitsOfOne * static_cast<double>(bytesOfOne.value_or(0));
        if (least && expected >= static_cast<double>(*least)) break;  // the expectation is rarely too high, and rises from here on
        Scene parts = maps;
        parts.lightMaps = partsOf(entry, split, found.displayKey);
        LC_TRY(bytes, bytesOfParts(parts, needs));
        if (best == nullptr || bytes->value_or(UINT64_MAX) < least.value_or(UINT64_MAX)) {
            best = &split;
            least = *bytes;
        }
        const bool isHeld = *bytes && static_cast<double>(**bytes) <= kHeldExpectation * expected;
        if (isHeld && areSmaller(*bytes, bytesOfOne)) break;
    }
    notes_[entry.name] = {
        {note_keys::kSplit, best != nullptr ? splitWords(entry, *best, least, bytesOfOne)
                                            : fmt::format("no, one layout for all {} charts takes the fewest bytes", packing.charts)}};
    if (!areSmaller(least, bytesOfOne)) return {};
    putSplit(entry.name, options_.decisions.splits[entry.name] = {*best, found.displayKey}, scene);
    return {};
}

/// Returns the GPU memory of the maps of a split [bytes]. Empty: one has no layout within the limits.
Result<std::optional<std::uint64_t>> MapPreparation::bytesOfParts(const Scene& parts, const Needs& needs) {
    LC_TRY(packed, pack(parts, packActions(parts), folder_ / "parts"));
    if (isStopped() || packed->lightMaps.size() < parts.lightMaps.size()) return std::optional<std::uint64_t>();
    LC_TRY(known, withContents(*packed, needs));
    std::vector<Action> trials;
    for (const LightMapEntry& entry : packed->lightMaps)
        if (auto trial = partTrial(*packed, *known, entry, options_.repair)) trials.push_back(std::move(*trial));
    if (isStopped()) return std::optional<std::uint64_t>();
    const ExecutionResult result = run(trials);
    std::uint64_t sum = 0;  // a map of constant light, which has no trial, takes a block
    for (const Action& action : trials) {
        const auto record = result.records.find(action.id);
        if (record == result.records.end()) return std::optional<std::uint64_t>();
        LC_TRY(trial, fromJson<TrialResult>(record->second.result, action.id));
        const auto least = leastBytes(*trial, options_.packed.at(action.asset).bake.packing, parts, needs, parts.lightMaps.front());
        if (!least) return std::optional<std::uint64_t>();
        sum += *least;
    }
    return std::optional(sum);
}

}  // namespace lightcook::pipeline
