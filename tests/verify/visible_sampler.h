// Visible errors of a cooked map at any place, rims of charts included, under any normal, view, m and F0, by a sampler that uses its
// tolerance: filtered and shaded here, to hold the verifier's bounds against.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "lighting/brdf.h"
#include "lighting/sphere.h"
#include "tests/verify/cooked_light_map.h"
#include "verify/assets/random.h"
#include "verify/light_map/layouts.h"

namespace lightcook::test {

/// Factors of the nine coefficients of light in the frame of a texel.
using ShadingRow = lighting::ShDouble;

inline constexpr double kSampledTilt = 60, kLowM = 0.1, kHighM = 0.5, kLowF0 = 0.04, kHighF0 = 0.6;

inline ShadingRow diffuseRow(const glm::dvec3& normal) {
    ShadingRow row = lighting::evaluateBasis(normal);
    for (std::size_t k = 0; k < row.size(); ++k) row[k] *= lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[k])];
    return row;
}
/// Returns area specular of a view, whose azimuth is turned from the x-z plane.
inline ShadingRow specularRow(double NoV, double m, double f0, double azimuth) {
    const auto kernel =
        lighting::integrateAreaSpecular(NoV, m, lighting::NormalDistribution::Beckmann, lighting::CookTorranceNormalization::Energy, 64);
    ShadingRow row;
    for (std::size_t k = 0; k < row.size(); ++k) row[k] = f0 * kernel.c[k] + (1 - f0) * kernel.d[k];
    const double c = std::cos(azimuth), s = std::sin(azimuth);
    return lighting::ShRotation(glm::dmat3(c, s, 0, -s, c, 0, 0, 0, 1)).apply(row);
}
inline glm::dvec3 normalInCap(verify::Random& random) {
    // Every fourth at the edge of the cap.
    const double lowest = std::cos(kSampledTilt * std::numbers::pi / 180);
    const double z = random.next() < 0.25 ? lowest : 1 - (1 - lowest) * random.next(), r = std::sqrt(1 - z * z),
                 azimuth = 2 * std::numbers::pi * random.next();
    return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

/// Rows of random shadings, in lanes.
class ShadingRows {
public:
    static constexpr std::size_t kLanes = verify::DisplayTransform::kLanes;
    ShadingRows(std::size_t count, bool isSpecular, std::uint64_t seed) {
        verify::Random random(seed);
        const auto between = [&](double low, double high) {
            const double part = random.next();
            return part < 0.15 ? low : part > 0.85 ? high : low + (high - low) * random.next();
        };
        std::vector<lighting::AreaSpecularKernel> kernels;
        for (std::size_t at = 0; at < count; ++at) {
            const double NoV = random.next() < 0.2 ? 0.001 + 0.1 * random.next() : std::max(1e-3, random.next());
            if (isSpecular) {
                rows.push_back(specularRow(NoV, between(kLowM, kHighM), between(kLowF0, kHighF0), 2 * std::numbers::pi * random.next()));
            } else {
                normals.push_back(at == 0 ? glm::dvec3(0, 0, 1) : normalInCap(random));
                rows.push_back(diffuseRow(normals.back()));
            }
        }
        for (std::size_t k = 0; k < lanes.size(); ++k)
            for (const ShadingRow& row : rows) lanes[k].push_back(static_cast<float>(row[k]));
    }
    std::vector<ShadingRow> rows;
    std::vector<glm::dvec3> normals;                           ///< of diffuse rows, in the frame of the texel
    std::array<std::vector<float>, lighting::kShCount> lanes;  ///< [coefficient][row]
};

/// A place of a map: the nearest texel, how far from it [texels, at most 1/2], the covered texel of the quad whose decode a surface there
/// uses, and what the sampler makes of it.
struct SampledPlace {
    int x = 0, y = 0;
    glm::vec2 off{0};
    int decode = 0;                ///< corner of the quad
    glm::vec2 shift{0};            ///< of the filter's fractions [texels]
    std::vector<float> tolerance;  ///< [layer][channel], in [-1, 1], of the format's tolerance; empty: an ideal sampler
    int quadX() const { return x + (off.x < 0 ? -1 : 0); }
    int quadY() const { return y + (off.y < 0 ? -1 : 0); }
};

/// Error and reference, [channel][coefficient], in the frame of the nearest texel and in units of the key.
struct SampledLight {
    std::array<lighting::Sh, 3> reference{}, found{};
    /// Diffuse light of a layout in tangent space, for a normal in the frame of the nearest texel. Empty: that of `found`.
    std::function<glm::vec3(const glm::dvec3&)> shown;
};

class VisibleSampler {
public:
    VisibleSampler(const Cooked& cooked, const verify::Viewing& viewing)
        : cooked_(cooked), layout_(layoutOn(cooked)), display_(viewing, cooked.key) {
        for (std::size_t t = 0; t < cooked.texels.textures.size(); ++t)
            for (std::size_t layer = 0; layer < cooked.texels.textures[t].size(); ++layer) {
                layers_.push_back(&cooked.texels.textures[t][layer]);
                spans_.push_back(&cooked.texels.spans[t][layer]);
                formats_.push_back(verify::toleranceOf(cooked.map.formats[t]));
            }
        for (int y = 0; y < cooked.map.height; ++y)
            for (int x = 0; x < cooked.map.width; ++x)
                if (isCovered(x, y)) covered.push_back({x, y});
    }
    std::size_t layerCount() const { return layers_.size(); }
    std::vector<std::pair<int, int>> covered;  ///< texels

    bool isCovered(int x, int y) const {
        return cooked_.reference.covered.at(std::clamp(x, 0, cooked_.map.width - 1), std::clamp(y, 0, cooked_.map.height - 1)) != 0;
    }
    /// Returns a random place at a texel.
    SampledPlace placeAt(int x, int y, verify::Random& random) const {
        const auto number = [&] { return static_cast<float>(random.next()); };
        SampledPlace place{x, y, glm::vec2(number(), number()) - 0.5f, 0, {}, {}};
        // Often at a corner or an edge of the square.
        for (int axis = 0; axis < 2; ++axis)
            if (number() < 0.3f) place.off[axis] = number() < 0.5f ? 0.5f : -0.5f;
        do place.decode = random.below(4);
        while (!isCovered(place.quadX() + place.decode % 2, place.quadY() + place.decode / 2));
        // A layout in tangent space has the frame of the texel.
        if (verify::layouts::infoOf(layout_).isInTangentSpace) place.decode = x - place.quadX() + 2 * (y - place.quadY());
        const int kind = random.below(3);
        if (kind == 0) return place;
        place.shift = (2.0f * glm::vec2(number(), number()) - 1.0f) / 256.0f;
        for (std::size_t i = 0; i < 4 * layers_.size(); ++i) {
            const float offset = 2 * number() - 1;
            place.tolerance.push_back(kind == 1 ? offset : offset < 0 ? -1.0f : 1.0f);
        }
        return place;
    }
    SampledLight lightAt(const SampledPlace& place) const {
        const int qx = place.quadX(), qy = place.quadY();
        const glm::vec2 exact = glm::vec2(static_cast<float>(place.x - qx), static_cast<float>(place.y - qy)) + place.off,
                        seen = glm::clamp(exact + place.shift, 0.0f, 1.0f);
        const auto weight = [](const glm::vec2& p, int i) {
            return static_cast<double>(i % 2 == 0 ? 1 - p.x : p.x) * static_cast<double>(i / 2 == 0 ? 1 - p.y : p.y);
        };
        const auto clampedX = [&](int x) { return std::clamp(x, 0, cooked_.map.width - 1); };
        const auto clampedY = [&](int y) { return std::clamp(y, 0, cooked_.map.height - 1); };
        lighting::ShRgb reference{}, found{};
        SampledLight out;
        const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(cooked_.reference.normal.at(place.x, place.y)));
        double sum = 0;
        for (int i = 0; i < 4; ++i)
            if (isCovered(qx + i % 2, qy + i / 2)) sum += weight(exact, i);
        for (int i = 0; i < 4; ++i) {
            const int x = clampedX(qx + i % 2), y = clampedY(qy + i / 2);
            if (!isCovered(x, y)) continue;
            for (std::size_t k = 0; k < reference.size(); ++k)
                reference[k] += static_cast<float>(weight(exact, i) / sum) * cooked_.reference.sh.at(x, y)[k];
        }
        std::visit(
            [&]<class Layout>(const Layout& layout) {
                if (cooked_.map.filter == formats::LightMapFilter::Decoded) {
                    for (int i = 0; i < 4; ++i) {
                        const int x = clampedX(qx + i % 2), y = clampedY(qy + i / 2);
                        if (!isCovered(x, y)) continue;
                        const shaders::LcSh light = lightOfTexel(cooked_, layout, x, y, place.tolerance);
                        for (std::size_t k = 0; k < found.size(); ++k) found[k] += static_cast<float>(weight(exact, i) / sum) * light.c[k];
                    }
                    return;
                }
                verify::layouts::Texels<Layout::kLayers> texels{};
                for (std::size_t layer = 0; layer < texels.size(); ++layer) {
                    glm::vec4 span(0), largest(0);
                    for (int i = 0; i < 4; ++i) {
                        const int x = clampedX(qx + i % 2), y = clampedY(qy + i / 2);
                        const glm::vec4& texel = layers_[layer]->at(x, y);
                        texels[layer] += static_cast<float>(weight(seen, i)) * texel;
                        largest = glm::max(largest, glm::abs(texel));
                        if (formats_[layer].hasSpans()) span = glm::max(span, spans_[layer]->at(x / 4, y / 4));
                    }
                    if (place.tolerance.empty()) continue;
                    const verify::FormatTolerance& format = formats_[layer];
                    const glm::vec4 most = format.decoded + format.perSpan * span + format.absolute + format.relative * largest;
                    for (int channel = 0; channel < 4; ++channel)
                        texels[layer][channel] += place.tolerance[4 * layer + static_cast<std::size_t>(channel)] * most[channel];
                }
                const shaders::LcSh sh =
                    verify::layouts::decodeAt(layout, clampedX(qx + place.decode % 2), clampedY(qy + place.decode / 2)).decode(texels);
                std::copy_n(sh.c, lighting::kShCount, found.begin());
                if constexpr (verify::layouts::InTangentSpace<Layout>)
                    out.shown = [decode = layout.at(place.x, place.y), texels, frame, key = cooked_.key](const glm::dvec3& normal) {
                        return decode.exitRadiance(texels, glm::vec3(frame * normal)) / static_cast<float>(key);
                    };
            },
            layout_);
        const lighting::ShRotation toFrame(glm::transpose(frame));
        out.reference = channelsOf(toFrame.apply(reference));
        out.found = channelsOf(toFrame.apply(found));
        return out;
    }
    /// Writes the visible errors of rows [first, first + kLanes).
    void differences(const SampledLight& light, const ShadingRows& rows, std::size_t first, float* out) const {
        constexpr std::size_t kLanes = ShadingRows::kLanes;
        std::array<float, 3 * kLanes> reference{}, found{}, shownReference{}, shownFound{};
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t k = 0; k < lighting::kShCount; ++k)
                for (std::size_t lane = 0; lane < kLanes; ++lane) {
                    reference[c * kLanes + lane] += light.reference[c][k] * rows.lanes[k][first + lane];
                    found[c * kLanes + lane] += light.found[c][k] * rows.lanes[k][first + lane];
                }
        for (std::size_t lane = 0; light.shown && !rows.normals.empty() && lane < kLanes; ++lane) {
            const glm::vec3 shown = light.shown(rows.normals[first + lane]);
            for (std::size_t c = 0; c < 3; ++c) found[c * kLanes + lane] = shown[static_cast<int>(c)];
        }
        display_.apply(reference.data(), kLanes, shownReference.data());
        display_.apply(found.data(), kLanes, shownFound.data());
        verify::visibleDifferences(shownReference.data(), shownFound.data(), kLanes, out);
    }

    /// Returns the visible error of one row.
    double difference(const SampledLight& light, const ShadingRow& row) const {
        constexpr std::size_t kLanes = ShadingRows::kLanes;
        std::array<float, 3 * kLanes> reference{}, found{}, shownReference{}, shownFound{};
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t k = 0; k < row.size(); ++k) {
                reference[c * kLanes] += light.reference[c][k] * static_cast<float>(row[k]);
                found[c * kLanes] += light.found[c][k] * static_cast<float>(row[k]);
            }
        std::array<float, kLanes> out{};
        display_.apply(reference.data(), kLanes, shownReference.data());
        display_.apply(found.data(), kLanes, shownFound.data());
        verify::visibleDifferences(shownReference.data(), shownFound.data(), kLanes, out.data());
        return static_cast<double>(out[0]);
    }

private:
    std::array<lighting::Sh, 3> channelsOf(const lighting::ShRgb& sh) const {
        std::array<lighting::Sh, 3> out{};
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t k = 0; k < sh.size(); ++k) out[c][k] = sh[k][static_cast<int>(c)] / static_cast<float>(cooked_.key);
        return out;
    }

    const Cooked& cooked_;
    verify::layouts::Layout layout_;
    verify::DisplayTransform display_;
    std::vector<const formats::Image<glm::vec4>*> layers_, spans_;
    std::vector<verify::FormatTolerance> formats_;
};

/// Returns the shading whose bounds cover these samples.
inline verify::LightMapShading sampledShading() {
    verify::LightMapShading shading;
    shading.m = {kLowM, kHighM};
    shading.f0 = {kLowF0, kHighF0};
    shading.normalCount = 2;
    shading.viewCount = 1;
    shading.normalMapTilt = kSampledTilt;
    return shading;
}

/// Returns the display that a map is shown on.
inline verify::Viewing viewingOf(const Cooked& cooked) {
    verify::LightMapKey key;
    key.add(cooked.reference, 0, cooked.map.height);
    return {lighting::DisplaySettings{}.of(key.displayKey())};
}

}  // namespace lightcook::test
