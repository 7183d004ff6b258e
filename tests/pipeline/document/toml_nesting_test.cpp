#include "pipeline/document/toml_nesting.h"

#include <gtest/gtest.h>

#include <string>

namespace lightcook::pipeline {
namespace {

TEST(TomlNesting, CountsBracketsAndPartsOfKeys) {
    EXPECT_FALSE(placeNestedDeeper("a = [[1], {b = [2]}]\n[c.d]\ne = 1", 4));
    EXPECT_TRUE(placeNestedDeeper("a = [[[[[1]]]]]", 4));
    EXPECT_TRUE(placeNestedDeeper("a.b.c.d.e = 1", 4));
    EXPECT_TRUE(placeNestedDeeper("[a . \"b.c\" . 'd' . e . f]", 4));
    EXPECT_FALSE(placeNestedDeeper("a = [1.5, 2.5, 3.5, 4.5, 5.5, 6.5]", 4)) << "dots of numbers";
}

TEST(TomlNesting, SkipsStringsAndComments) {
    EXPECT_FALSE(placeNestedDeeper("a = \"[[[[[[\\\"[[[[\" # [[[[[[\n", 4));
    EXPECT_FALSE(placeNestedDeeper("a = '[[[[[[\\' # [[[[[[", 4));
    EXPECT_FALSE(placeNestedDeeper("a = \"\"\"\n[[[[ \"\" [[[[\\\"\"\"\n[[\"\"\"", 4));
    EXPECT_FALSE(placeNestedDeeper("a = \'\'\'\n[[[[ '' [[[[\n\'\'\'", 4));
}

TEST(TomlNesting, FindsThePlace) {
    const auto place = placeNestedDeeper("a = 1\nbb = [[[[", 3);
    ASSERT_TRUE(place.has_value());
    EXPECT_EQ(place->line, 2);
    EXPECT_EQ(place->column, 9);
}

TEST(TomlNesting, ReadsHostileTextsInTime) {
    for (const char* part : {"[", "{a=", "a.", "'", "\"", "\"\"\"", "#", "[[", "\n"}) {
        std::string text;
        while (text.size() < 1 << 22) text += part;
        (void)placeNestedDeeper(text, 16);
    }
}

}  // namespace
}  // namespace lightcook::pipeline
