// lightcook verify: a cooked scene once more, from its files.
#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/printing.h"
#include "pipeline/command/session.h"
#include "pipeline/graph/files.h"
#include "pipeline/report/ci_report.h"

namespace lightcook::pipeline {

CommandFunction defineVerify(CLI::App& app) {
    struct Options {
        VerifyOptions verify;
        std::filesystem::path json, junit, sarif;
    };
    const auto options = std::make_shared<Options>();
    addFolderOption(app, "folder", options->verify.folder, "Output folder of cook")->required();
    addFolderOption(app, "--sources", options->verify.sources, "The scene's folder, if it has moved since the cook");
    addSamplesOption(app, options->verify.samples);
    addFileOption(app, "--json", options->json, "Write the report as JSON");
    addFileOption(app, "--junit", options->junit, "Write the verdict as JUnit XML");
    addFileOption(app, "--sarif", options->sarif, "Write the violations as SARIF");
    app.footer(R"(The content digest of every file is compared with the manifest's. Then errors and bounds are computed
from the textures against the float sources. An error over its limit, or a changed file, ends with
exit code 4.

--junit and --sarif are for test panes and annotations of continuous integration. Each violation
carries asset, stage, texel, normal, found and allowed value.)");
    return [options](Session& session) {
        Outcome outcome = verifyCooked(options->verify, session.state);
        const std::vector<formats::Error> failures = outcome.errors;
        const auto write = [&](const std::filesystem::path& file, const std::string& text) {
            if (file.empty()) return;
            if (auto written = writeFile(file, text); !written) outcome.errors.push_back(written.error());
        };
        write(options->json, textOf(outcome.report) + "\n");
        write(options->junit, junitReport(outcome.report, failures, options->verify.folder.string()));
        write(options->sarif, sarifReport(outcome.report, failures));
        // Last, because whoever reads the table may close the pipe before its end.
        if (outcome.report.is_object()) printReport(session.terminal, outcome.report);
        return session.finish(outcome.errors);
    };
}

}  // namespace lightcook::pipeline
