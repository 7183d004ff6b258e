#include "verify/cubemap.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>

#include "lighting/area_specular.h"
#include "lighting/cube.h"
#include "lighting/quadratic.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "shaders/lightcook_cpp.h"
#include "verify/assets/random.h"
#include "verify/error/sample_errors.h"
#include "verify/error/visible_metric.h"
#include "verify/texture_unit.h"

namespace lightcook::verify {
namespace {

using formats::Environment;

constexpr int kTileSize = 32;
/// Unnormalized directions of faces are major + u right + v down (the table in lighting/cube.h, as signed axes).
struct FaceAxes {
    glm::dvec3 major, right, down;
};
constexpr FaceAxes kFaceAxes[6] = {{{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
                                   {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
                                   {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}}};

/// Returns exp(max(x, -700)) for x <= 0, to a relative 3e-10: 2^n by its bits, the rest by a Taylor series up to x^8 / 8!. It has no branch
/// and no call, so that loops over it are vectorized.
inline double expOfNegative(double x) {
    constexpr double kRounder = 0x1.8p52;  // a number added to it is rounded to an integer in the lowest bits
    const double scaled = (x < -700 ? -700 : x) * std::numbers::log2e;
    const double shifted = scaled + kRounder, r = (scaled - (shifted - kRounder)) * std::numbers::ln2;
    const double power = std::bit_cast<double>((std::bit_cast<std::uint64_t>(shifted) + 1023) << 52);
    const double even = 1 + r * r * (1.0 / 2 + r * r * (1.0 / 24 + r * r * (1.0 / 720 + r * r * (1.0 / 40320))));
    return power * (even + r * (1 + r * r * (1.0 / 6 + r * r * (1.0 / 120 + r * r * (1.0 / 5040)))));
}

using lighting::NormalDistribution;

/// Returns the unnormalized prefilter kernel D(NoH) c for n = v = r, where NoH is the cosine of half the angle: NoH^2 = (1 + c) / 2,
/// tan^2 = 1 / NoH^2 - 1; 0 behind the plane. GGX: D is 1 / (tan^2 + m^2)^2 / NoH^4.
template <NormalDistribution kLobe>
inline double kernelShape(double cosine, double squaredM) {
    const double c = cosine < 0 ? 0 : cosine, inverse = 2 / (1 + c);
    if constexpr (kLobe == NormalDistribution::Ggx) {
        const double scaled = inverse / (inverse - 1 + squaredM);
        return scaled * scaled * c;
    } else {
        return expOfNegative((1 - inverse) * (1 / squaredM)) * inverse * inverse * c;
    }
}

/// Returns the angle [rad] beyond which the kernel is 0 or below 1e-7 of its peak.
double kernelSupport(double m, NormalDistribution lobe) {
    return lobe == NormalDistribution::Ggx ? 0.5 * std::numbers::pi : std::min(2 * std::atan(4 * m), 0.5 * std::numbers::pi);
}

/// Calls visit(cosine, weight) for the midpoints of even steps in the angle from the kernel's axis, so that narrow lobes are resolved. The
/// weight is the kernel's share of a ring, but for a common factor.
template <class Visit>
void forEachKernelStep(double m, NormalDistribution lobe, int count, Visit visit) {
    const double support = kernelSupport(m, lobe);
    for (int i = 0; i < count; ++i) {
        const double angle = support * (i + 0.5) / count, c = std::cos(angle);
        const double shape = lobe == NormalDistribution::Ggx ? kernelShape<NormalDistribution::Ggx>(c, m * m)
                                                             : kernelShape<NormalDistribution::Beckmann>(c, m * m);
        visit(c, std::sin(angle) * shape);
    }
}

lighting::ShDouble channelOf(const lighting::ShRgb& sh, int channel) {
    lighting::ShDouble coefficients{};
    for (std::size_t i = 0; i < sh.size(); ++i) coefficients[i] = sh[i][channel];
    return coefficients;
}

bool isFinite(const lighting::ShDouble& coefficients, const lighting::ShBands& bands) {
    const auto finite = [](double value) { return std::isfinite(value); };
    return std::all_of(coefficients.begin(), coefficients.end(), finite) && std::all_of(bands.begin(), bands.end(), finite);
}

/// Returns the largest local relative error of a result and a reference in the given ranges. As a function of the reference the error falls
/// up to the result and rises beyond it, so its maximum is at an end of the range.
double largestLocalError(const Interval& reference, const Interval& result, double key) {
    const double floor = lighting::kLocalErrorFloor * key;
    const double above = result.high > reference.low ? (result.high - reference.low) / (reference.low + floor) : 0;
    const double below = reference.high > result.low ? (reference.high - result.low) / (reference.high + floor) : 0;
    return std::max(above, below);
}

/// Returns the range of a channel of the stored texels. Nothing if one is not finite.
std::optional<Interval> storedRange(const CookedCubemap::Mip& mip, int channel) {
    Interval range{std::numeric_limits<double>::max(), -std::numeric_limits<double>::max()};
    for (const auto& face : mip.faces)
        for (const glm::vec4& texel : face.texels()) {
            const auto value = static_cast<double>(texel[channel]);
            if (!std::isfinite(value)) return std::nullopt;
            range.low = std::min(range.low, value);
            range.high = std::max(range.high, value);
        }
    return range;
}

/// Returns the exact extrema of S, 1 if the map is not divided. Nothing if S is not finite.
std::optional<lighting::Extrema> denominatorRange(const CookedCubemap& map, const CookedCubemap::Mip& mip, int channel) {
    lighting::Extrema range{};
    range.minimum = range.maximum = 1;
    if (!map.isDivided) return range;
    const lighting::ShDouble coefficients = channelOf(map.windowedSh, channel);
    if (!isFinite(coefficients, mip.bands)) return std::nullopt;
    return lighting::extremaOnSphere(lighting::sphereQuadratic(coefficients, mip.bands));
}

/// The range of an environment's prefiltered light over all directions. A kernel falls with the angle from its axis. So no light is
/// brighter than that of the brightest texels, sorted around the axis, and none is darker than that of the darkest ones (Hardy and
/// Littlewood's inequality of rearranged functions).
class PrefilteredRange {
public:
    explicit PrefilteredRange(const CubemapReference& reference) : reference_(reference) {
        for (int channel = 0; channel < 3; ++channel) texels_[static_cast<std::size_t>(channel)] = reference.sorted(channel);
    }
    /// m  0: texels as they are
    Intervals of(double m, NormalDistribution lobe) const {
        Intervals out;
        const std::vector<double> shares = m > 0 ? sharesOf(m, lobe) : std::vector<double>();
        for (int channel = 0; channel < 3; ++channel) {
            const double darkest = reference_.smallest()[channel], brightest = reference_.largest()[channel];
            Interval& range = out[static_cast<std::size_t>(channel)];
            range = {darkest, brightest};
            if (!(m > 0)) continue;
            const std::vector<CubemapReference::Weighted>& texels = texels_[static_cast<std::size_t>(channel)];
            const double support = kernelSupport(m, lobe);
            const double low = meanOf(texels.begin(), texels.end(), shares, support),
                         high = meanOf(texels.rbegin(), texels.rend(), shares, support);
            range = {std::max(darkest, brightest - kOutward * (brightest - low)),
                     std::min(brightest, darkest + kOutward * (high - darkest))};
        }
        return out;
    }

private:
    static constexpr int kSteps = 4096;
    /// Covers the quadratures here and of the reference: pieces of an eighth of a kernel's width change its peak by about 0.2 %.
    static constexpr double kOutward = 1.01;

    /// Returns the shares of a kernel within angles of its axis, at even steps up to its support.
    static std::vector<double> sharesOf(double m, NormalDistribution lobe) {
        std::vector<double> shares = {0};
        forEachKernelStep(m, lobe, kSteps, [&](double, double weight) { shares.push_back(shares.back() + weight); });
        for (double& share : shares) share /= shares.back();
        return shares;
    }
    /// Returns the mean of texels, the first ones around the axis.
    template <class Texel>
    static double meanOf(Texel texel, Texel end, const std::vector<double>& shares, double support) {
        double solidAngle = 0, before = 0, sum = 0;
        for (; texel != end && before < 1; ++texel) {
            solidAngle += texel->solidAngle;
            const double step = std::acos(std::max(1 - solidAngle / (2 * std::numbers::pi), -1.0)) / support * kSteps;
            const auto at = std::min(static_cast<std::size_t>(step), shares.size() - 2);
            const double share = std::min(1.0, shares[at] + (step - static_cast<double>(at)) * (shares[at + 1] - shares[at]));
            sum += std::max(share - before, 0.0) * static_cast<double>(texel->radiance);
            before = std::max(share, before);
        }
        return before > 0 ? sum / before : 0;
    }

    const CubemapReference& reference_;
    std::array<std::vector<CubemapReference::Weighted>, 3> texels_;
};

/// Light of a mip over every direction, by channel.
struct MipLight {
    Intervals reference, found;
};
/// Returns the light of a mip. The result is between the smallest and largest stored value, as allowed samplers read them, times the exact
/// extrema of S. Nothing if S is not positive everywhere, or a stored value is not finite.
std::optional<MipLight> lightOfMip(const CookedCubemap& map, const CookedCubemap::Mip& mip, const PrefilteredRange& references) {
    constexpr double kRounding = 1e-5;  // of the shader's S in floats
    MipLight out{references.of(mip.m, map.lobe), {}};
    for (int channel = 0; channel < 3; ++channel) {
        const std::optional<lighting::Extrema> s = denominatorRange(map, mip, channel);
        std::optional<Interval> stored = storedRange(mip, channel);
        if (!s || !(s->minimum > 0) || !stored) return std::nullopt;
        *stored = *stored +
                  Interval::around(0, static_cast<double>(map.tolerance.absolute) + static_cast<double>(map.tolerance.decoded[channel]) +
                                          static_cast<double>(map.tolerance.relative) * stored->largest());
        out.found[static_cast<std::size_t>(channel)] =
            static_cast<double>(map.range) * (*stored * Interval{s->minimum * (1 - kRounding), s->maximum * (1 + kRounding)});
    }
    return out;
}

/// Returns an upper bound of the local error over every direction, with its mip and channel; `local` is the bound. Sound but loose.
/// Infinite where nothing is known of a mip.
ErrorPlace boundOf(const CookedCubemap& map, const std::vector<std::optional<MipLight>>& light, double key) {
    ErrorPlace worst;
    for (std::size_t index = 0; index < map.mips.size(); ++index)
        for (int channel = 0; channel < 3; ++channel) {
            const auto c = static_cast<std::size_t>(channel);
            const double bound = light[index] ? largestLocalError(light[index]->reference[c], light[index]->found[c], key)
                                              : std::numeric_limits<double>::infinity();
            if (!(bound > worst.local)) continue;
            worst.mip = static_cast<int>(index);
            worst.channel = channel;
            worst.m = map.mips[index].m;
            worst.local = bound;
        }
    return worst;
}

/// Returns the place of a sample: a texel, or a direction between texels with the face that it hits.
ErrorPlace placeOf(const CookedCubemap& map, const CubemapSample& sample, int channel) {
    const CookedCubemap::Mip& mip = map.mips[static_cast<std::size_t>(sample.mip)];
    const lighting::CubeCoordinate hit = lighting::cubeFromDirection(sample.direction);
    const double size = mip.faces[0].width();
    ErrorPlace place;
    place.mip = sample.mip;
    place.face = sample.isTexel ? sample.face : hit.face;
    place.x = sample.isTexel ? sample.x : std::clamp(0.5 * (hit.uv.x + 1) * size - 0.5, 0.0, size - 1);
    place.y = sample.isTexel ? sample.y : std::clamp(0.5 * (hit.uv.y + 1) * size - 0.5, 0.0, size - 1);
    place.channel = channel;
    place.normal = sample.direction;
    place.m = mip.m;
    return place;
}

}  // namespace

/// The kernel of one call of prefiltered().
struct CubemapReference::Lobe {
    glm::dvec3 direction;
    double squaredM;
    NormalDistribution distribution;
    double reach, cosine, sine;  ///< largest angle of texel centres [rad], its cosine and sine
};

/// Values by column of pieces of a tile: those that all rows share, and those of the current row. The cosine to the kernel's axis is
/// y cos(theta) + sin(theta) along in panoramas, (along + v down) / sqrt(squared + v^2) on faces.
struct CubemapReference::Columns {
    std::vector<double> along;    ///< x sin(phi) - z cos(phi), or major + u right
    std::vector<double> squared;  ///< 1 + u^2
    std::vector<double> cosine, solidAngle;

    void resize(std::size_t count) {
        for (std::vector<double>* values : {&along, &squared, &cosine, &solidAngle}) values->resize(count);
    }
};

/// Buffers of one call of prefiltered(): texel centres and pieces of the current tile, their weights, and a sum for each column of a tile.
/// Columns are added up at the end, so that the loops over them are vectorized.
struct CubemapReference::Workspace {
    Columns centres, pieces;
    std::vector<double> pieceWeights, weights;
    struct Sums {
        std::array<double, kTileSize> weight{};
        std::array<std::array<double, kTileSize>, 3> radiance{};
    } sums;
};

void LightMoments::add(const glm::dvec3& radiance, const glm::dvec3& direction, double solidAngle) {
    mean += solidAngle * radiance;
    for (int channel = 0; channel < 3; ++channel) first[static_cast<std::size_t>(channel)] += solidAngle * radiance[channel] * direction;
}

void LightMoments::scale(double factor) {
    mean *= factor;
    for (glm::dvec3& each : first) each *= factor;
}

CubemapReference::CubemapReference(const Environment& environment)
    : environment_(environment), isPanorama_(environment.projection == Environment::Projection::Equirectangular) {
    const int width = environment.texels.width(), height = environment.texels.height();
    assert(width > 0 && height == (isPanorama_ ? width / 2 : 6 * width));
    texelWidth_ = isPanorama_ ? 2 * std::numbers::pi / width : 2.0 / width;
    const auto fill = [](Angles& angles, int count, double first, double step) {
        for (int i = 0; i < count; ++i) {
            angles.sine.push_back(std::sin(first + step * (i + 0.5)));
            angles.cosine.push_back(std::cos(first + step * (i + 0.5)));
        }
    };
    if (isPanorama_) {
        fill(longitudes_, width, -std::numbers::pi, texelWidth_);
        fill(colatitudes_, height, 0, std::numbers::pi / height);
    } else {
        for (int y = 0; y < width; ++y)
            for (int x = 0; x < width; ++x) {
                const double u = (2.0 * x + 1) / width - 1, v = (2.0 * y + 1) / width - 1;
                faceSolidAngles_.push_back(lighting::cubeTexelSolidAngle(x, y, width));
                faceInverseLengths_.push_back(1 / std::sqrt(1 + u * u + v * v));
            }
    }
    for (std::vector<float>& channel : radiance_) channel.reserve(environment.texels.texels().size());
    smallest_ = largest_ = glm::dvec3(environment.texels.at(0, 0));
    double total = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const glm::dvec3 radiance(environment.texels.at(x, y));
            const double solidAngle = solidAngleOf(x, y);
            moments_.add(radiance, directionOf(x, y), solidAngle);
            total += solidAngle;
            smallest_ = glm::min(smallest_, radiance);
            largest_ = glm::max(largest_, radiance);
        }
    moments_.scale(1 / total);
    const int faceHeight = isPanorama_ ? height : width;  // tiles do not cross faces
    for (int face = 0; face < height; face += faceHeight)
        for (int top = face; top < face + faceHeight; top += kTileSize)
            for (int left = 0; left < width; left += kTileSize)
                addTile(left, top, std::min(kTileSize, width - left), std::min(kTileSize, face + faceHeight - top));
}

double CubemapReference::displayKey(const glm::vec3& luminanceWeights) const {
    lighting::ShDouble luminance{};
    for (int y = 0; y < environment_.texels.height(); ++y)
        for (int x = 0; x < environment_.texels.width(); ++x) {
            const double weighted = solidAngleOf(x, y) * glm::dot(glm::dvec3(environment_.texels.at(x, y)), glm::dvec3(luminanceWeights));
            const lighting::ShDouble basis = lighting::evaluateBasis(directionOf(x, y));
            for (std::size_t i = 0; i < basis.size(); ++i) luminance[i] += weighted * basis[i];
        }
    for (std::size_t i = 0; i < luminance.size(); ++i)
        luminance[i] *= lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[i])];
    std::vector<double> exits;
    for (int i = 0; i < kKeyNormals; ++i) exits.push_back(lighting::evaluate(luminance, lighting::fibonacciSphere(i, kKeyNormals)));
    return displayKeyOf(exits);
}

