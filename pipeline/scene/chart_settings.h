// Settings of a cook for the charts of its light maps: keys `charts` and `charts_max_visible` of [output] and [[light_map]].
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "formats/error.h"
#include "pipeline/scene/chart_mode.h"

namespace lightcook::pipeline {

/// Largest value of charts_max_visible.
inline constexpr double kMostChartsVisible = 100;

/// Settings of one place: [output], a [[light_map]], or the command line. What is absent is that of the place before.
struct ChartSettings {
    std::optional<ChartMode> mode;
    std::optional<double> maxVisible;  ///< visible error that fewer texels may add; 0: charts are moved only
};

/// Settings of a scene.
class SceneCharts {
public:
    explicit SceneCharts(ChartSettings output = {}, std::map<std::string, ChartSettings> ofLightMap = {})
        : output_(output), ofLightMap_(std::move(ofLightMap)) {}

    /// Replaces what is given on the command line, for all light maps.
    void apply(const ChartSettings& overrides);
    /// Returns true if the charts of a light map are packed anew.
    bool isPacked(const std::string& lightMap) const;
    /// Returns the visible error that fewer texels of its charts may add.
    double maxVisibleOf(const std::string& lightMap) const;

private:
    ChartSettings output_;
    std::map<std::string, ChartSettings> ofLightMap_;  ///< by name
};

/// Reads the settings of a scene file that readScene() takes.
formats::Result<SceneCharts> readSceneCharts(const std::filesystem::path& file);

}  // namespace lightcook::pipeline
