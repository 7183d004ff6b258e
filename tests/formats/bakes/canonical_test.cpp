#include "formats/bakes/canonical.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>

#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "tests/formats/light_map_fixture.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;
using testing::AllOf;
using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(Canonical, OutsideChartsAnythingIsAllowedAndBecomesZero) {
    ExrRecipe recipe = seededMap(4, 2);
    recipe.channels["coverage.Y"] = [](int x, int) { return x == 0 ? 0.0f : x == 3 ? 0.5f : 1.0f; };
    for (const char axis : {'X', 'Y', 'Z'}) {
        recipe.channels[fmt::format("normal.{}", axis)] = [axis](int x, int) {
            return x == 0 ? kNan : x == 1 ? 0.0f : axis == 'Y' ? 3.0f : 0.0f;
        };
    }
    poke(recipe, "sh03.G", 0, 0, kNan);
    poke(recipe, "sh00.R", 0, 1, -5.0f);
    poke(recipe, "sh08.B", 1, 0, kInfinity);
    poke(recipe, "sh08.B", 3, 0, -kInfinity);
    const MapFile map(recipe);
    const LightMapStrip strip = readAll(map.path);
    for (int y = 0; y < 2; ++y) {
        for (const int x : {0, 1, 3}) {
            EXPECT_EQ(strip.covered.at(x, y), 0) << x;
            EXPECT_EQ(strip.sh.at(x, y), ShRgb{}) << x;
            EXPECT_EQ(strip.normal.at(x, y), glm::vec3(0, 0, 1)) << x;
        }
        EXPECT_EQ(strip.covered.at(2, y), 1);
        EXPECT_EQ(strip.sh.at(2, y), seededTexel(2, y));
        EXPECT_EQ(strip.normal.at(2, y), glm::vec3(0, 1, 0)) << "normals come back as unit vectors";
    }
    EXPECT_EQ(strip.repairs.notFinite, 0);
}

TEST(Canonical, BadCoveredTexelsAreRefusedWithChannelAndPosition) {
    struct Case {
        const char* channel;
        float value;
        ErrorCode code;
        const char* found;
    };
    for (const Case& bad :
         {Case{"sh03.G", kNan, ErrorCode::ValueNotFinite, "found nan"}, Case{"sh08.B", kInfinity, ErrorCode::ValueNotFinite, "found inf"},
          Case{"sh00.R", -kInfinity, ErrorCode::ValueNotFinite, "found -inf"},
          Case{"sh00.B", -0.25f, ErrorCode::ValueOutOfRange, "found -0.25"}}) {
        ExrRecipe recipe = seededMap(16, 80);
        recipe.isTiled = true;
        poke(recipe, bad.channel, 12, 70, bad.value);
        const MapFile map(recipe);
        const Error error = refusal(map.path);
        EXPECT_EQ(error.code, bad.code) << bad.channel;
        EXPECT_THAT(error.line(), AllOf(HasSubstr("map.exr"), HasSubstr(bad.channel), HasSubstr("texel (12, 70)"), HasSubstr(bad.found),
                                        HasSubstr("expected")));
    }
    ExrRecipe recipe = seededMap(4, 4);
    for (const char axis : {'X', 'Y', 'Z'}) recipe.channels[fmt::format("normal.{}", axis)] = [](int, int) { return 1.0f; };
    poke(recipe, "normal.Z", 1, 2, kNan);
    EXPECT_THAT(refusal(MapFile(recipe).path).line(), AllOf(HasSubstr("normal.Z"), HasSubstr("(1, 2)")));
}

