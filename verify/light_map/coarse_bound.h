// Coarse bounds of a quad, for layouts with a fixed decode: how far its control vectors can be from the bilinear blend of its corners'
// decodes, and how far a sampler's tolerance can move it. Computed from lengths only, at a fraction of the cost of the control vectors.
// Private to verify/.
//
// A decode is a product of factors that are each bilinear over the quad. For a polynomial of degree n along an axis, a control value
// differs from the linear blend of the two ends by at most K max |second derivative| with K = 1/4 for n = 2 and K = 1/6 for n = 3:
//   - n = 2: b_1 - (b_0 + b_2) / 2 is half a second difference of the control values;
//   - n = 3: the distance is one third of one second difference and two thirds of another;
//   - the second derivatives at the ends are n (n - 1) times these second differences.
// Control values of a product are means of products of the factors' corners, so factors at their largest bound the second derivative too:
// for bilinear f, g, h along one axis (fg)'' = 2 f'g' and (fgh)'' = 2 (f'g'h + f'gh' + fg'h'). The bounds of both axes add up.
//
// CoarseBoundsOf<Layout> implements CoarseBounds (map_decoder.h) for each layout. basis_coarse_bound.h adds the learned layouts.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <vector>

#include "verify/light_map/curvature.h"
#include "verify/light_map/deviation.h"
#include "verify/light_map/map_decoder.h"
#include "verify/light_map/tolerance.h"
#include "verify/light_map/vectors.h"

