#include "verify/rsrm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "lighting/radiometry.h"
#include "lighting/sh.h"
#include "shaders/lightcook_cpp.h"
#include "verify/error/sample_errors.h"
#include "verify/error/visible_metric.h"
#include "verify/texture_unit.h"

namespace lightcook::verify {
namespace {

/// Gauss-Legendre nodes of an integral over the distance from the reflection vector, and steps of the table of a lobe's density.
constexpr int kNodeCount = 20, kTableSteps = 4096;
/// Share of a lobe that lies farther out than its quadrature reaches.
constexpr double kFarShare = 1e-9;
/// Largest error of the share of a lobe above an edge: measured as 2.4e-7 against 400 nodes and exact powers (docs/theory/lighting.md).
constexpr double kShareError = 4e-7;
/// Largest effect of a shader's float texture coordinates, relative to the gradient's largest value: 2^-14 texel.
constexpr double kRoundingError = 5e-5;
/// Smaller codes count as 0: floats of a shader may flush such light to 0.
constexpr double kLeastCode = 1e-30;
/// The smallest step of halves and of shared exponents is two to this power.
constexpr int kLeastStepExponent = -24;

/// Returns the height z of the upper edge of a zone.
double edgeHeight(std::size_t edge, std::size_t zoneCount) {
    return 1 - 2 * static_cast<double>(edge) / static_cast<double>(zoneCount);
}

/// Returns acos of a value clamped to [-1, 1], as a root times a polynomial (Abramowitz and Stegun 4.4.46), within 5e-8. It has no branch
/// and no call, so that loops over it are vectorized.
inline double arcOf(double cosine) {
    const double size = std::abs(cosine), x = size > 1 ? 1 : size;
    const double low = 1.5707963050 + x * (-0.2145988016 + x * (0.0889789874 + x * -0.0501743046));
    const double high = 0.0308918810 + x * (-0.0170881256 + x * (0.0066700901 + x * -0.0012624911));
    const double arc = std::sqrt(1 - x) * (low + x * x * (x * x) * high);
    return cosine < 0 ? std::numbers::pi - arc : arc;
}

/// Nodes and weights of an integral over [0, 1] whose integrand has a square root at either end: Gauss-Legendre after x = t^2 (3 - 2 t).
struct Nodes {
    Nodes() {
        for (int i = 0; i < kNodeCount; ++i) {
            double root = std::cos(std::numbers::pi * (i + 0.75) / (kNodeCount + 0.5)), slope = 1;
            for (int newton = 0; newton < 8; ++newton) {
                double before = 1, value = root;
                for (int degree = 2; degree <= kNodeCount; ++degree)
                    before = std::exchange(value, ((2 * degree - 1) * root * value - (degree - 1) * before) / degree);
                slope = kNodeCount * (root * value - before) / (root * root - 1);
                root -= value / slope;
            }
            const double t = 0.5 * (1 - root), weight = 1 / ((1 - root * root) * slope * slope);
            at[static_cast<std::size_t>(i)] = t * t * (3 - 2 * t);
            weights[static_cast<std::size_t>(i)] = weight * 6 * t * (1 - t);
        }
    }
    std::array<double, kNodeCount> at{}, weights{};
};

/// A Phong lobe over y = sqrt(1 - cos a), a the angle from the reflection vector: cos(a)^(s + 1) is its share beyond a. The density is a
/// table, because a power for each node would take most of the time.
class Lobe {
public:
    explicit Lobe(double exponent)
        : exponent_(exponent), farthest_(std::sqrt(1 - std::pow(kFarShare, 1 / (exponent + 1)))), perStep_(kTableSteps / farthest_) {
        for (int i = 0; i <= kTableSteps + 1; ++i) {
            const double y = i / perStep_;
            density_.push_back(2 * y * (exponent + 1) * std::pow(std::max(0.0, 1 - y * y), exponent));
        }
    }
    double exponent() const { return exponent_; }
    double farthest() const { return farthest_; }
    double within(double y) const { return 1 - std::pow(std::max(0.0, 1 - y * y), exponent_ + 1); }
    double density(double y) const {
        const double position = y * perStep_;
        const int step = static_cast<int>(position);
        const double* const at = density_.data() + step;
        return at[0] + (position - step) * (at[1] - at[0]);
    }

private:
    double exponent_, farthest_, perStep_;
    std::vector<double> density_;
};

/// Height z of a reflection vector or an edge between zones, with sine and cosine of half its polar angle.
struct Height {
    explicit Height(double height) : z(height), halfSine(std::sqrt(0.5 * (1 - height))), halfCosine(std::sqrt(0.5 * (1 + height))) {}
    double z, halfSine, halfCosine;
};

/// Returns the share of a lobe around `axis` above an edge. Circles around the axis nearer than the edge are on one side of it, and those
/// farther than the edge's circle reaches around a pole on the side of the other pole. Those between are above it along an arc acos(q).
double shareAbove(const Lobe& lobe, const Height& axis, const Height& edge) {
    static const Nodes nodes;
    const double along = axis.halfSine * edge.halfCosine, across = axis.halfCosine * edge.halfSine;
    const double nearest = std::numbers::sqrt2 * std::abs(along - across), whole = std::numbers::sqrt2 * (along + across);
    const bool isAxisAbove = edge.z < axis.z;
    if (nearest >= lobe.farthest()) return isAxisAbove ? 1 : 0;
    const double width = std::min(whole, lobe.farthest()) - nearest, below = edge.z - axis.z;
    const double perSine = 0.5 / (axis.halfSine * axis.halfCosine);
    double sum = 0;
    for (std::size_t i = 0; i < nodes.at.size(); ++i) {
        const double y = nearest + width * nodes.at[i], square = y * y;
        const double q = (below + square * axis.z) * perSine / (y * std::sqrt(2 - square));
        sum += nodes.weights[i] * lobe.density(y) * arcOf(q);
    }
    double share = width * sum / std::numbers::pi;
    if (isAxisAbove) share += lobe.within(nearest);
    if (whole < lobe.farthest() && axis.z + edge.z < 0) share += 1 - lobe.within(whole);
    return share;
}

/// Convolves around a reflection vector off the poles. The weight of a zone is the difference of the lobe's shares above its two edges, so
/// that the result is exact but for the error of these shares.
glm::dvec3 convolveByShares(const std::vector<glm::vec3>& gradient, const Lobe& lobe, double z) {
    const Height axis(z);
    glm::dvec3 sum(0);
    double above = 0;
    for (std::size_t zone = 0; zone < gradient.size(); ++zone) {
        const double next = zone + 1 == gradient.size() ? 1 : shareAbove(lobe, axis, Height(edgeHeight(zone + 1, gradient.size())));
        sum += (next - above) * glm::dvec3(gradient[zone]);
        above = next;
    }
    return sum;
}

/// Convolves at a pole, where circles are zones: the weight of a zone is (s + 1) times the integral of c^s.
glm::dvec3 convolveAtPole(const std::vector<glm::vec3>& gradient, double exponent, bool isNorth) {
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < gradient.size(); ++i) {
        const double high = std::max(edgeHeight(i, gradient.size()), 0.0), low = std::max(edgeHeight(i + 1, gradient.size()), 0.0);
        const std::size_t zone = isNorth ? i : gradient.size() - 1 - i;
        sum += (std::pow(high, exponent + 1) - std::pow(low, exponent + 1)) * glm::dvec3(gradient[zone]);
    }
    return sum;
}

glm::dvec3 convolve(const std::vector<glm::vec3>& gradient, const Lobe& lobe, double z) {
    return 1 - std::abs(z) < 1e-12 ? convolveAtPole(gradient, lobe.exponent(), z > 0) : convolveByShares(gradient, lobe, z);
}

glm::dvec3 fetch(const CookedRsrm& map, int row, double z) {
    const glm::vec3 reflection(glm::dvec3(std::sqrt(std::max(0.0, 1 - z * z)), 0, z));
    const glm::vec2 uv =
        shaders::lcRsrmUv(reflection, glm::vec3(0, 0, 1), static_cast<float>(row), static_cast<float>(map.texels.height()));
    const glm::vec4 texel = sampleBilinear(map.texels.view(), glm::dvec2(uv));
    return glm::dvec3(map.isGrey ? shaders::lcRsrmGrey(texel.x, map.color) : shaders::lcRsrm(glm::vec3(texel), map.color));
}

/// Returns the sampler tolerance at a texel, in light: a place 1/256 texel away along the row and across rows, and the format's tolerance.
glm::dvec3 toleranceAt(const CookedRsrm& map, int row, int column) {
    const auto at = [&](int x, int y) {
        return map.texels.at(std::clamp(x, 0, map.texels.width() - 1), std::clamp(y, 0, map.texels.height() - 1));
    };
    glm::vec4 along(0), across(0), largest(0), span(0);
    for (int y = row - 1; y <= row + 1; ++y)
        for (int x = column - 1; x <= column + 1; ++x) {
            largest = glm::max(largest, glm::abs(at(x, y)));
            along = glm::max(along, glm::abs(at(x + 1, y) - at(x, y)));
            across = glm::max(across, glm::abs(at(x, y + 1) - at(x, y)));
            if (map.spans.width() > 0)
                span = glm::max(span,
                                map.spans.at(std::clamp(x, 0, map.texels.width() - 1) / 4, std::clamp(y, 0, map.texels.height() - 1) / 4));
        }
    const FormatTolerance& format = map.tolerance;
    const bool isIdeal = format.absolute == 0 && format.relative == 0;
    const glm::vec4 filter = isIdeal ? glm::vec4(0) : kFractionTolerance * (along + across);
    const glm::vec4 off = filter + format.decoded + format.perSpan * span + format.absolute + format.relative * largest;
    return glm::abs(glm::dvec3(map.color)) * (map.isGrey ? glm::dvec3(off.x) : glm::dvec3(off));
}

/// Smallest and largest value of the source, and the largest error of a reference computed from it.
struct Ends {
    glm::dvec3 low, high, slack;
};
Ends endsOf(const RsrmSource& source) {
    Ends ends{glm::dvec3(source.gradient[0]), glm::dvec3(source.gradient[0]), {}};
    // A convolution is the sum over edges of the light's step there times the lobe's share above.
    glm::dvec3 steps(0), before(source.gradient[0]);
    for (const glm::vec3& zone : source.gradient) {
        steps += glm::abs(glm::dvec3(zone) - before);
        before = glm::dvec3(zone);
        ends.low = glm::min(ends.low, glm::dvec3(zone));
        ends.high = glm::max(ends.high, glm::dvec3(zone));
    }
    ends.low = glm::max(ends.low - source.uncertainty, glm::dvec3(0));
    ends.high += source.uncertainty;
    ends.slack = kShareError * steps + kRoundingError * ends.high + source.uncertainty;
    return ends;
}

double logAverage(const std::vector<RsrmRow>& rows, const glm::vec3& luminanceWeights) {
    std::vector<double> luminances;
    double sum = 0, logSum = 0;
    for (const RsrmRow& row : rows)
        for (const RsrmRow::Point& point : row.points)
            if (point.isCentre) luminances.push_back(glm::dot(point.reference, glm::dvec3(luminanceWeights)));
    for (const double luminance : luminances) sum += luminance;
    if (!(sum > 0)) return 0;
    // Black zones count as a ten-thousandth of the mean; otherwise they would make the average 0.
    const double count = static_cast<double>(luminances.size()), least = 1e-4 * sum / count;
    for (const double luminance : luminances) logSum += std::log(std::max(luminance, least));
    return std::exp(logSum / count);
}

/// The source around a part of a row, and the error of references there.
class RowSource {
public:
    RowSource(const RsrmSource& source, double exponent)
        : source_(source), all_(endsOf(source)), exponent_(exponent), reach_(std::acos(std::pow(kFar, 1 / (exponent + 1)))) {
        for (std::size_t edge = 0; edge <= source.gradient.size(); ++edge)
            edges_.push_back(std::acos(std::clamp(edgeHeight(edge, source.gradient.size()), -1.0, 1.0)));
    }
    const glm::dvec3& slack() const { return all_.slack; }

