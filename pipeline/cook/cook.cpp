#include "pipeline/cook/cook.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include "formats/light_map_layout.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/planner.h"
#include "pipeline/cook/plan.h"
#include "pipeline/graph/cache.h"
#include "pipeline/graph/executor.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/contract.h"
#include "pipeline/manifest/json_shape.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/manifest/self_digest.h"
#include "pipeline/report/failures.h"
#include "pipeline/report/report.h"
#include "pipeline/scene/needs.h"
#include "shaders/include.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;
using formats::failure;
using formats::Result;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kCacheLimitBytes = std::uint64_t{4} << 30;

double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

void applyOverrides(const CookOptions& options, OutputSettings& output) {
    if (options.target) output.target = *options.target;
    if (options.maxError) output.maxError = *options.maxError;
    output.isErrorAsked = output.isErrorAsked || options.maxError;
    if (options.budgetBytes) output.budgetBytes = *options.budgetBytes;
    if (options.lightMapLayout) output.lightMapLayout = *options.lightMapLayout;
    if (options.container) output.container = *options.container;
    if (options.zstd) output.zstd = *options.zstd;
    if (options.effort) output.effort = *options.effort;
    if (options.rdo) output.rdo = *options.rdo;
}

/// Verdicts and budgets as the errors that decide the exit code.
void judge(const Json& report, std::vector<Error>& errors) {
    for (const Json& asset : report.at("assets"))
        if (!asset.at("passed").get<bool>())
            for (formats::Error& error : errorsOf(asset.value("failures", Json::array()))) errors.push_back(std::move(error));
    if (!isWithinBudget(report))
        errors.push_back(
            {ErrorCode::OverBudget, "budget",
             fmt::format("found {} bytes of GPU memory, expected at most {}", report.at("budget").at("used_bytes").get<std::uint64_t>(),
                         report.at("budget").at("limit_bytes").get<std::uint64_t>())});
}

std::string makeEscaped(const std::filesystem::path& path) {
    std::string escaped;
    for (const char c : path.generic_string()) {
        if (c == ' ' || c == '#') escaped += '\\';
        if (c == '$') escaped += '$';
        escaped += c;
    }
    return escaped;
}

/// Makefile syntax: the manifest depends on the scene file and everything that it names.
std::string depfileText(const Scene& scene, const std::filesystem::path& output, const std::vector<Action>& graph) {
    std::set<std::string> inputs = {makeEscaped(scene.file)};
    for (const Action& action : graph)
        for (const auto& [role, path] : action.inputs) inputs.insert(makeEscaped(path));
    if (!scene.colors.config.empty()) inputs.insert(makeEscaped(scene.colors.config));
    return fmt::format("{}: {}\n", makeEscaped(output / kManifestName), fmt::join(inputs, " "));
}

/// Whether a file is what some record of it says.
std::optional<Error> checkFile(const std::filesystem::path& file, const std::string& expected) {
    const auto digest = digestOfFile(file);
    if (!digest) return Error{ErrorCode::Verification, file.string(), "found no readable file, expected the one that was cooked"};
    if (*digest == expected) return {};
    return Error{ErrorCode::Verification, file.string(), fmt::format("found content {}, expected {} as cooked", *digest, expected)};
}

/// What report.json, as it was read, says of the files that go with it: the manifest, the page, the pictures.
std::vector<Error> checkReportFiles(const std::filesystem::path& folder, const std::string& manifestText, const Json& report) {
    std::vector<Error> errors;
    for (const Json& each : report.value("files", Json::array())) {
        const std::string file = each.at("file").get<std::string>(), expected = each.at("digest").get<std::string>();
        if (file != kManifestName) {
            if (auto error = checkFile(folder / file, expected)) errors.push_back(std::move(*error));
        } else if (digestOfText(manifestText) != expected) {
            errors.push_back({ErrorCode::Verification, (folder / kReportName).string(),
                              fmt::format("found the report of manifest {}, expected that of {}", expected, digestOfText(manifestText))});
        }
    }
    return errors;
}

