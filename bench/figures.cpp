#include "bench/figures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lighting/radiometry.h"
#include "verify/texture_unit.h"

namespace lightcook::bench {
namespace {

constexpr double kExactDb = 120;  ///< upper bound of the decibels

double decibels(double rms) {
    return rms > 0 ? std::min(kExactDb, -20 * std::log10(rms)) : kExactDb;
}

/// Returns sign(x) log2(1 + |x|).
double logOf(double x) {
    return std::copysign(std::log2(1 + std::abs(x)), x);
}

/// Returns the number of channels that count.
int countedChannels(formats::PixelFormat format) {
    return formats::info(format).isFloat ? 3 : formats::info(format).channelCount;
}

/// Calls each(reference, result, channel) for every value that counts. A result that is NaN becomes infinite, so that its error is too.
template <class Each>
void forEachValue(formats::PixelFormat format, formats::ImageView<const glm::vec4> reference, formats::ImageView<const float> significance,
                  formats::ImageView<const glm::vec4> decoded, const Each& each) {
    const int channels = countedChannels(format);
    for (int y = 0; y < reference.height; ++y)
        for (int x = 0; x < reference.width; ++x) {
            if (significance.row(y)[x] == 0) continue;
            for (int c = 0; c < channels; ++c) {
                const auto result = static_cast<double>(decoded.row(y)[x][c]);
                each(static_cast<double>(reference.row(y)[x][c]), std::isnan(result) ? std::numeric_limits<double>::infinity() : result, c);
            }
        }
}

}  // namespace

Figures measure(formats::PixelFormat format, formats::ImageView<const glm::vec4> reference, formats::ImageView<const float> significance,
                formats::ImageView<const glm::vec4> decoded, const std::array<float, 4>& channelWeights) {
    Figures figures;
    double squared = 0, squaredWeighted = 0, squaredReference = 0, squaredLog = 0, logSum = 0, weights = 0;
    std::int64_t values = 0, valuesNotZero = 0;
    forEachValue(format, reference, significance, decoded, [&](double wanted, double found, int channel) {
        const auto weight = static_cast<double>(channelWeights[static_cast<std::size_t>(channel)]);
        squared += (found - wanted) * (found - wanted);
        squaredWeighted += weight * (found - wanted) * (found - wanted);
        squaredReference += wanted * wanted;
        squaredLog += weight * std::pow(logOf(found) - logOf(wanted), 2);
        weights += weight;
        ++values;
        if (wanted == 0) return;
        logSum += std::log(std::abs(wanted));
        ++valuesNotZero;
    });
    if (values == 0) return figures;
    const double floor = valuesNotZero > 0 ? lighting::kLocalErrorFloor * std::exp(logSum / static_cast<double>(valuesNotZero)) : 1;
    std::vector<double> relative;
    relative.reserve(static_cast<std::size_t>(values));
    forEachValue(format, reference, significance, decoded,
                 [&](double wanted, double found, int) { relative.push_back(std::abs(found - wanted) / (std::abs(wanted) + floor)); });
    const auto percentile = relative.begin() + static_cast<std::ptrdiff_t>(relative.size() * 99 / 100);
    std::nth_element(relative.begin(), percentile, relative.end());
    figures.texels = values / countedChannels(format);
    figures.logRmse = std::sqrt(squaredLog / weights);
    figures.psnrDb = decibels(formats::info(format).isFloat ? figures.logRmse : std::sqrt(squaredWeighted / weights));
    figures.relRmse = squaredReference > 0 ? std::sqrt(squared / squaredReference) : 0;
    figures.p99Relative = *percentile;
    figures.maxRelative = *std::max_element(percentile, relative.end());
    return figures;
}

formats::Image<glm::vec4> decodedByVerifier(formats::PixelFormat format, std::span<const std::byte> bytes, int width, int height) {
    formats::Image<glm::vec4> decoded(width, height);
    verify::decodeRows(format, bytes, decoded.view());
    return decoded;
}

}  // namespace lightcook::bench
