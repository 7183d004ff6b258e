// Small light maps made of formulas: charts with gaps, lights that vary over them, and hard cases for encoders.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <numbers>

#include "formats/light_map.h"
#include "lighting/sh.h"
#include "lighting/sphere.h"

namespace lightcook::synthetic {

enum class Kind {
    Grey,           ///< radiance 0.5 from everywhere, all covered
    Gradient,       ///< three lights of colours that vary over each chart, gaps between charts
    Spikes,         ///< the same with texels of radiance 65504 strewn in
    NegativeBands,  ///< the same with bands far beyond the bounds of non-negative light
    Night,          ///< the gradient at 1e-5
    Black           ///< no light, all covered
};

inline glm::vec3 chartNormal(int x, int y) {
    return glm::vec3(lighting::fibonacciSphere((x / 20 * 7 + y / 14 * 13) % 64, 64));
}

inline lighting::ShRgb add(lighting::ShRgb a, const lighting::ShRgb& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
    return a;
}

inline lighting::ShRgb constantLight(const glm::vec3& radiance) {
    lighting::ShRgb sh{};
    sh[0] = radiance * std::sqrt(4 * std::numbers::pi_v<float>);
    return sh;
}

inline lighting::ShRgb gradientLight(int x, int y) {
    const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
    lighting::ShRgb sh = constantLight(glm::vec3(0.05f, 0.06f, 0.08f));
    const float shadow = 1 / (1 + std::exp(-(fx - fy) / 3));  // a soft shadow edge along the diagonal
    const glm::vec3 sun = shadow * (2.0f + std::sin(0.11f * fx)) * glm::vec3(1.0f, 0.9f, 0.7f);
    sh = add(sh, lighting::projectDirectional(glm::normalize(glm::vec3(0.5f, 0.7f, 0.2f)), sun));
    const glm::vec3 light = (0.4f + 0.3f * std::cos(0.07f * fy)) * glm::vec3(0.2f, 0.5f, 1.0f);
    sh = add(sh, lighting::projectDirectional(glm::normalize(glm::vec3(-0.6f, 0.1f, 0.4f)), light));
    return sh;
}

inline lighting::ShRgb lightAt(Kind kind, int x, int y) {
    switch (kind) {
        case Kind::Grey:
            return constantLight(glm::vec3(0.5f));
        case Kind::Black:
            return {};
        default:
            break;
    }
    lighting::ShRgb sh = gradientLight(x, y);
    if (kind == Kind::Spikes && (x * 31 + y * 17) % 97 == 0)
        sh = add(sh, lighting::projectDirectional(glm::vec3(0, 1, 0), glm::vec3(65504, 30000, 65504)));
    if (kind == Kind::NegativeBands)
        for (std::size_t i = 1; i < sh.size(); ++i) sh[i] *= (x / 5 + y / 3 + static_cast<int>(i)) % 2 == 0 ? -2.5f : 2.5f;
    if (kind == Kind::Night)
        for (glm::vec3& c : sh) c *= 1e-5f;
    return sh;
}

inline bool isCovered(Kind kind, int x, int y) {
    if (kind == Kind::Grey || kind == Kind::Black) return true;
    return x % 20 < 17 && y % 14 < 11;
}

/// Returns a tangent of a surface, turned about the normal by a tenth of a radian a step; every other one is of a mirrored picture.
inline glm::vec4 tangentOf(const glm::vec3& normal, int step) {
    const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(normal));
    const double angle = 0.1 * step;
    return glm::vec4(glm::vec3(std::cos(angle) * frame[0] + std::sin(angle) * frame[1]), step % 2 == 0 ? 1.0f : -1.0f);
}

/// Returns the rows [firstRow, firstRow + rowCount) of the map.
/// outside  value of the texels between charts
inline formats::LightMapStrip makeBand(Kind kind, int width, int firstRow, int rowCount, float outside = 0) {
    formats::LightMapStrip band;
    band.firstRow = firstRow;
    band.sh = formats::Image<lighting::ShRgb>(width, rowCount);
    band.covered = formats::Image<std::uint8_t>(width, rowCount, 0);
    band.normal = formats::Image<glm::vec3>(width, rowCount, glm::vec3(0, 0, 1));
    band.tangent = formats::Image<glm::vec4>(width, rowCount, glm::vec4(1, 0, 0, 1));
    for (int y = 0; y < rowCount; ++y)
        for (int x = 0; x < width; ++x) {
            if (isCovered(kind, x, firstRow + y)) {
                band.sh.at(x, y) = lightAt(kind, x, firstRow + y);
                band.covered.at(x, y) = 1;
                band.normal.at(x, y) = chartNormal(x, firstRow + y);
                band.tangent.at(x, y) = tangentOf(band.normal.at(x, y), x / 20 + 3 * ((firstRow + y) / 14));
            } else {
                band.sh.at(x, y).fill(glm::vec3(outside));
            }
        }
    return band;
}

/// Returns the rows and `context` more on either side where a map of `height` rows has them.
inline formats::LightMapStrip makeBandWithContext(Kind kind, int width, int height, int firstRow, int rowCount, int context,
                                                  float outside = 0) {
    const int first = std::max(0, firstRow - context), end = std::min(height, firstRow + rowCount + context);
    return makeBand(kind, width, first, end - first, outside);
}

}  // namespace lightcook::synthetic