/// One cook, from scene file to published folder.
class Cook {
public:
    Cook(Scene scene, const CookOptions& options, const RunState& state)
        : options_(options),
          state_(state),
          start_(Clock::now()),
          scene_(std::move(scene)),
          cache_(options.cache.empty() ? defaultCacheFolder() : options.cache, kCacheLimitBytes) {}

    Outcome run() {
        if (auto done = tryRun(); !done) outcome_.errors.insert(outcome_.errors.begin(), done.error());
        return std::move(outcome_);
    }

private:
    Result<void> tryRun() {
        applyOverrides(options_, scene_.output);
        if (scene_.output.zstd && scene_.output.container == formats::Container::Dds)
            return failure(ErrorCode::InvalidRequest, "--container dds",
                           "found zstd asked for as well, expected --container ktx2: DDS has no supercompression");
        if (scene_.output.rdo > 0 && scene_.output.target != Target::Bc)
            return failure(ErrorCode::InvalidRequest, "--rdo", "found a target other than bc, expected --target bc: only BC blocks repeat");
        outcome_.output = options_.output.empty() ? std::filesystem::path(scene_.name + ".cooked") : options_.output;
        std::error_code code;
        if (std::filesystem::exists(outcome_.output, code) && !std::filesystem::is_directory(outcome_.output, code))
            return failure(ErrorCode::InvalidRequest, outcome_.output.string(), "found a file, expected a folder or nothing");
        const std::filesystem::path absolute = std::filesystem::absolute(outcome_.output).lexically_normal();
        digests_.emplace(cache_.root() / "stamps" / digestOfText(absolute.string()));
        // On the output's own file system, so that finished files are renamed: inside it, or, where there is none yet, where it will be.
        auto staging =
            TemporaryFolder::create(std::filesystem::is_directory(absolute, code) ? absolute : (absolute / "").parent_path().parent_path());
        if (!staging) return tl::make_unexpected(staging.error());
        auto done = cookInto(staging->path());
        digests_->save();
        return done;
    }

    Result<void> cookInto(const std::filesystem::path& staging) {
        const ExecuteOptions executeOptions{outcome_.output, options_.force, options_.keepGoing};
        const std::vector<Action> needsGraph = planNeeds(scene_);
        const ExecutionResult materials = execute(needsGraph, executeOptions, staging, cache_, *digests_, state_);
        outcome_.errors = materials.errors;
        if (!materials.errors.empty() && (!options_.keepGoing || state_.interrupted)) return {};
        std::vector<const ActionRecord*> materialRecords;  // of meshes that can be read: of others nothing is known
        for (const auto& [id, record] : materials.records) materialRecords.push_back(&record);
        const Needs needs = resolveNeeds(scene_, materialRecords);
        PlanOptions planOptions{options_.only, options_.onlyKind, options_.repair, options_.samples};
        auto plan = planScene(scene_, needs, planOptions);
        if (!plan) return tl::make_unexpected(plan.error());
        meshBytes_ = mostMeshBytes(plan->undecided, materials);

        ExecutionResult result = execute(plan->actions, executeOptions, staging, cache_, *digests_, state_);
        if (!plan->undecided.empty() && (result.errors.empty() || options_.keepGoing) && !state_.interrupted) {
            auto decided = decideLayouts(*plan, needs, planOptions, executeOptions, staging, result);
            if (!decided) return tl::make_unexpected(decided.error());
            plan = std::move(*decided);
        }
        outcome_.actionsRun = materials.actionsRun + result.actionsRun;
        outcome_.actionsReused = materials.actionsReused + result.actionsReused;
        for (const Error& error : result.errors)
            if (!isTold(error)) outcome_.errors.push_back(error);
        if (!result.errors.empty() && (!options_.keepGoing || state_.interrupted)) return {};
        if (auto published = publish(result, staging, outcome_.output); !published) return published;
        if (auto written = writeSummaries(*plan, result); !written) return written;
        if (options_.depfile) {
            // The manifest speaks of all assets, those too that --only left alone.
            planOptions.only = {};
            const auto whole = planScene(scene_, needs, planOptions);
            if (!whole) return tl::make_unexpected(whole.error());
            std::vector<Action> all = needsGraph;
            all.insert(all.end(), whole->actions.begin(), whole->actions.end());
            if (auto written = writeFile(*options_.depfile, depfileText(scene_, outcome_.output, all)); !written) return written;
        }
        cache_.prune();
        judge(outcome_.report, outcome_.errors);
        return {};
    }

