// encoders.csv beside this file says how well each format does at each effort on the pictures that the repository carries or makes. Here
// the same code measures again: nothing may be worse than was committed. `./dev bench encoders --table tests/quality/encoders.csv` writes
// the table again; its difference in version control then shows the effect of a change to an encoder.
#include "bench/quality_table.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>

namespace lightcook::bench {
namespace {

using formats::PixelFormat;
using Key = std::pair<int, std::string>;  ///< effort, picture

/// Tolerance for the roundings of another mathematical library in pictures made by formula.
constexpr double kHairDb = 0.01;

const std::filesystem::path kTable = std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "tests/quality/encoders.csv";
constexpr const char* kRenew = "renew the table if it is meant: ./dev bench encoders --table tests/quality/encoders.csv";

const std::vector<QualityRow>& committed() {
    static const auto table = readQualityTable(kTable);
    if (!table) throw std::runtime_error(table.error().line());
    return *table;
}

const std::vector<Picture>& pictures() {
    static const std::vector<Picture> own = ownPictures(LIGHTCOOK_SOURCE_DIR, kTablePictureSize);
    return own;
}

std::vector<QualityRow> committedRows(PixelFormat format, int effort) {
    std::vector<QualityRow> rows;
    for (const QualityRow& row : committed())
        if (row.format == formats::info(format).name && row.effort == effort) rows.push_back(row);
    return rows;
}

/// Holds fresh rows of a format and effort against the table's.
void expectNotWorse(const std::vector<QualityRow>& fresh, PixelFormat format, int effort) {
    std::map<std::string, Figures> table;
    for (const QualityRow& row : committedRows(format, effort))
        EXPECT_TRUE(table.emplace(row.picture, row.figures).second) << fmt::format("{} twice in the table", row.picture);
    const std::string where = fmt::format("{} effort {}", formats::info(format).name, effort);
    for (const QualityRow& row : fresh) {
        const auto found = table.find(row.picture);
        if (found == table.end()) {
            ADD_FAILURE() << fmt::format("{}, {}: found no row in {}; {}", where, row.picture, kTable.string(), kRenew);
            continue;
        }
        EXPECT_GE(row.figures.psnrDb, found->second.psnrDb - kHairDb)
            << fmt::format("{}, {}: found {:.4f} dB, expected the {:.4f} dB of the table; {}", where, row.picture, row.figures.psnrDb,
                           found->second.psnrDb, kRenew);
        table.erase(found);
    }
    for (const auto& [picture, figures] : table)
        ADD_FAILURE() << fmt::format("{}, {}: found a row in the table, expected none of a picture that is not there; {}", where, picture,
                                     kRenew);
}

class EncoderTable : public testing::TestWithParam<PixelFormat> {};
using EncoderTableSoak = EncoderTable;

/// efforts  in ascending order
void expectAsInTheTable(PixelFormat format, const std::vector<int>& efforts) {
    double before = 0;
    for (const int effort : efforts) {
        const std::vector<QualityRow> rows = qualityRows(format, effort, pictures());
        expectNotWorse(rows, format, effort);
        const double mean = meanDb(rows);
        EXPECT_GT(mean, before) << fmt::format("{}: found effort {} no better than a smaller one over the mean of the pictures",
                                               formats::info(format).name, effort);
        before = mean;
    }
}

/// The efforts that cooks take, and the fast kernels. The others take five times as long.
TEST_P(EncoderTable, NoRowIsWorseAndEveryEffortIsBetterThanTheOneBefore) {
    expectAsInTheTable(GetParam(), {0, 3, 5});
}
TEST_P(EncoderTableSoak, NoRowIsWorseAndEveryEffortIsBetterThanTheOneBefore) {
    expectAsInTheTable(GetParam(), {0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
}
/// ASTC comes from a library, and its larger blocks take longer than all other formats: CI has one format of it.
std::vector<PixelFormat> formatsOfCi() {
    std::vector<PixelFormat> formats = tableFormats();
    std::erase_if(formats, [&](PixelFormat format) {
        const std::string_view name = formats::info(format).name;
        return name.starts_with("astc") && name != "astc-4x4-hdr";
    });
    return formats;
}
std::string nameOfFormat(const testing::TestParamInfo<PixelFormat>& instance) {
    std::string name(formats::info(instance.param).name);
    std::ranges::replace(name, '-', '_');
    return name;
}
INSTANTIATE_TEST_SUITE_P(Quality, EncoderTable, testing::ValuesIn(formatsOfCi()), nameOfFormat);
INSTANTIATE_TEST_SUITE_P(Quality, EncoderTableSoak, testing::ValuesIn(tableFormats()), nameOfFormat);

TEST(EncoderTableFile, HoldsNothingElse) {
    std::set<std::string> known;
    for (const PixelFormat format : tableFormats()) known.emplace(formats::info(format).name);
    for (const QualityRow& row : committed()) {
        EXPECT_TRUE(known.contains(row.format)) << fmt::format("found the unknown format '{}' in the table; {}", row.format, kRenew);
        EXPECT_TRUE(row.effort >= 0 && row.effort <= 9) << fmt::format("found effort {} in the table, expected 0 to 9", row.effort);
    }
}

TEST(EncoderTableFile, ABrokenLineIsNamed) {
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "broken_quality_table.csv";
    std::ofstream(file) << csvOf({}) << "bc7,5,foliage,41.5,0.1,0.2,0.3,0.4\nbc7,five,foliage,41.5,0.1,0.2,0.3,0.4\n";
    const auto table = readQualityTable(file);
    ASSERT_FALSE(table.has_value());
    EXPECT_NE(table.error().line().find("broken_quality_table.csv:3: found 'bc7,five"), std::string::npos) << table.error().line();
    std::filesystem::remove(file);
}

}  // namespace
}  // namespace lightcook::bench
