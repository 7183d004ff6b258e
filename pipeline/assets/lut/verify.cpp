#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <utility>

#include "fit/specular_tables.h"
#include "lighting/sphere.h"
#include "pipeline/assets/lut/light_moments.h"
#include "pipeline/assets/lut/lut.h"
#include "pipeline/assets/preview.h"
#include "pipeline/assets/verification.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/scene/scene.h"
#include "verify/lut.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// F0 of the surfaces that the tables shade: both ends of the range, a dielectric and a metal.
const std::vector<double> kTableF0 = {0.0, 0.04, 0.6, 1.0};
constexpr int kRandomTableSamples = 800;
/// Largest error of a texel, in steps of 16 bits: half a step of rounding, and some of the integration. Halves in [1/2, 1] are 2^-11
/// apart, 32 steps.
constexpr double kTableSteps = 0.75, kHalfTableSteps = 16.25;
/// Largest error of a coordinate, beside that of constants in single precision [texels].
constexpr double kCoordinateError = 1e-4;

verify::LutAxis axisOf(const LutConstants::Axis& axis) {
    return {axis.count, axis.minimum, axis.maximum, static_cast<float>(axis.scale), static_cast<float>(axis.offset), axis.factors};
}

/// Returns true if the factors of an axis are those of its name: an engine may go by either.
bool isKnownAxis(const LutConstants::Axis& axis, const std::vector<fit::AxisMapping>& mappings) {
    return std::ranges::any_of(
        mappings, [&](const fit::AxisMapping& mapping) { return axis.mapping == mapping.name && axis.factors == mapping.factors; });
}

/// Reads the tables of a manifest entry and its files.
Result<verify::CookedLut> readTables(const ActionContext& context, const CookedAsset& asset) {
    LC_TRY(constants, fromJson<LutConstants>(asset.constants.value_or(Json()), asset.name + ", constants"));
    if (!isKnownAxis(constants->view, fit::viewMappings()) || !isKnownAxis(constants->roughness, fit::roughnessMappings()))
        return failure(ErrorCode::Verification, context.action.asset + ", texture axes",
                       fmt::format("found {} and {}, expected known ones with their own factors", constants->view.mapping,
                                   constants->roughness.mapping));
    const std::string lobeName = asset.distribution.value_or(""), normalizationName = asset.normalization.value_or("");
    const auto* lobe = formats::findByName(formats::allSpecularLobes(), lobeName);
    const auto normalization = normalizationOf(normalizationName);
    if (lobe == nullptr || !normalization)
        return failure(ErrorCode::Verification, context.action.asset,
                       fmt::format("found distribution {} and normalization {}, expected {}, and energy or halo3", lobeName,
                                   normalizationName, formats::listOfNames(formats::allSpecularLobes())));
    verify::CookedLut tables;
    tables.lobe = lobe->id;
    tables.normalization = *normalization;
    tables.view = axisOf(constants->view);
    tables.roughness = axisOf(constants->roughness);
    for (std::size_t i = 0; i < kLutRoles.size(); ++i) {
        LC_TRY(texture, openTexture(context.upstreamFolder, asset, kLutRoles[i]));
        if (!isLutFormat(texture->shape().format))
            return failure(
                ErrorCode::Verification, fmt::format("{}, texture {}", context.action.asset, kLutRoles[i]),
                fmt::format("found texels of {}, expected rgba16-unorm or rgba16f", formats::info(texture->shape().format).name));
        LC_TRY(image, verify::decodeImage(*texture, {}));
        if (image->width() != tables.view.count || image->height() != tables.roughness.count)
            return failure(ErrorCode::Verification, fmt::format("{}, texture {}", context.action.asset, kLutRoles[i]),
                           fmt::format("found {} x {} texels, expected {} x {} as its axes", image->width(), image->height(),
                                       tables.view.count, tables.roughness.count));
        tables.textures[i] = std::move(*image);
        tables.tolerance[i] = verify::toleranceOf(texture->shape().format);
        tables.scale[i] = constants->scale[i];
        tables.bias[i] = constants->bias[i];
    }
    return tables;
}

