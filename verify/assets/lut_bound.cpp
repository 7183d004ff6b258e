#include "verify/lut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "lighting/radiometry.h"

namespace lightcook::verify {
namespace {

using lighting::SpecularLobe;
constexpr double kPi = std::numbers::pi;
/// Pieces of the whole view axis (of a cell, at least two), and no piece whose NoV grows by more than this factor.
constexpr int kViewPieces = 224;
constexpr double kGrazingRatio = 1.35;
/// Nor one that spans a larger angle, radians.
constexpr double kWidestPiece = 0.02;
/// A piece along the normal that is narrower than this need not be cut.
constexpr double kNarrowestPiece = 1e-3;
/// Second differences over roughness may add this much to an entry.
constexpr double kRoughnessSlack = 3e-4;
/// Boxes of half vectors: rings of the polar angle and arcs of half the azimuth.
constexpr int kLowRings = 32, kHighRings = 16, kArcs = 40;
constexpr double kLastRing = 1e-3;  ///< of 45 degrees
constexpr int kCornerPoints = 12;
/// Rounding of a fetch in single precision, as a share of a channel's range; and of the corners' kernels, absolute.
constexpr double kFetchRounding = 4e-6, kKernelRounding = 2e-7;
/// Of a number near 1 in single precision.
constexpr double kFloatRounding = 1.2e-7;
/// Shares of a distribution below this are far under that.
constexpr double kNothing = 1e-15;

struct Interval {
    double low = 0, high = 0;

    static Interval around(double middle, double radius) { return {middle - radius, middle + radius}; }
    double size() const { return std::max(std::abs(low), std::abs(high)); }
};
Interval operator*(const Interval& a, const Interval& b) {
    const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
    return {std::min({p, q, r, s}), std::max({p, q, r, s})};
}
Interval operator+(const Interval& a, const Interval& b) {
    return {a.low + b.low, a.high + b.high};
}
Interval meet(const Interval& a, const Interval& b) {
    return {std::max(a.low, b.low), std::min(a.high, b.high)};
}

using EntryIntervals = std::array<Interval, 12>;
/// Coefficients 0, 2, 3, 6, 7, 8, and where C and D of each stand among the entries.
constexpr std::array<std::size_t, 6> kCoefficients = {0, 2, 3, 6, 7, 8};
constexpr std::array<std::size_t, 6> kC = {0, 1, 2, 3, 8, 9}, kD = {4, 5, 6, 7, 10, 11};
/// |y_l|: no function of a band is larger, and each derivative along a rotation adds a factor l.
constexpr std::array<double, 3> kBandNorm = {0.28209479177387814, 0.48860251190291992, 0.63078313050504001};
/// Half of what w Y_i ranges over, w in [0, 2], light above the horizon: of 0, 2, 3, 6, 7, 8.
constexpr std::array<double, 6> kHalfRange = {0.2820948, 0.4886026, 0.9772051, 0.9461747, 1.0925485, 1.0925485};

double fifthPower(double x) {
    return x * x * x * x * x;
}

/// A box of views and half vectors.
struct Box {
    double theta0, theta1;          ///< of the view
    double psi0, psi1, phi0, phi1;  ///< of the half vector, phi from the view's side

