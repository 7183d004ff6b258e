// Quads that are settled at a glance: a glance is never under what a closer look finds of the same quad, whatever lies in its texels.
#include "verify/light_map/quad_coarse_bound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/compress/synthetic_light_map.h"
#include "tests/verify/cooked_light_map.h"
#include "verify/error/random.h"
#include "verify/light_map/controls.h"
#include "verify/light_map/zonal.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using verify::Random;
using verify::lightmap::Most;

constexpr int kWidth = 29, kHeight = 21;
constexpr LightMapLayout kLayouts[] = {LightMapLayout::Raw,        LightMapLayout::Flat,   LightMapLayout::Ratio,  LightMapLayout::Luvw,
                                       LightMapLayout::LuvwLinear, LightMapLayout::Zh3,    LightMapLayout::Basis3, LightMapLayout::Basis4,
                                       LightMapLayout::Basis12,    LightMapLayout::Basis16};

/// Texels of no order: anywhere in [0, 1], at its ends, or near each other. Light of any size.
void scramble(test::Cooked& cooked, Random& random) {
    const bool hasLight = cooked.map.layout == "ratio" || cooked.map.layout == "zh3" || cooked.map.layout.starts_with("basis"),
               isLight = cooked.map.layout == "raw" || cooked.map.layout == "flat";
    for (std::size_t texture = 0; texture < cooked.texels.textures.size(); ++texture)
        for (std::size_t layer = 0; layer < cooked.texels.textures[texture].size(); ++layer) {
            for (glm::vec4& texel : cooked.texels.textures[texture][layer].texels()) {
                const double kind = random.next(), size = std::pow(10.0, 4 * random.next() - 3);
                for (int c = 0; c < 4; ++c) {
                    const double value = kind < 0.4   ? random.next()
                                         : kind < 0.6 ? std::floor(2 * random.next())
                                                      : 0.5 + 0.02 * (random.next() - 0.5);
                    const bool scales = isLight || (hasLight && texture == 0);
                    texel[c] = static_cast<float>(scales ? size * value : value);
                }
            }
            for (glm::vec4& span : cooked.texels.spans[texture][layer].texels())
                for (int c = 0; c < 4; ++c) span[c] = static_cast<float>(random.next());
        }
    for (lighting::ShRgb& sh : cooked.reference.sh.texels())
        for (glm::vec3& c : sh)
            for (int i = 0; i < 3; ++i) c[i] *= static_cast<float>(2 * random.next());
}

struct Compared {
    int quads = 0, under = 0;
    std::vector<double> above;  ///< of quads as they come out of the encoder
};

/// The most of what ZonalBounds may find: the bounds of a quad, which it splits as it likes, all of them above what any place has.
template <verify::layouts::Zonal Layout>
Most closerLook(const verify::lightmap::MapRows<Layout>& rows, const verify::lightmap::Liberties<Layout>& liberties,
                const verify::lightmap::BoundJudge& judge, const typename verify::lightmap::MapRows<Layout>::Corners& corners, int x, int y,
                int) {
    using namespace verify::lightmap;
    Worst worst;
    ZonalBounds<Layout>(rows, liberties, judge).bound(corners.texels, corners.references, x, y, worst);
    return {static_cast<float>(kFloor * worst.diffuse.bound), static_cast<float>(kFloor * worst.specular.bound)};
}

/// What QuadBounds' lengths are, under the decode of one corner.
template <class Layout>
Most closerLook(const verify::lightmap::MapRows<Layout>& rows, const verify::lightmap::Liberties<Layout>& liberties,
                const verify::lightmap::BoundJudge& judge, const typename verify::lightmap::MapRows<Layout>::Corners& corners, int x, int y,
                int corner) {
    using namespace verify::lightmap;
    const QuadControls<Layout> quad(corners.texels, corners.references, {}, [&](const auto& t, const LcSh& reference) {
        return difference(rows.decoded(t, x + corner % 2, y + corner / 2), reference);
    });
    const Squares squares = largestSquares(quad.values);
    ChannelSlack slack{};
    addRounding(slack, squares, referenceSquares(corners.references));
    if (!liberties.isNone()) {
        Liberties<Layout>::addFractions(slack, corners.references, squares);
        slack = sumOf(slack, liberties.lengthsOf(liberties.ofQuad(corners.texels, x, y, corner), true));
    }
    BandLengths all{};
    for (std::size_t l = 0; l < 3; ++l)
        for (std::size_t c = 0; c < kChannels; ++c)
            all[3 * l + c] = static_cast<float>(slack[c][l] + outwardLength(squares[l][static_cast<int>(c)]));
    Most most;
    for (std::size_t c = 0; c < kChannels; ++c) most.raise(judge.mostOf(all, c));
    return most;
}

