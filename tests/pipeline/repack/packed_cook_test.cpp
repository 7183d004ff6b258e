// A cook that packs the charts of its light map: verdict, files and messages are those of the user's bake.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <set>

#include "formats/gltf_scene.h"
#include "lighting/radiometry.h"
#include "pipeline/assets/light_map/unpacked_bake.h"
#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "tests/pipeline/example_folder.h"
#include "tests/pipeline/repack/charts_cook.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::ErrorCode;
using testing::HasSubstr;
using testing::Not;

class PackedCook : public ChartsCook {
protected:
    PackedCook() {
        for (const char* file : {"cornell_lightmap.exr", "cornell.glb"}) fs::copy_file(exampleFolder() / file, folder_ / file);
    }
    /// output  lines of [output]; map  lines of [[light_map]]
    void writeScene(const std::string& output, const std::string& map = "mesh = \"cornell.glb\"\n") const {
        formats::writeContent(options_.scene, "schema = 1\nname = \"box\"\n[output]\nmax_error = 0.1\n" + output +
                                                  "\n[[light_map]]\nname = \"map\"\nfile = \"cornell_lightmap.exr\"\n" + map +
                                                  "[[material]]\nname = \"*\"\nnormal_map = true\nspecular = true\nm = [0.1, 0.5]\n");
    }
    /// charts  of the command line; empty: none
    Outcome cook(const std::string& charts = "") const {
        CookOptions options = options_;
        if (!charts.empty()) options.given.set("output.charts", charts);
        return cookScene(options, RunState());
    }
    Json cooked(const std::string& charts = "") const { return reportOf(cook(charts)); }
};

TEST_F(PackedCook, MovedChartsKeepTheErrorAtTexelsAndTheBound) {
    writeScene("light_map_layout = \"raw\"\ncharts = \"pack\"");
    const Json report = cooked();
    const Json& map = assetOf(report, "map");
    const Json &repacked = *(map.at("stages").end() - 2), &total = map.at("stages").back();
    EXPECT_EQ(repacked.at("name"), "repacked");
    EXPECT_EQ(total.at("name"), "total");
    for (const char* shading : {"diffuse", "specular"}) {
        EXPECT_LT(total.at("at_texels").at(shading).at("rel_rms").get<double>(), 1e-6) << "the bake has half floats, as the layout";
        EXPECT_LT(repacked.at("at_texels").at(shading).at("rel_rms").get<double>(), 1e-6);
        EXPECT_EQ(total.at("error").at(shading).at("max_bound"), repacked.at("error").at(shading).at("max_bound"));
        for (const Json& figures : {total.at("error").at(shading), total.at("at_texels").at(shading)})
            EXPECT_LE(figures.at("max_sampled").get<double>(), figures.at("max_bound").get<double>());
        EXPECT_EQ(total.at("error").at(shading).at("visible").at("bound"), repacked.at("error").at(shading).at("visible").at("bound"));
        EXPECT_LE(total.at("error").at(shading).at("visible").at("max").get<double>(),
                  total.at("error").at(shading).at("visible").at("bound").get<double>());
    }
    EXPECT_THAT(map.at("notes").at("packing").get<std::string>(), HasSubstr("of 256 x 256"));
    EXPECT_LT(map.at("width").get<int>() * map.at("height").get<int>(), 256 * 256);
    EXPECT_EQ(map.at("bytes_in").get<std::uint64_t>(), fs::file_size(folder_ / "cornell_lightmap.exr"));
}

using PackedCookSoak = PackedCook;
/// The bake before its charts were packed reads its mesh for coverage; the packed one has channels for it.
TEST_F(PackedCookSoak, CoverageMayComeFromTheMesh) {
    writeScene("light_map_layout = \"hdr\"\ncharts = \"pack\"", "mesh = \"cornell.glb\"\ncoverage = \"mesh\"\n");
    const Json report = cooked();
    const Json& map = assetOf(report, "map");
    EXPECT_LT(map.at("stages").back().at("error").at("diffuse").at("rel_rms").get<double>(), 0.01);
    verified();
}

