// A light map of learned bases and the mesh that reads it: each vertex names its basis, whatever the texels of its island look like.
#include <gmock/gmock.h>

#include <cmath>
#include <cstring>

#include "formats/gltf_scene.h"
#include "formats/image/exr_file.h"
#include "pipeline/cook/cook.h"
#include "pipeline/document/json.h"
#include "pipeline/graph/digest.h"
#include "pipeline/manifest/manifest.h"
#include "tests/pipeline/example_folder.h"
#include "tests/pipeline/rewritten_manifest.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;

/// Two squares of light that have nothing in common, and the mesh: a square over each and, where it is asked for, a neck between them that
/// is narrower than a texel and runs between the rows of texel centres.
class TwoSquares : public testing::Test {
protected:
    enum class Neck { Absent, Present };
    static constexpr int kWidth = 96, kHeight = 128;

    TwoSquares() { writeMap(); }

    static bool isLeft(int x, int y) { return 8 <= x && x < 40 && 8 <= y && y < 120; }
    static bool isRight(int x, int y) { return 56 <= x && x < 88 && 8 <= y && y < 120; }

    void writeMap() const {
        std::vector<std::string> channels;
        for (int i = 0; i < 9; ++i)
            for (const char channel : {'R', 'G', 'B'}) channels.push_back(fmt::format("sh0{}.{}", i, channel));
        channels.insert(channels.end(), {"coverage.Y", "normal.X", "normal.Y", "normal.Z"});
        auto writer = formats::ExrWriter::create(folder_ / "map.exr", kWidth, kHeight, channels, formats::ExrLayout::ScanLines);
        ASSERT_TRUE(writer.has_value());
        std::vector<float> texels;
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                for (std::size_t i = 0; i < 27; ++i) texels.push_back(coefficient(i / 3, i % 3, x, y));
                texels.insert(texels.end(), {isLeft(x, y) || isRight(x, y) ? 1.0f : 0.0f, 0, 0, 1});
            }
        ASSERT_TRUE(writer->append(texels.data(), static_cast<std::ptrdiff_t>(channels.size()) * kWidth, kHeight) && writer->commit());
    }
    /// Left light turns about one axis, right light about another, each in four waves that no few directions hold together.
    static float coefficient(std::size_t i, std::size_t channel, int x, int y) {
        if (i == 0) return 1;
        const double wave = 0.2 * std::sin(0.21 * x * (1 + static_cast<double>(channel)) + 0.17 * y);
        const bool isOurs = isLeft(x, y) ? i <= 4 : i > 4;
        return static_cast<float>(isOurs ? wave * (1 + 0.1 * static_cast<double>(i)) : isLeft(x, y) ? 0.3 : -0.3);
    }

    /// copies  of the squares, on top of each other: vertices
    void writeMesh(Neck neck, int copies = 1) const {
        std::vector<float> corners = {8,  8, 40, 8, 40, 24.1f, 40, 24.3f, 40, 120,   8,  120,     // the left square's outline
                                      56, 8, 88, 8, 88, 120,   56, 120,   56, 24.3f, 56, 24.1f};  // the right one's
        std::vector<std::uint16_t> indices = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5, 6, 7, 8, 6, 8, 11, 8, 10, 11, 8, 9, 10};
        if (neck == Neck::Present) indices.insert(indices.end(), {2, 11, 10, 2, 10, 3});
        const std::vector<float> cornersOnce = corners;
        const std::vector<std::uint16_t> indicesOnce = indices;
        for (int copy = 1; copy < copies; ++copy) {
            for (const std::uint16_t each : indicesOnce) indices.push_back(static_cast<std::uint16_t>(each + corners.size() / 2));
            corners.insert(corners.end(), cornersOnce.begin(), cornersOnce.end());
        }
        std::vector<float> buffer;
        for (std::size_t i = 0; i < corners.size(); i += 2) buffer.insert(buffer.end(), {corners[i], 0, corners[i + 1]});
        for (std::size_t i = 0; i < corners.size(); i += 2) buffer.insert(buffer.end(), {corners[i] / kWidth, corners[i + 1] / kHeight});
        std::string bytes(reinterpret_cast<const char*>(buffer.data()), buffer.size() * sizeof(float));
        bytes.append(reinterpret_cast<const char*>(indices.data()), indices.size() * sizeof(std::uint16_t));
        formats::writeContent(folder_ / "room.bin", bytes);
        const std::size_t count = corners.size() / 2;
        const Json document = {
            {"asset", {{"version", "2.0"}}},
            {"buffers", {{{"uri", "room.bin"}, {"byteLength", bytes.size()}}}},
            {"bufferViews",
             {{{"buffer", 0}, {"byteLength", 12 * count}},
              {{"buffer", 0}, {"byteOffset", 12 * count}, {"byteLength", 8 * count}},
              {{"buffer", 0}, {"byteOffset", 20 * count}, {"byteLength", 2 * indices.size()}}}},
            {"accessors",
             {{{"bufferView", 0}, {"componentType", 5126}, {"count", count}, {"type", "VEC3"}, {"min", {8, 0, 8}}, {"max", {88, 0, 120}}},
              {{"bufferView", 1}, {"componentType", 5126}, {"count", count}, {"type", "VEC2"}},
              {{"bufferView", 2}, {"componentType", 5123}, {"count", indices.size()}, {"type", "SCALAR"}}}},
            {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}, {"TEXCOORD_1", 1}}}, {"indices", 2}}}}}}},
            {"images", {{{"uri", "wood.png"}}}},
            {"nodes", {{{"mesh", 0}}}},
            {"scenes", {{{"nodes", {0}}}}},
            {"scene", 0}};
        formats::writeContent(folder_ / "room.gltf", document.dump());
    }

    void writeScene(const std::string& output, bool hasMesh = true) const {
        formats::writeContent(folder_ / "scene.toml",
                              fmt::format("schema = 1\nname = \"two\"\n[output]\neffort = 2\n{}\n[[light_map]]\nname = \"map\"\nfile = "
                                          "\"map.exr\"\n{}\n[[material]]\nname = \"*\"\nnormal_map = true\nspecular = false\n",
                                          output, hasMesh ? "mesh = \"room.gltf\"" : ""));
    }
    Outcome cook(const std::optional<std::string>& only = {}) const {
        CookOptions options;
        options.scene = folder_ / "scene.toml";
        options.output = folder_ / "out";
        options.cache = cache_;
        options.only = only;
        const RunState state;
        return cookScene(options, state);
    }
    Outcome verify() const {
        const RunState state;
        return verifyCooked({folder_ / "out", {}, {}}, state);
    }
    void expectCooksAndVerifies() const {
        for (const Outcome& outcome : {cook(), verify()}) {
            for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
            ASSERT_TRUE(outcome.report.is_object());
            EXPECT_TRUE(outcome.report.at("passed").get<bool>());
        }
    }
    /// An asset of the manifest; null without it.
    Json asset(const std::string& name) const {
        const auto manifest = readManifest(folder_ / "out");
        if (!manifest) return nullptr;
        for (const Json& each : manifest->at("assets"))
            if (each.at("name") == name) return each;
        return nullptr;
    }
    /// A texture of an asset; null without it.
    static Json textureOf(const Json& asset, const std::string& role) {
        for (const Json& each : asset.at("textures"))
            if (each.at("role") == role) return each;
        return nullptr;
    }
    formats::ClusterMap clusterMap() const {
        const Json constants = asset("map").at("constants");
        if (!constants.contains("index_runs")) return indexTexture();
        const auto map = formats::ClusterMap::fromRuns(kWidth, kHeight, constants.at("index_runs").get<std::vector<float>>());
        EXPECT_TRUE(map) << map.error();
        return *map;
    }
    /// The clusters that the texture "index" names, one byte a block.
    formats::ClusterMap indexTexture() const {
        const auto texture = formats::TextureReader::open(folder_ / "out" / "map_index.ktx2");
        EXPECT_TRUE(texture) << "neither runs nor a texture";
        EXPECT_EQ(texture->shape().format, formats::PixelFormat::Rgba8Unorm);
        formats::ClusterMap map{kWidth, kHeight, std::vector<std::uint8_t>(kWidth / 4 * (kHeight / 4))};
        EXPECT_TRUE(texture->readBlockRows({}, 0, std::as_writable_bytes(std::span(map.ofBlock))).has_value());
        return map;
    }
    std::optional<formats::GltfScene> cookedMesh() const {
        auto scene = formats::GltfScene::load(folder_ / "out" / "room_mesh.glb");
        if (!scene) return std::nullopt;
        return std::move(*scene);
    }
    /// Flips the first vertices' clusters in the cooked mesh, and has the manifest believe it.
    void breakClusters() const {
        std::string glb = formats::contentOf(folder_ / "out" / "room_mesh.glb");
        std::uint32_t length = 0;
        std::memcpy(&length, glb.data() + 12, 4);
        const Json document = parseJson(glb.substr(20, length));
        const Json& attributes = document["meshes"][0]["primitives"][0]["attributes"];
        const Json& accessor = document["accessors"][attributes[formats::kBasisAttribute].get<std::size_t>()];
        const Json& view = document["bufferViews"][accessor["bufferView"].get<std::size_t>()];
        for (std::size_t vertex = 0; vertex < 6; ++vertex) glb[28 + length + view["byteOffset"].get<std::size_t>() + 4 * vertex] ^= 1;
        formats::writeContent(folder_ / "out" / "room_mesh.glb", glb);
        Json manifest = parseJson(formats::contentOf(folder_ / "out" / kManifestName));
        for (Json& each : manifest["assets"])
            if (each["name"] == "room_mesh") each["digest"] = digestOfText(glb);
        writeManifestAndDigests(folder_ / "out", manifest);
    }

    const formats::TemporaryFolder folder_;
    std::filesystem::path cache_ = LIGHTCOOK_TEST_CACHE;  ///< many tests cook the same
};

