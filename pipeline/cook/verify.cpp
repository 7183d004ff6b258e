#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "formats/gltf_light_map.h"
#include "formats/process.h"
#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/gltf/gltf.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/results.h"
#include "pipeline/assets/verification.h"
#include "pipeline/cook/action_functions.h"
#include "pipeline/cook/cook.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/cook/map_preparation.h"
#include "pipeline/cook/plan.h"
#include "pipeline/cook/verdicts.h"
#include "pipeline/document/json_difference.h"
#include "pipeline/graph/files.h"
#include "pipeline/lint/lint.h"
#include "pipeline/manifest/contract.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/exit_codes.h"
#include "pipeline/report/failures.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;
using formats::Result;

/// Facts of an asset's cook, from an earlier report.
struct CookFacts {
    std::uint64_t bytesIn = 0;
    double seconds = 0;
};
CookFacts cookFactsOf(const std::optional<Report>& report, const std::string& asset) {
    CookFacts facts;
    if (!report) return facts;
    for (const ReportRow& row : report->assets)
        if (row.name == asset) facts = {row.bytesIn, row.seconds};
    return facts;
}

/// Returns the assets that a cook left out, as its manifest lists them. Only the report has the errors of that cook, and a folder may lack
/// it.
std::optional<IncompleteCook> leftOut(const std::string& file, const Manifest& manifest) {
    if (!manifest.incomplete) return {};
    std::string found = "found a cook that went on after an error";
    if (!manifest.incomplete->empty()) found += fmt::format(", without '{}'", fmt::join(*manifest.incomplete, "', '"));
    const FailedAction failed{exitCode(ErrorCode::Verification), file, found + ", expected all assets of the scene: cook it again"};
    return IncompleteCook{*manifest.incomplete, {failed}};
}

/// Returns the error of a source with what to do if it is not there.
Error withSourcesAdvice(Error error) {
    std::error_code code;
    if (!std::filesystem::exists(error.file, code))
        error.detail += ". Has the scene moved? --sources DIR names the folder of its scene file";
    return error;
}

/// A cook of the manifest, planned again.
struct PlannedCook {
    Scene scene;  ///< as the user made it
    Plan plan;
    bool repair = false;
};

/// Verifies a cooked folder again, from the bytes on disk and the sources.
class Verification {
public:
    Verification(const VerifyOptions& options, const RunState& state) : options_(options), state_(state) {}

    Outcome run() {
        outcome_.output = options_.folder;
        if (auto done = tryRun(); !done) outcome_.errors.insert(outcome_.errors.begin(), done.error());
        return std::move(outcome_);
    }

private:
    Result<void> tryRun() {
        LC_TRY(loaded, loadManifest(options_.folder));
        manifest_ = std::move(*loaded);
        if (manifest_.isPreview)
            return formats::failure(ErrorCode::Verification, manifestFile(),
                                    "found a preview, which has no certificate, expected a release: cook the scene without --preview");
        outcome_.errors = checkDigests(options_.folder, manifest_);
        if (!outcome_.errors.empty()) return {};
        if (auto report = loadReport(options_.folder / kReportName)) previous_ = std::move(*report);
        outcome_.errors = checkContract(options_.folder, manifest_);
        LC_TRY(scratch, TemporaryFolder::create());
        scratch_ = scratch->path();
        for (const CookedAsset& asset : manifest_.assets)
            if (const auto sources = formats::ofAsset(asset.name, unchangedSources(asset, sceneFolder())); !sources)
                return tl::make_unexpected(withSourcesAdvice(sources.error()));
        for (const CookRecord& cook : manifest_.cooks) LC_CHECK(planAgain(cook));
        comparePlans();
        if (state_.event)
            for (const CookedAsset& asset : manifest_.assets)
                state_.event(verifyAction(asset.name, asset.kind, {}, {}), ActionEvent::Planned, 0);
        std::vector<ReportRow> rows;
        for (const CookedAsset& asset : manifest_.assets) {
            LC_TRY(row, formats::ofAsset(asset.name, verifyAsset(asset)));
            if (*row) rows.push_back(std::move(**row));
        }
        addFailures(rows, manifest_.sceneFile ? LimitsFrom::SceneFile : LimitsFrom::Converter);
        for (const GltfFile& gltf : manifest_.gltf) compareBound(gltf, rows);
        LC_CHECK(lint());
        // A folder that lacks assets of its scene does not pass.
        std::optional<IncompleteCook> incomplete = previous_ ? previous_->incomplete : leftOut(manifestFile().text, manifest_);
        const Report report = makeReport({manifest_.scene,
                                          watch_.seconds(),
                                          formats::peakResidentBytes(),
                                          cooks_.back().scene.output.budgetBytes,
                                          {},
                                          outcome_.findings,
                                          {},
                                          std::move(incomplete),
                                          manifest_.partial},
                                         std::move(rows), {});
        for (Error& error : errorsOf(outcome_.findings)) outcome_.errors.push_back(std::move(error));
        appendErrorsOf(report, manifestFile().at("budget"), outcome_.errors);
        outcome_.report = toJson(report);
        return {};
    }

