#include <fmt/format.h>
#include <gmock/gmock.h>

#include <set>

#include "formats/vocabulary.h"
#include "pipeline/report/budgets.h"
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

/// A value of a type that no key has is refused by the name of the key.
TEST(SceneKeys, EveryRowIsRead) {
    const std::string date = " = 1979-05-27\n";
    for (const KeyTable& table : sceneKeyTables())
        for (const KeyRow& key : table.keys) {
            const std::string path = table.name.empty() ? key.name : fmt::format("{}.{}", table.name, key.name);
            SCOPED_TRACE(path);
            std::string text;
            for (const char* required : {"schema = 1\n", "name = \"s\"\n"})
                if (!table.name.empty() || !std::string_view(required).starts_with(key.name)) text += required;
            if (const std::size_t dot = table.name.find('.'); dot != std::string::npos)  // a table of a table
                text += fmt::format("[[{}]]\nname = \"a\"\nfile = \"a\"\nmesh = \"a\"\n", table.name.substr(0, dot));
            if (!table.name.empty()) text += fmt::format(fmt::runtime(table.isArray ? "[[{}]]\n" : "[{}]\n"), table.name);
            for (const KeyRow& other : table.keys)
                if (other.name != key.name && other.name != "schema" && other.fallback.starts_with("required") && !table.name.empty() &&
                    key.name != "files")
                    text += other.name + " = \"a\"\n";
            if (key.name == "files") text += "name = \"a\"\n";
            EXPECT_THAT(readError(text.append(key.name).append(date)), HasSubstr(fmt::format("found a date or time for {}, ", path)));
        }
}

TEST(SceneKeys, NumbersAreNoBooleans) {
    EXPECT_THAT(readError("schema = 1\nname = \"s\"\n[output]\ngltf = 1\n"),
                HasSubstr("found the integer 1 for output.gltf, expected true or false"));
    EXPECT_THAT(readError("schema = 1\nname = \"s\"\n[output]\nmips = 3\n"),
                HasSubstr("found the integer 3 for output.mips, expected true or false: the charts of a map decide"));
}

TEST(SceneKeys, AreNamedOnceAndDescribed) {
    for (const std::span<const KeyTable> tables : {sceneKeyTables(), budgetKeyTables()})
        for (const KeyTable& table : tables) {
            std::set<std::string_view> names;
            for (const KeyRow& key : table.keys) {
                EXPECT_TRUE(names.insert(key.name).second) << key.name;
                EXPECT_THAT(key.type, Not(IsEmpty())) << key.name;
                EXPECT_THAT(key.fallback, Not(IsEmpty())) << key.name;
                EXPECT_THAT(key.caption, Not(IsEmpty())) << key.name;
            }
        }
}

}  // namespace
}  // namespace lightcook::pipeline
