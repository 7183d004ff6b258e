#include "pipeline/cook/cook.h"
#include "pipeline/cook/action_functions.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <set>

#include "formats/foreign_files.h"
#include "formats/light_map_layout.h"
#include "formats/process.h"
#include "formats/temporaries.h"
#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/asset_kind.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/needs.h"
#include "pipeline/assets/results.h"
#include "pipeline/cook/contents.h"
#include "pipeline/cook/depfile.h"
#include "pipeline/cook/kept_candidates.h"
#include "pipeline/cook/layout_decision.h"
#include "pipeline/cook/map_preparation.h"
#include "pipeline/cook/patch.h"
#include "pipeline/cook/plan.h"
#include "pipeline/cook/preview.h"
#include "pipeline/cook/summary.h"
#include "pipeline/cook/trial_actions.h"
#include "pipeline/cook/verdicts.h"
#include "pipeline/graph/cache.h"
#include "pipeline/graph/executor.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/shared_objects.h"
#include "pipeline/graph/work_rates.h"
#include "pipeline/lint/lint.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"
#include "pipeline/scene/named_files.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;
using formats::failure;
using formats::Result;
using Clock = std::chrono::steady_clock;

/// Refuses scenes without anything to cook, and what cannot be written.
Result<void> checkScene(const Scene& scene, const std::filesystem::path& folder) {
    if (const std::string why = whyNothing(scene); !why.empty()) return failure(ErrorCode::InvalidRequest, scene.file, why);
    std::error_code code;
    if (std::filesystem::exists(folder, code) && !std::filesystem::is_directory(folder, code))
        return failure(ErrorCode::InvalidRequest, folder, "found a file, expected a folder or nothing");
    if (scene.isOfTargets && std::filesystem::exists(folder.parent_path() / kManifestName, code))
        return failure(ErrorCode::InvalidRequest, folder.parent_path(),
                       "found the cooked scene of one target, expected a folder for those of several: remove its files, or name another");
    return {};
}

/// One cook, from scene file to published folder: materials, needs, plan, actions, layouts that are still open, summaries.
class Cook {
public:
    /// layouts  of the light maps and dominant lights that the scene leaves open; those that are not here are tried
    Cook(Scene scene, const CookOptions& options, const RunState& state, std::map<std::string, std::string> layouts = {})
        : options_(options),
          state_(state),
          start_(Clock::now()),
          scene_(options.preview ? previewOf(std::move(scene)) : std::move(scene)),
          cache_(options.cache, kCacheLimitBytes),
          planOptions_{options.only, options.onlyKind, options.repair, options.samples, {std::move(layouts)}} {
        planOptions_.areTrialsComplete = options.keepCandidates;
    }

    Outcome run() {
        if (auto done = tryRun(); !done) outcome_.errors.insert(outcome_.errors.begin(), done.error());
        for (Error& error : outcome_.errors) blameSystem(error);
        return std::move(outcome_);
    }

private:
    /// A file that the cook itself made and cannot read is no fault of an input. The user knows it by its name in the output folder.
    void blameSystem(Error& error) const {
        const std::string made = staging_.string();
        if (made.empty() || !error.file.string().starts_with(made)) return;
        if (error.code == ErrorCode::FileUnreadable) error.code = ErrorCode::Internal;
        error.file = outcome_.output / error.file.lexically_relative(staging_);
        if (error.subject.starts_with(made)) error.subject = outcome_.output.string() + error.subject.substr(made.size());
    }

