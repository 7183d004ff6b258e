// Checks of plausibility of a scene: facts of its inputs from cached actions, judged, and compared with what the scene file allows.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/bake_reading.h"
#include "pipeline/graph/action.h"
#include "pipeline/lint/finding.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// The document that `lightcook lint --json` writes. Errors follow where there are any.
struct LintReport {
    std::string scene;
    bool passed = false;
    std::vector<BakeReading> lightMaps;
    std::vector<Finding> findings;
};
template <class Fields, Is<LintReport> Self>
void describe(Fields& fields, Self& report) {
    fields.required("scene", report.scene, "name of the scene");
    fields.required("passed", report.passed, "true without errors");
    fields.required("light_maps", report.lightMaps, "how each light map was recognised");
    fields.required("findings", report.findings, "findings, also those that the scene file allows");
}

/// Returns the actions that gather the facts of a scene's inputs.
/// assets  the light maps, probes and gradients that are meant; none: all
std::vector<Action> planLint(const Scene& scene, bool repair, const std::optional<std::set<std::string>>& assets = {});

/// Judges a scene.
/// records    by action id, of planLint() and of the actions "materials/..." of the meshes; what has no record is not judged
/// isStrict   makes every warning that the scene file does not allow an error; notes stay
formats::Result<std::vector<Finding>> judgeScene(const Scene& scene, const std::map<std::string, ActionRecord>& records, bool isStrict);

/// Returns how the light maps were recognised, in the order of the scene. A map that has no record is left out.
std::vector<BakeReading> readingsOf(const Scene& scene, const std::map<std::string, ActionRecord>& records);

}  // namespace lightcook::pipeline
