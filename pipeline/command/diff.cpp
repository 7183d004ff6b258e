// lightcook diff: what a patch from one cooked folder to another has to carry.
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <memory>
#include <vector>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/manifest/folder_difference.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

/// Ranges of a file that are printed, at most.
constexpr std::size_t kMostPrinted = 8;

void print(Terminal& terminal, const FileDifference& file) {
    if (file.change != FileChange::Changed) {
        const bool isAdded = file.change == FileChange::Added;
        return terminal.say(
            fmt::format("{}: {}, {}", file.file, isAdded ? "added" : "removed", sizeWords(isAdded ? file.bytesNew : file.bytesOld)));
    }
    terminal.say(fmt::format("{}: {} of {} in {}", file.file, sizeWords(file.bytesChanged), sizeWords(file.bytesNew),
                             counted(file.ranges.size(), "range")));
    for (std::size_t i = 0; i < std::min(file.ranges.size(), kMostPrinted); ++i)
        terminal.say(fmt::format("  {} at {}", counted(file.ranges[i].length, "byte"), file.ranges[i].offset));
    if (file.ranges.size() > kMostPrinted) terminal.say(fmt::format("  {} more", counted(file.ranges.size() - kMostPrinted, "range")));
    if (file.bytesNew < file.bytesOld)
        terminal.say(fmt::format("  ends after {}, before {}", counted(file.bytesNew, "byte"), file.bytesOld));
}

/// Runs the command. Returns the exit code.
int runDiff(Session& session, const std::filesystem::path& old, const std::filesystem::path& updated, const JsonOutput& json) {
    json.prepare(session);
    std::vector<FolderWithManifest> folders;
    for (const std::filesystem::path& folder : {old, updated}) {
        auto manifest = loadManifest(folder);
        if (!manifest) return json.finish(session, {}, {manifest.error()});
        if (auto changed = checkDigests(folder, *manifest); !changed.empty()) return json.finish(session, {}, std::move(changed));
        folders.push_back({folder, std::move(*manifest)});
    }
    const auto difference = differenceOf(folders[0], folders[1], session.state);
    if (!difference) return json.finish(session, {}, {difference.error()});
    if (session.terminal.verbosity() != Verbosity::Quiet) {
        for (const FileDifference& file : difference->files) print(session.terminal, file);
        session.terminal.say(fmt::format("{} of {} changed: {} changed, {} added, {} removed, {} the same",
                                         sizeWords(difference->bytesChanged), sizeWords(difference->bytesNew),
                                         counted(difference->filesChanged, "file"), difference->filesAdded, difference->filesRemoved,
                                         difference->filesSame));
    }
    return json.finish(session, toJson(*difference), {});
}

}  // namespace

CommandFunction defineDiff(CLI::App& app) {
    struct Options {
        std::filesystem::path old, updated;
        JsonOutput json;
    };
    const auto options = std::make_shared<Options>();
    addFolderOption(app, "old", options->old, "Output folder of an older cook")->required();
    addFolderOption(app, "new", options->updated, "Output folder of a newer cook of the same scene")->required();
    options->json.add(app, "the differences with all ranges");
    app.footer(R"(diff compares the files that an engine reads: the manifest and what it names, not the report. A range is of
the new file: bytes that the old file of that name does not have at the same offset. An old file, with the
ranges written over it, and cut or extended to the size of the new one, is the new file.

The exit code is 0 whether the folders differ or not. A file that is not the one that was cooked is an
error: exit code 4.)");
    return [options](Session& session) { return runDiff(session, options->old, options->updated, options->json); };
}

}  // namespace lightcook::pipeline
