// A cook that splits the charts of a light map among maps: each gets the layout that its charts need.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <set>

#include "formats/gltf_scene.h"
#include "formats/plain_image.h"
#include "pipeline/assets/light_map/layout_choice.h"
#include "pipeline/assets/light_map/unpacked_bake.h"
#include "pipeline/assets/preview.h"
#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "tests/pipeline/repack/charts_cook.h"
#include "tests/pipeline/rewritten_manifest.h"
#include "tests/pipeline/small_scene.h"
#include "tests/pipeline/walls.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::ErrorCode;
using testing::HasSubstr;
using testing::Not;

constexpr int kSide = 64;

/// Light of a chart, at a texel.
using ChartLight = lighting::ShRgb (*)(int x, int y);

lighting::ShRgb constantLight(int, int) {
    return shOf(sunAndSky, {0.5, 0.5});
}
/// Light that changes over hundreds of texels.
lighting::ShRgb smoothLight(int x, int y) {
    return shOf(sunAndSky, {0.5 + 0.001 * x, 0.5 + 0.001 * y});
}
/// A lattice of shadows, whose light has another direction in each of its cells.
lighting::ShRgb hardLight(int x, int y) {
    const int cell = (x / 3 + 5 * (y / 3)) % 7;
    lighting::ShRgb sh = shOf(sunAndSky, {0.1 * cell, 1 - 0.1 * cell});
    for (std::size_t i = 0; i < sh.size(); ++i) sh[i] *= (cell % 2 != 0 ? 0.05f : 1.0f) * (i > 0 && cell % 3 == 0 ? -1.0f : 1.0f);
    return sh;
}

/// Hard light below the first row of tiles of a chart, smooth light above it.
lighting::ShRgb halfHardLight(int x, int y) {
    return y < 34 ? smoothLight(x, y) : hardLight(x, y);
}

class SplitCook : public ChartsCook {
protected:
    SplitCook() {
        writeWalls(folder_ / "", {.leftUvs = {0.05f, 0.05f, 0.05f, 0.95f, 0.45f, 0.95f, 0.45f, 0.05f},
                                  .rightUvs = {0.55f, 0.05f, 0.55f, 0.95f, 0.95f, 0.95f, 0.95f, 0.05f},
                                  .right = {3, 7, 0, 3, 0, 0, 5, 0, 0, 5, 7, 0}});
    }
    /// left, right  light of the two charts
    void writeMap(ChartLight left, ChartLight right) const {
        formats::Image<lighting::ShRgb> sh(kSide, kSide, lighting::ShRgb{});
        formats::Image<std::uint8_t> covered(kSide, kSide, 0);
        formats::Image<glm::vec3> normal(kSide, kSide, glm::vec3(0, 0, 1));
        for (int y = 3; y < kSide - 3; ++y)
            for (int x = 3; x < kSide - 3; ++x) {
                if (x >= 29 && x < 35) continue;
                covered.at(x, y) = 1;
                sh.at(x, y) = x < 32 ? left(x, y) : right(x, y);
            }
        auto writer = formats::LightMapWriter::create(folder_ / "map.exr", kSide, kSide, formats::SurfaceOutput::CoverageAndNormals);
        ASSERT_TRUE(writer && writer->append(sh.view(), {covered.view(), normal.view()}) && writer->commit());
    }
    /// output  lines of [output]; map  lines of [[light_map]]
    void writeScene(const std::string& output, const std::string& map = "mesh = \"walls.gltf\"\n") const {
        formats::writeContent(options_.scene, "schema = 1\nname = \"walls\"\n[output]\n" + output +
                                                  "\n[[light_map]]\nname = \"map\"\nfile = \"map.exr\"\n" + map +
                                                  "[[material]]\nname = \"*\"\nnormal_map = true\nspecular = false\n");
    }
    Json cooked(const std::string& output) const {
        writeScene(output);
        return reportOf(cookScene(options_, RunState()));
    }
    static std::uint64_t bytesOf(const Json& report) { return report.at("budget").at("used_bytes").get<std::uint64_t>(); }
    static double visibleOf(const Json& asset) {
        return asset.at("stages").back().at("error").at("diffuse").at("visible").at("p99").get<double>();
    }
    /// Expects verification to find the errors of the cook, and returns its report.
    Json expectVerifiedAs(const Json& report) const {
        Json again = verified();
        for (const char* name : {"map", "map_fine"})
            EXPECT_EQ(assetOf(report, name).at("stages").back().at("error"), assetOf(again, name).at("stages").back().at("error")) << name;
        return again;
    }
    formats::GltfScene meshOf(const std::string& file) const {
        auto scene = formats::GltfScene::load(options_.output / file);
        EXPECT_TRUE(scene) << scene.error().line();
        return std::move(*scene);
    }
};

