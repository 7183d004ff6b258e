// Light maps of quads whose pages, charts and memory are known.
#include "pipeline/estimate/estimate.h"

#include <gmock/gmock.h>

#include "formats/pixel_format.h"
#include "pipeline/cook/cook.h"
#include "pipeline/estimate/cook_rates.h"
#include "pipeline/graph/work_rates.h"
#include "tests/formats/gltf/quad_scene.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using formats::LightMapLayout;
using formats::Quad;
using testing::HasSubstr;

/// Quads of side 1 in a glTF.
class EstimateOfQuads : public testing::Test {
protected:
    void add(const Quad& quad) { quads_.add(quad); }
    EstimateOptions options(double density) const {
        quads_.write(folder_ / "quads.glb");
        EstimateOptions options;
        options.meshes = {folder_ / "quads.glb"};
        options.texelDensity = density;
        options.rates = folder_ / kRatesName;
        return options;
    }
    static Estimate estimateOf(const EstimateOptions& options) {
        const RunState state;
        auto estimate = estimateLightMaps(options, state);
        EXPECT_TRUE(estimate) << estimate.error().line();
        return estimate.value_or(Estimate{});
    }
    static const EstimatedLayout& layoutOf(const Estimate& estimate, LightMapLayout layout) {
        return *std::ranges::find(estimate.layouts, std::string(info(layout).name), &EstimatedLayout::layout);
    }
    static const EstimatedPart& partOf(const Estimate& estimate, const std::string& node) {
        return *std::ranges::find_if(estimate.parts,
                                     [&](const EstimatedPart& part) { return part.name.find("'" + node + "'") != std::string::npos; });
    }

    formats::TemporaryFolder folder_;
    formats::QuadScene quads_;
};

TEST_F(EstimateOfQuads, TheSideIsThatOfTheDensity) {
    add({"floor"});
    const Estimate estimate = estimateOf(options(100));
    ASSERT_EQ(estimate.pages.size(), 1u);
    EXPECT_EQ(estimate.pages[0].width, 100);
    EXPECT_EQ(estimate.pages[0].height, 100);
    EXPECT_NEAR(*estimate.parts.at(0).density, 100, 1e-9);
    EXPECT_EQ(layoutOf(estimate, LightMapLayout::Raw).bytesGpu, 9u * 8 * 100 * 100);
    EXPECT_EQ(layoutOf(estimate, LightMapLayout::Flat).bytesGpu, formats::bytesPerImage(formats::PixelFormat::Bc6hUf16, 100, 100));
    EXPECT_EQ(estimate.layouts.size(), formats::allLightMapLayouts().size());
    EXPECT_TRUE(estimate.errors.empty());
    // UVs that take a quarter of the image: the rest of it is paid for too.
    quads_ = {};
    add({"floor", {0, 0}, {0.5, 0.5}});
    EXPECT_EQ(estimateOf(options(100)).pages.at(0).width, 200);
}

TEST_F(EstimateOfQuads, NodesShareAnImageUnlessTheirUvsLieOverEachOther) {
    add({"left", {0, 0}, {0.48, 0.96}});
    add({"right", {0.52, 0}, {1, 0.96}});
    const Estimate shared = estimateOf(options(50));
    EXPECT_EQ(shared.uvs, UvUse::Shared);
    EXPECT_EQ(shared.pages.size(), 1u);
    EXPECT_FALSE(shared.parts.at(0).side);

    quads_ = {};
    for (const char* name : {"a", "b", "c", "d"}) add({name});
    const Estimate each = estimateOf(options(50));
    EXPECT_EQ(each.uvs, UvUse::Each);
    EXPECT_EQ(each.parts.at(0).side, 52);
    ASSERT_EQ(each.pages.size(), 1u);
    EXPECT_EQ(each.texels, 52 * (3 * 56 + 52)) << "in a row, with two texels between them and on the grid of blocks";
    EstimateOptions small = options(50);
    small.largestPage = 64;
    EXPECT_EQ(estimateOf(small).pages.size(), 4u);
}

TEST_F(EstimateOfQuads, OverlapIsThatOfThePartThatComesSecond) {
    add({"first", {0, 0}, {0.5, 1}});
    add({"second", {0.46, 0}, {0.96, 1}});
    const Estimate estimate = estimateOf(options(200));
    ASSERT_EQ(estimate.uvs, UvUse::Shared);
    EXPECT_EQ(partOf(estimate, "first").sharedTexels, 0);
    const double side = estimate.pages.at(0).width;
    EXPECT_NEAR(static_cast<double>(partOf(estimate, "second").sharedTexels), 0.04 * side * side, side + 1);
}

TEST_F(EstimateOfQuads, AChartBelowItsPaddingIsSmall) {
    add({"large", {0, 0}, {0.8, 1}});
    add({"small", {0.9, 0.5}, {0.91, 0.51}});
    EstimateOptions given = options(100);
    const Estimate estimate = estimateOf(given);
    EXPECT_EQ(partOf(estimate, "large").smallCharts, 0);
    EXPECT_EQ(partOf(estimate, "small").charts, 1);
    EXPECT_EQ(partOf(estimate, "small").smallCharts, 1);
    const std::int64_t read = partOf(estimate, "small").texels;
    EXPECT_GT(partOf(estimate, "small").paddingTexels, read);
    // Without padding no chart is smaller than it, and the same texels are read.
    given.padding = 0;
    const Estimate without = estimateOf(given);
    EXPECT_EQ(without.paddingTexels, 0);
    EXPECT_EQ(partOf(without, "small").smallCharts, 0);
    EXPECT_EQ(partOf(without, "small").texels, read);
    EXPECT_EQ(without.readTexels, estimate.readTexels);
}

