#include "pipeline/scene/scene.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <set>

#include "fit/specular_tables.h"
#include "formats/bake_format.h"
#include "formats/color.h"
#include "formats/light_map_layout.h"
#include "formats/lmbake.h"
#include "formats/nearest.h"
#include "formats/vocabulary.h"
#include "pipeline/document/byte_count.h"
#include "pipeline/document/toml_file.h"
#include "pipeline/scene/checks.h"
#include "pipeline/scene/cubemap_layout.h"
#include "pipeline/scene/dominant_fit.h"
#include "pipeline/scene/dominant_layout.h"
#include "pipeline/scene/rsrm_format.h"
#include "pipeline/scene/settings.h"
#include "pipeline/scene/table_reader.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Reads a limit in just noticeable differences.
std::optional<double> readVisibleLimit(TableReader& reader, const char* key) {
    const auto limit = reader.optional<double>(key, "a positive number of just noticeable differences");
    if (limit) reader.check(key, objectionToMaxVisible(*limit));
    return limit;
}

/// Reads the key `lobe`. Another name is refused with the lobes that a scene takes; a lobe of tables alone, with the reason.
lighting::SpecularLobe readLobe(TableReader& reader) {
    const std::string name = reader.optional<std::string>("lobe", "a string").value_or("");
    if (const auto* lobe = formats::findByName(formats::allSpecularLobes(), name); lobe != nullptr)
        reader.check("lobe", objectionToSceneLobe(lobe->id));
    return reader.oneOfRows("lobe", formats::sceneLobes());
}

/// Reads the keys of charts in [output] or a [[light_map]].
ChartSettings readChartSettings(TableReader& reader) {
    ChartSettings settings;
    if (reader.has("charts")) settings.mode = reader.oneOfRows("charts", allChartModes());
    settings.maxVisible = reader.optional<double>("charts_max_visible", "a number of just noticeable differences");
    if (settings.maxVisible && !(*settings.maxVisible >= 0 && *settings.maxVisible <= kMostChartsVisible))
        reader.fail(reader.node("charts_max_visible"),
                    fmt::format("found {} for charts_max_visible, expected a number from 0 (charts are moved only) to {:g}",
                                *settings.maxVisible, kMostChartsVisible));
    return settings;
}

lighting::DisplaySettings readDisplay(TableReader reader) {
    lighting::DisplaySettings display;
    display.white = reader.optional<double>("white", "a positive exit radiance");
    if (display.white) reader.check("white", objectionToWhite(*display.white));
    display.stops = reader.optional<double>("stops", "a number").value_or(display.stops);
    if (reader.has("stops")) reader.check("stops", objectionToStops(display.stops));
    display.black = reader.optional<double>("black", "a luminance in cd/m^2").value_or(display.black);
    if (reader.has("black")) reader.check("black", objectionToBlack(display.black));
    return display;
}

/// Largest limit on the decode of a layout.
constexpr std::int64_t kMostDecodeCost = 1000000;

/// Reads the layouts that "auto" may take. Fails for an empty list, and for names that are unknown or there twice.
formats::LayoutList readLayouts(TableReader& reader) {
    constexpr const char* kExpected = "a list of light-map layouts, such as [\"godot\", \"sh4\"]";
    formats::LayoutList layouts;
    const toml::array* array = reader.array("layouts", kExpected);
    if (array == nullptr) return layouts;
    if (array->empty()) reader.fail(*array, fmt::format("found an empty list of layouts, expected {}", kExpected));
    for (const toml::node& element : *array) {
        const auto name = element.value<std::string>();
        if (!name) reader.fail(element, fmt::format("found an element of layouts that is no string, expected {}", kExpected));
        if (!formats::lightMapLayoutFromName(*name))
            reader.fail(element, fmt::format("found the layout {} in layouts, expected one of: {}{}", inQuotes(*name),
                                             listed(lightMapLayoutNames()), formats::nearestHint(*name, lightMapLayoutNames())));
        if (std::ranges::find(layouts, *name) != layouts.end())
            reader.fail(element, fmt::format("found the layout {} twice in layouts, expected it once", inQuotes(*name)));
        layouts.push_back(*name);
    }
    return layouts;
}

/// Reads what the decode may cost.
void readDecode(TableReader& reader, OutputSettings& output) {
    output.cost = reader.oneOfRows("cost", formats::allLayoutCosts());
    output.decode = {reader.positiveInteger("max_fetches", kMostDecodeCost), reader.positiveInteger("max_decode_ops", kMostDecodeCost)};
    output.layouts = readLayouts(reader);
}

