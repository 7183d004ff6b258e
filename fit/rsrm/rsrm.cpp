#include "fit/rsrm.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace lightcook::fit {
namespace {

constexpr int kMaximumDegree = 2048;
/// The series ends at factors below this: all later terms together add less than 1e-10 of the maximum to any texel.
constexpr double kSmallestFactor = 1e-13;

/// Returns the Legendre factors of the normalised lobe (s + 1) c^s over c in [0, 1]: k_0 = 1, k_1 = (s+1)/(s+2), k_l = k_(l-2)
/// (s-l+2)/(s+l+1), which is the closed form of (s + 1) times the integral of c^s P_l(c). Ends when both parities are negligible.
std::vector<double> lobeFactors(double exponent) {
    std::vector<double> factors = {1.0, (exponent + 1) / (exponent + 2)};
    for (int degree = 2; degree <= kMaximumDegree; ++degree) {
        const double next = factors[static_cast<std::size_t>(degree - 2)] * (exponent - degree + 2) / (exponent + degree + 1);
        factors.push_back(next);
        if (std::abs(next) < kSmallestFactor && std::abs(factors[static_cast<std::size_t>(degree - 1)]) < kSmallestFactor) break;
    }
    return factors;
}

/// Legendre polynomials of three successive degrees at fixed points, by the forward recurrence (stable on [-1, 1]).
class LegendreRun {
public:
    explicit LegendreRun(std::vector<double> points) : z_(std::move(points)), previous_(z_.size(), 1.0), current_(z_), next_(z_.size()) {
        fillNext();
    }
    int degree() const { return degree_; }  ///< degree of current()
    const std::vector<double>& previous() const { return previous_; }
    const std::vector<double>& current() const { return current_; }
    const std::vector<double>& next() const { return next_; }
    void advance() {
        ++degree_;
        previous_.swap(current_);
        current_.swap(next_);
        fillNext();
    }

private:
    void fillNext() {
        const double a = (2.0 * degree_ + 1) / (degree_ + 1), b = static_cast<double>(degree_) / (degree_ + 1);
        for (std::size_t i = 0; i < z_.size(); ++i) next_[i] = a * z_[i] * current_[i] - b * previous_[i];
    }

    int degree_ = 1;
    std::vector<double> z_, previous_, current_, next_;
};

/// Returns the step of radiance at each edge from north to south: the zone below minus the zone above, and 0 beyond both poles. Integrated
/// by parts, (2l + 1) times the integral of L P_l over z is the sum over edges of step times P_(l+1) - P_(l-1).
std::vector<glm::dvec3> edgeSteps(const std::vector<glm::vec3>& gradient) {
    const std::size_t count = gradient.size();
    std::vector<glm::dvec3> steps(count + 1);
    for (std::size_t edge = 0; edge <= count; ++edge) {
        const glm::dvec3 below = edge < count ? glm::dvec3(gradient[edge]) : glm::dvec3(0);
        const glm::dvec3 above = edge > 0 ? glm::dvec3(gradient[edge - 1]) : glm::dvec3(0);
        steps[edge] = below - above;
    }
    return steps;
}

std::vector<double> edgeHeights(std::size_t zoneCount) {
    std::vector<double> heights(zoneCount + 1);
    for (std::size_t edge = 0; edge <= zoneCount; ++edge)
        heights[edge] = 1 - 2 * static_cast<double>(edge) / static_cast<double>(zoneCount);
    return heights;
}

std::vector<double> texelHeights(int width) {
    std::vector<double> heights(static_cast<std::size_t>(width));
    for (int x = 0; x < width; ++x) heights[static_cast<std::size_t>(x)] = 1 - (2.0 * x + 1) / width;
    return heights;
}

glm::dvec3 meanOf(const std::vector<glm::vec3>& gradient) {
    glm::dvec3 sum(0);
    for (const glm::vec3& zone : gradient) sum += glm::dvec3(zone);
    return sum / static_cast<double>(gradient.size());
}

bool isConstant(const std::vector<glm::vec3>& gradient) {
    return std::all_of(gradient.begin(), gradient.end(), [&](const glm::vec3& zone) { return zone == gradient.front(); });
}

/// Clamps to the range of the source. A convolution with a positive kernel of integral 1 stays inside; the series leaves it by rounding
/// only.
void clampToSource(const std::vector<glm::vec3>& gradient, formats::Image<glm::dvec3>& values) {
    glm::dvec3 low(gradient.front()), high(gradient.front());
    for (const glm::vec3& zone : gradient) {
        for (int channel = 0; channel < 3; ++channel) {
            low[channel] = std::min(low[channel], static_cast<double>(zone[channel]));
            high[channel] = std::max(high[channel], static_cast<double>(zone[channel]));
        }
    }
    for (glm::dvec3& value : values.texels()) {
        for (int channel = 0; channel < 3; ++channel) value[channel] = std::clamp(value[channel], low[channel], high[channel]);
    }
}

/// Returns the smallest float not below the value, so that no code exceeds 255, also for denormal colours.
float floatNotBelow(double value) {
    const float nearest = static_cast<float>(value);
    return static_cast<double>(nearest) < value ? std::nextafter(nearest, std::numeric_limits<float>::infinity()) : nearest;
}

/// Sets the codes of one channel of a row. The channel's colour is at least its largest value, so that the diffused error stays within half
/// a code.
void quantizeRow(Rsrm& map, int row, int channel, bool dither) {
    double carried = 0;
    for (int x = 0; x < map.values.width(); ++x) {
        const double wanted = map.values.at(x, row)[channel] / static_cast<double>(map.color[channel]) * 255 + carried;
        const double code = std::clamp(std::floor(wanted + 0.5), 0.0, 255.0);
        map.codes.at(x, row)[channel] = static_cast<std::uint8_t>(code);
        if (dither) carried = wanted - code;
    }
}

}  // namespace

