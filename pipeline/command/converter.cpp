#include "pipeline/command/converter.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "formats/gltf_scene.h"
#include "formats/light_map_layout.h"
#include "pipeline/assets/asset_kind.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/command/command.h"
#include "pipeline/command/irradiance.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/printing.h"
#include "pipeline/command/texture_file.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/explained_light.h"
#include "pipeline/scene/asset_name.h"
#include "pipeline/scene/cubemap_layout.h"
#include "pipeline/scene/dominant_layout.h"
#include "pipeline/scene/rsrm_format.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::Result;

constexpr const char* kOutputsWithConstants = "a .ktx2 file, or a folder with --container dds, whose cooked.json has them";

Result<void> checkBesideSh(const Conversion& conversion, const Scene& scene);
Result<void> checkRows(const Conversion& conversion, const Scene& scene);
Result<void> checkBlockOptions(const Conversion& conversion, const Scene& scene);

struct ConverterInfo {
    std::string_view command, section;  ///< table of the asset in a scene file
    AssetKind kind;
    const char* input;         ///< help; nullptr: it has none
    const char* output;        ///< likewise
    Written written;           ///< the output
    const char* otherOutputs;  ///< beside a folder, for messages
    std::vector<KeyOption> options;
    Result<void> (*check)(const Conversion& conversion, const Scene& scene) = nullptr;  ///< of what is no rule between keys
};

std::vector<KeyOption> joined(std::initializer_list<std::vector<KeyOption>> lists) {
    std::vector<KeyOption> all;
    for (const std::vector<KeyOption>& list : lists) all.insert(all.end(), list.begin(), list.end());
    return all;
}

/// Returns the option of the scene's lobe. Phong lobes are those of tables alone.
KeyOption lobeOption() {
    return {"lobe", "", formats::namesOf(formats::sceneLobes()),
            withCaptions("Specular lobe of the engine's materials", formats::sceneLobes())};
}

const std::vector<ConverterInfo>& allConverters() {
    constexpr const char* kFileToo = "or a .ktx2 file";
    static const std::vector<ConverterInfo> kConverters = {
        {"lightmap", "light_map", AssetKind::LightMap, "The bake",
         "A folder; or a .ktx2 file if the layout is one texture, a .dds file if that has no constants", Written::FileOrFolder, kFileToo,
         joined({textureOptions(),
                 {{"output.max_error"},
                  {"output.max_visible"},
                  {"output.max_visible_bound"},
                  {"output.light_map_layout"},
                  {"output.objective"},
                  {"material.normal_map", "no-normal-maps", {}, "No surface has a normal map"},
                  {"material.normal_map_tilt"},
                  {"material.specular", "no-specular", {}, "No surface is specular; with --no-normal-maps directions are left out"},
                  {"output.mips"},
                  lobeOption(),
                  sourceOption()},
                 conventionOptions()})},
        {"dominant", "light_map", AssetKind::Dominant, "The bake", "Output folder", Written::Folder, kFileToo,
         joined({textureOptions(),
                 converterLimitOptions(),
                 {sourceOption()},
                 conventionOptions(),
                 {{"light_map.dominant_fit", "fit"}, lobeOption()}})},
        {"cubemap", "probe", AssetKind::Cubemap, "The environment", "A folder, or a .ktx2 or (--filter sh) .json file",
         Written::FileOrFolder, "or a .ktx2 file, or a .json file with --filter sh",
         joined({textureOptions(), converterLimitOptions(), {sourceOption(), lobeOption(), {"probe.layout"}, {"probe.sh"}}}),
         checkBesideSh},
        {"lut", "tables", AssetKind::Lut, nullptr, "Output folder", Written::Folder, kFileToo,
         joined({fileOptions(),
                 converterLimitOptions(),
                 {{"material.m", "", {}, "Range of roughness, within 0.0001 to 1: m of Beckmann, alpha of GGX"},
                  {"lobe"},
                  {"tables.normalization"},
                  {"tables.views"},
                  {"tables.rows"},
                  {"tables.view_axis"},
                  {"tables.roughness_axis"}}}),
         checkRows},
        {"rsrm", "gradient", AssetKind::Rsrm, "A gradient (one row of texels), or with --axis an environment", "A folder, or a .ktx2 file",
         Written::FileOrFolder, kFileToo,
         joined({textureOptions(),
                 converterLimitOptions(),
                 {sourceOption(),
                  {"gradient.exponents"},
                  {"gradient.encoding"},
                  {"gradient.axis"},
                  {"gradient.zones"},
                  {"gradient.format"},
                  {"gradient.dither"}}}),
         checkBlockOptions}};
    return kConverters;
}