    Result<void> tryRun() {
        outcome_.output = cookedFolder(scene_, options_.output);
        LC_TRY(cache, cacheFolder(options_.cache));
        cache_ = Cache(*cache, kCacheLimitBytes);
        LC_CHECK(checkScene(scene_, outcome_.output));
        const std::filesystem::path absolute = std::filesystem::absolute(outcome_.output).lexically_normal();
        digests_.emplace(cache_.root() / "stamps" / digestOfText(absolute.string()));
        keys_.emplace(cache_.root() / "keys" / digestOfText(absolute.string()), options_.explain);
        if (options_.launch) launcher_.emplace(*options_.launch, cache_, options_.remote, options_.trace);
        // Inside the output, so that finished files are renamed. A folder that is made for it goes with it unless the cook leaves files.
        auto staging = TemporaryFolder::create(absolute);
        // A read-only folder is no fault of a cook that has nothing to write: an action that is not up to date fails with this error.
        std::error_code code;
        if (!staging && staging.error().code == ErrorCode::Internal && std::filesystem::exists(absolute / kManifestName, code)) {
            unwritable_ = staging.error();
            staging = TemporaryFolder::create();
        }
        if (!staging) return tl::make_unexpected(staging.error());
        staging_ = staging->path();
        auto done = cookAndPublish();
        digests_->save();
        keys_->save();
        if (launcher_) launcher_->save();
        return done;
    }

    Result<void> cookAndPublish() {
        const std::vector<Action> needsGraph = planNeeds(scene_);
        const ExecutionResult materials = execute(needsGraph);
        addErrors(materials);
        if (isStopped(materials)) return {};
        LC_TRY(known, needsOf(materials));
        Needs needs = std::move(*known);
        LC_TRY(prepared, packCharts());
        if (isStopped()) return {};
        const Scene& planned = *prepared;
        const std::vector<Action> contentGraph = planContents(planned, needs, planOptions_);
        const ExecutionResult contents = execute(contentGraph);
        addErrors(contents);
        if (isStopped(contents)) return {};
        LC_CHECK(addContents(contents, needs));
        if (options_.preview) return preview(planned, needs, needsGraph, contentGraph);
        LC_TRY(floors, errorsOfFloors(planned, contents));
        outcome_.errors.insert(outcome_.errors.end(), floors->begin(), floors->end());
        if (isStopped()) return {};
        if (options_.patch) keepDecisions();
        LC_TRY(plan, planScene(planned, needs, planOptions_));
        LC_CHECK(checkOptions(*plan));
        LC_CHECK(lint(*plan, materials));
        if (isStopped()) return {};
        announceUndecided(*plan, planned, needs);
        ExecutionResult result = execute(plan->actions);
        if (isPatched() && !state_.interrupted) {
            outcome_.whyNotPatched = whyRefuted(scene_, *plan, result);
            if (!isPatched()) {
                planOptions_.decisions = {};
                LC_TRY(whole, planScene(planned, needs, planOptions_));
                plan = std::move(*whole);
                announceUndecided(*plan, planned, needs);
                result = execute(plan->actions);
            }
        }
        if (!plan->undecided.empty() && !isStopped(result)) {
            LC_TRY(decided, decideLayouts(*plan, planned, needs, materials, result));
            plan = std::move(*decided);
        }
        if (plan->openTables && !isStopped(result)) {
            LC_TRY(decided, decideTables(*plan, planned, needs, result));
            plan = std::move(*decided);
        }
        outcome_.actionsRun += materials.actionsRun + result.actionsRun;
        outcome_.actionsReused += materials.actionsReused + result.actionsReused;
        addErrors(result);
        if (isStopped(result)) return {};
        shared_.reset();
        if (options_.only) sceneAssets_ = assetsOfScene(*plan, planned, needs);
        LC_TRY(report, publishWithSummaries(*plan, needs, result));
        LC_CHECK(cookAlternatives());
        if (options_.depfile) LC_CHECK(setDepfile(*plan, needsGraph, contentGraph, planned, needs));
        cache_.prune();
        const GivenKey* const budget = options_.given.find("output.budget");
        appendErrorsOf(
            *report,
            budget != nullptr ? formats::Subject(budget->option) : placeIn(scene_, "output", "", "budget", "[output]").at("budget"),
            outcome_.errors);
        return {};
    }

