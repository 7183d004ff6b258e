#include "pipeline/cook/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <tuple>
#include <utility>

#include "formats/light_map_layout.h"
#include "formats/pixel_format.h"
#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/light_map/joint_trial.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/unpacked_bake.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/cook/layout_decision.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/self_digest.h"
#include "pipeline/report/exit_codes.h"
#include "pipeline/report/failures.h"
#include "pipeline/report/page.h"
#include "pipeline/scene/named_files.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

bool isPlanned(const Plan& plan, const std::string& asset) {
    return std::ranges::find(plan.assets, asset) != plan.assets.end();
}

/// Returns the light map that an asset belongs to, or is. Empty: none.
std::string lightMapOf(const CookedAsset& asset) {
    return asset.kind == AssetKind::LightMap ? asset.name : asset.lightMap.value_or("");
}

/// Returns true if a cook leaves an asset of an earlier one in the folder. It removes what no longer belongs to a light map that it cooks.
bool isLeft(const Plan& plan, const CookedAsset& asset) {
    return !isPlanned(plan, asset.name) && (plan.unwanted.contains(asset.name) || !isPlanned(plan, lightMapOf(asset)));
}

/// Removes the files of an earlier cook that the new manifest does not name. One that is an input of the scene now stays.
void removeStale(const std::filesystem::path& folder, const Manifest& oldManifest, const Manifest& manifest, const NamedPlaces& inputs) {
    std::set<std::string> current;
    for (const FileRecord& file : filesOf(manifest)) current.insert(file.name);
    for (const FileRecord& file : filesOf(oldManifest))
        if (!current.contains(file.name) && !inputs.contains(folder / file.name)) removeFileOf(folder, file.name);
}

/// Removes the pictures of an earlier report that the new one does not name: of assets that are gone, and of places that were among the
/// worst.
void removeStalePictures(const std::filesystem::path& folder, const std::vector<ReportRow>& oldRows, const std::vector<ReportRow>& rows,
                         const NamedPlaces& inputs) {
    const std::vector<std::string> files = picturesOf(rows);
    const std::set<std::string> current(files.begin(), files.end());
    for (const std::string& file : picturesOf(oldRows))
        if (!current.contains(file) && !inputs.contains(folder / file)) removeFileOf(folder, file);
}

/// Returns the skipped assets, with the bytes of light maps now that their sizes are known, and the actions whose results were reused. Time
/// is that of the work at the measured rate of its kind; none if this machine never did such work.
std::vector<Skip> skipsOf(const Plan& plan, const ExecutionResult& result, const std::vector<CookedAsset>& assets, const WorkRates& rates) {
    std::vector<Skip> skips = plan.skipped;
    for (Skip& skip : skips) {
        const auto lightMap = std::ranges::find(assets, skip.lightMap, &CookedAsset::name);
        if (!skip.lightMap.empty() && lightMap != assets.end()) {
            const glm::ivec2 size(lightMap->width, lightMap->height);
            const std::uint64_t would = bytesOf(skip.images, size), is = bytesOf(skip.instead, size);
            skip.bytesSaved = would - std::min(is, would);
            skip.work.texels = static_cast<double>(lightMap->width) * lightMap->height;
        }
        skip.secondsSaved = std::nan("");
        if (skip.work.kind.empty() || !(skip.work.texels > 0)) continue;
        if (const auto seconds = rates.secondsOf(skip.work.kind, skip.work.texels)) skip.secondsSaved = *seconds;
    }
    for (const auto& [id, seconds] : result.reused)
        skips.push_back({.what = id, .why = "nothing that it depends on has changed", .secondsSaved = seconds});
    return skips;
}

/// Gives an asset of a repacked light map the conventions of the user's bake.
Result<void> describeSource(const PackedLightMap& packed, CookedAsset& asset) {
    LC_TRY(repacked, descriptionOf(asset));
    formats::LightMapDescription description = packed.bake.description;
    if (repacked->constantOf) description.constantOf = glm::ivec2(packed.bake.packing.widthBefore, packed.bake.packing.heightBefore);
    asset.source.description = toJson(description);
    return {};
}

