// Shading as constant matrices: every sampled normal, or view and material, is one row of nine numbers in the texel's own frame, so that a
// texel is turned into that frame once and shaded by plain sums. Private to verify/.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "lighting/sh.h"
#include "shaders/lightcook_cpp.h"
#include "verify/figures.h"
#include "verify/light_map.h"
#include "verify/light_map/bound.h"

namespace lightcook::verify {

/// What a row of a shading matrix stands for, in the texel's frame.
struct ShadedWay {
    glm::dvec3 normal{0, 0, 1};
    glm::dvec3 view{0};  ///< of glossy ways only, like those below
    double m = 0, f0 = 0;
};

/// count rows of nine factors, stored by coefficient and padded with zeros to whole vectors.
class ShadingMatrix {
public:
    static constexpr std::size_t kLanes = 16;  ///< rows that are summed side by side

    ShadingMatrix() = default;
    ShadingMatrix(const std::vector<lighting::ShDouble>& rows, std::vector<ShadedWay> ways);
    std::size_t count() const { return count_; }
    const ShadedWay& way(std::size_t row) const { return ways_[row]; }
    std::size_t stride() const { return stride_; }
    /// out[k] = sum_i row_k[i] coefficients[i] for k < stride(). Each sum runs over i in order, at any vector width.
    void apply(const std::array<float, lighting::kShCount>& coefficients, float* out) const;

private:
    std::size_t count_ = 0, stride_ = 0;
    std::vector<float> weights_;   ///< [coefficient][stride_]
    std::vector<ShadedWay> ways_;  ///< [row]
};

/// Exit radiance of a white surface at `count` normals (Fibonacci points of the hemisphere), through the shader's evaluation.
ShadingMatrix diffuseMatrix(int count);
/// Exit radiance of the coefficient-0-only light of layout "flat".
ShadingMatrix flatMatrix();
/// Area specular of every view, m and F0.
ShadingMatrix specularMatrix(const LightMapShading& shading);

/// What is wrong with it, if anything.
std::optional<formats::Error> checkShading(const LightMapShading& shading);

/// The coefficients of each colour channel.
std::array<lighting::Sh, 3> channelsOf(const shaders::LcSh& sh);

/// Shades one texel after the other in every sampled way. Light in units of the key.
class ErrorShader {
public:
    /// The matrices must outlive it; one without rows is a kind of shading that the scene has not.
    /// unit  what light of 1 is outside
    ErrorShader(const ShadingMatrix& diffuse, const ShadingMatrix& specular, double unit);
    /// The texel that the errors to come are of, at `place` of the map [texels]. Neighbours often share a normal: its frame is kept.
    void setReference(const shaders::LcSh& reference, const glm::vec3& normal, const glm::dvec2& place);
    /// error  result - reference, of coefficients. The place of the largest is told to the accumulators.
    void add(const shaders::LcSh& error, ErrorAccumulator& diffuse, ErrorAccumulator& specular);

private:
    void shade(const shaders::LcSh& sh, std::vector<float>& out) const;
    /// The worst of what was shaded last.
    ErrorPlace worstOf(const ShadingMatrix& matrix, std::size_t offset) const;

    const ShadingMatrix& diffuse_;
    const ShadingMatrix& specular_;
    std::vector<float> shadedReference_, shadedError_;  ///< [kind][channel][row of the matrix]
    glm::vec3 normal_{0};
    std::array<glm::vec3, 3> frame_{};
    double unit_;
    glm::dvec2 place_{0};
};

/// Area specular of every view, every m and F0 of the ranges, in every frame: a few responses such that each kernel is a mean of them and
/// 0. A kernel is split into its part round about an axis (its bands) and the rest (the residual), which is small: lobes are nearly round.
/// Those of all kernels lie near a curve, band 1 over band 0 against band 2 over band 0, which a chain of a few responses follows; how
/// far a kernel is from the chain goes into the residual. Between the ends of F0 kernels are means of those at the ends. m and view (down
/// to NoV = 1e-3) are scanned; between scanned ones a kernel differs from a mean of its neighbours by an eighth of its second differences,
/// of which twice as much is added.
std::vector<Response> specularResponses(const LightMapShading& shading);

}  // namespace lightcook::verify
