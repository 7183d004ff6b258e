#include "formats/light_map.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>
#include <random>
#include <thread>
#include <vector>

#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "tests/formats/exr_fixture.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;
using testing::AllOf;
using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A map of seeded coefficients in a folder of its own.
struct MapFile {
    TemporaryFolder folder;
    std::filesystem::path path = folder / "map.exr";

    explicit MapFile(const ExrRecipe& recipe) { writeRecipe(path, recipe); }
};

ExrRecipe seededMap(int width, int height) {
    ExrRecipe recipe;
    recipe.width = width;
    recipe.height = height;
    recipe.channels = seededShChannels();
    return recipe;
}

LightMapStrip readAll(const std::filesystem::path& file, const LightMapDescription& description = {}) {
    auto reader = LightMapReader::open(file, description);
    if (!reader) {
        ADD_FAILURE() << reader.error().line();
        return {};
    }
    auto band = reader->read(0, reader->height());
    if (!band) {
        ADD_FAILURE() << band.error().line();
        return {};
    }
    return std::move(*band);
}

/// The error of opening and reading a whole map.
Error refusal(const std::filesystem::path& file, const LightMapDescription& description = {}) {
    auto reader = LightMapReader::open(file, description);
    if (!reader) return reader.error();
    const auto band = reader->read(0, reader->height());
    if (!band) return band.error();
    ADD_FAILURE() << file << " was not refused";
    return {};
}

ShRgb seededTexel(int x, int y) {
    ShRgb sh{};
    for (int index = 0; index < 9; ++index) {
        for (int channel = 0; channel < 3; ++channel) sh[static_cast<std::size_t>(index)][channel] = seededSh(index, channel, x, y);
    }
    return sh;
}

TEST(LightMapReader, ReadsHalfAndFloatTiledAndScanLineExactly) {
    for (const bool isHalf : {false, true}) {
        for (const bool isTiled : {false, true}) {
            for (const glm::ivec2 corner : {glm::ivec2(0), glm::ivec2(-3, 11)}) {
                ExrRecipe recipe = seededMap(150, 141);
                recipe.isHalf = isHalf;
                recipe.isTiled = isTiled;
                recipe.corner = corner;
                const MapFile map(recipe);
                const LightMapStrip band = readAll(map.path);
                ASSERT_EQ(band.sh.width(), 150);
                ASSERT_EQ(band.sh.height(), 141);
                for (int y = 0; y < 141; ++y) {
                    for (int x = 0; x < 150; ++x) {
                        ASSERT_EQ(band.sh.at(x, y), seededTexel(x, y)) << isHalf << isTiled << corner.x << ' ' << x << ' ' << y;
                        ASSERT_EQ(band.covered.at(x, y), 1);
                        ASSERT_EQ(band.normal.at(x, y), glm::vec3(0, 0, 1));
                    }
                }
            }
        }
    }
}

TEST(LightMapReader, AnyBandOfRowsEqualsTheseRowsOfTheWhole) {
    for (const bool isTiled : {false, true}) {
        ExrRecipe recipe = seededMap(70, 150);
        recipe.isTiled = isTiled;
        recipe.tileExtent = 32;
        const MapFile map(recipe);
        const LightMapStrip whole = readAll(map.path);
        const auto reader = LightMapReader::open(map.path, {});
        ASSERT_TRUE(reader);
        EXPECT_EQ(reader->tileHeight(), isTiled ? 32 : 64);
        for (const auto& [first, count] :
             {std::pair{0, 64}, {64, 64}, {128, 22}, {0, 1}, {31, 2}, {33, 100}, {149, 1}, {96, 32}, {5, 0}, {10, 12}}) {
            const auto band = reader->read(first, count);
            ASSERT_TRUE(band) << band.error().line();
            EXPECT_EQ(band->firstRow, first);
            ASSERT_EQ(band->sh.height(), count);
            for (int y = 0; y < count; ++y) {
                for (int x = 0; x < 70; ++x) ASSERT_EQ(band->sh.at(x, y), whole.sh.at(x, first + y)) << first << '+' << y << ' ' << x;
            }
        }
    }
}

