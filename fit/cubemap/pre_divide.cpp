#include "fit/pre_divide.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "lighting/cube.h"
#include "lighting/quadratic.h"

namespace lightcook::fit {
namespace {

lighting::ShBands windowOf(double lambda) {
    return {1, 1 / (1 + 4 * lambda), 1 / (1 + 36 * lambda)};
}

lighting::ShRgb windowed(const lighting::ShRgb& incident, double lambda) {
    const lighting::ShBands window = windowOf(lambda);
    lighting::ShRgb result;
    for (std::size_t i = 0; i < result.size(); ++i) {
        const double factor = window[static_cast<std::size_t>(lighting::kShBand[i])];
        for (int channel = 0; channel < 3; ++channel) result[i][channel] = static_cast<float>(factor * incident[i][channel]);
    }
    return result;
}

lighting::ShDouble channelOf(const lighting::ShRgb& coefficients, int channel) {
    lighting::ShDouble result;
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = coefficients[i][channel];
    return result;
}

/// Returns true if S >= epsilon * mean in every channel and mip. The coefficients are scaled by the DC, since extrema of tiny numbers lose
/// digits.
bool staysAbove(const lighting::ShRgb& coefficients, const std::vector<lighting::ShBands>& bands, double epsilon) {
    for (int channel = 0; channel < 3; ++channel) {
        lighting::ShDouble scaled = channelOf(coefficients, channel);
        const double dc = scaled[0];
        for (double& coefficient : scaled) coefficient /= dc;
        for (const lighting::ShBands& mipBands : bands) {
            const double mean = lighting::kShConstant * mipBands[0];
            if (lighting::extremaOnSphere(lighting::sphereQuadratic(scaled, mipBands)).minimum < epsilon * mean) return false;
        }
    }
    return true;
}

/// Sets the denominator of black channels to kBlackDenominator.
lighting::ShRgb blackChannelsLifted(const lighting::ShRgb& incident) {
    lighting::ShRgb result = incident;
    for (int channel = 0; channel < 3; ++channel) {
        if (lighting::kShConstant * incident[0][channel] >= kBlackDenominator) continue;
        for (glm::vec3& coefficient : result) coefficient[channel] = 0;
        result[0][channel] = static_cast<float>(kBlackDenominator / lighting::kShConstant);
    }
    return result;
}

/// Returns the smallest lambda that suffices, to a relative 1e-6, by bisection. The upper end always suffices, even if the set of such
/// lambdas has gaps.
double smallestLambda(const lighting::ShRgb& incident, const std::vector<lighting::ShBands>& bands, double epsilon) {
    if (staysAbove(incident, bands, epsilon)) return 0;
    double low = 0x1p-24, high = low;
    while (!staysAbove(windowed(incident, high), bands, epsilon)) {
        low = high;
        high *= 2;
        if (high > 0x1p300) return high;  // nothing is left of any float but the DC
    }
    while (high - low > 1e-6 * high) {
        const double middle = 0.5 * (low + high);
        (staysAbove(windowed(incident, middle), bands, epsilon) ? high : low) = middle;
    }
    return high;
}

}  // namespace

glm::dvec3 PreDivide::denominator(int mip, const glm::dvec3& direction) const {
    const lighting::ShBands& mipBands = bands[static_cast<std::size_t>(mip)];
    const lighting::ShDouble basis = lighting::evaluateBasis(direction);
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < basis.size(); ++i) {
        sum += mipBands[static_cast<std::size_t>(lighting::kShBand[i])] * basis[i] * glm::dvec3(windowedSh[i]);
    }
    return sum;
}

PreDivide makePreDivide(const lighting::ShRgb& incident, const std::vector<lighting::ShBands>& bands, const PreDivideOptions& options) {
    assert(0 < options.epsilon && options.epsilon < 1);
    const lighting::ShRgb lifted = blackChannelsLifted(incident);
    PreDivide result;
    result.epsilon = options.epsilon;
    result.bands = bands;
    result.windowLambda = smallestLambda(lifted, bands, options.epsilon);
    result.window = windowOf(result.windowLambda);
    result.windowedSh = windowed(lifted, result.windowLambda);
    return result;
}

std::int64_t preDivideRows(const PreDivide& preDivide, int mip, int face, int firstRow, formats::ImageView<glm::vec3> rows) {
    constexpr double kLargest = std::numeric_limits<float>::max();
    std::int64_t clamped = 0;
    for (int y = 0; y < rows.height; ++y) {
        for (int x = 0; x < rows.width; ++x) {
            glm::vec3& texel = rows.at(x, y);
            const glm::dvec3 denominator = preDivide.denominator(mip, lighting::cubeTexelDirection(face, x, firstRow + y, rows.width));
            const glm::dvec3 quotient = glm::dvec3(texel) / denominator;
            for (int channel = 0; channel < 3; ++channel) {
                if (quotient[channel] > kLargest) ++clamped;
                texel[channel] = static_cast<float>(std::clamp(quotient[channel], 0.0, kLargest));
            }
        }
    }
    return clamped;
}

}  // namespace lightcook::fit
