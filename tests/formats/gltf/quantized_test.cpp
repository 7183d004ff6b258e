// Vertex attributes of every component type that KHR_mesh_quantization allows, written plain and as Draco, and extensions that hold
// indices of what is written anew.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "formats/gltf_scene.h"
#include "tests/formats/gltf/quad_scene.h"

namespace lightcook::formats {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

json jsonInGlb(const std::filesystem::path& glb) {
    const std::string bytes = contentOf(glb);
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 12, 4);
    return json::parse(bytes.substr(20, length));
}

/// Returns the bytes of a buffer view of a GLB.
std::string viewInGlb(const std::filesystem::path& glb, std::size_t index) {
    const std::string bytes = contentOf(glb);
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 12, 4);
    const json view = jsonInGlb(glb)["bufferViews"][index];
    return bytes.substr(28 + length + view.value("byteOffset", std::size_t{0}), view["byteLength"].get<std::size_t>());
}

/// Writes a mesh as Draco, and returns how far that moved its vertices.
Result<MeshError> errorOfDraco(const std::filesystem::path& source, const std::filesystem::path& draco) {
    const auto scene = GltfScene::load(source);
    if (!scene) return tl::make_unexpected(scene.error());
    if (auto written = scene->writeDraco(draco, {}); !written) return tl::make_unexpected(written.error());
    const auto cooked = GltfScene::load(draco);
    if (!cooked) return tl::make_unexpected(cooked.error());
    return scene->errorOf(*cooked);
}

TEST(QuantizedMesh, EveryTypeOfNormalsSurvivesDraco) {
    for (const QuadScene::Encoding& encoding : {QuadScene::Encoding{}, {5120, 1, true}, {5122, 1, true}}) {
        SCOPED_TRACE(fmt::format("component type {}", encoding.type));
        const TemporaryFolder folder;
        QuadScene quads;
        quads.normals = encoding;
        quads.add({"floor"});
        // Directions that differ, of both signs.
        const double s = std::sqrt(0.5);
        quads.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
            quads.accessor({0, 1, 0, s, 0, -s, -1, 0, 0, -0.6, -0.8, 0}, 3, encoding);
        quads.write(folder / "scene.glb");
        const auto error = errorOfDraco(folder / "scene.glb", folder / "draco.glb");
        ASSERT_TRUE(error) << error.error().line();
        // Integers are kept bit for bit.
        EXPECT_LE(error->normalRadians, encoding.type == 5126 ? 0.01 : 1e-9);
    }
}

TEST(QuantizedMesh, EveryTypeOfPositionsAndUvsSurvivesDraco) {
    const std::vector<QuadScene::Encoding> positions = {{5120, 100, false}, {5120, 1, true}, {5121, 200, false}, {5121, 1, true},
                                                        {5122, 900, false}, {5122, 1, true}, {5123, 900, false}, {5123, 1, true}};
    for (const QuadScene::Encoding& encoding : positions)
        for (const bool isOfUvs : {false, true}) {
            SCOPED_TRACE(fmt::format("component type {}, factor {}, {}", encoding.type, encoding.factor, isOfUvs ? "UVs" : "positions"));
            const TemporaryFolder folder;
            QuadScene quads;
            (isOfUvs ? quads.uvs : quads.positions) = encoding;
            quads.add({"floor", {0.1, 0.2}, {0.7, 0.9}});
            quads.write(folder / "scene.glb");
            const auto error = errorOfDraco(folder / "scene.glb", folder / "draco.glb");
            ASSERT_TRUE(error) << error.error().line();
            EXPECT_LE(isOfUvs ? error->lightMapUv : error->position, 1e-9);
            if (isOfUvs) continue;
            // Bounds are those of the stored integers.
            const json primitive = jsonInGlb(folder / "draco.glb")["meshes"][0]["primitives"][0];
            const json accessor = jsonInGlb(folder / "draco.glb")["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
            const double most = encoding.isNormalized ? std::exp2(encoding.type == 5120   ? 7
                                                                  : encoding.type == 5121 ? 8
                                                                  : encoding.type == 5122 ? 15
                                                                                          : 16) -
                                                            1
                                                      : encoding.factor;
            EXPECT_EQ(accessor["max"], json::array({static_cast<int>(most), 0, static_cast<int>(most)}));
            EXPECT_EQ(accessor["min"], json::array({0, 0, 0}));
            EXPECT_TRUE(accessor["max"][0].is_number_integer());
        }
}

TEST(QuantizedMesh, UncompressedDataGoBeforeMeshopt) {
    const TemporaryFolder folder;
    QuadScene quads;
    quads.add({"floor"});
    // An animation that nothing writes anew, with a copy of its data that is compressed.
    const std::size_t view = quads.view(std::string(8, '\0'), 0);
    quads.json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"] = {
        {"buffer", 1}, {"byteLength", 4}, {"byteStride", 4}, {"count", 2}, {"mode", "ATTRIBUTES"}};
    quads.json["accessors"].push_back({{"bufferView", view}, {"componentType", 5126}, {"count", 2}, {"type", "SCALAR"}});
    const std::size_t accessor = quads.json["accessors"].size() - 1;
    quads.json["animations"] = {{{"samplers", {{{"input", accessor}, {"output", accessor}}}}, {"channels", json::array()}}};
    quads.json["extensionsUsed"] = {"EXT_meshopt_compression"};
    writeContent(folder / "compressed.bin", "abcd");
    quads.json["buffers"] = {{{"byteLength", quads.binary.size()}}, {{"byteLength", 4}, {"uri", "compressed.bin"}}};
    quads.write(folder / "scene.glb");
    const auto scene = GltfScene::load(folder / "scene.glb");
    ASSERT_TRUE(scene) << scene.error().line();
    ASSERT_TRUE(scene->writePlain(folder / "plain.glb", nullptr));
    const json written = jsonInGlb(folder / "plain.glb");
    EXPECT_EQ(written.dump().find("meshopt"), std::string::npos);
    EXPECT_EQ(written["buffers"].size(), 1u);

    // Without data that are not compressed, the scene is refused, with what undoes it.
    for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
        quads.json["extensionsRequired"] = {name};
        quads.write(folder / "scene.glb");
        EXPECT_THAT(GltfScene::load(folder / "scene.glb").error().line(),
                    AllOf(HasSubstr(fmt::format("extensionsRequired: found {}, expected plain or Draco geometry", name)),
                          HasSubstr("`gltf-transform copy IN.glb OUT.glb` undoes it")));
    }
    quads.json.erase("extensionsRequired");
    quads.json["buffers"][1] = {{"byteLength", 4}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}};
    quads.write(folder / "scene.glb");
    EXPECT_THAT(GltfScene::load(folder / "scene.glb").error().line(), HasSubstr("buffer 1: found EXT_meshopt_compression"));
}