constexpr const char* kSplit = "charts = \"split\"\nmax_visible = 3";

using SplitCookSoak = SplitCook;
TEST_F(SplitCookSoak, ChartsWithHardLightGetAMapOfTheirOwn) {
    writeMap(smoothLight, hardLight);
    const Json packed = cooked("charts = \"pack\"\nmax_visible = 3");
    const Json report = cooked(kSplit);
    const Json *map = findAsset(report, "map"), *fine = findAsset(report, "map_fine");
    ASSERT_TRUE(map != nullptr && fine != nullptr) << assetOf(report, "map").at("notes").dump();
    EXPECT_LT(map->at("bits_per_texel").get<double>(), fine->at("bits_per_texel").get<double>());
    EXPECT_LT(bytesOf(report), bytesOf(packed));
    for (const Json* each : {map, fine}) {
        EXPECT_LE(visibleOf(*each), 3) << each->at("name");
        EXPECT_LT(each->at("width").get<int>(), kSide) << each->at("name");
        EXPECT_FALSE(each->at("notes").contains("unread_texels")) << "texels of the other chart are no fault";
    }
    EXPECT_THAT(map->at("notes").at("split").get<std::string>(), HasSubstr("50.0 % of the texels in a map of their own"));
    EXPECT_FALSE(hasAsset(packed, "map_fine"));
    EXPECT_EQ(map->at("bytes_in").get<std::uint64_t>(), fs::file_size(folder_ / "map.exr"));
    EXPECT_EQ(fine->at("bytes_in"), 0) << "the bake counts once";

    // Each mesh has one of the walls; nodes and their names stay.
    for (const auto& [file, low] : {std::pair("map_walls_mesh.glb", 0.0), std::pair("map_fine_walls_mesh.glb", 3.0)}) {
        const formats::GltfScene scene = meshOf(file);
        EXPECT_EQ(scene.triangleCount(), 2) << file;
        ASSERT_EQ(scene.placedMeshes().size(), 1u) << file;
        const formats::MeshAttribute* position = scene.triangleMeshes().front()->find("POSITION");
        double least = 9;
        for (std::size_t i = 0; i < position->vertexCount(); ++i) least = std::min(least, position->at(i).x);
        EXPECT_NEAR(least, low, 0.01) << file;
    }
    EXPECT_FALSE(fs::exists(options_.output / "charts")) << "packed bakes are no output";
}

/// Returns the area of the triangles of a scene, with the x coordinates that they begin and end at.
struct Surface {
    double area = 0, low = HUGE_VAL, high = -HUGE_VAL;
};
Surface surfaceOf(const formats::GltfScene& scene) {
    Surface surface;
    for (const formats::GltfScene::Placed& placed : scene.placedMeshes()) {
        const formats::MeshAttribute& position = *placed.mesh->find("POSITION");
        const auto& indices = placed.mesh->indices;
        for (std::size_t i = 0; i < indices.size(); i += 3) {
            const glm::dvec3 a = position.at(indices[i]), b = position.at(indices[i + 1]), c = position.at(indices[i + 2]);
            surface.area += glm::length(glm::cross(b - a, c - a)) / 2;
            surface.low = std::min({surface.low, a.x, b.x, c.x});
            surface.high = std::max({surface.high, a.x, b.x, c.x});
        }
    }
    return surface;
}

