#include "pipeline/cook/layout_decision.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>

#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/light_map/detailed_layout.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/assets/results.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Returns the GPU memory of the meshes of some light maps: these meshes wait for the layouts.
Result<std::map<std::string, MeshMemory>> meshesOf(const Scene& scene, const std::vector<std::string>& lightMaps,
                                                   const ExecutionResult& materials) {
    std::map<std::string, MeshMemory> meshes;
    for (const LightMapEntry& entry : scene.lightMaps) {
        if (!entry.mesh || std::ranges::find(lightMaps, entry.name) == lightMaps.end()) continue;
        const auto record = materials.records.find(actionId(ActionStep::Materials, entry.mesh->string()));
        if (record == materials.records.end()) continue;
        LC_TRY(result, fromJson<MaterialsResult>(record->second.result, record->second.id));
        meshes[entry.name] = {result->mostVertices, scene.output.draco, isPacked(scene.output, entry)};
    }
    return meshes;
}

/// Keeps only the choices within a limit on rel_rms of the whole shading; where none is, those of least error.
void keepWithin(double limit, std::vector<AllocationChoice>& choices) {
    double least = std::numeric_limits<double>::infinity();
    for (const AllocationChoice& each : choices) least = std::min(least, each.relRms);
    std::erase_if(choices, [&](const AllocationChoice& each) { return each.relRms > std::max(limit, least); });
}

}  // namespace

std::uint64_t MeshMemory::bytesOf(const std::string& layout) const {
    if (const auto known = found.find(layout); known != found.end()) return known->second;
    const bool hasBases = hasLearnedBases(layout);
    return isDraco || isPacked || hasBases ? vertices * bytesOfVertex(isDraco, hasBases) : 0;
}

Limits layoutLimitsOf(const Scene& scene, const std::string& map) {
    const auto found = std::ranges::find(scene.lightMaps, map, &LightMapEntry::name);
    return layoutLimits(scene.output, found == scene.lightMaps.end() ? LightMapEntry{} : *found);
}

Result<LayoutDecision> LayoutDecision::create(const Scene& scene, const Plan& open, const ExecutionResult& trials,
                                              const ExecutionResult& materials) {
    LayoutDecision decision(scene);
    decision.openTables_ = open.openTables;
    for (const std::string& map : open.undecided) {
        const auto record = trials.records.find(actionId(ActionStep::Trial, map));
        if (record == trials.records.end()) continue;
        LC_TRY(trial, trialIn(record->second));
        decision.candidates_[map] = candidatesOf(trial->trial, layoutLimitsOf(scene, map));
        if (trial->trial.isPruned) decision.pruned_.insert(map);
        decision.addChoices(map, *trial);
    }
    LC_TRY(meshes, meshesOf(scene, open.undecided, materials));
    decision.meshes_ = std::move(*meshes);
    for (const auto& [map, mesh] : decision.meshes_)
        if (!decision.choices_.contains(map)) decision.otherBytes_ += mesh.mostBytes();
    for (const std::string& name : open.assets) {
        const auto record = trials.records.find(actionId(ActionStep::Cook, name));
        if (record == trials.records.end()) continue;
        LC_TRY(cooked, fromJson<CookResult>(record->second.result, record->second.id));
        decision.otherBytes_ += cooked->asset.totalBytesGpu();
    }
    return decision;
}

/// Returns true if a limit on the errors of this light map is given.
bool LayoutDecision::isErrorLimited(const std::string& map) const {
    const auto entry = std::ranges::find(scene_.lightMaps, map, &LightMapEntry::name);
    return entry == scene_.lightMaps.end() ? scene_.output.isErrorLimited() : pipeline::isErrorLimited(scene_.output, *entry);
}

/// Adds the layouts of a joint trial that are not known.
void LayoutDecision::addChoices(const std::string& map, const JointTrialResult& trial) {
    for (const WholeCandidate& each : trial.whole) {
        if (std::ranges::find(choices_[map], each.layout, &AllocationChoice::layout) != choices_[map].end()) continue;
        const auto candidate = std::ranges::find(trial.trial.candidates, each.layout, &TrialCandidate::layout);
        choices_[map].push_back({each.layout, candidate->bytesGpu, each.visible, each.relRms});
    }
}