/// Says what packing the charts saved in the textures of an asset.
std::string packingWords(const ChartPacking& packing, const CookedAsset& asset) {
    const bool isUnmoved = packing.width == packing.widthBefore && packing.height == packing.heightBefore;
    if (isUnmoved) return fmt::format("no: {} charts stay where they are, since the map would get no smaller", packing.charts);
    const double scaleX = static_cast<double>(packing.widthBefore) / packing.width,
                 scaleY = static_cast<double>(packing.heightBefore) / packing.height;
    std::int64_t saved = 0;
    for (const CookedTexture& texture : asset.textures) {
        const auto format = formats::pixelFormatFromName(texture.format);
        if (isLookupRole(texture.role) || !format) continue;
        const auto bytes = static_cast<std::uint64_t>(texture.layers) *
                           formats::bytesPerImage(*format, static_cast<int>(std::lround(texture.width * scaleX)),
                                                  static_cast<int>(std::lround(texture.height * scaleY)));
        saved += static_cast<std::int64_t>(bytes) - static_cast<std::int64_t>(texture.bytesGpu);
    }
    const double share = 100.0 / (scaleX * scaleY);
    const std::string fewer = packing.reducedCharts > 0
                                  ? fmt::format("{} of {} charts with fewer texels", packing.reducedCharts, packing.charts)
                                  : fmt::format("{} charts moved, none with fewer texels", packing.charts);
    return fmt::format("{} x {} texels of {} x {} ({:.1f} %), {:.1f} KiB {} in this layout; {}", packing.width, packing.height,
                       packing.widthBefore, packing.heightBefore, share, static_cast<double>(std::abs(saved)) / 1024,
                       saved < 0 ? "more" : "less", fewer);
}

/// Adds the trial of a light map to its row, with the layout that the scene's list lacks and that would have been better.
void addTrial(TrialResult trial, const Limits& limits, ReportRow& row) {
    if (const TrialCandidate* excluded = bestExcluded(trial.candidates, row.triedLayout(), limits)) {
        const auto chosen = std::ranges::find(trial.candidates, row.triedLayout(), &TrialCandidate::layout);
        row.betterExcluded = ExcludedLayout{excluded->layout,
                                            static_cast<std::int64_t>(chosen->bytesGpu) - static_cast<std::int64_t>(excluded->bytesGpu),
                                            std::max(chosen->diffuse, chosen->specular),
                                            std::max(excluded->diffuse, excluded->specular),
                                            std::max(chosen->visibleDiffuse, chosen->visibleSpecular),
                                            std::max(excluded->visibleDiffuse, excluded->visibleSpecular)};
    }
    row.trialCandidates = std::move(trial.candidates);
    row.trialShare = trial.share;
}

/// Gives the row of an asset of a repacked light map the bytes and the counts of the user's files.
void describeSources(const PackedLightMap& packed, const CookedAsset& asset, ReportRow& row) {
    const std::string role = row.kind == AssetKind::Mesh ? "mesh" : "source";
    row.bytesIn = 0;
    for (const auto& [name, file] : packed.sources) {
        std::error_code code;
        const auto bytes = std::filesystem::file_size(file, code);
        if (name.starts_with(role) && !code) row.bytesIn += bytes;
    }
    if (row.kind == AssetKind::Mesh) return;
    if (!row.notes) row.notes = Json::object();
    if (row.kind == AssetKind::LightMap) row.notes->update(packed.notes);
    (*row.notes)[note_keys::kPacking] = packingWords(packed.bake.packing, asset);
}

