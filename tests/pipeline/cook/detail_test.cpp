// Detail of light maps: tiles that are stored once more, in a finer layout.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "formats/light_map.h"
#include "formats/light_map_detail.h"
#include "pipeline/assets/light_map/detail.h"
#include "pipeline/assets/light_map/detailed_layout.h"
#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;
using Kind = verify::TileErrors::Kind;

/// Light whose colour and direction jump from texel to texel in a part of the map, and change slowly elsewhere.
glm::vec3 patchy(const glm::dvec3& direction, const glm::dvec2& place) {
    const bool isRough = place.y > 0.4 && place.y < 0.55;
    const double turn = isRough ? 40 * std::sin(151 * place.x + 977 * place.y) : 0.5 * place.x;
    const glm::dvec3 towards = glm::normalize(glm::dvec3(std::cos(turn), std::sin(turn), 0.8));
    const double light = std::pow(std::max(0.0, glm::dot(direction, towards)), 6);
    const glm::dvec3 colour =
        isRough ? glm::dvec3(0.5 + 0.5 * std::sin(37 * turn), 0.4, 0.5 - 0.3 * std::sin(37 * turn)) : glm::dvec3(1, 0.8, 0.6);
    return glm::vec3(light * colour + glm::dvec3(0.2, 0.25, 0.3));
}

class SceneDetail : public testing::Test {
protected:
    static constexpr int kRows = 288;

    Outcome cook(const std::string& output) const {
        scene_.writeSceneFile(output);
        return cookScene(scene_.options(), RunState());
    }
    Json map() const { return readManifest(scene_.options().output)->at("assets").at(0); }
    static std::string firstError(const Outcome& outcome) { return outcome.errors.empty() ? "" : outcome.errors.front().line(); }
    static const Json& rowOf(const Outcome& outcome) { return outcome.report.at("assets").at(0); }
    static double visibleOf(const Outcome& outcome) {
        double largest = 0;
        for (const char* kind : {"diffuse", "specular"})
            largest = std::max(largest, rowOf(outcome).at("stages").back().at("error").at(kind).at("visible").at("p99").get<double>());
        return largest;
    }
    /// Returns the light of each texel of the map that was cooked last.
    std::vector<lighting::ShRgb> light() const {
        const std::filesystem::path file = scene_ / "seen.exr";
        EXPECT_TRUE(reconstructLightMap(scene_.options().output, "map", file, 1, RunState()));
        const auto reader = formats::LightMapReader::open(file, {});
        if (!reader) return {};
        const auto strip = reader->read(0, kRows);
        if (!strip) return {};
        return strip->sh.texels();
    }

    SmallScene scene_{SmallScene::Parts::LightMap, patchy, kRows};
};

TEST_F(SceneDetail, BringsAMapWithinItsLimitInFewerBytesThanTheFinerLayout) {
    const Outcome coarse = cook("light_map_layout = \"basis-4\""), fine = cook("light_map_layout = \"lit\"");
    ASSERT_EQ(firstError(coarse), "");
    const double limit = 0.5 * (visibleOf(coarse) + visibleOf(fine));
    ASSERT_LT(visibleOf(fine), limit);
    const Outcome detailed = cook(fmt::format("light_map_layout = \"basis-4\"\ndetail = true\nmax_visible = {}", limit));
    ASSERT_EQ(firstError(detailed), "");
    EXPECT_LE(visibleOf(detailed), limit);
    const Json cooked = map();
    const Json& detail = cooked.at("detail");
    EXPECT_EQ(detail.at("layout"), "lit");
    EXPECT_LT(detail.at("tiles").get<int>(), 2 * kRows / formats::kCoverageRows / 2) << "where the light jumps, and hardly anywhere else";
    EXPECT_LT(rowOf(detailed).at("bytes_gpu"), rowOf(fine).at("bytes_gpu"));
    EXPECT_EQ(rowOf(detailed).at("choice"), fmt::format("basis-4+lit@{:.6g}", limit));
    std::map<std::string, int> layers;
    for (const Json& texture : cooked.at("textures")) layers[texture.at("role")] = texture.at("layers");
    EXPECT_EQ(layers["coverage"], 2);
    EXPECT_EQ(layers["detail_hdr"], 2);
    EXPECT_EQ(layers["detail_ldr"], 9);
}

