#include "verify/visible.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <glm/matrix.hpp>
#include <limits>

#include "verify/error/perceptual_quantizer.h"

namespace lightcook::verify {
namespace {

constexpr float kLargest = std::numeric_limits<float>::max();
constexpr auto kScale = static_cast<float>(lighting::kVisibleScale);

}  // namespace

DisplayTransform::DisplayTransform(const Viewing& viewing, double unit) : black_(static_cast<float>(viewing.display.black)) {
    const glm::dmat3 lms = lighting::lmsFromBt2020() * viewing.bt2020FromWorking * (viewing.display.nitsPerUnit * unit);
    for (int row = 0; row < 3; ++row)
        for (int channel = 0; channel < 3; ++channel)
            lms_[static_cast<std::size_t>(row)][static_cast<std::size_t>(channel)] = static_cast<float>(lms[channel][row]);
}

namespace {

/// Turns codes L', M', S' into I, T and P; NaN where the light is not finite. A function of its own: GCC vectorizes the loop where these
/// pointers are parameters.
void itpFromCodes(const float* __restrict reds, const float* __restrict greens, const float* __restrict blues, std::size_t count,
                  float* __restrict first, float* __restrict second, float* __restrict third) {
    for (std::size_t k = 0; k < count; ++k) {
        const float l = first[k], m = second[k], s = third[k];
        // 0 if all are finite, else NaN. Their sum may be infinite.
        const float valid = reds[k] * 0 + greens[k] * 0 + blues[k] * 0;
        first[k] = kScale / 2 * (l + m) + valid;
        second[k] = kScale / 8192 * (6610 * l - 13613 * m + 7003 * s);
        third[k] = kScale / 4096 * (17933 * l - 17390 * m - 543 * s);
    }
}

}  // namespace

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
            out[k] = black + redWeight * red + greenWeight * green + blueWeight * blue;
        }
        for (std::size_t k = 0; k < count; ++k) out[k] = perceptualQuantizerOf(out[k]);
    }
    itpFromCodes(reds, greens, blues, count, itp, itp + count, itp + 2 * count);
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
    if (other.bound > figures.bound) {
        figures.bound = other.bound;
        figures.boundAt = other.boundAt;
    }
    for (double VisibleFigures::*figure : {&VisibleFigures::rms, &VisibleFigures::p50, &VisibleFigures::p95, &VisibleFigures::p99,
                                           &VisibleFigures::p999, &VisibleFigures::max})
        figures.*figure = std::max(figures.*figure, other.*figure);
}

VisibleAccumulator::VisibleAccumulator() : histogram_(static_cast<std::size_t>(kBinCount)) {}

std::size_t VisibleAccumulator::binOf(float difference) {
    // The bin is the exponent and the upper 8 bits of the mantissa.
    constexpr std::int32_t kFirst = (127 + kLowestExponent) * kBinsPerOctave;
    const std::int32_t bin = (std::bit_cast<std::int32_t>(difference) >> 15) - kFirst + 1;
    return static_cast<std::size_t>(std::clamp(bin, 0, kBinCount - 1));
}

void VisibleAccumulator::add(std::span<const float> differences) {
    double squares = 0;
    float largest = 0;
    for (const float difference : differences) {
        squares += static_cast<double>(difference) * static_cast<double>(difference);
        largest = std::max(largest, difference);
        ++histogram_[binOf(difference)];
    }
    squares_ += squares;
    largest_ = std::max(largest_, static_cast<double>(largest));
    sampleCount_ += static_cast<std::int64_t>(differences.size());
}

void VisibleAccumulator::addExact(std::size_t count) {
    histogram_.front() += static_cast<std::int64_t>(count);
    sampleCount_ += static_cast<std::int64_t>(count);
}

void VisibleAccumulator::addBound(double bound, const VisiblePlace& place) {
    if (std::isnan(bound) || (bound_ && bound <= *bound_)) return;
    bound_ = bound;
    boundAt_ = place;
}

