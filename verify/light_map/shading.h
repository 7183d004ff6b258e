// Shading as constant matrices: each sampled normal, or view and material, is a row of nine factors in the frame of the texel. A texel's
// coefficients are rotated into that frame once, then shaded by sums of products. Private to verify/.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "lighting/sh.h"
#include "shaders/lightcook_cpp.h"
#include "verify/figures.h"
#include "verify/light_map.h"
#include "verify/light_map/bound.h"
#include "verify/light_map/scanned_kernels.h"
#include "verify/visible.h"

namespace lightcook::verify {

/// The shading of one row of a matrix, in the frame of the texel.
struct ShadingSample {
    glm::dvec3 normal{0, 0, 1};
    glm::dvec3 view{0};  ///< specular only, as are m and f0
    double m = 0, f0 = 0;
};

/// A matrix of count rows of nine factors, padded with zeros to whole groups of kLanes rows, in each of which it is stored by coefficient.
class ShadingMatrix {
public:
    static constexpr std::size_t kLanes = 16;  ///< rows that are summed in parallel

    ShadingMatrix() = default;
    ShadingMatrix(const std::vector<lighting::ShDouble>& rows, std::vector<ShadingSample> samples);
    std::size_t count() const { return count_; }
    const ShadingSample& sample(std::size_t row) const { return samples_[row]; }
    std::size_t stride() const { return stride_; }
    /// Computes out[k] = sum_i row_k[i] coefficients[i] for k < stride(). Each sum runs over i in order, at any vector width.
    void apply(const std::array<float, lighting::kShCount>& coefficients, float* out) const;

private:
    std::size_t count_ = 0, stride_ = 0;
    std::vector<float> weights_;          ///< [group of kLanes rows][coefficient][row]
    std::vector<ShadingSample> samples_;  ///< [row]
};

/// Returns the matrix of exit radiance of a white surface at `count` normals (Fibonacci points of the hemisphere), made with the shader's
/// lcExitRadiance.
ShadingMatrix diffuseMatrix(int count);
/// Returns the matrix of exit radiance of a white surface at its own normal and, with a tilt, at 24 normals of the cap of `tilt` degrees
/// around it (docs/theory/visible.md).
ShadingMatrix capMatrix(double tilt);
/// Returns the matrix of exit radiance for layouts "flat" and "flat-2", whose light has coefficient 0 only.
ShadingMatrix flatMatrix();
/// Returns the matrix of area specular for every view, m and F0.
ShadingMatrix specularMatrix(const LightMapShading& shading);

/// Returns an error if the shading has no normals or, with specular, no views, m or F0, or values out of range.
std::optional<formats::Error> checkShading(const LightMapShading& shading);

/// Returns the coefficients by colour channel.
std::array<lighting::Sh, 3> channelsOf(const shaders::LcSh& sh);

/// Shading for visible errors: of diffuse light, the normals of the cap; of specular light, the rows of ShadingMatrices::specular.
struct VisibleShading {
    ShadingMatrix cap;
    DisplayTransform display;  ///< of light in units of the key
};

/// The matrices that shade a light map. One has no rows where the scene has no such shading.
struct ShadingMatrices {
    ShadingMatrix diffuse, specular;
    std::optional<VisibleShading> visible;
};

/// Returns the matrices of a shading that checkShading accepts.
/// key  light of the map per unit of light that is shaded
ShadingMatrices shadingMatrices(const LightMapShading& shading, double key, const std::optional<Viewing>& viewing);

/// Returns the light of a white surface for its normal in world axes, if no coefficients have that function. Empty: coefficients have it.
using ShownLight = std::function<glm::vec3(const glm::vec3& normal)>;

/// Shades the error of one texel after another in all rows of two matrices. Light in units of the key.
class ErrorShader {
public:
    /// matrices  must outlive this object
    /// unit      light of the map per unit of light here, the key
    ErrorShader(const ShadingMatrices& matrices, double unit);
    /// Sets the texel of the errors that follow, at `place` in the map [texels]. Keeps the frame if the normal is the same.
    void setReference(const shaders::LcSh& reference, const glm::vec3& normal, const glm::dvec2& place);
    /// Adds the shaded error, with the place of the largest.
    /// error  result - reference, of coefficients
    /// shown  the result's diffuse light
    /// tiles  counts the visible errors as those of `tile`; null: nothing is counted
    void add(const shaders::LcSh& error, ShadedErrors& errors, const ShownLight& shown = {}, TileErrors* tiles = nullptr,
             std::size_t tile = 0);

private:
    /// Light in the rows of a matrix, by channel.
    struct Shaded {
        std::vector<float> reference, error;  ///< [channel][row]
        explicit Shaded(const ShadingMatrix& matrix);
    };
    /// The same light as a display shows it.
    struct Shown {
        std::vector<float> reference, found;  ///< [I, T, P][row]
        explicit Shown(const ShadingMatrix& matrix);
    };

    /// Shades an error in the rows of a matrix of exit radiance.
    void shadeDiffuse(const std::array<lighting::Sh, 3>& local, const ShadingMatrix& matrix, const ShownLight& shown, Shaded& out) const;
    void addEnergy(const ShadingMatrix& matrix, const Shaded& shaded, ErrorAccumulator& accumulator) const;
    /// Returns the errors that it added.
    std::span<const float> addVisible(const ShadingMatrix& matrix, const Shaded& shaded, Shown& shown, VisibleAccumulator& accumulator);
    /// Adds visible errors of 0 in all rows.
    void addUnseen(ShadedErrors& errors) const;
    /// Returns the place of the largest error.
    ErrorPlace worstOf(const ShadingMatrix& matrix, const Shaded& shaded) const;
    VisiblePlace visibleAt(const ShadingMatrix& matrix, const Shaded& shaded, std::size_t row) const;
    glm::dmat3 frame() const { return glm::dmat3(frame_[0], frame_[1], frame_[2]); }

    const ShadingMatrices& matrices_;
    Shaded diffuse_, specular_, cap_;
    Shown shownCap_, shownSpecular_;
    std::vector<float> found_, differences_;  ///< reused
    std::optional<shaders::LcSh> reference_;  ///< of the last texel
    glm::vec3 normal_{0};
    std::array<glm::vec3, 3> frame_{};
    double unit_;
    glm::dvec2 place_{0};
};

/// Returns a few responses that cover area specular of every view, every m and F0 of the ranges, in every frame: each kernel is a mean of
/// the responses and 0, plus its residual.
///   1. Kernels are computed on a grid of m and view (down to NoV = 1e-3), for the ends of the F0 range; kernels between these ends are
///      means of them. Between grid points a kernel differs from a mean of its neighbours by 1/8 of its second differences, of which twice
///      as much is added to the residual.
///   2. Each kernel is split into a zonal part about its own axis (the bands) and the rest (the residual), which is small.
///   3. The zonal parts lie near a curve in the plane of band 1 / band 0 and band 2 / band 0. A chain of a few knots follows the curve; the
///      distance of a kernel from the chain is added to its residual. The knots are the responses.
/// scanned  kernels of this shading
std::vector<Response> specularResponses(const LightMapShading& shading, const ScannedKernels& scanned);

}  // namespace lightcook::verify
