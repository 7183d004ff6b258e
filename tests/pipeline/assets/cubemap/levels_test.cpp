// Every texel of every level of a cubemap is compared: maps that are right by construction, and one fault in each.
#include "pipeline/assets/cubemap/levels.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <vector>

#include "lighting/cube.h"

namespace lightcook::pipeline {
namespace {

using LevelFault = std::function<void(verify::CookedCubemap& map)>;

/// A room: dim walls of three colours, and a lamp in the ceiling.
formats::Environment roomWithLamp() {
    constexpr int kRoomSide = 24;
    formats::Environment room;
    room.projection = formats::Environment::Projection::CubeStrip;
    room.texels = formats::Image<glm::vec3>(kRoomSide, 6 * kRoomSide);
    for (int y = 0; y < 6 * kRoomSide; ++y)
        for (int x = 0; x < kRoomSide; ++x) {
            const glm::dvec3 direction = lighting::cubeTexelDirection(y / kRoomSide, x, y % kRoomSide, kRoomSide);
            const bool isLamp = y / kRoomSide == 2 && std::abs(x - 12) < 3 && std::abs(y % kRoomSide - 12) < 3;
            room.texels.at(x, y) =
                isLamp ? glm::vec3(60, 50, 40) : glm::vec3(glm::dvec3(0.6 + 0.3 * direction.x, 0.5, 0.6 - 0.3 * direction.x));
        }
    return room;
}

/// A plain map with levels of these sizes and roughnesses, as the references have it.
verify::CookedCubemap rightMap(const verify::CubemapReference& reference) {
    struct Entry {
        int size;
        double m;
    };
    verify::CookedCubemap map;
    map.isDivided = false;
    for (const Entry& entry : {Entry{24, 0}, {16, 0.1}, {8, 0.2}, {32, 0.5}, {4, 1}}) {
        verify::CookedCubemap::Mip mip;
        mip.m = entry.m;
        for (int face = 0; face < 6; ++face) {
            formats::Image<glm::vec4> image(entry.size, entry.size);
            for (int y = 0; y < entry.size; ++y)
                for (int x = 0; x < entry.size; ++x) {
                    const glm::dvec3 direction = lighting::cubeTexelDirection(face, x, y, entry.size);
                    image.at(x, y) = glm::vec4(glm::vec3(entry.m > 0 ? reference.prefiltered(direction, entry.m, 2)
                                                                     : reference.footprintMean(direction, entry.size)),
                                               1);
                }
            mip.faces.push_back(std::move(image));
        }
        map.mips.push_back(std::move(mip));
    }
    return map;
}

verify::CookedCubemap copyOf(const verify::CookedCubemap& map) {
    verify::CookedCubemap copy;
    copy.isDivided = map.isDivided;
    for (const verify::CookedCubemap::Mip& mip : map.mips) {
        copy.mips.push_back({mip.m, mip.bands, {}});
        for (const auto& face : mip.faces) copy.mips.back().faces.push_back(face.copy());
    }
    return copy;
}

/// Returns the places of the violations of the right map with a fault.
std::string violationsWith(const LevelFault& fault) {
    static const formats::Environment room = roomWithLamp();
    static const verify::CubemapReference reference(room);
    static const verify::CookedCubemap right = rightMap(reference);
    verify::CookedCubemap map = copyOf(right);
    fault(map);
    CubemapLevels levels(map, room, reference, 1);
    for (std::size_t task = 0; task < levels.taskCount(); ++task) levels.run(task);
    std::vector<verify::Violation> violations;
    levels.check(0.1, violations);
    std::string places;
    for (const verify::Violation& violation : violations) places += violation.place + "\n";
    return places;
}

glm::vec4& texelAt(verify::CookedCubemap& map, std::size_t mip, std::size_t face, int x, int y) {
    return map.mips[mip].faces[face].at(x, y);
}

TEST(CubemapLevels, ARightMapHasNoViolation) {
    EXPECT_EQ(violationsWith([](verify::CookedCubemap&) {}), "");
}

/// The figures alone would miss most of them: they sample 96 of the 384 blocks of level 3.
TEST(CubemapLevels, AWrongBlockIsFoundAtAnyLevelWhereverItLies) {
    for (const std::size_t mip : {0u, 1u, 2u, 3u, 4u})
        for (const int block : mip == 3 ? std::vector<int>{1, 3, 7} : std::vector<int>{5}) {
            const std::size_t face = static_cast<std::size_t>(block) % 6;
            const auto fault = [&](verify::CookedCubemap& map) {
                const int size = map.mips[mip].faces[face].width(), first = 4 * (block % (size / 4)), top = 4 * (block * 3 % (size / 4));
                for (int y = top; y < top + 4; ++y)
                    for (int x = first; x < first + 4; ++x) texelAt(map, mip, face, x, y) = glm::vec4(6, 0, 6, 1);
            };
            EXPECT_THAT(violationsWith(fault), testing::HasSubstr(fmt::format("mip {}, face {}, block of texel", mip, face))) << block;
        }
}

/// The first texel of the block, which used to stand for it, is right.
TEST(CubemapLevels, WrongTexelsBesideARightOneAreFound) {
    EXPECT_THAT(violationsWith([](verify::CookedCubemap& map) {
                    for (int x = 9; x < 12; ++x)
                        for (int y = 5; y < 8; ++y) texelAt(map, 0, 1, x, y) = glm::vec4(0, 4, 0, 1);
                }),
                testing::HasSubstr("mip 0, face 1, block of texel (8, 4)"));
}

/// Multiplies the texels of some faces of a level.
LevelFault brightened(std::size_t mip, std::size_t firstFace, std::size_t endFace, const glm::vec4& factor) {
    return [=](verify::CookedCubemap& map) {
        for (std::size_t face = firstFace; face < endFace; ++face)
            for (glm::vec4& texel : map.mips[mip].faces[face].texels()) texel *= factor;
    };
}

TEST(CubemapLevels, ALevelOfTheWrongBrightnessIsFound) {
    for (const std::size_t mip : {0u, 1u, 2u, 4u})
        EXPECT_THAT(violationsWith(brightened(mip, 0, 6, glm::vec4(1.3f))),
                    testing::HasSubstr(fmt::format("mip {}, channel 0, light", mip)));
    EXPECT_THAT(violationsWith(brightened(2, 0, 6, glm::vec4(1, 1, 0.75f, 1))), testing::HasSubstr("mip 2, channel 2, light"));
}

TEST(CubemapLevels, AFaceOfTheWrongBrightnessIsFound) {
    EXPECT_THAT(violationsWith(brightened(3, 3, 4, glm::vec4(1, 1.3f, 1, 1))), testing::HasSubstr("mip 3, face 3, channel 1, light"));
}

}  // namespace
}  // namespace lightcook::pipeline
