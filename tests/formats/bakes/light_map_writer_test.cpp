#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "tests/formats/light_map_fixture.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;
using testing::HasSubstr;

Image<ShRgb> seededRows(int width, int firstRow, int rowCount) {
    Image<ShRgb> rows(width, rowCount);
    for (int y = 0; y < rowCount; ++y) {
        for (int x = 0; x < width; ++x) rows.at(x, y) = seededTexel(x, firstRow + y);
    }
    return rows;
}

void writeSeeded(const std::filesystem::path& file, int width, const std::vector<int>& strips, int height) {
    auto writer = LightMapWriter::create(file, width, height);
    ASSERT_TRUE(writer) << writer.error().line();
    int row = 0;
    for (const int count : strips) {
        const auto written = writer->append(seededRows(width, row, count).view());
        ASSERT_TRUE(written) << written.error().line();
        row += count;
    }
    EXPECT_FALSE(std::filesystem::exists(file)) << "nothing under the name before commit";
    const auto committed = writer->commit();
    ASSERT_TRUE(committed) << committed.error().line();
}

TEST(LightMapWriter, CoverageAndNormalsReadBackWithTheRows) {
    const TemporaryFolder folder;
    constexpr int kWidth = 70, kHeight = 130;
    const Image<ShRgb> sh = seededRows(kWidth, 0, kHeight);
    Image<std::uint8_t> covered(kWidth, kHeight, 0);
    Image<glm::vec3> normal(kWidth, kHeight, glm::vec3(0, 0, 1));
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            covered.at(x, y) = (x + y) % 3 == 0 ? 0 : 1;
            if (x % 2 == 0) normal.at(x, y) = glm::vec3(0.6f, 0, -0.8f);
        }
    auto writer = LightMapWriter::create(folder / "map.exr", kWidth, kHeight, SurfaceOutput::CoverageAndNormals);
    ASSERT_TRUE(writer);
    for (const auto& [first, count] : {std::pair{0, 100}, {100, 30}})
        ASSERT_TRUE(writer->append(sh.view().rows(first, count), {covered.view().rows(first, count), normal.view().rows(first, count)}));
    ASSERT_TRUE(writer->commit());
    const auto reader = LightMapReader::open(folder / "map.exr", {});
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_TRUE(reader->hasCoverage());
    EXPECT_TRUE(reader->hasNormals());
    const auto strip = reader->read(0, kHeight);
    ASSERT_TRUE(strip) << strip.error().line();
    EXPECT_EQ(strip->covered.texels(), covered.texels());
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            if (covered.at(x, y) == 0) continue;
            EXPECT_EQ(strip->sh.at(x, y), sh.at(x, y)) << x << " " << y;
            EXPECT_LT(glm::distance(strip->normal.at(x, y), normal.at(x, y)), 1e-6f) << x << " " << y;
        }
}

TEST(LightMapWriter, ChartsReadBackWithTheRows) {
    const TemporaryFolder folder;
    constexpr int kWidth = 70, kHeight = 66;
    constexpr std::uint32_t kLargest = (1u << 24u) - 1;
    const Image<ShRgb> sh = seededRows(kWidth, 0, kHeight);
    Image<std::uint8_t> covered(kWidth, kHeight, 1);
    const Image<glm::vec3> normal(kWidth, kHeight, glm::vec3(0, 0, 1));
    Image<std::uint32_t> chart(kWidth, kHeight, kNoChart);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            covered.at(x, y) = (x + y) % 3 == 0 ? 0 : 1;
            if (covered.at(x, y) != 0 || y % 2 == 0) chart.at(x, y) = x < 9 ? 1 + static_cast<std::uint32_t>(y) : kLargest;
        }
    auto writer = LightMapWriter::create(folder / "map.exr", kWidth, kHeight, SurfaceOutput::CoverageNormalsAndCharts);
    ASSERT_TRUE(writer);
    ASSERT_TRUE(writer->append(sh.view(), {covered.view(), normal.view(), chart.view()}));
    ASSERT_TRUE(writer->commit());
    const auto reader = LightMapReader::open(folder / "map.exr", {});
    ASSERT_TRUE(reader) << reader.error().line();
    const auto strip = reader->read(1, kHeight - 1);
    ASSERT_TRUE(strip) << strip.error().line();
    for (int y = 1; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) ASSERT_EQ(strip->chart.at(x, y - 1), chart.at(x, y)) << x << " " << y;
}

TEST(LightMapWriter, RowsReadBackBitForBitWhateverTheStrips) {
    const TemporaryFolder folder;
    writeSeeded(folder / "a.exr", 75, {130}, 130);
    writeSeeded(folder / "b.exr", 75, {1, 63, 30, 36}, 130);
    EXPECT_EQ(contentOf(folder / "a.exr"), contentOf(folder / "b.exr"));
    const LightMapStrip strip = readAll(folder / "a.exr");
    const Image<ShRgb> expected = seededRows(75, 0, 130);
    EXPECT_EQ(strip.sh.texels(), expected.texels());
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

}  // namespace
}  // namespace lightcook::formats
