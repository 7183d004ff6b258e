#include "verify/specular_tables.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "lighting/sh.h"
#include "lighting/sphere.h"
#include "shaders/lightcook_cpp.h"
#include "verify/random.h"
#include "verify/texture_unit.h"

namespace verify {
namespace {

/// Tables are evaluated no nearer to grazing than this: below it shadowing ends in a fold narrower than any sample.
constexpr double kSmallestNoV = 1e-3;
constexpr int kLightCount = 12;
/// Steps of 16 bits that two integrations at grazing view, where shadowing takes all but a fold of the lobe, may differ for one step
/// elsewhere.
constexpr double kGrazingSteps = 80;
/// Which coefficient each entry of a kernel belongs to.
constexpr std::array<std::size_t, 6> kCoefficients = {0, 2, 3, 6, 7, 8};

double axisValue(const SpecularTableAxis& axis, double index) {
    return axis.count == 1 ? axis.minimum : axis.minimum + (axis.maximum - axis.minimum) * index / (axis.count - 1);
}

SpecularKernelEntries entriesOf(const lighting::AreaSpecularKernel& k) {
    return {k.c[0], k.c[2], k.c[3], k.c[6], k.d[0], k.d[2], k.d[3], k.d[6], k.c[7], k.c[8], k.d[7], k.d[8]};
}

SpecularKernelEntries entriesOf(const shaders::LcSpecularKernel& k) {
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

shaders::LcSpecularKernel fetch(const CookedSpecularTables& tables, const SpecularTableSample& sample) {
    const glm::dvec2 uv(shaders::lcTableCoordinate(static_cast<float>(sample.view), tables.view.scale, tables.view.offset),
                        shaders::lcTableCoordinate(static_cast<float>(sample.m), tables.roughness.scale, tables.roughness.offset));
    const auto texel = [&](std::size_t texture) { return sampleBilinear(tables.textures[texture].view(), uv); };
    const shaders::LcSpecularConstants constants{{tables.scale[0], tables.scale[1], tables.scale[2]},
                                                 {tables.bias[0], tables.bias[1], tables.bias[2]}};
    return shaders::lcSpecularKernel({texel(0), texel(1), texel(2)}, constants);
}

/// Light 0 is constant; the others are half that and a directional light of the same mean radiance, 1 in all.
lighting::ShDouble lightOf(int index) {
    lighting::ShDouble light{};
    if (index > 0) {
        light = lighting::evaluateBasis(lighting::fibonacciHemisphere(index - 1, kLightCount));
        for (double& coefficient : light) coefficient *= 2 * std::numbers::pi;
    }
    light[0] += (index > 0 ? 0.5 : 1.0) * std::sqrt(4 * std::numbers::pi);
    return light;
}

double areaSpecular(const SpecularKernelEntries& k, const lighting::ShDouble& light, double f0) {
    constexpr std::array<std::size_t, 6> kC = {0, 1, 2, 3, 8, 9}, kD = {4, 5, 6, 7, 10, 11};
    double sum = 0;
    for (std::size_t i = 0; i < 6; ++i) sum += light[kCoefficients[i]] * (f0 * k[kC[i]] + (1 - f0) * k[kD[i]]);
    return sum;
}

double shadedByShader(const SpecularKernelEntries& k, const lighting::ShDouble& light, double f0) {
    shaders::LcSh sh;
    for (std::size_t i = 0; i < light.size(); ++i) sh.c[i] = glm::vec3(static_cast<float>(light[i]));
    return shaders::lcAreaSpecular(sh, kernelOf(k), glm::vec3(static_cast<float>(f0))).x;
}

struct Pair {
    double reference, cooked;
};

/// Bound: the largest error met. It covers every node, and of the cells between them the middles, where a linear filter of a smooth
/// function errs most to second order, with the seeded points as a check on that; it is no proof for the rest of a cell.
ErrorFigures figuresOf(const std::vector<Pair>& pairs, double key) {
    ErrorAccumulator errors(key);
    for (const Pair& pair : pairs) errors.add(pair.reference, pair.cooked);
    errors.addBound(errors.figures().maxSampled);
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

std::vector<SpecularTableSample> specularTableSamples(const CookedSpecularTables& tables, int randomCount, std::uint64_t seed) {
    const SpecularTableAxis &view = tables.view, &roughness = tables.roughness;
    std::vector<SpecularTableSample> samples;
    for (int y = 0; y < roughness.count; ++y)
        for (int x = 0; x < view.count; ++x) samples.push_back({axisValue(view, x), axisValue(roughness, y), true, false});
    for (int y = 0; y < std::max(1, roughness.count - 1); ++y)
        for (int x = 0; x + 1 < view.count; ++x) samples.push_back({axisValue(view, x + 0.5), axisValue(roughness, y + 0.5), false, true});
    Random random(seed);
    for (int i = 0; i < randomCount; ++i) {
        const double place = axisValue(view, random.next() * (view.count - 1));
        samples.push_back({place, axisValue(roughness, random.next() * (roughness.count - 1)), false, false});
    }
    return samples;
}

SpecularTableResult compareSpecularTables(const CookedSpecularTables& tables, const SpecularTableSample& sample) {
    const bool isSine = tables.viewAxis == SpecularViewAxis::Sine;
    const double NoV = std::max(isSine ? std::sqrt(std::max(0.0, 1 - sample.view * sample.view)) : sample.view, kSmallestNoV);
    const auto kernel = lighting::integrateAreaSpecular(NoV, sample.m, lighting::NormalDistribution::Beckmann,
                                                        lighting::CookTorranceNormalization::Energy, sample.isNode ? 1024 : 512);
    return {entriesOf(kernel), entriesOf(fetch(tables, sample))};
}

SpecularTableStepError specularTableStepError(const CookedSpecularTables& tables, const std::vector<SpecularTableSample>& samples,
                                              const std::vector<SpecularTableResult>& results) {
    assert(samples.size() == results.size());
    SpecularTableStepError worst;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (!samples[i].isNode) continue;
        const bool isGrazing = tables.viewAxis == SpecularViewAxis::Sine ? samples[i].view > 1 - 1e-6 : samples[i].view < kSmallestNoV;
        for (std::size_t k = 0; k < results[i].reference.size(); ++k) {
            const double step = std::abs(static_cast<double>(tables.scale[k / 4][static_cast<int>(k % 4)])) / 65535;
            // A NaN is an error too: the largest there is.
            const double error = std::abs(results[i].cooked[k] - results[i].reference[k]);
            const double steps = std::isnan(error) ? 65535.0 : error / std::max(step, 1e-9) / (isGrazing ? kGrazingSteps : 1.0);
            if (steps > worst.steps) worst = {steps, k, samples[i].view, samples[i].m};
        }
    }
    return worst;
}

std::vector<StageError> specularTableStages(const std::vector<SpecularTableSample>& samples,
                                            const std::vector<SpecularTableResult>& results, const std::vector<double>& f0) {
    assert(samples.size() == results.size());
    std::vector<Pair> nodes, between, shaded;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        for (std::size_t k = 0; k < results[i].reference.size(); ++k)
            (samples[i].isNode ? nodes : between).push_back({results[i].reference[k], results[i].cooked[k]});
        for (int light = 0; light <= kLightCount; ++light)
            for (const double f : f0) {
                const lighting::ShDouble incident = lightOf(light);
                shaded.push_back({areaSpecular(results[i].reference, incident, f), shadedByShader(results[i].cooked, incident, f)});
            }
    }
    double squares = 0;
    for (const Pair& node : nodes) squares += node.reference * node.reference;
    const double kernelKey = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, nodes.size())));
    return {{"quantize", {}, figuresOf(nodes, kernelKey), 0},
            {"filter", {}, figuresOf(between, kernelKey), 0},
            {"total", {}, figuresOf(shaded, logAverage(shaded)), 0}};
}

}  // namespace verify
