#include "fit/irradiance.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "fit/cubemap/kernel.h"
#include "fit/cubemap/tree.h"
#include "lighting/cube.h"

namespace lightcook::fit {
namespace {

/// A cell is opened down to kFinestCellWidth [rad] if its share of all light times its size [chord] exceeds kBrightShare: all of its light
/// crosses the horizon at once, which would be visible.
constexpr double kFinestCellWidth = 0.012, kBrightShare = 5e-5;
/// A cell has separate entries for area and flux if their centroids are farther apart than this part of its size.
constexpr double kSplitDistance = 0.02;
/// Each channel has an entry if Cell::colourShift exceeds this part of all light.
constexpr double kColourShare = 1e-6;

struct Entry {
    glm::vec3 direction;  ///< mean over the cell, not normalised: n.direction is the exact mean of n.l
    float solidAngle;
    glm::vec3 flux;
};

class Gatherer {
public:
    Gatherer(const MomentTree& tree, int cellsPerSide) : tree_(tree), cellsPerSide_(cellsPerSide) {
        for (const CellMoments& cell : tree.levels.front().cells) all_ += cell.brightness;
    }
    std::vector<Entry> entries() {
        for (int face = 0; face < 6; ++face) visit(0, face, 0, 0);
        return std::move(entries_);
    }

private:
    void visit(std::size_t levelIndex, int face, int x, int y) {
        const MomentLevel& level = tree_.levels[levelIndex];
        const CellMoments& cell = level.at(face, x, y);
        if (cell.solidAngle == 0) return;
        const bool isOpened = level.cellsPerSide < cellsPerSide_ || cell.brightness * level.size > kBrightShare * all_;
        if (levelIndex + 1 == tree_.levels.size() || !isOpened) {
            emit(finishCell(cell), level.size);
            return;
        }
        for (int child = 0; child < 4; ++child) visit(levelIndex + 1, face, 2 * x + child % 2, 2 * y + child / 2);
    }
    void emit(const Cell& cell, double size) {
        const bool isSplit = glm::distance(cell.areaCentroid, cell.fluxCentroid) > kSplitDistance * size;
        enterCell(cell, static_cast<double>(cell.colourShift) > kColourShare * all_, isSplit,
                  [&](const glm::vec3& centroid, float spread, float solidAngle, const glm::vec3& flux) {
                      entries_.push_back({(1 - spread) * centroid, solidAngle, flux});
                  });
    }

    const MomentTree& tree_;
    int cellsPerSide_;
    double all_ = 0;
    std::vector<Entry> entries_;
};

/// Returns the weighted mean radiance for eight normals, each divided by the sum of its weights.
std::array<glm::dvec3, 8> meansOf(const std::vector<Entry>& entries, const std::array<glm::vec3, 8>& normals, float wrap) {
    Float8 x{}, y{}, z{};
    for (int lane = 0; lane < 8; ++lane) {
        x[lane] = normals[static_cast<std::size_t>(lane)].x;
        y[lane] = normals[static_cast<std::size_t>(lane)].y;
        z[lane] = normals[static_cast<std::size_t>(lane)].z;
    }
    Double8 weightSum{}, redSum{}, greenSum{}, blueSum{};
    constexpr std::size_t kEntriesPerPartialSum = 64;  // rounding stays below 1e-6
    for (std::size_t first = 0; first < entries.size(); first += kEntriesPerPartialSum) {
        const std::size_t end = std::min(entries.size(), first + kEntriesPerPartialSum);
        Float8 weight{}, red{}, green{}, blue{};
        for (std::size_t i = first; i < end; ++i) {
            const Entry& entry = entries[i];
            const Float8 c = x * entry.direction.x + y * entry.direction.y + z * entry.direction.z + wrap;
            const Float8 shape = detail::select(c > 0.0f, c, Float8{});
            weight += shape * entry.solidAngle;
            red += shape * entry.flux.x;
            green += shape * entry.flux.y;
            blue += shape * entry.flux.z;
        }
        weightSum += __builtin_convertvector(weight, Double8);
        redSum += __builtin_convertvector(red, Double8);
        greenSum += __builtin_convertvector(green, Double8);
        blueSum += __builtin_convertvector(blue, Double8);
    }
    std::array<glm::dvec3, 8> means;
    for (int lane = 0; lane < 8; ++lane)
        means[static_cast<std::size_t>(lane)] = glm::dvec3(redSum[lane], greenSum[lane], blueSum[lane]) / weightSum[lane];
    return means;
}

formats::Result<void> check(const formats::Environment& environment, const IrradianceOptions& options) {
    LC_CHECK(checkShape(environment, "irradiance"));
    if (options.size < 1 || options.size > 1024)
        return formats::failure(formats::ErrorCode::InvalidRequest, "irradiance, size",
                                "found " + std::to_string(options.size) + ", expected 1 to 1024");
    if (options.cellsPerSide < 4 || options.cellsPerSide > 128 || (options.cellsPerSide & (options.cellsPerSide - 1)) != 0)
        return formats::failure(formats::ErrorCode::InvalidRequest, "irradiance, cells per side",
                                "found " + std::to_string(options.cellsPerSide) + ", expected a power of two, 4 to 128");
    if (!(options.wrap >= 0 && options.wrap <= 1))
        return formats::failure(formats::ErrorCode::InvalidRequest, "irradiance, wrap",
                                "found " + std::to_string(options.wrap) + ", expected 0 to 1");
    return {};
}

}  // namespace

formats::Result<formats::Image<glm::vec3>> irradianceCubemap(const formats::Environment& environment, const IrradianceOptions& options) {
    if (const formats::Result<void> checked = check(environment, options); !checked) return tl::make_unexpected(checked.error());
    const MomentTree tree = buildMomentTree(environment, kFinestCellWidth, kFinestCellWidth);
    const std::vector<Entry> entries = Gatherer(tree, options.cellsPerSide).entries();
    formats::Image<glm::vec3> strip(options.size, 6 * options.size);
    const int count = static_cast<int>(strip.texels().size());
    for (int first = 0; first < count; first += 8) {
        std::array<glm::vec3, 8> normals;
        for (int lane = 0; lane < 8; ++lane) {
            const int texel = std::min(first + lane, count - 1), row = texel / options.size;
            normals[static_cast<std::size_t>(lane)] =
                glm::vec3(lighting::cubeTexelDirection(row / options.size, texel % options.size, row % options.size, options.size));
        }
        const std::array<glm::dvec3, 8> means = meansOf(entries, normals, static_cast<float>(options.wrap));
        for (int lane = 0; lane < std::min(8, count - first); ++lane)
            for (int channel = 0; channel < 3; ++channel)
                strip.texels()[static_cast<std::size_t>(first + lane)][channel] =
                    static_cast<float>(std::clamp(means[static_cast<std::size_t>(lane)][channel], 0.0, 1.0) * tree.brightest);
    }
    return strip;
}

}  // namespace lightcook::fit