std::vector<CubemapReference::Weighted> CubemapReference::sorted(int channel) const {
    std::vector<Weighted> texels;
    for (int y = 0; y < environment_.texels.height(); ++y)
        for (int x = 0; x < environment_.texels.width(); ++x) texels.push_back({environment_.texels.at(x, y)[channel], solidAngleOf(x, y)});
    // Texels of one value are alike but for their solid angle, of which only the sum counts.
    std::ranges::sort(texels, [](const Weighted& a, const Weighted& b) {
        return a.radiance < b.radiance || (a.radiance == b.radiance && a.solidAngle < b.solidAngle);
    });
    return texels;
}

std::array<glm::dvec3, lighting::kShCount> CubemapReference::incidentSh() const {
    constexpr int kPanoramaRows = 256, kFaceRows = 64;
    const formats::Image<glm::vec3>& texels = environment_.texels;
    const int rows = isPanorama_ ? texels.height() : texels.width(), least = isPanorama_ ? kPanoramaRows : kFaceRows;
    const int pieces = std::max(1, (least + rows - 1) / rows), width = texels.width() * pieces, height = texels.height() * pieces;
    std::array<glm::dvec3, lighting::kShCount> sums{};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const glm::dvec3 direction = isPanorama_ ? lighting::directionFromEquirectangular({(x + 0.5) / width, (y + 0.5) / height})
                                                     : lighting::cubeTexelDirection(y / width, x, y % width, width);
            const double solidAngle = isPanorama_ ? lighting::equirectangularTexelSolidAngle(y, width, height)
                                                  : lighting::cubeTexelSolidAngle(x, y % width, width);
            const glm::dvec3 light = solidAngle * glm::dvec3(texels.at(x / pieces, y / pieces));
            const lighting::ShDouble basis = lighting::evaluateBasis(direction);
            for (std::size_t i = 0; i < basis.size(); ++i) sums[i] += basis[i] * light;
        }
    return sums;
}

