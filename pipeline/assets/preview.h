// Small pictures for the report: reference, cooked, and where they differ.
#pragma once

#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>

#include "formats/image.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Three pictures of one asset, filled texel by texel from any thread, each texel by one of them. Those of the reference and of what was
/// cooked are points; no error hides between them: the difference is the worst local relative error of all texels under a pixel.
class Preview {
public:
    /// Shows every stride-th texel of width x height, so that the longer side has at most kLongestSide pixels.
    /// key  log-average luminance: what is shown as middle grey; 0 shows everything black
    Preview(int width, int height, double key);

    int stride() const { return stride_; }
    bool shows(int x, int y) const {
        return x % stride_ == 0 && y % stride_ == 0 && x / stride_ < reference_.width() && y / stride_ < reference_.height();
    }
    /// Exit radiance or radiance at any texel: two pictures show those of texels that shows(), the one of the difference the worst of all
    /// that share a pixel.
    void set(int x, int y, const glm::vec3& reference, const glm::vec3& cooked);

    /// Writes <name>_reference.png, <name>_cooked.png, <name>_difference.png under `folder`/preview and names them in `outcome`.
    formats::Result<void> write(const std::filesystem::path& folder, const std::string& name, ActionOutcome& outcome) const;

    static constexpr int kLongestSide = 384;

private:
    void compare(int x, int y, const glm::vec3& reference, const glm::vec3& cooked);
    glm::u8vec3 toneMapped(const glm::vec3& radiance) const;
    static glm::u8vec3 heat(float worst);

    double key_;
    int stride_;
    formats::Image<glm::u8vec3> reference_, cooked_;
    formats::Image<float> worst_;  ///< local relative error
};

}  // namespace lightcook::pipeline
