#include "compress/light_map/shading_form.h"

#include <hwy/highway.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>

#include "lighting/brdf.h"
#include "lighting/display.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"

namespace lightcook::compress {

namespace {

// No dynamic dispatch: lanes hold different shadings or products, but the sums over shadings must be fused alike on every machine.
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, 8>;
constexpr Tag kTag;

/// The response curve of a display is steep at black. A slope at black would overstate the visible error, since an error moves the light to
/// where the curve is flatter. So slopes are taken where the light is brighter by this share of the response to coefficient 0.
constexpr float kExpectedError = 0.2f;
/// Factor of errors of a channel that the reference has below zero: it is shown as black, and so is the result unless its error is positive
/// and large.
constexpr float kHidden = 0.1f;
/// The brightest light of some maps is most of their energy, and an eye sees little of its errors. So errors cost by their energy too: one
/// of the map's RMS costs as much as a visible error of sqrt(kEnergyShare) (docs/lab/compress-light-maps.md has others).
constexpr double kEnergyShare = 1e3;
using Rows = std::vector<lighting::ShDouble>;

/// Returns the response of the exit radiance at a normal to each of nine coefficients, times a weight.
lighting::ShDouble exitRow(const glm::dvec3& normal, double weight) {
    lighting::ShDouble row = lighting::evaluateBasis(normal);
    for (std::size_t c = 0; c < kCoefficientCount; ++c)
        row[c] *= weight * lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[c])];
    return row;
}

/// Returns the response of area specular light to each of nine coefficients, for a view in the frame whose z is the normal.
lighting::ShDouble specularRow(const glm::dvec3& view, double m, double f0, lighting::NormalDistribution lobe) {
    const glm::dvec2 along = glm::dvec2(view) / glm::length(glm::dvec2(view));
    const lighting::ShRotation turn(glm::dmat3(glm::dvec3(along, 0), glm::dvec3(-along.y, along.x, 0), glm::dvec3(0, 0, 1)));
    const lighting::AreaSpecularKernel kernel =
        lighting::integrateAreaSpecular(view.z, m, lobe, lighting::CookTorranceNormalization::Energy, 48);
    lighting::ShDouble row;
    for (std::size_t c = 0; c < kCoefficientCount; ++c) row[c] = f0 * kernel.c[c] + (1 - f0) * kernel.d[c];
    return turn.apply(row);
}

/// Returns the rows of objective energy: normals of the hemisphere, and views and materials, each relative to its value for constant light,
/// so that a material of F0 = 4 % counts as much as one of 60 %. They are reduced to nine rows with the same sum of products: the columns
/// of its Cholesky factor.
Rows energyRows() {
    constexpr int kNormals = 16, kViews = 6;
    Rows rows;
    for (int i = 0; i < kNormals; ++i) rows.push_back(exitRow(lighting::fibonacciHemisphere(i, kNormals), 1 / std::sqrt(double{kNormals})));
    for (int i = 0; i < kViews; ++i)
        for (const double m : {0.1, 0.25, 0.5})
            for (const double f0 : {0.04, 0.6}) {
                rows.push_back(specularRow(lighting::fibonacciHemisphere(i, kViews), m, f0, lighting::NormalDistribution::Beckmann));
                const double unit = std::max(rows.back()[0], 1e-3) / lighting::kShConstant * std::sqrt(6.0 * kViews);
                for (double& value : rows.back()) value /= unit;
            }
    Eigen::Matrix<double, 9, 9> sum = Eigen::Matrix<double, 9, 9>::Zero();
    for (const lighting::ShDouble& row : rows) {
        const Eigen::Map<const Eigen::Matrix<double, 9, 1>> r(row.data());
        sum += r * r.transpose();
    }
    const Eigen::Matrix<double, 9, 9> factor = sum.llt().matrixL();
    rows.assign(kCoefficientCount, {});
    for (int c = 0; c < 9; ++c)
        for (int r = 0; r < 9; ++r) rows[static_cast<std::size_t>(c)][static_cast<std::size_t>(r)] = factor(r, c);
    return rows;
}