TEST_F(SceneDetail, HasTheLightOfTheFinerLayoutInItsTilesAndThatOfTheMapElsewhere) {
    for (const char* target : {"bc", "astc", "float"}) {
        const std::string output = fmt::format("target = \"{}\"\nmax_visible = 1000\nlight_map_layout = ", target);
        ASSERT_EQ(firstError(cook(output + "\"lit-half\"")), "");
        const auto coarse = light();
        ASSERT_EQ(firstError(cook(output + "\"lit\"")), "");
        const auto fine = light();
        const Outcome alone = cook(output + "\"lit-half\"");
        const double limit = 0.7 * visibleOf(alone);
        const Outcome outcome =
            cook(fmt::format("target = \"{}\"\ndetail = true\nmax_visible = {}\nlight_map_layout = \"lit-half\"", target, limit));
        ASSERT_EQ(firstError(outcome), "") << target;
        const auto found = light();
        std::set<std::size_t> detailed;
        for (std::size_t i = 0; i < found.size(); ++i) {
            if (found[i] == coarse[i]) continue;
            EXPECT_EQ(found[i], fine[i]) << target << ", texel " << i;
            const std::size_t x = i % SmallScene::kWidth, y = i / SmallScene::kWidth;
            detailed.insert(y / formats::kCoverageRows * 2 + x / formats::kCoverageColumns);
        }
        EXPECT_EQ(detailed.size(), map().at("detail").at("tiles").get<std::size_t>()) << target;
    }
}

TEST_F(SceneDetail, IsChosenByAutoWhereItIsSmaller) {
    const Outcome coarse = cook("light_map_layout = \"lit-quarter\"");
    const double limit = 0.6 * visibleOf(coarse);
    const std::string output = fmt::format("max_visible = {}\nlayouts = [\"lit-quarter\", \"lit\"]", limit);
    const Outcome without = cook(output + "\ndetail = false"), with = cook(output);
    ASSERT_EQ(firstError(without), "");
    ASSERT_EQ(firstError(with), "");
    EXPECT_EQ(rowOf(without).at("layout"), "lit");
    EXPECT_FALSE(rowOf(without).contains("choice"));
    EXPECT_EQ(rowOf(with).at("layout"), "lit-quarter");
    EXPECT_LE(visibleOf(with), limit);
    EXPECT_LT(rowOf(with).at("bytes_gpu"), rowOf(without).at("bytes_gpu"));
    const auto& candidates = rowOf(with).at("trial_candidates");
    EXPECT_TRUE(std::ranges::any_of(candidates, [&](const Json& each) { return each.at("layout") == rowOf(with).at("choice"); }));
    // A list without lit leaves detail out.
    EXPECT_THAT(firstError(cook(fmt::format("max_visible = {}\nlayouts = [\"lit-quarter\"]", limit))), HasSubstr("max_visible"));
}

TEST_F(SceneDetail, IsNotStoredWhereTheMapKeepsTheLimitWithoutIt) {
    ASSERT_EQ(firstError(cook("light_map_layout = \"basis-4\"\ndetail = true\nmax_visible = 1000")), "");
    EXPECT_FALSE(map().contains("detail"));
}

TEST_F(SceneDetail, IsRefusedWhereNothingWouldUseIt) {
    EXPECT_THAT(firstError(cook("light_map_layout = \"basis-4\"\ndetail = true")), HasSubstr("no max_visible"));
    EXPECT_THAT(firstError(cook("light_map_layout = \"lit\"\ndetail = true\nmax_visible = 5")), HasSubstr("fewer bits than lit"));
    EXPECT_THAT(firstError(cook("light_map_layout = \"godot\"\ndetail = true\nmax_visible = 5")), HasSubstr("decoded before the filter"));
    EXPECT_THAT(firstError(cook("light_map_layout = \"ratio\"\nfilter = \"hardware\"\ndetail = true\nmax_visible = 5")),
                HasSubstr("decoded before the filter"));
    EXPECT_THAT(firstError(cook("light_map_layout = \"basis-4\"\ndetail = true\nmax_visible = 0.001")), HasSubstr("detail in every tile"));
    EXPECT_THAT(firstError(cook("light_map_layout = \"lit-half\"\nmips = true\ndetail = true\nmax_visible = 5")),
                HasSubstr("levels above"));
    EXPECT_THAT(firstError(cook("light_map_layout = \"basis-4\"\nmax_fetches = 48\ndetail = true\nmax_visible = 5")),
                HasSubstr("within the limits"));
}

