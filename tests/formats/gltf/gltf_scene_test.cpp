#include "formats/gltf_scene.h"

#include <draco/io/mesh_io.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <set>
#include <span>

#include "formats/gltf/material_needs.h"
#include "formats/gltf_light_map.h"
#include "tests/formats/gltf/glb.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

/// A glTF being put together: arrays become accessors of one buffer.
struct GltfMaker {
    json document = {{"asset", {{"version", "2.0"}}},
                     {"accessors", json::array()},
                     {"bufferViews", json::array()},
                     {"meshes", json::array({{{"primitives", json::array()}}})}};
    std::string buffer;

    std::size_t view(const void* bytes, std::size_t size) {
        buffer.resize((buffer.size() + 3) / 4 * 4);
        document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", size}});
        buffer.append(static_cast<const char*>(bytes), size);
        return document["bufferViews"].size() - 1;
    }
    template <class Component>
    std::size_t accessor(const std::vector<Component>& values, int componentType, const std::string& type, std::size_t componentCount) {
        document["accessors"].push_back({{"bufferView", view(values.data(), values.size() * sizeof(Component))},
                                         {"componentType", componentType},
                                         {"count", values.size() / componentCount},
                                         {"type", type}});
        return document["accessors"].size() - 1;
    }
    std::size_t floats(const std::vector<float>& values, std::size_t componentCount) {
        return accessor(values, 5126, componentCount == 1 ? "SCALAR" : fmt::format("VEC{}", componentCount), componentCount);
    }
    json& primitives() { return document["meshes"][0]["primitives"]; }

    void writeGlb(const std::filesystem::path& file) const {
        json whole = document;
        if (!buffer.empty()) whole["buffers"] = json::array({{{"byteLength", buffer.size()}}});
        writeContent(file, glbOf(whole.dump(), buffer));
    }
};

/// A cube of 24 vertices with normals, both UV sets, colours as bytes and tangents; its six faces are two primitives that share the
/// vertices.
GltfMaker cube() {
    std::vector<float> positions, normals, uvs, lightMapUvs, tangents;
    std::vector<std::uint8_t> colors;
    std::vector<std::uint16_t> indices;
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        const float sign = face % 2 == 0 ? 1.0f : -1.0f;
        for (int corner = 0; corner < 4; ++corner) {
            const float u = corner == 1 || corner == 2 ? 1.0f : -1.0f, v = corner >= 2 ? 1.0f : -1.0f;
            std::array<float, 3> position{}, normal{}, tangent{};
            position[static_cast<std::size_t>(axis)] = sign;
            position[static_cast<std::size_t>((axis + 1) % 3)] = u * sign;
            position[static_cast<std::size_t>((axis + 2) % 3)] = v;
            normal[static_cast<std::size_t>(axis)] = sign;
            tangent[static_cast<std::size_t>((axis + 1) % 3)] = sign;
            positions.insert(positions.end(), position.begin(), position.end());
            normals.insert(normals.end(), normal.begin(), normal.end());
            tangents.insert(tangents.end(), {tangent[0], tangent[1], tangent[2], 0.123456f * static_cast<float>(face)});
            uvs.insert(uvs.end(), {0.5f * u + 0.5f, 0.5f * v + 0.5f});
            const int column = face % 3, row = face / 3;
            lightMapUvs.insert(lightMapUvs.end(), {(static_cast<float>(column) + 0.45f * u + 0.5f) / 3.0f,
                                                   (static_cast<float>(row) + 0.45f * v + 0.5f) / 2.0f});
            colors.insert(colors.end(), {static_cast<std::uint8_t>(40 * face), static_cast<std::uint8_t>(60 * corner), 7, 255});
        }
        for (const int corner : {0, 1, 2, 0, 2, 3}) indices.push_back(static_cast<std::uint16_t>(4 * face + corner));
    }
    GltfMaker maker;
    json attributes;
    attributes["POSITION"] = maker.floats(positions, 3);
    attributes["NORMAL"] = maker.floats(normals, 3);
    attributes["TEXCOORD_0"] = maker.floats(uvs, 2);
    attributes["TEXCOORD_1"] = maker.floats(lightMapUvs, 2);
    attributes["TANGENT"] = maker.floats(tangents, 4);
    attributes["COLOR_0"] = maker.accessor(colors, 5121, "VEC4", 4);
    maker.document["accessors"].back()["normalized"] = true;
    const std::vector<std::uint16_t> first(indices.begin(), indices.begin() + 18), second(indices.begin() + 18, indices.end());
    maker.primitives().push_back({{"attributes", attributes}, {"indices", maker.accessor(first, 5123, "SCALAR", 1)}, {"material", 0}});
    maker.primitives().push_back({{"attributes", attributes}, {"indices", maker.accessor(second, 5123, "SCALAR", 1)}, {"material", 1}});
    maker.document["materials"] = json::array({{{"name", "a"}}, {{"name", "b"}, {"extras", {{"bufferView", 77}}}}});
    maker.document["nodes"] =
        json::array({{{"mesh", 0}, {"name", "box"}, {"rotation", {0.1, 0.7071067811865476, 0.0, 0.7}}, {"extras", {{"note", "kept"}}}}});
    maker.document["scenes"] = json::array({{{"nodes", {0}}}});
    return maker;
}

GltfScene loaded(const std::filesystem::path& file) {
    auto scene = GltfScene::load(file);
    if (!scene) throw std::runtime_error(scene.error().line());
    return std::move(*scene);
}

Error refusal(const std::filesystem::path& file) {
    const auto scene = GltfScene::load(file);
    EXPECT_FALSE(scene) << file;
    if (scene) return {};
    EXPECT_EQ(scene.error().line().find('\n'), std::string::npos);
    EXPECT_THAT(scene.error().line(), AllOf(HasSubstr(file.filename().string()), HasSubstr("found"), HasSubstr("expected")));
    return scene.error();
}

Error refusal(const GltfMaker& maker) {
    const TemporaryFolder folder;
    maker.writeGlb(folder / "scene.glb");
    return refusal(folder / "scene.glb");
}

/// Returns the JSON of a GLB.
json jsonOf(const std::filesystem::path& glb) {
    const std::string bytes = contentOf(glb);
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 12, 4);
    return json::parse(bytes.substr(20, length));
}

TEST(GltfScene, ACubeIsCountedOnce) {
    const TemporaryFolder folder;
    cube().writeGlb(folder / "cube.glb");
    const GltfScene scene = loaded(folder / "cube.glb");
    EXPECT_EQ(scene.vertexCount(), 24);
    EXPECT_EQ(scene.triangleCount(), 12);
    EXPECT_TRUE(scene.hasLightMapUvs());
    ASSERT_EQ(scene.materials().size(), 2u);
    EXPECT_EQ(scene.materials()[1].name, "b");
}

TEST(GltfScene, DracoComesBackWithinItsQuantization) {
    const TemporaryFolder folder;
    cube().writeGlb(folder / "cube.glb");
    const GltfScene scene = loaded(folder / "cube.glb");
    for (const int bits : {8, 11, 16}) {
        const auto size = scene.writeDraco(folder / "cooked.glb",
                                           {.positionBits = bits, .normalBits = 10, .uvBits = 12, .lightMapUvBits = bits, .speed = 3});
        ASSERT_TRUE(size) << size.error().line();
        EXPECT_EQ(size->fileBytesOut, std::filesystem::file_size(folder / "cooked.glb"));
        EXPECT_EQ(size->fileBytesIn, std::filesystem::file_size(folder / "cube.glb"));
        EXPECT_EQ(size->triangleCount, 12);
        EXPECT_EQ(size->vertexCount, 24);
        const GltfScene cooked = loaded(folder / "cooked.glb");
        EXPECT_EQ(cooked.triangleCount(), 12);
        EXPECT_TRUE(cooked.hasLightMapUvs());
        const auto error = scene.errorOf(cooked);
        ASSERT_TRUE(error) << error.error().line();
        const double steps = std::ldexp(1.0, bits) - 1;
        EXPECT_LE(error->position, 0.5 * std::sqrt(3.0) * 2.0 / steps + 1e-6) << bits;  // half a step on each axis, the cube is 2 wide
        EXPECT_LE(error->lightMapUv, 0.5 * std::sqrt(2.0) / steps + 1e-6) << bits;
        EXPECT_GT(error->lightMapUv, 1e-9) << "0.0167 and the like are on no lattice";
        EXPECT_LE(error->normalRadians, 0.01) << bits;  // 10 bits: 2 / 1023 across the octahedron's square
        const std::map<std::string, std::set<int>> written = {
            {"NORMAL", {10}}, {"POSITION", {bits}}, {"TEXCOORD_0", {12}}, {"TEXCOORD_1", {bits}}};
        EXPECT_EQ(error->dracoBits, written);
    }
}