TEST(LightMapReader, SeveralThreadsReadRowsOfTheirOwn) {
    ExrRecipe recipe = seededMap(64, 256);
    recipe.isTiled = true;
    recipe.tileExtent = 16;
    const MapFile map(recipe);
    const auto reader = LightMapReader::open(map.path, {});
    ASSERT_TRUE(reader);
    std::vector<int> wrongTexels(8, -1);
    {
        std::vector<std::jthread> threads;
        for (int thread = 0; thread < 8; ++thread) {
            threads.emplace_back([&, thread] {
                int wrong = 0;
                for (int round = 0; round < 4; ++round) {
                    const auto band = reader->read(32 * thread + round, 28);
                    if (!band) return;
                    for (int y = 0; y < 28; ++y) {
                        for (int x = 0; x < 64; ++x) wrong += band->sh.at(x, y) != seededTexel(x, 32 * thread + round + y);
                    }
                }
                wrongTexels[static_cast<std::size_t>(thread)] = wrong;
            });
        }
    }
    EXPECT_THAT(wrongTexels, testing::Each(0));
}

TEST(LightMapReader, OutsideChartsAnythingIsAllowedAndBecomesZero) {
    ExrRecipe recipe = seededMap(4, 2);
    recipe.channels["coverage.Y"] = [](int x, int) { return x == 0 ? 0.0f : x == 3 ? kNan : 1.0f; };
    for (const char axis : {'X', 'Y', 'Z'}) {
        recipe.channels[fmt::format("normal.{}", axis)] = [axis](int x, int) {
            return x == 0 ? kNan : x == 1 ? 0.0f : axis == 'Y' ? 3.0f : 0.0f;
        };
    }
    poke(recipe, "sh03.G", 0, 0, kNan);
    poke(recipe, "sh00.R", 0, 1, -5.0f);
    poke(recipe, "sh08.B", 1, 0, kInfinity);
    poke(recipe, "sh08.B", 3, 0, -kInfinity);
    const MapFile map(recipe);
    const LightMapStrip band = readAll(map.path);
    for (int y = 0; y < 2; ++y) {
        for (const int x : {0, 1, 3}) {
            EXPECT_EQ(band.covered.at(x, y), 0) << x;
            EXPECT_EQ(band.sh.at(x, y), ShRgb{}) << x;
            EXPECT_EQ(band.normal.at(x, y), glm::vec3(0, 0, 1)) << x;
        }
        EXPECT_EQ(band.covered.at(2, y), 1);
        EXPECT_EQ(band.sh.at(2, y), seededTexel(2, y));
        EXPECT_EQ(band.normal.at(2, y), glm::vec3(0, 1, 0)) << "normals come back as unit vectors";
    }
    EXPECT_EQ(band.repairs.notFinite, 0);
}

TEST(LightMapReader, BadCoveredTexelsAreRefusedWithChannelAndPosition) {
    struct Case {
        const char* channel;
        float value;
        ErrorCode code;
        const char* found;
    };
    for (const Case& bad :
         {Case{"sh03.G", kNan, ErrorCode::ValueNotFinite, "found nan"}, Case{"sh08.B", kInfinity, ErrorCode::ValueNotFinite, "found inf"},
          Case{"sh00.R", -kInfinity, ErrorCode::ValueNotFinite, "found -inf"},
          Case{"sh00.B", -0.25f, ErrorCode::ValueOutOfRange, "found -0.25"}}) {
        ExrRecipe recipe = seededMap(16, 80);
        recipe.isTiled = true;
        poke(recipe, bad.channel, 12, 70, bad.value);
        const MapFile map(recipe);
        const Error error = refusal(map.path);
        EXPECT_EQ(error.code, bad.code) << bad.channel;
        EXPECT_THAT(error.line(), AllOf(HasSubstr("map.exr"), HasSubstr(bad.channel), HasSubstr("texel (12, 70)"), HasSubstr(bad.found),
                                        HasSubstr("expected")));
    }
    ExrRecipe recipe = seededMap(4, 4);
    for (const char axis : {'X', 'Y', 'Z'}) recipe.channels[fmt::format("normal.{}", axis)] = [](int, int) { return 1.0f; };
    poke(recipe, "normal.Z", 1, 2, kNan);
    EXPECT_THAT(refusal(MapFile(recipe).path).line(), AllOf(HasSubstr("normal.Z"), HasSubstr("(1, 2)")));
}

TEST(LightMapReader, NegativeZeroIsNotNegativeEnergy) {
    ExrRecipe recipe = seededMap(2, 1);
    for (int i = 0; i < 9; ++i) poke(recipe, fmt::format("sh{:02}.G", i), 1, 0, -0.0f);
    EXPECT_EQ(readAll(MapFile(recipe).path).covered.at(1, 0), 1);
}

