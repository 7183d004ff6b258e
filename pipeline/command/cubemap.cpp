#include "pipeline/command/cubemap.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/irradiance.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/printing.h"
#include "pipeline/command/texture_file.h"
#include "pipeline/scene/asset_name.h"
#include "pipeline/scene/checks.h"
#include "pipeline/scene/cubemap_layout.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

constexpr int kMostIrradianceSize = 1024;

/// Options of the command line; those that only some filters have are empty unless given.
struct CommandLine : CubemapOptions {
    OutputOptions outputOptions;
    JsonOutput json;
    std::string filter = "specular";
    std::optional<double> wrap;
    std::optional<std::string> normalize;
    const CLI::Option *lobeOption = nullptr, *layoutOption = nullptr;
};

/// Returns an error for the first option that was given to a filter which has no use for it.
formats::Result<void> checkFilterOptions(const CommandLine& options) {
    struct OwnedOption {
        const char* name;
        bool isGiven;
        std::vector<std::string> filters;
    };
    const CookOptions& cook = options.cook;
    const std::vector<std::string> textures = {"specular", "irradiance"};
    const OwnedOption owned[] = {
        {.name = "--wrap", .isGiven = options.wrap.has_value(), .filters = {"irradiance", "sh"}},
        {.name = "--size", .isGiven = options.size.has_value(), .filters = textures},
        {.name = "--normalize", .isGiven = options.normalize.has_value(), .filters = {"sh"}},
        {.name = "--lobe", .isGiven = options.lobeOption->count() > 0, .filters = {"specular"}},
        {.name = "--layout", .isGiven = options.layoutOption->count() > 0, .filters = {"specular"}},
        {.name = "--sh", .isGiven = !options.sh.empty(), .filters = {"specular"}},
        {.name = "--target", .isGiven = cook.target.has_value(), .filters = textures},
        {.name = "--container", .isGiven = cook.container.has_value(), .filters = textures},
        {.name = "--zstd", .isGiven = cook.zstd.has_value(), .filters = textures},
        {.name = "--budget", .isGiven = cook.budgetBytes.has_value(), .filters = textures},
        {.name = "--max-error", .isGiven = cook.limits[Limit::Error].has_value(), .filters = textures},
        {.name = "--max-visible", .isGiven = cook.limits[Limit::Visible].has_value(), .filters = {"specular"}},
        {.name = "--max-visible-bound", .isGiven = cook.limits[Limit::VisibleBound].has_value(), .filters = {"specular"}},
        {.name = "--effort", .isGiven = cook.effort.has_value(), .filters = textures},
        {.name = "--rdo", .isGiven = cook.rdo.has_value(), .filters = textures},
    };
    for (const OwnedOption& option : owned)
        if (option.isGiven && std::find(option.filters.begin(), option.filters.end(), options.filter) == option.filters.end())
            return checkOption(option.name, ValueError{fmt::format("it with --filter {}", options.filter),
                                                       fmt::format("--filter {}", fmt::join(option.filters, " or "))});
    return {};
}

/// Runs --filter irradiance.
formats::Result<Json> runIrradiance(const CommandLine& options) {
    LC_CHECK(checkContainer(options.cook, options.output));
    OutputSettings output;
    output.target = options.cook.target.value_or(output.target);
    output.rdo = options.cook.rdo.value_or(output.rdo);
    if (const auto conflict = brokenByOptions(rulesOf(output)))
        return formats::failure(formats::ErrorCode::InvalidRequest, std::string(conflict->option), conflict->optionWords);
    if (options.size && (*options.size < 1 || *options.size > kMostIrradianceSize))
        return formats::failure(formats::ErrorCode::InvalidRequest, "--size",
                                fmt::format("found {}, expected 1 to {}", *options.size, kMostIrradianceSize));
    IrradianceCommand command;
    command.input = options.input;
    command.output = options.output;
    command.wrap = options.wrap.value_or(command.wrap);
    command.size = options.size.value_or(command.size);
    command.repair = options.cook.repair;
    command.source = options.source;
    command.target = options.cook.target.value_or(command.target);
    command.budgetBytes = options.cook.budgetBytes;
    command.maxError = options.cook.limits[Limit::Error].value_or(command.maxError);
    command.textures.zstd = options.cook.zstd.value_or(command.textures.zstd);
    command.textures.effort = options.cook.effort.value_or(command.textures.effort);
    command.textures.rdo = options.cook.rdo.value_or(command.textures.rdo);
    return cookIrradiance(command);
}

/// Runs --filter sh.
formats::Result<Json> runSh(const CommandLine& options) {
    ShCommand command;
    command.input = options.input;
    command.output = options.output;
    command.wrap = options.wrap.value_or(command.wrap);
    command.normalize = options.normalize.value_or(command.normalize);
    command.repair = options.cook.repair;
    command.source = options.source;
    return cookSh(command);
}

}  // namespace

