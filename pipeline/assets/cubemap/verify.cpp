#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>

#include "formats/vocabulary.h"
#include "lighting/cube.h"
#include "lighting/quadratic.h"
#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/assets/cubemap/levels.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/assets/verdict.h"
#include "pipeline/assets/verification.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/scene/cubemap_layout.h"
#include "verify/cubemap.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

constexpr int kSamplesBetween = 64;  ///< directions between texels, of each level

Result<verify::CookedCubemap> readCubemap(const ActionContext& context, const CookedAsset& asset) {
    LC_TRY(constants, fromJson<CubemapConstants>(asset.constants.value_or(Json()), asset.name + ", constants"));
    const CubemapLayoutInfo* const layout = cubemapLayoutFromName(asset.layout);
    if (layout == nullptr)
        return failure(ErrorCode::Verification, asset.name + ", layout",
                       fmt::format("found \"{}\", expected {}", asset.layout, formats::listOfNames(allCubemapLayouts())));
    const bool isDivided = layout->id == CubemapLayout::PreDivided;
    if (constants->isDivided() != isDivided)
        return failure(ErrorCode::Verification, asset.name + ", constants",
                       fmt::format("found {} denominator, expected {} of the layout \"{}\"", isDivided ? "no" : "a",
                                   isDivided ? "one" : "none", asset.layout));
    LC_TRY(texture, openTexture(context.upstreamFolder, asset, "cubemap"));
    const formats::TextureShape& shape = texture->shape();
    if (shape.faceCount != 6 || shape.mipCount != static_cast<int>(constants->mips.size()))
        return failure(
            ErrorCode::Verification, context.action.asset,
            fmt::format("found {} faces and {} mips, expected 6 and {}", shape.faceCount, shape.mipCount, constants->mips.size()));
    verify::CookedCubemap map;
    map.range = constants->range;
    map.isDivided = isDivided;
    map.windowedSh = constants->windowedSh;
    map.lobe = constants->kernel;
    map.tolerance = verify::toleranceOf(shape.format);
    for (int level = 0; level < shape.mipCount; ++level) {
        const CubemapConstants::Mip& entry = constants->mips[static_cast<std::size_t>(level)];
        verify::CookedCubemap::Mip mip;
        mip.m = entry.m;
        mip.bands = entry.bands;
        for (int face = 0; face < 6; ++face) {
            LC_TRY(image, verify::decodeImage(*texture, {level, 0, face}));
            mip.faces.push_back(std::move(*image));
        }
        map.mips.push_back(std::move(mip));
    }
    return map;
}

/// Returns the light that a pixel sees at texel centres, each level that a material reads alike. Of a divided map: over S, since the
/// pixel's own area specular replaces that of the probe.
LightFigures lightOf(const verify::CookedCubemap& map, const std::vector<verify::CubemapErrors>& all, int unreadLevels) {
    const std::span levels = std::span(all).subspan(static_cast<std::size_t>(unreadLevels));
    double references = 0, errors = 0;
    for (const verify::CubemapErrors& level : levels) {
        const double reference = level.ratios.referenceRms(), error = level.ratios.figures().relRms * reference;
        references += reference * reference;
        errors += error * error;
    }
    const double rms = std::sqrt(references / static_cast<double>(levels.size()));
    LightFigures light;
    if (!map.isDivided) {
        light.specularRms = rms;
        return light;
    }
    light.ratioRms = rms;
    light.ratioRelRms = references > 0 ? std::sqrt(errors / references) : 0;
    return light;
}

/// Compares the band factors of each mip with those of its kernel.
void checkBands(const verify::CookedCubemap& map, std::vector<verify::Violation>& violations) {
    for (std::size_t mip = 0; mip < map.mips.size(); ++mip) {
        const lighting::ShBands &found = map.mips[mip].bands, expected = verify::kernelBands(map.mips[mip].m, map.lobe);
        bool isRight = true;
        for (std::size_t l = 0; l < 3; ++l) isRight = isRight && std::abs(found[l] - expected[l]) <= verify::kBandTolerance;
        if (isRight) continue;
        violations.push_back({fmt::format("mip {}, band factors", mip), fmt::format("{:.4f}, {:.4f}, {:.4f}", found[0], found[1], found[2]),
                              fmt::format("{:.4f}, {:.4f}, {:.4f} of m {:.4f}", expected[0], expected[1], expected[2], map.mips[mip].m)});
    }
}

/// Returns the SH that a probe is divided by before the window: stored beside it, or of its image.
Result<std::array<glm::dvec3, lighting::kShCount>> incidentShOf(const verify::CubemapReference& reference, const Action& action) {
    const auto stored = action.inputs.find("sh");
    if (stored == action.inputs.end()) return reference.incidentSh();
    LC_TRY(given, formats::loadProbeSh(stored->second, action.inputs.at("source").filename().string()));
    std::array<glm::dvec3, lighting::kShCount> incident;
    std::ranges::copy(*given, incident.begin());
    return incident;
}