TEST(LightMapReader, RepairCountsInsteadOfRefusing) {
    ExrRecipe recipe = seededMap(8, 4);
    poke(recipe, "sh03.G", 1, 1, kNan);
    poke(recipe, "sh04.B", 1, 1, kInfinity);
    poke(recipe, "sh00.R", 2, 1, -1.0f);
    poke(recipe, "sh00.B", 2, 1, -2.0f);
    LightMapDescription description;
    description.repair = true;
    const MapFile map(recipe);
    const LightMapStrip band = readAll(map.path, description);
    EXPECT_EQ(band.repairs.notFinite, 1);
    EXPECT_EQ(band.repairs.negativeDc, 2);
    EXPECT_EQ(band.sh.at(1, 1), ShRgb{});
    ShRgb onlyGreen = seededTexel(2, 1);
    for (glm::vec3& coefficient : onlyGreen) coefficient = {0, coefficient.g, 0};
    EXPECT_EQ(band.sh.at(2, 1), onlyGreen);
    EXPECT_EQ(band.sh.at(3, 1), seededTexel(3, 1));
}

/// Light from one direction has bands of exactly sqrt(2 l + 1) times sh00; what the file's quantity convolved has less.
TEST(LightMapReader, BandsFarBeyondWhatTheirMeanAllowsAreRefusedOrScaledDown) {
    for (const ShQuantity quantity : {ShQuantity::Radiance, ShQuantity::Irradiance}) {
        LightMapDescription description;
        description.quantity = quantity;
        const std::array<double, 3> cosine = {std::numbers::pi, 2 * std::numbers::pi / 3, std::numbers::pi / 4};
        const auto longest = [&](int degree) {
            const double ofRadiance = std::sqrt(2 * degree + 1.0);
            const bool isConvolved = quantity == ShQuantity::Irradiance;
            return 0.25 * ofRadiance * (isConvolved ? cosine[static_cast<std::size_t>(degree)] / cosine[0] : 1);
        };
        for (const int degree : {1, 2}) {
            const int first = degree * degree;
            for (const double times : {1.0, 3.9, 4.1, 1e6, 1e37}) {
                ExrRecipe recipe = seededMap(8, 4);
                for (int i = 0; i < 9; ++i) poke(recipe, fmt::format("sh{:02}.G", i), 5, 2, i == 0 ? 0.25f : 0.0f);
                const auto part = static_cast<float>(longest(degree) * times / std::numbers::sqrt2);
                poke(recipe, fmt::format("sh{:02}.G", first), 5, 2, part);
                poke(recipe, fmt::format("sh{:02}.G", first + 2), 5, 2, -part);
                const MapFile map(recipe);
                description.repair = false;
                if (times < 4) {
                    EXPECT_EQ(readAll(map.path, description).repairs.bandsBeyond, 0);
                    continue;
                }
                const auto reader = LightMapReader::open(map.path, description);
                ASSERT_TRUE(reader);
                const auto refused = reader->read(0, 4);
                ASSERT_FALSE(refused) << degree << ' ' << times;
                EXPECT_EQ(refused.error().code, ErrorCode::ValueOutOfRange);
                EXPECT_THAT(refused.error().line(), AllOf(HasSubstr(degree == 1 ? "sh01.G .. sh03.G" : "sh04.G .. sh08.G"),
                                                          HasSubstr("texel (5, 2)"), HasSubstr("sh00 of 0.25")));
                description.repair = true;
                const LightMapStrip band = readAll(map.path, description);
                EXPECT_EQ(band.repairs.bandsBeyond, 1);
                const ShRgb& sh = band.sh.at(5, 2);
                const auto at = static_cast<std::size_t>(first);
                EXPECT_NEAR(std::hypot(sh[at].g, sh[at + 2].g) / sh[0].g, std::sqrt(2 * degree + 1.0), 1e-5);
                EXPECT_FLOAT_EQ(sh[at].g, -sh[at + 2].g);
                EXPECT_EQ(band.sh.at(4, 2), readAll(MapFile(seededMap(8, 4)).path, description).sh.at(4, 2));
            }
        }
    }
}