glm::dvec3 CubemapReference::directionOf(int x, int y) const {
    const int width = environment_.texels.width(), height = environment_.texels.height();
    return isPanorama_ ? lighting::directionFromEquirectangular({(x + 0.5) / width, (y + 0.5) / height})
                       : lighting::cubeTexelDirection(y / width, x, y % width, width);
}

double CubemapReference::solidAngleOf(int x, int y) const {
    const int width = environment_.texels.width();
    return isPanorama_ ? lighting::equirectangularTexelSolidAngle(y, width, environment_.texels.height())
                       : faceSolidAngles_[static_cast<std::size_t>(y % width * width + x)];
}

void CubemapReference::addTile(int left, int top, int width, int height) {
    std::vector<glm::dvec3> directions;
    glm::dvec3 sum(0);
    for (int y = top; y < top + height; ++y)
        for (int x = left; x < left + width; ++x) {
            directions.push_back(directionOf(x, y));
            sum += directions.back();
        }
    Tile tile{left, top, width, height, radiance_[0].size()};
    for (int y = top; y < top + height; ++y)
        for (int x = left; x < left + width; ++x)
            for (int channel = 0; channel < 3; ++channel)
                radiance_[static_cast<std::size_t>(channel)].push_back(environment_.texels.at(x, y)[channel]);
    const double length = glm::length(sum);
    tile.centre = length > 1e-6 ? sum / length : glm::dvec3(0, 1, 0);
    for (const glm::dvec3& direction : directions)
        tile.radius = std::max(tile.radius, std::acos(std::clamp(glm::dot(tile.centre, direction), -1.0, 1.0)));
    tile.radius += 1e-6;  // rounding
    tile.cosine = std::cos(tile.radius);
    tile.sine = std::sin(tile.radius);
    tiles_.push_back(tile);
}

