#include "formats/environment.h"

#include <OpenEXR/ImfEnvmap.h>
#include <OpenEXR/ImfThreading.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <map>

#include "lighting/cube.h"
#include "lighting/sphere.h"
#include "tests/formats/exr_fixture.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/temporary_folder.h"
#include "tests/formats/texture_fixture.h"

namespace lightcook::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;

ExrRecipe colored(int width, int height) {
    ExrRecipe recipe;
    recipe.width = width;
    recipe.height = height;
    recipe.channels["R"] = [](int x, int y) { return static_cast<float>(x + 1000 * y); };
    recipe.channels["G"] = [](int x, int y) { return static_cast<float>(2 * x + y) + 0.5f; };
    recipe.channels["B"] = [](int, int) { return 0.25f; };
    return recipe;
}

/// Any image format that OpenImageIO chooses by the extension.
void writeImage(const std::filesystem::path& file, int width, int height, int channelCount, const std::vector<float>& values,
                OIIO::TypeDesc type = OIIO::TypeDesc::FLOAT) {
    const auto output = OIIO::ImageOutput::create(file.string());
    ASSERT_TRUE(output) << OIIO::geterror();
    ASSERT_TRUE(output->open(file.string(), OIIO::ImageSpec(width, height, channelCount, type)));
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()));
    ASSERT_TRUE(output->close());
}

std::vector<float> constant(int texelCount, const glm::vec3& color) {
    std::vector<float> values;
    for (int i = 0; i < texelCount; ++i) values.insert(values.end(), {color.r, color.g, color.b});
    return values;
}

Error refusal(const std::filesystem::path& file, const EnvironmentOptions& options = {}) {
    const auto loaded = loadEnvironment(file, options);
    EXPECT_FALSE(loaded);
    if (loaded) return {};
    EXPECT_EQ(loaded.error().line().find('\n'), std::string::npos);
    EXPECT_THAT(loaded.error().line(), AllOf(HasSubstr(file.filename().string()), HasSubstr("found"), HasSubstr("expected")));
    return loaded.error();
}

TEST(LoadEnvironment, ThePanoramaKeepsEveryTexel) {
    const TemporaryFolder folder;
    for (const bool isTiled : {false, true}) {
        ExrRecipe recipe = colored(16, 8);
        recipe.isTiled = isTiled;
        recipe.channels["A"] = [](int, int) { return 0.5f; };  // of no consequence
        writeRecipe(folder / "sky.exr", recipe);
        const auto loaded = loadEnvironment(folder / "sky.exr", {});
        ASSERT_TRUE(loaded) << loaded.error().line();
        EXPECT_EQ(loaded->environment.projection, Environment::Projection::Equirectangular);
        for (int y = 0; y < 8; ++y) {
            for (int x = 0; x < 16; ++x) {
                const glm::vec3 expected(x + 1000 * y, static_cast<float>(2 * x + y) + 0.5f, 0.25f);
                ASSERT_EQ(loaded->environment.texels.at(x, y), expected) << x << ' ' << y;
            }
        }
    }
}

TEST(LoadEnvironment, StartsNoThreadsThatLightMapsWouldQueueFor) {
    const TemporaryFolder folder;
    writeRecipe(folder / "sky.exr", colored(16, 8));
    ASSERT_TRUE(loadEnvironment(folder / "sky.exr", {}));
    EXPECT_EQ(Imf::globalThreadCount(), 0);
}

TEST(LoadEnvironment, ChannelsAreFoundByNameAmongOthers) {
    const TemporaryFolder folder;
    ExrRecipe recipe = colored(4, 2);
    recipe.channels["H"] = recipe.channels["C"] = recipe.channels["depth.Z"] = [](int, int) { return -7.0f; };
    writeRecipe(folder / "sky.exr", recipe);
    const auto loaded = loadEnvironment(folder / "sky.exr", {});
    ASSERT_TRUE(loaded) << loaded.error().line();
    EXPECT_EQ(loaded->environment.texels.at(3, 1), glm::vec3(1003, 7.5f, 0.25f));
}

