#include "pipeline/lint/light_map_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>

#include "formats/bake_format.h"
#include "formats/vocabulary.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "pipeline/assets/light_map/ground_truth.h"
#include "pipeline/assets/light_map/part_of_chunk.h"
#include "pipeline/assets/results.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/lint/gamma.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;
using lighting::ShRgb;

// Tolerances of one texel, each with its reason. judge.cpp has the shares of texels that may be beyond them.

/// Least length of band 1, over its longest, that counts as a direction. Below it lies the noise of even light.
constexpr double kShortestDirection = 0.02;
/// Length of band 1, over its longest. Light reaches 1; directions in 8 bits add up to 3 / 255 sqrt(3) = 0.02 of Bakery's and 0.01 of
/// Unity's, halves 0.001. The rest is for filters of bakers that work on each coefficient alone.
constexpr double kLongestDirection = 1.1;
/// Largest difference of the components of normals on a flat surface: one step of halves. Normals of a flat surface are equal; smooth ones
/// differ by more from texel to texel, unless a triangle is 700 texels wide.
constexpr double kFlat = 5e-4;
/// s of light_map_facts.h where a surface is not flat: the sine of 30 degrees between the normals of a vertex and its triangles, half of
/// the 60 degrees up to which modelling programs join faces to a smooth surface.
constexpr double kSmooth = 0.5;
/// Rounding of a coefficient to half: relative, and of numbers below 6e-5, which have fewer bits, absolute. The latter times pi, which
/// light_units = "game" multiplies by; other conventions multiply by less.
constexpr double kHalfRounding = 1.0 / 2048, kSmallHalfRounding = std::numbers::pi / (1 << 25);
/// Windows of bakers, which scale a band by a few percent, and quadrature of light by 50 directions or more.
constexpr double kBandTolerance = 0.02;
/// Filters of bakers that work on each coefficient alone, such as denoisers. Noise of 2 % in each alone takes 0.03 % of the texels of the
/// public scenes further than this over the border, 5 % takes 2.6 %; irradiance that is read as radiance 1.1 to 8.1 %.
constexpr double kBandNoise = 0.1;

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

/// Bounds of the moments of light at a texel.
struct LightBounds {
    double below = 0;     ///< s of light_map_facts.h
    double rounding = 0;  ///< of f, and of g

    /// Returns true if a light has these moments, to within a tolerance of g.
    bool allow(const Moments& moments, double tolerance) const {
        const auto [f, g] = moments;
        const double most = (3 * ((1 - below) * f + below) - 1) / 2, least = (3 * f * f - 1) / 2;
        return f >= -below - tolerance - rounding && f <= 1 + tolerance + rounding && g <= most + tolerance + 2.5 * rounding &&
               g >= least - tolerance - (1 + 3 * std::abs(f)) * rounding;
    }
};

/// Upper bound of the rounding of f and g. Of band l, |sh_l| <= sqrt(2l + 1) sh00, so rounding of its coefficients and of sh00 changes f
/// and g by at most twice the relative rounding, and the absolute one over sh00.
double roundingOf(const Luminances& sh) {
    return 2 * (kHalfRounding + kSmallHalfRounding / sh[0]);
}

/// Returns true if the surface around a texel is flat: the normals of its neighbours in the strip, of which there is one either way, are
/// its own.
bool isFlat(const formats::LightMapStrip& strip, int x, int y) {
    const glm::vec3& normal = strip.normal.at(x, y);
    // 1 for a neighbour with this normal; of two, one with another outweighs it.
    const auto count = [&](int u, int v) {
        if (u < 0 || v < 0 || u >= strip.sh.width() || v >= strip.sh.height() || strip.covered.at(u, v) == 0) return 0;
        const glm::vec3 difference = glm::abs(strip.normal.at(u, v) - normal);
        return std::max({difference.x, difference.y, difference.z}) <= kFlat ? 1 : -2;
    };
    const int across = count(x - 1, y) + count(x + 1, y), along = count(x, y - 1) + count(x, y + 1);
    return across > 0 && along > 0;
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

/// Facts of some rows.
struct Part {
    LightMapCounts counts;
    double radianceSum = 0;
    std::int64_t lit = 0;  ///< texels whose white surface has a positive luminance
    double logSum = 0;     ///< of the logarithms of these
    ChartRows charts;
    std::vector<verify::LightMapTruthPlace> traced;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.counts, self.radianceSum, self.lit, self.logSum, self.charts, self.traced);
    }
};

class PartCounter {
public:
    /// longest  band 1 of light, over sqrt(3) sh00: BakeFormatInfo::longestDirection
    PartCounter(const LightMapLintParameters& parameters, const glm::vec3& weights, double longest)
        : isTangent_(parameters.description.frame == formats::ShFrame::Tangent), weights_(weights), longest_(longest) {
        const lighting::ShBands& bands = lighting::kIrradianceBands;
        const bool isIrradiance = parameters.description.quantity == formats::ShQuantity::Irradiance;
        for (std::size_t degree = 1; degree < 3; ++degree) {
            const double ratio = bands[0] / bands[degree];
            otherQuantity_.at(degree - 1) = isIrradiance ? 1 / ratio : ratio;
        }
    }