void CubemapReference::fillColumns(const Tile& tile, const Lobe& lobe, int pieces, Columns& columns) const {
    columns.resize(static_cast<std::size_t>(tile.width) * static_cast<std::size_t>(pieces));
    const int size = environment_.texels.width() * pieces;
    const FaceAxes& axes = kFaceAxes[isPanorama_ ? 0 : tile.top / environment_.texels.width()];
    const double major = glm::dot(lobe.direction, axes.major), right = glm::dot(lobe.direction, axes.right);
    for (int piece = 0; piece < pieces; ++piece) {
        const double offset = texelWidth_ * ((piece + 0.5) / pieces - 0.5), offsetSine = std::sin(offset), offsetCosine = std::cos(offset);
        for (int x = 0; x < tile.width; ++x) {
            const std::size_t column = static_cast<std::size_t>(x * pieces + piece);
            if (isPanorama_) {
                const double sine = longitudes_.sine[static_cast<std::size_t>(tile.left + x)];
                const double cosine = longitudes_.cosine[static_cast<std::size_t>(tile.left + x)];
                columns.along[column] = lobe.direction.x * (sine * offsetCosine + cosine * offsetSine) -
                                        lobe.direction.z * (cosine * offsetCosine - sine * offsetSine);
            } else {
                const double u = (2.0 * ((tile.left + x) * pieces + piece) + 1) / size - 1;
                columns.along[column] = major + u * right;
                columns.squared[column] = 1 + u * u;
            }
        }
    }
}