    /// Chooses the layouts that were left open from their trials, cooks and verifies these maps, and adds that to `result`. A trial of a
    /// part of a map may promise too much: then the next better candidate is taken. Gives the plan of the whole scene.
    Result<Plan> decideLayouts(const Plan& open, const Needs& needs, PlanOptions& planOptions, const ExecuteOptions& executeOptions,
                               const std::filesystem::path& staging, ExecutionResult& result) {
        LightMapCandidates candidates;
        for (const std::string& map : open.undecided)
            if (const auto trial = result.records.find("trial/" + map); trial != result.records.end())
                candidates[map] = candidatesOf(trial->second);
        std::uint64_t otherBytes = meshBytes_;
        for (const std::string& name : open.assets)
            if (const auto cooked = result.records.find("cook/" + name); cooked != result.records.end())
                otherBytes += gpuBytesOf(cooked->second.result.at("asset"));
        while (true) {
            planOptions.layouts = choose(candidates, otherBytes);
            auto plan = planScene(scene_, needs, planOptions);
            if (!plan) return plan;
            std::vector<Action> rest;
            for (const Action& action : plan->actions)
                if (planOptions.layouts.contains(lightMapOf(*plan, action.asset)) && !result.records.contains(action.id))
                    rest.push_back(action);
            ExecutionResult chosen = execute(rest, executeOptions, staging, cache_, *digests_, state_);
            const std::vector<std::string> broken = brokenPromises(chosen, planOptions.layouts, candidates);
            if (broken.empty()) {
                result.add(std::move(chosen));
                return plan;
            }
        }
    }

    /// GPU memory that the meshes of light maps may take, at the most: those wait for the layouts.
    std::uint64_t mostMeshBytes(const std::vector<std::string>& lightMaps, const ExecutionResult& materials) const {
        std::uint64_t bytes = 0;
        for (const LightMapEntry& entry : scene_.lightMaps) {
            if (!entry.mesh || std::ranges::find(lightMaps, entry.name) == lightMaps.end()) continue;
            const auto record = materials.records.find("materials/" + entry.mesh->string());
            if (record != materials.records.end()) bytes += record->second.result.at("most_bytes_gpu").get<std::uint64_t>();
        }
        return bytes;
    }

    /// Of a mesh, the light map that it waits for; of others they themselves.
    static const std::string& lightMapOf(const Plan& plan, const std::string& asset) {
        const auto mesh = plan.meshes.find(asset);
        return mesh == plan.meshes.end() ? asset : mesh->second;
    }

    std::map<std::string, std::string> choose(const LightMapCandidates& candidates, std::uint64_t otherBytes) const {
        if (!scene_.output.budgetBytes || scene_.output.isErrorAsked) return smallestWithin(candidates, scene_.output.maxError);
        return bestWithin(candidates, *scene_.output.budgetBytes - std::min(otherBytes, *scene_.output.budgetBytes));
    }