const ConverterInfo& converterOf(std::string_view command) {
    return *std::ranges::find(allConverters(), command, &ConverterInfo::command);
}

/// Returns the name of the container of a texture file.
const std::string& containerNameOf(const std::filesystem::path& output) {
    return enumNames<formats::Container>()[static_cast<std::size_t>(containerOf(output))];
}

tl::unexpected<formats::Error> refuse(std::string option, std::string detail) {
    return formats::failure(ErrorCode::InvalidRequest, std::move(option), std::move(detail));
}

/// Returns a scene without assets, whose files state their colour space.
Json emptyDocument(const std::string& name) {
    return {{"schema", 1}, {"name", name}, {"color", {{"source", formats::kStatedSource}}}};
}

/// Reads the scene of one asset of a name.
Result<Scene> readNamed(const std::string& name, const ConverterInfo& converter, const std::filesystem::path& input,
                        const GivenKeys& given) {
    Json document = emptyDocument(name);
    if (const GivenKey* const source = given.find("color.source"))
        document["allow"] = {{{"code", info(LintCheck::WrongPrimaries).name}, {"reason", source->option}}};
    const auto isOfMaterials = [](const GivenKey& each) { return each.key.starts_with("material."); };
    if (input.empty() || std::ranges::any_of(given.all(), isOfMaterials)) document["material"] = {{{"name", "*"}}};
    if (!input.empty())
        document[std::string(converter.section)] = {{{"name", name}, {"file", input.has_filename() ? input.filename().string() : "."}}};
    return readSceneDocument(document, input.parent_path(), given);
}

/// Fails for a mesh without light-map UVs: a bake that has normals and coverage does not read it, and would not tell.
Result<void> checkSurfaces(const formats::LightMapDescription& description) {
    return description.mesh.empty() ? Result<void>() : formats::checkLightMapUvs(description.mesh);
}

/// Returns true if the only texture of an asset is known to have constants before it is cooked. Light maps of engines may have none, and
/// the layout of others may be chosen by the cook.
bool isKnownToHaveConstants(AssetKind kind, const Scene& scene) {
    if (kind != AssetKind::LightMap) return true;
    const auto layout = formats::lightMapLayoutFromName(scene.output.lightMapLayout);
    return layout && formats::info(*layout).textures.size() == 1 && !formats::info(*layout).isForEngine;
}

/// Copies the asset's only texture from the folder that it was cooked into to `output`.
Outcome keepTexture(Outcome outcome, const std::filesystem::path& output) {
    const auto refused = [&](std::string detail) { return outcomeOf({ErrorCode::InvalidRequest, output, std::move(detail)}); };
    const auto manifest = readManifest(outcome.output);
    if (!manifest) return outcomeOf(manifest.error());
    if (manifest->at("assets").empty()) return refused("found nothing to write: the cook left the asset out");
    const Json& asset = manifest->at("assets").at(0);
    const Json& textures = asset.at("textures");
    if (textures.size() != 1) return refused(fmt::format("found {} textures to write, expected a folder for them", textures.size()));
    if (containerOf(output) == formats::Container::Dds && !asset.value("constants", Json::object()).empty())
        return outcomeOf(constantsAreLost(output, kOutputsWithConstants));
    const std::string file = textures[0].at("file").get<std::string>();
    if (auto copied = copyFile(outcome.output / file, output, OutputLink::Follow); !copied) return outcomeOf(copied.error());
    outcome.output = output;
    return outcome;
}

/// Refuses a --container that is not that of the output file.
Result<void> checkContainer(const Conversion& conversion) {
    const GivenKey* const container = conversion.cook.given.find("output.container");
    if (container == nullptr || container->value == containerNameOf(conversion.output)) return {};
    return refuse(container->option, fmt::format("found another container than that of {}, expected the same, or no {}",
                                                 conversion.output.string(), container->option));
}