TEST(LightMapReader, RoundingOfDarkTexelsToHalvesIsNoFault) {
    ExrRecipe recipe = seededMap(4, 4);
    for (int i = 0; i < 9; ++i) poke(recipe, fmt::format("sh{:02}.B", i), 1, 1, i == 0 ? 0.0f : 6e-8f);
    EXPECT_EQ(readAll(MapFile(recipe).path).repairs.bandsBeyond, 0);
}

TEST(LightMapReader, TwentySixChannelsNameTheMissingOne) {
    ExrRecipe recipe = seededMap(8, 8);
    recipe.channels.erase("sh05.G");
    const Error error = refusal(MapFile(recipe).path);
    EXPECT_EQ(error.code, ErrorCode::WrongShape);
    EXPECT_THAT(error.detail, HasSubstr("found 26 of 27 sh channels, sh05.G is missing, expected sh00.R .. sh08.B"));
    recipe.channels.erase("sh07.R");
    EXPECT_THAT(refusal(MapFile(recipe).path).detail, HasSubstr("found 25 of 27 sh channels, sh05.G and 1 more are missing"));
}

TEST(LightMapReader, IncompleteNormalsAndATangentFrameWithoutThemAreRefused) {
    ExrRecipe recipe = seededMap(4, 4);
    LightMapDescription tangent;
    tangent.frame = ShFrame::Tangent;
    EXPECT_THAT(refusal(MapFile(recipe).path, tangent).line(), HasSubstr("frame is \"tangent\""));
    recipe.channels["normal.X"] = recipe.channels["normal.Y"] = [](int, int) { return 0.5f; };
    const Error error = refusal(MapFile(recipe).path);
    EXPECT_EQ(error.code, ErrorCode::WrongShape);
    EXPECT_THAT(error.line(), HasSubstr("found 2 of the channels normal.X"));
}

TEST(LightMapReader, WhatIsNotAnExrIsRefused) {
    const TemporaryFolder folder;
    EXPECT_THAT(refusal(folder / "absent.exr").line(), AllOf(HasSubstr("absent.exr"), HasSubstr("no such file")));
    EXPECT_EQ(refusal(folder.path()).code, ErrorCode::FileUnreadable) << "a folder";
    writeContent(folder / "text.exr", "this is not an image at all");
    EXPECT_THAT(refusal(folder / "text.exr").line(), HasSubstr("found the first bytes 74 68 69 73"));
    writeContent(folder / "short.exr", "v/1");
    EXPECT_THAT(refusal(folder / "short.exr").line(), HasSubstr("found 3 bytes"));
    LightMapDescription other;
    other.layout = "sh4";
    EXPECT_THAT(refusal(folder / "text.exr", other).line(), AllOf(HasSubstr("\"sh4\""), HasSubstr("expected \"sh9\"")));
    LightMapDescription encoded;
    encoded.colors.source = "srgb_texture";
    const MapFile map(seededMap(4, 4));
    EXPECT_EQ(refusal(map.path, encoded).code, ErrorCode::ColorSpace);
    EXPECT_THAT(refusal(map.path, encoded).line(), AllOf(HasSubstr("map.exr"), HasSubstr("'srgb_texture' is not linear")));
}

TEST(LightMapReader, EveryTruncatedLengthIsAnErrorAndNeverACrash) {
    for (const bool isTiled : {false, true}) {
        ExrRecipe recipe = seededMap(1, 18);  // two chunks
        recipe.isTiled = isTiled;
        recipe.tileExtent = 16;
        recipe.isHalf = true;
        const MapFile map(recipe);
        const std::string whole = contentOf(map.path);
        ASSERT_LT(whole.size(), 4000u);
        for (std::size_t length = whole.size(); length-- > 0;) {
            std::filesystem::resize_file(map.path, length);
            const Error error = refusal(map.path);
            ASSERT_TRUE(error.code == ErrorCode::FileUnreadable || error.code == ErrorCode::WrongShape) << length << ' ' << error.line();
            ASSERT_EQ(error.line().find('\n'), std::string::npos) << length;
            ASSERT_THAT(error.line(), AllOf(HasSubstr("map.exr"), HasSubstr("found"), HasSubstr("expected")));
        }
    }
}

