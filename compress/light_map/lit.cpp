// Family lit: one directional light taken out of each texel, in textures "l0", "light" and "direction", and the ratios of the rest, in
// texture "rest" of the same or of a smaller size (lit_fit.h).
//
// Each part is coded, and those after it are solved for what it decodes to: direction, l0, light, rest. Multi-stage compression as in
// Hu 2008. The shader decodes texels before it filters them, so that texels outside charts have no weight and every texel stands alone.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "compress/light_map/families.h"
#include "compress/light_map/lit_fit.h"

namespace lightcook::compress::rows {

namespace {

using formats::Image;

/// Textures of the plan.
enum Part : std::size_t { kDc, kLight, kDirection, kRest, kParts };

/// Ratios reach to this share of what light that is nowhere negative can have.
constexpr float kShareOfBound = 0.9f;
/// Ratio 0 has this code of 8 bits, so that a rest that is the same from everywhere is exact.
constexpr float kZero = 128.0f / 255;

/// Returns the octahedral projection of a unit vector, mapped to [0, 1].
glm::vec2 octahedral(const glm::vec3& d) {
    const glm::vec2 p = glm::vec2(d) / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
    if (d.z >= 0) return 0.5f * p + 0.5f;
    const glm::vec2 sign(p.x >= 0 ? 1.0f : -1.0f, p.y >= 0 ? 1.0f : -1.0f);
    return 0.5f * (1.0f - glm::abs(glm::vec2(p.y, p.x))) * sign + 0.5f;
}
glm::vec3 directionOf(const glm::vec4& texel) {
    const glm::vec2 p = 2.0f * glm::vec2(texel) - 1.0f;
    const float z = 1 - std::abs(p.x) - std::abs(p.y), below = std::max(-z, 0.0f);
    return glm::normalize(glm::vec3(p.x - (p.x >= 0 ? below : -below), p.y - (p.y >= 0 ? below : -below), z));
}

/// Returns the largest ratios that the constants allow in both signs.
std::array<float, LitFit::kHigher> largestRatios(const LightMapPlan& plan) {
    std::array<float, LitFit::kHigher> largest{};
    for (std::size_t i = 0; i < largest.size(); ++i) largest[i] = constant(plan, "scale", i) + constant(plan, "bias", i);
    return largest;
}

class LitRows {
public:
    LitRows(const LightMapPlan& plan, const Source& source, const EncodeOptions& options)
        : plan_(plan),
          source_(source),
          options_(options),
          range_(constant(plan, "range", 0)),
          fit_(source, range_, plan.textures[kRest].side, largestRatios(plan)) {
        options_.hdrMetric = HdrMetric::Linear;
        out_.textures.resize(kParts);
    }

    EncodedLightMapRows encode() {
        fit_.solve(false);
        encodeDirection();
        fit_.solve(true);
        encodeDc();
        fit_.solveIntensities();
        encodeLight();
        fit_.solveRatios();
        encodeRest();
        return std::move(out_);
    }

private:
    /// Keeps the bytes of a layer. Returns its decoded texels.
    Image<glm::vec4> keep(Part part, Layer layer) {
        out_.textures[part].layers.push_back(std::move(layer.bytes));
        return std::move(layer.decoded);
    }
    /// Returns the significance of a texel's number, of which an error is seen multiplied by a light with this square.
    float weightOf(int x, int y, float square) const { return significanceOf(source_, x, y, source_.importance.at(x, y) * square); }
    /// light  over the range
    float squareOverKey(const glm::vec3& light) const {
        const glm::vec3 perKey = light / std::max(static_cast<float>(plan_.key) / range_, 1e-12f);
        return glm::dot(perKey, perKey);
    }

    void encodeDirection() {
        Image<glm::vec4> texels(source_.width, source_.height, glm::vec4(0.5f, 0.5f, 0, 1));
        Image<float> significance(source_.width, source_.height, 0);
        fit_.forEachCovered([&](int x, int y) {
            texels.at(x, y) = glm::vec4(octahedral(fit_.directionAt(x, y)), 0, 1);
            significance.at(x, y) = weightOf(x, y, squareOverKey(fit_.intensity().at(x, y)));
        });
        const auto decoded =
            keep(kDirection, encodeLayer(plan_.textures[kDirection].format, texels, significance, options_, true, out_.report));
        fit_.forEachCovered([&](int x, int y) { fit_.setDirection(x, y, directionOf(decoded.at(x, y))); });
    }
    void encodeDc() {
        Image<glm::vec3> light(source_.width, source_.height, glm::vec3(0));
        fit_.forEachCovered([&](int x, int y) { light.at(x, y) = range_ * fit_.dc().at(x, y); });
        const auto decoded = keep(kDc, encodeHdr(plan_, source_, light, range_, options_, true, out_.report));
        fit_.forEachCovered([&](int x, int y) { fit_.dc().at(x, y) = glm::vec3(decoded.at(x, y)); });
    }
    void encodeLight() {
        Image<glm::vec4> texels(source_.width, source_.height, glm::vec4(0, 0, 0, 1));
        Image<float> significance(source_.width, source_.height, 0);
        fit_.forEachCovered([&](int x, int y) {
            texels.at(x, y) = glm::vec4(fit_.intensity().at(x, y), 1);
            significance.at(x, y) = weightOf(x, y, glm::dot(fit_.changeSquare(x, y), glm::vec3(1.0f / 3)));
        });
        const auto decoded = keep(kLight, encodeLayer(plan_.textures[kLight].format, texels, significance, options_, true, out_.report));
        fit_.forEachCovered([&](int x, int y) { fit_.intensity().at(x, y) = glm::vec3(decoded.at(x, y)); });
    }
    void encodeRest() {
        const int side = plan_.textures[kRest].side;
        Image<float> significance(fit_.across(), fit_.down(), 0);
        fit_.forEachCovered([&](int x, int y) { significance.at(x / side, y / side) += weightOf(x, y, squareOverKey(fit_.restAt(x, y))); });
        for (std::size_t i = 0; i < LitFit::kHigher; ++i) {
            Image<glm::vec4> texels(fit_.across(), fit_.down(), glm::vec4(0, 0, 0, 1));
            for (int v = 0; v < fit_.down(); ++v)
                for (int u = 0; u < fit_.across(); ++u)
                    texels.at(u, v) = glm::vec4((fit_.ratio(i, u, v) - constant(plan_, "bias", i)) / constant(plan_, "scale", i), 1);
            keep(kRest, encodeLayer(plan_.textures[kRest].format, texels, significance, options_, false, out_.report));
        }
    }

    const LightMapPlan& plan_;
    const Source& source_;
    EncodeOptions options_;
    float range_;
    LitFit fit_;
    EncodedLightMapRows out_;
};

}  // namespace

void planLit(LightMapPlan& plan, const LightMapMeasure& measure) {
    plan.constants["range"] = {halfRange(measure.maximumAbsolute(0) / kShaderY0)};  // the largest intensity that a light may have
    for (std::size_t i = 1; i < lighting::kShCount; ++i) {
        const float largest = kShareOfBound * std::sqrt(2.0f * static_cast<float>(lighting::kShBand[i]) + 1);
        plan.constants["scale"].push_back(2 * largest);
        plan.constants["bias"].push_back(-kZero * 2 * largest);
    }
}

EncodedLightMapRows encodeLit(const LightMapPlan& plan, const Source& source, const EncodeOptions& options) {
    return LitRows(plan, source, options).encode();
}

}  // namespace lightcook::compress::rows
