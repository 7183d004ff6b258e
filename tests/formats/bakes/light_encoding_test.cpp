#include "formats/bakes/light_encoding.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/formats/light_map_fixture.h"
#include "tests/formats/picture_fixture.h"

namespace lightcook::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr int kPictureSide = 64;

/// Every byte as a colour, with alphas from 0 to 255.
int byteAt(int channel, int x, int y) {
    return channel == 3 ? (y * 4 + x / 16) % 256 : (x + 64 * channel + 3 * y) % 256;
}

/// Light of a texel as Unity's sampler and shader have it, written out with powers: IEC 61966-2-1, then 5^2.2 a^2.2 or 4.59.
double decoded(LightEncoding encoding, int c, int x, int y) {
    const double v = byteAt(c, x, y) / 255.0, a = byteAt(3, x, y) / 255.0;
    const double linear = v > 0.04045 ? std::exp(2.4 * std::log((v + 0.055) / 1.055)) : v / 12.92;
    return encoding == LightEncoding::Rgbm ? std::pow(5.0 * a, 2.2) * linear : 4.59 * linear;
}

LightMapDescription encoded(LightEncoding encoding, const std::string& bake = std::string(kAutoBake)) {
    LightMapDescription description;
    description.bake = bake;
    description.encoding = encoding;
    return description;
}

TEST(LightEncoding, ATexelIsTheLightThatUnityDecodes) {
    const TemporaryFolder folder;
    writePng(folder / "room.png", kPictureSide, kPictureSide, 4, byteAt);
    for (const LightEncoding encoding : {LightEncoding::Rgbm, LightEncoding::Dldr}) {
        const LightMapStrip strip = readAll(folder / "room.png", encoded(encoding));
        ASSERT_EQ(strip.sh.height(), kPictureSide);
        double largest = 0, brightest = 0;
        for (int y = 0; y < kPictureSide; ++y)
            for (int x = 0; x < kPictureSide; ++x) {
                const bool isCovered = encoding == LightEncoding::Rgbm || byteAt(3, x, y) > 127;
                ASSERT_EQ(strip.covered.at(x, y), isCovered ? 1 : 0) << "the alpha of RGBM alone is no coverage";
                if (!isCovered) continue;
                for (int c = 0; c < 3; ++c) {
                    const double shown = static_cast<double>(strip.sh.at(x, y)[0][c]) / std::sqrt(4 * std::numbers::pi);
                    largest = std::max(largest, std::abs(shown - decoded(encoding, c, x, y)));
                    brightest = std::max(brightest, shown);
                }
            }
        RecordProperty(std::string(nameOfConvention(encoding)), fmt::format("{:.2g}", largest / brightest));
        EXPECT_LT(largest, 1e-6 * brightest) << nameOfConvention(encoding);
    }
}

TEST(LightEncoding, TheColourOfSeveralFilesIsDecodedAndTheDirectionsAreNot) {
    const TemporaryFolder folder;
    writePng(folder / "room_L0.png", kPictureSide, kPictureSide, 4, byteAt);
    writePng(folder / "room_L1.png", kPictureSide, kPictureSide, 3, [](int axis, int, int) { return 64 + 64 * axis; });
    const auto reader = LightMapReader::open(folder / "room_L0.png", encoded(LightEncoding::Rgbm));
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "bakery-mono-sh");
    const LightMapStrip strip = readAll(folder / "room_L0.png", encoded(LightEncoding::Rgbm));
    // x is coefficient 3; L1 = 4 L0 (t - 0.5), and 0.325735 lambda_1 = L1.
    const double light = decoded(LightEncoding::Rgbm, 1, 40, 50);
    EXPECT_NEAR(static_cast<double>(strip.sh.at(40, 50)[3].g) * std::sqrt(1 / (3 * std::numbers::pi)), 4 * light * (64 / 255.0 - 0.5),
                1e-5 * light);
    const LightMapStrip byOther = readAll(folder / "room_L1.png", encoded(LightEncoding::Rgbm));
    EXPECT_EQ(byOther.sh.at(40, 50), strip.sh.at(40, 50)) << "any of the files names the set";
}

TEST(LightEncoding, AFileThatIsNotEncodedSoIsRefused) {
    const TemporaryFolder folder;
    writePng(folder / "room.png", kPictureSide, kPictureSide, 3, byteAt);
    EXPECT_THAT(refusal(folder / "room.png", encoded(LightEncoding::Rgbm)).line(),
                AllOf(HasSubstr("room.png: found no alpha, expected the multiplier of RGBM"), HasSubstr("encoding = \"dldr\"")));
    EXPECT_EQ(readAll(folder / "room.png", encoded(LightEncoding::Dldr)).sh.width(), kPictureSide);
    EXPECT_THAT(refusal(folder / "room.png").line(),
                AllOf(HasSubstr("found a picture of integers, expected OpenEXR or Radiance HDR"),
                      HasSubstr("\"none\" of linear values, \"srgb\" of display"), HasSubstr("Set encoding (--encoding)")));
    const MapFile map(seededMap(8, 8));
    const Error error = refusal(map.path, encoded(LightEncoding::Dldr));
    EXPECT_EQ(error.code, ErrorCode::InvalidRequest);
    EXPECT_THAT(error.line(), HasSubstr("map.exr: found HDR values, expected an 8-bit picture (PNG, TGA): encoding is \"dldr\""));
    EXPECT_THAT(refusal(folder / "absent.png").line(), HasSubstr("absent.png"));
}