/// Computes cosine to the kernel's axis and solid angle of the columns [begin, end) of a row of pieces.
/// pieceY  row of pieces, from the top of the image
void CubemapReference::visitRow(const Lobe& lobe, const Tile& tile, int pieceY, int pieces, std::size_t begin, std::size_t end,
                                Columns& columns) const {
    const double* const along = columns.along.data();
    double* const cosine = columns.cosine.data();
    double* const solidAngle = columns.solidAngle.data();
    if (isPanorama_) {
        const std::size_t y = static_cast<std::size_t>(pieceY / pieces);
        const double step = std::numbers::pi / environment_.texels.height(), offset = step * ((pieceY % pieces + 0.5) / pieces - 0.5);
        const double offsetSine = std::sin(offset), offsetCosine = std::cos(offset);
        const double sinTheta = colatitudes_.sine[y] * offsetCosine + colatitudes_.cosine[y] * offsetSine;
        const double base = lobe.direction.y * (colatitudes_.cosine[y] * offsetCosine - colatitudes_.sine[y] * offsetSine);
        // Exact area: difference of the cosines at the row's ends, as a product.
        const double area = 2 * std::numbers::pi / (environment_.texels.width() * pieces) * 2 * std::sin(0.5 * step / pieces) * sinTheta;
        for (std::size_t i = begin; i < end; ++i) {
            cosine[i] = base + sinTheta * along[i];
            solidAngle[i] = area;
        }
        return;
    }
    const int width = environment_.texels.width(), size = width * pieces;
    const double v = (2.0 * (pieceY % size) + 1) / size - 1, vSquared = v * v, area = 4 / (static_cast<double>(size) * size);
    const double base = v * glm::dot(lobe.direction, kFaceAxes[pieceY / size].down);
    const double* const squared = columns.squared.data();
    if (pieces == 1) {
        const std::size_t first = static_cast<std::size_t>(pieceY % size * size + tile.left);
        const double *const inverse = faceInverseLengths_.data() + first, *const exact = faceSolidAngles_.data() + first;
        for (std::size_t i = begin; i < end; ++i) {
            cosine[i] = (along[i] + base) * inverse[i];
            solidAngle[i] = exact[i];
        }
        return;
    }
    for (std::size_t i = begin; i < end; ++i) {
        // Pieces are small: their solid angle is the density at the middle, 4 / size^2 (1 + u^2 + v^2)^(-3/2).
        const double inverse = 1 / std::sqrt(squared[i] + vSquared);
        cosine[i] = (along[i] + base) * inverse;
        solidAngle[i] = area * inverse * inverse * inverse;
    }
}

