#include "verify/light_map/scanned_kernels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lightcook::verify {

lighting::AreaSpecularKernel specularKernelAt(double NoV, double m, lighting::NormalDistribution lobe, int sampleCount) {
    return lighting::integrateAreaSpecular(NoV, m, lobe, lighting::CookTorranceNormalization::Energy, sampleCount);
}

lighting::ShDouble kernelAtF0(const lighting::AreaSpecularKernel& kernel, double f0) {
    lighting::ShDouble out{};
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = f0 * kernel.c[i] + (1 - f0) * kernel.d[i];
    return out;
}

ScannedKernels::ScannedKernels(const LightMapShading& shading) {
    constexpr int kScanSamples = 64;
    const auto [lowM, highM] = std::ranges::minmax(shading.m);
    const int steps = highM > lowM ? std::clamp(static_cast<int>(std::ceil(kStepsPerOctave * std::log2(highM / lowM))), 2, 24) : 0;
    for (int r = 0; r <= steps; ++r) {
        roughness_.push_back(steps == 0 ? lowM : lowM * std::pow(highM / lowM, static_cast<double>(r) / steps));
        // Even steps of the angle: kernels change fastest towards grazing.
        for (int v = 0; v < kViews; ++v)
            kernels_.push_back(specularKernelAt(std::max(1e-3, std::cos(viewAngle(v))), roughness_.back(), shading.lobe, kScanSamples));
    }
}

double ScannedKernels::viewAngle(double view) {
    return 0.5 * std::numbers::pi * view / (kViews - 1);
}

lighting::ShBands ScannedKernels::between(int r, int v, double f0) const {
    lighting::ShBands largest{};
    for (int row = std::max(r - 1, 0); row <= std::min(r + 1, roughnessCount() - 1); ++row)
        for (int column = std::max(v - 1, 0); column <= std::min(v + 1, kViews - 1); ++column) {
            const lighting::ShBands second = secondDifferenceAt(row, column, f0);
            for (std::size_t l = 0; l < second.size(); ++l) largest[l] = std::max(largest[l], kBetween * second[l]);
        }
    return largest;
}

lighting::ShBands ScannedKernels::secondDifferenceAt(int r, int v, double f0) const {
    const lighting::ShDouble middle = kernelAtF0(at(r, v), f0);
    lighting::ShBands sum{};
    const auto add = [&](const lighting::AreaSpecularKernel& before, const lighting::AreaSpecularKernel& after) {
        const lighting::ShDouble low = kernelAtF0(before, f0), high = kernelAtF0(after, f0);
        lighting::ShDouble second;
        for (std::size_t i = 0; i < second.size(); ++i) second[i] = low[i] - 2 * middle[i] + high[i];
        const lighting::ShBands lengths = lighting::bandLengths(second);
        for (std::size_t l = 0; l < sum.size(); ++l) sum[l] += lengths[l];
    };
    if (r > 0 && r + 1 < roughnessCount()) add(at(r - 1, v), at(r + 1, v));
    if (v > 0 && v + 1 < kViews) add(at(r, v - 1), at(r, v + 1));
    return sum;
}

}  // namespace lightcook::verify
