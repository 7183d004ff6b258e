// Family unreal: colour times luminance in logarithms, and one direction that the colours share, in two textures. C = L UVW is the light,
// and a white surface shows C (kY0 + SH . n):
//
//   LogL = (a0 + (a1 - 1/2) / 255) SCALE0.a + ADD0.a,  L = 2^LogL - kBlack,  UVW = rgb0^2 SCALE0.rgb + ADD0.rgb,  SH = rgb1 SCALE1 + ADD1
//
// Every texel stores the functions of the normal that show the bake best over the hemisphere of its normal and share a slope
// (linear_fit.h). BC3 has blocks of their own for colour and alpha, so that stages run in this order, each against the decoded texels of
// those before it:
//   1. rgb1, whose 5 and 6 bits are the coarsest; the constants are solved again for the decoded slope
//   2. a0, from the largest channel of C
//   3. rgb0, for the L that a0 and the best a1 give: a1 can add half a code to a0, and errors of a0 beyond that are left to the colour
//   4. a1, from the best L for the decoded colour and slope
// Other formats have one block for colour and alpha, with weights by channel: a0 and rgb0, then a1 and rgb1 for the decoded first texture.
//
// The engine's black point kBlack is fixed, but the unit of L is free, since SCALE0.rgb and ADD0.rgb take it back. It is chosen such that
// kBlack stands for kKnee times the key: light above it is stored by its logarithm, and light below it by its size. A GPU filters the
// stored logarithms, so that a larger knee reduces the error between texels, and a smaller one the error of codes in the dark. The unit is
// a power of two, so that maps that differ by such a factor have the same codes.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "compress/light_map/families.h"
#include "compress/light_map/linear_fit.h"

namespace lightcook::compress::rows {

namespace {

using formats::Image;
using formats::PixelFormat;

constexpr float kBlack = 0.01858136f;  ///< 2^-5.75, as the engine's shader has it
constexpr float kY0 = kShaderY0;       ///< the constant term of the directionality
constexpr float kResidualStep = 1.0f / 255;
constexpr double kKnee = 1;  ///< of the light L0 of a white surface, over the key
/// Colours and directions of texels darker than this share of the key do not count for the ranges: noise has any colour.
constexpr float kRangeShare = 1.0f / 16;

/// Returns the light C for which L is 1 and the colour is white, a power of two.
float lightOfUnit(double key) {
    constexpr double kLargestExponent = 100;
    const double exponent = std::round(std::log2(kKnee * std::max(key, 1e-12) / (kY0 * kBlack)));
    return static_cast<float>(std::exp2(std::clamp(exponent, -kLargestExponent, kLargestExponent)));
}
/// Returns LogL of light L0 of a white surface, at most what floats can raise 2 to.
float logOf(float light, float lightOfUnit) {
    constexpr double kLargest = 100;
    return static_cast<float>(std::min(std::log2(static_cast<double>(light) / (kY0 * lightOfUnit) + kBlack), kLargest));
}

/// The constants of the layout.
struct UnrealConstants {
    glm::vec4 scale0, add0, scale1, add1;

    explicit UnrealConstants(const LightMapPlan& plan)
        : scale0(read(plan, "scale0")), add0(read(plan, "add0")), scale1(read(plan, "scale1")), add1(read(plan, "add1")) {}

