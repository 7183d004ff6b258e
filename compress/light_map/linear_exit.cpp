// Families godot and bakery: what a white surface shows as a linear function of its normal, L0 and L1 = L0 times a number of [-extent,
// extent] along each axis, in the units of the engine. Every texel's function is the one that shows the bake best over the hemisphere of
// its normal (linear_fit.h).
//
// L0 is encoded first. L1 is solved again for the decoded L0, so that an error of L0 does not enter twice. Its texels weigh by the square
// of L0, as ratios do. Where L0 decodes to black every L1 gives black; 0 is stored.
// Layout mono-sh has one L1 over L0 for the three colours: it and L0 are solved in turns.
#include <algorithm>
#include <array>
#include <glm/common.hpp>

#include "compress/light_map/families.h"
#include "compress/light_map/linear_fit.h"

namespace lightcook::compress::rows {

namespace {

using formats::Image;
using formats::LightMapFamily;
using formats::LightMapLayout;

constexpr int kAxes = 3;

class LinearExitRows {
public:
    LinearExitRows(const LightMapPlan& plan, const formats::LightMapStrip& strip, const Source& source, const EncodeOptions& options)
        : plan_(plan),
          strip_(strip),
          source_(source),
          options_(options),
          isMono_(plan.layout == LightMapLayout::MonoSh),
          isGodot_(formats::info(plan.layout).family == LightMapFamily::Godot),
          extent_(isGodot_ ? 4 : 2) {}

    EncodedLightMapRows run() {
        out_.textures.resize(plan_.textures.size());
        encodeL0();
        std::array<Image<glm::vec4>, kAxes> slopes;
        for (auto& axis : slopes) axis = Image<glm::vec4>(source_.width, source_.height, glm::vec4(0.5f, 0.5f, 0.5f, 1));
        Image<float> significance(source_.width, source_.height, 0);
        forEachPadded(source_, [&](int x, int y) {
            const glm::vec3 l0(l0_.at(x, y));
            const std::array<glm::vec3, kAxes> slope = slopesFor(x, y, l0);
            for (std::size_t axis = 0; axis < kAxes; ++axis)
                slopes[axis].at(x, y) = glm::vec4(glm::clamp(slope[axis] / (2 * extent_) + 0.5f, 0.0f, 1.0f), 1);
            significance.at(x, y) = ratioSignificance(plan_, source_, x, y, l0);
        });
        if (isMono_) {
            Image<glm::vec4> shared(source_.width, source_.height, glm::vec4(0, 0, 0, 1));
            for (int axis = 0; axis < kAxes; ++axis)
                for (int y = 0; y < source_.height; ++y)
                    for (int x = 0; x < source_.width; ++x) shared.at(x, y)[axis] = slopes[static_cast<std::size_t>(axis)].at(x, y).x;
            encodeSlopes(1, shared, significance);
            return std::move(out_);
        }
        // Godot's slices are in the order of the coefficients: y, z, x.
        for (std::size_t i = 0; i < kAxes; ++i) encodeSlopes(isGodot_ ? 0 : 1 + i, slopes[isGodot_ ? (i + 1) % kAxes : i], significance);
        return std::move(out_);
    }

private:
    LinearExits bestAt(const LinearFit& fit, int x, int y) const { return fit.best(source_.lightAt(x, y, 1)); }
    SlopeRange range() const { return {glm::dvec3(-extent_), glm::dvec3(extent_)}; }
    glm::vec3 firstFor(const LinearFit& fit, const LinearExits& best) const {
        glm::dvec3 l0;
        for (int c = 0; c < 3; ++c) l0[c] = fit.within(best[static_cast<std::size_t>(c)], extent_).constant;
        return glm::vec3(isMono_ ? fit.shared(best, l0, range()).constant : l0);
    }
    void encodeL0() {
        Image<glm::vec3> values(source_.width, source_.height, glm::vec3(0));
        forEachPadded(source_, [&](int x, int y) {
            const LinearFit fit = fitAt(strip_, source_, x, y);
            values.at(x, y) = firstFor(fit, bestAt(fit, x, y));
        });
        Layer l0 = encodeHdr(plan_, source_, values, 1, options_, true, out_.report);
        out_.textures[0].layers.push_back(std::move(l0.bytes));
        l0_ = std::move(l0.decoded);
    }
    /// Returns L1 / L0 along x, y and z by channel, for the decoded L0.
    std::array<glm::vec3, kAxes> slopesFor(int x, int y, const glm::vec3& l0) const {
        const LinearFit fit = fitAt(strip_, source_, x, y);
        const LinearExits best = bestAt(fit, x, y);
        std::array<glm::vec3, kAxes> slopes{};
        if (isMono_) {
            const glm::dvec3 shared = fit.sharedSlope(best, glm::dvec3(l0), range());
            for (int axis = 0; axis < kAxes; ++axis) slopes[static_cast<std::size_t>(axis)] = glm::vec3(static_cast<float>(shared[axis]));
            return slopes;
        }
        for (int c = 0; c < 3; ++c) {
            if (!(l0[c] > 0)) continue;
            const auto constant = static_cast<double>(l0[c]);
            const glm::dvec3 slope = fit.linearFor(best[static_cast<std::size_t>(c)], constant) / constant;
            for (int axis = 0; axis < kAxes; ++axis) slopes[static_cast<std::size_t>(axis)][c] = static_cast<float>(slope[axis]);
        }
        return slopes;
    }
    void encodeSlopes(std::size_t texture, Image<glm::vec4>& texels, const Image<float>& significance) {
        EncodeOptions linear = options_;
        linear.hdrMetric = HdrMetric::Linear;
        Layer layer = encodeLayer(plan_.textures[texture].format, texels, significance, linear, false, out_.report);
        out_.textures[texture].layers.push_back(std::move(layer.bytes));
    }

    const LightMapPlan& plan_;
    const formats::LightMapStrip& strip_;
    const Source& source_;
    const EncodeOptions& options_;
    bool isMono_, isGodot_;
    float extent_;
    Image<glm::vec4> l0_;  ///< decoded
    EncodedLightMapRows out_;
};

}  // namespace

EncodedLightMapRows encodeLinearExit(const LightMapPlan& plan, const formats::LightMapStrip& strip, const Source& source,
                                     const EncodeOptions& options) {
    return LinearExitRows(plan, strip, source, options).run();
}

}  // namespace lightcook::compress::rows
