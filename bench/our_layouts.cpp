#include "bench/our_layouts.h"

#include <tbb/parallel_for.h>

#include "bench/or_throw.h"
#include "compress/light_map.h"
#include "formats/light_map_layout.h"
#include "formats/temporary_folder.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/planner.h"
#include "pipeline/assets/textures.h"
#include "pipeline/scene/scene.h"

namespace lightcook::bench {
namespace {

using formats::TemporaryFolder;

/// A cooked bake, decoded from its bytes.
struct DecodedBake {
    double bitsPerTexel = 0;
    int clusters = 0;  ///< learned bases; 0 where nothing is learned
    formats::Image<lighting::ShRgb> sh;
};
DecodedBake cook(const Bake& bake, const std::filesystem::path& file, const std::string& layout, int effort) {
    const TemporaryFolder folder;
    pipeline::TextureSettings settings;
    settings.effort = effort;
    const formats::LightMapFilter filter = formats::info(*formats::lightMapLayoutFromName(layout)).usualFilter();
    const pipeline::Action action{
        "cook/lightmap",
        "light-map",
        "lightmap",
        pipeline::toJson(pipeline::LightMapParameters{{}, layout, formats::Target::Bc, settings, pipeline::SceneView{}, false, filter}),
        {{"source", file}},
        {}};
    pipeline::SharedObjects shared;
    const pipeline::RunState state;
    const pipeline::ActionContext context{action, folder.path(), folder.path(), {}, shared, state};
    const auto cooked = orThrow(pipeline::fromJson<pipeline::CookResult>(orThrow(pipeline::cookLightMap(context)).result, layout));
    const pipeline::CookedAsset& asset = cooked.asset;
    const auto reader = orThrow(pipeline::CookedLightMapReader::open(folder.path(), asset, {.key = bake.measure.key()}));

    const pipeline::Json constants = asset.constants.value_or(pipeline::Json::object());
    const int clusters = constants.contains("clusters") ? constants.at("clusters").at(0).get<int>() : 0;
    DecodedBake decoded{asset.bitsPerTexel.value_or(0), clusters, formats::Image<lighting::ShRgb>(bake.width(), bake.height())};
    const int chunks = (bake.height() + pipeline::kChunkRows - 1) / pipeline::kChunkRows;
    tbb::parallel_for(0, chunks, [&](int chunk) {
        const int firstRow = chunk * pipeline::kChunkRows, rowCount = std::min(pipeline::kChunkRows, bake.height() - firstRow);
        const auto rows = reader.verifier().reconstruct(orThrow(reader.read(firstRow, rowCount)), firstRow, rowCount);
        for (int y = 0; y < rowCount; ++y)
            for (int x = 0; x < bake.width(); ++x) decoded.sh.at(x, firstRow + y) = rows.at(x, y);
    });
    return decoded;
}

/// Returns a plan of the layout for halves and 16-bit integers, with the same number of learned bases.
compress::LightMapPlan planWithoutBlocks(const Bake& bake, const std::string& name, int clusters, int effort) {
    using formats::Target;
    const formats::LightMapLayout layout = *formats::lightMapLayoutFromName(name);
    const int width = bake.width(), height = bake.height();
    compress::MeasuredLightMap measured{Target::Float, width, height, bake.measure};
    if (!formats::info(layout).isLearned()) return compress::planLightMap(layout, measured);
    compress::LightMapBlocks blocks(width, height);
    blocks.add(bake.strip, 0, height);
    const std::vector<int> chartOfBlock = blocks.chartOfBlock();
    compress::LightMapSamples samples(blocks.choose(chartOfBlock, compress::learningBlocks(effort, width, height)), blocks.across());
    samples.add(bake.strip, 0, height);
    compress::EncodeOptions options;
    options.effort = effort;
    verify::LightMapKey key;
    key.add(bake.strip, 0, height);
    measured.objective = pipeline::objectiveFor({}, key.displayKey(), lighting::bt2020FromRec709());
    return compress::planLearnedLightMap(layout, measured, {chartOfBlock, samples, clusters}, options);
}

}  // namespace

std::vector<std::string> ourLayouts() {
    std::vector<std::string> names = pipeline::lightMapLayoutNames();
    // One in tangent space needs a mesh.
    std::erase_if(names, [](const std::string& name) { return formats::isFlat(name) || formats::isInTangentSpace(name) || name == "raw"; });
    return names;
}

PeerMaps cookLayout(const Bake& bake, const std::filesystem::path& file, const std::string& layout, int effort) {
    DecodedBake decoded = cook(bake, file, layout, effort);
    return {decoded.bitsPerTexel, throughPlan(planWithoutBlocks(bake, layout, decoded.clusters, effort), bake.strip, effort),
            std::move(decoded.sh)};
}

}  // namespace lightcook::bench