formats::Result<void> checkRsrm(const std::vector<glm::vec3>& gradient, const RsrmOptions& options) {
    using formats::ErrorCode;
    if (gradient.empty()) return formats::failure(ErrorCode::WrongShape, "gradient", "found no zones, expected at least one");
    for (std::size_t zone = 0; zone < gradient.size(); ++zone) {
        for (int channel = 0; channel < 3; ++channel) {
            const float value = gradient[zone][channel];
            if (std::isfinite(value) && value >= 0) continue;
            return formats::failure(std::isfinite(value) ? ErrorCode::ValueOutOfRange : ErrorCode::ValueNotFinite,
                                    "gradient, zone " + std::to_string(zone) + ", channel " + std::string(1, "RGB"[channel]),
                                    fmt::format("found {}, expected a finite value of at least 0", value));
        }
    }
    if (options.width < 1 || options.width > 65536) {
        return formats::failure(ErrorCode::InvalidRequest, "reflection map width",
                                "found " + std::to_string(options.width) + ", expected 1 to 65536");
    }
    if (options.exponents.empty())
        return formats::failure(ErrorCode::InvalidRequest, "reflection map exponents", "found none, expected at least one");
    for (const double exponent : options.exponents) {
        if (exponent >= 1 && exponent <= 65536) continue;
        return formats::failure(ErrorCode::InvalidRequest, "reflection map exponents",
                                "found " + std::to_string(exponent) + ", expected 1 to 65536");
    }
    return {};
}

