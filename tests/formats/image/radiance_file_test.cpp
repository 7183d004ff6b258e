// Our reader of Radiance pictures against OpenImageIO's, and against files that are cut, changed or of another kind.
#include "formats/image/radiance_file.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "formats/environment.h"
#include "formats/plain_image.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

/// Nothing if OpenImageIO refuses.
std::optional<Image<glm::vec3>> readByOpenImageIO(const std::filesystem::path& file) {
    const auto input = OIIO::ImageInput::open(file.string());
    if (!input || input->spec().nchannels != 3) return std::nullopt;
    Image<glm::vec3> texels(input->spec().width, input->spec().height);
    if (!input->read_image(0, 0, 0, 3, OIIO::TypeDesc::FLOAT, texels.texels().data())) return std::nullopt;
    return texels;
}

/// Runs and noise, zeros, and every exponent that a picture can hold.
void writePicture(const std::filesystem::path& file, int width, int height, std::mt19937& random) {
    std::vector<float> values;
    float run = 1;
    for (int i = 0; i < width * height; ++i) {
        if (random() % 4 == 0) run = static_cast<float>(std::exp2(static_cast<double>(random() % 240) - 120.0));
        for (int channel = 0; channel < 3; ++channel)
            values.push_back(random() % 8 == 0 ? 0 : run * (random() % 3 == 0 ? static_cast<float>(random() % 256) / 256 : 1.0f));
    }
    const auto output = OIIO::ImageOutput::create(file.string());
    ASSERT_TRUE(output && output->open(file.string(), OIIO::ImageSpec(width, height, 3, OIIO::TypeDesc::FLOAT)));
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()) && output->close());
}

/// Equal but for the last bit: OpenImageIO's powers of two are not exact for some of the exponents (2^-89 becomes the float below it).
void expectEqual(const Image<glm::vec3>& ours, const Image<glm::vec3>& theirs) {
    ASSERT_EQ(ours.width(), theirs.width());
    ASSERT_EQ(ours.height(), theirs.height());
    for (std::size_t i = 0; i < ours.texels().size(); ++i)
        for (int channel = 0; channel < 3; ++channel) {
            const float own = ours.texels()[i][channel], other = theirs.texels()[i][channel];
            ASSERT_TRUE(other == own || other == std::nextafter(own, 0.0f)) << "texel " << i << ": " << own << " and " << other;
        }
}

TEST(ReadRadiancePicture, EqualsOpenImageIO) {
    const TemporaryFolder folder;
    std::mt19937 random(1);
    for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {8, 4}, {127, 2}, {128, 64}, {513, 9}, {32767, 1}, {32768, 2}}) {
        writePicture(folder / "p.hdr", width, height, random);
        const auto ours = readRadiancePicture(folder / "p.hdr");
        const auto theirs = readByOpenImageIO(folder / "p.hdr");
        ASSERT_TRUE(ours && theirs) << width;
        EXPECT_EQ(ours->texels.width(), width);
        EXPECT_EQ(ours->texels.height(), height);
        expectEqual(ours->texels, *theirs);
    }
}

/// Any byte changed: either it is left to OpenImageIO, or both read the same.
TEST(ReadRadiancePicture, ChangedFilesAreReadAlikeOrNotAtAll) {
    const TemporaryFolder folder;
    const auto file = folder / "p.hdr";
    std::mt19937 random(2);
    int readCount = 0;
    for (int trial = 0; trial < 1000; ++trial) {
        if (trial % 40 == 0)
            writePicture(folder / "whole.hdr", 8 + static_cast<int>(random() % 40), 1 + static_cast<int>(random() % 6), random);
        std::string content = contentOf(folder / "whole.hdr");
        content[random() % content.size()] = static_cast<char>(random());
        writeContent(file, content);
        const auto ours = readRadiancePicture(file);
        if (!ours) continue;
        ++readCount;
        const auto theirs = readByOpenImageIO(file);
        ASSERT_TRUE(theirs) << trial;
        expectEqual(ours->texels, *theirs);
        if (testing::Test::HasFatalFailure()) FAIL() << trial;
    }
    EXPECT_GT(readCount, 250);
}

TEST(ReadRadiancePicture, CutFilesAreNone) {
    const TemporaryFolder folder;
    const auto file = folder / "p.hdr";
    std::mt19937 random(3);
    writePicture(file, 20, 4, random);
    for (std::size_t length = std::filesystem::file_size(file); length-- > 0;) {
        std::filesystem::resize_file(file, length);
        ASSERT_FALSE(readRadiancePicture(file)) << length;
    }
    EXPECT_FALSE(readRadiancePicture(folder / "absent.hdr"));
    EXPECT_FALSE(readRadiancePicture(folder.path()));
}