/// Refuses a cost of layouts that nothing uses.
void refuseUnusedCost(TableReader& reader, const OutputSettings& output) {
    const bool isAuto = layoutAsked(output) == kAutoLayout;
    if (reader.has("cost") && !(isAuto && (output.isErrorLimited() || !output.budgetBytes)))
        reader.fail(reader.node("cost"),
                    isAuto ? "found output.cost where a budget chooses the layouts, expected max_error or max_visible as well"
                           : "found output.cost where the layout is named, expected light_map_layout = \"auto\" with max_error or "
                             "max_visible");
}

/// Reads the key `mips`. A number of levels is refused: charts decide it.
std::optional<bool> readMips(TableReader& reader) {
    return reader.optional<bool>("mips", "true or false: the charts of a map decide how many levels it has");
}

/// Reads the limits on errors, and the budget.
void readLimits(TableReader& reader, OutputSettings& output) {
    const auto fraction = [&](const char* key) {
        const auto value = reader.fraction(key, "a positive fraction: 0.02, or \"2%\"");
        if (value && (!(*value > 0) || !std::isfinite(*value)))
            reader.fail(reader.node(key),
                        fmt::format("found {} for output.{}, expected a positive fraction: 0.02, or \"2%\"", *value, key));
        return value;
    };
    output.maxError = fraction("max_error");
    output.maxConverterError = fraction("max_converter_error");
    output.maxVisible = readVisibleLimit(reader, "max_visible");
    output.maxVisibleBound = readVisibleLimit(reader, "max_visible_bound");
    output.maxConverterVisible = readVisibleLimit(reader, "max_converter_visible");
    output.maxConverterVisibleBound = readVisibleLimit(reader, "max_converter_visible_bound");
    output.maxSeam = readVisibleLimit(reader, "max_seam");
    output.maxWholeVisible = readVisibleLimit(reader, "max_whole_visible");
    output.maxWholeError = fraction("max_whole_error");
    if (const auto text = reader.optional<std::string>("budget", "a size such as \"2 MiB\"")) {
        const auto bytes = parseByteCount(*text, reader.place("budget"));
        if (!bytes) throw TomlMistake{bytes.error()};
        output.budgetBytes = *bytes;
    }
}

/// Reads the settings of the block encoders. Needs the target.
void readEncoding(TableReader& reader, OutputSettings& output) {
    if (const auto effort = reader.optional<std::int64_t>("effort", "an integer from 0 to 9")) {
        if (*effort < 0 || *effort > 9)
            reader.fail(reader.node("effort"), fmt::format("found {} for output.effort, expected an integer from 0 to 9", *effort));
        if (output.target == Target::Float)
            reader.fail(reader.node("effort"),
                        "found output.effort with target = \"float\", whose texels are not encoded, expected target = \"bc\" or \"astc\"");
        output.effort = static_cast<int>(*effort);
    }
    if (const auto rdo = reader.fraction("rdo", "a fraction from 0 to 1: 0.02, or \"2%\"")) {
        if (!(*rdo >= 0 && *rdo <= kLargestRdo))
            reader.fail(reader.node("rdo"), fmt::format("found {} for output.rdo, expected a fraction from 0 to {}", *rdo, kLargestRdo));
        output.rdo = *rdo;
    }
}

OutputSettings readOutput(TableReader reader) {
    OutputSettings output;
    output.target = reader.oneOfRows("target", formats::allTargets());
    readLimits(reader, output);
    if (reader.has("light_map_layout")) output.lightMapLayout = reader.oneOf("light_map_layout", lightMapLayoutChoices(), "");
    readDecode(reader, output);
    output.objective = reader.oneOfRows("objective", formats::allObjectives());
    output.container = reader.oneOf("container", {"ktx2", "dds"}, "ktx2") == "dds" ? formats::Container::Dds : formats::Container::Ktx2;
    output.zstd = reader.optional<bool>("zstd", "true or false").value_or(false);
    readEncoding(reader, output);
    output.draco = reader.optional<bool>("draco", "true or false").value_or(true);
    output.charts = readChartSettings(reader);
    output.gltf = reader.optional<bool>("gltf", "true or false").value_or(false);
    output.mips = readMips(reader).value_or(false);
    output.keepUnused = reader.optional<bool>("keep_unused", "true or false").value_or(false);
    if (const auto conflict = conflictIn(output)) reader.fail(reader.node(conflict->key), conflict->inScene);
    refuseUnusedCost(reader, output);
    return output;
}