TEST(LoadEnvironment, StripsOfFacesEndUpFromTopToBottom) {
    const TemporaryFolder folder;
    writeRecipe(folder / "vertical.exr", colored(4, 24));
    const auto vertical = loadEnvironment(folder / "vertical.exr", {});
    ASSERT_TRUE(vertical) << vertical.error().line();
    EXPECT_EQ(vertical->environment.projection, Environment::Projection::CubeStrip);
    EXPECT_EQ(vertical->environment.texels.at(1, 23).r, 23001.0f);

    writeRecipe(folder / "horizontal.exr", colored(24, 4));
    const auto horizontal = loadEnvironment(folder / "horizontal.exr", {});
    ASSERT_TRUE(horizontal) << horizontal.error().line();
    ASSERT_EQ(horizontal->environment.texels.height(), 24);
    for (int face = 0; face < 6; ++face)
        EXPECT_EQ(horizontal->environment.texels.at(3, 4 * face + 2).r, 2000.0f + 4.0f * face + 3.0f) << face;
}

/// A face of a paper cube: where it looks, and where its image's right and lower edges point. Folding knows nothing of the table in
/// lighting/cube.h: the next cell to the right of a face looks where that face's right edge points, and so on.
struct Folded {
    glm::dvec3 normal, right, down;
    Folded toTheRight() const { return {right, -normal, down}; }
    Folded toTheLeft() const { return {-right, normal, down}; }
    Folded below() const { return {down, right, -normal}; }
    Folded above() const { return {-down, right, normal}; }
    glm::vec3 lightAt(double u, double v) const { return glm::vec3(glm::normalize(normal + u * right + v * down) * 0.4 + 0.5); }
};
const Folded kFront{{0, 0, 1}, {1, 0, 0}, {0, -1, 0}};

/// Every texel holds its direction; unused cells hold values that would be refused.
ExrRecipe crossOf(int size, const std::map<std::pair<int, int>, Folded>& cells) {
    ExrRecipe recipe;
    recipe.width = recipe.height = 0;
    for (const auto& [cell, face] : cells) {
        recipe.width = std::max(recipe.width, size * (cell.first + 1));
        recipe.height = std::max(recipe.height, size * (cell.second + 1));
    }
    for (int channel = 0; channel < 3; ++channel) {
        recipe.channels[std::string(1, "RGB"[channel])] = [=](int x, int y) {
            const auto found = cells.find({x / size, y / size});
            if (found == cells.end()) return std::numeric_limits<float>::quiet_NaN();
            return found->second.lightAt((2.0 * (x % size) + 1) / size - 1, (2.0 * (y % size) + 1) / size - 1)[channel];
        };
    }
    return recipe;
}

void expectDirections(const std::filesystem::path& file, int size) {
    const auto loaded = loadEnvironment(file, {});
    ASSERT_TRUE(loaded) << loaded.error().line();
    EXPECT_EQ(loaded->environment.projection, Environment::Projection::CubeStrip);
    const Image<glm::vec3>& texels = loaded->environment.texels;
    ASSERT_EQ(texels.width(), size);
    ASSERT_EQ(texels.height(), 6 * size);
    for (int y = 0; y < 6 * size; ++y) {
        for (int x = 0; x < size; ++x) {
            const glm::vec3 expected(lighting::cubeTexelDirection(y / size, x, y % size, size) * 0.4 + 0.5);
            ASSERT_LT(glm::distance(texels.at(x, y), expected), 1e-6f) << "face " << y / size << " texel " << x << ' ' << y % size;
        }
    }
}

TEST(LoadEnvironment, ACrossThatLiesFoldsIntoACube) {
    const TemporaryFolder folder;
    const Folded right = kFront.toTheRight();
    writeRecipe(folder / "cross.exr", crossOf(3, {{{1, 1}, kFront},
                                                  {{2, 1}, right},
                                                  {{3, 1}, right.toTheRight()},
                                                  {{0, 1}, kFront.toTheLeft()},
                                                  {{1, 0}, kFront.above()},
                                                  {{1, 2}, kFront.below()}}));
    expectDirections(folder / "cross.exr", 3);
}

