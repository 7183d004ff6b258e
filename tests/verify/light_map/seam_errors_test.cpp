// Steps of light at edges that charts share, against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "formats/light_map_layout.h"
#include "lighting/area_specular.h"
#include "lighting/display.h"
#include "lighting/radiometry.h"
#include "tests/compress/synthetic_light_map.h"
#include "tests/verify/cooked_light_map.h"
#include "verify/seams.h"

namespace lightcook::verify {
namespace {

using formats::LightMapStrip;

constexpr int kSeamsWidth = 24, kSeamsHeight = 12;
constexpr double kY0 = 0.28209479177387814;

/// Returns constant light with some exit radiance.
lighting::ShRgb constant(const glm::vec3& exit) {
    lighting::ShRgb sh{};
    sh[0] = exit / static_cast<float>(kY0);
    return sh;
}

/// A map with two charts of one plane: columns 1 to 8 and 13 to 20 of rows 1 to 10. Uncovered texels hold no light.
struct TwoCharts {
    LightMapStrip bake{0,
                       {kSeamsWidth, kSeamsHeight},
                       {kSeamsWidth, kSeamsHeight},
                       {kSeamsWidth, kSeamsHeight, glm::vec3(0, 0, 1)},
                       {kSeamsWidth, kSeamsHeight, glm::vec4(1, 0, 0, 1)},
                       {},
                       {},
                       {}};
    DecodedLightMapRows cooked;

    TwoCharts() {
        auto& layers = cooked.textures.emplace_back();
        for (std::size_t i = 0; i < lighting::kShCount; ++i) layers.emplace_back(kSeamsWidth, kSeamsHeight);
    }
    static int chartOf(int x, int y) {
        if (y < 1 || y > 10) return -1;
        return x >= 1 && x <= 8 ? 0 : x >= 13 && x <= 20 ? 1 : -1;
    }
    template <class Light>
    void setBake(Light&& light) {
        forEach([&](int x, int y, int chart) {
            bake.covered.at(x, y) = chart >= 0 ? 1 : 0;
            if (chart >= 0) bake.sh.at(x, y) = light(chart, x, y);
        });
    }
    /// Sets the cooked texels, those outside of charts too (chart -1).
    template <class Light>
    void setCooked(Light&& light) {
        forEach([&](int x, int y, int chart) {
            const lighting::ShRgb sh = light(chart, x, y);
            for (std::size_t i = 0; i < sh.size(); ++i) cooked.textures[0][i].at(x, y) = glm::vec4(sh[i], 1);
        });
    }
    /// The right rim of the first chart meets the left rim of the second, at the corners of their texels, from top to bottom.
    static SplitEdge edge() {
        SplitEdge edge;
        edge.position = {glm::dvec3(0), glm::dvec3(0, 1, 0)};
        edge.normal = {glm::vec3(0, 0, 1), glm::vec3(0, 0, 1)};
        edge.uv[0] = {uv(8.5, 1), uv(8.5, 10)};
        edge.uv[1] = {uv(12.5, 1), uv(12.5, 10)};
        return edge;
    }
    static glm::dvec2 uv(double x, double y) { return (glm::dvec2(x, y) + 0.5) / glm::dvec2(kSeamsWidth, kSeamsHeight); }

private:
    template <class Work>
    static void forEach(Work&& work) {
        for (int y = 0; y < kSeamsHeight; ++y)
            for (int x = 0; x < kSeamsWidth; ++x) work(x, y, chartOf(x, y));
    }
};

/// A verifier of layout raw.
struct Meter {
    Viewing viewing;
    LightMapShading shading;
    double key = 0.7;
    LightMapVerifier verifier;

    explicit Meter(bool hasNormalMaps = false, bool isSpecular = false)
        : shading(shadingOf(hasNormalMaps, isSpecular)), verifier(verifierOf(viewing, shading, key)) {}

