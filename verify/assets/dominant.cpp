#include "verify/dominant.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <span>

#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "verify/assets/dominant_specular.h"
#include "verify/assets/surface_quad.h"
#include "verify/error/visible_metric.h"

namespace lightcook::verify {
namespace {

/// Returns the largest value of Beckmann's distribution over all angles: at the peak for m^2 <= 1/2, else on a ring around it. It falls
/// with m, so the smallest m of a range bounds the range.
double largestBeckmann(double m) {
    const double squared = m * m;
    return squared <= 0.5 ? 1 / (std::numbers::pi * squared) : 4 * squared * std::exp(1 / squared - 2) / std::numbers::pi;
}

/// Returns the same of GGX: it falls with the angle for every m up to 1, and its peak falls with m.
double largestGgx(double m) {
    return 1 / (std::numbers::pi * m * m);
}

/// Returns an upper bound of the reflected radiance over views, F0 and roughnesses of at least m. Apart from intensity and D,
/// NoL f = G F / (4 NoV), and G / (4 NoV) <= NoH^2 / (NoL + NoV) <= 1 / NoL because V + L = 2 VoH H.
double largestSpecular(const glm::dvec3& direction, double intensity, const glm::dvec3& normal, double m,
                       lighting::NormalDistribution lobe) {
    const double length = glm::length(direction);
    const double NoL = length > 0 ? glm::dot(direction, normal) / length : 1;
    const double largest = lobe == lighting::NormalDistribution::Ggx ? largestGgx(m) : largestBeckmann(m);
    return NoL > 0 && intensity > 0 ? intensity * largest / NoL : 0;
}

double luminanceOf(const glm::dvec3& color, const glm::vec3& weights) {
    return glm::dot(color, glm::dvec3(weights));
}

}  // namespace

struct DominantVerifier::Place {
    double x = 0, y = 0;  ///< [texels]
    glm::dvec3 normal{0, 0, 1};
    DominantLightSample reference, seen;

    /// Returns the place of an error of this light in one channel.
    ErrorPlace at(int channel) const {
        ErrorPlace place;
        place.x = x;
        place.y = y;
        place.channel = channel;
        place.normal = normal;
        return place;
    }
    /// Adds bounds over all views, F0 and roughnesses of at least smallestM. Stored and reference light may have different directions:
    /// either may be 0 where the other is largest.
    void addBounds(double smallestM, lighting::NormalDistribution lobe, double floor, ErrorAccumulator& errors) const {
        for (int channel = 0; channel < 3; ++channel) {
            const double found = largestSpecular(seen.direction, seen.intensity[channel], normal, smallestM, lobe);
            const double truth = largestSpecular(reference.direction, reference.intensity[channel], normal, smallestM, lobe);
            // The bound covers every view, so there is no light of one view to report beside it.
            const auto bound = [&](double local) {
                ErrorPlace worst = at(channel);
                worst.m = smallestM;
                worst.local = local;
                errors.addBound(local, worst);
            };
            constexpr double kRounding = 1 + 1e-4;  // of the shader's floats
            if (found > 0) bound(found / floor * kRounding);
            if (truth > 0) bound(truth / (truth + floor) * kRounding);
        }
    }
};

struct DominantVerifier::Highlights {
    struct Sample {
        glm::vec3 view;
        double m = 0, f0 = 0;
    };
    std::vector<Sample> samples;                          ///< of the place that was shaded last
    std::size_t stride;                                   ///< samples of a plane
    std::vector<float> reference, seen;                   ///< [channel][sample]
    std::vector<float> shownReference, shownSeen, apart;  ///< on the display

