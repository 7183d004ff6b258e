#include "formats/bakes/light_encoding.h"

#include <cmath>

#include "formats/srgb_curve.h"

namespace lightcook::formats {
namespace {

constexpr double kRgbmRange = 34.493242, kRgbmExponent = 2.2, kDldrRange = 4.59;

double multiplier(float alpha, LightEncoding encoding) {
    switch (encoding) {
        case LightEncoding::Auto:
        case LightEncoding::None:
        case LightEncoding::Srgb:
            return 1;
        case LightEncoding::Rgbm:
            return kRgbmRange * std::pow(static_cast<double>(alpha), kRgbmExponent);
        case LightEncoding::Dldr:
            return kDldrRange;
    }
    return 1;
}

}  // namespace

glm::vec3 decodedLight(const glm::vec4& stored, LightEncoding encoding) {
    if (encoding == LightEncoding::Auto || encoding == LightEncoding::None) return glm::vec3(stored);
    const double factor = multiplier(stored.a, encoding);
    glm::vec3 light;
    for (int c = 0; c < 3; ++c) light[c] = static_cast<float>(factor * linearFromSrgb(static_cast<double>(stored[c])));
    return light;
}

}  // namespace lightcook::formats
