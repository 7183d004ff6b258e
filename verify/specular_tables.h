// What the Cook-Torrance tables are worth: decoded nodes against direct integration, fetches between nodes through the texture unit, and
// the area specular that a shader makes of them.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec4.hpp>
#include <string>
#include <vector>

#include "formats/image.h"
#include "lighting/area_specular.h"
#include "verify/figures.h"

namespace lightcook::verify {

/// Tables are evaluated no nearer to grazing than this: below it shadowing ends in a fold narrower than any sample, and tables hold what
/// they have there.
inline constexpr double kSmallestTableNoV = 1e-3;

/// An axis as the manifest has it: it measures sqrt((p0 + p1 t) (q0 + q1 t)) of t, NoV or m, monotone; texel i holds
/// minimum + (maximum - minimum) i / (count - 1); coordinate = value * scale + offset.
struct SpecularTableAxis {
    int count = 0;
    double minimum = 0, maximum = 0;
    float scale = 0, offset = 0;
    std::array<double, 4> factors = {0, 1, 0, 1};

    double at(double index) const;  ///< value at a place between texels
    double of(double t) const;
    double inverse(double value) const;      ///< t of a value, in [0, 1]
    std::array<double, 3> radicand() const;  ///< the product's coefficients of 1, t, t^2
};

/// The tables as their manifest describes them, decoded.
struct CookedSpecularTables {
    lighting::SpecularLobe lobe = lighting::SpecularLobe::Beckmann;
    lighting::CookTorranceNormalization normalization = lighting::CookTorranceNormalization::Energy;
    SpecularTableAxis view, roughness;
    std::array<formats::Image<glm::vec4>, 3> textures;  ///< c0236, d0236, cd78
    std::array<glm::vec4, 3> scale{}, bias{};           ///< in the same order
};

/// Where tables and reference are compared.
struct SpecularTableSample {
    double NoV = 0, m = 0;
    bool isNode = false;
    bool isMiddle = false;  ///< of a cell: where a linear filter errs most, to second order
};
/// Every node, the middle of every cell, and randomCount seeded places, uniform in NoV and m whatever the axes are: in one
/// fixed order.
std::vector<SpecularTableSample> specularTableSamples(const CookedSpecularTables& tables, int randomCount, std::uint64_t seed);

/// Twelve numbers of a kernel, C 0 2 3 6, D 0 2 3 6, C 7 8, D 7 8.
using SpecularKernelEntries = std::array<double, 12>;
struct SpecularTableResult {
    SpecularKernelEntries reference{}, cooked{};
};
/// Pure, safe on several threads.
SpecularTableResult compareSpecularTables(const CookedSpecularTables& tables, const SpecularTableSample& sample);
SpecularKernelEntries entriesOf(const lighting::AreaSpecularKernel& kernel);
/// What a shader makes of a filtered fetch.
SpecularKernelEntries fetchSpecularTables(const CookedSpecularTables& tables, double NoV, double m);

/// The largest error of an entry at a node in steps of its channel's 16 bits, and where.
struct SpecularTableStepError {
    double steps = 0;
    std::size_t entry = 0;  ///< of SpecularKernelEntries
    double NoV = 0, m = 0;
};
SpecularTableStepError specularTableStepError(const CookedSpecularTables& tables, const std::vector<SpecularTableSample>& samples,
                                              const std::vector<SpecularTableResult>& results);

/// Light that tables are shaded with: weights of the twelve entries, one a light of the upper hemisphere and F0.
std::vector<SpecularKernelEntries> specularTableShadings(const std::vector<double>& f0);

/// Levels that local relative errors are taken against: RMS of the kernel entries at nodes; log-average of the positive radiances.
struct SpecularTableKeys {
    double kernel = 0, shaded = 0;
};
SpecularTableKeys specularTableKeys(const std::vector<SpecularTableSample>& samples, const std::vector<SpecularTableResult>& results,
                                    const std::vector<double>& f0);

/// Local relative errors that no place of the tables exceeds: specular_table_bound.h.
struct SpecularTableBounds {
    double filter = 0, total = 0;
    ErrorPlace filterAt, totalAt;  ///< middles of the cells that these are of
    void raise(const SpecularTableBounds& other);
};
/// A place of the tables, in texels; NoV and m as ErrorPlace has them.
ErrorPlace tablePlace(const CookedSpecularTables& tables, double NoV, double m);

/// Stages "quantize" (kernel entries at nodes; all of them are met, so the largest error is the bound), "filter" (kernel entries between
/// nodes) and "total": reflected radiance of representative light (a constant, and directional lights of the upper hemisphere) off nodes
/// and between them, for each f0. All of it is specular.
std::vector<StageError> specularTableStages(const CookedSpecularTables& tables, const std::vector<SpecularTableSample>& samples,
                                            const std::vector<SpecularTableResult>& results, const std::vector<double>& f0,
                                            const SpecularTableBounds& bounds);

}  // namespace lightcook::verify
