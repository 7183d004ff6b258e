#include "verify/visible.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <glm/matrix.hpp>
#include <limits>

namespace lightcook::verify {
namespace {

constexpr float kLargest = std::numeric_limits<float>::max();
/// Scale of Delta E ITP (ITU-R BT.2124-0).
constexpr float kScale = 720;

/// Returns log2 of a normal, positive number, within 6e-7: the mantissa m in [sqrt(1/2), sqrt 2) by the series of artanh((m - 1)/(m + 1)).
inline float log2Of(float x) {
    constexpr std::int32_t kRootHalf = 0x3f3504f3;
    const auto bits = std::bit_cast<std::int32_t>(x);
    const std::int32_t exponent = (bits - kRootHalf) >> 23;
    const auto mantissa = std::bit_cast<float>(bits - exponent * (1 << 23));
    const float s = (mantissa - 1) / (mantissa + 1), square = s * s;
    return static_cast<float>(exponent) + s * (2.885390082f + square * (0.961796694f + square * (0.577078016f + square * 0.412198583f)));
}

/// Returns lighting::perceptualQuantizer of a luminance, which is clamped to [2^-8, 10000] cd/m^2. The curve is smooth over the logarithm
/// of the luminance: a polynomial of degree 12, interpolated at the Chebyshev points of this interval, is within 2e-7, and its slope within
/// 0.01 %.
inline float perceptualQuantizerOf(float nits) {
    constexpr float kLowest = 0x1p-8f, kHighest = 10000, kMiddle = 2.64385619f, kPerHalf = 1 / 10.6438562f;
    constexpr std::array kCoefficients = {0.263920428f,   0.541255862f,     0.32387875f,     -0.0581648655f,  -0.104593237f,
                                          0.0148444869f,  0.0291957965f,    -0.00634778856f, -0.00689679671f, 0.00216951081f,
                                          0.00124764763f, -0.000379635896f, -0.00013018319f};
    const float raised = nits > kLowest ? nits : kLowest, clamped = raised < kHighest ? raised : kHighest;
    const float u = (log2Of(clamped) - kMiddle) * kPerHalf;
    float sum = kCoefficients.back();
    for (std::size_t i = kCoefficients.size() - 1; i-- > 0;) sum = sum * u + kCoefficients[i];
    return sum;
}

}  // namespace

DisplayTransform::DisplayTransform(const Viewing& viewing, double unit) : black_(static_cast<float>(viewing.display.black)) {
    const glm::dmat3 lms = lighting::lmsFromBt2020() * viewing.bt2020FromWorking * (viewing.display.nitsPerUnit * unit);
    for (int row = 0; row < 3; ++row)
        for (int channel = 0; channel < 3; ++channel)
            lms_[static_cast<std::size_t>(row)][static_cast<std::size_t>(channel)] = static_cast<float>(lms[channel][row]);
}

void DisplayTransform::apply(const float* rgb, std::size_t count, float* itp) const {
    assert(count % kLanes == 0);
    // Flat loops over pointers that do not overlap run in vector lanes. One pass for each of L, M and S needs few registers.
    const float* __restrict reds = rgb, * __restrict greens = rgb + count, * __restrict blues = rgb + 2 * count;
    for (std::size_t row = 0; row < 3; ++row) {
        float* __restrict out = itp + row * count;
        const auto [redWeight, greenWeight, blueWeight] = lms_[row];
        const float black = black_;
        for (std::size_t k = 0; k < count; ++k) {
            const float red = reds[k] > 0 ? reds[k] : 0, green = greens[k] > 0 ? greens[k] : 0, blue = blues[k] > 0 ? blues[k] : 0;
            // Rows of LMS sum to 1 for white, so black adds the same to each.
            out[k] = perceptualQuantizerOf(black + redWeight * red + greenWeight * green + blueWeight * blue);
        }
    }
    float* __restrict first = itp, * __restrict second = itp + count, * __restrict third = itp + 2 * count;
    for (std::size_t k = 0; k < count; ++k) {
        const float l = first[k], m = second[k], s = third[k];
        // 0 if all are finite, else NaN.
        const float valid = (reds[k] + greens[k] + blues[k]) * 0;
        first[k] = kScale / 2 * (l + m) + valid;
        second[k] = kScale / 8192 * (6610 * l - 13613 * m + 7003 * s);
        third[k] = kScale / 4096 * (17933 * l - 17390 * m - 543 * s);
    }
}

void visibleDifferences(const float* reference, const float* found, std::size_t count, float* differences) {
    assert(count % DisplayTransform::kLanes == 0);
    const float* __restrict a = reference, * __restrict b = found;
    float* __restrict out = differences;
    for (std::size_t k = 0; k < count; ++k) {
        const float di = b[k] - a[k], dt = b[count + k] - a[count + k], dp = b[2 * count + k] - a[2 * count + k];
        const float difference = std::sqrt(di * di + dt * dt + dp * dp);
        out[k] = difference <= kLargest ? difference : kLargest;
    }
}

void takeLarger(VisibleFigures& figures, const VisibleFigures& other) {
    if (other.max > figures.max) figures.maxAt = other.maxAt;
    for (double VisibleFigures::*figure : {&VisibleFigures::rms, &VisibleFigures::p50, &VisibleFigures::p95, &VisibleFigures::p99,
                                           &VisibleFigures::p999, &VisibleFigures::max})
        figures.*figure = std::max(figures.*figure, other.*figure);
}

VisibleAccumulator::VisibleAccumulator() : histogram_(static_cast<std::size_t>(kBinCount)) {}

void VisibleAccumulator::add(std::span<const float> differences) {
    // The bin is the exponent and the upper 8 bits of the mantissa.
    constexpr std::int32_t kFirst = (127 + kLowestExponent) * kBinsPerOctave;
    double squares = 0;
    float largest = 0;
    for (const float difference : differences) {
        squares += static_cast<double>(difference) * static_cast<double>(difference);
        largest = std::max(largest, difference);
        const std::int32_t bin = (std::bit_cast<std::int32_t>(difference) >> 15) - kFirst + 1;
        ++histogram_[static_cast<std::size_t>(std::clamp(bin, 0, kBinCount - 1))];
    }
    squares_ += squares;
    largest_ = std::max(largest_, static_cast<double>(largest));
    sampleCount_ += static_cast<std::int64_t>(differences.size());
}

void VisibleAccumulator::merge(const VisibleAccumulator& other) {
    squares_ += other.squares_;
    if (other.largest_ > largest_) {
        largest_ = other.largest_;
        maxAt_ = other.maxAt_;
    }
    sampleCount_ += other.sampleCount_;
    for (std::size_t i = 0; i < histogram_.size(); ++i) histogram_[i] += other.histogram_[i];
}

double VisibleAccumulator::quantile(double share) const {
    const double wanted = share * static_cast<double>(sampleCount_);
    double before = 0;
    for (std::size_t bin = 0; bin < histogram_.size(); ++bin) {
        const auto count = static_cast<double>(histogram_[bin]);
        if (before + count < wanted || count == 0) {
            before += count;
            continue;
        }
        const auto edge = [](std::size_t at) {  // the lower edge of a bin; the first one begins at 0
            if (at == 0) return 0.0;
            const std::size_t octave = (at - 1) / kBinsPerOctave, part = (at - 1) % kBinsPerOctave;
            return std::ldexp(1 + static_cast<double>(part) / kBinsPerOctave, kLowestExponent + static_cast<int>(octave));
        };
        const double low = edge(bin), high = bin + 1 < histogram_.size() ? edge(bin + 1) : largest_;
        return std::min(low + (high - low) * (wanted - before) / count, largest_);
    }
    return largest_;
}

VisibleFigures VisibleAccumulator::figures() const {
    VisibleFigures figures;
    if (sampleCount_ == 0) return figures;
    figures.rms = std::sqrt(squares_ / static_cast<double>(sampleCount_));
    figures.p50 = quantile(0.5);
    figures.p95 = quantile(0.95);
    figures.p99 = quantile(0.99);
    figures.p999 = quantile(0.999);
    figures.max = largest_;
    figures.maxAt = maxAt_;
    return figures;
}

}  // namespace lightcook::verify
