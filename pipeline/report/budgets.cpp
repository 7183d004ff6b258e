#include "pipeline/report/budgets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <toml++/toml.h>
#include <algorithm>
#include <set>
#include <utility>

#include "formats/nearest.h"
#include "formats/pixel_format.h"
#include "formats/target.h"
#include "formats/vocabulary.h"
#include "pipeline/assets/asset_kind.h"
#include "pipeline/document/toml_fields.h"
#include "pipeline/report/report.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;
using formats::failure;
using formats::Result;

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

}  // namespace

template <class Keys>
void describeKeys(Keys& keys, PlatformBudget& platform) {
    const KeyRule sizes = {.expected = "a table such as { name = \"8 MiB\" }", .type = "table of sizes"};
    const auto sizesOf = [&](std::vector<std::string> names) {
        KeyRule rule = sizes;
        rule.names = std::move(names);
        return rule;
    };
    std::vector<std::string> formatNames = formats::namesOf(formats::allPixelFormats());
    formatNames.emplace_back(kVertexMemory);
    keys.required("name", platform.name, {.expected = "the name of the platform", .type = "string"},
                  "name of the platform, once in the file");
    keys.optional("target", platform.target, oneOf(formats::allTargets()).otherwise("all"),
                  "only scenes that were cooked for this target count");
    keys.optional("total", platform.totalBytes, kByteCount, "largest GPU memory of all scenes together");
    keys.optional("scene", platform.sceneBytes, kByteCount, "largest GPU memory of each scene");
    keys.optional(
        "scenes", platform.scenes, sizes,
        "by the name of a scene: its own limit, in place of `scene`; a name that no cooked folder of the report has is a warning");
    keys.optional("kinds", platform.kinds, sizesOf(formats::namesOf(allAssetKinds())),
                  "by asset kind: largest GPU memory of a scene's assets of that kind");
    keys.optional("formats", platform.formatBytes, sizesOf(formatNames),
                  "by pixel format: largest GPU memory of a scene's textures of that format");
}

template <class Keys>
void describeKeys(Keys& keys, PlatformBudgets& budgets) {
    int schema = 1;
    keys.required("schema", schema, {.low = 1, .high = 1, .expected = "schema = 1", .type = "`1`"}, "version of this form");
    keys.sections("platform", budgets.platforms, {.intro = "A platform. The file has at least one."},
                  [](auto& inner, auto& platform) { describeKeys(inner, platform); });
}

std::span<const KeyTable> budgetKeyTables() {
    return keyTablesOf<PlatformBudgets>();
}

namespace {

PlatformBudgets readTables(const TomlDocument& document) {
    PlatformBudgets budgets;
    readKeys(document, budgets);
    budgets.file = document.file.string();
    if (budgets.platforms.empty()) document.fail(document.root, "found no platform, expected tables [[platform]]");
    std::set<std::string> names;
    for (std::size_t i = 0; i < budgets.platforms.size(); ++i) {
        const PlatformBudget& platform = budgets.platforms[i];
        const toml::table& table = *document.table("platform", i);
        if (platform.name.empty())
            document.fail(*table.get("name"), "found an empty name for platform.name, expected the name of the platform");
        if (!names.insert(platform.name).second)
            document.fail(table, fmt::format("found a second platform '{}', expected each name once", platform.name));
        if (!platform.totalBytes && !platform.sceneBytes && platform.scenes.empty() && platform.kinds.empty() &&
            platform.formatBytes.empty())
            document.fail(table, fmt::format("found no limit for platform '{}', expected one of total, scene, scenes, kinds and formats",
                                             platform.name));
    }
    return budgets;
}

}  // namespace

Result<PlatformBudgets> readBudgets(const std::filesystem::path& file) {
    constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 20;
    std::error_code code;
    if (!std::filesystem::is_regular_file(file, code))
        return failure(ErrorCode::InvalidRequest, file,
                       fmt::format("found {}, expected the budgets of platforms (TOML)",
                                   std::filesystem::is_directory(file, code) ? "a folder" : "no such file"));
    return readToml(file, kMostBytes, "budgets, which are 3 deep", [&](const toml::table& root) {
        return readTables({file, root, budgetKeyTables(), "the file"});
    });
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
                                  overBudgetWords(check.usedBytes, check.limitBytes)});
    return errors;
}

}  // namespace lightcook::pipeline
