#include "pipeline/assets/needs.h"

#include <gtest/gtest.h>

#include "tests/pipeline/scene_with_one_map.h"

namespace lightcook::pipeline {
namespace {

TEST(ResolveNeeds, NothingKnownMeansEverythingIsNeeded) {
    const Needs needs = resolveNeeds(sceneWithOneMap(), {});
    EXPECT_TRUE(needs.specular);
    EXPECT_TRUE(needs.normalMap);
    EXPECT_EQ(needs.m.low, 0.1);
    EXPECT_EQ(needs.f0.high, 0.6);
}

TEST(ResolveNeeds, TheUnionOfTheMeshsMaterials) {
    const Needs needs = resolveNeeds(
        sceneWithOneMap(),
        {{"a", false, true, {0.2, 0.3}, {0.04, 0.04}}, {"b", true, true, {0.25, 0.5}, {0.02, 0.1}}, {"c", false, false, {1, 1}, {0, 1}}});
    EXPECT_TRUE(needs.normalMap);
    EXPECT_EQ(needs.m.low, 0.2);
    EXPECT_EQ(needs.m.high, 0.5) << "a material that is not specular asks for no roughness";
    EXPECT_EQ(needs.f0.low, 0.02);
    EXPECT_EQ(needs.f0.high, 0.1);
}

TEST(ResolveNeeds, TheSceneFileOverridesTheMesh) {
    Scene scene = sceneWithOneMap();
    scene.materials = {{"*", false, std::nullopt, std::nullopt, std::nullopt}, {"b", std::nullopt, false, std::nullopt, std::nullopt}};
    const Needs needs = resolveNeeds(scene, {{"a", true, true, {0.2, 0.3}, {0.04, 0.04}}, {"b", true, true, {0.6, 0.6}, {0.04, 0.04}}});
    EXPECT_FALSE(needs.normalMap);
    EXPECT_EQ(needs.m.high, 0.3);
}

TEST(ResolveNeeds, TheLargestTiltOfMaterialsWithNormalMaps) {
    Scene scene = sceneWithOneMap();
    const std::vector<MaterialRecord> mesh = {{"bumpy", true, true, {0.2, 0.3}, {0.04, 0.04}},
                                              {"even", false, true, {0.2, 0.3}, {0.04, 0.04}}};
    const auto tiltOf = [&](std::vector<MaterialEntry> materials) {
        scene.materials = std::move(materials);
        return shadingOf(scene, resolveNeeds(scene, mesh)).normalMapTilt;
    };
    const auto entry = [](const std::string& name, std::optional<bool> normalMap, std::optional<double> tilt) {
        MaterialEntry made;
        made.name = name;
        made.normalMap = normalMap;
        made.normalMapTilt = tilt;
        return made;
    };
    EXPECT_EQ(tiltOf({}), 60);
    EXPECT_EQ(tiltOf({entry("*", {}, 30)}), 30);
    EXPECT_EQ(tiltOf({entry("*", {}, 30), entry("bumpy", {}, 45)}), 45);
    EXPECT_EQ(tiltOf({entry("*", {}, 30), entry("even", {}, 45)}), 30) << "a material without a normal map";
    EXPECT_EQ(tiltOf({entry("bumpy", {}, 30), entry("even", true, {})}), 60) << "one with a normal map of unknown tilt";
    EXPECT_EQ(tiltOf({entry("*", false, 30)}), 0);
}

TEST(UnreadLevels, AreThoseSharperThanTheSmoothestMaterial) {
    Needs needs;
    EXPECT_EQ(unreadLevelsOf(needs, 128), 0) << "no material says how rough it is";
    needs.isRoughnessKnown = true;
    const auto unread = [&](double m, int size) {
        needs.m = {m, 1};
        return unreadLevelsOf(needs, size);
    };
    EXPECT_EQ(unread(0, 128), 0) << "a mirror reads level 0";
    EXPECT_EQ(unread(0.02, 128), 0) << "perceptual roughness 0.14 is below level 1 of 7, at 0.143";
    EXPECT_EQ(unread(0.03, 128), 1);
    EXPECT_EQ(unread(0.1, 128), 2) << "0.316 lies between levels 2 and 3";
    EXPECT_EQ(unread(0.1, 2048), 3) << "of 11";
    EXPECT_EQ(unread(1, 128), 5) << "levels of 4 x 4 texels stay";
    EXPECT_EQ(unread(1, 16), 2);
}

TEST(TableRows, CoverTheNeededRoughnessAndNoMore) {
    for (const Range m : {Range{0.1, 0.5}, Range{0.3, 0.6}, Range{0, 1}, Range{0.25, 0.25}, Range{1, 1}, Range{0.01, 0.02}}) {
        Needs needs;
        needs.m = m;
        const TableRows rows = tableRowsFor(needs);
        EXPECT_GE(rows.count, 2);
        EXPECT_LE(rows.first + rows.count, 16);
        EXPECT_LE(rows.minimumM(), std::max(m.low, 1.0 / 16)) << m.low;
        EXPECT_GE(rows.maximumM(), m.high) << m.high;
    }
    Needs narrow;
    narrow.m = {0.3, 0.6};
    EXPECT_EQ(tableRowsFor(narrow).count, 7) << "4/16 .. 10/16";
}

TEST(Samples, TheRangesEndsAndTheUsualValuesInside) {
    EXPECT_EQ(samplesOf({0.1, 0.5}, {0.1, 0.25, 0.5}), (std::vector<double>{0.1, 0.25, 0.5}));
    EXPECT_EQ(samplesOf({0.2, 0.2}, {0.1, 0.25, 0.5}), (std::vector<double>{0.2}));
}

}  // namespace
}  // namespace lightcook::pipeline
