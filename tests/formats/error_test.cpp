#include "formats/error.h"

#include <gtest/gtest.h>

namespace lightcook::formats {
namespace {

TEST(ErrorLine, EscapesControlCharacters) {
    EXPECT_EQ((Error{ErrorCode::Internal, "a\nb\x1b[2J", "found \t"}).line(), "a\\nb\\x1b[2J: found \\t");
}

/// They reorder the rest of the line on a terminal: "gpj.exr" for "exr.jpg".
TEST(ErrorLine, EscapesControlsOfTheDirectionOfText) {
    EXPECT_EQ(withoutControls("a\u202Arxe.\u202E\u2066\u2069"), "a\\u202arxe.\\u202e\\u2066\\u2069");
    const std::string others = "\u2029\u202F\u2065\u206A \u00e9 \u65e5";
    EXPECT_EQ(withoutControls(others), others) << "letters beside them stay";
    EXPECT_EQ(withoutControls("\xe2\x80"), "\xe2\x80") << "a letter that was cut stays";
}

}  // namespace
}  // namespace lightcook::formats