TEST(Canonical, ChartsAreNumbersThatEveryCoveredTexelHas) {
    ExrRecipe recipe = seededMap(4, 2);
    recipe.channels["coverage.Y"] = [](int x, int) { return x < 2 ? 1.0f : 0.0f; };
    recipe.channels["chart.Y"] = [](int x, int y) { return x == 3 ? 0.0f : 1.0f + static_cast<float>(y); };
    const LightMapStrip strip = readAll(MapFile(recipe).path);
    for (int y = 0; y < 2; ++y) {
        const auto chart = static_cast<std::uint32_t>(1 + y);
        EXPECT_EQ(strip.chart.at(0, y), chart);
        EXPECT_EQ(strip.chart.at(2, y), chart) << "a filter reads it";
        EXPECT_EQ(strip.chart.at(3, y), kNoChart);
    }
    for (const float wrong : {0.0f, -1.0f, 1.5f, 0x1p24f, kNan, kInfinity}) {
        ExrRecipe bad = recipe;
        poke(bad, "chart.Y", 1, 1, wrong);
        const Error error = refusal(MapFile(bad).path);
        EXPECT_EQ(error.code, ErrorCode::ValueOutOfRange) << wrong;
        EXPECT_THAT(error.line(),
                    AllOf(HasSubstr("chart.Y, texel (1, 1)"), HasSubstr(fmt::format("found {}", wrong)), HasSubstr("from 1 on")));
    }
    EXPECT_EQ(readAll(MapFile(seededMap(4, 2)).path).chart.width(), 0) << "a file without charts";
}

TEST(LightMapStrip, SurfacesLieBetweenTexelsOfOneChart) {
    EXPECT_TRUE(mayHoldSurface({kAnyChart, kAnyChart, kAnyChart, kAnyChart}));
    EXPECT_TRUE(mayHoldSurface({7, 7, 7, 7}));
    EXPECT_TRUE(mayHoldSurface({7, kAnyChart, kAnyChart, 7}));
    EXPECT_FALSE(mayHoldSurface({7, 7, 8, 7}));
    EXPECT_FALSE(mayHoldSurface({kAnyChart, 7, kAnyChart, 8}));
    EXPECT_FALSE(mayHoldSurface({7, 7, 7, kNoChart}));
    EXPECT_FALSE(mayHoldSurface({kAnyChart, kAnyChart, kAnyChart, kNoChart}));
}

TEST(Canonical, LightBeyondFloatsIsNamedByItsChannel) {
    ExrRecipe recipe = seededMap(4, 4);
    poke(recipe, "sh00.G", 1, 2, 2e38f);
    LightMapDescription description;
    description.lightUnits = LightUnits::Game;
    const Error error = refusal(MapFile(recipe).path, description);
    EXPECT_EQ(error.code, ErrorCode::ValueOutOfRange);
    EXPECT_THAT(error.line(), HasSubstr("map.exr, channel sh00.G, texel (1, 2): found light that leaves the range of float"));
}

TEST(Canonical, NegativeZeroIsNotNegativeEnergy) {
    ExrRecipe recipe = seededMap(2, 1);
    for (int i = 0; i < 9; ++i) poke(recipe, fmt::format("sh{:02}.G", i), 1, 0, -0.0f);
    EXPECT_EQ(readAll(MapFile(recipe).path).covered.at(1, 0), 1);
}

/// An overflow of halves is light beyond them, not darkness.
TEST(Canonical, InfiniteLightIsRepairedToTheLargestHalf) {
    ExrRecipe recipe = seededMap(8, 4);
    poke(recipe, "sh00.R", 3, 1, kInfinity);
    poke(recipe, "sh02.R", 3, 1, -kInfinity);
    poke(recipe, "sh00.G", 4, 1, -kInfinity);
    LightMapDescription description;
    description.repair = true;
    description.fireflyLimit = 0;
    const MapFile map(recipe);
    const LightMapStrip strip = readAll(map.path, description);
    EXPECT_EQ(strip.repairs.notFinite, 2);
    ShRgb expected = seededTexel(3, 1);
    for (glm::vec3& coefficient : expected) coefficient.r = 0;
    expected[0].r = 65504;
    EXPECT_EQ(strip.sh.at(3, 1), expected);
    EXPECT_EQ(strip.sh.at(4, 1), ShRgb{});
}