/// Bands of a map in any order count as a whole map does, and take the memory of their tiles alone.
TEST(TileErrors, RunsAreMergedWhereTheyTouch) {
    const auto band = [](std::size_t first, std::size_t count, float error) {
        verify::TileErrors tiles({1.0f, 2.0f}, first, count);
        for (std::size_t tile = first; tile < first + count; ++tile) tiles.add(tile, Kind::Specular, {&error, 1});
        return tiles;
    };
    verify::TileErrors all;
    for (const auto& each : {band(40, 10, 1.5f), band(0, 10, 3.0f), band(20, 15, 1.5f), band(34, 7, 3.0f), band(1000000, 1, 3.0f)})
        all.merge(each);
    const auto over = [&](std::size_t tile, std::size_t limit) { return all.over(tile, Kind::Specular, limit); };
    for (const std::size_t outside : {10, 19, 50, 999999, 1000001}) EXPECT_EQ(over(outside, 0), 0) << outside;
    EXPECT_EQ(over(0, 1), 1);
    EXPECT_EQ(over(20, 0), 1);
    EXPECT_EQ(over(20, 1), 0);
    for (const std::size_t both : {34, 40}) EXPECT_EQ(over(both, 0), 2) << both;
    for (const std::size_t both : {34, 40}) EXPECT_EQ(over(both, 1), 1) << both;
    EXPECT_EQ(over(49, 0), 1);
    EXPECT_EQ(over(1000000, 1), 1);
    EXPECT_EQ(all.over(0, Kind::Diffuse, 0), 0);
}

/// Errors of three tiles: of ten samples each, so many over the limit in the map and under detail.
TEST(TilesWithin, TakesTheFewestThatBringTheMapToItsLimit) {
    const auto stageOf = [](const std::vector<int>& over) {
        verify::LightMapErrors::Stage stage{"", {}, {}, verify::TileErrors({1.0f, 2.0f}, 0, over.size())};
        for (std::size_t tile = 0; tile < over.size(); ++tile)
            for (int i = 0; i < 100; ++i) {
                const float error = i < over[tile] ? 1.5f : 0.5f;
                stage.tiles.add(tile, Kind::Diffuse, {&error, 1});
                stage.errors.visibleDiffuse.add({&error, 1});
            }
        return stage;
    };
    const auto map = stageOf({0, 60, 5, 30, 1}), detail = stageOf({0, 1, 0, 2, 1});
    // 500 samples, of which 4.75 may be over.
    EXPECT_EQ(tilesWithin({map, detail, 0}, 5), (std::vector<std::uint32_t>{1, 2, 3}));
    EXPECT_EQ(tilesWithin({map, detail, 1}, 5), std::vector<std::uint32_t>()) << "none is over 2";
    const auto poor = stageOf({0, 59, 5, 29, 1});
    EXPECT_EQ(tilesWithin({map, poor, 0}, 5), std::nullopt);
    EXPECT_EQ(tilesWithin({stageOf({2, 0, 1, 0, 1}), detail, 0}, 5), std::vector<std::uint32_t>()) << "4 of 500 are over";
}

TEST(DetailAtlas, HoldsItsTiles) {
    for (const int tiles : {1, 2, 3, 255, 256, 70000, formats::kMostDetailTiles}) {
        const formats::DetailAtlas atlas{tiles};
        EXPECT_GE(atlas.columns() * atlas.rows(), tiles);
        EXPECT_LT(atlas.columns() * (atlas.rows() - 1), tiles) << "no row is empty";
        EXPECT_LE(atlas.columns(), 256);
        EXPECT_LE(std::max(atlas.width(), atlas.height()), 16384);
    }
}

TEST(DetailedLayout, HasANameThatIsReadBack) {
    for (const DetailedLayout& each : {DetailedLayout{"basis-4"}, DetailedLayout{"lit-half", 5}, DetailedLayout{"basis-12", 2.82843}}) {
        const DetailedLayout read = DetailedLayout::ofName(each.name());
        EXPECT_EQ(read.layout, each.layout);
        EXPECT_EQ(read.limit, each.limit);
    }
    EXPECT_EQ((DetailedLayout{"basis-4", 5}.name()), "basis-4+lit@5");
}

}  // namespace
}  // namespace lightcook::pipeline
