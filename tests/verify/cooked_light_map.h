// Fixture of tests of the verifier: a light map, encoded and decoded in memory.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "compress/light_map.h"
#include "tests/compress/light_map_plan.h"
#include "tests/formats/light_map_layouts.h"
#include "verify/light_map.h"
#include "verify/light_map/layouts.h"
#include "verify/sampler_tolerance.h"
#include "verify/texture_unit.h"

namespace lightcook::test {

/// A cooked map, decoded from its bytes, with its reference.
struct Cooked {
    formats::LightMapStrip reference;
    verify::CookedLightMap map;
    verify::DecodedLightMapRows texels;
    double key = 0;

    verify::LightMapVerifier verifier(const verify::LightMapShading& shading = {}, const verify::LightMapSampling& sampling = {}) const {
        auto created = verify::LightMapVerifier::create(map, shading, sampling, key);
        EXPECT_TRUE(created.has_value());
        return std::move(*created);
    }
    std::vector<verify::StageError> stages(const verify::LightMapShading& shading = {},
                                           const verify::LightMapSampling& sampling = {}) const {
        return verifier(shading, sampling).verifyRows(texels, reference, 0, map.height).figures();
    }
    verify::StageError total() const { return stages().back(); }
    /// Returns the total for an ideal sampler.
    verify::StageError idealTotal() {
        const auto formats = std::exchange(map.formats, {});
        verify::StageError out = total();
        map.formats = formats;
        return out;
    }
};

inline Cooked cook(formats::LightMapStrip reference, formats::LightMapLayout layout, formats::Target target, int effort,
                   formats::LightMapFilter filter = formats::LightMapFilter::Hardware) {
    Cooked cooked;
    const int width = reference.sh.width(), height = reference.sh.height();
    compress::LightMapMeasure measure;
    measure.add(reference);
    compress::EncodeOptions options;
    options.effort = effort;
    const compress::LightMapPlan plan = synthetic::planOf(layout, target, reference, options, 0, filter);
    const compress::EncodedLightMapRows rows = compress::encodeLightMapRows(plan, reference, 0, height, options);
    for (std::size_t t = 0; t < rows.textures.size(); ++t) {
        cooked.texels.textures.emplace_back();
        cooked.texels.spans.emplace_back();
        cooked.map.formats.push_back(plan.textures[t].format);
        for (const auto& bytes : rows.textures[t].layers) {
            const glm::ivec2 size = plan.textures[t].sizeFor(width, height);
            cooked.texels.spans.back().push_back(verify::blockSpans(plan.textures[t].format, bytes, size.x));
            cooked.texels.textures.back().emplace_back(size.x, size.y);
            verify::decodeRows(plan.textures[t].format, bytes, cooked.texels.textures.back().back().view());
        }
    }
    verify::LightMapKey key;
    key.add(reference, 0, height);
    cooked.key = key.key();
    EXPECT_EQ(cooked.key, measure.key());
    cooked.map.layout = formats::info(layout).name;
    cooked.map.filter = plan.filter;
    cooked.map.constants = plan.constants;
    cooked.map.width = width;
    cooked.map.height = height;
    if (plan.hasCoverage()) cooked.texels.covered = reference.covered.copy();
    cooked.reference = std::move(reference);
    return cooked;
}

/// Returns the layout of a cooked map; of one in tangent space, on the tangents of its bake.
inline verify::layouts::Layout layoutOn(const Cooked& cooked) {
    verify::layouts::Layout layout = *verify::layouts::layoutOf(cooked.map);
    if (auto* const rnm = std::get_if<verify::layouts::Rnm>(&layout)) rnm->frames.strip = &cooked.reference;
    return layout;
}

/// Returns the shader's light of a texel.
/// off  [4 layer + channel] share of what decoders of blocks may differ by, in [-1, 1]; empty: none
template <class Layout>
shaders::LcSh lightOfTexel(const Cooked& cooked, const Layout& layout, int x, int y, std::span<const float> off = {}) {
    verify::layouts::Texels<Layout::kLayers> texels{};
    std::size_t at = 0;
    for (std::size_t t = 0; t < cooked.texels.textures.size(); ++t) {
        const int side = formats::info(Layout::kLayout).textures[t].side;
        const glm::vec4 most = verify::toleranceOf(cooked.map.formats.at(t)).decoded;
        for (const auto& layer : cooked.texels.textures[t]) {
            texels[at] = layer.at(x / side, y / side);
            for (std::size_t c = 0; c < 4 && !off.empty(); ++c)
                texels[at][static_cast<int>(c)] += off[4 * at + c] * most[static_cast<int>(c)];
            ++at;
        }
    }
    return verify::layouts::decodeAt(layout, x, y).decode(texels);
}

}  // namespace lightcook::test