TEST_F(PackedCook, FewerTexelsAreJudgedAgainstTheBake) {
    writeScene("light_map_layout = \"raw\"\ncharts = \"pack\"\ncharts_max_visible = 2");
    const Json report = cooked();
    const Json& map = assetOf(report, "map");
    const Json &repacked = *(map.at("stages").end() - 2), &total = map.at("stages").back();
    const auto atTexels = [](const Json& stage) { return stage.at("at_texels").at("diffuse").at("rel_rms").get<double>(); };
    EXPECT_LT(10 * atTexels(repacked), atTexels(total)) << "\"raw\" holds the repacked bake, which is not the bake";
    for (const char* shading : {"diffuse", "specular"}) {
        const auto onSurface = [&](const Json& stage) { return stage.at("error").at(shading).at("rel_rms").get<double>(); };
        EXPECT_LT(10 * onSurface(repacked), onSurface(total)) << "nothing is judged between charts, nor beyond their rims";
    }
    for (const char* where : {"error", "at_texels"})
        for (const char* shading : {"diffuse", "specular"}) {
            EXPECT_TRUE(repacked.at(where).at(shading).contains("max_bound")) << where;
            EXPECT_FALSE(total.at(where).at(shading).contains("max_bound")) << where << ": nothing bounds what fewer texels add";
        }
    EXPECT_FALSE(total.at("error").at("diffuse").at("visible").contains("bound"));

    // The same error by a reading of the test's own: reconstructed texels against those of the bake, at the texels' own normals.
    const formats::LightMapStrip before = texelsOf(folder_ / "cornell_lightmap.exr"), after = reconstructed("map");
    ASSERT_EQ(after.sh.width(), 256);
    ASSERT_EQ(after.sh.height(), 256);
    double error = 0, light = 0;
    for (int y = 0; y < 256; ++y)
        for (int x = 0; x < 256; ++x) {
            if (before.covered.at(x, y) == 0) continue;
            const glm::vec3 normal = before.normal.at(x, y);
            const auto exit = [&](const lighting::ShRgb& sh) {
                return glm::dvec3(lighting::lambertExitRadiance(sh, normal, glm::vec3(1)).value);
            };
            const glm::dvec3 wanted = exit(before.sh.at(x, y)), difference = exit(after.sh.at(x, y)) - wanted;
            error += glm::dot(difference, difference);
            light += glm::dot(wanted, wanted);
        }
    const double found = total.at("at_texels").at("diffuse").at("rel_rms").get<double>();
    EXPECT_NEAR(std::sqrt(error / light), found, 0.25 * found) << "of 32 normals a texel, not of its own alone";

    // A limit between both errors fails, although the repacked bake keeps it.
    writeScene("light_map_layout = \"raw\"\ncharts = \"pack\"\ncharts_max_visible = 2\nmax_converter_error = 1");
    options_.given.set("output.max_error", found / 2);
    const Outcome failed = cook();
    ASSERT_FALSE(failed.errors.empty()) << found / 2;
    EXPECT_EQ(failed.errors.front().code, ErrorCode::OverLimit);
}

