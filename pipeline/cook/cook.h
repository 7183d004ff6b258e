// Cook a scene, verify a cooked one, give a light map back: what the command line calls.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/action.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// What the command line lays over the scene file.
struct CookOptions {
    std::filesystem::path scene;
    std::filesystem::path output;  ///< empty: "<scene name>.cooked" in the current folder
    std::optional<Target> target;
    std::optional<double> maxError;
    std::optional<std::uint64_t> budgetBytes;
    std::optional<std::string> lightMapLayout;
    std::optional<formats::Container> container;
    std::optional<bool> zstd;
    std::optional<int> effort;
    std::optional<double> rdo;
    std::optional<std::filesystem::path> depfile;
    std::optional<std::string> only;      ///< a name: see PlanOptions
    std::optional<std::string> onlyKind;  ///< a kind: see PlanOptions
    bool force = false, keepGoing = false, repair = false;
    std::filesystem::path cache;  ///< empty: defaultCacheFolder()
    int samples = 1;              ///< random positions per texel quad
};

/// How a command ended. Errors in the order in which they count: the first one's code is the exit code.
struct Outcome {
    std::vector<formats::Error> errors;
    Json report;                   ///< null if there is none
    std::filesystem::path output;  ///< where it lies
    int actionsRun = 0, actionsReused = 0;
};

Outcome cookScene(const CookOptions& options, const RunState& state);
/// The same for a scene that was put together in memory: what the single converters do. options.scene is not read.
Outcome cookScene(Scene scene, const CookOptions& options, const RunState& state);

struct VerifyOptions {
    std::filesystem::path folder;
    std::filesystem::path sources;  ///< the scene's folder; empty: as the manifest says
    std::optional<int> samples;     ///< random positions per texel quad; default: as cooked
};
/// Reopens what was cooked: content digests of every file, then errors and bounds from the bytes. The report is a fresh one of the same
/// form.
Outcome verifyCooked(const VerifyOptions& options, const RunState& state);

/// Writes a cooked light map as the shader sees it: the bake's 27 channels.
formats::Result<void> reconstructLightMap(const std::filesystem::path& folder, const std::string& name, const std::filesystem::path& output,
                                          const RunState& state);

}  // namespace lightcook::pipeline
