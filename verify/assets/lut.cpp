#include "verify/lut.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "lighting/radiometry.h"
#include "lighting/sh.h"
#include "lighting/sphere.h"
#include "shaders/lightcook_cpp.h"
#include "verify/assets/lut_derivative.h"
#include "verify/assets/random.h"
#include "verify/texture_unit.h"

namespace lightcook::verify {
namespace {

constexpr int kLightCount = 12;
/// Gauss points of each piece: more than in the fit.
constexpr int kReferencePoints = 24;
/// Largest relative error of a value that is rounded to single precision.
constexpr double kHalfUlp = 0x1p-24;

SpecularKernelEntries entriesOfShader(const shaders::LcSpecularKernel& k) {
    SpecularKernelEntries entries;
    for (int i = 0; i < 4; ++i) {
        entries[static_cast<std::size_t>(i)] = k.c0236[i];
        entries[static_cast<std::size_t>(4 + i)] = k.d0236[i];
        entries[static_cast<std::size_t>(8 + i)] = k.cd78[i];
    }
    return entries;
}

shaders::LcSpecularKernel kernelOf(const SpecularKernelEntries& entries) {
    const auto four = [&](std::size_t first) {
        return glm::vec4(glm::dvec4(entries[first], entries[first + 1], entries[first + 2], entries[first + 3]));
    };
    return {four(0), four(4), four(8)};
}

SpecularKernelEntries decode(const CookedLut& tables, const std::array<glm::vec4, 3>& texels) {
    const shaders::LcSpecularConstants constants{{tables.scale[0], tables.scale[1], tables.scale[2]},
                                                 {tables.bias[0], tables.bias[1], tables.bias[2]}};
    return entriesOfShader(shaders::lcSpecularKernel({texels[0], texels[1], texels[2]}, constants));
}

/// Returns a light of mean radiance 1. Light 0 is constant; each other one is half constant, half directional.
lighting::ShDouble lightOf(int index) {
    lighting::ShDouble light{};
    if (index > 0) {
        light = lighting::evaluateBasis(lighting::fibonacciHemisphere(index - 1, kLightCount));
        for (double& coefficient : light) coefficient *= 2 * std::numbers::pi;
    }
    light[0] += (index > 0 ? 0.5 : 1.0) * std::sqrt(4 * std::numbers::pi);
    return light;
}

double reflected(const SpecularKernelEntries& k, const SpecularKernelEntries& shading) {
    double sum = 0;
    for (std::size_t i = 0; i < k.size(); ++i) sum += shading[i] * k[i];
    return sum;
}

double shadedByShader(const SpecularKernelEntries& k, const lighting::ShDouble& light, double f0) {
    shaders::LcSh sh;
    for (std::size_t i = 0; i < light.size(); ++i) sh.c[i] = glm::vec3(static_cast<float>(light[i]));
    return shaders::lcAreaSpecular(sh, kernelOf(k), glm::vec3(static_cast<float>(f0))).x;
}

/// Returns the exit radiance of a white Lambert surface under a light, whose normal is +Z.
double exitRadianceOf(const lighting::ShDouble& light) {
    const lighting::ShDouble basis = lighting::evaluateBasis(glm::dvec3(0, 0, 1));
    double sum = 0;
    for (std::size_t i = 0; i < light.size(); ++i)
        sum += lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[i])] * light[i] * basis[i];
    return sum;
}

struct Pair {
    double reference, cooked;
    std::size_t sample = 0;
    double f0 = 0;
    double exitRadiance = 1;  ///< of a white surface under the same light
};