/// Returns the rows of objective visible: the normals and views that the verifier samples (docs/theory/visible.md), with the largest F0,
/// whose lobes are the brightest; those of others are nearly the same. Fewer views leave lobes between them unseen, and errors collect
/// there.
Rows visibleRows(const LightMapObjective& objective) {
    constexpr int kCap = 24, kViews = 8;
    Rows rows = {exitRow({0, 0, 1}, 1)};
    const double span = 1 - std::cos(objective.normalMapTilt * std::numbers::pi / 180);
    for (int i = 0; i < kCap && span > 0; ++i) {
        const double z = 1 - span * (i + 0.5) / kCap, r = std::sqrt(1 - z * z), turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
        rows.push_back(exitRow({r * std::cos(turn), r * std::sin(turn), z}, 1));
    }
    for (int i = 0; i < kViews && objective.isSpecular; ++i)
        for (const double m : objective.m)
            rows.push_back(specularRow(lighting::fibonacciHemisphere(i, kViews), m, std::ranges::max(objective.f0), objective.lobe));
    return rows;
}

/// Slope of the curve PQ over luminance [m^2/cd]: linear between 16 points an octave, within 0.2 %. Above 8191 cd/m^2 it falls as 1 / nits:
/// no display is so bright, and an exposure that an engine changes should find errors there in proportion to the light.
class CurveSlope {
public:
    CurveSlope() {
        for (std::size_t i = 0; i < slopes_.size(); ++i) {
            const auto bits = static_cast<std::uint32_t>(i + kFirst) << kShift;
            const auto nits = static_cast<double>(std::bit_cast<float>(bits)), step = 1e-3 * nits;
            slopes_[i] =
                static_cast<float>((lighting::perceptualQuantizer(nits + step) - lighting::perceptualQuantizer(nits - step)) / (2 * step));
        }
    }
    /// Returns the slopes at some luminances.
    hn::Vec<Tag> at(hn::Vec<Tag> nits) const {
        constexpr hn::RebindToSigned<Tag> kBitsTag;
        const auto brightest = hn::Set(kTag, kBrightest);
        const auto bits = hn::BitCast(kBitsTag, hn::Min(hn::Max(nits, hn::Set(kTag, 0x1p-10f)), brightest));
        const auto i = hn::Sub(hn::ShiftRight<kShift>(bits), hn::Set(kBitsTag, static_cast<std::int32_t>(kFirst)));
        const auto part = hn::Mul(hn::ConvertTo(kTag, hn::And(bits, hn::Set(kBitsTag, (1 << kShift) - 1))), hn::Set(kTag, 0x1p-19f));
        const auto low = hn::GatherIndex(kTag, slopes_.data(), i), high = hn::GatherIndex(kTag, slopes_.data() + 1, i);
        const auto slope = hn::Add(low, hn::Mul(part, hn::Sub(high, low)));
        return hn::Div(hn::Mul(slope, brightest), hn::Max(nits, brightest));
    }

private:
    static constexpr float kBrightest = 8191;
    static constexpr int kShift = 19;
    static constexpr std::uint32_t kFirst = (127u - 10) << 4;
    std::array<float, 23 * 16 + 1> slopes_{};  ///< from 2^-10 to 2^13 cd/m^2
};

/// itp' itp of the rows that make 720 (I, T, P) of PQ-coded LMS (ITU-R BT.2100-2, table 7; BT.2124).
const glm::mat3& itpSquared() {
    static const glm::dmat3 kItp = lighting::kVisibleScale * lighting::itpFromLms();
    static const glm::mat3 kSquared(glm::transpose(kItp) * kItp);
    return kSquared;
}

}  // namespace

ShadingForm::ShadingForm(const std::optional<LightMapObjective>& objective, double unit, double lightSquare)
    : isVisible_(objective.has_value()) {
    static const Rows energy = energyRows();
    local_ = isVisible_ ? visibleRows(*objective) : energy;
    if (isVisible_) {
        const glm::dmat3 lms = lighting::lmsFromBt2020() * objective->bt2020FromWorking * (objective->display.nitsPerUnit * unit);
        for (int row = 0; row < 3; ++row)
            for (int channel = 0; channel < 3; ++channel)
                lms_[static_cast<std::size_t>(row)][static_cast<std::size_t>(channel)] = static_cast<float>(lms[channel][row]);
        const float share = 1 / static_cast<float>(local_.size());
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t d = c; d < 3; ++d)
                for (std::size_t r = 0; r < 3; ++r)
                    for (std::size_t q = 0; q < 3; ++q)
                        factors_[ErrorForm::pairOf(c, d)][r][q] =
                            share * lms_[r][c] * itpSquared()[static_cast<int>(r)][static_cast<int>(q)] * lms_[q][d];
        black_ = static_cast<float>(objective->display.black);
        if (lightSquare > 0) energyCost_ = static_cast<float>(kEnergyShare / (3 * lightSquare));
    }
    count_ = (local_.size() + kLanes - 1) / kLanes * kLanes;
    products_.assign(local_.size(), {});
    for (PerShading& row : rows_) row.assign(count_, 0);
    for (auto* arrays : {&colours_, &seen_})
        for (PerShading& values : *arrays) values.assign(count_, 0);
    for (PerShading& weights : weights_) weights.assign(count_, 0);
}

