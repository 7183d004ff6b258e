#include "pipeline/assets/light_map/trial_rows.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

/// Light maps of some sizes. Nothing reads their texels.
class TrialLevelsOfAMap : public testing::Test {
protected:
    LightMapSource& source(int width, int height) {
        const auto file = folder_ / fmt::format("{}x{}.exr", width, height);
        auto writer = formats::LightMapWriter::create(file, width, height);
        EXPECT_TRUE(writer->append(formats::Image<lighting::ShRgb>(width, height).view()));
        EXPECT_TRUE(writer->commit());
        return **sources_.open(file, {});
    }
    static std::set<int> rowsIn(const std::vector<TrialRows>& parts) {
        std::set<int> rows;
        for (const TrialRows& part : parts)
            for (int y = 0; y < part.rowCount; ++y) EXPECT_TRUE(rows.insert(part.firstRow + y).second) << "row twice";
        return rows;
    }

    formats::TemporaryFolder folder_;
    LightMapSources sources_;
};

TEST_F(TrialLevelsOfAMap, HaveEachOfItsRowsOnce) {
    for (const int height : {1, 40, 128, 250, 256, 520, 1030}) {
        LightMapSource& map = source(8, height);
        const TrialLevels levels(map);
        std::set<int> rows;
        for (int level = 0; level <= levels.last(); ++level) {
            for (const TrialRows& part : levels.rows(level, level + 1)) {
                EXPECT_EQ(part.firstRow % kRowAlignment, 0);
                EXPECT_GE(part.firstRow, map.stripFirstRow(part.strip));
                EXPECT_LE(part.firstRow + part.rowCount, map.stripFirstRow(part.strip) + map.stripRows(part.strip));
            }
            for (const int row : rowsIn(levels.rows(level, level + 1))) EXPECT_TRUE(rows.insert(row).second) << row << " in two levels";
            EXPECT_EQ(rows, rowsIn(levels.rows(0, level + 1)));
            EXPECT_DOUBLE_EQ(levels.share(level), static_cast<double>(rows.size()) / height);
            EXPECT_EQ(levels.margin(level) == 0, level == levels.last());
        }
        EXPECT_EQ(rows.size(), static_cast<std::size_t>(height));
    }
}

TEST_F(TrialLevelsOfAMap, HaveNoMoreTexelsThanATrialTakes) {
    LightMapSource& map = source(2048, 1024);
    const TrialLevels levels(map);
    EXPECT_EQ(levels.last(), 2);
    EXPECT_EQ(rowsIn(levels.rows(0, 1)).size(), 8u * kRowAlignment);
    EXPECT_EQ(rowsIn(levels.rows(0, 3)).size(), static_cast<std::size_t>(TrialLevels::kTrialTexels / 2048));
}

}  // namespace
}  // namespace lightcook::pipeline