formats::ColorSpaces readColors(TableReader reader) {
    formats::ColorSpaces colors;
    colors.source = reader.optional<std::string>("source", "the name of a colour space").value_or(colors.source);
    colors.working = reader.optional<std::string>("working", "the name of a colour space").value_or(colors.working);
    for (const auto& [key, space] : {std::pair("source", &colors.source), std::pair("working", &colors.working)})
        if (space->empty())
            reader.fail(reader.node(key), fmt::format("found an empty text for color.{}, expected the name of a colour space", key));
    colors.config = reader.optionalPath("config").value_or(std::filesystem::path());
    if (colors.working == formats::kStatedSource)
        reader.fail(reader.node("working"),
                    fmt::format("found \"{}\" for color.working, expected the name of a colour space: only a source "
                                "can be stated by files",
                                formats::kStatedSource));
    for (const auto& [key, space] : {std::pair("source", &colors.source), std::pair("working", &colors.working)}) {
        const auto checked = formats::checkColorSpace(*space, colors.config);
        if (checked) continue;
        // The default of a key that is not there may be unknown to a config file.
        const std::string place = reader.has(key) ? reader.place(key) : reader.place("config");
        throw TomlMistake{
            {ErrorCode::InvalidRequest, fmt::format("{}, color.{}, {}", place, key, checked.error().subject), checked.error().detail}};
    }
    return colors;
}

/// Reads a name that can be a file name and a key.
std::string readName(TableReader& reader) {
    std::string name = reader.required<std::string>("name", "a string");
    const bool usable = !name.empty() && name.front() != '.' && std::ranges::all_of(name, isNameLetter);
    if (!usable)
        reader.fail(reader.node("name"), fmt::format("found the name {}, expected letters, digits, '_', '-' and '.'", inQuotes(name)));
    if (name.size() > kLongestName)
        reader.fail(reader.node("name"), fmt::format("found a name of {} letters, expected at most {}: it becomes part of file names",
                                                     name.size(), kLongestName));
    if (isReservedOnWindows(name))
        reader.fail(reader.node("name"),
                    fmt::format("found the name {}, expected another one: Windows has no files of names such as con, nul, com1 and lpt1, "
                                "also with an extension, nor of names that end in '.'",
                                inQuotes(name)));
    return name;
}

/// Reads the key `bake`, or `layout`, its older name.
std::string readBake(TableReader& reader) {
    const bool isOldName = reader.has("layout");
    if (isOldName && reader.has("bake"))
        reader.fail(reader.node("layout"),
                    "found light_map.layout beside light_map.bake, expected one of them: layout is the older name of bake");
    const char* const key = isOldName ? "layout" : "bake";
    const std::vector<std::string> names = formats::bakeNames();
    const auto value = reader.has(key) ? reader.node(key).value<std::string>() : std::nullopt;
    if (value && std::ranges::find(names, *value) == names.end() && formats::lightMapLayoutFromName(*value))
        reader.fail(reader.node(key),
                    fmt::format("found the GPU layout {0} for light_map.{1}, which is the bake format of the file{2}, expected "
                                "light_map_layout = \"{3}\" in [output], or layouts = [\"{3}\"] here",
                                inQuotes(*value), key, isOldName ? " (older name of light_map.bake)" : "", *value));
    return reader.oneOf(key, names, std::string(formats::kAutoBake));
}

/// Reads the key `files`: paths by "sh00", or by "R", "G" and "B" below it. Returns them by "sh00" or "sh00.R".
std::map<std::string, std::filesystem::path> readPartFiles(const TableReader& reader, const toml::table& files) {
    std::map<std::string, std::filesystem::path> paths;
    const auto add = [&](const std::string& name, const toml::node& node) {
        const auto text = node.value<std::string>();
        if (!text || text->empty())
            reader.fail(node, fmt::format("found no path for {} in light_map.files, expected a string", inQuotes(name)));
        reader.checkPath(node, "files." + name, *text);
        paths[name] = reader.resolve(*text);
    };
    for (const auto& [key, node] : files) {
        const std::string name(key.str());
        const toml::table* const colours = node.as_table();
        if (colours == nullptr) add(name, node);
        if (colours != nullptr)
            for (const auto& [colour, path] : *colours) add(fmt::format("{}.{}", name, std::string_view(colour.str())), path);
    }
    return paths;
}

/// Reads the images of a bake that has one for each coefficient. Returns the path of the first: of coefficient 0, or of its red.
std::filesystem::path readFiles(TableReader& reader, formats::LightMapDescription& description) {
    const toml::table& files = reader.requiredTable("files", "a table of paths by coefficient");
    if (reader.has("file")) reader.fail(reader.node("files"), "found light_map.files beside light_map.file, expected one of them");
    description.partFiles = readPartFiles(reader, files);
    for (const auto& [name, path] : description.partFiles) description.parts.push_back(name);
    const auto format = formats::bakeFormatOfFiles(description.parts, reader.place("files"));
    if (!format) throw TomlMistake{format.error()};
    if (description.bake != formats::kAutoBake && description.bake != (*format)->name)
        reader.fail(reader.node("files"),
                    fmt::format("found the images of bake format {} beside bake = \"{}\", expected that bake or \"{}\"", (*format)->name,
                                description.bake, formats::kAutoBake));
    const auto whole = description.partFiles.find("sh00");
    return whole != description.partFiles.end() ? whole->second : description.partFiles.at("sh00.R");
}