    /// Maps whose verification missed the bound that their trial had kept; their candidates learn the truth.
    std::vector<std::string> brokenPromises(const ExecutionResult& chosen, const std::map<std::string, std::string>& layouts,
                                            LightMapCandidates& candidates) const {
        std::vector<std::string> broken;
        for (const auto& [map, layout] : layouts) {
            const auto verified = chosen.records.find("verify/" + map);
            if (verified == chosen.records.end()) continue;
            const Json& error = verified->second.result.at("verdict").at("stages").back().at("error");
            double found = 0;
            for (const char* kind : {"diffuse", "specular"})
                found = std::max(found, error.at(kind).at("rel_rms").is_number() ? error.at(kind).at("rel_rms").get<double>() : HUGE_VAL);
            LightMapCandidate& candidate = *std::ranges::find(candidates.at(map), layout, &LightMapCandidate::layout);
            if (found > scene_.output.maxError && candidate.error <= scene_.output.maxError) broken.push_back(map);
            candidate.error = found;
        }
        return broken;
    }

    /// Manifest, shader include and reports. With --only, the rows of other assets stay as they were.
    Result<void> writeSummaries(const Plan& plan, const ExecutionResult& result) {
        const auto oldManifest = readManifest(outcome_.output);
        const auto oldReport = readReport(outcome_.output / kReportName);
        std::vector<Json> assets, rows;
        if (options_.only && oldManifest && oldReport) {
            for (const Json& asset : oldManifest->at("assets"))
                if (!isPlanned(plan, asset)) assets.push_back(asset);
            for (const Json& row : oldReport->at("assets"))
                if (!isPlanned(plan, row)) rows.push_back(row);
        }
        for (const std::string& name : plan.assets) {
            const auto cooked = result.records.find("cook/" + name), verified = result.records.find("verify/" + name);
            if (cooked == result.records.end() || verified == result.records.end()) continue;
            assets.push_back(manifestAsset(actionOf(plan, "cook/" + name), actionOf(plan, "verify/" + name), cooked->second,
                                           scene_.directory, *digests_));
            rows.push_back(reportAsset(assets.back(), cooked->second, verified->second));
            if (const auto trial = result.records.find("trial/" + name); trial != result.records.end())
                for (const char* key : {"candidates", "share"}) rows.back()[std::string("trial_") + key] = trial->second.result.at(key);
        }
        const std::string shader = shaders::shaderInclude(formats::lightMapFamilies(layoutsOf(assets)));
        const Json manifest = makeManifest(scene_, outcome_.output, assets, digestOfText(shader));
        const std::string manifestText = sealed(manifest);
        if (oldManifest) removeStale(*oldManifest, manifest);
        if (auto written = writeFileIfChanged(outcome_.output / kShaderName, shader); !written) return written;
        if (auto written = writeFileIfChanged(outcome_.output / kManifestName, manifestText); !written) return written;

        const bool unchanged = outcome_.actionsRun == 0 && oldReport && oldManifest && sealed(*oldManifest) == manifestText &&
                               isSameButForTime(*oldReport, rows) && checkReportFiles(outcome_.output, manifestText, *oldReport).empty();
        if (unchanged) {
            outcome_.report = *oldReport;
            return {};
        }
        const ReportFrame frame{scene_.name, secondsSince(start_), peakResidentBytes(), scene_.output.budgetBytes};
        outcome_.report = makeReport(frame, rows, skipsOf(plan, result, rows));
        const std::string page = renderReportHtml(outcome_.report, outcome_.output);
        if (auto written = writeFile(outcome_.output / kReportHtmlName, page); !written) return written;
        outcome_.report["files"] = {{{"file", kManifestName}, {"digest", digestOfText(manifestText)}},
                                    {{"file", kReportHtmlName}, {"digest", digestOfText(page)}}};
        for (const Json& row : rows) {
            const Json pictures = row.value("preview", Json::object());
            for (const Json& file : pictures) {
                const auto digest = digestOfFile(outcome_.output / file.get<std::string>());
                if (!digest) return tl::make_unexpected(digest.error());
                outcome_.report["files"].push_back({{"file", file}, {"digest", *digest}});
            }
        }
        const std::string reportText = sealed(outcome_.report);
        outcome_.report["digest"] = parseJson(reportText).at("digest");
        return writeFile(outcome_.output / kReportName, reportText);
    }