TEST(LoadEnvironment, ACrossThatStandsFoldsIntoACube) {
    const TemporaryFolder folder;
    writeRecipe(folder / "cross.exr", crossOf(5, {{{1, 1}, kFront},
                                                  {{2, 1}, kFront.toTheRight()},
                                                  {{0, 1}, kFront.toTheLeft()},
                                                  {{1, 0}, kFront.above()},
                                                  {{1, 2}, kFront.below()},
                                                  {{1, 3}, kFront.below().below()}}));
    expectDirections(folder / "cross.exr", 5);
}

TEST(LoadEnvironment, SixFilesAreFoundBesideAnyOfThem) {
    const TemporaryFolder folder;
    const std::array<Folded, 6> faces = {
        kFront.toTheRight(), kFront.toTheLeft(), kFront.above(), kFront.below(), kFront, kFront.toTheRight().toTheRight()};
    const std::array<std::array<const char*, 6>, 2> names = {
        {{"px", "nx", "py", "ny", "pz", "nz"}, {"sky_posx", "sky_negx", "sky_posy", "sky_negy", "sky_posz", "sky_negz"}}};
    for (const auto& set : names) {
        for (std::size_t face = 0; face < 6; ++face)
            writeRecipe(folder / (std::string(set[face]) + ".exr"), crossOf(4, {{{0, 0}, faces[face]}}));
        for (std::size_t face = 0; face < 6; ++face) expectDirections(folder / (std::string(set[face]) + ".exr"), 4);
    }
    ExrRecipe bad = crossOf(4, {{{0, 0}, faces[3]}});
    poke(bad, "G", 2, 1, -1);
    writeRecipe(folder / "ny.exr", bad);
    EXPECT_THAT(loadEnvironment(folder / "px.exr", {}).error().line(), AllOf(HasSubstr("ny.exr"), HasSubstr("texel (2, 1)")));
    writeRecipe(folder / "ny.exr", crossOf(2, {{{0, 0}, faces[3]}}));
    EXPECT_THAT(loadEnvironment(folder / "px.exr", {}).error().line(), AllOf(HasSubstr("ny.exr"), HasSubstr("expected 4 x 4")));
    std::filesystem::remove(folder / "ny.exr");
    EXPECT_EQ(loadEnvironment(folder / "px.exr", {}).error().code, ErrorCode::FileUnreadable);
    EXPECT_THAT(loadEnvironment(folder / "px.exr", {}).error().line(),
                HasSubstr("ny.exr: found no such file, expected it: by its name the square image px.exr is one of six faces"));
    EXPECT_TRUE(faceFiles("panorama.hdr").empty());
}

TEST(LoadEnvironment, OtherShapesAndChannelsAreRefused) {
    const TemporaryFolder folder;
    writeRecipe(folder / "square.exr", colored(8, 8));
    EXPECT_EQ(refusal(folder / "square.exr").code, ErrorCode::WrongShape);
    EXPECT_THAT(refusal(folder / "square.exr").detail,
                HasSubstr("found 8 x 8 texels, expected 2:1 (equirectangular), 1:6 or 6:1 (six cube faces), 4:3 or 3:4"));
    ExrRecipe grey = colored(8, 4);
    grey.channels = {{"Y", grey.channels["R"]}};
    writeRecipe(folder / "grey.exr", grey);
    const auto ofGrey = loadEnvironment(folder / "grey.exr", {});
    ASSERT_TRUE(ofGrey) << ofGrey.error().line();
    EXPECT_EQ(ofGrey->environment.texels.at(3, 2), glm::vec3(2003));
    ExrRecipe two = colored(8, 4);
    two.channels.erase("B");
    writeRecipe(folder / "two.exr", two);
    EXPECT_THAT(refusal(folder / "two.exr").detail, HasSubstr("found the channels G, R, expected R, G and B, or Y for grey"));
}

/// Light that differs in every direction, and has no symmetry.
glm::vec3 lightToward(const glm::dvec3& d) {
    return glm::vec3(2 + 1.6 * d.x + 0.4 * d.x * d.y, 2 + 1.6 * d.y + 0.4 * d.y * d.z, 2 + 1.6 * d.z + 0.4 * d.z * d.x);
}

