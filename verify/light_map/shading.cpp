#include "verify/light_map/shading.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "lighting/brdf.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"

namespace lightcook::verify {

namespace {

/// Half-vector samples for each axis. The error is 5e-5 of a kernel's norm, far below that of an 8-bit texture.
constexpr int kKernelSamples = 160;
constexpr std::size_t kChannels = 3;
constexpr auto kFloor = static_cast<float>(lighting::kLocalErrorFloor);  ///< light is in units of the key

/// Rotates a kernel for a view in the x-z plane about the normal, to the azimuth of `view`.
lighting::ShDouble turnedAroundNormal(const lighting::ShDouble& kernel, const glm::dvec3& view) {
    const double azimuth = std::atan2(view.y, view.x);
    const double c = std::cos(azimuth), s = std::sin(azimuth);
    return lighting::ShRotation(glm::dmat3(c, s, 0, -s, c, 0, 0, 0, 1)).apply(kernel);
}

/// Lengths of the bands of Y(direction), for any direction.
constexpr lighting::ShBands kAxisLengths = {lighting::kShConstant, lighting::kShLinear, 2 * lighting::kShZonal};

/// Splits a kernel into its zonal part about an axis in the plane of normal and view, and the lengths of the rest. Searches directions near
/// that of band 1, in steps of one degree, for the axis with the least residual.
Response splitOf(const lighting::ShDouble& kernel) {
    const lighting::ShBands lengths = lighting::bandLengths(kernel);
    const auto splitAbout = [&](double angle) {
        const lighting::ShDouble axis = lighting::evaluateBasis(glm::dvec3(std::sin(angle), 0, std::cos(angle)));
        Response response;
        for (std::size_t i = 0; i < kernel.size(); ++i)
            response.bands[static_cast<std::size_t>(lighting::kShBand[i])] += kernel[i] * axis[i];
        for (std::size_t l = 0; l < lengths.size(); ++l) {
            response.bands[l] /= kAxisLengths[l] * kAxisLengths[l];
            const double along = response.bands[l] * kAxisLengths[l];
            response.residual[l] = l == 0 ? 0 : std::sqrt(std::max(0.0, lengths[l] * lengths[l] - along * along));
        }
        return response;
    };
    constexpr int kSteps = 20;
    const double middle = std::atan2(kernel[3], kernel[2]);
    Response best = splitAbout(middle);
    for (int i = -kSteps; i <= kSteps; ++i) {
        const Response each = splitAbout(middle + std::numbers::pi / 180 * i);
        if (each.residual[1] + each.residual[2] < best.residual[1] + best.residual[2]) best = each;
    }
    return best;
}

/// Adds each scanned kernel for this F0, split. Its residual covers kernels between it and its neighbours.
void addSplit(const ScannedKernels& scanned, double f0, std::vector<Response>& out) {
    for (int r = 0; r < scanned.roughnessCount(); ++r)
        for (int v = 0; v < ScannedKernels::kViews; ++v) {
            Response split = splitOf(kernelAtF0(scanned.at(r, v), f0));
            const lighting::ShBands between = scanned.between(r, v, f0);
            for (std::size_t l = 0; l < between.size(); ++l) split.residual[l] += between[l];
            out.push_back(split);
        }
}

/// A split kernel as a point near the chain: its band 0, and bands 1 and 2 and residual relative to band 0.
struct KernelPoint {
    double size, first, second;
    lighting::ShBands residual;
};

/// A chain of knots at even steps of band 1 / band 0. Band 2 / band 0 of each knot is fitted to the points around it by least squares.
class KernelChain {
public:
    explicit KernelChain(std::span<const KernelPoint> points) {
        constexpr double kKnotDistance = 0.07;
        constexpr int kRounds = 20;
        low_ = 1;
        double high = -1;
        for (const KernelPoint& point : points) {
            low_ = std::min(low_, point.first);
            high = std::max(high, point.first);
        }
        const double width = std::max(high - low_, 0.0);
        const int count = std::clamp(static_cast<int>(std::ceil(width / kKnotDistance)) + 1, 2, 8);
        step_ = std::max(width / (count - 1), 1e-6);
        second_.assign(static_cast<std::size_t>(count), 0.5);
        for (int round = 0; round < kRounds; ++round)
            for (std::size_t knot = 0; knot < second_.size(); ++knot) improve(knot, points);
    }
    std::size_t size() const { return second_.size(); }
    /// Returns the knot before a point, and the position of the point from there to the next knot, in [0, 1].
    std::pair<std::size_t, double> placeOf(const KernelPoint& point) const {
        const double last = static_cast<double>(second_.size() - 1), place = std::clamp((point.first - low_) / step_, 0.0, last);
        const std::size_t before = std::min(static_cast<std::size_t>(place), second_.size() - 2);
        return {before, place - static_cast<double>(before)};
    }
    /// Returns the distance of a point's band 2 from the chain.
    double distance(const KernelPoint& point) const {
        const auto [before, part] = placeOf(point);
        return point.second - ((1 - part) * second_[before] + part * second_[before + 1]);
    }
    lighting::ShBands bandsAt(std::size_t knot) const { return {1, low_ + step_ * static_cast<double>(knot), second_[knot]}; }

private:
    void improve(std::size_t knot, std::span<const KernelPoint> points) {
        double sum = 0, weights = 0;
        for (const KernelPoint& point : points) {
            const auto [before, part] = placeOf(point);
            const double weight = before == knot ? 1 - part : before + 1 == knot ? part : 0;
            if (weight == 0) continue;
            sum += weight * distance(point);
            weights += weight * weight;
        }
        if (weights > 0) second_[knot] += sum / weights;
    }
    double low_ = 0, step_ = 1;
    std::vector<double> second_;
};

}  // namespace

ShadingMatrix::ShadingMatrix(const std::vector<lighting::ShDouble>& rows, std::vector<ShadingSample> samples)
    : count_(rows.size()),
      stride_((rows.size() + kLanes - 1) / kLanes * kLanes),
      weights_(stride_ * static_cast<std::size_t>(lighting::kShCount), 0.0f),
      samples_(std::move(samples)) {
    assert(samples_.size() == count_);
    for (std::size_t k = 0; k < rows.size(); ++k)
        for (std::size_t i = 0; i < rows[k].size(); ++i)
            weights_[(k / kLanes * lighting::kShCount + i) * kLanes + k % kLanes] = static_cast<float>(rows[k][i]);
}

namespace {

constexpr std::size_t kRowLanes = ShadingMatrix::kLanes;

/// Computes the sums of the rows of one group. One pointer for all factors: with one for each coefficient they do not fit in registers.
/// w  [coefficient][row]
void applyGroup(const float* __restrict w, const lighting::Sh& coefficients, float* __restrict out) {
    const auto [c0, c1, c2, c3, c4, c5, c6, c7, c8] = coefficients;
    for (std::size_t k = 0; k < kRowLanes; ++k) {
        float fused = w[k] * c0;
        fused = std::fma(w[kRowLanes + k], c1, fused);
        fused = std::fma(w[2 * kRowLanes + k], c2, fused);
        fused = std::fma(w[3 * kRowLanes + k], c3, fused);
        fused = std::fma(w[4 * kRowLanes + k], c4, fused);
        fused = std::fma(w[5 * kRowLanes + k], c5, fused);
        fused = std::fma(w[6 * kRowLanes + k], c6, fused);
        fused = std::fma(w[7 * kRowLanes + k], c7, fused);
        out[k] = std::fma(w[8 * kRowLanes + k], c8, fused);
    }
}

}  // namespace

void ShadingMatrix::apply(const std::array<float, lighting::kShCount>& coefficients, float* out) const {
    constexpr std::size_t kGroup = kLanes * lighting::kShCount;
    const float* group = weights_.data();
    // The first stage of many layouts has an error in coefficient 0 only.
    if (std::all_of(coefficients.begin() + 1, coefficients.end(), [](float c) { return c == 0; })) {
        for (std::size_t first = 0; first < stride_; first += kLanes, group += kGroup)
            for (std::size_t k = 0; k < kLanes; ++k) out[first + k] = group[k] * coefficients[0];
        return;
    }
    for (std::size_t first = 0; first < stride_; first += kLanes, group += kGroup) applyGroup(group, coefficients, out + first);
}

namespace {
/// Returns the matrix of exit radiance of a white surface at some normals.
ShadingMatrix exitRadianceMatrix(const std::vector<glm::dvec3>& normals) {
    std::vector<lighting::ShDouble> rows(normals.size());
    std::vector<ShadingSample> samples;
    for (std::size_t k = 0; k < normals.size(); ++k) {
        samples.push_back({.normal = normals[k]});
        for (std::size_t i = 0; i < static_cast<std::size_t>(lighting::kShCount); ++i) {
            shaders::LcSh one{};
            one.c[i] = glm::vec3(1);
            rows[k][i] = static_cast<double>(shaders::lcExitRadiance(one, glm::vec3(normals[k])).x);
        }
    }
    return ShadingMatrix(rows, std::move(samples));
}
}  // namespace

ShadingMatrix diffuseMatrix(int count) {
    std::vector<glm::dvec3> normals;
    for (int k = 0; k < count; ++k) normals.push_back(lighting::fibonacciHemisphere(k, count));
    return exitRadianceMatrix(normals);
}

ShadingMatrix capMatrix(double tilt) {
    constexpr int kCapNormals = 24;
    std::vector<glm::dvec3> normals = {{0, 0, 1}};
    if (tilt > 0)
        for (int k = 0; k < kCapNormals; ++k) {
            const double z = 1 - (1 - std::cos(tilt * std::numbers::pi / 180)) * (k + 0.5) / kCapNormals, r = std::sqrt(1 - z * z);
            const double azimuth = k * std::numbers::pi * (3 - std::sqrt(5.0));
            normals.emplace_back(r * std::cos(azimuth), r * std::sin(azimuth), z);
        }
    return exitRadianceMatrix(normals);
}

ShadingMatrix flatMatrix() {
    shaders::LcSh one{};
    one.c[0] = glm::vec3(1);
    return ShadingMatrix({lighting::ShDouble{static_cast<double>(shaders::lcExitRadiance(one, glm::vec3(0, 0, 1)).x)}}, {ShadingSample{}});
}

ShadingMatrix specularMatrix(const LightMapShading& shading) {
    std::vector<lighting::ShDouble> rows;
    std::vector<ShadingSample> samples;
    for (int k = 0; k < shading.viewCount; ++k) {
        const glm::dvec3 view = lighting::fibonacciHemisphere(k, shading.viewCount);
        for (const double m : shading.m) {
            const lighting::AreaSpecularKernel kernel = specularKernelAt(view.z, m, shading.lobe, kKernelSamples);
            for (const double f0 : shading.f0) {
                rows.push_back(turnedAroundNormal(kernelAtF0(kernel, f0), view));
                samples.push_back({.view = view, .m = m, .f0 = f0});
            }
        }
    }
    return ShadingMatrix(rows, std::move(samples));
}

std::vector<Response> specularResponses(const LightMapShading& shading, const ScannedKernels& scanned) {
    // Relative to the brightest kernel: darker ones are covered by a residual alone.
    constexpr double kNegligible = 1e-3;
    std::vector<Response> kernels;
    const auto [lowF0, highF0] = std::ranges::minmax(shading.f0);
    addSplit(scanned, lowF0, kernels);
    if (highF0 > lowF0) addSplit(scanned, highF0, kernels);
    double brightest = 0;
    for (const Response& kernel : kernels) brightest = std::max(brightest, kernel.bands[0]);
    Response dim;
    std::vector<KernelPoint> points;
    for (const Response& kernel : kernels) {
        const double size = kernel.bands[0];
        const lighting::ShBands norms = kernel.norms(), &residual = kernel.residual;
        if (size > kNegligible * brightest)
            points.push_back(
                {size, kernel.bands[1] / size, kernel.bands[2] / size, {residual[0] / size, residual[1] / size, residual[2] / size}});
        else
            for (std::size_t l = 0; l < norms.size(); ++l) dim.residual[l] = std::max(dim.residual[l], norms[l]);
    }
    // A point is a mean of the two knots around it if their band 0 and relative residual are at least as large as its own.
    const KernelChain chain(points);
    std::vector<Response> responses(chain.size());
    for (const KernelPoint& point : points) {
        const std::size_t before = chain.placeOf(point).first;
        for (const std::size_t knot : {before, before + 1}) {
            Response& response = responses[knot];
            response.bands[0] = std::max(response.bands[0], point.size);
            for (std::size_t l = 0; l < 3; ++l) {
                const double off = l == 2 ? kAxisLengths[2] * std::abs(chain.distance(point)) : 0;
                response.residual[l] = std::max(response.residual[l], point.residual[l] + off);
            }
        }
    }
    for (std::size_t knot = 0; knot < responses.size(); ++knot) {
        const double size = responses[knot].bands[0];
        for (std::size_t l = 0; l < 3; ++l) {
            responses[knot].bands[l] = size * chain.bandsAt(knot)[l];
            responses[knot].residual[l] *= size;
        }
    }
    std::erase_if(responses, [](const Response& response) { return !(response.bands[0] > 0); });
    if (dim.residual != lighting::ShBands{}) responses.push_back(dim);
    return responses;
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

static_assert(ShadingMatrix::kLanes % ErrorAccumulator::kLanes == 0 && ShadingMatrix::kLanes % DisplayTransform::kLanes == 0);

ShadingMatrices shadingMatrices(const LightMapShading& shading, double key, const std::optional<Viewing>& viewing) {
    ShadingMatrices matrices;
    matrices.diffuse = diffuseMatrix(shading.normalCount);
    if (shading.specular) matrices.specular = specularMatrix(shading);
    const double tilt = shading.normalCount > 1 ? shading.normalMapTilt : 0;
    if (viewing) matrices.visible = VisibleShading{capMatrix(tilt), DisplayTransform(*viewing, key)};
    return matrices;
}

namespace {
const ShadingMatrix kNoRows;

const ShadingMatrix& capOf(const ShadingMatrices& matrices) {
    return matrices.visible ? matrices.visible->cap : kNoRows;
}
}  // namespace

ErrorShader::Shaded::Shaded(const ShadingMatrix& matrix) : reference(kChannels * matrix.stride()), error(reference.size()) {}
ErrorShader::Shown::Shown(const ShadingMatrix& matrix) : reference(kChannels * matrix.stride()), found(reference.size()) {}

ErrorShader::ErrorShader(const ShadingMatrices& matrices, double unit)
    : matrices_(matrices),
      diffuse_(matrices.diffuse),
      specular_(matrices.specular),
      cap_(capOf(matrices)),
      shownCap_(capOf(matrices)),
      shownSpecular_(matrices.specular),
      unit_(unit) {}

namespace {
/// Shades the channels of a light in the rows of a matrix.
void shade(const std::array<lighting::Sh, kChannels>& local, const ShadingMatrix& matrix, std::vector<float>& out) {
    for (std::size_t c = 0; c < kChannels; ++c) matrix.apply(local[c], out.data() + c * matrix.stride());
}

bool isZero(std::span<const glm::vec3> coefficients) {
    return std::ranges::all_of(coefficients, [](const glm::vec3& coefficient) { return coefficient == glm::vec3(0); });
}

/// Returns the coefficients in a frame by channel. Light without directions, that of a flat map, is the same in every frame.
std::array<lighting::Sh, kChannels> localChannels(const shaders::LcSh& sh, const std::array<glm::vec3, 3>& frame) {
    return channelsOf(isZero(std::span(sh.c).subspan(1)) ? sh : shaders::lcLocalSh(sh, frame[0], frame[1], frame[2]));
}
}  // namespace

void ErrorShader::setReference(const shaders::LcSh& reference, const glm::vec3& normal, const glm::dvec2& place) {
    place_ = place;
    // Neighbours are often alike: black, or of one colour.
    if (reference_ && normal == normal_ && std::ranges::equal(reference.c, reference_->c)) return;
    reference_ = reference;
    if (normal != normal_) {
        const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(normal));
        frame_ = {glm::vec3(frame[0]), glm::vec3(frame[1]), glm::vec3(frame[2])};
        normal_ = normal;
    }
    const auto local = localChannels(reference, frame_);
    shade(local, matrices_.diffuse, diffuse_.reference);
    shade(local, matrices_.specular, specular_.reference);
    if (!matrices_.visible) return;
    const VisibleShading& visible = *matrices_.visible;
    shade(local, visible.cap, cap_.reference);
    visible.display.apply(cap_.reference.data(), visible.cap.stride(), shownCap_.reference.data());
    visible.display.apply(specular_.reference.data(), matrices_.specular.stride(), shownSpecular_.reference.data());
}

void ErrorShader::shadeDiffuse(const std::array<lighting::Sh, 3>& local, const ShadingMatrix& matrix, const ShownLight& shown,
                               Shaded& out) const {
    if (!shown) return shade(local, matrix, out.error);
    for (std::size_t k = 0; k < matrix.count(); ++k) {
        const glm::vec3 n(matrix.sample(k).normal), light = shown(n.x * frame_[0] + n.y * frame_[1] + n.z * frame_[2]);
        for (std::size_t c = 0; c < kChannels; ++c) {
            const std::size_t at = c * matrix.stride() + k;
            out.error[at] = light[static_cast<int>(c)] - out.reference[at];
        }
    }
}

void ErrorShader::add(const shaders::LcSh& error, ShadedErrors& errors, const ShownLight& shown, TileErrors* tiles, std::size_t tile) {
    // Light that is shown beside the coefficients is 0 where they are.
    const bool isExact = isZero(error.c) && (!shown || isZero(reference_->c));
    if (isExact) addUnseen(errors);
    if (isExact && isZero(reference_->c)) {
        errors.diffuse.addDark(kChannels * matrices_.diffuse.count());
        errors.specular.addDark(kChannels * matrices_.specular.count());
        return;
    }
    const auto local = localChannels(error, frame_);
    shadeDiffuse(local, matrices_.diffuse, shown, diffuse_);
    shade(local, matrices_.specular, specular_.error);
    addEnergy(matrices_.diffuse, diffuse_, errors.diffuse);
    addEnergy(matrices_.specular, specular_, errors.specular);
    if (isExact || !matrices_.visible) return;
    shadeDiffuse(local, matrices_.visible->cap, shown, cap_);
    const auto diffuse = addVisible(matrices_.visible->cap, cap_, shownCap_, errors.visibleDiffuse);
    if (tiles != nullptr) tiles->add(tile, TileErrors::Kind::Diffuse, diffuse);
    const auto specular = addVisible(matrices_.specular, specular_, shownSpecular_, errors.visibleSpecular);
    if (tiles != nullptr) tiles->add(tile, TileErrors::Kind::Specular, specular);
}

void ErrorShader::addUnseen(ShadedErrors& errors) const {
    if (!matrices_.visible) return;
    errors.visibleDiffuse.addExact(matrices_.visible->cap.count());
    errors.visibleSpecular.addExact(matrices_.specular.count());
}

void ErrorShader::addEnergy(const ShadingMatrix& matrix, const Shaded& shaded, ErrorAccumulator& accumulator) const {
    const double before = accumulator.maxSampled();
    const auto addRows = [&](std::size_t first, std::size_t stride, std::size_t count) {
        accumulator.addPaddedErrors(std::span(shaded.reference).subspan(first, stride), std::span(shaded.error).subspan(first, stride),
                                    count);
    };
    if (matrix.count() == matrix.stride())  // channels are contiguous
        addRows(0, kChannels * matrix.stride(), kChannels * matrix.count());
    else
        for (std::size_t c = 0; c < kChannels; ++c) addRows(c * matrix.stride(), matrix.stride(), matrix.count());
    if (accumulator.maxSampled() > before) accumulator.setSampledAt(worstOf(matrix, shaded));
}

std::span<const float> ErrorShader::addVisible(const ShadingMatrix& matrix, const Shaded& shaded, Shown& shown,
                                               VisibleAccumulator& accumulator) {
    if (matrix.count() == 0) return {};
    found_.resize(shaded.error.size());
    differences_.resize(matrix.stride());
    for (std::size_t k = 0; k < found_.size(); ++k) found_[k] = shaded.reference[k] + shaded.error[k];
    matrices_.visible->display.apply(found_.data(), matrix.stride(), shown.found.data());
    visibleDifferences(shown.reference.data(), shown.found.data(), matrix.stride(), differences_.data());
    const double before = accumulator.largest();
    const auto measured = std::span<const float>(differences_).first(matrix.count());
    accumulator.add(measured);
    if (!(accumulator.largest() > before)) return measured;
    const auto largest = std::ranges::max_element(measured);
    VisiblePlace place = visibleAt(matrix, shaded, static_cast<std::size_t>(largest - measured.begin()));
    place.difference = static_cast<double>(*largest);
    accumulator.setMaxAt(place);
    return measured;
}

VisiblePlace ErrorShader::visibleAt(const ShadingMatrix& matrix, const Shaded& shaded, std::size_t row) const {
    const ShadingSample& way = matrix.sample(row);
    VisiblePlace place{.x = place_.x, .y = place_.y, .normal = frame() * way.normal, .view = frame() * way.view, .m = way.m, .f0 = way.f0};
    for (std::size_t c = 0; c < kChannels; ++c) {
        const std::size_t at = c * matrix.stride() + row;
        const auto reference = static_cast<double>(shaded.reference[at]), error = static_cast<double>(shaded.error[at]);
        place.reference[static_cast<int>(c)] = unit_ * reference;
        place.found[static_cast<int>(c)] = unit_ * (reference + error);
    }
    return place;
}

ErrorPlace ErrorShader::worstOf(const ShadingMatrix& matrix, const Shaded& shaded) const {
    // Values that are not finite count as the largest, like in ErrorAccumulator.
    const auto localAt = [&](std::size_t at) {
        const float error = std::abs(shaded.error[at]), local = error == 0 ? 0.0f : error / (std::abs(shaded.reference[at]) + kFloor);
        return local <= std::numeric_limits<float>::max() ? static_cast<double>(local) : std::numeric_limits<double>::max();
    };
    ErrorPlace worst{.x = place_.x, .y = place_.y, .local = -1};
    std::size_t row = 0;
    for (std::size_t c = 0; c < kChannels; ++c)
        for (std::size_t k = 0; k < matrix.count(); ++k) {
            const std::size_t at = c * matrix.stride() + k;
            if (!(localAt(at) > worst.local)) continue;
            const auto error = static_cast<double>(shaded.error[at]), reference = static_cast<double>(shaded.reference[at]);
            worst.channel = static_cast<int>(c);
            worst.reference = unit_ * reference;
            worst.found = unit_ * (reference + error);
            worst.local = localAt(at);
            row = k;
        }
    const ShadingSample& way = matrix.sample(row);
    worst.normal = frame() * way.normal;
    worst.view = frame() * way.view;
    worst.m = way.m;
    worst.f0 = way.f0;
    return worst;
}

}  // namespace lightcook::verify
