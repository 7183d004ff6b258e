#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "formats/gltf_light_map.h"
#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/asset_kind.h"
#include "pipeline/assets/gltf/gltf.h"
#include "pipeline/assets/light_map/ground_truth.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/split_seams.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/assets/results.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/assets/verification.h"
#include "pipeline/cook/action_functions.h"
#include "pipeline/cook/cook.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/cook/plan.h"
#include "pipeline/cook/verdicts.h"
#include "pipeline/graph/files.h"
#include "pipeline/lint/lint.h"
#include "pipeline/manifest/contract.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/repack/packed_light_map.h"
#include "pipeline/report/exit_codes.h"
#include "pipeline/report/report.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;
using formats::failure;
using formats::Result;

using Sources = std::map<std::string, std::filesystem::path>;

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

/// Records of an asset's own actions.
struct OwnRecords {
    ActionRecord cooked, verified;
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
        LC_TRY(manifest, loadManifest(options_.folder));
        outcome_.errors = checkDigests(options_.folder, *manifest);
        if (!outcome_.errors.empty()) return {};
        outcome_.errors = checkContract(options_.folder, *manifest);
        LC_TRY(scratch, TemporaryFolder::create());
        std::optional<Report> previous;
        if (auto loaded = loadReport(options_.folder / kReportName)) previous = std::move(*loaded);
        std::vector<ReportRow> rows;
        if (state_.event)
            for (const CookedAsset& asset : manifest->assets)
                state_.event(verifyAction(asset.name, asset.kind, {}, {}), ActionEvent::Planned, 0);
        for (const CookedAsset& asset : manifest->assets) {
            LC_TRY(row, formats::ofAsset(asset.name, verifyAsset(*manifest, asset, scratch->path(), previous)));
            rows.push_back(std::move(*row));
        }
        if (previous) compareAssets(*manifest, *previous);
        if (previous) compareLimits(*manifest, rows, *previous);
        for (const GltfFile& gltf : manifest->gltf) compareBound(gltf, rows, previous);
        LC_CHECK(lint(*manifest, scratch->path()));
        // A folder that lacks assets of its scene does not pass.
        std::optional<IncompleteCook> incomplete = previous ? previous->incomplete : leftOut(manifestFile(), *manifest);
        const Report report = makeReport({manifest->scene,
                                          watch_.seconds(),
                                          peakResidentBytes(),
                                          manifest->budgetBytes,
                                          {},
                                          outcome_.findings,
                                          {},
                                          std::move(incomplete),
                                          manifest->partial},
                                         std::move(rows), {});
        for (Error& error : errorsOf(outcome_.findings)) outcome_.errors.push_back(std::move(error));
        appendErrorsOf(report, formats::Subject(options_.folder / kManifestName).at("budget_bytes"), outcome_.errors);
        outcome_.report = toJson(report);
        return {};
    }

    Result<ReportRow> verifyAsset(const Manifest& manifest, const CookedAsset& asset, const std::filesystem::path& scratch,
                                  const std::optional<Report>& previous) {
        const auto sources = unchangedSources(asset, sceneFolder(manifest));
        if (!sources) return tl::make_unexpected(withSourcesAdvice(sources.error()));
        LC_CHECK(checkProbePlace(manifest, asset, *sources));
        Json parameters = asset.verify.value_or(Json::object());
        if (options_.samples && parameters.contains("samples")) parameters["samples"] = *options_.samples;
        LC_CHECK(noteSources(asset, *sources));
        Action action = verifyAction(asset.name, asset.kind, *sources, parameters);
        CookedAsset read = asset;
        LC_TRY(unpacked, unpackedBakeOf(asset));
        if (*unpacked) {
            LC_TRY(packed, repacked(asset, **unpacked, *sources, scratch));
            action.inputs = verifyInputsOf(asset.kind, **packed);
            read = asRepacked(asset, **packed);
        }
        const CookFacts facts = cookFactsOf(previous, asset.name);
        ActionRecord cooked, lightMap;
        cooked.result = toJson(CookResult{read, facts.bytesIn, {}});
        cooked.seconds = facts.seconds;
        std::vector<const ActionRecord*> upstream = {&cooked};
        if (asset.basis) {
            LC_TRY(found, lightMapOf(manifest, asset));
            lightMap.result = toJson(CookResult{**found, 0, {}});
            upstream.push_back(&lightMap);
        }
        if (state_.event) state_.event(action, ActionEvent::Started, 0);
        LC_TRY(verified, run(action, upstream, scratch));
        verified->result.erase("preview");  // drawn in a scratch folder
        if (state_.event) state_.event(action, ActionEvent::Finished, verified->seconds);
        return rowOf(manifest, asset, action.inputs, {cooked, *verified}, scratch);
    }

    /// Verifies an asset together with others, where the manifest says so, and returns its row.
    /// sources  of the asset
    Result<ReportRow> rowOf(const Manifest& manifest, const CookedAsset& asset, const Sources& sources, const OwnRecords& own,
                            const std::filesystem::path& scratch) {
        AssetRecords records{&own.cooked, &own.verified};
        Result<ActionRecord> whole, splitSeams;
        if (asset.verifyWhole) {
            whole = verifyWhole(manifest, asset, sources, own.cooked, scratch);
            if (!whole) return tl::make_unexpected(whole.error());
            records.whole = &*whole;
        }
        if (asset.verifySplitSeams) {
            splitSeams = verifySplitSeams(manifest, asset, scratch);
            if (!splitSeams) return tl::make_unexpected(splitSeams.error());
            splitSeams->result.erase("views");  // drawn in a scratch folder
            records.splitSeams = &*splitSeams;
        }
        return reportRow(asset, records, manifest.sceneFile ? LimitsFrom::SceneFile : LimitsFrom::Converter);
    }

    void complain(formats::Subject place, const std::string& found, const std::string& expected, const std::string& asset = "") {
        const std::string detail = fmt::format("found {}, expected {}: cook the scene again", found, expected);
        outcome_.errors.emplace_back(ErrorCode::Verification, std::move(place), detail).asset = asset;
    }

    /// Looks for assets of the cook's report that the manifest lacks.
    void compareAssets(const Manifest& manifest, const Report& report) {
        for (const ReportRow& before : report.assets)
            if (std::ranges::find(manifest.assets, before.name, &CookedAsset::name) == manifest.assets.end())
                complain(manifestFile(), fmt::format("no asset '{}'", before.name), fmt::format("that of {}", kReportName));
    }

    /// Compares the limits that the manifest states with those of the cook's report.
    void compareLimits(const Manifest& manifest, const std::vector<ReportRow>& rows, const Report& report) {
        const auto ofReport = [](const Json& expected) { return fmt::format("{} of {}", expected.dump(), kReportName); };
        for (const ReportRow& row : rows)
            for (const ReportRow& before : report.assets) {
                if (before.name != row.name || before.kind != row.kind) continue;
                const Json found = toJson(row.verdict).at("limit"), expected = toJson(before.verdict).at("limit");
                if (found != expected)
                    complain(row.name + ", verify", fmt::format("the limits {}", found.dump()), ofReport(expected), row.name);
            }
        const auto words = [](const std::optional<std::uint64_t>& bytes) { return bytes ? Json(*bytes) : Json(nullptr); };
        if (manifest.budgetBytes != report.budget.limitBytes)
            complain(manifestFile() + ", budget_bytes", words(manifest.budgetBytes).dump(), ofReport(words(report.budget.limitBytes)));
    }

    /// Compares the errors in a glTF with those of its light map. With another number of samples they are those of the cook's report.
    void compareBound(const GltfFile& gltf, const std::vector<ReportRow>& rows, const std::optional<Report>& report) {
        if (options_.samples && !report) return;
        const std::vector<ReportRow>& known = options_.samples ? report->assets : rows;
        const auto row = std::ranges::find_if(
            known, [&](const ReportRow& each) { return each.name == gltf.lightMap && each.kind == AssetKind::LightMap; });
        if (row == known.end() || !row->verdict.passed) return;
        const std::filesystem::path file = options_.folder / gltf.file;
        const auto text = formats::boundLightMaps(file);
        const Json maps = text ? parseJson(*text) : Json();
        if (!maps.is_array() || maps.empty() || !maps[0].is_object()) return;  // checkContract() reports it
        const Json found = maps[0].value("bound", Json()).flatten(), expected = boundFiguresOf(row->verdict).flatten();
        constexpr double kRounding = 1e-6;
        for (const auto& [name, value] : expected.items()) {
            const Json stated = found.value(name, Json());
            const bool areNumbers = stated.is_number() && value.is_number();
            if (areNumbers ? std::abs(stated.get<double>() - value.get<double>()) <= kRounding * value.get<double>() : stated == value)
                continue;
            complain(formats::Subject(file).at("bound" + name), stated.dump(), value.dump() + " of its light map");
        }
        for (const auto& [name, value] : found.items())
            if (!expected.contains(name))
                complain(formats::Subject(file).at("bound" + name), value.dump(), "no such error of its light map");
    }

    /// Compares the place of a probe with the scene file, which goes before the list of probes. A scene file that cannot be read may have
    /// stated anything.
    Result<void> checkProbePlace(const Manifest& manifest, const CookedAsset& asset, const Sources& sources) {
        if (asset.kind != AssetKind::Cubemap) return {};
        std::filesystem::path statedIn;
        Json stated = Json::object(), listed = Json::object();
        if (manifest.sceneFile) {
            const Scene* const scene = sceneFileOf(manifest);
            if (scene == nullptr) return {};
            const auto entry = std::ranges::find(scene->probes, asset.name, &ProbeEntry::name);
            if (entry == scene->probes.end()) return {};
            statedIn = scene->file;
            stated = toJson(entry->place);
        }
        const auto list = sources.find("sh"), image = sources.find("source");
        if (list != sources.end() && image != sources.end()) {
            LC_TRY(place, formats::loadProbePlace(list->second, image->second.filename().string()));
            listed = toJson(*place);
        }
        const Json found = toJson(asset.probe.value_or(formats::ProbePlace()));
        for (const char* key : {"position", "box", "radius"}) {
            const Json expected = stated.contains(key) ? stated[key] : listed.value(key, Json());
            if (found.value(key, Json()) == expected) continue;
            std::string words = "none, as no source states one";
            if (!expected.is_null())
                words = fmt::format("{} of {}", expected.dump(), (stated.contains(key) ? statedIn : list->second).string());
            complain(fmt::format("{}, probe/{}", asset.name, key), found.value(key, Json()).dump(), words, asset.name);
        }
        return {};
    }

    /// Returns an asset of a repacked light map as the cook had it, with the description of the repacked bake.
    static CookedAsset asRepacked(CookedAsset asset, const PackedLightMap& packed) {
        auto description = packed.packed;
        const ChartPacking& packing = packed.bake.packing;
        if (const auto before = descriptionOf(asset); before && before->constantOf)
            description.constantOf = glm::ivec2(packing.width, packing.height);
        asset.source.description = toJson(description);
        return asset;
    }

    /// Verifies a light map and its dominant light together.
    Result<ActionRecord> verifyWhole(const Manifest& manifest, const CookedAsset& lightMap, const Sources& sources,
                                     const ActionRecord& cooked, const std::filesystem::path& scratch) {
        ActionRecord dominant;
        std::vector<const ActionRecord*> upstream = {&cooked};
        for (const CookedAsset& asset : manifest.assets) {
            if (asset.kind != AssetKind::Dominant || asset.lightMap != lightMap.name) continue;
            dominant.result = toJson(CookResult{asset, 0, {}});
            upstream.push_back(&dominant);
        }
        return run(wholeAction(lightMap.name, sources, *lightMap.verifyWhole, {}), upstream, scratch);
    }

    /// Verifies the seams between the maps of a split.
    /// first  the map that has the parameters
    Result<ActionRecord> verifySplitSeams(const Manifest& manifest, const CookedAsset& first, const std::filesystem::path& scratch) {
        LC_TRY(parameters, fromJson<SplitSeamsParameters>(*first.verifySplitSeams, first.name + ", verify_split_seams"));
        std::vector<const PackedLightMap*> maps;
        std::vector<ActionRecord> cooked(parameters->maps.size());
        std::vector<const ActionRecord*> upstream;
        for (const std::string& name : parameters->maps) {
            const auto asset = std::ranges::find_if(
                manifest.assets, [&](const CookedAsset& each) { return each.name == name && each.kind == AssetKind::LightMap; });
            const auto unpacked =
                asset == manifest.assets.end() ? Result<std::optional<UnpackedBake>>(std::nullopt) : unpackedBakeOf(*asset);
            if (!unpacked) return tl::make_unexpected(unpacked.error());
            if (!*unpacked || !(*unpacked)->part || (*unpacked)->part->of != first.name)
                return failure(
                    ErrorCode::Verification, first.name + ", verify_split_seams",
                    fmt::format("found no light map '{}' of the same split in the manifest, expected it: cook the scene again", name));
            const auto sources = unchangedSources(*asset, sceneFolder(manifest));
            if (!sources) return tl::make_unexpected(withSourcesAdvice(sources.error()));
            LC_TRY(packed, repacked(*asset, **unpacked, *sources, scratch));
            cooked[maps.size()].result = toJson(CookResult{asRepacked(*asset, **packed), 0, {}});
            upstream.push_back(&cooked[maps.size()]);
            maps.push_back(*packed);
        }
        return run(splitSeamsAction(first.name, maps, *first.verifySplitSeams, {}), upstream, scratch);
    }

    /// Runs an action on cooked assets.
    Result<ActionRecord> run(const Action& action, const std::vector<const ActionRecord*>& upstream, const std::filesystem::path& scratch) {
        const Stopwatch watch;
        LC_TRY(outcome, actionFunction(action.kind)({action, scratch, options_.folder, upstream, shared_, state_}));
        return ActionRecord{action.id, std::move(outcome->result), {}, watch.seconds()};
    }

    /// Packs the charts of an asset's light map again, once for all its assets.
    Result<const PackedLightMap*> repacked(const CookedAsset& asset, const UnpackedBake& bake, const Sources& sources,
                                           const std::filesystem::path& scratch) {
        const std::string name = asset.lightMap.value_or(asset.name);
        if (const auto known = packed_.find(name); known != packed_.end()) return &known->second;
        const Action action{actionId(ActionStep::Pack, name),
                            kPackChartsKind,
                            name,
                            toJson(PackParameters{bake.description, bake.packing.maxVisible, bake.part}),
                            sources,
                            {}};
        ActionRecord record;
        auto outcome = actionFunction(action.kind)({action, scratch, scratch, {}, shared_, state_});
        if (!outcome) return tl::make_unexpected(outcome.error());
        record.result = std::move(outcome->result);
        LC_TRY(packed, packedLightMap(action, record, scratch));
        if (toJson(packed->bake.packing) != toJson(bake.packing) || (!bake.places.empty() && packed->bake.places != bake.places))
            return failure(ErrorCode::Verification, asset.name,
                           "found charts that are packed otherwise than in the cooked folder, expected the same: cook the scene again");
        return &packed_.emplace(name, std::move(*packed)).first->second;
    }

    std::string manifestFile() const { return (options_.folder / kManifestName).string(); }

    std::filesystem::path sceneFolder(const Manifest& manifest) const {
        return options_.sources.empty() ? options_.folder / manifest.sceneDirectory : options_.sources;
    }

    /// Adds the sources of an asset to the scene that lint looks at.
    Result<void> noteSources(const CookedAsset& asset, const Sources& sources) {
        const auto source = sources.find("source");
        if (asset.verify && asset.verify->contains("max_error") && info(asset.kind).isHeldToMaxError)
            scene_.output.limits[Limit::Error] = asset.verify->at("max_error").get<double>();
        if (source == sources.end()) return {};
        if (asset.kind == AssetKind::Cubemap) {
            ProbeEntry entry{asset.name, source->second, {}};
            if (const auto sh = sources.find("sh"); sh != sources.end()) entry.sh = sh->second;
            scene_.probes.push_back(std::move(entry));
            if (asset.source.colors) scene_.colors = *asset.source.colors;  // all probes have the same
            if (const auto config = sources.find(kColorConfigRole); config != sources.end()) scene_.colors.config = config->second;
        }
        if (!asset.source.description) return {};
        auto entry = std::ranges::find(scene_.lightMaps, source->second, &LightMapEntry::file);
        if (entry == scene_.lightMaps.end()) {
            LC_TRY(description, descriptionOf(asset));
            LightMapEntry added;
            added.name = asset.name;
            added.file = source->second;
            added.description = withFiles(std::move(*description), sources);
            added.description.constantOf = {};  // one part of a split map may be constant, and the other not
            if (const auto traced = sources.find(kGroundTruthRole); traced != sources.end()) added.groundTruth = traced->second;
            scene_.lightMaps.push_back(std::move(added));
            entry = std::prev(scene_.lightMaps.end());
        }
        if (const auto mesh = sources.find(kMeshRole); mesh != sources.end() && asset.kind == AssetKind::Mesh) {
            entry->mesh = mesh->second;
            entry->description.lmbake = lmbakeOf(sources, kMeshRole);
        }
        return {};
    }

    /// Returns the scene that was cooked, or null if its file is not there or cannot be read.
    const Scene* sceneFileOf(const Manifest& manifest) {
        if (!wasSceneRead_ && manifest.sceneFile)
            if (auto scene = readScene(sceneFolder(manifest) / *manifest.sceneFile)) sceneFile_ = std::move(*scene);
        wasSceneRead_ = true;
        return sceneFile_ ? &*sceneFile_ : nullptr;
    }

    /// Looks again for what is implausible in the sources.
    Result<void> lint(const Manifest& manifest, const std::filesystem::path& scratch) {
        scene_.name = manifest.scene;
        if (const Scene* const scene = sceneFileOf(manifest)) {
            scene_.file = scene->file;
            scene_.lines = scene->lines;
        }
        if (scene_.file.empty()) scene_.file = options_.folder / kManifestName;
        scene_.allowances = manifest.allowances;
        std::map<std::string, ActionRecord> records;
        for (const Action& action : planLint(scene_, false)) {
            auto outcome = actionFunction(action.kind)({action, scratch, options_.folder, {}, shared_, state_});
            if (!outcome) return tl::make_unexpected(outcome.error());
            records[action.id] = {action.id, std::move(outcome->result), {}, 0};
        }
        LC_TRY(findings, judgeScene(scene_, records, options_.strict));
        outcome_.isLinted = true;
        outcome_.findings = std::move(*findings);
        return {};
    }

    /// Returns the light map whose bases the vertices of a mesh name.
    static Result<const CookedAsset*> lightMapOf(const Manifest& manifest, const CookedAsset& mesh) {
        for (const CookedAsset& other : manifest.assets)
            if (other.name == mesh.basis->lightMap && other.kind == AssetKind::LightMap) return &other;
        return failure(
            ErrorCode::Verification, mesh.name,
            fmt::format("found no light map \"{}\" in the manifest, expected the one whose bases its vertices name", mesh.basis->lightMap));
    }

    const VerifyOptions& options_;
    const RunState& state_;
    const Stopwatch watch_;
    SharedObjects shared_;
    Scene scene_;                     ///< the sources of all assets, for lint
    std::optional<Scene> sceneFile_;  ///< see sceneFileOf()
    bool wasSceneRead_ = false;
    std::map<std::string, PackedLightMap> packed_;  ///< by light map
    Outcome outcome_;
};

}  // namespace

Outcome verifyCooked(const VerifyOptions& options, const RunState& state) {
    return Verification(options, state).run();
}

}  // namespace lightcook::pipeline