    /// Returns the number in [0, 1] that is stored for a value.
    static float stored(float value, float scale, float add) { return scale > 0 ? std::clamp((value - add) / scale, 0.0f, 1.0f) : 0.0f; }
    float storedLog(float l) const { return stored(std::log2(std::max(l, 0.0f) + kBlack), scale0.w, add0.w); }
    /// Returns L for a0 + (a1 - 1/2) / 255.
    float luminanceOf(float fraction) const { return std::exp2(fraction * scale0.w + add0.w) - kBlack; }
    static float fractionOf(float a0, float a1) { return a0 + (a1 - 0.5f) * kResidualStep; }
    glm::vec3 colorOf(const glm::vec4& first) const {
        const glm::vec3 root(first);
        return root * root * glm::vec3(scale0) + glm::vec3(add0);
    }
    /// Axis of component i of the direction: y, z, x.
    static int axisOf(int i) { return (i + 1) % 3; }
    /// Returns the slopes over kY0 that the direction can hold.
    SlopeRange slopes() const {
        SlopeRange range{};
        for (int i = 0; i < 3; ++i) {
            range.low[axisOf(i)] = static_cast<double>(add1[i] / kY0);
            range.high[axisOf(i)] = static_cast<double>((add1[i] + scale1[i]) / kY0);
        }
        return range;
    }

private:
    static glm::vec4 read(const LightMapPlan& plan, const char* name) {
        return {constant(plan, name, 0), constant(plan, name, 1), constant(plan, name, 2), constant(plan, name, 3)};
    }
};

/// Returns channel weights scaled so that the largest is 1, and at least 1e-6, since 0 would leave a channel to chance.
std::array<float, 4> normalized(const glm::vec4& weights) {
    const float largest = std::max({weights.x, weights.y, weights.z, weights.w});
    std::array<float, 4> out{};
    for (int c = 0; c < 4; ++c) out[static_cast<std::size_t>(c)] = largest > 0 ? std::max(weights[c] / largest, 1e-6f) : 1.0f;
    return out;
}

class UnrealRows {
public:
    UnrealRows(const LightMapPlan& plan, const formats::LightMapStrip& strip, const Source& source, const EncodeOptions& options)
        : plan_(plan),
          strip_(strip),
          source_(source),
          options_(options),
          k_(plan),
          slopes_(k_.slopes()),
          lightOfUnit_(lightOfUnit(plan.key)),
          perKey_(1 / static_cast<float>(plan.key + 1e-12)) {
        options_.hdrMetric = HdrMetric::Linear;
    }

    EncodedLightMapRows run() {
        fit();
        if (plan_.textures[0].format == PixelFormat::Bc3)
            encodeHalves();
        else
            encodeWhole();
        return std::move(out_);
    }

private:
    using Numbers = Image<glm::vec4>;
    using Weights = Image<float>;

    Weights noWeights() const { return Weights(source_.width, source_.height, 0); }
    /// Returns the weight of a texel's number for its slope d(light) / d(number).
    float weightOf(int x, int y, float slope) const {
        const float length = std::min(std::sqrt(source_.importance.at(x, y)) * slope * perKey_, 1e15f);
        return significanceOf(source_, x, y, length * length);
    }
    /// Returns dL / d(a0).
    float slopeOfLog(float l) const { return 0.69314718f * k_.scale0.w * (std::max(l, 0.0f) + kBlack); }
    static float largestOf(const glm::vec3& v) { return std::max({v.x, v.y, v.z, 0.0f}); }

    LinearExits bestAt(const LinearFit& fit, int x, int y) const { return fit.best(source_.lightAt(x, y, 1)); }
    /// Sets light_ and slope_ to the best functions that share a slope.
    void fit() {
        light_ = Image<glm::vec3>(source_.width, source_.height, glm::vec3(0));
        slope_ = Image<glm::dvec3>(source_.width, source_.height, glm::dvec3(0));
        forEachPadded(source_, [&](int x, int y) {
            const LinearFit fit = fitAt(strip_, source_, x, y);
            const LinearExits best = bestAt(fit, x, y);
            glm::dvec3 start;
            for (int c = 0; c < 3; ++c) start[c] = fit.within(best[static_cast<std::size_t>(c)], kLargestSharedSlope).constant;
            const SharedExit exit = fit.shared(best, start, slopes_);
            light_.at(x, y) = glm::vec3(exit.constant) / kY0;
            slope_.at(x, y) = exit.slope;
        });
    }
    /// Sets light_ to the best for the slopes that the direction decodes to.
    void fitLight(const Numbers& direction) {
        forEachPadded(source_, [&](int x, int y) {
            for (int i = 0; i < 3; ++i) {
                const float value = direction.at(x, y)[i] * k_.scale1[i] + k_.add1[i];
                slope_.at(x, y)[UnrealConstants::axisOf(i)] = static_cast<double>(value / kY0);
            }
            const LinearFit fit = fitAt(strip_, source_, x, y);
            const LinearExits best = bestAt(fit, x, y);
            for (int c = 0; c < 3; ++c)
                light_.at(x, y)[c] = static_cast<float>(fit.constantFor(best[static_cast<std::size_t>(c)], slope_.at(x, y))) / kY0;
        });
    }

