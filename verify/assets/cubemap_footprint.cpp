// Means of the source over the squares of a face's texels: the references of a cubemap's level without a kernel.
//
// Panorama. A meridian crosses the cone of a square in one interval of latitude: each of the four planes through the origin that bound the
// cone cuts a meridian once. Along a meridian the solid angle is the difference of the sines of latitude, so that the sum over the rows
// between the interval's ends is exact. Over longitude it is the midpoint rule, in pieces that end where columns of the source and the
// square do: what is left is smooth, but for kinks where an edge of the square passes from one row to the next.
// Faces. Texels are rectangles in the plane of the face, and parts of them have solid angles in closed form.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "lighting/cube.h"
#include "lighting/sphere.h"
#include "verify/cubemap.h"

namespace lightcook::verify {
namespace {

/// Sum of radiance over solid angle.
struct WeightedSum {
    glm::dvec3 radiance{0};
    double weight = 0;
    void add(const glm::vec3& texel, double solidAngle) {
        radiance += solidAngle * glm::dvec3(texel);
        weight += solidAngle;
    }
    glm::dvec3 mean() const { return radiance / weight; }
};

/// Square in the plane of a face.
struct Square {
    lighting::CubeCoordinate centre;
    double half;  ///< of its side
    glm::dvec2 low() const { return centre.uv - half; }
    glm::dvec2 high() const { return centre.uv + half; }
};

/// The cone of directions through a square.
class SquareCone {
public:
    explicit SquareCone(const Square& square) {
        const glm::dvec2 low = square.low(), high = square.high();
        const std::array<glm::dvec2, 4> corners = {low, {high.x, low.y}, high, {low.x, high.y}};
        const glm::dvec3 centre = lighting::directionFromCube(square.centre);
        for (std::size_t i = 0; i < 4; ++i) corners_[i] = lighting::directionFromCube({square.centre.face, corners[i]});
        for (std::size_t i = 0; i < 4; ++i) {
            const glm::dvec3 plane = glm::cross(corners_[i], corners_[(i + 1) % 4]);
            planes_[i] = glm::dot(plane, centre) < 0 ? -plane : plane;
        }
        const auto isInside = [&](double pole) { return std::ranges::all_of(planes_, [&](const auto& n) { return pole * n.y >= 0; }); };
        const double middle = longitudeOf(centre);
        if (isInside(1) || isInside(-1)) {
            first_ = middle - std::numbers::pi;
            last_ = middle + std::numbers::pi;
            return;
        }
        // Longitude is monotonous along a great circle, so its extrema are at corners.
        first_ = last_ = middle;
        for (const glm::dvec3& corner : corners_) {
            const double away = std::remainder(longitudeOf(corner) - middle, 2 * std::numbers::pi);
            first_ = std::min(first_, middle + away);
            last_ = std::max(last_, middle + away);
        }
    }
    double firstLongitude() const { return first_; }
    double lastLongitude() const { return last_; }

    struct Sines {
        double low = -1, high = 1;
    };
    /// Returns the sines of the latitudes where a meridian lies inside; low >= high: nowhere.
    Sines crossing(double longitude) const {
        const double x = std::sin(longitude), z = -std::cos(longitude);
        Sines sines;
        for (const glm::dvec3& plane : planes_) {
            // across cos(latitude) + plane.y sin(latitude) >= 0 is a half circle: of the meridian it cuts off the lower or the upper end.
            const double across = plane.x * x + plane.z * z, sine = across / std::hypot(across, plane.y);
            if (plane.y >= 0)
                sines.low = std::max(sines.low, -sine);
            else
                sines.high = std::min(sines.high, sine);
        }
        return sines;
    }

private:
    /// Returns 0 at -Z, as the middle of a panorama.
    static double longitudeOf(const glm::dvec3& direction) { return std::atan2(direction.x, -direction.z); }

