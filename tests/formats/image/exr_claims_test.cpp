// EXR headers, made byte by byte: claims of more than a file can hold, which OpenEXR itself would refuse to write, windows and
// chromaticities.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "formats/environment.h"
#include "formats/image/exr_file.h"
#include "formats/light_map.h"
#include "formats/plain_image.h"
#include "tests/formats/picture_fixture.h"
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

/// A window of a file: its corner and its size.
struct Box {
    int x = 0, y = 0;
    std::uint32_t width = 0, height = 0;

    std::string bytes() const {
        const auto left = static_cast<std::uint32_t>(x), top = static_cast<std::uint32_t>(y);
        return bytesOf(left) + bytesOf(top) + bytesOf(left + width - 1) + bytesOf(top + height - 1);
    }
};

struct Header {
    std::uint32_t width = 16, height = 8;
    std::vector<std::string> channels = {"B", "G", "R"};
    Compression compression = kNone;
    PixelType type = kFloat;
    std::uint32_t tileExtent = 0;     ///< 0: scan lines
    int x = 0, y = 0;                 ///< corner of the data window
    std::optional<Box> display = {};  ///< empty: the data window
    std::string more = {};            ///< further attributes
};

/// Returns a file of the header and `rest` bytes of value 1, which are no pixel data.
std::string fileOf(const Header& header, std::size_t rest) {
    std::string channels;
    for (const std::string& name : header.channels) channels += name + '\0' + bytesOf(header.type) + bytesOf(0) + bytesOf(1) + bytesOf(1);
    const Box data{header.x, header.y, header.width, header.height};
    const std::string one = bytesOf(0x3f800000);
    std::string file = bytesOf(20000630) + bytesOf(header.tileExtent != 0 ? 0x202 : 2);
    file += attribute("channels", "chlist", channels + '\0') + attribute("compression", "compression", {header.compression});
    file += attribute("dataWindow", "box2i", data.bytes());
    file += attribute("displayWindow", "box2i", header.display.value_or(data).bytes());
    file += attribute("lineOrder", "lineOrder", std::string(1, '\0')) + attribute("pixelAspectRatio", "float", one);
    file += attribute("screenWindowCenter", "v2f", bytesOf(0) + bytesOf(0)) + attribute("screenWindowWidth", "float", one);
    if (header.tileExtent != 0)
        file += attribute("tiles", "tiledesc", bytesOf(header.tileExtent) + bytesOf(header.tileExtent) + std::string(1, '\0'));
    return file + header.more + '\0' + std::string(rest, '\1');
}

