// Method. From a strip, a texel is a sum over the rectangles in which it overlaps source texels, each with its exact solid angle.
// From a panorama, a texel is integrated over the azimuth psi: at a given psi it is an interval of y = cos(theta), and since
// dw = d(psi) dy the integral over y is an exact sum over source rows. The outer integral takes three Gauss points for each piece
// between the panorama's meridians.
#include "fit/cubemap/area_resample.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "fit/cubemap/gauss_legendre.h"
#include "lighting/cube.h"

namespace lightcook::fit {
namespace {

using std::numbers::pi;

/// Widest piece of an azimuth integral [rad]: with a coarse source the integrand is curved inside a texel.
constexpr double kWidestPiece = pi / 64;

double rectangleSolidAngle(double u0, double v0, double u1, double v1) {
    return lighting::cubeCornerSolidAngle(u1, v1) - lighting::cubeCornerSolidAngle(u0, v1) - lighting::cubeCornerSolidAngle(u1, v0) +
           lighting::cubeCornerSolidAngle(u0, v0);
}

double wrappedNear(double angle, double centre) {
    return angle + 2 * pi * std::round((centre - angle) / (2 * pi));
}

}  // namespace

AreaResampler::AreaResampler(const formats::Environment& environment) : environment_(environment) {
    if (environment.projection != formats::Environment::Projection::Equirectangular) return;
    const int height = environment.texels.height();
    for (int y = 0; y <= height; ++y) rowEdges_.push_back(y == height ? -1 : std::cos(pi * y / height));
}

glm::dvec3 AreaResampler::mean(int face, int x, int y, int size) const {
    if (environment_.projection == formats::Environment::Projection::CubeStrip) return meanFromStrip(face, x, y, size);
    const glm::dvec2 low(2.0 * x / size - 1, 2.0 * y / size - 1), high(2.0 * (x + 1) / size - 1, 2.0 * (y + 1) / size - 1);
    // psi = atan2(x, -z) at the centres of the side faces, +X -X (+Y -Y) +Z -Z; u decreases with psi on all four.
    constexpr double kPsiOfFace[6] = {pi / 2, -pi / 2, 0, 0, pi, 0};
    Sum sum;
    if (face == 2 || face == 3) {
        addPolarFace(face == 2, low, high, sum);
    } else {
        addSideFace(kPsiOfFace[face], low, high, sum);
    }
    return sum.flux / sum.solidAngle;
}

glm::dvec3 AreaResampler::meanFromStrip(int face, int x, int y, int size) const {
    const int sourceSize = environment_.texels.width();
    if (sourceSize == size) return glm::dvec3(environment_.texels.at(x, face * size + y));
    const auto firstOf = [&](int i) { return static_cast<int>(static_cast<std::int64_t>(i) * sourceSize / size); };
    const auto endOf = [&](int i) { return static_cast<int>((static_cast<std::int64_t>(i + 1) * sourceSize + size - 1) / size); };
    const auto overlap = [&](int i, int source) {
        return glm::dvec2(std::max(2.0 * i / size, 2.0 * source / sourceSize) - 1,
                          std::min(2.0 * (i + 1) / size, 2.0 * (source + 1) / sourceSize) - 1);
    };
    Sum sum;
    for (int row = firstOf(y); row < endOf(y); ++row) {
        const glm::dvec2 v = overlap(y, row);
        for (int column = firstOf(x); column < endOf(x); ++column) {
            const glm::dvec2 u = overlap(x, column);
            const double solidAngle = rectangleSolidAngle(u.x, v.x, u.y, v.y);
            sum.flux += solidAngle * glm::dvec3(environment_.texels.at(column, face * sourceSize + row));
            sum.solidAngle += solidAngle;
        }
    }
    return sum.flux / sum.solidAngle;
}

/// Adds the integral along a meridian. A texel is an interval of y = cos(theta) there and dw = d(psi) dy, so that it is a sum over rows.
void AreaResampler::addMeridian(double psi, double weight, double yLow, double yHigh, Sum& sum) const {
    const formats::Image<glm::vec3>& texels = environment_.texels;
    const int width = texels.width(), height = texels.height();
    int column = static_cast<int>(std::floor((psi / (2 * pi) + 0.5) * width)) % width;
    if (column < 0) column += width;
    int row = std::clamp(static_cast<int>(std::acos(std::clamp(yHigh, -1.0, 1.0)) / pi * height), 0, height - 1);
    while (row > 0 && rowEdges_[static_cast<std::size_t>(row)] < yHigh) --row;
    for (double top = yHigh; row < height && top > yLow; ++row) {
        const double bottom = std::max(yLow, rowEdges_[static_cast<std::size_t>(row) + 1]);
        if (bottom >= top) continue;
        sum.flux += weight * (top - bottom) * glm::dvec3(texels.at(column, row));
        top = bottom;
    }
    sum.solidAngle += weight * (yHigh - yLow);
}

/// Integrates over azimuths: splits [begin, end] at the panorama's meridians and at kWidestPiece, three Gauss points a piece.
/// intervalAt(psi) returns (yLow, yHigh).
template <class Interval>
void AreaResampler::integrateAzimuth(double begin, double end, const Interval& intervalAt, Sum& sum) const {
    static const GaussRule<3> rule = gaussLegendre<3>();
    const double columnWidth = 2 * pi / environment_.texels.width();
    const auto edgeAfter = [&](double psi) { return (std::floor((psi + pi) / columnWidth + 1e-9) + 1) * columnWidth - pi; };
    while (end - begin > 1e-12) {
        const double next = std::min({end, edgeAfter(begin), begin + kWidestPiece});
        const double pieceEnd = end - next < 1e-12 ? end : next;
        for (std::size_t i = 0; i < rule.point.size(); ++i) {
            const double psi = begin + (pieceEnd - begin) * rule.point[i];
            const glm::dvec2 interval = intervalAt(psi);
            if (interval.y > interval.x) addMeridian(psi, (pieceEnd - begin) * rule.weight[i], interval.x, interval.y, sum);
        }
        begin = pieceEnd;
    }
}

void AreaResampler::addSideFace(double psiOfFace, glm::dvec2 low, glm::dvec2 high, Sum& sum) const {
    const auto intervalAt = [&](double psi) {
        const double u = std::tan(psiOfFace - psi), squared = 1 + u * u;
        return glm::dvec2(-high.y / std::sqrt(squared + high.y * high.y), -low.y / std::sqrt(squared + low.y * low.y));
    };
    integrateAzimuth(psiOfFace - std::atan(high.x), psiOfFace - std::atan(low.x), intervalAt, sum);
}

void AreaResampler::addPolarFace(bool north, glm::dvec2 low, glm::dvec2 high, Sum& sum) const {
    // In the plane of the face (x, w) = rho (sin psi, cos psi), w = -v on +Y and v on -Y. A texel lies in one quadrant, or is cut into
    // four.
    if (low.x < 0 && high.x > 0) {
        for (const bool left : {true, false}) {
            for (const bool top : {true, false}) {
                addPolarFace(north, {left ? low.x : 0, top ? low.y : 0}, {left ? 0 : high.x, top ? 0 : high.y}, sum);
            }
        }
        return;
    }
    const glm::dvec2 x(low.x, high.x), w = north ? glm::dvec2(-high.y, -low.y) : glm::dvec2(low.y, high.y);
    const double centre = std::atan2(0.5 * (x.x + x.y), 0.5 * (w.x + w.y));
    std::vector<double> breaks;
    for (const double cornerX : {x.x, x.y}) {
        for (const double cornerW : {w.x, w.y}) {
            if (cornerX != 0 || cornerW != 0) breaks.push_back(wrappedNear(std::atan2(cornerX, cornerW), centre));
        }
    }
    std::sort(breaks.begin(), breaks.end());
    const auto intervalAt = [&](double psi) {
        double rhoLow = 0, rhoHigh = 1e9;
        const auto clip = [&](double slope, double a, double b) {
            if (std::abs(slope) < 1e-15) return;
            rhoLow = std::max(rhoLow, std::min(a / slope, b / slope));
            rhoHigh = std::min(rhoHigh, std::max(a / slope, b / slope));
        };
        clip(std::sin(psi), x.x, x.y);
        clip(std::cos(psi), w.x, w.y);
        const double yNear = 1 / std::sqrt(1 + rhoLow * rhoLow), yFar = 1 / std::sqrt(1 + rhoHigh * rhoHigh);
        return north ? glm::dvec2(yFar, yNear) : glm::dvec2(-yNear, -yFar);
    };
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) integrateAzimuth(breaks[i], breaks[i + 1], intervalAt, sum);
}

}  // namespace lightcook::fit
