// Light maps of Godot whose lmbake says where the nodes of the mesh lie, cooked as a whole.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "formats/gltf_scene.h"
#include "formats/image/exr_file.h"
#include "pipeline/command/info.h"
#include "pipeline/manifest/manifest.h"
#include "tests/formats/lmbake_fixture.h"
#include "tests/pipeline/repack/charts_cook.h"
#include "tests/pipeline/walls.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::GodotBake;
using formats::GodotMesh;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int kSliceSide = 16, kSlices = 2;

/// Two walls whose light-map UVs both run over [0, 1], each in a rectangle of a slice of its own, of 10 x 12 and 8 x 8 texels.
class GodotScene : public ChartsCook {
protected:
    GodotScene() {
        const std::array<float, 8> whole = {0, 0, 0, 1, 1, 1, 1, 0};
        writeWalls(folder_.path(), {whole, whole, {3, 7, 0, 3, 0, 0, 5, 0, 0, 5, 7, 0}});
        writeBake(bake_);
        writeLight();
        writeScene("");
    }
    void writeBake(const GodotBake& bake) const { bake.write(folder_ / "room.lmbake"); }
    /// Writes pages of slices L0, y, z and x, with light from in front, and alpha 1 in the rectangles and a texel around.
    void writeLight() const {
        const auto valueAt = [](int c, int x, int y) {  // of R, G, B and A
            const int page = y / (4 * kSliceSide), slice = y / kSliceSide % 4, v = y % kSliceSide;
            const int first = page == 0 ? 1 : 3, right = page == 0 ? 13 : 12, bottom = page == 0 ? 15 : 12;
            if (c == 3) return x >= first && x < right && v >= first && v < bottom ? 1.0f : 0.0f;
            if (slice == 0) return 0.4f + 0.01f * static_cast<float>(c + x + v + page);
            return slice == 2 ? 0.6f : 0.5f;
        };
        constexpr int kHeight = 4 * kSlices * kSliceSide;
        std::vector<float> rows;
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kSliceSide; ++x)
                for (const int c : {3, 2, 1, 0}) rows.push_back(valueAt(c, x, y));
        auto writer =
            formats::ExrWriter::create(folder_ / "room.exr", kSliceSide, kHeight, {"A", "B", "G", "R"}, formats::ExrLayout::ScanLines);
        ASSERT_TRUE(writer && writer->append(rows.data(), 4 * kSliceSide, kHeight) && writer->commit());
        formats::writeContent(folder_ / "room.exr.import",
                              fmt::format("importer=\"2d_array_texture\"\nslices/horizontal=1\nslices/vertical={}\n", 4 * kSlices));
    }
    void writeScene(const std::string& map, const std::string& output = "") const {
        formats::writeContent(options_.scene, "schema = 1\nname = \"room\"\n[output]\n" + output +
                                                  "\n[[light_map]]\nname = \"map\"\nfile = \"room.exr\"\nmesh = \"walls.gltf\"\n" + map);
    }
    Json cooked() const { return reportOf(cookScene(options_, RunState())); }
    /// Returns the places of the corners of the cooked walls in the map, in texels and sorted.
    std::set<std::string> cookedCorners(const char* attribute = "TEXCOORD_1") const {
        const auto scene = formats::GltfScene::load(options_.output / "walls_mesh.glb");
        if (!scene) throw std::runtime_error(scene.error().line());
        std::set<std::string> corners;
        for (const auto* mesh : scene->triangleMeshes())
            for (std::size_t vertex = 0; vertex < mesh->vertexCount(); ++vertex) {
                const glm::dvec3 at = mesh->find("POSITION")->at(vertex), uv = mesh->find(attribute)->at(vertex);
                corners.insert(fmt::format("{:.0f} {:.0f}: {:.1f} {:.1f}", at.x, at.y, uv.x * kSliceSide, uv.y * kSliceSide * kSlices));
            }
        return corners;
    }
    static std::vector<LintCheck> checksOf(const Outcome& outcome) {
        std::vector<LintCheck> checks;
        for (const Finding& finding : outcome.findings) checks.push_back(finding.check);
        return checks;
    }

    GodotBake bake_{.meshes = {{{"..", "left"}, 2.0 / kSliceSide, 2.0 / kSliceSide, 10.0 / kSliceSide, 12.0 / kSliceSide, 0},
                               {{"..", "right"}, 0.25, 0.25, 0.5, 0.5, 1}}};
    const std::set<std::string> corners_ = {"0 7: 2.0 2.0",  "0 0: 2.0 14.0", "2 0: 12.0 14.0", "2 7: 12.0 2.0",
                                            "3 7: 4.0 20.0", "3 0: 4.0 28.0", "5 0: 12.0 28.0", "5 7: 12.0 20.0"};
};

