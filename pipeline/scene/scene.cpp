#include "pipeline/scene/scene.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <fstream>
#include <set>

#include "fit/specular_tables.h"
#include "formats/color.h"
#include "formats/light_map_layout.h"
#include "formats/nearest.h"
#include "formats/vocabulary.h"
#include "pipeline/document/toml_fields.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

std::string faultOfName(const std::string& name) {
    const bool usable = !name.empty() && name.front() != '.' && std::ranges::all_of(name, isNameLetter);
    if (!usable) return fmt::format("found the name '{}', expected letters, digits, '_', '-' and '.'", name);
    if (name.size() > kLongestName)
        return fmt::format("found a name of {} letters, expected at most {}: it becomes part of file names", name.size(), kLongestName);
    if (!isReservedOnWindows(name)) return "";
    return fmt::format(
        "found the name '{}', expected another one: Windows has no files of names such as con, nul, com1 and lpt1, also with an "
        "extension, nor of names that end in '.'",
        name);
}

std::string faultOfBake(const std::string& bake) {
    const std::vector<std::string> names = formats::bakeNames();
    if (std::ranges::find(names, bake) != names.end() || !formats::lightMapLayoutFromName(bake)) return "";
    return fmt::format(
        "found the GPU layout '{0}' for light_map.bake, which is the bake format of the file, expected light_map_layout = \"{0}\" in "
        "[output], or layouts = [\"{0}\"] here",
        bake);
}

namespace {

/// Reads a list of different names.
/// name   of one, for messages: "layout"
/// known  the names that there are
std::vector<std::string> readNames(const TomlValue& value, std::string_view name, const std::vector<std::string>& known,
                                   const std::string& expected) {
    std::vector<std::string> names;
    for (const TomlValue& element : value.elements(expected)) {
        if (!element.isText()) element.fail(fmt::format("found an element of {}s that is no string, expected {}", name, expected));
        const std::string text = element.text(expected);
        if (std::ranges::find(known, text) == known.end())
            element.fail(fmt::format("found the {0} '{1}' in {0}s, expected one of: {2}{3}", name, text, fmt::join(known, ", "),
                                     formats::nearestHint(text, known)));
        if (std::ranges::find(names, text) != names.end())
            element.fail(fmt::format("found the {0} '{1}' twice in {0}s, expected it once", name, text));
        names.push_back(text);
    }
    if (names.empty()) value.fail(fmt::format("found an empty list of {}s, expected {}", name, expected));
    return names;
}

}  // namespace

formats::LayoutList readLayouts(const TomlValue& value) {
    return readNames(value, "layout", lightMapLayoutNames(), kLayouts.expected);
}

std::vector<std::string> readTargets(const TomlValue& value) {
    return readNames(value, "target", formats::namesOf(formats::allTargets()), kTargets.expected);
}

void readFiles(const TomlValue& value, LightMapEntry& entry) {
    formats::LightMapDescription& description = entry.description;
    for (const auto& [name, member] : value.members("a table of paths by coefficient")) {
        if (!member.isTable()) {
            description.partFiles[name] = member.path("a path");
            continue;
        }
        for (const auto& [colour, path] : member.members("a table of paths by colour"))
            description.partFiles[fmt::format("{}.{}", name, colour)] = path.path("a path");
    }
    for (const auto& [name, path] : description.partFiles) description.parts.push_back(name);
    const auto format = formats::bakeFormatOfFiles(description.parts, value.place());
    if (!format) throw TomlMistake{format.error()};
    if (description.bake != formats::kAutoBake && description.bake != (*format)->name)
        value.fail(fmt::format("found the images of bake format {} beside bake = \"{}\", expected that bake or \"{}\"", (*format)->name,
                               description.bake, formats::kAutoBake));
    const auto whole = description.partFiles.find("sh00");
    entry.file = whole != description.partFiles.end() ? whole->second : description.partFiles.at("sh00.R");
}