namespace lightcook::verify::layouts {

using lightmap::BandLengths;
using lightmap::CoarseBound;
using lightmap::CoarseBounds;
using lightmap::kBandLanes;
using lightmap::QuadTolerance;

namespace detail {

constexpr float kCurvature2 = 1.0f / 4, kCurvature3 = 1.0f / 6;  ///< K of degree 2 and 3

/// Returns the band lengths of upper bounds of coefficients.
inline BandLengths lengthsOf(const shaders::LcSh& upperBounds) {
    return lightmap::bandLengths(upperBounds);
}

/// Returns the box of a layer over a quad, of its corners.
/// absolute, relative  tolerance of the layer's texels, and the part that is a fraction of the value
inline TexelBox boxOf(const std::array<glm::vec4, 4>& at, const glm::vec4& absolute, float relative) {
    const glm::vec4 low = glm::min(glm::min(at[0], at[1]), glm::min(at[2], at[3])),
                    high = glm::max(glm::max(at[0], at[1]), glm::max(at[2], at[3]));
    return {0.5f * (low + high), 0.5f * (high - low), absolute + relative * glm::max(glm::abs(low), glm::abs(high))};
}

}  // namespace detail

/// Coarse bounds of one layout.
template <class Layout>
class CoarseBoundsOf;

/// Returns the largest tolerance of a layer of values in [0, 1], for any block endpoints.
inline glm::vec4 largestTolerance(const FormatTolerance& format) {
    return format.decoded + format.perSpan + format.absolute + format.relative;
}
/// Returns true if the tolerance is a fraction of the value: floating-point formats.
inline bool isRelative(const FormatTolerance& format) {
    return format.absolute == 0 && format.decoded == glm::vec4(0) && format.perSpan == glm::vec4(0);
}
/// Returns true for formats of values in [0, 1]. Signed formats have a larger tolerance.
inline bool isUnsigned(const FormatTolerance& format) {
    return format.relative == 0 && format.absolute < 3.0f / 255;
}

/// Directions in tangent space: linear, but what is shown beside the coefficients counts as curvature.
template <InTangentSpace Layout>
class CoarseBoundsOf<Layout> final : public CoarseBounds {
public:
    CoarseBoundsOf(const Layout& layout, const std::vector<FormatTolerance>& formats) : layout_(layout), formats_(formats) {}
    bool isKnown() const override { return true; }
    CoarseBound bound(const QuadTexels& t, std::size_t cluster, const QuadTolerance& tolerance) const override {
        std::array<TexelBox, Layout::kLayers> boxes;
        Texels<Layout::kLayers> largest;
        for (std::size_t layer = 0; layer < boxes.size(); ++layer) {
            const auto at = detail::layerAt(t, layer);
            largest[layer] = detail::largestOf(at);
            if (!formats_.empty()) boxes[layer] = detail::boxOf(at, tolerance.at(layer), formats_[layer].relative);
        }
        shaders::LcSh beside{};
        beside.c[0] = besideOf(layout_, largest);
        return {detail::lengthsOf(beside), formats_.empty() ? BandLengths{} : detail::lengthsOf(deviationOf(layout_, cluster, boxes))};
    }

private:
    const Layout& layout_;
    std::vector<FormatTolerance> formats_;
};

/// Linear decodes: the corners are the control vectors, so the curvature is 0.
template <class Layout>
requires(Layout::kDegree == 1 && !Curved<Layout> && !InTangentSpace<Layout>) class CoarseBoundsOf<Layout> final : public CoarseBounds {
public:
    CoarseBoundsOf(const Layout& layout, const std::vector<FormatTolerance>& formats) : layout_(layout), formats_(formats) {}
    bool isKnown() const override { return true; }
    CoarseBound bound(const QuadTexels& t, std::size_t, const QuadTolerance&) const override {
        if (formats_.empty()) return {};
        std::array<TexelBox, Layout::kLayers> boxes;
        for (std::size_t layer = 0; layer < boxes.size(); ++layer) {
            const FormatTolerance& format = formats_[layer];
            // Endpoints of signed blocks are up to 2 apart.
            boxes[layer].tolerance =
                format.decoded + 2.0f * format.perSpan + format.absolute + format.relative * detail::largestOf(detail::layerAt(t, layer));
        }
        return {{}, detail::lengthsOf(deviationOf(layout_, boxes))};
    }

private:
    const Layout& layout_;
    std::vector<FormatTolerance> formats_;
};

/// Ratios: L (1, ratios), degree 2.
template <RatioFamily Layout>
class CoarseBoundsOf<Layout> final : public CoarseBounds {
public:
    CoarseBoundsOf(const Layout& layout, const std::vector<FormatTolerance>& formats) : k_(layout.k) {
        static_assert(Layout::kDegree == 2);
        if (formats.empty()) return;
        std::array<TexelBox, Layout::kLayers> boxes;
        for (std::size_t layer = 0; layer < boxes.size(); ++layer) {
            isKnown_ = isKnown_ && (layer == 0 ? isRelative(formats[layer]) : isUnsigned(formats[layer]));
            boxes[layer] = {glm::vec4(0.5f), glm::vec4(0.5f), largestTolerance(formats[layer])};
        }
        unit_ = detail::lengthsOf(deviationOf(layout, boxes));
    }
    bool isKnown() const override { return isKnown_; }
    CoarseBound bound(const QuadTexels& t, std::size_t, const QuadTolerance&) const override {
        using detail::layerAt;
        using detail::step;
        const auto l0 = layerAt(t, 0);
        const glm::vec4 across = step(l0, 0), down = step(l0, 1), light = detail::largestOf(l0);
        shaders::LcSh curvature{};
        for (std::size_t i = 0; i < Layout::kRatioCount; ++i) {
            const auto ratio = layerAt(t, 1 + i);
            const glm::vec4 second = across * step(ratio, 0) + down * step(ratio, 1);
            curvature.c[i + 1] = std::abs(2 * detail::kCurvature2 * k_.range * k_.scale[i]) * glm::vec3(second);
        }
        CoarseBound out{detail::lengthsOf(curvature), unit_};
        for (std::size_t l = 0; l < 3; ++l)
            for (std::size_t c = 0; c < 3; ++c) out.tolerance[3 * l + c] *= light[static_cast<int>(c)];
        return out;
    }

private:
    decltype(Layout::k) k_;
    bool isKnown_ = true;
    BandLengths unit_{};  ///< deviation for l0 = 1 and any ratios
};

/// Linear exit radiance: L0 (1, u), degree 2. Texels of u may be of a floating-point format, whose tolerance follows from the quad's own.
template <LinearExitLayout Layout>
class CoarseBoundsOf<Layout> final : public CoarseBounds {
public:
    CoarseBoundsOf(const Layout& layout, const std::vector<FormatTolerance>& formats) : layout_(layout), formats_(formats) {
        static_assert(Layout::kDegree == 2);
    }
    bool isKnown() const override { return true; }
    CoarseBound bound(const QuadTexels& t, std::size_t, const QuadTolerance& tolerance) const override {
        Texels<Layout::kLayers> across, down;
        std::array<TexelBox, Layout::kLayers> boxes;
        for (std::size_t layer = 0; layer < boxes.size(); ++layer) {
            const auto at = detail::layerAt(t, layer);
            across[layer] = detail::step(at, 0);
            down[layer] = detail::step(at, 1);
            if (formats_.empty()) continue;
            boxes[layer] = detail::boxOf(at, tolerance.at(layer), formats_[layer].relative);
        }
        shaders::LcSh curvature{};
        for (std::size_t i = 1; i < 4; ++i)
            curvature.c[i] = 2 * detail::kCurvature2 * Layout::kSlope *
                             (glm::vec3(across[0]) * Layout::unit(across, i) + glm::vec3(down[0]) * Layout::unit(down, i));
        return {detail::lengthsOf(curvature), formats_.empty() ? BandLengths{} : detail::lengthsOf(deviationOf(layout_, boxes))};
    }

private:
    const Layout& layout_;
    std::vector<FormatTolerance> formats_;
};

/// Curved layouts. Parts of a quad are refined one by one (curved_bounds.h), and the curvature of a part adds to how far its corners are
/// from the blend: halving divides the curvature by four, so that all of them are within 1 + 1/4 of the curvature of the quad, here 4/3.
template <Curved Layout>
class CoarseBoundsOf<Layout> final : public CoarseBounds {
public:
    CoarseBoundsOf(const Layout& layout, const std::vector<FormatTolerance>& formats) : layout_(layout), formats_(formats) {}
    bool isKnown() const override { return true; }
    CoarseBound bound(const QuadTexels& t, std::size_t, const QuadTolerance& tolerance) const override {
        CoarseBound out{detail::lengthsOf(curvatureOf(layout_, t)), {}};
        for (float& length : out.curvature) length *= kParts;
        if (formats_.empty()) return out;
        std::array<TexelBox, Layout::kLayers> boxes;
        for (std::size_t layer = 0; layer < boxes.size(); ++layer) {
            const auto at = detail::layerAt(t, layer);
            boxes[layer] = detail::boxOf(at, tolerance.at(layer), formats_[layer].relative);
        }
        out.tolerance = detail::lengthsOf(deviationOf(layout_, boxes));
        return out;
    }

private:
    static constexpr float kParts = 4.0f / 3;
    const Layout& layout_;
    std::vector<FormatTolerance> formats_;
};

/// halo3: a0 a1 uvw, degree 3.
template <>
class CoarseBoundsOf<Halo3> final : public CoarseBounds {
public:
    CoarseBoundsOf(const Halo3& layout, const std::vector<FormatTolerance>& formats) : k_(layout.k), isIdeal_(formats.empty()) {
        static_assert(Halo3::kDegree == 3);
        for (const FormatTolerance& format : formats) isKnown_ = isKnown_ && isUnsigned(format);
    }
    bool isKnown() const override { return isKnown_; }
    CoarseBound bound(const QuadTexels& t, std::size_t, const QuadTolerance& tolerance) const override {
        shaders::LcSh curvature{}, off{};
        for (std::size_t i = 0; i < kCount; ++i)
            if (isIdeal_)
                addCoefficient(t, i, glm::vec4(0), glm::vec4(0), curvature.c[i], off.c[i]);
            else
                addCoefficient(t, i, tolerance.at(i), tolerance.at(kCount + i), curvature.c[i], off.c[i]);
        return {detail::lengthsOf(curvature), detail::lengthsOf(off)};
    }

private:
    static constexpr std::size_t kCount = Halo3::kLayers / 2;

