// The job of `lightcook lint`: the checks of plausibility alone, from the cache where the inputs have not changed.
#include "pipeline/lint/lint.h"
#include "pipeline/assets/asset_kind.h"
#include "pipeline/cook/action_functions.h"
#include "pipeline/cook/cook.h"
#include "pipeline/cook/plan.h"
#include "pipeline/graph/cache.h"
#include "pipeline/graph/executor.h"
#include "pipeline/graph/files.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

formats::Result<void> lint(const Scene& scene, const LintOptions& options, const RunState& state, Outcome& outcome) {
    if (const std::string why = whyNothing(scene); !why.empty())
        return formats::failure(formats::ErrorCode::InvalidRequest, scene.file, why);
    LC_TRY(folder, cacheFolder(options.cache));
    LC_TRY(staging, TemporaryFolder::create());
    const Cache cache(*folder, kCacheLimitBytes);
    DigestMemo digests(cache.root() / "stamps" / digestOfText("lint " + std::filesystem::absolute(scene.file).string()));
    std::vector<Action> graph = planNeeds(scene);
    for (Action& action : planLint(scene, options.repair)) graph.push_back(std::move(action));
    ExecutionResult facts = execute(graph, {.outputFolder = staging->path() / "none", .force = false, .keepGoing = true}, staging->path(),
                                    {actionFunction, cache, digests, state});
    digests.save();
    outcome.errors = facts.errors;
    outcome.actionsRun = facts.actionsRun;
    outcome.actionsReused = facts.actionsReused;
    if (state.interrupted) return {};
    LC_TRY(findings, judgeScene(scene, facts.records, options.strict));
    outcome.isLinted = true;
    outcome.findings = std::move(*findings);
    for (formats::Error& error : errorsOf(outcome.findings)) outcome.errors.push_back(std::move(error));
    outcome.report = toJson(LintReport{scene.name, outcome.errors.empty(), readingsOf(scene, facts.records), outcome.findings});
    return {};
}

}  // namespace

Outcome lintScene(const Scene& scene, const LintOptions& options, const RunState& state) {
    Outcome outcome;
    if (auto done = lint(scene, options, state, outcome); !done) outcome.errors.push_back(done.error());
    return outcome;
}

Outcome lintScene(const LintOptions& options, const RunState& state) {
    const auto scene = readScene(options.scene);
    return scene ? lintScene(*scene, options, state) : outcomeOf(scene.error());
}

}  // namespace lightcook::pipeline