TEST(LightMapReader, AnyFlippedByteIsReadOrRefusedAndNeverACrash) {
    std::mt19937 random(11);
    for (const bool isTiled : {false, true}) {
        ExrRecipe recipe = seededMap(5, 20);
        recipe.isTiled = isTiled;
        recipe.tileExtent = 8;
        const MapFile map(recipe);
        const std::string whole = contentOf(map.path);
        std::size_t at = 0;
        for (int round = 0; round < 600; ++round) {
            setByte(map.path, at, whole[at]);     // as it was
            const std::size_t headerBytes = 900;  // most of the flips go where they can hurt
            at = random() % (round % 4 ? headerBytes : whole.size());
            setByte(map.path, at, static_cast<char>(random()));
            const auto reader = LightMapReader::open(map.path, {});
            if (!reader) continue;
            for (int row = 0; row < reader->height() && row < 64; row += 8) {
                const auto band = reader->read(row, std::min(8, reader->height() - row));
                EXPECT_TRUE(band || band.error().line().find('\n') == std::string::npos);
            }
        }
    }
}

TEST(LightMapReader, AbsurdSizesAreRefusedBeforeAnythingIsAllocated) {
    const MapFile map(seededMap(2, 2));
    const std::string whole = contentOf(map.path);
    const std::size_t name = whole.find("dataWindow");
    ASSERT_NE(name, std::string::npos);
    const std::size_t value = name + sizeof("dataWindow") + sizeof("box2i") + 4;
    const auto withMax = [&](std::int32_t x, std::int32_t y) {
        std::string broken = whole;
        for (std::size_t byte = 0; byte < 4; ++byte) {
            broken[value + 8 + byte] = static_cast<char>(x >> (8 * byte));
            broken[value + 12 + byte] = static_cast<char>(y >> (8 * byte));
        }
        writeContent(map.path, broken);
        return refusal(map.path);
    };
    EXPECT_THAT(withMax(1000000000, 1).line(), AllOf(HasSubstr("1000000001 x 2"), HasSubstr("expected")));
    EXPECT_THAT(withMax(-7, 1).line(), HasSubstr("expected"));
    EXPECT_EQ(withMax(65535, 65535).code, ErrorCode::FileUnreadable) << "plausible extents, but the file is far too short";
}

ShRgb convertedTexel(const LightMapDescription& description, const ExrRecipe& recipe) {
    const MapFile map(recipe);
    return readAll(map.path, description).sh.at(1, 1);
}

void expectNear(const ShRgb& found, const ShRgb& expected, float tolerance) {
    for (std::size_t i = 0; i < 9; ++i) {
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(found[i][channel], expected[i][channel], tolerance) << i << ' ' << channel;
    }
}

TEST(LightMapReader, CondonShortleyNegatesTheOddOnes) {
    LightMapDescription description;
    description.phase = ShPhase::CondonShortley;
    ShRgb expected = seededTexel(1, 1);
    for (const std::size_t index : {1u, 3u, 5u, 7u}) expected[index] = -expected[index];
    EXPECT_EQ(convertedTexel(description, seededMap(3, 3)), expected);
}

TEST(LightMapReader, IrradianceIsDividedByTheCosineBandsAndGameLightsGetTheirPi) {
    LightMapDescription description;
    description.quantity = ShQuantity::Irradiance;
    const double pi = std::numbers::pi, cosine[9] = {pi, 2 * pi / 3, 2 * pi / 3, 2 * pi / 3, pi / 4, pi / 4, pi / 4, pi / 4, pi / 4};
    ShRgb radiance = seededTexel(1, 1), game = radiance, both = radiance;
    for (std::size_t i = 0; i < 9; ++i) {
        for (int channel = 0; channel < 3; ++channel) {
            const double stored = static_cast<double>(radiance[i][channel]);
            radiance[i][channel] = static_cast<float>(stored / cosine[i]);
            game[i][channel] = static_cast<float>(stored * pi);
            both[i][channel] = static_cast<float>(stored / cosine[i] * pi);
        }
    }
    expectNear(convertedTexel(description, seededMap(3, 3)), radiance, 1e-6f);
    description.lightUnits = LightUnits::Game;
    expectNear(convertedTexel(description, seededMap(3, 3)), both, 4e-6f);
    description.quantity = ShQuantity::Radiance;
    expectNear(convertedTexel(description, seededMap(3, 3)), game, 4e-6f);
}

/// The nine basis functions again, from the table in lighting/sh.h.
std::array<double, 9> basis(const glm::dvec3& d) {
    const double pi = std::numbers::pi, a = std::sqrt(3 / (4 * pi)), b = std::sqrt(15 / pi) / 2;
    return {std::sqrt(1 / pi) / 2,
            a * d.y,
            a * d.z,
            a * d.x,
            b * d.x * d.y,
            b * d.y * d.z,
            std::sqrt(5 / pi) / 4 * (3 * d.z * d.z - 1),
            b * d.x * d.z,
            b / 2 * (d.x * d.x - d.y * d.y)};
}