/// Returns the largest difference of coefficient 0 between a bake and the reconstruction of both maps together, over the covered texels, in
/// parts of the bake's root mean square.
double errorOfBoth(const formats::LightMapStrip& bake, const formats::LightMapStrip& both) {
    double largest = 0, light = 0;
    for (std::size_t i = 0; i < bake.sh.texels().size(); ++i) {
        if (bake.covered.texels()[i] == 0) continue;
        const glm::dvec3 truth(bake.sh.texels()[i][0]), off = glm::dvec3(both.sh.texels()[i][0]) - truth;
        largest = std::max(largest, glm::length(off));
        light += glm::dot(truth, truth) / static_cast<double>(std::ranges::count(bake.covered.texels(), 1));
    }
    return largest / std::sqrt(light);
}

TEST_F(SplitCookSoak, AChartIsCutWhereItsLightChanges) {
    writeMap(smoothLight, halfHardLight);
    const Json packed = cooked("charts = \"pack\"\nmax_visible = 3\ndraco = false");
    const Json report = cooked(std::string(kSplit) + "\ndraco = false");
    const Json *map = findAsset(report, "map"), *fine = findAsset(report, "map_fine");
    ASSERT_TRUE(map != nullptr && fine != nullptr) << assetOf(report, "map").at("notes").dump();
    EXPECT_LT(bytesOf(report), bytesOf(packed));
    for (const Json* each : {map, fine}) {
        EXPECT_LE(visibleOf(*each), 3) << each->at("name");
        EXPECT_FALSE(each->at("notes").contains("unread_texels")) << "texels of the other tiles are no fault";
    }
    // 14 units of each wall; the fine map has the lower part of the right one.
    const Surface coarse = surfaceOf(meshOf("map_walls_mesh.glb")), rest = surfaceOf(meshOf("map_fine_walls_mesh.glb"));
    EXPECT_NEAR(coarse.area + rest.area, 28, 1e-5);
    EXPECT_NEAR(rest.area, 14 * (0.95 - (34.5 / kSide)) / 0.9, 0.01) << "from the line beside the centres of row 34 on";
    EXPECT_EQ(coarse.low, 0);
    EXPECT_EQ(rest.low, 3);
    EXPECT_LT(errorOfBoth(texelsOf(folder_ / "map.exr"), reconstructed("map")), 0.1);
    expectVerifiedAs(report);
}

/// The cut goes through a chart: the bake has the same light on both sides of it, and each map its own.
TEST_F(SplitCook, SeamsBetweenMapsAreMeasured) {
    writeMap(smoothLight, halfHardLight);
    const Json report = cooked(std::string(kSplit) + "\nmax_seam = 200");
    const Json& map = assetOf(report, "map");
    ASSERT_TRUE(map.contains("split_seams")) << map.at("notes").dump();
    const Json& seams = map.at("split_seams");
    EXPECT_EQ(seams.at("maps"), Json::array({"map", "map_fine"}));
    EXPECT_EQ(seams.at("max_seam"), 200);
    EXPECT_GT(seams.at("edges"), 0);
    EXPECT_GT(seams.at("places"), 20) << "one for each texel along the cut";
    EXPECT_EQ(seams.at("dark_places"), 0);
    EXPECT_LT(seams.at("bake_diffuse").at("max").get<double>(), 0.05) << "charts were moved, and keep their texels";
    ASSERT_EQ(seams.at("stages").size(), 1u);
    const double added = seams.at("stages").at(0).at("diffuse").at("added").at("max").get<double>();
    EXPECT_GT(added, 0);
    const Json& worst = seams.at("worst").at(0);
    EXPECT_EQ(worst.at("added"), added);
    EXPECT_EQ(std::set<std::string>({worst.at("maps").at(0), worst.at("maps").at(1)}), std::set<std::string>({"map", "map_fine"}));
    EXPECT_LE(added, worst.at("errors").at(0).get<double>() + worst.at("errors").at(1).get<double>() + 1e-3);
    EXPECT_FALSE(assetOf(report, "map_fine").contains("split_seams")) << "the first map has them";
    for (const char* name : {"map", "map_fine"}) EXPECT_EQ(assetOf(report, name).at("limit").at("max_seam"), 200) << name;
    Json figures = seams;
    figures.erase("views");
    EXPECT_EQ(assetOf(verified(), "map").at("split_seams"), figures) << "from the bytes on disk";
    EXPECT_EQ(cookScene(options_, RunState()).actionsRun, 0) << "nothing has changed";
}