    bool isTold(const Error& error) const {
        return std::any_of(outcome_.errors.begin(), outcome_.errors.end(), [&](const Error& each) { return each.line() == error.line(); });
    }

    /// The report stands if its rows and its budget are what this cook would write.
    bool isSameButForTime(const Json& old, const std::vector<Json>& rows) const {
        const Json limit = scene_.output.budgetBytes ? Json(*scene_.output.budgetBytes) : Json(nullptr);
        return old.at("assets") == Json(rows) && old.at("budget").at("limit_bytes") == limit;
    }

    static bool isPlanned(const Plan& plan, const Json& asset) {
        return std::find(plan.assets.begin(), plan.assets.end(), asset.at("name").get<std::string>()) != plan.assets.end();
    }
    static const Action& actionOf(const Plan& plan, const std::string& id) {
        return *std::find_if(plan.actions.begin(), plan.actions.end(), [&](const Action& action) { return action.id == id; });
    }
    static std::vector<std::string> layoutsOf(const std::vector<Json>& assets) {
        std::vector<std::string> layouts;
        for (const Json& asset : assets)
            if (asset.at("kind") == "light-map") layouts.push_back(asset.at("layout").get<std::string>());
        return layouts;
    }

    void removeStale(const Json& oldManifest, const Json& manifest) const {
        std::set<std::string> current;
        for (const FileRecord& file : filesOf(manifest)) current.insert(file.name);
        for (const FileRecord& file : filesOf(oldManifest)) {
            std::error_code ignored;
            const bool isPlain = std::filesystem::path(file.name).lexically_normal().generic_string().find("..") != 0 &&
                                 !std::filesystem::path(file.name).is_absolute();
            if (isPlain && !current.contains(file.name)) std::filesystem::remove(outcome_.output / file.name, ignored);
        }
    }

    std::vector<Skip> skipsOf(const Plan& plan, const ExecutionResult& result, const std::vector<Json>& rows) const {
        std::vector<Skip> skips = plan.skipped;
        for (Skip& skip : skips) {
            for (const Json& row : rows) {
                if (skip.lightMap.empty() || row.at("name") != skip.lightMap) continue;
                const double texels = row.at("width").get<double>() * row.at("height").get<double>();
                skip.bytesSaved = static_cast<std::uint64_t>(texels * skip.bitsPerTexel / 8);
                skip.secondsSaved = estimatedSeconds("light-map", texels * 1e-6 * skip.bitsPerTexel / 72);
            }
        }
        for (const auto& [id, seconds] : result.reused) skips.push_back({id, "nothing that it depends on has changed", 0, seconds});
        return skips;
    }

    const CookOptions& options_;
    const RunState& state_;
    Clock::time_point start_;
    Scene scene_;
    Cache cache_;
    std::optional<DigestMemo> digests_;
    Outcome outcome_;
    std::uint64_t meshBytes_ = 0;  ///< see mostMeshBytes
};

/// Files of a cooked folder whose content is not what the cook left: the manifest and the report by their own digests, all others by those
/// that these two have of them. A folder without its report is whole: an engine has no use for one.
std::vector<Error> checkDigests(const std::filesystem::path& folder, const Json& manifest) {
    std::vector<Error> errors;
    const auto add = [&](const Result<void>& checked) {
        if (!checked) errors.push_back(checked.error());
        return checked.has_value();
    };
    const auto text = readFile(folder / kManifestName);
    if (!text) return {text.error()};
    add(checkSeal(*text, (folder / kManifestName).string()));
    for (const FileRecord& file : filesOf(manifest))
        if (auto error = checkFile(folder / file.name, file.digest)) errors.push_back(std::move(*error));
    std::error_code code;
    if (!std::filesystem::exists(folder / kReportName, code)) return errors;
    const auto reportText = readFile(folder / kReportName);
    if (!reportText) return {reportText.error()};
    if (!add(checkSeal(*reportText, (folder / kReportName).string()))) return errors;
    const auto report = readReport(folder / kReportName);
    if (!report) {
        errors.push_back(report.error());
        return errors;
    }
    for (Error& error : checkReportFiles(folder, *text, *report)) errors.push_back(std::move(error));
    return errors;
}