TEST(GltfScene, TheSameSceneGivesTheSameBytes) {
    const TemporaryFolder folder;
    cube().writeGlb(folder / "cube.glb");
    ASSERT_TRUE(loaded(folder / "cube.glb").writeDraco(folder / "a.glb", {}));
    ASSERT_TRUE(loaded(folder / "cube.glb").writeDraco(folder / "b.glb", {}));
    EXPECT_EQ(contentOf(folder / "a.glb"), contentOf(folder / "b.glb"));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 3) << "nothing else is left behind";
}

TEST(GltfScene, EverythingBesideGeometryIsKept) {
    const TemporaryFolder folder;
    GltfMaker maker = cube();
    const std::string png = "\x89PNG of sorts";
    maker.document["images"] =
        json::array({{{"bufferView", maker.view(png.data(), png.size())}, {"mimeType", "image/png"}, {"name", "inside"}},
                     {{"uri", "../beside%20it.png"}},
                     {{"uri", "absent.png"}},
                     {{"uri", "/etc/passwd"}}});
    std::filesystem::create_directories(folder / "scene");
    writeContent(folder / "beside it.png", png);
    const std::vector<float> times = {0.0f, 0.5f, 1.0f}, places(9, 0.25f);
    maker.document["animations"] =
        json::array({{{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
                      {"samplers", {{{"input", maker.floats(times, 1)}, {"output", maker.floats(places, 3)}}}}}});
    maker.document["extensionsUsed"] = {"KHR_lights_punctual"};
    maker.document["extensions"]["KHR_lights_punctual"]["lights"] = json::array({{{"type", "point"}, {"intensity", 1234.5678901234567}}});
    maker.document["extensions"]["VENDOR_blob"] = {{"bufferView", maker.view("blob", 4)}};
    maker.writeGlb(folder / "scene/scene.glb");
    const GltfScene scene = loaded(folder / "scene/scene.glb");
    ASSERT_TRUE(scene.writeDraco(folder / "cooked.glb", {}));
    const json before = jsonOf(folder / "scene/scene.glb"), after = jsonOf(folder / "cooked.glb");
    for (const char* key : {"asset", "materials", "nodes", "scenes", "animations"}) EXPECT_EQ(after[key], before[key]) << key;
    EXPECT_EQ(after["extensions"]["KHR_lights_punctual"], before["extensions"]["KHR_lights_punctual"]);
    EXPECT_EQ(after["extensionsUsed"], json({"KHR_lights_punctual", "KHR_draco_mesh_compression"}));
    EXPECT_EQ(after["extensionsRequired"], json({"KHR_draco_mesh_compression"}));
    EXPECT_EQ(after["images"][0]["name"], "inside");
    EXPECT_EQ(after["images"][1]["mimeType"], "image/png") << "embedded";
    EXPECT_FALSE(after["images"][1].contains("uri"));
    EXPECT_EQ(after["images"][2]["uri"], "absent.png");
    EXPECT_EQ(after["images"][3]["uri"], "/etc/passwd") << "no picture";

    const auto bytesOf = [&](const json& document, const std::filesystem::path& file, std::size_t view) {
        const std::string content = contentOf(file);
        std::uint32_t jsonLength = 0;
        std::memcpy(&jsonLength, content.data() + 12, 4);
        const json& v = document["bufferViews"][view];
        return content.substr(28 + jsonLength + v.value("byteOffset", std::size_t{0}), v["byteLength"].get<std::size_t>());
    };
    EXPECT_EQ(bytesOf(after, folder / "cooked.glb", after["images"][0]["bufferView"]), png);
    EXPECT_EQ(bytesOf(after, folder / "cooked.glb", after["images"][1]["bufferView"]), png);
    EXPECT_EQ(bytesOf(after, folder / "cooked.glb", after["extensions"]["VENDOR_blob"]["bufferView"]), "blob");
    for (const char* end : {"input", "output"}) {
        const std::size_t accessor = before["animations"][0]["samplers"][0][end];
        EXPECT_EQ(bytesOf(after, folder / "cooked.glb", after["accessors"][accessor]["bufferView"]),
                  bytesOf(before, folder / "scene/scene.glb", before["accessors"][accessor]["bufferView"]));
    }
    EXPECT_EQ(after["extensions"]["VENDOR_blob"], before["extensions"]["VENDOR_blob"]) << "nobody knows what its numbers mean";
    const json& primitive = after["meshes"][0]["primitives"][1];
    for (const char* name : {"POSITION", "NORMAL", "TEXCOORD_0", "TEXCOORD_1", "TANGENT", "COLOR_0"})
        EXPECT_TRUE(primitive["extensions"]["KHR_draco_mesh_compression"]["attributes"].contains(name)) << name;
}

// Draco's own glTF reader, which parses the file with a tinygltf of its own.
TEST(GltfScene, AnotherReaderFindsTheSameCube) {
    const TemporaryFolder folder;
    cube().writeGlb(folder / "cube.glb");
    ASSERT_TRUE(loaded(folder / "cube.glb").writeDraco(folder / "cooked.glb", {}));
    const auto plain = draco::ReadMeshFromFile((folder / "cube.glb").string());
    const auto cooked = draco::ReadMeshFromFile((folder / "cooked.glb").string());
    ASSERT_TRUE(plain.ok()) << plain.status().error_msg_string();
    ASSERT_TRUE(cooked.ok()) << cooked.status().error_msg_string();
    EXPECT_EQ(cooked.value()->num_faces(), 12u);
    EXPECT_EQ(cooked.value()->num_attributes(), plain.value()->num_attributes());
    const draco::BoundingBox expected = plain.value()->ComputeBoundingBox(), found = cooked.value()->ComputeBoundingBox();
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(found.GetMinPoint()[axis], expected.GetMinPoint()[axis], 2.0 / 16383) << axis;
        EXPECT_NEAR(found.GetMaxPoint()[axis], expected.GetMaxPoint()[axis], 2.0 / 16383) << axis;
    }
}

/// The cube's faces lie in three by two cells of a map of 48 x 32 texels, each under a cluster of its own.
ClusterMap mapOfCube(int firstCluster) {
    ClusterMap map{48, 32, {}};
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 12; ++x) map.ofBlock.push_back(static_cast<std::uint8_t>(firstCluster + x / 4 + 3 * (y / 4)));
    return map;
}

void expectClusters(const GltfScene& scene, int firstCluster) {
    std::size_t vertices = 0;
    for (const TriangleMesh* mesh : scene.triangleMeshes()) {
        const MeshAttribute *uv = mesh->find("TEXCOORD_1"), *cluster = mesh->find(kBasisAttribute);
        ASSERT_TRUE(uv != nullptr && cluster != nullptr);
        EXPECT_EQ(cluster->componentType, ComponentType::Uint8);
        EXPECT_EQ(cluster->componentCount, 1);
        EXPECT_FALSE(cluster->isNormalized);
        ASSERT_EQ(cluster->vertexCount(), uv->vertexCount());
        for (std::size_t i = 0; i < uv->vertexCount(); ++i, ++vertices)
            EXPECT_EQ(cluster->at(i).x, firstCluster + std::floor(3 * uv->at(i).x) + 3 * std::floor(2 * uv->at(i).y));
    }
    EXPECT_EQ(vertices, 24u);
}