glm::dvec3 CubemapReference::prefiltered(const glm::dvec3& direction, double m, double piecesPerWidth,
                                         NormalDistribution distribution) const {
    assert(0 < m && m <= 1);
    // The kernel's standard deviation is sqrt(2) m. Pieces of an eighth of it widen the kernel by a thousandth.
    const double width = std::numbers::sqrt2 * m;
    const auto piecesFor = [&](double scale) {
        return std::clamp(static_cast<int>(std::ceil(piecesPerWidth * texelWidth_ / scale)), 1, 256);
    };
    const double reach = std::min(kernelSupport(m, distribution) + texelWidth_, std::numbers::pi);
    const Lobe lobe{direction, m * m, distribution, reach, std::cos(reach), std::sin(reach)};
    Workspace workspace;
    for (const Tile& tile : tiles_) {
        const bool isInside = reach + tile.radius >= std::numbers::pi;
        const double cosine = glm::dot(tile.centre, direction);
        if (!isInside && cosine < lobe.cosine * tile.cosine - lobe.sine * tile.sine) continue;
        double scale = width;
        if (distribution == NormalDistribution::Ggx) {
            // D falls with 1 / (m^2 + angle^2 / 4)^2: it changes by a share over a width of half the angle.
            const double nearest = std::max(0.0, std::acos(std::clamp(cosine, -1.0, 1.0)) - tile.radius);
            scale = std::max(width, nearest / 2);
        }
        gatherTile(lobe, tile, piecesFor(scale), workspace);
    }
    glm::dvec3 sum(0);
    double weightSum = 0;
    for (std::size_t column = 0; column < kTileSize; ++column) {
        weightSum += workspace.sums.weight[column];
        for (int channel = 0; channel < 3; ++channel) sum[channel] += workspace.sums.radiance[static_cast<std::size_t>(channel)][column];
    }
    return weightSum > 0 ? sum / weightSum : glm::dvec3(0);
}

/// Adds a tile: in each row, every texel from the first to the last whose centre is in reach, cut into pieces x pieces.
void CubemapReference::gatherTile(const Lobe& lobe, const Tile& tile, int pieces, Workspace& workspace) const {
    const std::size_t width = static_cast<std::size_t>(tile.width), cuts = static_cast<std::size_t>(pieces);
    Columns& centres = workspace.centres;
    fillColumns(tile, lobe, 1, centres);
    if (pieces > 1) fillColumns(tile, lobe, pieces, workspace.pieces);
    for (int y = tile.top; y < tile.top + tile.height; ++y) {
        visitRow(lobe, tile, y, 1, 0, width, centres);
        std::size_t begin = 0, end = width;
        while (begin < end && centres.cosine[begin] < lobe.cosine) ++begin;
        while (begin < end && centres.cosine[end - 1] < lobe.cosine) --end;
        if (begin == end) continue;
        workspace.weights.assign(width, 0.0);
        if (pieces == 1)
            addWeights(lobe, centres, begin, end, workspace.weights);
        else {
            workspace.pieceWeights.assign(width * cuts, 0.0);
            for (int piece = 0; piece < pieces; ++piece) {
                visitRow(lobe, tile, y * pieces + piece, pieces, begin * cuts, end * cuts, workspace.pieces);
                addWeights(lobe, workspace.pieces, begin * cuts, end * cuts, workspace.pieceWeights);
            }
            for (std::size_t i = begin * cuts; i < end * cuts; ++i) workspace.weights[i / cuts] += workspace.pieceWeights[i];
        }
        addRadiance(tile, y, begin, end, workspace);
    }
}

void CubemapReference::addWeights(const Lobe& lobe, const Columns& columns, std::size_t begin, std::size_t end,
                                  std::vector<double>& weights) {
    const double* const cosine = columns.cosine.data();
    const double* const solidAngle = columns.solidAngle.data();
    double* const weight = weights.data();
    const double squaredM = lobe.squaredM;
    if (lobe.distribution == NormalDistribution::Ggx)
        for (std::size_t i = begin; i < end; ++i) weight[i] += solidAngle[i] * kernelShape<NormalDistribution::Ggx>(cosine[i], squaredM);
    else
        for (std::size_t i = begin; i < end; ++i)
            weight[i] += solidAngle[i] * kernelShape<NormalDistribution::Beckmann>(cosine[i], squaredM);
}

void CubemapReference::addRadiance(const Tile& tile, int y, std::size_t begin, std::size_t end, Workspace& workspace) const {
    const std::size_t first = tile.first + static_cast<std::size_t>((y - tile.top) * tile.width);
    const double* const weight = workspace.weights.data();
    double* const weightSum = workspace.sums.weight.data();
    for (std::size_t x = begin; x < end; ++x) weightSum[x] += weight[x];
    for (std::size_t channel = 0; channel < 3; ++channel) {
        const float* const radiance = radiance_[channel].data() + first;
        double* const sum = workspace.sums.radiance[channel].data();
        for (std::size_t x = begin; x < end; ++x) sum[x] += weight[x] * static_cast<double>(radiance[x]);
    }
}