    /// References between two polar angles: their range, and a bound of their slope over the angle.
    struct Near {
        glm::dvec3 low, high, slope;
    };
    /// A lobe's share kFar lies beyond reach_, and is of any light of the source. The rest is a mean of the zones within reach.
    /// The slope of a convolution is at most half the range of the light times the integral of |dk/da| of the lobe,
    /// (s + 1) s / pi B(s/2, 3/2) < sqrt(2 (s + 1) / pi) (Kershaw's inequality). Beyond reach_ that integral is at most
    /// 2 / pi (s + 1) cos(reach_)^s, and light is off the middle of the range by at most that of the source.
    Near between(double from, double to) const {
        Ends near{all_.high, all_.low, {}};
        const auto first = std::ranges::upper_bound(edges_, from - reach_), last = std::ranges::lower_bound(edges_, to + reach_);
        const auto begin = static_cast<std::size_t>(std::max<std::ptrdiff_t>(first - edges_.begin() - 1, 0)),
                   end = std::min(static_cast<std::size_t>(last - edges_.begin()), source_.gradient.size());
        for (std::size_t zone = begin; zone < end; ++zone) {
            near.low = glm::min(near.low, glm::dvec3(source_.gradient[zone]) - source_.uncertainty);
            near.high = glm::max(near.high, glm::dvec3(source_.gradient[zone]) + source_.uncertainty);
        }
        near.low = glm::max(near.low, all_.low);
        const glm::dvec3 range = all_.high - all_.low;
        const double far = 2 / std::numbers::pi * (exponent_ + 1) * std::pow(kFar, exponent_ / (exponent_ + 1));
        return {near.low - kFar * range, near.high + kFar * range,
                0.5 * std::sqrt(2 * (exponent_ + 1) / std::numbers::pi) * (near.high - near.low) + far * range};
    }

private:
    static constexpr double kFar = 1e-12;
    const RsrmSource& source_;
    Ends all_;
    double exponent_;
    double reach_;               ///< [rad]
    std::vector<double> edges_;  ///< polar angles of the zones' edges
};

/// Ranges of the light of a part of a row, by channel.
struct PartLight {
    Intervals reference, found;
};

/// Returns the light between two points of a row.
///   - What is found is linear between texel centres, and off by the sampler tolerance.
///   - The reference is Lipschitz in the angle, and within the range of the source there.
/// left, right  the texel centres on either side, or twice the outermost one beside a pole
PartLight lightBetween(const RsrmRow::Point& a, const RsrmRow::Point& b, const RsrmRow::Point& left, const RsrmRow::Point& right,
                       const RowSource& source) {
    const double from = std::acos(a.z), to = std::acos(b.z);
    const RowSource::Near near = source.between(from, to);
    PartLight out;
    for (int channel = 0; channel < 3; ++channel) {
        const auto c = static_cast<std::size_t>(channel);
        const double middle = 0.5 * (a.reference[channel] + b.reference[channel]);
        const double reach = 0.5 * near.slope[channel] * (to - from) + source.slack()[channel];
        out.reference[c] = {std::max(near.low[channel] - source.slack()[channel], middle - reach),
                            std::min(near.high[channel] + source.slack()[channel], middle + reach)};
        // Rounding of the texture coordinate.
        const double slack = 1e-4 * std::abs(left.cooked[channel] - right.cooked[channel]) +
                             1e-6 * std::max(std::abs(a.cooked[channel]), std::abs(b.cooked[channel])) +
                             std::max(left.tolerance[channel], right.tolerance[channel]);
        out.found[c] = {std::min(a.cooked[channel], b.cooked[channel]) - slack, std::max(a.cooked[channel], b.cooked[channel]) + slack};
    }
    return out;
}

/// Returns the bound of the local error of a part of a row. Sets only `local` and `channel`.
ErrorPlace boundOf(const PartLight& light, double key) {
    ErrorPlace worst;
    for (int channel = 0; channel < 3; ++channel) {
        const auto raise = [&](double bound) {
            if (!(bound > worst.local)) return;
            worst.channel = channel;
            worst.local = bound;
        };
        const Interval &reference = light.reference[static_cast<std::size_t>(channel)],
                       &found = light.found[static_cast<std::size_t>(channel)];
        const double low = std::max(reference.low, 0.0), high = std::max(reference.high, 0.0), floor = lighting::kLocalErrorFloor * key;
        if (found.high > low) raise((found.high - low) / (low + floor));
        if (high > found.low) raise((high - found.low) / (high + floor));
    }
    return worst;
}

struct RowErrors {
    SampleErrors quantize, total;
};

/// Returns the place of z in a row of `width` texels.
ErrorPlace placeOf(double z, int width, int row, int channel) {
    ErrorPlace place;
    place.x = std::clamp(0.5 * (1 - z) * width - 0.5, 0.0, width - 1.0);
    place.y = row;
    place.channel = channel;
    place.normal = {std::sqrt(std::max(0.0, 1 - z * z)), 0, z};
    return place;
}

/// Adds the colours of a point, as a pixel shows them.
void addVisible(const RsrmRow::Point& point, const ErrorPlace& at, RowErrors& errors) {
    const VisiblePlace place{.x = at.x, .y = at.y, .normal = at.normal};
    for (SampleErrors* each : {&errors.total, &errors.quantize})
        if (each->visible && (point.isCentre || each == &errors.total)) each->visible->add(point.reference, point.cooked, place);
}

/// Adds the bounds of the parts between the points of a row, pole to pole.
/// metric  of the display; null: no bounds of visible errors
void addBounds(const RsrmRow& row, int index, int width, const RowSource& source, double key, const VisibleMetric* metric,
               RowErrors& errors) {
    std::vector<const RsrmRow::Point*> centres;
    for (const RsrmRow::Point& point : row.points)
        if (point.isCentre) centres.push_back(&point);
    std::size_t next = 0;  // centre at the part's end, or beyond it
    for (std::size_t i = 0; i + 1 < row.points.size(); ++i) {
        const RsrmRow::Point &a = row.points[i], &b = row.points[i + 1];
        if (a.isCentre) ++next;
        const RsrmRow::Point &left = *centres[next > 0 ? next - 1 : 0], &right = *centres[std::min(next, centres.size() - 1)];
        const PartLight light = lightBetween(a, b, left, right, source);
        ErrorPlace place = placeOf(0.5 * (a.z + b.z), width, index, 0);
        const ErrorPlace bound = boundOf(light, key);
        place.local = bound.local;
        place.channel = bound.channel;
        errors.total.energy.addBound(bound.local, place);
        if (metric != nullptr)
            errors.total.visible->addBound(metric->bound(light.reference, light.found), {.x = place.x,
                                                                                         .y = place.y,
                                                                                         .normal = place.normal,
                                                                                         .reference = 0.5 * (a.reference + b.reference),
                                                                                         .found = 0.5 * (a.cooked + b.cooked)});
    }
}

void addRow(const RsrmRow& row, int index, const RowSource& source, double key, const VisibleMetric* metric, RowErrors& errors) {
    const int width = static_cast<int>(std::ranges::count_if(row.points, &RsrmRow::Point::isCentre));
    for (const RsrmRow::Point& point : row.points) {
        addVisible(point, placeOf(point.z, width, index, 0), errors);
        for (int channel = 0; channel < 3; ++channel) {
            const double reference = point.reference[channel], cooked = point.cooked[channel];
            const auto here = [&] { return placeOf(point.z, width, index, channel); };
            errors.total.energy.add(reference, cooked, here);
            if (!point.isCentre) continue;
            errors.quantize.energy.add(reference, cooked, here);
            // Every texel is a sample, so the bound adds only the error of the reference.
            const double slack = source.slack()[channel];
            const double scale = std::max(reference - slack, 0.0) + lighting::kLocalErrorFloor * key, error = std::abs(cooked - reference);
            ErrorPlace place = here();
            place.local = error == 0 ? 0 : (error + slack) / scale;
            errors.quantize.energy.addBound(place.local, place);
        }
    }
    addBounds(row, index, width, source, key, metric, errors);
}

/// Calls place(z, isCentre) from north to south: at both poles, at texel centres, and `between` times from each to the next.
template <class Place>
void forEachPlace(int width, int between, const Place& place) {
    const auto at = [&](double position, bool isCentre) {
        place(1 - 2 * position / width, isCentre);
    };  // position in texels from the north pole
    at(0, false);
    for (int i = 0; i < between; ++i) at(0.5 * (i + 1) / (between + 1), false);
    for (int x = 0; x < width; ++x) {
        at(x + 0.5, true);
        const double gap = x + 1 < width ? 1.0 : 0.5;
        for (int i = 0; i < between; ++i) at(x + 0.5 + gap * (i + 1) / (between + 1), false);
    }
    at(width, false);
}

}  // namespace

