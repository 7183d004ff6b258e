#include "pipeline/manifest/manifest.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/document/json_schema.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;

/// Expects that a schema lists every member of a value.
void expectListed(const Json& value, const Json& schema, const Json& definitions, const std::string& path) {
    if (schema.contains("$ref")) return expectListed(value, definitions.at(schema["$ref"].get<std::string>().substr(8)), definitions, path);
    if (value.is_array())
        for (const Json& element : value) expectListed(element, schema.value("items", Json::object()), definitions, path + "[]");
    if (!value.is_object() || !schema.contains("properties")) return;
    for (const auto& [key, member] : value.items()) {
        EXPECT_TRUE(schema["properties"].contains(key)) << path << '.' << key;
        if (schema["properties"].contains(key))
            expectListed(member, schema["properties"][key], definitions, fmt::format("{}.{}", path, key));
    }
}

TEST(Manifest, IsReadAsItWasWrittenAndEveryFieldIsListed) {
    const SmallScene scene(SmallScene::Parts::All);
    const RunState state;
    const Outcome outcome = cookScene(scene.options(), state);
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    const Json written = Json::parse(formats::contentOf(scene / "out" / kManifestName));
    const auto manifest = loadManifest(scene / "out");
    ASSERT_TRUE(manifest.has_value()) << manifest.error().line();
    Json read = toJson(*manifest);
    read["digest"] = written.at("digest");
    EXPECT_EQ(read.dump(), written.dump());

    Json schema = documentSchema<Manifest>("");
    schema["properties"]["digest"] = Json::object();
    expectListed(written, schema, schema.at("$defs"), "");
}

TEST(Manifest, OfAnotherSchemaAsksForACook) {
    const formats::TemporaryFolder folder;
    formats::writeContent(folder / kManifestName, R"({"schema": 2, "assets": []})");
    EXPECT_EQ(loadManifest(folder.path()).error().detail,
              "found schema 2, expected 1: another version of lightcook wrote it; cook the scene again");
}

TEST(Manifest, MembersThatTheCookLeavesOpenAreNeeded) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    const RunState state;
    ASSERT_TRUE(cookScene(scene.options(), state).errors.empty());
    const Json whole = Json::parse(formats::contentOf(scene / "out" / kManifestName));
    const auto lineWithout = [&](const char* parent, const char* key) {
        Json json = whole;
        json[Json::json_pointer(parent)].erase(key);
        formats::writeContent(scene / "out" / kManifestName, json.dump());
        const auto manifest = loadManifest(scene / "out");
        return manifest ? std::string("accepted") : manifest.error().line();
    };
    EXPECT_THAT(lineWithout("/assets/0/textures/0", "digest"), HasSubstr("assets/0/textures/0: found"));
    EXPECT_THAT(lineWithout("", "cooks"), HasSubstr("expected an object with a member \"cooks\""));
    EXPECT_THAT(lineWithout("/assets/0/source/files", "source"), HasSubstr("assets/0/source/files"));
    EXPECT_THAT(lineWithout("/shader", "file"), HasSubstr("shader: found"));
}

TEST(Manifest, HasNumbersInRangeAndANameForEachAsset) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    const RunState state;
    ASSERT_TRUE(cookScene(scene.options(), state).errors.empty());
    const Json whole = Json::parse(formats::contentOf(scene / "out" / kManifestName));
    ASSERT_EQ(whole.at("/assets/0/name"_json_pointer), "map");
    const auto expectRefused = [&](const char* place, const Json& value, const std::string& expected) {
        Json json = whole;
        json.at(Json::json_pointer(place)) = value;
        formats::writeContent(scene / "out" / kManifestName, json.dump());
        const auto manifest = loadManifest(scene / "out");
        ASSERT_FALSE(manifest) << place;
        EXPECT_EQ(manifest.error().code, formats::ErrorCode::FileUnreadable);
        EXPECT_THAT(manifest.error().line(), HasSubstr(fmt::format("cooked.json, {}: found {}, expected ", place + 1, value.dump())));
        EXPECT_THAT(manifest.error().detail, HasSubstr(expected));
    };
    expectRefused("/assets/0/bits_per_texel", -1, "a number from 0 to ");
    expectRefused("/assets/1/name", "map", "a name that no other asset has");
}

}  // namespace
}  // namespace lightcook::pipeline