Outcome convertCubemap(const CubemapOptions& options, const RunState& state) {
    if (!isTextureFile(options.output))
        if (auto checked = checkFolderName(options.output, "or a .ktx2 file, or a .json file with --filter sh"); !checked)
            return failedOutcome(checked.error());
    Scene scene = sceneFor(options);
    scene.name = assetNameOf(options.input);
    scene.lobe = options.lobe;
    ProbeEntry probe{scene.name, options.input, options.sh.empty() ? std::nullopt : std::optional(options.sh)};
    if (options.size) {
        if (auto checked = checkOption("--size", objectionToProbeSize(*options.size)); !checked) return failedOutcome(checked.error());
        probe.size = *options.size;
    }
    if (!options.sh.empty() && options.layout != info(CubemapLayout::PreDivided).name)
        return failedOutcome({formats::ErrorCode::InvalidRequest, "--sh",
                              fmt::format("found it with --layout {}, expected --layout {}, which is divided by that SH", options.layout,
                                          info(CubemapLayout::PreDivided).name)});
    probe.layout = options.layout;
    scene.probes.push_back(std::move(probe));
    return convertScene(std::move(scene), "cubemap", options, state);
}

CommandFunction defineCubemap(CLI::App& app) {
    const auto options = std::make_shared<CommandLine>();
    addFileOption(app, "input", options->input, "The environment")->required();
    declareWritten(addFileOption(app, "output", options->output, "A folder, or a .ktx2 or (--filter sh) .json file"), Written::FileOrFolder)
        ->required();
    options->outputOptions.addTextures(app);
    addRepairOption(app, options->cook.repair);
    addSourceOption(app, options->source);
    options->json.add(app, "the report, or with another --filter what was written,");
    app.add_option("--filter", options->filter,
                   "specular: prefiltered levels; irradiance: diffuse light, one level in one file; sh: nine coefficients "
                   "as JSON")
        ->check(CLI::IsMember({"specular", "irradiance", "sh"}))
        ->capture_default_str();
    options->lobeOption = addLobeOption(app, options->lobe, formats::sceneLobes());
    options->layoutOption =
        app.add_option("--layout", options->layout, "For specular: divided by the environment's own area specular, or as it is")
            ->check(CLI::IsMember(formats::namesOf(allCubemapLayouts())))
            ->capture_default_str();
    addFileOption(app, "--sh", options->sh, "For specular, pre-divided: JSON with the environment's SH; default: projected from the image");
    app.add_option("--wrap", options->wrap, "For irradiance and sh: wrapped diffuse, energy conserving, 0 (Lambert, the default) to 1")
        ->check(CLI::Range(0.0, 1.0));
    app.add_option("--size", options->size,
                   fmt::format("Texels of a face's edge. For specular: a power of two, {} to {}; default: {}. For irradiance: 1 to {}; "
                               "default: {}",
                               kLeastProbeSize, kMostProbeSize, ProbeEntry{}.size, kMostIrradianceSize, IrradianceCommand{}.size));
    app.add_option("--normalize", options->normalize,
                   "For sh: none (the default), or d3dx: multiply by 16/17, so that a game light of 1 is 1 through nine coefficients")
        ->check(CLI::IsMember({"none", "d3dx"}));
    app.footer(R"(The environment is an equirectangular panorama (2:1), six faces +X -X +Y -Y +Z -Z in a strip (1:6 or
6:1), a horizontal (4:3) or vertical (3:4) cross, or one of six square files whose names end in
px nx py ny pz nz or posx negx posy negy posz negz. The shape of the image selects the form. The
corners of a cross are ignored. An OpenEXR file with the attribute envmap has OpenEXR's directions.

--filter irradiance writes the exit radiance of a white Lambert surface (irradiance over pi) for every
normal, computed from the whole environment. The texture's metadata has the "range" to multiply by.
--wrap W makes the kernel max(0, n.l + W) / (pi (1 + W)^2), with the SH bands 1, (2 - W) / 3 and
(1 - W)^2 / 4. 96 texels of the file are compared with the sum over every source texel; --max-error
(default 0.1) limits their RMS error.

--filter sh writes "sh", the incident radiance as nine rows of R, G and B, without Condon-Shortley
signs, and "exit", the same times the bands of wrapped Lambert: the sum of exit_i Y_i(n) is the exit
radiance of a white surface. Through nine coefficients, a white surface that faces a game light of 1
shows 17/16; --normalize d3dx multiplies everything by 16/17, as D3DX does.)");
    return [options](Session& session) {
        if (auto applied = options->outputOptions.apply(options->cook); !applied) return session.finish(applied);
        if (auto checked = checkSource(options->source); !checked) return session.finish(checked);
        if (auto checked = checkFilterOptions(*options); !checked) return session.finish(checked);
        options->json.prepare(session);
        if (options->filter != "specular") {
            const auto cooked = options->filter == "sh" ? runSh(*options) : runIrradiance(*options);
            if (cooked) warnOfRepairs(session.terminal, options->input.string(), cooked->at("repaired_texels").get<std::int64_t>());
            if (cooked && session.terminal.isInteractive()) printJson(session.terminal, *cooked);
            return options->json.finish(session, cooked);
        }
        return finishCook(session, options->json, convertCubemap(*options, session.state));
    };
}

}  // namespace lightcook::pipeline