    void addCoefficient(const QuadTexels& t, std::size_t i, const glm::vec4& tolerance0, const glm::vec4& tolerance1, glm::vec3& curvature,
                        glm::vec3& tolerance) const {
        using detail::step;
        const auto first = detail::layerAt(t, i), second = detail::layerAt(t, kCount + i);
        const float range = std::abs(k_.range[i]);
        // Largest factors: |uvw| over the boxes of both colours (xyz), a0 and a1 (w).
        const glm::vec4 low0 = glm::min(glm::min(first[0], first[1]), glm::min(first[2], first[3])),
                        high0 = glm::max(glm::max(first[0], first[1]), glm::max(first[2], first[3])),
                        low1 = glm::min(glm::min(second[0], second[1]), glm::min(second[2], second[3])),
                        high1 = glm::max(glm::max(second[0], second[1]), glm::max(second[2], second[3]));
        const glm::vec4 uvw = glm::abs(low0 + high0 + low1 + high1 - 2.0f) + (high0 - low0) + (high1 - low1);
        const float a0 = std::max(std::abs(low0.w), std::abs(high0.w)), a1 = std::max(std::abs(low1.w), std::abs(high1.w));
        for (int axis = 0; axis < 2; ++axis) {
            const glm::vec4 step0 = step(first, axis), step1 = step(second, axis);
            const glm::vec4 stepUvw = 2.0f * (step0 + step1);
            curvature +=
                2 * detail::kCurvature3 * range * (step0.w * step1.w * glm::vec3(uvw) + (step0.w * a1 + a0 * step1.w) * glm::vec3(stepUvw));
        }
        const glm::vec3 off = 2.0f * glm::vec3(tolerance0 + tolerance1);
        const float largest0 = a0 + tolerance0.w, largest1 = a1 + tolerance1.w;
        tolerance = range * (largest0 * largest1 * off + (largest0 * tolerance1.w + largest1 * tolerance0.w) * (glm::vec3(uvw) + off));
    }

    shaders::LcHalo3Constants k_;
    bool isIdeal_, isKnown_ = true;
};

}  // namespace lightcook::verify::layouts