TEST(GltfScene, VerticesHaveTheClusterOfTheirChartInDracoAndPlain) {
    const TemporaryFolder folder;
    cube().writeGlb(folder / "cube.glb");
    const GltfScene scene = loaded(folder / "cube.glb");
    const ClusterMap map = mapOfCube(250), other = mapOfCube(7);
    ASSERT_TRUE(scene.writeDraco(folder / "draco.glb", {}, &map));
    ASSERT_TRUE(scene.writePlain(folder / "plain.glb", &map));
    for (const char* first : {"draco.glb", "plain.glb"}) {
        SCOPED_TRACE(first);
        const GltfScene once = loaded(folder / first);
        expectClusters(once, 250);
        const auto error = scene.errorOf(once);
        ASSERT_TRUE(error) << error.error().line();
        EXPECT_EQ(error->lightMapUv > 0, std::string(first) == "draco.glb") << "plain is bit for bit";
        EXPECT_EQ(once.errorOf(once)->dracoBits.size(), 0u) << "a stream of the source";
        // The clusters of another cook are not kept beside the new ones.
        ASSERT_TRUE(once.writeDraco(folder / "again.glb", {}, &other));
        expectClusters(loaded(folder / "again.glb"), 7);
        ASSERT_TRUE(once.writePlain(folder / "again.glb", &other));
        expectClusters(loaded(folder / "again.glb"), 7);
        EXPECT_EQ(once.errorOf(loaded(folder / "again.glb"))->lightMapUv, 0);
    }
    ASSERT_TRUE(scene.writeDraco(folder / "none.glb", {}));
    const GltfScene none = loaded(folder / "none.glb");
    for (const TriangleMesh* mesh : none.triangleMeshes()) EXPECT_EQ(mesh->find(kBasisAttribute), nullptr);
}

/// New UVs that tell primitive and vertex.
std::vector<std::vector<glm::vec2>> numberedUvs(const GltfScene& scene) {
    std::vector<std::vector<glm::vec2>> uvs;
    for (const TriangleMesh* mesh : scene.triangleMeshes()) {
        const auto primitive = static_cast<float>(uvs.size());
        uvs.emplace_back();
        for (std::size_t i = 0; i < mesh->vertexCount(); ++i) uvs.back().emplace_back(static_cast<float>(i) / 64, primitive / 8);
    }
    return uvs;
}

TEST(GltfScene, LightMapUvsAreReplacedAndNothingElse) {
    const TemporaryFolder folder;
    cube().writeGlb(folder / "cube.glb");
    const GltfScene scene = loaded(folder / "cube.glb");
    const auto uvs = numberedUvs(scene);
    ASSERT_TRUE(scene.writeLightMapUvs(folder / "moved.glb", uvs));
    const GltfScene moved = loaded(folder / "moved.glb");
    const auto before = scene.triangleMeshes(), after = moved.triangleMeshes();
    ASSERT_EQ(after.size(), before.size());
    for (std::size_t mesh = 0; mesh < before.size(); ++mesh) {
        EXPECT_EQ(after[mesh]->indices, before[mesh]->indices);
        for (const MeshAttribute& attribute : before[mesh]->attributes) {
            const MeshAttribute* found = after[mesh]->find(attribute.semantic);
            ASSERT_NE(found, nullptr) << attribute.semantic;
            if (attribute.semantic == "TEXCOORD_1") continue;
            EXPECT_EQ(found->values, attribute.values) << attribute.semantic;
        }
        const MeshAttribute* uv = after[mesh]->find("TEXCOORD_1");
        for (std::size_t i = 0; i < uvs[mesh].size(); ++i) EXPECT_EQ(glm::dvec2(uv->at(i)), glm::dvec2(uvs[mesh][i])) << mesh << " " << i;
    }
    for (std::size_t mesh = 0; mesh < before.size(); ++mesh)
        EXPECT_EQ(after[mesh]->find("TEXCOORD_2")->values, before[mesh]->find("TEXCOORD_1")->values) << "the old ones are kept";
}

/// They would read other texels of the new map, and nothing says which ones they should.
TEST(GltfScene, LinesHaveNoLightMapUvsBesideReplacedOnes) {
    const TemporaryFolder folder;
    GltfMaker maker = cube();
    const json uvs = maker.primitives()[0]["attributes"]["TEXCOORD_1"];
    for (const int mode : {0, 1})
        maker.primitives().push_back(
            {{"attributes", {{"POSITION", 0}, {"TEXCOORD_0", uvs}, {"TEXCOORD_1", uvs}}}, {"mode", mode}, {"material", 0}});
    maker.writeGlb(folder / "cube.glb");
    const GltfScene scene = loaded(folder / "cube.glb");
    ASSERT_TRUE(scene.writeLightMapUvs(folder / "moved.glb", numberedUvs(scene)));
    const json primitives = jsonOf(folder / "moved.glb")["meshes"][0]["primitives"];
    ASSERT_EQ(primitives.size(), 4u);
    for (const std::size_t i : {0, 1}) EXPECT_TRUE(primitives[i]["attributes"].contains("TEXCOORD_1"));
    for (const std::size_t i : {2, 3}) EXPECT_EQ(primitives[i]["attributes"], (json{{"POSITION", 0}, {"TEXCOORD_0", uvs}}));
    EXPECT_TRUE(loaded(folder / "moved.glb").hasLightMapUvs());
    ASSERT_TRUE(scene.writePlain(folder / "plain.glb", nullptr));
    EXPECT_EQ(jsonOf(folder / "plain.glb")["meshes"][0]["primitives"], maker.primitives()) << "which are not replaced";

    maker.primitives()[3]["attributes"]["TEXCOORD_2"] = uvs;
    maker.writeGlb(folder / "cube.glb");
    const GltfScene further = loaded(folder / "cube.glb");
    const auto refused = further.writeLightMapUvs(folder / "none.glb", numberedUvs(further));
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().line().find("cube.glb, mesh 0, primitive 3: found TEXCOORD_1 and TEXCOORD_2 on lines or points"),
              std::string::npos)
        << refused.error().line();
    EXPECT_FALSE(std::filesystem::exists(folder / "none.glb"));
}

TEST(GltfScene, LightMapUvsOfDracoStreamsAreReplaced) {
    const TemporaryFolder folder;
    cube().writeGlb(folder / "cube.glb");
    ASSERT_TRUE(loaded(folder / "cube.glb").writeDraco(folder / "draco.glb", {}));
    const GltfScene scene = loaded(folder / "draco.glb");
    // Draco may reorder vertices: a new UV is told by the old one.
    std::vector<std::vector<glm::vec2>> uvs;
    for (const TriangleMesh* mesh : scene.triangleMeshes()) {
        uvs.emplace_back();
        for (std::size_t i = 0; i < mesh->vertexCount(); ++i)
            uvs.back().emplace_back(glm::vec2(mesh->find("TEXCOORD_1")->at(i)) * 0.5f + 0.25f);
    }
    ASSERT_TRUE(scene.writeLightMapUvs(folder / "moved.glb", uvs));
    const GltfScene moved = loaded(folder / "moved.glb");
    const auto before = scene.triangleMeshes(), after = moved.triangleMeshes();
    ASSERT_EQ(after.size(), before.size());
    const auto cornersOf = [](const TriangleMesh& mesh, bool isMoved) {
        std::multiset<std::array<double, 5>> corners;
        for (const std::uint32_t vertex : mesh.indices) {
            const glm::dvec3 position = mesh.find("POSITION")->at(vertex);
            const glm::vec2 uv = glm::vec2(mesh.find("TEXCOORD_1")->at(vertex)), wanted = isMoved ? uv : uv * 0.5f + 0.25f;
            corners.insert({position.x, position.y, position.z, static_cast<double>(wanted.x), static_cast<double>(wanted.y)});
        }
        return corners;
    };
    for (std::size_t mesh = 0; mesh < before.size(); ++mesh) EXPECT_EQ(cornersOf(*after[mesh], true), cornersOf(*before[mesh], false));
    for (const TriangleMesh* mesh : after)
        for (std::size_t i = 0; i < mesh->vertexCount(); ++i)
            EXPECT_EQ(glm::vec2(mesh->find("TEXCOORD_2")->at(i)) * 0.5f + 0.25f, glm::vec2(mesh->find("TEXCOORD_1")->at(i)));
}

