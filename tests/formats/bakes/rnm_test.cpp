#include "formats/bakes/rnm.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "lighting/sphere.h"
#include "tests/formats/light_map_fixture.h"
#include "tests/formats/surface_fixture.h"

namespace lightcook::formats {
namespace {

using glm::dvec3;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kRnmSide = 16, kHemisphere = 4000;
using Nine = std::array<double, 9>;

/// The basis of Half-Life 2, in (tangent, down the picture, normal).
const std::array<dvec3, 3> kBasis = {dvec3(std::sqrt(2.0 / 3), 0, 1 / std::sqrt(3.0)),
                                     dvec3(-1 / std::sqrt(6.0), 1 / std::sqrt(2.0), 1 / std::sqrt(3.0)),
                                     dvec3(-1 / std::sqrt(6.0), -1 / std::sqrt(2.0), 1 / std::sqrt(3.0))};

/// Returns the weights of the three maps for a normal in tangent space, as the shaders compute them.
dvec3 weightsOf(const dvec3& normal, bool isSource) {
    dvec3 weights;
    for (int i = 0; i < 3; ++i) weights[i] = std::max(0.0, glm::dot(kBasis[static_cast<std::size_t>(i)], normal));
    if (!isSource) return weights;
    weights *= weights;
    return weights / (weights.x + weights.y + weights.z);
}

/// Exit radiance of a white surface of each coefficient: Y of bands 0 to 2, times 1, 2/3, 1/4, written out.
Nine shownBy(const dvec3& n) {
    const double first = std::sqrt(1 / (4 * std::numbers::pi)), linear = 2.0 / 3 * std::sqrt(3 / (4 * std::numbers::pi)),
                 quadratic = 0.25 * std::sqrt(15 / (4 * std::numbers::pi));
    return {first,
            linear * n.y,
            linear * n.z,
            linear * n.x,
            quadratic * n.x * n.y,
            quadratic * n.y * n.z,
            quadratic * (3 * n.z * n.z - 1) / (2 * std::sqrt(3.0)),
            quadratic * n.x * n.z,
            quadratic * (n.x * n.x - n.y * n.y) / 2};
}

/// Solves the symmetric system of least squares over the hemisphere with one equation kept exactly, by elimination.
Nine bestFor(int map, bool isSource) {
    std::array<std::array<double, 11>, 10> a{};
    for (int k = 0; k < kHemisphere; ++k) {
        const dvec3 n = lighting::fibonacciHemisphere(k, kHemisphere);
        const Nine row = shownBy(n);
        for (std::size_t i = 0; i < 9; ++i) {
            for (std::size_t j = 0; j < 9; ++j) a[i][j] += row[i] * row[j] / kHemisphere;
            a[i][10] += row[i] * weightsOf(n, isSource)[map] / kHemisphere;
        }
    }
    const Nine own = shownBy(dvec3(0, 0, 1));
    for (std::size_t i = 0; i < 9; ++i) a[i][9] = a[9][i] = own[i];
    a[9][10] = weightsOf(dvec3(0, 0, 1), isSource)[map];
    for (std::size_t column = 0; column < 10; ++column) {
        std::size_t pivot = column;
        for (std::size_t row = column; row < 10; ++row)
            if (std::abs(a[row][column]) > std::abs(a[pivot][column])) pivot = row;
        std::swap(a[pivot], a[column]);
        for (std::size_t row = 0; row < 10; ++row) {
            if (row == column) continue;
            const double factor = a[row][column] / a[column][column];
            for (std::size_t i = column; i < 11; ++i) a[row][i] -= factor * a[column][i];
        }
    }
    Nine out{};
    for (std::size_t i = 0; i < 9; ++i) out[i] = a[i][10] / a[i][i];
    return out;
}

double stored(int map, int c, int x, int y) {
    return 0.5 * static_cast<double>(seededSh(0, c, (x + 5 * map) % kRnmSide, y)) * (map == 1 ? 3 : 1);
}

void writeMaps(const TemporaryFolder& folder, int height = kRnmSide) {
    for (int map = 0; map < 3; ++map) {
        ExrRecipe recipe;
        recipe.width = kRnmSide;
        recipe.height = map == 2 ? height : kRnmSide;
        for (int c = 0; c < 3; ++c)
            recipe.channels[std::string(1, "RGB"[c])] = [map, c](int x, int y) { return static_cast<float>(stored(map, c, x, y)); };
        writeRecipe(folder / fmt::format("room_RNM{}.exr", map), recipe);
    }
}

LightMapDescription onMesh(const TemporaryFolder& folder, std::string bake) {
    LightMapDescription description;
    description.bake = std::move(bake);
    description.mesh = folder / "square.glb";
    return description;
}

struct Engine {
    const char* bake;
    bool isSource;
    double most;  ///< RMS of what nine coefficients leave over the hemisphere, of the brightest map
};
class Rnm : public testing::TestWithParam<Engine> {};

/// The square's picture is turned and mirrored, so that a frame of the wrong hand or axis shows.
TEST_P(Rnm, ATexelIsTheNearestLightToWhatTheShaderShows) {
    const auto& [bake, isSource, most] = GetParam();
    const TemporaryFolder folder;
    writeMaps(folder);
    writeSquare(folder / "square.glb", {.texture = glm::mat2(0, 1, 1, 0)});
    const LightMapStrip strip = readAll(folder / "room_RNM0.exr", onMesh(folder, bake));
    ASSERT_EQ(strip.sh.height(), kRnmSide);
    // u = z and v = x: the tangent is z, down the picture is x.
    const glm::dmat3 worldFromTangents(dvec3(0, 0, 1), dvec3(1, 0, 0), dvec3(0, 1, 0));
    std::array<Nine, 3> best;
    for (int map = 0; map < 3; ++map) best[static_cast<std::size_t>(map)] = bestFor(map, isSource);
    double squares = 0, count = 0;
    for (int y = 0; y < kRnmSide; ++y)
        for (int x = 0; x < kRnmSide; ++x)
            for (int c = 0; c < 3; ++c) {
                ASSERT_EQ(strip.covered.at(x, y), 1);
                const auto shown = [&](const dvec3& n) {
                    const Nine row = shownBy(worldFromTangents * n);
                    double sum = 0;
                    for (std::size_t i = 0; i < 9; ++i) sum += row[i] * static_cast<double>(strip.sh.at(x, y)[i][c]);
                    return sum;
                };
                const dvec3 maps(stored(0, c, x, y), stored(1, c, x, y), stored(2, c, x, y));
                const double brightest = std::max({maps.x, maps.y, maps.z});
                const dvec3 own(0, 0, 1);
                ASSERT_NEAR(shown(own), glm::dot(weightsOf(own, isSource), maps), 1e-3 * brightest);
                for (int k = 0; k < 40; ++k) {
                    const dvec3 n = lighting::fibonacciHemisphere(k, 40);
                    double nearest = 0;
                    const Nine row = shownBy(n);
                    for (int map = 0; map < 3; ++map)
                        for (std::size_t i = 0; i < 9; ++i) nearest += maps[map] * row[i] * best[static_cast<std::size_t>(map)][i];
                    ASSERT_NEAR(shown(n), nearest, 1e-3 * brightest) << x << ' ' << y << ' ' << k;
                    squares += std::pow((shown(n) - glm::dot(weightsOf(n, isSource), maps)) / brightest, 2);
                    ++count;
                }
            }
    EXPECT_LT(std::sqrt(squares / count), most);
}
INSTANTIATE_TEST_SUITE_P(All, Rnm, testing::Values(Engine{"bakery-rnm", false, 0.06}, Engine{"source-rnm", true, 0.08}),
                         [](const auto& each) { return each.param.isSource ? "Source" : "Bakery"; });

TEST(Rnm, EvenLightStaysEvenInSource) {
    const TemporaryFolder folder;
    for (int map = 0; map < 3; ++map) {
        ExrRecipe recipe;
        for (const char* colour : {"R", "G", "B"}) recipe.channels[colour] = [](int, int) { return 0.5f; };
        writeRecipe(folder / fmt::format("room_RNM{}.exr", map), recipe);
    }
    writeSquare(folder / "square.glb", {});
    const LightMapStrip strip = readAll(folder / "room_RNM1.exr", onMesh(folder, "source-rnm"));
    for (const dvec3& n : {dvec3(0, 1, 0), dvec3(1, 0, 0), glm::normalize(dvec3(-1, 2, 3))}) {
        double shown = 0;
        for (std::size_t i = 0; i < 9; ++i) shown += shownBy(n)[i] * static_cast<double>(strip.sh.at(2, 3)[i].g);
        EXPECT_NEAR(shown, 0.5, 1e-5);
    }
}

/// The sum of the three is positive at every normal: only the file tells.
TEST(Rnm, ANegativeNumberOfOneFileIsRefusedOrRepaired) {
    const TemporaryFolder folder;
    const auto write = [&](float second) {
        for (int map = 0; map < 3; ++map) {
            ExrRecipe recipe;
            for (const char* colour : {"R", "G", "B"}) recipe.channels[colour] = [](int, int) { return 0.5f; };
            if (map == 1) poke(recipe, "G", 2, 3, second);
            writeRecipe(folder / fmt::format("room_RNM{}.exr", map), recipe);
        }
    };
    writeSquare(folder / "square.glb", {});
    write(-0.25f);
    LightMapDescription description = onMesh(folder, "bakery-rnm");
    const Error error = refusal(folder / "room_RNM0.exr", description);
    EXPECT_EQ(error.code, ErrorCode::ValueOutOfRange);
    EXPECT_THAT(error.line(), HasSubstr("room_RNM1.exr, channel G, texel (2, 3): found -0.25, expected no negative energy"));
    description.repair = true;
    const LightMapStrip repaired = readAll(folder / "room_RNM0.exr", description);
    EXPECT_EQ(repaired.repairs.negativeDc, 1);
    for (const float harmless : {0.0f, -1e-7f}) {
        write(harmless);
        const LightMapStrip dark = readAll(folder / "room_RNM0.exr", onMesh(folder, "bakery-rnm"));
        EXPECT_EQ(dark.sh.at(2, 3), repaired.sh.at(2, 3)) << "the other two files keep their light";
    }
    EXPECT_GT(repaired.sh.at(2, 3)[0].g, 0);
}

TEST(Rnm, NamesOfFilesIdentifyBakeryWhichNeedsAMesh) {
    const TemporaryFolder folder;
    writeMaps(folder);
    writeSquare(folder / "square.glb", {.lightMap = {0.5f, 1}});
    const auto reader = LightMapReader::open(folder / "room_RNM0.exr", onMesh(folder, std::string(kAutoBake)));
    ASSERT_TRUE(reader) << reader.error().line();
    EXPECT_EQ(reader->bake(), "bakery-rnm");
    EXPECT_TRUE(reader->recognition().isCertain);
    EXPECT_TRUE(reader->hasNormals() && reader->hasCoverage());
    const auto strip = reader->read(0, kRnmSide);
    ASSERT_TRUE(strip) << strip.error().line();
    EXPECT_EQ(strip->covered.at(3, 3), 1);
    EXPECT_EQ(strip->covered.at(12, 3), 0) << "no surface";
    EXPECT_EQ(strip->normal.at(3, 3), glm::vec3(0, 1, 0));

    const Error without = refusal(folder / "room_RNM0.exr");
    EXPECT_EQ(without.code, ErrorCode::InvalidRequest);
    EXPECT_THAT(without.line(), AllOf(HasSubstr("found bake format bakery-rnm without a mesh"), HasSubstr("mesh = \"FILE\" (--mesh)")));
    const auto known = LightMapReader::recognize(folder / "room_RNM0.exr", {});
    ASSERT_TRUE(known);
    EXPECT_EQ(known->format->name, "bakery-rnm");
    EXPECT_TRUE(mayNeedMesh(folder / "room_RNM0.exr", kAutoBake));
    EXPECT_FALSE(mayNeedMesh(folder / "room_RNM0.exr", "flat"));
    EXPECT_EQ(leadingFile(folder / "room_RNM2.exr", kAutoBake), folder / "room_RNM0.exr");
    EXPECT_EQ(leadingFile(folder / "room_RNM2.exr", "flat"), folder / "room_RNM2.exr");

    writeMaps(folder, kRnmSide / 2);
    EXPECT_THAT(refusal(folder / "room_RNM0.exr", onMesh(folder, "bakery-rnm")).line(),
                AllOf(HasSubstr("room_RNM2.exr"), HasSubstr("found 16 x 8 texels, expected 16 x 16")));
    std::filesystem::remove(folder / "room_RNM2.exr");
    EXPECT_THAT(refusal(folder / "room_RNM0.exr", onMesh(folder, "source-rnm")).line(),
                HasSubstr("found 2 of the 3 files of bake format source-rnm, room_RNM2 (.exr, .hdr, .tga or .png) is missing"));
}

}  // namespace
}  // namespace lightcook::formats
