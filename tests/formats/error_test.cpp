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

TEST(ErrorSubject, NamesItsFileAndLineForProgramsToo) {
    const std::filesystem::path file = "maps/lobby.exr";
    const Error inside = failure(ErrorCode::ValueNotFinite, Subject(file).at("channel R"), "found NaN").value();
    EXPECT_EQ(inside.line(), "maps/lobby.exr, channel R: found NaN");
    EXPECT_EQ(inside.file, file);
    EXPECT_FALSE(inside.lineNumber);
    const Error inText(ErrorCode::InvalidRequest, Subject::inLine("scene.toml", 12, 3), "found no key");
    EXPECT_EQ(inText.subject, "scene.toml:12:3");
    EXPECT_EQ(inText.file, "scene.toml");
    EXPECT_EQ(inText.lineNumber, 12);
    EXPECT_TRUE(Error(ErrorCode::InvalidRequest, "--only", "found 'x'").file.empty());
}

TEST(ErrorList, HasEachLineOnce) {
    std::vector<Error> errors;
    EXPECT_TRUE(addOnce(errors, {ErrorCode::Internal, "a", "b"}));
    EXPECT_FALSE(addOnce(errors, {ErrorCode::Internal, "a", "b"}));
    EXPECT_TRUE(addOnce(errors, {ErrorCode::Internal, "a", "c"}));
    EXPECT_EQ(errors.size(), 2u);
}

}  // namespace
}  // namespace lightcook::formats