    explicit Highlights(const DominantShading& shading)
        : stride((static_cast<std::size_t>(shading.viewCount) * shading.m.size() * shading.f0.size() + kLanes - 1) / kLanes * kLanes),
          reference(3 * stride),
          seen(3 * stride),
          shownReference(3 * stride),
          shownSeen(3 * stride),
          apart(stride) {
        samples.reserve(stride);
    }
    void add(const Sample& sample, const glm::vec3& trueLight, const glm::vec3& seenLight) {
        for (int channel = 0; channel < 3; ++channel) {
            const std::size_t at = static_cast<std::size_t>(channel) * stride + samples.size();
            reference[at] = trueLight[channel];
            seen[at] = seenLight[channel];
        }
        samples.push_back(sample);
    }
    glm::dvec3 lightOf(const std::vector<float>& planes, std::size_t sample) const {
        return {planes[sample], planes[stride + sample], planes[2 * stride + sample]};
    }

private:
    static constexpr std::size_t kLanes = DisplayTransform::kLanes;
};

int dominantStride(int width, int height) {
    constexpr double kTexels = 1 << 18;
    const double texels = static_cast<double>(width) * height;
    return std::max(1, static_cast<int>(std::ceil(std::sqrt(texels / kTexels))));
}

void HighlightErrors::merge(const HighlightErrors& other) {
    energy.merge(other.energy);
    visible.merge(other.visible);
}

ErrorFigures HighlightErrors::figures() const {
    ErrorFigures figures = energy.figures();
    if (visible.sampleCount() > 0) figures.visible = visible.figures();
    return figures;
}

void DominantErrors::merge(const DominantErrors& other) {
    centres_.merge(other.centres_);
    between_.merge(other.between_);
    angleSum_ += other.angleSum_;
    weightSum_ += other.weightSum_;
    largestAngle_ = std::max(largestAngle_, other.largestAngle_);
    storedError_ += other.storedError_;
    referenceError_ += other.referenceError_;
    energy_ += other.energy_;
    visibleBound_ = std::max(visibleBound_, other.visibleBound_);
}

std::vector<StageError> DominantErrors::stages() const {
    std::vector<StageError> stages = {{"magnified", {}, between_.figures(), 0}, {"total", {}, centres_.figures(), 0}};
    // The verdict: texel centres, raised to the maxima between them.
    takeLarger(stages[1].specular, stages[0].specular);
    std::optional<VisibleFigures>& visible = stages[1].specular.visible;
    if (!visible || !visibleBound_) return stages;
    // Light that is not finite has no bound.
    visible->bound = visible->max <= *visibleBound_ ? *visibleBound_ : std::numeric_limits<double>::infinity();
    visible->boundAt = visible->maxAt;
    visible->boundAt.difference = *visible->bound;
    return stages;
}

double DominantErrors::meanDirectionError() const {
    return weightSum_ > 0 ? angleSum_ / weightSum_ : 0;
}

double DominantErrors::maxDirectionError() const {
    return largestAngle_;
}

DominantVerifier::DominantVerifier(const CookedDominant& map, const DominantShading& shading, const glm::vec3& luminanceWeights, double key,
                                   const std::optional<Viewing>& viewing)
    : map_(map), shading_(shading), luminanceWeights_(luminanceWeights), key_(key) {
    if (!viewing) return;
    display_.emplace(*viewing, 1);
    mostVisible_ = VisibleMetric(*viewing, 1).mostVisible();
}

DominantRowRange dominantRowsFor(const CookedDominant& map, double first, double last) {
    const auto rowOf = [](double place) { return static_cast<int>(std::floor(place)); };
    const int top = std::clamp(rowOf(first), 0, map.height - 1), bottom = std::clamp(rowOf(last) + 1, 0, map.height - 1);
    return {top, bottom - top + 1};
}

DominantLightSample DominantVerifier::decodeTexel(const DecodedDominantRows& texels, int x, int y) const {
    const glm::vec3 direction(texels.direction.at(x, y - texels.firstRow)), intensity(texels.intensity.at(x, y - texels.firstRow));
    return {glm::dvec3(map_.directionScale * direction + map_.directionBias), glm::dvec3(map_.intensityRange * intensity)};
}

DominantLightSample DominantVerifier::decode(const DecodedDominantRows& texels, double x, double y) const {
    const double u = std::clamp(x, 0.0, map_.width - 1.0), v = std::clamp(y, 0.0, map_.height - 1.0);
    const int left = static_cast<int>(u), top = static_cast<int>(v);
    const double right = u - left, below = v - top;
    DominantLightSample sum;
    for (int corner = 0; corner < 4; ++corner) {
        const double weight = (corner % 2 == 0 ? 1 - right : right) * (corner / 2 == 0 ? 1 - below : below);
        if (weight == 0) continue;
        const DominantLightSample texel = decodeTexel(texels, left + corner % 2, top + corner / 2);
        sum.direction += weight * texel.direction;
        sum.intensity += weight * texel.intensity;
    }
    return sum;
}

void DominantVerifier::shade(const Place& place, Highlights& highlights, HighlightErrors& errors) const {
    if (place.seen.intensity == glm::dvec3(0) && place.reference.intensity == glm::dvec3(0)) {
        const auto count = static_cast<std::size_t>(shading_.viewCount) * shading_.m.size() * shading_.f0.size();
        errors.energy.addDark(3 * count);
        if (display_) errors.visible.addExact(count);
        return;
    }
    highlights.samples.clear();
    const glm::dmat3 frame = lighting::worldFromTangentFrame(place.normal);
    const glm::vec3 normal(place.normal), trueDirection(place.reference.direction), trueIntensity(place.reference.intensity);
    for (int i = 0; i < shading_.viewCount; ++i) {
        const glm::vec3 view(frame * lighting::fibonacciHemisphere(i, shading_.viewCount));
        for (const double m : shading_.m)
            for (const double f0 : shading_.f0) {
                const auto shaded = [&](const glm::vec3& direction, const glm::vec3& intensity) {
                    return dominantSpecular(shading_.lobe, view, direction, intensity, normal, static_cast<float>(m),
                                            glm::vec3(static_cast<float>(f0)));
                };
                const glm::vec3 reference = shaded(trueDirection, trueIntensity),
                                seen = shaded(glm::vec3(place.seen.direction), glm::vec3(place.seen.intensity));
                for (int channel = 0; channel < 3; ++channel)
                    errors.energy.add(reference[channel], seen[channel], [&] {
                        ErrorPlace worst = place.at(channel);
                        worst.view = glm::dvec3(view);
                        worst.m = m;
                        worst.f0 = f0;
                        return worst;
                    });
                highlights.add({view, m, f0}, reference, seen);
            }
    }
    place.addBounds(*std::min_element(shading_.m.begin(), shading_.m.end()), shading_.lobe, lighting::kLocalErrorFloor * key_,
                    errors.energy);
    if (display_) addVisible(place, highlights, errors.visible);
}

void DominantVerifier::addVisible(const Place& place, Highlights& highlights, VisibleAccumulator& errors) const {
    display_->apply(highlights.reference.data(), highlights.stride, highlights.shownReference.data());
    display_->apply(highlights.seen.data(), highlights.stride, highlights.shownSeen.data());
    visibleDifferences(highlights.shownReference.data(), highlights.shownSeen.data(), highlights.stride, highlights.apart.data());
    const auto differences = std::span(highlights.apart).first(highlights.samples.size());
    const double before = errors.largest();
    errors.add(differences);
    if (!(errors.largest() > before)) return;
    const auto largest = std::ranges::max_element(differences);
    const auto at = static_cast<std::size_t>(largest - differences.begin());
    const Highlights::Sample& sample = highlights.samples[at];
    errors.setMaxAt({.x = place.x,
                     .y = place.y,
                     .normal = place.normal,
                     .view = glm::dvec3(sample.view),
                     .m = sample.m,
                     .f0 = sample.f0,
                     .reference = highlights.lightOf(highlights.reference, at),
                     .found = highlights.lightOf(highlights.seen, at),
                     .difference = static_cast<double>(*largest)});
}

DominantLightSample DominantVerifier::reference(const lighting::ShRgb& incident, const glm::dvec3& normal,
                                                const DominantLightSample& seen) const {
    if (map_.fit == DominantFit::Closed) return dominantReference(incident, normal, luminanceWeights_);
    if (map_.fit == DominantFit::Explained) return explainedReference(incident, normal, luminanceWeights_, seen.direction);
    return refinedReference(incident, normal, luminanceWeights_, map_.fit == DominantFit::RefinedAmbient, seen.direction);
}

void DominantVerifier::addTexel(const Place& place, const lighting::ShRgb& incident, Highlights& highlights, DominantErrors& errors) const {
    shade(place, highlights, errors.centres_);
    const bool hasAmbient = map_.fit == DominantFit::RefinedAmbient;
    const Unexplained stored = unexplainedBy(incident, place.seen, hasAmbient);
    errors.storedError_ += stored.error;
    errors.referenceError_ += unexplainedBy(incident, place.reference, hasAmbient).error;
    errors.energy_ += stored.energy;
    const double weight = luminanceOf(place.reference.intensity, luminanceWeights_);
    const double length = glm::length(place.seen.direction);
    if (!(weight > 0) || !(length > 0)) return;
    const glm::dvec3 a = place.seen.direction / length, b = glm::normalize(place.reference.direction);
    const double angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / std::numbers::pi;
    errors.angleSum_ += weight * angle;
    errors.weightSum_ += weight;
    errors.largestAngle_ = std::max(errors.largestAngle_, angle);
}

DominantErrors DominantVerifier::verifyRows(const DecodedDominantRows& texels, const formats::LightMapStrip& strip, int firstRow,
                                            int rowCount) const {
    DominantErrors errors(key_);
    errors.visibleBound_ = mostVisible_;
    Highlights highlights(shading_);
    const auto covered = [&](int x, int y) { return strip.covered.at(x, y - strip.firstRow) != 0; };
    const auto shAt = [&](int x, int y) -> const lighting::ShRgb& { return strip.sh.at(x, y - strip.firstRow); };
    const auto normalAt = [&](int x, int y) { return glm::dvec3(strip.normal.at(x, y - strip.firstRow)); };
    for (int y = firstRow; y < firstRow + rowCount; ++y)
        for (int x = 0; x < map_.width; ++x) {
            if (!covered(x, y)) continue;
            Place place{static_cast<double>(x), static_cast<double>(y), normalAt(x, y), {}, decode(texels, x, y)};
            place.reference = reference(shAt(x, y), place.normal, place.seen);
            addTexel(place, shAt(x, y), highlights, errors);
            if (x % shading_.stride != 0 || y % shading_.stride != 0) continue;
            if (x + 1 >= map_.width || y + 1 >= map_.height || !holdsSurface(strip, x, y - strip.firstRow)) continue;
            Place middle;
            middle.x = x + 0.5;
            middle.y = y + 0.5;
            middle.seen = decode(texels, middle.x, middle.y);
            middle.normal = glm::dvec3(0);
            lighting::ShRgb sh{};
            for (int corner = 0; corner < 4; ++corner) {
                const int cornerX = x + corner % 2, cornerY = y + corner / 2;
                middle.normal += normalAt(cornerX, cornerY);
                for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += 0.25f * shAt(cornerX, cornerY)[i];
            }
            const double length = glm::length(middle.normal);
            if (length < 1e-3) continue;  // opposite normals: no surface between these charts
            middle.normal /= length;
            middle.reference = reference(sh, middle.normal, middle.seen);
            shade(middle, highlights, errors.between_);
        }
    return errors;
}

}  // namespace lightcook::verify
