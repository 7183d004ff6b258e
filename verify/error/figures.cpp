#include "verify/figures.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "lighting/radiometry.h"

namespace lightcook::verify {
namespace {

constexpr double kLargest = std::numeric_limits<double>::max();
constexpr float kLargestFloat = std::numeric_limits<float>::max();

/// Returns the largest double for NaN and infinity, so that comparisons with a limit fail instead of being unordered.
double finiteOrLargest(double value) {
    return value <= kLargest ? value : kLargest;
}

/// Returns the quotient, 0 for 0 / 0: a black map that stays black has no error.
double localRelative(double error, double scale) {
    return error == 0 ? 0 : finiteOrLargest(error / scale);
}

}  // namespace

std::size_t ErrorAccumulator::binOf(double local) {
    // The bin is the exponent and the upper 8 bits of the mantissa. The first bin holds all smaller values, the last all larger ones.
    constexpr std::int64_t kFirst = static_cast<std::int64_t>(1023 + kLowestExponent) * kBinsPerOctave;
    const std::int64_t bin = static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(local) >> 44) - kFirst + 1;
    return static_cast<std::size_t>(std::clamp<std::int64_t>(bin, 0, kBinCount - 1));
}

std::int32_t ErrorAccumulator::floatBinOf(float local) {
    // The same bins, from the bits of a float.
    constexpr std::int32_t kFirst = (127 + kLowestExponent) * kBinsPerOctave;
    return std::clamp(static_cast<std::int32_t>(std::bit_cast<std::uint32_t>(local) >> 15) - kFirst + 1, 0, kBinCount - 1);
}

ErrorAccumulator::ErrorAccumulator(double key) : key_(key), histogram_(static_cast<std::size_t>(kBinCount)) {}

void ErrorAccumulator::add(double reference, double result, double weight) {
    const double error = std::abs(result - reference), scale = std::abs(reference) + lighting::kLocalErrorFloor * key_;
    const double local = localRelative(error, scale);
    squaredError_ = finiteOrLargest(squaredError_ + weight * (error * error));
    squaredReference_ += weight * (reference * reference);
    maxSampled_ = std::max(maxSampled_, local);
    ++sampleCount_;
    ++histogram_[binOf(local)];
}

namespace {
constexpr std::size_t kPiece = 192;
}

void ErrorAccumulator::addErrors(std::span<const float> reference, std::span<const float> error) {
    assert(reference.size() == error.size());
    // Padding of the last piece, zero light and error, does not change any sum.
    std::array<float, kPiece> errors, references;
    for (std::size_t start = 0; start < reference.size(); start += kPiece) {
        const std::size_t count = std::min(kPiece, reference.size() - start);
        std::fill(std::copy_n(error.data() + start, count, errors.begin()), errors.end(), 0.0f);
        std::fill(std::copy_n(reference.data() + start, count, references.begin()), references.end(), 0.0f);
        addPiece(references.data(), errors.data(), count);
    }
}

void ErrorAccumulator::addPaddedErrors(std::span<const float> reference, std::span<const float> error, std::size_t count) {
    assert(reference.size() == error.size() && reference.size() >= (count + kLanes - 1) / kLanes * kLanes);
    for (std::size_t start = 0; start < count; start += kPiece)
        addPiece(reference.data() + start, error.data() + start, std::min(kPiece, count - start));
}

void ErrorAccumulator::addDark(std::size_t count) {
    histogram_[static_cast<std::size_t>(floatBinOf(0))] += static_cast<std::int64_t>(count);
    sampleCount_ += static_cast<std::int64_t>(count);
}