/// Returns the visible errors of shaded pairs, each under its light at the key.
std::optional<VisibleFigures> visibleOf(const CookedLut& tables, const std::vector<LutSample>& samples, const std::vector<Pair>& pairs,
                                        const Viewing& viewing) {
    VisiblePairs errors(viewing);
    for (const Pair& pair : pairs) {
        const ErrorPlace at = lutPlace(tables, samples[pair.sample].NoV, samples[pair.sample].m);
        errors.add(glm::dvec3(pair.reference / pair.exitRadiance), glm::dvec3(pair.cooked / pair.exitRadiance),
                   {.x = at.x, .y = at.y, .normal = at.normal, .view = at.view, .m = at.m, .f0 = pair.f0});
    }
    return errors.figures();
}

ErrorFigures figuresOf(const CookedLut& tables, const std::vector<LutSample>& samples, const std::vector<Pair>& pairs, double key) {
    ErrorAccumulator errors(key);
    for (const Pair& pair : pairs)
        errors.add(pair.reference, pair.cooked, [&] {
            ErrorPlace place = lutPlace(tables, samples[pair.sample].NoV, samples[pair.sample].m);
            place.f0 = pair.f0;
            return place;
        });
    return errors.figures();
}

double logAverage(const std::vector<Pair>& pairs) {
    double logSum = 0;
    std::size_t count = 0;
    for (const Pair& pair : pairs) {
        if (!(pair.reference > 0)) continue;
        logSum += std::log(pair.reference);
        ++count;
    }
    return count > 0 ? std::exp(logSum / static_cast<double>(count)) : 0;
}

}  // namespace

ErrorPlace lutPlace(const CookedLut& tables, double NoV, double m) {
    const auto texelOf = [](const LutAxis& axis, double t) {
        const double coordinate = axis.of(t) * static_cast<double>(axis.scale) + static_cast<double>(axis.offset);
        return std::clamp(coordinate * axis.count - 0.5, 0.0, std::max(0.0, axis.count - 1.0));
    };
    ErrorPlace place;
    place.channel.reset();
    place.x = texelOf(tables.view, NoV);
    place.y = texelOf(tables.roughness, m);
    place.normal = {0, 0, 1};
    place.view = {std::sqrt(std::max(0.0, 1 - NoV * NoV)), 0, NoV};
    place.m = m;
    return place;
}

void LutBounds::raise(const LutBounds& other) {
    if (other.filter > filter) {
        filter = other.filter;
        filterAt = other.filterAt;
    }
    if (other.total > total) {
        total = other.total;
        totalAt = other.totalAt;
    }
    if (other.visible > visible) {
        visible = other.visible;
        visibleAt = other.visibleAt;
    }
}

double LutAxis::at(double index) const {
    return count == 1 ? minimum : minimum + (maximum - minimum) * index / (count - 1);
}

double LutAxis::of(double t) const {
    return std::sqrt(std::max(0.0, (factors[0] + factors[1] * t) * (factors[2] + factors[3] * t)));
}

std::array<double, 3> LutAxis::radicand() const {
    return {factors[0] * factors[2], factors[0] * factors[3] + factors[1] * factors[2], factors[1] * factors[3]};
}

double LutAxis::inverse(double value) const {
    const auto [ends, linear, quadratic] = radicand();
    const double constant = ends - value * value;
    const double root = std::sqrt(std::max(0.0, linear * linear - 4 * quadratic * constant));
    const double t = quadratic == 0 ? -constant / linear : ((linear + quadratic > 0 ? root : -root) - linear) / (2 * quadratic);
    return std::clamp(t, 0.0, 1.0);
}

double LutAxis::coordinateError() const {
    const auto errorAt = [&](int texel) {
        return std::abs((at(texel) * static_cast<double>(scale) + static_cast<double>(offset)) * count - texel - 0.5);
    };
    return std::max(errorAt(0), errorAt(count - 1));
}

double LutAxis::coordinateRounding() const {
    const double largest = std::max(std::abs(minimum), std::abs(maximum));
    return count * kHalfUlp * (largest * std::abs(static_cast<double>(scale)) + std::abs(static_cast<double>(offset)));
}

