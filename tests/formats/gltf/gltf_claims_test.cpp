// glTF and Draco files of a few bytes that claim to be enormous.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "formats/gltf/gltf_document.h"
#include "formats/gltf_scene.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

using testing::HasSubstr;

class GltfClaims : public testing::Test {
protected:
    Error refusalOf(const std::string& text) const {
        writeContent(folder_ / "a.gltf", text);
        const auto start = std::chrono::steady_clock::now();
        const auto scene = GltfScene::load(folder_ / "a.gltf");
        EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
        return scene ? Error{} : scene.error();
    }

    const TemporaryFolder folder_;
};

TEST_F(GltfClaims, AGlbHasLessThanFourGigabytes) {
    EXPECT_TRUE(checkGlbSize(0xFFFFFFFF, "room.glb"));
    const auto size = checkGlbSize(std::uint64_t{1} << 32, "room.glb");
    ASSERT_FALSE(size);
    EXPECT_EQ(size.error().line(), "room.glb: found 4294967296 bytes, expected less than 4 GiB in a GLB");
}

TEST_F(GltfClaims, JsonIsNotNestedDeeply) {
    const std::string head = R"({"asset":{"version":"2.0"},"nodes":[)";
    std::string open, close;
    for (int i = 0; i < 100000; ++i) {
        open += R"({"children":[)";
        close += "]}";
    }
    for (const std::string& text : {head + open, fmt::format("{}{}{}]}}", head, open, close),
                                    fmt::format(R"({{"asset":{{"version":"2.0"}},"extras":{})", std::string(200000, '['))}) {
        const Error error = refusalOf(text);
        EXPECT_EQ(error.code, ErrorCode::FileUnreadable);
        EXPECT_THAT(error.line(), HasSubstr("found JSON nested more than 256 deep, expected a glTF 2.0 file"));
    }
}

/// A chain of nodes is not nested JSON, but engines recurse over it.
TEST_F(GltfClaims, AChainOfNodesHasALimit) {
    const auto chainOf = [](int nodes) {
        std::string text = R"({"asset":{"version":"2.0"},"nodes":[)";
        for (int i = 1; i < nodes; ++i) text += fmt::format(R"({{"children":[{}]}},)", i);
        return text + "{}]}";
    };
    EXPECT_EQ(refusalOf(chainOf(1024)).line(), ": ") << "it is read";
    for (const int nodes : {1025, 100000}) {
        const Error error = refusalOf(chainOf(nodes));
        EXPECT_EQ(error.code, ErrorCode::FormatUnsupported);
        EXPECT_THAT(error.line(), HasSubstr(fmt::format("found nodes {} deep, expected at most 1024", nodes)));
    }
    // The depth of a circle has no end.
    EXPECT_THAT(refusalOf(R"({"asset":{"version":"2.0"},"nodes":[{"children":[1]},{"children":[0]}],"scenes":[{"nodes":[0]}]})").line(),
                HasSubstr("node 0: found the node below itself"));
}

TEST_F(GltfClaims, DracoCountsAreCheckedAgainstTheMemory) {
    // A mesh of 2.2 * 10^9 faces and points: 7 bits a byte. 2.2: version of the stream; then kind (mesh), method, flags.
    const std::string count = "\xff\xff\xff\xff\x07", head = std::string("DRACO\2\2\1", 8);
    for (const std::string& stream : {fmt::format("{}{}{}{}", head, std::string("\0\0\0", 3), count, count),
                                      fmt::format("{}{}{}{}", head, std::string("\1\0\0\0", 4), count, count)}) {
        writeContent(folder_ / "a.bin", stream + std::string(64, '\0'));
        const Error error = refusalOf(fmt::format(
            R"({{"asset":{{"version":"2.0"}},"accessors":[{{"componentType":5126,"count":3,"type":"VEC3"}}],
                "buffers":[{{"byteLength":{0},"uri":"a.bin"}}],"bufferViews":[{{"buffer":0,"byteLength":{0}}}],
                "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"extensions":
                {{"KHR_draco_mesh_compression":{{"bufferView":0,"attributes":{{"POSITION":0}}}}}}}}]}}]}})",
            stream.size() + 64));
        EXPECT_EQ(error.code, ErrorCode::FileUnreadable);
        EXPECT_THAT(error.line(), testing::AllOf(HasSubstr("bufferView 0"), HasSubstr("of memory")));
    }
}

/// A thousand buffers of one file are read once.
TEST_F(GltfClaims, BuffersOfOneFileShareItsBytes) {
    const std::size_t length = std::size_t{32} << 20;
    writeContent(folder_ / "a.bin", std::string(length, '\0'));
    std::string buffers;
    for (int i = 0; i < 1024; ++i)
        buffers += fmt::format(R"({}{{"byteLength":{},"uri":"{}a.bin"}})", i == 0 ? "" : ",", length - static_cast<std::size_t>(i),
                               i % 2 == 0 ? "" : "./");
    writeContent(folder_ / "a.gltf", fmt::format(R"({{"asset":{{"version":"2.0"}},"buffers":[{}],"bufferViews":[
        {{"buffer":1023,"byteLength":{}}}, {{"buffer":1023,"byteLength":{}}}]}})",
                                                 buffers, length - 1023, length));
    const GltfDocument document(folder_ / "a.gltf");
    EXPECT_EQ(document.bufferView(0).size(), length - 1023);
    EXPECT_THROW((void)document.bufferView(1), GltfFault) << "the buffer is shorter than its file";
    EXPECT_EQ(document.fileBytes(), length + std::filesystem::file_size(folder_ / "a.gltf"));
}

/// A glTF may come from anybody.
TEST_F(GltfClaims, FilesOutsideItsFolderAreNotRead) {
    std::filesystem::create_directories(folder_ / "scene/parts");
    writeContent(folder_ / "secret.bin", std::string(36, '\0'));
    writeContent(folder_ / "scene/parts/a.bin", std::string(36, '\0'));
    const auto refusalOfUri = [&](const std::string& uri) {
        writeContent(folder_ / "scene/a.gltf", fmt::format(R"({{"asset":{{"version":"2.0"}},"buffers":[
                         {{"byteLength":3,"uri":"data:application/octet-stream;base64,AAAA"}}, {{"byteLength":36,"uri":"{}"}}]}})",
                                                           uri));
        const auto scene = GltfScene::load(folder_ / "scene/a.gltf");
        EXPECT_EQ(gltfFilesBeside(folder_ / "scene/a.gltf", GltfFiles::All).size(), scene ? 1u : 0u);
        return scene ? Error{} : scene.error();
    };
    for (const std::string& uri : {std::string("parts/a.bin"), std::string("./parts/../parts/a.bin"), std::string("parts%2Fa.bin")})
        EXPECT_EQ(refusalOfUri(uri).line(), ": ") << uri;
    for (const std::string& uri :
         {std::string("../secret.bin"), (folder_ / "secret.bin").string(), std::string("parts/../../secret.bin"),
          std::string("%2E%2E/secret.bin"), std::string("..%2fsecret.bin"), std::string("/etc/passwd"), std::string("%2Fetc/passwd")}) {
        const Error error = refusalOfUri(uri);
        EXPECT_EQ(error.code, ErrorCode::FormatUnsupported);
        EXPECT_THAT(error.line(),
                    HasSubstr(fmt::format("a.gltf, buffer 1: found the file \"{}\", expected one in the folder of the glTF", uri)));
    }
}

}  // namespace
}  // namespace lightcook::formats