void ErrorAccumulator::addPiece(const float* reference, const float* error, std::size_t count) {
    // Each lane has its own sums, which are added up in a fixed order: the bits are the same at any vector width. With 8 lanes, GCC's -O3
    // unrolls the loop first and generates scalar code.
    const std::size_t whole = (count + kLanes - 1) / kLanes * kLanes;
    const auto floor = static_cast<float>(lighting::kLocalErrorFloor * key_);
    std::array<float, kPiece> locals;
    std::array<std::int32_t, kPiece> bins;
    std::array<double, kLanes> squaredError{}, squaredReference{};
    std::array<float, kLanes> largest{};
    for (std::size_t i = 0; i < whole; i += kLanes)
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const float e = std::abs(error[i + lane]), r = std::abs(reference[i + lane]);
            // A sum beyond all floats counts as the largest one: divided by infinity, any error would be 0.
            const float scale = r + floor < kLargestFloat ? r + floor : kLargestFloat;
            const float local = e == 0 ? 0.0f : e / scale;
            locals[i + lane] = local;
            largest[lane] = local > largest[lane] ? local : largest[lane];
            squaredError[lane] += static_cast<double>(e) * static_cast<double>(e);
            squaredReference[lane] += static_cast<double>(r) * static_cast<double>(r);
        }
    for (std::size_t i = 0; i < whole; ++i) bins[i] = floatBinOf(locals[i]);
    for (std::size_t i = 0; i < count; ++i) ++histogram_[static_cast<std::size_t>(bins[i])];
    double pieceError = 0, pieceReference = 0;
    for (std::size_t lane = 0; lane < std::min(kLanes, count); ++lane) {  // those of padding are 0
        pieceError += squaredError[lane];
        pieceReference += squaredReference[lane];
        maxSampled_ = std::max(maxSampled_, static_cast<double>(largest[lane]));
    }
    squaredError_ = finiteOrLargest(squaredError_ + pieceError);
    squaredReference_ += pieceReference;
    // NaN compares as not larger; infinity is not a valid figure.
    if (!(pieceError <= kLargest))
        for (std::size_t i = 0; i < count; ++i) maxSampled_ = std::max(maxSampled_, finiteOrLargest(static_cast<double>(locals[i])));
    maxSampled_ = finiteOrLargest(maxSampled_);
    sampleCount_ += static_cast<std::int64_t>(count);
}

void ErrorAccumulator::addBound(double bound, const ErrorPlace& place) {
    const double finite = finiteOrLargest(bound);
    if (!(finite > maxBound_)) return;
    maxBound_ = finite;
    boundAt_ = place;
}

void ErrorAccumulator::merge(const ErrorAccumulator& other) {
    assert(key_ == other.key_);
    squaredError_ = finiteOrLargest(squaredError_ + other.squaredError_);
    squaredReference_ += other.squaredReference_;
    if (other.maxSampled_ > maxSampled_) {
        maxSampled_ = other.maxSampled_;
        sampledAt_ = other.sampledAt_;
    }
    addBound(other.maxBound_, other.boundAt_);
    sampleCount_ += other.sampleCount_;
    for (std::size_t i = 0; i < histogram_.size(); ++i) histogram_[i] += other.histogram_[i];
}

double ErrorAccumulator::referenceRms() const {
    return sampleCount_ > 0 ? std::sqrt(squaredReference_ / static_cast<double>(sampleCount_)) : 0;
}

void takeLargerMaxima(ErrorFigures& figures, const ErrorFigures& other) {
    if (other.maxSampled > figures.maxSampled) {
        figures.maxSampled = other.maxSampled;
        figures.sampledAt = other.sampledAt;
    }
    if (figures.maxBound && other.maxBound && *other.maxBound > *figures.maxBound) {
        figures.maxBound = other.maxBound;
        figures.boundAt = other.boundAt;
    }
    if (figures.visible && other.visible && other.visible->max > figures.visible->max) {
        figures.visible->max = other.visible->max;
        figures.visible->maxAt = other.visible->maxAt;
    }
}

void takeLarger(ErrorFigures& figures, const ErrorFigures& other) {
    takeLargerMaxima(figures, other);
    if (figures.visible && other.visible) takeLarger(*figures.visible, *other.visible);
}

ErrorFigures ErrorAccumulator::figures() const {
    ErrorFigures figures;
    figures.maxSampled = maxSampled_;
    figures.sampledAt = sampledAt_;
    figures.boundAt = boundAt_;
    figures.maxBound = maxBound_;  // not raised to maxSampled: a sample above its bound is a bug that must be visible
    if (sampleCount_ == 0) return figures;
    // Without a finite reference the errors are undefined.
    if (squaredError_ != 0)
        figures.relRms = squaredReference_ <= kLargest ? finiteOrLargest(std::sqrt(squaredError_ / squaredReference_)) : kLargest;
    // The smallest value that at least 99 % of the samples do not exceed.
    std::int64_t left = sampleCount_ - sampleCount_ / 100;
    std::size_t bin = 0;
    while ((left -= histogram_[bin]) > 0) ++bin;
    double upperEdge = kLargest;
    if (bin + 1 < histogram_.size()) {
        const auto octaves = static_cast<int>(bin / kBinsPerOctave);
        const double part = static_cast<double>(bin % kBinsPerOctave) / kBinsPerOctave;
        upperEdge = std::ldexp(1 + part, kLowestExponent + octaves);
    }
    figures.p99 = std::min(upperEdge, maxSampled_);
    return figures;
}

}  // namespace lightcook::verify