    double viewRadius() const { return (theta1 - theta0) / 2; }
    double halfRadius() const { return (psi1 - psi0) / 2 + std::sin(psi1) * (phi1 - phi0) / 2; }
};

/// w = max(0, min(u, 2, 4 c u - 2)) and its derivative by the view's angle over a box.
struct Attenuation {
    Interval value, slope;
};
Attenuation attenuationOver(const Box& box) {
    const Interval cosine = {std::cos(box.phi1), std::cos(box.phi0)};
    const Interval radius = {std::tan(box.psi0), std::tan(box.psi1)}, tangent = {std::tan(box.theta0), std::tan(box.theta1)};
    const Interval c = {std::pow(std::cos(box.psi1), 2), std::pow(std::cos(box.psi0), 2)};
    const Interval p = radius * cosine, excess = p * tangent;
    const Interval u = {1 + excess.low, 1 + excess.high};
    const auto w = [](double at, double squared) { return std::max(0.0, std::min({at, 2.0, 4 * squared * at - 2})); };
    Attenuation result{{w(u.low, u.low > 0 ? c.low : c.high), w(u.high, c.high)}, {}};

    // Which of the lines may be the smallest, and between 0 and 2, somewhere in the box: its slope, and that times u - 1.
    const Interval active = meet(u, {1 / (2 * c.high), std::max(2.0, 1 / c.low)});
    if (active.low > active.high) return result;
    constexpr double kNone = std::numeric_limits<double>::infinity();
    Interval line = {kNone, -kNone}, moment = line;
    const auto include = [&](const Interval& slope, const Interval& product) {
        line = {std::min(line.low, slope.low), std::max(line.high, slope.high)};
        moment = {std::min(moment.low, product.low), std::max(moment.high, product.high)};
    };
    if (u.low <= 1 / (2 * c.low) || u.high >= 2) include({0, 0}, {0, 0});
    if (u.low <= 2 && (4 * c.high - 1) * u.high >= 2) include({1, 1}, {active.low - 1, std::min(active.high, 2.0) - 1});
    if ((4 * c.low - 1) * active.low <= 2 && 4 * c.low * active.low <= 4) {
        // 4 c u is between 2 and 4 on this line, whatever both are.
        const Interval steep = {4 * c.low, 4 * c.high};
        include(steep, meet(steep * Interval{active.low - 1, active.high - 1}, {2 - 4 * c.high, 4 - 4 * c.low}));
    }
    if (line.low > line.high) return result;
    // du / dtheta = p / cos^2(theta) = (u - 1) / (sin cos): the first is tight along the normal, the second towards grazing views.
    const Interval secant = {1 + tangent.low * tangent.low, 1 + tangent.high * tangent.high};
    result.slope = line * (p * secant);
    if (tangent.low > 0) {
        const double s0 = secant.low / tangent.low, s1 = secant.high / tangent.high;  // 1 / (sin cos), least at 45 degrees
        const double least = tangent.low < 1 && tangent.high > 1 ? 2 : std::min(s0, s1);
        const Interval tighter = meet(result.slope, moment * Interval{least, std::max(s0, s1)});
        if (tighter.low <= tighter.high) result.slope = tighter;
    }
    return result;
}

/// Adds a box's enclosure of d/dtheta (w Y_i), and of that times (1 - VoH)^5, to twelve sums.
void addDerivative(const Box& box, EntryIntervals& sums) {
    const Attenuation w = attenuationOver(box);
    if (w.value.high == 0 && w.slope.size() == 0) return;
    const double theta = (box.theta0 + box.theta1) / 2, psi = (box.psi0 + box.psi1) / 2, phi = (box.phi0 + box.phi1) / 2;
    const glm::dvec3 half(std::sin(psi) * std::cos(phi), std::sin(psi) * std::sin(phi), std::cos(psi));
    const glm::dvec3 view(std::sin(theta), 0, std::cos(theta)), turning(std::cos(theta), 0, -std::sin(theta));
    const double VoH = glm::dot(view, half), VoHSlope = glm::dot(turning, half);
    const glm::dvec3 light = 2 * VoH * half - view, motion = 2 * VoHSlope * half - turning;
    const lighting::ShDouble basis = lighting::evaluateBasis(light);
    // Along the great circle of the light's motion: a finite difference would do, but all six are quadratics.
    const double x = light.x, y = light.y, z = light.z, dx = motion.x, dy = motion.y, dz = motion.z;
    const std::array<double, 6> slopes = {0,
                                          lighting::kShLinear * dz,
                                          lighting::kShLinear * dx,
                                          6 * lighting::kShZonal * z * dz,
                                          lighting::kShProduct * (x * dz + z * dx),
                                          2 * lighting::kShDifference * (x * dx - y * dy)};
    const double moved = box.viewRadius() + 2 * box.halfRadius(), nearer = box.viewRadius() + box.halfRadius();
    const Interval v = {std::clamp(VoH - nearer, 0.0, 1.0), std::clamp(VoH + nearer, 0.0, 1.0)};
    const Interval fresnel = {fifthPower(1 - v.high), fifthPower(1 - v.low)};
    const Interval steep = {-5 * std::pow(1 - v.low, 4), -5 * std::pow(1 - v.high, 4)};
    const Interval fresnelSlope = steep * meet(Interval::around(VoHSlope, nearer), {-1, 1});
    for (std::size_t i = 0; i < kCoefficients.size(); ++i) {
        const int band = lighting::kShBand[kCoefficients[i]];
        const double norm = kBandNorm[static_cast<std::size_t>(band)];
        const Interval value = meet(Interval::around(basis[kCoefficients[i]], band * norm * moved), {-norm, norm});
        const Interval slope = meet(Interval::around(slopes[i], band * band * norm * moved), {-band * norm, band * norm});
        sums[kC[i]] = sums[kC[i]] + w.slope * value + w.value * slope;
        sums[kD[i]] = sums[kD[i]] + w.slope * (value * fresnel) + w.value * (slope * fresnel + value * fresnelSlope);
    }
}

/// Share of half vectors steeper than psi.
double steeper(double psi, double m, SpecularLobe lobe) {
    if (psi >= kPi / 2) return 0;
    const double squaredTangent = std::pow(std::tan(psi), 2);
    return lobe == SpecularLobe::Beckmann ? std::exp(-squaredTangent / (m * m)) : m * m / (m * m + squaredTangent);
}

/// Angles between rings: they grow from the smallest lobe to 45 degrees and shrink again, since tangents do not end.
std::vector<double> ringEnds(double smallestM) {
    std::vector<double> ends = {0};
    const double first = std::min(0.1, 0.15 * smallestM), growth = std::pow(kPi / 4 / first, 1.0 / (kLowRings - 1));
    for (int ring = 0; ring < kLowRings; ++ring) ends.push_back(first * std::pow(growth, ring));
    for (int ring = 1; ring < kHighRings; ++ring)
        ends.push_back(kPi / 2 - kPi / 4 * std::pow(kLastRing, static_cast<double>(ring) / (kHighRings - 1)));
    ends.push_back(kPi / 2);
    return ends;
}

bool isPhong(SpecularLobe lobe) {
    return lobe == SpecularLobe::Phong || lobe == SpecularLobe::PhongPower;
}

/// Means of |first| and |second derivative by m| over the density, times m and m^2.
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

class Bounds {
public:
    Bounds(const CookedLut& tables, const LutKeys& keys, const std::vector<double>& f0)
        : tables_(tables), keys_(keys), shadings_(lutShadings(f0)) {
        smallestM_ = tables.roughness.inverse(tables.roughness.minimum);
        largestM_ = tables.roughness.inverse(tables.roughness.maximum);
        scale_ = tables.normalization == lighting::CookTorranceNormalization::Halo3 && !isPhong(tables.lobe) ? 4 : 1;
        layRows();
        ends_ = ringEnds(smallestM_);
        for (const double m : rows_) {
            std::vector<double> shares;
            for (std::size_t ring = 0; ring + 1 < ends_.size(); ++ring)
                shares.push_back((steeper(ends_[ring], m, tables.lobe) - steeper(ends_[ring + 1], m, tables.lobe)) * scale_ / kArcs);
            shares_.push_back(std::move(shares));
        }
        for (std::size_t ring = 0; ring + 1 < ends_.size(); ++ring)
            isEmpty_.push_back(std::all_of(shares_.begin(), shares_.end(), [&](const auto& row) { return row[ring] < kNothing; }));
    }

