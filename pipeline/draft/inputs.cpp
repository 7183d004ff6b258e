#include "pipeline/draft/inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "formats/bake_format.h"
#include "formats/environment.h"
#include "formats/epic_light_maps.h"
#include "formats/gltf_scene.h"
#include "formats/light_map.h"
#include "formats/lower_extension.h"
#include "formats/plain_image.h"
#include "pipeline/graph/files.h"
#include "pipeline/scene/checks.h"
#include "pipeline/scene/lint_checks.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Rows of a light map that are read together.
constexpr int kRowsTogether = 256;

bool isOneOf(const std::string& text, std::initializer_list<const char*> choices) {
    return std::ranges::find(choices, text) != choices.end();
}
bool isPicture(const fs::path& file) {
    return isOneOf(formats::lowerExtension(file), {".exr", ".hdr", ".png", ".tga", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp"});
}

/// A file that the command line names, or that lies in a folder which it names.
struct Found {
    fs::path file;
    bool isNamed = false;
};

Result<std::vector<Found>> filesOf(const std::vector<fs::path>& paths) {
    std::vector<Found> files;
    for (const fs::path& path : paths) {
        std::error_code code;
        if (!fs::exists(path, code)) return failure(ErrorCode::FileUnreadable, path, "found no such file, expected a file or a folder");
        if (!fs::is_directory(path, code)) {
            files.push_back({path, true});
            continue;
        }
        for (const fs::directory_entry& entry : fs::directory_iterator(path, code))
            if (entry.is_regular_file(code) && !entry.path().filename().string().starts_with('.')) files.push_back({entry.path(), false});
        if (code) return failure(ErrorCode::FileUnreadable, path, fmt::format("could not be listed: {}", code.message()));
    }
    std::ranges::sort(files, {}, &Found::file);
    const auto isSame = [](const Found& a, const Found& b) { return a.file == b.file; };
    files.erase(std::unique(files.begin(), files.end(), isSame), files.end());
    return files;
}

/// Returns an error as the reason why a file is left out: without the name of that file, which stands before it, but with that of another.
std::string reasonOf(const fs::path& file, const formats::Error& error) {
    if (error.subject == file.string()) return error.detail;
    const std::string folder = file.has_parent_path() ? (file.parent_path() / "").string() : "";
    return fmt::format("{}: {}", error.subject.starts_with(folder) ? error.subject.substr(folder.size()) : error.subject, error.detail);
}

/// Returns true for the width and height of a panorama, of six faces in a strip or of a cross (formats/environment.h).
bool isEnvironmentShape(int width, int height) {
    const auto is = [&](int x, int y) { return std::int64_t{width} * y == std::int64_t{height} * x; };
    return is(2, 1) || is(1, 6) || is(6, 1) || is(4, 3) || is(3, 4);
}

class InputFinder {
public:
    explicit InputFinder(std::vector<Found> files) : files_(std::move(files)) {}

    Result<DraftInputs> run() {
        for (const Found& each : files_)
            if (formats::isGltfFile(each.file)) LC_CHECK(addMesh(each));
        // Bakes that say so first: their other files are no pictures of their own.
        for (const Found& each : files_)
            if (isPicture(each.file)) addCertainLightMap(each);
        for (const Found& each : files_)
            if (isPicture(each.file) && !isTaken(each.file)) LC_CHECK(addPicture(each));
        pairMeshes();
        for (DraftLightMap& map : inputs_.lightMaps)
            if (!map.hasCoverage && !map.mesh) map.gaps = gapsOf(map);
        pairProbes();
        for (const Found& each : files_)
            if (!isTaken(each.file))
                leaveOut(each.file, formats::lowerExtension(each.file) == ".csv"
                                        ? "traced light can be named as ground_truth of a light map"
                                        : "no part of a scene has this kind of file");
        if (inputs_.lightMaps.empty() && inputs_.probes.empty() && inputs_.gradients.empty()) return nothingFound();
        return std::move(inputs_);
    }

private:
    bool isTaken(const fs::path& file) const { return taken_.contains(file.lexically_normal()); }
    void take(const fs::path& file) { taken_.insert(file.lexically_normal()); }
    void leaveOut(const fs::path& file, std::string why) {
        take(file);
        inputs_.leftOut.push_back({file, std::move(why)});
    }
    /// Leaves out a file of a folder that cannot be read. One that the command line names is an error.
    Result<void> refuse(const Found& found, const formats::Error& error) {
        if (found.isNamed) return tl::make_unexpected(error);
        leaveOut(found.file, reasonOf(found.file, error));
        return {};
    }

    Result<void> addMesh(const Found& found) {
        const auto scene = formats::GltfScene::load(found.file);
        if (!scene) return refuse(found, scene.error());
        if (!scene->hasLightMapUvs()) {
            leaveOut(found.file, unrealLightMapsOf(found.file).value_or("it has no light-map UVs (TEXCOORD_1)"));
            return {};
        }
        meshes_.push_back(found.file);
        // glTF's own stands for those that nobody gave.
        if (std::ranges::find(scene->materials(), "default", &formats::MaterialNeeds::name) == scene->materials().end())
            haveMaterials_.insert(found.file);
        return {};
    }
    /// Returns what to write for a glTF that holds light maps of Unreal.
    static std::optional<std::string> unrealLightMapsOf(const fs::path& file) {
        const auto images = formats::epicImageNames(file);
        if (!images || images->empty()) return std::nullopt;
        const bool isOne = images->size() == 1;
        return fmt::format("it holds {} of Unreal; write file = \"{}\"{} into a [[light_map]]{}", isOne ? "a light map" : "light maps",
                           file.filename().string(), isOne ? "" : fmt::format(" and image = \"{}\"", images->front()),
                           isOne ? "" : fmt::format(", and so for each: {}", fmt::join(*images, ", ")));
    }

    /// found  any file of a set
    void addLightMap(const fs::path& found, const formats::LightMapReader& map) {
        const fs::path file = formats::leadingFile(found, map.bake());
        take(found);
        take(file);
        for (const fs::path& beside : formats::bakeFilesBeside(file, map.bake())) take(beside);
        const BakeReading reading = readingOf(map);
        inputs_.lightMaps.push_back({file, reading, reading.bake != "flat", map.hasCoverage(), !map.recognition().isCertain});
    }
    /// Opens a light map; one of a format that needs a mesh on the mesh that it will get by its name.
    Result<formats::LightMapReader> open(const fs::path& file) const {
        auto map = formats::LightMapReader::open(file, {});
        if (map) return map;
        const auto known = formats::LightMapReader::recognize(file, {});
        const auto mesh = known && known->format->needsMesh() ? meshNamedAs(file) : std::nullopt;
        if (!mesh) return map;
        formats::LightMapDescription description;
        description.mesh = *mesh;
        return formats::LightMapReader::open(file, description);
    }
    void addCertainLightMap(const Found& found) {
        if (isTaken(found.file)) return;
        const auto map = open(found.file);
        if (map && map->recognition().isCertain) addLightMap(found.file, *map);
    }

    /// Adds a picture that no bake format is certain of: six faces, a gradient, an environment, or a flat light map.
    Result<void> addPicture(const Found& found) {
        if (const auto faces = formats::faceFiles(found.file); areAllThere(faces)) {
            inputs_.probes.push_back({faces.front()});
            for (const fs::path& face : faces) take(face);
            return {};
        }
        const auto image = formats::readImage(found.file);
        if (!image) return refuse(found, image.error());
        const int width = image->texels.width(), height = image->texels.height();
        if (height == 1 && width > 1) {
            take(found.file);
            inputs_.gradients.push_back(found.file);
            return {};
        }
        const bool isHdr = isOneOf(formats::lowerExtension(found.file), {".exr", ".hdr"});
        const bool hasHint = isNamedAsLightMap(found.file);
        if (isHdr && isEnvironmentShape(width, height) && !hasHint) {
            take(found.file);
            inputs_.probes.push_back({found.file});
            return {};
        }
        const auto map = open(found.file);
        if (map && (isHdr || hasHint))
            addLightMap(found.file, *map);
        else
            leaveOut(found.file,
                     map ? "a picture of integers; if it is a light map, give it \"lightmap\" in its name, or write it into the scene"
                         : reasonOf(found.file, map.error()));
        return {};
    }
    static bool areAllThere(const std::vector<fs::path>& files) {
        std::error_code code;
        return !files.empty() && std::ranges::all_of(files, [&](const fs::path& file) { return fs::is_regular_file(file, code); });
    }
    /// Returns true if a name says "light map", or is that of a mesh.
    bool isNamedAsLightMap(const fs::path& file) const {
        const std::string stem = inLowerCase(file.stem().string());
        return stem.find("lightmap") != std::string::npos || stem.find("light_map") != std::string::npos ||
               std::ranges::any_of(meshes_, [&](const fs::path& mesh) { return inLowerCase(mesh.stem().string()) == stem; });
    }

    /// Returns the mesh whose name that of a light map begins with, the longest such.
    std::optional<fs::path> meshNamedAs(const fs::path& file) const {
        const std::string stem = inLowerCase(file.stem().string());
        std::optional<fs::path> named;
        std::size_t longest = 0;
        for (const fs::path& mesh : meshes_) {
            const std::string name = inLowerCase(mesh.stem().string());
            const bool begins =
                stem.starts_with(name) && (stem.size() == name.size() || !std::isalnum(static_cast<unsigned char>(stem[name.size()])));
            if (!begins || name.size() <= longest) continue;
            longest = name.size();
            named = mesh;
        }
        return named;
    }

    /// Gives each light map the mesh of its name; a single light map the single mesh.
    void pairMeshes() {
        std::set<fs::path> used;
        for (DraftLightMap& map : inputs_.lightMaps) {
            map.mesh = meshNamedAs(map.file);
            if (!map.mesh && meshes_.size() == 1 && inputs_.lightMaps.size() == 1) map.mesh = meshes_.front();
            if (!map.mesh) continue;
            used.insert(*map.mesh);
            map.hasMaterials = haveMaterials_.contains(*map.mesh);
        }
        for (const fs::path& mesh : meshes_) {
            take(mesh);
            if (!used.contains(mesh))
                inputs_.leftOut.push_back(
                    {mesh, unrealLightMapsOf(mesh).value_or("no light map has a name that begins with its name; write mesh = \"FILE\" at "
                                                            "the light map that it carries")});
        }
    }

    /// Returns the share of a map that coverage = "light" calls gaps. 0 if that is little, or all: then it may be a room
    /// that is dark; and for a map that cannot be read, which its cook reports.
    static double gapsOf(const DraftLightMap& map) {
        formats::LightMapDescription description;
        description.bake = map.reading.bake;
        description.coverage = formats::CoverageSource::Light;
        description.repair = true;
        const auto reader = formats::LightMapReader::open(map.file, description);
        if (!reader) return 0;
        std::int64_t inside = 0;
        for (int row = 0; row < reader->height(); row += kRowsTogether) {
            const auto strip = reader->read(row, std::min(kRowsTogether, reader->height() - row));
            if (!strip) return 0;
            inside += strip->coverage.inside;
        }
        const double gaps = 1 - static_cast<double>(inside) / (static_cast<double>(reader->width()) * reader->height());
        return gaps > kMostGapsWithoutCoverage && inside > 0 ? gaps : 0;
    }

    /// Gives each probe the JSON file that states its SH.
    void pairProbes() {
        for (const Found& each : files_) {
            if (formats::lowerExtension(each.file) != ".json") continue;
            for (DraftProbe& probe : inputs_.probes)
                if (!probe.sh && formats::loadProbeSh(each.file, probe.file.filename().string())) {
                    probe.sh = each.file;
                    take(each.file);
                }
        }
    }

    Result<DraftInputs> nothingFound() const {
        std::string words;
        for (std::size_t i = 0; i < inputs_.leftOut.size() && i < 3; ++i)
            words += fmt::format("{}{}: {}", i == 0 ? " (" : "; ", inputs_.leftOut[i].file.filename().string(), inputs_.leftOut[i].why);
        if (!words.empty()) words += inputs_.leftOut.size() > 3 ? "; ...)" : ")";
        return failure(ErrorCode::FormatUnsupported, "init",
                       fmt::format("found nothing that can be cooked{}, expected a light map, an environment or a gradient; "
                                   "docs/guide/from-a-baker-to-a-scene.md has scene files to write by hand",
                                   words));
    }

    std::vector<Found> files_;
    std::set<fs::path> taken_;
    std::vector<fs::path> meshes_;
    std::set<fs::path> haveMaterials_;  ///< of meshes_
    DraftInputs inputs_;
};

}  // namespace

Result<DraftInputs> findInputs(const std::vector<fs::path>& paths) {
    LC_TRY(files, filesOf(paths));
    return InputFinder(std::move(*files)).run();
}

}  // namespace lightcook::pipeline