    /// Takes over the decisions of the last cook into the folder, if they may serve.
    void keepDecisions() {
        auto kept = keptDecisions(scene_, planOptions_, outcome_.output, PartCache(cache_.root(), options_.force), *digests_);
        if (kept)
            planOptions_.decisions = std::move(*kept);
        else
            outcome_.whyNotPatched = kept.error().line();
    }
    bool isPatched() const { return options_.patch && outcome_.whyNotPatched.empty(); }

    /// Cooks and publishes a preview of a scene whose contents are known. Layouts are those of the last cook into the folder.
    Result<void> preview(const Scene& planned, const Needs& needs, const std::vector<Action>& needsGraph,
                         const std::vector<Action>& contentGraph) {
        planOptions_.decisions = decisionsIn(outcome_.output, scene_);
        LC_TRY(plan, planScene(planned, needs, planOptions_));
        if (!plan->undecided.empty()) {
            for (const LightMapEntry& entry : planned.lightMaps)
                if (std::ranges::count(plan->undecided, entry.name) > 0)
                    planOptions_.decisions.layouts[entry.name] = previewLayoutOf(planned, entry);
            LC_TRY(decided, planScene(planned, needs, planOptions_));
            plan = std::move(*decided);
        }
        const ExecutionResult result = execute(previewActionsOf(*plan));
        outcome_.actionsRun += result.actionsRun;
        outcome_.actionsReused += result.actionsReused;
        addErrors(result);
        if (isStopped(result) || !outcome_.errors.empty()) return {};
        shared_.reset();
        warnOfOtherScene();
        LC_TRY(transaction, formats::OutputTransaction::begin());
        LC_CHECK(checkOutputs(result));
        SummaryWriter writer(scene_, outcome_.output, false, *digests_);
        writer.setCook({scene_.document, plan->wanted, options_.repair, options_.samples, needs, planOptions_.decisions});
        LC_CHECK(writer.preparePreview(*plan, result));
        LC_CHECK(publish(result, staging_, outcome_.output));
        LC_CHECK(writer.commit());
        const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
        LC_TRY(summary, previewSummary(scene_, *plan, result, seconds));
        outcome_.report = toJson(*summary);
        if (options_.depfile) LC_CHECK(setDepfile(*plan, needsGraph, contentGraph, planned, needs));
        cache_.prune();
        return {};
    }

    /// Returns the folder of repacked bakes and meshes, which no output has.
    std::filesystem::path packedFolder() const { return staging_ / "charts"; }

    /// earlier  results that dependencies may be of
    ExecutionResult execute(const std::vector<Action>& graph, std::vector<const ExecutionResult*> earlier = {}) {
        ExecutionContext context = executionContext();
        context.earlier = std::move(earlier);
        return pipeline::execute(graph, {outcome_.output, options_.force, options_.keepGoing, unwritable_}, staging_, context);
    }
    ExecutionContext executionContext() {
        return {actionFunction, cache_,  *digests_,       state_,         at_,
                shared_.get(),  &*keys_, options_.remote, options_.trace, launcher_ ? &*launcher_ : nullptr};
    }

    /// Leaves the files of the actions in a folder.
    ExecutionResult executeInto(const std::filesystem::path& folder, const std::vector<Action>& graph) {
        return pipeline::execute(graph, {folder, options_.force, options_.keepGoing}, folder, executionContext());
    }

    /// Looks at the inputs of the planned assets. Its actions do not count as run or reused: they make nothing.
    Result<void> lint(const Plan& plan, const ExecutionResult& materials) {
        std::set<std::string> assets(plan.assets.begin(), plan.assets.end());
        assets.insert(plan.undecided.begin(), plan.undecided.end());
        linted_ = inputsOf(scene_, std::move(assets));
        ExecutionResult facts = execute(planLint(scene_, options_.repair, linted_));
        addErrors(facts);
        facts.records.insert(materials.records.begin(), materials.records.end());
        LC_TRY(findings, judgeScene(scene_, facts.records, options_.strict));
        outcome_.isLinted = true;
        outcome_.findings = std::move(*findings);
        for (Error& error : errorsOf(outcome_.findings)) outcome_.errors.push_back(std::move(error));
        return {};
    }