/// Returns true if the limits of a light map alone allow a layout. A limit on the whole may need a finer one than the cheapest.
bool LayoutDecision::keepsLimits(const std::string& map, const std::string& layout, const std::string& cheapest) const {
    if (layout == cheapest) return true;
    return scene_.output.isWholeLimited() && std::ranges::find(candidates_.at(map), layout, &LightMapCandidate::layout)->usedOfLimits <= 1;
}

/// Returns the choices within the limits on light maps and on rel_rms of the whole shading, with the bytes of the meshes.
AllocationChoices LayoutDecision::allowedChoices() const {
    AllocationChoices allowed = choices_;
    for (auto& entry : allowed) {
        const std::string& map = entry.first;
        AllocationChoices::mapped_type& choices = entry.second;
        if (isErrorLimited(map)) {
            const std::string cheapest = cheapestWithin({{map, candidates_.at(map)}}, 1, scene_.output.cost).at(map);
            std::erase_if(choices, [&](const AllocationChoice& each) { return !keepsLimits(map, each.layout, cheapest); });
        }
        if (scene_.output.limits[Limit::WholeError]) keepWithin(*scene_.output.limits[Limit::WholeError], choices);
        if (const auto mesh = meshes_.find(map); mesh != meshes_.end())
            for (AllocationChoice& each : choices) each.bytes += mesh->second.bytesOf(each.layout);
    }
    return allowed;
}

std::map<std::string, std::string> LayoutDecision::choose() {
    auto alone = candidates_;  // maps that no budget or limit on the whole trades
    std::erase_if(alone, [&](const auto& entry) { return choices_.contains(entry.first); });
    chosen_ = cheapestWithin(alone, 1, scene_.output.cost);
    for (const auto& [map, candidates] : alone)
        if (const auto entry = std::ranges::find(scene_.lightMaps, map, &LightMapEntry::name);
            entry != scene_.lightMaps.end() && isByDefault(scene_.output, *entry) &&
            std::ranges::none_of(candidates, [](const LightMapCandidate& each) { return each.usedOfLimits <= 1; }))
            unlimited_.insert(map);
    if (choices_.empty()) return chosen_;
    frontier_ = allocationFrontier(allowedChoices(), otherBytes_);
    const OutputSettings& output = scene_.output;
    chosenPoint_ = output.isWholeLimited() ? pointOfLimits() : frontier_.size() - 1;
    if (output.budgetBytes) {
        const TableBytes tables = openTables_.value_or(TableBytes{});
        const BudgetChoice choice = choiceWithin(frontier_, tables, *output.budgetBytes, chosenPoint_, areLeastTablesRefuted_);
        chosenPoint_ = choice.point;
        for (AllocationPoint& point : frontier_) point.bytes += choice.areTablesFine ? tables.fine : tables.least;
        if (openTables_) tableViews_ = choice.areTablesFine ? kFineViewCount : kLeastViewCount;
    }
    for (const auto& [map, choice] : frontier_[chosenPoint_].choices) chosen_[map] = choice.layout;
    return chosen_;
}

/// Returns the smallest point that keeps the limits on the whole shading. All points keep the one on rel_rms.
std::size_t LayoutDecision::pointOfLimits() const {
    return scene_.output.limits[Limit::WholeVisible] ? pointOfError(frontier_, *scene_.output.limits[Limit::WholeVisible]) : 0;
}

std::vector<std::string> LayoutDecision::mapsToTry() const {
    std::vector<std::string> maps;
    const auto isLeft = [&](const std::string& map) {
        if (const auto joint = choices_.find(map); joint != choices_.end())
            return std::ranges::any_of(joint->second, [&](const AllocationChoice& each) {
                const auto alone = std::ranges::find(candidates_.at(map), each.layout, &LightMapCandidate::layout);
                return each.visible <= scene_.output.limits[Limit::WholeVisible].value_or(0) &&
                       (!isErrorLimited(map) || alone->usedOfLimits <= 1);
            });
        return std::ranges::any_of(candidates_.at(map), [](const LightMapCandidate& each) { return each.usedOfLimits <= 1; });
    };
    std::ranges::copy_if(pruned_, std::back_inserter(maps), std::not_fn(isLeft));
    return maps;
}

