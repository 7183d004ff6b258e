// Dependency files: names that Make and Ninja read otherwise than they stand.
#include "pipeline/cook/depfile.h"

#include <gmock/gmock.h>

namespace lightcook::pipeline {
namespace {

std::string depfileOf(const std::filesystem::path& sceneFile, const std::filesystem::path& output = "out") {
    Scene scene;
    scene.file = sceneFile;
    return depfileText(scene, output, {});
}

TEST(Depfile, EscapesBlanksHashesAndDollars) {
    EXPECT_EQ(depfileOf("a b.toml"), "out/cooked.json: a\\ b.toml\n");
    EXPECT_EQ(depfileOf("a\tb.toml"), "out/cooked.json: a\\\tb.toml\n");
    EXPECT_EQ(depfileOf("a#b.toml", "o$t"), "o$$t/cooked.json: a\\#b.toml\n");
}

// Make takes what follows a bare colon for a pattern, and ends.
TEST(Depfile, EscapesColons) {
    EXPECT_EQ(depfileOf("a:b.toml", "o:t"), "o\\:t/cooked.json: a\\:b.toml\n");
}

// "\\ " is a backslash and the end of the name: the build system then misses the target, and an input.
TEST(Depfile, DoublesBackslashesBeforeBlanksAlone) {
    EXPECT_EQ(depfileOf("a\\ b.toml"), "out/cooked.json: a\\\\\\ b.toml\n");
    EXPECT_EQ(depfileOf("a\\\\ b.toml", "o\\ t"), "o\\\\\\ t/cooked.json: a\\\\\\\\\\ b.toml\n");
    EXPECT_EQ(depfileOf("a\\b c.toml"), "out/cooked.json: a\\b\\ c.toml\n");
}

// Make and Ninja have no common escape for these. `make` 4.3 was tried with each.
TEST(Depfile, WarnsOfPathsThatMakeReadsOtherwise) {
    const auto warningOf = [](const std::filesystem::path& sceneFile, const std::filesystem::path& output) {
        Scene scene;
        scene.file = sceneFile;
        const auto warning = warningForMake(scene, output);
        return warning ? warning->line() : "";
    };
    EXPECT_EQ(warningOf("a%b(c)d'&~!.toml", "o (1)|'&~!*"), "");
    EXPECT_THAT(warningOf("a.toml", "o%1"), testing::StartsWith("o%1/cooked.json: found '%' in a path of the depfile"));
    EXPECT_THAT(warningOf("a.toml", "o=1"), testing::HasSubstr("found '=' in a path of the depfile"));
    EXPECT_THAT(warningOf("a=b.toml", "o"), testing::HasSubstr("a=b.toml: found '='"));
    EXPECT_THAT(warningOf("a;b.toml", "o"), testing::HasSubstr("Make takes it for a command"));
    EXPECT_THAT(warningOf("a|b.toml", "o"), testing::HasSubstr("found '|'"));
    EXPECT_THAT(warningOf("a\nb.toml", "o"), testing::HasSubstr("found '\\n'"));
    EXPECT_THAT(warningOf("lib(b.toml)", "o"), testing::HasSubstr("found '(...)'"));
    EXPECT_EQ(depfileOf("a.toml", "o%1"), "o%1/cooked.json: a.toml\n") << "as Ninja and CMake read it";
}

}  // namespace
}  // namespace lightcook::pipeline
