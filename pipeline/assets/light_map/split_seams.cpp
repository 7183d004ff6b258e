#include "pipeline/assets/light_map/split_seams.h"

#include <fmt/format.h>

#include <cstdint>
#include <utility>

#include "formats/gltf_scene.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/mesh_view.h"
#include "pipeline/assets/light_map/seams.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/results.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Returns a file of an action, which a manifest that was written by hand may lack.
Result<std::filesystem::path> inputOf(const ActionContext& context, const std::string& role) {
    const auto found = context.action.inputs.find(role);
    if (found != context.action.inputs.end()) return found->second;
    return formats::failure(formats::ErrorCode::Verification, context.action.asset,
                            fmt::format("found no file for '{}', expected that of each of its maps", role));
}

/// Opens the repacked bake of a map.
Result<LightMapSource*> openSplitBake(const ActionContext& context, std::size_t index, const CookedAsset& asset) {
    LC_TRY(description, descriptionOf(asset));
    LC_TRY(file, inputOf(context, splitBakeRole(index)));
    return context.shared.get<LightMapSources>().open(*file, withFiles(*description, context.action.inputs));
}

/// Returns the triangles of the meshes of all maps.
Result<std::vector<verify::SurfaceTriangle>> trianglesOfMaps(const ActionContext& context, std::size_t mapCount) {
    std::vector<verify::SurfaceTriangle> all;
    for (std::size_t map = 0; map < mapCount; ++map) {
        LC_TRY(file, inputOf(context, splitMeshRole(map)));
        LC_TRY(mesh, formats::GltfScene::load(*file));
        for (verify::SurfaceTriangle& triangle : litTriangles(*mesh)) {
            triangle.map = static_cast<std::uint8_t>(map);
            all.push_back(triangle);
        }
    }
    return all;
}

}  // namespace

std::string splitBakeRole(std::size_t index) {
    return fmt::format("bake{}", index);
}

std::string splitMeshRole(std::size_t index) {
    return fmt::format("mesh{}", index);
}

Result<ActionOutcome> verifySplitSeams(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<SplitSeamsParameters>(context));
    const std::size_t mapCount = parameters->maps.size();
    std::vector<CookedAsset> assets;
    std::vector<LightMapSource*> bakes;
    for (std::size_t i = 0; i < mapCount; ++i) {
        LC_TRY(asset, upstreamAsset(context, i));
        LC_TRY(bake, openSplitBake(context, i, *asset));
        assets.push_back(std::move(*asset));
        bakes.push_back(*bake);
    }
    // One key for all: it is the unit of light that the verifier works in. The display has a white of its own (partsOf).
    LC_TRY(key, surveyKey(*bakes.front(), context));
    const verify::Viewing viewing{parameters->view.display.of(key->displayKey()), bakes.front()->bt2020FromWorking()};
    verify::LightMapSampling sampling;
    sampling.placesPerTexel = 0;
    sampling.figures = verify::LightMapFigures::Sampled;
    std::vector<CookedLightMapReader> readers;
    for (const CookedAsset& asset : assets) {
        LC_TRY(reader,
               CookedLightMapReader::open(context.upstreamFolder, asset, {parameters->view.shading, sampling, key->key(), viewing}));
        readers.push_back(std::move(*reader));
    }
    std::vector<ComparedMap> maps;
    for (std::size_t i = 0; i < mapCount; ++i) maps.push_back({parameters->maps[i], *bakes[i], readers[i]});
    LC_TRY(triangles, trianglesOfMaps(context, mapCount));
    const LitSurface surface{maps, *triangles, viewing};
    LC_TRY(seams, measureSeamsBetween(surface, context));
    LC_TRY(views, writeSeamViews(*seams, surface, context, context.action.asset + "_split_seam"));
    std::vector<std::string> pictures;
    appendFiles(*views, pictures);
    return outcomeWith(SplitSeams{parameters->maps, std::move(*seams), parameters->limits, std::move(*views)}, std::move(pictures));
}

}  // namespace lightcook::pipeline
