#include "pipeline/lint/light_map_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>

#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "pipeline/assets/light_map/ground_truth.h"
#include "pipeline/assets/results.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/lint/gamma.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;
using lighting::ShRgb;

/// Shortest band 1, over its longest, that has a direction.
constexpr double kShortestDirection = 0.02;
/// Length of band 1, over its longest, beyond which 8-bit directions are more than rounded.
constexpr double kLongestDirection = 1.1;
/// Rounding of halves, and of baker's windows, in f and g.
constexpr double kBandTolerance = 0.02;

/// Luminance of the nine coefficients of a texel.
using Luminances = std::array<double, lighting::kShCount>;
Luminances luminances(const ShRgb& sh, const glm::dvec3& weights) {
    Luminances values{};
    for (std::size_t i = 0; i < sh.size(); ++i) values[i] = glm::dot(glm::dvec3(sh[i]), weights);
    return values;
}

glm::dvec3 band1(const Luminances& sh) {
    return {sh[3], sh[1], sh[2]};
}

/// Means of the cosine and of its second Legendre polynomial over the light of a texel, along its normal.
struct Moments {
    double f = 0, g = 0;
};
Moments momentsOf(const Luminances& sh, const glm::dvec3& normal) {
    const lighting::ShDouble basis = lighting::evaluateBasis(normal);
    double linear = 0, quadratic = 0;
    for (std::size_t i = 1; i < 4; ++i) linear += sh[i] * basis[i];
    for (std::size_t i = 4; i < 9; ++i) quadratic += sh[i] * basis[i];
    const double fullTurn = 4 * std::numbers::pi;
    return {std::sqrt(fullTurn) * linear / (3 * sh[0]), std::sqrt(fullTurn) * quadratic / (5 * sh[0])};
}

bool isPossible(const Moments& moments) {
    const auto [f, g] = moments;
    return f >= -kBandTolerance && f <= 1 + kBandTolerance && g <= (3 * f - 1) / 2 + kBandTolerance &&
           g >= (3 * f * f - 1) / 2 - kBandTolerance;
}

/// Returns false for light of order 0 or 1, which is cut off: its bands need not be those of any light.
bool hasBand2(const Luminances& sh) {
    return std::ranges::any_of(std::span(sh).subspan<4>(), [](double value) { return value != 0; });
}

/// The texel as it was before somebody stored each coefficient under a gamma curve.
ShRgb decodedGamma(const ShRgb& sh) {
    ShRgb decoded{};
    for (std::size_t i = 0; i < sh.size(); ++i)
        for (int channel = 0; channel < 3; ++channel)
            decoded[i][channel] = static_cast<float>(std::copysign(std::pow(std::abs(sh[i][channel]), kGamma), sh[i][channel]));
    return decoded;
}

/// Facts of some rows, and what the scanner of charts needs of them.
struct Part {
    LightMapFacts facts;
    double radianceSum = 0;
    std::int64_t lit = 0;                   ///< texels whose white surface has a positive luminance
    double logSum = 0;                      ///< of the logarithms of these
    std::vector<std::vector<float>> light;  ///< by row: the largest channel of sh00; negative where it is not covered
    std::vector<verify::LightMapTruthPlace> traced;
};

class PartCounter {
public:
    PartCounter(const LightMapLintParameters& parameters, const glm::vec3& weights)
        : isTangent_(parameters.description.frame == formats::ShFrame::Tangent), weights_(weights) {
        const lighting::ShBands& bands = lighting::kIrradianceBands;
        const bool isIrradiance = parameters.description.quantity == formats::ShQuantity::Irradiance;
        for (std::size_t degree = 1; degree < 3; ++degree) {
            const double ratio = bands[0] / bands[degree];
            otherQuantity_.at(degree - 1) = isIrradiance ? 1 / ratio : ratio;
        }
    }

    Part count(const formats::LightMapStrip& strip, bool hasNormals) const {
        Part part;
        part.facts.coverage = strip.coverage;
        for (int y = 0; y < strip.sh.height(); ++y) {
            std::vector<float>& light = part.light.emplace_back(static_cast<std::size_t>(strip.sh.width()), -1.0f);
            for (int x = 0; x < strip.sh.width(); ++x) {
                if (strip.covered.at(x, y) == 0) continue;
                const ShRgb& sh = strip.sh.at(x, y);
                light[static_cast<std::size_t>(x)] = std::max({sh[0].x, sh[0].y, sh[0].z, 0.0f});
                add(sh, glm::dvec3(strip.normal.at(x, y)), hasNormals, part);
            }
        }
        return part;
    }

private:
    void add(const ShRgb& sh, const glm::dvec3& normal, bool hasNormals, Part& part) const {
        LightMapFacts& facts = part.facts;
        ++facts.covered;
        facts.black += sh == ShRgb{} ? 1 : 0;
        const auto exit = lighting::lambertExitRadiance(sh, glm::vec3(normal), glm::vec3(1));
        if (const double luminance = glm::dot(glm::dvec3(exit.value), weights_); luminance > 0) {
            ++part.lit;
            part.logSum += std::log(luminance);
        }
        const Luminances values = luminances(sh, weights_);
        // Light of radiance 1 from a hemisphere has an sh00 of sqrt(pi).
        part.radianceSum += values[0] / std::sqrt(std::numbers::pi);
        if (!(values[0] > 0)) return;
        const double longest = std::sqrt(3.0) * values[0], noise = kShortestDirection * longest, length = glm::length(band1(values));
        facts.tooDirected += length > kLongestDirection * longest ? 1 : 0;
        if (length >= noise) {
            ++facts.directional;
            if (hasNormals) addDirection(band1(values), noise, normal, facts);
        }
        if (hasNormals && hasBand2(values)) addBands(sh, values, normal, facts.bands);
    }

