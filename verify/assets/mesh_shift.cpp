#include "verify/mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <vector>

#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "verify/assets/surface_quad.h"
#include "verify/error/visible_metric.h"

namespace lightcook::verify {
namespace {

using lighting::ShRgb;

struct Quad {
    std::array<const ShRgb*, 4> corners;  ///< 00, 10, 01, 11

    ShRgb at(double s, double t) const {
        const std::array<double, 4> weights = {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
        ShRgb result{};
        for (std::size_t corner = 0; corner < 4; ++corner)
            for (std::size_t i = 0; i < lighting::kShCount; ++i) result[i] += static_cast<float>(weights[corner]) * (*corners[corner])[i];
        return result;
    }
};

glm::vec3 exitRadiance(const ShRgb& sh, const glm::vec3& normal) {
    return lighting::lambertExitRadiance(sh, normal, glm::vec3(1)).value;
}

/// Returns sum_l factor_l |band l| for one channel.
double weightedBands(const ShRgb& sh, int channel, const lighting::ShBands& factors) {
    std::array<double, 3> squares{};
    for (std::size_t i = 0; i < lighting::kShCount; ++i) {
        const double value = static_cast<double>(sh[i][channel]);
        squares[static_cast<std::size_t>(lighting::kShBand[i])] += value * value;
    }
    return factors[0] * std::sqrt(squares[0]) + factors[1] * std::sqrt(squares[1]) + factors[2] * std::sqrt(squares[2]);
}

lighting::ShBands valueFactors() {
    lighting::ShBands factors{};
    for (std::size_t l = 0; l < 3; ++l)
        factors[l] = lighting::kExitRadianceBands[l] * std::sqrt((2.0 * static_cast<double>(l) + 1) / (4 * std::numbers::pi));
    return factors;
}

lighting::ShBands gradientFactors() {
    lighting::ShBands factors = valueFactors();
    for (std::size_t l = 0; l < 3; ++l) factors[l] *= std::sqrt(static_cast<double>(l * (l + 1)));
    return factors;
}

/// Upper bounds of the change of a channel of a quad: per texel across, per texel down, per radian.
struct Slopes {
    double across = 0, down = 0, turn = 0;
};
Slopes slopesOf(const Quad& quad, int channel) {
    static const lighting::ShBands value = valueFactors(), gradient = gradientFactors();
    const auto difference = [&](std::size_t a, std::size_t b) {
        ShRgb result;
        for (std::size_t i = 0; i < lighting::kShCount; ++i) result[i] = (*quad.corners[a])[i] - (*quad.corners[b])[i];
        return weightedBands(result, channel, value);
    };
    Slopes slopes{std::max(difference(1, 0), difference(3, 2)), std::max(difference(2, 0), difference(3, 1)), 0};
    for (const ShRgb* corner : quad.corners) slopes.turn = std::max(slopes.turn, weightedBands(*corner, channel, gradient));
    return slopes;
}

double boundOf(const Quad& quad, int channel, const MeshShift& shift, double key) {
    const Slopes slopes = slopesOf(quad, channel);
    const double largest = shift.uTexels * slopes.across + shift.vTexels * slopes.down + shift.normalRadians * slopes.turn;
    return largest > 0 ? largest / (lighting::kLocalErrorFloor * key) : 0.0;
}

Quad quadAt(const formats::LightMapStrip& strip, int x, int y) {
    return {{&strip.sh.at(x, y), &strip.sh.at(x + 1, y), &strip.sh.at(x, y + 1), &strip.sh.at(x + 1, y + 1)}};
}

/// Calls visit(x, y, quad, normal of its first texel) for each quad that holds a surface.
template <class Visit>
void forEachQuad(const formats::LightMapStrip& strip, int firstRow, int rowCount, Visit visit) {
    const int lastRow = std::min(firstRow + rowCount, strip.firstRow + strip.sh.height() - 1);
    for (int row = firstRow; row < lastRow; ++row) {
        const int y = row - strip.firstRow;
        for (int x = 0; x + 1 < strip.sh.width(); ++x) {
            if (!holdsSurface(strip, x, y)) continue;
            visit(x, row, quadAt(strip, x, y), glm::dvec3(strip.normal.at(x, y)));
        }
    }
}

/// Calls visit(normal, result) for the centre of a quad, moved by the whole shift into each of four directions, its normal turned about
/// two axes.
template <class Visit>
void forEachShifted(const Quad& quad, const glm::dvec3& normal, const MeshShift& shift, Visit visit) {
    const double s = std::min(shift.uTexels, 0.5), t = std::min(shift.vTexels, 0.5);
    const glm::dmat3 frame = lighting::worldFromTangentFrame(normal);
    for (int corner = 0; corner < 4; ++corner) {
        const double signS = corner % 2 == 0 ? -1 : 1, signT = corner < 2 ? -1 : 1;
        const glm::dvec3 turned =
            glm::normalize(normal + std::tan(shift.normalRadians) * (signS * frame[0] + signT * frame[1]) / std::numbers::sqrt2);
        visit(turned, exitRadiance(quad.at(0.5 + signS * s, 0.5 + signT * t), glm::vec3(turned)));
    }
}

/// Slopes of the quads of some rows, by channel.
class SlopeField {
public:
    /// rows of `strip`, as far as it has them
    SlopeField(const formats::LightMapStrip& strip, int firstRow, int rowCount)
        : first_(std::max(firstRow, strip.firstRow)),
          width_(strip.sh.width() - 1),
          height_(std::max(0, std::min(firstRow + rowCount, strip.firstRow + strip.sh.height() - 1) - first_)),
          slopes_(static_cast<std::size_t>(std::max(0, width_)) * static_cast<std::size_t>(height_)) {
        forEachQuad(strip, first_, height_, [&](int x, int y, const Quad& quad, const glm::dvec3&) {
            for (int channel = 0; channel < 3; ++channel) slopes_[index(x, y)][static_cast<std::size_t>(channel)] = slopesOf(quad, channel);
        });
    }
    /// Returns the largest slopes of a quad and those around it; others, of no surface, count as level.
    std::array<Slopes, 3> around(int x, int y) const {
        std::array<Slopes, 3> out;
        for (int j = std::max(y - 1, first_); j < std::min(y + 2, first_ + height_); ++j)
            for (int i = std::max(x - 1, 0); i < std::min(x + 2, width_); ++i)
                for (std::size_t c = 0; c < 3; ++c) {
                    const Slopes& each = slopes_[index(i, j)][c];
                    out[c] = {std::max(out[c].across, each.across), std::max(out[c].down, each.down), std::max(out[c].turn, each.turn)};
                }
        return out;
    }

private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y - first_) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    int first_, width_, height_;
    std::vector<std::array<Slopes, 3>> slopes_;
};

/// Returns the range of the light of a quad at the normals of its texels.
Intervals lightOf(const formats::LightMapStrip& strip, int x, int y) {
    Intervals out;
    const Quad quad = quadAt(strip, x, y);
    std::array<glm::vec3, 4> seen;
    std::size_t count = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const glm::vec3& normal = strip.normal.at(x + corner % 2, y + corner / 2);
        if (std::find(seen.begin(), seen.begin() + static_cast<std::ptrdiff_t>(count), normal) ==
            seen.begin() + static_cast<std::ptrdiff_t>(count))
            seen[count++] = normal;
    }
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t corner = 0; corner < 4; ++corner) {
            const glm::dvec3 light(exitRadiance(*quad.corners[corner], seen[i]));
            for (int c = 0; c < 3; ++c) {
                Interval& range = out[static_cast<std::size_t>(c)];
                range = i == 0 && corner == 0 ? Interval{light[c], light[c]} : hullOf(range, {light[c], light[c]});
            }
        }
    return out;
}