/// Writes an environment whose texels are at the places that OpenEXR's library gives them.
void writeExrEnvironment(const std::filesystem::path& file, int width, int height, ExrEnvironment environment) {
    const Imath::Box2i window({0, 0}, {width - 1, height - 1});
    Image<glm::vec3> texels(width, height);
    const auto put = [&](const Imath::V2f& place, const Imath::V3f& direction) {
        texels.at(static_cast<int>(std::lround(place.x)), static_cast<int>(std::lround(place.y))) =
            lightToward(glm::normalize(glm::dvec3(direction.x, direction.y, direction.z)));
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Imath::V2f place(static_cast<float>(x), static_cast<float>(environment == ExrEnvironment::Cube ? y % width : y));
            if (environment == ExrEnvironment::LatLong) {
                put(place, Imf::LatLongMap::direction(window, place));
            } else {
                const auto face = static_cast<Imf::CubeMapFace>(y / width);
                put(Imf::CubeMap::pixelPosition(face, window, place), Imf::CubeMap::direction(face, window, place));
            }
        }
    ExrRecipe recipe;
    recipe.width = width;
    recipe.height = height;
    recipe.environment = environment;
    for (int channel = 0; channel < 3; ++channel)
        recipe.channels[std::string(1, "RGB"[channel])] = [&texels, channel](int x, int y) { return texels.at(x, y)[channel]; };
    writeRecipe(file, recipe);
}

TEST(LoadEnvironment, TheAttributeEnvmapMeansOpenExrsDirections) {
    const TemporaryFolder folder;
    constexpr int kSize = 64;
    writeExrEnvironment(folder / "cube.exr", kSize, 6 * kSize, ExrEnvironment::Cube);
    const auto cube = loadEnvironment(folder / "cube.exr", {});
    ASSERT_TRUE(cube) << cube.error().line();
    EXPECT_EQ(cube->environment.projection, Environment::Projection::CubeStrip);
    for (int y = 0; y < 6 * kSize; ++y)
        for (int x = 0; x < kSize; ++x)
            ASSERT_LT(
                glm::distance(cube->environment.texels.at(x, y), lightToward(lighting::cubeTexelDirection(y / kSize, x, y % kSize, kSize))),
                3e-3f)
                << "face " << y / kSize << " texel " << x << ' ' << y % kSize;
    writeExrEnvironment(folder / "panorama.exr", 2 * kSize, kSize, ExrEnvironment::LatLong);
    const auto panorama = loadEnvironment(folder / "panorama.exr", {});
    ASSERT_TRUE(panorama) << panorama.error().line();
    EXPECT_EQ(panorama->environment.projection, Environment::Projection::Equirectangular);
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < 2 * kSize; ++x) {
            const glm::dvec3 direction = lighting::directionFromEquirectangular({(x + 0.5) / (2 * kSize), (y + 0.5) / kSize});
            ASSERT_LT(glm::distance(panorama->environment.texels.at(x, y), lightToward(direction)), 5e-3f) << x << ' ' << y;
        }
}

TEST(LoadEnvironment, TheAttributeEnvmapNeedsItsShape) {
    const TemporaryFolder folder;
    ExrRecipe recipe = colored(16, 8);
    recipe.environment = ExrEnvironment::Cube;
    writeRecipe(folder / "a.exr", recipe);
    EXPECT_THAT(refusal(folder / "a.exr").detail,
                HasSubstr("found 16 x 8 texels with the attribute envmap \"cube\", expected 1:6 (six faces)"));
    recipe = colored(4, 24);
    recipe.environment = ExrEnvironment::LatLong;
    writeRecipe(folder / "a.exr", recipe);
    EXPECT_THAT(refusal(folder / "a.exr").detail, HasSubstr("envmap \"latlong\", expected 2:1 (a panorama)"));
}

