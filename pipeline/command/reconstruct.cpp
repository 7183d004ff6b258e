// lightcook reconstruct: a cooked light map as the shader sees it.
#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/info.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/texture_file.h"

namespace lightcook::pipeline {

CommandFunction defineReconstruct(CLI::App& app) {
    struct Options {
        std::filesystem::path folder, output;
        std::string name;
        int supersample = 1;
        JsonOutput json;
    };
    const auto options = std::make_shared<Options>();
    addFolderOption(app, "folder", options->folder, "Output folder of cook")->required();
    app.add_option("name", options->name, "Name of the light map")->required()->type_name("NAME");
    declareWritten(addFileOption(app, "output", options->output, "The EXR to write: 27 float channels sh00.R .. sh08.B"), Written::File)
        ->required();
    app.add_option("--supersample", options->supersample,
                   "Write N x N places of each texel, as a GPU filters the textures there, in an image of N times the size")
        ->type_name("N")
        ->check(CLI::Range(1, kMostPlacesPerTexel))
        ->capture_default_str();
    options->json.add(app, "what was written");
    app.footer("The coefficients are radiance in the world frame, without Condon-Shortley signs.");
    return [options](Session& session) {
        options->json.prepare(session);
        if (auto checked = requireExrFile(options->output); !checked) return options->json.finish(session, {}, {checked.error()});
        const auto folders = FoldersOfFile::make(options->output);
        if (!folders) return options->json.finish(session, {}, {folders.error()});
        const auto written = reconstructLightMap(options->folder, options->name, options->output, options->supersample, session.state);
        if (!written) return options->json.finish(session, {}, {written.error()});
        return options->json.finish(session,
                                    options->json.isGiven() ? describeFile(options->output) : formats::Result<Json>(Json::object()));
    };
}

}  // namespace lightcook::pipeline
