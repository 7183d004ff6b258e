#include "pipeline/cook/ninja.h"

#include <fmt/format.h>

#include "pipeline/cook/plan.h"
#include "pipeline/graph/shell_word.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/scene/named_files.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;

/// Returns a path as an input or output of a build statement. Ninja has no escape for |, but does not look into the value of a variable.
std::string pathWord(const std::filesystem::path& path) {
    std::string word;
    for (const char c : path.generic_string()) {
        if (c == '$' || c == ' ' || c == ':') word += '$';
        if (c == '|')
            word += "${bar}";
        else
            word += c;
    }
    return word;
}

/// Returns text as the value of a Ninja variable.
std::string dollarsEscaped(const std::string& text) {
    std::string escaped;
    for (const char c : text) escaped += c == '$' ? std::string("$$") : std::string(1, c);
    return escaped;
}

/// Returns a path as one argument of a shell command, as the value of a Ninja variable.
std::string ninjaWord(const std::filesystem::path& path) {
    return dollarsEscaped(shellQuoted(path.string()));
}

/// Characters that end a path in a depfile as Ninja 1.11 reads it. It has no escape for them.
constexpr std::string_view kNotInDepfiles = "&'\"?*;<>^`|";

}  // namespace

std::optional<Error> warningOfDepfiles(const Scene& scene, const NinjaOptions& options) {
    std::vector<std::filesystem::path> paths = {options.output};
    for (const std::filesystem::path& file : filesNamedBy(scene)) paths.push_back(file);
    for (const std::filesystem::path& path : paths) {
        const std::string name = path.string();
        const std::size_t at = name.find_first_of(kNotInDepfiles);
        if (at != std::string::npos)
            return Error{
                ErrorCode::InvalidRequest, name,
                fmt::format("found '{}', expected none of {} in the path: Ninja does not read it in a depfile, and runs the command "
                            "each time",
                            name[at], kNotInDepfiles)};
    }
    return std::nullopt;
}

formats::Result<void> checkNinjaPaths(const Scene& scene, const NinjaOptions& options) {
    for (const std::filesystem::path& path : {options.program, scene.file, options.output, options.cache})
        if (formats::withoutControls(path.string()) != path.string())
            return formats::failure(ErrorCode::InvalidRequest, path,
                                    "found a control character in the path, expected none: a Ninja file cannot hold it");
    return {};
}

std::vector<std::string> ninjaPartsOf(const Scene& scene) {
    std::vector<std::string> parts;
    for (const LightMapEntry& entry : scene.lightMaps) parts.push_back(entry.name);
    for (const ProbeEntry& entry : scene.probes) parts.push_back(entry.name);
    for (const GradientEntry& entry : scene.gradients) parts.push_back(entry.name);
    if (!scene.lightMaps.empty() || !scene.materials.empty()) parts.emplace_back(kTablesName);
    return parts;
}

std::string ninjaFileOf(const Scene& scene, const NinjaOptions& options) {
    std::string cook = fmt::format("{} --quiet cook {}", ninjaWord(options.program), ninjaWord(scene.file));
    if (!options.cache.empty()) cook += " --cache " + ninjaWord(options.cache);
    if (!options.launcher.empty()) cook += " --launcher " + ninjaWord(options.launcher);
    for (const std::string& word : options.words) cook += " " + ninjaWord(word);
    std::string text = fmt::format("# Written by `lightcook plan`: cooks the scene {}.\n\nbar = |\n", scene.name);
    const auto addRule = [&](const char* rule, const char* more, const std::string& description) {
        text += fmt::format("\nrule {}\n  command = {}{} -o $folder --depfile $inputs\n  description = {}\n  restat = 1\n", rule, cook,
                            more, description);
    };
    addRule("asset", " --only $name", "cook $name");
    addRule("scene", "", fmt::format("cook the scene {}", scene.name));
    // Adds the command that cooks into a folder, and returns the manifests that it makes.
    const auto addBuild = [&](const char* rule, const std::filesystem::path& folder, const std::string& after) {
        std::string made = options.targets.empty() ? pathWord(folder / kManifestName) : "";
        for (const std::string& target : options.targets) made += (made.empty() ? "" : " ") + pathWord(folder / target / kManifestName);
        const std::string depfile = folder.string() + ".d";
        text += fmt::format("\nbuild {}: {} {}{}\n  folder = {}\n  inputs = {}\n  depfile = {}\n", made, rule, pathWord(scene.file), after,
                            ninjaWord(folder), ninjaWord(depfile), dollarsEscaped(depfile));
        return made;
    };
    std::string parts;
    for (const std::string& name : ninjaPartsOf(scene)) {
        parts += " " + addBuild("asset", std::filesystem::path(options.output.string() + ".assets") / name, "");
        text += fmt::format("  name = {}\n", name);
    }
    const std::string made = addBuild("scene", options.output, " |" + parts);
    return text + fmt::format("\ndefault {}\n", made);
}

}  // namespace lightcook::pipeline
