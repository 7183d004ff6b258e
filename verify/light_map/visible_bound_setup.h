// The metric and the shading kernels that bound the visible errors of a map. Private to verify/.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "verify/error/visible_metric.h"
#include "verify/light_map/kernel_cells.h"
#include "verify/light_map/shading.h"
#include "verify/light_map/visible_grid.h"

namespace lightcook::verify {

/// The kernels of one kind of shading, without any if the scene has no such shading.
struct VisibleKernels {
    KernelTree tree;
    KernelGrids grids;
    lighting::ShBands lengths{};              ///< largest length of each band of the coarse kernels
    ShadingMatrix centres;                    ///< of the coarse kernels, in whole vectors
    std::array<std::vector<float>, 3> radii;  ///< [band][row], rounded up

    VisibleKernels() = default;
    VisibleKernels(KernelTree kernels, KernelGrids controls, const CoarseKernels& coarse);
    bool isNone() const { return centres.count() == 0; }
};

struct VisibleBoundSetup {
    VisibleMetric metric;  ///< of light in units of the key
    std::shared_ptr<const AnyLightBound> anyLight;
    VisibleKernels diffuse, specular;
};

/// Returns what bounds visible errors.
/// key      light of the map for each unit of light that is bounded
/// tilt     largest angle of a normal from the texel's own [degrees]
/// scanned  kernels of the scene; null: no specular light
VisibleBoundSetup visibleBoundSetup(const LightMapShading& shading, const Viewing& viewing, double key, double tilt,
                                    const ScannedKernels* scanned);

}  // namespace lightcook::verify