glm::dvec3 convolvePhong(const std::vector<glm::vec3>& gradient, double exponent, double z) {
    return convolve(gradient, Lobe(exponent), z);
}

RsrmRow compareRsrmRow(const CookedRsrm& map, const RsrmSource& source, int row, int between) {
    const double exponent = map.exponents[static_cast<std::size_t>(row)];
    const Lobe lobe(exponent);
    RsrmRow result;
    int column = 0;
    forEachPlace(map.texels.width(), between, [&](double z, bool isCentre) {
        result.points.push_back({z, isCentre, convolve(source.gradient, lobe, z), fetch(map, row, z), glm::dvec3(0)});
        if (isCentre) result.points.back().tolerance = toleranceAt(map, row, column++);
    });
    return result;
}

glm::dvec3 rsrmCodeSize(const CookedRsrm& map, const glm::dvec3& light) {
    const glm::dvec3 color = glm::abs(glm::dvec3(map.color));
    if (map.codes == RsrmCodes::Rounded || map.codes == RsrmCodes::Dithered || map.codes == RsrmCodes::Blocks) return color / 255.0;
    const auto stepOf = [](double stored, int bitsBelow) {
        return std::ldexp(1.0, stored > 0 ? std::max(std::ilogb(stored) - bitsBelow, kLeastStepExponent) : kLeastStepExponent);
    };
    glm::dvec3 stored(0), steps(0);
    for (int channel = 0; channel < 3; ++channel)
        if (color[channel] > 0) stored[channel] = std::abs(light[channel]) / color[channel];
    const double largest = std::max({stored.x, stored.y, stored.z});
    for (int channel = 0; channel < 3; ++channel)
        steps[channel] = map.codes == RsrmCodes::SharedExponent ? stepOf(largest, 8) : stepOf(stored[channel], 10);
    return steps * color;
}

