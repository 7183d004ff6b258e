#include "pipeline/scene/scene.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <set>
#include <stdexcept>
#include <type_traits>

#include "fit/specular_tables.h"
#include "formats/color.h"
#include "formats/light_map_layout.h"
#include "formats/nearest.h"
#include "formats/read_file.h"
#include "formats/vocabulary.h"
#include "pipeline/scene/checks.h"
#include "pipeline/scene/cubemap_layout.h"
#include "pipeline/scene/dominant_fit.h"
#include "pipeline/scene/dominant_layout.h"
#include "pipeline/scene/keys.h"
#include "pipeline/scene/rsrm_format.h"
#include "pipeline/scene/toml_nesting.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Thrown inside this file only, at the first mistake of a table; readScene returns it as an error.
struct SceneMistake {
    formats::Error error;
};

std::string inQuotes(std::string_view text) {
    return fmt::format("'{}'", text);
}

std::string listed(const std::vector<std::string>& names) {
    return fmt::format("{}", fmt::join(names, ", "));
}

std::string costOf(const formats::LightMapLayoutInfo& layout) {
    return fmt::format("{} ({} fetches, {} operations)", layout.name, layout.tapCount(), layout.decodeOps);
}

/// Returns what is wrong with limits that no layout of a list keeps, or an empty text.
std::string whyNoneKeeps(const formats::DecodeLimits& decode, const formats::LayoutList& layouts) {
    std::string costs;
    for (const formats::LightMapLayoutInfo& each : formats::allLightMapLayouts()) {
        if (!formats::isCandidate(layouts, each)) continue;
        if (decode.allow(each)) return "";
        costs += (costs.empty() ? "" : ", ") + costOf(each);
    }
    return fmt::format("found limits on the decode that no layout keeps, expected those of one of {}", costs);
}

/// Reads the keys of one table of the file. The constructor refuses keys that the section does not have (keys.h).
class TableReader {
public:
    /// `section`: a name of keys.h; empty for the keys before the first table.
    TableReader(const toml::table& table, std::filesystem::path file, std::string_view section)
        : table_(table), file_(std::move(file)), name_(section.empty() ? "the scene" : section), section_(sceneSection(section)) {
        refuseUnknownKeys();
    }

    [[noreturn]] void fail(const toml::node& node, const std::string& detail) const {
        const toml::source_position at = node.source().begin;
        throw SceneMistake{{ErrorCode::InvalidRequest, fmt::format("{}:{}:{}", file_.string(), at.line, at.column), detail}};
    }

    /// Refuses the value of a key that a check objects to.
    void check(const char* key, const Objection& objection) const {
        if (objection) fail(node(key), fmt::format("found {} for {}.{}, expected {}", objection->found, name_, key, objection->expected));
    }

    /// Reads the name of a row of a table.
    template <class Row>
    auto oneOfRows(const char* key, std::span<const Row> rows) {
        const Row* row = formats::findByName(rows, oneOf(key, formats::namesOf(rows), std::string(rows.front().name)));
        if (row == nullptr) throw std::logic_error(fmt::format("the key '{}' has a name without a row", key));
        return row->id;
    }

    bool has(const char* key) const { return table_.contains(key); }
    bool isString(const char* key) const { return table_[key].is_string(); }

    template <class T>
    std::optional<T> optional(const char* key, const char* expected) {
        requireRow(key);
        const toml::node* node = table_.get(key);
        if (node == nullptr) return std::nullopt;
        std::optional<T> value;
        if constexpr (std::is_same_v<T, bool>)
            value = node->value_exact<bool>();  // numbers are none
        else if (!node->is_boolean())           // toml++ converts true to 1
            value = node->value<T>();
        if (!value) fail(*node, fmt::format("found {} for {}.{}, expected {}", typeName(*node), name_, key, expected));
        return value;
    }

    /// Reads a fraction: a number, or a string such as "2%".
    std::optional<double> fraction(const char* key, const char* expected) {
        requireRow(key);
        const toml::node* node = table_.get(key);
        if (node == nullptr || !node->is_string()) return optional<double>(key, expected);
        const std::string text = node->value_or(std::string());
        const auto value = parseFraction(text);
        if (!value || !text.ends_with('%'))
            fail(*node, fmt::format("found {} for {}.{}, expected {}", typeName(*node), name_, key, expected));
        return value;
    }

