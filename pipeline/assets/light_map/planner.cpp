#include "pipeline/assets/light_map/planner.h"

#include <fmt/format.h>

#include <algorithm>

#include "compress/parallel.h"
#include "formats/gltf_scene.h"
#include "pipeline/assets/light_map/mips.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

/// Spreads the loops of a fit over the threads of the arena.
void forEachInArena(std::size_t count, const std::function<void(std::size_t)>& work) {
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t index) { work(index); });
}

}  // namespace

using formats::Result;

compress::LightMapObjective objectiveFor(const SceneView& view, double displayKey, const glm::dmat3& bt2020FromWorking) {
    const verify::LightMapShading& shading = view.shading;
    return {view.display.of(displayKey),
            bt2020FromWorking,
            shading.normalCount > 1 ? shading.normalMapTilt : 0,
            shading.specular,
            shading.m,
            shading.f0,
            shading.lobe};
}

std::optional<compress::LightMapPlan> LearnedPlans::find(const std::string& key, const formats::LightMapLayoutInfo& layout) const {
    const std::lock_guard lock(mutex_);
    const auto known = plans_.find(key);
    if (known == plans_.end()) return std::nullopt;
    for (const compress::LightMapPlan& plan : known->second) {
        const formats::LightMapLayoutInfo& planned = formats::info(plan.layout);
        if (planned.codeCount == layout.codeCount && planned.residualCount() >= layout.residualCount()) return plan.shortenedTo(layout.id);
    }
    return std::nullopt;
}

void LearnedPlans::add(const std::string& key, compress::LightMapPlan plan) {
    const std::lock_guard lock(mutex_);
    plans_[key].push_back(std::move(plan));
}

LightMapPlanner::LightMapPlanner(LightMapSource& source, formats::Target target, const TextureSettings& textures, const MapSurvey& survey,
                                 const std::optional<SceneView>& visible, int mipCount, const ActionContext& context)
    : source_(source),
      measure_(survey.measure),
      textures_(textures),
      visible_(visible),
      context_(context),
      target_(target),
      mipCount_(mipCount),
      options_(textures.encodeOptions()) {
    if (visible) objective_ = objectiveFor(*visible, survey.key.displayKey(), source.bt2020FromWorking());
}

Result<compress::LightMapPlan> LightMapPlanner::plan(const std::string& layout, formats::LightMapFilter filter,
                                                     const ActionContext& context) {
    auto plan = planLevel0(layout, filter, context);
    if (plan) plan->mipCount = plan->hasCoverage() ? coverageLevels(plan->width, plan->height, mipCount_) : mipCount_;
    return plan;
}

Result<compress::LightMapPlan> LightMapPlanner::planLevel0(const std::string& name, formats::LightMapFilter filter,
                                                           const ActionContext& context) {
    const formats::LightMapLayout layout = *formats::lightMapLayoutFromName(name);
    const compress::MeasuredLightMap map{target_, source_.width(), source_.height(), measure_, objective_, filter};
    if (!formats::info(layout).isLearned()) return compress::planLightMap(layout, map);
    LearnedPlans& known = context_.shared.get<LearnedPlans>();
    const std::string key = keyOfLearned(filter);
    if (auto plan = known.find(key, formats::info(layout))) return std::move(*plan);
    auto plan = learn(formats::info(layout), map, context);
    if (plan) known.add(key, *plan);
    return plan;
}

/// Returns a text that is the same for planners that learn the same. A map is open once in a cook, with its conventions.
std::string LightMapPlanner::keyOfLearned(formats::LightMapFilter filter) const {
    const auto mesh = context_.action.inputs.find(kMeshRole);
    return fmt::format("{}\n{}\n{}\n{}\n{}\n{}", static_cast<const void*>(&source_), static_cast<int>(target_), toJson(textures_).dump(),
                       visible_ ? toJson(*visible_).dump() : "", static_cast<int>(filter),
                       mesh == context_.action.inputs.end() ? "" : mesh->second.string());
}