TEST(ForeignExtension, ItsIndicesStayThoseOfTheirData) {
    const TemporaryFolder folder;
    QuadScene quads;
    quads.add({"floor"});
    const std::size_t view = quads.view("a table", 0);
    quads.json["accessors"].push_back(
        {{"bufferView", quads.view(std::string(4, 'x'), 0)}, {"componentType", 5121}, {"count", 4}, {"type", "SCALAR"}});
    const std::size_t accessor = quads.json["accessors"].size() - 1;
    quads.json["extensions"]["EXT_structural_metadata"]["propertyTables"] = {{{"properties", {{"height", {{"values", view}}}}}}};
    quads.json["nodes"][0]["extensions"]["VENDOR_edges"] = {{"visibility", accessor}};
    quads.json["extensionsUsed"] = {"EXT_structural_metadata", "VENDOR_edges"};
    quads.write(folder / "scene.glb");
    const auto scene = GltfScene::load(folder / "scene.glb");
    ASSERT_TRUE(scene) << scene.error().line();
    ASSERT_TRUE(scene->writeDraco(folder / "draco.glb", {}));
    const json written = jsonInGlb(folder / "draco.glb");
    EXPECT_EQ(written["extensions"], quads.json["extensions"]);
    EXPECT_EQ(viewInGlb(folder / "draco.glb", view), "a table");
    EXPECT_EQ(viewInGlb(folder / "draco.glb", written["accessors"][accessor]["bufferView"].get<std::size_t>()), "xxxx");
    // Every view lies in the buffer.
    for (const json& each : written["bufferViews"]) {
        EXPECT_GT(each["byteLength"], 0);
        EXPECT_LE(each["byteOffset"].get<std::size_t>() + each["byteLength"].get<std::size_t>(),
                  written["buffers"][0]["byteLength"].get<std::size_t>());
    }
    EXPECT_TRUE(GltfScene::load(folder / "draco.glb"));
}

TEST(ForeignExtension, APrimitiveWhoseOrderMayCountIsKept) {
    const TemporaryFolder folder;
    QuadScene quads;
    quads.add({"floor"});
    json& primitive = quads.json["meshes"][0]["primitives"][0];
    primitive["extensions"]["CESIUM_primitive_outline"] = {{"indices", primitive["indices"]}};
    quads.add({"wall", {0, 0}, {0.5, 0.5}});
    quads.json["extensionsUsed"] = {"CESIUM_primitive_outline"};
    quads.write(folder / "scene.glb");
    ASSERT_TRUE(GltfScene::load(folder / "scene.glb")->writeDraco(folder / "draco.glb", {}));
    const json written = jsonInGlb(folder / "draco.glb");
    EXPECT_FALSE(written["meshes"][0]["primitives"][0]["extensions"].contains("KHR_draco_mesh_compression"));
    EXPECT_TRUE(written["meshes"][1]["primitives"][0]["extensions"].contains("KHR_draco_mesh_compression"));
    EXPECT_EQ(written["meshes"][0]["primitives"][0]["indices"], quads.json["meshes"][0]["primitives"][0]["indices"]);
}

TEST(ForeignExtension, AReferenceToABufferIsRefused) {
    const TemporaryFolder folder;
    QuadScene quads;
    quads.add({"floor"});
    quads.json["extensions"]["VENDOR_stream"] = {{"buffer", 0}};
    quads.json["extensionsUsed"] = {"VENDOR_stream"};
    quads.write(folder / "scene.glb");
    const auto written = GltfScene::load(folder / "scene.glb")->writePlain(folder / "plain.glb", nullptr);
    ASSERT_FALSE(written);
    EXPECT_THAT(written.error().line(), HasSubstr("scene.glb, VENDOR_stream: found a reference to buffer 0"));
    EXPECT_FALSE(std::filesystem::exists(folder / "plain.glb"));
}

}  // namespace
}  // namespace lightcook::formats
