// The coarse bound of a quad is never below its refined bound, for any content of its texels.
#include "verify/light_map/quad_coarse_bound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/compress/synthetic_light_map.h"
#include "tests/verify/cooked_light_map.h"
#include "verify/assets/random.h"
#include "verify/light_map/controls.h"
#include "verify/light_map/curved_bounds.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using verify::Random;
using verify::lightmap::ErrorBound;

constexpr int kQuadsWidth = 29, kQuadsHeight = 21;

/// Replaces the texels by random ones: anywhere in [0, 1], at its ends, or near 1/2; light of any magnitude.
void scramble(test::Cooked& cooked, Random& random) {
    const formats::LightMapLayoutInfo& info = formats::info(*formats::lightMapLayoutFromName(cooked.map.layout));
    for (std::size_t texture = 0; texture < cooked.texels.textures.size(); ++texture) {
        const formats::TexelRole role = info.textures[texture].role;
        const bool isLight = role == formats::TexelRole::Half || role == formats::TexelRole::Hdr;
        for (std::size_t layer = 0; layer < cooked.texels.textures[texture].size(); ++layer) {
            for (glm::vec4& texel : cooked.texels.textures[texture][layer].texels()) {
                const double kind = random.next(), size = std::pow(10.0, 4 * random.next() - 3);
                for (int c = 0; c < 4; ++c) {
                    const double value = kind < 0.4   ? random.next()
                                         : kind < 0.6 ? std::floor(2 * random.next())
                                                      : 0.5 + 0.02 * (random.next() - 0.5);
                    texel[c] = static_cast<float>(isLight ? size * value : value);
                }
            }
            for (glm::vec4& span : cooked.texels.spans[texture][layer].texels())
                for (int c = 0; c < 4; ++c) span[c] = static_cast<float>(random.next());
        }
    }
    for (lighting::ShRgb& sh : cooked.reference.sh.texels())
        for (glm::vec3& c : sh)
            for (int i = 0; i < 3; ++i) c[i] *= static_cast<float>(2 * random.next());
}

struct Compared {
    int quads = 0, below = 0;    ///< quads, and those whose coarse bound is below the refined one
    std::vector<double> ratios;  ///< coarse over refined bound
};

/// Returns the bound by CurvedBounds, which may split the quad. Of other layouts: the bound by lengths of control vectors,
/// as QuadBounds computes them under the decode of one corner.
ErrorBound refinedBound(const verify::lightmap::MapRows& rows, const verify::lightmap::SamplerTolerance& tolerance,
                        const verify::lightmap::BoundEvaluator& evaluator, const verify::lightmap::MapRows::Corners& corners, int x, int y,
                        int corner) {
    using namespace verify::lightmap;
    if (rows.decoder().isCurved()) {
        LargestBounds largest;
        CurvedBounds(rows, tolerance, evaluator).bound(corners.texels, corners.references, x, y, largest);
        return {static_cast<float>(kFloor * largest.diffuse.bound), static_cast<float>(kFloor * largest.specular.bound)};
    }
    const auto quad = QuadControls::ofErrors(rows.decoder(), rows.clusterOf(x, y, corner), corners.texels, corners.references, {});
    const Squares squares = largestSquares(quad.values());
    ChannelSlack slack{};
    addRounding(slack, squares, referenceSquares(corners.references));
    if (!tolerance.isNone()) {
        tolerance.addFilterFractions(slack, corners.references, squares);
        slack = sumOf(slack, tolerance.lengthsOf(tolerance.quadDeviation(corners.texels, x, y, corner), true));
    }
    BandLengths all{};
    for (std::size_t l = 0; l < 3; ++l)
        for (std::size_t c = 0; c < kChannels; ++c)
            all[3 * l + c] = static_cast<float>(slack[c][l] + outwardLength(squares[l][static_cast<int>(c)]));
    ErrorBound bound;
    for (std::size_t c = 0; c < kChannels; ++c) bound.raise(evaluator.errorBound(all, c));
    return bound;
}

