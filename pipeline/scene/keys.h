// The keys of the scene file: one row each. The reader refuses every other key, and docs/reference/scene-file.md is made from the rows.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lightcook::pipeline {

struct SceneKeyInfo {
    std::string_view name;
    std::string type;      ///< in Markdown: "`\"bc\"`, `\"astc\"`, `\"float\"`" or "fraction"
    std::string fallback;  ///< in Markdown: the default, or "required"
    std::string caption;   ///< in Markdown
};

/// A table of the scene file, or the keys before the first table.
struct SceneSectionInfo {
    std::string_view name;  ///< "light_map"; empty for the keys before the first table
    bool isArray;           ///< [[name]], any number of times
    std::string intro;      ///< Markdown before the keys
    std::vector<SceneKeyInfo> keys;
    std::string outro;  ///< Markdown after the keys
};

/// Returns every section, in the order of the reference.
std::span<const SceneSectionInfo> allSceneSections();

/// Returns the section of a name, which must exist.
const SceneSectionInfo& sceneSection(std::string_view name);

}  // namespace lightcook::pipeline
