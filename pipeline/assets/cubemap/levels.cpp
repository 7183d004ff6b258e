#include "pipeline/assets/cubemap/levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "lighting/cube.h"
#include "pipeline/assets/verdict.h"

namespace lightcook::pipeline {
namespace {

constexpr int kBlockTexels = verify::BlockErrors::kSize;
constexpr double kDarkShare = 0.02;  // of the mean radiance: deviations in the dark are relative to it

/// Returns the height of the pictures: a row of six faces for each level, one below the other.
int shownRows(const verify::CookedCubemap& map) {
    int rows = 0;
    for (std::size_t mip = 0; mip < map.mips.size() && mip < CubemapLevels::kShownMips; ++mip) rows += map.mips[mip].faces[0].width();
    return rows;
}

/// Returns the number of texels of the source, or pieces of them, that a standard deviation of a level's kernel holds at least. Small
/// levels have few texels, and the wide kernels whose tails a lamp behind the horizon decides. GGX's kernel has tails over the whole
/// hemisphere, all of which a large level would sum for each texel.
double piecesPerWidth(int size, lighting::NormalDistribution lobe) {
    if (size <= 16) return 8;
    if (size <= 32) return 4;
    return lobe == lighting::NormalDistribution::Ggx ? 1 : 2;
}

}  // namespace

CubemapLevels::CubemapLevels(const verify::CookedCubemap& map, const formats::Environment& source,
                             const verify::CubemapReference& reference, double key)
    : map_(map), reference_(reference), preview_(6 * map.mips[0].faces[0].width(), shownRows(map), key) {
    for (int mip = 0; mip < static_cast<int>(map.mips.size()); ++mip) {
        const int size = sizeOf(mip);
        const double m = map.mips[static_cast<std::size_t>(mip)].m;
        const verify::BlockErrors face(size, size);
        Level level{{face, face, face, face, face, face}, nullptr, nullptr};
        if (auto reduced =
                m > 0 ? verify::reducedEnvironment(source, std::numbers::sqrt2 * m / piecesPerWidth(size, map.lobe)) : std::nullopt) {
            level.source = std::make_unique<const formats::Environment>(std::move(*reduced));
            level.reference = std::make_unique<const verify::CubemapReference>(*level.source);
        }
        levels_.push_back(std::move(level));
        const int rows = m > 0 ? kBlockTexels : size;
        for (int each = 0; each < 6; ++each)
            for (int row = 0; row < size; row += rows) tasks_.push_back({mip, each, row, std::min(rows, size - row)});
    }
    lights_.resize(tasks_.size());
}

glm::dvec3 CubemapLevels::prefiltered(int mip, const glm::dvec3& direction) const {
    const Level& level = levels_[static_cast<std::size_t>(mip)];
    return (level.reference ? *level.reference : reference_)
        .prefiltered(direction, map_.mips[static_cast<std::size_t>(mip)].m, piecesPerWidth(sizeOf(mip), map_.lobe), map_.lobe);
}

void CubemapLevels::run(std::size_t index) {
    const Task& task = tasks_[index];
    const int size = sizeOf(task.mip);
    formats::Image<glm::vec3> references;
    if (map_.mips[static_cast<std::size_t>(task.mip)].m > 0) {
        references = formats::Image<glm::vec3>(size, task.rowCount);
        for (int y = 0; y < task.rowCount; ++y)
            for (int x = 0; x < size; ++x)
                references.at(x, y) = glm::vec3(prefiltered(task.mip, lighting::cubeTexelDirection(task.face, x, task.firstRow + y, size)));
    } else {
        references = reference_.footprintMeans(task.face, size);
    }
    compareRows(task, references.view(), lights_[index]);
}

void CubemapLevels::compareRows(const Task& task, formats::ImageView<const glm::vec3> references, FaceLight& light) {
    const int size = sizeOf(task.mip);
    const auto& face = map_.mips[static_cast<std::size_t>(task.mip)].faces[static_cast<std::size_t>(task.face)];
    verify::BlockErrors& blocks = levels_[static_cast<std::size_t>(task.mip)].blocks[static_cast<std::size_t>(task.face)];
    int shownRow = 0;
    for (int mip = 0; mip < task.mip && mip < kShownMips; ++mip) shownRow += sizeOf(mip);
    struct BlockLight {
        glm::dvec3 reference{0}, found{0};
        double solidAngle = 0;
    };
    std::vector<BlockLight> row(static_cast<std::size_t>((size + kBlockTexels - 1) / kBlockTexels));
    for (int y = task.firstRow; y < task.firstRow + task.rowCount; ++y) {
        for (int x = 0; x < size; ++x) {
            const glm::dvec3 direction = lighting::cubeTexelDirection(task.face, x, y, size);
            const glm::vec3 truth = references.at(x, y - task.firstRow);
            const glm::dvec3 seen = verify::shadeCubemap(map_, task.mip, glm::vec3(face.at(x, y)), direction);
            const glm::dvec3 error = seen - glm::dvec3(truth);
            blocks.add(x, y, glm::dot(error, error), glm::dot(glm::dvec3(truth), glm::dvec3(truth)));
            const int column = task.face * size + x;
            if (task.mip < kShownMips && preview_.shows(column, shownRow + y)) preview_.set(column, shownRow + y, truth, glm::vec3(seen));
            const double solidAngle = lighting::cubeTexelSolidAngle(x, y, size);
            BlockLight& block = row[static_cast<std::size_t>(x / kBlockTexels)];
            block.reference += solidAngle * glm::dvec3(truth);
            block.found += solidAngle * seen;
            block.solidAngle += solidAngle;
        }
        if ((y + 1) % kBlockTexels != 0 && y + 1 < size) continue;
        for (BlockLight& block : row) {
            for (int channel = 0; channel < 3; ++channel) {
                const double mean = reference_.mean()[channel], reference = block.reference[channel] / block.solidAngle,
                             found = block.found[channel] / block.solidAngle;
                const double deviation = (found - reference) / (reference + kDarkShare * mean), weight = std::min(reference, mean);
                if (!(mean > 0)) continue;
                light.deviation[channel] += block.solidAngle * weight * std::clamp(deviation, -1.0, 1.0);
                light.weight[channel] += block.solidAngle * weight;
            }
            block = {};
        }
    }
}

verify::ErrorPlace CubemapLevels::worstInBlock(int mip, int face, const verify::BlockErrors::Block& block) const {
    const int size = sizeOf(mip);
    const verify::CookedCubemap::Mip& level = map_.mips[static_cast<std::size_t>(mip)];
    verify::ErrorPlace worst;
    for (int y = block.y; y < std::min(block.y + kBlockTexels, size); ++y)
        for (int x = block.x; x < std::min(block.x + kBlockTexels, size); ++x) {
            const glm::dvec3 direction = lighting::cubeTexelDirection(face, x, y, size);
            const glm::dvec3 truth = level.m > 0 ? prefiltered(mip, direction) : reference_.footprintMean(direction, size);
            const glm::dvec3 seen =
                verify::shadeCubemap(map_, mip, glm::vec3(level.faces[static_cast<std::size_t>(face)].at(x, y)), direction);
            for (int channel = 0; channel < 3; ++channel) {
                if (worst.isKnown() && std::abs(seen[channel] - truth[channel]) <= std::abs(worst.found - worst.reference)) continue;
                worst.mip = mip;
                worst.face = face;
                worst.x = x;
                worst.y = y;
                worst.channel = channel;
                worst.normal = direction;
                worst.reference = truth[channel];
                worst.found = seen[channel];
            }
        }
    return worst;
}

void CubemapLevels::check(double maxError, std::vector<verify::Violation>& violations) const {
    // A face that only has the tail of a light source behind it is dark beside the other faces: its relative error does not count.
    constexpr double kLeastShare = 1e-4;
    for (int mip = 0; mip < static_cast<int>(levels_.size()); ++mip) {
        const auto& faces = levels_[static_cast<std::size_t>(mip)].blocks;
        double all = 0;
        for (const verify::BlockErrors& face : faces) all += face.meanSquare() / 6;
        for (int face = 0; face < 6; ++face) {
            if (const auto block = checkBlocks(faces[static_cast<std::size_t>(face)], fmt::format("mip {}, face {}, ", mip, face), maxError,
                                               violations, kLeastShare * all))
                violations.back().at = worstInBlock(mip, face, *block);
        }
        checkLight(mip, maxError, violations);
    }
}

void CubemapLevels::checkLight(int mip, double maxError, std::vector<verify::Violation>& violations) const {
    // Twice the largest deviations of correct cooks, and more (docs/lab/experiments.md, "Faults that averages miss").
    constexpr double kLargestDeviation = 0.15, kErrors = 1.5, kSmallFaces = 3, kFaceFloor = 0.1;
    constexpr int kLargeFace = 32;
    if (sizeOf(mip) < kBlockTexels) return;  // the prefilter moves light between so few texels, for the mean of all
    std::array<FaceLight, 6> faces;
    for (std::size_t i = 0; i < tasks_.size(); ++i)
        if (tasks_[i].mip == mip) faces[static_cast<std::size_t>(tasks_[i].face)] += lights_[i];
    const double allowed = std::max(kLargestDeviation, kErrors * maxError);
    const auto complain = [&](const std::string& place, int channel, double deviation, double limit) {
        violations.push_back({fmt::format("{}, channel {}, light", place, channel),
                              fmt::format("off by {:+.3f} of its light in the mean over blocks", deviation),
                              fmt::format("within {:.3g}", limit)});
    };
    FaceLight all;
    for (const FaceLight& face : faces) all += face;
    for (int channel = 0; channel < 3; ++channel)
        if (const double deviation = all.of(channel, 0); std::abs(deviation) > allowed)
            return complain(fmt::format("mip {}", mip), channel, deviation, allowed);
    const double ofFace = sizeOf(mip) >= kLargeFace ? allowed : kSmallFaces * allowed;
    for (std::size_t face = 0; face < faces.size(); ++face)
        for (int channel = 0; channel < 3; ++channel) {
            const double deviation = faces[face].of(channel, kFaceFloor * reference_.mean()[channel] * 4 * std::numbers::pi / 6);
            if (std::abs(deviation) > ofFace) return complain(fmt::format("mip {}, face {}", mip, face), channel, deviation, ofFace);
        }
}

}  // namespace lightcook::pipeline