TEST(LightMapReader, TangentFramesAreTurnedToTheWorld) {
    // A light from local direction d, stored in the frame around n, is a light from frame * d in the world.
    const glm::dvec3 local = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));
    for (const glm::dvec3& direction :
         {glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), glm::dvec3(0.2, -0.9, -0.4), glm::dvec3(-1, 2, 3)}) {
        const glm::dvec3 normal = glm::normalize(direction);
        ExrRecipe recipe = seededMap(3, 3);
        const std::array<double, 9> stored = basis(local);
        for (std::size_t i = 0; i < 9; ++i) {
            for (const char channel : {'R', 'G', 'B'}) {
                recipe.channels[fmt::format("sh{:02}.{}", i, channel)] = [value = static_cast<float>(stored[i])](int, int) {
                    return value;
                };
            }
        }
        for (int axis = 0; axis < 3; ++axis) {
            recipe.channels[fmt::format("normal.{}", "XYZ"[axis])] = [value = static_cast<float>(normal[axis])](int, int) { return value; };
        }
        LightMapDescription description;
        description.frame = ShFrame::Tangent;
        const std::array<double, 9> expected = basis(lighting::worldFromTangentFrame(normal) * local);
        const ShRgb found = convertedTexel(description, recipe);
        for (std::size_t i = 0; i < 9; ++i)
            EXPECT_NEAR(found[i].y, expected[i], 2e-6) << i << " around " << normal.x << ' ' << normal.y << ' ' << normal.z;
        // Signs of the file are undone in the file's own frame.
        for (const char* odd : {"sh01", "sh03", "sh05", "sh07"}) {
            for (const char channel : {'R', 'G', 'B'}) {
                const std::string name = fmt::format("{}.{}", odd, channel);
                recipe.channels[name] = [before = recipe.channels[name]](int x, int y) { return -before(x, y); };
            }
        }
        description.phase = ShPhase::CondonShortley;
        const ShRgb unflipped = convertedTexel(description, recipe);
        for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(unflipped[i].y, expected[i], 2e-6) << i;
    }
}

TEST(LightMapReader, ColoursAreConvertedAndNegativeOnesCounted) {
    LightMapDescription description;
    description.colors = {"lin_rec2020", "lin_rec709", {}};
    const auto conversion = linearConversion(description.colors);
    ASSERT_TRUE(conversion);
    ExrRecipe recipe = seededMap(3, 3);
    ShRgb expected = seededTexel(1, 1);
    for (glm::vec3& coefficient : expected) coefficient = conversion->workingFromSource * coefficient;
    expectNear(convertedTexel(description, recipe), expected, 1e-6f);

    for (const auto& [x, y] : {std::pair(2, 0), std::pair(1, 2)})  // a green that Rec.709 cannot hold: red and blue go below zero
        for (int i = 0; i < 9; ++i)
            for (const char channel : {'R', 'B'}) poke(recipe, fmt::format("sh{:02}.{}", i, channel), x, y, 0.0f);
    const MapFile map(recipe);
    EXPECT_EQ(readAll(map.path, description).negativeAfterGamut, 4);
    EXPECT_EQ(readAll(map.path).negativeAfterGamut, 0);
    EXPECT_EQ(LightMapReader::open(map.path, description)->luminanceWeights(), conversion->luminanceWeights);
}

TEST(LightMapReader, ValuesThatLeaveFloatOnTheWayAreRefused) {
    ExrRecipe recipe = seededMap(2, 2);
    poke(recipe, "sh02.G", 1, 0, 3e38f);
    LightMapDescription description;
    description.lightUnits = LightUnits::Game;
    EXPECT_EQ(refusal(MapFile(recipe).path, description).code, ErrorCode::ValueOutOfRange);
}