/// Returns a whole file: scan lines of zeros, four bytes a channel, not compressed.
std::string wholeFileOf(const Header& header) {
    std::string file = fileOf(header, 0);
    const auto pixelBytes = static_cast<std::uint32_t>(header.width * header.channels.size() * 4);
    const std::size_t firstChunk = file.size() + header.height * std::size_t{8}, chunkBytes = 8 + pixelBytes;
    for (std::size_t row = 0; row < header.height; ++row)
        file += bytesOf(static_cast<std::uint32_t>(firstChunk + row * chunkBytes)) + bytesOf(0);
    for (std::uint32_t row = 0; row < header.height; ++row)
        file += bytesOf(static_cast<std::uint32_t>(header.y) + row) + bytesOf(pixelBytes) + std::string(pixelBytes, '\0');
    return file;
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
        const auto image = readImage(folder_ / "a.exr");
        ASSERT_FALSE(image);
        EXPECT_EQ(lineOf(image.error()), lineOf(reader.error()));
        const auto gradient = loadPaintedGradient(folder_ / "a.exr", {});
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
    writeContent(folder_ / "a.exr", wholeFileOf({.type = kUint}));
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

/// Writes parts of 4 x 2 texels whose channels are R, G and B.
void writeParts(const std::filesystem::path& file, const std::vector<const char*>& names) {
    std::vector<Imf::Header> headers;
    for (const char* name : names) {
        Imf::Header& header = headers.emplace_back(4, 2);
        header.setName(name);
        header.setType(Imf::SCANLINEIMAGE);
        for (const char* channel : {"R", "G", "B"}) header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
    }
    Imf::MultiPartOutputFile output(file.c_str(), headers.data(), static_cast<int>(headers.size()));
    const std::vector<float> texels(8, 0.5f);
    for (int i = 0; i < static_cast<int>(names.size()); ++i) {
        Imf::OutputPart part(output, i);
        Imf::FrameBuffer buffer;
        for (const char* channel : {"R", "G", "B"})
            buffer.insert(channel, Imf::Slice::Make(Imf::FLOAT, texels.data(), Imath::V2i(0, 0), 4, 2));
        part.setFrameBuffer(buffer);
        part.writePixels(2);
    }
}

TEST_F(ExrClaims, SeveralPartsAreRefusedByNameWhereverAnExrIsRead) {
    const auto file = folder_ / "a.exr";
    writeParts(file, {"depthpass", "beauty"});
    const std::string line = file.string() +
                             ": found 2 parts, \"depthpass\" (B, G, R), \"beauty\" (B, G, R), expected one flat image. Take one out: "
                             "oiiotool in.exr --subimage NAME -o out.exr";
    const auto expectLine = [&line](const auto& read) {
        ASSERT_FALSE(read);
        EXPECT_EQ(read.error().line(), line);
        EXPECT_EQ(read.error().code, ErrorCode::FormatUnsupported);
    };
    expectLine(ExrReader::open(file));
    expectLine(readImage(file));
    expectLine(loadPaintedGradient(file, {}));
    expectLine(loadEnvironment(file, {}));
    expectLine(LightMapReader::open(file, {}));
}

TEST_F(ExrClaims, DeepImagesAndChromaAreRefusedByName) {
    const auto lineFor = [&](const std::string& content) {
        writeContent(folder_ / "a.exr", content);
        const auto image = readImage(folder_ / "a.exr");
        EXPECT_FALSE(image);
        return image ? "" : image.error().line();
    };
    std::string deep = wholeFileOf({.more = attribute("type", "string", "deepscanline")});
    deep[5] = 8;  // the flag of other texels than flat ones
    EXPECT_THAT(lineFor(deep), testing::HasSubstr("a.exr: found a deep image (B, G, R), expected a flat one. Flatten it: oiiotool in.exr "
                                                  "--flatten -o out.exr"));
    {
        Imf::RgbaOutputFile output((folder_ / "chroma.exr").c_str(), Imf::Header(8, 8), Imf::WRITE_YC);
        const std::vector<Imf::Rgba> texels(64, Imf::Rgba(0.5f, 0.25f, 1));
        output.setFrameBuffer(texels.data(), 1, 8);
        output.writePixels(8);
    }
    EXPECT_THAT(lineFor(contentOf(folder_ / "chroma.exr")),
                testing::HasSubstr("found luminance and chroma (BY, RY, Y), expected R, G and B. Export it as RGB"));
}

TEST_F(ExrClaims, IntegersBesideTheColoursAreOfNoConsequence) {
    std::string content = wholeFileOf({.channels = {"B", "G", "R", "id"}});
    content[content.find(std::string("id\0", 3)) + 3] = 0;  // its type: UINT
    writeContent(folder_ / "a.exr", content);
    const auto image = readImage(folder_ / "a.exr");
    ASSERT_TRUE(image) << image.error().line();
    EXPECT_THAT(image->ignored, testing::ElementsAre("id"));
    EXPECT_TRUE(loadEnvironment(folder_ / "a.exr", {}));
}

TEST_F(ExrClaims, DataWindowsThatAreNotTheDisplayWindowAreRefused) {
    struct Case {
        Box data, display;
        const char* found;
        const char* remedy;
    };
    for (const Case& window : {Case{{8, 8, 32, 1},
                                    {0, 0, 64, 64},
                                    "32 x 1 texels at (8, 8), smaller than the display window of 64 x 64 texels at (0, 0)",
                                    "Pad with black"},
                               Case{{-4, -1, 72, 6},
                                    {0, 0, 64, 4},
                                    "72 x 6 texels at (-4, -1), larger than the display window of 64 x 4 texels at (0, 0)",
                                    "Crop"},
                               Case{{-4, 0, 64, 1},
                                    {0, 0, 64, 1},
                                    "64 x 1 texels at (-4, 0), partly outside the display window of 64 x 1 texels at (0, 0)",
                                    "Crop and pad with black"}}) {
        const Header header{
            .width = window.data.width, .height = window.data.height, .x = window.data.x, .y = window.data.y, .display = window.display};
        writeContent(folder_ / "a.exr", wholeFileOf(header));
        const std::string line = (folder_ / "a.exr").string() + ": found a data window of " + window.found + ", expected equal windows. " +
                                 window.remedy + ": oiiotool in.exr --croptofull -o out.exr";
        const auto expectLine = [&line](const auto& read) {
            ASSERT_FALSE(read) << line;
            EXPECT_EQ(read.error().code, ErrorCode::WrongShape);
            EXPECT_EQ(read.error().line(), line);
        };
        expectLine(ExrReader::open(folder_ / "a.exr"));
        expectLine(readImage(folder_ / "a.exr"));
        expectLine(loadPaintedGradient(folder_ / "a.exr", {}));
        expectLine(loadEnvironment(folder_ / "a.exr", {}));
    }
}

TEST_F(ExrClaims, EqualWindowsMayBeginAnywhere) {
    writeContent(folder_ / "a.exr", wholeFileOf({.x = -3, .y = 11}));
    const auto reader = ExrReader::open(folder_ / "a.exr");
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->info().width, 16);
    EXPECT_EQ(reader->info().height, 8);
    const auto environment = loadEnvironment(folder_ / "a.exr", {});
    EXPECT_TRUE(environment) << environment.error().line();
    const auto image = readImage(folder_ / "a.exr");
    EXPECT_TRUE(image) << image.error().line();
}