/// Checks that no texel is farther from its kernel than rounding to the format of the textures explains.
std::vector<verify::Violation> checkSteps(const CookedAsset& asset, const verify::CookedLut& tables,
                                          const std::vector<verify::LutSample>& samples, const std::vector<verify::LutResult>& results) {
    const auto isHalf = [](const CookedTexture& texture) { return texture.format == formats::info(formats::PixelFormat::Rgba16f).name; };
    const double allowed = std::ranges::any_of(asset.textures, isHalf) ? kHalfTableSteps : kTableSteps;
    const verify::LutStepError worst = verify::lutStepError(tables, samples, results);
    if (!(worst.steps > allowed)) return {};
    return {{fmt::format("texture {}, channel {}, texel of NoV {:.4g} and m {:.4g}", kLutRoles[worst.entry / 4], worst.entry % 4, worst.NoV,
                         worst.m),
             fmt::format("an error of {:.4g} steps of 16 bits", worst.steps), fmt::format("at most {}", allowed),
             verify::lutPlace(tables, worst.NoV, worst.m)}};
}

/// Checks that the coordinates of both axes meet the centres of their texels. Any coordinate fetches the single value of an axis.
std::vector<verify::Violation> checkCoordinates(const verify::CookedLut& tables) {
    std::vector<verify::Violation> violations;
    for (const auto& [name, axis] : {std::pair("NoV", &tables.view), std::pair("m", &tables.roughness)}) {
        const double error = axis->coordinateError(), allowed = kCoordinateError + axis->coordinateRounding();
        if (axis->minimum < axis->maximum && !(error <= allowed))
            violations.push_back({fmt::format("axis of {}, coordinate of an outer texel", name),
                                  fmt::format("{:.4g} texels from its centre", error), fmt::format("at most {:.4g}", allowed)});
    }
    return violations;
}

/// Bounds the error of every cell between texels. Returns nothing after an interrupt.
std::optional<verify::LutBounds> boundTables(const verify::CookedLut& tables, const verify::LutKeys& keys, const verify::Viewing& viewing,
                                             const ActionContext& context) {
    std::vector<verify::LutBounds> bounds(static_cast<std::size_t>(tables.view.count - 1));
    const bool finished = forEachIndex(bounds.size(), context, "verify " + context.action.asset, [&](std::size_t cell) {
        const int viewCell = static_cast<int>(cell);
        bounds[cell] = verify::largestOf(tables, viewCell, verify::boundLut(tables, viewCell, keys, kTableF0, viewing), kTableF0);
    });
    if (!finished) return {};
    verify::LutBounds bound;
    for (const verify::LutBounds& each : bounds) bound.raise(each);
    return bound;
}

/// Draws the reflected light over NoV (grazing on the left) and m (smooth on top), over the range of the tables: the light of a constant
/// environment at F0 0.04, and the RMS error of all environments and F0 of the verdict. Returns nothing after an interrupt.
std::optional<Preview> drawTables(const verify::CookedLut& tables, double key, const ActionContext& context) {
    constexpr int kAcross = 96, kDown = 48;
    const std::vector<verify::SpecularKernelEntries> shadings = verify::lutShadings(kTableF0);
    const std::size_t shown = static_cast<std::size_t>(std::ranges::find(kTableF0, 0.04) - kTableF0.begin());
    const auto ends = [](const verify::LutAxis& axis) {
        return std::minmax({axis.inverse(axis.at(0)), axis.inverse(axis.at(axis.count - 1))});
    };
    const std::pair<double, double> rangeNoV = ends(tables.view), rangeM = ends(tables.roughness);
    Preview preview(kAcross, kDown, key);
    const bool finished = forEachIndex(kDown, context, "verify " + context.action.asset, [&](std::size_t row) {
        const double m = rangeM.first + (rangeM.second - rangeM.first) * (static_cast<double>(row) + 0.5) / kDown;
        for (int x = 0; x < kAcross; ++x) {
            const double NoV =
                std::max(verify::kSmallestTableNoV, rangeNoV.first + (rangeNoV.second - rangeNoV.first) * (x + 0.5) / kAcross);
            const verify::LutResult found = verify::compareLut(tables, {NoV, m, false, false});
            const auto reflected = [&](const verify::SpecularKernelEntries& k, std::size_t shading) {
                return std::inner_product(k.begin(), k.end(), shadings[shading].begin(), 0.0);
            };
            double squares = 0, errors = 0;
            for (std::size_t i = 0; i < shadings.size(); ++i) {
                const double truth = reflected(found.reference, i), error = reflected(found.cooked, i) - truth;
                squares += truth * truth;
                errors += error * error;
            }
            const auto count = static_cast<double>(shadings.size());
            const double light = std::sqrt(squares / count), off = std::sqrt(errors / count);
            preview.set(x, static_cast<int>(row), glm::vec3(static_cast<float>(light)), glm::vec3(static_cast<float>(light + off)));
            // The pictures keep the last light, the difference keeps the largest error.
            preview.set(x, static_cast<int>(row), glm::vec3(static_cast<float>(reflected(found.reference, shown))),
                        glm::vec3(static_cast<float>(reflected(found.cooked, shown))));
        }
    });
    if (!finished) return {};
    return preview;
}