TEST(LoadEnvironment, StatedPrimariesAreConvertedIfTheSourceIsStated) {
    const TemporaryFolder folder;
    ExrRecipe recipe = colored(16, 8);
    recipe.chromaticities = {0.713f, 0.293f, 0.165f, 0.83f, 0.128f, 0.044f, 0.32168f, 0.33767f};
    for (const char* channel : {"R", "G", "B"})
        recipe.channels[channel] = [channel](int x, int) { return 1 + static_cast<float>(x) * (channel[0] == 'R' ? 0.05f : 0.03f); };
    writeRecipe(folder / "sky.exr", recipe);
    const auto as = [&](const char* source) {
        auto loaded = loadEnvironment(folder / "sky.exr", {{source, "lin_rec709", {}}, false});
        EXPECT_TRUE(loaded) << loaded.error().line();
        return std::move(loaded->environment.texels.texels());
    };
    EXPECT_EQ(as("stated"), as("acescg"));
    EXPECT_NE(as("stated"), as("lin_rec709"));
    ExrRecipe green = recipe;  // outside the gamut of lin_rec709
    green.channels["R"] = green.channels["B"] = [](int, int) { return 0.0f; };
    writeRecipe(folder / "green.exr", green);
    EXPECT_FALSE(loadEnvironment(folder / "green.exr", {{"acescg", "lin_rec709", {}}, false}));
    const auto limited = loadEnvironment(folder / "green.exr", {{"stated", "lin_rec709", {}}, false});
    ASSERT_TRUE(limited) << limited.error().line();
    EXPECT_EQ(limited->repairedTexels, 16 * 8);
    EXPECT_EQ(limited->environment.texels.at(3, 3).r, 0);
    EXPECT_GT(limited->environment.texels.at(3, 3).g, 1);
    recipe.chromaticities.reset();
    writeRecipe(folder / "sky.exr", recipe);
    EXPECT_EQ(as("stated"), as("lin_rec709"));
    recipe.chromaticities = std::array<float, 8>{};
    writeRecipe(folder / "sky.exr", recipe);
    EXPECT_THAT(loadEnvironment(folder / "sky.exr", {{"stated", "lin_rec709", {}}, false}).error().line(),
                HasSubstr("found the primaries and white (0, 0, 0, 0, 0, 0, 0, 0), which no space has"));
}

/// An overflow of halves is light beyond them, not darkness.
TEST(LoadEnvironment, InfiniteLightIsRepairedToTheLargestHalf) {
    const TemporaryFolder folder;
    const float infinity = std::numeric_limits<float>::infinity();
    ExrRecipe recipe = colored(16, 8);
    recipe.channels["R"] = recipe.channels["G"] = [](int, int) { return 3.0f; };
    poke(recipe, "R", 5, 3, infinity);
    poke(recipe, "G", 6, 3, infinity);
    poke(recipe, "B", 6, 3, std::numeric_limits<float>::quiet_NaN());
    poke(recipe, "R", 7, 3, -infinity);
    for (const bool isHalf : {false, true}) {
        recipe.isHalf = isHalf;
        writeRecipe(folder / "sky.exr", recipe);
        const auto loaded = loadEnvironment(folder / "sky.exr", {{}, true});
        ASSERT_TRUE(loaded) << loaded.error().line();
        EXPECT_EQ(loaded->repairedTexels, 3);
        EXPECT_EQ(loaded->environment.texels.at(5, 3), glm::vec3(65504, 3, 0.25f));
        EXPECT_EQ(loaded->environment.texels.at(6, 3), glm::vec3(0));
        EXPECT_EQ(loaded->environment.texels.at(7, 3), glm::vec3(0));
    }
    recipe.isHalf = false;
    poke(recipe, "G", 1, 1, 1e6f);
    writeRecipe(folder / "sky.exr", recipe);
    EXPECT_EQ(loadEnvironment(folder / "sky.exr", {{}, true})->environment.texels.at(5, 3), glm::vec3(1e6f, 3, 0.25f));
}