TEST(GltfScene, AnAccessorThatIsAnotherUvSetTooKeepsItsValues) {
    const TemporaryFolder folder;
    GltfMaker maker = cube();
    for (json& primitive : maker.primitives()) primitive["attributes"]["TEXCOORD_0"] = primitive["attributes"]["TEXCOORD_1"];
    maker.writeGlb(folder / "cube.glb");
    const GltfScene scene = loaded(folder / "cube.glb");
    const auto uvs = numberedUvs(scene);
    ASSERT_TRUE(scene.writeLightMapUvs(folder / "moved.glb", uvs));
    const GltfScene moved = loaded(folder / "moved.glb");
    const auto before = scene.triangleMeshes(), after = moved.triangleMeshes();
    for (std::size_t mesh = 0; mesh < before.size(); ++mesh) {
        EXPECT_EQ(after[mesh]->find("TEXCOORD_0")->values, before[mesh]->find("TEXCOORD_1")->values);
        for (std::size_t i = 0; i < uvs[mesh].size(); ++i)
            EXPECT_EQ(glm::dvec2(after[mesh]->find("TEXCOORD_1")->at(i)), glm::dvec2(uvs[mesh][i]));
    }
}

TEST(GltfScene, PlacedMeshesSayWhetherBothSidesShow) {
    const TemporaryFolder folder;
    for (const bool isDoubleSided : {false, true}) {
        GltfMaker maker = cube();
        for (json& material : maker.document["materials"])
            if (isDoubleSided) material["doubleSided"] = true;
        maker.writeGlb(folder / "cube.glb");
        const auto placed = loaded(folder / "cube.glb").placedMeshes();
        ASSERT_FALSE(placed.empty());
        for (const GltfScene::Placed& each : placed) EXPECT_EQ(each.isDoubleSided, isDoubleSided);
    }
}

TEST(GltfScene, LightMapUvsAreThoseOfTrianglesThatANodeDraws) {
    const TemporaryFolder folder;
    const auto refusalOf = [&](const GltfMaker& maker) {
        maker.writeGlb(folder / "scene.glb");
        const auto checked = formats::checkLightMapUvs(folder / "scene.glb");
        return checked ? std::string() : checked.error().line();
    };
    EXPECT_EQ(refusalOf(cube()), "");
    GltfMaker plain = cube();
    for (json& primitive : plain.primitives()) primitive["attributes"].erase("TEXCOORD_1");
    EXPECT_THAT(refusalOf(plain), HasSubstr("scene.glb: found no triangles with TEXCOORD_1, expected the light-map UVs"));
    GltfMaker lines = cube();
    for (json& primitive : lines.primitives()) primitive["mode"] = 1;
    EXPECT_THAT(refusalOf(lines), HasSubstr("found no triangles with TEXCOORD_1"));
    GltfMaker undrawn = cube();
    for (json& node : undrawn.document["nodes"]) node.erase("mesh");
    EXPECT_THAT(refusalOf(undrawn), HasSubstr("found no triangles with TEXCOORD_1"));
    formats::writeContent(folder / "scene.glb", "no glTF");
    const auto unreadable = formats::checkLightMapUvs(folder / "scene.glb");
    ASSERT_FALSE(unreadable);
    EXPECT_EQ(unreadable.error().line(), GltfScene::load(folder / "scene.glb").error().line());
}

TEST(GltfScene, VerticesOfUnknownOrderKeepItAndHaveTheirCluster) {
    const TemporaryFolder folder;
    GltfMaker maker = cube();
    const std::size_t moved = maker.floats(std::vector<float>(72, 0.125f), 3);
    for (json& primitive : maker.primitives()) primitive["targets"] = json::array({{{"POSITION", moved}}});
    maker.writeGlb(folder / "scene.glb");
    const ClusterMap map = mapOfCube(0);
    ASSERT_TRUE(loaded(folder / "scene.glb").writeDraco(folder / "cooked.glb", {}, &map));
    expectClusters(loaded(folder / "cooked.glb"), 0);
    const json after = jsonOf(folder / "cooked.glb");
    for (const json& primitive : after["meshes"][0]["primitives"]) {
        EXPECT_EQ(primitive["targets"][0]["POSITION"], moved);
        const json& accessor = after["accessors"][primitive["attributes"][kBasisAttribute].get<std::size_t>()];
        EXPECT_EQ(accessor["count"], 24) << "as many as the accessors beside it";
        EXPECT_EQ(after["bufferViews"][accessor["bufferView"].get<std::size_t>()]["byteStride"], 4);
    }
}

/// A bumpy sheet: many triangles, one primitive.
GltfMaker sheet(int extent, unsigned seed) {
    std::mt19937 random(seed);
    const auto number = [&random] { return static_cast<float>(random() >> 8) / 16777216.0f; };
    std::vector<float> positions, normals, lightMapUvs;
    std::vector<std::uint32_t> indices;
    for (int y = 0; y <= extent; ++y) {
        for (int x = 0; x <= extent; ++x) {
            const float u = static_cast<float>(x) / static_cast<float>(extent), v = static_cast<float>(y) / static_cast<float>(extent);
            positions.insert(positions.end(), {10 * u, 0.5f * number(), 10 * v});
            const glm::vec3 normal = glm::normalize(glm::vec3(number() - 0.5f, 1, number() - 0.5f));
            normals.insert(normals.end(), {normal.x, normal.y, normal.z});
            lightMapUvs.insert(lightMapUvs.end(), {u, v});
        }
    }
    for (int y = 0; y < extent; ++y) {
        for (int x = 0; x < extent; ++x) {
            const auto a = static_cast<std::uint32_t>(y * (extent + 1) + x), b = a + 1, c = a + static_cast<std::uint32_t>(extent) + 1,
                       d = c + 1;
            for (const std::uint32_t index : {a, c, b, b, c, d}) indices.push_back(index);
        }
    }
    GltfMaker maker;
    json attributes = {
        {"POSITION", maker.floats(positions, 3)}, {"NORMAL", maker.floats(normals, 3)}, {"TEXCOORD_1", maker.floats(lightMapUvs, 2)}};
    maker.primitives().push_back({{"attributes", attributes}, {"indices", maker.accessor(indices, 5125, "SCALAR", 1)}});
    return maker;
}

TEST(GltfSceneSoak, ErrorsOfABigMeshStayWithinTheStepsAndShrinkWithBits) {
    const TemporaryFolder folder;
    sheet(60, 3).writeGlb(folder / "sheet.glb");
    const GltfScene scene = loaded(folder / "sheet.glb");
    double previous = 1e9;
    for (const int bits : {9, 12, 15}) {
        const auto size = scene.writeDraco(folder / "cooked.glb", {.positionBits = bits, .lightMapUvBits = bits});
        ASSERT_TRUE(size) << size.error().line();
        EXPECT_LT(size->fileBytesOut, size->fileBytesIn / 3);
        const auto error = scene.errorOf(loaded(folder / "cooked.glb"));
        ASSERT_TRUE(error) << error.error().line();
        const double steps = std::ldexp(1.0, bits) - 1;
        EXPECT_LE(error->position, 0.5 * std::sqrt(3.0) * 10 / steps + 2e-6);
        EXPECT_GE(error->position, 0.3 * 10 / steps) << "of 3,721 random heights one is near the middle between two steps";
        EXPECT_LE(error->lightMapUv, 0.5 * std::sqrt(2.0) / steps + 1e-6);
        EXPECT_LT(error->position, previous);
        previous = error->position;
    }
    const auto coarse = scene.writeDraco(folder / "cooked.glb", {.normalBits = 6});
    ASSERT_TRUE(coarse);
    const double normal = scene.errorOf(loaded(folder / "cooked.glb"))->normalRadians;
    EXPECT_GT(normal, 0.01);
    EXPECT_LT(normal, 0.1);
}

TEST(GltfScene, ErrorOfTellsAForeignScene) {
    const TemporaryFolder folder;
    sheet(10, 3).writeGlb(folder / "a.glb");
    sheet(10, 4).writeGlb(folder / "b.glb");
    sheet(9, 3).writeGlb(folder / "c.glb");
    const GltfScene a = loaded(folder / "a.glb");
    ASSERT_TRUE(a.writeDraco(folder / "a_cooked.glb", {}));
    const GltfScene cooked = loaded(folder / "a_cooked.glb");
    EXPECT_TRUE(a.errorOf(cooked));
    for (const char* other : {"b.glb", "c.glb"}) {
        const auto error = loaded(folder / other).errorOf(cooked);
        ASSERT_FALSE(error) << other;
        EXPECT_EQ(error.error().code, ErrorCode::Verification);
        EXPECT_THAT(error.error().line(), AllOf(HasSubstr("a_cooked.glb"), HasSubstr("found"), HasSubstr("expected")));
    }
    const auto itself = a.errorOf(a);
    ASSERT_TRUE(itself) << itself.error().line();
    EXPECT_EQ(itself->position, 0);
    EXPECT_EQ(itself->normalRadians, 0);
}