/// Reads the conventions of a bake, and its limit on fireflies.
void readConventions(TableReader& reader, formats::LightMapDescription& description) {
    description.phase = reader.oneOfRows("phase", formats::conventions<formats::ShPhase>());
    description.frame = reader.oneOfRows("frame", formats::conventions<formats::ShFrame>());
    if (reader.has("axes")) {
        const auto text = reader.optional<std::string>("axes", formats::BakeAxes::kExpected.data());
        const auto axes = formats::BakeAxes::fromName(*text);
        if (!axes)
            reader.fail(reader.node("axes"),
                        fmt::format("found {} for light_map.axes, expected {}", inQuotes(*text), formats::BakeAxes::kExpected));
        description.axes = *axes;
    }
    description.quantity = reader.oneOfRows("quantity", formats::conventions<formats::ShQuantity>());
    description.encoding = reader.oneOfRows("encoding", formats::conventions<formats::LightEncoding>());
    description.coverage = reader.oneOfRows("coverage", formats::conventions<formats::CoverageSource>());
    description.image = reader.optional<std::string>("image", "the name of an image in the glTF").value_or("");
    description.lightUnits = reader.oneOfRows("light_units", formats::conventions<formats::LightUnits>());
    if (const auto limit = reader.optional<double>("firefly_limit", "a number from 1, or 0 for no check")) {
        reader.check("firefly_limit", objectionToFireflyLimit(*limit));
        description.fireflyLimit = *limit;
    }
}

void readDominantFit(TableReader& reader, LightMapEntry& entry) {
    if (!reader.has("dominant_fit")) return;
    const auto name = reader.optional<std::string>("dominant_fit", "a string");
    const DominantFitInfo* fit = dominantFitFromName(*name);
    entry.dominantFit =
        fit != nullptr ? std::string(fit->name) : reader.oneOf("dominant_fit", formats::namesOf(allDominantFits()), entry.dominantFit);
}

/// Reads the layout of the dominant light. A fit beside the layout without a light is refused.
void readDominantLayout(TableReader& reader, LightMapEntry& entry) {
    if (reader.has("dominant_layout")) entry.dominantLayout = reader.oneOf("dominant_layout", formats::namesOf(allDominantLayouts()), "");
    const DominantLayoutInfo* const dominant = dominantLayoutFromName(entry.dominantLayout.value_or(""));
    if (reader.has("dominant_fit") && dominant != nullptr && dominant->divisor == 0)
        reader.fail(reader.node("dominant_fit"),
                    fmt::format("found light_map.dominant_fit beside dominant_layout = \"{}\", expected one of "
                                "them: there is no dominant light",
                                dominant->name));
}

/// Reads where the nodes of the mesh lie in a bake of Godot, or finds the file beside the bake.
void readLmbake(TableReader& reader, LightMapEntry& entry) {
    std::filesystem::path& lmbake = entry.description.lmbake;
    if (!reader.has("lmbake")) {
        if (entry.mesh && entry.description.parts.empty()) lmbake = formats::lmbakeBeside(entry.file, entry.description.bake);
        return;
    }
    if (reader.optional<std::string>("lmbake", "a path, or \"none\"") == formats::kNoLmbake) {
        entry.description.hasNoLmbake = true;
        return;
    }
    lmbake = *reader.optionalPath("lmbake");
    if (!entry.mesh)
        reader.fail(reader.node("lmbake"),
                    fmt::format("found light_map.lmbake without a mesh for '{}', expected mesh = \"FILE\": its nodes are in the lmbake",
                                entry.name));
    if (!entry.description.parts.empty() || !formats::mayTakeLmbake(entry.description.bake))
        reader.fail(reader.node("lmbake"),
                    fmt::format("found light_map.lmbake beside {}, expected a light map of Godot: {}",
                                entry.description.parts.empty() ? "bake = \"" + entry.description.bake + "\"" : "files",
                                fmt::join(formats::lmbakeBakeNames(), " or ")));
}

