#include "formats/nearest.h"

#include <gtest/gtest.h>

namespace lightcook::formats {
namespace {

const std::vector<std::string> kFormats = {"bc1", "bc7", "bc6h-uf16", "rgba16f"};

TEST(NearestName, IsTheOneWithTheLeastEdits) {
    EXPECT_EQ(nearestName("bc8", kFormats), "bc1") << "of equally near names the first";
    EXPECT_EQ(nearestName("rbga16f", kFormats), "rgba16f");
    EXPECT_EQ(nearestName("bc1", {}), "");
}

TEST(NearestName, PrefersANameThatHasAllOfTheFoundOne) {
    EXPECT_EQ(nearestName("bc6", kFormats), "bc6h-uf16") << "bc1 is one edit away";
    EXPECT_EQ(nearestName("6", kFormats), "bc1") << "a letter is in many names";
}

TEST(NearestHint, IsEmptyWhereNoNameIsNear) {
    EXPECT_EQ(nearestHint("rgb16f", kFormats), "; nearest is 'rgba16f'");
    EXPECT_EQ(nearestHint("bc6h-uf16-unsigned", kFormats), "; nearest is 'bc6h-uf16'") << "a name is a part of the found one";
    EXPECT_EQ(nearestHint("exponents", kFormats), "");
    EXPECT_EQ(nearestHint("bc1", {}), "");
}

}  // namespace
}  // namespace lightcook::formats