TEST(GltfScene, DegenerateAndDoubledTrianglesAreMatched) {
    const TemporaryFolder folder;
    GltfMaker maker = sheet(6, 5);
    std::vector<std::uint32_t> indices;
    for (const std::uint32_t index : {0u, 7u, 1u, 1u, 7u, 8u, 0u, 7u, 1u, 1u, 7u, 0u, 3u, 3u, 9u, 4u, 5u, 5u})
        indices.push_back(index);  // twice, back to back, two degenerate
    maker.primitives()[0]["indices"] = maker.accessor(indices, 5125, "SCALAR", 1);
    maker.writeGlb(folder / "odd.glb");
    const GltfScene scene = loaded(folder / "odd.glb");
    const auto size = scene.writeDraco(folder / "cooked.glb", {});
    ASSERT_TRUE(size) << size.error().line();
    EXPECT_EQ(size->triangleCount, 4);
    const auto error = scene.errorOf(loaded(folder / "cooked.glb"));
    ASSERT_TRUE(error) << error.error().line();
    EXPECT_LT(error->position, 10.0 / 16383);

    maker.primitives()[0]["indices"] = maker.accessor(std::vector<std::uint32_t>{2, 2, 3, 4, 4, 4}, 5125, "SCALAR", 1);
    maker.writeGlb(folder / "odd.glb");
    const GltfScene nothing = loaded(folder / "odd.glb");
    ASSERT_TRUE(nothing.writeDraco(folder / "cooked.glb", {})) << "what Draco cannot code stays plain";
    EXPECT_FALSE(jsonOf(folder / "cooked.glb").contains("extensionsRequired"));
    EXPECT_TRUE(nothing.errorOf(loaded(folder / "cooked.glb")));
}

TEST(GltfScene, MorphTargetsLinesAndPointsStayAsTheyAre) {
    const TemporaryFolder folder;
    GltfMaker maker = cube();
    const std::size_t moved = maker.floats(std::vector<float>(72, 0.125f), 3);
    maker.primitives()[0]["targets"] = json::array({{{"POSITION", moved}}});
    maker.primitives().push_back({{"attributes", {{"POSITION", 0}, {"TEXCOORD_1", 3}}}, {"mode", 1}, {"material", 0}});
    maker.writeGlb(folder / "scene.glb");
    const GltfScene scene = loaded(folder / "scene.glb");
    ASSERT_TRUE(scene.writeDraco(folder / "cooked.glb", {}));
    const json before = jsonOf(folder / "scene.glb"), after = jsonOf(folder / "cooked.glb");
    EXPECT_EQ(after["meshes"][0]["primitives"][0], before["meshes"][0]["primitives"][0]);
    EXPECT_EQ(after["meshes"][0]["primitives"][2], before["meshes"][0]["primitives"][2]);
    EXPECT_TRUE(after["meshes"][0]["primitives"][1].contains("extensions"));
    const auto error = scene.errorOf(loaded(folder / "cooked.glb"));
    ASSERT_TRUE(error) << error.error().line();
}

/// The cube with its first three faces as one strip, joined by vertices named twice, and the others as a fan each.
GltfMaker cubeOfStripsAndFans() {
    GltfMaker maker = cube();
    const json attributes = maker.primitives()[0]["attributes"];
    const auto setPrimitive = [&](std::size_t index, const std::vector<std::uint16_t>& indices, int mode, int material) {
        maker.primitives()[index] = {
            {"attributes", attributes}, {"indices", maker.accessor(indices, 5123, "SCALAR", 1)}, {"mode", mode}, {"material", material}};
    };
    setPrimitive(0, {1, 2, 0, 3, 3, 5, 5, 6, 4, 7, 7, 9, 9, 10, 8, 11}, 5, 0);
    for (std::size_t face = 3; face < 6; ++face) {
        const auto first = static_cast<std::uint16_t>(4 * face);
        setPrimitive(
            face - 2,
            {first, static_cast<std::uint16_t>(first + 1), static_cast<std::uint16_t>(first + 2), static_cast<std::uint16_t>(first + 3)}, 6,
            1);
    }
    return maker;
}

TEST(GltfScene, StripsAndFansAreTheirTriangles) {
    const TemporaryFolder folder;
    cube().writeGlb(folder / "cube.glb");
    cubeOfStripsAndFans().writeGlb(folder / "chains.glb");
    const GltfScene triangles = loaded(folder / "cube.glb"), chains = loaded(folder / "chains.glb");
    EXPECT_EQ(chains.triangleCount(), 12);
    ASSERT_EQ(chains.triangleMeshes().size(), 4u);
    const auto match = matchTriangles(*triangles.triangleMeshes()[0], *chains.triangleMeshes()[0], 0);
    ASSERT_TRUE(match) << match.error();
    EXPECT_EQ(match->position, 0);
    EXPECT_EQ(match->lightMapUv, 0);
}

/// A cooked file that was tampered with may have vertices anywhere. The sanitizers watch this one.
TEST(MatchTriangles, ACopyFarAwayIsNoCounterpart) {
    const auto meshAround = [](float size) {
        TriangleMesh mesh;
        const std::array<float, 9> corners = {size, 0, 0, 0, size, 0, 0, 0, size};
        const auto bytes = std::as_bytes(std::span(corners));
        mesh.attributes.push_back({"POSITION", ComponentType::Float32, 3, false, {bytes.begin(), bytes.end()}});
        mesh.indices = {0, 1, 2};
        return mesh;
    };
    EXPECT_TRUE(matchTriangles(meshAround(1), meshAround(1), 0));
    EXPECT_FALSE(matchTriangles(meshAround(1), meshAround(3e38f), 0));
}

TEST(GltfScene, StripsAndFansAreWrittenAsTriangles) {
    const TemporaryFolder folder;
    cubeOfStripsAndFans().writeGlb(folder / "chains.glb");
    const GltfScene chains = loaded(folder / "chains.glb");
    const auto size = chains.writeDraco(folder / "cooked.glb", {});
    ASSERT_TRUE(size) << size.error().line();
    EXPECT_EQ(size->triangleCount, 12);
    const json cooked = jsonOf(folder / "cooked.glb");
    for (const json& primitive : cooked["meshes"][0]["primitives"]) {
        EXPECT_FALSE(primitive.contains("mode")) << "the default: triangles";
        EXPECT_TRUE(primitive.contains("extensions"));
    }
    EXPECT_EQ(cooked["accessors"][cooked["meshes"][0]["primitives"][0]["indices"].get<std::size_t>()]["count"], 18);
    const auto error = chains.errorOf(loaded(folder / "cooked.glb"));
    ASSERT_TRUE(error) << error.error().line();
    EXPECT_LE(error->position, 2.0 / 16383);
}

TEST(GltfScene, ADracoSceneIsReadAndCodedAgain) {
    const TemporaryFolder folder;
    cube().writeGlb(folder / "cube.glb");
    const GltfScene scene = loaded(folder / "cube.glb");
    ASSERT_TRUE(scene.writeDraco(folder / "once.glb", {}));
    const GltfScene once = loaded(folder / "once.glb");
    ASSERT_TRUE(once.writeDraco(folder / "twice.glb", {}));
    const GltfScene twice = loaded(folder / "twice.glb");
    const auto error = scene.errorOf(twice);
    ASSERT_TRUE(error) << error.error().line();
    EXPECT_LE(error->position, 2 * 2.0 / 16383);
    EXPECT_EQ(jsonOf(folder / "twice.glb")["extensionsUsed"].size(), 1u) << "declared once";
    EXPECT_EQ(jsonOf(folder / "twice.glb")["bufferViews"].size(), 2u) << "the first streams are gone";
}