    /// Plans a cook as it was planned, with the same decisions. Charts of light maps are packed again.
    Result<void> planAgain(const CookRecord& cook) {
        auto scene = readSceneDocument(cook.scene, std::filesystem::proximate(sceneFolder()));
        if (!scene) return formats::failure(ErrorCode::Verification, manifestFile().at("cooks"), scene.error().detail);
        PlanOptions options{{}, {}, cook.repair, cook.samples, cook.decisions, {}, cook.assets};
        const std::filesystem::path folder = scratch_ / fmt::format("charts{}", cooks_.size());
        const bool isIncomplete = manifest_.incomplete.has_value();
        const auto runInto = [this](const std::vector<Action>& graph, const std::filesystem::path& into) {
            ExecutionResult result;
            for (const Action& action : graph) {
                auto record = run(action, {}, into);
                if (!record) result.errors.push_back(record.error());
                if (record) result.records[action.id] = std::move(*record);
            }
            return result;
        };
        LC_TRY(prepared, prepareMaps(*scene, options, folder, runInto));
        const std::vector<Error>& errors = prepared->result.errors;
        if (isEndedBy(errors, isIncomplete, state_)) return tl::make_unexpected(errors.front());
        LC_TRY(plan, planScene(prepared->scene, cook.needs, options));
        cooks_.push_back({std::move(*scene), std::move(*plan), cook.repair});
        return {};
    }

    /// Returns the plan of an asset: that of the last cook that made it. Null: none did.
    const Plan* planOf(const std::string& asset) const {
        const auto has = [&](const PlannedCook& cook) { return std::ranges::find(cook.plan.assets, asset) != cook.plan.assets.end(); };
        const auto cook = std::find_if(cooks_.rbegin(), cooks_.rend(), has);
        return cook == cooks_.rend() ? nullptr : &cook->plan;
    }

    const CookedAsset* assetOf(const std::string& name) const {
        const auto asset = std::ranges::find(manifest_.assets, name, &CookedAsset::name);
        return asset == manifest_.assets.end() ? nullptr : &*asset;
    }

    /// Compares the manifest with what the plans say of it.
    void comparePlans() {
        const Scene& scene = cooks_.back().scene;
        const Json planned = toJson(makeManifest(scene, options_.folder, {}, {}, "")), stored = toJson(manifest_);
        for (const char* key : {"scene", "target", "color", "lobe", "up_axis"})
            compare(manifestFile().at(key), stored.at(key), planned.at(key));
        for (const PlannedCook& cook : cooks_)
            for (const std::string& name : cook.plan.assets)
                if (assetOf(name) == nullptr && std::ranges::count(manifest_.incomplete.value_or(std::vector<std::string>()), name) == 0)
                    complain(manifestFile(), fmt::format("no asset '{}'", name), "that of its scene");
        for (const CookedAsset& asset : manifest_.assets) {
            const Plan* plan = planOf(asset.name);
            if (plan != nullptr)
                compare(asset.name, toJson(asset), plannedAsset(*plan, asset), asset.name);
            else
                complain(manifestFile(), fmt::format("the asset '{}'", asset.name), "those of its scene", asset.name);
        }
    }