    /// Packs the charts of the light maps that ask for it, and returns the scene with the new maps.
    Result<Scene> packCharts() {
        const auto runInto = [this](const auto& graph, const auto& folder) { return executeInto(folder, graph); };
        LC_TRY(prepared, prepareMaps(scene_, planOptions_, packedFolder(), runInto));
        packGraph_ = std::move(prepared->graph);
        addErrors(prepared->result);
        outcome_.actionsRun += prepared->result.actionsRun;
        outcome_.actionsReused += prepared->result.actionsReused;
        return std::move(prepared->scene);
    }

    /// Refuses options that the plan shows to be impossible.
    Result<void> checkOptions(const Plan& plan) const {
        if (const std::string why = options_.only ? whyNotLeft(scene_, plan, outcome_.output) : ""; !why.empty())
            return failure(ErrorCode::InvalidRequest, "--only", why);
        if (!options_.keepCandidates || !plan.undecided.empty()) return {};
        return failure(ErrorCode::InvalidRequest, "--keep-candidates",
                       layoutAsked(scene_.output) == kAutoLayout
                           ? "found no light map whose layout is tried, expected at least one that leaves a choice"
                           : "found no light map whose layout is tried, expected --layout auto with a limit (--max-visible, "
                             "--max-error) or a budget");
    }

    bool isStopped() const { return isEndedBy(outcome_.errors, options_.keepGoing, state_); }
    bool isStopped(const ExecutionResult& result) const { return isEndedBy(result.errors, options_.keepGoing, state_); }

    /// Returns the needs of the materials. Meshes that could not be read count as unknown.
    Result<Needs> needsOf(const ExecutionResult& materials) const {
        std::vector<MaterialRecord> all;
        for (const auto& [id, record] : materials.records) {
            LC_TRY(ofMesh, fromJson<MaterialsResult>(record.result, id));
            all.insert(all.end(), ofMesh->materials.begin(), ofMesh->materials.end());
        }
        return resolveNeeds(scene_, all);
    }

    /// Announces the actions of maps whose layout is open as those of one layout, so that the progress counts them from the start.
    void announceUndecided(const Plan& open, const Scene& planned, const Needs& needs) const {
        if (!state_.event) return;
        PlanOptions options = planOptions_;
        for (const std::string& map : open.undecided) options.decisions.layouts[map] = formats::info(formats::LightMapLayout::Ratio).name;
        const auto plan = planScene(planned, needs, options);
        if (!plan) return;
        for (const Action& action : plan->actions) state_.event(action, ActionEvent::Planned, 0);
    }

    /// Chooses the layouts that were left open, cooks and verifies these maps and their meshes, and adds that to `result`. Repeats with the
    /// next better candidate where a verification misses the error of a trial. Returns the plan of the whole scene.
    Result<Plan> decideLayouts(const Plan& open, const Scene& planned, const Needs& needs, const ExecutionResult& materials,
                               ExecutionResult& result) {
        LC_TRY(decision, LayoutDecision::create(scene_, open, result, materials));
        while (true) {
            LC_CHECK(completeTrials(open, *decision, result));
            if (isStopped(result)) return open;
            planOptions_.decisions.layouts = decision->choose();
            planOptions_.decisions.unlimited = decision->unlimited();
            planOptions_.decisions.tableViews = decision->tableViews();
            LC_TRY(plan, planScene(planned, needs, planOptions_));
            ExecutionResult chosen;
            bool isRefuted = false;
            for (const std::vector<Action>& part : partsOf(actionsOf(*plan, result))) {
                chosen.add(execute(part, {&result, &chosen}));
                LC_TRY(isWrong, decision->learnFrom(*plan, result, chosen));
                isRefuted = *isWrong && !isStopped(chosen);
                if (isRefuted || isStopped(chosen)) break;
            }
            for (const auto& [id, record] : result.records) chosen.reused.erase(id);  // it ran before in this cook
            if (isRefuted) continue;
            result.add(std::move(chosen));
            if (options_.keepCandidates) alternatives_ = decision->alternatives();
            notes_ = wholeVisibleNotes(*decision);
            seams_ = decision->seams();
            frontier_ = frontierOf(*decision);
            return plan;
        }
    }

