// lightcook verify: a cooked scene once more, from its files.
#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/printing.h"
#include "pipeline/manifest/cooked_folder.h"

namespace lightcook::pipeline {

CommandFunction defineVerify(CLI::App& app) {
    struct Options {
        VerifyOptions verify;
        CiOutputs files;
    };
    const auto options = std::make_shared<Options>();
    addFolderOption(app, "folder", options->verify.folder, "Output folder of cook")->required();
    addFolderOption(app, "--sources", options->verify.sources, "The scene's folder, if it has moved since the cook");
    addSamplesOption(app, options->verify.samples);
    addStrictOption(app, options->verify.strict);
    options->files.add(app);
    app.footer(R"(The content digest of every file is compared with the manifest's. Then errors and bounds are computed
from the textures against the float sources. An error over its limit, or a changed file, ends with
exit code 4. Of a scene with several targets, each target is verified.

--junit and --sarif are for test panes and annotations of continuous integration. JUnit has a suite
for the scene and one for each asset, and a case for each check; SARIF points at the asset's lines of
the scene file. Each failure carries asset, stage, texel, normal, found and allowed value.)");
    return [options](Session& session) {
        if (auto ready = options->files.prepare(session); !ready) return session.finish(ready);
        std::vector<Outcome> outcomes;
        for (const std::filesystem::path& folder : targetFolders(options->verify.folder)) {
            VerifyOptions verify = options->verify;
            verify.folder = folder;
            outcomes.push_back(verifyCooked(verify, session.state));
            if (session.state.interrupted) break;
        }
        const std::vector<formats::Error> errors = options->files.write(session, "verify", outcomes, {}, options->verify.sources);
        keepFindingsOnce(outcomes);
        for (const Outcome& outcome : outcomes) printFindings(session.terminal, outcome.findings);
        // Last, because whoever reads the table may close the pipe before its end.
        for (const Outcome& outcome : outcomes)
            if (outcome.report.is_object() && session.terminal.verbosity() != Verbosity::Quiet)
                printReport(session.terminal, outcome.report);
        return session.finish(errors);
    };
}

}  // namespace lightcook::pipeline
