// Kernels of area specular on a grid of roughness and view. The bounds of every view, m and F0 are made from them. Private to verify/.
#pragma once

#include <vector>

#include "lighting/brdf.h"
#include "lighting/sh.h"
#include "verify/light_map.h"

namespace lightcook::verify {

/// Returns the kernel of a view in the x-z plane, by `sampleCount` half vectors for each axis.
lighting::AreaSpecularKernel specularKernelAt(double NoV, double m, lighting::NormalDistribution lobe, int sampleCount);
/// Returns the kernel of a material with this F0.
lighting::ShDouble kernelAtF0(const lighting::AreaSpecularKernel& kernel, double f0);

/// Kernels on a grid of roughness and view, with bounds for everything between the grid points.
class ScannedKernels {
public:
    explicit ScannedKernels(const LightMapShading& shading);
    static constexpr int kViews = 49;
    int roughnessCount() const { return static_cast<int>(roughness_.size()); }
    double roughness(int r) const { return roughness_[static_cast<std::size_t>(r)]; }
    /// Returns the angle between view and normal [rad].
    static double viewAngle(double view);
    const lighting::AreaSpecularKernel& at(int roughness, int view) const {
        return kernels_[static_cast<std::size_t>(roughness * kViews + view)];
    }
    /// Returns the lengths by which kernels between this grid point and its neighbours may differ from means of grid points.
    lighting::ShBands between(int roughness, int view, double f0) const;

private:
    static constexpr int kStepsPerOctave = 5;
    static constexpr double kBetween = 2.0 / 8;  ///< share of second differences, twice the 1/8 of linear interpolation
    /// Returns the sum of the lengths of the second differences along both axes.
    lighting::ShBands secondDifferenceAt(int r, int v, double f0) const;

    std::vector<double> roughness_;
    std::vector<lighting::AreaSpecularKernel> kernels_;  ///< [roughness][view]
};

}  // namespace lightcook::verify
