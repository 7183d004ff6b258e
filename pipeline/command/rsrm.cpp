#include "pipeline/command/rsrm.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <utility>

#include "pipeline/assets/note_keys.h"
#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/scene/asset_name.h"
#include "pipeline/scene/rsrm_format.h"

namespace lightcook::pipeline {
namespace {

/// Prints the energy that the average of an environment around its axis lost.
void printAsymmetry(Session& session, const Json& report) {
    if (!report.is_object() || report.at("assets").empty()) return;
    const Json measures = report.at("assets").at(0).value("measures", Json::object());
    if (!measures.contains(note_keys::kAsymmetricEnergy)) return;
    const double fraction = measures.at(note_keys::kAsymmetricEnergy).get<double>();
    session.terminal.say(session.log == LogFormat::JsonLines
                             ? Json({{note_keys::kAsymmetricEnergy, fraction}}).dump()
                             : fmt::format("{:.3g} % of the light's energy is not symmetric around the axis and is lost", 100 * fraction));
}

/// Refuses options of block encoders beside a format that has no blocks.
formats::Result<void> checkBlockOptions(const RsrmOptions& options) {
    const std::string name = options.format.empty() ? std::string(info(RsrmFormat::Rgba8).name) : options.format;
    const RsrmFormatInfo* const format = rsrmFormatFromName(name);
    if (format == nullptr || format->hasBlocks()) return {};
    std::string blocks;
    for (const RsrmFormatInfo& each : allRsrmFormats())
        if (each.hasBlocks()) blocks += fmt::format("{}, ", each.name);
    for (const auto& [option, isGiven] :
         {std::pair("--effort", options.cook.effort.has_value()), std::pair("--rdo", options.cook.rdo.has_value())})
        if (isGiven)
            return formats::failure(formats::ErrorCode::InvalidRequest, option,
                                    fmt::format("found it with --format {}, whose texels are rounded, expected --format {}or {}", name,
                                                blocks, kAutoRsrmFormat));
    return {};
}

}  // namespace

Outcome convertRsrm(const RsrmOptions& options, const RunState& state) {
    if (auto usable = checkBlockOptions(options); !usable) return failedOutcome(usable.error());
    Scene scene = sceneFor(options);
    GradientEntry entry{assetNameOf(options.input), options.input};
    scene.name = entry.name;
    if (!options.exponents.empty()) {
        if (auto checked = checkOption("--exponents", objectionToExponents(options.exponents)); !checked)
            return failedOutcome(checked.error());
        entry.exponents = options.exponents;
    }
    if (!options.axis.empty()) {
        if (auto checked = checkOption("--axis", objectionToAxis(options.axis)); !checked) return failedOutcome(checked.error());
        entry.axis = directionOfAxis(options.axis);
        if (options.encoding != GradientEntry{}.encoding)
            return failedOutcome(
                {formats::ErrorCode::InvalidRequest, "--encoding", "found it beside --axis, expected it for painted gradients alone"});
    }
    entry.encoding = options.encoding;
    entry.zones = options.zones;
    entry.format = options.format;
    entry.dither = options.dither;
    scene.gradients.push_back(entry);
    return convertScene(std::move(scene), "rsrm", options, state);
}

CommandFunction defineRsrm(CLI::App& app) {
    struct Options : RsrmOptions {
        OutputOptions outputOptions;
        JsonOutput json;
    };
    const auto options = std::make_shared<Options>();
    addFileOption(app, "input", options->input, "A gradient (one row of texels), or with --axis an environment")->required();
    declareWritten(addFileOption(app, "output", options->output, "A folder, or a .ktx2 file"), Written::FileOrFolder)->required();
    options->outputOptions.addTextures(app);
    addRepairOption(app, options->cook.repair);
    addSourceOption(app, options->source);
    options->json.add(app, "the report");
    app.add_option("--exponents", options->exponents, "Phong exponents, one row each: 1 to 256 increasing numbers from 1 to 65536")
        ->delimiter(',')
        ->type_name("S,S,...");
    app.add_option("--encoding", options->encoding, "Encoding of a painted gradient; auto: sRGB for PNG, JPEG, TGA and BMP, else linear")
        ->check(CLI::IsMember(kGradientEncodings))
        ->capture_default_str();
    CLI::Option* axis = app.add_option("--axis", options->axis, "The input is an environment: average it around this world direction")
                            ->delimiter(',')
                            ->expected(3)
                            ->type_name("X,Y,Z");
    app.add_option("--zones", options->zones, "Zones of equal solid angle of the average around the axis")
        ->check(CLI::Range(1, kMostGradientZones))
        ->needs(axis)
        ->capture_default_str();
    app.add_option(
           "--format", options->format,
           fmt::format("Pixel format; {} is the smallest that keeps the error limit. Default: {} where it keeps the limit, else as {}. "
                       "bc4 for gradients of one colour; bc7, bc4 and bc6h for --target bc only",
                       kAutoRsrmFormat, info(RsrmFormat::Rgba8).name, kAutoRsrmFormat))
        ->check(CLI::IsMember(rsrmFormatChoices()));
    app.add_flag("--dither", options->dither, "Carry the rounding error to the next texel of the row (rgba8 only)");
    app.footer(R"(With --axis the command prints the fraction of the light's energy that is not symmetric around the
axis; with --log json as {"asymmetric_energy": 0.7}. If it is large, a reflection map cannot represent
the environment.)");
    return [options](Session& session) {
        if (auto applied = options->outputOptions.apply(options->cook); !applied) return session.finish(applied);
        if (auto checked = checkSource(options->source); !checked) return session.finish(checked);
        options->json.prepare(session);
        Outcome outcome = convertRsrm(*options, session.state);
        if (outcome.errors.empty() && !options->axis.empty()) printAsymmetry(session, outcome.report);
        return finishCook(session, options->json, std::move(outcome));
    };
}

}  // namespace lightcook::pipeline
