// What the Cook-Torrance tables are worth: decoded nodes against direct integration, fetches between nodes through the texture unit, and
// the area specular that a shader makes of them.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec4.hpp>
#include <string>
#include <vector>

#include "formats/image.h"
#include "lighting/brdf.h"
#include "verify/figures.h"

namespace verify {

/// An axis as the manifest has it: texel i holds minimum + (maximum - minimum) i / (count - 1); coordinate = value * scale + offset.
struct SpecularTableAxis {
    int count = 0;
    double minimum = 0, maximum = 0;
    float scale = 0, offset = 0;
};

/// What the view axis measures.
enum class SpecularViewAxis { Sine, NoV };

/// The tables as their manifest describes them, decoded; Beckmann, normalised by energy. The roughness axis is m.
struct CookedSpecularTables {
    SpecularViewAxis viewAxis = SpecularViewAxis::Sine;
    SpecularTableAxis view, roughness;
    std::array<formats::Image<glm::vec4>, 3> textures;  ///< c0236, d0236, cd78
    std::array<glm::vec4, 3> scale{}, bias{};           ///< in the same order
};

/// Where tables and reference are compared.
struct SpecularTableSample {
    double view = 0, m = 0;  ///< view: as the axis measures it
    bool isNode = false;
    bool isMiddle = false;  ///< of a cell: where a linear filter errs most, to second order
};
/// Every node, the middle of every cell, and randomCount seeded points of the axes' ranges, in one fixed order.
std::vector<SpecularTableSample> specularTableSamples(const CookedSpecularTables& tables, int randomCount, std::uint64_t seed);

/// Twelve numbers of a kernel, C 0 2 3 6, D 0 2 3 6, C 7 8, D 7 8.
using SpecularKernelEntries = std::array<double, 12>;
struct SpecularTableResult {
    SpecularKernelEntries reference{}, cooked{};
};
/// Pure, safe on several threads. Nodes are integrated with 1024 samples an axis, others with 512. NoV is at least 1e-3, as in the tables.
SpecularTableResult compareSpecularTables(const CookedSpecularTables& tables, const SpecularTableSample& sample);

/// The largest error of an entry at a node in steps of its channel's 16 bits, and where. At grazing view, where two
/// integrations of a fold narrower than their samples differ by more, eighty steps count as one.
struct SpecularTableStepError {
    double steps = 0;
    std::size_t entry = 0;  ///< of SpecularKernelEntries
    double view = 0, m = 0;
};
SpecularTableStepError specularTableStepError(const CookedSpecularTables& tables, const std::vector<SpecularTableSample>& samples,
                                              const std::vector<SpecularTableResult>& results);

/// Stages "quantize" (kernel entries at nodes), "filter" (kernel entries between nodes) and "total": reflected radiance of representative
/// light (a constant, and directional lights of the upper hemisphere) off nodes and between them, for each f0. All of it is specular.
/// Keys: RMS of the kernel entries at nodes; for "total" the log-average of the positive references.
std::vector<StageError> specularTableStages(const std::vector<SpecularTableSample>& samples,
                                            const std::vector<SpecularTableResult>& results, const std::vector<double>& f0);

}  // namespace verify