    Part count(const formats::LightMapStrip& strip, bool hasNormals) const {
        Part part;
        part.counts.coverage = strip.coverage;
        for (int y = 0; y < strip.sh.height(); ++y) {
            std::vector<float> light(static_cast<std::size_t>(strip.sh.width()), -1.0f);  // negative where it is not covered
            for (int x = 0; x < strip.sh.width(); ++x) {
                if (strip.covered.at(x, y) == 0) continue;
                const ShRgb& sh = strip.sh.at(x, y);
                light[static_cast<std::size_t>(x)] = std::max({sh[0].x, sh[0].y, sh[0].z, 0.0f});
                add(sh, glm::dvec3(strip.normal.at(x, y)), hasNormals, hasNormals && isFlat(strip, x, y) ? 0 : kSmooth, part);
            }
            part.charts.addRow(std::move(light));
        }
        return part;
    }

private:
    /// below  s of light_map_facts.h
    void add(const ShRgb& sh, const glm::dvec3& normal, bool hasNormals, double below, Part& part) const {
        LightMapCounts& facts = part.counts;
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
        facts.tooDirected += length > (kLongestDirection * longest_ + roundingOf(values)) * longest ? 1 : 0;
        if (length >= noise) {
            ++facts.directional;
            if (hasNormals) addDirection(band1(values), below * length + noise + roundingOf(values) * longest, normal, facts);
        }
        if (hasNormals && hasBand2(values)) addBands(sh, values, normal, {below, roundingOf(values)}, facts.bands);
    }

    /// far  of light from behind: its cosine to the normal times its length is below -far
    void addDirection(const glm::dvec3& light, double far, const glm::dvec3& normal, LightMapCounts& facts) const {
        for (int choice = 0; choice < formats::BakeAxes::kChoices; ++choice) {
            const double cosine = glm::dot(normal, formats::BakeAxes::choice(choice)(light));
            facts.behind[static_cast<std::size_t>(choice)] += cosine < -far ? 1 : 0;
        }
        // A file whose frame is "tangent" was turned to the world; otherwise its z would be along the normal.
        const double inOtherFrame =
            isTangent_ ? glm::dot(normal, glm::transpose(lighting::worldFromTangentFrame(normal)) * light) : light.z;
        facts.behindInOtherFrame += inOtherFrame < -far ? 1 : 0;
    }

    void addBands(const ShRgb& sh, const Luminances& values, const glm::dvec3& normal, const LightBounds& bounds, BandFacts& bands) const {
        const Moments moments = momentsOf(values, normal);
        const Moments other{otherQuantity_[0] * moments.f, otherQuantity_[1] * moments.g};
        ++bands.texels;
        bands.asDescribed += bounds.allow(moments, kBandNoise) ? 0 : 1;
        bands.otherQuantity += bounds.allow(other, kBandTolerance) ? 0 : 1;
        bands.decoded += bounds.allow(momentsOf(luminances(decodedGamma(sh), weights_), normal), kBandTolerance) ? 0 : 1;
    }

    bool isTangent_;
    glm::dvec3 weights_;
    double longest_;
    std::array<double, 2> otherQuantity_{};  ///< factors of bands 1 and 2 over that of band 0
};

}  // namespace

void LightMapCounts::merge(const LightMapCounts& other) {
    coverage += other.coverage;
    covered += other.covered;
    black += other.black;
    tooDirected += other.tooDirected;
    directional += other.directional;
    for (std::size_t i = 0; i < behind.size(); ++i) behind[i] += other.behind[i];
    behindInOtherFrame += other.behindInOtherFrame;
    bands.texels += other.bands.texels;
    bands.asDescribed += other.bands.asDescribed;
    bands.otherQuantity += other.bands.otherQuantity;
    bands.decoded += other.bands.decoded;
}

Result<ActionOutcome> lintLightMap(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<LightMapLintParameters>(context));
    LC_TRY(opened, openLightMap(context, parameters->description));
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
    LC_TRY(truth, GroundTruth::open(context, source, parameters->description.colors));
    const formats::BakeFormatInfo* const format = formats::findByName(formats::allBakeFormats(), facts.reading.bake);
    const PartCounter counter(*parameters, source.luminanceWeights(), format != nullptr ? format->longestDirection : 1);
    ChartScanner scanner(source.width(), parameters->description.fireflyLimit);
    double radianceSum = 0, logSum = 0;
    std::int64_t lit = 0;
    std::vector<verify::LightMapTruthPlace> traced;
    const std::string what = digestOf("lint", toJson(*parameters).dump(), source.luminanceWeights(), truth->digest());
    const auto merged = foldInOrder<Part>(
        source.chunkCount(), context, "lint " + context.action.asset,
        [&](int index) {
            return partOfChunk(source, index, context, what, [&](const formats::LightMapStrip& chunk) -> Result<Part> {
                Part part = counter.count(chunk, facts.hasNormals);
                LC_TRY(values, truth->within(chunk, chunk.firstRow, chunk.sh.height()));
                part.traced = lightMapPlaces(*values, chunk, chunk.sh, chunk.firstRow);
                return part;
            });
        },
        [&](const Part& part) {
            facts.merge(part.counts);
            radianceSum += part.radianceSum;
            logSum += part.logSum;
            lit += part.lit;
            scanner.add(part.charts);
            traced.insert(traced.end(), part.traced.begin(), part.traced.end());
        });
    if (!merged) return tl::make_unexpected(merged.error());
    if (facts.coverage.smallest > facts.coverage.largest) facts.coverage.smallest = facts.coverage.largest = 0;
    facts.key = lit > 0 ? std::exp(logSum / static_cast<double>(lit)) : 0.0;
    facts.meanRadiance = facts.covered > facts.black ? radianceSum / static_cast<double>(facts.covered - facts.black) : 0.0;
    facts.charts = scanner.finish();
    if (const auto ratio = verify::tracedRatio(traced)) {
        facts.tracedRatio = ratio->ratio;
        facts.isTracedSpecular = ratio->isSpecular;
    }
    return outcomeWith(facts);
}

}  // namespace lightcook::pipeline