    /// Sets alphas to a0, and the weights of both.
    void setFirstAlpha(Numbers& texels, Weights& weights) const {
        forEachPadded(source_, [&](int x, int y) {
            const float l = largestOf(light_.at(x, y)) / lightOfUnit_;
            texels.at(x, y).w = k_.storedLog(l);
            weights.at(x, y) = weightOf(x, y, lightOfUnit_ * slopeOfLog(l));
        });
    }
    /// Sets colours to rgb0, for alphas a0.
    void setColor(Numbers& texels, const Numbers& alpha, Weights& weights) const {
        forEachPadded(source_, [&](int x, int y) {
            const glm::vec3& light = light_.at(x, y);
            const float l = reachable(alpha.at(x, y).w, largestOf(light) / lightOfUnit_);
            for (int c = 0; c < 3; ++c)
                texels.at(x, y)[c] = std::sqrt(UnrealConstants::stored(l > 0 ? light[c] / l : 0, k_.scale0[c], k_.add0[c]));
            weights.at(x, y) = weightOf(x, y, largestOf(light));
        });
    }
    /// Sets alphas to a1, for the decoded first texture.
    /// hasSlope  true: the slopes slope_ are given; false: sets slope_ to the best ones for the light that a1 gives
    void setSecondAlpha(Numbers& texels, const Numbers& first, bool hasSlope, Weights& weights) {
        forEachPadded(source_, [&](int x, int y) {
            const glm::vec4& stored = first.at(x, y);
            const glm::vec3 uvw = k_.colorOf(stored);
            const LinearFit fit = fitAt(strip_, source_, x, y);
            const LinearExit exit = scalarExit(bestAt(fit, x, y), uvw);
            double constant = 0;
            if (hasSlope)
                constant = fit.constantFor(exit, slope_.at(x, y));
            else
                constant = fit.shared({exit, exit, exit}, glm::dvec3(fit.within(exit, kLargestSharedSlope).constant), slopes_).constant.x;
            const float l = static_cast<float>(constant) / kY0;
            texels.at(x, y).w = k_.scale0.w > 0 ? std::clamp((k_.storedLog(l) - stored.w) / kResidualStep + 0.5f, 0.0f, 1.0f) : 0.5f;
            weights.at(x, y) = weightOf(x, y, kResidualStep * glm::length(uvw) * slopeOfLog(l));
            if (hasSlope) return;
            const auto shown = static_cast<double>(kY0 * k_.luminanceOf(UnrealConstants::fractionOf(stored.w, texels.at(x, y).w)));
            slope_.at(x, y) = fit.sharedSlope({exit, exit, exit}, glm::dvec3(std::max(shown, 0.0)), slopes_);
        });
    }
    /// Sets colours to rgb1, for slopes slope_.
    void setDirection(Numbers& texels, Weights& weights) const {
        forEachPadded(source_, [&](int x, int y) {
            for (int i = 0; i < 3; ++i)
                texels.at(x, y)[i] = UnrealConstants::stored(kY0 * static_cast<float>(slope_.at(x, y)[UnrealConstants::axisOf(i)]),
                                                             k_.scale1[i], k_.add1[i]);
            weights.at(x, y) = weightOf(x, y, glm::length(light_.at(x, y)));
        });
    }