Result<void> checkBesideSh(const Conversion& conversion, const Scene& scene) {
    const GivenKey* const sh = conversion.cook.given.find("probe.sh");
    const std::string_view divided = info(CubemapLayout::PreDivided).name;
    const std::string& layout = scene.probes.front().layout;
    if (sh == nullptr || layout == divided) return {};
    return refuse(sh->option, fmt::format("found it with --layout {}, expected --layout {}, which is divided by that SH", layout, divided));
}

Result<void> checkRows(const Conversion& conversion, const Scene& scene) {
    const GivenKey* const rows = conversion.cook.given.find("tables.rows");
    const auto& m = scene.materials.front().m;
    if (scene.tables.roughnessCount != 1 || (m && m->low == m->high)) return {};
    return refuse(rows->option,
                  fmt::format("found 1, expected 2 to {}: one row holds one roughness only, such as --m 0.5,0.5", kMostTableNodes));
}

/// Refuses options of block encoders beside a format that has no blocks.
Result<void> checkBlockOptions(const Conversion& conversion, const Scene& scene) {
    const std::string& asked = scene.gradients.front().format;
    const std::string name = asked.empty() ? std::string(info(RsrmFormat::Rgba8).name) : asked;
    const RsrmFormatInfo* const format = rsrmFormatFromName(name);
    if (format == nullptr || format->hasBlocks()) return {};
    std::string blocks;
    for (const RsrmFormatInfo& each : allRsrmFormats())
        if (each.hasBlocks()) blocks += fmt::format("{}, ", each.name);
    for (const char* key : {"output.effort", "output.rdo"})
        if (const GivenKey* const given = conversion.cook.given.find(key))
            return refuse(given->option, fmt::format("found it with --format {}, whose texels are rounded, expected --format {}or {}", name,
                                                     blocks, kAutoRsrmFormat));
    return {};
}

}  // namespace

Result<Scene> sceneOf(const Conversion& conversion) {
    const ConverterInfo& converter = converterOf(conversion.command);
    const std::filesystem::path& input = conversion.input;
    GivenKeys given = conversion.cook.given;
    if (isTextureFile(conversion.output)) given.set("output.container", containerNameOf(conversion.output), conversion.output.string());
    const std::string name = input.empty() ? "specular" : assetNameOf(input, info(converter.kind).name);
    auto scene = readNamed(name, converter, input, given);
    if (!scene || scene->lightMaps.empty()) return scene;
    const formats::LightMapDescription& description = scene->lightMaps.front().description;
    LC_CHECK(checkSurfaces(description));
    const auto known = formats::LightMapReader::recognize(input, description);  // a cook refuses what is not
    const std::string ofBake = lightMapNameOf(input, known ? known->format->name : "");
    return ofBake == name ? std::move(scene) : readNamed(ofBake, converter, input, given);
}

Outcome convert(const Conversion& conversion, const RunState& state) {
    const ConverterInfo& converter = converterOf(conversion.command);
    const bool isFile = isTextureFile(conversion.output);
    if (auto checked = isFile ? checkContainer(conversion) : checkFolderName(conversion.output, converter.otherOutputs); !checked)
        return outcomeOf(checked.error());
    auto scene = sceneOf(conversion);
    if (!scene) return outcomeOf(scene.error());
    if (converter.check != nullptr)
        if (auto checked = converter.check(conversion, *scene); !checked) return outcomeOf(checked.error());
    CookOptions cook = conversion.cook;
    cook.onlyKind = info(converter.kind).name;
    if (converter.kind == AssetKind::Dominant) scene->lightMaps.front().dominantLayout = kStoredDominant;
    if (!isFile) {
        cook.output = conversion.output;
        return cookScene(std::move(*scene), cook, state);
    }
    if (containerOf(conversion.output) == formats::Container::Dds && isKnownToHaveConstants(converter.kind, *scene))
        return outcomeOf(constantsAreLost(conversion.output, kOutputsWithConstants));
    auto folder = TemporaryFolder::create();
    if (!folder) return outcomeOf(folder.error());
    cook.output = folder->path() / "cooked";
    Outcome outcome = cookScene(std::move(*scene), cook, state);
    return outcome.errors.empty() ? keepTexture(std::move(outcome), conversion.output) : outcome;
}

