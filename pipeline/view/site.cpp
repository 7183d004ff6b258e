#include "pipeline/view/site.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "formats/temporaries.h"
#include "pipeline/assets/verdict.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/cook/kept_candidates.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/file_list.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;
namespace fs = std::filesystem;

constexpr const char* kCookedPrefix = "cooked/";
const std::string kSceneDataName = fmt::format("{}/scene.json", kViewerFolder);
/// Names the files of the site, so that an export over it knows which files are its own.
const std::string kFileListName = fmt::format("{}/files.json", kViewerFolder);

struct MediaType {
    std::string_view extension, type;
};
constexpr MediaType kMediaTypes[] = {
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".mjs", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".wasm", "application/wasm"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".ktx2", "image/ktx2"},
    {".dds", "image/vnd-ms.dds"},
    {".glb", "model/gltf-binary"},
    {".gltf", "model/gltf+json"},
    {".glsl", "text/plain; charset=utf-8"},
    {".txt", "text/plain; charset=utf-8"},
};

/// Returns true if a file lies inside a folder once symbolic links are followed.
bool liesInside(const fs::path& file, const fs::path& folder) {
    std::error_code code;
    const fs::path inner = fs::canonical(file, code), outer = fs::canonical(folder, code);
    if (code) return false;
    return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

/// Fails unless an export may be written to a folder.
Result<void> checkExportPlace(const fs::path& folder) {
    std::error_code code;
    if (!fs::exists(folder, code)) return {};
    if (!fs::is_directory(folder, code)) return failure(ErrorCode::InvalidRequest, folder, "found a file, expected a folder or none");
    if (fs::is_empty(folder, code) || fs::exists(folder / kSceneDataName, code) || fs::exists(folder / kFileListName, code)) return {};
    return failure(ErrorCode::InvalidRequest, folder,
                   "found a folder with other files, expected none, an empty one, or an earlier export of view");
}

/// Fails if a file of the site would replace something that no export wrote.
/// earlier   files of the earlier export; nothing: of an export without a list, whose files have the names of this one
Result<void> checkReplaced(const Site& site, const fs::path& folder, const std::optional<FileNames>& earlier) {
    for (const auto& [name, file] : site.files()) {
        if (const auto found = inPlaceOfFolder(folder, name))
            return failure(ErrorCode::InvalidRequest, found->string(),
                           "found a file or a link that no export wrote, expected a folder of the page there: move it");
        std::error_code code;
        const fs::file_status status = fs::symlink_status(folder / name, code);
        if (fs::is_directory(status) || (fs::exists(status) && earlier && !earlier->contains(name)))
            return failure(ErrorCode::InvalidRequest, folder / name,
                           fmt::format("found a {} that no export wrote, expected a file of the page there: move it",
                                       fs::is_directory(status) ? "folder" : "file"));
    }
    return {};
}

/// Removes a file of an earlier export, and the folders that are empty then.
Result<void> removeExported(const fs::path& folder, const fs::path& name) {
    if (inPlaceOfFolder(folder, name)) return {};
    std::error_code code;
    if (fs::is_directory(fs::symlink_status(folder / name, code))) return {};
    fs::remove(folder / name, code);
    if (code)
        return failure(ErrorCode::Internal, folder / name,
                       fmt::format("found '{}', expected to remove a file of the earlier export", code.message()));
    removeEmptyFoldersOf(folder, name);
    return {};
}

/// Moves the files of a site into a folder that exists, and removes those of the earlier export that are no longer there. Every other file
/// stays. The list names the files of both exports until the end, so that an export after a killed one knows them.
Result<void> replaceExport(const Site& site, const fs::path& fresh, const fs::path& folder, const std::optional<FileNames>& earlier) {
    FileNames both = earlier.value_or(FileNames());
    for (const auto& [name, file] : site.files()) both.insert(name);
    LC_CHECK(writeFile(folder / kFileListName, listText(both)));
    const auto move = [&](const std::string& name) -> Result<void> {
        LC_CHECK(makeFolder((folder / name).parent_path()));
        return moveFile(fresh / name, folder / name);
    };
    // The page comes after what it loads.
    for (const auto& [name, file] : site.files())
        if (name != kPageName && name != kFileListName) LC_CHECK(move(name));
    if (site.files().contains(kPageName)) LC_CHECK(move(kPageName));
    for (const std::string& name : both)
        if (!site.files().contains(name)) LC_CHECK(removeExported(folder, name));
    return move(kFileListName);
}

/// Fails if a texture is no KTX2 file: the page reads no others.
Result<void> requireKtx2(const fs::path& folder, const Manifest& manifest) {
    for (const CookedAsset& asset : manifest.assets)
        for (const CookedTexture& texture : asset.textures)
            if (fs::path(texture.file).extension() == ".dds")
                return failure(ErrorCode::FormatUnsupported, folder / texture.file,
                               "found a DDS texture, which the page does not read, expected KTX2: cook with container = \"ktx2\"");
    return {};
}

Result<void> writeSiteFile(const SiteFile& file, const fs::path& place) {
    return file.onDisk() != nullptr ? copyFile(*file.onDisk(), place) : writeFile(place, file.inMemory());
}

}  // namespace