TEST(GltfScene, BrokenDracoStreamsAreRefusedAndNeverCrash) {
    const TemporaryFolder folder;
    sheet(5, 9).writeGlb(folder / "sheet.glb");
    ASSERT_TRUE(loaded(folder / "sheet.glb").writeDraco(folder / "cooked.glb", {}));
    const std::string whole = contentOf(folder / "cooked.glb");
    const std::size_t stream = whole.find("DRACO\x02");
    ASSERT_NE(stream, std::string::npos);
    const auto file = folder / "broken.glb";
    writeContent(file, whole);
    setByte(file, stream, 'd');
    EXPECT_THAT(refusal(file).line(), AllOf(HasSubstr("mesh 0, primitive 0"), HasSubstr("expected a Draco mesh")));
    std::mt19937 random(4);
    std::size_t at = stream;
    for (int round = 0; round < 250; ++round) {
        setByte(file, at, whole[at]);  // as it was
        at = stream + 5 + random() % (whole.size() - stream - 5);
        setByte(file, at, static_cast<char>(random()));
        const auto scene = GltfScene::load(file);
        EXPECT_TRUE(scene || scene.error().line().find('\n') == std::string::npos);
    }
}

TEST(GltfScene, BadReferencesAndValuesAreRefusedWithTheirPlace) {
    GltfMaker maker = cube();
    maker.primitives()[0]["indices"] = maker.accessor(std::vector<std::uint16_t>{0, 1, 24}, 5123, "SCALAR", 1);
    EXPECT_THAT(refusal(maker).line(),
                AllOf(HasSubstr("mesh 0, primitive 0, index 2"), HasSubstr("found vertex 24, expected less than 24")));
    maker.primitives()[0]["indices"] = maker.accessor(std::vector<std::uint16_t>{0, 1, 2, 3}, 5123, "SCALAR", 1);
    EXPECT_THAT(refusal(maker).line(), HasSubstr("found 4 indices, expected a multiple of 3"));
    maker = cube();
    maker.primitives()[0]["material"] = 99;
    EXPECT_THAT(refusal(maker).line(), HasSubstr("mesh 0, primitive 0, material: found 99, expected the index of one of "));

    for (const auto& [semantic, components] : {std::pair{"POSITION", 3}, std::pair{"TEXCOORD_1", 2}}) {
        maker = cube();
        const std::size_t accessor = maker.primitives()[0]["attributes"][semantic];
        const float bad = components == 3 ? std::numeric_limits<float>::quiet_NaN() : std::numeric_limits<float>::infinity();
        const std::size_t at =
            maker.document["bufferViews"][accessor]["byteOffset"].get<std::size_t>() + 4 * static_cast<std::size_t>(components) * 5 + 4;
        std::memcpy(maker.buffer.data() + at, &bad, 4);
        const Error error = refusal(maker);
        EXPECT_EQ(error.code, ErrorCode::ValueNotFinite);
        EXPECT_THAT(error.line(), AllOf(HasSubstr(fmt::format("accessor {} ({} of mesh 0, primitive 0), vertex 5", accessor, semantic)),
                                        HasSubstr("finite")));
    }
    maker = cube();
    const std::size_t uvs = maker.primitives()[0]["attributes"]["TEXCOORD_1"];
    const std::array<float, 2> badUv = {0.5f, std::numeric_limits<float>::quiet_NaN()};
    std::memcpy(maker.buffer.data() + maker.document["bufferViews"][uvs]["byteOffset"].get<std::size_t>() + 8 * 5, badUv.data(), 8);
    EXPECT_THAT(refusal(maker).line(), HasSubstr("vertex 5: found (0.5, nan), expected finite values"));
    maker = cube();
    const std::size_t positions = maker.primitives()[0]["attributes"]["POSITION"];
    const float far = 1e30f;
    std::memcpy(maker.buffer.data() + maker.document["bufferViews"][positions]["byteOffset"].get<std::size_t>() + 12 * 5, &far, 4);
    const Error tooFar = refusal(maker);
    EXPECT_EQ(tooFar.code, ErrorCode::ValueOutOfRange);
    EXPECT_THAT(tooFar.line(), AllOf(HasSubstr("mesh 0, primitive 0, POSITION, vertex 5: found ("),
                                     HasSubstr(" in world space, expected coordinates from -1e+09 to 1e+09")));
    maker = cube();
    maker.document["nodes"][0]["scale"] = {1, 1e20, 1};
    EXPECT_THAT(refusal(maker).line(), HasSubstr("in world space, expected coordinates"));
    maker = cube();
    maker.document["accessors"][1]["count"] = 23;
    EXPECT_THAT(refusal(maker).line(), AllOf(HasSubstr("accessor 1 (NORMAL"), HasSubstr("found 23 vertices, expected 24")));
    maker = cube();
    maker.document["accessors"][0]["count"] = 1000000;
    EXPECT_THAT(refusal(maker).line(), AllOf(HasSubstr("accessor 0 (POSITION)"), HasSubstr("found 1000000 elements")));
    maker = cube();
    maker.primitives()[1]["attributes"]["NORMAL"] = 99;
    EXPECT_THAT(refusal(maker).line(), AllOf(HasSubstr("accessors"), HasSubstr("entry 99")));
    maker = cube();
    maker.primitives()[1]["attributes"]["NORMAL"] = -1;
    EXPECT_THAT(refusal(maker).line(), HasSubstr("NORMAL = -1"));
    maker = cube();
    maker.primitives()[0]["attributes"].erase("POSITION");
    EXPECT_THAT(refusal(maker).line(), HasSubstr("found no POSITION"));
    maker = cube();
    maker.document["bufferViews"][2]["byteLength"] = 1u << 30;
    EXPECT_THAT(refusal(maker).line(), HasSubstr("bufferView 2"));
    maker = cube();
    maker.document["materials"] = 7;
    EXPECT_EQ(refusal(maker).code, ErrorCode::WrongShape);
    maker = cube();
    maker.document["asset"]["version"] = "1.0";
    EXPECT_THAT(refusal(maker).line(), HasSubstr("found version \"1.0\""));
}

TEST(GltfScene, FilesThatAreNoGltfAreRefused) {
    const TemporaryFolder folder;
    EXPECT_EQ(refusal(folder / "absent.glb").code, ErrorCode::FileUnreadable);
    writeContent(folder / "text.gltf", "neither JSON nor GLB");
    EXPECT_EQ(refusal(folder / "text.gltf").code, ErrorCode::FileUnreadable);
    writeContent(folder / "deep.gltf", std::string(100000, '['));
    EXPECT_EQ(refusal(folder / "deep.gltf").code, ErrorCode::FileUnreadable);
    writeContent(folder / "apart.gltf", R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 4, "uri": "absent.bin"}]})");
    EXPECT_THAT(refusal(folder / "apart.gltf").line(), AllOf(HasSubstr("buffer 0"), HasSubstr("absent.bin")));
    cube().writeGlb(folder / "cut.glb");
    for (std::size_t length = std::filesystem::file_size(folder / "cut.glb"); length-- > 0;) {
        std::filesystem::resize_file(folder / "cut.glb", length);
        ASSERT_EQ(refusal(folder / "cut.glb").code, ErrorCode::FileUnreadable) << length;
    }
}

TEST(GltfScene, TextFormWithBuffersBesideAndInDataUris) {
    const TemporaryFolder folder;
    GltfMaker maker = cube();
    json document = maker.document;
    document["buffers"] = json::array({{{"byteLength", maker.buffer.size()}, {"uri", "the%20buffer.bin"}}});
    writeContent(folder / "the buffer.bin", maker.buffer);
    writeContent(folder / "cube.gltf", document.dump());
    cube().writeGlb(folder / "cube.glb");
    const GltfScene apart = loaded(folder / "cube.gltf");
    EXPECT_EQ(apart.triangleCount(), 12);
    const auto size = apart.writeDraco(folder / "apart.glb", {});
    ASSERT_TRUE(size);
    EXPECT_EQ(size->fileBytesIn, std::filesystem::file_size(folder / "cube.gltf") + maker.buffer.size());

    const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text = "data:application/octet-stream;base64,";
    maker.buffer.resize((maker.buffer.size() + 2) / 3 * 3, '\0');
    for (std::size_t i = 0; i < maker.buffer.size(); i += 3) {
        const auto byte = [&](std::size_t j) { return static_cast<unsigned>(static_cast<unsigned char>(maker.buffer[i + j])); };
        const unsigned bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for (int shift = 18; shift >= 0; shift -= 6) text += digits[bits >> shift & 63u];
    }
    document["buffers"][0]["uri"] = text;
    writeContent(folder / "inline.gltf", document.dump());
    ASSERT_TRUE(loaded(folder / "inline.gltf").writeDraco(folder / "inline.glb", {}));
    ASSERT_TRUE(loaded(folder / "cube.glb").writeDraco(folder / "plain.glb", {}));
    EXPECT_EQ(contentOf(folder / "inline.glb"), contentOf(folder / "apart.glb"));
    EXPECT_EQ(contentOf(folder / "plain.glb"), contentOf(folder / "apart.glb"));
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64,!!!";
    writeContent(folder / "inline.gltf", document.dump());
    EXPECT_THAT(refusal(folder / "inline.gltf").line(), HasSubstr("base64"));
}