    /// Returns actions in the order in which they can refute the layouts. What pixels show of the whole is measured in a tenth of the time
    /// of a verification: where it decides, it comes first.
    std::vector<std::vector<Action>> partsOf(std::vector<Action> actions) const {
        if (!scene_.output.isChosenByWhole()) return {std::move(actions)};
        const auto isFirst = [](const Action& each) { return isOfStep(each.id, ActionStep::Cook) || isOfStep(each.id, ActionStep::Whole); };
        const auto rest = std::stable_partition(actions.begin(), actions.end(), isFirst);
        return {{actions.begin(), rest}, {rest, actions.end()}};
    }

    /// Tries the other layouts of maps that none of those that were tried is left for.
    Result<void> completeTrials(const Plan& open, LayoutDecision& decision, ExecutionResult& result) {
        for (const std::string& map : decision.mapsToTry()) {
            const std::string id = actionId(ActionStep::Trial, map);
            ExecutionResult complete = execute({completeTrial(*std::ranges::find(open.actions, id, &Action::id))});
            decision.setTried(map);
            if (const auto record = complete.records.find(id); record != complete.records.end()) {
                LC_CHECK(decision.addTrial(map, record->second));
                result.records.insert_or_assign(id, record->second);
            }
            result.add(std::move(complete));
            if (isStopped(result)) return {};
        }
        return {};
    }

    /// Chooses the views of tables by what the other assets, which no frontier trades, leave of the budget; cooks and verifies the tables,
    /// and adds that to `result`. Returns the plan of the whole scene.
    Result<Plan> decideTables(const Plan& open, const Scene& planned, const Needs& needs, ExecutionResult& result) {
        AllocationPoint others;
        for (const std::string& name : open.assets) {
            const auto record = result.records.find(actionId(ActionStep::Cook, name));
            if (record == result.records.end()) continue;
            LC_TRY(cooked, fromJson<CookResult>(record->second.result, record->first));
            others.bytes += cooked->asset.totalBytesGpu();
        }
        const bool areFine = choiceWithin({others}, *open.openTables, *scene_.output.budgetBytes, 0).areTablesFine;
        planOptions_.decisions.tableViews = areFine ? kFineViewCount : kLeastViewCount;
        auto plan = planScene(planned, needs, planOptions_);
        if (plan) result.add(execute(actionsOf(*plan, result)));
        return plan;
    }

    /// Cooks the alternatives of the layouts into folders of their own, and removes those of an earlier cook. An alternative may miss the
    /// limits of the scene: its own report says so.
    Result<void> cookAlternatives() {
        if (options_.only) return {};
        for (const auto& [layout, layouts] : alternatives_) {
            CookOptions options = options_;
            options.output = candidateFolder(outcome_.output, layout);
            options.keepCandidates = false;
            options.depfile = {};
            LC_CHECK(makeFoldersOf(outcome_.output, candidateFolder({}, layout) / kManifestName));
            Json document = scene_.document;
            Json& output = document["output"];
            output["light_map_layout"] = layoutAsked(scene_.output);  // as the limits had it
            for (const char* whole : {"budget", "max_whole_visible", "max_whole_error"}) output.erase(whole);
            LC_TRY(scene, readSceneDocument(document, scene_.directory));
            scene->file = scene_.file;
            scene->lines = scene_.lines;
            const Outcome done = Cook(std::move(*scene), options, state_, layouts).run();
            outcome_.actionsRun += done.actionsRun;
            outcome_.actionsReused += done.actionsReused;
            const auto isFault = [](const Error& error) {
                return error.code != ErrorCode::OverLimit && error.code != ErrorCode::Verification;
            };
            if (const auto fault = std::ranges::find_if(done.errors, isFault); fault != done.errors.end())
                return tl::make_unexpected(*fault);
            outcome_.candidates.push_back(layout);
        }
        removeCandidates(outcome_.output, {outcome_.candidates.begin(), outcome_.candidates.end()}, NamedPlaces(scene_));
        return {};
    }

