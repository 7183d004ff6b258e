#include "pipeline/command/launcher_option.h"

#include <fmt/format.h>

#include "formats/process.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {

formats::Result<void> checkLauncher(const std::string& launcher) {
    if (formats::withoutControls(launcher) == launcher) return {};
    return formats::failure(formats::ErrorCode::InvalidRequest, "--launcher",
                            fmt::format("found '{}', expected a command in one line, without control characters", launcher));
}

formats::Result<LaunchOptions> launchOptionsOf(const std::string& launcher, const std::vector<std::string>& cacheWords) {
    LC_TRY(program, formats::programFile());
    LaunchOptions options{.command = launcher, .program = *program, .words = {"--json", "-"}, .statedError = errorInOutput};
    options.words.insert(options.words.end(), cacheWords.begin(), cacheWords.end());
    return options;
}

std::optional<formats::Error> errorInOutput(const std::string& output) {
    const std::string text = "\n" + output;
    const std::size_t end = text.rfind("\n}"), begin = text.rfind("\n{\n", end);
    if (end == std::string::npos || begin == std::string::npos) return std::nullopt;
    const Json json = parseJson(text.substr(begin, end + 2 - begin));
    if (!json.is_object() || !json.contains("errors") || !json["errors"].is_array() || json["errors"].empty()) return std::nullopt;
    const auto error = fromJson<DocumentError>(json["errors"].front(), "output");
    return error ? std::optional(error->error()) : std::nullopt;
}

}  // namespace lightcook::pipeline