    std::vector<LutCellBound> cellsAt(int viewCell) const {
        std::vector<LutCellBound> cells(static_cast<std::size_t>(std::max(1, tables_.roughness.count - 1)));
        const std::vector<double> places = viewPlaces(viewCell);
        Column left = columnAt(places[0]);
        for (std::size_t i = 1; i < places.size(); ++i) {
            Column right = columnAt(places[i]);
            addStrip(left, right, cells);
            left = std::move(right);
        }
        return cells;
    }

private:
    struct Corner {
        SpecularKernelEntries truth{}, error{};
        std::vector<double> reflected, reflectedError;
    };
    struct Column {
        double NoV = 0, value = 0;
        std::vector<Corner> corners;  ///< one a row
    };

    /// Roughnesses that are looked at: pieces of every cell, and how much a piece's second difference may add.
    void layRows() {
        const LutAxis& axis = tables_.roughness;
        rows_ = {smallestM_};
        const double widest = *std::max_element(kHalfRange.begin(), kHalfRange.end());
        for (int cell = 0; cell + 1 < axis.count; ++cell) {
            const double high = axis.at(cell + 1);
            for (double from = axis.at(cell); from < high;) {
                // As wide as the slack allows where roughness is least, which is where the piece begins.
                const double width = std::sqrt(8 * kRoughnessSlack / (widest * curvature(from, from)));
                const double to = from + 1.2 * width < high ? from + width : high;
                rows_.push_back(axis.inverse(to));
                bends_.push_back(curvature(from, to) * (to - from) * (to - from) / 8 * scale_);
                cellOfPiece_.push_back(static_cast<std::size_t>(cell));
                from = to;
            }
        }
        if (bends_.empty()) {
            rows_.push_back(smallestM_);  // a table of one row: a cell without height
            bends_.push_back(0);
            cellOfPiece_.push_back(0);
        }
    }

