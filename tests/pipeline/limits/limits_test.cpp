// Limits, and the one comparison of figures with them.
#include "pipeline/limits/limits.h"

#include <gmock/gmock.h>

#include <cmath>

namespace lightcook::pipeline {
namespace {

using testing::ElementsAre;
using testing::Field;

TEST(Limits, OnlyFiguresWithALimitAreChecked) {
    const std::vector<Figure> figures = {
        {Limit::Error, 0.01, "total", "diffuse"}, {Limit::Visible, 4, "total", "diffuse"}, {Limit::Error, 0.03, "total", "specular"}};
    EXPECT_TRUE(judge(figures, {}).empty());
    const std::vector<Check> checks = judge(figures, {{Limit::Error, 0.02}, {Limit::Seam, 1}});
    EXPECT_THAT(checks, ElementsAre(Field(&Check::allowed, 0.02), Field(&Check::allowed, 0.02)));
    EXPECT_TRUE(checks[0].isKept());
    EXPECT_FALSE(checks[1].isKept());
    EXPECT_FALSE(areKept(checks));
    EXPECT_TRUE(areKept(judge(figures, {{Limit::Error, 0.03}, {Limit::Visible, 4}}))) << "a figure may be as large as its limit";
}

TEST(Limits, AFigureThatIsNotFiniteKeepsNone) {
    for (const double value : {std::nan(""), HUGE_VAL}) {
        const std::vector<Check> checks = judge({{Limit::Visible, value, "total", "diffuse"}}, {{Limit::Visible, 5}});
        EXPECT_FALSE(areKept(checks));
        EXPECT_EQ(mostUsedShare(checks), HUGE_VAL);
    }
}

TEST(Limits, TheMostUsedIsTheLargestShareAndOfEqualOnesTheFirst) {
    const Limits limits = {{Limit::Error, 0.1}, {Limit::Visible, 5}, {Limit::Seam, 0}};
    const auto most = mostUsed(judge(
        {{Limit::Error, 0.02, "a", ""}, {Limit::Visible, 4, "b", ""}, {Limit::Error, 0.08, "c", ""}, {Limit::Seam, 0, "d", ""}}, limits));
    ASSERT_TRUE(most);
    EXPECT_EQ(most->figure.stage, "b");
    EXPECT_DOUBLE_EQ(most->share(), 0.8);
    EXPECT_EQ(mostUsedShare(judge({{Limit::Seam, 0.5, "", ""}}, limits)), HUGE_VAL) << "nothing is allowed";
    EXPECT_FALSE(mostUsed({}));
    EXPECT_EQ(mostUsedShare({}), 0);
}

}  // namespace
}  // namespace lightcook::pipeline
