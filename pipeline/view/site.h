// The site of `lightcook view` is a list of files: the page itself, the cooked folder, and data made for the page. The list is served on
// loopback (view/server.h), or written into a folder for any web server (exportSite).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "formats/error.h"
#include "formats/temporary_folder.h"
#include "pipeline/graph/action.h"
#include "pipeline/report/bundle.h"
#include "pipeline/view/scene_data.h"

namespace lightcook::pipeline {

/// Path of the page on the site.
inline constexpr const char* kPageName = "index.html";

/// A file of the site.
struct SiteFile {
    std::variant<std::string_view, std::string, std::filesystem::path> content;  ///< bytes of the program, text, or a file
    std::string_view mediaType;

    /// Returns the file on disk; null for content in memory.
    const std::filesystem::path* onDisk() const { return std::get_if<std::filesystem::path>(&content); }
    /// Returns the content in memory. Must not be on disk.
    std::string_view inMemory() const;
};

struct SiteOptions {
    std::filesystem::path folder;   ///< cooked folder
    std::filesystem::path sources;  ///< the scene's folder; empty: as the manifest says
    std::span<const BundledFile> page = viewerBundle();
};

/// Every file that the page may request, by its path relative to the page: "index.html", "cooked/cooked.json", "viewer/scene.json". No
/// other file is read for a request.
class Site {
public:
    /// Checks the digests of the cooked folder, and prepares the bakes in a temporary folder. Refuses symbolic links that lead out of the
    /// cooked folder.
    static formats::Result<Site> open(const SiteOptions& options, const RunState& state);

    const std::map<std::string, SiteFile>& files() const { return files_; }
    const std::string& scene() const { return scene_; }
    /// Returns true while the cooked folder has the manifest that the site was opened with.
    bool isCurrent() const;
    /// Lines for people: light maps that are shown without their bake, and candidates that are left out, and why.
    const std::vector<std::string>& notes() const { return notes_; }

private:
    explicit Site(formats::TemporaryFolder scratch) : scratch_(std::move(scratch)) {}
    /// Adds the manifest, the files that it names, and the report if the folder has one.
    formats::Result<void> addCookedFolder(const std::filesystem::path& folder, const Manifest& manifest);
    /// Adds the float bakes of light maps, and a note for each that has none.
    /// hasSources  true: the user named the scene's folder
    void addReferences(const std::vector<ViewedLightMap>& maps, bool hasSources);
    /// Adds the candidates of the scene, the smallest first.
    formats::Result<std::vector<ViewedCandidate>> addCandidates(const std::filesystem::path& cooked, const Manifest& manifest);
    /// prefix  of the paths on the site
    formats::Result<void> addCooked(const std::filesystem::path& folder, const std::string& prefix, const std::string& name);
    /// Adds a candidate of the scene. Returns nothing, and adds a note, for one of another cook.
    formats::Result<std::optional<ViewedCandidate>> addCandidate(const std::filesystem::path& cooked, const Manifest& manifest,
                                                                 const std::string& layout);

    formats::TemporaryFolder scratch_;
    std::map<std::string, SiteFile> files_;
    std::string scene_;
    std::filesystem::path manifestFile_;
    std::optional<std::string> manifestDigest_;
    std::vector<std::string> notes_;
};

/// Writes every file of a site into a folder. The folder may not exist yet, be empty, or hold an earlier export, which is replaced. Files
/// that no export wrote stay; one with the name of a file of the site is an error, before anything is changed. A folder that did not exist
/// appears whole.
formats::Result<void> exportSite(const Site& site, const std::filesystem::path& folder, const RunState& state);

/// Returns the media type of a file name by its extension.
std::string_view mediaTypeOf(std::string_view name);

}  // namespace lightcook::pipeline