std::string_view SiteFile::inMemory() const {
    const auto* text = std::get_if<std::string>(&content);
    return text != nullptr ? std::string_view(*text) : std::get<std::string_view>(content);
}

std::string_view mediaTypeOf(std::string_view name) {
    for (const MediaType& row : kMediaTypes)
        if (name.ends_with(row.extension)) return row.type;
    return "application/octet-stream";
}

Result<void> Site::addCooked(const fs::path& folder, const std::string& prefix, const std::string& name) {
    const fs::path file = folder / name;
    if (!liesInside(file, folder))
        return failure(ErrorCode::FileUnreadable, file, "found a symbolic link out of the folder, expected a file in it");
    files_[prefix + name] = {fs::absolute(file), mediaTypeOf(name)};
    return {};
}

Result<std::optional<ViewedCandidate>> Site::addCandidate(const fs::path& cooked, const Manifest& manifest, const std::string& layout) {
    const fs::path folder = candidateFolder(cooked, layout);
    LC_TRY(own, loadManifest(folder));
    if (!isCandidateOf(*own, manifest)) {
        notes_.push_back(fmt::format("{} is left out: it is of another cook", folder.string()));
        return std::nullopt;
    }
    if (const auto errors = checkDigests(folder, *own); !errors.empty()) return tl::make_unexpected(errors.front());
    LC_TRY(report, loadReport(folder / kReportName));
    ViewedCandidate candidate{layout, (candidateFolder(kCookedPrefix, layout) / "").generic_string(), 0, 0};
    // Cubemaps, tables and dominant lights on the page are those of the cooked scene.
    std::vector<std::string> names = {kManifestName, own->shader.file};
    for (const CookedAsset& asset : own->assets) {
        if (asset.kind != AssetKind::LightMap && asset.kind != AssetKind::Mesh) continue;
        for (const CookedTexture& texture : asset.textures) names.push_back(texture.file);
        if (asset.file) names.push_back(*asset.file);
        if (asset.kind != AssetKind::LightMap) continue;
        candidate.bytesGpu += asset.totalBytesGpu();
        if (const auto row = std::ranges::find(report->assets, asset.name, &ReportRow::name); row != report->assets.end())
            candidate.visible = std::max(candidate.visible, visibleP99(row->verdict.stages.back()).value_or(0));
    }
    for (const std::string& name : names) LC_CHECK(addCooked(folder, candidate.folder, name));
    return candidate;
}

Result<void> Site::addCookedFolder(const fs::path& folder, const Manifest& manifest) {
    std::vector<std::string> names = {kManifestName};
    for (const FileRecord& file : filesOf(manifest)) names.push_back(file.name);
    if (const auto report = loadReport(folder / kReportName)) {
        names.push_back(kReportName);
        for (const ReportFile& file : report->files.value_or(std::vector<ReportFile>())) names.push_back(file.file);
    }
    for (const std::string& name : names) LC_CHECK(addCooked(folder, kCookedPrefix, name));
    return {};
}