TEST(LoadEnvironment, WhatIsNotLightIsRefusedWithItsTexelOrRepaired) {
    const TemporaryFolder folder;
    struct Case {
        const char* channel;
        float value;
        ErrorCode code;
        const char* found;
    };
    for (const Case& bad : {Case{"G", std::numeric_limits<float>::quiet_NaN(), ErrorCode::ValueNotFinite, "found nan"},
                            Case{"R", std::numeric_limits<float>::infinity(), ErrorCode::ValueNotFinite, "found inf"},
                            Case{"B", -0.5f, ErrorCode::ValueOutOfRange, "found -0.5"}}) {
        ExrRecipe recipe = colored(24, 4);
        poke(recipe, bad.channel, 13, 2, bad.value);
        writeRecipe(folder / "sky.exr", recipe);
        const Error error = refusal(folder / "sky.exr");
        EXPECT_EQ(error.code, bad.code);
        EXPECT_THAT(error.line(),
                    AllOf(HasSubstr(fmt::format("channel {}", bad.channel)), HasSubstr("texel (13, 2)"), HasSubstr(bad.found)));
        EnvironmentOptions repair;
        repair.repair = true;
        const auto repaired = loadEnvironment(folder / "sky.exr", repair);
        ASSERT_TRUE(repaired) << repaired.error().line();
        EXPECT_EQ(repaired->repairedTexels, 1);
        const glm::vec3 expected = std::isinf(bad.value) ? glm::vec3(65504, 28.5f, 0.25f) : glm::vec3(0);
        EXPECT_EQ(repaired->environment.texels.at(1, 3 * 4 + 2), expected) << "face 3, column 1";
    }
}

TEST(LoadEnvironment, ColoursOutsideTheWorkingGamutAreRefusedOrClamped) {
    const TemporaryFolder folder;
    writeImage(folder / "green.exr", 4, 2, 3, constant(8, {0, 1, 0}));
    EnvironmentOptions options;
    options.colors = {"lin_rec2020", "lin_rec709", {}};
    EXPECT_EQ(refusal(folder / "green.exr", options).code, ErrorCode::ValueOutOfRange);
    EXPECT_THAT(refusal(folder / "green.exr", options).line(), HasSubstr("in the working colour space"));
    options.repair = true;
    const auto repaired = loadEnvironment(folder / "green.exr", options);
    ASSERT_TRUE(repaired);
    EXPECT_EQ(repaired->repairedTexels, 8);
    EXPECT_EQ(repaired->environment.texels.at(0, 0).r, 0.0f);
    EXPECT_NEAR(repaired->environment.texels.at(0, 0).g, 1.1329f, 1e-3f);
    options.colors = {"srgb_texture", "lin_rec709", {}};
    EXPECT_EQ(refusal(folder / "green.exr", options).code, ErrorCode::ColorSpace);
}

TEST(LoadEnvironment, AConstantOfOneHalfComesThroughExactly) {
    const TemporaryFolder folder;
    for (const char* name : {"grey.exr", "grey.hdr"}) {  // 0.5 is 128 * 2^-8: RGBE holds it exactly as well
        writeImage(folder / name, 32, 16, 3, constant(512, glm::vec3(0.5f)));
        const auto loaded = loadEnvironment(folder / name, {});
        ASSERT_TRUE(loaded) << loaded.error().line();
        EXPECT_THAT(loaded->environment.texels.texels(), testing::Each(glm::vec3(0.5f))) << name;
    }
}

TEST(LoadEnvironment, RgbeAboveTheRangeOfHalfSurvives) {
    const TemporaryFolder folder;
    writeImage(folder / "sun.hdr", 16, 8, 3, constant(128, {69120.0f, 1000.0f, 3.0e7f}));
    const auto loaded = loadEnvironment(folder / "sun.hdr", {});
    ASSERT_TRUE(loaded) << loaded.error().line();
    const glm::vec3 texel = loaded->environment.texels.at(3, 3);
    const float step = 3.0e7f / 128;  // one step of the shared exponent
    EXPECT_NEAR(texel.b, 3.0e7f, step);
    EXPECT_NEAR(texel.r, 69120.0f, step);
    EXPECT_GT(texel.b, 65504.0f);
}