TEST_F(ExrClaims, PicturesOfOtherFormatsMayHaveAnOffset) {
    writePng(folder_ / "a.png", 2, 1, 3, [](int, int, int) { return 51; });
    std::string content = contentOf(folder_ / "a.png");
    content.insert(content.find("IDAT") - 4, pngChunk("oFFs", bigEndian(5) + bigEndian(7) + std::string(1, '\0')));
    writeContent(folder_ / "a.png", content);
    const auto image = readImage(folder_ / "a.png");
    ASSERT_TRUE(image) << image.error().line();
    EXPECT_NEAR(image->texels.at(1, 0).g, 0.2f, 1e-6f);
}

TEST_F(ExrClaims, ChromaticitiesAreThoseOfTheHeader) {
    writeContent(folder_ / "a.exr", wholeFileOf({}));
    const auto without = ExrReader::open(folder_ / "a.exr");
    ASSERT_TRUE(without) << without.error().line();
    EXPECT_FALSE(without->info().chromaticities);
    constexpr std::array<float, 8> kAcesCg = {0.713f, 0.293f, 0.165f, 0.83f, 0.128f, 0.044f, 0.32168f, 0.33767f};
    std::string value;
    for (const float number : kAcesCg) value += bytesOf(std::bit_cast<std::uint32_t>(number));
    writeContent(folder_ / "a.exr", wholeFileOf({.more = attribute("chromaticities", "chromaticities", value)}));
    const auto with = ExrReader::open(folder_ / "a.exr");
    ASSERT_TRUE(with) << with.error().line();
    EXPECT_EQ(with->info().chromaticities, kAcesCg);
}

}  // namespace
}  // namespace lightcook::formats
