#include "pipeline/command/lightmap.h"

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "formats/bake_format.h"
#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/scene/asset_name.h"
#include "pipeline/scene/checks.h"

namespace lightcook::pipeline {

Scene lightMapScene(const ConverterOptions& options, const formats::LightMapDescription& description) {
    Scene scene = sceneFor(options);
    LightMapEntry entry;
    const auto known = formats::LightMapReader::recognize(options.input, description);  // a cook refuses what is not
    entry.name = scene.name = lightMapNameOf(options.input, known ? known->format->name : "");
    entry.file = options.input;
    entry.description = description;
    entry.description.colors = scene.colors;
    scene.lightMaps.push_back(entry);
    return scene;
}

Outcome convertLightMap(const LightMapOptions& options, const RunState& state) {
    Scene scene = lightMapScene(options, options.description);
    scene.lobe = options.lobe;
    MaterialEntry surfaces;
    surfaces.name = "*";
    surfaces.normalMapTilt = options.normalMapTilt;
    if (options.noNormalMaps) surfaces.normalMap = false;
    if (options.noSpecular) surfaces.specular = false;
    if (options.noNormalMaps || options.noSpecular || options.normalMapTilt) scene.materials.push_back(surfaces);
    return convertScene(std::move(scene), "light-map", options, state);
}

CommandFunction defineLightmap(CLI::App& app) {
    struct Options : LightMapOptions {
        OutputOptions outputOptions;
        JsonOutput json;
        ConventionOptions conventions;
    };
    const auto options = std::make_shared<Options>();
    addFileOption(app, "input", options->input, "The bake")->required();
    declareWritten(addFileOption(app, "output", options->output,
                                 "A folder; or a .ktx2 file if the layout is one texture, a .dds file if that has no constants"),
                   Written::FileOrFolder)
        ->required();
    options->outputOptions.addLightMap(app);
    app.add_flag("--no-normal-maps", options->noNormalMaps, "No surface has a normal map");
    app.add_option("--normal-map-tilt", options->normalMapTilt,
                   "Largest angle between a normal of a normal map and that of the surface [degrees]; default: 60")
        ->check(CLI::Range(kLeastNormalMapTilt, kMostNormalMapTilt));
    app.add_flag("--no-specular", options->noSpecular, "No surface is specular; with --no-normal-maps directions are left out");
    app.add_flag("--mips", options->cook.mips, "Write mip levels, as far as these keep charts apart");
    addLobeOption(app, options->lobe, formats::sceneLobes());
    addRepairOption(app, options->cook.repair);
    addSourceOption(app, options->source);
    options->conventions.add(app);
    options->json.add(app, "the report");
    return [options](Session& session) {
        if (auto applied = options->outputOptions.apply(options->cook); !applied) return session.finish(applied);
        if (auto checked = checkSource(options->source); !checked) return session.finish(checked);
        if (auto applied = options->conventions.apply(options->description, options->input); !applied) return session.finish(applied);
        options->json.prepare(session);
        return finishCook(session, options->json, convertLightMap(*options, session.state));
    };
}

}  // namespace lightcook::pipeline
