// The levels of a cooked cubemap against its source: every texel of every level, for the figures and for the pictures.
//
// References come first, rows of texels in any order: means over the squares of a level without a kernel, a face at a time
// (CubemapReference::footprintMeans), and light through the kernel for the others (PrefilteredLight). Faces are compared with them then.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/assets/preview.h"
#include "verify/cubemap.h"

namespace lightcook::pipeline {

class CubemapLevels {
public:
    /// map, source, reference  must outlive this
    /// key                     luminance of the source's mean radiance
    CubemapLevels(const verify::CookedCubemap& map, const formats::Environment& source, const verify::CubemapReference& reference,
                  double key, const std::optional<verify::Viewing>& viewing);

    /// Number of tasks that find references. They may run in any order and on several threads, each once.
    std::size_t taskCount() const { return tasks_.size(); }
    void run(std::size_t task);
    /// Number of faces of all levels, which are compared after all tasks, in any order and on several threads, each once.
    std::size_t faceCount() const { return 6 * levels_.size(); }
    void compare(std::size_t face);

    // After all faces.
    const Preview& preview() const { return preview_; }
    /// Returns the errors of each level.
    std::vector<verify::CubemapErrors> errors() const;
    /// Returns the reference of a direction between texels.
    glm::dvec3 referenceOf(const verify::CubemapSample& sample) const;

    /// The first levels are in the picture.
    static constexpr int kShownMips = 3;

private:
    /// Rows of a face.
    struct Task {
        int mip, face, firstRow, rowCount;
    };
    struct Level {
        std::optional<verify::PrefilteredLight> light;  ///< empty: the level has no kernel
        formats::Image<glm::vec3> references;           ///< six faces, one below the other
    };
    int sizeOf(int mip) const { return map_.mips[static_cast<std::size_t>(mip)].faces[0].width(); }

    const verify::CookedCubemap& map_;
    const verify::CubemapReference& reference_;
    double key_;
    std::optional<verify::Viewing> viewing_;
    std::vector<Level> levels_;
    std::vector<Task> tasks_;
    std::vector<std::optional<verify::CubemapErrors>> faces_;  ///< [6 mip + face]
    Preview preview_;
};

}  // namespace lightcook::pipeline
