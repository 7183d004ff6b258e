// Means of the source over the squares of a face's texels: the references of a cubemap's level without a kernel.
//
// Panorama. A meridian crosses the cone of a square in one interval of latitude: each of the four planes through the origin that bound the
// cone cuts a meridian once. Along a meridian the solid angle is the difference of the sines of latitude, so that the sum over the rows
// between the interval's ends is exact. Over longitude it is the midpoint rule, in pieces that end where columns of the source and the
// square do: what is left is smooth, but for kinks where an edge of the square passes from one row to the next.
// Faces. Texels are rectangles in the plane of the face, and parts of them have solid angles in closed form.
//
// All texels of a face at once: in the plane of a side face a meridian is a line u = const, in that of +Y or -Y a ray from the centre. So
// a walk along one meridian crosses the squares of many texels, one after the other, and the rows of the source between them. The sums are
// those of single squares, at a tenth of the time.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <vector>

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

/// Sums over the squares of all texels of a face, by walks along meridians.
class FaceWalk {
public:
    FaceWalk(formats::ImageView<const glm::vec3> texels, int face, int size)
        : texels_(texels), face_(face), size_(size), sums_(size, size), edges_(static_cast<std::size_t>(size) + 1) {
        for (int i = 0; i <= size; ++i) edges_[static_cast<std::size_t>(i)] = 2.0 * i / size - 1;
        for (int row = 0; row <= texels.height; ++row) rowSines_.push_back(std::cos(row * std::numbers::pi / texels.height));
    }
    formats::Image<glm::vec3> means() {
        constexpr int kFirstPole = 2, kSecondPole = 3;
        if (face_ == kFirstPole || face_ == kSecondPole)
            walkPole();
        else
            for (int x = 0; x < size_; ++x) walkColumn(x);
        formats::Image<glm::vec3> means(size_, size_);
        for (int y = 0; y < size_; ++y)
            for (int x = 0; x < size_; ++x) means.at(x, y) = glm::vec3(sums_.at(x, y).mean());
        return means;
    }

private:
    static constexpr int kLines = 64;  ///< at least, over the width of a square

