#include "formats/lmbake.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/formats/light_map_fixture.h"
#include "tests/formats/lmbake_fixture.h"

namespace lightcook::formats {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::ElementsAre;
using testing::HasSubstr;

GodotBake room() {
    return {.meshes = {{{"..", "Room", "Wall"}, 0.25, 0.5, 0.125, 0.5, 1}, {{"..", "Gräser"}, 0, 0, 0.5, 0.25, 0, 7}}};
}

Result<Lmbake> read(const std::string& bytes) {
    static const TemporaryFolder folder;
    writeContent(folder / "room.lmbake", bytes);
    return readLmbake(folder / "room.lmbake");
}

std::string faultOf(const std::string& bytes) {
    const auto bake = read(bytes);
    return bake ? "none" : bake.error().line();
}

TEST(Lmbake, SaysHowDirectionsAreStored) {
    struct Case {
        bool isPacked;
        int minor;
        bool isOld;
    };
    for (const auto& [isPacked, minor, isOld] : {Case{true, 4, false}, Case{false, 3, true}, Case{false, 4, false}, Case{true, 3, false}}) {
        GodotBake bake = room();
        bake.isPacked = isPacked;
        bake.minor = minor;
        const auto found = read(bake.plain());
        ASSERT_TRUE(found) << found.error().line();
        EXPECT_TRUE(found->isDirectional);
        EXPECT_EQ(found->hasOldDirections(), isOld) << "an older bake that Godot 4.4 saved again is known by its values";
    }
}

TEST(Lmbake, MeshesHaveARectangleOfASlice) {
    GodotBake bake = room();
    std::vector<std::string> files = {bake.plain(), bake.compressed(), bake.compressed(1u << 16)};
    bake.isBigEndian = true;
    files.push_back(bake.plain());
    bake.isBigEndian = false;
    bake.isDouble = true;
    bake.hasNamesInTable = false;
    files.push_back(bake.plain());
    for (std::size_t i = 0; i < files.size(); ++i) {
        const auto found = read(files[i]);
        ASSERT_TRUE(found) << i << ": " << found.error().line();
        ASSERT_EQ(found->users.size(), 2u) << i;
        EXPECT_THAT(found->users[0].path, ElementsAre("..", "Room", "Wall")) << i;
        EXPECT_EQ(found->users[0].rectangle, glm::dvec4(0.25, 0.5, 0.125, 0.5)) << i;
        EXPECT_EQ(found->users[0].slice, 1) << i;
        EXPECT_EQ(found->users[0].name(), "../Room/Wall") << i;
        EXPECT_EQ(found->users[1].name(), "../Gräser, mesh 7") << i;
        EXPECT_EQ(found->sliceCount(), 2) << i;
    }
}

TEST(Lmbake, AnEmptyBlockMayBeTheLast) {
    constexpr std::uint32_t kBlock = 1024;
    GodotBake bake = room();
    bake.hasNamesInTable = false;
    bake.meshes.front().path.back().append(kBlock - bake.content(0).size() % kBlock, 'x');
    ASSERT_EQ(bake.content(0).size() % kBlock, 0u);
    const auto found = read(bake.compressed(kBlock));
    ASSERT_TRUE(found) << found.error().line();
    EXPECT_EQ(found->users.size(), 2u);
}

TEST(Lmbake, OtherResourcesAreNamed) {
    GodotBake old = room();
    old.resource = "BakedLightmapData";
    EXPECT_THAT(faultOf(old.plain()), HasSubstr("room.lmbake: found a resource of class \"BakedLightmapData\" (Godot 4), expected "
                                                "LightmapGIData of Godot 4"));
    EXPECT_THAT(faultOf("[gd_resource type=\"LightmapGIData\"]"), HasSubstr("found no binary resource of Godot, expected"));
    EXPECT_THAT(faultOf(""), HasSubstr("found no binary resource of Godot"));
    std::string other = room().compressed();
    other[4] = 0;
    EXPECT_THAT(faultOf(other), HasSubstr("found compression 0 of Godot, expected 2 (Zstandard) or none"));
    std::string newer = room().plain();
    newer[20] = 9;
    EXPECT_THAT(faultOf(newer), HasSubstr("found format 9 of Godot's resources, expected 3 to 6"));
}

TEST(Lmbake, ValuesThatNoBakeHasAreRefusedByMesh) {
    const auto faultOfMesh = [](const GodotMesh& mesh) { return faultOf(GodotBake{.meshes = {{{"..", "Floor"}}, mesh}}.plain()); };
    EXPECT_THAT(faultOfMesh({{"..", "Wall"}, 0.5, 0, 0.75, 1}),
                HasSubstr("room.lmbake, mesh 1 '../Wall': found a rectangle at (0.5, 0) of 0.75 x 1, expected a part of the slice"));
    EXPECT_THAT(faultOfMesh({{"..", "Wall"}, 0, 0, 0, 1}), HasSubstr("found a rectangle"));
    EXPECT_THAT(faultOfMesh({{"..", "Wall"}, std::nan(""), 0, 1, 1}), HasSubstr("found a rectangle at (nan"));
    EXPECT_THAT(faultOfMesh({{"..", "Wall"}, 0, 0, 1, 1, -1}), HasSubstr("found slice -1, expected 0 to 2047"));
    EXPECT_THAT(faultOfMesh({{}}), HasSubstr("mesh 1: found an empty node path"));
}

/// Nothing foreign may crash the reader or make it allocate: cut off anywhere, and with any byte replaced by one that makes a count huge.
TEST(Lmbake, DamagedFilesAreRefused) {
    for (const std::string& whole : {room().plain(), room().compressed(1024)}) {
        for (std::size_t length = 0; length + 4 < whole.size(); ++length) {
            const std::string fault = faultOf(whole.substr(0, length));
            ASSERT_THAT(fault, AnyOf(HasSubstr("found"), HasSubstr("expected"))) << length;
        }
        for (std::size_t at = 4; at < whole.size(); ++at) {
            std::string damaged = whole;
            damaged[at] = static_cast<char>(damaged[at] == '\x7f' ? '\xff' : '\x7f');
            (void)read(damaged);
        }
    }
}

TEST(Lmbake, ListsWithinListsEnd) {
    GodotBytes bytes;
    bytes.text = room().plain();
    // The first property becomes a list of a list of a list ...
    const std::size_t at = bytes.text.find(std::string("\x1e\0\0\0\x01\0\0\0\x18", 9));
    ASSERT_NE(at, std::string::npos);
    bytes.text.resize(at);
    for (int i = 0; i < 100000; ++i) bytes.u32(30).u32(1);
    EXPECT_THAT(faultOf(bytes.text), HasSubstr("found lists 33 deep, expected at most 32"));
}

TEST(Lmbake, NamesThatAreLongAndOftenUsedDoNotFillTheMemory) {
    GodotBake bake;
    bake.meshes.push_back({std::vector<std::string>(1, std::string(std::size_t{1} << 20, 'a'))});
    std::string bytes = bake.plain();
    const std::size_t path = bytes.find(std::string("\x16\0\0\0\x01\0\0\0", 8));
    ASSERT_NE(path, std::string::npos);
    GodotBytes many;
    many.u32(22).number(1000, 2).number(0, 2);
    for (int i = 0; i < 1000; ++i) many.u32(6);
    EXPECT_THAT(faultOf(bytes.substr(0, path) + many.text), HasSubstr("found node paths of more than"));
}

TEST(Lmbake, IsFoundBesideTheBakeThatGodotWrites) {
    ExrRecipe picture;
    picture.width = picture.height = 4;
    for (const char* colour : {"R", "G", "B"}) picture.channels[colour] = [](int, int) { return 0.5f; };
    const MapFile flat(picture), sh9(seededMap(4, 4));
    for (const MapFile* map : {&flat, &sh9}) {
        EXPECT_EQ(lmbakeBeside(map->path, "auto"), std::filesystem::path());
        room().write(map->folder / "map.lmbake");
    }
    EXPECT_EQ(lmbakeBeside(flat.path, "auto"), flat.folder / "map.lmbake");
    EXPECT_EQ(lmbakeBeside(flat.path, "flat"), flat.folder / "map.lmbake");
    EXPECT_EQ(lmbakeBeside(flat.path, "bakery-sh"), std::filesystem::path());
    EXPECT_EQ(lmbakeBeside(sh9.path, "auto"), std::filesystem::path()) << "another baker's";
    EXPECT_EQ(lmbakeBeside(sh9.path, "sh9"), std::filesystem::path());
}

TEST(Lmbake, BelongsToALightMapOfGodotWithItsSlices) {
    const MapFile sh9(seededMap(4, 4));
    room().write(sh9.folder / "room.lmbake");
    LightMapDescription description;
    description.lmbake = sh9.folder / "room.lmbake";
    const Error other = refusal(sh9.path, description);
    EXPECT_EQ(other.code, ErrorCode::InvalidRequest);
    EXPECT_THAT(other.line(), AllOf(HasSubstr("map.exr, lmbake: found room.lmbake beside a light map of bake format sh9, expected none"),
                                    HasSubstr("flat, godot, godot-radiance")));

    ExrRecipe picture;
    picture.width = 4;
    picture.height = 12;
    for (const char* colour : {"R", "G", "B"}) picture.channels[colour] = [](int, int) { return 0.5f; };
    const MapFile flat(picture);
    writeContent(flat.path.string() + ".import", "importer=\"2d_array_texture\"\nslices/horizontal=1\nslices/vertical=3\n");
    description.bake = "flat";
    EXPECT_THAT(refusal(flat.path, description).line(), HasSubstr("room.lmbake: found meshes in 2 slices, expected 3, as "));
}

}  // namespace
}  // namespace lightcook::formats