    template <class T>
    T required(const char* key, const char* expected) {
        const std::optional<T> value = optional<T>(key, expected);
        if (!value) fail(table_, fmt::format("found no key '{}' in {}, expected {}", key, name_, expected));
        return *value;
    }

    std::string oneOf(const char* key, const std::vector<std::string>& choices, const std::string& otherwise) {
        std::string value = optional<std::string>(key, "a string").value_or(otherwise);
        if (std::find(choices.begin(), choices.end(), value) == choices.end())
            fail(*table_.get(key), fmt::format("found {} for {}.{}, expected one of: {}", inQuotes(value), name_, key, listed(choices)));
        return value;
    }

    /// Returns the path relative to the scene file's folder.
    std::filesystem::path resolve(const std::string& text) const { return (file_.parent_path() / text).lexically_normal(); }
    std::filesystem::path requiredPath(const char* key) { return pathOf(key, required<std::string>(key, "a path")); }
    std::optional<std::filesystem::path> optionalPath(const char* key) {
        const auto text = optional<std::string>(key, "a path");
        if (!text) return std::nullopt;
        return pathOf(key, *text);
    }
    std::filesystem::path pathOf(const char* key, const std::string& text) {
        if (text.empty()) fail(node(key), fmt::format("found an empty path for {}.{}, expected a path", name_, key));
        checkPath(node(key), key, text);
        return resolve(text);
    }

    /// Refuses a path with a character 0: the system would open the file of the part before it.
    void checkPath(const toml::node& node, std::string_view key, const std::string& text) const {
        if (text.find('\0') != std::string::npos)
            fail(node, fmt::format("found a character 0 in the path {} for {}.{}, expected none", inQuotes(text), name_, key));
    }

    /// Returns nullptr if the key is missing.
    const toml::array* array(const char* key, const char* expected) {
        requireRow(key);
        const toml::node* node = table_.get(key);
        if (node != nullptr && !node->is_array())
            fail(*node, fmt::format("found {} for {}.{}, expected {}", typeName(*node), name_, key, expected));
        return node == nullptr ? nullptr : node->as_array();
    }

    std::optional<std::vector<double>> numbers(const char* key, const char* expected) {
        const toml::array* array = this->array(key, expected);
        if (array == nullptr) return std::nullopt;
        std::vector<double> values;
        for (const toml::node& element : *array) {
            const std::optional<double> value = element.is_number() ? element.value<double>() : std::nullopt;
            if (!value || !std::isfinite(*value))
                fail(element, fmt::format("found {} in {}.{}, expected {}", typeName(element), name_, key, expected));
            values.push_back(*value);
        }
        return values;
    }

    std::optional<Range> range(const char* key, double lowest, double highest) {
        const std::string expected = fmt::format("[low, high] with {} <= low <= high <= {}", lowest, highest);
        const auto values = numbers(key, expected.c_str());
        if (!values) return std::nullopt;
        check(key, objectionToRange(*values, lowest, highest));
        return Range{(*values)[0], (*values)[1]};
    }

    const toml::table* table(const char* key) {
        const toml::node* node = table_.get(key);
        if (node == nullptr) return nullptr;
        if (!node->is_table()) fail(*node, fmt::format("found {} for '{}', expected a table [{}]", typeName(*node), key, key));
        return node->as_table();
    }

    /// Returns the table that a key holds.
    const toml::table& requiredTable(const char* key, const char* expected) {
        requireRow(key);
        const toml::node& value = node(key);
        if (!value.is_table()) fail(value, fmt::format("found {} for {}.{}, expected {}", typeName(value), name_, key, expected));
        return *value.as_table();
    }

    std::vector<const toml::table*> tables(const char* key) {
        std::vector<const toml::table*> found;
        const toml::node* node = table_.get(key);
        if (node == nullptr) return found;
        const toml::array* array = node->as_array();
        if (array == nullptr) fail(*node, fmt::format("found {} for '{}', expected tables [[{}]]", typeName(*node), key, key));
        for (const toml::node& element : *array) {
            if (!element.is_table()) fail(element, fmt::format("found {} in '{}', expected a table", typeName(element), key));
            found.push_back(element.as_table());
        }
        return found;
    }

