// Upper bound of the tables' error at every view and roughness, also between the samples.
//
// Method. Each cell between four nodes is cut into small pieces: rows of roughness and columns of views. Inside a piece the fetched table
// is bilinear in the two axis values. Its error therefore differs from the bilinear blend of the four corners' errors only by the
// difference of the kernel T from the blend of its own corners, so
//   |error| <= largest |error| of the corners + (deviation of T from its chord over roughness) + (the same over the view).
//   - Over roughness: deviation <= width^2 / 8 * |d2T/dvalue2|, and |d2T/dm2| <= K sup|w Y| / m^2, because only the density of slopes
//     depends on m. K is the mean of |second derivative / density| (roughnessFactors). Pieces are as wide as kRoughnessSlack allows.
//   - Over the view: T(x) - chord <= (D - d) width / 4 for a derivative inside [d, D], which lut_derivative.h computes.
// Local relative errors divide by the smallest |T| or |reflected radiance| in the piece, plus 0.02 key.
//
// Visible errors are of grey light: bounds of reflected radiance and of its error give those of the luminance (error/visible_metric.h).
//
// Kernels at the corners count as exact: they are, to 1e-7. Filter fractions count as exact (verify/texture_unit.h); single-precision
// coordinates are allowed for. Bounds of visible errors also allow for the tolerance of samplers.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "lighting/radiometry.h"
#include "verify/assets/lut_derivative.h"
#include "verify/error/visible_metric.h"
#include "verify/lut.h"

namespace lightcook::verify {
namespace {

using lighting::SpecularLobe;
using lut::EntryIntervals, lut::kEntryOfC, lut::kEntryOfD;
constexpr double kPi = std::numbers::pi;
/// Pieces of the view axis: of the whole axis (each cell at least two), limits of the growth of NoV and of the angle [rad] within a piece.
constexpr int kViewPieces = 224;
constexpr double kGrazingRatio = 1.35;
constexpr double kWidestPiece = 0.02;
/// A piece at the normal need not be narrower than this [rad].
constexpr double kNarrowestPiece = 1e-3;
/// Largest deviation of an entry by second differences over roughness.
constexpr double kRoughnessSlack = 3e-4;
/// Boxes of half vectors: rings of polar angle below and above 45 degrees, and arcs of half the azimuth.
constexpr int kLowRings = 32, kHighRings = 16, kArcs = 40;
constexpr double kLastRing = 1e-3;  ///< relative to 45 degrees
constexpr int kCornerPoints = 12;
/// Rounding of a fetch in single precision, relative to a channel's range; and of the corners' kernels, absolute.
constexpr double kFetchRounding = 4e-6, kKernelRounding = 2e-7;
/// Rounding of a number near 1 in single precision.
constexpr double kFloatRounding = 1.2e-7;
/// Rings with a smaller share of the distribution are skipped.
constexpr double kNothing = 1e-15;
/// Half the range of w Y_i for coefficients 0, 2, 3, 6, 7, 8, with w in [0, 2] and light above the horizon.
constexpr std::array<double, 6> kHalfRange = {0.2820948, 0.4886026, 0.9772051, 0.9461747, 1.0925485, 1.0925485};

bool isPhong(SpecularLobe lobe) {
    return lobe == SpecularLobe::Phong || lobe == SpecularLobe::PhongPower;
}

/// Means of |first derivative by m| and |second derivative by m| over the density, times m and m^2.
struct RoughnessFactors {
    double first, second;
};
RoughnessFactors roughnessFactors(SpecularLobe lobe) {
    // Beckmann, rho = tan^2 / m^2 of density exp(-rho): 2 (rho - 1) and 4 rho^2 - 14 rho + 6, roots at 1, and at 1/2 and 3. Appendix B's
    // lobe has the same density. GGX, s = 1 / (1 + rho) uniform: 2 - 4 s and 2 - 20 s + 24 s^2. A cosine power is Beckmann's in
    // a = m / sqrt(2 - m^2) for -ln(cos) = a^2 rho: with a' / a <= 2 / m and a'' / a <= 6 / m^2 by the chain rule.
    if (lobe == SpecularLobe::Ggx) return {1, 1.7362};
    if (lobe == SpecularLobe::PhongPower) return {2.9432, 25.7024};
    return {1.4716, 4.2182};
}

/// The pieces of the roughness axis, and the roughnesses between them.
class RoughnessPieces {
public:
    struct Piece {
        double secondDifference;  ///< deviation of T from its chord in the piece, for a half range of 1
        std::size_t cell;
    };
    /// scale  factor of the kernels' normalization
    RoughnessPieces(const LutAxis& axis, SpecularLobe lobe, double scale) : axis_(axis), factors_(roughnessFactors(lobe)) {
        const double smallestM = axis.inverse(axis.minimum);
        rows_ = {smallestM};
        const double largestRange = *std::max_element(kHalfRange.begin(), kHalfRange.end());
        for (int cell = 0; cell + 1 < axis.count; ++cell) {
            const double high = axis.at(cell + 1);
            for (double from = axis.at(cell); from < high;) {
                // The curvature is largest where roughness is smallest, at the beginning of the piece.
                const double width = std::sqrt(8 * kRoughnessSlack / (largestRange * curvature(from, from)));
                const double to = from + 1.2 * width < high ? from + width : high;
                rows_.push_back(axis.inverse(to));
                pieces_.push_back({curvature(from, to) * (to - from) * (to - from) / 8 * scale, static_cast<std::size_t>(cell)});
                from = to;
            }
        }
        if (pieces_.empty()) {
            rows_.push_back(smallestM);  // a table of one row: a cell of height 0
            pieces_.push_back({0, 0});
        }
    }
    const std::vector<double>& rows() const { return rows_; }     ///< m, one more than pieces
    const std::vector<Piece>& pieces() const { return pieces_; }  ///< piece i lies between rows i and i + 1

private:
    /// Returns an upper bound of |d2T / dvalue2| over a part of the axis, for half ranges of 1.
    double curvature(double low, double high) const {
        const double m0 = axis_.inverse(low), m1 = axis_.inverse(high);
        // value^2 = r0 + r1 m + r2 m^2, differentiated twice by the value.
        const auto radicand = axis_.radicand();
        const double slope0 = radicand[1] + 2 * radicand[2] * m0, slope1 = radicand[1] + 2 * radicand[2] * m1;
        const double first0 = 2 * low / std::max(slope0, slope1), first1 = 2 * high / std::min(slope0, slope1);
        const auto bend = [&](double first) { return std::abs(2 - 2 * radicand[2] * first * first); };
        const double second = std::max(bend(first0), bend(first1)) / std::min(slope0, slope1);
        return factors_.second * first1 * first1 / (m0 * m0) + factors_.first * second / m0;
    }