    /// Returns the actions of the assets that waited for a layout, less those that ran before.
    std::vector<Action> actionsOf(const Plan& plan, const ExecutionResult& result) const {
        std::vector<Action> rest;
        const Decisions& decisions = planOptions_.decisions;
        for (const Action& action : plan.actions) {
            const bool isChosen =
                decisions.layouts.contains(lightMapOf(plan, action.asset)) || (decisions.tableViews && action.asset == kTablesName);
            if (isChosen && !result.records.contains(action.id)) rest.push_back(action);
        }
        return rest;
    }

    /// Returns the assets that a cook without --only would make. A light map whose layout is open stands for its mesh too.
    std::vector<std::string> assetsOfScene(const Plan& plan, const Scene& planned, const Needs& needs) const {
        PlanOptions options = planOptions_;
        options.only = {};
        auto whole = planScene(planned, needs, options);
        if (!whole) return {plan.unwanted.begin(), plan.unwanted.end()};  // a mistake in what this cook leaves alone
        std::vector<std::string> assets = std::move(whole->assets);
        assets.insert(assets.end(), whole->undecided.begin(), whole->undecided.end());
        return assets;
    }

    /// Refuses to replace a file that the scene is made of, where it lies in the output folder under the name of an output; and an output
    /// that the command would replace by another file afterwards.
    Result<void> checkOutputs(const ExecutionResult& result) const {
        const NamedPlaces inputs(scene_);
        std::vector<std::filesystem::path> names = {kManifestName, kShaderName, kReportName, kReportHtmlName};
        for (const FileRecord& file : result.files) names.emplace_back(file.name);
        for (const std::filesystem::path& name : names)
            if (inputs.contains(outcome_.output / name))
                return failure(ErrorCode::InvalidRequest, outcome_.output / name,
                               "found a file of the scene in the place of an output, expected another output folder");
        if (!state_.checkOutputs) return {};
        std::vector<std::filesystem::path> files;  // the report may be a document of the command
        for (const FileRecord& file : result.files) files.push_back(outcome_.output / file.name);
        return state_.checkOutputs(files);
    }

    /// Warns before the files of another scene in the output folder are replaced: two converters may have been given one folder, and two
    /// scene files that lie beside each other may have one name. A scene file that is no longer there was renamed.
    void warnOfOtherScene() const {
        const auto old = loadManifest(outcome_.output);
        if (!old || !state_.warning) return;
        const std::filesystem::path oldFile = (outcome_.output / old->sceneDirectory / old->sceneFile.value_or("")).lexically_normal();
        std::error_code code;
        const bool isOtherFile = old->sceneFile && !scene_.file.empty() && std::filesystem::is_regular_file(oldFile, code) &&
                                 !std::filesystem::equivalent(oldFile, scene_.file, code);
        if (old->scene == scene_.name && !isOtherFile) return;
        const auto [of, expected] = old->scene != scene_.name ? std::pair(std::string(), "'" + scene_.name + "'")
                                                              : std::pair(" of " + oldFile.string(), "that of " + scene_.file.string());
        state_.warning(outcome_.output.string(),
                       fmt::format("found the cooked scene '{}'{}, expected {} or none: its files are replaced; another folder would keep "
                                   "them",
                                   old->scene, of, expected));
    }

