// lightcook cook: a whole scene.
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <memory>
#include <utility>

#include "pipeline/command/command.h"
#include "pipeline/command/key_options.h"
#include "pipeline/command/launcher_option.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/remote.h"
#include "pipeline/command/session.h"
#include "pipeline/cook/cook.h"
#include "pipeline/cook/depfile.h"
#include "pipeline/cook/preview.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/history.h"
#include "pipeline/report/report.h"
#include "pipeline/report/words.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {

namespace {

/// The command line of `cook`.
struct CookCommand {
    CookOptions cook;
    CiOutputs files;
    std::optional<int> samples;
    std::filesystem::path history, trace;
    RemoteOptions remote;
    std::string launcher;
    bool explain = false;
};

void addCookOptions(CLI::App& app, CookCommand& command) {
    CookOptions& cook = command.cook;
    addFileOption(app, "scene", cook.scene, "The scene file (scene.toml)")->required();
    declareWritten(addFolderOption(app, "-o,--output", cook.output, "Output folder; default: <scene name>.cooked"), Written::Folder);
    addOutputOptions(app, cook.given);
    declareWritten(app.add_option("--depfile", cook.depfile, "Write the inputs as a Makefile rule")->type_name(kFilePlaceholder),
                   Written::File);
    CLI::Option* only = app.add_option("--only", cook.only, "Cook this asset and those that derive from it; leave the others as they are");
    only->type_name("NAME");
    addCacheOption(app, cook.cache);
    command.remote.add(app);
    app.add_option("--launcher", command.launcher,
                   "Run what takes long on other machines: put this before a command of one action, {memory} in MiB and {time} in minutes")
        ->type_name("COMMAND");
    addSamplesOption(app, command.samples);
    app.add_flag(
           "--keep-candidates", cook.keepCandidates,
           "Also cook the scene with each other layout that was tried and may be worth its bytes, into DIR/candidates: view shows them "
           "beside each other")
        ->excludes(only);
    CLI::Option* const preview = app.add_flag(
        "--preview", cook.preview,
        "Cook as fast as the light can be seen: effort 0, the layouts of the last cook into the folder or else a fast one, no limits, no "
        "report, and errors of some rows of light maps alone. verify refuses the folder");
    CLI::Option* const patch = app.add_flag(
        "--patch", cook.patch,
        "After a bake of few charts: keep layouts, ranges and learned tables of the last cook into the folder while they serve, so that "
        "strips of light maps that did not change keep their bytes and come from the cache");
    app.add_flag("--force", cook.force, "Cook everything again");
    app.add_flag("--keep-going", cook.keepGoing, "Cook the other assets after a failure; the exit code is the first failure's");
    addStrictOption(app, cook.strict);
    addRepairOption(app, cook.repair);
    app.add_flag(
        "--explain", command.explain,
        "Print for each action why it runs or does not: which input, parameter or result differs from the last cook into the folder");
    declareWritten(addFileOption(app, "--trace", command.trace,
                                 "Write when each action and each exchange with the remote cache ran, for ui.perfetto.dev (Chrome's trace "
                                 "events)"),
                   Written::File);
    command.files.add(app);
    declareWritten(
        addFileOption(app, "--history", command.history, "Append a line with the memory and the errors of the scene (JSON lines)"),
        Written::File);
    for (const char* other : {"--only", "--keep-candidates", "--strict", "--junit", "--sarif", "--history", "--effort"})
        preview->excludes(app.get_option(other));
    app.get_option("--targets")->excludes(app.get_option("--target"));
    for (const char* other : {"--only", "--keep-candidates", "--preview", "--force"}) patch->excludes(app.get_option(other));
}

/// Prints what a preview found.
void printPreview(Session& session, const Outcome& outcome) {
    const auto summary = fromJson<PreviewSummary>(outcome.report, "preview");
    if (!summary || session.terminal.verbosity() == Verbosity::Quiet) return;
    for (const PreviewedMap& map : summary->lightMaps) {
        const verify::StageError& total = map.errors.total;
        session.terminal.say(fmt::format("{} ({}): rel_rms {}, visible error {:.1f}, in {} of {} rows", map.name, map.layout,
                                         humanPercent(std::max(total.diffuse.relRms, total.specular.relRms)), visibleP99(total).value_or(0),
                                         map.errors.rows, map.errors.rowsOfMap));
    }
    session.terminal.say(fmt::format("preview of {} in {:.1f} s, {} of GPU memory, in {}: not verified, no release", summary->scene,
                                     summary->seconds, sizeWords(summary->bytesGpu), outcome.output.string()));
}

/// Prints why an action ran or did not.
void explain(Terminal& terminal, const Action& action, bool hasRun, const std::string& why) {
    if (terminal.format() == LogFormat::Text)
        return terminal.detail(fmt::format("lightcook: {} {}: {}", action.id, hasRun ? "runs" : "does not run", why));
    const Json line = {{"level", "explain"}, {"action", action.id}, {"asset", action.asset}, {"runs", hasRun}, {"why", why}};
    terminal.jsonDetail(line.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// Returns the lines of --history.
std::vector<HistoryLine> historyOf(const std::vector<Outcome>& outcomes) {
    std::vector<HistoryLine> lines;
    for (const Outcome& outcome : outcomes) {
        const auto manifest = loadManifest(outcome.output);
        if (const auto report = fromJson<Report>(outcome.report, kReportName))
            lines.push_back(historyLine(*report, manifest ? manifest->target : ""));
    }
    return lines;
}

/// Runs the command. Returns the exit code.
int runCook(Session& session, CookCommand& command) {
    for (const auto& [option, file] : {std::pair("--depfile", command.cook.depfile.value_or("")), std::pair("--history", command.history),
                                       std::pair("--trace", command.trace)})
        if (auto checked = checkIsFile(option, file); !checked) return session.finish(checked);
    if (command.samples) command.cook.samples = *command.samples;
    if (auto ready = command.files.prepare(session); !ready) return session.finish(ready);
    auto scenes = readScenes(command.cook.scene, command.cook.given);
    if (scenes)
        for (const Scene& scene : *scenes)
            if (auto checked = session.paths.checkAgainstScene(scene, cookedFolder(scene, command.cook.output)); !checked)
                return session.finish(checked);
    // A file that is no history is refused before the cook.
    if (!command.history.empty())
        if (const auto history = readHistory(command.history); !history) return session.finish(history);
    // Quiet cooks are those of `plan`, whose depfiles Make does not read.
    if (scenes && command.cook.depfile && session.terminal.verbosity() != Verbosity::Quiet)
        if (const auto warning = warningForMake(scenes->front(), cookedFolder(scenes->front(), command.cook.output)))
            session.terminal.warning(warning->subject, warning->detail);
    Trace trace;
    if (!command.trace.empty()) command.cook.trace = &trace;
    if (command.explain)
        command.cook.explain = [&session](const Action& action, bool hasRun, const std::string& why) {
            explain(session.terminal, action, hasRun, why);
        };
    if (auto checked = checkLauncher(command.launcher); !checked) return session.finish(checked);
    auto remote = command.remote.open(command.cook.cache, command.cook.trace, !command.launcher.empty());
    if (!remote) return session.finish(remote);
    command.cook.remote = remote->get();
    if (!command.launcher.empty()) {
        const auto cache = cacheFolder(command.cook.cache);
        if (!cache) return session.finish(cache);
        const std::vector<std::string> folder = {"--cache", std::filesystem::absolute(*cache).string()};
        auto launch = launchOptionsOf(command.launcher, *remote != nullptr ? command.remote.words() : folder);
        if (!launch) return session.finish(launch);
        command.cook.launch = std::move(*launch);
    }
    std::vector<Outcome> outcomes =
        scenes ? cookScenes(std::move(*scenes), command.cook, session.state) : std::vector<Outcome>{outcomeOf(scenes.error())};
    if (*remote != nullptr) {
        outcomes.back().remote = (*remote)->finish();
        command.remote.warn(session.terminal, *outcomes.back().remote);
    }
    std::vector<formats::Error> errors = command.files.write(session, "cook", outcomes, command.cook.scene, {});
    if (!command.history.empty())
        if (const std::vector<HistoryLine> lines = historyOf(outcomes); !lines.empty())
            if (const auto history = appendHistory(command.history, lines); !history) errors.push_back(history.error());
    if (!command.trace.empty())
        if (const auto written = session.write(command.trace, trace.document().dump(-1, ' ', false, Json::error_handler_t::replace));
            !written)
            errors.push_back(written.error());
    if (outcomes.size() == 1) outcomes.front().errors = errors;
    keepFindingsOnce(outcomes);
    for (const Outcome& outcome : outcomes) {
        if (!outcome.whyNotPatched.empty())
            session.terminal.note("--patch", fmt::format("nothing of the last cook is kept: {}", outcome.whyNotPatched));
        if (command.cook.preview)
            printPreview(session, outcome);
        else
            printCook(session, outcome);
        if (!command.cook.preview && outcome.report.is_object() && session.terminal.isInteractive() &&
            session.terminal.verbosity() != Verbosity::Quiet)
            session.terminal.say(fmt::format("the report is {}; next: lightcook view {}", (outcome.output / kReportHtmlName).string(),
                                             outcome.output.string()));
    }
    return session.finish(errors);
}

}  // namespace

CommandFunction defineCook(CLI::App& app) {
    const auto command = std::make_shared<CookCommand>();
    addCookOptions(app, *command);
    app.footer(R"(Each key of [output] is an option, whose default is what the scene file says. It goes before the file, and
before what targets, light maps, probes, gradients and tables of the file have of their own.

With targets, each is cooked into DIR/TARGET, one after another; they share what does not depend on the
target. One that is over a limit or the budget does not keep the next from being cooked, and the exit code is
that of the first failure. --target cooks one alone, into DIR.

An action (one step: cooks or verifies an asset, tries layouts, packs charts) is identified by a
digest of the content of its inputs, its parameters and lightcook's own sources. Results of earlier
actions are taken from the cache, which holds at most 4 GiB and drops the least recently used first.
If nothing changed, a cook opens no image and does not touch the outputs.

--depfile writes the inputs as a Makefile rule whose target is DIR/cooked.json. Give a build system
cooked.json as the output: with restat = 1 in Ninja, because an unchanged cook does not touch the
file; in Make, end the recipe with touch $@.

A bad input (missing, truncated, of the wrong shape, not finite, negative energy) ends with exit code
3 and a line that names file and place, and nothing is written. --repair replaces bad values and
counts them in the report. In light maps it also repairs SH bands that are too long for their mean,
and fireflies.

--keep-candidates keeps those of the tried layouts that no other beats in bytes and error. Each is a
cooked folder, DIR/candidates/LAYOUT, whose report says whether it keeps the limits. A cook without
the option removes them, but no other file there.

With --launcher, each action that is predicted to take 10 s or more is a command `COMMAND lightcook work
JOB`, which may run on another machine. Machines need the same lightcook under the same path, and a
remote cache that they may write; without one, all have to see the files of the scene, the output folder
and the cache folder. Up to -j actions are launched at once. An action is done when the cache has its
record and its outputs; until then it is launched again, five times in all.

--preview is for the time between a bake and a first look. Its manifest says that it is a preview, and a
later cook without the option replaces it. --json then writes what a preview found, which is no report.

--rdo applies to every BC texture. The verifier's bounds include what it changes.

The last line has the verdict, the sizes, and how many actions came from the cache; with --log json it
is an object on standard error. --quiet leaves it out. -v prints a line for each action.)");
    return [command](Session& session) { return runCook(session, *command); };
}

}  // namespace lightcook::pipeline