using TwoSquaresSoak = TwoSquares;
TEST_F(TwoSquaresSoak, TheirClustersDifferUnlessAnIslandJoinsThem) {
    writeMesh(Neck::Absent);
    writeScene("light_map_layout = \"basis-4\"");
    expectCooksAndVerifies();
    const formats::ClusterMap apart = clusterMap();
    EXPECT_NE(apart.at(20, 24), apart.at(70, 24)) << "else the rest says nothing";
    writeMesh(Neck::Present);
    expectCooksAndVerifies();
    const formats::ClusterMap joined = clusterMap();
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            EXPECT_TRUE(!(isLeft(x, y) || isRight(x, y)) || joined.at(x, y) == joined.at(20, 24)) << x << " " << y;
    writeScene("light_map_layout = \"basis-4\"", false);
    expectCooksAndVerifies();
    EXPECT_EQ(clusterMap().ofBlock, apart.ofBlock) << "no mesh, no island";
}

TEST_F(TwoSquares, WithClustersAtTheVerticesNeedNoIndexInMemory) {
    writeMesh(Neck::Absent);
    const std::size_t index = kWidth / 4 * (kHeight / 4), attribute = 4 * 12;
    for (const bool hasMesh : {true, false}) {
        writeScene("light_map_layout = \"basis-8\"", hasMesh);
        expectCooksAndVerifies();
        const Json map = asset("map");
        const Json tables = textureOf(map, "tables");
        const std::size_t bytes = tables.at("bytes_gpu").get<std::size_t>();
        EXPECT_EQ(tables.at("width"), 120 + 36) << "15 monomials of 8 coefficients, 4 channels of 9";
        EXPECT_EQ(tables.at("height"), map.at("constants").at("clusters")[0]);
        EXPECT_EQ(tables.at("format"), "rgba16f");
        EXPECT_EQ(tables.at("sampler").at("filter"), "nearest");
        EXPECT_EQ(map.at("constants").at("tables"), Json({{"file", tables.at("file")}}));
        EXPECT_FALSE(map.contains("bytes_gpu")) << "beside its textures";
        for (const char* gone : {"code", "residual"}) EXPECT_FALSE(map.at("constants").contains(gone));
        EXPECT_EQ(map.at("constants").contains("index_runs"), hasMesh);
        EXPECT_EQ(map.at("textures").size(), hasMesh ? 5u : 6u);
        EXPECT_EQ(map.value("vertex_bytes_gpu", std::size_t{0}), hasMesh ? attribute : 0);
        const double names = static_cast<double>(hasMesh ? attribute : index);
        EXPECT_NEAR(map.at("bits_per_texel").get<double>(), 24 + 1 + 8 * (static_cast<double>(bytes) + names) / (kWidth * kHeight), 1e-9);
    }
}