/// Adds to the record of a cook the assets of an earlier one, and what was found and decided for them. Returns false if that cooked another
/// scene.
bool takeOver(const CookRecord& old, CookRecord& current) {
    const auto sceneOf = [](CookRecord cook) {
        cook.assets.clear();
        cook.needs.contents.clear();
        cook.needs.unusedProbes.clear();
        cook.decisions = {};
        return toJson(cook);
    };
    if (sceneOf(old) != sceneOf(current)) return false;
    const auto take = [&](const auto& from, auto& to) {
        for (const auto& each : from)
            if (!current.assets.contains(each.first)) to.insert(each);
    };
    take(old.needs.contents, current.needs.contents);
    take(old.decisions.layouts, current.decisions.layouts);
    take(old.decisions.kept, current.decisions.kept);
    if (!current.decisions.kept.empty() && current.decisions.keptFrom.empty()) current.decisions.keptFrom = old.decisions.keptFrom;
    if (!current.assets.contains(kTablesName)) current.decisions.tableViews = old.decisions.tableViews;
    for (const auto& [from, to] : {std::pair(&old.decisions.unlimited, &current.decisions.unlimited),
                                   std::pair(&old.needs.unusedProbes, &current.needs.unusedProbes)})
        std::ranges::copy_if(*from, std::inserter(*to, to->end()), [&](const auto& name) { return !current.assets.contains(name); });
    current.assets.insert(old.assets.begin(), old.assets.end());
    return true;
}

}  // namespace

std::string whyNotLeft(const Scene& scene, const Plan& plan, const std::filesystem::path& folder) {
    auto old = loadManifest(folder);
    if (!old) return {};
    if (old->isPreview)
        return fmt::format("found a preview in {}, expected a release beside the asset: cook the whole scene, without --only",
                           folder.string());
    const auto isUndecided = [&](const CookedAsset& asset) { return std::ranges::count(plan.undecided, lightMapOf(asset)) > 0; };
    const auto isOfOtherScene = [&](const CookedAsset& asset) { return isLeft(plan, asset) && !isUndecided(asset); };
    if (const auto other = std::ranges::find_if(old->assets, isOfOtherScene); old->scene != scene.name && other != old->assets.end())
        return fmt::format(
            "found '{}' of the scene '{}' in {}, expected assets of '{}' alone: cook into another folder, or the whole scene, "
            "without --only, which replaces them",
            other->name, old->scene, folder.string(), scene.name);
    std::set<std::string> packed;
    for (const CookedAsset& asset : old->assets)
        if (asset.verify && asset.verify->contains(kUnpackedKey)) packed.insert(asset.name);
    std::erase_if(old->assets, [&](const CookedAsset& asset) { return !plan.unwanted.contains(asset.name); });
    if (old->assets.empty()) return {};
    for (const CookedAsset& asset : old->assets)
        if (std::ranges::find(plan.lightMaps, lightMapOf(asset)) != plan.lightMaps.end() && packed.contains(lightMapOf(asset)))
            return fmt::format("found '{}' of an earlier cook with packed charts, expected the whole light map to be cooked: --only {}",
                               asset.name, plan.lightMaps.front());
    const std::string left = std::exchange(old->assets, {}).front().name;
    const Json before = toJson(*old), now = toJson(makeManifest(scene, folder, {}, {}, ""));
    for (const char* key : {"target", "color", "lobe", "up_axis"})
        if (before.at(key) != now.at(key))
            return fmt::format("found '{}' of an earlier cook with {} = {}, expected {} of this one: cook the whole scene, without --only",
                               left, key, before.at(key).dump(), now.at(key).dump());
    return {};
}

SummaryWriter::SummaryWriter(const Scene& scene, const std::filesystem::path& folder, bool isPartial, DigestMemo& digests)
    : scene_(scene), folder_(folder), digests_(digests) {
    if (auto manifest = loadManifest(folder)) oldManifest_ = std::move(*manifest);
    if (auto report = loadReport(folder / kReportName)) oldReport_ = std::move(*report);
    isPartial_ = isPartial && oldManifest_ && oldReport_;
}

std::string kindOfWork(const CookedAsset& asset) {
    // A flat map costs less than one with directions.
    const bool isFlat = asset.kind == AssetKind::LightMap && formats::isFlat(asset.layout);
    return std::string(info(asset.kind).name) + (isFlat ? "/flat" : "");
}