formats::Image<glm::dvec3> convolveGradient(const std::vector<glm::vec3>& gradient, const RsrmOptions& options) {
    assert(checkRsrm(gradient, options).has_value());
    const int rowCount = static_cast<int>(options.exponents.size());
    formats::Image<glm::dvec3> values(options.width, rowCount, meanOf(gradient));  // degree 0
    if (isConstant(gradient)) {
        std::fill(values.texels().begin(), values.texels().end(), glm::dvec3(gradient.front()));
        return values;
    }
    std::vector<std::vector<double>> factors;
    std::size_t degreeCount = 0;
    for (const double exponent : options.exponents) {
        factors.push_back(lobeFactors(exponent));
        degreeCount = std::max(degreeCount, factors.back().size());
    }
    const std::vector<glm::dvec3> steps = edgeSteps(gradient);
    LegendreRun edges(edgeHeights(gradient.size())), texels(texelHeights(options.width));
    for (std::size_t degree = 1; degree < degreeCount; ++degree, edges.advance(), texels.advance()) {
        // (2l + 1)/2 times the integral of L P_l; the antiderivative of P_l is (P_(l+1) - P_(l-1)) / (2l + 1).
        glm::dvec3 moment(0);
        for (std::size_t edge = 0; edge < steps.size(); ++edge) moment += (edges.next()[edge] - edges.previous()[edge]) * steps[edge];
        moment *= 0.5;
        for (int row = 0; row < rowCount; ++row) {
            const std::vector<double>& rowFactors = factors[static_cast<std::size_t>(row)];
            if (degree >= rowFactors.size() || rowFactors[degree] == 0) continue;
            const glm::dvec3 amplitude = rowFactors[degree] * moment;
            glm::dvec3* out = values.view().row(row);
            for (int x = 0; x < options.width; ++x) out[x] += texels.current()[static_cast<std::size_t>(x)] * amplitude;
        }
    }
    clampToSource(gradient, values);
    return values;
}

Rsrm makeRsrm(const std::vector<glm::vec3>& gradient, const RsrmOptions& options) {
    Rsrm map;
    map.exponents = options.exponents;
    map.values = convolveGradient(gradient, options);
    glm::dvec3 largest(0);
    for (const glm::dvec3& value : map.values.texels()) {
        for (int channel = 0; channel < 3; ++channel) largest[channel] = std::max(largest[channel], value[channel]);
    }
    map.codes = formats::Image<glm::u8vec3>(map.values.width(), map.values.height(), glm::u8vec3(0));
    for (int channel = 0; channel < 3; ++channel) {
        map.color[channel] = floatNotBelow(largest[channel]);
        if (map.color[channel] == 0) continue;
        for (int row = 0; row < map.values.height(); ++row) quantizeRow(map, row, channel, options.dither);
    }
    return map;
}

formats::Image<glm::vec3> scaledValues(const Rsrm& map) {
    formats::Image<glm::vec3> scaled(map.values.width(), map.values.height(), glm::vec3(0));
    for (std::size_t texel = 0; texel < scaled.texels().size(); ++texel)
        for (int channel = 0; channel < 3; ++channel)
            if (map.color[channel] > 0)
                scaled.texels()[texel][channel] =
                    std::min(1.0f, static_cast<float>(map.values.texels()[texel][channel] / static_cast<double>(map.color[channel])));
    return scaled;
}

float floatRange(const Rsrm& map) {
    constexpr int kLargest = 14, kLeastRange = -120;  // exponents of two
    const float largest = std::max({map.color.x, map.color.y, map.color.z});
    return largest > 0 ? std::ldexp(1.0f, std::max(std::ilogb(largest) - kLargest, kLeastRange)) : 1.0f;
}

formats::Image<glm::vec3> floatValues(const Rsrm& map) {
    const double range = floatRange(map);
    formats::Image<glm::vec3> scaled(map.values.width(), map.values.height(), glm::vec3(0));
    for (std::size_t texel = 0; texel < scaled.texels().size(); ++texel)
        scaled.texels()[texel] = glm::vec3(map.values.texels()[texel] / range);
    return scaled;
}

std::optional<std::size_t> firstZoneOfAnotherHue(const std::vector<glm::vec3>& gradient) {
    constexpr double kTolerance = 1e-4;
    glm::dvec3 largest(0);
    for (const glm::vec3& zone : gradient)
        for (int channel = 0; channel < 3; ++channel) largest[channel] = std::max(largest[channel], static_cast<double>(zone[channel]));
    for (std::size_t zone = 0; zone < gradient.size(); ++zone) {
        double low = 1, high = 0;
        for (int channel = 0; channel < 3; ++channel) {
            if (!(largest[channel] > 0)) continue;
            const double share = static_cast<double>(gradient[zone][channel]) / largest[channel];
            low = std::min(low, share), high = std::max(high, share);
        }
        if (high - low > kTolerance) return zone;
    }
    return std::nullopt;
}

}  // namespace lightcook::fit