/// Reads which nodes of the mesh a light map lies on.
std::vector<formats::NodePlace> readPlaces(TableReader& reader, const LightMapEntry& entry, const std::filesystem::path& file) {
    std::vector<formats::NodePlace> places;
    for (const toml::table* table : reader.tables("place")) {
        TableReader place(*table, file, "light_map.place");
        formats::NodePlace& added = places.emplace_back();
        added.node = place.required<std::string>("node", "the name of a node of the mesh");
        const auto readTwo = [&](const char* key, const char* expected, std::array<double, 2>& out) {
            const auto found = place.numbers(key, expected);
            if (!found) return;
            const auto isWithin = [](double each) { return std::abs(each) <= formats::kMostPlace; };
            if (found->size() != 2 || !std::ranges::all_of(*found, isWithin))
                place.fail(place.node(key), fmt::format("found {} for light_map.place.{}, expected {} up to {:g}",
                                                        found->size() == 2 ? fmt::format("[{}]", fmt::join(*found, ", "))
                                                                           : fmt::format("{} numbers", found->size()),
                                                        key, expected, formats::kMostPlace));
            out = {(*found)[0], (*found)[1]};
        };
        readTwo("scale", "factors [x, y] of the UVs", added.scale);
        readTwo("offset", "shares [x, y] of the map", added.offset);
        if (added.scale[0] == 0 || added.scale[1] == 0)
            place.fail(place.node("scale"), "found 0 for light_map.place.scale, expected factors other than 0");
    }
    if (places.empty()) return places;
    if (!entry.mesh)
        reader.fail(reader.node("place"),
                    fmt::format("found light_map.place without a mesh for '{}', expected mesh = \"FILE\": it names its "
                                "nodes",
                                entry.name));
    if (!entry.description.lmbake.empty())
        reader.fail(reader.node("place"), fmt::format("found light_map.place beside {}, which places the nodes too, expected one of them: "
                                                      "lmbake = \"{}\" leaves the file out",
                                                      entry.description.lmbake.filename().string(), formats::kNoLmbake));
    return places;
}

LightMapEntry readLightMap(TableReader reader, const formats::ColorSpaces& colors, const std::filesystem::path& file) {
    LightMapEntry entry;
    entry.name = readName(reader);
    entry.description.bake = readBake(reader);
    entry.file = reader.has("files") ? readFiles(reader, entry.description) : reader.requiredPath("file");
    readConventions(reader, entry.description);
    entry.description.colors = colors;
    entry.maxVisible = readVisibleLimit(reader, "max_visible");
    entry.maxVisibleBound = readVisibleLimit(reader, "max_visible_bound");
    entry.layouts = readLayouts(reader);
    entry.maxSeam = readVisibleLimit(reader, "max_seam");
    entry.mips = readMips(reader);
    entry.mesh = reader.optionalPath("mesh");
    entry.description.mesh = entry.mesh.value_or("");
    if (entry.description.coverage == formats::CoverageSource::Mesh && !entry.mesh)
        reader.fail(reader.node("coverage"), "found coverage \"mesh\" for a light map without a mesh, expected mesh = \"FILE\"");
    if (entry.maxSeam && !entry.mesh)
        reader.fail(
            reader.node("max_seam"),
            fmt::format("found light_map.max_seam without a mesh for '{}', expected mesh = \"FILE\": seams are at its edges", entry.name));
    readLmbake(reader, entry);
    entry.description.places = readPlaces(reader, entry, file);
    entry.groundTruth = reader.optionalPath("ground_truth");
    readDominantFit(reader, entry);
    entry.charts = readChartSettings(reader);
    readDominantLayout(reader, entry);
    return entry;
}

ProbeEntry readProbe(TableReader reader) {
    ProbeEntry entry;
    entry.name = readName(reader);
    entry.file = reader.requiredPath("file");
    entry.sh = reader.optionalPath("sh");
    if (reader.isString("size")) {
        reader.oneOf("size", {std::string(kAutoProbeSize)}, "");
    } else if (const auto size = reader.optional<std::int64_t>("size", "a power of two or \"auto\"")) {
        reader.check("size", objectionToProbeSize(*size));
        entry.size = static_cast<int>(*size);
        entry.readLevelsOnly = false;
    }
    entry.layout = info(reader.oneOfRows("layout", allCubemapLayouts())).name;
    entry.maxVisible = readVisibleLimit(reader, "max_visible");
    entry.maxVisibleBound = readVisibleLimit(reader, "max_visible_bound");
    const auto numbers = [&](const char* key, std::size_t count, const char* expected) {
        auto found = reader.numbers(key, expected);
        if (found && found->size() != count)
            reader.fail(reader.node(key), fmt::format("found {} numbers for probe.{}, expected {}", found->size(), key, expected));
        return found;
    };
    const auto three = [](const std::vector<double>& all, std::size_t first) {
        return glm::dvec3(all[first], all[first + 1], all[first + 2]);
    };
    if (const auto found = numbers("position", 3, "a place [x, y, z]")) entry.place.position = three(*found, 0);
    if (const auto found = numbers("box", 6, "the corners [x, y, z, X, Y, Z], the lowest first"))
        entry.place.box = std::array{three(*found, 0), three(*found, 3)};
    entry.place.radius = reader.optional<double>("radius", "a positive number");
    if (const std::string expected = formats::objectionToProbePlace(entry.place); !expected.empty()) {
        const bool isRadius = entry.place.radius && !(*entry.place.radius > 0 && std::isfinite(*entry.place.radius));
        const auto corner = [&](std::size_t i) {
            return fmt::format("{}, {}, {}", (*entry.place.box)[i].x, (*entry.place.box)[i].y, (*entry.place.box)[i].z);
        };
        const std::string found = isRadius ? fmt::format("{}", *entry.place.radius) : fmt::format("[{}, {}]", corner(0), corner(1));
        const char* const key = isRadius ? "radius" : "box";
        reader.fail(reader.node(key), fmt::format("found {} for probe.{}, expected {}", found, key, expected));
    }
    return entry;
}