    /// Bound of |d2T / dvalue2| over a part of the roughness axis, for half ranges of 1.
    double curvature(double low, double high) const {
        const LutAxis& axis = tables_.roughness;
        const RoughnessFactors factors = roughnessFactors(tables_.lobe);
        const double m0 = axis.inverse(low), m1 = axis.inverse(high);
        // value^2 = r0 + r1 m + r2 m^2, twice differentiated by the value.
        const auto radicand = axis.radicand();
        const double slope0 = radicand[1] + 2 * radicand[2] * m0, slope1 = radicand[1] + 2 * radicand[2] * m1;
        const double first0 = 2 * low / std::max(slope0, slope1), first1 = 2 * high / std::min(slope0, slope1);
        const auto bend = [&](double first) { return std::abs(2 - 2 * radicand[2] * first * first); };
        const double second = std::max(bend(first0), bend(first1)) / std::min(slope0, slope1);
        return factors.second * first1 * first1 / (m0 * m0) + factors.first * second / m0;
    }

    /// Values of the view axis from one node to the next; pieces shrink towards grazing, where slopes are steep.
    std::vector<double> viewPlaces(int viewCell) const {
        const LutAxis& axis = tables_.view;
        std::vector<double> cosines;
        const int pieces = std::max(2, kViewPieces / (axis.count - 1));
        for (int i = 0; i <= pieces; ++i) cosines.push_back(axis.inverse(axis.at(viewCell + static_cast<double>(i) / pieces)));
        std::sort(cosines.begin(), cosines.end());
        std::vector<double> places = {cosines[0]};
        for (std::size_t i = 1; i < cosines.size(); ++i) {
            if (places.back() < kSmallestTableNoV && cosines[i] > kSmallestTableNoV) places.push_back(kSmallestTableNoV);
            while (places.back() >= kSmallestTableNoV && cosines[i] > places.back() * kGrazingRatio * 1.1)
                places.push_back(places.back() * kGrazingRatio);
            double from = std::acos(places.back());
            const double to = std::acos(cosines[i]);
            const int count = static_cast<int>(std::ceil((from - to) / kWidestPiece));
            for (int piece = 1; piece < count; ++piece) places.push_back(std::cos(std::lerp(from, to, static_cast<double>(piece) / count)));
            // Off the normal an axis that is not 0 there has a root in the angle.
            if (count > 1) from = std::acos(places.back());
            for (; !isZeroAlongNormal() && from > kNarrowestPiece && from > to * kGrazingRatio * 1.1; places.push_back(std::cos(from)))
                from /= kGrazingRatio;
            places.push_back(cosines[i]);
        }
        return places;
    }