/// Compares the divisor of a map with the SH of its probe: stored texels and divisor may agree with each other and still have the energy of
/// another probe, which every pixel then shows. docs/theory/lighting.md, "Pre-divided cubemaps", describes the divisor.
class DivisorCheck {
public:
    DivisorCheck(const CubemapConstants& constants, std::vector<verify::Violation>& violations)
        : constants_(constants), window_(windowOf(constants.windowLambda)), violations_(violations) {}

    void check(const std::array<glm::dvec3, lighting::kShCount>& incident) {
        checkWindow();
        for (int channel = 0; channel < 3; ++channel) checkCoefficients(incident, channel);
        checkMinimum();
    }

private:
    static constexpr double kEpsilon = 0.05;           ///< least S over its mean
    static constexpr double kBlackDivisor = 1e-30;     ///< S of a channel without light
    static constexpr double kWindowTolerance = 1e-6;   ///< of factors in [0, 1] that are stored as doubles
    static constexpr double kShTolerance = 1e-3;       ///< over the largest coefficient: five times the error of incidentSh()
    static constexpr double kMinimumTolerance = 1e-3;  ///< of S over its mean: the coefficients are rounded to floats
    static constexpr double kWindowExcess = 1e-2;      ///< S over its mean that a window may leave above epsilon
    static constexpr double kLargestLambda = 0x1p39;   ///< S is constant beyond it, and lambda is not searched any more

    /// Returns the factors 1 / (1 + lambda l^2 (l + 1)^2) of the bands.
    static lighting::ShBands windowOf(double lambda) { return {1, 1 / (1 + 4 * lambda), 1 / (1 + 36 * lambda)}; }

    void checkWindow() {
        const double lambda = constants_.windowLambda;
        const lighting::ShBands &expected = window_, &found = constants_.window;
        bool isRight = lambda >= 0;
        for (std::size_t l = 0; l < 3; ++l) isRight = isRight && std::abs(found[l] - expected[l]) <= kWindowTolerance;
        if (!isRight)
            violations_.push_back(
                {"window", fmt::format("{:.6g}, {:.6g}, {:.6g}", found[0], found[1], found[2]),
                 fmt::format("{:.6g}, {:.6g}, {:.6g} of window_lambda {:.6g}", expected[0], expected[1], expected[2], lambda)});
        if (std::abs(constants_.epsilon - kEpsilon) > kWindowTolerance)
            violations_.push_back({"epsilon", fmt::format("{:.6g}", constants_.epsilon), fmt::format("{}", kEpsilon)});
    }

    void checkCoefficients(const std::array<glm::dvec3, lighting::kShCount>& incident, int channel) {
        const double mean = 0.5 * std::numbers::inv_sqrtpi * incident[0][channel];
        if (std::abs(mean - kBlackDivisor) <= 1e-2 * kBlackDivisor) return;  // black or not is a matter of rounding
        const bool isBlack = mean < kBlackDivisor;
        std::array<double, lighting::kShCount> expected{};
        double largest = 0;
        for (std::size_t i = 0; i < expected.size(); ++i) {
            const double coefficient = isBlack ? (i == 0 ? 2 * kBlackDivisor / std::numbers::inv_sqrtpi : 0) : incident[i][channel];
            expected[i] = coefficient * window_[static_cast<std::size_t>(lighting::kShBand[i])];
            largest = std::max(largest, std::abs(coefficient));
        }
        for (std::size_t i = 0; i < expected.size(); ++i) {
            const auto found = static_cast<double>(constants_.windowedSh[i][channel]);
            if (std::abs(found - expected[i]) <= kShTolerance * largest) continue;
            violations_.push_back({fmt::format("windowed_sh {}, channel {}", i, channel), fmt::format("{:.6g}", found),
                                   fmt::format("{:.6g} of the probe's SH and window_lambda", expected[i])});
            return;
        }
    }

    /// S stays above epsilon of its mean, and the window is no stronger than that takes.
    void checkMinimum() {
        double least = 1;
        for (const CubemapConstants::Mip& mip : constants_.mips)
            for (int channel = 0; channel < 3; ++channel) {
                lighting::ShDouble scaled{};
                const auto dc = static_cast<double>(constants_.windowedSh[0][channel]);
                if (!(dc > 0)) return;  // the bound is infinite
                for (std::size_t i = 0; i < scaled.size(); ++i) scaled[i] = static_cast<double>(constants_.windowedSh[i][channel]) / dc;
                const double mean = 0.5 * std::numbers::inv_sqrtpi * mip.bands[0];
                least = std::min(least, lighting::extremaOnSphere(lighting::sphereQuadratic(scaled, mip.bands)).minimum / mean);
            }
        const double lambda = constants_.windowLambda;
        if (least < kEpsilon - kMinimumTolerance)
            violations_.push_back({"least divisor over its mean", fmt::format("{:.4f}", least), fmt::format("at least {}", kEpsilon)});
        else if (lambda > 0 && lambda < kLargestLambda && least > kEpsilon + kWindowExcess)
            violations_.push_back({"window_lambda", fmt::format("{:.6g}, which keeps the divisor above {:.4f} of its mean", lambda, least),
                                   fmt::format("the smallest one that keeps it above {}", kEpsilon)});
    }