/// A hole takes no room on the disk.
TEST(ReadRadiancePicture, AFileLargerThanTheMemoryIsNone) {
    const TemporaryFolder folder;
    const auto file = folder / "p.hdr";
    std::mt19937 random(4);
    writePicture(file, 20, 4, random);
    std::error_code code;
    std::filesystem::resize_file(file, std::uintmax_t{1} << 42, code);
    if (code) GTEST_SKIP() << "no file system for such files: " << code.message();
    EXPECT_FALSE(readRadiancePicture(file));
    EXPECT_TRUE(radianceFactors(file));
}

TEST(ReadRadiancePicture, OtherKindsAreLeftToOpenImageIO) {
    const TemporaryFolder folder;
    const auto file = folder / "p.hdr";
    const std::string texels(8, '\x80');
    const auto isRead = [&](const std::string& head) {
        writeContent(file, head + texels);
        return readRadiancePicture(file).has_value();
    };
    EXPECT_TRUE(isRead("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"));
    EXPECT_TRUE(isRead("#?RGBE\n# any comment\nFORMAT=32-bit_rle_rgbe\nGAMMA=1\n\n-Y 2 +X 1\n"));
    for (const char* head :
         {"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 2\n", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+Y 1 +Y 2\n",
          "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n*X 2 -Y 1\n", "#?RADIANCE\n\n-Y 1 +X 2\n",
          "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n-Y 1 +X 2\n", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 2\n",
          "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y -1 +X 2\n", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 70000 +X 70000\n",
          "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 99999999999 +X 2\n", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2 \n",
          "RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"})
        EXPECT_FALSE(isRead(head)) << head;
}

/// Writes `width` x 1 texels that store (1, 0.5, 0.25), flat.
/// lines  of the header, beside the format
void writeFlat(const std::filesystem::path& file, const std::string& lines, int width) {
    std::string content = fmt::format("#?RADIANCE\n{}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X {}\n", lines, width);
    for (int x = 0; x < width; ++x) content += "\x80\x40\x20\x81";
    writeContent(file, content);
}

TEST(RadianceFactors, EveryReaderDividesByThemOnce) {
    const TemporaryFolder folder;
    const auto file = folder / "p.hdr";
    struct Case {
        const char* lines;
        glm::vec3 expected;
    };
    for (const Case& header :
         {Case{"", {1, 0.5f, 0.25f}}, Case{"EXPOSURE=4\n", {0.25f, 0.125f, 0.0625f}},
          Case{"EXPOSURE= 4.0 \nSOFTWARE=x\nEXPOSURE=5.000e-01\n", {0.5f, 0.25f, 0.125f}},
          Case{"COLORCORR= 1 2 0.5\nCOLORCORR=2 1 1\n", {0.5f, 0.25f, 0.5f}},
          Case{"COLORCORR=1\t2 0.5\nEXPOSURE=2\n", {0.5f, 0.125f, 0.25f}}, Case{"PRIMARIES=0 0 0 0 0 0 0 0\n", {1, 0.5f, 0.25f}},
          Case{"\tEXPOSURE=4\n", {1, 0.5f, 0.25f}}}) {  // indented: of a picture that this one was made of
        SCOPED_TRACE(header.lines);
        writeFlat(file, header.lines, 2);
        const auto own = readRadiancePicture(file);
        ASSERT_TRUE(own);
        EXPECT_EQ(own->texels.at(1, 0), header.expected);
        const auto image = readImage(file);
        ASSERT_TRUE(image) << image.error().line();
        EXPECT_EQ(image->texels.at(1, 0), glm::vec4(header.expected, 1));
        const auto gradient = loadPaintedGradient(file, {});
        ASSERT_TRUE(gradient) << gradient.error().line();
        EXPECT_EQ(gradient->zones[1], header.expected);
        writeFlat(file, header.lines, 8);  // flat although rows of 8 can be encoded
        EXPECT_TRUE(readRadiancePicture(file));
        const auto wide = loadPaintedGradient(file, {});
        ASSERT_TRUE(wide) << wide.error().line();
        EXPECT_EQ(wide->zones[7], header.expected);
    }
}

void expectRefused(const std::filesystem::path& file, ErrorCode code, const std::string& detail) {
    SCOPED_TRACE(detail);
    EXPECT_FALSE(readRadiancePicture(file));
    const auto factors = radianceFactors(file);
    const auto image = readImage(file);
    const auto gradient = loadPaintedGradient(file, {});
    ASSERT_TRUE(!factors && !image && !gradient);
    for (const Error& error : {factors.error(), image.error(), gradient.error()}) {
        EXPECT_EQ(error.code, code);
        EXPECT_EQ(error.line(), file.string() + ": " + detail);
    }
}

