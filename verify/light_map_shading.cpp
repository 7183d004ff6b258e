#include "verify/light_map_shading.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "lighting/brdf.h"
#include "lighting/sphere.h"

namespace verify {

namespace {

/// Half-vector samples an axis: 5e-5 of a kernel's norm, far under what an 8-bit texture leaves.
constexpr int kKernelSamples = 160;
constexpr int kScanSamples = 64;
constexpr std::size_t kChannels = 3;

/// A kernel whose view lies in the x-z plane, for a view of any azimuth: turned around the normal.
lighting::ShDouble turnedAroundNormal(const lighting::ShDouble& kernel, const glm::dvec3& view) {
    const double azimuth = std::atan2(view.y, view.x);
    const double c = std::cos(azimuth), s = std::sin(azimuth);
    return lighting::ShRotation(glm::dmat3(c, s, 0, -s, c, 0, 0, 0, 1)).apply(kernel);
}

lighting::ShDouble atF0(const lighting::AreaSpecularKernel& kernel, double f0) {
    lighting::ShDouble out{};
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = f0 * kernel.c[i] + (1 - f0) * kernel.d[i];
    return out;
}

lighting::AreaSpecularKernel kernelAt(double NoV, double m, int sampleCount) {
    return lighting::integrateAreaSpecular(NoV, m, lighting::NormalDistribution::Beckmann, lighting::CookTorranceNormalization::Energy,
                                           sampleCount);
}

lighting::ShBands bandNorms(const lighting::ShDouble& kernel) {
    lighting::ShBands squared{};
    for (std::size_t i = 0; i < kernel.size(); ++i) squared[static_cast<std::size_t>(lighting::kShBand[i])] += kernel[i] * kernel[i];
    return {std::sqrt(squared[0]), std::sqrt(squared[1]), std::sqrt(squared[2])};
}

}  // namespace

ShadingMatrix::ShadingMatrix(const std::vector<lighting::ShDouble>& rows)
    : count_(rows.size()),
      stride_((rows.size() + kLanes - 1) / kLanes * kLanes),
      weights_(stride_ * static_cast<std::size_t>(lighting::kShCount), 0.0f) {
    for (std::size_t k = 0; k < rows.size(); ++k)
        for (std::size_t i = 0; i < rows[k].size(); ++i) weights_[i * stride_ + k] = static_cast<float>(rows[k][i]);
}

void ShadingMatrix::apply(const std::array<float, lighting::kShCount>& coefficients, float* out) const {
    for (std::size_t first = 0; first < stride_; first += kLanes) {
        float sum[kLanes] = {};
        for (std::size_t i = 0; i < coefficients.size(); ++i) {
            const float* row = weights_.data() + i * stride_ + first;
            for (std::size_t lane = 0; lane < kLanes; ++lane) sum[lane] += row[lane] * coefficients[i];
        }
        for (std::size_t lane = 0; lane < kLanes; ++lane) out[first + lane] = sum[lane];
    }
}

ShadingMatrix diffuseMatrix(int count) {
    std::vector<lighting::ShDouble> rows(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k)
        for (std::size_t i = 0; i < static_cast<std::size_t>(lighting::kShCount); ++i) {
            shaders::LcSh one{};
            one.c[i] = glm::vec3(1);
            rows[static_cast<std::size_t>(k)][i] =
                static_cast<double>(shaders::lcExitRadiance(one, glm::vec3(lighting::fibonacciHemisphere(k, count))).x);
        }
    return ShadingMatrix(rows);
}

ShadingMatrix flatMatrix() {
    shaders::LcSh one{};
    one.c[0] = glm::vec3(1);
    return ShadingMatrix({lighting::ShDouble{static_cast<double>(shaders::lcExitRadiance(one, glm::vec3(0, 0, 1)).x)}});
}

ShadingMatrix specularMatrix(const LightMapShading& shading) {
    std::vector<lighting::ShDouble> rows;
    for (int k = 0; k < shading.viewCount; ++k) {
        const glm::dvec3 view = lighting::fibonacciHemisphere(k, shading.viewCount);
        for (const double m : shading.m) {
            const lighting::AreaSpecularKernel kernel = kernelAt(view.z, m, kKernelSamples);
            for (const double f0 : shading.f0) rows.push_back(turnedAroundNormal(atF0(kernel, f0), view));
        }
    }
    return ShadingMatrix(rows);
}

lighting::ShBands specularBandSuprema(const LightMapShading& shading) {
    constexpr int viewSteps = 24, roughnessSteps = 6;
    const auto [lowM, highM] = std::ranges::minmax(shading.m);
    const auto [lowF0, highF0] = std::ranges::minmax(shading.f0);
    lighting::ShBands suprema{};
    for (int r = 0; r <= (highM > lowM ? roughnessSteps : 0); ++r) {
        const double m = lowM * std::pow(highM / lowM, static_cast<double>(r) / roughnessSteps);
        for (int v = 0; v <= viewSteps; ++v) {
            // Even in angle: norms change fastest towards grazing.
            const double NoV = std::max(1e-3, std::cos(0.5 * std::numbers::pi * v / viewSteps));
            const lighting::AreaSpecularKernel kernel = kernelAt(NoV, m, kScanSamples);
            for (const double f0 : {lowF0, highF0}) {
                const lighting::ShBands norms = bandNorms(atF0(kernel, f0));
                for (std::size_t l = 0; l < norms.size(); ++l) suprema[l] = std::max(suprema[l], norms[l]);
            }
        }
    }
    for (std::size_t l = 0; l < suprema.size(); ++l) {
        const double allLight = std::sqrt((2.0 * static_cast<double>(l) + 1) / (4 * std::numbers::pi));
        suprema[l] = std::min(allLight, suprema[l] * (1 + kSpecularScanMargin));
    }
    return suprema;
}

std::optional<formats::Error> checkShading(const LightMapShading& shading) {
    const auto refuse = [](const char* what, const char* detail) {
        return formats::Error{formats::ErrorCode::InvalidRequest, std::string("light map shading, ") + what, detail};
    };
    if (shading.normalCount < 1) return refuse("normals", "found none, expected at least 1");
    if (!shading.specular) return std::nullopt;
    if (shading.viewCount < 1) return refuse("views", "found none, expected at least 1");
    if (shading.m.empty() || !std::ranges::all_of(shading.m, [](double m) { return m >= 0.005 && m <= 1; }))
        return refuse("m", "found an empty list or a value out of range, expected values in [0.005, 1]");
    if (shading.f0.empty() || !std::ranges::all_of(shading.f0, [](double f) { return f >= 0 && f <= 1; }))
        return refuse("f0", "found an empty list or a value out of range, expected values in [0, 1]");
    return std::nullopt;
}

std::array<lighting::Sh, 3> channelsOf(const shaders::LcSh& sh) {
    std::array<lighting::Sh, 3> out;
    for (std::size_t i = 0; i < lighting::kShCount; ++i)
        for (std::size_t c = 0; c < out.size(); ++c) out[c][i] = sh.c[i][static_cast<int>(c)];
    return out;
}

ErrorShader::ErrorShader(const ShadingMatrix& diffuse, const ShadingMatrix& specular)
    : diffuse_(diffuse),
      specular_(specular),
      shadedReference_(kChannels * (diffuse.stride() + specular.stride())),
      shadedError_(shadedReference_.size()) {}

void ErrorShader::setReference(const shaders::LcSh& reference, const glm::vec3& normal) {
    if (normal != normal_) {
        const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(normal));
        frame_ = {glm::vec3(frame[0]), glm::vec3(frame[1]), glm::vec3(frame[2])};
        normal_ = normal;
    }
    shade(reference, shadedReference_);
}

void ErrorShader::add(const shaders::LcSh& error, ErrorAccumulator& diffuse, ErrorAccumulator& specular) {
    shade(error, shadedError_);
    const auto addAll = [&](ErrorAccumulator& accumulator, const ShadingMatrix& matrix, std::size_t offset) {
        for (std::size_t c = 0; c < kChannels; ++c, offset += matrix.stride())
            accumulator.addErrors(std::span(shadedReference_).subspan(offset, matrix.count()),
                                  std::span(shadedError_).subspan(offset, matrix.count()));
    };
    addAll(diffuse, diffuse_, 0);
    addAll(specular, specular_, kChannels * diffuse_.stride());
}

void ErrorShader::shade(const shaders::LcSh& sh, std::vector<float>& out) const {
    const auto local = channelsOf(shaders::lcLocalSh(sh, frame_[0], frame_[1], frame_[2]));
    float* next = out.data();
    for (std::size_t c = 0; c < kChannels; ++c, next += diffuse_.stride()) diffuse_.apply(local[c], next);
    for (std::size_t c = 0; c < kChannels; ++c, next += specular_.stride()) specular_.apply(local[c], next);
}

}  // namespace verify
