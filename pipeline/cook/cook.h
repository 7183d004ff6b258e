// The jobs of the command line: cook a scene, verify a cooked folder, write a cooked light map as a bake.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/action.h"
#include "pipeline/graph/key_log.h"
#include "pipeline/graph/launcher.h"
#include "pipeline/graph/remote_cache.h"
#include "pipeline/graph/trace.h"
#include "pipeline/lint/finding.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Options of a cook that no scene has, and the keys that the command line gives over those of the scene file.
struct CookOptions {
    std::filesystem::path scene;
    std::filesystem::path output;  ///< empty: "<scene name>.cooked" in the current folder
    GivenKeys given = {};
    std::optional<std::filesystem::path> depfile;
    std::optional<std::string> only;      ///< a name: see PlanOptions
    std::optional<std::string> onlyKind;  ///< a kind: see PlanOptions
    bool force = false, keepGoing = false, repair = false;
    bool keepCandidates = false;               ///< also cook the scene with the other layouts that were tried: kept_candidates.h
    bool preview = false;                      ///< a preview alone: preview.h
    bool patch = false;                        ///< keep what the last cook into the folder decided and planned: patch.h
    bool strict = false;                       ///< every finding of lint that the scene does not allow is an error
    std::filesystem::path cache;               ///< see cacheFolder()
    int samples = 1;                           ///< random positions per texel quad
    RemoteCache* remote = nullptr;             ///< beside that cache; null: none
    std::optional<LaunchOptions> launch = {};  ///< how actions get to other machines; none: all run here
    Trace* trace = nullptr;                    ///< of actions; null: none
    Explain explain = {};                      ///< why each action runs or does not; may be empty
};

/// Result of a job. The code of the first error is the exit code.
struct Outcome {
    std::vector<formats::Error> errors;
    Json report;                   ///< null without one
    std::filesystem::path output;  ///< folder of the cooked scene
    int actionsRun = 0, actionsReused = 0;
    bool isLinted = false;                     ///< the inputs were looked at
    std::vector<Finding> findings = {};        ///< of lint, also those that are errors or allowed
    std::vector<std::string> candidates = {};  ///< layouts of the candidates that were kept
    std::optional<RemoteCounts> remote = {};   ///< of the remote cache, if there is one
    std::string depfile = {};                  ///< its rule of the dependency file; empty: none was asked for, or the cook came to none
    std::string whyNotPatched = {};            ///< why a cook with CookOptions::patch kept nothing; empty: it did
};

/// Returns the outcome of what could not begin.
inline Outcome outcomeOf(const formats::Error& error) {
    return {{error}, {}, {}, 0, 0};
}

/// Returns true for an error of what was cooked for a target (errors, bounds, budget), which says nothing of other targets.
inline bool isOfTarget(const formats::Error& error) {
    using formats::ErrorCode;
    return error.code == ErrorCode::Verification || error.code == ErrorCode::OverLimit || error.code == ErrorCode::OverBudget;
}

/// Cooks the scene file of the options, of several targets the first.
Outcome cookScene(const CookOptions& options, const RunState& state);
/// Cooks scenes that are targets of one file, one after another, and writes one dependency file. What one target misses (error, budget)
/// does not keep the next from being cooked; other errors do unless options.keepGoing. Does not open the file options.scene.
/// scenes  at least one, which were read with the given keys of the options
/// returns  an outcome for each that was begun
std::vector<Outcome> cookScenes(std::vector<Scene> scenes, const CookOptions& options, const RunState& state);
/// The same of one scene.
Outcome cookScene(Scene scene, const CookOptions& options, const RunState& state);

struct VerifyOptions {
    std::filesystem::path folder;
    std::filesystem::path sources;  ///< the scene's folder; empty: as the manifest says
    std::optional<int> samples;     ///< random positions per texel quad; default: as cooked
    bool strict = false;            ///< see CookOptions
};
/// Verifies a cooked folder again: content digests of every file, then errors and bounds from the bytes. Returns a new report.
Outcome verifyCooked(const VerifyOptions& options, const RunState& state);

struct LintOptions {
    std::filesystem::path scene;
    std::filesystem::path cache;  ///< see cacheFolder()
    bool strict = false, repair = false;
};
/// Checks the inputs of a scene for implausible values, without cooking it. Does not open the file options.scene.
Outcome lintScene(const Scene& scene, const LintOptions& options, const RunState& state);
/// The same of the scene file of the options.
Outcome lintScene(const LintOptions& options, const RunState& state);

/// Writes a cooked light map as the shader decodes it, with the 27 channels of a bake.
/// placesPerTexel  N: at N x N places of each texel, from filtered texels (verify::LightMapVerifier::reconstruct)
formats::Result<void> reconstructLightMap(const std::filesystem::path& folder, const std::string& name, const std::filesystem::path& output,
                                          int placesPerTexel, const RunState& state);
inline constexpr int kMostPlacesPerTexel = 16;

}  // namespace lightcook::pipeline
