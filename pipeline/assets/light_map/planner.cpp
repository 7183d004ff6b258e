#include "pipeline/assets/light_map/planner.h"

#include <fmt/format.h>

#include "formats/gltf_scene.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Returns the islands of the map's mesh, so that each of its vertices can name one basis. Returns none without a mesh, or if it cannot be
/// read: the mesh's own action reports that.
std::vector<formats::IslandRun> islandsOf(const Action& action, const LightMapSource& source) {
    const auto mesh = action.inputs.find(kMeshRole);
    if (mesh == action.inputs.end()) return {};
    const auto scene = formats::GltfScene::load(mesh->second);
    if (!scene) return {};
    return formats::islandRuns(scene->triangleMeshes(), source.width(), source.height());
}

}  // namespace

LightMapPlanner::LightMapPlanner(LightMapSource& source, formats::Target target, const TextureSettings& textures,
                                 const compress::LightMapMeasure& measure, const ActionContext& context)
    : source_(source), measure_(measure), context_(context), target_(target), options_(textures.encodeOptions()) {}

Result<compress::LightMapPlan> LightMapPlanner::plan(const std::string& name) {
    const formats::LightMapLayout layout = *formats::lightMapLayoutFromName(name);
    if (!formats::info(layout).isLearned()) return compress::planLightMap(layout, target_, source_.width(), source_.height(), measure_);
    if (!samples_)
        if (auto gathered = gather(); !gathered) return tl::make_unexpected(gathered.error());
    compress::LightMapPlan plan = compress::planLearnedLightMap(layout, target_, source_.width(), source_.height(), measure_, blocks_,
                                                                charts_, *samples_, 0, options_);
    plan.isClusterInMesh = hasIslands_;
    return plan;
}

Result<void> LightMapPlanner::gather() {
    if (auto surveyed = surveyCharts(); !surveyed) return surveyed;
    return sample();
}

/// Finds the charts, from the coverage and the mesh.
Result<void> LightMapPlanner::surveyCharts() {
    blocks_ = compress::LightMapBlocks(source_.width(), source_.height());
    const auto surveyed = mapInOrder<int>(source_.chunkCount(), context_, fmt::format("survey the charts of {}", context_.action.asset),
                                          [&](int index) -> Result<int> {
                                              const auto chunk = source_.chunk(index);
                                              if (!chunk) return tl::make_unexpected(chunk.error());
                                              blocks_.add(**chunk, (*chunk)->firstRow, source_.chunkRows(index));
                                              return 0;
                                          });
    if (!surveyed) return tl::make_unexpected(surveyed.error());
    const std::vector<formats::IslandRun> islands = islandsOf(context_.action, source_);
    charts_ = blocks_.charts(islands);
    hasIslands_ = !islands.empty();
    return {};
}

/// Gathers the texels of the blocks that layouts learn from.
Result<void> LightMapPlanner::sample() {
    compress::LightMapSamples samples(blocks_.choose(charts_, compress::learningBlocks(options_.effort, source_.width(), source_.height())),
                                      blocks_.across());
    constexpr int kMargin = compress::LightMapSamples::kMargin;
    const auto sampled =
        mapInOrder<int>(source_.stripCount(), context_, fmt::format("sample {}", context_.action.asset), [&](int index) -> Result<int> {
            const auto strip = source_.stripWithMargin(index, kMargin, kMargin);
            if (!strip) return tl::make_unexpected(strip.error());
            samples.add(*strip, source_.stripFirstRow(index), source_.stripRows(index));
            return 0;
        });
    if (!sampled) return tl::make_unexpected(sampled.error());
    samples_ = std::move(samples);
    return {};
}

}  // namespace lightcook::pipeline