TEST(RadianceFactors, OtherThanPositiveFiniteNumbersAreRefusedByName) {
    const TemporaryFolder folder;
    const auto file = folder / "p.hdr";
    for (const char* line :
         {"EXPOSURE=", "EXPOSURE=0", "EXPOSURE=-2", "EXPOSURE=nan", "EXPOSURE=inf", "EXPOSURE=1e999", "EXPOSURE=abc", "EXPOSURE=4 5"}) {
        writeFlat(file, fmt::format("EXPOSURE=2\n{}\n", line), 2);
        expectRefused(file, ErrorCode::ValueOutOfRange, fmt::format("found {}, expected 1 positive finite number", line));
    }
    for (const char* line : {"COLORCORR=1", "COLORCORR=1 2", "COLORCORR=1 0 1", "COLORCORR=1 1 1 1"}) {
        writeFlat(file, fmt::format("{}\n", line), 2);
        expectRefused(file, ErrorCode::ValueOutOfRange, fmt::format("found {}, expected 3 positive finite numbers", line));
    }
    writeFlat(file, "EXPOSURE=1e30\nEXPOSURE=1e30\n", 2);
    EXPECT_THAT(readImage(file).error().line(), testing::HasSubstr("as the product of EXPOSURE and COLORCORR, expected 1.2e-38 to 3.4e38"));
    writeFlat(file, "EXPOSURE=1e-300\n", 2);
    EXPECT_THAT(readImage(file).error().line(), testing::HasSubstr("found 1e-300 as the product of EXPOSURE and COLORCORR"));
}

TEST(RadianceFactors, OtherFormatsAreRefusedByName) {
    const TemporaryFolder folder;
    const auto file = folder / "p.hdr";
    writeContent(file, "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 2\n" + std::string(8, '\x80'));
    expectRefused(file, ErrorCode::FormatUnsupported,
                  "found FORMAT=32-bit_rle_xyze, expected 32-bit_rle_rgbe. Convert it: ra_xyze -r in.hdr out.hdr");
    writeContent(file, "#?RADIANCE\nFORMAT=8-bit\n\n-Y 1 +X 2\n" + std::string(8, '\x80'));
    expectRefused(file, ErrorCode::FormatUnsupported, "found FORMAT=8-bit, expected 32-bit_rle_rgbe");
    for (const char* line : {"PRIMARIES=", "PRIMARIES=1 2 3", "PRIMARIES=1 2 3 4 5 6 7 8 9", "PRIMARIES=a 2 3 4 5 6 7 8"}) {
        writeFlat(file, fmt::format("{}\n", line), 2);
        expectRefused(file, ErrorCode::ValueOutOfRange,
                      fmt::format("found {}, expected 8 finite numbers: x and y of red, green, blue and white", line));
    }
}

/// Scan lines of before 1991: (1, 1, 1, n) repeats a texel n times, the next such texel n * 256 times.
TEST(ReadRadiancePicture, RepeatsOfTexelsAreRead) {
    const TemporaryFolder folder;
    const auto file = folder / "p.hdr";
    const auto texel = [](int value, int exponent = 128) {
        return std::string{static_cast<char>(value), static_cast<char>(value / 2), 64, static_cast<char>(exponent)};
    };
    const auto repeats = [](int count) { return std::string("\1\1\1", 3) + static_cast<char>(count); };
    const auto light = [](int value) { return glm::vec3(value, value / 2, 64) / 256.0f; };  // NOLINT: bytes
    const std::string head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
    // 1 + 3 + 2 * 256 texels, then one of another colour and its repeats.
    const std::string line = texel(128) + repeats(3) + repeats(2) + texel(200) + repeats(9);
    writeContent(file, head + "-Y 2 +X 526\n" + line + line);
    const auto picture = readRadiancePicture(file);
    ASSERT_TRUE(picture);
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 526; ++x) ASSERT_EQ(picture->texels.at(x, y), light(x < 516 ? 128 : 200)) << x;
    for (const std::string& bad : {repeats(3) + texel(128) + repeats(2), texel(128) + repeats(7), texel(128) + repeats(4)}) {
        writeContent(file, head + "-Y 1 +X 6\n" + bad);
        EXPECT_FALSE(readRadiancePicture(file));
    }
    writeContent(file, head + "-Y 1 +X 6\n" + texel(128) + repeats(5));
    EXPECT_TRUE(readRadiancePicture(file));
    EXPECT_TRUE(readImage(file));
}