    /// Publishes files, manifest and report together: an interrupt comes before or after all, and so does a full disk, since all are
    /// written before the first gets its name.
    Result<Report> publishWithSummaries(const Plan& plan, const Needs& needs, const ExecutionResult& result) {
        warnOfOtherScene();
        LC_TRY(transaction, formats::OutputTransaction::begin());
        LC_CHECK(checkOutputs(result));
        SummaryWriter writer(scene_, outcome_.output, options_.only.has_value(), *digests_);
        writer.addNotes(notes_);
        writer.addNotes(plan.notes);
        writer.setSeams(seams_);
        writer.addFailed(failed_);
        writer.setSceneAssets(sceneAssets_);
        writer.setLinted(linted_);
        writer.setCook({scene_.document, plan.wanted, options_.repair, options_.samples, needs, planOptions_.decisions});
        const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
        const RunRecord current{
            at_, seconds, formats::peakResidentBytes(), outcome_.actionsRun, workByRun(result)[at_], formats::wallsOfReaders()};
        if (outcome_.actionsRun > 0) cache_.storeRun(current);
        LC_TRY(report, writer.prepare(plan, result, staging_, outcome_.actionsRun > 0,
                                      {scene_.name, seconds, current.peakRssBytes, scene_.output.budgetBytes, runsOf(result, current),
                                       outcome_.findings, frontier_},
                                      measureRates(result)));
        LC_CHECK(publish(result, staging_, outcome_.output));
        LC_CHECK(writer.commit());
        outcome_.report = toJson(*report);
        return report;
    }

    /// Sets the rule of the dependency file: the inputs of all assets that the manifest describes, also of those that --only left alone.
    Result<void> setDepfile(const Plan& plan, const std::vector<Action>& needsGraph, const std::vector<Action>& contentGraph,
                            const Scene& planned, const Needs& needs) {
        LC_TRY(manifest, loadManifest(outcome_.output));
        const auto isPlanned = [&](const CookedAsset& asset) { return std::ranges::find(plan.assets, asset.name) != plan.assets.end(); };
        const bool isLeftAlone = !std::ranges::all_of(manifest->assets, isPlanned);
        if (isLeftAlone) planOptions_.only = {};
        LC_TRY(described, isLeftAlone ? planScene(planned, needs, planOptions_) : Result<Plan>(plan));
        std::vector<Action> all = needsGraph;
        all.insert(all.end(), packGraph_.begin(), packGraph_.end());
        all.insert(all.end(), contentGraph.begin(), contentGraph.end());
        all.insert(all.end(), described->actions.begin(), described->actions.end());
        // Files of the cook's own are no inputs: those that they were made of are.
        for (Action& action : all)
            std::erase_if(action.inputs, [&](const auto& input) { return input.second.string().starts_with(packedFolder().string()); });
        outcome_.depfile = depfileText(scene_, outcome_.output, all);
        return {};
    }

    /// Returns the time of the actions that made the results, by run.
    static std::map<std::string, double> workByRun(const ExecutionResult& result) {
        std::map<std::string, double> work;
        for (const auto& [id, record] : result.records) work[record.run] += record.seconds;
        return work;
    }

    /// Returns the runs that made the results, the first one first, each with its part in them: it may have made another scene too. A run
    /// that the cache has lost is left out.
    std::vector<RunRecord> runsOf(const ExecutionResult& result, const RunRecord& current) const {
        std::vector<RunRecord> runs;
        for (const auto& [at, seconds] : workByRun(result)) {
            const auto run = at == current.at ? std::optional(current) : cache_.findRun(at);
            if (run) runs.push_back(run->partOf(seconds));
        }
        return runs;
    }

    /// Returns the rates of this machine, with those of the assets that were just cooked.
    WorkRates measureRates(const ExecutionResult& result) const {
        WorkRates rates(cache_.root() / kRatesName);
        for (const auto& [id, record] : result.records) {
            if (result.reused.contains(id) || !isOfStep(id, ActionStep::Cook)) continue;
            const auto cooked = fromJson<CookResult>(record.result, id);
            if (!cooked) continue;
            rates.add(kindOfWork(cooked->asset), workOf(cooked->asset), record.seconds);
            if (cooked->asset.kind == AssetKind::LightMap) addLightMapRates(result, cooked->asset, record.seconds, rates);
        }
        rates.save();
        return rates;
    }

