// Our KTX2 files, read by somebody else: npm's ktx-parse.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "formats/file/file_bytes.h"
#include "formats/gpu_texture.h"
#include "tests/formats/temporary_folder.h"
#include "tests/formats/texture_fixture.h"

namespace lightcook::formats {
namespace {

using nlohmann::json;

/// Data format descriptors from the Khronos specifications, written by hand: [bit offset, bit length - 1, channel and qualifiers, lower,
/// upper].
struct Expected {
    PixelFormat format;
    int vkFormat, typeSize, model, transfer;
    std::vector<int> block;  ///< extent - 1
    int bytesPlane0;
    json samples;
};

constexpr std::uint32_t kAll = 0xffffffffu, kOne = 0x3f800000u, kMinusOne = 0xbf800000u;

std::vector<Expected> expectations() {
    const std::vector<int> b1 = {0, 0, 0, 0}, b4 = {3, 3, 0, 0}, b6 = {5, 5, 0, 0}, b8 = {7, 7, 0, 0};
    const json hdrBlock = {{0, 127, 0xc0, kMinusOne, kOne}};
    return {
        {PixelFormat::Bc1, 131, 1, 128, 1, b4, 8, {{0, 63, 0, 0, kAll}}},
        {PixelFormat::Bc3, 137, 1, 130, 1, b4, 16, {{0, 63, 15, 0, kAll}, {64, 63, 0, 0, kAll}}},
        {PixelFormat::Bc4, 139, 1, 131, 1, b4, 8, {{0, 63, 0, 0, kAll}}},
        {PixelFormat::Bc4Snorm, 140, 1, 131, 1, b4, 8, {{0, 63, 0x40, 0x80000000u, 0x7fffffffu}}},
        {PixelFormat::Bc5, 141, 1, 132, 1, b4, 16, {{0, 63, 0, 0, kAll}, {64, 63, 1, 0, kAll}}},
        {PixelFormat::Bc5Snorm,
         142,
         1,
         132,
         1,
         b4,
         16,
         {{0, 63, 0x40, 0x80000000u, 0x7fffffffu}, {64, 63, 0x41, 0x80000000u, 0x7fffffffu}}},
        {PixelFormat::Bc6hUf16, 143, 1, 133, 1, b4, 16, {{0, 127, 0x80, 0, kOne}}},
        {PixelFormat::Bc6hSf16, 144, 1, 133, 1, b4, 16, hdrBlock},
        {PixelFormat::Bc7, 145, 1, 134, 1, b4, 16, {{0, 127, 0, 0, kAll}}},
        {PixelFormat::Astc4x4Hdr, 1000066000, 1, 162, 1, b4, 16, hdrBlock},
        {PixelFormat::Astc6x6Hdr, 1000066004, 1, 162, 1, b6, 16, hdrBlock},
        {PixelFormat::Astc8x8Hdr, 1000066007, 1, 162, 1, b8, 16, hdrBlock},
        {PixelFormat::Astc4x4Ldr, 157, 1, 162, 1, b4, 16, {{0, 127, 0, 0, kAll}}},
        {PixelFormat::Rgb9e5,
         123,
         4,
         1,
         1,
         b1,
         4,
         {{0, 8, 0, 0, 8448},
          {27, 4, 0x20, 15, 31},
          {9, 8, 1, 0, 8448},
          {27, 4, 0x21, 15, 31},
          {18, 8, 2, 0, 8448},
          {27, 4, 0x22, 15, 31}}},
        {PixelFormat::R11g11b10f, 122, 4, 1, 1, b1, 4, {{0, 10, 0x80, 0, kOne}, {11, 10, 0x81, 0, kOne}, {22, 9, 0x82, 0, kOne}}},
        {PixelFormat::Rgba16f,
         97,
         2,
         1,
         1,
         b1,
         8,
         {{0, 15, 0xc0, kMinusOne, kOne},
          {16, 15, 0xc1, kMinusOne, kOne},
          {32, 15, 0xc2, kMinusOne, kOne},
          {48, 15, 0xcf, kMinusOne, kOne}}},
        {PixelFormat::Rgb16f,
         90,
         2,
         1,
         1,
         b1,
         6,
         {{0, 15, 0xc0, kMinusOne, kOne}, {16, 15, 0xc1, kMinusOne, kOne}, {32, 15, 0xc2, kMinusOne, kOne}}},
        {PixelFormat::R16Unorm, 70, 2, 1, 1, b1, 2, {{0, 15, 0, 0, 65535}}},
        {PixelFormat::Rg16Unorm, 77, 2, 1, 1, b1, 4, {{0, 15, 0, 0, 65535}, {16, 15, 1, 0, 65535}}},
        {PixelFormat::Rgba16Unorm,
         91,
         2,
         1,
         1,
         b1,
         8,
         {{0, 15, 0, 0, 65535}, {16, 15, 1, 0, 65535}, {32, 15, 2, 0, 65535}, {48, 15, 15, 0, 65535}}},
        {PixelFormat::Rgba8Unorm, 37, 1, 1, 1, b1, 4, {{0, 7, 0, 0, 255}, {8, 7, 1, 0, 255}, {16, 7, 2, 0, 255}, {24, 7, 15, 0, 255}}},
        {PixelFormat::Rgba8Srgb, 43, 1, 1, 2, b1, 4, {{0, 7, 0, 0, 255}, {8, 7, 1, 0, 255}, {16, 7, 2, 0, 255}, {24, 7, 0x1f, 0, 255}}},
    };
}

/// The answer of check.mjs, or nothing where node or ktx-parse are not installed.
std::optional<json> askKtxParse(const std::vector<std::filesystem::path>& files) {
    const std::filesystem::path folder = std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "tests/formats/ktx_parse";
    if (!std::filesystem::exists(folder / "node_modules/ktx-parse") || std::system("node --version > /dev/null 2>&1") != 0) return {};
    std::string command = "cd '" + folder.string() + "' && node check.mjs";
    for (const std::filesystem::path& file : files) command += " '" + file.string() + "'";
    std::FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return json();
    std::string text;
    std::array<char, 4096> buffer;
    for (std::size_t count = 0; (count = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) text.append(buffer.data(), count);
    if (::pclose(pipe) != 0) return json();
    return json::parse(text);
}

std::uint32_t hashOf(std::span<const std::byte> bytes) {
    std::uint32_t value = 0x811c9dc5;
    for (const std::byte byte : bytes) value = (value ^ std::to_integer<std::uint32_t>(byte)) * 0x01000193;
    return value;
}

struct Case {
    Expected expected;
    TextureShape shape;
    bool zstd;
    std::filesystem::path file;
};

void compare(const Case& written, const json& found) {
    const TextureShape& shape = written.shape;
    EXPECT_EQ(found["vkFormat"], written.expected.vkFormat);
    EXPECT_EQ(found["typeSize"], written.expected.typeSize);
    EXPECT_EQ(found["pixelWidth"], shape.width);
    EXPECT_EQ(found["pixelHeight"], shape.height);
    EXPECT_EQ(found["pixelDepth"], 0);
    EXPECT_EQ(found["layerCount"], shape.isArray ? shape.layerCount : 0);
    EXPECT_EQ(found["faceCount"], shape.faceCount);
    EXPECT_EQ(found["levelCount"], shape.mipCount);
    EXPECT_EQ(found["supercompressionScheme"], written.zstd ? 2 : 0);
    ASSERT_EQ(found["descriptors"].size(), 1u);
    const json& descriptor = found["descriptors"][0];
    EXPECT_EQ(descriptor["model"], written.expected.model);
    EXPECT_EQ(descriptor["primaries"], 1);
    EXPECT_EQ(descriptor["transfer"], written.expected.transfer);
    EXPECT_EQ(descriptor["flags"], 0);
    EXPECT_EQ(descriptor["block"], json(written.expected.block));
    EXPECT_EQ(descriptor["bytesPlane"], json({written.expected.bytesPlane0, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(descriptor["samples"], written.expected.samples) << descriptor["samples"];
    EXPECT_EQ(found["keys"], json({{"KTXorientation", "rd"}, {"KTXwriter", "lightcook 0.1.0"}, {"lightcook.test", "value"}}));
    ASSERT_EQ(found["levels"].size(), static_cast<std::size_t>(shape.mipCount));
    for (int mip = 0; mip < shape.mipCount; ++mip) {
        std::vector<std::byte> level;
        for (int layer = 0; layer < shape.layerCount; ++layer)
            for (int face = 0; face < shape.faceCount; ++face) {
                const std::vector<std::byte> image = patternImage(shape, {mip, layer, face});
                level.insert(level.end(), image.begin(), image.end());
            }
        const json& place = found["levels"][static_cast<std::size_t>(mip)];
        EXPECT_EQ(place["uncompressedBytes"], level.size());
        if (written.zstd) continue;
        EXPECT_EQ(place["bytes"], level.size());
        EXPECT_EQ(place["hash"], hashOf(level));
    }
}

TEST(KtxParse, ReadsEveryFormatShapeAndLevelAsWeWroteThem) {
    const TemporaryFolder folder;
    std::vector<Case> cases;
    std::vector<std::filesystem::path> files;
    for (const Expected& expected : expectations())
        for (const TextureShape& shape :
             {TextureShape{expected.format, 37, 21, 6, 1, false, 1}, TextureShape{expected.format, 9, 5, 1, 3, true, 1},
              TextureShape{expected.format, 19, 19, 5, 1, false, 6}})
            for (const bool zstd : {false, true}) {
                cases.push_back({expected, shape, zstd, folder / (std::to_string(cases.size()) + ".ktx2")});
                TextureFileOptions options;
                options.zstd = zstd;
                options.metadata = {{"lightcook.test", "value"}};
                ASSERT_TRUE(writePattern(cases.back().file, shape, options));
                files.push_back(cases.back().file);
            }
    ASSERT_EQ(cases.size(), allPixelFormats().size() * 6);
    const std::optional<json> found = askKtxParse(files);
    if (!found) GTEST_SKIP() << "node or tests/formats/ktx_parse/node_modules is not there: run ./dev setup (npm ci)";
    ASSERT_EQ(found->size(), cases.size());
    for (std::size_t i = 0; i < cases.size(); ++i) {
        SCOPED_TRACE(std::string(info(cases[i].shape.format).name) + (cases[i].zstd ? " zstd" : ""));
        compare(cases[i], (*found)[i]);
    }
}

/// ktx-parse does not judge alignment and order: the specification does.
TEST(Ktx2File, LevelsComeSmallestFirstAndAligned) {
    const TemporaryFolder folder;
    for (const PixelFormatInfo& format : allPixelFormats()) {
        ASSERT_TRUE(writePattern(folder / "texture", {format.format, 37, 21, 6, 1, false, 1}, {}));
        const std::vector<std::byte> bytes = wholeFile(folder / "texture");
        std::uint64_t end = 0;
        for (std::size_t mip = 6; mip-- > 0;) {
            const std::uint64_t offset = loadU64(bytes, 80 + 24 * mip), length = loadU64(bytes, 88 + 24 * mip);
            EXPECT_GE(offset, end) << format.name;
            EXPECT_EQ(offset % 4, 0u) << format.name;
            EXPECT_EQ(offset % static_cast<std::uint64_t>(format.bytesPerBlock), 0u) << format.name;
            end = offset + length;
        }
        EXPECT_EQ(end, bytes.size());
    }
}

}  // namespace
}  // namespace lightcook::formats
