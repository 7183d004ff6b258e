#include "pipeline/cook/depfile.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <set>
#include <string_view>

#include "pipeline/manifest/manifest.h"
#include "pipeline/scene/named_files.h"

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

/// Characters of a target and of an input with what GNU Make 4.3 takes them for.
struct MakeMeaning {
    char letter;
    const char* words;
    bool inTargets, inInputs;
};
constexpr std::array kMakeMeanings = {MakeMeaning{'%', "a pattern", true, false}, MakeMeaning{'=', "a variable", true, true},
                                      MakeMeaning{';', "a command", true, true}, MakeMeaning{'|', "the end of the inputs", false, true},
                                      MakeMeaning{'\n', "the end of the rule", true, true}};

std::optional<formats::Error> makeWarningOf(const std::filesystem::path& path, bool isTarget) {
    const std::string name = path.generic_string();
    const auto warn = [&](std::string_view letters, const char* words) {
        return formats::Error{
            formats::ErrorCode::InvalidRequest, name,
            fmt::format("found '{}' in a path of the depfile, expected a path without it: Make takes it for {}, and misses "
                        "changes",
                        letters, words)};
    };
    for (const MakeMeaning& each : kMakeMeanings)
        if ((isTarget ? each.inTargets : each.inInputs) && name.find(each.letter) != std::string::npos)
            return warn(each.letter == '\n' ? "\\n" : std::string_view(&each.letter, 1), each.words);
    if (!isTarget && name.ends_with(')') && name.find('(') != std::string::npos) return warn("(...)", "a member of an archive");
    return std::nullopt;
}

}  // namespace

std::optional<formats::Error> warningForMake(const Scene& scene, const std::filesystem::path& output) {
    if (auto warning = makeWarningOf(output / kManifestName, true)) return warning;
    for (const std::filesystem::path& file : filesNamedBy(scene))
        if (auto warning = makeWarningOf(file, false)) return warning;
    return std::nullopt;
}

std::string depfileText(const Scene& scene, const std::filesystem::path& output, const std::vector<Action>& graph) {
    std::set<std::string> inputs = {makeEscaped(scene.file)};
    for (const Action& action : graph)
        for (const auto& [role, path] : action.inputs) inputs.insert(makeEscaped(path));
    if (!scene.colors.config.empty()) inputs.insert(makeEscaped(scene.colors.config));
    return fmt::format("{}: {}\n", makeEscaped(output / kManifestName), fmt::join(inputs, " "));
}

}  // namespace lightcook::pipeline