double workOf(const CookedAsset& asset) {
    return static_cast<double>(asset.width) * asset.height;
}

/// Adds the runs of the rows that this cook left alone.
void SummaryWriter::addRunsOfKeptRows(std::vector<RunRecord>& runs) const {
    if (!isPartial_) return;
    for (const RunRecord& run : oldReport_->runs) {
        const auto names = [&](const ReportRow& row) { return row.cookedAt == run.at || row.verifiedAt == run.at; };
        const bool isKnown = std::ranges::find(runs, run.at, &RunRecord::at) != runs.end();
        if (!isKnown && std::ranges::any_of(rows_, names)) runs.push_back(run);
    }
    std::ranges::sort(runs, {}, &RunRecord::at);
}

Result<Report> SummaryWriter::prepare(const Plan& plan, const ExecutionResult& result, const std::filesystem::path& staging,
                                      bool isAnythingRun, ReportFrame frame, const WorkRates& rates) {
    LC_CHECK(collect(plan, result, frame.frontier));
    frame.incomplete = incompleteOf(plan);
    frame.partial = leftOut(frame.incomplete);
    frame.findings = withKeptFindings(std::move(frame.findings));
    LC_CHECK(prepareManifest(plan, frame));
    if (!isAnythingRun && isReportCurrent(frame, staging)) return *oldReport_;
    addRunsOfKeptRows(frame.runs);
    std::vector<Skip> skips = keptSkips(plan, frame.partial);
    for (Skip& skip : skipsOf(plan, result, assets_, rates)) skips.push_back(std::move(skip));
    return prepareReport(makeReport(frame, rows_, std::move(skips)), staging);
}

Result<void> SummaryWriter::preparePreview(const Plan& plan, const ExecutionResult& result) {
    isPreview_ = true;
    for (const std::string& name : plan.assets) {
        const auto cooked = result.records.find(actionId(ActionStep::Cook, name));
        if (cooked == result.records.end()) continue;
        LC_TRY(asset, entryOf(plan, cooked->second, name));
        assets_.push_back(std::move(*asset));
    }
    return prepareManifest(plan, {});
}

Result<void> SummaryWriter::commit() {
    for (formats::PendingFile& file : pending_) LC_CHECK(file.commit());
    const NamedPlaces inputs(scene_);
    if (oldManifest_) removeStale(folder_, *oldManifest_, *manifest_, inputs);
    if (isPreview_)
        for (const char* name : {kReportName, kReportHtmlName})
            if (!inputs.contains(folder_ / name)) removeFileOf(folder_, name);
    if ((isReportNew_ || isPreview_) && oldReport_) removeStalePictures(folder_, oldReport_->assets, rows_, inputs);
    return {};
}

Result<void> SummaryWriter::prepareFile(const char* name, const std::string& content) {
    LC_TRY(file, formats::prepareWholeFile(folder_ / name, std::as_bytes(std::span(content)), formats::OutputLink::Replace));
    pending_.push_back(std::move(*file));
    return {};
}

Result<void> SummaryWriter::prepareFileIfChanged(const char* name, const std::string& content) {
    LC_TRY(file, pipeline::prepareFileIfChanged(folder_ / name, content));
    if (*file) pending_.push_back(std::move(**file));
    return {};
}

/// Adds to the findings of a cook of some assets those on inputs that it left alone, in the order of the report before.
std::vector<Finding> SummaryWriter::withKeptFindings(std::vector<Finding> found) const {
    if (!isPartial_) return found;
    std::vector<Finding> all;
    for (const Finding& old : oldReport_->findings) {
        const bool isOfFolder = !old.asset.empty() && (isInFolder(old.asset) || isInFolder(dominantNameOf(old.asset)));
        if (isOfFolder && !linted_.contains(old.asset)) {
            all.push_back(old);
            continue;
        }
        const auto again = std::ranges::find_if(found, [&](const Finding& each) { return toJson(each) == toJson(old); });
        if (again == found.end()) continue;
        all.push_back(std::move(*again));
        found.erase(again);
    }
    std::ranges::move(found, std::back_inserter(all));
    return all;
}

