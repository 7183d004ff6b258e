// lightcook demo: the scene that ships with the program.
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <utility>

#include "formats/process.h"
#include "pipeline/command/command.h"
#include "pipeline/command/key_options.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/printing.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

/// Returns the example scene beside the installed program, or that of the source tree which the program was built from.
std::filesystem::path demoScene() {
    const std::filesystem::path scene = "examples/cornell/scene.toml";
    std::error_code code;
    if (const auto folder = formats::programFolder())
        if (auto installed = folder->parent_path() / "share/lightcook" / scene; std::filesystem::exists(installed, code)) return installed;
    return std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / scene;
}

}  // namespace

CommandFunction defineDemo(CLI::App& app) {
    struct Options {
        CookOptions cook;
        JsonOutput json;
    };
    const auto options = std::make_shared<Options>();
    options->cook.output = "demo.cooked";
    declareWritten(addFolderOption(app, "-o,--output", options->cook.output, "Output folder; default: demo.cooked"), Written::Folder);
    addOutputOptions(app, options->cook.given);
    app.remove_option(app.get_option("--targets"));
    options->json.add(app, "the report");
    return [options](Session& session) {
        options->json.prepare(session);
        options->cook.scene = demoScene();
        auto scene = readScene(options->cook.scene, options->cook.given);
        if (!scene) return options->json.finish(session, {}, {scene.error()});
        if (auto checked = session.paths.checkAgainstScene(*scene, options->cook.output); !checked) return session.finish(checked);
        const Outcome cooked = cookScene(std::move(*scene), options->cook, session.state);
        printCook(session, cooked);
        if (cooked.errors.empty() && session.terminal.verbosity() != Verbosity::Quiet) {
            if (!session.terminal.isInteractive()) printReport(session.terminal, cooked.report);
            session.terminal.say(fmt::format("cooked and verified; the report is {}; next: lightcook view {}",
                                             std::filesystem::absolute(options->cook.output / kReportHtmlName).lexically_normal().string(),
                                             options->cook.output.string()));
        }
        return options->json.finish(session, cooked.report, cooked.errors);
    };
}

}  // namespace lightcook::pipeline