/// The camera looks at the seam, and each of the maps lights half of what it sees.
TEST_F(SplitCook, PicturesOfSeamsBetweenMapsShowBothMaps) {
    writeMap(smoothLight, halfHardLight);
    const Json report = cooked(std::string(kSplit) + "\nmax_seam = 200");
    const Json& seams = assetOf(report, "map").at("split_seams");
    ASSERT_GE(seams.at("worst").at(0).at("added").get<double>(), 0.5) << "smaller steps get no picture";
    ASSERT_TRUE(seams.contains("views"));
    EXPECT_LE(seams.at("views").size(), seams.at("worst").size());
    for (const char* which : {"reference", "cooked"}) {
        const auto picture = formats::readImage(options_.output / seams.at("views").at(0).at(which).get<std::string>());
        ASSERT_TRUE(picture.has_value()) << which;
        const int middle = picture->texels.width() / 2;
        for (int y = middle - 8; y < middle + 8; ++y)
            for (int x = middle - 8; x < middle + 8; ++x)
                EXPECT_GT(glm::distance(255.0f * glm::vec3(picture->texels.at(x, y)), glm::vec3(kOutside)), 3)
                    << which << ' ' << x << ' ' << y << " shows no light map";
    }
}

TEST_F(SplitCookSoak, SeamsBetweenMapsAreHeldToTheLimit) {
    writeMap(smoothLight, halfHardLight);
    const Json loose = cooked(kSplit);
    ASSERT_TRUE(hasAsset(loose, "map_fine")) << assetOf(loose, "map").at("notes").dump();
    // Of two layouts, so that the search for one within the limit is short.
    writeScene(std::string(kSplit) + "\nmax_seam = 0.001\nlayouts = " +
               Json({assetOf(loose, "map").at("layout"), assetOf(loose, "map_fine").at("layout")}).dump());
    const Outcome outcome = cookScene(options_, RunState());
    ASSERT_FALSE(outcome.errors.empty());
    const auto between = std::ranges::find_if(
        outcome.errors, [](const formats::Error& error) { return error.subject.starts_with("map, seams between its maps, diffuse"); });
    ASSERT_NE(between, outcome.errors.end()) << outcome.errors.front().line();
    EXPECT_EQ(between->code, ErrorCode::OverLimit);
    EXPECT_THAT(between->line(),
                testing::AllOf(HasSubstr("found a seam of "), HasSubstr("expected at most 0.001 (max_seam); worst at the edge from ("),
                               HasSubstr(" of 'map' and 'map_fine': found (")));
    EXPECT_FALSE(assetOf(outcome.report, "map").at("passed").get<bool>());
    const Outcome again = verifyCooked({options_.output, {}, {}}, RunState());
    ASSERT_EQ(again.errors.size(), outcome.errors.size());
    for (std::size_t i = 0; i < again.errors.size(); ++i) EXPECT_EQ(again.errors[i].line(), outcome.errors[i].line());
}

/// A layout that is over the limit at an edge between maps gives way to a better one.
TEST_F(SplitCookSoak, LayoutsAreChosenToKeepTheLimitBetweenMaps) {
    writeMap(smoothLight, halfHardLight);
    const auto addedIn = [](const Json& report) {
        return assetOf(report, "map").at("split_seams").at("stages").at(0).at("diffuse").at("added").at("max").get<double>();
    };
    const Json loose = cooked(kSplit);
    const double limit = 0.7 * addedIn(loose);
    const Json tight = cooked(std::string(kSplit) + fmt::format("\nmax_seam = {}", limit));
    EXPECT_LE(addedIn(tight), limit);
    EXPECT_GT(bytesOf(tight), bytesOf(loose));
}

TEST_F(SplitCook, VerificationNeedsAllMapsOfTheSeams) {
    writeMap(smoothLight, halfHardLight);
    cooked(std::string(kSplit) + "\nmax_seam = 200");
    auto manifest = loadManifest(options_.output);
    ASSERT_TRUE(manifest);
    std::erase_if(manifest->assets, [](const CookedAsset& asset) { return asset.name == "map_fine"; });
    writeManifestAndDigests(options_.output, toJson(*manifest));
    const Outcome outcome = verifyCooked({options_.output, {}, {}}, RunState());
    ASSERT_FALSE(outcome.errors.empty());
    std::string lines;
    for (const formats::Error& error : outcome.errors) lines += error.line() + "\n";
    EXPECT_THAT(lines, HasSubstr("found no asset 'map_fine', expected that of its scene"));
}

