// EXR headers that claim more than a file can hold, made byte by byte: OpenEXR itself would refuse to write them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <string>
#include <vector>

#include "formats/environment.h"
#include "formats/image/exr_file.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

enum Compression : char { kNone = 0, kZip = 3, kDwab = 9 };
enum PixelType : std::uint32_t { kUint = 0, kFloat = 2 };

std::string bytesOf(std::uint32_t value) {
    std::string bytes;
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xff);
    return bytes;
}
std::string attribute(const std::string& name, const std::string& type, const std::string& value) {
    return name + '\0' + type + '\0' + bytesOf(static_cast<std::uint32_t>(value.size())) + value;
}

struct Header {
    std::uint32_t width = 16, height = 8;
    std::vector<std::string> channels = {"B", "G", "R"};
    Compression compression = kNone;
    PixelType type = kFloat;
    std::uint32_t tileExtent = 0;  ///< 0: scan lines
};

/// Returns a file of the header and `rest` bytes of value 1, which are no pixel data.
std::string fileOf(const Header& header, std::size_t rest) {
    std::string channels;
    for (const std::string& name : header.channels) channels += name + '\0' + bytesOf(header.type) + bytesOf(0) + bytesOf(1) + bytesOf(1);
    const std::string window = bytesOf(0) + bytesOf(0) + bytesOf(header.width - 1) + bytesOf(header.height - 1), one = bytesOf(0x3f800000);
    std::string file = bytesOf(20000630) + bytesOf(header.tileExtent != 0 ? 0x202 : 2);
    file += attribute("channels", "chlist", channels + '\0') + attribute("compression", "compression", {header.compression});
    file += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window);
    file += attribute("lineOrder", "lineOrder", std::string(1, '\0')) + attribute("pixelAspectRatio", "float", one);
    file += attribute("screenWindowCenter", "v2f", bytesOf(0) + bytesOf(0)) + attribute("screenWindowWidth", "float", one);
    if (header.tileExtent != 0)
        file += attribute("tiles", "tiledesc", bytesOf(header.tileExtent) + bytesOf(header.tileExtent) + std::string(1, '\0'));
    return file + '\0' + std::string(rest, '\1');
}

/// Returns the error's line without the memory that was free, which changes between two calls.
std::string lineOf(const Error& error) {
    static const std::regex kFreeMemory("the [0-9]+ MiB that are free");
    return std::regex_replace(error.line(), kFreeMemory, "the memory that is free");
}

class ExrClaims : public testing::Test {
protected:
    /// Expects that neither reader of images nor reader of channels takes the file.
    void expectRefused(const Header& header, std::size_t rest, ErrorCode code, const std::string& words) const {
        SCOPED_TRACE(words);
        writeContent(folder_ / "a.exr", fileOf(header, rest));
        const auto reader = ExrReader::open(folder_ / "a.exr");
        ASSERT_FALSE(reader);
        EXPECT_EQ(reader.error().code, code) << reader.error().line();
        EXPECT_THAT(reader.error().line(), testing::HasSubstr(words));
        if (code != ErrorCode::WrongShape) return;  // else OpenImageIO reports it
        const auto image = readImage(folder_ / "a.exr");
        ASSERT_FALSE(image);
        EXPECT_EQ(lineOf(image.error()), lineOf(reader.error()));
        const auto gradient = loadGradient(folder_ / "a.exr", {});
        ASSERT_FALSE(gradient);
        EXPECT_EQ(lineOf(gradient.error()), lineOf(reader.error()));
    }

    const TemporaryFolder folder_;
};

TEST_F(ExrClaims, ExtentsChannelsAndChunksHaveLimits) {
    expectRefused({.width = 1000000, .height = 1}, 20000, ErrorCode::WrongShape, "found 1000000 x 1 texels, expected 1 to 65536 a side");
    expectRefused({.width = 65536, .height = 65536, .compression = kZip}, 40000, ErrorCode::FileUnreadable,
                  "expected more for 65536 x 65536");
    std::vector<std::string> many;
    for (int i = 0; i < 5000; ++i) many.push_back(std::to_string(10000 + i));
    expectRefused({.channels = many}, 4000, ErrorCode::WrongShape, "found 5000 channels, expected at most 1024");
    many.resize(1024);
    // 64 Ki x 256 x 1024 channels of 4 bytes: 64 GiB in a chunk, which OpenEXR allocates when it opens the file.
    expectRefused({.width = 65536, .height = 256, .channels = many, .compression = kDwab}, 4000, ErrorCode::WrongShape, "of memory");
    expectRefused({.width = 2048, .height = 2048, .channels = std::vector(many), .compression = kZip, .tileExtent = 4096}, 4000,
                  ErrorCode::FormatUnsupported, "found tiles of 4096 x 4096");
}

TEST_F(ExrClaims, ChannelsOfIntegersAreNoLight) {
    const Header header{.type = kUint};
    std::string file = fileOf(header, 0);
    const std::size_t table = file.size(), rowBytes = 8 + 16 * 3 * 4;
    for (std::size_t row = 0; row < header.height; ++row)
        file += bytesOf(static_cast<std::uint32_t>(table + 8 * 8 + row * rowBytes)) + bytesOf(0);
    for (std::uint32_t row = 0; row < header.height; ++row) file += bytesOf(row) + bytesOf(16 * 3 * 4) + std::string(16 * 3 * 4, '\0');
    writeContent(folder_ / "a.exr", file);
    const auto reader = ExrReader::open(folder_ / "a.exr");
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_THAT(reader->info().integerChannels, testing::ElementsAre("B", "G", "R"));
    std::vector<float> texels(16 * 8);
    const ExrPlane plane{"G", texels.data(), 1, 16};
    const auto rows = reader->readRows(0, 8, {&plane, 1});
    ASSERT_FALSE(rows);
    EXPECT_THAT(rows.error().line(), testing::HasSubstr("a.exr, channel G: found 32-bit integers (UINT), expected half or float"));
    const auto image = readImage(folder_ / "a.exr");
    ASSERT_FALSE(image);
    EXPECT_THAT(image.error().line(), testing::HasSubstr("found 32-bit integers (UINT), expected half or float"));
    const auto environment = loadEnvironment(folder_ / "a.exr", {});
    ASSERT_FALSE(environment);
    EXPECT_THAT(environment.error().line(), testing::HasSubstr("found 32-bit integers (UINT), expected half or float"));
}

}  // namespace
}  // namespace lightcook::formats
