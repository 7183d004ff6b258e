#include "pipeline/draft/scene_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "formats/lmbake.h"
#include "formats/unity_axes.h"
#include "pipeline/document/json.h"
#include "pipeline/scene/asset_name.h"
#include "pipeline/scene/checks.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::ErrorCode;
using formats::failure;
using formats::Result;

constexpr std::size_t kCommentColumn = 33;

/// Returns a basic string of TOML.
std::string tomlString(std::string_view text) {
    std::string out = "\"";
    for (const char letter : text) {
        if (letter == '"' || letter == '\\')
            out += fmt::format("\\{}", letter);
        else if (static_cast<unsigned char>(letter) < 0x20 || letter == 0x7F)
            out += fmt::format("\\u{:04X}", static_cast<unsigned>(letter));
        else
            out += letter;
    }
    return out + "\"";
}
/// Returns text for a comment: on one line.
std::string oneLine(std::string text) {
    std::ranges::replace_if(
        text, [](unsigned char letter) { return letter < 0x20 || letter == 0x7F; }, ' ');
    return text;
}
std::string line(const std::string& key, const std::string& value, const std::string& comment = "") {
    const std::string start = fmt::format("{} = {}", key, value);
    if (comment.empty()) return start + "\n";
    return fmt::format("{:<{}}# {}\n", start, std::max(kCommentColumn, start.size() + 1), oneLine(comment));
}

class SceneText {
public:
    SceneText(const DraftInputs& inputs, const fs::path& folder) : inputs_(inputs), folder_(fs::absolute(folder).lexically_normal()) {}

    Result<std::string> run() {
        for (const fs::path& file : allFiles())
            if (!isUtf8(file.string()))
                return failure(ErrorCode::FileUnreadable, file,
                               "found a name that is no UTF-8, expected one: scene files are UTF-8. Rename the file");
        writeHead();
        for (const DraftLightMap& map : inputs_.lightMaps) write(map);
        for (const DraftProbe& probe : inputs_.probes) write(probe);
        for (const fs::path& gradient : inputs_.gradients) writeGradient(gradient);
        if (hasDirections()) writeMaterials();
        return std::move(text_);
    }

private:
    bool hasDirections() const { return std::ranges::any_of(inputs_.lightMaps, &DraftLightMap::hasDirections); }
    std::vector<fs::path> allFiles() const {
        std::vector<fs::path> files = inputs_.gradients;
        for (const DraftLightMap& map : inputs_.lightMaps) {
            files.push_back(map.file);
            if (map.mesh) files.push_back(*map.mesh);
        }
        for (const DraftProbe& probe : inputs_.probes) {
            files.push_back(probe.file);
            if (probe.sh) files.push_back(*probe.sh);
        }
        files.push_back(folder_);
        return files;
    }
    std::string pathOf(const fs::path& file) const {
        return tomlString(fs::absolute(file).lexically_normal().lexically_proximate(folder_).generic_string());
    }
    std::string uniqueName(const std::string& name) {
        std::string unique = name;
        for (int number = 2; !names_.insert(inLowerCase(unique)).second; ++number) unique = fmt::format("{}_{}", name, number);
        return tomlString(unique);
    }