SpecularKernelEntries entriesOf(const lighting::AreaSpecularKernel& k) {
    return {k.c[0], k.c[2], k.c[3], k.c[6], k.d[0], k.d[2], k.d[3], k.d[6], k.c[7], k.c[8], k.d[7], k.d[8]};
}

SpecularKernelEntries fetchLut(const CookedLut& tables, double NoV, double m) {
    const auto coordinate = [](const LutAxis& axis, double t) {
        const glm::vec4 factors(glm::dvec4(axis.factors[0], axis.factors[1], axis.factors[2], axis.factors[3]));
        const float value = shaders::lcTableAxis(static_cast<float>(t), factors);
        return static_cast<double>(shaders::lcTableCoordinate(value, axis.scale, axis.offset));
    };
    const glm::dvec2 uv(coordinate(tables.view, NoV), coordinate(tables.roughness, m));
    const auto texel = [&](std::size_t texture) { return sampleBilinear(tables.textures[texture].view(), uv); };
    return decode(tables, {texel(0), texel(1), texel(2)});
}

std::vector<LutSample> lutSamples(const CookedLut& tables, int randomCount, std::uint64_t seed) {
    const LutAxis &view = tables.view, &roughness = tables.roughness;
    const auto sampleAt = [&](double x, double y, bool isNode, bool isMiddle) {
        return LutSample{view.inverse(view.at(x)), roughness.inverse(roughness.at(y)), isNode, isMiddle};
    };
    std::vector<LutSample> samples;
    for (int y = 0; y < roughness.count; ++y)
        for (int x = 0; x < view.count; ++x) samples.push_back(sampleAt(x, y, true, false));
    for (int y = 0; y < std::max(1, roughness.count - 1); ++y)
        for (int x = 0; x + 1 < view.count; ++x) samples.push_back(sampleAt(x + 0.5, y + 0.5, false, true));
    Random random(seed);
    const double low = roughness.inverse(roughness.minimum), high = roughness.inverse(roughness.maximum);
    for (int i = 0; i < randomCount; ++i) {
        const double NoV = random.next();
        samples.push_back({NoV, low + (high - low) * random.next(), false, false});
    }
    return samples;
}

LutResult compareLut(const CookedLut& tables, const LutSample& sample) {
    const auto kernel =
        lighting::areaSpecular(std::max(sample.NoV, kSmallestTableNoV), sample.m, tables.lobe, tables.normalization, kReferencePoints);
    return {entriesOf(kernel), fetchLut(tables, sample.NoV, sample.m)};
}

LutStepError lutStepError(const CookedLut& tables, const std::vector<LutSample>& samples, const std::vector<LutResult>& results) {
    assert(samples.size() == results.size());
    LutStepError worst;
    int node = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (!samples[i].isNode) continue;
        const int x = node % tables.view.count, y = node / tables.view.count;
        ++node;
        const SpecularKernelEntries decoded =
            decode(tables, {tables.textures[0].at(x, y), tables.textures[1].at(x, y), tables.textures[2].at(x, y)});
        for (std::size_t k = 0; k < decoded.size(); ++k) {
            const auto scale = static_cast<double>(tables.scale[k / 4][static_cast<int>(k % 4)]);
            const auto bias = static_cast<double>(tables.bias[k / 4][static_cast<int>(k % 4)]);
            const double step = std::max(std::abs(scale) / 65535, 1e-9);
            // The value is rounded to single precision once before it is quantized, and once by the shader.
            const double rounding = 2 * kHalfUlp * std::max(std::abs(bias), std::abs(bias + scale));
            // NaN counts as the largest error.
            const double error = std::abs(decoded[k] - results[i].reference[k]);
            const double steps = std::isnan(error) ? 65535.0 : std::max(0.0, error - rounding) / step;
            if (steps > worst.steps) worst = {steps, k, samples[i].NoV, samples[i].m};
        }
    }
    return worst;
}

