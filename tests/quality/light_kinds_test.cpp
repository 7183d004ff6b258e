// The generated light maps are those that they say: readable, possible light, and the same each time.
#include <gmock/gmock.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "bench/light_kinds.h"
#include "formats/light_map.h"
#include "formats/read_file.h"
#include "formats/temporary_folder.h"
#include "tests/formats/read_light_map.h"

namespace lightcook::bench {
namespace {

using formats::LightMapStrip;

constexpr int kSize = 40;

class LightKinds : public testing::TestWithParam<std::string> {
protected:
    formats::TemporaryFolder folder_;
};

/// Light of the hemisphere of a normal has |L1| <= sqrt(3) L0, and a mean direction there. Halves round by a part of 2^-11, or 2^-25.
TEST_P(LightKinds, HoldPossibleLight) {
    const auto file = folder_.path() / "map.exr";
    writeLightKind(file, GetParam(), kSize);
    const LightMapStrip map = formats::readAll(file);
    ASSERT_EQ(map.sh.width(), kSize);
    ASSERT_EQ(map.sh.height(), kSize);
    int covered = 0, impossible = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            if (map.covered.at(x, y) == 0) continue;
            ++covered;
            const lighting::ShRgb& sh = map.sh.at(x, y);
            const glm::dvec3 normal(map.normal.at(x, y));
            EXPECT_NEAR(glm::length(normal), 1, 1e-6);
            for (int c = 0; c < 3; ++c) {
                const double zonal = static_cast<double>(sh[0][c]), rounding = 0x1p-10 * zonal + 0x1p-23;
                const glm::dvec3 linear(sh[3][c], sh[1][c], sh[2][c]);
                impossible += !(glm::length(linear) <= std::sqrt(3.0) * (zonal + rounding) && glm::dot(linear, normal) >= -2 * rounding);
            }
        }
    EXPECT_GT(covered, GetParam() == "single-texels" ? kSize * kSize / 12 : kSize * kSize / 2);
    EXPECT_EQ(impossible, 0);
}

TEST_P(LightKinds, AreTheSameEachTime) {
    const auto content = [&](const char* name) {
        writeLightKind(folder_.path() / name, GetParam(), 9, 3);
        return formats::readWholeFile(folder_.path() / name).value_or(std::vector<std::byte>());
    };
    const auto first = content("a.exr");
    EXPECT_FALSE(first.empty());
    EXPECT_EQ(first, content("b.exr"));
}

/// Unity's pair, whose light is in halves, shows the exit radiance of the bake at the surface's own normal, up to 8 bits of direction.
TEST_P(LightKinds, ShowTheSameLightInTheFormatOfUnity) {
    if (std::string_view(GetParam()) == "tiny" || std::string_view(GetParam()) == "huge") return;  // no light that halves hold
    writeLightKind(folder_.path() / "map.exr", GetParam(), kSize);
    writeUnityLightKind(folder_.path(), "room", GetParam(), kSize);
    const LightMapStrip map = formats::readAll(folder_.path() / "map.exr"), unity = formats::readAll(folder_.path() / "room_light.exr");
    ASSERT_EQ(unity.sh.width(), kSize);
    double error = 0, light = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            if (map.covered.at(x, y) == 0) continue;
            for (int c = 0; c < 3; ++c) {
                const double a = static_cast<double>(map.sh.at(x, y)[0][c]), b = static_cast<double>(unity.sh.at(x, y)[0][c]);
                error += (a - b) * (a - b);
                light += a * a;
            }
        }
    EXPECT_LE(std::sqrt(error / light), 0.01);
}

std::vector<std::string> names() {
    std::vector<std::string> out;
    for (const LightKind& kind : lightKinds()) out.emplace_back(kind.name);
    return out;
}

INSTANTIATE_TEST_SUITE_P(Each, LightKinds, testing::ValuesIn(names()), [](const auto& name) {
    std::string word = name.param;
    std::erase(word, '-');
    return word;
});

/// Lamps of the night span five decades, the light of the map four.
TEST(LightKindsNight, SpansFourDecades) {
    const formats::TemporaryFolder folder;
    writeLightKind(folder.path() / "night.exr", "night", 128);
    const LightMapStrip map = formats::readAll(folder.path() / "night.exr");
    float low = 1e30f, high = 0;
    for (const lighting::ShRgb& sh : map.sh.texels()) {
        if (sh[0].g > 0) low = std::min(low, sh[0].g);
        high = std::max(high, sh[0].g);
    }
    EXPECT_GE(high, 1e4f * low);
}

}  // namespace
}  // namespace lightcook::bench
