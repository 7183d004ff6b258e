// The levels of a cooked cubemap against its source: every texel of every level, for the laws on blocks and faces, and for the pictures.
//
// A level without a kernel is a resampling, whose means of the source over all texels of a face come from one pass
// (CubemapReference::footprintMeans). The others are prefiltered from a source whose texels are parts of a standard deviation of
// their kernel, so that a texel costs microseconds. Figures have references of their own, of full accuracy, at the samples of
// verify/cubemap.h.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "pipeline/assets/preview.h"
#include "verify/block_errors.h"
#include "verify/cubemap.h"
#include "verify/violation.h"

namespace lightcook::pipeline {

class CubemapLevels {
public:
    /// map, source, reference  must outlive this
    /// key                     of the pictures
    CubemapLevels(const verify::CookedCubemap& map, const formats::Environment& source, const verify::CubemapReference& reference,
                  double key);

    /// Number of tasks, which may run in any order and on several threads, each once.
    std::size_t taskCount() const { return tasks_.size(); }
    void run(std::size_t task);

    // After all tasks.
    const Preview& preview() const { return preview_; }
    /// Adds a violation for the worst block of each face of a level if its error is over the limit, and for each level whose light as a
    /// whole is, or that of a face (docs/theory/error.md, "Laws beside the figures").
    void check(double maxError, std::vector<verify::Violation>& violations) const;

    /// The first levels are in the picture.
    static constexpr int kShownMips = 3;

private:
    /// Rows of a face.
    struct Task {
        int mip, face, firstRow, rowCount;
    };
    /// Deviations of a face's light from its reference, by channel. The weight of a block is its solid angle times its light, or times the
    /// mean light if that is less: an encoder may miss the block of a small light source, and the face can be right all the same.
    struct FaceLight {
        glm::dvec3 deviation{0}, weight{0};

        FaceLight& operator+=(const FaceLight& other) {
            deviation += other.deviation;
            weight += other.weight;
            return *this;
        }
        /// Returns the mean deviation of a channel; 0 for a black one.
        double of(int channel, double floor) const {
            const double over = weight[channel] + floor;
            return over > 0 ? deviation[channel] / over : 0;
        }
    };
    struct Level {
        std::array<verify::BlockErrors, 6> blocks;
        /// Source of larger texels, and its reference; empty where those of the map serve.
        std::unique_ptr<const formats::Environment> source;
        std::unique_ptr<const verify::CubemapReference> reference;
    };
    int sizeOf(int mip) const { return map_.mips[static_cast<std::size_t>(mip)].faces[0].width(); }
    glm::dvec3 prefiltered(int mip, const glm::dvec3& direction) const;
    void compareRows(const Task& task, formats::ImageView<const glm::vec3> references, FaceLight& light);
    verify::ErrorPlace worstInBlock(int mip, int face, const verify::BlockErrors::Block& block) const;
    void checkLight(int mip, double maxError, std::vector<verify::Violation>& violations) const;

    const verify::CookedCubemap& map_;
    const verify::CubemapReference& reference_;
    std::vector<Level> levels_;
    std::vector<Task> tasks_;
    std::vector<FaceLight> lights_;  ///< [task]
    Preview preview_;
};

}  // namespace lightcook::pipeline
