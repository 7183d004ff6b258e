#include "pipeline/report/budgets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "formats/nearest.h"
#include "formats/pixel_format.h"
#include "formats/target.h"
#include "formats/vocabulary.h"
#include "pipeline/assets/asset_kind.h"
#include "pipeline/document/byte_count.h"
#include "pipeline/document/toml_file.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;
using formats::failure;
using formats::Result;

constexpr std::array kBudgetKeys = {
    BudgetKeyInfo{"schema", "`1`", "required", "version of this form"},
    BudgetKeyInfo{"platform", "tables", "required", "`[[platform]]`, any number of times"},
};
constexpr std::array kPlatformKeys = {
    BudgetKeyInfo{"name", "string", "required", "name of the platform, once in the file"},
    BudgetKeyInfo{"target", "`\"bc\"`, `\"astc\"`, `\"float\"`", "all", "only scenes that were cooked for this target count"},
    BudgetKeyInfo{"total", "size", "none", "largest GPU memory of all scenes together"},
    BudgetKeyInfo{"scene", "size", "none", "largest GPU memory of each scene"},
    BudgetKeyInfo{
        "scenes", "table of sizes", "none",
        "by the name of a scene: its own limit, in place of `scene`; a name that no cooked folder of the report has is a warning"},
    BudgetKeyInfo{"kinds", "table of sizes", "none", "by asset kind: largest GPU memory of a scene's assets of that kind"},
    BudgetKeyInfo{"formats", "table of sizes", "none", "by pixel format: largest GPU memory of a scene's textures of that format"},
};

/// Reads the tables of one file.
class BudgetReader {
public:
    explicit BudgetReader(std::string file) : file_(std::move(file)) {}

    PlatformBudgets read(const toml::table& root) const {
        refuseUnknown(root, "the file", namesOf(allBudgetKeys()));
        const toml::node* schema = root.get("schema");
        if (schema == nullptr) fail(root, "found no key 'schema', expected schema = 1");
        if (schema->is_boolean())
            fail(*schema, fmt::format("found {} (a boolean) for schema, expected schema = 1", schema->value_or(false)));
        if (schema->value<std::int64_t>() != 1) fail(*schema, "found another schema, expected schema = 1");
        PlatformBudgets budgets;
        budgets.file = file_;
        const toml::node* platforms = root.get("platform");
        const toml::array* tables = platforms != nullptr ? platforms->as_array() : nullptr;
        if (tables == nullptr || tables->empty())
            fail(platforms != nullptr ? *platforms : root, "found no platform, expected tables [[platform]]");
        for (const toml::node& node : *tables) {
            const toml::table* table = node.as_table();
            if (table == nullptr) fail(node, "found a value in 'platform', expected tables [[platform]]");
            PlatformBudget platform = readPlatform(*table);
            if (std::ranges::find(budgets.platforms, platform.name, &PlatformBudget::name) != budgets.platforms.end())
                fail(*table, fmt::format("found a second platform '{}', expected each name once", platform.name));
            budgets.platforms.push_back(std::move(platform));
        }
        return budgets;
    }

private:
    template <class Row>
    static std::vector<std::string> namesOf(std::span<const Row> rows) {
        return formats::namesOf(rows);
    }

    std::string place(const toml::source_position& at) const { return fmt::format("{}:{}:{}", file_, at.line, at.column); }
    [[noreturn]] void fail(const toml::node& node, const std::string& detail) const {
        throw TomlMistake{{ErrorCode::InvalidRequest, place(node.source().begin), detail}};
    }

    void refuseUnknown(const toml::table& table, const std::string& where, const std::vector<std::string>& known) const {
        for (const auto& [key, node] : table) {
            const std::string name(key.str());
            if (std::ranges::find(known, name) != known.end()) continue;
            throw TomlMistake{{ErrorCode::InvalidRequest, place(key.source().begin),
                               fmt::format("found unknown key '{}' in {}, expected one of: {}{}", name, where, fmt::join(known, ", "),
                                           formats::nearestHint(name, known))}};
        }
    }

    std::uint64_t size(const toml::node& node, const std::string& key) const {
        const auto text = node.value<std::string>();
        if (!text || !node.is_string()) fail(node, fmt::format("found no string for platform.{}, expected a size such as \"8 MiB\"", key));
        const auto bytes = parseByteCount(*text, place(node.source().begin));
        if (!bytes) throw TomlMistake{bytes.error()};
        return *bytes;
    }
    std::optional<std::uint64_t> optionalSize(const toml::table& table, const char* key) const {
        const toml::node* node = table.get(key);
        return node == nullptr ? std::nullopt : std::optional(size(*node, key));
    }