    SeamErrors errors(const TwoCharts& charts, const SplitEdge& edge) const {
        const glm::dvec2 size(kSeamsWidth, kSeamsHeight);
        const int count = edge.placeCount(size);
        std::vector<std::vector<lighting::ShRgb>> lights;
        std::vector<LitSeamPlace> places;
        for (int i = 0; i < 2 * count; ++i) lights.emplace_back(verifier.lightCount());
        for (int i = 0; i < count; ++i) {
            const double along = static_cast<double>(i) / (count - 1);
            LitSeamPlace place{0, along, edge.normalAt(along), {}, {}};
            for (std::size_t side = 0; side < 2; ++side) {
                auto& light = lights[2 * static_cast<std::size_t>(i) + side];
                place.texel[side] = edge.texelAt(side, along, size);
                EXPECT_TRUE(verifier.lightAt(charts.cooked, charts.bake, place.texel[side], light));
                place.light[side] = light;
            }
            places.push_back(place);
        }
        return verifier.seamErrors(places);
    }
    double step(const glm::dvec3& a, const glm::dvec3& b) const { return lighting::visibleDifference(a, b, viewing.display); }

private:
    static LightMapShading shadingOf(bool hasNormalMaps, bool isSpecular) {
        LightMapShading shading;
        shading.specular = isSpecular;
        shading.normalCount = hasNormalMaps ? 32 : 1;
        return shading;
    }
    static LightMapVerifier verifierOf(const Viewing& viewing, const LightMapShading& shading, double key) {
        LightMapSampling sampling;
        sampling.figures = LightMapFigures::Sampled;
        CookedLightMap map{"raw", {{"range", {1.0f}}}, kSeamsWidth, kSeamsHeight};
        return std::move(*LightMapVerifier::create(map, shading, sampling, key, viewing));
    }
};

const glm::vec3 kGrey(0.4f), kBright(0.5f, 0.45f, 0.4f), kDark(0.1f, 0.2f, 0.3f);

TEST(SeamErrors, ChartsOfDifferentCookedLightHaveTheStepOfTheirColours) {
    TwoCharts charts;
    charts.setBake([](int, int, int) { return constant(kGrey); });
    charts.setCooked([](int, int x, int) { return constant(x < 11 ? kGrey : kBright); });
    const Meter meter;
    const SeamErrors errors = meter.errors(charts, TwoCharts::edge());
    const double step = meter.step(kGrey, kBright);
    ASSERT_EQ(errors.stages.size(), 1u);
    const auto& diffuse = errors.stages.back().diffuse;
    EXPECT_EQ(diffuse.added.sampleCount(), 10);
    EXPECT_NEAR(diffuse.cooked.largest(), step, 1e-3 * step);
    EXPECT_NEAR(diffuse.added.largest(), step, 1e-3 * step);
    EXPECT_NEAR(errors.bakeDiffuse.largest(), 0, 1e-4);
    EXPECT_EQ(errors.stages.back().specular.cooked.sampleCount(), 0);
    ASSERT_EQ(errors.worstDiffuse.size(), 1u);
    const SeamStep& worst = errors.worstDiffuse.front();
    EXPECT_NEAR(worst.added, step, 1e-3 * step);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(worst.bake[1][c], static_cast<double>(kGrey[c]), 1e-5);
        EXPECT_NEAR(worst.cooked[0][c], static_cast<double>(kGrey[c]), 1e-5);
        EXPECT_NEAR(worst.cooked[1][c], static_cast<double>(kBright[c]), 1e-5);
    }
    EXPECT_DOUBLE_EQ(worst.texel[0].x, 8.5);
    EXPECT_DOUBLE_EQ(worst.texel[1].x, 12.5);
}

TEST(SeamErrors, TheFilterReachesTexelsOutsideOfCharts) {
    // At the rim the filter shows half of the padding: black padding darkens both sides, and black on one side alone is a seam.
    TwoCharts charts;
    charts.setBake([](int, int, int) { return constant(kGrey); });
    charts.setCooked([](int chart, int x, int) { return constant(chart < 0 && x < 11 ? glm::vec3(0) : kGrey); });
    const Meter meter;
    const double step = meter.step(kGrey, 0.5f * kGrey);
    SplitEdge edge = TwoCharts::edge();
    // The padding above and below reaches no place in rows 2 to 9.
    EXPECT_NEAR(meter.errors(charts, edge).stages.back().diffuse.added.largest(), step, 1e-3 * step);
    // Inside the chart the padding is out of reach.
    edge.uv[0] = {TwoCharts::uv(8, 1), TwoCharts::uv(8, 10)};
    EXPECT_NEAR(meter.errors(charts, edge).stages.back().diffuse.added.largest(), 0, 1e-4);
}

TEST(SeamErrors, ASeamOfTheBakeIsNotAdded) {
    TwoCharts charts;
    charts.setBake([](int chart, int, int) { return constant(chart == 0 ? kGrey : kDark); });
    const Meter meter;
    const double ofBake = meter.step(kGrey, kDark);
    const auto added = [&](const glm::vec3& left, const glm::vec3& right) {
        charts.setCooked([&](int, int x, int) { return constant(x < 11 ? left : right); });
        const SeamErrors errors = meter.errors(charts, TwoCharts::edge());
        EXPECT_NEAR(errors.bakeDiffuse.largest(), ofBake, 1e-3 * ofBake);
        EXPECT_NEAR(errors.worstBakeDiffuse.bakeStep, ofBake, 1e-3 * ofBake);
        EXPECT_NEAR(errors.stages.back().diffuse.cooked.largest(), meter.step(left, right), 1e-3 * ofBake);
        return errors.stages.back().diffuse.added.largest();
    };
    EXPECT_NEAR(added(kGrey, kDark), 0, 1e-3 * ofBake) << "the same step";
    EXPECT_EQ(added(kGrey, kGrey), 0) << "a smaller one";
    EXPECT_NEAR(added(kBright, kDark), meter.step(kBright, kDark) - ofBake, 1e-3 * ofBake) << "a larger one";
}

TEST(SeamErrors, RotatedAndMirroredChartsAreReadAlongTheEdge) {
    // Light rises along the edge. The second chart is mirrored, or rotated by a quarter: its texels hold the same light at the same place.
    const auto light = [](double along) { return constant(glm::vec3(static_cast<float>(0.2 + 0.05 * along))); };
    const Meter meter;
    TwoCharts mirrored, rotated;
    const auto set = [](TwoCharts& charts, auto&& lightOf) {
        charts.setBake(lightOf);
        charts.setCooked([&](int, int x, int y) { return lightOf(x < 11 ? 0 : 1, x, y); });
    };
    set(mirrored, [&](int chart, int, int y) { return light(chart == 0 ? y : 11 - y); });
    set(rotated, [&](int chart, int x, int y) { return light(chart == 0 ? y : x - 12); });
    SplitEdge right = TwoCharts::edge(), up = right;
    right.uv[1] = {TwoCharts::uv(12.5, 10), TwoCharts::uv(12.5, 1)};
    up.uv[0] = {TwoCharts::uv(8.5, 1), TwoCharts::uv(8.5, 8)};
    up.uv[1] = {TwoCharts::uv(13, 0.5), TwoCharts::uv(20, 0.5)};
    for (const auto& [charts, edge] : {std::pair(&mirrored, right), std::pair(&rotated, up)}) {
        const SeamErrors errors = meter.errors(*charts, edge);
        EXPECT_LT(errors.bakeDiffuse.largest(), 1e-3);
        EXPECT_LT(errors.stages.back().diffuse.cooked.largest(), 1e-3);
    }
    EXPECT_GT(meter.errors(mirrored, TwoCharts::edge()).stages.back().diffuse.cooked.largest(), 1) << "read the wrong way round";
}

TEST(SeamErrors, DirectionsCountWhereNormalMapsAndViewsShowThem) {
    // Both sides are as bright at the normal; linear light across it differs.
    const auto light = [](float across) {
        lighting::ShRgb sh = constant(kGrey);
        sh[3] = glm::vec3(across);
        return sh;
    };
    TwoCharts charts;
    charts.setBake([&](int, int, int) { return light(0.3f); });
    charts.setCooked([&](int, int x, int) { return light(x < 11 ? 0.3f : -0.3f); });
    EXPECT_LT(Meter(false).errors(charts, TwoCharts::edge()).stages.back().diffuse.added.largest(), 1e-3);
    const Meter meter(true, true);
    const SeamErrors errors = meter.errors(charts, TwoCharts::edge());
    // The worst normal, by the definition of the visible error's samples.
    const SeamStep& worst = errors.worstDiffuse.front();
    const auto exit = [&](float across) {
        return glm::dvec3(lighting::lambertExitRadiance(light(across), glm::vec3(worst.normal), glm::vec3(1)).value);
    };
    EXPECT_NEAR(worst.added, meter.step(exit(0.3f), exit(-0.3f)), 1e-3 * worst.added);
    EXPECT_GT(std::acos(worst.normal.z), 0.6) << "towards the rim of the cap";
    EXPECT_GT(errors.stages.back().specular.added.largest(), 1);
    EXPECT_NE(errors.worstSpecular.front().view, glm::dvec3(0));
}

TEST(SeamErrors, PlacesWithoutLightAreNotMeasured) {
    TwoCharts charts;
    charts.setBake([](int, int, int) { return constant(kGrey); });
    charts.setCooked([](int, int, int) { return constant(kGrey); });
    const Meter meter;
    std::vector<lighting::ShRgb> light(meter.verifier.lightCount());
    EXPECT_FALSE(meter.verifier.lightAt(charts.cooked, charts.bake, {10.5, 5}, light));
    EXPECT_FALSE(meter.verifier.lightAt(charts.cooked, charts.bake, {9.5, 5}, light));
    EXPECT_TRUE(meter.verifier.lightAt(charts.cooked, charts.bake, {8.9, 5}, light));
}

TEST(SeamErrors, MergingKeepsOneEntryForEachEdge) {
    TwoCharts charts;
    charts.setBake([](int, int, int) { return constant(kGrey); });
    charts.setCooked([](int, int x, int y) { return constant(x < 11 ? kGrey : (1 + 0.02f * static_cast<float>(y)) * kGrey); });
    const Meter meter;
    SeamErrors part = meter.errors(charts, TwoCharts::edge()), whole = meter.verifier.noSeamErrors();
    whole.merge(part);
    part.worstDiffuse.front().edge = 1;
    part.worstDiffuse.front().added *= 2;
    whole.merge(part);
    whole.merge(part);
    EXPECT_EQ(whole.stages.back().diffuse.added.sampleCount(), 30);
    ASSERT_EQ(whole.worstDiffuse.size(), 2u);
    EXPECT_EQ(whole.worstDiffuse[0].edge, 1u);
    EXPECT_EQ(whole.worstDiffuse[1].edge, 0u);
}

/// Light of a place is what reconstruct decodes there, for every layout, and its bake that of the covered texels.
TEST(SeamErrors, LightAtAPlaceIsThatOfTheShader) {
    for (const formats::LightMapLayout layout : test::kEveryLayout) {
        const auto cooked =
            test::cook(synthetic::makeBand(synthetic::Kind::Gradient, kSeamsWidth, 0, kSeamsHeight), layout, formats::Target::Bc, 0);
        const LightMapVerifier verifier = cooked.verifier();
        constexpr int kPlaces = 3;
        const auto decoded = verifier.reconstruct(cooked.texels, 0, kSeamsHeight, kPlaces, &cooked.reference);
        std::vector<lighting::ShRgb> light(verifier.lightCount());
        for (int y = kPlaces; y < kPlaces * (kSeamsHeight - 1); y += 5)
            for (int x = kPlaces; x < kPlaces * (kSeamsWidth - 1); x += 4) {
                const glm::dvec2 at((x + 0.5) / kPlaces - 0.5, (y + 0.5) / kPlaces - 0.5);
                if (cooked.reference.covered.at(x / kPlaces, y / kPlaces) == 0) continue;
                ASSERT_TRUE(verifier.lightAt(cooked.texels, cooked.reference, at, light));
                for (std::size_t i = 0; i < light.back().size(); ++i)
                    for (int c = 0; c < 3; ++c)
                        ASSERT_NEAR(static_cast<double>(light.back()[i][c]) * cooked.key, static_cast<double>(decoded.at(x, y)[i][c]),
                                    1e-4 * cooked.key)
                            << formats::info(layout).name << " " << x << " " << y << " " << i;
            }
    }
}

}  // namespace
}  // namespace lightcook::verify
