#include "verify/cubemap.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "lighting/cube.h"
#include "lighting/sphere.h"

namespace lightcook::verify {
namespace {

constexpr int kTexels = 96;
constexpr double kDarkest = 0.02;       ///< smallest denominator of an error, relative to the mean radiance
constexpr double kLeastWeight = 1e-12;  ///< a place with a smaller sum of weights faces the centre of no texel [sr]

struct Place {
    glm::dvec3 normal;
    glm::dvec3 cooked, reference{0};
    double weight = 0;
};

/// Adds one source texel to every reference.
void addLight(std::vector<Place>& places, double wrap, const glm::dvec3& direction, double solidAngle, const glm::dvec3& radiance) {
    for (Place& place : places) {
        const double weight = std::max(0.0, glm::dot(place.normal, direction) + wrap) * solidAngle;
        place.weight += weight;
        place.reference += weight * radiance;
    }
}

/// Returns the solid angles of the texels of a face [sr], row by row.
std::vector<double> faceSolidAngles(int size) {
    std::vector<double> solidAngles;
    for (int i = 0; i < size * size; ++i) solidAngles.push_back(lighting::cubeTexelSolidAngle(i % size, i / size, size));
    return solidAngles;
}

void addStrip(std::vector<Place>& places, double wrap, const formats::Image<glm::vec3>& texels) {
    const int size = texels.width();
    const std::vector<double> solidAngles = faceSolidAngles(size);
    for (int y = 0; y < texels.height(); ++y)
        for (int x = 0; x < size; ++x)
            addLight(places, wrap, lighting::cubeTexelDirection(y / size, x, y % size, size),
                     solidAngles[static_cast<std::size_t>(y % size * size + x)], glm::dvec3(texels.at(x, y)));
}

/// Prefix sums over the columns of a panorama's row: of L, L sin(psi) and L cos(psi). The direction of a texel at azimuth psi is
/// (across sin(psi), up, -across cos(psi)), so n.l + w is a sinusoid of psi that is positive over a single arc. The sum over an arc is the
/// difference of two prefix sums: the exact sum over the row's texels in a few operations.
class RowPrefixes {
public:
    explicit RowPrefixes(int width) : width_(static_cast<std::size_t>(width)), sums_(width_ + 1) {
        for (std::size_t x = 0; x < width_; ++x) {
            const glm::dvec3 direction = lighting::directionFromEquirectangular({(static_cast<double>(x) + 0.5) / width, 0.5});
            azimuths_.push_back({direction.x, -direction.z});
            sums_[x + 1].turn = sums_[x].turn + azimuths_[x];
        }
    }
    void setRow(const glm::vec3* texels) {
        for (std::size_t x = 0; x < width_; ++x) {
            const glm::dvec3 radiance(texels[x]);
            const Sums& before = sums_[x];
            Sums& after = sums_[x + 1];
            after.light = before.light + radiance;
            after.sine = before.sine + azimuths_[x].x * radiance;
            after.cosine = before.cosine + azimuths_[x].y * radiance;
        }
    }
    /// Adds `constant + sine sin(psi) + cosine cos(psi)` times L over all columns where it is positive.
    void addPositive(double constant, double sine, double cosine, double solidAngle, Place& place) const {
        const double swing = glm::length(glm::dvec2(sine, cosine));
        if (constant <= -swing) return;
        if (constant >= swing) return add(0, width_, constant, sine, cosine, solidAngle, place);
        // Column x has psi = 2 pi (x + 0.5) / width - pi. A full turn is added to avoid negative columns before the seam.
        const double middle = std::atan2(sine, cosine) + 3 * std::numbers::pi, reach = std::acos(-constant / swing);
        const double columns = static_cast<double>(width_) / (2 * std::numbers::pi);
        const double begin = std::ceil((middle - reach) * columns - 0.5), end = std::floor((middle + reach) * columns - 0.5) + 1;
        if (end <= begin) return;
        const std::size_t first = static_cast<std::size_t>(begin) % width_,
                          last = first + std::min(width_, static_cast<std::size_t>(end - begin));
        add(first, std::min(last, width_), constant, sine, cosine, solidAngle, place);
        if (last > width_) add(0, last - width_, constant, sine, cosine, solidAngle, place);
    }

private:
    struct Sums {
        glm::dvec3 light{0}, sine{0}, cosine{0};
        glm::dvec2 turn{0};  ///< part of sine and cosine, without the constant
    };
    void add(std::size_t first, std::size_t last, double constant, double sine, double cosine, double solidAngle, Place& place) const {
        const Sums &a = sums_[first], &b = sums_[last];
        const glm::dvec2 turn = b.turn - a.turn;
        place.weight += solidAngle * (constant * static_cast<double>(last - first) + sine * turn.x + cosine * turn.y);
        place.reference += solidAngle * (constant * (b.light - a.light) + sine * (b.sine - a.sine) + cosine * (b.cosine - a.cosine));
    }

