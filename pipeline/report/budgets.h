// Memory budgets of platforms (budgets.toml), and what the cooked scenes use of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"
#include "pipeline/document/keys.h"

namespace lightcook::pipeline {

/// Largest GPU memory [bytes] of the scenes of a platform.
struct PlatformBudget {
    std::string name;
    std::optional<std::string> target;                 ///< only scenes that were cooked for it; none: all
    std::optional<std::uint64_t> totalBytes;           ///< of all scenes together
    std::optional<std::uint64_t> sceneBytes;           ///< of each scene
    std::map<std::string, std::uint64_t> scenes;       ///< of scenes by name, in place of sceneBytes
    std::map<std::string, std::uint64_t> kinds;        ///< of each scene's assets of a kind
    std::map<std::string, std::uint64_t> formatBytes;  ///< of each scene's textures of a pixel format
};
struct PlatformBudgets {
    std::string file;
    std::vector<PlatformBudget> platforms;
};

/// Reads budgets.toml. Unknown keys, asset kinds, pixel formats and targets are refused with the nearest known one.
formats::Result<PlatformBudgets> readBudgets(const std::filesystem::path& file);

/// Returns the tables of budgets.toml with their keys, for the reference.
std::span<const KeyTable> budgetKeyTables();

/// GPU memory of one scene, as budgets count it.
struct SceneMemory {
    std::string name, target;
    std::uint64_t bytes = 0;
    std::map<std::string, std::uint64_t> byKind, byFormat;
};

/// A limit of a platform and what is used of it.
struct BudgetCheck {
    std::string limit;                     ///< total, scene, kind or format
    std::optional<std::string> scene, of;  ///< of: name of the kind or format
    std::uint64_t limitBytes = 0, usedBytes = 0;
    bool passed = true;
};
template <class Fields, Is<BudgetCheck> Self>
void describe(Fields& fields, Self& check) {
    fields.required("limit", check.limit, "total: all scenes; scene: one scene; kind or format: one scene's assets of it");
    fields.optional("scene", check.scene, "name of the scene");
    fields.optional("of", check.of, "asset kind or pixel format");
    fields.required("limit_bytes", check.limitBytes, "budget [bytes]");
    fields.required("used_bytes", check.usedBytes, "GPU memory [bytes]");
    fields.required("passed", check.passed, "true if the memory is within the budget");
}

struct PlatformUse {
    std::string name;
    std::optional<std::string> target;
    std::uint64_t usedBytes = 0;
    int scenes = 0;
    bool passed = true;
    std::vector<BudgetCheck> checks;
};
template <class Fields, Is<PlatformUse> Self>
void describe(Fields& fields, Self& platform) {
    fields.required("name", platform.name, "name of the platform");
    fields.optional("target", platform.target, "target of the scenes that count; absent: all scenes count");
    fields.required("used_bytes", platform.usedBytes, "GPU memory of these scenes [bytes]");
    fields.required("scenes", platform.scenes, "number of these scenes");
    fields.required("passed", platform.passed, "true if every limit is kept");
    fields.required("checks", platform.checks, "limits of the platform");
}

/// Holds scenes against the budgets of every platform. A scene of another target does not count.
std::vector<PlatformUse> usesOf(const PlatformBudgets& budgets, const std::vector<SceneMemory>& scenes);

/// Returns a warning about the names of `scenes` that no cooked scene has, those that are nearest to one first: their limits hold nothing.
/// A file of budgets may name more scenes than one report has, so that this is no error. Nothing: there are none.
std::optional<std::string> warningOfUnknownScenes(const PlatformBudgets& budgets, const std::vector<SceneMemory>& scenes);

/// Returns a warning about the platforms whose target no scene was cooked for: their limits hold nothing. Nothing: there are none.
std::optional<std::string> warningOfUnusedPlatforms(const PlatformBudgets& budgets, const std::vector<SceneMemory>& scenes);

/// Returns an error (OverBudget) for each limit that is not kept.
std::vector<formats::Error> errorsOf(const std::vector<PlatformUse>& uses, const std::string& file);

}  // namespace lightcook::pipeline