    const LutAxis& axis_;
    RoughnessFactors factors_;
    std::vector<double> rows_;
    std::vector<Piece> pieces_;
};

/// Returns the share of half vectors whose polar angle exceeds psi.
double shareBeyond(double psi, double m, SpecularLobe lobe) {
    if (psi >= kPi / 2) return 0;
    const double squaredTangent = std::pow(std::tan(psi), 2);
    return lobe == SpecularLobe::Beckmann ? std::exp(-squaredTangent / (m * m)) : m * m / (m * m + squaredTangent);
}

/// Half vectors in rings of polar angle, with the share of the distribution in each ring for each roughness.
class HalfVectorRings {
public:
    /// rows   roughnesses m
    /// scale  factor of the kernels' normalization
    HalfVectorRings(const std::vector<double>& rows, SpecularLobe lobe, double smallestM, double scale) : ends_(endsOf(smallestM)) {
        for (const double m : rows) {
            std::vector<double> shares;
            for (std::size_t ring = 0; ring + 1 < ends_.size(); ++ring)
                shares.push_back((shareBeyond(ends_[ring], m, lobe) - shareBeyond(ends_[ring + 1], m, lobe)) * scale / kArcs);
            shares_.push_back(std::move(shares));
        }
        for (std::size_t ring = 0; ring + 1 < ends_.size(); ++ring)
            isEmpty_.push_back(std::all_of(shares_.begin(), shares_.end(), [&](const auto& row) { return row[ring] < kNothing; }));
    }
    /// Returns, for each ring, intervals of the derivative by the view's angle, summed over the ring's arcs.
    std::vector<EntryIntervals> derivativeOver(double theta0, double theta1) const {
        std::vector<EntryIntervals> rings(ends_.size() - 1);
        for (std::size_t ring = 0; ring < rings.size(); ++ring) {
            if (isEmpty_[ring]) continue;
            // At 90 degrees tangents are infinite. No light is reflected there.
            const double psi1 = std::min(ends_[ring + 1], kPi / 2 - 1e-6);
            for (int arc = 0; arc < kArcs; ++arc)
                lut::addDerivative({theta0, theta1, ends_[ring], psi1, kPi * arc / kArcs, kPi * (arc + 1) / kArcs}, rings[ring]);
        }
        return rings;
    }
    /// Returns the sum of the rings, weighted by their shares for a row.
    EntryIntervals weighted(const std::vector<EntryIntervals>& rings, std::size_t row) const {
        EntryIntervals sums;
        for (std::size_t ring = 0; ring < rings.size(); ++ring)
            for (std::size_t k = 0; k < sums.size(); ++k) {
                sums[k].low += shares_[row][ring] * rings[ring][k].low;
                sums[k].high += shares_[row][ring] * rings[ring][k].high;
            }
        return sums;
    }

private:
    /// Returns the angles between rings: geometric steps from the smallest lobe to 45 degrees, then mirrored, as tangents are unbounded.
    static std::vector<double> endsOf(double smallestM) {
        std::vector<double> ends = {0};
        const double first = std::min(0.1, 0.15 * smallestM), growth = std::pow(kPi / 4 / first, 1.0 / (kLowRings - 1));
        for (int ring = 0; ring < kLowRings; ++ring) ends.push_back(first * std::pow(growth, ring));
        for (int ring = 1; ring < kHighRings; ++ring)
            ends.push_back(kPi / 2 - kPi / 4 * std::pow(kLastRing, static_cast<double>(ring) / (kHighRings - 1)));
        ends.push_back(kPi / 2);
        return ends;
    }

