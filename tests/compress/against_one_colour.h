// The error of an encoded block beside that of one colour for all its texels, which no block may exceed.
#pragma once

#include "tests/compress/hostile_blocks.h"

namespace lightcook::compress::test {

/// Weights of texels: of four sizes, or over eight decades with none on one side of each block, as beside a chart or dark light.
enum class Weights { Few, Wide };

/// Returns the largest error that a block may have beside one colour. Where weights span eight decades, sums of floats and the integers of
/// the fast kernels lose the small ones: such a block may err by a few codes more, but never lose its light.
inline double mostOf(double oneColour, Weights weights) {
    constexpr double kCodes = 20.0 / 255;
    return weights == Weights::Few ? 1.02 * oneColour : 4 * oneColour + kCodes * kCodes * std::min(1.0, 1e6 * oneColour);
}

/// Returns the error of a block, and that of one colour for the whole block, the weighted mean, rounded as the format does; both are
/// divided by the weights.
struct AgainstOneColour {
    double error = 0, oneColour = 0;
};
inline AgainstOneColour againstOneColour(formats::PixelFormat format, const HostileImage& image, const TexelImage& decoded, int left,
                                         int top) {
    AgainstOneColour found;
    const bool isBc1 = format == formats::PixelFormat::Bc1 || format == formats::PixelFormat::Bc3;
    for (int c = 0; c < formats::info(format).channelCount; ++c) {
        // Channels that are coded apart know nothing of weights of channels.
        const bool isApart =
            format == formats::PixelFormat::Bc4 || format == formats::PixelFormat::Bc5 || (format == formats::PixelFormat::Bc3 && c == 3);
        const auto channelWeight = isApart ? 1.0 : static_cast<double>(image.options.channelWeights[static_cast<std::size_t>(c)]);
        const double step = isBc1 && c < 3 ? 1.0 / 62 : 1.0 / 255;
        double sum = 0, weights = 0, squares = 0, misses = 0;
        for (int t = 0; t < kTexelCount; ++t) {
            const int x = left + t % 4, y = top + t / 4;
            const auto weight = static_cast<double>(image.significance.at(x, y));
            const double value = std::clamp(static_cast<double>(image.texels.at(x, y)[c]), 0.0, 1.0);
            sum += weight * value;
            squares += weight * value * value;
            weights += weight;
            misses += weight * std::pow(static_cast<double>(decoded.at(x, y)[c]) - value, 2);
        }
        if (!(weights > 0)) return {};
        found.error += channelWeight * misses / weights;
        found.oneColour += channelWeight * (std::max(0.0, squares / weights - std::pow(sum / weights, 2)) + step * step);
    }
    return found;
}

/// Returns the same for BC6H: the one colour is the weighted mean in the metric, rounded to halves (mode 14 holds any); errors are in the
/// metric.
inline AgainstOneColour againstOneLight(formats::PixelFormat format, const HostileImage& image, const TexelImage& decoded, int left,
                                        int top) {
    AgainstOneColour found;
    const auto scale = static_cast<double>(image.options.hdrScale);
    const bool isLog = image.options.hdrMetric == HdrMetric::Log;
    const auto metric = [&](double x) { return isLog ? std::copysign(std::log2(1 + std::abs(x) / scale), x) : x; };
    const double least = formats::info(format).isSigned ? -65504 : 0;
    for (int c = 0; c < 3; ++c) {
        double weights = 0, sum = 0, squares = 0, misses = 0;
        for (int t = 0; t < kTexelCount; ++t) {
            const int x = left + t % 4, y = top + t / 4;
            const double value = std::clamp(static_cast<double>(image.texels.at(x, y)[c]), least, 65504.0), m = metric(value);
            double weight = static_cast<double>(image.significance.at(x, y));
            if (image.options.hdrMetric == HdrMetric::Relative) weight /= std::pow(std::abs(value) + scale, 2);
            weights += weight;
            sum += weight * m;
            squares += weight * m * m;
            misses += weight * std::pow(metric(static_cast<double>(decoded.at(x, y)[c])) - m, 2);
        }
        if (!(weights > 0)) return {};
        const auto channelWeight = static_cast<double>(image.options.channelWeights[static_cast<std::size_t>(c)]);
        // A half is off by 2^-12 of itself, or by 2^-25.
        const double mean = sum / weights, half = isLog ? (std::exp2(std::abs(mean)) - 1) * scale : std::abs(mean);
        // The logarithms of the kernels have an absolute error of 1e-6 near 0.
        const double away = metric(half + std::max(half * 0x1p-11, 0x1p-24)) - metric(half) + (isLog ? 1e-6 : 0.0);
        found.error += channelWeight * misses;
        found.oneColour += channelWeight * (std::max(0.0, squares - sum * mean) + weights * away * away);
    }
    return found;
}

}  // namespace lightcook::compress::test