void ShadingForm::turnTo(const glm::vec3& normal) {
    if (normal == normal_) return;
    normal_ = normal + 0.0f;  // no -0: it equals 0 and has another frame, so the form would depend on the texel before
    const lighting::ShRotation turn(lighting::worldFromTangentFrame(glm::dvec3(normal_)));
    for (std::size_t k = 0; k < local_.size(); ++k) {
        const lighting::ShDouble world = turn.apply(local_[k]);
        std::size_t product = 0;
        for (std::size_t i = 0; i < kCoefficientCount; ++i) {
            rows_[i][k] = static_cast<float>(world[i]);
            for (std::size_t j = 0; j <= i; ++j) products_[k][product++] = static_cast<float>(world[i] * world[j]);
        }
    }
}

/// Sets colours_ and seen_.
void ShadingForm::shade(std::span<const glm::vec3> light) {
    for (std::size_t c = 0; c < 3; ++c) {
        float* __restrict colour = colours_[c].data(), * __restrict seen = seen_[c].data();
        std::fill_n(colour, count_, 0.0f);
        for (std::size_t i = 0; i < kCoefficientCount; ++i) {
            const float* __restrict row = rows_[i].data();
            const float coefficient = light[i][static_cast<int>(c)];
            for (std::size_t k = 0; k < count_; ++k) colour[k] += coefficient * row[k];
        }
        const float* __restrict constant = rows_[0].data();
        const float expected = kExpectedError * std::max(light[0][static_cast<int>(c)], 0.0f);
        for (std::size_t k = 0; k < count_; ++k) {
            seen[k] = colour[k] > 0 ? 1.0f : kHidden;
            colour[k] = (colour[k] > 0 ? colour[k] : 0.0f) + expected * constant[k];
        }
    }
}

/// Sets weights_ from the colours: J_oc = seen_c sum_r itp_or slope_r lms_rc, so (J'J)_cd = seen_c seen_d sum_rq slope_r slope_q lms_rc
/// (itp' itp)_rq lms_qd.
void ShadingForm::weighColours() {
    static const CurveSlope slope;
    static_assert(kLanes % hn::MaxLanes(kTag) == 0);
    for (std::size_t k = 0; k < count_; k += hn::MaxLanes(kTag)) {
        const auto loaded = [&](const std::array<PerShading, 3>& values, std::size_t i) { return hn::LoadU(kTag, values[i].data() + k); };
        const hn::Vec<Tag> red = loaded(colours_, 0), green = loaded(colours_, 1), blue = loaded(colours_, 2);
        const auto slopeOf = [&](std::size_t row) {
            const auto& [toRed, toGreen, toBlue] = lms_[row];
            const auto first = hn::Add(hn::Set(kTag, black_), hn::Mul(hn::Set(kTag, toRed), red)),
                       second = hn::Add(first, hn::Mul(hn::Set(kTag, toGreen), green));
            return slope.at(hn::Add(second, hn::Mul(hn::Set(kTag, toBlue), blue)));
        };
        const hn::Vec<Tag> slopes[3] = {slopeOf(0), slopeOf(1), slopeOf(2)};
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t d = c; d < 3; ++d) {
                const std::size_t pair = ErrorForm::pairOf(c, d);
                hn::Vec<Tag> sum = hn::Zero(kTag);
                for (std::size_t r = 0; r < 3; ++r)
                    for (std::size_t q = 0; q < 3; ++q)
                        sum = hn::Add(sum, hn::Mul(hn::Mul(hn::Set(kTag, factors_[pair][r][q]), slopes[r]), slopes[q]));
                hn::StoreU(hn::Mul(sum, hn::Mul(loaded(seen_, c), loaded(seen_, d))), kTag, weights_[pair].data() + k);
            }
    }
}