TEST_F(EstimateOfQuads, TexelsOfARectangleWithPaddingAreThoseOfALargerOne) {
    // Edges a quarter of a texel beyond centres: filters read 21 x 41 texels.
    add({"floor", {(10 + 0.25) / 100, (20 + 0.25) / 100}, {(30 - 0.25) / 100, (60 - 0.25) / 100}});
    EstimateOptions given = options(1);
    given.texelDensity = 100 * std::sqrt(19.5 * 39.5) / 100;
    given.padding = 3;
    const Estimate estimate = estimateOf(given);
    ASSERT_EQ(estimate.pages.at(0).width, 100);
    EXPECT_EQ(estimate.readTexels, 22 * 42);
    EXPECT_EQ(estimate.paddingTexels, 25 * 45 - 22 * 42);
}

TEST_F(EstimateOfQuads, AnImageBeyondTheLargestPageIsAnErrorThatSaysWhatFits) {
    add({"floor"});
    EstimateOptions given = options(1000);
    given.largestPage = 512;
    const Estimate estimate = estimateOf(given);
    ASSERT_EQ(estimate.errors.size(), 1u);
    EXPECT_EQ(estimate.errors[0].code, formats::ErrorCode::WrongShape);
    EXPECT_THAT(estimate.errors[0].line(), HasSubstr("1000 x 1000 texels, expected at most 512 x 512"));
    EXPECT_THAT(estimate.errors[0].line(), HasSubstr("at most 512"));
    EXPECT_EQ(estimate.texels, 1000 * 1000);
    EXPECT_EQ(estimate.readTexels, 1000 * 1000);
    given.texelDensity = 512;
    EXPECT_TRUE(estimateOf(given).errors.empty());
}

TEST_F(EstimateOfQuads, TheSmallestLayoutOrTheNamedOneDecidesTheBudget) {
    add({"floor"});
    EstimateOptions given = options(100);
    given.budgetBytes = 20000;
    const Estimate open = estimateOf(given);
    EXPECT_TRUE(open.errors.empty());
    EXPECT_EQ(layoutOf(open, LightMapLayout::Flat).passed, true);
    EXPECT_EQ(layoutOf(open, LightMapLayout::Ratio).passed, false);
    given.layout = LightMapLayout::Ratio;
    const Estimate named = estimateOf(given);
    ASSERT_EQ(named.errors.size(), 1u);
    EXPECT_EQ(named.errors[0].code, formats::ErrorCode::OverBudget);
    EXPECT_EQ(named.layouts.size(), 1u);
    given.budgetBytes = layoutOf(named, LightMapLayout::Ratio).bytesGpu;
    EXPECT_TRUE(estimateOf(given).errors.empty());
}

TEST_F(EstimateOfQuads, SurfacesWithoutUvsCountByTheirArea) {
    add({"floor"});
    add({"wall", {0, 0}, {1, 1}, false});
    const Estimate estimate = estimateOf(options(64));
    EXPECT_EQ(estimate.withoutUvs, 1);
    EXPECT_FALSE(partOf(estimate, "wall").density);
    EXPECT_EQ(partOf(estimate, "wall").texels, 64 * 64);
    EXPECT_GE(estimate.texels, 2 * 64 * 64);
}

TEST_F(EstimateOfQuads, UvsOutsideTheImageAreRefusedByNodeAndTriangle) {
    add({"floor", {0, 0}, {1.5, 1}});
    const RunState state;
    const auto estimate = estimateLightMaps(options(64), state);
    ASSERT_FALSE(estimate);
    EXPECT_THAT(estimate.error().line(), HasSubstr("node 0 'floor', primitive 0"));
    EXPECT_THAT(estimate.error().line(), HasSubstr("expected numbers in [0, 1]"));
}

TEST_F(EstimateOfQuads, TimesAreThoseOfTheLastCookOnThisMachine) {
    const SmallScene scene(SmallScene::Parts::LightMap);  // layout ratio
    CookOptions cooking = scene.optionsWithOwnCache();
    ASSERT_TRUE(cook(cooking).errors.empty());
    add({"floor"});
    EstimateOptions given = options(100);
    given.rates = cooking.cache / kRatesName;
    const Estimate estimate = estimateOf(given);
    const EstimatedLayout &ratio = layoutOf(estimate, LightMapLayout::Ratio), &flat = layoutOf(estimate, LightMapLayout::Flat);
    EXPECT_TRUE(ratio.isMeasuredHere);
    EXPECT_GT(ratio.seconds, 0);
    EXPECT_FALSE(flat.isMeasuredHere);
    EXPECT_DOUBLE_EQ(flat.seconds, measuredSecondsPerMegatexel(LightMapLayout::Flat) * 0.01);
}

}  // namespace
}  // namespace lightcook::pipeline