RsrmCodeError rsrmCodeError(const CookedRsrm& map, const RsrmSource& source, const std::vector<RsrmRow>& rows) {
    RsrmCodeError worst{-1, 0, 0};
    if (map.codes == RsrmCodes::Blocks || map.codes == RsrmCodes::HalfBlocks) return worst;
    double allowed = map.codes == RsrmCodes::Dithered ? 1.001 : 0.501;
    if (map.codes == RsrmCodes::SharedExponent) allowed = kSharedExponentCodes + 0.001;
    const glm::dvec3 off = 2.0 * endsOf(source).slack;
    for (std::size_t row = 0; row < rows.size(); ++row) {
        int column = 0;
        for (const RsrmRow::Point& point : rows[row].points) {
            if (!point.isCentre) continue;
            const glm::dvec3 codes = rsrmCodeSize(map, point.reference);
            for (int channel = 0; channel < 3; ++channel) {
                const double code = codes[channel];
                const double slack = allowed * code + off[channel] + kLeastCode;
                double beyond = (std::abs(point.cooked[channel] - point.reference[channel]) - slack) / std::max(code, kLeastCode);
                if (!std::isfinite(beyond)) beyond = std::numeric_limits<double>::max();  // also for NaN
                if (beyond > worst.codes) worst = {beyond, static_cast<int>(row), column};
            }
            ++column;
        }
    }
    return worst;
}

