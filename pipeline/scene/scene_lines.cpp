#include "pipeline/scene/scene_lines.h"

#include <fmt/format.h>

namespace lightcook::pipeline {
namespace {

std::string placeOf(std::string_view section, std::string_view name, std::string_view key) {
    return fmt::format("{}/{}/{}", section, name, key);
}

}  // namespace

void SceneLines::add(std::string_view section, std::string_view name, std::string_view key, int line) {
    lines_.emplace(placeOf(section, name, key), line);
}

std::optional<int> SceneLines::find(std::string_view section, std::string_view name, std::string_view key) const {
    for (const std::string& place : {placeOf(section, name, key), placeOf(section, name, "")})
        if (const auto found = lines_.find(place); found != lines_.end()) return found->second;
    return std::nullopt;
}

std::optional<int> SceneLines::findFile(const std::filesystem::path& file) const {
    const auto found = linesOfFiles_.find(file.lexically_normal());
    return found == linesOfFiles_.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace lightcook::pipeline
