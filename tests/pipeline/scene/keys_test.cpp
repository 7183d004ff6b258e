#include "pipeline/scene/keys.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <set>

#include "formats/vocabulary.h"
#include "pipeline/scene/scene.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::string readError(const std::string& text) {
    const formats::TemporaryFolder folder;
    formats::writeContent(folder / "scene.toml", text);
    const auto scene = readScene(folder / "scene.toml");
    return scene ? "" : scene.error().line();
}

/// The reader asks for every key of the table: a value of a type that no key has is refused by name. (That the table has every key that
/// is read, the reader itself checks: the reading of a complete scene in scene_test.cpp would throw.)
TEST(SceneKeys, EveryRowIsRead) {
    const std::string date = " = 1979-05-27\n";
    for (const SceneSectionInfo& section : allSceneSections())
        for (const SceneKeyInfo& key : section.keys) {
            const std::string name(key.name), place = section.name.empty() ? "the scene" : std::string(section.name);
            SCOPED_TRACE(fmt::format("{}.{}", place, name));
            std::string text;
            for (const char* required : {"schema = 1\n", "name = \"s\"\n"})
                if (!section.name.empty() || !std::string_view(required).starts_with(name)) text += required;
            if (section.name.find('.') != std::string_view::npos)  // a table of a table
                text += fmt::format("[[{}]]\nname = \"a\"\nfile = \"a\"\nmesh = \"a\"\n", section.name.substr(0, section.name.find('.')));
            if (!section.name.empty()) {
                text += section.isArray ? "[[" + place + "]]\n" : "[" + place + "]\n";
                for (const char* required : {"name", "file", "node"})
                    if (name != required && formats::findByName(std::span<const SceneKeyInfo>(section.keys), required) != nullptr)
                        text += std::string(required) + " = \"a\"\n";
            }
            EXPECT_THAT(readError(text.append(name).append(date)), HasSubstr(fmt::format("found a date or time for {}.{}", place, name)));
        }
}

TEST(SceneKeys, NumbersAreNoBooleans) {
    EXPECT_THAT(readError("schema = 1\nname = \"s\"\n[output]\ngltf = 1\n"),
                HasSubstr("found the integer 1 for output.gltf, expected true or false"));
    EXPECT_THAT(readError("schema = 1\nname = \"s\"\n[output]\nmips = 3\n"),
                HasSubstr("found the integer 3 for output.mips, expected true or false: the charts of a map decide"));
}

TEST(SceneKeys, AreNamedOnceAndDescribed) {
    for (const SceneSectionInfo& section : allSceneSections()) {
        std::set<std::string_view> names;
        for (const SceneKeyInfo& key : section.keys) {
            EXPECT_TRUE(names.insert(key.name).second) << key.name;
            EXPECT_THAT(key.type, Not(IsEmpty())) << key.name;
            EXPECT_THAT(key.fallback, Not(IsEmpty())) << key.name;
            EXPECT_THAT(key.caption, Not(IsEmpty())) << key.name;
        }
    }
}

}  // namespace
}  // namespace lightcook::pipeline