TEST(LoadEnvironment, UnreadableFilesAreOneLine) {
    const TemporaryFolder folder;
    EXPECT_EQ(refusal(folder / "absent.exr").code, ErrorCode::FileUnreadable);
    writeContent(folder / "text.hdr", "not a picture\nat all");
    EXPECT_EQ(refusal(folder / "text.hdr").code, ErrorCode::FileUnreadable);
    writeContent(folder / "text.exr", "not a picture\nat all");
    EXPECT_EQ(refusal(folder / "text.exr").code, ErrorCode::FileUnreadable);
    writeContent(folder / "unknown.xyz", "?");
    EXPECT_EQ(refusal(folder / "unknown.xyz").code, ErrorCode::FileUnreadable);
}

TEST(LoadEnvironment, EveryTruncatedLengthIsAnErrorAndNeverACrash) {
    const TemporaryFolder folder;
    for (const char* name : {"cut.exr", "cut.hdr"}) {
        const auto file = folder / name;
        writeImage(file, 16, 8, 3, constant(128, {1.0f, 2.0f, 3.0f}));
        for (std::size_t length = std::filesystem::file_size(file); length-- > 0;) {
            std::filesystem::resize_file(file, length);
            const Error error = refusal(file);
            ASSERT_TRUE(error.code == ErrorCode::FileUnreadable || error.code == ErrorCode::WrongShape) << name << ' ' << length;
        }
    }
}

TEST(LoadPaintedGradient, ReadsOneRowAndRefusesMore) {
    const TemporaryFolder folder;
    writeRecipe(folder / "sky.exr", colored(256, 1));
    const auto gradient = loadPaintedGradient(folder / "sky.exr", {});
    ASSERT_TRUE(gradient) << gradient.error().line();
    ASSERT_EQ(gradient->zones.size(), 256u);
    EXPECT_EQ(gradient->zones[200], glm::vec3(200, 400.5f, 0.25f));
    writeRecipe(folder / "two.exr", colored(256, 2));
    EXPECT_THAT(loadPaintedGradient(folder / "two.exr", {}).error().line(), HasSubstr("found 256 x 2 texels, expected N x 1"));
    ExrRecipe negative = colored(256, 1);
    poke(negative, "B", 255, 0, -1e-6f);
    writeRecipe(folder / "sky.exr", negative);
    EXPECT_THAT(loadPaintedGradient(folder / "sky.exr", {}).error().line(), HasSubstr("texel (255, 0)"));
}

std::string probesJson(const std::string& rows) {
    return fmt::format(R"({{"probes": [{{"file": "other.exr", "sh": []}}, {{"file": "p.exr", "position": [0, 1, 2], "sh": {}}}]}})", rows);
}

TEST(LoadProbeSh, FindsTheProbeByTheNameOfItsFile) {
    const TemporaryFolder folder;
    const auto file = folder / "probes.json";
    writeContent(file, probesJson("[[1,2,3],[4,5,6],[7,8,9],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[-1,-2.5,-3e-3]]"));
    const auto sh = loadProbeSh(file, "p.exr");
    ASSERT_TRUE(sh) << sh.error().line();
    EXPECT_EQ((*sh)[1], glm::vec3(4, 5, 6));
    EXPECT_EQ((*sh)[8], glm::vec3(-1, -2.5f, -3e-3f));
    EXPECT_THAT(loadProbeSh(file, "q.exr").error().line(), AllOf(HasSubstr("found 2 probes"), HasSubstr("\"q.exr\"")));
    EXPECT_THAT(loadProbeSh(file, "other.exr").error().line(), HasSubstr("found 0 rows"));
}

TEST(LoadProbeSh, NegativeLightIsRefused) {
    const TemporaryFolder folder;
    const auto file = folder / "probes.json";
    const std::string rest = "[-4,5,6],[7,8,9],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]]";
    writeContent(file, probesJson("[[0,2,3]," + rest));
    EXPECT_TRUE(loadProbeSh(file, "p.exr")) << "other rows may be negative";
    for (const char* light : {"[-1,2,3]", "[1,2,-1e-6]"}) {
        writeContent(file, probesJson("[" + std::string(light) + "," + rest));
        const auto sh = loadProbeSh(file, "p.exr");
        ASSERT_FALSE(sh) << light;
        EXPECT_EQ(sh.error().code, ErrorCode::ValueOutOfRange);
        EXPECT_THAT(sh.error().line(), AllOf(HasSubstr("sh of p.exr: found -"), HasSubstr("expected no negative energy")));
    }
}

