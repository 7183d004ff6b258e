#include "verify/whole_shading.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>
#include <vector>

#include "lighting/sphere.h"
#include "verify/assets/dominant_specular.h"
#include "verify/light_map/shading.h"

namespace lightcook::verify {
namespace {

shaders::LcSh shaderSh(const lighting::ShRgb& sh) {
    shaders::LcSh out;
    for (std::size_t i = 0; i < sh.size(); ++i) out.c[i] = sh[i];
    return out;
}

/// Returns coefficients in the frame of a normal, by channel.
std::array<lighting::Sh, 3> localChannels(const shaders::LcSh& sh, const glm::dmat3& frame) {
    return channelsOf(shaders::lcLocalSh(sh, glm::vec3(frame[0]), glm::vec3(frame[1]), glm::vec3(frame[2])));
}

}  // namespace

struct WholeShader::State {
    ShadingMatrix specular;  ///< without rows where nothing is specular
    lighting::NormalDistribution lobe = lighting::NormalDistribution::Beckmann;

    std::size_t count() const { return std::max<std::size_t>(1, specular.count()); }
    std::size_t stride() const { return std::max(DisplayTransform::kLanes, specular.stride()); }
    /// Writes area specular, or zeros.
    void shadeArea(const std::array<lighting::Sh, 3>& channels, std::span<float> out) const {
        std::ranges::fill(out, 0.0f);
        if (specular.count() == 0) return;
        for (std::size_t channel = 0; channel < 3; ++channel) specular.apply(channels[channel], out.data() + channel * stride());
    }
};

formats::Result<WholeShader> WholeShader::create(const LightMapShading& shading) {
    if (auto error = checkShading(shading)) return tl::make_unexpected(*error);
    auto state = std::make_unique<State>();
    if (shading.specular) state->specular = specularMatrix(shading);
    state->lobe = shading.lobe;
    return WholeShader(std::move(state));
}

WholeShader::WholeShader(std::unique_ptr<const State> state) : state_(std::move(state)) {}
WholeShader::WholeShader(WholeShader&&) noexcept = default;
WholeShader& WholeShader::operator=(WholeShader&&) noexcept = default;
WholeShader::~WholeShader() = default;

std::size_t WholeShader::sampleCount() const {
    return state_->count();
}
std::size_t WholeShader::stride() const {
    return state_->stride();
}

void WholeShader::shadeLightMap(const lighting::ShRgb& incident, const glm::vec3& normal, std::span<float> out) const {
    assert(out.size() == 3 * stride());
    const shaders::LcSh sh = shaderSh(incident);
    state_->shadeArea(localChannels(sh, lighting::worldFromTangentFrame(glm::dvec3(normal))), out);
    const glm::vec3 diffuse = shaders::lcExitRadiance(sh, normal);
    for (std::size_t channel = 0; channel < 3; ++channel)
        for (std::size_t k = 0; k < sampleCount(); ++k) out[channel * stride() + k] += diffuse[static_cast<int>(channel)];
}

void WholeShader::shadeDominant(const DominantLightSample& light, const glm::vec3& normal, std::span<float> out) const {
    assert(out.size() == 3 * stride());
    const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(normal));
    const glm::vec3 direction(light.direction), intensity(light.intensity);
    const shaders::LcSh less = shaders::lcWithoutLight({}, shaders::lcDominantDirection(direction, normal), intensity);
    state_->shadeArea(localChannels(less, frame), out);
    for (std::size_t k = 0; k < state_->specular.count(); ++k) {
        const ShadingSample& sample = state_->specular.sample(k);
        const glm::vec3 highlight = dominantSpecular(state_->lobe, glm::vec3(frame * sample.view), direction, intensity, normal,
                                                     static_cast<float>(sample.m), glm::vec3(static_cast<float>(sample.f0)));
        for (std::size_t channel = 0; channel < 3; ++channel) out[channel * stride() + k] += highlight[static_cast<int>(channel)];
    }
}

DominantLightSample derivedLight(const lighting::ShRgb& incident, const glm::vec3& normal) {
    const shaders::LcDominantLight light = shaders::lcDerivedLight(shaderSh(incident), normal);
    return {glm::dvec3(light.direction), glm::dvec3(light.intensity)};
}

void WholeErrors::append(const WholeErrors& other) {
    visible.insert(visible.end(), other.visible.begin(), other.visible.end());
    squaredErrors.insert(squaredErrors.end(), other.squaredErrors.begin(), other.squaredErrors.end());
    squaredLights.insert(squaredLights.end(), other.squaredLights.begin(), other.squaredLights.end());
}

VisibleFigures WholeErrors::visibleFigures() const {
    VisibleAccumulator errors;
    errors.add(visible);
    return errors.figures();
}

double WholeErrors::relRms() const {
    const double errors = std::accumulate(squaredErrors.begin(), squaredErrors.end(), 0.0),
                 lights = std::accumulate(squaredLights.begin(), squaredLights.end(), 0.0);
    return lights > 0 ? std::sqrt(errors / lights) : 0;
}

WholeErrors wholeErrors(std::span<const float> reference, std::span<const float> a, std::span<const float> b, std::size_t sampleCount,
                        std::size_t stride, const Viewing& viewing) {
    assert(reference.size() == a.size() && (b.empty() || b.size() == a.size()));
    const DisplayTransform display(viewing, 1);
    WholeErrors errors;
    std::vector<float> found(3 * stride), shownReference(3 * stride), shownFound(3 * stride), apart(stride);
    for (std::size_t place = 0; place < reference.size(); place += 3 * stride) {
        for (std::size_t i = 0; i < found.size(); ++i) found[i] = a[place + i] + (b.empty() ? 0.0f : b[place + i]);
        display.apply(reference.data() + place, stride, shownReference.data());
        display.apply(found.data(), stride, shownFound.data());
        visibleDifferences(shownReference.data(), shownFound.data(), stride, apart.data());
        errors.visible.insert(errors.visible.end(), apart.begin(), apart.begin() + static_cast<std::ptrdiff_t>(sampleCount));
        double squaredError = 0, squaredLight = 0;
        for (std::size_t channel = 0; channel < found.size(); channel += stride)
            for (std::size_t i = channel; i < channel + sampleCount; ++i) {
                const auto expected = static_cast<double>(reference[place + i]);
                const double error = static_cast<double>(a[place + i]) + (b.empty() ? 0.0 : static_cast<double>(b[place + i])) - expected;
                squaredError += error * error;
                squaredLight += expected * expected;
            }
        errors.squaredErrors.push_back(squaredError);
        errors.squaredLights.push_back(squaredLight);
    }
    return errors;
}

}  // namespace lightcook::verify