TEST_F(SplitCook, BothMapsTogetherAreTheBake) {
    writeMap(smoothLight, hardLight);
    cooked(kSplit);
    const formats::LightMapStrip bake = texelsOf(folder_ / "map.exr"), both = reconstructed("map"), fine = reconstructed("map_fine");
    double error = 0, light = 0;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            if (bake.covered.at(x, y) == 0) continue;
            const glm::dvec3 truth(bake.sh.at(x, y)[0]), difference = glm::dvec3(both.sh.at(x, y)[0]) - truth;
            error += glm::dot(difference, difference);
            light += glm::dot(truth, truth);
            const bool isOfFine = x >= 32;
            EXPECT_EQ(fine.sh.at(x, y)[0] == glm::vec3(0), !isOfFine) << x << ", " << y;
        }
    EXPECT_LT(std::sqrt(error / light), 0.05);
}

TEST_F(SplitCook, VerificationCachesAndSourcesAreThoseOfTheUser) {
    writeMap(smoothLight, hardLight);
    options_.depfile = folder_ / "walls.d";
    const Json first = cooked(kSplit);
    EXPECT_EQ(cookScene(options_, RunState()).actionsRun, 0) << "nothing has changed";
    const auto manifest = loadManifest(options_.output);
    ASSERT_TRUE(manifest) << manifest.error().line();
    EXPECT_EQ(std::ranges::count(manifest->assets, AssetKind::LightMap, &CookedAsset::kind), 2);
    for (const CookedAsset& asset : manifest->assets) {
        if (asset.kind != AssetKind::LightMap) continue;
        EXPECT_EQ(asset.source.files->at("source").file, "map.exr") << asset.name;
        const auto unpacked = unpackedBakeOf(asset);
        ASSERT_TRUE(unpacked && *unpacked && (*unpacked)->part) << asset.name;
        EXPECT_EQ((*unpacked)->part->of, "map");
        EXPECT_EQ((*unpacked)->part->tiles, asset.name == "map" ? (std::vector{0, 1}) : (std::vector{2, 3}));
    }
    EXPECT_THAT(formats::contentOf(folder_ / "walls.d"), HasSubstr("map.exr"));
    EXPECT_THAT(formats::contentOf(folder_ / "walls.d"), Not(HasSubstr("packed")));

    const Json verified = expectVerifiedAs(first);
    for (const Json* report : {&first, &verified}) {
        ASSERT_EQ(report->at("findings").size(), 1u) << "no finding comes twice";
        EXPECT_EQ(report->at("findings").at(0).at("asset"), "map");
    }
}

/// A mesh that was cooked for other charts is refused.
TEST_F(SplitCook, VerificationRefusesAMeshOfOtherCharts) {
    writeMap(smoothLight, hardLight);
    cooked(std::string(kSplit) + "\ndraco = false");
    auto manifest = loadManifest(options_.output);
    ASSERT_TRUE(manifest);
    std::string text = formats::contentOf(folder_ / "walls.gltf");
    text.replace(text.find("\"nodes\": [0, 1]"), 15, "\"nodes\": [1, 0]");
    formats::writeContent(folder_ / "walls.gltf", text);
    const Outcome verified = verifyCooked({options_.output, {}, {}}, RunState());
    ASSERT_FALSE(verified.errors.empty());
    EXPECT_EQ(verified.errors.front().code, ErrorCode::Verification);
}

TEST_F(SplitCookSoak, AChartOfConstantLightTakesABlock) {
    writeMap(constantLight, hardLight);
    const Json report = cooked(std::string(kSplit) + "\nmax_seam = 200");
    const Json *map = findAsset(report, "map"), *fine = findAsset(report, "map_fine");
    ASSERT_TRUE(map != nullptr && fine != nullptr) << assetOf(report, "map").at("notes").dump();
    EXPECT_LE(map->at("width").get<int>(), 16);
    EXPECT_TRUE(map->at("passed").get<bool>()) << "a map of one texel's light has no seam";
    EXPECT_EQ(map->at("split_seams").at("note"), "no edge of the mesh lies between two of the maps");
    EXPECT_LE(visibleOf(*map), 3);
    verified();
    const formats::LightMapStrip both = reconstructed("map");
    for (const int x : {5, 20}) EXPECT_NEAR(both.sh.at(x, 30)[0].x, constantLight(0, 0)[0].x, 0.02f * constantLight(0, 0)[0].x) << x;
    EXPECT_NE(both.sh.at(50, 30)[0], both.sh.at(51, 33)[0]) << "the other chart is there, too";
}