/// Sources must still be those that were cooked: an error against another bake says nothing.
Result<std::map<std::string, std::filesystem::path>> sourcesOf(const Json& asset, const std::filesystem::path& sceneDirectory) {
    std::map<std::string, std::filesystem::path> sources;
    if (!asset.contains("source")) return sources;
    for (const auto& [role, entry] : asset.at("source").at("files").items()) {
        const std::filesystem::path path = sceneDirectory / entry.at("file").get<std::string>();
        const auto digest = digestOfFile(path);
        if (!digest) return tl::make_unexpected(digest.error());
        if (*digest != entry.at("digest").get<std::string>())
            return failure(ErrorCode::Verification, path.string(),
                           fmt::format("found content {}, expected {}: the source changed after {} was cooked", *digest,
                                       entry.at("digest").get<std::string>(), asset.at("name").get<std::string>()));
        sources[role] = path;
    }
    return sources;
}

/// A manifest that is JSON, but not of our making.
Error brokenManifest(const std::filesystem::path& folder, const nlohmann::json::exception& mistake) {
    return {ErrorCode::FileUnreadable, (folder / kManifestName).string(),
            fmt::format("found {}, expected what `lightcook cook` writes", mistake.what())};
}

class Verification {
public:
    Verification(const VerifyOptions& options, const RunState& state) : options_(options), state_(state), start_(Clock::now()) {}

    Outcome run() {
        outcome_.output = options_.folder;
        if (auto done = tryRun(); !done) outcome_.errors.insert(outcome_.errors.begin(), done.error());
        return std::move(outcome_);
    }

private:
    Result<void> tryRun() {
        auto manifest = readManifest(options_.folder);
        if (!manifest) return tl::make_unexpected(manifest.error());
        outcome_.errors = checkDigests(options_.folder, *manifest);
        if (!outcome_.errors.empty()) return {};
        outcome_.errors = checkContract(options_.folder, *manifest);
        auto scratch = TemporaryFolder::create();
        if (!scratch) return tl::make_unexpected(scratch.error());
        const auto previous = readReport(options_.folder / kReportName);
        std::vector<Json> rows;
        for (const Json& asset : manifest->at("assets")) {
            auto row = verifyAsset(*manifest, asset, scratch->path(), previous ? *previous : Json());
            if (!row) return tl::make_unexpected(row.error());
            rows.push_back(std::move(*row));
        }
        std::optional<std::uint64_t> budget;
        if (previous && previous->at("budget").at("limit_bytes").is_number())
            budget = previous->at("budget").at("limit_bytes").get<std::uint64_t>();
        outcome_.report =
            makeReport({manifest->at("scene").get<std::string>(), secondsSince(start_), peakResidentBytes(), budget}, rows, {});
        judge(outcome_.report, outcome_.errors);
        return {};
    }