    std::size_t width_;
    std::vector<glm::dvec2> azimuths_;  ///< [column], sine and cosine of psi
    std::vector<Sums> sums_;            ///< [column], over all columns before it
};

void addPanorama(std::vector<Place>& places, double wrap, const formats::Image<glm::vec3>& texels) {
    const int width = texels.width(), height = texels.height();
    RowPrefixes prefixes(width);
    for (int y = 0; y < height; ++y) {
        prefixes.setRow(texels.view().row(y));
        const double solidAngle = lighting::equirectangularTexelSolidAngle(y, width, height);
        const glm::dvec3 middle = lighting::directionFromEquirectangular({0.5, (y + 0.5) / height});  // psi = 0
        for (Place& place : places)
            prefixes.addPositive(place.normal.y * middle.y + wrap, place.normal.x * -middle.z, place.normal.z * middle.z, solidAngle,
                                 place);
    }
}

/// Returns the mean radiance over sphere and channels.
double meanOf(const formats::Environment& environment) {
    const formats::Image<glm::vec3>& texels = environment.texels;
    const int width = texels.width(), height = texels.height();
    const bool isPanorama = environment.projection == formats::Environment::Projection::Equirectangular;
    const std::vector<double> solidAngles = isPanorama ? std::vector<double>() : faceSolidAngles(width);
    double all = 0;
    for (int y = 0; y < height; ++y) {
        const double rowSolidAngle = isPanorama ? lighting::equirectangularTexelSolidAngle(y, width, height) : 0;
        for (int x = 0; x < width; ++x) {
            const glm::dvec3 radiance(texels.at(x, y));
            all += (isPanorama ? rowSolidAngle : solidAngles[static_cast<std::size_t>(y % width * width + x)]) *
                   (radiance.x + radiance.y + radiance.z);
        }
    }
    return all / 3 / (4 * std::numbers::pi);
}

}  // namespace

IrradianceFigures compareIrradiance(std::span<const formats::Image<glm::vec4>> faces, float range, double wrap,
                                    const formats::Environment& environment) {
    assert(faces.size() == 6);
    const int size = faces[0].width(), count = 6 * size * size;
    std::vector<Place> places;
    for (int i = 0; i < std::min(kTexels, count); ++i) {
        const int texel = static_cast<int>(static_cast<long long>(i) * count / std::min(kTexels, count));
        const int face = texel / (size * size), y = texel / size % size, x = texel % size;
        const glm::vec4& stored = faces[static_cast<std::size_t>(face)].at(x, y);
        places.push_back({lighting::cubeTexelDirection(face, x, y, size), static_cast<double>(range) * glm::dvec3(stored)});
    }
    if (environment.projection == formats::Environment::Projection::Equirectangular)
        addPanorama(places, wrap, environment.texels);
    else
        addStrip(places, wrap, environment.texels);
    const double floor = kDarkest * meanOf(environment);
    IrradianceFigures figures;
    figures.texelCount = static_cast<int>(places.size());
    double squares = 0, references = 0;
    for (const Place& place : places) {
        if (!(place.weight > kLeastWeight)) continue;  // no reference
        for (int channel = 0; channel < 3; ++channel) {
            const double reference = place.reference[channel] / place.weight;
            const double error = std::abs(place.cooked[channel] - reference);
            if (!std::isfinite(error)) {
                figures.relRms = figures.worst = std::numeric_limits<double>::max();
                return figures;
            }
            squares += error * error;
            references += reference * reference;
            if (error > 0) figures.worst = std::max(figures.worst, error / (reference + floor));
        }
    }
    figures.relRms = squares > 0 ? std::sqrt(squares / references) : 0;
    return figures;
}

}  // namespace lightcook::verify
