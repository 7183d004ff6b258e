// The files of a cooked folder beside textures and meshes: manifest, shader include, report and its page.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "formats/pending_file.h"
#include "pipeline/cook/plan.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/executor.h"
#include "pipeline/graph/work_rates.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {

/// Return the kind of work that an asset was, and its amount [texels], for WorkRates.
std::string kindOfWork(const CookedAsset& asset);
double workOf(const CookedAsset& asset);

/// Returns why assets of an earlier cook in a folder cannot stay beside those that a plan cooks. They may be of another scene; their
/// textures or UVs may belong to another packing of the charts of a light map that is cooked now; and the manifest has one target, working
/// colour space, lobe and up axis for all. Empty: they can.
std::string whyNotLeft(const Scene& scene, const Plan& plan, const std::filesystem::path& folder);

/// Writes the summaries of one cook.
class SummaryWriter {
public:
    /// isPartial   only some assets were cooked: the entries and rows of the others stay as they are
    SummaryWriter(const Scene& scene, const std::filesystem::path& folder, bool isPartial, DigestMemo& digests);

    /// Adds notes to the rows of these assets. Those of one asset are given in one call.
    void addNotes(const std::map<std::string, Json>& notes) {
        for (const auto& [asset, added] : notes) notes_[asset].update(added);
    }
    /// Takes the seams of the layouts that were verified: LayoutDecision::seams().
    void setSeams(std::map<std::string, std::map<std::string, double>> seams) { seams_ = std::move(seams); }
    /// Adds the errors of actions that failed in a cook that went on with the others.
    void addFailed(const std::vector<formats::Error>& errors) { failed_.insert(failed_.end(), errors.begin(), errors.end()); }
    /// Says which assets the whole scene has, in a cook of some: those that are not in the folder then are named.
    void setSceneAssets(std::vector<std::string> assets) { sceneAssets_ = std::move(assets); }
    /// Says which inputs lint has looked at, in a cook of some assets: the findings on the others stay.
    void setLinted(std::set<std::string> assets) { linted_ = std::move(assets); }
    /// Says what `verify` plans again, for the manifest.
    void setCook(CookRecord cook) { cook_ = std::move(cook); }
    /// Writes manifest, shader and report under temporary names, so that a full disk ends the cook before any output has changed. Returns
    /// the report. That of an earlier cook stays if nothing was run and it says the same.
    /// staging  folder of the files that publish() will move; the page of the report embeds pictures from there
    /// frame   of a new report
    /// rates   of this machine, for what was skipped
    formats::Result<Report> prepare(const Plan& plan, const ExecutionResult& result, const std::filesystem::path& staging,
                                    bool isAnythingRun, ReportFrame frame, const WorkRates& rates);
    /// Writes manifest and shader of a preview under temporary names. There is no report, and commit() removes an earlier one.
    formats::Result<void> preparePreview(const Plan& plan, const ExecutionResult& result);
    /// Gives these files their names, then removes files of an earlier cook: a manifest that stays names no file that is gone.
    formats::Result<void> commit();

private:
    formats::Result<void> collect(const Plan& plan, const ExecutionResult& result, const std::vector<FrontierPoint>& frontier);
    void sortAsInScene();
    formats::Result<void> addAsset(const Plan& plan, const ExecutionResult& result, const std::string& name);
    formats::Result<CookedAsset> entryOf(const Plan& plan, const ActionRecord& cooked, const std::string& name);
    bool isInFolder(const std::string& asset) const;
    std::optional<IncompleteCook> incompleteOf(const Plan& plan) const;
    std::vector<std::string> leftOut(const std::optional<IncompleteCook>& incomplete) const;
    std::vector<Finding> withKeptFindings(std::vector<Finding> found) const;
    std::vector<Skip> keptSkips(const Plan& plan, const std::vector<std::string>& partial) const;
    void addRunsOfKeptRows(std::vector<RunRecord>& runs) const;
    formats::Result<void> prepareFile(const char* name, const std::string& content);
    formats::Result<void> prepareFileIfChanged(const char* name, const std::string& content);
    std::vector<CookRecord> cooksOf(const Plan& plan) const;
    formats::Result<void> prepareManifest(const Plan& plan, const ReportFrame& frame);
    bool isReportCurrent(const ReportFrame& frame, const std::filesystem::path& staging) const;
    formats::Result<Report> prepareReport(Report report, const std::filesystem::path& staging);

    const Scene& scene_;
    std::filesystem::path folder_;
    DigestMemo& digests_;
    std::optional<Manifest> oldManifest_;
    std::optional<Report> oldReport_;
    bool isPartial_;
    std::vector<CookedAsset> assets_;
    std::vector<ReportRow> rows_;  ///< of the report
    std::vector<GltfFile> gltf_;
    std::map<std::string, Json> notes_;  ///< by asset, beside those of its cook
    std::map<std::string, std::map<std::string, double>> seams_;
    std::vector<formats::Error> failed_;
    std::vector<std::string> sceneAssets_;
    std::set<std::string> linted_;
    CookRecord cook_;
    std::string manifestText_;
    std::optional<Manifest> manifest_;           ///< the new one
    std::vector<formats::PendingFile> pending_;  ///< in the order of their appearance
    bool isReportNew_ = false, isPreview_ = false;
};

}  // namespace lightcook::pipeline