TEST(LoadProbeSh, TwoProbesOfOneFileMustNotDiffer) {
    const TemporaryFolder folder;
    const auto file = folder / "probes.json";
    const auto list = [](const char* first, const char* second) {
        const std::string rest = "[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]]}";
        const std::string entry = "{\"file\": \"p.exr\", \"sh\": [";
        return "{\"probes\": [" + entry + first + "," + rest + ", " + entry + second + "," + rest + "]}";
    };
    writeContent(file, list("[1,2,3]", "[1,2,3]"));
    EXPECT_TRUE(loadProbeSh(file, "p.exr"));
    writeContent(file, list("[1,2,3]", "[1,2,4]"));
    const auto sh = loadProbeSh(file, "p.exr");
    ASSERT_FALSE(sh);
    EXPECT_EQ(sh.error().code, ErrorCode::WrongShape);
    EXPECT_THAT(sh.error().line(), HasSubstr("found two different probes with the file \"p.exr\", expected one"));
}

TEST(LoadProbeSh, BrokenListsAreRefused) {
    const TemporaryFolder folder;
    const auto file = folder / "probes.json";
    EXPECT_EQ(loadProbeSh(file, "p.exr").error().code, ErrorCode::FileUnreadable);
    for (const std::string& text : {std::string("{"), std::string("[1, 2]"), std::string("{\"probes\": 3}"), probesJson("[[1,2,3]]"),
                                    probesJson("7"), probesJson("[[1,2],[4,5,6],[7,8,9],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]]"),
                                    probesJson("[[1,2,\"3\"],[4,5,6],[7,8,9],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]]"),
                                    probesJson("[[1,2,1e300],[4,5,6],[7,8,9],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]]")}) {
        writeContent(file, text);
        const auto sh = loadProbeSh(file, "p.exr");
        ASSERT_FALSE(sh) << text;
        EXPECT_THAT(sh.error().line(), AllOf(HasSubstr("probes.json"), HasSubstr("found"), HasSubstr("expected"))) << text;
    }
}

TEST(LoadEnvironment, ATextureIsRefusedByItsContainer) {
    const TemporaryFolder folder;
    ASSERT_TRUE(writePattern(folder / "probe.ktx2", {PixelFormat::Rgba8Unorm, 8, 4}, {}));
    EXPECT_THAT(refusal(folder / "probe.ktx2").line(), AllOf(HasSubstr("found a GPU texture (KTX2), expected an image"),
                                                             HasSubstr("`lightcook decode` writes a texture as OpenEXR")));
}

TEST(LoadEnvironment, TheSharedPanoramasProbesAndGradientsAreReadWhole) {
    const std::filesystem::path data = LIGHTCOOK_SHARED_DATA;
    if (!std::filesystem::exists(data)) GTEST_SKIP() << "needs the shared test data at " << LIGHTCOOK_SHARED_DATA;
    const auto sun = loadEnvironment(data / "env/rooitou_park_1k.hdr", {});
    ASSERT_TRUE(sun) << sun.error().line();
    float brightest = 0;
    for (const glm::vec3& texel : sun->environment.texels.texels()) brightest = std::max({brightest, texel.r, texel.g, texel.b});
    EXPECT_EQ(brightest, 69120.0f);
    const auto probe = loadEnvironment(data / "scenes/interior_probe3.exr", {});
    ASSERT_TRUE(probe) << probe.error().line();
    EXPECT_EQ(probe->environment.projection, Environment::Projection::CubeStrip);
    EXPECT_TRUE(loadProbeSh(data / "scenes/interior_probes.json", "interior_probe3.exr"));
    const auto gradient = loadPaintedGradient(data / "gradients/sun_glow_256x1.exr", {});
    ASSERT_TRUE(gradient) << gradient.error().line();
    EXPECT_EQ(gradient->zones.size(), 256u);
}

}  // namespace
}  // namespace lightcook::formats
