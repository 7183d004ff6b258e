#include "formats/bakes/sh9.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <thread>
#include <vector>

#include "tests/formats/light_map_fixture.h"

namespace lightcook::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Sh9, ReadsHalfAndFloatTiledAndScanLineExactly) {
    for (const bool isHalf : {false, true}) {
        for (const bool isTiled : {false, true}) {
            for (const glm::ivec2 corner : {glm::ivec2(0), glm::ivec2(-3, 11)}) {
                ExrRecipe recipe = seededMap(150, 141);
                recipe.isHalf = isHalf;
                recipe.isTiled = isTiled;
                recipe.corner = corner;
                const MapFile map(recipe);
                const LightMapStrip strip = readAll(map.path);
                ASSERT_EQ(strip.sh.width(), 150);
                ASSERT_EQ(strip.sh.height(), 141);
                for (int y = 0; y < 141; ++y) {
                    for (int x = 0; x < 150; ++x) {
                        ASSERT_EQ(strip.sh.at(x, y), seededTexel(x, y)) << isHalf << isTiled << corner.x << ' ' << x << ' ' << y;
                        ASSERT_EQ(strip.covered.at(x, y), 1);
                        ASSERT_EQ(strip.normal.at(x, y), glm::vec3(0, 0, 1));
                    }
                }
            }
        }
    }
}

TEST(Sh9, AnyStripEqualsTheseRowsOfTheWhole) {
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
            const auto strip = reader->read(first, count);
            ASSERT_TRUE(strip) << strip.error().line();
            EXPECT_EQ(strip->firstRow, first);
            ASSERT_EQ(strip->sh.height(), count);
            for (int y = 0; y < count; ++y) {
                for (int x = 0; x < 70; ++x) ASSERT_EQ(strip->sh.at(x, y), whole.sh.at(x, first + y)) << first << '+' << y << ' ' << x;
            }
        }
    }
}

TEST(Sh9, SeveralThreadsReadRowsOfTheirOwn) {
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
                    const auto strip = reader->read(32 * thread + round, 28);
                    if (!strip) return;
                    for (int y = 0; y < 28; ++y) {
                        for (int x = 0; x < 64; ++x) wrong += strip->sh.at(x, y) != seededTexel(x, 32 * thread + round + y);
                    }
                }
                wrongTexels[static_cast<std::size_t>(thread)] = wrong;
            });
        }
    }
    EXPECT_THAT(wrongTexels, testing::Each(0));
}

TEST(Sh9, EveryTruncatedLengthIsAnErrorAndNeverACrash) {
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

TEST(Sh9, AnyFlippedByteIsReadOrRefusedAndNeverACrash) {
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
                const auto strip = reader->read(row, std::min(8, reader->height() - row));
                EXPECT_TRUE(strip || strip.error().line().find('\n') == std::string::npos);
            }
        }
    }
}

TEST(Sh9, AbsurdSizesAreRefusedBeforeAnythingIsAllocated) {
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

TEST(Sh9Soak, TheSharedBakesAreReadWhole) {
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
            const auto strip = reader->read(row, reader->tileHeight());
            ASSERT_TRUE(strip) << strip.error().line();
            for (const std::uint8_t covered : strip->covered.texels()) coveredCount += covered;
        }
        EXPECT_EQ(coveredCount, bake.coveredCount) << bake.name;
    }
}

}  // namespace
}  // namespace lightcook::formats