/// A mesh of many vertices costs more than an index of one byte a block, which an engine then fetches in place of an attribute.
TEST_F(TwoSquaresSoak, OfManyVerticesAreNamedByTheSmallerIndexTexture) {
    writeMesh(Neck::Absent, 40);
    writeScene("light_map_layout = \"basis-8\"\ndraco = false");
    expectCooksAndVerifies();
    const Json map = asset("map"), mesh = asset("room_mesh");
    EXPECT_GT(4 * mesh.at("vertices").get<std::size_t>(), std::size_t{kWidth / 4 * (kHeight / 4)});
    EXPECT_FALSE(mesh.contains("basis"));
    EXPECT_FALSE(map.at("constants").contains("index_runs"));
    const Json index = textureOf(map, "index");
    EXPECT_EQ(index.at("role"), "index");
    EXPECT_EQ(index.at("format"), "rgba8-unorm");
    EXPECT_EQ(index.at("sampler").at("filter"), "nearest");
    EXPECT_EQ(index.at("bytes_gpu").get<int>(), kWidth / 4 * (kHeight / 4)) << "half a bit a texel";
    const formats::ClusterMap byBlock = indexTexture();
    EXPECT_NE(byBlock.at(20, 24), byBlock.at(70, 24));
    const auto scene = cookedMesh();
    ASSERT_TRUE(scene);
    for (const formats::TriangleMesh* primitive : scene->triangleMeshes()) EXPECT_EQ(primitive->find("_LIGHTCOOK_BASIS"), nullptr);
    // Another cluster in the texture is another decode.
    std::vector<std::uint8_t> other = byBlock.ofBlock;
    for (std::uint8_t& cluster : other) cluster = cluster == byBlock.at(20, 24) ? byBlock.at(70, 24) : byBlock.at(20, 24);
    formats::TextureShape shape;
    shape.format = formats::PixelFormat::Rgba8Unorm;
    shape.width = kWidth / 16;
    shape.height = kHeight / 4;
    const auto reader = formats::TextureReader::open(folder_ / "out" / "map_index.ktx2");
    const auto bytes = std::as_bytes(std::span<const std::uint8_t>(other));
    std::map<std::string, std::string> metadata = reader->metadata();
    std::erase_if(metadata, [](const auto& entry) { return entry.first.starts_with("KTX"); });
    const auto written = writeTexture(folder_ / "out" / "map_index.ktx2", shape, {}, metadata, {{bytes.begin(), bytes.end()}});
    ASSERT_TRUE(written.has_value()) << written.error().line();
    Json manifest = parseJson(formats::contentOf(folder_ / "out" / kManifestName));
    for (Json& each : manifest["assets"])
        for (Json& texture : each["textures"])
            if (texture["role"] == "index") texture["digest"] = digestOfText(formats::contentOf(folder_ / "out" / "map_index.ktx2"));
    writeManifestAndDigests(folder_ / "out", manifest);
    const Outcome swapped = verify();
    ASSERT_FALSE(swapped.errors.empty());
    EXPECT_EQ(swapped.errors.front().code, formats::ErrorCode::Verification);
}

