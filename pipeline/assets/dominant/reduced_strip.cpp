#include "pipeline/assets/dominant/reduced_strip.h"

#include <algorithm>
#include <cassert>
#include <glm/geometric.hpp>

namespace lightcook::pipeline {
namespace {

/// Sets texel (x, y) of `out` to the mean of its covered texels in `strip`.
void reduceTexel(const formats::LightMapStrip& strip, int divisor, int x, int y, formats::LightMapStrip& out) {
    const int endX = std::min((x + 1) * divisor, strip.sh.width()), endY = std::min((y + 1) * divisor, strip.sh.height());
    lighting::ShRgb sum{};
    glm::vec3 normals(0), firstNormal(0, 0, 1);
    int count = 0;
    for (int sourceY = y * divisor; sourceY < endY; ++sourceY)
        for (int sourceX = x * divisor; sourceX < endX; ++sourceX) {
            if (strip.covered.at(sourceX, sourceY) == 0) continue;
            if (count++ == 0) firstNormal = strip.normal.at(sourceX, sourceY);
            for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += strip.sh.at(sourceX, sourceY)[i];
            normals += strip.normal.at(sourceX, sourceY);
        }
    if (count > 0)
        for (auto& coefficient : sum) coefficient /= static_cast<float>(count);
    constexpr float kShortest = 1e-3f;  // normals of opposite charts cancel
    out.sh.at(x, y) = sum;
    out.covered.at(x, y) = count > 0 ? 1 : 0;
    out.normal.at(x, y) = glm::length(normals) > kShortest ? glm::normalize(normals) : firstNormal;
}

}  // namespace

formats::LightMapStrip reducedStrip(const formats::LightMapStrip& strip, int divisor) {
    assert(divisor >= 1 && strip.firstRow % divisor == 0);
    const glm::ivec2 size = reducedSize({strip.sh.width(), strip.sh.height()}, divisor);
    formats::LightMapStrip out;
    out.firstRow = strip.firstRow / divisor;
    out.sh = formats::Image<lighting::ShRgb>(size.x, size.y);
    out.covered = formats::Image<std::uint8_t>(size.x, size.y);
    out.normal = formats::Image<glm::vec3>(size.x, size.y);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) reduceTexel(strip, divisor, x, y, out);
    return out;
}

}  // namespace lightcook::pipeline