TEST(LightMapReader, AGreyMapComesThroughExactly) {
    // The SH of a constant environment of 0.5: lambda_0 = 0.5 sqrt(4 pi), and E / pi = 0.5 at every normal.
    ExrRecipe recipe = seededMap(5, 5);
    const float dc = static_cast<float>(0.5 * std::sqrt(4 * std::numbers::pi));
    for (auto& [name, value] : recipe.channels) value = [dc, isDc = name.starts_with("sh00")](int, int) { return isDc ? dc : 0.0f; };
    const MapFile map(recipe);
    const LightMapStrip band = readAll(map.path);
    for (const ShRgb& texel : band.sh.texels()) {
        EXPECT_EQ(texel[0], glm::vec3(dc));
        const glm::vec3 exitRadiance = lighting::irradiance(texel, {0, 1, 0}).value / std::numbers::pi_v<float>;
        EXPECT_NEAR(exitRadiance.g, 0.5f, 1e-6f);
    }
}

Image<ShRgb> seededRows(int width, int firstRow, int rowCount) {
    Image<ShRgb> rows(width, rowCount);
    for (int y = 0; y < rowCount; ++y) {
        for (int x = 0; x < width; ++x) rows.at(x, y) = seededTexel(x, firstRow + y);
    }
    return rows;
}

void writeSeeded(const std::filesystem::path& file, int width, const std::vector<int>& bands, int height) {
    auto writer = LightMapWriter::create(file, width, height);
    ASSERT_TRUE(writer) << writer.error().line();
    int row = 0;
    for (const int count : bands) {
        const auto written = writer->append(seededRows(width, row, count).view());
        ASSERT_TRUE(written) << written.error().line();
        row += count;
    }
    EXPECT_FALSE(std::filesystem::exists(file)) << "nothing under the name before commit";
    const auto committed = writer->commit();
    ASSERT_TRUE(committed) << committed.error().line();
}

TEST(LightMapWriter, WhatIsWrittenReadsBackBitForBitWhateverTheBands) {
    const TemporaryFolder folder;
    writeSeeded(folder / "a.exr", 75, {130}, 130);
    writeSeeded(folder / "b.exr", 75, {1, 63, 30, 36}, 130);
    EXPECT_EQ(contentOf(folder / "a.exr"), contentOf(folder / "b.exr"));
    const LightMapStrip band = readAll(folder / "a.exr");
    const Image<ShRgb> expected = seededRows(75, 0, 130);
    EXPECT_EQ(band.sh.texels(), expected.texels());
    EXPECT_EQ(LightMapReader::open(folder / "a.exr", {})->tileHeight(), 64);
}

TEST(LightMapWriter, LeavesNothingBehindWithoutCommit) {
    const TemporaryFolder folder;
    {
        auto writer = LightMapWriter::create(folder / "a.exr", 8, 8);
        ASSERT_TRUE(writer);
        ASSERT_TRUE(writer->append(seededRows(8, 0, 4).view()));
        EXPECT_FALSE(writer->commit()) << "rows are missing";
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
    const auto nowhere = LightMapWriter::create(folder / "absent" / "a.exr", 8, 8);
    ASSERT_FALSE(nowhere);
    EXPECT_THAT(nowhere.error().line(), HasSubstr("absent"));
    EXPECT_EQ(LightMapWriter::create(folder / "a.exr", 0, 8).error().code, ErrorCode::WrongShape);
}

TEST(LightMapReader, TheSharedBakesAreReadWhole) {
    const std::filesystem::path scenes = std::filesystem::path(LIGHTCOOK_SHARED_DATA) / "scenes";
    if (!std::filesystem::exists(scenes)) GTEST_SKIP() << "needs the shared test data at " << LIGHTCOOK_SHARED_DATA;
    struct Bake {
        const char* name;
        int extent;
        int coveredCount;  ///< as ../shared/data/README.md counts
    };
    for (const Bake& bake :
         {Bake{"cornell", 256, 43254}, Bake{"zdm2_sun", 1024, 526362}, Bake{"interior", 512, 181647}, Bake{"outdoor", 512, 199127}}) {
        const auto reader = LightMapReader::open(scenes / fmt::format("{}_lightmap.exr", bake.name), {});
        ASSERT_TRUE(reader) << reader.error().line();
        EXPECT_EQ(reader->width(), bake.extent);
        EXPECT_TRUE(reader->hasNormals());
        std::int64_t coveredCount = 0;
        for (int row = 0; row < reader->height(); row += reader->tileHeight()) {
            const auto band = reader->read(row, reader->tileHeight());
            ASSERT_TRUE(band) << band.error().line();
            for (const std::uint8_t covered : band->covered.texels()) coveredCount += covered;
        }
        EXPECT_EQ(coveredCount, bake.coveredCount) << bake.name;
    }
}

}  // namespace
}  // namespace lightcook::formats