    void addDirection(const glm::dvec3& light, double noise, const glm::dvec3& normal, LightMapFacts& facts) const {
        for (int choice = 0; choice < formats::BakeAxes::kChoices; ++choice) {
            const double cosine = glm::dot(normal, formats::BakeAxes::choice(choice)(light));
            facts.behind[static_cast<std::size_t>(choice)] += cosine < -noise ? 1 : 0;
        }
        // A file whose frame is "tangent" was turned to the world; otherwise its z would be along the normal.
        const double inOtherFrame =
            isTangent_ ? glm::dot(normal, glm::transpose(lighting::worldFromTangentFrame(normal)) * light) : light.z;
        facts.behindInOtherFrame += inOtherFrame < -noise ? 1 : 0;
    }

    void addBands(const ShRgb& sh, const Luminances& values, const glm::dvec3& normal, BandFacts& bands) const {
        const Moments moments = momentsOf(values, normal);
        ++bands.texels;
        bands.asDescribed += isPossible(moments) ? 0 : 1;
        bands.otherQuantity += isPossible({otherQuantity_[0] * moments.f, otherQuantity_[1] * moments.g}) ? 0 : 1;
        bands.decoded += isPossible(momentsOf(luminances(decodedGamma(sh), weights_), normal)) ? 0 : 1;
    }

    bool isTangent_;
    glm::dvec3 weights_;
    std::array<double, 2> otherQuantity_{};  ///< factors of bands 1 and 2 over that of band 0
};

void merge(LightMapFacts& whole, const LightMapFacts& part) {
    whole.coverage += part.coverage;
    whole.covered += part.covered;
    whole.black += part.black;
    whole.tooDirected += part.tooDirected;
    whole.directional += part.directional;
    for (std::size_t i = 0; i < whole.behind.size(); ++i) whole.behind[i] += part.behind[i];
    whole.behindInOtherFrame += part.behindInOtherFrame;
    whole.bands.texels += part.bands.texels;
    whole.bands.asDescribed += part.bands.asDescribed;
    whole.bands.otherQuantity += part.bands.otherQuantity;
    whole.bands.decoded += part.bands.decoded;
}

}  // namespace

Result<ActionOutcome> lintLightMap(const ActionContext& context) {
    const auto parameters = parametersOf<LightMapLintParameters>(context);
    if (!parameters) return tl::make_unexpected(parameters.error());
    const auto opened = openLightMap(context, parameters->description);
    if (!opened) return tl::make_unexpected(opened.error());
    LightMapSource& source = **opened;
    LightMapFacts facts;
    facts.width = source.width();
    facts.height = source.height();
    facts.hasCoverage = source.hasCoverage();
    facts.hasNormals = source.hasNormals();
    facts.hasMeshNormals = source.hasMeshNormals();
    facts.reading = source.reading();
    facts.primaries = source.primaries();
    facts.reading.lightMap = context.action.asset;
    const auto truth = GroundTruth::open(context, source, parameters->description.colors);
    if (!truth) return tl::make_unexpected(truth.error());
    const PartCounter counter(*parameters, source.luminanceWeights());
    ChartScanner scanner(source.width(), parameters->description.fireflyLimit);
    double radianceSum = 0, logSum = 0;
    std::int64_t lit = 0;
    std::vector<verify::LightMapTruthPlace> traced;
    const auto merged = foldInOrder<Part>(
        source.chunkCount(), context, "lint " + context.action.asset,
        [&](int index) -> Result<Part> {
            const auto chunk = source.chunk(index);
            if (!chunk) return tl::make_unexpected(chunk.error());
            Part part = counter.count(**chunk, facts.hasNormals);
            const auto values = truth->within(**chunk, (*chunk)->firstRow, (*chunk)->sh.height());
            if (!values) return tl::make_unexpected(values.error());
            part.traced = lightMapPlaces(*values, **chunk, (*chunk)->sh, (*chunk)->firstRow);
            return part;
        },
        [&](Part&& part) {
            merge(facts, part.facts);
            radianceSum += part.radianceSum;
            logSum += part.logSum;
            lit += part.lit;
            for (std::vector<float>& row : part.light) scanner.addRow(std::move(row));
            traced.insert(traced.end(), part.traced.begin(), part.traced.end());
        });
    if (!merged) return tl::make_unexpected(merged.error());
    if (facts.coverage.smallest > facts.coverage.largest) facts.coverage.smallest = facts.coverage.largest = 0;
    facts.key = lit > 0 ? std::exp(logSum / static_cast<double>(lit)) : 0.0;
    facts.meanRadiance = facts.covered > facts.black ? radianceSum / static_cast<double>(facts.covered - facts.black) : 0.0;
    facts.charts = scanner.finish();
    facts.tracedRatio = verify::tracedRatio(traced);
    return outcomeWith(facts);
}

}  // namespace lightcook::pipeline