    std::vector<double> ends_;
    std::vector<bool> isEmpty_;                ///< [ring], for all rows
    std::vector<std::vector<double>> shares_;  ///< [row][ring], of one arc
};

/// The pieces of the view axis. An axis value v satisfies v^2 = r0 + r1 NoV + r2 NoV^2.
class ViewPieces {
public:
    explicit ViewPieces(const LutAxis& axis) : axis_(axis) {}

    /// Returns NoV at the ends of the pieces of a cell, ascending. Pieces shrink towards grazing views, where derivatives are large.
    std::vector<double> endsOf(int viewCell) const {
        std::vector<double> cosines;
        const int pieces = std::max(2, kViewPieces / (axis_.count - 1));
        for (int i = 0; i <= pieces; ++i) cosines.push_back(axis_.inverse(axis_.at(viewCell + static_cast<double>(i) / pieces)));
        std::sort(cosines.begin(), cosines.end());
        std::vector<double> ends = {cosines[0]};
        for (std::size_t i = 1; i < cosines.size(); ++i) {
            if (ends.back() < kSmallestTableNoV && cosines[i] > kSmallestTableNoV) ends.push_back(kSmallestTableNoV);
            while (ends.back() >= kSmallestTableNoV && cosines[i] > ends.back() * kGrazingRatio * 1.1)
                ends.push_back(ends.back() * kGrazingRatio);
            double from = std::acos(ends.back());
            const double to = std::acos(cosines[i]);
            const int count = static_cast<int>(std::ceil((from - to) / kWidestPiece));
            for (int piece = 1; piece < count; ++piece) ends.push_back(std::cos(std::lerp(from, to, static_cast<double>(piece) / count)));
            // At the normal, an axis that is not 0 there grows as the root of the angle.
            if (count > 1) from = std::acos(ends.back());
            for (; !isZeroAtNormal() && from > kNarrowestPiece && from > to * kGrazingRatio * 1.1; ends.push_back(std::cos(from)))
                from /= kGrazingRatio;
            ends.push_back(cosines[i]);
        }
        return ends;
    }