std::vector<SpecularKernelEntries> lutShadings(const std::vector<double>& f0) {
    std::vector<SpecularKernelEntries> shadings;
    for (int light = 0; light <= kLightCount; ++light)
        for (const double f : f0) {
            const lighting::ShDouble incident = lightOf(light);
            SpecularKernelEntries shading{};
            for (std::size_t i = 0; i < lut::kKernelCoefficients.size(); ++i) {
                shading[lut::kEntryOfC[i]] = f * incident[lut::kKernelCoefficients[i]];
                shading[lut::kEntryOfD[i]] = (1 - f) * incident[lut::kKernelCoefficients[i]];
            }
            shadings.push_back(shading);
        }
    return shadings;
}

std::vector<double> lutExitRadiances(const std::vector<double>& f0) {
    std::vector<double> exits;
    for (int light = 0; light <= kLightCount; ++light) exits.insert(exits.end(), f0.size(), exitRadianceOf(lightOf(light)));
    return exits;
}

LutKeys lutKeys(const std::vector<LutSample>& samples, const std::vector<LutResult>& results, const std::vector<double>& f0) {
    const std::vector<SpecularKernelEntries> shadings = lutShadings(f0);
    std::vector<Pair> shaded;
    double squares = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        for (const SpecularKernelEntries& shading : shadings) shaded.push_back({reflected(results[i].reference, shading), 0});
        if (!samples[i].isNode) continue;
        for (const double entry : results[i].reference) squares += entry * entry;
        count += results[i].reference.size();
    }
    return {std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, count))), logAverage(shaded)};
}

std::vector<StageError> lutStages(const CookedLut& tables, const std::vector<LutSample>& samples, const std::vector<LutResult>& results,
                                  const std::vector<double>& f0, const LutBounds& bounds, const std::optional<Viewing>& viewing) {
    assert(samples.size() == results.size());
    const LutKeys keys = lutKeys(samples, results, f0);
    const std::vector<SpecularKernelEntries> shadings = lutShadings(f0);
    const std::vector<double> exits = lutExitRadiances(f0);
    std::vector<Pair> nodes, between, shaded;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        for (std::size_t k = 0; k < results[i].reference.size(); ++k)
            (samples[i].isNode ? nodes : between).push_back({results[i].reference[k], results[i].cooked[k], i});
        std::size_t shading = 0;
        for (int index = 0; index <= kLightCount; ++index) {
            const lighting::ShDouble light = lightOf(index);
            for (const double f : f0) {
                shaded.push_back({reflected(results[i].reference, shadings[shading]), shadedByShader(results[i].cooked, light, f), i, f,
                                  exits[shading]});
                ++shading;
            }
        }
    }
    const auto stage = [&](const char* name, const std::vector<Pair>& pairs, double key) {
        return StageError{name, {}, figuresOf(tables, samples, pairs, key), 0};
    };
    std::vector<StageError> stages = {stage("quantize", nodes, keys.kernel), stage("filter", between, keys.kernel),
                                      stage("total", shaded, keys.shaded)};
    const auto bound = [](ErrorFigures& figures, double value, const ErrorPlace& at) {
        figures.maxBound = std::isfinite(value) ? value : std::numeric_limits<double>::max();
        figures.boundAt = at;
    };
    bound(stages[0].specular, stages[0].specular.maxSampled, stages[0].specular.sampledAt);
    bound(stages[1].specular, bounds.filter, bounds.filterAt);
    bound(stages[2].specular, bounds.total, bounds.totalAt);
    if (!viewing) return stages;
    std::optional<VisibleFigures>& visible = stages[2].specular.visible;
    visible = visibleOf(tables, samples, shaded, *viewing);
    if (!visible || !bounds.visible) return stages;
    visible->bound = bounds.visible;
    visible->boundAt = bounds.visibleAt;
    return stages;
}

}  // namespace lightcook::verify