    /// Returns what a plan knows of an asset of the manifest.
    Json plannedAsset(const Plan& plan, const CookedAsset& asset) const {
        const Action &cook = actionOf(plan, actionId(ActionStep::Cook, asset.name)),
                     &verify = actionOf(plan, actionId(ActionStep::Verify, asset.name));
        const AssetKind kind = assetKindFromName(cook.kind).value();
        Json planned = toJson(makeCookedAsset(asset.name, kind, "", 0, 0));
        for (const char* unknown : {"layout", "width", "height", "textures"}) planned.erase(unknown);
        if (kind == AssetKind::Cubemap) planned.erase("quantity");  // its layout decides
        Json source = {{"files", Json::object()}};
        for (const auto& [role, file] : sourcesOf(plan, asset.name))
            source["files"][role]["file"] = std::filesystem::proximate(file, sceneFolder()).generic_string();
        for (const char* key : {"description", "colors", "repair", "encoding", "axis", "zones"})
            if (cook.parameters.contains(key) && !plan.packed.contains(asset.name)) source[key] = cook.parameters.at(key);
        planned["source"] = std::move(source);
        if (cook.parameters.contains("light_map")) planned["light_map"] = cook.parameters.at("light_map");
        if (asset.basis) planned["basis"]["light_map"] = planned["light_map"];
        if (cook.parameters.contains("north")) planned["axis"] = cook.parameters.at("north");
        planned["verify"] = verify.parameters;
        return planned;
    }

    void complain(formats::Subject place, const std::string& found, const std::string& expected, const std::string& asset = "") {
        const std::string detail = fmt::format("found {}, expected {}: cook the scene again", found, expected);
        outcome_.errors.emplace_back(ErrorCode::Verification, std::move(place), detail).asset = asset;
    }

    /// Complains of every member of the manifest that differs from what was planned. Those that no plan knows are left out.
    void compare(const formats::Subject& subject, const Json& stored, const Json& planned, const std::string& asset = "") {
        eachDifference(stored, planned, [&](const std::string& path, const Json& found, const Json& expected) {
            if (expected.is_null() && !path.starts_with("verify/")) return;
            complain(subject.at(path), wordsOf(found), wordsOf(expected) + " of its scene", asset);
        });
    }

    static std::string wordsOf(const Json& value) {
        constexpr std::size_t kMost = 100;
        const std::string words = value.is_null() ? "nothing" : value.dump();
        return words.size() <= kMost ? words : words.substr(0, kMost) + "...";
    }

    /// Verifies an asset, and it together with others where that was planned, and returns its row. Empty: nobody planned it.
    Result<std::optional<ReportRow>> verifyAsset(const CookedAsset& asset) {
        const Plan* plan = planOf(asset.name);
        std::map<ActionStep, ActionRecord> records;
        for (const ActionStep step : {ActionStep::Verify, ActionStep::Whole}) {
            if (plan == nullptr) continue;
            const auto planned = std::ranges::find(plan->actions, actionId(step, asset.name), &Action::id);
            if (planned == plan->actions.end()) continue;
            Action action = *planned;
            if (options_.samples && action.parameters.contains("samples")) action.parameters["samples"] = *options_.samples;
            std::vector<ActionRecord> cooked;
            for (const std::string& id : action.dependencies)
                if (const CookedAsset* upstream = assetOf(actionSubject(id, ActionStep::Cook)))
                    cooked.push_back(cookedRecord(*plan, *upstream));
            if (cooked.size() < action.dependencies.size()) continue;  // comparePlans() reports what is missing
            if (state_.event && step == ActionStep::Verify) state_.event(action, ActionEvent::Started, 0);
            LC_TRY(record, run(action, cooked, scratch_));
            if (state_.event && step == ActionStep::Verify) state_.event(action, ActionEvent::Finished, record->seconds);
            for (const char* drawn : {"preview", "views"}) record->result.erase(drawn);  // in a scratch folder
            records[step] = std::move(*record);
        }
        if (!records.contains(ActionStep::Verify)) return std::optional<ReportRow>();
        const ActionRecord cooked = cookedRecord(*plan, asset);
        const auto recordOf = [&](ActionStep step) { return records.contains(step) ? &records[step] : nullptr; };
        LC_TRY(row, reportRow(asset, {&cooked, recordOf(ActionStep::Verify), recordOf(ActionStep::Whole)}));
        takeTrial(*row);
        return std::optional(std::move(*row));
    }

    /// Adds what the cook measured of other layouts, for the advice.
    void takeTrial(ReportRow& row) const {
        if (!previous_) return;
        const auto cooked = std::ranges::find(previous_->assets, row.name, &ReportRow::name);
        if (cooked == previous_->assets.end() || cooked->triedLayout() != row.triedLayout()) return;
        row.trialCandidates = cooked->trialCandidates;
        row.trialShare = cooked->trialShare;
    }

    /// Returns an asset as its cook action left it: of a repacked light map with the description of the repacked bake.
    ActionRecord cookedRecord(const Plan& plan, CookedAsset asset) const {
        if (const auto packed = plan.packed.find(asset.name); packed != plan.packed.end())
            asset.source.description = actionOf(plan, actionId(ActionStep::Cook, asset.name)).parameters.at("description");
        const CookFacts facts = cookFactsOf(previous_, asset.name);
        ActionRecord record;
        record.result = toJson(CookResult{asset, facts.bytesIn, {}});
        record.seconds = facts.seconds;
        return record;
    }