    /// Returns an interval of |dtheta/dvalue| between two views. |dtheta/dvalue| = 2 value / (sin(theta) |r1 + 2 r2 NoV|), which is
    /// monotone in its factors. If the axis is 0 at the normal, value and sine both vanish there; the square of their quotient is (r0 - r2
    /// NoV) / (1 + NoV).
    Interval anglePerValue(double leftNoV, double leftValue, double rightNoV, double rightValue) const {
        const auto r = axis_.radicand();
        const auto ends = [](double a, double b) { return Interval{std::min(a, b), std::max(a, b)}; };
        const Interval slope = ends(std::abs(r[1] + 2 * r[2] * leftNoV), std::abs(r[1] + 2 * r[2] * rightNoV));
        Interval quotient;
        if (isZeroAtNormal()) {
            const Interval top = ends(r[0] - r[2] * leftNoV, r[0] - r[2] * rightNoV);
            quotient = {std::sqrt(top.low / (1 + rightNoV)), std::sqrt(top.high / (1 + leftNoV))};
        } else {
            const Interval value = ends(leftValue, rightValue);
            quotient = {value.low / std::sqrt((1 - leftNoV) * (1 + leftNoV)), value.high / std::sqrt((1 - rightNoV) * (1 + rightNoV))};
        }
        return {2 * quotient.low / slope.high, 2 * quotient.high / slope.low};
    }

    /// Returns the rounding error of the axis coordinate in single precision [texels]: the last digit of NoV, times the axis' slope, which
    /// is largest at the normal.
    double rounding(double leftNoV, double leftValue, double rightNoV, double rightValue) const {
        const auto r = axis_.radicand();
        const double slope = std::max(std::abs(r[1] + 2 * r[2] * leftNoV), std::abs(r[1] + 2 * r[2] * rightNoV));
        const double least = std::min(leftValue, rightValue), moved = kFloatRounding * slope;  // of the radicand
        const double off = moved / std::max(2 * least, std::sqrt(moved));
        return off * (axis_.count - 1) / (axis_.maximum - axis_.minimum);
    }

private:
    /// Returns true for axes like the sine, whose radicand has a root at NoV = 1.
    bool isZeroAtNormal() const {
        const auto r = axis_.radicand();
        return std::abs(r[0] + r[1] + r[2]) < 1e-12;
    }

    const LutAxis& axis_;
};

/// Bounds the cells of one column after another.
class LutBounder {
public:
    LutBounder(const CookedLut& tables, const LutKeys& keys, const std::vector<double>& f0, const std::optional<Viewing>& viewing)
        : tables_(tables),
          keys_(keys),
          shadings_(lutShadings(f0)),
          exits_(lutExitRadiances(f0)),
          smallestM_(tables.roughness.inverse(tables.roughness.minimum)),
          largestM_(tables.roughness.inverse(tables.roughness.maximum)),
          scale_(tables.normalization == lighting::CookTorranceNormalization::Halo3 && !isPhong(tables.lobe) ? 4 : 1),
          roughness_(tables.roughness, tables.lobe, scale_),
          view_(tables.view),
          rings_(roughness_.rows(), tables.lobe, smallestM_, scale_) {
        if (viewing) metric_.emplace(*viewing, 1);
    }

    std::vector<LutCellBound> cellsAt(int viewCell) const {
        std::vector<LutCellBound> cells(static_cast<std::size_t>(std::max(1, tables_.roughness.count - 1)));
        std::vector<SpecularKernelEntries> tolerances;
        for (std::size_t row = 0; metric_ && row < cells.size(); ++row) {
            tolerances.push_back(toleranceAt(viewCell, static_cast<int>(row)));
            cells[row].visible = 0;
        }
        const std::vector<double> ends = view_.endsOf(viewCell);
        Column left = columnAt(ends[0]);
        for (std::size_t i = 1; i < ends.size(); ++i) {
            Column right = columnAt(ends[i]);
            addColumn(left, right, tolerances, cells);
            left = std::move(right);
        }
        return cells;
    }

private:
    /// Kernel and error at one view and roughness, and the radiance that each shading makes of them.
    struct Corner {
        SpecularKernelEntries truth{}, error{};
        std::vector<double> reflected, reflectedError;  ///< [shading]
    };
    struct Column {
        double NoV = 0, value = 0;
        std::vector<Corner> corners;  ///< [row]
    };