TEST(Canonical, RepairCountsInsteadOfRefusing) {
    ExrRecipe recipe = seededMap(8, 4);
    poke(recipe, "sh03.G", 1, 1, kNan);
    poke(recipe, "sh04.B", 1, 1, kInfinity);
    poke(recipe, "sh00.R", 2, 1, -1.0f);
    poke(recipe, "sh00.B", 2, 1, -2.0f);
    LightMapDescription description;
    description.repair = true;
    const MapFile map(recipe);
    const LightMapStrip strip = readAll(map.path, description);
    EXPECT_EQ(strip.repairs.notFinite, 1);
    EXPECT_EQ(strip.repairs.negativeDc, 2);
    EXPECT_EQ(strip.sh.at(1, 1), ShRgb{});
    ShRgb onlyGreen = seededTexel(2, 1);
    for (glm::vec3& coefficient : onlyGreen) coefficient = {0, coefficient.g, 0};
    EXPECT_EQ(strip.sh.at(2, 1), onlyGreen);
    EXPECT_EQ(strip.sh.at(3, 1), seededTexel(3, 1));
}

/// Light from one direction has bands of length sqrt(2 l + 1) times sh00; in a file of irradiance they are shorter by the cosine lobe.
TEST(Canonical, BandsFarBeyondWhatTheirMeanAllowsAreRefusedOrScaledDown) {
    for (const ShQuantity quantity : {ShQuantity::Radiance, ShQuantity::Irradiance}) {
        LightMapDescription description;
        description.quantity = quantity;
        const std::array<double, 3> cosine = {std::numbers::pi, 2 * std::numbers::pi / 3, std::numbers::pi / 4};
        const auto longest = [&](int degree) {
            const double ofRadiance = std::sqrt(2 * degree + 1.0);
            const bool isConvolved = quantity == ShQuantity::Irradiance;
            return 0.25 * ofRadiance * (isConvolved ? cosine[static_cast<std::size_t>(degree)] / cosine[0] : 1);
        };
        for (const int degree : {1, 2}) {
            const int first = degree * degree;
            for (const double times : {1.0, 3.9, 4.1, 1e6, 1e37}) {
                ExrRecipe recipe = seededMap(8, 4);
                for (int i = 0; i < 9; ++i) poke(recipe, fmt::format("sh{:02}.G", i), 5, 2, i == 0 ? 0.25f : 0.0f);
                const auto part = static_cast<float>(longest(degree) * times / std::numbers::sqrt2);
                poke(recipe, fmt::format("sh{:02}.G", first), 5, 2, part);
                poke(recipe, fmt::format("sh{:02}.G", first + 2), 5, 2, -part);
                const MapFile map(recipe);
                description.repair = false;
                if (times < 4) {
                    EXPECT_EQ(readAll(map.path, description).repairs.bandsBeyond, 0);
                    continue;
                }
                const auto reader = LightMapReader::open(map.path, description);
                ASSERT_TRUE(reader);
                const auto refused = reader->read(0, 4);
                ASSERT_FALSE(refused) << degree << ' ' << times;
                EXPECT_EQ(refused.error().code, ErrorCode::ValueOutOfRange);
                EXPECT_THAT(refused.error().line(), AllOf(HasSubstr(degree == 1 ? "sh01.G .. sh03.G" : "sh04.G .. sh08.G"),
                                                          HasSubstr("texel (5, 2)"), HasSubstr("sh00 of 0.25")));
                description.repair = true;
                const LightMapStrip strip = readAll(map.path, description);
                EXPECT_EQ(strip.repairs.bandsBeyond, 1);
                const ShRgb& sh = strip.sh.at(5, 2);
                const auto at = static_cast<std::size_t>(first);
                EXPECT_NEAR(std::hypot(sh[at].g, sh[at + 2].g) / sh[0].g, std::sqrt(2 * degree + 1.0), 1e-5);
                EXPECT_FLOAT_EQ(sh[at].g, -sh[at + 2].g);
                EXPECT_EQ(strip.sh.at(4, 2), readAll(MapFile(seededMap(8, 4)).path, description).sh.at(4, 2));
            }
        }
    }
}