Compared compare(const test::Cooked& cooked, bool isIdeal) {
    using namespace verify::lightmap;
    verify::ShadingSetup setup;
    setup.responses = {{{1, 0.8, 0.5}, {0, 0.01, 0.02}}};
    setup.largestResponse = setup.responses[0].norms();
    const verify::layouts::Layout layout = test::layoutOn(cooked);
    const bool isMixed = cooked.map.filter == formats::LightMapFilter::Decoded;
    for (std::size_t t = 0; t < cooked.map.formats.size() && !isIdeal && !isMixed; ++t)
        setup.tolerance.insert(setup.tolerance.end(), cooked.texels.textures[t].size(), verify::toleranceOf(cooked.map.formats[t]));
    const auto perKey = static_cast<float>(1 / cooked.key);
    std::shared_ptr<const MapDecoder> decoder = mapDecoder(layout, perKey);
    if (isMixed) decoder = mixedDecoder(decoder, nullptr);
    const MapRows rows(*decoder, cooked.map, cooked.texels, cooked.reference);
    const SamplerTolerance tolerance(rows, setup.tolerance);
    const BoundEvaluator evaluator(setup, perKey);
    const QuadCoarseBound coarseBound(rows, tolerance, evaluator);
    EXPECT_TRUE(coarseBound.isKnown()) << cooked.map.layout;
    LargestBounds exceedsAll;
    exceedsAll.diffuse.bound = exceedsAll.specular.bound = std::numeric_limits<double>::max();
    Compared compared;
    std::vector<TexelLengths> upper, lower;
    rows.forEachPairOfRows(0, kQuadsHeight, [&](const auto& above, const auto& below, int y) {
        if (y == 0) coarseBound.measure(above, y, upper);
        coarseBound.measure(below, y + 1, lower);
        for (int x = 0; x + 1 < kQuadsWidth; ++x) {
            if (!rows.isQuad(above, below, x)) continue;
            const auto corners = rows.cornersOf(above, below, x);
            ErrorBound refined;
            for (int corner = 0; corner < 4; ++corner) refined.raise(refinedBound(rows, tolerance, evaluator, corners, x, y, corner));
            // With every refinement, and with none.
            for (const LargestBounds& largest : {LargestBounds{}, exceedsAll}) {
                const ErrorBound coarse = coarseBound.bound(largest, corners, {&upper[index(x)], &lower[index(x)]}, x, y).bound;
                ++compared.quads;
                compared.below += !(coarse.diffuse >= refined.diffuse) || !(coarse.specular >= refined.specular);
                if (largest.diffuse.bound == 0 && refined.diffuse > 0)
                    compared.ratios.push_back(static_cast<double>(coarse.diffuse / refined.diffuse));
            }
        }
        std::swap(upper, lower);
    });
    return compared;
}

TEST(LightMapCoarseBound, IsNeverBelowTheRefinedBound) {
    Random random(31);
    for (const LightMapLayout layout : test::layoutsOfEveryFamily())
        for (const synthetic::Kind kind : {synthetic::Kind::Gradient, synthetic::Kind::NegativeBands}) {
            test::Cooked cooked = test::cook(synthetic::makeBand(kind, kQuadsWidth, 0, kQuadsHeight), layout, formats::Target::Bc, 1);
            for (int round = 0; round < (kind == synthetic::Kind::Gradient ? 1 : 2); ++round) {
                for (const bool isIdeal : {true, false}) {
                    const Compared compared = compare(cooked, isIdeal);
                    EXPECT_GT(compared.quads, 100);
                    EXPECT_EQ(compared.below, 0) << cooked.map.layout << ", round " << round << (isIdeal ? ", ideal" : "");
                }
                scramble(cooked, random);
            }
        }
}

TEST(LightMapCoarseBoundSoak, IsNotFarAboveTheRefinedBound) {
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts()) {
        // Their refined bound is exact, not one by lengths, and much smaller.
        if (layout.decodeDegree == 0) continue;
        const test::Cooked cooked =
            test::cook(synthetic::makeBand(synthetic::Kind::Gradient, kQuadsWidth, 0, kQuadsHeight), layout.id, formats::Target::Bc, 1);
        Compared compared = compare(cooked, false);
        std::ranges::sort(compared.ratios);
        EXPECT_LT(compared.ratios[compared.ratios.size() / 2], 6) << cooked.map.layout;
    }
}

}  // namespace
}  // namespace lightcook