Result<compress::LightMapPlan> LightMapPlanner::learn(const formats::LightMapLayoutInfo& layout, const compress::MeasuredLightMap& map,
                                                      const ActionContext& context) {
    if (!samples_) LC_CHECK(gather(context));
    compress::setParallelLoop(forEachInArena);
    compress::LightMapPlan plan = compress::planLearnedLightMap(layout.id, map, {chartOfBlock_, *samples_}, options_);
    // The smaller of the two names the clusters.
    const std::size_t attribute = meshVertices_ * kBasisBytes;
    if (!islands_.empty() && (attribute < plan.indexBytes() || !doesIndexServe(plan))) plan.vertexBytes = attribute;
    return plan;
}

/// Returns true if every block that an island of the mesh reads has the island's cluster, so that a fetch from the index is right wherever
/// a surface may ask.
bool LightMapPlanner::doesIndexServe(const compress::LightMapPlan& plan) const {
    const auto clusters = plan.clusterOfBlock();
    const int across = formats::blocksAcross(formats::PixelFormat::Bc1, source_.width());
    std::vector<int> clusterOf;  // [island]
    for (const formats::IslandRun& run : islands_) {
        if (run.row < 0 || run.row >= source_.height()) continue;
        clusterOf.resize(std::max(clusterOf.size(), static_cast<std::size_t>(run.island) + 1), -1);
        int& expected = clusterOf[static_cast<std::size_t>(run.island)];
        const int end = std::min(run.end, source_.width());
        for (int x = std::max(run.begin, 0); x < end; ++x) {
            const int cluster = clusters[static_cast<std::size_t>(run.row / formats::kClusterBlock * across + x / formats::kClusterBlock)];
            if (expected >= 0 && cluster != expected) return false;
            expected = cluster;
        }
    }
    return true;
}

Result<void> LightMapPlanner::gather(const ActionContext& context) {
    LC_CHECK(surveyCharts(context.between(0, 0.5)));
    return sample(context.between(0.5, 1));
}

/// Finds the charts, from the coverage and the mesh.
Result<void> LightMapPlanner::surveyCharts(const ActionContext& context) {
    blocks_ = compress::LightMapBlocks(source_.width(), source_.height());
    const auto surveyed = mapInOrder<int>(source_.chunkCount(), context, fmt::format("survey the charts of {}", context_.action.asset),
                                          [&](int index) -> Result<int> {
                                              LC_TRY(chunk, source_.chunk(index));
                                              blocks_.add(**chunk, (*chunk)->firstRow, source_.chunkRows(index));
                                              return 0;
                                          });
    if (!surveyed) return tl::make_unexpected(surveyed.error());
    readIslands();
    chartOfBlock_ = blocks_.chartOfBlock(islands_);
    return {};
}

/// Reads the islands of the map's mesh, so that each of its vertices can name one basis. There are none without a mesh, or if it cannot be
/// read: the mesh's own action reports that.
void LightMapPlanner::readIslands() {
    const auto mesh = context_.action.inputs.find(kMeshRole);
    if (mesh == context_.action.inputs.end()) return;
    const auto scene = loadMesh(context_.action.inputs, kMeshRole, source_.places());
    if (!scene) return;
    islands_ = formats::islandRuns(scene->triangleMeshes(), source_.width(), source_.height());
    for (const formats::TriangleMesh* primitive : scene->triangleMeshes()) meshVertices_ += primitive->vertexCount();
}

/// Gathers the texels of the blocks that layouts learn from.
Result<void> LightMapPlanner::sample(const ActionContext& context) {
    compress::LightMapSamples samples(
        blocks_.choose(chartOfBlock_, compress::learningBlocks(options_.effort, source_.width(), source_.height())), blocks_.across());
    constexpr int kMargin = compress::LightMapSamples::kMargin;
    const auto sampled =
        mapInOrder<int>(source_.stripCount(), context, fmt::format("sample {}", context_.action.asset), [&](int index) -> Result<int> {
            LC_TRY(strip, source_.stripWithMargin(index, kMargin, kMargin));
            samples.add(*strip, source_.stripFirstRow(index), source_.stripRows(index));
            return 0;
        });
    if (!sampled) return tl::make_unexpected(sampled.error());
    samples_ = std::move(samples);
    return {};
}

}  // namespace lightcook::pipeline