    /// known  names that the table may have; empty: any
    std::map<std::string, std::uint64_t> sizes(const toml::table& table, const char* key, const std::vector<std::string>& known) const {
        std::map<std::string, std::uint64_t> found;
        const toml::node* node = table.get(key);
        if (node == nullptr) return found;
        if (!node->is_table())
            fail(*node, fmt::format("found a value for platform.{0}, expected a table such as {0} = {{ name = \"8 MiB\" }}", key));
        if (!known.empty()) refuseUnknown(*node->as_table(), fmt::format("platform.{}", key), known);
        for (const auto& [name, value] : *node->as_table())
            found[std::string(name.str())] = size(value, fmt::format("{}.{}", key, name.str()));
        return found;
    }

    PlatformBudget readPlatform(const toml::table& table) const {
        refuseUnknown(table, "platform", namesOf(allPlatformKeys()));
        PlatformBudget platform;
        const toml::node* name = table.get("name");
        if (name == nullptr) fail(table, "found no key 'name' in platform, expected the name of the platform");
        platform.name = name->is_string() ? name->value_or(std::string()) : "";
        if (platform.name.empty()) fail(*name, "found no name for platform.name, expected a string");
        if (const toml::node* target = table.get("target")) {
            const std::string found = target->value_or(std::string());
            if (!formats::targetFromName(found))
                fail(*target,
                     fmt::format("found '{}' for platform.target, expected {}", found, formats::listOfNames(formats::allTargets())));
            platform.target = found;
        }
        std::vector<std::string> formatNames = formats::namesOf(formats::allPixelFormats());
        formatNames.emplace_back(kVertexMemory);
        platform.totalBytes = optionalSize(table, "total");
        platform.sceneBytes = optionalSize(table, "scene");
        platform.scenes = sizes(table, "scenes", {});
        platform.kinds = sizes(table, "kinds", namesOf(allAssetKinds()));
        platform.formatBytes = sizes(table, "formats", formatNames);
        if (!platform.totalBytes && !platform.sceneBytes && platform.scenes.empty() && platform.kinds.empty() &&
            platform.formatBytes.empty())
            fail(table,
                 fmt::format("found no limit for platform '{}', expected one of total, scene, scenes, kinds and formats", platform.name));
        return platform;
    }

    std::string file_;
};

void addCheck(PlatformUse& use, BudgetCheck check) {
    check.passed = check.usedBytes <= check.limitBytes;
    use.passed = use.passed && check.passed;
    use.checks.push_back(std::move(check));
}

void addScene(const PlatformBudget& platform, const SceneMemory& scene, PlatformUse& use) {
    use.usedBytes += scene.bytes;
    ++use.scenes;
    const auto own = platform.scenes.find(scene.name);
    if (own != platform.scenes.end())
        addCheck(use, {"scene", scene.name, {}, own->second, scene.bytes});
    else if (platform.sceneBytes)
        addCheck(use, {"scene", scene.name, {}, *platform.sceneBytes, scene.bytes});
    for (const auto& [limits, name, used] :
         {std::tuple(&platform.kinds, "kind", &scene.byKind), std::tuple(&platform.formatBytes, "format", &scene.byFormat)})
        for (const auto& [of, limit] : *limits) {
            const auto found = used->find(of);
            if (found != used->end()) addCheck(use, {name, scene.name, of, limit, found->second});
        }
}

std::string keyTable(std::span<const BudgetKeyInfo> keys) {
    std::string text = "| key | value | default | meaning |\n| --- | --- | --- | --- |\n";
    for (const BudgetKeyInfo& key : keys) text += fmt::format("| `{}` | {} | {} | {} |\n", key.name, key.type, key.fallback, key.caption);
    return text;
}

}  // namespace

std::span<const BudgetKeyInfo> allBudgetKeys() {
    return kBudgetKeys;
}

std::span<const BudgetKeyInfo> allPlatformKeys() {
    return kPlatformKeys;
}

Result<PlatformBudgets> readBudgets(const std::filesystem::path& file) {
    constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 20;
    std::error_code code;
    if (!std::filesystem::is_regular_file(file, code))
        return failure(ErrorCode::InvalidRequest, file.string(),
                       fmt::format("found {}, expected the budgets of platforms (TOML)",
                                   std::filesystem::is_directory(file, code) ? "a folder" : "no such file"));
    return readToml(file, kMostBytes, "budgets, which are 3 deep",
                    [&](const toml::table& root) { return BudgetReader(file.string()).read(root); });
}

