// Packed charts as a part of a cook: the action that repacks a bake and its mesh, and the light map as the other actions take it.
//
// The action runs before the plan. Its files go to a folder of the cook that is not published: the assets of a repacked light map are
// planned as if a user had named these files. What the cook writes about sources (manifest, report, dependency file) names the user's own.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipeline/assets/asset_kind.h"
#include "pipeline/assets/light_map/unpacked_bake.h"
#include "pipeline/graph/action.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Files of an action, by role.
using RoleFiles = std::map<std::string, std::filesystem::path>;

/// Parameters of action "pack-charts". Its inputs are "source" and "mesh".
struct PackParameters {
    formats::LightMapDescription description;
    double maxVisible = 0;
};
template <class Fields, Is<PackParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("description", parameters.description, "conventions of the bake");
    fields.required("max_visible", parameters.maxVisible, "visible error that fewer texels may add");
}

struct PackResult {
    ChartPacking packing;
    std::vector<int> places;  ///< see UnpackedBake
    std::string map, mesh;    ///< files, relative to the folder
    Json notes;               ///< counts of the bake, as a light map's cook has them
};
template <class Fields, Is<PackResult> Self>
void describe(Fields& fields, Self& result) {
    fields.required("packing", result.packing, "how the charts were packed");
    fields.required("places", result.places, "places of the charts");
    fields.required("map", result.map, kFileInFolder, "the repacked bake");
    fields.required("mesh", result.mesh, kFileInFolder, "the mesh with the new UVs");
    fields.required("notes", result.notes, "counts of the bake");
}

/// A repacked light map.
struct PackedLightMap {
    RoleFiles sources;                    ///< the user's: inputs of the action
    RoleFiles files;                      ///< "source" and "mesh" of the repacked one, and the configuration of its colours
    UnpackedBake bake;                    ///< how the user's is read, and where its charts are now
    formats::LightMapDescription packed;  ///< how the repacked one is read
    Json notes;
};

/// Returns the action that repacks a light map: "pack/" and its name.
/// maxVisible  see PackParameters
Action packAction(const LightMapEntry& entry, double maxVisible, bool repair);
/// Runs that action.
formats::Result<ActionOutcome> packCharts(const ActionContext& context);
/// Returns the light map that an action repacked.
/// folder  where its files lie
formats::Result<PackedLightMap> packedLightMap(const Action& action, const ActionRecord& record, const std::filesystem::path& folder);

/// Returns a light map with the repacked files in place of the user's.
LightMapEntry packedEntry(LightMapEntry entry, const PackedLightMap& packed);
/// Returns the inputs by which the verification of a light map finds the bake and the mesh as they were.
RoleFiles unpackedInputs(const PackedLightMap& packed);

}  // namespace lightcook::pipeline
