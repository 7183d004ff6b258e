#include "verify/light_map/visible_bound_setup.h"

#include <utility>

#include "verify/light_map/rounding.h"

namespace lightcook::verify {

namespace {

/// Returns kernels in whole vectors: the last one is repeated.
CoarseKernels padded(CoarseKernels kernels) {
    while (kernels.centres.size() % ShadingMatrix::kLanes != 0) {
        kernels.centres.push_back(lighting::ShDouble(kernels.centres.back()));
        kernels.radii.push_back(lighting::ShBands(kernels.radii.back()));
    }
    return kernels;
}

}  // namespace

VisibleKernels::VisibleKernels(KernelTree kernels, KernelGrids controls, const CoarseKernels& unpadded)
    : tree(std::move(kernels)), grids(std::move(controls)), lengths(unpadded.lengths) {
    const CoarseKernels coarse = padded(unpadded);
    centres = ShadingMatrix(coarse.centres, std::vector<ShadingSample>(coarse.centres.size()));
    for (std::size_t l = 0; l < radii.size(); ++l) {
        for (const lighting::ShBands& radius : coarse.radii)
            radii[l].push_back(static_cast<float>(radius[l] + lightmap::kShadingRounding * lengths[l]));
        lengths[l] *= 1 + lightmap::kShadingRounding;
    }
}

VisibleBoundSetup visibleBoundSetup(const LightMapShading& shading, const Viewing& viewing, double key, double tilt,
                                    const ScannedKernels* scanned) {
    const VisibleMetric metric(viewing, key);
    VisibleBoundSetup out{metric, std::make_shared<AnyLightBound>(metric), {}, {}};
    KernelTree diffuse = KernelTree::diffuse(tilt);
    const CoarseKernels coarse = CoarseKernels::diffuse(diffuse);
    out.diffuse = VisibleKernels(std::move(diffuse), {KernelGrid::diffuse(tilt, 1), KernelGrid::diffuse(tilt, 2)}, coarse);
    if (scanned == nullptr) return out;
    KernelTree specular = KernelTree::specular(shading, *scanned);
    const CoarseKernels coarseSpecular = CoarseKernels::specular(specular);
    out.specular = VisibleKernels(std::move(specular),
                                  {KernelGrid::specular(shading, *scanned, 1), KernelGrid::specular(shading, *scanned, 2)}, coarseSpecular);
    return out;
}

}  // namespace lightcook::verify
