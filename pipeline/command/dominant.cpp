#include "pipeline/command/dominant.h"

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <utility>

#include "pipeline/command/command.h"
#include "pipeline/command/lightmap.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/printing.h"
#include "pipeline/command/session.h"
#include "pipeline/report/explained_light.h"
#include "pipeline/scene/dominant_fit.h"
#include "pipeline/scene/dominant_layout.h"

namespace lightcook::pipeline {
namespace {

/// Prints and returns how much of the light map one light and two lights explain.
formats::Result<Json> printExplanation(const DominantOptions& options, Session& session) {
    formats::LightMapDescription description = options.description;
    description.repair = options.cook.repair;
    auto explanation = explainDominant(options.input, description, options.fit == "refined-ambient", session.state);
    if (!explanation) return explanation;
    if (session.log == LogFormat::JsonLines)
        session.terminal.say(explanation->dump());
    else
        for (const std::string& line : linesOf(*explanation)) session.terminal.say(line);
    return explanation;
}

}  // namespace

Outcome convertDominant(const DominantOptions& options, const RunState& state) {
    Scene scene = lightMapScene(options, options.description);
    scene.lightMaps.front().dominantFit = dominantFitFromName(options.fit)->name;
    if (options.layout != allDominantLayouts().front().name) scene.lightMaps.front().dominantLayout = options.layout;
    scene.lobe = options.lobe;
    return convertScene(std::move(scene), "dominant", options, state);
}

CommandFunction defineDominant(CLI::App& app) {
    struct Options : DominantOptions {
        OutputOptions outputOptions;
        ConventionOptions conventions;
        JsonOutput json;
        bool explain = false;
    };
    const auto options = std::make_shared<Options>();
    addFileOption(app, "input", options->input, "The bake")->required();
    declareWritten(addFolderOption(app, "output", options->output, "Output folder"), Written::Folder)->required();
    options->outputOptions.addTextures(app);
    addRepairOption(app, options->cook.repair);
    options->conventions.add(app);
    options->json.add(app, "the report, and with --report \"explanation\",");
    addDominantFitOption(app, options->fit);
    addDominantLayoutOption(app, options->layout);
    addLobeOption(app, options->lobe, formats::sceneLobes());
    app.add_flag("--report", options->explain, "Print where one light cannot represent the map, and what a second light would gain");
    app.footer(R"(--report prints, for the closed form, the best single light and two lights: the fraction of energy
(squares of all SH coefficients) that is not explained; median and 99th percentile of the residual
(root of the squared error over the norm of a texel's coefficients); texels and energy with a
residual over 10, 25 and 50 %; and the worst texel of up to eight strips of 64 rows with the two
lights that would do better. With --log json it is one JSON object on standard output. The textures
hold one light.)");
    return [options](Session& session) {
        if (auto applied = options->outputOptions.apply(options->cook); !applied) return session.finish(applied);
        if (auto applied = options->conventions.apply(options->description); !applied) return session.finish(applied);
        options->json.prepare(session);
        Outcome outcome = convertDominant(*options, session.state);
        if (!options->explain || !outcome.errors.empty()) return finishCook(session, options->json, std::move(outcome));
        printCook(session, outcome);
        const auto explanation = printExplanation(*options, session);
        if (!explanation) return options->json.finish(session, outcome.report, {explanation.error()});
        outcome.report["explanation"] = *explanation;
        return options->json.finish(session, outcome.report, {});
    };
}

}  // namespace lightcook::pipeline
