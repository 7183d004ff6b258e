#include "pipeline/cook/depfile.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

#include "pipeline/manifest/manifest.h"

namespace lightcook::pipeline {
namespace {

/// Escapes a path as GCC does for Make and Ninja. A blank after 2n + 1 backslashes is a blank of the name after n backslashes; backslashes
/// before anything else stand for themselves.
std::string makeEscaped(const std::filesystem::path& path) {
    std::string escaped;
    std::size_t backslashes = 0;  // that end what is escaped so far
    for (const char c : path.generic_string()) {
        if (c == ' ' || c == '\t') escaped += std::string(backslashes + 1, '\\');
        if (c == '#' || c == ':') escaped += '\\';
        if (c == '$') escaped += '$';
        escaped += c;
        backslashes = c == '\\' ? backslashes + 1 : 0;
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
