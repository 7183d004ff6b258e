#include "pipeline/command/lut.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <cmath>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"

namespace lightcook::pipeline {
namespace {

/// Returns the roughness m of a cosine power s = 2 / m^2 - 2.
double roughnessOf(double exponent) {
    return std::sqrt(2 / (exponent + 2));
}

formats::Result<void> checkExponents(const LutOptions& options) {
    if (options.exponents.empty()) return {};
    if (options.lobe != lighting::SpecularLobe::PhongPower)
        return checkOption("--exponents",
                           ValueError{fmt::format("the lobe {}", formats::info(options.lobe).name), "--lobe phong-power, or --m"});
    if (!options.m.empty()) return checkOption("--exponents", ValueError{"--m beside it", "one of them"});
    return checkOption("--exponents", objectionToRange(options.exponents, 0, 1e8));
}

formats::Result<void> check(const LutOptions& options) {
    if (!options.m.empty()) LC_CHECK(checkOption("--m", objectionToRange(options.m, 0, 1)));
    LC_CHECK(checkExponents(options));
    // Without a range it is that of all materials.
    const std::vector<double>& range = options.exponents.empty() ? options.m : options.exponents;
    if (options.tables.roughnessCount == 1 && (range.size() != 2 || range[0] < range[1]))
        return checkOption("--rows",
                           ValueError{"1", fmt::format("2 to {}: one row holds one roughness only, such as --m 0.5,0.5", kMostTableNodes)});
    return checkOption("--normalization", objectionToNormalization(options.tables.normalization, options.lobe));
}

}  // namespace

Outcome convertLut(const LutOptions& options, const RunState& state) {
    if (auto checked = check(options); !checked) return failedOutcome(checked.error());
    Scene scene = sceneFor(options);
    scene.name = "specular";
    MaterialEntry material;
    material.name = "*";
    if (options.m.size() == 2) material.m = Range{options.m[0], options.m[1]};
    if (options.exponents.size() == 2) material.m = Range{roughnessOf(options.exponents[1]), roughnessOf(options.exponents[0])};
    scene.materials.push_back(material);
    scene.tables = options.tables;
    scene.lobe = options.lobe;
    return convertScene(std::move(scene), "lut", options, state);
}

CommandFunction defineLut(CLI::App& app) {
    struct Options : LutOptions {
        OutputOptions outputOptions;
        JsonOutput json;
    };
    const auto options = std::make_shared<Options>();
    TableSettings& tables = options->tables;
    declareWritten(addFolderOption(app, "output", options->output, "Output folder"), Written::Folder)->required();
    options->outputOptions.addFiles(app);
    options->json.add(app, "the report");
    app.add_option("--m", options->m, "Range of roughness, within 0.0001 to 1")->delimiter(',')->expected(2)->type_name("LOW,HIGH");
    app.add_option("--exponents", options->exponents, "The range of roughness as cosine powers, for --lobe phong-power")
        ->delimiter(',')
        ->expected(2)
        ->type_name("LOW,HIGH");
    addLobeOption(app, options->lobe, formats::allSpecularLobes());
    app.add_option("--normalization", tables.normalization, "energy: energy conserving; halo3: four times as bright")
        ->check(CLI::IsMember(kNormalizationNames))
        ->capture_default_str();
    app.add_option("--views", tables.viewCount, "Number of columns")
        ->check(CLI::Range(2, kMostTableNodes))
        ->default_str(std::to_string(kFineViewCount));
    app.add_option("--rows", tables.roughnessCount,
                   "Number of rows over exactly the range of roughness; default: those of the 16 rows m = 1/16 .. 1 that the range needs")
        ->check(CLI::Range(1, kMostTableNodes));
    app.add_option("--view-axis", tables.viewAxis, "Quantity along the columns; auto: the one with the least error between columns")
        ->check(CLI::IsMember(viewAxisNames()))
        ->capture_default_str();
    app.add_option("--roughness-axis", tables.roughnessAxis, "Quantity along the rows; auto: the one with the least error between rows")
        ->check(CLI::IsMember(roughnessAxisNames()))
        ->capture_default_str();
    app.footer(R"(Without options the tables are those of a cooked scene: Beckmann's lobe, energy conserving, 24 views.

Lobes: beckmann; ggx (m is alpha); phong: exp(-tan^2 a / m^2) / (pi m^2 cos^3 a) around the reflected
view; phong-power: (s + 1) / (2 pi) cos^s a with s = 2 / m^2 - 2. For Phong lobes C holds the
harmonics of the reflected direction times the lobe's bands, not cut at the horizon, and D is C times
(1 - NoV)^5.

Without --rows a roughness below 1/16 uses the first row.

An axis is chosen from a dozen forms: the one for which F0 C + (1 - F0) D, for the F0 of the scene, has
the least error between the nodes; plain NoV or m if no form is 3 % better. The manifest describes
each axis by "of" (the form as text) and "factors" p0, p1, q0, q1. The axis measures
sqrt((p0 + p1 t) (q0 + q1 t)) of t = NoV or m, the shader's lcTableAxis(t, factors);
lcTableCoordinate(value, scale, offset) then is the texture coordinate. "minimum" and "maximum" are
the values of the first and last texel.

"max_bound" of the stages filter and total holds for every view and every roughness of the table's
range, also between sampled positions. Only the filter's fractions are taken as exact. It bounds the
local relative error, which is large where the harmonics of the light cancel.)");
    return [options](Session& session) {
        if (auto applied = options->outputOptions.apply(options->cook); !applied) return session.finish(applied);
        options->json.prepare(session);
        return finishCook(session, options->json, convertLut(*options, session.state));
    };
}

}  // namespace lightcook::pipeline