namespace {

/// Reads an element of `allow`: a code, or a table with a code, a reason and an asset.
/// assets  names of the scene's assets
Allowance readAllowance(const TomlValue& value, const std::vector<std::string>& assets) {
    const std::string expected = "a code of `lightcook lint`, or { code = \"...\", reason = \"...\" }";
    std::string code;
    Allowance allowance;
    if (!value.isTable()) {
        code = value.isText() ? value.text(expected) : "";
    } else {
        for (const auto& [key, member] : value.members(expected, {"code", "reason", "asset"})) {
            const std::string text = member.text("a string");
            (key == "code" ? code : key == "asset" ? allowance.asset : allowance.reason) = text;
            if (key == "asset" && !text.empty() && std::ranges::find(assets, text) == assets.end())
                member.fail(fmt::format("found the asset '{}' in allow, expected a light map, probe or gradient of this scene{}", text,
                                        assets.empty() ? ", which has none" : formats::nearestHint(text, assets)));
        }
    }
    if (code.empty()) value.fail(fmt::format("found no code in allow, expected {}", expected));
    const LintCheckInfo* check = formats::findByName(allLintChecks(), code);
    if (check == nullptr)
        value.fail(fmt::format("found the code '{}' in allow, expected one of `lightcook lint`{}", code,
                               formats::nearestHint(code, formats::namesOf(allLintChecks()))));
    if (check->severity == LintSeverity::Error)
        value.fail(fmt::format("found the code '{}' in allow, expected a warning: this one is an error, which cannot be allowed", code));
    allowance.check = check->id;
    return allowance;
}

}  // namespace

void readAllowances(const TomlValue& value, Scene& scene) {
    std::vector<std::string> assets;
    for (const LightMapEntry& entry : scene.lightMaps) assets.push_back(entry.name);
    for (const ProbeEntry& entry : scene.probes) assets.push_back(entry.name);
    for (const GradientEntry& entry : scene.gradients) assets.push_back(entry.name);
    for (const TomlValue& element : value.elements("a list of codes")) scene.allowances.push_back(readAllowance(element, assets));
}

namespace {

/// Refuses colour spaces that the config does not have, and those that are not linear.
void checkColors(const TomlDocument& document, const formats::ColorSpaces& colors) {
    document.hold("color", 0, rulesOf(colors));
    for (const auto& [key, space] : {std::pair("source", &colors.source), std::pair("working", &colors.working)}) {
        const auto checked = formats::checkColorSpace(*space, colors.config);
        if (checked) continue;
        // The default of a key that is not there may be unknown to a config file.
        const toml::node* const given = document.find("color", 0, key);
        const toml::node& node = given != nullptr ? *given : *document.find("color", 0, "config");
        const formats::Subject place = document.placeOf(node);
        throw TomlMistake{{ErrorCode::InvalidRequest,
                           document.isGiven(node) ? place : place.at(fmt::format("color.{}, {}", key, checked.error().subject)),
                           checked.error().detail}};
    }
}

/// Refuses two assets of one name: they would overwrite each other's files in the output folder. So would names that differ in the case of
/// letters alone, where the file system does not tell it apart: on Windows and macOS.
void refuseRepeatedNames(const TomlDocument& document, const Scene& scene) {
    static const std::set<std::string> kReserved = {"cooked", "report", "lightcook", "specular"};
    struct Claim {
        std::string name;
        toml::source_index line = 0;
    };
    std::map<std::string, Claim> claims;  // by the lower case of the name
    const auto claim = [&](const char* section, const auto& entries) {
        for (std::size_t i = 0; i < entries.size(); ++i) {
            const toml::node& node = *document.find(section, i, "name");
            const std::string &name = entries[i].name, lower = inLowerCase(name);
            if (kReserved.contains(lower))
                document.fail(node, fmt::format("found the reserved name '{}', expected another one: files of the output folder are called "
                                                "{}",
                                                name, fmt::join(kReserved, ", ")));
            const auto [first, isNew] = claims.try_emplace(lower, Claim{name, node.source().begin.line});
            if (isNew) continue;
            const Claim& other = first->second;
            if (other.name == name)
                document.fail(node, fmt::format("found the name '{}' twice, expected a name of its own for every light map, probe and "
                                                "gradient: the first is in line {}",
                                                name, other.line));
            document.fail(node, fmt::format("found the names '{}' in line {} and '{}', expected names that differ in more than the case of "
                                            "letters: Windows and macOS hold them for one",
                                            other.name, other.line, name));
        }
    };
    claim("light_map", scene.lightMaps);
    claim("probe", scene.probes);
    claim("gradient", scene.gradients);
}

/// Refuses a second table of one material: it would override the first one.
void refuseRepeatedMaterials(const TomlDocument& document, const Scene& scene) {
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        const std::string& name = scene.materials[i].name;
        if (std::ranges::find(scene.materials, name, &MaterialEntry::name) != scene.materials.begin() + static_cast<std::ptrdiff_t>(i))
            document.fail(
                *document.find("material", i, "name"),
                fmt::format("found the material '{}' twice, expected one table [[material]] of that name: the first is in line {}", name,
                            scene.lines.find("material", name).value_or(0)));
    }
}