    void writeHead() {
        const std::string folder = assetNameOf(folder_.filename().empty() ? folder_.parent_path() : folder_, "scene");
        text_ +=
            "# Written by `lightcook init`. docs/reference/scene-file.md describes every key. Keys that are commented out show\n"
            "# their default or an example. Paths are relative to this file.\n\nschema = 1\n";
        text_ += line("name", tomlString(folder));
        text_ += "\n[output]\n";
        text_ += line("target", "\"bc\"", "bc (desktop, consoles) | astc (mobile)");
        // The limit is on what a pixel shows. Where no map has directions, a pixel shows the light map alone.
        if (!inputs_.lightMaps.empty())
            text_ += line(hasDirections() ? "max_whole_visible" : "max_visible", "5",
                          "of what a pixel shows: visible error that 99 % keep, in just noticeable differences");
        // Not set: where filters read past small charts, no layout keeps it (docs/lab/verify.md, "What does cooking add at seams").
        if (std::ranges::any_of(inputs_.lightMaps, [](const DraftLightMap& map) { return map.mesh.has_value(); }))
            text_ += line("# max_seam", "5", "of edges where charts meet: the step of light that cooking may add; no limit by default");
        if (!inputs_.probes.empty() || !inputs_.gradients.empty())
            text_ +=
                line("# max_converter_visible", "20", "the same of dominant lights, tables, probes and gradients; no limit by default");
        text_ += line("# budget", "\"2 MiB\"", "GPU memory of the whole scene: the best layouts within it are chosen; no limit by default");
    }
    /// Returns the lmbake that a map of Godot needs on its mesh; empty: it needs none, or has it.
    static fs::path missingLmbakeOf(const DraftLightMap& map) {
        if (!map.mesh || !formats::lmbakeBeside(map.file, map.reading.bake).empty()) return {};
        const fs::path split = formats::lmbakeOfSplitBake(map.file);
        return split.empty() ? formats::lmbakeOfImport(map.file) : split;
    }
    void write(const DraftLightMap& map) {
        text_ += "\n[[light_map]]\n";
        text_ += line("name", uniqueName(lightMapNameOf(map.file, map.reading.bake)));
        text_ += line("file", pathOf(map.file));
        const std::string evidence = map.isGuess ? "a guess: " + map.reading.evidence : map.reading.evidence;
        // lint keeps its warning of an incomplete set only where no format is named.
        if (map.reading.incompleteSets.empty())
            text_ += line("bake", tomlString(map.reading.bake), evidence);
        else
            text_ += line("bake", "\"auto\"", fmt::format("read as {}, {}", map.reading.bake, evidence));
        for (const std::string& set : map.reading.incompleteSets) text_ += oneLine("# An incomplete set: " + set) + "\n";
        if (!map.reading.otherReadings.empty())
            text_ +=
                oneLine(fmt::format("# The file would also fit bake = \"{}\".", fmt::join(map.reading.otherReadings, "\" or \""))) + "\n";
        const bool isCoveredByMesh = map.mesh && !map.hasCoverage;
        const bool isOfUnity = map.mesh && std::ranges::find(map.reading.assumed, formats::kUnityAxes) != map.reading.assumed.end();
        // A mesh gives a bake the coverage and the normals that it lacks, and says the axes.
        const auto isKnown = [&](const std::string& assumed) {
            return (map.mesh && assumed == kEverySurfaceFacesZ) || ((map.mesh || map.gaps > 0) && assumed == kEveryTexelIsCovered) ||
                   (isOfUnity && assumed == formats::kUnityAxes);
        };
        for (const std::string& assumed : map.reading.assumed)
            if (!isKnown(assumed)) text_ += oneLine("# Assumed: " + assumed) + "\n";
        if (map.mesh)
            text_ += line("mesh", pathOf(*map.mesh), "TEXCOORD_1 is the light-map UV");
        else
            text_ += line("# mesh", "\"level.glb\"", "the mesh that the map lies on, if there is one");
        if (isOfUnity) text_ += line("axes", "\"-x,y,z\"", "Unity's, for a glTF that Unity exported: lint names others that fit better");
        if (const fs::path lmbake = missingLmbakeOf(map); !lmbake.empty())
            text_ += line("# lmbake", tomlString(lmbake.filename().string()),
                          "Godot's file with the rectangles of the nodes: without it the mesh reads other places of the map");
        if (isCoveredByMesh) text_ += line("coverage", "\"mesh\"", "the file does not say which texels lie inside charts");
        if (map.gaps > 0)
            text_ += line("coverage", "\"light\"",
                          fmt::format("the file does not say which texels lie inside charts: the {:.0f} % that are black are taken for "
                                      "gaps",
                                      100 * map.gaps));
    }
    void write(const DraftProbe& probe) {
        text_ += "\n[[probe]]\n";
        text_ += line("name", uniqueName(assetNameOf(probe.file, "probe")));
        // Comments stand at the first of several probes.
        const bool isFirst = &probe == inputs_.probes.data();
        const auto remark = [&](const char* comment) { return isFirst ? comment : ""; };
        text_ += line("file", pathOf(probe.file), remark("an environment: panorama, cross, strip or six files"));
        if (probe.sh) text_ += line("sh", pathOf(*probe.sh), remark("SH of the probe from the baker"));
        if (isFirst) text_ += line("# size", "128", "of a face of the cubemap");
    }
    void writeGradient(const fs::path& gradient) {
        text_ += "\n[[gradient]]\n";
        text_ += line("name", uniqueName(assetNameOf(gradient, "gradient")));
        text_ += line("file", pathOf(gradient), "a sky that is symmetric around its axis, zenith first");
    }
    /// Writes materials; as comments where those of the meshes are known.
    void writeMaterials() {
        const bool areKnown =
            std::ranges::all_of(inputs_.lightMaps, [](const DraftLightMap& map) { return map.hasMaterials || !map.hasDirections; });
        const std::string start = areKnown ? "# " : "";
        text_ +=
            areKnown
                ? "\n# Materials are those of the glTF. What the engine has in place of them:\n"
                : "\n# What the materials of the engine need. Without specular, dominant light, tables and cubemaps are skipped; without\n"
                  "# normal maps as well, light maps become flat.\n";
        text_ += start + "[[material]]\n" + line(start + "name", "\"*\"", "all materials");
        text_ += line(start + "normal_map", "true") + line(start + "specular", "true");
        text_ += line(start + "m", "[0.1, 0.5]", "roughness of Beckmann's lobe (glTF: roughnessFactor squared)");
        text_ += line(start + "f0", "[0.04, 0.6]", "reflectance at normal incidence");
    }

    const DraftInputs& inputs_;
    fs::path folder_;
    std::set<std::string> names_;  ///< in lower case
    std::string text_;
};

}  // namespace

Result<std::string> draftScene(const DraftInputs& inputs, const fs::path& folder) {
    return SceneText(inputs, folder).run();
}

}  // namespace lightcook::pipeline