template <class Layout>
Compared compare(const Layout& layout, const test::Cooked& cooked, bool isIdeal) {
    using namespace verify::lightmap;
    verify::ShadingSetup setup;
    setup.responses = {{{1, 0.8, 0.5}, {0, 0.01, 0.02}}};
    setup.largestResponse = setup.responses[0].norms();
    for (std::size_t t = 0; t < cooked.map.formats.size() && !isIdeal; ++t)
        setup.freedom.insert(setup.freedom.end(), cooked.texels.textures[t].size(), verify::freedomOf(cooked.map.formats[t]));
    const auto perKey = static_cast<float>(1 / cooked.key);
    const MapRows<Layout> rows(layout, cooked.map, perKey, cooked.texels, cooked.reference);
    const Liberties<Layout> liberties(rows, setup.freedom);
    const BoundJudge judge(setup, perKey);
    const QuadGlance<Layout> glance(rows, liberties, judge);
    EXPECT_TRUE(glance.isKnown()) << cooked.map.layout;
    Worst settlesAll;
    settlesAll.diffuse.bound = settlesAll.specular.bound = std::numeric_limits<double>::max();
    Compared compared;
    std::vector<TexelLengths> upper, lower;
    rows.forEachPairOfRows(0, kHeight, [&](const auto& above, const auto& below, int y) {
        if (y == 0) glance.measure(above, y, upper);
        glance.measure(below, y + 1, lower);
        for (int x = 0; x + 1 < kWidth; ++x) {
            if (!rows.isQuad(above, below, x)) continue;
            const auto corners = rows.cornersOf(above, below, x);
            Most closer;
            for (int corner = 0; corner < 4; ++corner) closer.raise(closerLook(rows, liberties, judge, corners, x, y, corner));
            // As it is where nothing is settled, and where all is.
            for (const Worst& worst : {Worst{}, settlesAll}) {
                const Most most = glance.look(worst, corners, {&upper[index(x)], &lower[index(x)]}, x, y).most;
                ++compared.quads;
                compared.under += !(most.diffuse >= closer.diffuse) || !(most.specular >= closer.specular);
                if (worst.diffuse.bound == 0 && closer.diffuse > 0)
                    compared.above.push_back(static_cast<double>(most.diffuse / closer.diffuse));
            }
        }
        std::swap(upper, lower);
    });
    return compared;
}

Compared compareAny(const test::Cooked& cooked, bool isIdeal) {
    return std::visit([&](const auto& layout) { return compare(layout, cooked, isIdeal); }, *verify::layouts::layoutOf(cooked.map));
}

TEST(LightMapGlance, IsNeverUnderACloserLook) {
    Random random(31);
    for (const LightMapLayout layout : kLayouts)
        for (const synthetic::Kind kind : {synthetic::Kind::Gradient, synthetic::Kind::NegativeBands}) {
            test::Cooked cooked = test::cook(synthetic::makeBand(kind, kWidth, 0, kHeight), layout, formats::Target::Bc, 1);
            for (int round = 0; round < 6; ++round) {
                for (const bool isIdeal : {true, false}) {
                    const Compared compared = compareAny(cooked, isIdeal);
                    EXPECT_GT(compared.quads, 100);
                    EXPECT_EQ(compared.under, 0) << cooked.map.layout << ", round " << round << (isIdeal ? ", ideal" : "");
                }
                scramble(cooked, random);
            }
        }
}

TEST(LightMapGlance, IsNotFarAboveACloserLook) {
    for (const LightMapLayout layout : kLayouts) {
        // Of these the closer look is a proven bound, far under the lengths that it is made of.
        if (layout == LightMapLayout::LuvwLinear || layout == LightMapLayout::Zh3) continue;
        const test::Cooked cooked =
            test::cook(synthetic::makeBand(synthetic::Kind::Gradient, kWidth, 0, kHeight), layout, formats::Target::Bc, 1);
        Compared compared = compareAny(cooked, false);
        std::ranges::sort(compared.above);
        EXPECT_LT(compared.above[compared.above.size() / 2], 6) << cooked.map.layout;
    }
}

}  // namespace
}  // namespace lightcook