namespace {

/// Adds a share of the mean cost to each coefficient of each channel. Some errors are hardly seen, such as those of light below zero.
/// Without a cost of their own, solvers would not bound them.
void addAllDirections(PackedForm& form) {
    constexpr float kShare = 0.1f;
    for (std::size_t channel = 0; channel < 3; ++channel) {
        float trace = 0;
        for (std::size_t i = 0; i < kCoefficientCount; ++i) trace += form.part[channel][PackedForm::diagonal(i)];
        for (std::size_t i = 0; i < kCoefficientCount; ++i)
            form.part[channel][PackedForm::diagonal(i)] += kShare * trace / kCoefficientCount;
    }
}

/// Adds the cost of the energy of an error to each coefficient: about that of its shaded light, over all normals and materials.
void addEnergy(PackedForm& form, float cost) {
    constexpr std::array<float, 3> kBands = {1, 0.6f, 0.3f};
    for (std::size_t channel = 0; channel < 3; ++channel)
        for (std::size_t i = 0; i < kCoefficientCount; ++i)
            form.part[channel][PackedForm::diagonal(i)] += cost * kBands[static_cast<std::size_t>(lighting::kShBand[i])];
}

}  // namespace

template <std::size_t kTogether>
void ShadingForm::sumProducts(std::size_t first, PackedForm& form) const {
    constexpr std::size_t kWidth = hn::MaxLanes(kTag), kParts = kProducts / kWidth;
    hn::Vec<Tag> sum[kTogether][kParts];
    for (auto& parts : sum)
        for (auto& part : parts) part = hn::Zero(kTag);
    for (std::size_t k = 0; k < local_.size(); ++k) {
        hn::Vec<Tag> weight[kTogether];
        for (std::size_t n = 0; n < kTogether; ++n) weight[n] = hn::Set(kTag, isVisible_ ? weights_[first + n][k] : 1);
        for (std::size_t p = 0; p < kParts; ++p) {
            const auto product = hn::LoadU(kTag, products_[k].data() + p * kWidth);
            for (std::size_t n = 0; n < kTogether; ++n) sum[n][p] = hn::MulAdd(weight[n], product, sum[n][p]);
        }
    }
    for (std::size_t n = 0; n < kTogether; ++n) {
        std::array<float, kProducts> products;
        for (std::size_t p = 0; p < kParts; ++p) hn::StoreU(sum[n][p], kTag, products.data() + p * kWidth);
        std::copy_n(products.begin(), PackedForm::kProducts, form.part[first + n].begin());
    }
}

PackedForm ShadingForm::at(std::span<const glm::vec3> light, const glm::vec3& normal) {
    turnTo(normal);
    if (isVisible_) {
        shade(light);
        weighColours();
    }
    PackedForm form;
    // Two pairs share a load of each product.
    if (isVisible_)
        for (std::size_t pair = 0; pair < ErrorForm::kPairs; pair += 2) sumProducts<2>(pair, form);
    else
        for (std::size_t pair = 0; pair < 3; ++pair) sumProducts<1>(pair, form);
    if (isVisible_) {
        addAllDirections(form);
        addEnergy(form, energyCost_);
    }
    return form;
}

ErrorForm PackedForm::unpacked() const {
    // Places in `part` of the products of a form.
    constexpr auto kPlaces = [] {
        std::array<std::uint8_t, kCoefficientCount * kCoefficientCount> places{};
        for (std::size_t i = 0; i < kCoefficientCount; ++i)
            for (std::size_t j = 0; j < kCoefficientCount; ++j)
                places[i * kCoefficientCount + j] = static_cast<std::uint8_t>(std::max(i, j) * (std::max(i, j) + 1) / 2 + std::min(i, j));
        return places;
    }();
    ErrorForm out;
    for (std::size_t pair = 0; pair < ErrorForm::kPairs; ++pair) {
        const float* products = part[pair].data();
        float* to = out.part[pair][0].data();
        for (std::size_t k = 0; k < kPlaces.size(); ++k) to[k] = products[kPlaces[k]];
    }
    return out;
}

}  // namespace lightcook::compress