/// Returns the skips in the report before of assets that this cook leaves alone.
std::vector<Skip> SummaryWriter::keptSkips(const Plan& plan, const std::vector<std::string>& partial) const {
    std::vector<Skip> kept;
    if (!isPartial_) return kept;
    for (const Skip& skip : oldReport_->skipped)
        if (plan.unwanted.contains(skip.asset) && std::ranges::find(partial, skip.asset) == partial.end()) kept.push_back(skip);
    return kept;
}

bool SummaryWriter::isInFolder(const std::string& asset) const {
    return std::ranges::find(assets_, asset, &CookedAsset::name) != assets_.end();
}

/// Returns the assets of the scene that are not in the folder because nobody asked for them. The light of a map that this cook has not read
/// may have nothing to fit a dominant light to: the cook of the map has decided it.
std::vector<std::string> SummaryWriter::leftOut(const std::optional<IncompleteCook>& incomplete) const {
    std::vector<std::string> names;
    const auto isFailed = [&](const std::string& name) {
        return incomplete && std::ranges::find(incomplete->assets, name) != incomplete->assets.end();
    };
    const auto isDecided = [&](const std::string& name) {
        if (!isPartial_ || std::ranges::find(oldManifest_->partial, name) != oldManifest_->partial.end()) return false;
        return std::ranges::any_of(
            assets_, [&](const CookedAsset& asset) { return asset.kind == AssetKind::LightMap && dominantNameOf(asset.name) == name; });
    };
    for (const std::string& name : sceneAssets_)
        if (!isInFolder(name) && !isFailed(name) && !isDecided(name)) names.push_back(name);
    return names;
}

/// Returns what this cook could not make and, of a cook of some assets, what the one before could not and this one did not try.
std::optional<IncompleteCook> SummaryWriter::incompleteOf(const Plan& plan) const {
    IncompleteCook incomplete;
    const auto add = [&](const std::string& name) {
        if (!isInFolder(name) && std::ranges::find(incomplete.assets, name) == incomplete.assets.end()) incomplete.assets.push_back(name);
    };
    const auto addError = [&](const FailedAction& failed) {
        if (std::ranges::find(incomplete.errors, failed) == incomplete.errors.end()) incomplete.errors.push_back(failed);
    };
    for (const formats::Error& error : failed_) addError({DocumentError::of(error)});
    if (!failed_.empty()) {
        std::ranges::for_each(plan.assets, add);
        std::ranges::for_each(plan.undecided, add);
    }
    if (isPartial_ && oldReport_->incomplete) {
        bool isAnyLeft = oldReport_->incomplete->assets.empty();  // then nobody knows whose errors they are
        for (const std::string& name : oldReport_->incomplete->assets) {
            if (isPlanned(plan, name)) continue;
            add(name);
            isAnyLeft = true;
        }
        if (isAnyLeft) std::ranges::for_each(oldReport_->incomplete->errors, addError);
    }
    if (incomplete.errors.empty()) return std::nullopt;
    return incomplete;
}

/// Collects entries and rows in the order of the scene.
Result<void> SummaryWriter::collect(const Plan& plan, const ExecutionResult& result, const std::vector<FrontierPoint>& frontier) {
    if (isPartial_) {
        std::set<std::string> left;
        for (const CookedAsset& asset : oldManifest_->assets) {
            if (!isLeft(plan, asset)) continue;
            assets_.push_back(asset);
            left.insert(asset.name);
        }
        for (const ReportRow& row : oldReport_->assets)
            if (left.contains(row.name)) rows_.push_back(row);
        for (const GltfFile& gltf : oldManifest_->gltf)
            if (left.contains(gltf.lightMap)) gltf_.push_back(gltf);
    }
    for (const std::string& name : plan.assets) {
        LC_CHECK(addAsset(plan, result, name));
        if (const auto gltf = result.records.find(actionId(ActionStep::Gltf, name)); gltf != result.records.end())
            for (const FileRecord& file : gltf->second.files) gltf_.push_back({file.name, name, file.digest});
    }
    if (isPartial_) sortAsInScene();
    addFailures(rows_, scene_.file.empty() ? LimitsFrom::Converter : LimitsFrom::SceneFile,
                scene_.output.budgetBytes ? frontier : std::vector<FrontierPoint>());
    return {};
}

