#include "compress/light_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "compress/light_map/basis/model.h"
#include "compress/light_map/rows.h"
#include "compress/light_map/zonal.h"
#include "lighting/radiometry.h"

namespace lightcook::compress {

namespace {

using formats::LightMapFamily;
using rows::halfRange;

/// Ratios beyond 1.25 times the bound of non-negative light are noise of texels that are almost black.
constexpr float kRatioAllowance = 1.25f;
constexpr double kLogUnits = 1 << 24;
constexpr std::array<float, 3> kRatioBound = {1.0f, 1.7320508f, 2.2360680f};  ///< sqrt(2l + 1)

float largestAbsolute(const glm::vec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// Half of what rgb1 can add to uvw. Halo 3 has 1; what BC1 colours leave is far less: docs/experiments.md has the curve.
constexpr float kLuvwSpan = 0.125f;
/// Where light of the key would be fewer codes than this in 8 bits of L, both alphas hold its square root.
constexpr double kLuvwFewCodes = 4;

std::vector<float> listOf(const glm::vec3& v) {
    return {v.x, v.y, v.z};
}

/// Plans the luvw family: a range and a span for each layer. The last layer of an isZonal layout holds the intensity of band 2.
void planLuvw(LightMapPlan& plan, const LightMapMeasure& measure) {
    // Neutral a1 is 4/5, so that the second texture can lift what the first one rounded down; 204/255 is exact in 8 bits. The centre of
    // rgb1 is the code nearest to 1/2 that 5 and 6 bits hold exactly: a texel without residual costs nothing.
    constexpr float neutral = 0.8f;
    const bool isBc = plan.target == formats::Target::Bc;
    plan.constants["neutral"] = isBc ? std::vector<float>{16.0f / 31, 32.0f / 63, 16.0f / 31, neutral}
                                     : std::vector<float>{128.0f / 255, 128.0f / 255, 128.0f / 255, neutral};
    const double dcOfKey = measure.key() / 0.28209479;
    plan.constants["root"] = {255 * dcOfKey < kLuvwFewCodes * static_cast<double>(measure.maximumAbsolute(0)) ? 1.0f : 0.0f};
    const auto add = [&](float largest) {
        plan.constants["range"].push_back(std::min(largest, neutral * std::numeric_limits<float>::max()) / neutral);
        plan.constants["span"].push_back(kLuvwSpan);
    };
    const bool isZonal = formats::info(plan.layout).isZonal;
    const int coefficientCount = plan.textures[0].layerCount - (isZonal ? 1 : 0);
    for (int i = 0; i < coefficientCount; ++i) add(measure.maximumAbsolute(i));
    if (!isZonal) return;
    add(measure.maximumIntensity());
    plan.constants["luminance"] = listOf(measure.luminanceWeights());
}

/// Plans the families ratio and zh3: a scale and a bias for each layer of texture "ratio". The last layer of an isZonal layout holds the
/// zonal coefficient of band 2.
void planRatio(LightMapPlan& plan, const LightMapMeasure& measure) {
    plan.constants["range"] = {halfRange(measure.maximumAbsolute(0))};
    const auto add = [&](float minimum, float maximum) {
        plan.constants["scale"].push_back(maximum - minimum);
        plan.constants["bias"].push_back(minimum);
    };
    const bool isZonal = formats::info(plan.layout).isZonal;
    const int ratioCount = plan.textures[1].layerCount - (isZonal ? 1 : 0);
    for (int i = 1; i <= ratioCount; ++i) add(measure.minimumRatio(i), measure.maximumRatio(i));
    if (!isZonal) return;
    add(measure.minimumZonal(), measure.maximumZonal());
    plan.constants["luminance"] = listOf(measure.luminanceWeights());
}

}  // namespace

namespace rows {

LightMapPlan emptyPlan(formats::LightMapLayout layout, formats::Target target, int width, int height, const LightMapMeasure& measure) {
    LightMapPlan plan;
    plan.layout = layout;
    plan.target = target;
    plan.width = width;
    plan.height = height;
    plan.key = measure.key();
    for (const formats::LightMapTextureInfo& texture : formats::info(layout).textures)
        plan.textures.push_back({std::string(texture.name), formats::formatFor(texture.role, formats::info(target)), texture.layerCount});
    return plan;
}

float halfRange(float largest) {
    if (!(largest > 0)) return 1;
    int exponent = 0;
    const float mantissa = std::frexp(largest, &exponent);  // largest = mantissa 2^exponent, mantissa in [0.5, 1)
    if (mantissa == 0.5f) --exponent;
    return std::ldexp(1.0f, exponent - 14);
}

}  // namespace rows

LightMapMeasure::LightMapMeasure(const glm::vec3& luminanceWeights) : luminanceWeights_(luminanceWeights) {}

void LightMapMeasure::add(const formats::LightMapStrip& band, int firstRow, int rowCount) {
    assert(firstRow >= band.firstRow && firstRow + rowCount <= band.firstRow + band.sh.height());
    for (int y = firstRow - band.firstRow; y < firstRow - band.firstRow + rowCount; ++y)
        for (int x = 0; x < band.sh.width(); ++x)
            if (band.covered.at(x, y) != 0) addTexel(band.sh.at(x, y), band.normal.at(x, y));
}

void LightMapMeasure::addTexel(const lighting::ShRgb& sh, const glm::vec3& normal) {
    ++coveredTexels_;
    const glm::vec3 exit = lighting::evaluate(lighting::convolve(sh, lighting::kExitRadianceBands), normal);
    const double logLuminance = std::log(std::max(static_cast<double>(glm::dot(exit, luminanceWeights_)), 1e-12));
    logLuminanceSum_ += std::llround(logLuminance * kLogUnits);
    maximumExit_ = std::max({maximumExit_, exit.x, exit.y, exit.z});
    for (std::size_t i = 0; i < sh.size(); ++i) maximumAbsolute_[i] = std::max(maximumAbsolute_[i], largestAbsolute(sh[i]));
    for (int channel = 0; channel < 3; ++channel) {
        const float dc = sh[0][channel];
        std::array<float, 3> squared{};
        for (std::size_t i = 1; i < sh.size(); ++i) {
            const auto band = static_cast<std::size_t>(lighting::kShBand[i]);
            squared[band] += sh[i][channel] * sh[i][channel];
            if (dc > 0) {
                const float bound = kRatioAllowance * kRatioBound[band];
                const float ratio = std::clamp(sh[i][channel] / dc, -bound, bound);
                minimumRatio_[i] = std::min(minimumRatio_[i], ratio);
                maximumRatio_[i] = std::max(maximumRatio_[i], ratio);
            }
        }
        const float limit = 1.001f * std::max(dc, 0.0f);
        if (std::sqrt(squared[1]) > limit * kRatioBound[1] || std::sqrt(squared[2]) > limit * kRatioBound[2]) ++beyondPositiveBounds_;
    }
    addZonal(sh);
}

void LightMapMeasure::addZonal(const lighting::ShRgb& sh) {
    const glm::vec3 axis = rows::linearAxis(sh[1], sh[2], sh[3], luminanceWeights_);
    maximumIntensity_ = std::max(maximumIntensity_, largestAbsolute(rows::intensityAlong(sh, axis)));
    const glm::vec3 zonal = rows::zonalAlong(sh, axis);
    const float bound = kRatioAllowance * kRatioBound[2];
    for (int channel = 0; channel < 3; ++channel) {
        if (!(sh[0][channel] > 0)) continue;
        const float ratio = std::clamp(zonal[channel] / sh[0][channel], -bound, bound);
        minimumZonal_ = std::min(minimumZonal_, ratio);
        maximumZonal_ = std::max(maximumZonal_, ratio);
    }
}

void LightMapMeasure::merge(const LightMapMeasure& other) {
    coveredTexels_ += other.coveredTexels_;
    beyondPositiveBounds_ += other.beyondPositiveBounds_;
    logLuminanceSum_ += other.logLuminanceSum_;
    maximumExit_ = std::max(maximumExit_, other.maximumExit_);
    maximumIntensity_ = std::max(maximumIntensity_, other.maximumIntensity_);
    minimumZonal_ = std::min(minimumZonal_, other.minimumZonal_);
    maximumZonal_ = std::max(maximumZonal_, other.maximumZonal_);
    for (std::size_t i = 0; i < maximumAbsolute_.size(); ++i) {
        maximumAbsolute_[i] = std::max(maximumAbsolute_[i], other.maximumAbsolute_[i]);
        minimumRatio_[i] = std::min(minimumRatio_[i], other.minimumRatio_[i]);
        maximumRatio_[i] = std::max(maximumRatio_[i], other.maximumRatio_[i]);
    }
}

double LightMapMeasure::key() const {
    return coveredTexels_ == 0 ? 0 : std::exp(static_cast<double>(logLuminanceSum_) / kLogUnits / static_cast<double>(coveredTexels_));
}

int LightMapPlan::blockHeight() const {
    int largest = 1;
    for (const LightMapTexture& texture : textures) largest = std::max(largest, formats::info(texture.format).blockHeight);
    return largest;
}

std::size_t LightMapPlan::gpuBytes() const {
    std::size_t bytes = tableBytes();
    for (const LightMapTexture& texture : textures)
        bytes += static_cast<std::size_t>(texture.layerCount) * formats::bytesPerImage(texture.format, width, height);
    return bytes;
}

double LightMapPlan::bitsPerTexel() const {
    double bits = 8.0 * static_cast<double>(tableBytes()) / (static_cast<double>(width) * height);
    for (const LightMapTexture& texture : textures) {
        const formats::PixelFormatInfo& format = formats::info(texture.format);
        bits += 8.0 * texture.layerCount * format.bytesPerBlock / (format.blockWidth * format.blockHeight);
    }
    return bits;
}

std::size_t LightMapPlan::tableBytes() const {
    if (!basis) return 0;
    return basis->tableBytes() + (isClusterInMesh ? 0 : basis->indexBytes());
}

LightMapPlan withHalo3Constants(LightMapPlan luvw) {
    assert(luvw.layout == formats::LightMapLayout::Luvw);
    for (float& range : luvw.constants.at("range")) range *= luvw.constants.at("neutral")[3];
    luvw.constants["neutral"] = {0.5f, 0.5f, 0.5f, 1.0f};
    luvw.constants["root"] = {1.0f};
    luvw.constants["span"].assign(lighting::kShCount, 1.0f);
    return luvw;
}

LightMapPlan planLightMap(formats::LightMapLayout layout, formats::Target target, int width, int height, const LightMapMeasure& measure) {
    LightMapPlan plan = rows::emptyPlan(layout, target, width, height, measure);
    switch (formats::info(layout).family) {
        case LightMapFamily::Raw: {
            float largest = 0;
            for (int i = 0; i < lighting::kShCount; ++i) largest = std::max(largest, measure.maximumAbsolute(i));
            plan.constants["range"] = {halfRange(largest)};
            break;
        }
        case LightMapFamily::Flat:
            plan.constants["range"] = {halfRange(measure.maximumExit())};
            break;
        case LightMapFamily::Luvw:
            planLuvw(plan, measure);
            break;
        case LightMapFamily::Ratio:
        case LightMapFamily::Zh3:
            planRatio(plan, measure);
            break;
        case LightMapFamily::Basis:
            assert(false && "a learned layout needs planLearnedLightMap");
            break;
    }
    return plan;
}

}  // namespace lightcook::compress