/// A looser limit takes fewer bits and a tighter one more. The error of the chosen bits stays within their bound.
TEST_F(TwoSquares, BitsAreTheLeastThatKeepATenthOfTheLimit) {
    writeMesh(Neck::Absent);
    int bitsBefore = 0;
    for (const double limit : {0.9, 0.3, 0.05}) {
        SCOPED_TRACE(limit);
        writeScene(fmt::format("light_map_layout = \"raw\"\nmax_error = {}", limit));
        const RunState state;
        CookOptions options;
        options.scene = folder_ / "scene.toml";
        options.output = folder_ / "out";
        options.cache = cache_;
        const Outcome outcome = cookScene(options, state);
        ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
        for (const Json& row : outcome.report.at("assets")) {
            if (row.at("kind") != "mesh") continue;
            const Json& notes = row.at("notes");
            const int bits = notes.at("light_map_uv_bits").get<int>() + notes.at("normal_bits").get<int>();
            EXPECT_GT(bits, bitsBefore);
            bitsBefore = bits;
            const double bound = notes.at("bound_of_rel_rms").get<double>();
            EXPECT_LE(bound, 0.1 * limit);
            EXPECT_LE(row.at("stages").back().at("error").at("diffuse").at("rel_rms").get<double>(), bound);
            EXPECT_EQ(asset("room_mesh").at("quantization").at("normal_bits"), notes.at("normal_bits"));
        }
    }
    EXPECT_GT(bitsBefore, 0);
}