/// Returns the shift of light: it moves with the UVs and with the surface.
MeshShift shiftOfLight(const MeshShift& shift, double positionTexels) {
    return {shift.uTexels + positionTexels, shift.vTexels + positionTexels, shift.normalRadians};
}

/// Returns the signed double area of a triangle in the plane.
double doubleArea(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// A triangle primitive of which positions and light-map UVs are known.
struct LitMesh {
    const formats::TriangleMesh* mesh;
    const formats::MeshAttribute *position, *lightMapUv;

    explicit LitMesh(const formats::TriangleMesh* of) : mesh(of), position(of->find("POSITION")), lightMapUv(of->find("TEXCOORD_1")) {}
    explicit operator bool() const { return position != nullptr && lightMapUv != nullptr; }
    glm::dvec3 positionOf(std::size_t corner) const { return position->at(mesh->indices[corner]); }
    glm::dvec2 uvOf(std::size_t corner) const { return lightMapUv->at(mesh->indices[corner]); }
    /// Returns true if a UV lies in the triangle or on its rim.
    bool isInside(std::size_t triangle, const glm::dvec2& uv) const {
        const glm::dvec2 a = uvOf(3 * triangle), b = uvOf(3 * triangle + 1), c = uvOf(3 * triangle + 2);
        const double first = doubleArea(a, b, uv), second = doubleArea(b, c, uv), third = doubleArea(c, a, uv);
        return doubleArea(a, b, c) != 0 && ((first >= 0 && second >= 0 && third >= 0) || (first <= 0 && second <= 0 && third <= 0));
    }
};

}  // namespace