Result<void> LayoutDecision::addTrial(const std::string& map, const ActionRecord& record) {
    LC_TRY(trial, trialIn(record));
    std::vector<LightMapCandidate>& known = candidates_.at(map);
    for (LightMapCandidate& each : candidatesOf(trial->trial, layoutLimitsOf(scene_, map)))
        if (std::ranges::find(known, each.layout, &LightMapCandidate::layout) == known.end()) known.push_back(std::move(each));
    addChoices(map, *trial);
    return {};
}

std::map<std::string, std::map<std::string, std::string>> LayoutDecision::alternatives() const {
    std::map<std::string, std::map<std::string, std::string>> out;
    for (const auto& [map, candidates] : candidates_)
        for (const std::string& layout : layoutsOfCurve(candidates))
            if (layout != chosen_.at(map) && !DetailedLayout::ofName(layout).limit)
                out.try_emplace(layout, chosen_).first->second[map] = layout;
    return out;
}

Result<bool> LayoutDecision::learnFrom(const Plan& plan, const ExecutionResult& others, const ExecutionResult& chosen) {
    auto isMapRefuted = noteVerifiedMaps(chosen);
    if (!isMapRefuted || choices_.empty()) return isMapRefuted;
    LC_CHECK(noteFailedTables(chosen));
    LC_CHECK(noteWholes(chosen));
    LC_CHECK(correctBytes(plan, others, chosen));
    const std::map<std::string, std::string> before = chosen_;
    const std::optional<int> viewsBefore = tableViews_;
    return choose() != before || tableViews_ != viewsBefore || !mapsToTry().empty();
}

/// Notes the verified errors of light maps. Returns true if one misses a limit that its trial had kept.
Result<bool> LayoutDecision::noteVerifiedMaps(const ExecutionResult& chosen) {
    bool isRefuted = false;
    for (auto& [map, candidates] : candidates_) {
        const std::string& layout = chosen_.at(map);
        const auto record = chosen.records.find(actionId(ActionStep::Verify, map));
        if (record == chosen.records.end()) continue;
        LC_TRY(verified, fromJson<VerifyResult>(record->second.result, record->second.id));
        if (verified->seams) seams_[map][layout] = verified->seams->largestAdded();
        const double found = verifiedUse(*verified, layoutLimitsOf(scene_, map));
        LightMapCandidate& candidate = *std::ranges::find(candidates, layout, &LightMapCandidate::layout);
        const bool isMissed = found > 1 && candidate.usedOfLimits <= 1;
        candidate.usedOfLimits = found;
        if (isMissed && layoutLimitsOf(scene_, map)[Limit::VisibleBound]) expectBounds(candidate, candidates);
        isRefuted = isRefuted || isMissed;
    }
    return isRefuted;
}

/// Notes that open tables of the fewest views missed a limit of theirs.
Result<void> LayoutDecision::noteFailedTables(const ExecutionResult& chosen) {
    const auto record = chosen.records.find(actionId(ActionStep::Verify, kTablesName));
    if (record == chosen.records.end() || tableViews_ != kLeastViewCount) return {};
    LC_TRY(verified, fromJson<VerifyResult>(record->second.result, record->second.id));
    areLeastTablesRefuted_ = areLeastTablesRefuted_ || !verified->verdict.passed;
    return {};
}

/// Notes what pixels show of the layouts that were verified: the trial of a part of the map may have found less. Layouts over a limit on it
/// are not chosen again.
Result<void> LayoutDecision::noteWholes(const ExecutionResult& chosen) {
    for (auto& [map, choices] : choices_) {
        const auto record = chosen.records.find(actionId(ActionStep::Whole, map));
        if (record == chosen.records.end()) continue;
        LC_TRY(whole, fromJson<WholeFigures>(record->second.result, record->second.id));
        AllocationChoice& choice = *std::ranges::find(choices, chosen_.at(map), &AllocationChoice::layout);
        double& excess = trialExcess_.try_emplace(map, 1).first->second;
        if (wholes_[map].try_emplace(choice.layout, whole->visible.p99).second && choice.visible > 0)
            excess = std::max(excess, whole->visible.p99 / choice.visible);
        if (areKept(whole->checks())) continue;
        choice.visible = std::max(choice.visible, whole->visible.p99);
        choice.relRms = std::max(choice.relRms, whole->relRms);
    }
    return {};
}

