// Finds out whether all covered texels of a light map hold the same light.
#pragma once

#include <cstdint>

#include "formats/light_map.h"

namespace lightcook::pipeline {

/// Gathers the light of a map, strip by strip. Parts of a map are merged in the order of their rows.
class ConstantLight {
public:
    void add(const formats::LightMapStrip& strip);
    void merge(const ConstantLight& next);

    std::int64_t texels() const { return texels_; }  ///< covered ones
    /// Returns true if there are covered texels, and their coefficients are equal to the bit.
    bool isConstant() const { return texels_ > 0 && hasOneLight_; }
    bool isBlack() const { return isConstant() && sh_ == lighting::ShRgb{}; }
    /// Returns true if all covered texels have the same normal.
    bool hasOneNormal() const { return texels_ > 0 && hasOneNormal_; }
    /// Returns true if the light comes from every direction alike, so that no normal sees more of it than another.
    bool isIsotropic() const;
    const lighting::ShRgb& sh() const { return sh_; }    ///< of the first covered texel
    const glm::vec3& normal() const { return normal_; }  ///< of the first covered texel

private:
    void addTexels(std::int64_t count, const lighting::ShRgb& sh, const glm::vec3& normal);

    std::int64_t texels_ = 0;
    lighting::ShRgb sh_{};
    glm::vec3 normal_{0, 0, 1};
    bool hasOneLight_ = true, hasOneNormal_ = true;
};

}  // namespace lightcook::pipeline