std::vector<std::string> axisNames(const std::vector<fit::AxisMapping>& mappings) {
    std::vector<std::string> names = {"auto"};
    for (const fit::AxisMapping& mapping : mappings) names.push_back(mapping.name);
    return names;
}

int lineOf(const toml::node& node) {
    return static_cast<int>(node.source().begin.line);
}

/// Adds the lines of the texts of a table: those that name files are looked up.
/// folder  that paths are relative to
void addTexts(const toml::table& table, const std::filesystem::path& folder, SceneLines& lines) {
    for (const auto& [key, node] : table) {
        if (const auto text = node.value<std::string>(); text && lineOf(node) > 0)  // else an option gave it
            lines.add(folder / *text, lineOf(node));
        if (const toml::table* const inner = node.as_table()) addTexts(*inner, folder, lines);
        if (const toml::array* const array = node.as_array())
            for (const toml::node& element : *array)
                if (const toml::table* const inner = element.as_table()) addTexts(*inner, folder, lines);
    }
}

/// Adds the lines of a table and its keys.
void addLines(const toml::table& table, std::string_view section, SceneLines& lines) {
    const std::string name = table["name"].value_or(std::string());
    if (section.empty() || lineOf(table) > 0) lines.add(section, section.empty() ? "" : name, "", std::max(1, lineOf(table)));
    for (const auto& [key, node] : table)
        if (key.source().begin.line > 0)  // options have none
            lines.add(section, section.empty() ? "" : name, key.str(), static_cast<int>(key.source().begin.line));
}

SceneLines linesOf(const toml::table& root, const std::filesystem::path& folder) {
    SceneLines lines;
    addTexts(root, folder, lines);
    addLines(root, "", lines);
    for (const auto& [key, node] : root) {
        if (const toml::table* table = node.as_table()) addLines(*table, key.str(), lines);
        if (const toml::array* array = node.as_array())
            for (const toml::node& element : *array)
                if (const toml::table* table = element.as_table()) addLines(*table, key.str(), lines);
    }
    return lines;
}

/// Completes what was read with what other settings imply.
void complete(const TomlDocument& document, Scene& scene) {
    if (!document.file.empty()) scene.lines = linesOf(document.root, document.directory);
    scene.file = document.file;
    scene.directory = document.directory;
    scene.document = jsonOfToml(document.root);
    for (std::size_t i = 0; i < scene.lightMaps.size(); ++i) {
        LightMapEntry& entry = scene.lightMaps[i];
        formats::LightMapDescription& description = entry.description;
        description.colors = scene.colors;
        description.takesTangents = takesTangents(scene.output, entry);
        if (entry.mesh) description.mesh = *entry.mesh;
        if (document.find("light_map", i, "lmbake") == nullptr && !description.mesh.empty() && description.parts.empty())
            description.lmbake = formats::lmbakeBeside(entry.file, description.bake);
    }
}

