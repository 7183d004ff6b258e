// Plans of layouts for one light map, with samples for learned layouts that are gathered once.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "compress/light_map.h"
#include "formats/chart_clusters.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Returns the objective of a map.
/// displayKey  of the map (verify::LightMapKey)
compress::LightMapObjective objectiveFor(const SceneView& view, double displayKey, const glm::dmat3& bt2020FromWorking);

/// Plans of learned layouts, kept for as long as a cook runs. The cook of a map takes what its trial has learned, for the same layout or a
/// longer one.
class LearnedPlans {
public:
    /// key  of the map and of everything that its plans depend on
    std::optional<compress::LightMapPlan> find(const std::string& key, const formats::LightMapLayoutInfo& layout) const;
    void add(const std::string& key, compress::LightMapPlan plan);

private:
    mutable std::mutex mutex_;
    std::map<std::string, std::vector<compress::LightMapPlan>> plans_;
};

/// Plans layouts for one map. The samples of learned layouts are gathered when the first of these layouts is planned.
class LightMapPlanner {
public:
    /// visible   scene that learned layouts minimize the visible error of; empty: energy
    /// mipCount  levels of the plans
    LightMapPlanner(LightMapSource& source, formats::Target target, const TextureSettings& textures, const MapSurvey& survey,
                    const std::optional<SceneView>& visible, int mipCount, const ActionContext& context);
    /// context  of this pass of the action
    formats::Result<compress::LightMapPlan> plan(const std::string& layout, formats::LightMapFilter filter, const ActionContext& context);

private:
    formats::Result<compress::LightMapPlan> planLevel0(const std::string& layout, formats::LightMapFilter filter,
                                                       const ActionContext& context);
    formats::Result<compress::LightMapPlan> learn(const formats::LightMapLayoutInfo& layout, const compress::MeasuredLightMap& map,
                                                  const ActionContext& context);
    std::string keyOfLearned(formats::LightMapFilter filter) const;
    formats::Result<void> gather(const ActionContext& context);
    formats::Result<void> surveyCharts(const ActionContext& context);
    void readIslands();
    formats::Result<void> sample(const ActionContext& context);
    bool doesIndexServe(const compress::LightMapPlan& plan) const;

    LightMapSource& source_;
    const compress::LightMapMeasure& measure_;
    TextureSettings textures_;
    std::optional<SceneView> visible_;
    std::optional<compress::LightMapObjective> objective_;  ///< of learned layouts; empty: energy
    const ActionContext& context_;
    formats::Target target_;
    int mipCount_;
    compress::EncodeOptions options_;
    compress::LightMapBlocks blocks_;
    std::vector<int> chartOfBlock_;
    std::vector<formats::IslandRun> islands_;  ///< of the map's mesh, if it can be read
    std::size_t meshVertices_ = 0;
    std::optional<compress::LightMapSamples> samples_;
};

}  // namespace lightcook::pipeline
