#include "formats/image/envmap.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lightcook::formats {
namespace {

/// Returns the place among n texels from edge to edge, 0 to n - 1, of texel i of n whose centres lie half a texel inside.
double placeFromEdge(int i, int n) {
    return (i + 0.5) / n * (n - 1);
}

/// Interpolates between the texels of a part of an image, whose corner is (0, top).
template <class Texel>
Texel bilinear(const Image<Texel>& image, int top, int width, int height, double x, double y) {
    const int left = std::clamp(static_cast<int>(x), 0, std::max(width - 2, 0)),
              above = std::clamp(static_cast<int>(y), 0, std::max(height - 2, 0));
    const int right = std::min(left + 1, width - 1), below = std::min(above + 1, height - 1);
    const auto u = static_cast<float>(x - left), v = static_cast<float>(y - above);
    return (1 - v) * ((1 - u) * image.at(left, top + above) + u * image.at(right, top + above)) +
           v * ((1 - u) * image.at(left, top + below) + u * image.at(right, top + below));
}

template <class Texel>
Image<Texel> fromCube(const Image<Texel>& texels) {
    const int size = texels.width();
    Image<Texel> out(size, texels.height());
    for (int face = 0; face < 6; ++face) {
        const bool isPole = face == 2 || face == 3;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const double u = placeFromEdge(isPole ? x : size - 1 - x, size), v = placeFromEdge(isPole ? size - 1 - y : y, size);
                out.at(x, face * size + y) = bilinear(texels, face * size, size, size, u, v);
            }
    }
    return out;
}

template <class Texel>
Image<Texel> fromPanorama(const Image<Texel>& texels) {
    const int width = texels.width(), height = texels.height();
    Image<Texel> out(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            out.at(x, y) = bilinear(texels, 0, width, height, placeFromEdge((x + width / 2) % width, width), placeFromEdge(y, height));
    return out;
}

template <class Texel>
Image<Texel> resampled(const Image<Texel>& texels, ExrEnvironment environment) {
    return environment == ExrEnvironment::Cube ? fromCube(texels) : fromPanorama(texels);
}

}  // namespace

Result<void> checkEnvironmentShape(int width, int height, ExrEnvironment environment, const Subject& subject) {
    const bool isCube = environment == ExrEnvironment::Cube;
    if (isCube ? height == 6 * width : width == 2 * height) return {};
    return failure(ErrorCode::WrongShape, subject,
                   fmt::format("found {} x {} texels with the attribute envmap \"{}\", expected {}", width, height,
                               isCube ? "cube" : "latlong", isCube ? "1:6 (six faces)" : "2:1 (a panorama)"));
}

Image<glm::vec3> fromExrEnvironment(const Image<glm::vec3>& texels, ExrEnvironment environment) {
    return resampled(texels, environment);
}

Image<glm::vec4> fromExrEnvironment(const Image<glm::vec4>& texels, ExrEnvironment environment) {
    return resampled(texels, environment);
}

}  // namespace lightcook::formats