Scene readRoot(const TomlDocument& document) {
    Scene scene;
    readKeys(document, scene);
    complete(document, scene);
    document.hold("output", 0, rulesOf(scene.output));
    checkColors(document, scene.colors);
    for (std::size_t i = 0; i < scene.lightMaps.size(); ++i) document.hold("light_map", i, rulesOf(scene, scene.lightMaps[i]));
    for (std::size_t i = 0; i < scene.gradients.size(); ++i) document.hold("gradient", i, rulesOf(scene.output, scene.gradients[i]));
    document.hold("", 0, rulesOf(scene));
    refuseRepeatedNames(document, scene);
    refuseRepeatedMaterials(document, scene);
    return scene;
}

constexpr const char* kTargetsKey = "output.targets";

/// Returns the targets that a scene file or an option lists; empty: there is one, without a list. Refuses other tables [target.NAME] than
/// those of targets.
std::vector<std::string> targetsOf(const TomlDocument& document) {
    const toml::node* const list = document.find("output", 0, "targets");
    const toml::node* const one = document.find("output", 0, "target");
    if (list != nullptr && one != nullptr && document.isGiven(*list) == document.isGiven(*one))
        document.fail(*list, "found output.targets beside output.target, expected one of them");
    std::vector<std::string> targets;
    if (list != nullptr) targets = readTargets({document, *list, kTargetsKey});
    const toml::node* const tables = document.root.get("target");
    if (tables == nullptr) return targets;
    const bool isOfFile = list != nullptr && !document.isGiven(*list);
    for (const auto& [name, value] : TomlValue(document, *tables, "target")
                                         .members("tables such as [target.astc]; the target of a scene is a key of [output]",
                                                  isOfFile ? targets : formats::namesOf(formats::allTargets()))) {
        if (!value.isTable()) value.refuseType("a table of keys of [output]");
        for (const auto& [key, member] : value.members("keys of [output]"))
            if (key == "target" || key == "targets") member.fail(fmt::format("found {}, expected it in [output]", member.name()));
    }
    return targets;
}

/// Leaves one target of a scene file: the keys of its table [target.NAME] go to [output], over those there.
/// isListed  it is one of output.targets
void selectTarget(toml::table& root, const std::string& target, bool isListed) {
    toml::table* const own = root["target"][target].as_table();
    if (isListed || own != nullptr) root.insert("output", toml::table());
    toml::table* const output = root["output"].as_table();
    if (output == nullptr) return;  // the reader refuses what else it is
    if (isListed) {
        output->erase("targets");
        output->insert_or_assign("target", target);
    }
    if (own != nullptr)
        for (auto&& [key, node] : *own) {
            output->erase(key);
            node.visit([&, &name = key](auto& value) { output->insert(name, std::move(value)); });  // a copy would have no line
        }
    root.erase("target");
}

/// Returns true if a file begins with something that no text holds, as bakes, meshes and textures do.
bool looksBinary(const std::filesystem::path& file) {
    std::array<char, 64> head{};
    std::ifstream stream(file, std::ios::binary);
    stream.read(head.data(), head.size());
    return std::find(head.begin(), head.begin() + stream.gcount(), '\0') != head.begin() + stream.gcount();
}

}  // namespace

const std::vector<std::string>& lightMapLayoutNames() {
    static const std::vector<std::string> names = formats::namesOf(formats::allLightMapLayouts());
    return names;
}

const std::vector<std::string>& lightMapLayoutChoices() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all = lightMapLayoutNames();
        all.push_back(kAutoLayout);
        return all;
    }();
    return names;
}

std::vector<std::string> viewAxisNames() {
    return axisNames(fit::viewMappings());
}

std::vector<std::string> roughnessAxisNames() {
    return axisNames(fit::roughnessMappings());
}

