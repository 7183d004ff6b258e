#include "verify/ground_truth.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "lighting/brdf.h"
#include "lighting/display.h"
#include "lighting/radiometry.h"
#include "verify/assets/dominant_specular.h"

namespace lightcook::verify {
namespace {

using Kind = formats::ShadingValue::Kind;

shaders::LcSh shaderSh(const lighting::ShRgb& sh) {
    shaders::LcSh out;
    for (std::size_t i = 0; i < sh.size(); ++i) out.c[i] = sh[i];
    return out;
}

/// Cache of kernels by view and roughness: files repeat a few values of each.
class Kernels {
public:
    explicit Kernels(lighting::NormalDistribution lobe) : lobe_(lobe) {}
    const lighting::AreaSpecularKernel& at(double NoV, double m) {
        constexpr int kSamples = 256;
        const auto [kernel, isNew] = kernels_.try_emplace({std::lround(NoV / kStep), m});
        if (isNew)
            kernel->second = lighting::integrateAreaSpecular(static_cast<double>(kernel->first.first) * kStep, m, lobe_,
                                                             lighting::CookTorranceNormalization::Energy, kSamples);
        return kernel->second;
    }

private:
    static constexpr double kStep = 1e-3;  ///< step of NoV
    lighting::NormalDistribution lobe_;
    std::map<std::pair<long, double>, lighting::AreaSpecularKernel> kernels_;
};

glm::dvec3 areaSpecular(const shaders::LcSh& sh, const formats::ShadingValue& value, const glm::dvec3& normal, Kernels& kernels) {
    const double NoV = glm::dot(normal, value.direction);
    if (NoV <= 0) return glm::dvec3(0);
    const shaders::LcFrame frame = shaders::lcViewFrame(glm::vec3(normal), glm::vec3(value.direction));
    const shaders::LcSh local = shaders::lcLocalSh(sh, frame.x, frame.y, frame.z);
    const lighting::AreaSpecularKernel& kernel = kernels.at(NoV, value.m);
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < lighting::kShCount; ++i)
        sum += (value.f0 * kernel.c[i] + (1 - value.f0) * kernel.d[i]) * glm::dvec3(local.c[i]);
    return sum;
}

glm::dvec3 analyticSpecular(const DominantLightSample& light, const formats::ShadingValue& value, const glm::dvec3& normal,
                            lighting::NormalDistribution lobe) {
    return glm::dvec3(dominantSpecular(lobe, glm::vec3(value.direction), glm::vec3(light.direction), glm::vec3(light.intensity),
                                       glm::vec3(normal), static_cast<float>(value.m), glm::vec3(static_cast<float>(value.f0))));
}

/// Adds the visible errors of one value.
void addVisible(const glm::dvec3& truth, const glm::dvec3& fromFloats, const glm::dvec3& fromCooked, const std::optional<Viewing>& viewing,
                TruthVisible& errors) {
    if (!viewing) return;
    const auto add = [&](const glm::dvec3& reference, VisibleAccumulator& accumulator) {
        const auto apart =
            static_cast<float>(lighting::visibleDifference(reference, fromCooked, viewing->display, viewing->bt2020FromWorking));
        accumulator.add(std::span(&apart, 1));
    };
    add(fromFloats, errors.cooking);
    add(truth, errors.total);
}

}  // namespace

void TruthSums::add(const glm::dvec3& truth, const glm::dvec3& fromFloats, const glm::dvec3& fromCooked) {
    const auto square = [](const glm::dvec3& v) { return glm::dot(v, v); };
    ++count_;
    truth_ += square(truth);
    model_ += square(fromFloats - truth);
    cooking_ += square(fromCooked - fromFloats);
    total_ += square(fromCooked - truth);
}

void TruthSums::merge(const TruthSums& other) {
    count_ += other.count_;
    truth_ += other.truth_;
    model_ += other.model_;
    cooking_ += other.cooking_;
    total_ += other.total_;
}

TruthErrors TruthSums::errors() const {
    const auto relative = [&](double squares) {
        constexpr double kLargest = std::numeric_limits<double>::max();
        const double error = squares == 0 ? 0 : std::sqrt(squares / truth_);
        return error <= kLargest ? error : kLargest;
    };
    return {relative(model_), relative(cooking_), relative(total_)};
}

