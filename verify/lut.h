// Verification of the Cook-Torrance lookup tables (asset kind `lut`): decoded nodes against direct integration, filtered fetches between
// the nodes, the area specular that a shader computes from them, and a bound that holds for every view and roughness.
// docs/theory/lighting.md, "Specular tables", describes the tables.
//
// Use: lutSamples -> compareLut for each -> lutKeys -> boundLut -> lutStages.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec4.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/image.h"
#include "lighting/area_specular.h"
#include "verify/figures.h"
#include "verify/sampler_tolerance.h"

namespace lightcook::verify {

/// Smallest NoV at which tables are evaluated. Below it, shadowing ends in a fold narrower than any sample, and a fetch returns the entry
/// of this NoV.
inline constexpr double kSmallestTableNoV = 1e-3;

/// One axis of the tables. The axis value of t (NoV or m) is sqrt((p0 + p1 t) (q0 + q1 t)), which is monotone. Texel i holds the value
/// minimum + (maximum - minimum) i / (count - 1). The texture coordinate is value * scale + offset.
struct LutAxis {
    int count = 0;
    double minimum = 0, maximum = 0;
    float scale = 0, offset = 0;
    std::array<double, 4> factors = {0, 1, 0, 1};  ///< p0, p1, q0, q1

    double at(double index) const;           ///< axis value at a texel, or between two
    double of(double t) const;               ///< axis value of t
    double inverse(double value) const;      ///< t of an axis value, in [0, 1]
    std::array<double, 3> radicand() const;  ///< coefficients of 1, t, t^2 under the root
    /// Returns the larger distance of the coordinates of the first and the last texel from their centres [texels].
    double coordinateError() const;
    /// Returns an upper bound of coordinateError() for an ideal scale and offset that are rounded to floats.
    double coordinateRounding() const;
};

/// The tables as their manifest describes them, decoded.
struct CookedLut {
    lighting::SpecularLobe lobe = lighting::SpecularLobe::Beckmann;
    lighting::CookTorranceNormalization normalization = lighting::CookTorranceNormalization::Energy;
    LutAxis view, roughness;
    std::array<formats::Image<glm::vec4>, 3> textures;  ///< c0236, d0236, cd78
    std::array<glm::vec4, 3> scale{}, bias{};           ///< in the same order
    std::array<FormatTolerance, 3> tolerance{};         ///< of samplers, in the same order; default: ideal ones
};

/// A place where tables and reference are compared.
struct LutSample {
    double NoV = 0, m = 0;
    bool isNode = false;
    bool isMiddle = false;  ///< middle of a cell: to second order the largest error of a linear filter
};
/// Returns every node, the middle of every cell, and randomCount seeded places that are uniform in NoV and m, in a fixed order.
std::vector<LutSample> lutSamples(const CookedLut& tables, int randomCount, std::uint64_t seed);

/// The twelve entries of a kernel: C 0 2 3 6, D 0 2 3 6, C 7 8, D 7 8.
using SpecularKernelEntries = std::array<double, 12>;
struct LutResult {
    SpecularKernelEntries reference{}, cooked{};
};
/// Compares the tables with direct integration at one place. Pure, safe on several threads.
LutResult compareLut(const CookedLut& tables, const LutSample& sample);
SpecularKernelEntries entriesOf(const lighting::AreaSpecularKernel& kernel);
/// Returns the entries that a shader computes from one filtered fetch.
SpecularKernelEntries fetchLut(const CookedLut& tables, double NoV, double m);

/// The largest error of an entry that a shader decodes from a texel, in steps of its channel's 16 bits. What rounding to single precision
/// explains does not count: it is many steps of a channel whose range is small beside its values, such as C 0 of a smooth surface, which
/// is nearly the same for all views.
struct LutStepError {
    double steps = 0;
    std::size_t entry = 0;  ///< of SpecularKernelEntries
    double NoV = 0, m = 0;
};
/// Compares every texel itself, not a fetch at its coordinate: LutAxis::coordinateError() is about those.
/// samples  as lutSamples() returns them
LutStepError lutStepError(const CookedLut& tables, const std::vector<LutSample>& samples, const std::vector<LutResult>& results);

/// Returns the lighting that tables are shaded with: weights of the twelve entries, for each F0 and each light of the upper hemisphere.
std::vector<SpecularKernelEntries> lutShadings(const std::vector<double>& f0);
/// Returns the exit radiance of a white Lambert surface under the light of each of lutShadings.
std::vector<double> lutExitRadiances(const std::vector<double>& f0);

/// Keys of the local relative errors: RMS of the kernel entries at nodes, and log-average of the positive shaded radiances.
struct LutKeys {
    double kernel = 0, shaded = 0;
};
LutKeys lutKeys(const std::vector<LutSample>& samples, const std::vector<LutResult>& results, const std::vector<double>& f0);

/// Upper bounds of the local relative error over all places of the tables, and of the visible error.
struct LutBounds {
    double filter = 0, total = 0;
    ErrorPlace filterAt, totalAt;        ///< middles of the cells with these bounds
    std::optional<double> visible = {};  ///< sampler tolerance included; empty: no display was given
    VisiblePlace visibleAt = {};         ///< middle of its cell
    void raise(const LutBounds& other);
};

/// Upper bounds of the errors in one cell, the area between four neighbouring nodes.
struct LutCellBound {
    SpecularKernelEntries entries{};  ///< absolute error of each entry
    double filter = 0;                ///< local relative error of an entry
    double total = 0;                 ///< local relative error of a shading
    std::optional<double> visible;    ///< visible error of a shading; empty: no display was given
    std::size_t visibleShading = 0;   ///< which of lutShadings has it
};

/// Bounds the cells between view nodes viewCell and viewCell + 1, one for each pair of neighbouring roughness nodes (one in all for a table
/// of one row). assets/lut_bound.cpp describes the method. All bounds are infinite if the axes' coordinates do not meet their texels.
/// Pure, safe on several threads.
/// viewing  as in lutStages
std::vector<LutCellBound> boundLut(const CookedLut& tables, int viewCell, const LutKeys& keys, const std::vector<double>& f0,
                                   const std::optional<Viewing>& viewing = std::nullopt);
/// Bounds all cells on the calling thread.
LutBounds boundLut(const CookedLut& tables, const LutKeys& keys, const std::vector<double>& f0,
                   const std::optional<Viewing>& viewing = std::nullopt);
/// Returns the largest bounds of one column of cells, with their places.
/// f0  as in boundLut
LutBounds largestOf(const CookedLut& tables, int viewCell, const std::vector<LutCellBound>& cells, const std::vector<double>& f0);

/// Returns a place of the tables: x and y in texels, NoV and m in the fields of ErrorPlace.
ErrorPlace lutPlace(const CookedLut& tables, double NoV, double m);

/// Returns three stages, all of them specular:
///   "quantize"  kernel entries at nodes. Every node is a sample, so the largest sampled error is also the bound.
///   "filter"    kernel entries between nodes
///   "total"     reflected radiance at and between nodes, for each F0, under constant light and directional lights of the upper hemisphere
/// viewing  display for visible errors of "total", on which exit radiance 1 is the key: each light is scaled so that a white Lambert
/// surface
///          has exit radiance 1 under it; empty: none
std::vector<StageError> lutStages(const CookedLut& tables, const std::vector<LutSample>& samples, const std::vector<LutResult>& results,
                                  const std::vector<double>& f0, const LutBounds& bounds,
                                  const std::optional<Viewing>& viewing = std::nullopt);

}  // namespace lightcook::verify
