// Decides the layouts that a scene leaves open: by the errors of each light map, or of all light maps together by budget or by the error of
// what a pixel shows; from their trials, and again after verification.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/joint_trial.h"
#include "pipeline/assets/light_map/layout_choice.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/cook/allocation.h"
#include "pipeline/cook/plan.h"
#include "pipeline/graph/executor.h"
#include "pipeline/limits/limits.h"
#include "pipeline/report/frontier.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns the limits that the layout of a light map is chosen by.
Limits layoutLimitsOf(const Scene& scene, const std::string& map);

/// GPU memory of the mesh of a light map, which depends on the layout of the map: vertices name the bases of a learned one, and a plain
/// mesh is written for these alone.
struct MeshMemory {
    std::uint64_t vertices = 0;                       ///< of its triangles, at most
    bool isDraco = false, isPacked = false;           ///< Draco, or a packing of charts: there is a mesh under every layout
    std::map<std::string, std::uint64_t> found = {};  ///< bytes of those that were cooked, by layout of the light map

    /// Returns the bytes under a layout of the light map: those that were found, or else an upper bound.
    std::uint64_t bytesOf(const std::string& layout) const;
    /// Returns an upper bound for any layout.
    std::uint64_t mostBytes() const { return vertices * bytesOfVertex(isDraco, true); }
};

class LayoutDecision {
public:
    /// open        plan with maps whose layout is not decided
    /// trials      records of the trials, and of the assets that were cooked with them
    /// materials   records of the meshes' materials
    static formats::Result<LayoutDecision> create(const Scene& scene, const Plan& open, const ExecutionResult& trials,
                                                  const ExecutionResult& materials);

    /// Returns layouts by light map: the cheapest within the error; or with a budget the allocation of least error within it; or with a
    /// limit on what a pixel shows the smallest allocation within it, or within the budget as well. Beside an error of light maps and a
    /// budget, maps keep the cheapest within that error.
    std::map<std::string, std::string> choose();
    /// Returns the light maps under the default limit that no layout of theirs keeps: the best one is held to no limit.
    const std::set<std::string>& unlimited() const { return unlimited_; }
    /// Returns the views of the tables that the last choose() takes. Empty: the plan leaves none open, or no frontier to choose them by.
    const std::optional<int>& tableViews() const { return tableViews_; }
    /// Notes what verification found of the chosen assets: errors of light maps, failures, and the bytes that meshes take. Where layouts
    /// are chosen together, also chooses again. Returns true if the choice has to be tried anew: a map missed a limit that its trial had
    /// kept, since a trial of a part of a map may be too good; another allocation was chosen, as meshes turned out smaller than their upper
    /// bound; or a map is left without a layout that keeps its limits, while its trial left out some.
    formats::Result<bool> learnFrom(const Plan& plan, const ExecutionResult& others, const ExecutionResult& chosen);

    /// Returns the maps that no layout is left for of those that their trial measured, while it left out others: they need a complete
    /// trial.
    std::vector<std::string> mapsToTry() const;
    /// Says that a complete trial of a map was run, so that it is not asked for again, also where it failed.
    void setTried(const std::string& map) { pruned_.erase(map); }
    /// Adds the layouts of a complete trial that the first one left out.
    formats::Result<void> addTrial(const std::string& map, const ActionRecord& trial);

    /// Returns the largest steps that layouts add to edges, by light map and layout: of those that were verified.
    const std::map<std::string, std::map<std::string, double>>& seams() const { return seams_; }

    /// Returns other choices than the last choose(), by layout: each map that the layout is on the curve of (layoutsOfCurve) has it, the
    /// other assets are as chosen.
    std::map<std::string, std::map<std::string, std::string>> alternatives() const;

    /// Returns the frontier of the last choose(), with the point that it chose. Empty where only errors of light maps decide.
    const std::vector<AllocationPoint>& frontier() const { return frontier_; }
    std::size_t chosenPoint() const { return chosenPoint_; }
    /// Returns the visible error of the whole shading of a choice: verified, or else that of its trial, times how much more the verified
    /// choices of the map had than their trials found.
    double expectedVisible(const std::string& map, const AllocationChoice& choice) const;

private:
    explicit LayoutDecision(const Scene& scene) : scene_(scene) {}
    bool isErrorLimited(const std::string& map) const;
    void addChoices(const std::string& map, const JointTrialResult& trial);
    bool keepsLimits(const std::string& map, const std::string& layout, const std::string& cheapest) const;
    AllocationChoices allowedChoices() const;
    std::size_t pointOfLimits() const;
    formats::Result<bool> noteVerifiedMaps(const ExecutionResult& chosen);
    formats::Result<void> noteFailedTables(const ExecutionResult& chosen);
    formats::Result<void> noteWholes(const ExecutionResult& chosen);
    std::uint64_t chosenMeshBytes() const;
    formats::Result<void> noteMeshes(const Plan& plan, const ExecutionResult& chosen);
    formats::Result<void> correctBytes(const Plan& plan, const ExecutionResult& others, const ExecutionResult& chosen);

    const Scene& scene_;
    LightMapCandidates candidates_;
    std::set<std::string> pruned_;                                 ///< maps whose trial left out layouts
    std::map<std::string, std::map<std::string, double>> seams_;   ///< see seams()
    std::map<std::string, std::map<std::string, double>> wholes_;  ///< visible errors of the whole, of layouts that were verified
    std::map<std::string, double> trialExcess_;                    ///< largest ratio of these to those of the trial; at least 1
    AllocationChoices choices_;  ///< of a scene whose layouts are chosen together (OutputSettings::isChosenByWhole), without meshes
    std::map<std::string, MeshMemory> meshes_;  ///< of maps whose layout is open, by light map
    std::uint64_t otherBytes_ = 0;          ///< GPU memory of assets without a choice, meshes at their upper bound, open tables left out
    std::optional<TableBytes> openTables_;  ///< Plan::openTables
    bool areLeastTablesRefuted_ = false;    ///< they missed a limit of theirs
    bool mayShrink_ = true;                 ///< otherBytes_ was not corrected downwards yet
    std::map<std::string, std::string> chosen_;  ///< by the last choose(), as are those below
    std::set<std::string> unlimited_;
    std::vector<AllocationPoint> frontier_;
    std::size_t chosenPoint_ = 0;
    std::optional<int> tableViews_;
};

/// Returns the light map whose layout an asset waits for; for another asset its own name.
const std::string& lightMapOf(const Plan& plan, const std::string& asset);

/// Returns the frontier of the last choose() for the report. Empty without a budget.
std::vector<FrontierPoint> frontierOf(const LayoutDecision& decision);
/// Returns notes for the report by light map: the visible error of the whole shading. Empty without a budget.
std::map<std::string, Json> wholeVisibleNotes(const LayoutDecision& decision);

}  // namespace lightcook::pipeline