TEST(GltfScene, SparseAccessorsAreApplied) {
    const TemporaryFolder folder;
    GltfMaker plain = cube(), sparse = cube();
    const std::vector<float> corner = {5, 6, 7};
    const std::size_t at = plain.document["bufferViews"][0]["byteOffset"].get<std::size_t>() + 12 * 3;
    std::memcpy(plain.buffer.data() + at, corner.data(), 12);
    const std::vector<std::uint8_t> index = {3};
    const std::size_t indexView = sparse.view(index.data(), 1), valueView = sparse.view(corner.data(), 12);
    sparse.document["accessors"][0]["sparse"] = {
        {"count", 1}, {"indices", {{"bufferView", indexView}, {"componentType", 5121}}}, {"values", {{"bufferView", valueView}}}};
    plain.writeGlb(folder / "plain.glb");
    sparse.writeGlb(folder / "sparse.glb");
    const auto error = loaded(folder / "plain.glb").errorOf(loaded(folder / "sparse.glb"));
    ASSERT_TRUE(error) << error.error().line();
    EXPECT_EQ(error->position, 0);
    sparse.document["accessors"][0]["sparse"]["indices"]["byteOffset"] = 1;
    EXPECT_EQ(refusal(sparse).code, ErrorCode::WrongShape);
}

TEST(GltfScene, OptionsOutOfRangeAreRefused) {
    const TemporaryFolder folder;
    cube().writeGlb(folder / "cube.glb");
    const GltfScene scene = loaded(folder / "cube.glb");
    for (const DracoOptions& options : {DracoOptions{.positionBits = 0}, DracoOptions{.lightMapUvBits = 31}, DracoOptions{.speed = 11}}) {
        const auto written = scene.writeDraco(folder / "cooked.glb", options);
        ASSERT_FALSE(written);
        EXPECT_EQ(written.error().code, ErrorCode::InvalidRequest);
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "cooked.glb"));
    EXPECT_FALSE(scene.writeDraco(folder / "absent" / "cooked.glb", {}));
}

MaterialNeeds needsOf(const json& material) {
    const TemporaryFolder folder;
    GltfMaker maker = cube();
    maker.document["materials"][0] = material;
    maker.document["textures"] = json::array({json::object()});
    maker.writeGlb(folder / "scene.glb");
    return loaded(folder / "scene.glb").materials()[0];
}