/// The charts are found again in the packed map, where the smooth one is so small that two maps do not pay.
TEST_F(SplitCookSoak, ChartsMayHaveFewerTexels) {
    writeMap(smoothLight, hardLight);
    const Json report = cooked(std::string(kSplit) + "\ncharts_max_visible = 1");
    const Json& notes = assetOf(report, "map").at("notes");
    EXPECT_THAT(notes.at("packing").get<std::string>(), HasSubstr("1 of 2 charts with fewer texels"));
    EXPECT_THAT(notes.at("split").get<std::string>(), HasSubstr("no, one layout for all 2 charts"));
}

TEST_F(SplitCookSoak, ChartsOfOneKindStayTogether) {
    writeMap(smoothLight, smoothLight);
    const Json packed = cooked("charts = \"pack\"\nmax_visible = 3");
    const Json report = cooked(kSplit);
    EXPECT_FALSE(hasAsset(report, "map_fine"));
    EXPECT_THAT(assetOf(report, "map").at("notes").at("split").get<std::string>(), HasSubstr("no, one layout for all 2 charts"));
    EXPECT_EQ(bytesOf(report), bytesOf(packed));
    EXPECT_EQ(assetOf(report, "map").at("stages"), assetOf(packed, "map").at("stages"));
}

/// Their charts are packed together, whichever of their names is given.
TEST_F(SplitCook, OnlyCooksAllThatBelongsToTheMap) {
    writeMap(smoothLight, hardLight);
    for (const char* only : {"map", "map_fine", "walls_mesh", "map_walls_mesh", "map_fine_walls_mesh"}) {
        options_.output = folder_ / only;
        options_.only = only;
        EXPECT_EQ(cooked(kSplit).at("assets").size(), 4u) << only << ": two maps and two meshes";
    }
}

TEST_F(SplitCookSoak, OnlyLeavesNoAssetsOfOtherCharts) {
    writeMap(smoothLight, hardLight);
    const auto namesAfter = [&](const std::string& output) {
        std::set<std::string> names;
        const Json report = cooked(output);
        for (const Json& asset : report.at("assets")) names.insert(asset.at("name"));
        const auto manifest = loadManifest(options_.output);
        EXPECT_TRUE(manifest && manifest->assets.size() == names.size());
        return names;
    };
    const std::set<std::string> one = {"map", "walls_mesh"}, two = {"map", "map_fine", "map_walls_mesh", "map_fine_walls_mesh"};
    EXPECT_EQ(namesAfter(kSplit), two);
    options_.only = "map";
    EXPECT_EQ(namesAfter("charts = \"pack\"\nmax_visible = 3"), one);
    EXPECT_FALSE(fs::exists(options_.output / "map_fine_walls_mesh.gltf"));
    EXPECT_EQ(namesAfter(kSplit), two);
    options_.only = "walls_mesh";
    EXPECT_EQ(namesAfter("charts = \"pack\"\nmax_visible = 3"), one);
    writeScene("charts = \"keep\"\nmax_visible = 3");
    EXPECT_EQ(mistake(),
              "--only: found 'map' of an earlier cook with packed charts, expected the whole light map to be cooked: --only map");
    options_.only = "map";
    EXPECT_EQ(namesAfter("charts = \"keep\"\ndraco = false\nlight_map_layout = \"ratio\""), std::set<std::string>{"map"});
}

