// Judgement of the facts of a scene's inputs: which of them are implausible, with the thresholds and the sentences. Pure functions.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/lint/finding.h"
#include "pipeline/lint/gradient_facts.h"
#include "pipeline/lint/light_map_facts.h"
#include "pipeline/lint/mesh_facts.h"
#include "pipeline/lint/probe_facts.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

using Findings = std::vector<Finding>;

Findings judgeLightMap(const Scene& scene, const LightMapEntry& entry, const LightMapFacts& facts);
/// isWholeMap  no other light map of the scene has the same file, with a part of its own
Findings judgeMesh(const LightMapEntry& entry, const MeshFacts& facts, bool isWholeMap = true);
/// Returns true if the UVs of a mesh are places in the whole map: nothing speaks against it, and no change of the UVs fits better.
bool fits(const LightMapEntry& entry, const MeshFacts& facts, bool isWholeMap);
/// Looks for the lmbake of a light map of Godot on a mesh. Looks at files beside the map.
/// isFitting  see fits(); UVs in the whole map need no lmbake
Findings judgeGodot(const LightMapEntry& entry, bool isFitting);
/// nodes  with light-map UVs that no light map of their mesh has a place for
Findings judgePlaces(const LightMapEntry& entry, const std::vector<std::string>& nodes);
/// Share of the texels that a mesh reads which two triangles may read: see judgeMesh().
inline constexpr double kMostShared = 0.03;
/// Looks for nodes and rectangles of a bake of Godot that have no counterpart.
Findings judgeLmbake(const LightMapEntry& entry, const MeshFacts& facts);
Findings judgeProbe(const ProbeEntry& entry, const ProbeFacts& facts);
Findings judgeGradient(const GradientEntry& entry, const GradientFacts& facts);
/// Compares the primaries that a file of an asset states with those of the source space of the scene.
Findings judgePrimaries(const std::string& asset, const std::filesystem::path& file, const std::string& source,
                        const std::optional<formats::StatedPrimaries>& primaries);
/// Compares the brightness of a light map with that of the probes of its scene.
Findings judgeUnits(const LightMapEntry& entry, const LightMapFacts& facts, const std::vector<ProbeFacts>& probes);
/// Compares the brightness of traced light with that of its light map.
Findings judgeGroundTruth(const LightMapEntry& entry, const LightMapFacts& facts);
/// Looks for limits above 1.
Findings judgeSettings(const Scene& scene);
/// Looks for a mesh that was written after its light map, by the times of the files.
Findings judgeAge(const LightMapEntry& entry);
/// Looks for names of [[material]] that no mesh has. materials: of all meshes; none: there is nothing to compare with.
Findings judgeMaterials(const Scene& scene, const std::vector<MaterialRecord>& materials);
/// Looks for materials of a mesh whose extensions are not read and whose reflection no [[material]] states.
Findings judgeExtensions(const Scene& scene, const LightMapEntry& entry, const std::vector<UnreadMaterial>& materials);

}  // namespace lightcook::pipeline