TEST(MaterialNeeds, FollowsTheSpecification) {
    const MaterialNeeds metal = needsOf({{"name", "default"}});  // glTF's default is a rough white metal
    EXPECT_EQ(metal.mMin, 1);
    EXPECT_EQ(metal.f0Max, 1);
    EXPECT_EQ(metal.f0Min, 1);
    EXPECT_TRUE(metal.isSpecular);
    EXPECT_FALSE(metal.hasNormalMap);

    const MaterialNeeds plastic =
        needsOf({{"normalTexture", {{"index", 0}}},
                 {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 0.5}, {"baseColorFactor", {0.9, 0.1, 0.1, 1}}}}});
    EXPECT_DOUBLE_EQ(plastic.mMin, 0.25);
    EXPECT_DOUBLE_EQ(plastic.mMax, 0.25);
    EXPECT_NEAR(plastic.f0Min, 0.04, 1e-12);
    EXPECT_NEAR(plastic.f0Max, 0.04, 1e-12);
    EXPECT_TRUE(plastic.hasNormalMap);

    const MaterialNeeds gold = needsOf({{"pbrMetallicRoughness",
                                         {{"metallicFactor", 0.5},
                                          {"roughnessFactor", 0.8},
                                          {"metallicRoughnessTexture", {{"index", 0}}},
                                          {"baseColorFactor", {1.0, 0.8, 0.3, 1}}}}});
    EXPECT_EQ(gold.mMin, 0);
    EXPECT_NEAR(gold.mMax, 0.64, 1e-12);
    EXPECT_NEAR(gold.f0Min, 0.04, 1e-12) << "the texture can take the metal away";
    EXPECT_NEAR(gold.f0Max, 0.5 * 0.04 + 0.5 * 1.0, 1e-12);

    const auto dielectric = [](const json& extensions) {
        return needsOf({{"pbrMetallicRoughness", {{"metallicFactor", 0}}}, {"extensions", extensions}});
    };
    EXPECT_NEAR(dielectric({{"KHR_materials_ior", {{"ior", 1.33}}}}).f0Max, std::pow(0.33 / 2.33, 2), 1e-12);
    EXPECT_NEAR(dielectric({{"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {1.0, 0.5, 2.0}}}}}).f0Max,
                0.5 * 0.08, 1e-12);
    EXPECT_NEAR(dielectric({{"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {1.0, 0.5, 2.0}}}}}).f0Min,
                0.5 * 0.02, 1e-12);
    EXPECT_EQ(dielectric({{"KHR_materials_specular", {{"specularTexture", {{"index", 0}}}}}}).f0Min, 0);
    EXPECT_FALSE(dielectric({{"KHR_materials_specular", {{"specularFactor", 0}}}}).isSpecular);
    EXPECT_FALSE(dielectric({{"KHR_materials_unlit", json::object()}}).isSpecular);
    EXPECT_TRUE(dielectric({{"KHR_materials_specular", {{"specularFactor", 0.01}}}}).isSpecular);
}

void expectRanges(const MaterialNeeds& needs, std::array<double, 2> m, std::array<double, 2> f0) {
    EXPECT_TRUE(needs.isSpecular);
    EXPECT_NEAR(needs.mMin, m[0], 1e-12);
    EXPECT_NEAR(needs.mMax, m[1], 1e-12);
    EXPECT_NEAR(needs.f0Min, f0[0], 1e-12);
    EXPECT_NEAR(needs.f0Max, f0[1], 1e-12);
}

TEST(MaterialNeeds, AClearcoatIsAnotherLobe) {
    // The base is a dielectric with m = 0.9^2 and f0 = 0.04.
    const auto coated = [](const json& clearcoat, double specularFactor = 1) {
        return needsOf(
            {{"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 0.9}}},
             {"extensions", {{"KHR_materials_clearcoat", clearcoat}, {"KHR_materials_specular", {{"specularFactor", specularFactor}}}}}});
    };
    expectRanges(coated({{"clearcoatFactor", 1.0}}), {0, 0.81}, {0.04, 0.04});
    expectRanges(coated({{"clearcoatFactor", 1.0}, {"clearcoatRoughnessFactor", 0.3}}), {0.09, 0.81}, {0.04, 0.04});
    expectRanges(coated({{"clearcoatFactor", 0.5}, {"clearcoatRoughnessFactor", 1.0}}), {0.81, 1}, {0.02, 0.04});
    expectRanges(coated(json::object()), {0.81, 0.81}, {0.04, 0.04});
    expectRanges(coated({{"clearcoatFactor", 0.5}, {"clearcoatRoughnessFactor", 0.3}}, 0), {0.09, 0.09}, {0.02, 0.02});
    EXPECT_FALSE(coated({{"clearcoatFactor", 0.0}}, 0).isSpecular);

    const json texture = {{"index", 0}};
    expectRanges(coated({{"clearcoatFactor", 0.5}, {"clearcoatTexture", texture}, {"clearcoatRoughnessFactor", 0.3}}, 0), {0.09, 0.09},
                 {0, 0.02});
    expectRanges(coated({{"clearcoatFactor", 1.0}, {"clearcoatRoughnessFactor", 0.6}, {"clearcoatRoughnessTexture", texture}}, 0),
                 {0, 0.36}, {0.04, 0.04});
    EXPECT_FALSE(coated({{"clearcoatFactor", 1.0}}).hasNormalMap);
    EXPECT_TRUE(coated({{"clearcoatFactor", 1.0}, {"clearcoatNormalTexture", texture}}).hasNormalMap);
}

TEST(MaterialNeeds, SpecularGlossinessIsRead) {
    const auto glossy = [](const json& glossiness, json material = json::object()) {
        material["extensions"]["KHR_materials_pbrSpecularGlossiness"] = glossiness;
        return needsOf(material);
    };
    expectRanges(glossy(json::object()), {0, 0}, {1, 1});
    json glossiness = {{"specularFactor", {0.2, 0.1, 0.05}}, {"glossinessFactor", 0.7}};
    expectRanges(glossy(glossiness), {0.09, 0.09}, {0.05, 0.2});
    const json fallback = {{"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 0.5}}}};
    expectRanges(glossy(glossiness, fallback), {0.09, 0.25}, {0.04, 0.2});
    glossiness["specularGlossinessTexture"] = {{"index", 0}};
    expectRanges(glossy(glossiness), {0.09, 1}, {0, 0.2});
}

TEST(MaterialNeeds, ExtensionsThatAreNotReadHaveNames) {
    const auto unreadOf = [](const std::vector<std::string>& names) {
        Json material;
        for (const std::string& name : names) material["extensions"][name] = Json::object();
        return unreadExtensions(material);
    };
    EXPECT_THAT(unreadOf({}), testing::IsEmpty());
    EXPECT_THAT(unreadOf({"KHR_materials_clearcoat", "KHR_materials_ior", "KHR_materials_specular", "KHR_materials_pbrSpecularGlossiness",
                          "KHR_materials_emissive_strength", "KHR_materials_variants", "KHR_materials_volume", "KHR_materials_dispersion",
                          "KHR_texture_transform", "KHR_xmp_json_ld", "MOZ_lightmap"}),
                testing::IsEmpty());
    EXPECT_THAT(unreadOf({"KHR_materials_sheen", "KHR_materials_ior", "KHR_materials_iridescence", "ADOBE_materials_thin_transparency"}),
                testing::ElementsAre("KHR_materials_sheen", "KHR_materials_iridescence", "ADOBE_materials_thin_transparency"));
    EXPECT_THAT(unreadOf({"KHR_materials_sheen", "KHR_materials_unlit"}), testing::IsEmpty()) << "it reflects nothing";
}

TEST(MaterialNeeds, APrimitiveWithoutMaterialAsksForTheDefault) {
    const TemporaryFolder folder;
    GltfMaker maker = cube();
    maker.primitives()[1].erase("material");
    maker.writeGlb(folder / "scene.glb");
    const GltfScene scene = loaded(folder / "scene.glb");
    ASSERT_EQ(scene.materials().size(), 3u);
    EXPECT_EQ(scene.materials()[2].name, "default");
    EXPECT_EQ(scene.materials()[2].mMax, 1);
}

TEST(GltfScene, WithoutASecondUvSetItSaysSo) {
    const TemporaryFolder folder;
    GltfMaker maker = cube();
    maker.primitives()[1]["attributes"].erase("TEXCOORD_1");
    maker.writeGlb(folder / "scene.glb");
    EXPECT_FALSE(loaded(folder / "scene.glb").hasLightMapUvs());
}

/// Lines and points have no surface, so no light map lies on them.
TEST(GltfScene, LinesAndPointsNeedNoSecondUvSet) {
    const TemporaryFolder folder;
    GltfMaker maker = cube();
    for (const int mode : {0, 1}) maker.primitives().push_back({{"attributes", {{"POSITION", 0}}}, {"mode", mode}, {"material", 0}});
    maker.writeGlb(folder / "scene.glb");
    const GltfScene scene = loaded(folder / "scene.glb");
    EXPECT_TRUE(scene.hasLightMapUvs());
    const auto expectKept = [&](const GltfScene& from, const char* file) {
        const json primitives = jsonOf(folder / file)["meshes"][0]["primitives"];
        ASSERT_EQ(primitives.size(), 4u) << file;
        for (const std::size_t i : {2, 3}) EXPECT_EQ(primitives[i], maker.primitives()[i]) << file;
        EXPECT_TRUE(loaded(folder / file).hasLightMapUvs()) << file;
        const auto plain = from.writePlain(folder / "again.glb", nullptr);
        ASSERT_TRUE(plain) << plain.error().line();
        EXPECT_EQ(plain->triangleVertexCount, 24);
        EXPECT_EQ(plain->vertexCount, 24 + 24 + 24);
    };
    ASSERT_TRUE(scene.writePlain(folder / "plain.glb", nullptr));
    expectKept(scene, "plain.glb");
    ASSERT_TRUE(scene.writeLightMapUvs(folder / "packed.glb", numberedUvs(scene)));
    expectKept(scene, "packed.glb");
    ASSERT_TRUE(scene.writeDraco(folder / "draco.glb", {}));
    expectKept(scene, "draco.glb");
    EXPECT_TRUE(scene.errorOf(loaded(folder / "draco.glb")));

    maker.primitives().erase(std::size_t{0});
    maker.primitives().erase(std::size_t{0});
    maker.writeGlb(folder / "lines.glb");
    EXPECT_FALSE(loaded(folder / "lines.glb").hasLightMapUvs());
}

TEST(GltfLightMap, LinesWithoutASecondUvSetHaveNoPictureOfIt) {
    const TemporaryFolder folder;
    GltfMaker maker = cube();
    maker.document["materials"].push_back({{"name", "of lines alone"}});
    for (const int material : {0, 0, 2})
        maker.primitives().push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}, {"material", material}});
    maker.primitives().push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
    maker.writeGlb(folder / "scene.glb");
    const auto bound = bindLightMap(folder / "scene.glb", folder / "bound.glb", {"map", "{}", std::vector<std::byte>(8), 1, {}});
    ASSERT_TRUE(bound) << bound.error().line();
    const json after = jsonOf(folder / "bound.glb"), primitives = after["meshes"][0]["primitives"];
    ASSERT_EQ(after["materials"].size(), 4u);
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_EQ(after["materials"][i].value("extensions", json::object()).contains("MOZ_lightmap"), i < 2) << i;
    EXPECT_EQ(primitives[0]["material"], maker.primitives()[0]["material"]);
    EXPECT_EQ(primitives[2]["material"], 3) << "a copy without the picture";
    EXPECT_EQ(primitives[3]["material"], 3);
    EXPECT_EQ(after["materials"][3]["name"], after["materials"][0]["name"]);
    EXPECT_EQ(primitives[4]["material"], 2);
    EXPECT_FALSE(primitives[5].contains("material"));
}

TEST(GltfSceneSoak, TheSharedScenesShrinkWithinTheirSteps) {
    const std::filesystem::path scenes = std::filesystem::path(LIGHTCOOK_SHARED_DATA) / "scenes";
    if (!std::filesystem::exists(scenes)) GTEST_SKIP() << "needs the shared test data at " << LIGHTCOOK_SHARED_DATA;
    const TemporaryFolder folder;
    for (const auto& [name, extent] : {std::pair{"cornell", 5.5}, {"zdm2_sun", 59.6}, {"interior", 8.0}, {"outdoor", 14.0}}) {
        const GltfScene scene = loaded(scenes / fmt::format("{}.glb", name));
        EXPECT_TRUE(scene.hasLightMapUvs());
        const auto size = scene.writeDraco(folder / "cooked.glb", {});
        ASSERT_TRUE(size) << size.error().line();
        const auto error = scene.errorOf(loaded(folder / "cooked.glb"));
        ASSERT_TRUE(error) << name << ": " << error.error().line();
        EXPECT_LE(error->position, 0.5 * std::sqrt(3.0) * extent / 16383 * 1.01) << name;
        EXPECT_LE(error->lightMapUv, 0.5 * std::sqrt(2.0) / 65535 * 1.05) << name;
        EXPECT_LE(error->normalRadians, 0.01) << name;
        fmt::print("{}: {} -> {} bytes, {} triangles of {}, position {:.3g}, normal {:.3g}, uv {:.3g}\n", name, size->fileBytesIn,
                   size->fileBytesOut, size->triangleCount, scene.triangleCount(), error->position, error->normalRadians,
                   error->lightMapUv);
    }
}

}  // namespace
}  // namespace lightcook::formats