TEST_F(PackedCookSoak, TheCookedMeshHasBothUvs) {
    for (const char* draco : {"draco = false", "draco = true"}) {
        writeScene(std::string("light_map_layout = \"ratio\"\ncharts = \"pack\"\n") + draco);
        cooked();
        const auto manifest = loadManifest(options_.output);
        ASSERT_TRUE(manifest) << manifest.error().line();
        const auto mesh = std::ranges::find(manifest->assets, AssetKind::Mesh, &CookedAsset::kind);
        const auto map = std::ranges::find(manifest->assets, AssetKind::LightMap, &CookedAsset::kind);
        ASSERT_TRUE(mesh != manifest->assets.end() && map != manifest->assets.end());
        const auto unpacked = unpackedBakeOf(*map);
        ASSERT_TRUE(unpacked && *unpacked);
        const ChartPacking& packing = (*unpacked)->packing;
        EXPECT_EQ(packing.uvBefore, "TEXCOORD_2");
        EXPECT_EQ(packing.widthBefore, 256);
        EXPECT_EQ(packing.width, map->width);
        EXPECT_EQ(static_cast<std::int64_t>((*unpacked)->places.size()), 4 * packing.charts);

        // Triangles of both meshes with the same corners have the same old UVs, and new ones that are these moved.
        const auto before = formats::GltfScene::load(folder_ / "cornell.glb"),
                   after = formats::GltfScene::load(options_.output / *mesh->file);
        ASSERT_TRUE(before && after);
        std::set<std::array<int, 5>> known;
        const auto rounded = [](double value) { return static_cast<int>(std::lround(value * 64)); };
        const auto corner = [&](const glm::dvec3& position, const glm::dvec3& uv, int du, int dv) {
            return std::array<int, 5>{rounded(position.x), rounded(position.y), rounded(position.z), rounded(uv.x * 64) + du,
                                      rounded(uv.y * 64) + dv};
        };
        for (const auto* triangles : before->triangleMeshes())
            for (const std::uint32_t vertex : triangles->indices)
                for (int du = -1; du <= 1; ++du)
                    for (int dv = -1; dv <= 1; ++dv)
                        known.insert(corner(triangles->find("POSITION")->at(vertex), triangles->find("TEXCOORD_1")->at(vertex), du, dv));
        std::size_t moved = 0, corners = 0;
        for (const auto* triangles : after->triangleMeshes()) {
            const auto *old = triangles->find("TEXCOORD_2"), *made = triangles->find("TEXCOORD_1");
            ASSERT_TRUE(old != nullptr && made != nullptr);
            for (std::size_t i = 0; i < triangles->indices.size(); ++i, ++corners) {
                const std::uint32_t vertex = triangles->indices[i];
                EXPECT_TRUE(known.contains(corner(triangles->find("POSITION")->at(vertex), old->at(vertex), 0, 0))) << draco << " " << i;
                moved += glm::any(glm::greaterThan(glm::abs(old->at(vertex) - made->at(vertex)), glm::dvec3(1e-3))) ? 1 : 0;
            }
        }
        EXPECT_GT(corners, 0u) << draco;
        EXPECT_GT(2 * moved, corners) << draco;
    }
}

TEST_F(PackedCook, FilesOfTheUserAreTheSources) {
    writeScene("light_map_layout = \"ratio\"\ncharts = \"pack\"");
    options_.depfile = folder_ / "box.d";
    cooked();
    const auto manifest = loadManifest(options_.output);
    ASSERT_TRUE(manifest);
    EXPECT_EQ(std::ranges::count(manifest->assets, AssetKind::LightMap, &CookedAsset::kind), 1);
    EXPECT_EQ(std::ranges::count(manifest->assets, AssetKind::Mesh, &CookedAsset::kind), 1);
    for (const CookedAsset& asset : manifest->assets) {
        if (asset.kind == AssetKind::Lut) continue;
        ASSERT_TRUE(asset.source.files);
        EXPECT_EQ(asset.source.files->at("source").file, "cornell_lightmap.exr") << asset.name;
        EXPECT_EQ(asset.source.files->at("mesh").file, "cornell.glb") << asset.name;
    }
    EXPECT_THAT(formats::contentOf(folder_ / "box.d"), HasSubstr("cornell_lightmap.exr"));
    EXPECT_THAT(formats::contentOf(folder_ / "box.d"), Not(HasSubstr("packed")));
    EXPECT_FALSE(fs::exists(options_.output / "packed"));
    EXPECT_FALSE(fs::exists(options_.output / "map"));

    const Outcome again = cook();
    EXPECT_EQ(again.actionsRun, 0) << "nothing has changed";

    const Json report = verified();
    const Json& first = assetOf(again.report, "map").at("stages").back();
    const Json& second = assetOf(report, "map").at("stages").back();
    EXPECT_EQ(first.at("error"), second.at("error"));
}

