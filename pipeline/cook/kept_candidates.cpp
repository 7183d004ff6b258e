#include "pipeline/cook/kept_candidates.h"

#include <algorithm>

#include "formats/light_map_layout.h"
#include "formats/temporaries.h"
#include "pipeline/graph/files.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "candidates";

/// Returns the digest of the bake of a light map; empty without one.
std::string bakeDigestOf(const CookedAsset& asset) {
    if (!asset.source.files) return "";
    const auto source = asset.source.files->find("source");
    return source == asset.source.files->end() ? "" : source->second.digest;
}

/// Returns the files that a cook wrote into a folder, relative to it. The manifest is the last one: a removal that is interrupted can be
/// repeated.
std::vector<fs::path> writtenFiles(const fs::path& folder) {
    std::vector<fs::path> files;
    if (const auto manifest = loadManifest(folder))
        for (const FileRecord& file : filesOf(*manifest)) files.emplace_back(file.name);
    if (const auto report = loadReport(folder / kReportName))
        for (const std::string& picture : picturesOf(report->assets)) files.emplace_back(picture);
    for (const char* name : {kShaderName, kReportHtmlName, kReportName, kManifestName}) files.emplace_back(name);
    return files;
}

/// Removes the files that a cook wrote into a candidate, and the folders above them that are empty then.
void removeCandidate(const fs::path& cooked, const std::string& layout, const NamedPlaces& inputs) {
    const fs::path candidate = candidateFolder({}, layout);
    formats::removeOldTemporaries(cooked / candidate);
    for (const fs::path& file : writtenFiles(cooked / candidate)) {
        const fs::path name = candidate / file;
        if (inputs.contains(cooked / name)) continue;
        removeFileOf(cooked, name);
        removeEmptyFoldersOf(cooked, name);
    }
}

}  // namespace

fs::path candidateFolder(const fs::path& cooked, const std::string& layout) {
    return cooked / kFolder / layout;
}

std::vector<std::string> candidatesIn(const fs::path& cooked) {
    std::vector<std::string> layouts;
    std::error_code ignored;
    for (const formats::LightMapLayoutInfo& row : formats::kLightMapLayouts)
        if (fs::is_regular_file(candidateFolder(cooked, std::string(row.name)) / kManifestName, ignored)) layouts.emplace_back(row.name);
    return layouts;
}

void removeCandidates(const fs::path& cooked, const std::set<std::string>& kept, const NamedPlaces& inputs) {
    for (const std::string& layout : candidatesIn(cooked))
        if (!kept.contains(layout) && !inPlaceOfFolder(cooked, candidateFolder({}, layout) / kManifestName))
            removeCandidate(cooked, layout, inputs);
}

bool isCandidateOf(const Manifest& candidate, const Manifest& cooked) {
    if (candidate.scene != cooked.scene) return false;
    return std::ranges::all_of(cooked.assets, [&](const CookedAsset& asset) {
        if (asset.kind != AssetKind::LightMap) return true;
        const auto other = std::ranges::find(candidate.assets, asset.name, &CookedAsset::name);
        return other != candidate.assets.end() && other->kind == asset.kind && other->width == asset.width &&
               other->height == asset.height && bakeDigestOf(*other) == bakeDigestOf(asset);
    });
}

}  // namespace lightcook::pipeline