TEST_F(GodotScene, TheCookedMeshHasTheUvsOfTheWholeMap) {
    options_.depfile = folder_ / "room.d";
    options_.cache = folder_ / "cache";  // of what runs again
    cooked();
    EXPECT_EQ(cookedCorners(), corners_);
    const auto manifest = loadManifest(options_.output);
    ASSERT_TRUE(manifest) << manifest.error().line();
    const auto mesh = std::ranges::find(manifest->assets, AssetKind::Mesh, &CookedAsset::kind);
    ASSERT_NE(mesh, manifest->assets.end());
    EXPECT_EQ(mesh->source.files->at("mesh_lmbake").file, "room.lmbake");
    EXPECT_THAT(formats::contentOf(folder_ / "room.d"), HasSubstr("room.lmbake"));
    verified();
    EXPECT_EQ(cookScene(options_, RunState()).actionsRun, 0);

    // The slices exchanged: what hangs on the file is cooked anew.
    std::swap(bake_.meshes[0].slice, bake_.meshes[1].slice);
    writeBake(bake_);
    EXPECT_FALSE(verifyCooked({options_.output, {}, {}}, RunState()).errors.empty()) << "a source has changed";
    EXPECT_GT(cookScene(options_, RunState()).actionsRun, 0);
    EXPECT_THAT(cookedCorners(), Contains("0 7: 2.0 18.0"));
}

TEST_F(GodotScene, PackedChartsComeFromTheirRectangles) {
    writeScene("", "charts = \"pack\"\nlight_map_layout = \"raw\"\n");
    const Json report = cooked();
    EXPECT_LT(assetOf(report, "map").at("width").get<int>() * assetOf(report, "map").at("height").get<int>(),
              kSliceSide * kSliceSide * kSlices);
    EXPECT_EQ(cookedCorners("TEXCOORD_2"), corners_);
    verified();
    const formats::LightMapStrip texels = reconstructed("map");
    EXPECT_EQ(texels.sh.width(), kSliceSide);
    EXPECT_EQ(texels.sh.height(), kSliceSide * kSlices);
    const formats::LightMapStrip bake = texelsOf(folder_ / "room.exr");
    for (const glm::ivec2& at : {glm::ivec2(3, 3), glm::ivec2(11, 12), glm::ivec2(6, 22)})
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(texels.sh.at(at.x, at.y)[0][c], bake.sh.at(at.x, at.y)[0][c], 2e-3);
}

TEST_F(GodotScene, NodesAndRectanglesWithoutACounterpartAreNamed) {
    bake_.meshes[1].path.back() = "door";
    writeBake(bake_);
    const Outcome outcome = cookScene(options_, RunState());
    EXPECT_THAT(checksOf(outcome), AllOf(Contains(LintCheck::UnplacedNodes), Contains(LintCheck::UnreadRectangles)));
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_THAT(outcome.errors.front().line(), HasSubstr("room.lmbake, unplaced-nodes: found 1 node(s) of walls.gltf without a rectangle: "
                                                         "'right'; expected one for each that has TEXCOORD_1"));
    const auto described = describeFile(folder_ / "room.lmbake");
    ASSERT_TRUE(described) << described.error().line();
    EXPECT_EQ(described->at("slices"), 2);
    EXPECT_EQ(described->at("meshes")[1], Json({{"node", "../door"}, {"slice", 1}, {"rectangle", {0.25, 0.25, 0.5, 0.5}}}));
    fs::copy_file(folder_ / "room.lmbake", folder_ / "walls.lmbake");
    const auto mesh = describeFile(folder_ / "walls.gltf");
    ASSERT_TRUE(mesh) << mesh.error().line();
    EXPECT_EQ(mesh->at("lmbake").at("nodes_with_rectangle"), 1);
    EXPECT_EQ(mesh->at("lmbake").at("nodes_without_rectangle"), Json({"right"}));
    EXPECT_EQ(mesh->at("lmbake").at("rectangles_without_node"), Json({"../door"}));
}

TEST_F(GodotScene, AKeyNamesTheFileOrNone) {
    fs::rename(folder_ / "room.lmbake", folder_ / "other.lmbake");
    writeScene("lmbake = \"other.lmbake\"\n");
    cooked();
    EXPECT_EQ(cookedCorners(), corners_);
    fs::rename(folder_ / "other.lmbake", folder_ / "room.lmbake");
    writeScene("lmbake = \"none\"\n");
    (void)cookScene(options_, RunState());
    EXPECT_THAT(cookedCorners(), Contains("0 7: 0.0 0.0")) << "TEXCOORD_1 as it is";

    writeScene("lmbake = \"room.lmbake\"\nbake = \"bakery-sh\"\n");
    EXPECT_THAT(mistake(), HasSubstr("found light_map.lmbake beside bake = \"bakery-sh\", expected a light map of Godot: flat or godot or "
                                     "godot-radiance"));
    formats::writeContent(folder_ / "room.lmbake", "RSRC");
    writeScene("");
    EXPECT_THAT(mistake(), HasSubstr("room.lmbake, byte 4: found 0 bytes up to the end, expected 4: truncated"));
    writeScene("lmbake = \"gone.lmbake\"\n");
    EXPECT_THAT(mistake(), HasSubstr("gone.lmbake: found no such file"));
}

}  // namespace
}  // namespace lightcook::pipeline