TEST_F(PackedCookSoak, TheCommandLineKeepsUvs) {
    writeScene("light_map_layout = \"ratio\"");
    const Json kept = cooked();
    writeScene("light_map_layout = \"ratio\"\ncharts = \"pack\"");
    const Json report = cooked("keep");
    EXPECT_EQ(assetOf(report, "map").at("width"), 256);
    EXPECT_EQ(assetOf(report, "map").at("stages"), assetOf(kept, "map").at("stages"));
    writeScene("light_map_layout = \"ratio\"\ncharts = \"pack\"", "mesh = \"cornell.glb\"\ncharts = \"keep\"\n");
    EXPECT_EQ(assetOf(cooked(), "map").at("width"), 256) << "the light map's own key goes before";
    EXPECT_LT(assetOf(cooked("pack"), "map").at("width"), 256) << "the command line before both";
}

TEST_F(PackedCookSoak, LayoutsAndBudgetsAreChosenForTheRepackedMap) {
    // Layouts of more fetches are not tried, since each trial takes seconds.
    writeScene("charts = \"pack\"\ncharts_max_visible = 1\nbudget = \"300 KiB\"\nmax_fetches = 5");
    const Json report = cooked();
    EXPECT_LE(report.at("budget").at("used_bytes").get<std::uint64_t>(), 300u * 1024);
    writeScene("charts = \"pack\"\nmax_visible = 8\nmax_fetches = 5");
    const Json chosen = cooked();
    const Json& total = assetOf(chosen, "map").at("stages").back();
    for (const char* shading : {"diffuse", "specular"}) EXPECT_LE(total.at("error").at(shading).at("visible").at("p99").get<double>(), 8);
}

TEST_F(PackedCook, WhatCannotBePackedIsRefused) {
    writeScene("charts = \"pack\"", "");
    EXPECT_THAT(mistake(), HasSubstr("found charts of 'map' to pack without a mesh, expected mesh = \"FILE\""));
    writeScene("charts = \"pack\"", "mesh = \"cornell.glb\"\nground_truth = \"traced.csv\"\n");
    EXPECT_THAT(mistake(), HasSubstr("found charts of 'map' to pack beside ground_truth"));
    writeScene("charts = \"pack\"\ncharts_max_visible = 1\nmax_visible_bound = 9");
    EXPECT_THAT(mistake(), HasSubstr("expected charts_max_visible = 0"));
    writeScene("charts = \"pack\"\ncharts_max_visible = -1");
    EXPECT_THAT(mistake(), HasSubstr("found -1 for output.charts_max_visible, expected a number from 0"));
    writeScene("charts_max_visible = 1");
    EXPECT_THAT(mistake(), HasSubstr("scene.toml:5:22: found charts_max_visible where no charts are packed, expected charts = \"pack\""));
    writeScene("charts = \"pack\"", "mesh = \"cornell.glb\"\ncharts = \"keep\"\ncharts_max_visible = 1\n");
    EXPECT_THAT(mistake(), HasSubstr("found charts_max_visible where no charts are packed"));
    writeScene("charts = \"packed\"");
    EXPECT_THAT(mistake(), HasSubstr("expected one of: keep, pack"));
}

TEST_F(PackedCookSoak, UvsThatAreKeptDoNotHelpTrianglesWithoutAny) {
    std::string bytes = formats::contentOf(folder_ / "cornell.glb");
    for (std::size_t at = 0; (at = bytes.find("\"TEXCOORD_1\"", at)) != std::string::npos;) bytes.replace(at, 12, "\"TEXCOORD_9\"");
    formats::writeContent(folder_ / "cornell.glb", bytes);
    writeScene("charts = \"pack\"");
    EXPECT_THAT(mistake(), testing::EndsWith("cornell.glb, primitive 0: found no TEXCOORD_1, expected light-map UVs on all triangles, "
                                             "with --charts keep too: unwrap these as well, or put what no light map lies on into a "
                                             "mesh of its own"));
    writeScene("charts = \"keep\"");
    EXPECT_THAT(mistake(), HasSubstr("found triangles without TEXCOORD_1, expected light-map UVs on all triangles"));
}

}  // namespace
}  // namespace lightcook::pipeline