TEST(Canonical, RoundingOfDarkTexelsToHalvesIsNoFault) {
    ExrRecipe recipe = seededMap(4, 4);
    for (int i = 0; i < 9; ++i) poke(recipe, fmt::format("sh{:02}.B", i), 1, 1, i == 0 ? 0.0f : 6e-8f);
    EXPECT_EQ(readAll(MapFile(recipe).path).repairs.bandsBeyond, 0);
    // The same in cd/m^2: the light was rounded, then multiplied.
    constexpr float kUnit = 1e5f;
    for (auto& [name, channel] : recipe.channels) channel = [before = channel](int x, int y) { return kUnit * before(x, y); };
    EXPECT_EQ(readAll(MapFile(recipe).path).repairs.bandsBeyond, 0);
    poke(recipe, "sh02.B", 1, 1, 10);
    EXPECT_THAT(refusal(MapFile(recipe).path).line(), HasSubstr("texel (1, 1)"));
}

ShRgb convertedTexel(const LightMapDescription& description, const ExrRecipe& recipe) {
    const MapFile map(recipe);
    return readAll(map.path, description).sh.at(1, 1);
}

void expectNear(const ShRgb& found, const ShRgb& expected, float tolerance) {
    for (std::size_t i = 0; i < 9; ++i) {
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(found[i][channel], expected[i][channel], tolerance) << i << ' ' << channel;
    }
}

TEST(Canonical, CondonShortleyNegatesTheOddOnes) {
    LightMapDescription description;
    description.phase = ShPhase::CondonShortley;
    ShRgb expected = seededTexel(1, 1);
    for (const std::size_t index : {1u, 3u, 5u, 7u}) expected[index] = -expected[index];
    EXPECT_EQ(convertedTexel(description, seededMap(3, 3)), expected);
}

TEST(Canonical, IrradianceIsDividedByTheCosineBandsAndGameLightsGetTheirPi) {
    LightMapDescription description;
    description.quantity = ShQuantity::Irradiance;
    const double pi = std::numbers::pi, cosine[9] = {pi, 2 * pi / 3, 2 * pi / 3, 2 * pi / 3, pi / 4, pi / 4, pi / 4, pi / 4, pi / 4};
    ShRgb radiance = seededTexel(1, 1), game = radiance, both = radiance;
    for (std::size_t i = 0; i < 9; ++i) {
        for (int channel = 0; channel < 3; ++channel) {
            const double stored = static_cast<double>(radiance[i][channel]);
            radiance[i][channel] = static_cast<float>(stored / cosine[i]);
            game[i][channel] = static_cast<float>(stored * pi);
            both[i][channel] = static_cast<float>(stored / cosine[i] * pi);
        }
    }
    expectNear(convertedTexel(description, seededMap(3, 3)), radiance, 1e-6f);
    description.lightUnits = LightUnits::Game;
    expectNear(convertedTexel(description, seededMap(3, 3)), both, 4e-6f);
    description.quantity = ShQuantity::Radiance;
    expectNear(convertedTexel(description, seededMap(3, 3)), game, 4e-6f);
}

/// The nine basis functions again, from the table in lighting/sh.h.
std::array<double, 9> basis(const glm::dvec3& d) {
    const double pi = std::numbers::pi, a = std::sqrt(3 / (4 * pi)), b = std::sqrt(15 / pi) / 2;
    return {std::sqrt(1 / pi) / 2,
            a * d.y,
            a * d.z,
            a * d.x,
            b * d.x * d.y,
            b * d.y * d.z,
            std::sqrt(5 / pi) / 4 * (3 * d.z * d.z - 1),
            b * d.x * d.z,
            b / 2 * (d.x * d.x - d.y * d.y)};
}