TEST_F(SplitCookSoak, BytesDoNotDependOnThreads) {
    writeMap(smoothLight, hardLight);
    std::array<std::string, 2> manifests;
    for (const int threads : {1, 3}) {
        options_.output = folder_ / fmt::format("out{}", threads);
        options_.force = true;
        tbb::task_arena arena(threads);
        arena.execute([&] { cooked(kSplit); });
        std::string& digests = manifests[threads == 1 ? 0 : 1];
        const auto manifest = loadManifest(options_.output);
        ASSERT_TRUE(manifest);
        for (const FileRecord& file : filesOf(*manifest)) digests += file.name + " " + file.digest + "\n";
    }
    EXPECT_EQ(manifests[0], manifests[1]);
}

/// The search for a split takes minutes, so morph targets are refused before it, even if no split would be found.
TEST_F(SplitCookSoak, MorphTargetsAreRefusedBeforeTheSearchForASplit) {
    writeMap(smoothLight, smoothLight);
    std::string text = formats::contentOf(folder_ / "walls.gltf");
    const std::string indices = "\"indices\": 4";
    formats::writeContent(folder_ / "walls.gltf",
                          text.replace(text.rfind(indices), indices.size(), indices + R"(, "targets": [{"POSITION": 1}])"));
    writeScene(kSplit);
    EXPECT_THAT(mistake(),
                HasSubstr("walls.gltf, mesh 1, primitive 0: found morph targets, expected none in a mesh whose charts are split"));
    cooked("charts = \"pack\"\nmax_visible = 3");
}

TEST_F(SplitCookSoak, LinesNeedNoLightMapUvs) {
    writeMap(smoothLight, smoothLight);
    std::string text = formats::contentOf(folder_ / "walls.gltf");
    const std::string primitives = "\"primitives\": [";
    formats::writeContent(folder_ / "walls.gltf",
                          text.insert(text.find(primitives) + primitives.size(), R"({"attributes": {"POSITION": 0}, "mode": 1}, )"));
    for (const char* charts : {"keep", "pack", "split"}) {
        SCOPED_TRACE(charts);
        const Json report = cooked(fmt::format("charts = \"{}\"\nmax_visible = 3", charts));
        ASSERT_TRUE(hasAsset(report, "walls_mesh"));
        const formats::GltfScene mesh = meshOf("walls_mesh.glb");
        EXPECT_TRUE(mesh.hasLightMapUvs());
        EXPECT_EQ(mesh.triangleMeshes().size(), 2u);
        EXPECT_THAT(formats::contentOf(options_.output / "walls_mesh.glb"), HasSubstr("\"mode\":1"));
    }
}

TEST_F(SplitCook, WhatCannotBeSplitIsRefused) {
    writeMap(smoothLight, hardLight);
    writeScene("charts = \"split\"\nlight_map_layout = \"ratio\"");
    EXPECT_THAT(mistake(), HasSubstr("found charts of 'map' to split without a limit within which each map gets a layout"));
    writeScene("charts = \"split\"\nlight_map_layout = \"auto\"\nbudget = \"1 MiB\"");
    EXPECT_THAT(mistake(), testing::EndsWith("expected max_visible or max_error"));
    writeScene("charts = \"split\"\nbudget = \"1 MiB\"");
    EXPECT_THAT(mistake(), HasSubstr("expected max_visible or max_error"));
    writeScene("charts = \"split\"\nmax_visible = 3\ncost = \"taps\"");
    EXPECT_THAT(mistake(), HasSubstr("found charts of 'map' to split beside cost = \"taps\", expected cost = \"bytes\""));
    writeScene("charts = \"split\"\nmax_visible = 3", "");
    EXPECT_THAT(mistake(), HasSubstr("without a mesh"));
    writeScene("charts = \"split\"\nmax_visible = 3",
               "mesh = \"walls.gltf\"\n[[light_map]]\nname = \"map_fine\"\nfile = \"map.exr\"\ncharts = \"keep\"\n");
    EXPECT_THAT(mistake(), HasSubstr("found charts of 'map' to split beside a light map 'map_fine', expected another name for that one"));
    writeScene("charts = \"split\"\nmax_visible = 3", "mesh = \"walls.gltf\"\n[[gradient]]\nname = \"map_fine\"\nfile = \"sky.png\"\n");
    EXPECT_THAT(mistake(), HasSubstr("found charts of 'map' to split beside a gradient 'map_fine', expected another name for that one"));
    EXPECT_FALSE(fs::exists(options_.output));
}

}  // namespace
}  // namespace lightcook::pipeline