    Column columnAt(double NoV) const {
        const double seen = std::max(NoV, kSmallestTableNoV);
        const lighting::AreaSpecularColumn kernels(seen, smallestM_, largestM_, tables_.lobe, kCornerPoints);
        Column column{NoV, tables_.view.of(NoV), {}};
        for (const double m : roughness_.rows()) {
            Corner corner;
            corner.truth = entriesOf(kernels.kernel(m, tables_.normalization));
            corner.error = fetchLut(tables_, NoV, m);
            for (std::size_t k = 0; k < corner.error.size(); ++k) corner.error[k] -= corner.truth[k];
            for (const SpecularKernelEntries& shading : shadings_) {
                double reflected = 0, error = 0;
                for (std::size_t k = 0; k < shading.size(); ++k) {
                    reflected += shading[k] * corner.truth[k];
                    error += shading[k] * corner.error[k];
                }
                corner.reflected.push_back(reflected);
                corner.reflectedError.push_back(error);
            }
            column.corners.push_back(std::move(corner));
        }
        return column;
    }

    /// Returns, for each row, upper bounds of the deviation of T from its chord between two views.
    std::vector<SpecularKernelEntries> deviationsFromChord(const Column& left, const Column& right) const {
        const std::size_t rowCount = roughness_.rows().size();
        std::vector<SpecularKernelEntries> all(rowCount, SpecularKernelEntries{});
        if (std::max(left.NoV, right.NoV) <= kSmallestTableNoV) return all;  // T is constant there
        const double theta0 = std::acos(right.NoV), theta1 = std::acos(left.NoV);
        const double width = std::abs(right.value - left.value);
        const Interval perValue = view_.anglePerValue(left.NoV, left.value, right.NoV, right.value);
        const bool isAnalytic = isPhong(tables_.lobe);
        const std::vector<EntryIntervals> rings = isAnalytic ? std::vector<EntryIntervals>() : rings_.derivativeOver(theta0, theta1);
        for (std::size_t row = 0; row < rowCount; ++row) {
            const EntryIntervals derivative =
                isAnalytic ? lut::phongDerivative(theta0, theta1, lighting::phongBands(tables_.lobe, roughness_.rows()[row]))
                           : rings_.weighted(rings, row);
            for (std::size_t k = 0; k < derivative.size(); ++k)
                all[row][k] = deviationFromChord(derivative[k], perValue, width, theta1 - theta0);
        }
        return all;
    }
    static double deviationFromChord(const Interval& slope, const Interval& perValue, double width, double angle) {
        // Mean value theorem: no value differs from an end by more than largest slope * angle, and the chord lies between the ends.
        const double whole = slope.largest() * angle;
        if (!std::isfinite(perValue.high)) return whole;
        const Interval derivative = slope * perValue;
        return std::min(whole, (derivative.high - derivative.low) * width / 4);
    }

    /// Adds the pieces between two columns to their cells.
    /// tolerances  of samplers, for each cell
    void addColumn(const Column& left, const Column& right, const std::vector<SpecularKernelEntries>& tolerances,
                   std::vector<LutCellBound>& cells) const {
        const std::vector<SpecularKernelEntries> deviations = deviationsFromChord(left, right);
        const double fetchRounding = kFetchRounding + view_.rounding(left.NoV, left.value, right.NoV, right.value);
        for (std::size_t piece = 0; piece < roughness_.pieces().size(); ++piece) {
            const RoughnessPieces::Piece& row = roughness_.pieces()[piece];
            SpecularKernelEntries slack;
            for (std::size_t i = 0; i < lut::kKernelCoefficients.size(); ++i)
                for (const std::size_t k : {kEntryOfC[i], kEntryOfD[i]})
                    slack[k] = std::max(deviations[piece][k], deviations[piece + 1][k]) + row.secondDifference * kHalfRange[i] +
                               kKernelRounding * scale_ +
                               fetchRounding * std::abs(static_cast<double>(tables_.scale[k / 4][static_cast<int>(k % 4)]));
            const std::array<const Corner*, 4> corners = {&left.corners[piece], &left.corners[piece + 1], &right.corners[piece],
                                                          &right.corners[piece + 1]};
            addPiece(corners, slack, cells[row.cell]);
            if (metric_) addVisible(corners, slack, tolerances[row.cell], cells[row.cell]);
        }
    }