    void encodeHalves() {
        Numbers first(source_.width, source_.height, glm::vec4(0)), second(source_.width, source_.height, glm::vec4(0));
        Weights weights = noWeights();
        setDirection(second, weights);
        Layer direction = encode(1, second, weights);
        fitLight(direction.decoded);
        setFirstAlpha(first, weights);
        const Layer firstAlpha = encodeAlpha(first, weights, options_, out_.report);
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) first.at(x, y).w = firstAlpha.decoded.at(x, y).x;
        setColor(first, first, weights);
        Layer color = encode(0, first, weights);
        putAlpha(color, firstAlpha);
        setSecondAlpha(second, color.decoded, true, weights);
        putAlpha(direction, encodeAlpha(second, weights, options_, out_.report));
        out_.textures.resize(2);
        out_.textures[0].layers.push_back(std::move(color.bytes));
        out_.textures[1].layers.push_back(std::move(direction.bytes));
    }
    void encodeWhole() {
        Numbers first(source_.width, source_.height, glm::vec4(0)), second(source_.width, source_.height, glm::vec4(0));
        Weights weights = noWeights(), unused = noWeights();
        setFirstAlpha(first, unused);
        setColor(first, first, weights);
        Layer color = encode(0, first, weights);
        setSecondAlpha(second, color.decoded, false, unused);
        setDirection(second, weights);
        Layer direction = encode(1, second, weights);
        out_.textures.resize(2);
        out_.textures[0].layers.push_back(std::move(color.bytes));
        out_.textures[1].layers.push_back(std::move(direction.bytes));
    }
    Layer encode(std::size_t texture, Numbers& texels, const Weights& weights) {
        EncodeOptions options = options_;
        const float ofLog = 0.69314718f * k_.scale0.w;
        if (texture == 0) {
            // d(light) / d(root) = 2 root scale L and d(light) / d(a0) = ln 2 scale L, over the light, for roots near 1.
            const glm::vec3 ofRoots = 2.0f * glm::vec3(k_.scale0) / lightOfUnit_;
            options.channelWeights = normalized(glm::vec4(ofRoots * ofRoots, 3 * ofLog * ofLog));
        } else {
            // d(light shown) / d(direction) = scale n . axis and d(light shown) / d(a1) = kY0 ln 2 scale / 255, over the light.
            const glm::vec3 ofAxes(k_.scale1);
            const float ofResidual = kY0 * kResidualStep * ofLog;
            options.channelWeights = normalized(glm::vec4(ofAxes * ofAxes / 3.0f, ofResidual * ofResidual));
        }
        return encodeLayer(plan_.textures[texture].format, texels, weights, options, true, out_.report);
    }

    /// Returns the function that, times the colour, is nearest to the best ones.
    static LinearExit scalarExit(const LinearExits& best, const glm::vec3& uvw) {
        LinearExit sum;
        const auto square = static_cast<double>(glm::dot(uvw, uvw));
        if (!(square > 0)) return sum;
        for (int c = 0; c < 3; ++c) {
            const LinearExit& each = best[static_cast<std::size_t>(c)];
            const double share = static_cast<double>(uvw[c]) / square;
            sum.constant += share * each.constant;
            sum.linear += share * each.linear;
        }
        return sum;
    }
    /// Returns the luminance nearest to l that a0 and some a1 give.
    float reachable(float a0, float l) const {
        return std::clamp(l, k_.luminanceOf(UnrealConstants::fractionOf(a0, 0)), k_.luminanceOf(UnrealConstants::fractionOf(a0, 1)));
    }

    const LightMapPlan& plan_;
    const formats::LightMapStrip& strip_;
    const Source& source_;
    EncodeOptions options_;
    UnrealConstants k_;
    SlopeRange slopes_;
    float lightOfUnit_;
    float perKey_;
    Image<glm::vec3> light_;   ///< C of the functions to store
    Image<glm::dvec3> slope_;  ///< their slopes
    EncodedLightMapRows out_;
};

}  // namespace

void planUnreal(LightMapPlan& plan, const LightMapMeasure& measure) {
    const SharedExitRange all = measure.sharedExitRange(0);
    SharedExitRange range = measure.sharedExitRange(kRangeShare * static_cast<float>(plan.key));
    if (!(range.highestLight > 0)) range = all;
    glm::vec4 scale0(0), add0(0, 0, 0, std::log2(kBlack)), scale1(0), add1(0, 0, 0, kY0);
    if (all.highestLight > 0) {
        const float unit = lightOfUnit(plan.key);
        const float low = logOf(all.lowestLight, unit);
        scale0 = glm::vec4(unit * (range.highestChroma - range.lowestChroma), logOf(all.highestLight, unit) - low);
        add0 = glm::vec4(unit * range.lowestChroma, low);
        for (int i = 0; i < 3; ++i) {
            const int axis = UnrealConstants::axisOf(i);
            scale1[i] = kY0 * (range.highestSlope[axis] - range.lowestSlope[axis]);
            add1[i] = kY0 * range.lowestSlope[axis];
        }
    }
    const auto add = [&](const char* name, const glm::vec4& v) { plan.constants[name] = {v.x, v.y, v.z, v.w}; };
    add("scale0", scale0);
    add("add0", add0);
    add("scale1", scale1);
    add("add1", add1);
}

EncodedLightMapRows encodeUnreal(const LightMapPlan& plan, const formats::LightMapStrip& strip, const Source& source,
                                 const EncodeOptions& options) {
    return UnrealRows(plan, strip, source, options).run();
}

}  // namespace lightcook::compress::rows
