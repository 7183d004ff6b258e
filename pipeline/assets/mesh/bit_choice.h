// Bits of a compressed mesh: as few as keep its share of the limits of the light map, to whose errors its own add.
#pragma once

#include "formats/gltf_scene.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

struct MeshBits {
    formats::DracoOptions options;
    double bound = 0;  ///< of rel_rms
};

/// Chooses the bits of positions, normals and light-map UVs from the gradients of the light map. Where even the most bits do not keep the
/// limits, those are taken.
/// context  of the cook action
formats::Result<MeshBits> chooseMeshBits(const formats::GltfScene& scene, const MeshParameters& parameters, const ActionContext& context);

}  // namespace lightcook::pipeline