RsrmCodeError rsrmDitherError(const CookedRsrm& map, const RsrmSource& source, const std::vector<RsrmRow>& rows) {
    RsrmCodeError worst{-1, 0, 0};
    if (map.codes != RsrmCodes::Dithered) return worst;
    constexpr double kRounding = 1e-3;  // of one texel [codes], as in rsrmCodeError()
    const glm::dvec3 off = 2.0 * endsOf(source).slack;
    for (std::size_t row = 0; row < rows.size(); ++row) {
        glm::dvec3 sum(0);
        int column = 0;
        for (const RsrmRow::Point& point : rows[row].points) {
            if (!point.isCentre) continue;
            const glm::dvec3 codes = rsrmCodeSize(map, point.reference);
            for (int channel = 0; channel < 3; ++channel) {
                const double code = codes[channel];
                if (!(code > kLeastCode)) continue;  // black
                sum[channel] += (point.cooked[channel] - point.reference[channel]) / code;
                const double slack = 0.5 + (column + 1) * (kRounding + (off[channel] + kLeastCode) / code);
                const double beyond = std::abs(sum[channel]) - slack;
                if (beyond > worst.codes) worst = {beyond, static_cast<int>(row), column};
            }
            ++column;
        }
    }
    return worst;
}

RsrmBanding rsrmBanding(const CookedRsrm& map, const std::vector<RsrmRow>& rows, const glm::vec3& luminanceWeights) {
    const double key = logAverage(rows, luminanceWeights);
    RsrmBanding banding;
    for (const RsrmRow& row : rows)
        for (int channel = 0; channel < 3; ++channel) {
            std::vector<double> errors, codeErrors;
            double window = 0, referenceBefore = 0, cookedBefore = 0, codeBefore = 0;
            for (const RsrmRow::Point& point : row.points) {
                if (!point.isCentre) continue;
                const double code = rsrmCodeSize(map, point.reference)[channel];
                if (!(code > kLeastCode)) continue;
                const double reference = point.reference[channel], cooked = point.cooked[channel];
                errors.push_back(cooked - reference);
                codeErrors.push_back(errors.back() / code);
                banding.codeError = std::max(banding.codeError, std::abs(codeErrors.back()));
                window += codeErrors.back();
                const std::size_t count = errors.size();
                if (count > RsrmBanding::kWindow) window -= codeErrors[count - RsrmBanding::kWindow - 1];
                if (count >= RsrmBanding::kWindow) banding.bandCodes = std::max(banding.bandCodes, std::abs(window) / RsrmBanding::kWindow);
                if (count > 1) {
                    const double step = std::abs(errors.back() - errors[count - 2]);
                    banding.stepCodes = std::max(banding.stepCodes, step / std::max(code, codeBefore));
                    const double light = std::max({reference, referenceBefore, cooked, cookedBefore});
                    if (light + key > 0)
                        banding.stepContrast = std::max(banding.stepContrast, step / (light + lighting::kLocalErrorFloor * key));
                }
                referenceBefore = reference, cookedBefore = cooked, codeBefore = code;
            }
        }
    return banding;
}

