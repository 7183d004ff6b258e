#include "pipeline/figures_json.h"

#include <cmath>

namespace pipeline {
namespace {

bool isFinite(const verify::ErrorFigures& figures) {
    return std::isfinite(figures.relRms) && std::isfinite(figures.p99) && std::isfinite(figures.maxSampled) &&
           std::isfinite(figures.maxBound);
}

}  // namespace

Json toJson(const verify::ErrorFigures& figures) {
    return {{"rel_rms", figures.relRms}, {"p99", figures.p99}, {"max_sampled", figures.maxSampled}, {"max_bound", figures.maxBound}};
}

Json toJson(const verify::StageError& stage) {
    return {{"name", stage.name},
            {"seconds", stage.seconds},
            {"error", {{"diffuse", toJson(stage.diffuse)}, {"specular", toJson(stage.specular)}}}};
}

Json verdict(const std::vector<verify::StageError>& stages, double maxError) {
    Json result = {{"stages", Json::array()}, {"limit", {{"metric", "rel_rms"}, {"value", maxError}}}, {"passed", false}};
    bool passed = !stages.empty();
    for (const verify::StageError& stage : stages) {
        result["stages"].push_back(toJson(stage));
        passed = passed && isFinite(stage.diffuse) && isFinite(stage.specular);
    }
    result["passed"] = passed && stages.back().diffuse.relRms <= maxError && stages.back().specular.relRms <= maxError;
    return result;
}

}  // namespace pipeline
