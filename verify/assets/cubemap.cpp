#include "verify/cubemap.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <functional>
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
#include "verify/assets/prefilter_kernel.h"
#include "verify/assets/random.h"
#include "verify/error/visible_metric.h"
#include "verify/texture_unit.h"

namespace lightcook::verify {
namespace {

using formats::Environment;

using lighting::NormalDistribution;

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

/// Returns the place of a sample, on the face that its direction hits.
ErrorPlace placeOf(const CookedCubemap& map, const CubemapSample& sample, int channel) {
    const CookedCubemap::Mip& mip = map.mips[static_cast<std::size_t>(sample.mip)];
    const lighting::CubeCoordinate hit = lighting::cubeFromDirection(sample.direction);
    const double size = mip.faces[0].width();
    ErrorPlace place;
    place.mip = sample.mip;
    place.face = hit.face;
    place.x = std::clamp(0.5 * (hit.uv.x + 1) * size - 0.5, 0.0, size - 1);
    place.y = std::clamp(0.5 * (hit.uv.y + 1) * size - 0.5, 0.0, size - 1);
    place.channel = channel;
    place.normal = sample.direction;
    place.m = mip.m;
    return place;
}

}  // namespace

CubemapReference::CubemapReference(const Environment& environment)
    : environment_(environment), isPanorama_(environment.projection == Environment::Projection::Equirectangular) {
    const int width = environment.texels.width(), height = environment.texels.height();
    assert(width > 0 && height == (isPanorama_ ? width / 2 : 6 * width));
    for (int i = 0; !isPanorama_ && i < width * width; ++i)
        faceSolidAngles_.push_back(lighting::cubeTexelSolidAngle(i % width, i / width, width));
    smallest_ = largest_ = glm::dvec3(environment.texels.at(0, 0));
    double total = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const glm::dvec3 radiance(environment.texels.at(x, y));
            const double solidAngle = solidAngleOf(x, y);
            mean_ += solidAngle * radiance;
            total += solidAngle;
            smallest_ = glm::min(smallest_, radiance);
            largest_ = glm::max(largest_, radiance);
        }
    mean_ /= total;
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

std::vector<CubemapSample> cubemapSamples(const CookedCubemap& map, int count, std::uint64_t seed) {
    std::vector<CubemapSample> samples;
    Random random(seed);
    for (int mip = 0; mip < static_cast<int>(map.mips.size()); ++mip)
        for (int i = 0; i < count; ++i) samples.push_back({mip, random.direction()});
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

CubemapResult compareCubemap(const CookedCubemap& map, const CubemapSample& sample, const glm::dvec3& reference) {
    const glm::vec4 stored = sampleCube(map.mips[static_cast<std::size_t>(sample.mip)].faces, sample.direction);
    return {reference, shadeCubemap(map, sample.mip, glm::vec3(stored), sample.direction)};
}

double cubemapReflectance(double m, NormalDistribution lobe) {
    constexpr double kLeastM = 1e-4;
    if (m < kLeastM) return 1;
    const auto kind = lobe == NormalDistribution::Ggx ? lighting::SpecularLobe::Ggx : lighting::SpecularLobe::Beckmann;
    // Light of radiance 1 from everywhere has the coefficient sqrt(4 pi) alone.
    return lighting::areaSpecular(1, m, kind, lighting::CookTorranceNormalization::Energy).c[0] * std::sqrt(4 * std::numbers::pi);
}

namespace {

/// Returns a place that is seen in a surface of F0 1.
VisiblePlace shownPlace(const ErrorPlace& at) {
    return {.x = at.x, .y = at.y, .mip = at.mip, .face = at.face, .normal = at.normal, .m = at.m, .f0 = 1};
}

/// Raises the bound of visible errors to that of each mip. Its light is that of the mip's texel with the largest error.
/// reflectances  one for each mip
void addVisibleBounds(const std::vector<std::optional<MipLight>>& light, std::span<const double> reflectances,
                      std::span<const CubemapErrors> levels, const Viewing& viewing, ErrorFigures& figures) {
    const VisibleMetric metric(viewing, 1);
    for (std::size_t mip = 0; mip < levels.size(); ++mip) {
        double bound = std::numeric_limits<double>::infinity();
        if (light[mip]) {
            MipLight shown = *light[mip];
            for (std::size_t c = 0; c < 3; ++c) {
                shown.reference[c] = reflectances[mip] * shown.reference[c];
                shown.found[c] = reflectances[mip] * shown.found[c];
            }
            bound = metric.bound(shown.reference, shown.found);
        }
        if (!figures.visible || !levels[mip].visible || bound <= figures.visible->bound.value_or(-1)) continue;
        figures.visible->bound = bound;
        figures.visible->boundAt = levels[mip].visible->figures().value_or(VisibleFigures{}).maxAt;
        figures.visible->boundAt.difference = bound;
    }
}

/// Returns the largest figures of any level.
ErrorFigures largestOf(std::span<const CubemapErrors> levels) {
    ErrorFigures largest;
    for (const CubemapErrors& level : levels) {
        ErrorFigures figures = level.energy.figures();
        if (level.visible) figures.visible = level.visible->figures();
        if (largest.visible && figures.visible)
            std::ranges::transform(largest.visible->histogram, figures.visible->histogram, largest.visible->histogram.begin(), std::plus());
        else
            largest.visible = figures.visible;
        largest.relRms = std::max(largest.relRms, figures.relRms);
        largest.p99 = std::max(largest.p99, figures.p99);
        takeLarger(largest, figures);
    }
    return largest;
}

}  // namespace

CubemapErrors::CubemapErrors(double key, const std::optional<Viewing>& viewing) : energy(key), ratios(0) {
    if (viewing) visible.emplace(*viewing);
}

void CubemapErrors::merge(const CubemapErrors& other) {
    energy.merge(other.energy);
    ratios.merge(other.ratios);
    if (visible && other.visible) visible->merge(*other.visible);
}

CubemapErrors compareCubemapFace(const CookedCubemap& map, int mip, int face, formats::ImageView<const glm::vec3> references, double key,
                                 const std::optional<Viewing>& viewing) {
    const CookedCubemap::Mip& level = map.mips[static_cast<std::size_t>(mip)];
    const auto& texels = level.faces[static_cast<std::size_t>(face)];
    const int size = texels.width();
    const double reflectance = cubemapReflectance(level.m, map.lobe), texelCount = 6.0 * size * size;
    CubemapErrors errors(key, viewing);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            ErrorPlace place;
            place.mip = mip;
            place.face = face;
            place.x = x;
            place.y = y;
            place.normal = lighting::cubeTexelDirection(face, x, y, size);
            place.m = level.m;
            const glm::dvec3 reference(references.at(x, y)), found = shadeCubemap(map, mip, glm::vec3(texels.at(x, y)), place.normal);
            const glm::dvec3 s = map.isDivided ? shadeCubemap(map, mip, glm::vec3(1.0f / map.range), place.normal) : glm::dvec3(1);
            const double weight = lighting::cubeTexelSolidAngle(x, y, size) * texelCount / (4 * std::numbers::pi);
            for (int channel = 0; channel < 3; ++channel) {
                place.channel = channel;
                errors.energy.add(
                    reference[channel], found[channel], [&] { return place; }, weight);
                errors.ratios.add(reference[channel] / s[channel], found[channel] / s[channel], weight);
            }
            // Light as a pixel shows it: reflected off a surface of F0 1.
            if (errors.visible) errors.visible->add(reflectance * reference, reflectance * found, shownPlace(place));
        }
    return errors;
}

std::vector<StageError> cubemapStages(const CookedCubemap& map, const CubemapReference& reference, std::span<const CubemapErrors> levels,
                                      std::span<const CubemapSample> samples, std::span<const CubemapResult> results,
                                      const glm::vec3& luminanceWeights, const std::optional<Viewing>& viewing) {
    assert(samples.size() == results.size());
    const double key = glm::dot(reference.mean(), glm::dvec3(luminanceWeights));
    std::vector<double> reflectances;
    std::vector<CubemapErrors> between;
    for (const CookedCubemap::Mip& mip : map.mips) {
        reflectances.push_back(cubemapReflectance(mip.m, map.lobe));
        between.emplace_back(key, viewing);
    }
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const auto mip = static_cast<std::size_t>(samples[i].mip);
        for (int channel = 0; channel < 3; ++channel)
            between[mip].energy.add(results[i].reference[channel], results[i].cooked[channel],
                                    [&] { return placeOf(map, samples[i], channel); });
        if (between[mip].visible)
            between[mip].visible->add(reflectances[mip] * results[i].reference, reflectances[mip] * results[i].cooked,
                                      shownPlace(placeOf(map, samples[i], 0)));
    }
    const PrefilteredRange references(reference);
    std::vector<std::optional<MipLight>> light;
    for (const CookedCubemap::Mip& mip : map.mips) light.push_back(lightOfMip(map, mip, references));
    const ErrorPlace bound = boundOf(map, light, key);
    ErrorFigures divide = largestOf(levels), filter = largestOf(between);
    for (ErrorFigures* const figures : {&divide, &filter}) {
        figures->maxBound = std::min(bound.local, std::numeric_limits<double>::max());
        figures->boundAt = bound;
    }
    // S may be negative in a direction of no texel.
    if (!std::isfinite(bound.local)) divide.relRms = divide.p99 = divide.maxSampled = std::numeric_limits<double>::max();
    std::vector<StageError> stages = {{"divide", {}, divide, 0}, {"filter", {}, filter, 0}};
    if (viewing) addVisibleBounds(light, reflectances, levels, *viewing, divide);
    stages.push_back({"total", {}, divide, 0});
    takeLargerMaxima(stages[2].specular, filter);
    return stages;
}

}  // namespace lightcook::verify
