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

}  // namespace
}  // namespace lightcook::pipeline
