#include "pipeline/cook/depfile.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

#include "pipeline/manifest/manifest.h"

namespace lightcook::pipeline {
namespace {

std::string makeEscaped(const std::filesystem::path& path) {
    std::string escaped;
    for (const char c : path.generic_string()) {
        if (c == ' ' || c == '#') escaped += '\\';
        if (c == '$') escaped += '$';
        escaped += c;
    }
    return escaped;
}

}  // namespace

std::string depfileText(const Scene& scene, const std::filesystem::path& output, const std::vector<Action>& graph) {
    std::set<std::string> inputs = {makeEscaped(scene.file)};
    for (const Action& action : graph)
        for (const auto& [role, path] : action.inputs) inputs.insert(makeEscaped(path));
    if (!scene.colors.config.empty()) inputs.insert(makeEscaped(scene.colors.config));
    return fmt::format("{}: {}\n", makeEscaped(output / kManifestName), fmt::join(inputs, " "));
}

}  // namespace lightcook::pipeline