glm::dvec3 CubemapReference::radianceAt(const glm::dvec3& direction) const {
    const auto texels = environment_.texels.view();
    const auto index = [](double coordinate, int size) { return std::clamp(static_cast<int>(coordinate * size), 0, size - 1); };
    if (isPanorama_) {
        const glm::dvec2 uv = lighting::equirectangularFromDirection(direction);
        return glm::dvec3(texels.at(index(uv.x, texels.width), index(uv.y, texels.height)));
    }
    const lighting::CubeCoordinate place = lighting::cubeFromDirection(direction);
    return glm::dvec3(
        texels.at(index(0.5 * (place.uv.x + 1), texels.width), place.face * texels.width + index(0.5 * (place.uv.y + 1), texels.width)));
}

std::vector<CubemapSample> cubemapSamples(const CookedCubemap& map, const CubemapSampling& sampling) {
    std::vector<CubemapSample> samples;
    Random random(sampling.seed);
    for (int mip = 0; mip < static_cast<int>(map.mips.size()); ++mip) {
        const int size = map.mips[static_cast<std::size_t>(mip)].faces[0].width(), count = 6 * size * size;
        const auto addTexel = [&](int index) {
            const int face = index / (size * size), y = index / size % size, x = index % size;
            samples.push_back({mip, true, face, x, y, lighting::cubeTexelDirection(face, x, y, size)});
        };
        const int blocksAcross = (size + 3) / 4, blockCount = 6 * blocksAcross * blocksAcross;
        const auto inBlock = [&](int block) {
            const auto place = [&](int first) { return 4 * first + random.below(std::min(4, size - 4 * first)); };
            const int face = block / (blocksAcross * blocksAcross), x = place(block % blocksAcross);
            return (face * size + place(block / blocksAcross % blocksAcross)) * size + x;
        };
        if (count <= sampling.texelsPerMip)
            for (int index = 0; index < count; ++index) addTexel(index);
        else
            // Stratified: one texel out of each of as many equal parts.
            for (int i = 0; i < sampling.texelsPerMip; ++i) addTexel(inBlock(i * blockCount / sampling.texelsPerMip));
        for (int i = 0; i < sampling.directionsPerMip; ++i) samples.push_back({mip, false, 0, 0, 0, random.direction()});
    }
    return samples;
}

lighting::ShBands kernelBands(double m, NormalDistribution lobe) {
    if (!(m > 0)) return {1, 1, 1};
    constexpr int kSteps = 4096;
    std::array<double, 3> sums{};
    forEachKernelStep(m, lobe, kSteps, [&](double c, double weight) {
        sums[0] += weight;
        sums[1] += weight * c;
        sums[2] += weight * 0.5 * (3 * c * c - 1);
    });
    return {1, sums[1] / sums[0], sums[2] / sums[0]};
}

glm::dvec3 shadeCubemap(const CookedCubemap& map, int mip, const glm::vec3& stored, const glm::dvec3& direction) {
    if (!map.isDivided) return glm::dvec3(shaders::lcPrefiltered(stored, map.range));
    shaders::LcSh sh;
    for (std::size_t i = 0; i < map.windowedSh.size(); ++i) sh.c[i] = map.windowedSh[i];
    const lighting::ShBands& bands = map.mips[static_cast<std::size_t>(mip)].bands;
    const glm::vec3 s = shaders::lcZonalSpecular(sh, glm::vec3(direction), glm::vec3(glm::dvec3(bands[0], bands[1], bands[2])));
    return glm::dvec3(shaders::lcEnvironment(map.range * stored, s));
}

LightMoments cubemapMoments(const CookedCubemap& map, int mip) {
    const auto& faces = map.mips[static_cast<std::size_t>(mip)].faces;
    const int size = faces[0].width();
    LightMoments moments;
    for (int face = 0; face < 6; ++face)
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const glm::dvec3 direction = lighting::cubeTexelDirection(face, x, y, size);
                const glm::vec3 stored(faces[static_cast<std::size_t>(face)].at(x, y));
                moments.add(shadeCubemap(map, mip, stored, direction), direction, lighting::cubeTexelSolidAngle(x, y, size));
            }
    moments.scale(1 / (4 * std::numbers::pi));
    return moments;
}

CubemapResult compareCubemap(const CookedCubemap& map, const CubemapReference& reference, const CubemapSample& sample) {
    const CookedCubemap::Mip& mip = map.mips[static_cast<std::size_t>(sample.mip)];
    const glm::vec4 stored =
        sample.isTexel ? mip.faces[static_cast<std::size_t>(sample.face)].at(sample.x, sample.y) : sampleCube(mip.faces, sample.direction);
    CubemapResult result;
    result.cooked = shadeCubemap(map, sample.mip, glm::vec3(stored), sample.direction);
    result.reference = mip.m > 0 ? reference.prefiltered(sample.direction, mip.m, 8, map.lobe)
                                 : reference.footprintMean(sample.direction, mip.faces[0].width());
    return result;
}

