// Prefiltered environment cubemaps: one kernel for each mip level. No seams, since every texel is a function of its direction alone.
//
// Method, as in tree codes for n-body problems (Barnes and Hut 1986):
// 1. The texels of the source are cut into pieces (direction, solid angle, flux), which fall into the cells of a quadtree on the six faces
//    of a cube. A cell has the exact solid angle and flux of its pieces, and the centroids of both: nothing is resampled, no energy is
//    lost.
// 2. A texel sums kernel times flux over the coarsest cells that are small against the kernel's width at their distance. Cells that hold
//    a large share of all light are opened further.
// 3. The variance of a cell widens the kernel at its centroid: second-order accuracy.
// Mips whose kernel is narrower than a texel are area resamples instead.
// Source of the use: Chen and Liu 2008, Lighting and Material of Halo 3, section 1.4.2. Pre-division is in fit/pre_divide.h.
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
    /// Width of the kernel (one standard deviation) over the size of the largest cell, 1 to 64, at the finest filtered level. Coarser
    /// levels, which cost little, have up to three times as many cells. docs/lab/fit.md has run time against error.
    double cellsPerKernelWidth = 3;
};

/// The kernel of a level, for shader and manifest.
struct MipKernel {
    int size = 0;  ///< [texels] of a face
    double perceptualRoughness = 0;
    double m = 0;  ///< perceptualRoughness squared; 0: an exact area resample over the texel's footprint
    lighting::ShBands bands{1, 1, 1};
};

class CubemapPrefilter {
public:
    /// Refuses options outside the limits above and empty environments. The environment must outlive the filter: filterRows reads it.
    static formats::Result<CubemapPrefilter> create(const formats::Environment& environment, const CubemapOptions& options);
    CubemapPrefilter(CubemapPrefilter&&) noexcept;
    CubemapPrefilter& operator=(CubemapPrefilter&&) noexcept;
    ~CubemapPrefilter();

    int mipCount() const;
    const std::vector<MipKernel>& mips() const;
    /// Filters rows of a face of a level. May run on several threads; texels do not depend on how the rows are divided. Results lie between
    /// zero and the brightest source value of the channel.
    /// out  receives the rows [firstRow, firstRow + out.height); mips()[mip].size wide
    void filterRows(int mip, int face, int firstRow, formats::ImageView<glm::vec3> out) const;
    /// Corrects the mean of a whole level, a strip of six faces +X -X +Y -Y +Z -Z from top to bottom, to the source's mean over the sphere.
    /// Sums over texel centres are no exact quadrature: with a small sun the mean is off by 0.3 % at 4 x 4 texels and more, by 7 % at 2 x 2
    /// and by 34 % at 1 x 1. The difference is distributed in proportion to p min(p / (1.5 mean), 1)^2, where p is the texel's value: no
    /// texel changes by much more than a third, and dark ones hardly change. Levels with m = 0 are exact and stay as they are.
    void keepMean(int mip, formats::ImageView<glm::vec3> strip) const;
    /// Returns a whole level as such a strip, with its mean corrected.
    formats::Image<glm::vec3> filterMip(int mip) const;

private:
    struct State;
    explicit CubemapPrefilter(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace lightcook::fit
