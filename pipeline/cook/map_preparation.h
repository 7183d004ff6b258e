// The step of a cook between the materials and the plan: charts of light maps are packed anew, or split between maps. What comes after
// it takes the packed bakes and meshes as if the user had named them.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "pipeline/assets/needs.h"
#include "pipeline/cook/plan.h"
#include "pipeline/cook/split_maps.h"
#include "pipeline/graph/executor.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

class MapPreparation {
public:
    /// Runs the actions of a graph, whose files go to a folder; an empty path: they make none.
    using Run = std::function<ExecutionResult(const std::vector<Action>& graph, const std::filesystem::path& folder)>;

    /// options  get the packed light maps and the splits; those of a cook that is planned again have the splits
    /// folder   for packed bakes and meshes, which no output has
    MapPreparation(PlanOptions& options, bool keepGoing, const RunState& state, std::filesystem::path folder, Run run)
        : options_(options), keepGoing_(keepGoing), state_(state), folder_(std::move(folder)), run_(std::move(run)) {}

    /// Returns the scene with repacked bakes and meshes in place of the user's; a light map whose charts could not be packed is not in it.
    /// scene  gets two light maps in place of each that is split
    formats::Result<Scene> prepare(Scene& scene, const Needs& needs);

    /// Return the packing of every light map, and the errors and counts of all actions.
    const std::vector<Action>& graph() const { return graph_; }
    const ExecutionResult& result() const { return result_; }
    /// Returns notes for the report, by light map.
    const std::map<std::string, Json>& notes() const { return notes_; }

private:
    ExecutionResult run(const std::vector<Action>& graph, const std::filesystem::path& folder = {});
    bool isStopped() const { return isEndedBy(result_.errors, keepGoing_, state_); }
    std::vector<Action> packActions(const Scene& scene) const;
    formats::Result<Scene> pack(const Scene& scene, const std::vector<Action>& graph, const std::filesystem::path& folder);
    formats::Result<Needs> withContents(const Scene& packed, Needs needs);
    formats::Result<void> split(Scene& scene, const Needs& needs);
    formats::Result<void> trySplits(Scene& scene, const Scene& maps, const LightMapEntry& entry, const SplitResult& found,
                                    const Needs& needs);
    formats::Result<std::optional<std::uint64_t>> bytesOfParts(const Scene& parts, const Needs& needs);

    PlanOptions& options_;
    bool keepGoing_;
    const RunState& state_;
    std::filesystem::path folder_;
    Run run_;
    std::vector<Action> graph_;
    ExecutionResult result_;  ///< of all actions, without their records
    std::map<std::string, Json> notes_;
};

}  // namespace lightcook::pipeline