    /// Returns how far fetches in a cell may be from those of an ideal sampler: at a place 1/256 texel away on each axis, which may lie in
    /// the next cell, and with the tolerance of the format.
    SpecularKernelEntries toleranceAt(int viewCell, int roughnessCell) const {
        SpecularKernelEntries out{};
        for (std::size_t texture = 0; texture < tables_.textures.size(); ++texture) {
            const formats::Image<glm::vec4>& texels = tables_.textures[texture];
            const auto at = [&](int x, int y) {
                return texels.at(std::clamp(x, 0, texels.width() - 1), std::clamp(y, 0, texels.height() - 1));
            };
            glm::vec4 along(0), across(0), largest(0);
            for (int y = roughnessCell - 1; y <= roughnessCell + 2; ++y)
                for (int x = viewCell - 1; x <= viewCell + 2; ++x) {
                    largest = glm::max(largest, glm::abs(at(x, y)));
                    along = glm::max(along, glm::abs(at(x + 1, y) - at(x, y)));
                    across = glm::max(across, glm::abs(at(x, y + 1) - at(x, y)));
                }
            const FormatTolerance& format = tables_.tolerance[texture];
            const bool isIdeal = format.absolute == 0 && format.relative == 0;
            const glm::vec4 off =
                (isIdeal ? glm::vec4(0) : kFractionTolerance * (along + across)) + format.absolute + format.relative * largest;
            for (int channel = 0; channel < 4; ++channel)
                out[4 * texture + static_cast<std::size_t>(channel)] =
                    static_cast<double>(off[channel]) * std::abs(static_cast<double>(tables_.scale[texture][channel]));
        }
        return out;
    }

    /// Raises the bound of visible errors to that of a piece. Each light is scaled such that a white surface has exit radiance 1.
    void addVisible(const std::array<const Corner*, 4>& corners, const SpecularKernelEntries& slack, const SpecularKernelEntries& tolerance,
                    LutCellBound& cell) const {
        for (std::size_t i = 0; i < shadings_.size(); ++i) {
            constexpr double kInfinity = std::numeric_limits<double>::infinity();
            Interval reference{kInfinity, -kInfinity}, error = reference;
            for (const Corner* corner : corners) {
                reference = hullOf(reference, {corner->reflected[i], corner->reflected[i]});
                error = hullOf(error, {corner->reflectedError[i], corner->reflectedError[i]});
            }
            double deviation = 0, sampler = 0;
            for (std::size_t k = 0; k < slack.size(); ++k) {
                deviation += std::abs(shadings_[i][k]) * slack[k];
                sampler += std::abs(shadings_[i][k]) * tolerance[k];
            }
            const double unit = 1 / exits_[i];
            reference = unit * (reference + Interval::around(0, deviation));
            error = unit * (error + Interval::around(0, deviation + sampler));
            const double bound = metric_->greyBound(reference, reference + error, error);
            if (!(bound > cell.visible)) continue;
            cell.visible = bound;
            cell.visibleShading = i;
        }
    }

    void addPiece(const std::array<const Corner*, 4>& corners, const SpecularKernelEntries& slack, LutCellBound& cell) const {
        for (std::size_t k = 0; k < slack.size(); ++k) {
            double error = 0, low = std::numeric_limits<double>::infinity(), high = -low;
            for (const Corner* corner : corners) {
                error = std::max(error, std::abs(corner->error[k]));
                low = std::min(low, corner->truth[k]);
                high = std::max(high, corner->truth[k]);
            }
            cell.entries[k] = std::max(cell.entries[k], error + slack[k]);
            cell.filter = std::max(cell.filter, relative(error, low, high, slack[k], keys_.kernel));
        }
        for (std::size_t i = 0; i < shadings_.size(); ++i) {
            double error = 0, low = std::numeric_limits<double>::infinity(), high = -low, shadedSlack = 0;
            for (const Corner* corner : corners) {
                error = std::max(error, std::abs(corner->reflectedError[i]));
                low = std::min(low, corner->reflected[i]);
                high = std::max(high, corner->reflected[i]);
            }
            for (std::size_t k = 0; k < slack.size(); ++k) shadedSlack += std::abs(shadings_[i][k]) * slack[k];
            cell.total = std::max(cell.total, relative(error, low, high, shadedSlack, keys_.shaded));
        }
    }
    /// Returns the local relative error for values in [low, high], where errors and values may be off by `slack`.
    static double relative(double error, double low, double high, double slack, double key) {
        const double smallest = std::max({0.0, low - slack, -high - slack});
        return (error + slack) / (smallest + lighting::kLocalErrorFloor * key);
    }