GradientEntry readGradient(TableReader reader) {
    GradientEntry entry;
    entry.name = readName(reader);
    entry.file = reader.requiredPath("file");
    if (const auto exponents = reader.numbers("exponents", "1 to 256 increasing Phong exponents from 1 to 65536")) {
        reader.check("exponents", objectionToExponents(*exponents));
        entry.exponents = *exponents;
    }
    entry.encoding = reader.oneOf("encoding", kGradientEncodings, entry.encoding);
    if (const auto axis = reader.numbers("axis", "a direction [x, y, z] other than zero")) {
        reader.check("axis", objectionToAxis(*axis));
        entry.axis = directionOfAxis(*axis);
        if (reader.has("encoding") && entry.encoding != "auto")
            reader.fail(reader.node("encoding"), "found gradient.encoding beside an axis, expected it for painted gradients alone");
    }
    if (const auto zones = reader.optional<std::int64_t>("zones", "an integer from 1 to 4096")) {
        if (*zones < 1 || *zones > kMostGradientZones)
            reader.fail(reader.node("zones"), fmt::format("found {} for gradient.zones, expected 1 to {}", *zones, kMostGradientZones));
        if (!entry.axis) reader.fail(reader.node("zones"), "found gradient.zones without an axis, expected the axis to average around");
        entry.zones = static_cast<int>(*zones);
    }
    if (reader.has("format")) entry.format = reader.oneOf("format", rsrmFormatChoices(), "");
    entry.dither = reader.optional<bool>("dither", "true or false").value_or(false);
    entry.maxVisible = readVisibleLimit(reader, "max_visible");
    entry.maxVisibleBound = readVisibleLimit(reader, "max_visible_bound");
    return entry;
}

MaterialEntry readMaterial(TableReader reader) {
    MaterialEntry entry;
    entry.name = reader.required<std::string>("name", "a material's name, or \"*\"");
    entry.normalMap = reader.optional<bool>("normal_map", "true or false");
    entry.specular = reader.optional<bool>("specular", "true or false");
    entry.m = reader.range("m", 0, 1);
    entry.f0 = reader.range("f0", 0, 1);
    entry.normalMapTilt = reader.optional<double>("normal_map_tilt", "an angle in degrees");
    if (entry.normalMapTilt) reader.check("normal_map_tilt", objectionToNormalMapTilt(*entry.normalMapTilt));
    return entry;
}

/// Returns the names of light maps, probes and gradients.
std::vector<std::string> assetNames(const Scene& scene) {
    std::vector<std::string> names;
    for (const LightMapEntry& entry : scene.lightMaps) names.push_back(entry.name);
    for (const ProbeEntry& entry : scene.probes) names.push_back(entry.name);
    for (const GradientEntry& entry : scene.gradients) names.push_back(entry.name);
    return names;
}

int lineOf(const toml::node& node) {
    return static_cast<int>(node.source().begin.line);
}

/// Refuses two assets of one name: they would overwrite each other's files in the output folder. So would names that differ in the case of
/// letters alone, where the file system does not tell it apart: on Windows and macOS.
void refuseRepeatedNames(TableReader& root, const std::filesystem::path& file) {
    static const std::set<std::string> kReserved = {"cooked", "report", "lightcook", "specular"};
    struct Claim {
        std::string name;
        int line = 0;
    };
    std::map<std::string, Claim> claims;  // by the lower case of the name
    for (const char* section : {"light_map", "probe", "gradient"})
        for (const toml::table* table : root.tables(section)) {
            const TableReader reader(*table, file, section);
            const toml::node& node = reader.node("name");
            const std::string name = node.value_or(std::string()), lower = inLowerCase(name);
            if (kReserved.contains(lower))
                reader.fail(node, fmt::format("found the reserved name '{}', expected another one: files of the output folder are called "
                                              "{}",
                                              name, fmt::join(kReserved, ", ")));
            const auto [first, isNew] = claims.try_emplace(lower, Claim{name, lineOf(node)});
            if (isNew) continue;
            const Claim& other = first->second;
            if (other.name == name)
                reader.fail(node, fmt::format("found the name '{}' twice, expected a name of its own for every light map, probe and "
                                              "gradient: the first is in line {}",
                                              name, other.line));
            reader.fail(node, fmt::format("found the names '{}' in line {} and '{}', expected names that differ in more than the case of "
                                          "letters: Windows and macOS hold them for one",
                                          other.name, other.line, name));
        }
}

