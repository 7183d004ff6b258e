// LightMapMeasure: statistics of a map, texel by texel. Sums are integers and extremes, so that they do not depend on the order of texels.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "compress/light_map.h"
#include "compress/light_map/linear_fit.h"
#include "lighting/radiometry.h"

namespace lightcook::compress {

namespace {

/// Clamp of ratios, as a multiple of the bound of non-negative light.
constexpr float kRatioAllowance = 1.25f;
/// |band l| / lambda_0 of non-negative light is at most sqrt(2l + 1).
constexpr std::array<float, 3> kRatioBound = {1.0f, 1.7320508f, 2.2360680f};
constexpr double kLogUnits = 1 << 24;  ///< units of logLuminanceSum_ in 1

float largestAbsolute(const glm::vec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

void SharedExitRange::merge(const SharedExitRange& other) {
    lowestLight = std::min(lowestLight, other.lowestLight);
    highestLight = std::max(highestLight, other.highestLight);
    lowestChroma = glm::min(lowestChroma, other.lowestChroma);
    highestChroma = glm::max(highestChroma, other.highestChroma);
    lowestSlope = glm::min(lowestSlope, other.lowestSlope);
    highestSlope = glm::max(highestSlope, other.highestSlope);
}

LightMapMeasure::LightMapMeasure(const glm::vec3& luminanceWeights, bool hasSharedExit)
    : luminanceWeights_(luminanceWeights), hasSharedExit_(hasSharedExit) {}

void LightMapMeasure::add(const formats::LightMapStrip& strip, int firstRow, int rowCount) {
    assert(firstRow >= strip.firstRow && firstRow + rowCount <= strip.firstRow + strip.sh.height());
    for (int y = firstRow - strip.firstRow; y < firstRow - strip.firstRow + rowCount; ++y)
        for (int x = 0; x < strip.sh.width(); ++x)
            if (strip.covered.at(x, y) != 0) addTexel(strip.sh.at(x, y), strip.normal.at(x, y));
}

void LightMapMeasure::addTexel(const lighting::ShRgb& sh, const glm::vec3& normal) {
    ++coveredTexels_;
    const glm::vec3 exit = lighting::evaluate(lighting::convolve(sh, lighting::kExitRadianceBands), normal);
    const double logLuminance = std::log(std::max(static_cast<double>(glm::dot(exit, luminanceWeights_)), 1e-12));
    logLuminanceSum_ += std::llround(logLuminance * kLogUnits);
    maximumExit_ = std::max({maximumExit_, exit.x, exit.y, exit.z});
    for (std::size_t i = 0; i < sh.size(); ++i) maximumAbsolute_[i] = std::max(maximumAbsolute_[i], largestAbsolute(sh[i]));
    for (int channel = 0; channel < 3; ++channel) addRatios(sh, channel);
    if (hasSharedExit_) addSharedExit(sh, normal);
}

void LightMapMeasure::addRatios(const lighting::ShRgb& sh, int channel) {
    const float dc = sh[0][channel];
    std::array<float, 3> squared{};
    for (std::size_t i = 1; i < sh.size(); ++i) {
        const auto band = static_cast<std::size_t>(lighting::kShBand[i]);
        squared[band] += sh[i][channel] * sh[i][channel];
        if (!(dc > 0)) continue;
        const float bound = kRatioAllowance * kRatioBound[band];
        const float ratio = std::clamp(sh[i][channel] / dc, -bound, bound);
        minimumRatio_[i] = std::min(minimumRatio_[i], ratio);
        maximumRatio_[i] = std::max(maximumRatio_[i], ratio);
    }
    const float limit = 1.001f * std::max(dc, 0.0f);
    if (std::sqrt(squared[1]) > limit * kRatioBound[1] || std::sqrt(squared[2]) > limit * kRatioBound[2]) ++beyondPositiveBounds_;
}

std::size_t LightMapMeasure::octaveOf(float light) {
    return light > 0 ? static_cast<std::size_t>(std::clamp(std::ilogb(light) - kLowestOctave, 0, kOctaves - 1)) : 0;
}

void LightMapMeasure::addSharedExit(const lighting::ShRgb& sh, const glm::vec3& normal) {
    const rows::LinearFit fit(normal);
    const rows::LinearExits best = fit.best(sh);
    // One round, from constants that hold the slopes, is accurate enough for a range: the encoder solves within it.
    glm::dvec3 start;
    for (std::size_t c = 0; c < best.size(); ++c) {
        const glm::dvec3 linear = glm::abs(best[c].linear);
        const double least = std::max({linear.x, linear.y, linear.z}) / rows::kLargestSharedSlope;
        start[static_cast<glm::dvec3::length_type>(c)] = std::max(best[c].constant, least);
    }
    const rows::SharedExit exit =
        fit.shared(best, start, {glm::dvec3(-rows::kLargestSharedSlope), glm::dvec3(rows::kLargestSharedSlope)}, 1);
    const auto light = static_cast<float>(std::max({exit.constant.x, exit.constant.y, exit.constant.z}));
    SharedExitRange range;
    range.lowestLight = range.highestLight = light;
    if (light > 0) {
        range.lowestChroma = range.highestChroma = glm::vec3(exit.constant) / light;
        range.lowestSlope = range.highestSlope = glm::vec3(exit.slope);
    }
    sharedExit_[octaveOf(light)].merge(range);
}

SharedExitRange LightMapMeasure::sharedExitRange(float leastLight) const {
    assert(hasSharedExit_);
    SharedExitRange range;
    for (std::size_t octave = octaveOf(leastLight); octave < sharedExit_.size(); ++octave) range.merge(sharedExit_[octave]);
    return range;
}

void LightMapMeasure::merge(const LightMapMeasure& other) {
    coveredTexels_ += other.coveredTexels_;
    beyondPositiveBounds_ += other.beyondPositiveBounds_;
    logLuminanceSum_ += other.logLuminanceSum_;
    maximumExit_ = std::max(maximumExit_, other.maximumExit_);
    for (std::size_t i = 0; i < maximumAbsolute_.size(); ++i) {
        maximumAbsolute_[i] = std::max(maximumAbsolute_[i], other.maximumAbsolute_[i]);
        minimumRatio_[i] = std::min(minimumRatio_[i], other.minimumRatio_[i]);
        maximumRatio_[i] = std::max(maximumRatio_[i], other.maximumRatio_[i]);
    }
    for (std::size_t octave = 0; octave < sharedExit_.size(); ++octave) sharedExit_[octave].merge(other.sharedExit_[octave]);
}

double LightMapMeasure::key() const {
    return coveredTexels_ == 0 ? 0 : std::exp(static_cast<double>(logLuminanceSum_) / kLogUnits / static_cast<double>(coveredTexels_));
}

}  // namespace lightcook::compress