    std::array<glm::dvec3, 4> corners_, planes_;
    double first_ = 0, last_ = 0;  ///< [rad]
};

glm::dvec3 panoramaMean(formats::ImageView<const glm::vec3> texels, const Square& square) {
    constexpr int kLines = 64;  // at least, over the width of the square
    const SquareCone cone(square);
    const double columnsPerRadian = texels.width / (2 * std::numbers::pi), rowsPerRadian = texels.height / std::numbers::pi;
    const double first = (cone.firstLongitude() + std::numbers::pi) * columnsPerRadian,
                 last = (cone.lastLongitude() + std::numbers::pi) * columnsPerRadian;
    WeightedSum sum;
    const auto addLine = [&](int column, double longitude, double width) {
        const auto [low, high] = cone.crossing(longitude);
        if (!(low < high)) return;
        const auto rowOf = [&](double sine) { return std::clamp(static_cast<int>(std::acos(sine) * rowsPerRadian), 0, texels.height - 1); };
        double above = high;
        for (int row = rowOf(high), end = rowOf(low); row <= end; ++row) {
            const double below = row == end ? low : std::max(low, std::cos((row + 1) / rowsPerRadian));
            sum.add(texels.at(column, row), width * std::max(above - below, 0.0));
            above = std::min(above, below);
        }
    };
    for (int column = static_cast<int>(std::floor(first)); column < last; ++column) {
        const double begin = std::max<double>(first, column), end = std::min<double>(last, column + 1);
        const int lines = std::max(1, static_cast<int>(std::ceil(kLines * (end - begin) / (last - first))));
        const double step = (end - begin) / lines;
        const int wrapped = ((column % texels.width) + texels.width) % texels.width;
        for (int line = 0; line < lines; ++line)
            addLine(wrapped, (begin + (line + 0.5) * step) / columnsPerRadian - std::numbers::pi, step);
    }
    return sum.mean();
}

/// texels  six faces of a strip; the square lies in its face
glm::dvec3 faceMean(formats::ImageView<const glm::vec3> texels, const Square& square) {
    const int size = texels.width;
    const double scale = 0.5 * size;
    const glm::dvec2 low = glm::clamp((square.low() + 1.0) * scale, 0.0, static_cast<double>(size));
    const glm::dvec2 high = glm::clamp((square.high() + 1.0) * scale, 0.0, static_cast<double>(size));
    WeightedSum sum;
    for (int y = static_cast<int>(low.y); y < high.y; ++y)
        for (int x = static_cast<int>(low.x); x < high.x; ++x) {
            const glm::dvec2 a = glm::max(low, glm::dvec2(x, y)) / scale - 1.0, b = glm::min(high, glm::dvec2(x + 1, y + 1)) / scale - 1.0;
            const auto corner = [](double u, double v) { return lighting::cubeCornerSolidAngle(u, v); };
            sum.add(texels.at(x, square.centre.face * size + y), corner(b.x, b.y) - corner(a.x, b.y) - corner(b.x, a.y) + corner(a.x, a.y));
        }
    return sum.mean();
}

}  // namespace

glm::dvec3 CubemapReference::footprintMean(const glm::dvec3& direction, int size) const {
    constexpr int kPlaces = 128;
    constexpr double kRounding = 1e-9;
    const Square square{lighting::cubeFromDirection(direction), 1.0 / size};
    const formats::ImageView<const glm::vec3> texels = environment_.texels.view();
    if (isPanorama_) return panoramaMean(texels, square);
    const glm::dvec2 farthest = glm::abs(square.centre.uv) + square.half;
    if (std::max(farthest.x, farthest.y) <= 1 + kRounding) return faceMean(texels, square);
    // Around a direction near an edge of the face: looked up at places through directions, since other faces continue it.
    WeightedSum sum;
    const double step = 2 * square.half / kPlaces;
    for (int j = 0; j < kPlaces; ++j)
        for (int i = 0; i < kPlaces; ++i) {
            const glm::dvec2 uv = square.low() + step * (glm::dvec2(i, j) + 0.5);
            const double squared = 1 + glm::dot(uv, uv);
            sum.add(glm::vec3(radianceAt(lighting::directionFromCube({square.centre.face, uv}))), 1 / (squared * std::sqrt(squared)));
        }
    return sum.mean();
}

}  // namespace lightcook::verify