formats::Subject placeIn(const Scene& scene, std::string_view section, std::string_view name, std::string_view key,
                         const std::string& otherwise) {
    if (scene.file.empty()) return otherwise;
    const auto line = scene.lines.find(section, name, key);
    return line ? formats::Subject::inLine(scene.file, *line) : scene.file;
}

std::span<const KeyTable> sceneKeyTables() {
    return keyTablesOf<Scene>();
}

std::string faultOfKey(const std::string& key, const std::string& value) {
    GivenKeys given;
    given.set(key, value);
    toml::table root;
    const GivenNodes nodes = mergeKeys(root, sceneKeyTables(), given, {});
    const auto read = catchTomlMistakes({}, [&] {
        Scene scene;
        readKeys({{}, root, sceneKeyTables(), "", {}, nodes, true}, scene);
        return true;
    });
    return read ? "" : read.error().detail;
}

Result<Scene> readSceneDocument(const Json& document, const std::filesystem::path& directory, const GivenKeys& given) {
    toml::table root = tomlOfJson(document);
    const GivenNodes nodes = mergeKeys(root, sceneKeyTables(), given, directory);
    return catchTomlMistakes({}, [&] { return readRoot({{}, root, sceneKeyTables(), "the scene", directory, nodes}); });
}

Result<std::vector<Scene>> readScenes(const std::filesystem::path& file, const GivenKeys& given) {
    constexpr std::uint64_t kMostBytes = std::uint64_t{16} << 20;
    std::error_code code;
    const auto kind = std::filesystem::status(file, code).type();
    if (kind == std::filesystem::file_type::directory && std::filesystem::is_regular_file(file / "scene.toml", code))
        return failure(ErrorCode::InvalidRequest, file,
                       fmt::format("found a folder, expected a scene file (TOML), such as {}", (file / "scene.toml").string()));
    if (kind == std::filesystem::file_type::regular && looksBinary(file))
        return failure(ErrorCode::InvalidRequest, file,
                       "found a file that is no UTF-8 text, expected a scene file (TOML): `lightcook init` writes one for a bake");
    if (kind != std::filesystem::file_type::regular)
        return failure(ErrorCode::InvalidRequest, file,
                       fmt::format("found {}, expected a scene file (TOML)",
                                   kind == std::filesystem::file_type::directory ? "a folder"
                                   : kind == std::filesystem::file_type::not_found || kind == std::filesystem::file_type::none
                                       ? "no such file"
                                       : "something that is no file"));
    // Read once: between two reads the file could become another scene.
    LC_TRY(text, readTomlText(file, kMostBytes, "a scene file, which is 3 deep"));
    return catchTomlMistakes(file, [&] {
        const std::filesystem::path directory = file.parent_path();
        const auto documentOf = [&](const toml::table& root, GivenNodes nodes) {
            return TomlDocument{file, root, sceneKeyTables(), "the scene", directory, std::move(nodes)};
        };
        toml::table whole = toml::parse(*text, file.string());
        GivenNodes nodes = mergeKeys(whole, sceneKeyTables(), given, directory);
        std::vector<std::string> targets = targetsOf(documentOf(whole, std::move(nodes)));
        const bool areListed = !targets.empty();
        if (!areListed) targets = {whole["output"]["target"].value_or(std::string(formats::info(Target::Bc).name))};
        std::vector<Scene> scenes;
        for (const std::string& target : targets) {
            toml::table root = toml::parse(*text, file.string());
            selectTarget(root, target, areListed);
            nodes = mergeKeys(root, sceneKeyTables(), given.without(kTargetsKey), directory);
            scenes.push_back(readRoot(documentOf(root, std::move(nodes))));
            scenes.back().isOfTargets = areListed;
        }
        return scenes;
    });
}

Result<Scene> readScene(const std::filesystem::path& file, const GivenKeys& given) {
    LC_TRY(scenes, readScenes(file, given));
    return std::move(scenes->front());
}

}  // namespace lightcook::pipeline