std::vector<PlatformUse> usesOf(const PlatformBudgets& budgets, const std::vector<SceneMemory>& scenes) {
    std::vector<PlatformUse> uses;
    for (const PlatformBudget& platform : budgets.platforms) {
        PlatformUse use;
        use.name = platform.name;
        use.target = platform.target;
        for (const SceneMemory& scene : scenes)
            if (!platform.target || *platform.target == scene.target) addScene(platform, scene, use);
        if (platform.totalBytes) {
            addCheck(use, {"total", {}, {}, *platform.totalBytes, use.usedBytes});
            std::rotate(use.checks.begin(), use.checks.end() - 1, use.checks.end());
        }
        uses.push_back(std::move(use));
    }
    return uses;
}

std::optional<std::string> warningOfUnknownScenes(const PlatformBudgets& budgets, const std::vector<SceneMemory>& scenes) {
    constexpr std::size_t kMostNames = 3;
    std::vector<std::string> known;
    for (const SceneMemory& scene : scenes) known.push_back(scene.name);
    std::set<std::pair<std::size_t, std::string>> unknown;  // by the distance to the nearest known name
    for (const PlatformBudget& platform : budgets.platforms)
        for (const auto& [name, limit] : platform.scenes)
            if (std::ranges::find(known, name) == known.end())
                unknown.emplace(formats::editDistance(name, formats::nearestName(name, known)), name);
    if (unknown.empty()) return std::nullopt;
    std::vector<std::string> words;
    for (const auto& [distance, name] : unknown)
        if (words.size() < kMostNames) words.push_back(fmt::format("'{}' (nearest is '{}')", name, formats::nearestName(name, known)));
    const std::string more = unknown.size() > kMostNames ? fmt::format(" and {} more", unknown.size() - kMostNames) : "";
    return fmt::format("found limits for {}{}, expected names of cooked scenes: other limits are not checked", fmt::join(words, ", "),
                       more);
}

std::optional<std::string> warningOfUnusedPlatforms(const PlatformBudgets& budgets, const std::vector<SceneMemory>& scenes) {
    constexpr std::size_t kMostNames = 3;
    std::vector<std::string> words;
    std::size_t unused = 0;
    for (const PlatformBudget& platform : budgets.platforms) {
        if (!platform.target || std::ranges::find(scenes, *platform.target, &SceneMemory::target) != scenes.end()) continue;
        if (++unused <= kMostNames) words.push_back(fmt::format("'{}' (target {})", platform.name, *platform.target));
    }
    if (unused == 0) return std::nullopt;
    const std::string more = unused > kMostNames ? fmt::format(" and {} more", unused - kMostNames) : "";
    return fmt::format("found limits for {}{}, expected scenes that were cooked for that target: other limits are not checked",
                       fmt::join(words, ", "), more);
}

std::vector<Error> errorsOf(const std::vector<PlatformUse>& uses, const std::string& file) {
    std::vector<Error> errors;
    for (const PlatformUse& use : uses)
        for (const BudgetCheck& check : use.checks)
            if (!check.passed)
                errors.push_back({ErrorCode::OverBudget,
                                  fmt::format("{}, platform {}{}{}", file, use.name,
                                              check.scene ? ", scene " + *check.scene : ", all scenes", check.of ? ", " + *check.of : ""),
                                  fmt::format("found {} bytes of GPU memory, expected at most {}", check.usedBytes, check.limitBytes)});
    return errors;
}

std::string budgetsReference() {
    return "# Budgets\n\n`budgets.toml` has the GPU memory that each platform allows; `lightcook report --budgets FILE` holds cooked "
           "scenes against it and ends with code 5 if a limit is passed. Sizes are strings: `\"4096\"`, `\"512 KiB\"`, `\"2 MiB\"`. "
           "Unknown keys are refused with the nearest known one.\n\n## Top of the file\n\n" +
           keyTable(allBudgetKeys()) + "\n## `[[platform]]`\n\n" + keyTable(allPlatformKeys()) +
           "\n## Example\n\n```toml\nschema = 1\n\n[[platform]]\nname = \"console\"\ntarget = \"bc\"\ntotal = \"512 MiB\"\nscene = \"8 "
           "MiB\"\nscenes = { lobby = \"12 MiB\" }\nkinds = { light-map = \"6 MiB\" }\n```\n";
}

}  // namespace lightcook::pipeline