void Site::addReferences(const std::vector<ViewedLightMap>& maps, bool hasSources) {
    for (const ViewedLightMap& map : maps)
        if (map.reference)
            files_[*map.reference] = {scratch_ / fs::path(*map.reference).filename(), mediaTypeOf(*map.reference)};
        else
            notes_.push_back(fmt::format("{} is shown without its bake: {}{}", map.name, map.referenceMissing.value_or(""),
                                         hasSources ? "" : ". If the scene's folder has moved, name it with --sources"));
}

Result<std::vector<ViewedCandidate>> Site::addCandidates(const fs::path& cooked, const Manifest& manifest) {
    std::vector<ViewedCandidate> candidates;
    for (const std::string& layout : candidatesIn(cooked)) {
        LC_TRY(candidate, addCandidate(cooked, manifest, layout));
        if (*candidate) candidates.push_back(std::move(**candidate));
    }
    std::ranges::sort(candidates, {}, &ViewedCandidate::bytesGpu);
    return candidates;
}

Result<Site> Site::open(const SiteOptions& options, const RunState& state) {
    if (options.page.empty())
        return failure(ErrorCode::InvalidRequest, "view",
                       "this build has no viewer; build it with -DLIGHTCOOK_VIEWER=ON, which needs Node");
    const fs::path manifestFile = fs::absolute(options.folder / kManifestName);
    const auto digest = digestOfFile(manifestFile);
    LC_TRY(manifest, loadManifest(options.folder));
    LC_CHECK(requireKtx2(options.folder, *manifest));
    if (const auto errors = checkDigests(options.folder, *manifest); !errors.empty()) return tl::make_unexpected(errors.front());
    LC_TRY(scratch, formats::TemporaryFolder::create());
    Site site(std::move(*scratch));
    site.scene_ = manifest->scene;
    site.manifestFile_ = manifestFile;
    if (digest) site.manifestDigest_ = *digest;
    for (const BundledFile& file : options.page) site.files_[std::string(file.path)] = {file.bytes, mediaTypeOf(file.path)};
    LC_CHECK(site.addCookedFolder(options.folder, *manifest));
    const fs::path sources = options.sources.empty() ? options.folder / manifest->sceneDirectory : options.sources;
    LC_TRY(data, describeForView(*manifest, {options.folder, sources, site.scratch_.path()}, state));
    site.addReferences(data->lightMaps, !options.sources.empty());
    LC_TRY(candidates, site.addCandidates(options.folder, *manifest));
    data->candidates = std::move(*candidates);
    site.files_[kSceneDataName] = {textOf(toJson(*data)) + "\n", mediaTypeOf(kSceneDataName)};
    FileNames all = {kFileListName};
    for (const auto& [path, file] : site.files_) all.insert(path);
    site.files_[kFileListName] = {listText(all), mediaTypeOf(kFileListName)};
    return site;
}

bool Site::isCurrent() const {
    const auto digest = digestOfFile(manifestFile_);
    return digest && digest.value() == manifestDigest_;
}

Result<void> exportSite(const Site& site, const fs::path& asked, const RunState& state) {
    LC_CHECK(checkExportPlace(asked));
    std::error_code code;
    fs::path folder = fs::weakly_canonical(fs::absolute(asked), code);
    if (code) folder = fs::absolute(asked);
    if (!folder.has_filename()) folder = folder.parent_path();
    const bool exists = fs::exists(folder, code);
    const auto earlier = exists ? readFileList(folder / kFileListName) : std::nullopt;
    LC_CHECK(checkReplaced(site, asked, earlier));
    // Staged on the file system of the folder, which may be a mount.
    const fs::path parent = exists ? folder : folder.parent_path();
    LC_TRY(staging, formats::TemporaryFolder::create(parent));
    const fs::path fresh = *staging / "new";
    for (const auto& [path, file] : site.files()) {
        if (state.interrupted) return failure(ErrorCode::Interrupted, "view", "interrupted");
        LC_CHECK(writeSiteFile(file, fresh / path));
    }
    LC_TRY(outputs, formats::OutputTransaction::begin());
    if (exists) return replaceExport(site, fresh, folder, earlier);
    fs::rename(fresh, folder, code);
    if (code)
        return failure(ErrorCode::Internal, folder, fmt::format("found '{}', expected to move the finished export here", code.message()));
    return {};
}

}  // namespace lightcook::pipeline