Result<Scene> settingsOf(const GivenKeys& given) {
    return readSceneDocument(emptyDocument("none"), {}, given);
}

formats::ColorSpaces colorsOf(const std::optional<std::string>& source) {
    formats::ColorSpaces colors;
    colors.source = source.value_or(formats::kStatedSource);
    return colors;
}

std::vector<KeyOption> conventionOptions() {
    return {{"light_map.bake"},
            {"light_map.phase"},
            {"light_map.frame"},
            {"light_map.axes"},
            {"light_map.output_axes"},
            {"light_map.quantity"},
            {"light_map.light_units"},
            {"light_map.encoding"},
            {"light_map.coverage"},
            {"light_map.image"},
            {"light_map.surfaces",
             "",
             {},
             fmt::format("The glTF whose surfaces the bake lies on: for normals that the bake lacks, --coverage mesh, and {}",
                         fmt::join(formats::meshBakeNames(), ", "))},
            {"light_map.lmbake"},
            {"light_map.firefly_limit"}};
}

Result<formats::LightMapDescription> describeBake(const std::filesystem::path& bake, const GivenKeys& given,
                                                  const std::vector<std::filesystem::path>& meshes) {
    const std::string surfaces = "light_map.surfaces";
    const bool isGiven = given.find(surfaces) != nullptr;
    GivenKeys keys = given;
    if (!isGiven && !meshes.empty()) keys.set(surfaces, meshes.front().string(), "meshes");
    LC_TRY(scene, readNamed(assetNameOf(bake, "lightmap"), converterOf("lightmap"), bake, keys));
    formats::LightMapDescription& description = scene->lightMaps.front().description;
    if (isGiven) LC_CHECK(checkSurfaces(description));
    if (!isGiven && meshes.size() > 1) description.mesh.clear();
    description.hasNoLmbake = false;  // there is none then, which says all
    description.colors = {};          // nothing is converted
    return std::move(description);
}

formats::Error constantsAreLost(const std::filesystem::path& output, const std::string& otherwise) {
    return {ErrorCode::InvalidRequest, output,
            fmt::format("found a DDS file, which cannot hold the constants that its texels are decoded with, expected {}", otherwise)};
}