double cubemapReflectance(double m, NormalDistribution lobe) {
    constexpr double kLeastM = 1e-4;
    if (m < kLeastM) return 1;
    const auto kind = lobe == NormalDistribution::Ggx ? lighting::SpecularLobe::Ggx : lighting::SpecularLobe::Beckmann;
    // Light of radiance 1 from everywhere has the coefficient sqrt(4 pi) alone.
    return lighting::areaSpecular(1, m, kind, lighting::CookTorranceNormalization::Energy).c[0] * std::sqrt(4 * std::numbers::pi);
}

namespace {

/// Returns the place of a sample that is seen in a surface of F0 1.
VisiblePlace shownPlace(const CookedCubemap& map, const CubemapSample& sample) {
    const ErrorPlace at = placeOf(map, sample, 0);
    return {.x = at.x, .y = at.y, .mip = at.mip, .face = at.face, .normal = at.normal, .m = at.m, .f0 = 1};
}

/// Raises the bound of visible errors to that of each mip. Its light is that of the mip's sample with the largest error.
/// reflectances  one for each mip
void addVisibleBounds(const CookedCubemap& map, const std::vector<std::optional<MipLight>>& light, std::span<const double> reflectances,
                      std::span<const CubemapSample> samples, std::span<const CubemapResult> results, const Viewing& viewing,
                      VisiblePairs& errors) {
    const VisibleMetric metric(viewing, 1);
    for (std::size_t mip = 0; mip < map.mips.size(); ++mip) {
        double bound = std::numeric_limits<double>::infinity();
        if (light[mip]) {
            MipLight shown = *light[mip];
            for (std::size_t c = 0; c < 3; ++c) {
                shown.reference[c] = reflectances[mip] * shown.reference[c];
                shown.found[c] = reflectances[mip] * shown.found[c];
            }
            bound = metric.bound(shown.reference, shown.found);
        }
        double largest = -1;
        VisiblePlace place;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            if (samples[i].mip != static_cast<int>(mip)) continue;
            const glm::dvec3 reference = reflectances[mip] * results[i].reference, found = reflectances[mip] * results[i].cooked;
            const double difference = lighting::visibleDifference(reference, found, viewing.display, viewing.bt2020FromWorking);
            if (difference <= largest) continue;
            largest = difference;
            place = shownPlace(map, samples[i]);
            place.reference = reference;
            place.found = found;
        }
        errors.addBound(bound, place);
    }
}

}  // namespace

std::vector<StageError> cubemapStages(const CookedCubemap& map, const CubemapReference& reference, std::span<const CubemapSample> samples,
                                      std::span<const CubemapResult> results, const glm::vec3& luminanceWeights,
                                      const std::optional<Viewing>& viewing) {
    assert(samples.size() == results.size());
    const double key = glm::dot(reference.mean(), glm::dvec3(luminanceWeights));
    SampleErrors divide(key, viewing), filter(key, viewing);
    std::vector<double> reflectances;
    for (const CookedCubemap::Mip& mip : map.mips) reflectances.push_back(cubemapReflectance(mip.m, map.lobe));
    for (std::size_t i = 0; i < samples.size(); ++i) {
        SampleErrors& errors = samples[i].isTexel ? divide : filter;
        for (int channel = 0; channel < 3; ++channel)
            errors.energy.add(results[i].reference[channel], results[i].cooked[channel], [&] { return placeOf(map, samples[i], channel); });
        const double reflectance = reflectances[static_cast<std::size_t>(samples[i].mip)];
        // Light as a pixel shows it: reflected off a surface of F0 1.
        if (errors.visible)
            errors.visible->add(reflectance * results[i].reference, reflectance * results[i].cooked, shownPlace(map, samples[i]));
    }
    const PrefilteredRange references(reference);
    std::vector<std::optional<MipLight>> light;
    for (const CookedCubemap::Mip& mip : map.mips) light.push_back(lightOfMip(map, mip, references));
    const ErrorPlace bound = boundOf(map, light, key);
    divide.energy.addBound(bound.local, bound);
    filter.energy.addBound(bound.local, bound);
    // Samples may miss the direction in which S is not positive, and the texel that is not finite.
    if (!std::isfinite(bound.local)) divide.energy.add(0, bound.local, [&] { return bound; });
    std::vector<StageError> stages = {{"divide", {}, divide.figures(), 0}, {"filter", {}, filter.figures(), 0}};
    if (viewing) addVisibleBounds(map, light, reflectances, samples, results, *viewing, *divide.visible);
    stages.push_back({"total", {}, divide.figures(), 0});
    takeLarger(stages[2].specular, stages[1].specular);
    return stages;
}

}  // namespace lightcook::verify
