#include "pipeline/command/dominant.h"

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <utility>

#include "pipeline/command/command.h"
#include "pipeline/command/lightmap.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/printing.h"
#include "pipeline/report/explained_light.h"
#include "pipeline/scene/dominant_fit.h"
#include "pipeline/scene/dominant_layout.h"

namespace lightcook::pipeline {
namespace {

/// Prints how much of the light map one light and two lights explain.
void printExplanation(const Json& explanation, Session& session) {
    if (session.log == LogFormat::JsonLines)
        session.terminal.say(explanation.dump());
    else
        for (const std::string& line : linesOf(explanation)) session.terminal.say(line);
}

/// Adds how much of the light map one light and two lights explain to a cook without errors, writes the JSON, and prints both: the verdict
/// comes after all that may still fail.
int finishExplained(const DominantOptions& options, Session& session, const JsonOutput& json, Outcome outcome) {
    formats::LightMapDescription description = options.description;
    description.repair = options.cook.repair;
    description.colors = colorsOf(options.source);
    const auto explanation = explainDominant(options.input, description, options.fit == "refined-ambient", session.state);
    if (explanation)
        outcome.report["explanation"] = *explanation;
    else
        outcome.errors.push_back(explanation.error());
    if (auto written = json.write(session, outcome.report, outcome.errors); !written) outcome.errors.push_back(written.error());
    outcome.report.erase("explanation");  // it is no member of a report
    printCook(session, outcome);
    if (explanation) printExplanation(*explanation, session);
    return session.finish(outcome.errors);
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
    addSourceOption(app, options->source);
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
        if (auto checked = checkSource(options->source); !checked) return session.finish(checked);
        if (auto applied = options->conventions.apply(options->description, options->input); !applied) return session.finish(applied);
        options->json.prepare(session);
        Outcome outcome = convertDominant(*options, session.state);
        if (!options->explain || !outcome.errors.empty()) return finishCook(session, options->json, std::move(outcome));
        return finishExplained(*options, session, options->json, std::move(outcome));
    };
}

}  // namespace lightcook::pipeline