/// Returns the moments of the kernels that the scene shades with: the views, m and F0 that its light maps are verified with. The verdict
/// is about all kernels of the tables, mostly those of grazing views; how much their error matters depends on the light of a map.
LightFigures momentsOf(const verify::CookedLut& tables, const verify::LightMapShading& shading) {
    std::vector<verify::LutSample> samples;
    for (int i = 0; i < shading.viewCount; ++i) {
        const double NoV = lighting::fibonacciHemisphere(i, shading.viewCount).z;
        for (const double m : shading.m) samples.push_back({NoV, m, false, false});
    }
    std::vector<verify::LutResult> results(samples.size());
    tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) { results[i] = verify::compareLut(tables, samples[i]); });
    const TableMoments moments = tableMoments(results, shading.f0);
    LightFigures light;
    light.kernelMoments.emplace(moments.reference.begin(), moments.reference.end());
    light.errorMoments.emplace(moments.error.begin(), moments.error.end());
    return light;
}

/// Returns the display on which exit radiance 1 is the key. Tables are shaded by lights of that strength, whatever a scene's light is: an
/// exit radiance that the scene shows as white says nothing about them.
verify::Viewing viewingAtKey(VisibleParameters visible) {
    if (visible.display) visible.display->white.reset();
    return visible.viewing(1, lighting::bt2020FromRec709());
}

}  // namespace

Result<ActionOutcome> verifyLut(const ActionContext& context) {
    const Stopwatch watch;
    LC_TRY(asset, upstreamAsset(context));
    LC_TRY(parameters, parametersOf<LutVerifyParameters>(context));
    LC_TRY(tables, readTables(context, *asset));
    const auto samples = verify::lutSamples(*tables, kRandomTableSamples, 1);
    std::vector<verify::LutResult> results(samples.size());
    if (!forEachIndex(samples.size(), context, "verify " + context.action.asset,
                      [&](std::size_t i) { results[i] = verify::compareLut(*tables, samples[i]); }))
        return interrupted(context);
    const verify::LutKeys keys = verify::lutKeys(samples, results, kTableF0);
    const verify::Viewing viewing = viewingAtKey(parameters->visible);
    const auto bound = boundTables(*tables, keys, viewing, context);
    if (!bound) return interrupted(context);
    const auto preview = drawTables(*tables, keys.shaded, context);
    if (!preview) return interrupted(context);
    std::vector<verify::Violation> violations = checkSteps(*asset, *tables, samples, results);
    std::ranges::move(checkCoordinates(*tables), std::back_inserter(violations));
    VerifyResult result = judged(verify::lutStages(*tables, samples, results, kTableF0, *bound, viewing), parameters->visible.limits, watch,
                                 std::move(violations));
    if (parameters->shading) result.light = momentsOf(*tables, *parameters->shading);
    return outcomeWithPreview(std::move(result), *preview, context);
}

}  // namespace lightcook::pipeline
