#include "pipeline/lint/probe_facts.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>

#include "fit/environment_sh.h"
#include "formats/environment.h"
#include "formats/probe_place.h"
#include "pipeline/assets/results.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/lint/gamma.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;
using lighting::ShRgb;

/// Rounding of halves, in levels of 8 bits.
constexpr double kLevelTolerance = 0.07;
/// Fewest levels that tell 8 bits from a painted test image.
constexpr std::size_t kFewestLevels = 8;

double encodedSrgb(double value) {
    return value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

/// Returns true if every value under `curve` is one of 256 levels.
template <class Curve>
bool hasEightBits(const formats::Image<glm::vec3>& texels, Curve curve) {
    std::set<int> levels;
    for (const glm::vec3& texel : texels.texels())
        for (int channel = 0; channel < 3; ++channel) {
            const double level = 255 * curve(static_cast<double>(texel[channel]));
            if (level > 255 + kLevelTolerance || std::abs(level - std::round(level)) > kLevelTolerance) return false;
            levels.insert(static_cast<int>(std::round(level)));
        }
    return levels.size() >= kFewestLevels;
}

/// Returns the RMS of a difference over that of the expected SH. All light is a difference of 1 from SH without any.
double relativeDifference(const ShRgb& found, const ShRgb& expected) {
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const glm::dvec3 given(expected[i]), error = glm::dvec3(found[i]) - given;
        difference += glm::dot(error, error);
        sum += glm::dot(given, given);
    }
    if (sum > 0) return std::sqrt(difference / sum);
    return difference > 0 ? 1.0 : 0.0;
}

}  // namespace

Result<ActionOutcome> lintProbe(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<ProbeLintParameters>(context));
    const std::filesystem::path& file = context.action.inputs.at("source");
    const formats::ColorSpaces colors = withConfig(parameters->colors, context.action);
    LC_TRY(loaded, formats::loadEnvironment(file, {colors, parameters->repair}));
    formats::Environment& environment = loaded->environment;
    ProbeFacts facts;
    facts.primaries = formats::statedPrimaries(file, colors);
    const auto& texels = environment.texels.texels();
    const auto largestOf = [](const glm::vec3& texel) { return 1.0 * std::max({texel.x, texel.y, texel.z}); };
    for (const glm::vec3& texel : texels) facts.largest = std::max(facts.largest, largestOf(texel));
    const auto atLargest = std::ranges::count(texels, facts.largest, largestOf);
    facts.atLargest = static_cast<double>(atLargest) / static_cast<double>(texels.size());
    facts.isEightBit =
        hasEightBits(environment.texels, [](double value) { return value; }) || hasEightBits(environment.texels, encodedSrgb);
    const ShRgb projected = fit::projectEnvironment(environment);
    facts.meanRadiance = glm::dot(glm::dvec3(projected[0]), glm::dvec3(lighting::kRec709Luminance)) / std::sqrt(4 * std::numbers::pi);
    if (const auto sh = context.action.inputs.find("sh"); sh != context.action.inputs.end()) {
        LC_TRY(given, formats::loadProbeSh(sh->second, parameters->probeFile.value_or("")));
        // The cook refuses it, too.
        LC_CHECK(formats::loadProbePlace(sh->second, parameters->probeFile.value_or("")));
        facts.shDifference = relativeDifference(projected, *given);
        for (glm::vec3& texel : environment.texels.texels())
            for (int channel = 0; channel < 3; ++channel) texel[channel] = static_cast<float>(std::pow(texel[channel], kGamma));
        facts.shDifferenceDecoded = relativeDifference(fit::projectEnvironment(environment), *given);
    }
    return outcomeWith(facts);
}

}  // namespace lightcook::pipeline
