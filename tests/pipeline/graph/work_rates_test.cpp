// Times of work that was skipped.
#include "pipeline/graph/work_rates.h"

#include <gtest/gtest.h>

#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

TEST(WorkRates, AreKeptAndScaledWithTheTexels) {
    const formats::TemporaryFolder folder;
    WorkRates rates(folder / "rates.json");
    rates.add("cubemap", 1000, 2);
    rates.add("mesh", 0, 3);
    rates.save();
    const WorkRates again(folder / "rates.json");
    EXPECT_DOUBLE_EQ(again.secondsOf("cubemap", 4000).value_or(0), 8);
    EXPECT_FALSE(again.secondsOf("mesh", 4000)) << "no texels, no rate";
}

/// The rate of a cubemap of 4 x 4 texels is that of reading its source: a minute for one of 128 x 128.
TEST(WorkRates, SayNothingOfWorkThatIsMuchLarger) {
    const formats::TemporaryFolder folder;
    WorkRates rates(folder / "rates.json");
    rates.add("cubemap", 96, 0.06);
    EXPECT_TRUE(rates.secondsOf("cubemap", 16 * 96));
    EXPECT_FALSE(rates.secondsOf("cubemap", 98304));
}

TEST(WorkRates, ReadNothingFromAnotherFile) {
    const formats::TemporaryFolder folder;
    for (const char* content :
         {"", "[]", R"({"cubemap": 0.001})", R"({"cubemap": {"texels": 0, "seconds": 1}})", R"({"cubemap": {"texels": 5}})"}) {
        formats::writeContent(folder / "rates.json", content);
        EXPECT_FALSE(WorkRates(folder / "rates.json").secondsOf("cubemap", 10)) << content;
    }
}

}  // namespace
}  // namespace lightcook::pipeline
