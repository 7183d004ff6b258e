#include "verify/error/visible_any_light.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "verify/error/perceptual_quantizer.h"

namespace lightcook::verify {

namespace {

float stepOfCode(float nits, float step) {
    return perceptualQuantizerOf(nits + step) - perceptualQuantizerOf(nits);
}
/// Rounding of the difference of two codes of the curve in floats.
constexpr double kStepRounding = 1.2e-6;

}  // namespace

/// Light of two channels above a grey light, as L, M and S relative to it, from dark to bright, and their codes.
struct AnyLightBound::Places {
    static constexpr std::size_t kDirections = 32, kBrightnesses = 40;
    /// Brightnesses: none, and powers of the root of 2 from 1/16 of the grey light on.
    static constexpr int kDarkest = -8;
    using Row = std::array<float, kDirections>;
    std::array<std::array<Row, kBrightnesses>, 3> nits, codes;

    Places(const VisibleMetric& metric, double black) {
        // Each pair of channels in eleven shares, one of which two pairs have in common.
        constexpr int kShares = 11;
        for (std::size_t i = 0; i < kDirections; ++i) {
            const auto pair = static_cast<int>(i) / kShares, share = static_cast<int>(i) % kShares;
            const double part = share == 0 ? 0 : share == kShares - 1 ? 1 : 1 / (1 + std::exp2(5 - share));
            const auto unit = [&](int channel, std::size_t k) {
                const double sum = metric.lms(0)[channel] + metric.lms(1)[channel] + metric.lms(2)[channel];
                return metric.lms(static_cast<int>(k))[channel] / sum;
            };
            for (std::size_t k = 0; k < 3; ++k)
                for (std::size_t b = 0; b < kBrightnesses; ++b) {
                    const double brightness = b == 0 ? 0 : black * std::exp2(0.5 * (kDarkest + static_cast<int>(b) - 1));
                    const double z = brightness * ((1 - part) * unit(pair, k) + part * unit((pair + 1) % 3, k));
                    nits[k][b][i] = static_cast<float>(black + z);
                    codes[k][b][i] = perceptualQuantizerOf(nits[k][b][i]);
                }
        }
    }
};

AnyLightBound::AnyLightBound(const VisibleMetric& metric) : metric_(metric) {
    if (!metric.isPositive()) return;
    for (int c = 0; c < 3; ++c)
        shares_[static_cast<std::size_t>(c)] =
            static_cast<float>((metric.lms(0)[c] + metric.lms(1)[c] + metric.lms(2)[c]) / metric.black());
    changes_.resize(kLevels);
    for (std::size_t level = 0; level < kLevels; ++level) {
        const double black = metric.black() * std::exp2(static_cast<double>(level));
        const Places places(metric, black);
        for (std::size_t c = 0; c < 3; ++c) addChanges(black, places, c, changes_[level][c]);
    }
}

void AnyLightBound::addChanges(double black, const Places& places, std::size_t channel, std::vector<Changes>& out) const {
    const auto c = static_cast<int>(channel);
    const double sum = metric_.lms(0)[c] + metric_.lms(1)[c] + metric_.lms(2)[c];
    std::array<std::array<float, 3>, 2> weights;
    for (std::size_t row = 0; row < 2; ++row)
        for (int k = 0; k < 3; ++k)
            weights[row][static_cast<std::size_t>(k)] = static_cast<float>(VisibleMetric::itp(static_cast<int>(row) + 1)[k]);
    for (std::uint32_t bits = kFinest; bits <= kCoarsest; ++bits) {
        const double relative = static_cast<double>(std::bit_cast<float>(bits << kMantissa)), step = relative * black;
        // All codes change less beyond, where light is brighter than the step.
        const auto last =
            std::min(Places::kBrightnesses, static_cast<std::size_t>(2 * std::log2(16 * std::max(relative, 1.0)) + 1 - Places::kDarkest));
        std::array<Places::Row, 2> low{}, high{};
        for (std::size_t b = 0; b < last; ++b) {
            std::array<Places::Row, 3> rises;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto nits = static_cast<float>(step * metric_.lms(static_cast<int>(k))[c] / sum);
                for (std::size_t i = 0; i < Places::kDirections; ++i)
                    rises[k][i] = perceptualQuantizerOf(places.nits[k][b][i] + nits) - places.codes[k][b][i];
            }
            for (std::size_t row = 0; row < 2; ++row)
                for (std::size_t i = 0; i < Places::kDirections; ++i) {
                    const float change = weights[row][0] * rises[0][i] + weights[row][1] * rises[1][i] + weights[row][2] * rises[2][i];
                    low[row][i] = low[row][i] < change ? low[row][i] : change;
                    high[row][i] = high[row][i] > change ? high[row][i] : change;
                }
        }
        Changes& changes = out.emplace_back();
        constexpr double kMargin = 1.03;
        for (std::size_t row = 0; row < 2; ++row) {
            double rounding = 0;
            for (const float weight : weights[row]) rounding += kStepRounding * static_cast<double>(std::abs(weight));
            changes[row] = {kMargin * static_cast<double>(std::ranges::min(low[row])) - rounding,
                            kMargin * static_cast<double>(std::ranges::max(high[row])) + rounding};
        }
    }
}