    const toml::node& node(const char* key) const { return *table_.get(key); }
    std::string place(const char* key) const {
        const toml::source_position at = table_.get(key)->source().begin;
        return fmt::format("{}:{}:{}", file_.string(), at.line, at.column);
    }

private:
    void refuseUnknownKeys() const {
        std::vector<std::string> known = formats::namesOf(std::span<const SceneKeyInfo>(section_.keys));
        if (section_.name.empty())  // sections are keys of the root
            for (const SceneSectionInfo& section : allSceneSections())
                if (!section.name.empty()) known.emplace_back(section.name);
        for (const auto& [key, node] : table_) {
            const std::string name(key.str());
            if (std::find(known.begin(), known.end(), name) != known.end()) continue;
            const toml::source_position at = key.source().begin;
            throw SceneMistake{{ErrorCode::InvalidRequest, fmt::format("{}:{}:{}", file_.string(), at.line, at.column),
                                fmt::format("found unknown key '{}' in {}, expected one of its keys; nearest is '{}'", name, name_,
                                            formats::nearestName(name, known))}};
        }
    }

    /// Throws if a key that is read has no row in keys.h.
    void requireRow(std::string_view key) const {
        if (formats::findByName(std::span<const SceneKeyInfo>(section_.keys), key) == nullptr)
            throw std::logic_error(fmt::format("the key '{}' of {} has no row", key, name_));
    }

    static std::string typeName(const toml::node& node) {
        switch (node.type()) {
            case toml::node_type::string:
                return fmt::format("the string '{}'", node.value_or(std::string()));
            case toml::node_type::integer:
                return fmt::format("the integer {}", node.value_or(std::int64_t{0}));
            case toml::node_type::floating_point:
                return fmt::format("the number {}", node.value_or(0.0));
            case toml::node_type::boolean:
                return node.value_or(false) ? "true (a boolean)" : "false (a boolean)";
            case toml::node_type::array:
                return "an array";
            case toml::node_type::table:
                return "a table";
            default:
                return "a date or time";
        }
    }

    const toml::table& table_;
    std::filesystem::path file_;
    std::string name_;  ///< for messages
    const SceneSectionInfo& section_;
};

std::optional<double> readMaxVisible(TableReader& reader, const char* key = "max_visible") {
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

std::optional<int> readLeastOne(TableReader& reader, const char* key) {
    const auto value = reader.optional<std::int64_t>(key, "a positive integer");
    if (value && (*value < 1 || *value > kMostDecodeCost))
        reader.fail(reader.node(key),
                    fmt::format("found {} for output.{}, expected an integer from 1 to {}", *value, key, kMostDecodeCost));
    return value ? std::optional(static_cast<int>(*value)) : std::nullopt;
}

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
            reader.fail(element, fmt::format("found the layout {} in layouts, expected one of: {}; nearest is {}", inQuotes(*name),
                                             listed(lightMapLayoutNames()), inQuotes(formats::nearestName(*name, lightMapLayoutNames()))));
        if (std::ranges::find(layouts, *name) != layouts.end())
            reader.fail(element, fmt::format("found the layout {} twice in layouts, expected it once", inQuotes(*name)));
        layouts.push_back(*name);
    }
    return layouts;
}

/// Reads what the decode may cost. Fails for limits that no layout keeps, and for a cost that nothing uses.
void readDecode(TableReader& reader, OutputSettings& output) {
    output.cost = reader.oneOfRows("cost", formats::allLayoutCosts());
    output.decode = {readLeastOne(reader, "max_fetches"), readLeastOne(reader, "max_decode_ops")};
    output.layouts = readLayouts(reader);
    if (const std::string why = whyNotDecode(output); !why.empty())
        reader.fail(reader.node(output.decode.maxFetches ? "max_fetches" : output.decode.maxDecodeOps ? "max_decode_ops" : "layouts"), why);
    const bool isAuto = layoutAsked(output) == kAutoLayout;
    if (reader.has("cost") && !(isAuto && (output.isErrorLimited() || !output.budgetBytes)))
        reader.fail(reader.node("cost"),
                    fmt::format("found output.cost where {}, expected light_map_layout = \"auto\" with max_error or max_visible",
                                isAuto ? "a budget chooses the layouts" : "the layout is named"));
}

/// Reads the key `mips`. A number of levels is refused: charts decide it.
std::optional<bool> readMips(TableReader& reader) {
    return reader.optional<bool>("mips", "true or false: the charts of a map decide how many levels it has");
}