void VisibleAccumulator::merge(const VisibleAccumulator& other) {
    squares_ += other.squares_;
    if (other.largest_ > largest_) {
        largest_ = other.largest_;
        maxAt_ = other.maxAt_;
    }
    if (other.bound_) addBound(*other.bound_, other.boundAt_);
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

std::vector<std::int64_t> VisibleAccumulator::octaves() const {
    constexpr int kOctaves = VisibleFigures::kHighestOctave - VisibleFigures::kLowestOctave;
    std::vector<std::int64_t> counts(kOctaves + 2);
    for (std::size_t bin = 0; bin < histogram_.size(); ++bin) {
        // Bin 0 lies below all octaves, the last one above.
        const int octave = bin == 0 ? kLowestExponent - 1 : kLowestExponent + static_cast<int>((bin - 1) / kBinsPerOctave);
        counts[static_cast<std::size_t>(std::clamp(octave - VisibleFigures::kLowestOctave + 1, 0, kOctaves + 1))] += histogram_[bin];
    }
    return counts;
}

VisibleFigures VisibleAccumulator::figures() const {
    VisibleFigures figures;
    if (sampleCount_ == 0) return figures;
    figures.rms = std::sqrt(squares_ / static_cast<double>(sampleCount_));
    figures.p50 = quantile(0.5);
    figures.p95 = quantile(0.95);
    figures.p99 = quantile(0.99);
    figures.p999 = quantile(0.999);
    figures.histogram = octaves();
    figures.max = largest_;
    figures.maxAt = maxAt_;
    figures.bound = bound_;
    figures.boundAt = boundAt_;
    return figures;
}

double displayKeyOf(std::span<const double> luminances) {
    if (luminances.empty()) return 0;
    const auto count = static_cast<double>(luminances.size());
    double sum = 0, logSum = 0;
    for (const double luminance : luminances) sum += luminance;
    if (!(sum / count >= kBlackMean)) return 0;
    for (const double luminance : luminances) logSum += std::log(std::max(luminance, kDarkestShare * sum / count));
    return std::exp(logSum / count);
}

void VisiblePairs::add(const glm::dvec3& reference, const glm::dvec3& found, const VisiblePlace& place) {
    VisiblePlace& pair = waiting_[count_++];
    pair = place;
    pair.reference = reference;
    pair.found = found;
    if (count_ == kLanes) flush();
}

void VisiblePairs::flush() {
    if (count_ == 0) return;
    Planes reference{}, found{}, shownReference{}, shownFound{};
    for (std::size_t i = 0; i < count_; ++i)
        for (std::size_t channel = 0; channel < 3; ++channel) {
            reference[channel * kLanes + i] = static_cast<float>(waiting_[i].reference[static_cast<int>(channel)]);
            found[channel * kLanes + i] = static_cast<float>(waiting_[i].found[static_cast<int>(channel)]);
        }
    transform_.apply(reference.data(), kLanes, shownReference.data());
    transform_.apply(found.data(), kLanes, shownFound.data());
    std::array<float, kLanes> differences{};
    visibleDifferences(shownReference.data(), shownFound.data(), kLanes, differences.data());
    const auto measured = std::span<const float>(differences).first(count_);
    count_ = 0;
    const double before = errors_.largest();
    errors_.add(measured);
    if (!(errors_.largest() > before)) return;
    const auto largest = std::ranges::max_element(measured);
    VisiblePlace place = waiting_[static_cast<std::size_t>(largest - measured.begin())];
    place.difference = static_cast<double>(*largest);
    errors_.setMaxAt(place);
}

void VisiblePairs::addBound(double bound, VisiblePlace place) {
    place.difference = bound;
    errors_.addBound(bound, place);
}

void VisiblePairs::merge(const VisiblePairs& other) {
    flush();
    VisiblePairs rest = other;
    rest.flush();
    errors_.merge(rest.errors_);
}

std::optional<VisibleFigures> VisiblePairs::figures() const {
    VisiblePairs whole = *this;
    whole.flush();
    if (whole.errors_.sampleCount() == 0) return std::nullopt;
    return whole.errors_.figures();
}

}  // namespace lightcook::verify
