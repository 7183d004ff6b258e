#include "pipeline/manifest/self_digest.h"

#include <gtest/gtest.h>

namespace lightcook::pipeline {
namespace {

TEST(SelfDigest, AChangeOfAnyByteShows) {
    const std::string text = withSelfDigest({{"scene", "room"}, {"assets", {1, 2, 3}}});
    ASSERT_TRUE(checkSelfDigest(text, "cooked.json").has_value());
    for (std::size_t i = 0; i < text.size(); ++i) {
        std::string changed = text;
        changed[i] = static_cast<char>(changed[i] ^ 1);
        EXPECT_FALSE(checkSelfDigest(changed, "cooked.json").has_value()) << "byte " << i;
    }
}

TEST(SelfDigest, ReplacesAnOlderOne) {
    const std::string text = withSelfDigest({{"scene", "room"}});
    EXPECT_EQ(withSelfDigest(Json::parse(text)), text);
    EXPECT_FALSE(checkSelfDigest("{}", "cooked.json").has_value());
}

}  // namespace
}  // namespace lightcook::pipeline