void addMeshShiftErrors(const formats::LightMapStrip& strip, int firstRow, int rowCount, const MeshShift& shift, double key,
                        ErrorAccumulator& errors, const MeshShiftSeen& seen) {
    forEachQuad(strip, firstRow, rowCount, [&](int x, int y, const Quad& quad, const glm::dvec3& normal) {
        const glm::vec3 reference = exitRadiance(quad.at(0.5, 0.5), glm::vec3(normal));
        const auto at = [&](int channel, const glm::dvec3& direction) {
            ErrorPlace place;
            place.x = x + 0.5;
            place.y = y + 0.5;
            place.channel = channel;
            place.normal = direction;
            return place;
        };
        forEachShifted(quad, normal, shift, [&](const glm::dvec3& turned, const glm::vec3& result) {
            if (seen) seen(x, y, reference, result);
            for (int channel = 0; channel < 3; ++channel)
                errors.add(static_cast<double>(reference[channel]), static_cast<double>(result[channel]),
                           [&] { return at(channel, turned); });
        });
        for (int channel = 0; channel < 3; ++channel) {
            ErrorPlace place = at(channel, normal);
            place.local = boundOf(quad, channel, shift, key);
            errors.addBound(place.local, place);
        }
    });
}

void addMeshShiftVisible(const formats::LightMapStrip& strip, int firstRow, int rowCount, const MeshShift& shift, double positionTexels,
                         VisiblePairs& errors) {
    const MeshShift seen = shiftOfLight(shift, positionTexels);
    forEachQuad(strip, firstRow, rowCount, [&](int x, int y, const Quad& quad, const glm::dvec3& normal) {
        const glm::dvec3 reference(exitRadiance(quad.at(0.5, 0.5), glm::vec3(normal)));
        forEachShifted(quad, normal, seen, [&](const glm::dvec3& turned, const glm::vec3& result) {
            errors.add(reference, glm::dvec3(result), {.x = x + 0.5, .y = y + 0.5, .normal = turned});
        });
    });
}

void addMeshShiftVisibleBound(const formats::LightMapStrip& strip, int firstRow, int rowCount, const MeshShift& shift,
                              double positionTexels, const Viewing& viewing, VisiblePairs& errors) {
    constexpr double kRounding = 1e-5;  // of the samples' floats, relative to the light
    const MeshShift seen = shiftOfLight(shift, positionTexels);
    const VisibleMetric metric(viewing, 1);
    // Beyond the quads around it nothing is known of a place's light.
    const bool isNear = seen.uTexels <= 1 && seen.vTexels <= 1;
    const SlopeField slopes(strip, firstRow - 1, rowCount + 2);
    double largest = -1;
    glm::ivec2 at(0);
    forEachQuad(strip, firstRow, rowCount, [&](int x, int y, const Quad&, const glm::dvec3&) {
        if (!isNear && largest >= 0) return;
        const std::array<Slopes, 3> steepest = slopes.around(x, y);
        const Intervals reference = lightOf(strip, x, y - strip.firstRow);
        Intervals error, found;
        glm::dvec3 low, off;
        for (int c = 0; c < 3; ++c) {
            const auto channel = static_cast<std::size_t>(c);
            off[c] = seen.uTexels * steepest[channel].across + seen.vTexels * steepest[channel].down +
                     seen.normalRadians * steepest[channel].turn + kRounding * reference[channel].largest();
            low[c] = reference[channel].low;
            error[channel] = {-off[c], off[c]};
            found[channel] = reference[channel] + error[channel];
        }
        if (isNear && metric.cannotExceedCheaply(low, off, largest)) return;
        const double bound = isNear ? metric.bound(reference, found, error) : metric.mostVisible();
        if (!(bound > largest)) return;
        largest = bound;
        at = {x, y};
    });
    if (largest < 0) return;
    // The light at the place is that of its worst sample.
    const Quad quad = quadAt(strip, at.x, at.y - strip.firstRow);
    const glm::dvec3 normal(strip.normal.at(at.x, at.y - strip.firstRow)), reference(exitRadiance(quad.at(0.5, 0.5), glm::vec3(normal)));
    VisiblePlace place{.x = at.x + 0.5, .y = at.y + 0.5, .normal = normal, .reference = reference, .found = reference};
    double farthest = 0;
    forEachShifted(quad, normal, seen, [&](const glm::dvec3& turned, const glm::vec3& result) {
        const double difference = lighting::visibleDifference(reference, glm::dvec3(result), viewing.display, viewing.bt2020FromWorking);
        if (!(difference > farthest)) return;
        farthest = difference;
        place.normal = turned;
        place.found = glm::dvec3(result);
    });
    errors.addBound(largest, place);
}