    /// Runs an action on cooked assets.
    /// into  folder of its files
    Result<ActionRecord> run(const Action& action, const std::vector<ActionRecord>& cooked, const std::filesystem::path& into) {
        const Stopwatch watch;
        std::vector<const ActionRecord*> upstream;
        for (const ActionRecord& record : cooked) upstream.push_back(&record);
        LC_TRY(outcome, actionFunction(action.kind)({action, into, options_.folder, upstream, shared_, state_}));
        return ActionRecord{action.id, std::move(outcome->result), {}, watch.seconds()};
    }

    /// Compares the errors in a glTF with those of its light map. With another number of samples they are those of the cook's report.
    void compareBound(const GltfFile& gltf, const std::vector<ReportRow>& rows) {
        if (options_.samples && !previous_) return;
        const std::vector<ReportRow>& known = options_.samples ? previous_->assets : rows;
        const auto row = std::ranges::find_if(
            known, [&](const ReportRow& each) { return each.name == gltf.lightMap && each.kind == AssetKind::LightMap; });
        if (row == known.end() || !row->verdict.passed) return;
        const std::filesystem::path file = options_.folder / gltf.file;
        const auto text = formats::boundLightMaps(file);
        const Json maps = text ? parseJson(*text) : Json();
        if (!maps.is_array() || maps.empty() || !maps[0].is_object()) return;  // checkContract() reports it
        constexpr double kRounding = 1e-6;
        eachDifference(maps[0].value("bound", Json()), boundFiguresOf(row->verdict),
                       [&](const std::string& path, const Json& found, const Json& expected) {
                           const bool areNumbers = found.is_number() && expected.is_number();
                           if (areNumbers && std::abs(found.get<double>() - expected.get<double>()) <= kRounding * expected.get<double>())
                               return;
                           complain(formats::Subject(file).at("bound/" + path), found.dump(),
                                    expected.is_null() ? "no such error of its light map" : expected.dump() + " of its light map");
                       });
    }

    formats::Subject manifestFile() const { return options_.folder / kManifestName; }

    std::filesystem::path sceneFolder() const {
        return options_.sources.empty() ? options_.folder / manifest_.sceneDirectory : options_.sources;
    }

    /// Looks again for what is implausible in the sources of the assets. Meshes that nothing was verified with may be gone.
    Result<void> lint() {
        // Findings name lines of the scene file, or else the manifest.
        const auto file = manifest_.sceneFile ? readScene(sceneFolder() / *manifest_.sceneFile) : Result<Scene>();
        std::set<std::string> known;  // in the lint of an earlier cook
        for (PlannedCook& cook : cooks_) {
            std::error_code code;
            for (LightMapEntry& entry : cook.scene.lightMaps)
                if (entry.mesh && !std::filesystem::exists(*entry.mesh, code)) entry.mesh.reset();
            cook.scene.file = file && !file->file.empty() ? file->file : options_.folder / kManifestName;
            if (file) cook.scene.lines = file->lines;
            std::set<std::string> assets(cook.plan.assets.begin(), cook.plan.assets.end());
            std::erase_if(assets, [&](const std::string& name) { return assetOf(name) == nullptr; });
            std::map<std::string, ActionRecord> records;
            for (const Action& action : planLint(cook.scene, cook.repair, inputsOf(cook.scene, std::move(assets)))) {
                LC_TRY(record, run(action, {}, scratch_));
                records[action.id] = std::move(*record);
            }
            LC_TRY(findings, judgeScene(cook.scene, records, options_.strict));
            for (Finding& finding : *findings)
                if (known.insert(toJson(finding).dump()).second) outcome_.findings.push_back(std::move(finding));
        }
        outcome_.isLinted = true;
        return {};
    }

    const VerifyOptions& options_;
    const RunState& state_;
    const Stopwatch watch_;
    SharedObjects shared_;
    Manifest manifest_;
    std::optional<Report> previous_;  ///< of the cook
    std::vector<PlannedCook> cooks_;  ///< as in the manifest
    std::filesystem::path scratch_;
    Outcome outcome_;
};

}  // namespace

Outcome verifyCooked(const VerifyOptions& options, const RunState& state) {
    return Verification(options, state).run();
}

}  // namespace lightcook::pipeline