    const CubemapConstants& constants_;
    const lighting::ShBands window_;  ///< that the constants must have
    std::vector<verify::Violation>& violations_;
};

/// Checks the roughness of each level: an engine picks the level by perceptual roughness, whose square the kernel has.
void checkRoughness(const CubemapConstants& constants, std::vector<verify::Violation>& violations) {
    const double last = static_cast<double>(constants.mips.size()) - 1 + constants.firstLevel;
    for (std::size_t mip = 0; mip < constants.mips.size(); ++mip) {
        const double perceptual = constants.mips[mip].perceptualRoughness, m = constants.mips[mip].m;
        const auto complain = [&](const std::string& expected) {
            violations.push_back({fmt::format("mip {}, perceptual_roughness", mip), fmt::format("{}", perceptual), expected});
        };
        if (!(std::abs(perceptual * perceptual - m) <= 1e-6)) complain(fmt::format("the square root of m {}", m));
        // An engine finds the level of a roughness without this list, so the levels must be evenly spaced.
        const double level = static_cast<double>(mip) + constants.firstLevel;
        if (m > 0 && !(std::abs(perceptual * last - level) <= 1e-6 * last))
            complain(fmt::format("{} of level {} of 0 to {}", level / last, level, last));
    }
}

/// Checks that a map whose largest levels were left out has a level for the smoothest material.
void checkFirstLevel(const verify::CookedCubemap& map, double smoothest, std::vector<verify::Violation>& violations) {
    constexpr double kTolerance = 1e-6;
    const double first = map.mips.front().m;
    if (first > smoothest + kTolerance)
        violations.push_back(
            {"mip 0, m", fmt::format("{:.4f}", first), fmt::format("at most {:.4f} of the smoothest material", smoothest)});
}

}  // namespace

Result<ActionOutcome> verifyCubemap(const ActionContext& context) {
    const Stopwatch watch;
    LC_TRY(asset, upstreamAsset(context));
    LC_TRY(parameters, parametersOf<CubemapVerifyParameters>(context));
    const VisibleParameters& visible = parameters->visible;
    const formats::EnvironmentOptions options = environmentOptions(asset->source, context.action);
    LC_TRY(source, formats::loadEnvironment(context.action.inputs.at("source"), options));
    LC_TRY(colors, formats::linearConversion(options.colors));
    LC_TRY(map, readCubemap(context, *asset));

    const verify::CubemapReference reference(source->environment);
    const verify::Viewing viewing = visible.viewing(reference.displayKey(colors->luminanceWeights), colors->bt2020FromWorking);
    CubemapLevels levels(*map, source->environment, reference, glm::dot(reference.mean(), glm::dvec3(colors->luminanceWeights)), viewing);
    const std::vector<verify::CubemapSample> samples = verify::cubemapSamples(*map, kSamplesBetween);
    std::vector<verify::CubemapResult> results(samples.size());
    const std::string what = "verify " + context.action.asset;
    const std::size_t taskCount = levels.taskCount();
    const bool finished = forEachIndex(taskCount + samples.size(), context, what, [&](std::size_t index) {
        if (index < taskCount) return levels.run(index);
        const verify::CubemapSample& sample = samples[index - taskCount];
        results[index - taskCount] = verify::compareCubemap(*map, sample, levels.referenceOf(sample));
    });
    if (!finished || !forEachIndex(levels.faceCount(), context, what, [&](std::size_t face) { levels.compare(face); }))
        return interrupted(context);
    const std::vector<verify::CubemapErrors> errors = levels.errors();
    std::vector<verify::Violation> violations;
    checkBands(*map, violations);
    LC_TRY(constants, fromJson<CubemapConstants>(asset->constants.value_or(Json()), asset->name + ", constants"));
    checkRoughness(*constants, violations);
    if (map->isDivided) {
        LC_TRY(incident, incidentShOf(reference, context.action));
        DivisorCheck(*constants, violations).check(*incident);
    }
    if (parameters->smoothest) checkFirstLevel(*map, *parameters->smoothest, violations);
    VerifyResult result = judged(verify::cubemapStages(*map, reference, errors, samples, results, colors->luminanceWeights, viewing),
                                 visible.limits, watch, std::move(violations));
    result.light = lightOf(*map, errors, parameters->unreadLevels);
    return outcomeWithPreview(std::move(result), levels.preview(), context);
}

}  // namespace lightcook::pipeline