TEST(ReadRadiancePicture, EveryOrientationIsTurnedUpright) {
    const TemporaryFolder folder;
    const auto file = folder / "p.hdr";
    constexpr int kWidth = 3, kHeight = 2;
    for (const char* order : {"-Y +X", "-Y -X", "+Y +X", "+Y -X", "+X -Y", "+X +Y", "-X -Y", "-X +Y"}) {
        const std::string first(order, 2), second(order + 3, 2);
        const auto count = [](const std::string& axis) { return axis[1] == 'Y' ? kHeight : kWidth; };
        // The place along an axis of the picture, from the left or from the top, of step i.
        const auto place = [&](const std::string& axis, int i) { return axis == "-Y" || axis == "+X" ? i : count(axis) - 1 - i; };
        std::string texels;
        for (int i = 0; i < count(first); ++i)
            for (int j = 0; j < count(second); ++j) {
                const int a = place(first, i), b = place(second, j), x = first[1] == 'Y' ? b : a, y = first[1] == 'Y' ? a : b;
                texels += {static_cast<char>(128 + 10 * x + y), 0, 0, static_cast<char>(128)};
            }
        writeContent(
            file, fmt::format("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{} {} {} {}\n{}", first, count(first), second, count(second), texels));
        const auto picture = readRadiancePicture(file);
        ASSERT_TRUE(picture) << order;
        ASSERT_EQ(picture->texels.width(), kWidth);
        ASSERT_EQ(picture->texels.height(), kHeight);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x)
                EXPECT_EQ(picture->texels.at(x, y).r, static_cast<float>(128 + 10 * x + y) / 256) << order << ' ' << x << ' ' << y;
    }
}

TEST(RadianceChromaticities, AreThoseOfTheHeader) {
    const TemporaryFolder folder;
    const auto file = folder / "p.hdr";
    writeFlat(file, "EXPOSURE=2\nPRIMARIES= 0.713 0.293\t0.165 0.83 0.128 0.044 0.32168 0.33767\n", 2);
    const StatedChromaticities aces = {0.713f, 0.293f, 0.165f, 0.83f, 0.128f, 0.044f, 0.32168f, 0.33767f};
    EXPECT_EQ(radianceChromaticities(file), aces);
    EXPECT_EQ(readRadiancePicture(file)->chromaticities, aces);
    EXPECT_EQ(readImage(file)->chromaticities, aces);
    const auto primaries = statedPrimaries(file, {});
    ASSERT_TRUE(primaries);
    EXPECT_EQ(primaries->space, "acescg");
    const auto stated = loadPaintedGradient(file, {{"stated", "lin_rec709", {}}, true});
    const auto named = loadPaintedGradient(file, {{"acescg", "lin_rec709", {}}, true});
    ASSERT_TRUE(stated && named);
    EXPECT_EQ(stated->zones, named->zones);
    EXPECT_NE(stated->zones, loadPaintedGradient(file, {})->zones);
    writeFlat(file, "", 2);
    EXPECT_FALSE(radianceChromaticities(file));
    EXPECT_FALSE(radianceChromaticities(folder / "absent.hdr"));
}

TEST(RadianceFactors, AreOneForOtherFiles) {
    const TemporaryFolder folder;
    writeContent(folder / "a.txt", "EXPOSURE=4\nFORMAT=32-bit_rle_xyze\n\n");
    for (const auto& file : {folder / "a.txt", folder / "absent.hdr", folder.path()}) {
        const auto factors = radianceFactors(file);
        ASSERT_TRUE(factors) << factors.error().line();
        EXPECT_EQ(*factors, glm::vec3(1));
    }
}

TEST(ReadRadiancePicture, EqualsOpenImageIOBitForBitOnTheSharedPanoramas) {
    const std::filesystem::path data = std::filesystem::path(LIGHTCOOK_SHARED_DATA) / "env";
    if (!std::filesystem::is_directory(data)) GTEST_SKIP() << "needs the shared test data at " << data;
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(data)) {
        if (entry.path().extension() != ".hdr") continue;
        const auto ours = readRadiancePicture(entry.path());
        const auto theirs = readByOpenImageIO(entry.path());
        ASSERT_TRUE(ours && theirs) << entry.path();
        EXPECT_TRUE(ours->texels.texels() == theirs->texels()) << entry.path();
        ++count;
    }
    EXPECT_GE(count, 4);
}

}  // namespace
}  // namespace lightcook::formats