/// Returns the bytes of the meshes of the last choose() whose maps have choices.
std::uint64_t LayoutDecision::chosenMeshBytes() const {
    std::uint64_t bytes = 0;
    for (const auto& [map, mesh] : meshes_)
        if (choices_.contains(map)) bytes += mesh.bytesOf(chosen_.at(map));
    return bytes;
}

/// Notes the bytes of the meshes that were cooked. They have as many vertices under other layouts, too.
Result<void> LayoutDecision::noteMeshes(const Plan& plan, const ExecutionResult& chosen) {
    for (const auto& [asset, map] : plan.meshes) {
        const auto record = chosen.records.find(actionId(ActionStep::Cook, asset));
        const auto mesh = meshes_.find(map);
        if (record == chosen.records.end() || mesh == meshes_.end()) continue;
        LC_TRY(cooked, fromJson<CookResult>(record->second.result, record->first));
        const std::uint64_t bytes = cooked->asset.totalBytesGpu();
        mesh->second.found[chosen_.at(map)] = bytes;
        mesh->second.vertices = bytes / bytesOfVertex(mesh->second.isDraco, cooked->asset.basis.has_value());
    }
    return {};
}

/// Replaces the upper bound of the meshes' memory, and of what has no choice, by what they take. The latter sum shrinks once at most;
/// otherwise a choice that fits could be taken and refused in turn.
Result<void> LayoutDecision::correctBytes(const Plan& plan, const ExecutionResult& others, const ExecutionResult& chosen) {
    const std::uint64_t meshesBefore = chosenMeshBytes();
    LC_CHECK(noteMeshes(plan, chosen));
    std::uint64_t found = 0;
    for (const std::string& asset : plan.assets) {
        const std::string id = actionId(ActionStep::Cook, asset);
        const auto& records = chosen.records.contains(id) ? chosen.records : others.records;
        const auto record = records.find(id);
        if (record == records.end()) return {};
        LC_TRY(cooked, fromJson<CookResult>(record->second.result, id));
        found += cooked->asset.totalBytesGpu();
    }
    const std::uint64_t expected = frontier_[chosenPoint_].bytes - meshesBefore + chosenMeshBytes();
    if (found == expected || (found < expected && !mayShrink_)) return {};
    if (found < expected) mayShrink_ = false;
    otherBytes_ = otherBytes_ + found - expected;
    return {};
}

const std::string& lightMapOf(const Plan& plan, const std::string& asset) {
    const auto mesh = plan.meshes.find(asset);
    return mesh == plan.meshes.end() ? asset : mesh->second;
}

double LayoutDecision::expectedVisible(const std::string& map, const AllocationChoice& choice) const {
    const auto verified = wholes_.find(map);
    if (verified == wholes_.end()) return choice.visible;
    const auto found = verified->second.find(choice.layout);
    return found == verified->second.end() ? choice.visible * trialExcess_.at(map) : found->second;
}

std::vector<FrontierPoint> frontierOf(const LayoutDecision& decision) {
    std::vector<FrontierPoint> out;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < decision.frontier().size(); ++i) {
        const AllocationPoint& point = decision.frontier()[i];
        FrontierPoint made{point.bytes, 0, i == decision.chosenPoint(), {}};
        for (const auto& [map, choice] : point.choices) {
            made.visible = std::max(made.visible, decision.expectedVisible(map, choice));
            made.layouts.push_back({map, choice.layout});
        }
        if (!made.isChosen && made.visible >= least) continue;
        least = std::min(least, made.visible);
        out.push_back(std::move(made));
    }
    return out;
}

std::map<std::string, Json> wholeVisibleNotes(const LayoutDecision& decision) {
    std::map<std::string, Json> notes;
    if (decision.frontier().empty()) return notes;
    for (const auto& [map, choice] : decision.frontier()[decision.chosenPoint()].choices)
        notes[map] = {{note_keys::kWholeVisible, choice.visible}};
    return notes;
}

}  // namespace lightcook::pipeline