    /// As the sine is: its radicand has a root at NoV = 1.
    bool isZeroAlongNormal() const {
        const auto r = tables_.view.radicand();
        return std::abs(r[0] + r[1] + r[2]) < 1e-12;
    }

    Column columnAt(double NoV) const {
        const double seen = std::max(NoV, kSmallestTableNoV);
        const lighting::AreaSpecularColumn kernels(seen, smallestM_, largestM_, tables_.lobe, kCornerPoints);
        Column column{NoV, tables_.view.of(NoV), {}};
        for (const double m : rows_) {
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

    /// Enclosures of the derivative by theta, summed over the arcs of each ring.
    std::vector<EntryIntervals> derivativeOver(double theta0, double theta1) const {
        std::vector<EntryIntervals> rings(ends_.size() - 1);
        for (std::size_t ring = 0; ring < rings.size(); ++ring) {
            if (isEmpty_[ring]) continue;
            // Half vectors at a right angle to the normal end all light: the last ring only closes the range.
            const double psi1 = std::min(ends_[ring + 1], kPi / 2 - 1e-6);
            for (int arc = 0; arc < kArcs; ++arc)
                addDerivative({theta0, theta1, ends_[ring], psi1, kPi * arc / kArcs, kPi * (arc + 1) / kArcs}, rings[ring]);
        }
        return rings;
    }

    /// What T may differ from its chord between two views, for each row.
    std::vector<SpecularKernelEntries> bulges(const Column& left, const Column& right) const {
        std::vector<SpecularKernelEntries> all(rows_.size(), SpecularKernelEntries{});
        if (std::max(left.NoV, right.NoV) <= kSmallestTableNoV) return all;  // held
        const double theta0 = std::acos(right.NoV), theta1 = std::acos(left.NoV);
        const double width = std::abs(right.value - left.value);
        const Interval perValue = anglePerValue(left, right);
        if (isPhong(tables_.lobe)) return phongBulges(theta0, theta1, perValue, width);
        const std::vector<EntryIntervals> rings = derivativeOver(theta0, theta1);
        for (std::size_t row = 0; row < rows_.size(); ++row) {
            EntryIntervals sums;
            for (std::size_t ring = 0; ring < rings.size(); ++ring)
                for (std::size_t k = 0; k < sums.size(); ++k) {
                    sums[k].low += shares_[row][ring] * rings[ring][k].low;
                    sums[k].high += shares_[row][ring] * rings[ring][k].high;
                }
            for (std::size_t k = 0; k < sums.size(); ++k) all[row][k] = bulge(sums[k], perValue, width, theta1 - theta0);
        }
        return all;
    }
    /// |d theta / d value| = 2 value / (sin(theta) |r1 + 2 r2 NoV|), which is monotone in its factors. Where the axis is 0 along the
    /// normal, as the sine is, both vanish there and their quotient's square is (r0 - r2 NoV) / (1 + NoV).
    Interval anglePerValue(const Column& left, const Column& right) const {
        const auto r = tables_.view.radicand();
        const auto ends = [](double a, double b) { return Interval{std::min(a, b), std::max(a, b)}; };
        const Interval slope = ends(std::abs(r[1] + 2 * r[2] * left.NoV), std::abs(r[1] + 2 * r[2] * right.NoV));
        Interval quotient;
        if (isZeroAlongNormal()) {
            const Interval top = ends(r[0] - r[2] * left.NoV, r[0] - r[2] * right.NoV);
            quotient = {std::sqrt(top.low / (1 + right.NoV)), std::sqrt(top.high / (1 + left.NoV))};
        } else {
            const Interval value = ends(left.value, right.value);
            quotient = {value.low / std::sqrt((1 - left.NoV) * (1 + left.NoV)), value.high / std::sqrt((1 - right.NoV) * (1 + right.NoV))};
        }
        return {2 * quotient.low / slope.high, 2 * quotient.high / slope.low};
    }
    static double bulge(const Interval& slope, const Interval& perValue, double width, double turn) {
        // Between two places a function moves no farther from either than its steepest slope takes it, and the chord lies between them.
        const double whole = slope.size() * turn;
        if (!std::isfinite(perValue.high)) return whole;
        const Interval derivative = slope * perValue;
        return std::min(whole, (derivative.high - derivative.low) * width / 4);
    }
    /// Both Phong lobes turn with the reflection: a band's second derivative by theta is at most l^2 |y_l|, its own factor at most 1.
    std::vector<SpecularKernelEntries> phongBulges(double theta0, double theta1, const Interval& perValue, double width) const {
        const double theta = (theta0 + theta1) / 2, radius = (theta1 - theta0) / 2;
        const double s = std::sin(theta), c = std::cos(theta);
        const std::array<double, 6> values = {lighting::kShConstant,         lighting::kShLinear * c,
                                              -lighting::kShLinear * s,      lighting::kShZonal * (3 * c * c - 1),
                                              -lighting::kShProduct * s * c, lighting::kShDifference * s * s};
        const std::array<double, 6> slopes = {0,
                                              -lighting::kShLinear * s,
                                              -lighting::kShLinear * c,
                                              -6 * lighting::kShZonal * s * c,
                                              -lighting::kShProduct * (c * c - s * s),
                                              2 * lighting::kShDifference * s * c};
        const Interval v = {std::cos(theta1), std::cos(theta0)};
        const Interval schlick = {fifthPower(1 - v.high), fifthPower(1 - v.low)};
        const Interval schlickSlope =
            Interval{5 * std::pow(1 - v.high, 4), 5 * std::pow(1 - v.low, 4)} * Interval{std::sin(theta0), std::sin(theta1)};
        std::vector<SpecularKernelEntries> all;
        for (const double m : rows_) {
            const lighting::ShBands bands = lighting::phongBands(tables_.lobe, m);
            SpecularKernelEntries entries{};
            for (std::size_t i = 0; i < values.size(); ++i) {
                const int band = lighting::kShBand[kCoefficients[i]];
                const double factor = bands[static_cast<std::size_t>(band)], norm = kBandNorm[static_cast<std::size_t>(band)];
                const Interval value = Interval::around(values[i], band * norm * radius) * Interval{factor, factor};
                const Interval slope = Interval::around(slopes[i], band * band * norm * radius) * Interval{factor, factor};
                entries[kC[i]] = bulge(slope, perValue, width, theta1 - theta0);
                entries[kD[i]] = bulge(slope * schlick + value * schlickSlope, perValue, width, theta1 - theta0);
            }
            all.push_back(entries);
        }
        return all;
    }

    /// What the view axis may be off by in single precision, in texels: NoV's own last digit, where the axis is steep, along the normal.
    double rounding(const Column& left, const Column& right) const {
        const auto r = tables_.view.radicand();
        const double slope = std::max(std::abs(r[1] + 2 * r[2] * left.NoV), std::abs(r[1] + 2 * r[2] * right.NoV));
        const double least = std::min(left.value, right.value), moved = kFloatRounding * slope;  // of the radicand
        const double off = moved / std::max(2 * least, std::sqrt(moved));
        return off * (tables_.view.count - 1) / (tables_.view.maximum - tables_.view.minimum);
    }

    void addStrip(const Column& left, const Column& right, std::vector<LutCellBound>& cells) const {
        const std::vector<SpecularKernelEntries> between = bulges(left, right);
        const double fetchRounding = kFetchRounding + rounding(left, right);
        for (std::size_t piece = 0; piece < bends_.size(); ++piece) {
            SpecularKernelEntries slack;
            for (std::size_t i = 0; i < kCoefficients.size(); ++i)
                for (const std::size_t k : {kC[i], kD[i]})
                    slack[k] = std::max(between[piece][k], between[piece + 1][k]) + bends_[piece] * kHalfRange[i] +
                               kKernelRounding * scale_ +
                               fetchRounding * std::abs(static_cast<double>(tables_.scale[k / 4][static_cast<int>(k % 4)]));
            const std::array<const Corner*, 4> corners = {&left.corners[piece], &left.corners[piece + 1], &right.corners[piece],
                                                          &right.corners[piece + 1]};
            addPiece(corners, slack, cells[cellOfPiece_[piece]]);
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
            double error = 0, low = std::numeric_limits<double>::infinity(), high = -low, loose = 0;
            for (const Corner* corner : corners) {
                error = std::max(error, std::abs(corner->reflectedError[i]));
                low = std::min(low, corner->reflected[i]);
                high = std::max(high, corner->reflected[i]);
            }
            for (std::size_t k = 0; k < slack.size(); ++k) loose += std::abs(shadings_[i][k]) * slack[k];
            cell.total = std::max(cell.total, relative(error, low, high, loose, keys_.shaded));
        }
    }
    static double relative(double error, double low, double high, double slack, double key) {
        const double least = std::max({0.0, low - slack, -high - slack});
        return (error + slack) / (least + lighting::kLocalErrorFloor * key);
    }

    const CookedLut& tables_;
    LutKeys keys_;
    std::vector<SpecularKernelEntries> shadings_;
    double smallestM_ = 0, largestM_ = 0, scale_ = 1;
    std::vector<double> rows_;                 ///< m of each row of corners
    std::vector<double> bends_;                ///< between a row and the next: second difference for a half range of 1
    std::vector<std::size_t> cellOfPiece_;     ///< likewise: the cell of roughness
    std::vector<double> ends_;                 ///< of rings
    std::vector<bool> isEmpty_;                ///< rings that have nothing of any row
    std::vector<std::vector<double>> shares_;  ///< of the distribution in an arc of each ring, for each row
};

/// Whether the filter meets texel i at its own value: elsewhere the table has kinks where none are looked for.
bool meetsItsTexels(const LutAxis& axis) {
    for (const int texel : {0, axis.count - 1}) {
        const double coordinate = axis.at(texel) * static_cast<double>(axis.scale) + static_cast<double>(axis.offset);
        if (!(std::abs(coordinate * axis.count - texel - 0.5) < 1e-4)) return false;
    }
    return true;
}

}  // namespace

std::vector<LutCellBound> boundLut(const CookedLut& tables, int viewCell, const LutKeys& keys, const std::vector<double>& f0) {
    if (!meetsItsTexels(tables.view) || !meetsItsTexels(tables.roughness)) {
        LutCellBound none;
        none.entries.fill(std::numeric_limits<double>::infinity());
        none.filter = none.total = std::numeric_limits<double>::infinity();
        return {none};
    }
    return Bounds(tables, keys, f0).cellsAt(viewCell);
}

LutBounds boundLut(const CookedLut& tables, const LutKeys& keys, const std::vector<double>& f0) {
    LutBounds bounds;
    for (int cell = 0; cell + 1 < tables.view.count; ++cell) bounds.raise(largestOf(tables, cell, boundLut(tables, cell, keys, f0)));
    return bounds;
}

LutBounds largestOf(const CookedLut& tables, int viewCell, const std::vector<LutCellBound>& cells) {
    LutBounds bounds;
    for (std::size_t row = 0; row < cells.size(); ++row) {
        const double rowMiddle = tables.roughness.count > 1 ? static_cast<double>(row) + 0.5 : 0.0;
        ErrorPlace place =
            lutPlace(tables, tables.view.inverse(tables.view.at(viewCell + 0.5)), tables.roughness.inverse(tables.roughness.at(rowMiddle)));
        ErrorPlace filterAt = place;
        filterAt.local = cells[row].filter;
        place.local = cells[row].total;
        bounds.raise({cells[row].filter, cells[row].total, filterAt, place});
    }
    return bounds;
}

}  // namespace lightcook::verify