namespace {

/// A command line.
struct ConverterCommand : Conversion {
    JsonOutput json;
};

/// Adds what all converters have.
/// facts  that --json writes
void define(CLI::App& app, ConverterCommand& command, std::string_view name, const std::string& facts) {
    const ConverterInfo& converter = converterOf(name);
    command.command = name;
    if (converter.input != nullptr) addFileOption(app, "input", command.input, converter.input)->required();
    CLI::Option* const output = converter.written == Written::Folder ? addFolderOption(app, "output", command.output, converter.output)
                                                                     : addFileOption(app, "output", command.output, converter.output);
    declareWritten(output, converter.written)->required();
    addKeyOptions(app, command.cook.given, converter.options);
    if (converter.input != nullptr) addRepairOption(app, command.cook.repair);
    command.json.add(app, facts);
}

/// Prints how much of the light map one light and two lights explain.
void printExplanation(const Json& explanation, Session& session) {
    if (session.log == LogFormat::JsonLines)
        session.terminal.say(explanation.dump());
    else
        for (const std::string& line : linesOf(explanation)) session.terminal.say(line);
}

/// Adds how much of the light map one light and two lights explain to a cook without errors, writes the JSON, and prints both: the verdict
/// comes after all that may still fail.
int finishExplained(const ConverterCommand& command, Session& session, Outcome outcome) {
    const auto explanation = sceneOf(command).and_then([&](const Scene& scene) {
        const LightMapEntry& entry = scene.lightMaps.front();
        formats::LightMapDescription description = entry.description;
        description.repair = command.cook.repair;
        return explainDominant(command.input, description, entry.dominantFit == "refined-ambient", session.state);
    });
    if (explanation)
        outcome.report["explanation"] = *explanation;
    else
        outcome.errors.push_back(explanation.error());
    if (auto written = command.json.write(session, outcome.report, outcome.errors); !written) outcome.errors.push_back(written.error());
    outcome.report.erase("explanation");  // it is no member of a report
    printCook(session, outcome);
    if (explanation) printExplanation(*explanation, session);
    return session.finish(outcome.errors);
}

constexpr int kMostIrradianceSize = 1024;

/// The command line of `cubemap`.
struct CubemapCommand : ConverterCommand {
    std::string filter = "specular", size;
    std::optional<double> wrap;
    std::optional<std::string> normalize;
};

/// Returns an error for the first option that was given to a filter which has no use for it.
Result<void> checkFilterOptions(const CubemapCommand& command) {
    using Filters = std::vector<std::string>;
    const Filters textures = {"specular", "irradiance"};
    std::vector<std::pair<std::string, Filters>> given;
    if (command.wrap) given.push_back({"--wrap", {"irradiance", "sh"}});
    if (!command.size.empty()) given.push_back({"--size", textures});
    if (command.normalize) given.push_back({"--normalize", {"sh"}});
    for (const GivenKey& each : command.cook.given.all()) {
        const bool isOfTextures = each.key.starts_with("output.") && each.key.find("visible") == std::string::npos;
        if (each.key != "color.source") given.emplace_back(each.option, isOfTextures ? textures : Filters{"specular"});
    }
    for (const auto& [option, filters] : given)
        if (std::ranges::find(filters, command.filter) == filters.end())
            return refuse(option,
                          fmt::format("found it with --filter {}, expected --filter {}", command.filter, fmt::join(filters, " or ")));
    return {};
}

/// Runs --filter irradiance.
Result<Json> runIrradiance(const CubemapCommand& command) {
    LC_CHECK(checkContainer(command));
    LC_TRY(scene, settingsOf(command.cook.given));
    IrradianceCommand irradiance;
    if (!command.size.empty()) {
        const double size = std::stod(command.size);
        if (!(size >= 1 && size <= kMostIrradianceSize && size == std::floor(size)))
            return refuse("--size", fmt::format("found {}, expected 1 to {}", command.size, kMostIrradianceSize));
        irradiance.size = static_cast<int>(size);
    }
    const OutputSettings& output = scene->output;
    irradiance.input = command.input;
    irradiance.output = command.output;
    irradiance.wrap = command.wrap.value_or(irradiance.wrap);
    irradiance.repair = command.cook.repair;
    irradiance.source = scene->colors.source;
    irradiance.target = output.target;
    irradiance.budgetBytes = output.budgetBytes;
    irradiance.maxError = output.limits[Limit::ConverterError].value_or(irradiance.maxError);
    irradiance.textures = TextureSettings{output.container, output.zstd, output.effort, output.rdo};
    return cookIrradiance(irradiance);
}

/// Runs --filter sh.
Result<Json> runSh(const CubemapCommand& command) {
    LC_TRY(scene, settingsOf(command.cook.given));
    ShCommand sh;
    sh.input = command.input;
    sh.output = command.output;
    sh.wrap = command.wrap.value_or(sh.wrap);
    sh.normalize = command.normalize.value_or(sh.normalize);
    sh.repair = command.cook.repair;
    sh.source = scene->colors.source;
    return cookSh(sh);
}

int runCubemap(const CubemapCommand& command, Session& session) {
    if (auto checked = checkFilterOptions(command); !checked) return session.finish(checked);
    command.json.prepare(session);
    if (command.filter == "specular") return finishCook(session, command.json, convert(command, session.state));
    const auto cooked = command.filter == "sh" ? runSh(command) : runIrradiance(command);
    if (cooked) warnOfRepairs(session.terminal, command.input.string(), cooked->at("repaired_texels").get<std::int64_t>());
    if (cooked && session.terminal.isInteractive()) printJson(session.terminal, *cooked);
    return command.json.finish(session, cooked);
}

/// Gives the range of m of a range of cosine powers s = 2 / m^2 - 2.
Result<void> giveExponents(const std::vector<double>& exponents, GivenKeys& given) {
    if (exponents.empty()) return {};
    constexpr const char* kOption = "--exponents";
    const GivenKey* const lobe = given.find("lobe");
    const std::string name = lobe == nullptr ? std::string(formats::info(Scene{}.lobe).name) : lobe->value;
    if (name != formats::info(lighting::SpecularLobe::PhongPower).name)
        return refuse(kOption, fmt::format("found the lobe {}, expected --lobe phong-power, or --m", name));
    if (given.find("material.m") != nullptr) return refuse(kOption, "found --m beside it, expected one of them");
    constexpr double kMostExponent = 1e8;
    if (!(exponents[0] >= 0 && exponents[0] <= exponents[1] && exponents[1] <= kMostExponent))
        return refuse(kOption, fmt::format("found '{}', expected [low, high] with 0 <= low <= high <= {:g}", fmt::join(exponents, ","),
                                           kMostExponent));
    const auto roughnessOf = [](double exponent) { return std::sqrt(2 / (exponent + 2)); };
    given.set("material.m", fmt::format("{},{}", roughnessOf(exponents[1]), roughnessOf(exponents[0])), kOption);
    return {};
}

/// Prints the energy that the average of an environment around its axis lost.
void printAsymmetry(Session& session, const Json& report) {
    if (!report.is_object() || report.at("assets").empty()) return;
    const Json measures = report.at("assets").at(0).value("measures", Json::object());
    if (!measures.contains(note_keys::kAsymmetricEnergy)) return;
    const double fraction = measures.at(note_keys::kAsymmetricEnergy).get<double>();
    session.terminal.say(session.log == LogFormat::JsonLines
                             ? Json({{note_keys::kAsymmetricEnergy, fraction}}).dump()
                             : fmt::format("{:.3g} % of the light's energy is not symmetric around the axis and is lost", 100 * fraction));
}

}  // namespace

