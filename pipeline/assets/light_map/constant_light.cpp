#include "pipeline/assets/light_map/constant_light.h"

#include <algorithm>

namespace lightcook::pipeline {

void ConstantLight::addTexels(std::int64_t count, const lighting::ShRgb& sh, const glm::vec3& normal) {
    if (texels_ == 0) {
        sh_ = sh;
        normal_ = normal;
    }
    hasOneLight_ = hasOneLight_ && sh == sh_;
    hasOneNormal_ = hasOneNormal_ && normal == normal_;
    texels_ += count;
}

void ConstantLight::add(const formats::LightMapStrip& strip) {
    for (int y = 0; y < strip.sh.height(); ++y)
        for (int x = 0; x < strip.sh.width(); ++x)
            if (strip.covered.at(x, y) != 0) addTexels(1, strip.sh.at(x, y), strip.normal.at(x, y));
}

void ConstantLight::merge(const ConstantLight& next) {
    if (next.texels_ == 0) return;
    addTexels(next.texels_, next.sh_, next.normal_);
    hasOneLight_ = hasOneLight_ && next.hasOneLight_;
    hasOneNormal_ = hasOneNormal_ && next.hasOneNormal_;
}

bool ConstantLight::isIsotropic() const {
    return isConstant() && std::all_of(sh_.begin() + 1, sh_.end(), [](const glm::vec3& c) { return c == glm::vec3(0); });
}

}  // namespace lightcook::pipeline