LightMapTruth lightMapTruth(std::span<const LightMapTruthPlace> places, lighting::NormalDistribution lobe,
                            const std::optional<Viewing>& viewing) {
    LightMapTruth truth;
    Kernels kernels(lobe);
    for (const LightMapTruthPlace& place : places) {
        const formats::ShadingValue& value = place.value;
        if (value.kind == Kind::Lambert) {
            const glm::dvec3 fromFloats(lighting::irradiance(place.baked, glm::vec3(value.direction)).value),
                fromCooked(shaders::lcIrradiance(shaderSh(place.cooked), glm::vec3(value.direction)));
            truth.lambert.add(value.value, fromFloats, fromCooked);
            constexpr double kExit = std::numbers::inv_pi;  // exit radiance of a white surface from irradiance
            addVisible(kExit * value.value, kExit * fromFloats, kExit * fromCooked, viewing, truth.visibleLambert);
        } else
            truth.areaSpecular[value.m].add(value.value, areaSpecular(shaderSh(place.baked), value, place.normal, kernels),
                                            areaSpecular(shaderSh(place.cooked), value, place.normal, kernels));
    }
    return truth;
}

std::optional<TracedRatio> tracedRatio(std::span<const LightMapTruthPlace> places) {
    constexpr std::size_t kLeastPlaces = 8, kMostPlaces = 4096;  // further ones change a median little
    constexpr double kDarkest = 0.05;
    constexpr double kLeastShown = 0.3;
    const auto isLambert = [](const LightMapTruthPlace& place) { return place.value.kind == Kind::Lambert; };
    const Kind kind = std::ranges::any_of(places, isLambert) ? Kind::Lambert : Kind::Specular;
    std::vector<const LightMapTruthPlace*> chosen;
    for (const LightMapTruthPlace& place : places)
        if (place.value.kind == kind) chosen.push_back(&place);
    const std::size_t step = chosen.size() / kMostPlaces + 1;
    const auto sumOfColors = [](const glm::dvec3& light) { return light.x + light.y + light.z; };
    struct Pair {
        double traced = 0, baked = 0, all = 0;
    };
    std::vector<Pair> pairs;
    Kernels kernels(lighting::NormalDistribution::Beckmann);  // another lobe is no matter of units
    double mean = 0;
    for (std::size_t i = 0; i < chosen.size(); i += step) {
        const auto& [value, normal, baked, cooked] = *chosen[i];
        const glm::dvec3 light = kind == Kind::Lambert ? glm::dvec3(lighting::irradiance(baked, glm::vec3(value.direction)).value)
                                                       : areaSpecular(shaderSh(baked), value, normal, kernels);
        const double all = kind == Kind::Lambert ? std::sqrt(4 * std::numbers::pi) * sumOfColors(glm::dvec3(baked[0])) : 0;
        pairs.push_back({sumOfColors(value.value), sumOfColors(light), all});
        mean += std::max(pairs.back().baked, 0.0);
    }
    mean /= static_cast<double>(std::max<std::size_t>(pairs.size(), 1));
    std::vector<double> ratios;
    for (const auto& [traced, baked, all] : pairs)
        if (baked > kDarkest * mean && baked > kLeastShown * all) ratios.push_back(traced / baked);
    if (ratios.size() < kLeastPlaces) return std::nullopt;
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::ranges::nth_element(ratios, middle);
    return TracedRatio{*middle, kind == Kind::Specular};
}

DominantTruth dominantTruth(std::span<const DominantTruthPlace> places, lighting::NormalDistribution lobe,
                            const std::optional<Viewing>& viewing) {
    DominantTruth truth;
    Kernels kernels(lobe);
    for (const DominantTruthPlace& place : places) {
        const formats::ShadingValue& value = place.value;
        const glm::dvec3 one = analyticSpecular(place.fitted, value, place.normal, lobe);
        const glm::dvec3 two =
            analyticSpecular(place.two[0], value, place.normal, lobe) + analyticSpecular(place.two[1], value, place.normal, lobe);
        const auto whole = [&](const DominantLightSample& light) {
            const glm::vec3 towards = shaders::lcDominantDirection(glm::vec3(light.direction), glm::vec3(place.normal));
            const shaders::LcSh rest = shaders::lcWithoutLight(shaderSh(place.baked), towards, glm::vec3(light.intensity));
            return analyticSpecular(light, value, place.normal, lobe) + areaSpecular(rest, value, place.normal, kernels);
        };
        const glm::dvec3 area = areaSpecular(shaderSh(place.baked), value, place.normal, kernels);
        const glm::dvec3 wholeOfFloats = whole(place.fitted), wholeOfCooked = whole(place.cooked);
        truth.withRest[value.m].add(value.value, wholeOfFloats, wholeOfCooked);
        addVisible(value.value, wholeOfFloats, wholeOfCooked, viewing, truth.visibleWithRest);
        truth.oneLight[value.m].add(value.value, one, analyticSpecular(place.cooked, value, place.normal, lobe));
        truth.twoLights[value.m].add(value.value, one, two);
        truth.areaSpecular[value.m].add(value.value, area, area);
    }
    return truth;
}

TruthSums sumOf(const std::map<double, TruthSums>& byM) {
    TruthSums sum;
    for (const auto& [m, sums] : byM) sum.merge(sums);
    return sum;
}

}  // namespace lightcook::verify
