#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