RsrmBlend compareRsrmBlend(const CookedRsrm& first, const std::vector<glm::vec3>& firstGradient, const CookedRsrm& second,
                           const std::vector<glm::vec3>& secondGradient, double weight, int between) {
    std::vector<glm::vec3> blended;
    for (std::size_t zone = 0; zone < firstGradient.size(); ++zone)
        blended.emplace_back((1 - weight) * glm::dvec3(firstGradient[zone]) + weight * glm::dvec3(secondGradient[zone]));
    RsrmBlend result;
    std::vector<RsrmRow> rows;
    for (std::size_t index = 0; index < first.exponents.size(); ++index) {
        const int row = static_cast<int>(index);
        const Lobe lobe(first.exponents[index]);
        RsrmRow& compared = rows.emplace_back();
        forEachPlace(first.texels.width(), between, [&](double z, bool isCentre) {
            const glm::vec3 cooked =
                shaders::lcRsrmBlend(glm::vec3(fetch(first, row, z)), glm::vec3(fetch(second, row, z)), static_cast<float>(weight));
            const glm::dvec3 reference = convolve(blended, lobe, z);
            compared.points.push_back({z, isCentre, reference, glm::dvec3(cooked), glm::dvec3(0)});
            for (int channel = 0; isCentre && channel < 3; ++channel) {
                const double code =
                    ((1 - weight) * static_cast<double>(first.color[channel]) + weight * static_cast<double>(second.color[channel])) / 255;
                if (code > 0)
                    result.codeError =
                        std::max(result.codeError, std::abs(compared.points.back().cooked[channel] - reference[channel]) / code);
            }
        });
    }
    ErrorAccumulator errors(logAverage(rows, lighting::kRec709Luminance));
    for (const RsrmRow& row : rows)
        for (const RsrmRow::Point& point : row.points)
            for (int channel = 0; channel < 3; ++channel) errors.add(point.reference[channel], point.cooked[channel]);
    result.figures = errors.figures();
    return result;
}