TEST_F(TwoSquares, AVisibleErrorAboveTheLimitNamesTheTriangleAndBothColours) {
    writeMesh(Neck::Absent);
    writeScene("light_map_layout = \"raw\"\nmax_error = 0.3\nmax_visible = 0.0001");
    const Outcome outcome = cook("room_mesh");
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors.front().code, formats::ErrorCode::OverLimit);
    EXPECT_THAT(outcome.errors.front().line(),
                testing::AllOf(HasSubstr("room_mesh, stage quantize, diffuse: found a visible error of "),
                               HasSubstr("worst at primitive 0, triangle "), HasSubstr("): found ("), HasSubstr("a difference of ")));
    const Json& visible = outcome.report.at("assets").at(0).at("stages").at(0).at("error").at("diffuse").at("visible");
    const auto triangle = visible.at("max_at").at("triangle").get<int>();
    EXPECT_GE(triangle, 0);
    EXPECT_LT(triangle, 8);
    // The left square has the first four triangles.
    EXPECT_EQ(triangle < 4, visible.at("max_at").at("texel").at(0).get<double>() < 0.5 * kWidth);
}

TEST_F(TwoSquares, EveryVertexHasTheClusterOfItsSquareInDracoAndPlain) {
    writeMesh(Neck::Absent);
    for (const char* draco : {"true", "false"}) {
        SCOPED_TRACE(draco);
        writeScene(fmt::format("light_map_layout = \"basis-8\"\ndraco = {}", draco));
        expectCooksAndVerifies();
        const Json mesh = asset("room_mesh");
        ASSERT_TRUE(mesh.is_object());
        EXPECT_EQ(mesh.at("basis"), (Json{{"attribute", "_LIGHTCOOK_BASIS"}, {"light_map", "map"}}));
        EXPECT_EQ(mesh.at("layout"), std::string(draco) == "true" ? "glb-draco" : "glb");
        const formats::ClusterMap map = clusterMap();
        const auto scene = cookedMesh();
        ASSERT_TRUE(scene);
        std::size_t vertices = 0;
        for (const formats::TriangleMesh* primitive : scene->triangleMeshes()) {
            const formats::MeshAttribute *uv = primitive->find("TEXCOORD_1"), *cluster = primitive->find("_LIGHTCOOK_BASIS");
            ASSERT_TRUE(uv != nullptr && cluster != nullptr);
            EXPECT_EQ(cluster->componentType, formats::ComponentType::Uint8);
            for (std::size_t i = 0; i < uv->vertexCount(); ++i, ++vertices)
                EXPECT_EQ(cluster->at(i).x, uv->at(i).x < 0.5 ? map.at(20, 24) : map.at(70, 24));
        }
        EXPECT_EQ(vertices, 12u);
    }
}