double AnyLightBound::bound(double low, const Intervals& error) const {
    const double most = metric_.mostVisible();
    if (changes_.empty()) return most;
    const double grey = metric_.black() + (metric_.lms(0).x + metric_.lms(0).y + metric_.lms(0).z) * std::max(low, 0.0);
    std::size_t level = 0;
    for (double next = 2 * metric_.black(); level + 1 < kLevels && next <= grey; next *= 2) ++level;
    const float scale = std::ldexp(1.0f, -static_cast<int>(level));
    std::array<double, 2> up{}, down{};
    Changes sum{};
    for (std::size_t c = 0; c < 3; ++c) {
        for (const bool isUp : {true, false}) {
            const double step = isUp ? error[c].high : -error[c].low;
            if (!(step > 0)) {
                if (step <= 0) continue;
                return most;  // NaN
            }
            for (std::size_t k = 0; k < 2; ++k) (isUp ? up : down)[k] += metric_.lms(static_cast<int>(k))[static_cast<int>(c)] * step;
        }
        const auto at = [&](double step) -> const Changes* {
            const float share = scale * shares_[c] * static_cast<float>(step);
            if (!(share < 0x1p14f)) return nullptr;
            const std::uint32_t place = std::max(std::bit_cast<std::uint32_t>(std::max(share, 0.0f)) >> kMantissa, kFinest - 1) + 1;
            return &changes_[level][c][place - kFinest];
        };
        const Changes* const rising = error[c].high > 0 ? at(error[c].high) : nullptr;
        const Changes* const falling = error[c].low < 0 ? at(-error[c].low) : nullptr;
        if ((error[c].high > 0 && rising == nullptr) || (error[c].low < 0 && falling == nullptr)) return most;
        for (std::size_t row = 0; row < 2; ++row) {
            Interval change;
            if (rising != nullptr) change = (*rising)[row];
            if (falling != nullptr) change = hullOf(change, -1.0 * (*falling)[row]);
            sum[row] = sum[row] + change;
        }
    }
    const auto black = static_cast<float>(grey);
    const auto lightness = [&](const std::array<double, 2>& step) {
        return static_cast<double>(stepOfCode(black, static_cast<float>(step[0]))) +
               static_cast<double>(stepOfCode(black, static_cast<float>(step[1])));
    };
    const double i = VisibleMetric::itp(0)[0] * (std::max(lightness(up), lightness(down)) + 2 * kStepRounding);
    const double colour = std::min(std::hypot(sum[0].largest(), sum[1].largest()), metric_.mostColour());
    return std::min(VisibleMetric::roundedUp(std::hypot(i, colour)), most);
}

}  // namespace lightcook::verify