CommandFunction defineLightmap(CLI::App& app) {
    const auto command = std::make_shared<ConverterCommand>();
    define(app, *command, "lightmap", "the report");
    return [command](Session& session) {
        command->json.prepare(session);
        return finishCook(session, command->json, convert(*command, session.state));
    };
}

CommandFunction defineDominant(CLI::App& app) {
    struct DominantCommand : ConverterCommand {
        bool isExplained = false;
    };
    const auto command = std::make_shared<DominantCommand>();
    define(app, *command, "dominant", "the report, and with --report \"explanation\",");
    app.add_flag("--report", command->isExplained, "Print where one light cannot represent the map, and what a second light would gain");
    app.footer(R"(--report prints, for the closed form, the best single light and two lights: the fraction of energy
(squares of all SH coefficients) that is not explained; median and 99th percentile of the residual
(root of the squared error over the norm of a texel's coefficients); texels and energy with a
residual over 10, 25 and 50 %; and the worst texel of up to eight strips of 64 rows with the two
lights that would do better. With --log json it is one JSON object on standard output. The textures
hold one light.)");
    return [command](Session& session) {
        command->json.prepare(session);
        Outcome outcome = convert(*command, session.state);
        if (!command->isExplained || !outcome.errors.empty()) return finishCook(session, command->json, std::move(outcome));
        return finishExplained(*command, session, std::move(outcome));
    };
}

CommandFunction defineCubemap(CLI::App& app) {
    const auto command = std::make_shared<CubemapCommand>();
    define(app, *command, "cubemap", "the report, or with another --filter what was written,");
    app.add_option("--filter", command->filter,
                   "specular: prefiltered levels; irradiance: diffuse light, one level in one file; sh: nine coefficients "
                   "as JSON")
        ->check(CLI::IsMember({"specular", "irradiance", "sh"}))
        ->capture_default_str();
    app.add_option("--wrap", command->wrap, "For irradiance and sh: wrapped diffuse, energy conserving, 0 (Lambert, the default) to 1")
        ->check(CLI::Range(0.0, 1.0));
    app.add_option("--size", command->size,
                   fmt::format("Texels of a face's edge. For specular: a power of two, {} to {}; default: {}. For irradiance: 1 to {}; "
                               "default: {}",
                               kLeastProbeSize, kMostProbeSize, ProbeEntry{}.size, kMostIrradianceSize, IrradianceCommand{}.size))
        ->type_name("INT");
    app.add_option("--normalize", command->normalize,
                   "For sh: none (the default), or d3dx: multiply by 16/17, so that a game light of 1 is 1 through nine coefficients")
        ->check(CLI::IsMember({"none", "d3dx"}));
    app.footer(R"(The environment is an equirectangular panorama (2:1), six faces +X -X +Y -Y +Z -Z in a strip (1:6 or
6:1), a horizontal (4:3) or vertical (3:4) cross, or one of six square files whose names end in
px nx py ny pz nz or posx negx posy negy posz negz. The shape of the image selects the form. The
corners of a cross are ignored. An OpenEXR file with the attribute envmap has OpenEXR's directions.

--filter irradiance writes the exit radiance of a white Lambert surface (irradiance over pi) for every
normal, computed from the whole environment. The texture's metadata has the "range" to multiply by.
--wrap W makes the kernel max(0, n.l + W) / (pi (1 + W)^2), with the SH bands 1, (2 - W) / 3 and
(1 - W)^2 / 4. Every texel of the file is compared with the sum over every source texel; --max-error
(default 0.1) limits their RMS error.

--filter sh writes "sh", the incident radiance as nine rows of R, G and B, without Condon-Shortley
signs, and "exit", the same times the bands of wrapped Lambert: the sum of exit_i Y_i(n) is the exit
radiance of a white surface. Through nine coefficients, a white surface that faces a game light of 1
shows 17/16; --normalize d3dx multiplies everything by 16/17, as D3DX does.)");
    return [command](Session& session) {
        if (!command->size.empty() && command->filter == "specular") command->cook.given.set("probe.size", command->size);
        return runCubemap(*command, session);
    };
}