/// Returns the exit radiance of a flat map at a texel.
double shownAt(const LightMapStrip& strip, int x, int y, int c) {
    return static_cast<double>(strip.sh.at(x, y)[0][c]) / std::sqrt(4 * std::numbers::pi);
}

TEST(LightEncoding, LinearBytesAreSharesOf255) {
    const TemporaryFolder folder;
    writePng(folder / "room.png", kPictureSide, kPictureSide, 4, byteAt);
    const LightMapStrip strip = readAll(folder / "room.png", encoded(LightEncoding::None, "flat"));
    for (int y = 0; y < kPictureSide; ++y)
        for (int x = 0; x < kPictureSide; ++x) {
            const bool isCovered = byteAt(3, x, y) > 127;
            ASSERT_EQ(strip.covered.at(x, y), isCovered ? 1 : 0) << "alpha is coverage";
            for (int c = 0; isCovered && c < 3; ++c) ASSERT_NEAR(shownAt(strip, x, y, c), byteAt(c, x, y) / 255.0, 1e-6);
        }
    const MapFile map(seededMap(8, 8));
    EXPECT_EQ(readAll(map.path, encoded(LightEncoding::None)).sh.at(3, 4), seededTexel(3, 4)) << "HDR values have no encoding";
    writePng(folder / "hall_L0.png", 8, 8, 3, byteAt);
    writePng(folder / "hall_L1.png", 8, 8, 3, [](int, int, int) { return 128; });
    EXPECT_NEAR(shownAt(readAll(folder / "hall_L0.png", encoded(LightEncoding::None)), 3, 5, 1), byteAt(1, 3, 5) / 255.0, 1e-6)
        << "the colour of a set";
}

TEST(LightEncoding, LinearNumbersOf16BitsAreSharesOf65535) {
    const TemporaryFolder folder;
    writePng16(folder / "room.png", 16, 16, 3, [](int channel, int x, int y) { return 4000 * x + 17 * y + 1000 * channel; });
    const LightMapStrip strip = readAll(folder / "room.png", encoded(LightEncoding::None));
    for (int x = 0; x < 16; ++x)
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(shownAt(strip, x, 5, c), (4000 * x + 17 * 5 + 1000 * c) / 65535.0, 1e-7);
}

TEST(LightEncoding, AGreyMapIsOneWhoseColoursAreEqual) {
    const TemporaryFolder folder;
    writePng(folder / "grey.png", 8, 8, 1, byteAt);
    writePng(folder / "alpha.png", 8, 8, 2, [](int channel, int x, int y) { return channel == 0 ? byteAt(0, x, y) : x < 4 ? 255 : 0; });
    for (const char* file : {"grey.png", "alpha.png"}) {
        const LightMapStrip strip = readAll(folder / file, encoded(LightEncoding::None));
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(shownAt(strip, 3, 5, c), byteAt(0, 3, 5) / 255.0, 1e-6) << file;
        EXPECT_EQ(strip.covered.at(5, 5), file == std::string("grey.png") ? 1 : 0) << file;
    }
    ExrRecipe recipe;
    recipe.width = recipe.height = 8;
    recipe.channels["Y"] = [](int x, int y) { return seededSh(0, 0, x, y); };
    recipe.channels["coverage.Y"] = [](int x, int) { return x < 4 ? 1.0f : 0.0f; };
    const MapFile map(recipe);
    const auto reader = LightMapReader::open(map.path, {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "flat");
    const LightMapStrip strip = readAll(map.path);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(shownAt(strip, 3, 5, c), seededSh(0, 0, 3, 5), 1e-6);
    EXPECT_EQ(strip.covered.at(5, 5), 0);
}

TEST(LightEncoding, FormatsWithoutColoursRefuseIt) {
    const TemporaryFolder folder;
    writePng(folder / "room.png", 8, 32, 4, byteAt);
    const Error error = refusal(folder / "room.png", encoded(LightEncoding::Rgbm, "godot"));
    EXPECT_EQ(error.code, ErrorCode::InvalidRequest);
    EXPECT_THAT(error.line(), HasSubstr("room.png, encoding: found \"rgbm\" for bake format godot, expected none: it is for flat, "
                                        "bakery-sh, bakery-mono-sh, unity-directional, bakery-dominant, deluxe"));
}

TEST(LightEncoding, AlphaOfOneAndNoAlphaAreTheSameToDoubleLdr) {
    EXPECT_EQ(decodedLight({1, 0.5f, 0, 1}, LightEncoding::Dldr), decodedLight({1, 0.5f, 0, 0.25f}, LightEncoding::Dldr));
    EXPECT_FLOAT_EQ(decodedLight({1, 1, 1, 1}, LightEncoding::Rgbm).r, 34.493242f);
    EXPECT_EQ(decodedLight({0.5f, 2, -1, 0}, LightEncoding::None), glm::vec3(0.5f, 2, -1)) << "as stored";
}

}  // namespace
}  // namespace lightcook::formats