    const CookedLut& tables_;
    LutKeys keys_;
    std::vector<SpecularKernelEntries> shadings_;
    std::vector<double> exits_;  ///< of each shading: exit radiance of a white surface
    std::optional<VisibleMetric> metric_;
    double smallestM_, largestM_, scale_;
    RoughnessPieces roughness_;
    ViewPieces view_;
    HalfVectorRings rings_;
};

/// Returns true if the axis maps the value of each texel to its centre. Otherwise the table has kinks inside the cells.
bool meetsItsTexels(const LutAxis& axis) {
    return axis.coordinateError() < 1e-4;
}

}  // namespace

std::vector<LutCellBound> boundLut(const CookedLut& tables, int viewCell, const LutKeys& keys, const std::vector<double>& f0,
                                   const std::optional<Viewing>& viewing) {
    if (!meetsItsTexels(tables.view) || !meetsItsTexels(tables.roughness)) {
        LutCellBound unbounded;
        unbounded.entries.fill(std::numeric_limits<double>::infinity());
        unbounded.filter = unbounded.total = std::numeric_limits<double>::infinity();
        if (viewing) unbounded.visible = std::numeric_limits<double>::infinity();
        return {unbounded};
    }
    return LutBounder(tables, keys, f0, viewing).cellsAt(viewCell);
}

LutBounds boundLut(const CookedLut& tables, const LutKeys& keys, const std::vector<double>& f0, const std::optional<Viewing>& viewing) {
    LutBounds bounds;
    for (int cell = 0; cell + 1 < tables.view.count; ++cell)
        bounds.raise(largestOf(tables, cell, boundLut(tables, cell, keys, f0, viewing), f0));
    return bounds;
}

LutBounds largestOf(const CookedLut& tables, int viewCell, const std::vector<LutCellBound>& cells, const std::vector<double>& f0) {
    LutBounds bounds;
    const LutCellBound* seen = nullptr;
    for (std::size_t row = 0; row < cells.size(); ++row) {
        const double rowMiddle = tables.roughness.count > 1 ? static_cast<double>(row) + 0.5 : 0.0;
        ErrorPlace place =
            lutPlace(tables, tables.view.inverse(tables.view.at(viewCell + 0.5)), tables.roughness.inverse(tables.roughness.at(rowMiddle)));
        if (cells[row].visible > bounds.visible) {
            seen = &cells[row];
            bounds.visible = seen->visible;
            bounds.visibleAt = {.x = place.x, .y = place.y, .normal = place.normal, .view = place.view, .m = place.m};
        }
        ErrorPlace filterAt = place;
        filterAt.local = cells[row].filter;
        place.local = cells[row].total;
        bounds.raise({cells[row].filter, cells[row].total, filterAt, place});
    }
    if (seen == nullptr) return bounds;
    // The light of the middle of the cell.
    const std::size_t shading = seen->visibleShading;
    const LutResult middle = compareLut(tables, {bounds.visibleAt.view.z, bounds.visibleAt.m});
    const auto shown = [&](const SpecularKernelEntries& kernel) {
        const SpecularKernelEntries weights = lutShadings(f0)[shading];
        return glm::dvec3(std::inner_product(kernel.begin(), kernel.end(), weights.begin(), 0.0) / lutExitRadiances(f0)[shading]);
    };
    bounds.visibleAt.f0 = f0[shading % f0.size()];
    bounds.visibleAt.difference = *seen->visible;
    bounds.visibleAt.reference = shown(middle.reference);
    bounds.visibleAt.found = shown(middle.cooked);
    return bounds;
}

}  // namespace lightcook::verify