TEST(Canonical, TangentFramesAreTurnedToTheWorld) {
    // A light from local direction d, stored in the frame around n, is a light from frame * d in the world.
    const glm::dvec3 local = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));
    for (const glm::dvec3& direction :
         {glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), glm::dvec3(0.2, -0.9, -0.4), glm::dvec3(-1, 2, 3)}) {
        const glm::dvec3 normal = glm::normalize(direction);
        ExrRecipe recipe = seededMap(3, 3);
        const std::array<double, 9> stored = basis(local);
        for (std::size_t i = 0; i < 9; ++i) {
            for (const char channel : {'R', 'G', 'B'}) {
                recipe.channels[fmt::format("sh{:02}.{}", i, channel)] = [value = static_cast<float>(stored[i])](int, int) {
                    return value;
                };
            }
        }
        for (int axis = 0; axis < 3; ++axis) {
            recipe.channels[fmt::format("normal.{}", "XYZ"[axis])] = [value = static_cast<float>(normal[axis])](int, int) { return value; };
        }
        LightMapDescription description;
        description.frame = ShFrame::Tangent;
        const std::array<double, 9> expected = basis(lighting::worldFromTangentFrame(normal) * local);
        const ShRgb found = convertedTexel(description, recipe);
        for (std::size_t i = 0; i < 9; ++i)
            EXPECT_NEAR(found[i].y, expected[i], 2e-6) << i << " around " << normal.x << ' ' << normal.y << ' ' << normal.z;
        // Signs of the file are undone in the file's own frame.
        for (const char* odd : {"sh01", "sh03", "sh05", "sh07"}) {
            for (const char channel : {'R', 'G', 'B'}) {
                const std::string name = fmt::format("{}.{}", odd, channel);
                recipe.channels[name] = [before = recipe.channels[name]](int x, int y) { return -before(x, y); };
            }
        }
        description.phase = ShPhase::CondonShortley;
        const ShRgb unflipped = convertedTexel(description, recipe);
        for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(unflipped[i].y, expected[i], 2e-6) << i;
    }
}

TEST(Canonical, ColoursAreConvertedAndNegativeOnesCounted) {
    LightMapDescription description;
    description.colors = {"lin_rec2020", "lin_rec709", {}};
    const auto conversion = linearConversion(description.colors);
    ASSERT_TRUE(conversion);
    ExrRecipe recipe = seededMap(3, 3);
    ShRgb expected = seededTexel(1, 1);
    for (glm::vec3& coefficient : expected) coefficient = conversion->workingFromSource * coefficient;
    expectNear(convertedTexel(description, recipe), expected, 1e-6f);

    for (const auto& [x, y] : {std::pair(2, 0), std::pair(1, 2)})  // a green that Rec.709 cannot hold: red and blue go below zero
        for (int i = 0; i < 9; ++i)
            for (const char channel : {'R', 'B'}) poke(recipe, fmt::format("sh{:02}.{}", i, channel), x, y, 0.0f);
    const MapFile map(recipe);
    EXPECT_EQ(readAll(map.path, description).negativeAfterGamut, 4);
    EXPECT_EQ(readAll(map.path).negativeAfterGamut, 0);
    EXPECT_EQ(LightMapReader::open(map.path, description)->luminanceWeights(), conversion->luminanceWeights);
}

TEST(Canonical, ValuesThatLeaveFloatOnTheWayAreRefused) {
    ExrRecipe recipe = seededMap(2, 2);
    poke(recipe, "sh02.G", 1, 0, 3e38f);
    LightMapDescription description;
    description.lightUnits = LightUnits::Game;
    EXPECT_EQ(refusal(MapFile(recipe).path, description).code, ErrorCode::ValueOutOfRange);
}

TEST(Canonical, AGreyMapComesThroughExactly) {
    // The SH of a constant environment of 0.5: lambda_0 = 0.5 sqrt(4 pi), and E / pi = 0.5 at every normal.
    ExrRecipe recipe = seededMap(5, 5);
    const float dc = static_cast<float>(0.5 * std::sqrt(4 * std::numbers::pi));
    for (auto& [name, value] : recipe.channels) value = [dc, isDc = name.starts_with("sh00")](int, int) { return isDc ? dc : 0.0f; };
    const MapFile map(recipe);
    const LightMapStrip strip = readAll(map.path);
    for (const ShRgb& texel : strip.sh.texels()) {
        EXPECT_EQ(texel[0], glm::vec3(dc));
        const glm::vec3 exitRadiance = lighting::irradiance(texel, {0, 1, 0}).value / std::numbers::pi_v<float>;
        EXPECT_NEAR(exitRadiance.g, 0.5f, 1e-6f);
    }
}

}  // namespace
}  // namespace lightcook::formats