CommandFunction defineLut(CLI::App& app) {
    struct LutCommand : ConverterCommand {
        std::vector<double> exponents;
    };
    const auto command = std::make_shared<LutCommand>();
    define(app, *command, "lut", "the report");
    app.add_option("--exponents", command->exponents, "The range of roughness as cosine powers, for --lobe phong-power")
        ->delimiter(',')
        ->expected(2)
        ->type_name("LOW,HIGH");
    app.footer(R"(Without options the tables are those of a cooked scene: Beckmann's lobe, energy conserving, 24 views.

Lobes: beckmann; ggx (m is alpha); phong: exp(-tan^2 a / m^2) / (pi m^2 cos^3 a) around the reflected
view; phong-power: (s + 1) / (2 pi) cos^s a with s = 2 / m^2 - 2. For Phong lobes C holds the
harmonics of the reflected direction times the lobe's bands, not cut at the horizon, and D is C times
(1 - NoV)^5.

Without --rows a roughness below 1/16 uses the first row.

An axis is chosen from a dozen forms: the one for which F0 C + (1 - F0) D, for the F0 of the scene, has
the least error between the nodes; plain NoV or m if no form is 3 % better. The manifest describes
each axis by "of" (the form as text) and "factors" p0, p1, q0, q1. The axis measures
sqrt((p0 + p1 t) (q0 + q1 t)) of t = NoV or m, the shader's lcTableAxis(t, factors);
lcTableCoordinate(value, scale, offset) then is the texture coordinate. "minimum" and "maximum" are
the values of the first and last texel.

"max_bound" of the stages filter and total holds for every view and every roughness of the table's
range, also between sampled positions. Only the filter's fractions are taken as exact. It bounds the
local relative error, which is large where the harmonics of the light cancel.)");
    return [command](Session& session) {
        command->json.prepare(session);
        if (auto given = giveExponents(command->exponents, command->cook.given); !given)
            return finishCook(session, command->json, outcomeOf(given.error()));
        return finishCook(session, command->json, convert(*command, session.state));
    };
}

CommandFunction defineRsrm(CLI::App& app) {
    const auto command = std::make_shared<ConverterCommand>();
    define(app, *command, "rsrm", "the report");
    app.footer(R"(With --axis the command prints the fraction of the light's energy that is not symmetric around the
axis; with --log json as {"asymmetric_energy": 0.7}. If it is large, a reflection map cannot represent
the environment.)");
    return [command](Session& session) {
        command->json.prepare(session);
        Outcome outcome = convert(*command, session.state);
        if (outcome.errors.empty() && command->cook.given.find("gradient.axis") != nullptr) printAsymmetry(session, outcome.report);
        return finishCook(session, command->json, std::move(outcome));
    };
}

}  // namespace lightcook::pipeline