/// Sorts what earlier cooks and this one made as a cook of the whole scene has it: the assets of each light map, probes, gradients, tables.
void SummaryWriter::sortAsInScene() {
    const auto indexIn = [](const auto& entries, const std::string& name) {
        return std::ranges::find_if(entries, [&](const auto& entry) { return entry.name == name; }) - entries.begin();
    };
    const auto placeOf = [&](const CookedAsset& asset) {
        enum Part { OfLightMaps, Probes, Gradients, Tables };
        switch (asset.kind) {
            case AssetKind::LightMap:
                return std::tuple(OfLightMaps, indexIn(scene_.lightMaps, asset.name), 0);
            case AssetKind::Dominant:
                return std::tuple(OfLightMaps, indexIn(scene_.lightMaps, lightMapOf(asset)), 1);
            case AssetKind::Mesh:
                return std::tuple(OfLightMaps, indexIn(scene_.lightMaps, lightMapOf(asset)), 2);
            case AssetKind::Cubemap:
                return std::tuple(Probes, indexIn(scene_.probes, asset.name), 0);
            case AssetKind::Rsrm:
                return std::tuple(Gradients, indexIn(scene_.gradients, asset.name), 0);
            case AssetKind::Lut:
                break;
        }
        return std::tuple(Tables, std::ptrdiff_t{0}, 0);
    };
    std::ranges::stable_sort(assets_, {}, placeOf);
    std::ranges::stable_sort(rows_, {}, [&](const ReportRow& row) { return indexIn(assets_, row.name); });
    std::ranges::stable_sort(gltf_, {}, [&](const GltfFile& gltf) { return indexIn(scene_.lightMaps, gltf.lightMap); });
}

/// Returns the entry of an asset in the manifest, without its verification.
Result<CookedAsset> SummaryWriter::entryOf(const Plan& plan, const ActionRecord& cooked, const std::string& name) {
    LC_TRY(asset, manifestAsset(cooked, sourcesOf(plan, name), scene_.directory, digests_));
    if (const auto packed = plan.packed.find(name); packed != plan.packed.end()) LC_CHECK(describeSource(packed->second, *asset));
    return std::move(*asset);
}

Result<void> SummaryWriter::addAsset(const Plan& plan, const ExecutionResult& result, const std::string& name) {
    const auto cooked = result.records.find(actionId(ActionStep::Cook, name)),
               verified = result.records.find(actionId(ActionStep::Verify, name));
    if (cooked == result.records.end() || verified == result.records.end()) return {};
    const auto packed = plan.packed.find(name);
    LC_TRY(asset, entryOf(plan, cooked->second, name));
    asset->verify = actionOf(plan, verified->first).parameters;
    const auto recordOf = [&](ActionStep step) {
        const auto found = result.records.find(actionId(step, name));
        return found == result.records.end() ? nullptr : &found->second;
    };
    LC_TRY(row, reportRow(*asset, {&cooked->second, &verified->second, recordOf(ActionStep::Whole)}));
    if (packed != plan.packed.end()) describeSources(packed->second, *asset, *row);
    if (const auto record = result.records.find(actionId(ActionStep::Trial, name)); record != result.records.end()) {
        LC_TRY(trial, trialIn(record->second));
        // Whatever else allows a smaller layout, one of a large error is not better.
        Limits limits = layoutLimitsOf(scene_, name);
        limits[Limit::Error] = errorLimit(scene_.output);
        if (const auto seams = seams_.find(name); seams != seams_.end())
            for (TrialCandidate& each : trial->trial.candidates)
                if (const auto seam = seams->second.find(each.layout); seam != seams->second.end()) each.seam = seam->second;
        addTrial(std::move(trial->trial), limits, *row);
    }
    if (const auto notes = notes_.find(name); notes != notes_.end()) {
        if (!row->notes) row->notes = Json::object();
        row->notes->update(notes->second);
    }
    assets_.push_back(std::move(*asset));
    rows_.push_back(std::move(*row));
    return {};
}