TEST_F(TwoSquaresSoak, OtherLayoutsHaveNoBasisToName) {
    writeMesh(Neck::Present);
    for (const char* layout : {"ratio", "hdr-2"}) {
        writeScene(fmt::format("light_map_layout = \"{}\"", layout));
        expectCooksAndVerifies();
        EXPECT_FALSE(asset("room_mesh").contains("basis"));
        EXPECT_FALSE(asset("map").at("source").at("files").contains("mesh")) << "the map's bytes do not hang on it";
        const auto scene = cookedMesh();
        ASSERT_TRUE(scene);
        for (const formats::TriangleMesh* primitive : scene->triangleMeshes()) EXPECT_EQ(primitive->find("_LIGHTCOOK_BASIS"), nullptr);
    }
    writeScene("light_map_layout = \"ratio\"\ndraco = false");
    expectCooksAndVerifies();
    EXPECT_TRUE(asset("room_mesh").is_null()) << "nothing to write";
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "room_mesh.glb"));
}

TEST_F(TwoSquares, AWrongClusterIsFoundByTriangleAndTexel) {
    writeMesh(Neck::Absent);
    writeScene("light_map_layout = \"basis-4\"\ndraco = false");
    expectCooksAndVerifies();
    breakClusters();
    const Outcome outcome = verify();
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, formats::ErrorCode::Verification);
    EXPECT_THAT(outcome.errors[0].line(), testing::AllOf(HasSubstr("room_mesh.glb"), HasSubstr("found cluster"), HasSubstr("in triangle 0"),
                                                         HasSubstr("expected"), HasSubstr("at texel (")));
}

TEST_F(TwoSquares, AManifestThatNamesNoSuchLightMapIsRefused) {
    writeMesh(Neck::Absent);
    writeScene("light_map_layout = \"basis-4\"");
    expectCooksAndVerifies();
    const Json whole = parseJson(formats::contentOf(folder_ / "out" / kManifestName));
    const auto verifiedWith = [&](auto&& edit) {
        Json manifest = whole;
        for (Json& each : manifest["assets"]) edit(each);
        writeManifestAndDigests(folder_ / "out", manifest);
        const Outcome outcome = verify();
        return outcome.errors.empty() ? formats::Error{formats::ErrorCode::Internal, "nothing", ""} : outcome.errors[0];
    };
    const auto ofMesh = [](const char* key, const Json& value) {
        return [key, value](Json& each) {
            if (each.contains("basis")) each["basis"][key] = value;
        };
    };
    EXPECT_THAT(verifiedWith(ofMesh("light_map", "sky")).line(),
                HasSubstr("room_mesh, basis/light_map: found \"sky\", expected \"map\" of its scene"));
    EXPECT_EQ(verifiedWith(ofMesh("light_map", "sky")).code, formats::ErrorCode::Verification);
    EXPECT_EQ(verifiedWith(ofMesh("light_map", 7)).code, formats::ErrorCode::FileUnreadable);
    for (const Json& runs : {Json{0, 5}, Json{0, 1e30}, Json{300, 768}, Json::array()})
        EXPECT_NE(verifiedWith([&](Json& each) {
                      if (each["kind"] == "light-map") each["constants"]["index_runs"] = runs;
                  }).code,
                  formats::ErrorCode::Internal)
            << runs;
}

TEST_F(TwoSquaresSoak, TheMeshIsAnInputOfTheLightMapOnlyWhereBasesAreLearned) {
    cache_ = folder_ / "cache";  // nothing is known from elsewhere
    writeMesh(Neck::Absent);
    const auto again = [&](Neck neck) {
        writeMesh(neck);
        const Outcome outcome = cook();
        EXPECT_TRUE(outcome.errors.empty());
        return outcome.actionsRun;
    };
    writeScene("light_map_layout = \"ratio\"");
    expectCooksAndVerifies();
    EXPECT_EQ(again(Neck::Present), 4) << "its materials, itself, its verification, and that of the light map, which draws the mesh";
    writeScene("light_map_layout = \"basis-4\"");
    expectCooksAndVerifies();
    EXPECT_EQ(again(Neck::Absent), 4) << "itself, the light map, and their verifications: its materials are known by now";
    EXPECT_EQ(cook().actionsRun, 0);
    formats::writeContent(folder_ / "wood.png", "no picture, but one that the mesh names");
    EXPECT_EQ(cook().actionsRun, 3) << "of a picture the light map knows nothing";
}

