// Light maps without coverage on meshes that belong to them and on others: what does not fit is found, and what fits is not, whatever the
// margin of the charts and the shadows.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include <vector>

#include "pipeline/lint/lint.h"
#include "tests/formats/gltf/quad_scene.h"
#include "tests/pipeline/lint/planted_scene.h"

namespace lightcook::pipeline {
namespace {

using formats::QuadScene;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kFitSide = 64;

/// A chart: rows and columns [first, last).
struct Chart {
    int x, y, width, height;
};
const std::vector<Chart> kCharts = {{2, 2, 28, 28}, {34, 2, 20, 28}, {2, 36, 28, 12}};

enum class Growth { Square, Diamond };

/// A scene of a flat map and the quads that lie on its charts.
class FitScene {
public:
    FitScene() {
        image_.width = image_.height = kFitSide;
        for (const char* channel : {"R", "G", "B"}) image_.values[channel].assign(kFitSide * kFitSide, 0.0f);
        for (const Chart& chart : kCharts) quads_.push_back(chart);
    }
    /// Lights the charts, and texels beside them.
    /// margin  [texels]
    void light(int margin, Growth growth = Growth::Square) {
        for (int y = 0; y < kFitSide; ++y)
            for (int x = 0; x < kFitSide; ++x)
                for (const Chart& chart : kCharts) {
                    const int dx = std::max({chart.x - x, x - chart.x - chart.width + 1, 0}),
                              dy = std::max({chart.y - y, y - chart.y - chart.height + 1, 0});
                    if ((growth == Growth::Square ? std::max(dx, dy) : dx + dy) <= margin)
                        set(x, y, 0.5f + 0.01f * static_cast<float>(x % 7));
                }
    }
    void set(int x, int y, float light) {
        for (const char* channel : {"R", "G", "B"}) image_.values[channel][static_cast<std::size_t>(y * kFitSide + x)] = light;
    }
    /// Returns the codes of the findings on a mesh whose UVs are changed; texts of errors, too.
    /// quads  number of charts that the mesh has
    std::vector<std::string> codes(
        const std::function<glm::dvec2(glm::dvec2)>& change = [](glm::dvec2 uv) { return uv; }, std::size_t quads = kCharts.size()) {
        QuadScene mesh;
        for (std::size_t i = 0; i < quads; ++i) {
            const Chart& chart = quads_[i];
            const glm::dvec2 low(chart.x, chart.y), size(chart.width, chart.height);
            mesh.add({fmt::format("quad{}", i), change(low / double{kFitSide}), change((low + size) / double{kFitSide})});
        }
        mesh.write(folder_ / "room.glb");
        if (!image_.write(folder_ / "room.exr")) return {"could not write"};
        formats::writeContent(folder_ / "scene.toml",
                              "schema = 1\nname = \"case\"\n[output]\nlight_map_layout = \"flat\"\n[[light_map]]\nname = \"room\"\nfile = "
                              "\"room.exr\"\nmesh = \"room.glb\"\ncoverage = \"mesh\"\n" +
                                  keys);
        const RunState state;
        const Outcome outcome = lintScene({folder_ / "scene.toml", folder_ / "cache", false, false}, state);
        std::vector<std::string> found;
        finding = outcome.findings.empty() ? Finding{} : outcome.findings.front();
        for (const Finding& each : outcome.findings) found.emplace_back(info(each.check).name);
        for (const formats::Error& error : outcome.errors) found.push_back(error.line());
        return found;
    }
    const formats::TemporaryFolder& folder() const { return folder_; }

