// lightcook reconstruct: a cooked light map as the shader sees it.
#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <set>

#include "pipeline/command/command.h"
#include "pipeline/command/info.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/texture_file.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/manifest/manifest.h"

namespace lightcook::pipeline {
namespace {

/// Fails unless the manifest and the textures of a light map are those that were cooked. Other files of the folder are not read.
formats::Result<void> checkCookedFiles(const std::filesystem::path& folder, const std::string& name) {
    LC_TRY(manifest, loadManifest(folder));
    std::erase_if(manifest->assets, [&](const CookedAsset& asset) { return asset.kind != AssetKind::LightMap || asset.name != name; });
    std::set<std::filesystem::path> read = {folder / kManifestName};
    for (const CookedAsset& asset : manifest->assets)
        for (const CookedTexture& texture : asset.textures) read.insert(folder / texture.file);
    for (const formats::Error& error : checkDigests(folder, *manifest))
        if (read.contains(error.file)) return tl::make_unexpected(error);
    return {};
}

}  // namespace

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
    declareWritten(addFileOption(app, "output", options->output,
                                 "The EXR to write: float channels sh00.R .. sh08.B, coverage.Y, normal.X .. normal.Z"),
                   Written::File)
        ->required();
    app.add_option("--supersample", options->supersample,
                   "Write N x N places of each texel, as a GPU filters the textures there, in an image of N times the size")
        ->type_name("N")
        ->check(CLI::Range(1, kMostPlacesPerTexel))
        ->capture_default_str();
    options->json.add(app, "what was written");
    app.footer(R"(The coefficients are radiance in the world frame, without Condon-Shortley signs. Coverage and normals are
those of the bake, of the texel that a place lies in. If the bake is not where it was, or has neither,
the coefficients are written alone. If the manifest or a texture of the light map is not the one that
was cooked, nothing is written: exit code 4.)");
    return [options](Session& session) {
        options->json.prepare(session);
        if (auto checked = requireExrFile(options->output); !checked) return options->json.finish(session, {}, {checked.error()});
        if (auto checked = checkCookedFiles(options->folder, options->name); !checked)
            return options->json.finish(session, {}, {checked.error()});
        const auto folders = FoldersOfFile::make(options->output);
        if (!folders) return options->json.finish(session, {}, {folders.error()});
        const auto written = reconstructLightMap(options->folder, options->name, options->output, options->supersample, session.state);
        if (!written) return options->json.finish(session, {}, {written.error()});
        return options->json.finish(session,
                                    options->json.isGiven() ? describeFile(options->output) : formats::Result<Json>(Json::object()));
    };
}

}  // namespace lightcook::pipeline