/// Refuses a second table of one material: it would override the first one.
void refuseRepeatedMaterial(const Scene& scene, const TableReader& reader) {
    const std::string& name = scene.materials.back().name;
    if (std::ranges::count(scene.materials, name, &MaterialEntry::name) < 2) return;
    reader.fail(reader.node("name"),
                fmt::format("found the material '{}' twice, expected one table [[material]] of that name: the first is in line {}", name,
                            scene.lines.find("material", name).value_or(0)));
}

std::vector<std::string> axisNames(const std::vector<fit::AxisMapping>& mappings) {
    std::vector<std::string> names = {"auto"};
    for (const fit::AxisMapping& mapping : mappings) names.push_back(mapping.name);
    return names;
}

TableSettings readTables(TableReader reader, lighting::SpecularLobe sceneLobe) {
    TableSettings tables;
    const auto count = [&](const char* key, int least) -> std::optional<int> {
        const auto value = reader.optional<std::int64_t>(key, "an integer up to 1024");
        if (value && (*value < least || *value > kMostTableNodes))
            reader.fail(reader.node(key), fmt::format("found {} for tables.{}, expected an integer from {} to 1024", *value, key, least));
        return value ? std::optional(static_cast<int>(*value)) : std::nullopt;
    };
    tables.viewCount = count("views", 2);
    tables.roughnessCount = count("rows", 1);
    if (const auto lobe = readLobe(reader); reader.has("lobe")) reader.check("lobe", objectionToTableLobe(lobe, sceneLobe));
    tables.normalization = reader.oneOf("normalization", kNormalizationNames, tables.normalization);
    if (reader.has("normalization")) reader.check("normalization", objectionToNormalization(tables.normalization, sceneLobe));
    tables.viewAxis = reader.oneOf("view_axis", viewAxisNames(), tables.viewAxis);
    tables.roughnessAxis = reader.oneOf("roughness_axis", roughnessAxisNames(), tables.roughnessAxis);
    tables.maxVisible = readVisibleLimit(reader, "max_visible");
    tables.maxVisibleBound = readVisibleLimit(reader, "max_visible_bound");
    return tables;
}

/// Reads an element of `allow`: a code, or a table with a code, a reason and an asset.
/// assets  names of the scene's assets
Allowance readAllowance(const TableReader& root, const toml::node& node, const std::vector<std::string>& assets) {
    static const std::vector<std::string> kKeys = {"code", "reason", "asset"};
    const toml::table* table = node.as_table();
    const std::string expected = "a code of `lightcook lint`, or { code = \"...\", reason = \"...\" }";
    const auto text = [&](const char* key) {
        const toml::node* value = table->get(key);
        if (value != nullptr && !value->is_string())
            root.fail(*value, fmt::format("found {} that is no string in allow, expected {}", key, expected));
        return value == nullptr ? std::string() : value->value_or(std::string());
    };
    if (table != nullptr)
        for (const auto& [key, value] : *table)
            if (const std::string name(key.str()); std::ranges::find(kKeys, name) == kKeys.end())
                root.fail(value, fmt::format("found unknown key '{}' in allow, expected one of: {}{}", name, listed(kKeys),
                                             formats::nearestHint(name, kKeys)));
    const std::string code = table != nullptr ? text("code") : node.value_or(std::string());
    if (code.empty()) root.fail(node, fmt::format("found no code in allow, expected {}", expected));
    const LintCheckInfo* check = formats::findByName(allLintChecks(), code);
    if (check == nullptr)
        root.fail(node, fmt::format("found the code '{}' in allow, expected one of `lightcook lint`{}", code,
                                    formats::nearestHint(code, formats::namesOf(allLintChecks()))));
    if (check->severity == LintSeverity::Error)
        root.fail(node,
                  fmt::format("found the code '{}' in allow, expected a warning: this one is an error, which cannot be allowed", code));
    if (table == nullptr) return Allowance{check->id};
    Allowance allowance{check->id, text("asset"), text("reason")};
    if (!allowance.asset.empty() && std::ranges::find(assets, allowance.asset) == assets.end())
        root.fail(*table->get("asset"),
                  fmt::format("found the asset '{}' in allow, expected a light map, probe or gradient of this scene{}", allowance.asset,
                              assets.empty() ? ", which has none" : formats::nearestHint(allowance.asset, assets)));
    return allowance;
}

/// Adds the lines of a table and its keys.
void addLines(const toml::table& table, std::string_view section, SceneLines& lines) {
    const std::string name = table["name"].value_or(std::string());
    lines.add(section, section.empty() ? "" : name, "", std::max(1, lineOf(table)));
    for (const auto& [key, node] : table)
        lines.add(section, section.empty() ? "" : name, key.str(), static_cast<int>(key.source().begin.line));
}