std::vector<StageError> rsrmStages(const CookedRsrm& map, const RsrmSource& source, const std::vector<RsrmRow>& rows,
                                   const glm::vec3& luminanceWeights, const std::optional<Viewing>& viewing) {
    const double key = logAverage(rows, luminanceWeights);
    const SampleErrors none(key, viewing);
    RowErrors diffuse{none, none}, specular{none, none};
    std::optional<VisibleMetric> metric;
    if (viewing) metric.emplace(*viewing, 1);
    for (std::size_t row = 0; row < rows.size(); ++row)
        addRow(rows[row], static_cast<int>(row), RowSource(source, map.exponents[row]), key, metric ? &*metric : nullptr,
               map.exponents[row] == 1 ? diffuse : specular);
    return {{"quantize", diffuse.quantize.figures(), specular.quantize.figures(), 0},
            {"total", diffuse.total.figures(), specular.total.figures(), 0}};
}

double rsrmDisplayKey(const std::vector<glm::vec3>& gradient, const glm::vec3& luminanceWeights) {
    constexpr int kHeights = 64;
    std::vector<double> luminances;
    for (int i = 0; i < kHeights; ++i)
        luminances.push_back(glm::dot(convolvePhong(gradient, 1, 1 - (2.0 * i + 1) / kHeights), glm::dvec3(luminanceWeights)));
    return displayKeyOf(luminances);
}

}  // namespace lightcook::verify