    Result<Json> verifyAsset(const Json& manifest, const Json& asset, const std::filesystem::path& scratch, const Json& previous) {
        const std::filesystem::path sceneDirectory =
            options_.sources.empty() ? options_.folder / manifest.at("scene_directory").get<std::string>() : options_.sources;
        const auto sources = sourcesOf(asset, sceneDirectory);
        if (!sources) return tl::make_unexpected(sources.error());
        Json parameters = asset.at("verify");
        if (options_.samples && parameters.contains("samples")) parameters["samples"] = *options_.samples;
        const std::string name = asset.at("name").get<std::string>();
        const Action action = verifyAction(name, asset.at("kind").get<std::string>(), *sources, parameters);
        ActionRecord cooked, verified, lightMap;
        std::vector<const ActionRecord*> upstream = {&cooked};
        if (asset.contains("basis")) {
            for (const Json& other : manifest.at("assets"))
                if (other.at("name") == asset.at("basis").at("light_map") && other.at("kind") == "light-map")
                    lightMap.result["asset"] = other;
            if (!lightMap.result.contains("asset"))
                return failure(ErrorCode::Verification, name,
                               fmt::format("found no light map {} in the manifest, expected the one whose bases its vertices name",
                                           asset.at("basis").at("light_map").dump()));
            upstream.push_back(&lightMap);
        }
        cooked.result = {{"asset", asset}, {"bytes_in", 0}};
        if (previous.is_object())
            for (const Json& row : previous.at("assets"))
                if (row.at("name") == name) {
                    cooked.result["bytes_in"] = row.at("bytes_in");
                    cooked.seconds = row.at("seconds").get<double>();
                }
        const auto start = Clock::now();
        auto outcome = actionFunction(action.kind)({action, scratch, options_.folder, upstream, lightMaps_, state_});
        if (!outcome) return tl::make_unexpected(outcome.error());
        verified.result = std::move(outcome->result);
        verified.result.erase("preview");  // drawn in a scratch folder
        verified.seconds = secondsSince(start);
        return reportAsset(asset, cooked, verified);
    }

    const VerifyOptions& options_;
    const RunState& state_;
    Clock::time_point start_;
    LightMapSources lightMaps_;
    Outcome outcome_;
};

}  // namespace

Outcome cookScene(Scene scene, const CookOptions& options, const RunState& state) {
    return Cook(std::move(scene), options, state).run();
}

Outcome cookScene(const CookOptions& options, const RunState& state) {
    auto scene = readScene(options.scene);
    if (!scene) return {{scene.error()}, {}, {}, 0, 0};
    return cookScene(std::move(*scene), options, state);
}

Outcome verifyCooked(const VerifyOptions& options, const RunState& state) {
    try {
        return Verification(options, state).run();
    } catch (const nlohmann::json::exception& mistake) {
        return {{brokenManifest(options.folder, mistake)}, {}, options.folder, 0, 0};
    }
}

formats::Result<void> reconstructLightMap(const std::filesystem::path& folder, const std::string& name, const std::filesystem::path& output,
                                          const RunState& state) try {
    const auto manifest = readManifest(folder);
    if (!manifest) return tl::make_unexpected(manifest.error());
    std::vector<std::string> known;
    for (const Json& asset : manifest->at("assets")) {
        if (asset.at("kind") != "light-map") continue;
        known.push_back(asset.at("name").get<std::string>());
        if (known.back() != name) continue;
        const auto cooked = CookedLightMapReader::open(folder, asset, {}, {}, 0);
        if (!cooked) return tl::make_unexpected(cooked.error());
        auto writer = formats::LightMapWriter::create(output, cooked->width(), cooked->height());
        if (!writer) return tl::make_unexpected(writer.error());
        for (int row = 0; row < cooked->height(); row += kBandRows) {
            if (state.interrupted) return failure(ErrorCode::Interrupted, "reconstruct", "found an interrupt, expected to finish");
            const int rowCount = std::min(kBandRows, cooked->height() - row);
            const auto texels = cooked->read(row, rowCount);
            if (!texels) return tl::make_unexpected(texels.error());
            if (auto appended = writer->append(cooked->verifier().reconstruct(*texels, row, rowCount).view()); !appended) return appended;
        }
        return writer->commit();
    }
    return failure(ErrorCode::InvalidRequest, folder.string(),
                   fmt::format("found no light map '{}', expected one of: {}", name, fmt::join(known, ", ")));
} catch (const nlohmann::json::exception& mistake) {
    return tl::make_unexpected(brokenManifest(folder, mistake));
}

}  // namespace lightcook::pipeline
