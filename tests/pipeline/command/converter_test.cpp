#include <gtest/gtest.h>

#include "formats/plain_image.h"
#include "pipeline/command/converter.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

using formats::Image;

/// A conversion can be planned again from what its scene keeps.
TEST(Converters, AreScenesOfOneAsset) {
    const std::filesystem::path folder = "bakes";
    const std::vector<std::pair<Conversion, std::vector<std::pair<const char*, const char*>>>> all = {
        {{"lightmap", folder / "map.exr", "out"},
         {{"light_map.phase", "condon-shortley"}, {"output.mips", "true"}, {"material.specular", "false"}}},
        {{"dominant", folder / "map.exr", "out"}, {{"light_map.dominant_fit", "refined"}, {"output.max_converter_error", "2%"}}},
        {{"cubemap", folder / "sky.exr", "out"}, {{"probe.size", "32"}, {"color.source", "acescg"}}},
        {{"rsrm", folder / "sky.exr", "sky.dds"}, {{"gradient.exponents", "1,8"}, {"gradient.axis", "0,1,0"}}},
        {{"lut", {}, "out"}, {{"material.m", "0.1,0.5"}, {"lobe", "phong"}}}};
    for (auto [conversion, keys] : all) {
        SCOPED_TRACE(conversion.command);
        for (const auto& [key, value] : keys) conversion.cook.given.set(key, value);
        const auto scene = sceneOf(conversion);
        ASSERT_TRUE(scene) << scene.error().line();
        EXPECT_EQ(scene->lightMaps.size() + scene->probes.size() + scene->gradients.size(), conversion.command == "lut" ? 0u : 1u);
        const auto again = readSceneDocument(parseJson(textOf(scene->document)), scene->directory);
        ASSERT_TRUE(again) << again.error().line();
        EXPECT_EQ(again->document, scene->document);
        EXPECT_EQ(again->lobe, scene->lobe);
        EXPECT_EQ(again->allowances.size(), conversion.cook.given.find("color.source") == nullptr ? 0u : 1u);
        for (const auto& [key, value] : keys) EXPECT_EQ(faultOfKey(key, value), "") << key;
    }
}

TEST(Converters, WriteTheContainerOfTheirFile) {
    Conversion conversion{"rsrm", "sky.exr", "sky.dds"};
    EXPECT_EQ(sceneOf(conversion)->output.container, formats::Container::Dds);
    conversion.cook.given.set("output.container", "ktx2");
    const Outcome refused = convert(conversion, RunState());
    ASSERT_EQ(refused.errors.size(), 1u);
    EXPECT_EQ(refused.errors[0].line(), "--container: found another container than that of sky.dds, expected the same, or no --container");
}

/// A light source 10^18 times as bright as the rest: no 16-bit float holds both, and the report counts the lost texels of each level.
TEST(Cubemap, LightLostByTheDivisionIsCountedByLevel) {
    const formats::TemporaryFolder folder;
    for (const bool isDark : {false, true}) {
        Image<glm::vec4> sky(16, 8, glm::vec4(isDark ? 1e-12f : 0.5f));
        if (isDark) sky.at(3, 2) = glm::vec4(1e6f);
        ASSERT_TRUE(formats::writeExr(folder / "sky.exr", sky.view(), 3));
        Conversion options{"cubemap", folder / "sky.exr", folder / (isDark ? "dark" : "calm")};
        options.cook.cache = folder / "cache";
        options.cook.given.set("output.target", "float");
        const Outcome outcome = convert(options, RunState());
        ASSERT_TRUE(outcome.report.is_object());
        const Json& notes = outcome.report.at("assets").at(0).at("notes");
        EXPECT_TRUE(notes.at("division_clamped").empty());
        EXPECT_EQ(notes.at("division_lost").empty(), !isDark);
        if (isDark) {
            EXPECT_GT(notes.at("division_lost").at("level 0").get<int>(), 6 * 128 * 128);
        }
    }
}

}  // namespace
}  // namespace lightcook::pipeline
