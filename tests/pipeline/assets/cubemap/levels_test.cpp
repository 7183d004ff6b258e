// Every texel of every level of a cubemap is compared: maps that are right by construction, and one fault in each.
#include "pipeline/assets/cubemap/levels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>
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
verify::CookedCubemap rightMap(const formats::Environment& room) {
    struct Entry {
        int size;
        double m;
    };
    const verify::CubemapReference reference(room);
    verify::CookedCubemap map;
    map.isDivided = false;
    for (const Entry& entry : {Entry{24, 0}, {16, 0.1}, {8, 0.2}, {32, 0.5}, {4, 1}}) {
        verify::CookedCubemap::Mip mip;
        mip.m = entry.m;
        std::optional<verify::PrefilteredLight> light;
        if (entry.m > 0) light.emplace(room, entry.m);
        for (int face = 0; face < 6; ++face) {
            formats::Image<glm::vec4> image(entry.size, entry.size);
            for (int y = 0; y < entry.size; ++y)
                for (int x = 0; x < entry.size; ++x) {
                    const glm::dvec3 direction = lighting::cubeTexelDirection(face, x, y, entry.size);
                    image.at(x, y) =
                        glm::vec4(glm::vec3(light ? light->towards(direction) : reference.footprintMean(direction, entry.size)), 1);
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

/// Returns the errors of the levels of the right map with a fault.
std::vector<verify::CubemapErrors> errorsWith(const LevelFault& fault) {
    static const formats::Environment room = roomWithLamp();
    static const verify::CubemapReference reference(room);
    static const verify::CookedCubemap right = rightMap(room);
    verify::CookedCubemap map = copyOf(right);
    fault(map);
    CubemapLevels levels(map, room, reference, 1, std::nullopt);
    for (std::size_t task = 0; task < levels.taskCount(); ++task) levels.run(task);
    for (std::size_t face = 0; face < levels.faceCount(); ++face) levels.compare(face);
    return levels.errors();
}

glm::vec4& texelAt(verify::CookedCubemap& map, std::size_t mip, std::size_t face, int x, int y) {
    return map.mips[mip].faces[face].at(x, y);
}

TEST(CubemapLevels, ARightMapHasNoError) {
    for (const verify::CubemapErrors& level : errorsWith([](verify::CookedCubemap&) {})) {
        EXPECT_LT(level.energy.figures().relRms, 1e-5);
        EXPECT_GT(level.energy.sampleCount(), 0);
    }
}

/// Of every block of every level one texel is wrong in turn: each is in the figures of its level, and of no other.
TEST(CubemapLevels, AWrongTexelIsFoundAtAnyLevelWhereverItLies) {
    for (const std::size_t mip : {0u, 1u, 2u, 3u, 4u})
        for (const int block : mip == 3 ? std::vector<int>{1, 3, 7} : std::vector<int>{5}) {
            const std::size_t face = static_cast<std::size_t>(block) % 6;
            glm::ivec2 at(0);
            const auto levels = errorsWith([&](verify::CookedCubemap& map) {
                const int size = map.mips[mip].faces[face].width();
                at = {4 * (block % (size / 4)) + block % 4, 4 * (block * 3 % (size / 4)) + block % 3};
                texelAt(map, mip, face, at.x, at.y) = glm::vec4(6, 0, 6, 1);
            });
            for (std::size_t each = 0; each < levels.size(); ++each) {
                const verify::ErrorFigures figures = levels[each].energy.figures();
                if (each != mip) {
                    EXPECT_LT(figures.relRms, 1e-5) << each;
                    continue;
                }
                EXPECT_GT(figures.relRms, 1e-3);
                EXPECT_EQ(figures.sampledAt.mip, static_cast<int>(mip));
                EXPECT_EQ(figures.sampledAt.face, static_cast<int>(face));
                EXPECT_EQ(figures.sampledAt.x, at.x);
                EXPECT_EQ(figures.sampledAt.y, at.y);
            }
        }
}

TEST(CubemapLevels, ALevelOfTheWrongBrightnessErrsByThat) {
    for (const std::size_t mip : {0u, 1u, 2u, 3u, 4u}) {
        const auto levels = errorsWith([&](verify::CookedCubemap& map) {
            for (auto& face : map.mips[mip].faces)
                for (glm::vec4& texel : face.texels()) texel *= 1.3f;
        });
        EXPECT_NEAR(levels[mip].energy.figures().relRms, 0.3, 1e-5);
    }
}

}  // namespace
}  // namespace lightcook::pipeline
