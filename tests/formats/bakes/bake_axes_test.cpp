#include "formats/bake_axes.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <string>

#include "tests/formats/light_map_fixture.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/surface_fixture.h"

namespace lightcook::formats {
namespace {

using glm::dvec3;
using testing::AllOf;
using testing::HasSubstr;

TEST(BakeAxes, EachChoiceHasANameThatReadsBack) {
    std::set<std::string> names;
    for (int index = 0; index < BakeAxes::kChoices; ++index) {
        const std::string name = BakeAxes::choice(index).name();
        EXPECT_TRUE(names.insert(name).second) << name;
        const auto read = BakeAxes::fromName(name);
        ASSERT_TRUE(read) << name;
        EXPECT_EQ(read->index(), index) << name;
        const dvec3 vector(1, 2, 3);
        EXPECT_EQ(BakeAxes::choice(index).inverse()(BakeAxes::choice(index)(vector)), vector) << name;
    }
    EXPECT_EQ(BakeAxes().name(), "x,y,z");
    EXPECT_EQ(BakeAxes::fromName(" x, -z , y")->name(), "x,-z,y");
    EXPECT_EQ(BakeAxes::choice(BakeAxes::kPhaseChoice).name(), "-x,-y,z");
}

TEST(BakeAxes, OthersThanSignedPermutationsAreRefused) {
    for (const char* text :
         {"", "x", "x,y", "x,y,z,x", "x,y,x", "-x,-x,z", "x,y,w", "x;y;z", "+x,y,z", "--x,y,z", "X,y,z", "x,,z", "x y z"})
        EXPECT_FALSE(BakeAxes::fromName(text)) << text;
}

TEST(BakeAxes, OneAfterTheOther) {
    const BakeAxes upright = *BakeAxes::fromName("x,z,-y"), mirrored = *BakeAxes::fromName("-x,y,z");
    EXPECT_TRUE(upright.isRotation());
    EXPECT_FALSE(mirrored.isRotation());
    EXPECT_EQ(upright(dvec3(0, 0, 1)), dvec3(0, 1, 0)) << "z up becomes y up";
    EXPECT_EQ(upright.then(mirrored).name(), "-x,z,-y");
    EXPECT_EQ(upright.then(upright.inverse()).name(), "x,y,z");
}

/// A turn of a file's vectors, written out.
struct Turn {
    const char* name;
    dvec3 (*meshFromFile)(const dvec3&);
};
const std::array<Turn, 4> kTurns = {{{"-x,y,z", [](const dvec3& v) { return dvec3(-v.x, v.y, v.z); }},
                                     {"x,z,-y", [](const dvec3& v) { return dvec3(v.x, v.z, -v.y); }},
                                     {"-y,z,x", [](const dvec3& v) { return dvec3(-v.y, v.z, v.x); }},
                                     {"z,-x,-y", [](const dvec3& v) { return dvec3(v.z, -v.x, -v.y); }}}};

/// Radiance of order 2 that no turn leaves as it is, at least 0.3.
double radianceOf(int colour, const dvec3& w) {
    return 2 + 0.1 * colour + 0.5 * w.x - 0.3 * w.y + 0.2 * w.z + 0.25 * w.x * w.y - 0.15 * w.y * w.z + 0.1 * w.x * w.z + 0.2 * w.z * w.z -
           0.1 * w.x * w.x;
}

/// The nine functions, written out.
std::array<double, 9> basisOf(const dvec3& w) {
    const double first = std::sqrt(3 / (4 * std::numbers::pi)), second = std::sqrt(15 / (4 * std::numbers::pi));
    return {1 / std::sqrt(4 * std::numbers::pi),
            first * w.y,
            first * w.z,
            first * w.x,
            second * w.x * w.y,
            second * w.y * w.z,
            second / (2 * std::sqrt(3.0)) * (3 * w.z * w.z - 1),
            second * w.x * w.z,
            second / 2 * (w.x * w.x - w.y * w.y)};
}

/// Sums a function over directions that cover the sphere evenly.
template <class Visit>
void overSphere(Visit visit) {
    constexpr int kCount = 20000;
    for (int i = 0; i < kCount; ++i) {
        const double z = 1 - (2 * i + 1.0) / kCount, phi = i * std::numbers::pi * (3 - std::sqrt(5.0)), r = std::sqrt(1 - z * z);
        visit(dvec3(r * std::cos(phi), r * std::sin(phi), z), 4 * std::numbers::pi / kCount);
    }
}

/// The map of that radiance in the axes of a file, with a normal in these.
ExrRecipe mapOfRadiance(const dvec3& normal) {
    ExrRecipe recipe;
    recipe.width = recipe.height = 2;
    for (int c = 0; c < 3; ++c) {
        std::array<double, 9> sh{};
        overSphere([&](const dvec3& w, double solidAngle) {
            const auto basis = basisOf(w);
            for (std::size_t i = 0; i < 9; ++i) sh[i] += radianceOf(c, w) * basis[i] * solidAngle;
        });
        for (std::size_t i = 0; i < 9; ++i)
            recipe.channels[fmt::format("sh{:02}.{}", i, "RGB"[c])] = [value = static_cast<float>(sh[i])](int, int) { return value; };
        recipe.channels[fmt::format("normal.{}", "XYZ"[c])] = [value = static_cast<float>(normal[c])](int, int) { return value; };
    }
    return recipe;
}

TEST(BakeAxes, RadianceAndNormalsTurnIntoTheAxesOfTheMesh) {
    const dvec3 normal = glm::normalize(dvec3(3, -1, 2));
    const MapFile map(mapOfRadiance(normal));
    for (const Turn& turn : kTurns) {
        LightMapDescription description;
        description.axes = *BakeAxes::fromName(turn.name);
        const LightMapStrip strip = readAll(map.path, description);
        const lighting::ShRgb& sh = strip.sh.at(1, 1);
        double largest = 0;
        overSphere([&](const dvec3& w, double) {
            const auto basis = basisOf(turn.meshFromFile(w));
            for (int c = 0; c < 3; ++c) {
                double found = 0;
                for (std::size_t i = 0; i < 9; ++i) found += static_cast<double>(sh[i][c]) * basis[i];
                largest = std::max(largest, std::abs(found - radianceOf(c, w)));
            }
        });
        EXPECT_LT(largest, 1e-3) << turn.name << ", of radiance up to 3";
        EXPECT_LT(glm::distance(dvec3(strip.normal.at(1, 1)), turn.meshFromFile(normal)), 1e-6) << turn.name;
    }
}

/// Shaders of engines take light and normals in axes of their own.
TEST(BakeAxes, OutputAxesTurnLightAndNormalsAfterAllElse) {
    const MapFile map(mapOfRadiance(glm::normalize(dvec3(3, -1, 2))));
    for (const Turn& turn : kTurns) {
        LightMapDescription toMesh, toMeshAndBack;
        toMesh.outputAxes = toMeshAndBack.axes = *BakeAxes::fromName(turn.name);
        toMeshAndBack.outputAxes = toMeshAndBack.axes.inverse();
        LightMapDescription byAxes;
        byAxes.axes = toMesh.outputAxes;
        const auto expectSame = [&](const LightMapDescription& a, const LightMapDescription& b) {
            const LightMapStrip found = readAll(map.path, a), expected = readAll(map.path, b);
            for (std::size_t i = 0; i < 9; ++i)
                EXPECT_LT(glm::distance(found.sh.at(1, 0)[i], expected.sh.at(1, 0)[i]), 1e-5f) << turn.name << ", coefficient " << i;
            EXPECT_LT(glm::distance(found.normal.at(1, 0), expected.normal.at(1, 0)), 1e-6f) << turn.name;
        };
        expectSame(toMesh, byAxes);
        expectSame(toMeshAndBack, {});
        // Frames are those of the normals in the file.
        toMeshAndBack.frame = ShFrame::Tangent;
        LightMapDescription tangent;
        tangent.frame = ShFrame::Tangent;
        expectSame(toMeshAndBack, tangent);
    }
}

/// Coefficients about each normal are turned to the world of the file by the normal of the file, and with it to that of the mesh.
TEST(BakeAxes, TangentFramesAreThoseOfTheNormalsInTheFile) {
    const MapFile map(mapOfRadiance(glm::normalize(dvec3(3, -1, 2))));
    LightMapDescription description;
    description.frame = ShFrame::Tangent;
    const lighting::ShRgb inFile = readAll(map.path, description).sh.at(0, 0);
    for (const Turn& turn : kTurns) {
        description.axes = *BakeAxes::fromName(turn.name);
        const lighting::ShRgb sh = readAll(map.path, description).sh.at(0, 0);
        for (const dvec3& w : kShadedNormals) {
            const auto before = basisOf(w), after = basisOf(turn.meshFromFile(w));
            double expected = 0, found = 0;
            for (std::size_t i = 0; i < 9; ++i) {
                expected += static_cast<double>(inFile[i].g) * before[i];
                found += static_cast<double>(sh[i].g) * after[i];
            }
            EXPECT_NEAR(found, expected, 1e-5) << turn.name;
        }
    }
}

TEST(BakeAxes, NormalsOfTheMeshStay) {
    ExrRecipe recipe = mapOfRadiance(dvec3(0, 0, 1));
    for (const char axis : {'X', 'Y', 'Z'}) recipe.channels.erase(fmt::format("normal.{}", axis));
    const MapFile map(recipe);
    writeSquare(map.folder / "square.glb", {});
    LightMapDescription description;
    description.mesh = map.folder / "square.glb";
    description.axes = *BakeAxes::fromName("x,z,-y");
    EXPECT_EQ(readAll(map.path, description).normal.at(0, 0), glm::vec3(0, 1, 0));
    description.outputAxes = *BakeAxes::fromName("x,z,-y");
    EXPECT_EQ(readAll(map.path, description).normal.at(0, 0), glm::vec3(0, 0, -1)) << "but for the shader that reads them";
}

/// q3map2 writes directions with z up. They are compared with normals of the mesh before they become coefficients.
TEST(BakeAxes, DirectionsBesideAMeshTurnToo) {
    constexpr int kSide = 4;
    const TemporaryFolder folder;
    writeSquare(folder / "square.glb", {});
    const auto light = [](int c, int x, int y) { return 90 + 20 * c + 10 * x + 5 * y; };
    const auto direction = [](int x, int y) { return glm::normalize(dvec3(1 + x, 2 + y, -1.5)); };
    const auto write = [&](const std::string& stem, const std::function<dvec3(const dvec3&)>& inFile) {
        writePng(folder / (stem + ".png"), kSide, kSide, 3, light);
        writePng(folder / (stem + "_deluxe.png"), kSide, kSide, 3,
                 [&](int c, int x, int y) { return static_cast<int>(std::lround(255 * (0.5 * inFile(direction(x, y))[c] + 0.5))); });
    };
    write("mesh", [](const dvec3& v) { return v; });
    write("quake", [](const dvec3& v) { return dvec3(v.x, -v.z, v.y); });
    LightMapDescription description;
    description.mesh = folder / "square.glb";
    description.encoding = LightEncoding::Srgb;
    const LightMapStrip expected = readAll(folder / "mesh.png", description);
    description.axes = *BakeAxes::fromName("x,z,-y");
    const LightMapStrip found = readAll(folder / "quake.png", description);
    double largest = 0;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            EXPECT_EQ(found.normal.at(x, y), glm::vec3(0, 1, 0));
            for (std::size_t i = 0; i < 9; ++i)
                largest = std::max(largest, glm::length(dvec3(found.sh.at(x, y)[i]) - dvec3(expected.sh.at(x, y)[i])));
        }
    EXPECT_LT(largest, 0.05) << "directions of 8 bits";
    EXPECT_GT(glm::length(dvec3(expected.sh.at(2, 2)[3])), 0.1) << "light with a direction";
}

TEST(BakeAxes, LightRelativeToSurfacesHasNone) {
    const TemporaryFolder folder;
    writeSquare(folder / "square.glb", {});
    ExrRecipe recipe;
    recipe.width = recipe.height = 2;
    for (const char* colour : {"R", "G", "B"}) recipe.channels[colour] = [](int, int) { return 0.5f; };
    for (const char* part : {"RNM0", "RNM1", "RNM2"}) writeRecipe(folder / fmt::format("map_{}.exr", part), recipe);
    LightMapDescription description;
    description.bake = "source-rnm";
    description.mesh = folder / "square.glb";
    description.axes = *BakeAxes::fromName("-x,y,z");
    EXPECT_THAT(refusal(folder / "map_RNM0.exr", description).line(),
                AllOf(HasSubstr("axes: found \"-x,y,z\" for bake format source-rnm"), HasSubstr("relative to the surfaces of the mesh")));
}

}  // namespace
}  // namespace lightcook::formats