    std::string keys;  ///< of the light map
    Finding finding;   ///< the first of the last codes()

private:
    Channels image_;
    std::vector<Chart> quads_;
    formats::TemporaryFolder folder_;
};

TEST(MeshFit, RightMeshesHaveNoFinding) {
    for (const Growth growth : {Growth::Square, Growth::Diamond})
        for (const int margin : {0, 1, 2, 5, 9, 64}) {
            SCOPED_TRACE(fmt::format("margin {}, growth {}", margin, static_cast<int>(growth)));
            FitScene scene;
            scene.light(margin, growth);
            EXPECT_THAT(scene.codes(), IsEmpty());
        }
}

TEST(MeshFit, ShadowsAreNoFinding) {
    for (const int margin : {0, 3}) {
        FitScene scene;
        scene.light(margin);
        // The sun lights half of a chart.
        for (int y = 0; y < 36; ++y)
            for (int x = 0; x < 17; ++x) scene.set(x, y, 0);
        EXPECT_THAT(scene.codes(), IsEmpty()) << margin;
    }
}

TEST(MeshFit, NoiseOfADenoiserIsNoLight) {
    FitScene scene;
    for (int y = 0; y < kFitSide; ++y)
        for (int x = 0; x < kFitSide; ++x)
            if ((x * 7 + y * 13) % 5 < 2) scene.set(x, y, 1e-3f);
    scene.light(1);
    EXPECT_THAT(scene.codes(), IsEmpty());
}

TEST(MeshFit, UvsOfAnotherScaleAreFound) {
    for (const int margin : {0, 2})
        for (const double scale : margin == 0 ? std::vector{0.5, 0.75, 1.1, 1.5, 2.0} : std::vector{0.5, 1.5, 2.0}) {
            SCOPED_TRACE(fmt::format("scale {}, margin {}", scale, margin));
            FitScene scene;
            scene.light(margin);
            EXPECT_THAT(scene.codes([&](glm::dvec2 uv) { return uv * scale; }), ElementsAre("wrong-mesh"));
            EXPECT_THAT(scene.finding.found, HasSubstr(fmt::format("with UVs times ({:.2f}", 1 / scale).substr(0, 17)));
        }
}

TEST(MeshFit, UvsAtAnotherPlaceAreFound) {
    for (const int margin : {0, 2})
        for (const glm::dvec2 offset : {glm::dvec2(0.1, 0), glm::dvec2(0, 0.15)}) {
            FitScene scene;
            scene.light(margin);
            EXPECT_THAT(scene.codes([&](glm::dvec2 uv) { return uv + offset; }), ElementsAre("wrong-mesh")) << offset.x << " " << offset.y;
        }
}

TEST(MeshFit, FlippedAndExchangedUvsAreFoundWithoutBlackCharts) {
    FitScene scene;
    scene.light(0);
    EXPECT_THAT(scene.codes([](glm::dvec2 uv) { return glm::dvec2(uv.x, 1 - uv.y); }), ElementsAre("flipped-v"));
    EXPECT_THAT(scene.finding.found, HasSubstr("; with V upside down it is 0.0 % and 0.0 %"));
    EXPECT_THAT(scene.codes([](glm::dvec2 uv) { return glm::dvec2(uv.y, uv.x); }), ElementsAre("wrong-mesh"));
    EXPECT_THAT(scene.finding.found, HasSubstr("; with U and V exchanged it is 0.0 % and 0.0 %"));
}

TEST(MeshFit, APartOfTheMeshIsFound) {
    for (const int margin : {0, 2}) {
        FitScene scene;
        scene.light(margin);
        EXPECT_THAT(scene.codes([](glm::dvec2 uv) { return uv; }, 1), ElementsAre("wrong-mesh"));
        EXPECT_THAT(scene.finding.found,
                    AllOf(HasSubstr("with light or coverage outside the mesh"), HasSubstr("and neither in 0.0 % of the")));
    }
    // A chart without light is black, and no fault of the mesh.
    FitScene scene;
    scene.light(0);
    for (int y = 0; y < 36; ++y)
        for (int x = 30; x < kFitSide; ++x) scene.set(x, y, 0);
    EXPECT_THAT(scene.codes(), ElementsAre("black-charts"));
}

TEST(MeshFit, MapsOfNodesHavePlaces) {
    FitScene scene;
    scene.light(0);
    // Only the first chart of the map is shown, so the rest is unread.
    scene.keys = "[[light_map.place]]\nnode = \"quad0\"\n";
    EXPECT_THAT(scene.codes(), ElementsAre("wrong-mesh", "nodes-without-map"));
    scene.keys =
        "[[light_map.place]]\nnode = \"quad0\"\nscale = [2, 2]\n[[light_map.place]]\nnode = \"quad1\"\nscale = [2, "
        "2]\n[[light_map.place]]\nnode = \"quad2\"\nscale = [2, 2.0]\n";
    EXPECT_THAT(scene.codes([](glm::dvec2 uv) { return uv / 2.0; }), IsEmpty());
    for (const auto& [keys, expected] : std::initializer_list<std::pair<const char*, const char*>>{
             {"[[light_map.place]]\nscale = [1, 1]\n", "found no key 'node' in light_map.place"},
             {"[[light_map.place]]\nnode = \"quad0\"\nscale = [1]\n", "found [1] for light_map.place.scale"},
             {"[[light_map.place]]\nnode = \"quad0\"\nscale = [0, 1]\n", "found [0, 1] for light_map.place.scale"},
             {"[[light_map.place]]\nnode = \"quad0\"\noffset = [0, 1e9]\n", "for light_map.place.offset, expected shares"},
             {"[[light_map.place]]\nnode = \"quad0\"\nturn = 1\n", "found unknown key 'turn' in light_map.place"},
             {"[[light_map.place]]\nnode = \"quad7\"\n", "found no node 'quad7'"}}) {
        scene.keys = keys;
        EXPECT_THAT(scene.codes(), AllOf(testing::Not(IsEmpty()), testing::Each(HasSubstr(expected))));
    }
}

TEST(MeshFit, AMapOfGodotNeedsItsLmbake) {
    FitScene scene;
    scene.light(0);
    formats::writeContent(scene.folder() / "room.exr.import",
                          "[remap]\n\nimporter=\"2d_array_texture\"\n\n[params]\n\nslices/horizontal=1\nslices/vertical=1\n");
    EXPECT_THAT(scene.codes([](glm::dvec2 uv) { return uv * 0.5; }), ElementsAre("no-lmbake"));
    EXPECT_THAT(scene.finding.found, HasSubstr("found a map that Godot imports as slices (2d_array_texture), without room.lmbake"));
    scene.keys = "lmbake = \"none\"\n";
    EXPECT_THAT(scene.codes(), IsEmpty());
    scene.keys = "[[light_map.place]]\nnode = \"quad0\"\n[[light_map.place]]\nnode = \"quad1\"\n[[light_map.place]]\nnode = \"quad2\"\n";
    EXPECT_THAT(scene.codes(), IsEmpty());
}

TEST(MeshFit, CookRefusesTrianglesWithoutUvsByName) {
    FitScene scene;
    scene.light(0);
    (void)scene.codes();
    QuadScene mesh;
    mesh.add({"floor"});
    mesh.add({"Sky", {0, 0}, {1, 1}, false});
    mesh.write(scene.folder() / "room.glb");
    const RunState state;
    CookOptions options;
    options.scene = scene.folder() / "scene.toml";
    options.output = scene.folder() / "out";
    options.cache = scene.folder() / "cache";
    const Outcome outcome = cookScene(options, state);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_THAT(outcome.errors[0].line(), HasSubstr("room.glb: found triangles without TEXCOORD_1 in mesh 1 'SkyMesh' of node 1 'Sky'"));
    EXPECT_EQ(outcome.errors[0].code, formats::ErrorCode::WrongShape);
    EXPECT_FALSE(std::filesystem::exists(options.output / "cooked.json"));
}

}  // namespace
}  // namespace lightcook::pipeline