SceneLines linesOf(const toml::table& root) {
    SceneLines lines;
    addLines(root, "", lines);
    for (const auto& [key, node] : root) {
        if (const toml::table* table = node.as_table()) addLines(*table, key.str(), lines);
        if (const toml::array* array = node.as_array())
            for (const toml::node& element : *array)
                if (const toml::table* table = element.as_table()) addLines(*table, key.str(), lines);
    }
    return lines;
}

Scene readRoot(const toml::table& root, const std::filesystem::path& file) {
    Scene scene;
    scene.lines = linesOf(root);
    scene.file = file;
    scene.directory = file.parent_path();
    TableReader reader(root, file, "");
    const std::int64_t schema = reader.required<std::int64_t>("schema", "schema = 1");
    if (schema != 1) reader.fail(reader.node("schema"), fmt::format("found schema {}, expected 1", schema));
    scene.name = readName(reader);
    scene.lobe = readLobe(reader);
    scene.up = reader.oneOfRows("up_axis", allUpAxes());
    if (const toml::table* table = reader.table("output")) scene.output = readOutput({*table, file, "output"});
    if (const toml::table* table = reader.table("color")) scene.colors = readColors({*table, file, "color"});
    if (const toml::table* table = reader.table("display")) scene.display = readDisplay({*table, file, "display"});
    if (const toml::table* table = reader.table("tables")) scene.tables = readTables({*table, file, "tables"}, scene.lobe);
    for (const toml::table* table : reader.tables("light_map")) {
        scene.lightMaps.push_back(readLightMap({*table, file, "light_map"}, scene.colors, file));
        if (const std::string why = whyNotLayouts(scene.output, scene.lightMaps.back()); !why.empty())
            reader.fail(*table->get("layouts"), why);
    }
    for (const toml::table* table : reader.tables("probe")) scene.probes.push_back(readProbe({*table, file, "probe"}));
    for (const toml::table* table : reader.tables("gradient")) scene.gradients.push_back(readGradient({*table, file, "gradient"}));
    for (const toml::table* table : reader.tables("material")) {
        scene.materials.push_back(readMaterial({*table, file, "material"}));
        refuseRepeatedMaterial(scene, {*table, file, "material"});
    }
    if (const toml::array* allowances = reader.array("allow", "a list of codes"))
        for (const toml::node& node : *allowances) scene.allowances.push_back(readAllowance(reader, node, assetNames(scene)));
    const auto refuseOutput = [&](const char* key, const std::string& why) {
        const TableReader output(*reader.table("output"), file, "output");
        output.fail(output.node(key), why);
    };
    if (const std::string why = whyNotSeams(scene); !why.empty()) refuseOutput("max_seam", why);
    if (scene.output.gltf && std::ranges::none_of(scene.lightMaps, [](const LightMapEntry& entry) { return entry.mesh.has_value(); }))
        refuseOutput("gltf", "found output.gltf where no light map has a mesh, expected mesh = \"FILE\" in a [[light_map]]");
    refuseRepeatedNames(reader, file);
    return scene;
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

std::string placeIn(const Scene& scene, std::string_view section, std::string_view name, std::string_view key,
                    const std::string& otherwise) {
    if (scene.file.empty()) return otherwise;
    const auto line = scene.lines.find(section, name, key);
    return line ? fmt::format("{}:{}", scene.file.string(), *line) : scene.file.string();
}

Result<Scene> readScene(const std::filesystem::path& file) {
    constexpr std::uint64_t kMostBytes = std::uint64_t{16} << 20;
    std::error_code code;
    const auto kind = std::filesystem::status(file, code).type();
    if (kind == std::filesystem::file_type::directory && std::filesystem::is_regular_file(file / "scene.toml", code))
        return failure(ErrorCode::InvalidRequest, file.string(),
                       fmt::format("found a folder, expected a scene file (TOML), such as {}", (file / "scene.toml").string()));
    if (kind == std::filesystem::file_type::regular && looksBinary(file))
        return failure(ErrorCode::InvalidRequest, file.string(),
                       "found a file that is no UTF-8 text, expected a scene file (TOML): `lightcook init` writes one for a bake");
    if (kind != std::filesystem::file_type::regular)
        return failure(ErrorCode::InvalidRequest, file.string(),
                       fmt::format("found {}, expected a scene file (TOML)",
                                   kind == std::filesystem::file_type::directory ? "a folder"
                                   : kind == std::filesystem::file_type::not_found || kind == std::filesystem::file_type::none
                                       ? "no such file"
                                       : "something that is no file"));
    return readToml(file, kMostBytes, "a scene file, which is 3 deep", [&](const toml::table& root) { return readRoot(root, file); });
}

}  // namespace lightcook::pipeline
