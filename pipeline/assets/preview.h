// Small pictures for the report: reference, cooked, difference.
#pragma once

#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "formats/image.h"
#include "pipeline/assets/results.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Pixels without a surface, or of texels outside charts.
inline constexpr glm::u8vec3 kOutside(40);

/// Returns the pixel of a light: the key, a log-average luminance, is shown as middle grey. A key of 0 shows everything black.
glm::u8vec3 toneMapped(const glm::vec3& radiance, double key);
/// Returns the pixel of a visible error: the colour ramp ends at 10 just noticeable differences.
glm::u8vec3 heatOf(float visible);

/// Three pictures of one asset: reference, cooked, difference. Threads may fill them together, each texel by one thread. Reference and
/// cooked are point samples; the difference is the largest error of all texels under a pixel, so that no error is missed.
class Preview {
public:
    /// Shows every stride-th texel of width x height, so that the longer side has at most kLongestSide pixels.
    /// key  log-average luminance, shown as middle grey; 0 shows everything black
    Preview(int width, int height, double key) : Preview(width, height, key, 0, height) {}
    /// Shows the texels of rows [firstRow, firstRow + rowCount) alone.
    Preview(int width, int height, double key, int firstRow, int rowCount);
    Preview() = default;
    /// Adds the rows of a part of this preview.
    void merge(const Preview& rows);

    int stride() const { return stride_; }
    bool shows(int x, int y) const {
        const int row = y / stride_ - firstPixelRow_;
        return x % stride_ == 0 && y % stride_ == 0 && x / stride_ < reference_.width() && 0 <= row && row < reference_.height();
    }
    /// Sets the light of a texel. Reference and cooked show it only if shows(x, y); the difference counts every texel. It is the local
    /// relative error; the scale ends at 10 %.
    void set(int x, int y, const glm::vec3& reference, const glm::vec3& cooked);
    /// Sets the light of a texel and its visible error; the scale ends at 10 just noticeable differences. A picture has one kind of error.
    void set(int x, int y, const glm::vec3& reference, const glm::vec3& cooked, float visible);

    /// Sets the visible error of a texel at the worst of the normals that a normal map can turn to. The picture shows it if shows(x, y).
    void setAtAnyNormal(int x, int y, float visible);

    /// Writes <name>_reference.png, <name>_cooked.png, <name>_difference.png and, if errors at any normal were set, <name>_any_normal.png
    /// into `folder`/preview, and returns their names relative to `folder`.
    formats::Result<PreviewFiles> write(const std::filesystem::path& folder, const std::string& name) const;

    static constexpr int kLongestSide = 384;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.key_, self.stride_, self.firstRow_, self.rowCount_, self.firstPixelRow_, self.reference_, self.cooked_, self.worst_,
                self.anyNormal_);
    }

private:
    float localError(const glm::vec3& reference, const glm::vec3& cooked) const;
    /// part  of the scale
    void show(int x, int y, const glm::vec3& reference, const glm::vec3& cooked, float part);

    double key_ = 0;
    int stride_ = 1;
    int firstRow_ = 0, rowCount_ = 0;  ///< of the texels
    int firstPixelRow_ = 0;
    formats::Image<glm::u8vec3> reference_, cooked_;
    formats::Image<float> worst_;      ///< error, as a part of the scale
    formats::Image<float> anyNormal_;  ///< visible error; negative where none was set
};

/// Writes the preview and returns the outcome of a verify action with its names.
/// worst  pictures of the worst places, which lie in the action's folder already, as do those of seams
formats::Result<ActionOutcome> outcomeWithPreview(VerifyResult result, const Preview& preview, const ActionContext& context,
                                                  std::vector<WorstPlacePicture> worst = {}, std::vector<RenderedView> seams = {});

}  // namespace lightcook::pipeline
