// Environment cubemaps: prefilter by a kernel per mip, without seams because every texel is a function of its direction alone.
// Source: Chen and Liu, Lighting and Material of Halo 3, section 1.4.2; lighting-math section 5. Pre-division is in fit/pre_divide.h.
//
// The source becomes points (direction, solid angle, flux) that fall into the cells of a quadtree on the six faces of a cube; a cell knows
// its exact solid angle, its exact flux and both centroids, so nothing is resampled and no energy is lost. A texel sums over the coarsest
// cells that are small beside the kernel at their distance.
#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "fit/environment_sh.h"
#include "formats/environment.h"
#include "formats/error.h"
#include "formats/image.h"

namespace lightcook::fit {

struct CubemapOptions {
    int size = 128;    ///< [texels] of a face at mip 0, a power of two, 1..4096
    int mipCount = 0;  ///< 0: the whole chain, log2(size) + 1
    PrefilterKernel kernel = PrefilterKernel::Beckmann;
    /// Beckmann's m (GGX's alpha) of each mip, in [0, 1]; empty: perceptual roughness mip / (mipCount - 1), squared (a single mip: 0).
    std::vector<double> roughness;
    /// Kernel's width (one standard deviation) over the largest cell, at the finest filtered level; coarser levels, which cost little, have
    /// up to three times as many. 1..64. docs/experiments.md has run time against error.
    double cellsPerKernelWidth = 3;
};

/// What a level was filtered with: everything a shader or a manifest needs.
struct MipKernel {
    int size = 0;  ///< [texels] of a face
    double perceptualRoughness = 0;
    double m = 0;  ///< perceptualRoughness squared; 0: an exact area resample over the texel's footprint
    lighting::ShBands bands{1, 1, 1};
};

class CubemapPrefilter {
public:
    /// Refuses options outside the limits above and empty environments. The environment is read again by filterRows: it must outlive the
    /// filter.
    static formats::Result<CubemapPrefilter> create(const formats::Environment& environment, const CubemapOptions& options);
    CubemapPrefilter(CubemapPrefilter&&) noexcept;
    CubemapPrefilter& operator=(CubemapPrefilter&&) noexcept;
    ~CubemapPrefilter();

    int mipCount() const;
    const std::vector<MipKernel>& mips() const;
    /// Rows [firstRow, firstRow + rowCount) of a face of a level, filtered around each texel's centre, into out (mips()[mip].size wide,
    /// rowCount high). Pure and safe on several threads; a texel does not depend on how the rows were cut. Results lie between zero and the
    /// brightest source value of the channel.
    void filterRows(int mip, int face, int firstRow, int rowCount, formats::ImageView<glm::vec3> out) const;
    /// Gives the rows of a whole level, a strip of six faces +X -X +Y -Y +Z -Z from top to bottom, the source's mean over the sphere.
    /// Values at texel centres are no exact quadrature: at 4 x 4 texels and more a small sun costs 0.3 % of the mean, at 2 x 2 and 1 x 1, 7
    /// and 34 %. What is missing goes to the texels in proportion to p min(p / (1.5 mean), 1)^2, so that no texel changes by more than
    /// about a third over that share and dark ones, mostly half of all, hardly change. Levels with m = 0 are exact already and stay as they
    /// are.
    void keepMean(int mip, formats::ImageView<glm::vec3> strip) const;
    /// A whole level as such a strip, its mean kept.
    formats::Image<glm::vec3> filterMip(int mip) const;

private:
    struct State;
    explicit CubemapPrefilter(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace lightcook::fit