TEST_F(TwoSquaresSoak, OnlyOfAMeshCooksTheLightMapOfItsClusters) {
    writeMesh(Neck::Present);
    for (const char* output : {"light_map_layout = \"basis-3\"", "max_error = 0.05"}) {
        writeScene(output);
        const Outcome outcome = cook("room_mesh");
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        EXPECT_TRUE(asset("room_mesh").is_object());
        const bool isLearned = asset("map").is_object() && asset("map").at("layout").get<std::string>().starts_with("basis-");
        EXPECT_EQ(asset("room_mesh").contains("basis"), isLearned);
        for (const formats::Error& error : verify().errors) ADD_FAILURE() << error.line();
    }
}

TEST_F(TwoSquares, OnlyRemovesAMeshTogetherWithTheMapThatNeedsIt) {
    writeMesh(Neck::Present);
    writeScene("light_map_layout = \"basis-4\"\ndraco = false");
    expectCooksAndVerifies();
    ASSERT_TRUE(asset("room_mesh").is_object());
    writeScene("light_map_layout = \"ratio\"\ndraco = false");
    EXPECT_TRUE(cook("map_dominant").errors.empty());
    EXPECT_TRUE(asset("room_mesh").is_object()) << "the map is still the learned one";
    EXPECT_TRUE(cook("map").errors.empty());
    EXPECT_EQ(asset("map").at("layout"), "ratio");
    EXPECT_TRUE(asset("room_mesh").is_null());
    EXPECT_TRUE(verify().errors.empty());
}

TEST_F(TwoSquares, AMeshThatCannotBeReadDoesNotStopALearnedLightMap) {
    writeScene("light_map_layout = \"basis-4\"");
    const auto keepGoing = [&] {
        CookOptions options;
        options.scene = folder_ / "scene.toml";
        options.output = folder_ / "out";
        options.cache = cache_;
        options.keepGoing = true;
        const RunState state;
        const Outcome outcome = cookScene(options, state);
        EXPECT_EQ(outcome.errors.size(), 1u);
        EXPECT_TRUE(asset("map").is_object());
        EXPECT_TRUE(asset("room_mesh").is_null());
    };
    keepGoing();  // there is none
    formats::writeContent(folder_ / "room.gltf", "no glTF");
    keepGoing();
}

/// A limit on visible errors alone: bits that rel_rms would allow are too few for it.
TEST(MeshBits, KeepALimitOnVisibleErrors) {
    const formats::TemporaryFolder folder;
    for (const char* file : {"cornell_lightmap.exr", "cornell.glb"}) std::filesystem::copy_file(exampleFolder() / file, folder / file);
    const auto cooked = [&](const std::string& limit) {
        formats::writeContent(folder / "scene.toml", "schema = 1\nname = \"box\"\n[output]\nlight_map_layout = \"raw\"\nmax_error = 0.1\n" +
                                                         limit +
                                                         "\n[[light_map]]\nname = \"map\"\nfile = \"cornell_lightmap.exr\"\nmesh = "
                                                         "\"cornell.glb\"\n[[material]]\nname = \"*\"\nspecular = false\n");
        CookOptions options;
        options.scene = folder / "scene.toml";
        options.output = folder / "out";
        options.cache = LIGHTCOOK_TEST_CACHE;
        options.only = "cornell_mesh";
        const RunState state;
        const Outcome outcome = cookScene(options, state);
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        return outcome.report.at("assets").at(0);
    };
    const auto visibleOf = [](const Json& mesh) {
        return mesh.at("stages").back().at("error").at("diffuse").at("visible").at("p99").get<double>();
    };
    const Json free = cooked(""), limited = cooked("max_visible = 0.4");
    EXPECT_GT(visibleOf(free), 0.4);
    EXPECT_LT(visibleOf(limited), 0.3) << "half of the limit, by an estimate of the largest shift";
    EXPECT_GT(visibleOf(limited), 0.1) << "no more bits than that takes";
    const auto bitsOf = [](const Json& mesh) {
        return mesh.at("notes").at("light_map_uv_bits").get<int>() + mesh.at("notes").at("normal_bits").get<int>();
    };
    EXPECT_GT(bitsOf(limited), bitsOf(free));
}

}  // namespace
}  // namespace lightcook::pipeline