    /// Adds the rates of a light map that was just cooked: with its verification, and of its trial.
    static void addLightMapRates(const ExecutionResult& result, const CookedAsset& asset, double cookSeconds, WorkRates& rates) {
        const auto secondsOf = [&](ActionStep step) -> std::optional<double> {
            const auto record = result.records.find(actionId(step, asset.name));
            return record == result.records.end() || result.reused.contains(record->first) ? std::nullopt
                                                                                           : std::optional(record->second.seconds);
        };
        if (const auto verified = secondsOf(ActionStep::Verify))
            rates.add(kLayoutWork + asset.layout, workOf(asset), cookSeconds + *verified);
        if (const auto tried = secondsOf(ActionStep::Trial)) rates.add(kTrialWork, workOf(asset), *tried);
    }

    /// Adds the errors of some actions.
    void addErrors(const ExecutionResult& result) {
        for (const Error& error : result.errors)
            if (formats::addOnce(outcome_.errors, error)) failed_.push_back(error);
    }

    const CookOptions& options_;
    const RunState& state_;
    Clock::time_point start_;
    std::string at_ = timeNow();
    const Scene scene_;
    Cache cache_;
    PlanOptions planOptions_;
    std::optional<DigestMemo> digests_;
    std::optional<KeyLog> keys_;
    std::optional<Launcher> launcher_;
    /// Open bakes, for all graphs of the cook.
    std::unique_ptr<SharedObjects> shared_ = std::make_unique<SharedObjects>();
    std::map<std::string, Json> notes_;                                       ///< of a scene with a budget, by light map
    std::map<std::string, std::map<std::string, double>> seams_;              ///< LayoutDecision::seams()
    std::vector<FrontierPoint> frontier_;                                     ///< of such a scene
    std::map<std::string, std::map<std::string, std::string>> alternatives_;  ///< to cook as well: LayoutDecision::alternatives
    std::vector<Action> packGraph_;
    std::vector<std::string> sceneAssets_;  ///< of the whole scene, in a cook with --only
    std::set<std::string> linted_;          ///< assets whose inputs lint looked at
    std::filesystem::path staging_;
    std::optional<Error> unwritable_;  ///< why the output folder cannot be written: then staging_ lies elsewhere
    std::vector<Error> failed_;        ///< of actions, which with --keep-going do not stop the cook
    Outcome outcome_;
};

}  // namespace

std::vector<Outcome> cookScenes(std::vector<Scene> scenes, const CookOptions& options, const RunState& state) {
    std::vector<Outcome> outcomes;
    std::string depfile;
    for (Scene& scene : scenes) {
        outcomes.push_back(Cook(std::move(scene), options, state).run());
        const Outcome& outcome = outcomes.back();
        depfile += outcome.depfile;
        if (state.interrupted || !(options.keepGoing || std::ranges::all_of(outcome.errors, isOfTarget))) break;
    }
    const bool areAllThere = outcomes.size() == scenes.size() && std::ranges::none_of(outcomes, &std::string::empty, &Outcome::depfile);
    if (!options.depfile || !areAllThere) return outcomes;
    if (const auto written = writeFile(*options.depfile, depfile, OutputLink::Follow); !written)
        outcomes.back().errors.insert(outcomes.back().errors.begin(), written.error());
    return outcomes;
}

Outcome cookScene(Scene scene, const CookOptions& options, const RunState& state) {
    std::vector<Scene> scenes;
    scenes.push_back(std::move(scene));
    return std::move(cookScenes(std::move(scenes), options, state).front());
}

Outcome cookScene(const CookOptions& options, const RunState& state) {
    auto scene = readScene(options.scene, options.given);
    if (!scene) return outcomeOf(scene.error());
    return cookScene(std::move(*scene), options, state);
}

}  // namespace lightcook::pipeline
