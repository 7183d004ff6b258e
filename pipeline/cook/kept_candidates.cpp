#include "pipeline/cook/kept_candidates.h"

#include <algorithm>

#include "formats/light_map_layout.h"
#include "pipeline/graph/files.h"

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

void removeCandidates(const fs::path& cooked, const std::set<std::string>& kept) {
    if (inPlaceOfFolder(cooked, fs::path(kFolder) / kManifestName)) return;  // a link, or a file of somebody else
    std::error_code ignored;
    for (const std::string& layout : candidatesIn(cooked))
        if (!kept.contains(layout)) fs::remove_all(candidateFolder(cooked, layout), ignored);
    fs::remove(cooked / kFolder, ignored);  // if it is empty
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