OutputSettings readOutput(TableReader reader) {
    OutputSettings output;
    output.target = reader.oneOfRows("target", formats::allTargets());
    const auto fraction = [&](const char* key, double otherwise) {
        const auto value = reader.fraction(key, "a positive fraction: 0.02, or \"2%\"");
        if (value && (!(*value > 0) || !std::isfinite(*value)))
            reader.fail(reader.node(key),
                        fmt::format("found {} for output.{}, expected a positive fraction: 0.02, or \"2%\"", *value, key));
        return value.value_or(otherwise);
    };
    output.isErrorAsked = reader.has("max_error");
    output.maxError = fraction("max_error", output.maxError);
    if (reader.has("max_converter_error")) output.maxConverterError = fraction("max_converter_error", kDefaultMaxError);
    output.maxVisible = readMaxVisible(reader);
    output.maxVisibleBound = readMaxVisible(reader, "max_visible_bound");
    output.maxConverterVisible = readMaxVisible(reader, "max_converter_visible");
    output.maxSeam = readMaxVisible(reader, "max_seam");
    output.maxWholeVisible = readMaxVisible(reader, "max_whole_visible");
    if (reader.has("max_whole_error")) output.maxWholeError = fraction("max_whole_error", kDefaultMaxError);
    if (const auto text = reader.optional<std::string>("budget", "a size such as \"2 MiB\"")) {
        const auto bytes = parseByteCount(*text, reader.place("budget"));
        if (!bytes) throw SceneMistake{bytes.error()};
        output.budgetBytes = *bytes;
    }
    if (reader.has("light_map_layout")) output.lightMapLayout = reader.oneOf("light_map_layout", lightMapLayoutChoices(), "");
    readDecode(reader, output);
    output.objective = reader.oneOfRows("objective", formats::allObjectives());
    output.container = reader.oneOf("container", {"ktx2", "dds"}, "ktx2") == "dds" ? formats::Container::Dds : formats::Container::Ktx2;
    output.zstd = reader.optional<bool>("zstd", "true or false").value_or(false);
    if (output.zstd && output.container == formats::Container::Dds)
        reader.fail(reader.node("zstd"),
                    "found zstd = true with container = \"dds\", expected container = \"ktx2\": DDS has no supercompression");
    if (const std::string why = whyNotContainer(output); !why.empty()) reader.fail(reader.node("container"), why);
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
        if (*rdo > 0 && output.target != Target::Bc)
            reader.fail(reader.node("rdo"),
                        fmt::format("found output.rdo with target = \"{}\", expected target = \"bc\"", formats::info(output.target).name));
        output.rdo = *rdo;
    }
    output.draco = reader.optional<bool>("draco", "true or false").value_or(true);
    output.charts = readChartSettings(reader);
    output.gltf = reader.optional<bool>("gltf", "true or false").value_or(false);
    if (const std::string why = whyNotGltf(output); !why.empty()) reader.fail(reader.node("gltf"), why);
    output.mips = readMips(reader).value_or(false);
    output.keepUnused = reader.optional<bool>("keep_unused", "true or false").value_or(false);
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
    for (const auto& [key, space] : {std::pair("source", &colors.source), std::pair("working", &colors.working)}) {
        const auto checked = formats::checkColorSpace(*space, colors.config);
        if (checked) continue;
        // The default of a key that is not there may be unknown to a config file.
        const std::string place = reader.has(key) ? reader.place(key) : reader.place("config");
        throw SceneMistake{
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
    return reader.oneOf(isOldName ? "layout" : "bake", formats::bakeNames(), std::string(formats::kAutoBake));
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
    if (!format) throw SceneMistake{format.error()};
    if (description.bake != formats::kAutoBake && description.bake != (*format)->name)
        reader.fail(reader.node("files"),
                    fmt::format("found the images of bake format {} beside bake = \"{}\", expected that bake or \"{}\"", (*format)->name,
                                description.bake, formats::kAutoBake));
    const auto whole = description.partFiles.find("sh00");
    return whole != description.partFiles.end() ? whole->second : description.partFiles.at("sh00.R");
}

LightMapEntry readLightMap(TableReader reader, const formats::ColorSpaces& colors) {
    LightMapEntry entry;
    entry.name = readName(reader);
    entry.description.bake = readBake(reader);
    entry.file = reader.has("files") ? readFiles(reader, entry.description) : reader.requiredPath("file");
    entry.description.phase = reader.oneOfRows("phase", formats::conventions<formats::ShPhase>());
    entry.description.frame = reader.oneOfRows("frame", formats::conventions<formats::ShFrame>());
    entry.description.quantity = reader.oneOfRows("quantity", formats::conventions<formats::ShQuantity>());
    entry.description.encoding = reader.oneOfRows("encoding", formats::conventions<formats::LightEncoding>());
    entry.description.coverage = reader.oneOfRows("coverage", formats::conventions<formats::CoverageSource>());
    entry.description.image = reader.optional<std::string>("image", "the name of an image in the glTF").value_or("");
    entry.description.lightUnits = reader.oneOfRows("light_units", formats::conventions<formats::LightUnits>());
    if (const auto limit = reader.optional<double>("firefly_limit", "a number from 1, or 0 for no check")) {
        reader.check("firefly_limit", objectionToFireflyLimit(*limit));
        entry.description.fireflyLimit = *limit;
    }
    entry.description.colors = colors;
    entry.maxVisible = readMaxVisible(reader);
    entry.maxVisibleBound = readMaxVisible(reader, "max_visible_bound");
    entry.layouts = readLayouts(reader);
    entry.maxSeam = readMaxVisible(reader, "max_seam");
    entry.mips = readMips(reader);
    entry.mesh = reader.optionalPath("mesh");
    entry.description.mesh = entry.mesh.value_or("");
    if (entry.description.coverage == formats::CoverageSource::Mesh && !entry.mesh)
        reader.fail(reader.node("coverage"), "found coverage \"mesh\" for a light map without a mesh, expected mesh = \"FILE\"");
    if (entry.maxSeam && !entry.mesh)
        reader.fail(
            reader.node("max_seam"),
            fmt::format("found light_map.max_seam without a mesh for '{}', expected mesh = \"FILE\": seams are at its edges", entry.name));
    entry.groundTruth = reader.optionalPath("ground_truth");
    if (reader.has("dominant_fit")) {
        const auto name = reader.optional<std::string>("dominant_fit", "a string");
        const DominantFitInfo* fit = dominantFitFromName(*name);
        entry.dominantFit =
            fit != nullptr ? std::string(fit->name) : reader.oneOf("dominant_fit", formats::namesOf(allDominantFits()), entry.dominantFit);
    }
    entry.charts = readChartSettings(reader);
    if (reader.has("dominant_layout")) entry.dominantLayout = reader.oneOf("dominant_layout", formats::namesOf(allDominantLayouts()), "");
    return entry;
}

ProbeEntry readProbe(TableReader reader) {
    ProbeEntry entry;
    entry.name = readName(reader);
    entry.file = reader.requiredPath("file");
    entry.sh = reader.optionalPath("sh");
    if (reader.isString("size")) {
        reader.oneOf("size", {std::string(kAutoProbeSize)}, "");
        entry.readLevelsOnly = true;
    } else if (const auto size = reader.optional<std::int64_t>("size", "a power of two or \"auto\"")) {
        reader.check("size", objectionToProbeSize(*size));
        entry.size = static_cast<int>(*size);
        entry.readLevelsOnly = false;
    }
    entry.layout = info(reader.oneOfRows("layout", allCubemapLayouts())).name;
    entry.maxVisible = readMaxVisible(reader);
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
    entry.maxVisible = readMaxVisible(reader);
    return entry;
}

MaterialEntry readMaterial(TableReader reader) {
    MaterialEntry entry;
    entry.name = reader.required<std::string>("name", "a material's name, or \"*\"");
    entry.normalMap = reader.optional<bool>("normal_map", "true or false");
    entry.specular = reader.optional<bool>("specular", "true or false");
    entry.m = reader.range("m", 0, 1);
    entry.f0 = reader.range("f0", 0, 1);
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

/// Refuses two assets of one name: they would overwrite each other's files in the output folder. So would names that differ in the case of
/// letters alone, where the file system does not tell it apart: on Windows and macOS.
void refuseRepeatedNames(const Scene& scene) {
    static const std::set<std::string> kReserved = {"cooked", "report", "lightcook", "specular"};
    std::map<std::string, std::string> names;  // by their lower case
    const auto refuse = [&](const std::string& detail) { throw SceneMistake{{ErrorCode::InvalidRequest, scene.file.string(), detail}}; };
    const auto claim = [&](const std::string& name) {
        const std::string lower = inLowerCase(name);
        const auto [other, isNew] = names.emplace(lower, name);
        if (!isNew && other->second != name)
            refuse(
                fmt::format("found the names '{}' and '{}', expected names that differ in more than the case of letters: "
                            "Windows and macOS hold them for one",
                            other->second, name));
        if (!isNew || kReserved.contains(lower))
            refuse(fmt::format("found the name '{}' twice or reserved, expected a name of its own for every light map, probe and gradient",
                               name));
    };
    for (const std::string& name : assetNames(scene)) claim(name);
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
    tables.maxVisible = readMaxVisible(reader);
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
                root.fail(value, fmt::format("found unknown key '{}' in allow, expected one of its keys; nearest is '{}'", name,
                                             formats::nearestName(name, kKeys)));
    const std::string code = table != nullptr ? text("code") : node.value_or(std::string());
    if (code.empty()) root.fail(node, fmt::format("found no code in allow, expected {}", expected));
    const LintCheckInfo* check = formats::findByName(allLintChecks(), code);
    if (check == nullptr)
        root.fail(node, fmt::format("found the code '{}' in allow, expected one of `lightcook lint`; nearest is '{}'", code,
                                    formats::nearestName(code, formats::namesOf(allLintChecks()))));
    if (check->severity == LintSeverity::Error)
        root.fail(node,
                  fmt::format("found the code '{}' in allow, expected a warning: this one is an error, which cannot be allowed", code));
    if (table == nullptr) return Allowance{check->id};
    Allowance allowance{check->id, text("asset"), text("reason")};
    if (!allowance.asset.empty() && std::ranges::find(assets, allowance.asset) == assets.end())
        root.fail(*table->get("asset"),
                  fmt::format("found the asset '{}' in allow, expected a light map, probe or gradient of this scene{}", allowance.asset,
                              assets.empty() ? ", which has none"
                                             : fmt::format("; nearest is '{}'", formats::nearestName(allowance.asset, assets))));
    return allowance;
}

int lineOf(const toml::node& node) {
    return static_cast<int>(node.source().begin.line);
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
        scene.lightMaps.push_back(readLightMap({*table, file, "light_map"}, scene.colors));
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
    if (const std::string why = whyNotSeams(scene); !why.empty()) {
        const TableReader output(*reader.table("output"), file, "output");
        output.fail(output.node("max_seam"), why);
    }
    refuseRepeatedNames(scene);
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

std::string whyNotRsrm(const GradientEntry& entry, Target target) {
    if (const RsrmFormatInfo* format = rsrmFormatFromName(entry.format); format != nullptr && !format->isFor(target)) {
        std::string possible;
        for (const RsrmFormatInfo& each : allRsrmFormats())
            if (each.isFor(target)) possible += fmt::format("{}\"{}\"", possible.empty() ? "" : ", ", each.name);
        return fmt::format("found format \"{}\" with target \"{}\", expected target \"bc\" or a format of {}", entry.format,
                           formats::info(target).name, possible);
    }
    const std::string_view rgba8 = info(RsrmFormat::Rgba8).name;
    if (entry.dither && !entry.format.empty() && entry.format != rgba8)
        return fmt::format("found dither with format \"{}\", expected format \"{}\", whose codes alone are dithered", entry.format, rgba8);
    return "";
}

std::string whyNotGltf(const OutputSettings& output) {
    return output.gltf && output.container != formats::Container::Ktx2 ? "found glTF with container dds, expected container ktx2" : "";
}

std::string whyNotContainer(const OutputSettings& output) {
    return output.target == Target::Astc && output.container == formats::Container::Dds
               ? "found container dds with target astc, expected container ktx2: DDS has no ASTC formats"
               : "";
}

std::filesystem::path cookedFolder(const Scene& scene, const std::filesystem::path& given) {
    return given.empty() ? std::filesystem::path(scene.name + ".cooked") : given;
}

std::string whyNothing(const Scene& scene) {
    // Materials alone bring the specular tables.
    const bool isEmpty = scene.lightMaps.empty() && scene.probes.empty() && scene.gradients.empty() && scene.materials.empty();
    return isEmpty ? "found nothing to cook, expected at least one table [[light_map]], [[probe]], [[gradient]] or [[material]]" : "";
}

std::string whyNotSeams(const Scene& scene) {
    if (!scene.output.maxSeam) return "";
    const bool hasMesh = std::ranges::any_of(scene.lightMaps, [](const LightMapEntry& entry) { return entry.mesh.has_value(); });
    return hasMesh ? ""
                   : "found a limit on seams where no light map has a mesh, expected mesh = \"FILE\" in a [[light_map]]: seams are at its "
                     "edges";
}

std::string whyNotDecode(const OutputSettings& output) {
    const auto named = formats::lightMapLayoutFromName(layoutAsked(output));
    if (!named) return whyNoneKeeps(output.decode, output.layouts);
    if (!formats::mayTake(output.layouts, formats::info(*named)))
        return fmt::format("found layout {} that the list of layouts ({}) lacks, expected one of the list, or \"auto\"",
                           formats::info(*named).name, listed(output.layouts));
    if (output.decode.allow(formats::info(*named))) return "";
    return fmt::format("found layout {} over the limits on the decode, expected a cheaper one, or \"auto\" with a limit on the error",
                       costOf(formats::info(*named)));
}

const formats::LayoutList& layoutsFor(const OutputSettings& output, const LightMapEntry& entry) {
    return entry.layouts.empty() ? output.layouts : entry.layouts;
}

std::string whyNotLayouts(const OutputSettings& output, const LightMapEntry& entry) {
    if (entry.layouts.empty()) return "";
    const std::string asked = layoutAsked(output);
    if (asked == kAutoLayout) return whyNoneKeeps(output.decode, entry.layouts);
    if (std::ranges::find(entry.layouts, asked) != entry.layouts.end()) return "";
    return fmt::format(
        "found a list of layouts for light map {} without layout {}, which the scene asks for, expected "
        "light_map_layout = \"auto\" in [output], or that layout in the list",
        inQuotes(entry.name), asked);
}

double converterLimit(const OutputSettings& output) {
    return output.maxConverterError.value_or(std::max(output.maxError, kDefaultMaxError));
}

std::optional<double> converterVisibleLimit(const OutputSettings& output, const std::optional<double>& ofAsset) {
    return ofAsset ? ofAsset : output.maxConverterVisible;
}

int viewCountOf(const TableSettings& tables, const OutputSettings& output) {
    return tables.viewCount.value_or(output.isChosenByWhole() ? kFineViewCount : kUsualViewCount);
}

std::string layoutAsked(const OutputSettings& output) {
    if (!output.lightMapLayout.empty()) return output.lightMapLayout;
    return output.isErrorLimited() || output.isChosenByWhole() || !output.layouts.empty() ? kAutoLayout : "ratio";
}

std::optional<double> visibleLimit(const OutputSettings& output, const std::optional<double>& ofLightMap) {
    if (ofLightMap) return ofLightMap;
    if (output.maxVisible) return output.maxVisible;
    const bool isNothingAsked = layoutAsked(output) == kAutoLayout && !output.isErrorLimited() && !output.isChosenByWhole();
    return isNothingAsked ? std::optional(kDefaultMaxVisible) : std::nullopt;
}

std::optional<double> seamLimit(const OutputSettings& output, const LightMapEntry& entry) {
    if (entry.maxSeam) return entry.maxSeam;
    return entry.mesh ? output.maxSeam : std::nullopt;
}

lighting::DisplaySettings displayOf(const Scene& scene, const LightMapEntry& entry) {
    lighting::DisplaySettings display = scene.display;
    if (!display.white) display.white = entry.white;
    return display;
}

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

Result<std::uint64_t> parseByteCount(std::string_view text, const std::string& subject) {
    const auto refuse = [&] {
        return failure(ErrorCode::InvalidRequest, subject,
                       fmt::format("found {}, expected a size such as \"4096\", \"512 KiB\", \"2 MiB\" or \"1.5 GB\"", inQuotes(text)));
    };
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed);
    // from_chars takes a sign, and names such as "inf".
    const bool isDecimal = !text.empty() && ((text[0] >= '0' && text[0] <= '9') || text[0] == '.');
    if (!isDecimal || error != std::errc()) return refuse();
    std::string_view asked = text.substr(static_cast<std::size_t>(end - text.data()));
    while (asked.starts_with(' ')) asked.remove_prefix(1);
    static const std::pair<std::string_view, double> kUnits[] = {{"", 1},         {"B", 1},       {"kB", 1e3},     {"KB", 1e3},
                                                                 {"MB", 1e6},     {"GB", 1e9},    {"KiB", 0x1p10}, {"MiB", 0x1p20},
                                                                 {"GiB", 0x1p30}, {"TiB", 0x1p40}};
    for (const auto& [unit, scale] : kUnits) {
        if (asked != unit) continue;
        const double bytes = number * scale, nearest = std::round(bytes);
        // 2.007 kB is 2006.9999999999998 in doubles.
        const bool isWhole = std::abs(bytes - nearest) <= 4 * std::numeric_limits<double>::epsilon() * bytes;
        const double whole = isWhole ? nearest : std::floor(bytes);
        const bool isFraction = !isWhole && (scale == 1 || whole == 0);
        if (isFraction)
            return failure(ErrorCode::InvalidRequest, subject, fmt::format("found {}, expected a whole number of bytes", inQuotes(text)));
        if (!(bytes < 0x1p63)) return refuse();
        return static_cast<std::uint64_t>(whole);
    }
    return refuse();
}

namespace {

ChartMode chartModeOf(const OutputSettings& output, const LightMapEntry& entry) {
    return entry.charts.mode ? *entry.charts.mode : output.charts.mode.value_or(ChartMode::Keep);
}

}  // namespace

bool hasMips(const OutputSettings& output, const LightMapEntry& entry) {
    return entry.mips.value_or(output.mips);
}

bool isPacked(const OutputSettings& output, const LightMapEntry& entry) {
    return chartModeOf(output, entry) != ChartMode::Keep;
}

bool isSplit(const OutputSettings& output, const LightMapEntry& entry) {
    return chartModeOf(output, entry) == ChartMode::Split;
}

double chartsMaxVisible(const OutputSettings& output, const LightMapEntry& entry) {
    return entry.charts.maxVisible ? *entry.charts.maxVisible : output.charts.maxVisible.value_or(0);
}

Result<Scene> readScene(const std::filesystem::path& file) {
    constexpr std::uint64_t kMostBytes = std::uint64_t{16} << 20;
    constexpr int kDeepest = 16;  // a scene is 3 deep
    std::error_code code;
    const auto kind = std::filesystem::status(file, code).type();
    if (kind == std::filesystem::file_type::directory && std::filesystem::is_regular_file(file / "scene.toml", code))
        return failure(ErrorCode::InvalidRequest, file.string(),
                       fmt::format("found a folder, expected a scene file (TOML), such as {}", (file / "scene.toml").string()));
    if (kind == std::filesystem::file_type::regular && looksBinary(file))
        return failure(ErrorCode::InvalidRequest, file.string(),
                       "found a file that is no text, expected a scene file (TOML): `lightcook init` writes one for a bake");
    if (kind != std::filesystem::file_type::regular)
        return failure(ErrorCode::InvalidRequest, file.string(),
                       fmt::format("found {}, expected a scene file (TOML)",
                                   kind == std::filesystem::file_type::directory ? "a folder"
                                   : kind == std::filesystem::file_type::not_found || kind == std::filesystem::file_type::none
                                       ? "no such file"
                                       : "something that is no file"));
    const auto text = formats::readWholeText(file, kMostBytes);
    if (!text) return failure(ErrorCode::InvalidRequest, text.error().subject, text.error().detail);
    if (const auto place = placeNestedDeeper(*text, kDeepest))
        return failure(ErrorCode::InvalidRequest, fmt::format("{}:{}:{}", file.string(), place->line, place->column),
                       fmt::format("found values nested more than {} deep, expected a scene file, which is 3 deep", kDeepest));
    try {
        return readRoot(toml::parse(*text, file.string()), file);
    } catch (const SceneMistake& mistake) {
        return tl::make_unexpected(mistake.error);
    } catch (const toml::parse_error& mistake) {
        const toml::source_position at = mistake.source().begin;
        return failure(ErrorCode::InvalidRequest, fmt::format("{}:{}:{}", file.string(), at.line, at.column),
                       fmt::format("found a syntax error ({}), expected TOML", mistake.description()));
    }
}

}  // namespace lightcook::pipeline