/// Returns the earlier cooks whose assets are still there, and this one, the last. Cooks of the same scene are one.
std::vector<CookRecord> SummaryWriter::cooksOf(const Plan& plan) const {
    std::vector<CookRecord> cooks;
    CookRecord current = cook_;
    for (CookRecord old : isPartial_ ? oldManifest_->cooks : std::vector<CookRecord>()) {
        std::erase_if(old.assets, [&](const std::string& name) { return plan.wanted.contains(name) || isPlanned(plan, name); });
        if (std::ranges::none_of(old.assets, [&](const std::string& name) { return isInFolder(name); })) continue;
        if (!takeOver(old, current)) cooks.push_back(std::move(old));
    }
    cooks.push_back(std::move(current));
    return cooks;
}

Result<void> SummaryWriter::prepareManifest(const Plan& plan, const ReportFrame& frame) {
    const std::string shader = shaderTextOf(assets_, scene_.lobe);
    Manifest manifest = makeManifest(scene_, folder_, assets_, gltf_, digestOfText(shader));
    manifest.cooks = cooksOf(plan);
    if (frame.incomplete) manifest.incomplete = frame.incomplete->assets;
    manifest.partial = frame.partial;
    manifest.isPreview = isPreview_;
    manifestText_ = withSelfDigest(toJson(manifest));
    manifest_ = std::move(manifest);
    LC_CHECK(prepareFileIfChanged(kShaderName, shader));
    return prepareFileIfChanged(kManifestName, manifestText_);
}

/// Returns true if the earlier report has the rows and the budget of this cook, and belongs to the files that are there or staged.
bool SummaryWriter::isReportCurrent(const ReportFrame& frame, const std::filesystem::path& staging) const {
    if (!oldReport_ || !oldManifest_ || withSelfDigest(toJson(*oldManifest_)) != manifestText_) return false;
    return jsonOf(oldReport_->assets) == jsonOf(rows_) && jsonOf(oldReport_->findings) == jsonOf(frame.findings) &&
           jsonOf(oldReport_->budget.frontier) == jsonOf(asCooked(frame.frontier, rows_)) && oldReport_->incomplete == frame.incomplete &&
           oldReport_->partial == frame.partial && oldReport_->budget.limitBytes == scene_.output.budgetBytes &&
           checkReportFiles({folder_, staging}, manifestText_, *oldReport_).empty();
}

/// Writes the page and the report with the digests of all files that go with it. Returns the report with its own digest.
Result<Report> SummaryWriter::prepareReport(Report report, const std::filesystem::path& staging) {
    const StagedFolder files(folder_, staging);
    const std::string page = renderReportHtml(report, files);
    LC_CHECK(prepareFile(kReportHtmlName, page));
    report.files = {{kManifestName, digestOfText(manifestText_)}, {kReportHtmlName, digestOfText(page)}};
    for (const ReportRow& row : rows_) {
        for (const std::string& file : row.pictures()) {
            LC_TRY(digest, digestOfFile(files.of(file) / file));
            report.files->push_back({file, *digest});
        }
    }
    const std::string text = withSelfDigest(toJson(report));
    LC_CHECK(prepareFile(kReportName, text));
    isReportNew_ = true;
    return fromJson<Report>(parseJson(text), kReportName);
}

}  // namespace lightcook::pipeline