double texelsPerUnit(std::span<const formats::TriangleMesh* const> meshes, int width, int height) {
    const glm::dvec2 size(width, height);
    double texels = 0, surface = 0;
    for (const formats::TriangleMesh* mesh : meshes) {
        const LitMesh lit(mesh);
        if (!lit) continue;
        for (std::size_t corner = 0; corner + 2 < mesh->indices.size(); corner += 3) {
            texels += std::abs(doubleArea(size * lit.uvOf(corner), size * lit.uvOf(corner + 1), size * lit.uvOf(corner + 2)));
            const glm::dvec3 first = lit.positionOf(corner);
            surface += glm::length(glm::cross(lit.positionOf(corner + 1) - first, lit.positionOf(corner + 2) - first));
        }
    }
    return surface > 0 ? std::sqrt(texels / surface) : 0;
}

void findTriangle(std::span<const formats::TriangleMesh* const> meshes, int width, int height, VisiblePlace& place) {
    const glm::dvec2 uv((place.x + 0.5) / width, (place.y + 0.5) / height);
    for (std::size_t primitive = 0; primitive < meshes.size(); ++primitive) {
        const LitMesh lit(meshes[primitive]);
        if (!lit) continue;
        for (std::size_t triangle = 0; triangle < lit.mesh->triangleCount(); ++triangle) {
            if (!lit.isInside(triangle, uv)) continue;
            place.triangle = {static_cast<std::int64_t>(primitive), static_cast<std::int64_t>(triangle)};
            return;
        }
    }
}

void MeshShiftBound::add(const formats::LightMapStrip& strip, int firstRow, int rowCount) {
    forEachQuad(strip, firstRow, rowCount, [&](int, int, const Quad& quad, const glm::dvec3& normal) {
        const glm::dvec3 reference(exitRadiance(quad.at(0.5, 0.5), glm::vec3(normal)));
        reference_ += glm::dot(reference, reference);
        for (int channel = 0; channel < 3; ++channel) {
            const Slopes slopes = slopesOf(quad, channel);
            uu_ += slopes.across * slopes.across;
            vv_ += slopes.down * slopes.down;
            nn_ += slopes.turn * slopes.turn;
            uv_ += slopes.across * slopes.down;
            un_ += slopes.across * slopes.turn;
            vn_ += slopes.down * slopes.turn;
        }
    });
}

void MeshShiftBound::merge(const MeshShiftBound& other) {
    uu_ += other.uu_;
    vv_ += other.vv_;
    nn_ += other.nn_;
    uv_ += other.uv_;
    un_ += other.un_;
    vn_ += other.vn_;
    reference_ += other.reference_;
}

double MeshShiftBound::relRms(const MeshShift& shift) const {
    const double u = shift.uTexels, v = shift.vTexels, n = shift.normalRadians;
    const double squares = u * u * uu_ + v * v * vv_ + n * n * nn_ + 2 * (u * v * uv_ + u * n * un_ + v * n * vn_);
    return squares > 0 && reference_ > 0 ? std::sqrt(squares / reference_) : 0;
}

}  // namespace lightcook::verify
