#include "pipeline/assets/cubemap/levels.h"

#include <algorithm>

#include "lighting/cube.h"

namespace lightcook::pipeline {
namespace {

/// Returns the height of the pictures: a row of six faces for each level, one below the other.
int shownRows(const verify::CookedCubemap& map) {
    int rows = 0;
    for (std::size_t mip = 0; mip < map.mips.size() && mip < CubemapLevels::kShownMips; ++mip) rows += map.mips[mip].faces[0].width();
    return rows;
}

}  // namespace

CubemapLevels::CubemapLevels(const verify::CookedCubemap& map, const formats::Environment& source,
                             const verify::CubemapReference& reference, double key, const std::optional<verify::Viewing>& viewing)
    : map_(map),
      reference_(reference),
      key_(key),
      viewing_(viewing),
      faces_(6 * map.mips.size()),
      preview_(6 * map.mips[0].faces[0].width(), shownRows(map), key) {
    constexpr int kRows = 4;
    for (int mip = 0; mip < static_cast<int>(map.mips.size()); ++mip) {
        const int size = sizeOf(mip);
        const double m = map.mips[static_cast<std::size_t>(mip)].m;
        Level level;
        level.references = formats::Image<glm::vec3>(size, 6 * size);
        const bool hasOther = !levels_.empty() && levels_.back().light;
        if (m > 0) level.light.emplace(source, m, map.lobe, hasOther ? &*levels_.back().light : nullptr);
        levels_.push_back(std::move(level));
        const int rows = m > 0 ? kRows : size;
        for (int face = 0; face < 6; ++face)
            for (int row = 0; row < size; row += rows) tasks_.push_back({mip, face, row, std::min(rows, size - row)});
    }
}

void CubemapLevels::run(std::size_t index) {
    const Task& task = tasks_[index];
    Level& level = levels_[static_cast<std::size_t>(task.mip)];
    const int size = sizeOf(task.mip);
    if (!level.light) {
        const formats::Image<glm::vec3> means = reference_.footprintMeans(task.face, size);
        std::ranges::copy(means.texels(), &level.references.at(0, task.face * size));
        return;
    }
    for (int y = task.firstRow; y < task.firstRow + task.rowCount; ++y)
        for (int x = 0; x < size; ++x)
            level.references.at(x, task.face * size + y) =
                glm::vec3(level.light->towards(lighting::cubeTexelDirection(task.face, x, y, size)));
}

void CubemapLevels::compare(std::size_t index) {
    const int mip = static_cast<int>(index / 6), face = static_cast<int>(index % 6), size = sizeOf(mip);
    const formats::ImageView<const glm::vec3> references = levels_[static_cast<std::size_t>(mip)].references.view().rows(face * size, size);
    faces_[index] = verify::compareCubemapFace(map_, mip, face, references, key_, viewing_);
    if (mip >= kShownMips) return;
    const auto& texels = map_.mips[static_cast<std::size_t>(mip)].faces[static_cast<std::size_t>(face)];
    int shownRow = 0;
    for (int before = 0; before < mip; ++before) shownRow += sizeOf(before);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            if (!preview_.shows(face * size + x, shownRow + y)) continue;
            const glm::dvec3 seen =
                verify::shadeCubemap(map_, mip, glm::vec3(texels.at(x, y)), lighting::cubeTexelDirection(face, x, y, size));
            preview_.set(face * size + x, shownRow + y, references.at(x, y), glm::vec3(seen));
        }
}

std::vector<verify::CubemapErrors> CubemapLevels::errors() const {
    std::vector<verify::CubemapErrors> errors;
    for (std::size_t mip = 0; mip < levels_.size(); ++mip) {
        errors.push_back(*faces_[6 * mip]);
        for (std::size_t face = 1; face < 6; ++face) errors.back().merge(*faces_[6 * mip + face]);
    }
    return errors;
}

glm::dvec3 CubemapLevels::referenceOf(const verify::CubemapSample& sample) const {
    const std::optional<verify::PrefilteredLight>& light = levels_[static_cast<std::size_t>(sample.mip)].light;
    return light ? light->towards(sample.direction) : reference_.footprintMean(sample.direction, sizeOf(sample.mip));
}

}  // namespace lightcook::pipeline
