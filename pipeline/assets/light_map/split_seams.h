// Verification of the seams between the maps of a split light map (chart_split.h), from the bytes of all of them.
//
// Method: the cut meshes of all maps are looked at together. A cut makes the same vertices on both of its sides, so that its edges are
// found like any other edge that two charts share. Each side of an edge is lit by its own map. Edges inside one map are measured by the
// verification of that map.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/shading.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"
#include "pipeline/limits/limits.h"

namespace lightcook::pipeline {

/// Roles of the inputs of map `index`: its repacked bake and its cut mesh.
std::string splitBakeRole(std::size_t index);
std::string splitMeshRole(std::size_t index);

/// Parameters of action "verify-split-seams". Its dependencies are the cook actions of the maps.
struct SplitSeamsParameters {
    SceneView view;
    std::vector<std::string> maps;  ///< in the order of the split
    Limits limits;                  ///< on the largest step that cooking adds to an edge
};
template <class Fields, Is<SplitSeamsParameters> Self>
void describe(Fields& fields, Self& parameters) {
    describe(fields, parameters.view);
    fields.required("maps", parameters.maps, atLeast(2), "light maps, in the order of the split");
    describe(fields, parameters.limits, {Limit::Seam});
}

/// Returns a SplitSeams.
formats::Result<ActionOutcome> verifySplitSeams(const ActionContext& context);

}  // namespace lightcook::pipeline