    /// Calls visit(column of the source, longitude, width) for lines that lie evenly between two longitudes and keep to one column each.
    /// Longitude is 0 at -Z; the width is in columns.
    template <class Visit>
    void forEachLine(double first, double last, int lineCount, Visit visit) const {
        const double columnsPerRadian = texels_.width / (2 * std::numbers::pi);
        const double begin = (first + std::numbers::pi) * columnsPerRadian, end = (last + std::numbers::pi) * columnsPerRadian;
        for (int column = static_cast<int>(std::floor(begin)); column < end; ++column) {
            const double from = std::max<double>(begin, column), to = std::min<double>(end, column + 1);
            if (!(from < to)) continue;
            const int lines = std::max(1, static_cast<int>(std::ceil(lineCount * (to - from) / (end - begin))));
            const int wrapped = ((column % texels_.width) + texels_.width) % texels_.width;
            for (int line = 0; line < lines; ++line)
                visit(wrapped, (from + (line + 0.5) * (to - from) / lines) / columnsPerRadian - std::numbers::pi, (to - from) / lines);
        }
    }
    /// Returns the row of the source at a sine of latitude.
    int rowAt(double sine) const {
        return std::clamp(static_cast<int>(std::acos(sine) * texels_.height / std::numbers::pi), 0, texels_.height - 1);
    }
    /// Adds the part of a meridian between two sines of latitude to a texel. Parts come from north to south, so the row only grows.
    void add(int x, int y, int column, double high, double low, double width, int& row) {
        WeightedSum& sum = sums_.at(x, y);
        while (high > low) {
            const double below = row + 1 < texels_.height ? std::max(low, rowSines_[static_cast<std::size_t>(row) + 1]) : low;
            sum.add(texels_.at(column, row), width * (high - below));
            high = below;
            if (high > low) ++row;
        }
    }
    /// Side faces: the meridians of a column of texels.
    void walkColumn(int x) {
        const glm::dvec3 middle = lighting::directionFromCube({face_, {0, 0}});
        const double towards = std::atan2(middle.x, -middle.z), left = edges_[static_cast<std::size_t>(x)],
                     right = edges_[static_cast<std::size_t>(x) + 1];
        // A face is seen from inside the cube: to the right, longitudes fall.
        forEachLine(towards - std::atan(right), towards - std::atan(left), kLines, [&](int column, double longitude, double width) {
            const double u = std::tan(towards - longitude), distance = 1 + u * u;
            const auto sineAt = [&](int edge) {
                const double v = edges_[static_cast<std::size_t>(edge)];
                return -v / std::sqrt(distance + v * v);
            };
            double high = sineAt(0);
            int row = rowAt(high);
            for (int y = 0; y < size_; ++y) {
                const double low = sineAt(y + 1);
                add(x, y, column, high, low, width, row);
                high = low;
            }
        });
    }
    /// Faces +Y and -Y: the meridians of the whole circle, each from the centre to the rim, or back on -Y to go from north to south.
    void walkPole() {
        const double pole = lighting::directionFromCube({face_, {0, 0}}).y;
        const int lineCount = static_cast<int>(std::ceil(std::numbers::pi * kLines * size_));  // kLines a texel at distance 1
        std::vector<Crossing> crossings;
        forEachLine(-std::numbers::pi, std::numbers::pi, lineCount, [&](int column, double longitude, double width) {
            const glm::dvec2 ray = lighting::cubeFromDirection({0.5 * std::sin(longitude), pole, -0.5 * std::cos(longitude)}).uv * 2.0;
            findCrossings(ray, crossings);
            const auto sineAt = [&](const Crossing& crossing) { return pole / std::sqrt(1 + crossing.radius * crossing.radius); };
            int row = rowAt(pole > 0 ? 1.0 : sineAt(crossings.back()));
            for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
                const std::size_t part = pole > 0 ? i : crossings.size() - 2 - i;
                const Crossing &near = crossings[part], &far = crossings[part + 1];
                if (pole > 0)
                    add(near.x, near.y, column, sineAt(near), sineAt(far), width, row);
                else
                    add(near.x, near.y, column, sineAt(far), sineAt(near), width, row);
            }
        });
    }
    /// A ray from the centre enters texel (x, y) at this radius. The last crossing is the rim.
    struct Crossing {
        double radius;
        int x, y;
    };
    void findCrossings(const glm::dvec2& ray, std::vector<Crossing>& crossings) const {
        crossings.clear();
        const auto first = [&](double slope) { return slope >= 0 ? size_ / 2 : (size_ - 1) / 2; };
        glm::ivec2 texel(first(ray.x), first(ray.y));
        crossings.push_back({0, texel.x, texel.y});
        const auto edgeAfter = [&](int axis) {
            const double slope = ray[axis];
            if (slope == 0) return std::numeric_limits<double>::infinity();
            return edges_[static_cast<std::size_t>(texel[axis] + (slope > 0 ? 1 : 0))] / slope;
        };
        while (true) {
            const glm::dvec2 next(edgeAfter(0), edgeAfter(1));
            const int axis = next.x <= next.y ? 0 : 1;
            const glm::ivec2 from = texel;
            texel[axis] += ray[axis] > 0 ? 1 : -1;
            if (texel[axis] < 0 || texel[axis] >= size_) {
                crossings.push_back({next[axis], from.x, from.y});
                return;
            }
            crossings.push_back({next[axis], texel.x, texel.y});
        }
    }

    formats::ImageView<const glm::vec3> texels_;
    int face_, size_;
    formats::Image<WeightedSum> sums_;
    std::vector<double> edges_;     ///< of the texels, in the plane of the face
    std::vector<double> rowSines_;  ///< sines of latitude of the edges of the source's rows
};

}  // namespace

formats::Image<glm::vec3> CubemapReference::footprintMeans(int face, int size) const {
    const formats::ImageView<const glm::vec3> texels = environment_.texels.view();
    if (isPanorama_) return FaceWalk(texels, face, size).means();
    formats::Image<glm::vec3> means(size, size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            means.at(x, y) = glm::vec3(faceMean(texels, {{face, {(2.0 * x + 1) / size - 1, (2.0 * y + 1) / size - 1}}, 1.0 / size}));
    return means;
}

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
