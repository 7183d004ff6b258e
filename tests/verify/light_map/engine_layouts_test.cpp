// Layouts of engines, from a bake to textures and back: the readers of the engines' own bakes see what the verifier decodes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "formats/light_map.h"
#include "formats/plain_image.h"
#include "tests/compress/synthetic_light_map.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/temporary_folder.h"
#include "tests/formats/unreal_fixture.h"
#include "tests/verify/cooked_light_map.h"

namespace lightcook {
namespace {

using formats::Image;
using formats::LightMapLayout;
using formats::Target;
using synthetic::Kind;

constexpr int kEngineWidth = 46, kEngineHeight = 38;

/// Light of order 1, and for the layout whose colours share a direction the same light in three strengths.
formats::LightMapStrip bakeFor(LightMapLayout layout) {
    formats::LightMapStrip bake = synthetic::makeBand(Kind::Gradient, kEngineWidth, 0, kEngineHeight);
    for (lighting::ShRgb& sh : bake.sh.texels()) {
        std::fill(sh.begin() + 4, sh.end(), glm::vec3(0));
        if (layout != LightMapLayout::MonoSh) continue;
        for (glm::vec3& coefficient : sh) coefficient = coefficient.x * glm::vec3(1.0f, 0.6f, 0.25f);
    }
    return bake;
}

/// Writes layers one below the other, as Godot's bakes are, with the coverage of the first as alpha.
void writeStack(const std::filesystem::path& file, const std::vector<const Image<glm::vec4>*>& layers, const formats::LightMapStrip& bake) {
    Image<glm::vec4> stack(kEngineWidth, kEngineHeight * static_cast<int>(layers.size()));
    for (std::size_t layer = 0; layer < layers.size(); ++layer)
        for (int y = 0; y < kEngineHeight; ++y)
            for (int x = 0; x < kEngineWidth; ++x)
                stack.at(x, static_cast<int>(layer) * kEngineHeight + y) =
                    glm::vec4(glm::vec3(layers[layer]->at(x, y)), bake.covered.at(x, y) != 0 ? 1 : 0);
    const auto written = formats::writeExr(file, stack.view(), 4);
    ASSERT_TRUE(written.has_value()) << written.error().line();
}

/// Writes the textures of a layout as files of the bake that the engine's baker would write. Returns the file to open.
std::filesystem::path writeBake(const formats::TemporaryFolder& folder, LightMapLayout layout, const test::Cooked& cooked) {
    const auto& textures = cooked.texels.textures;
    if (layout == LightMapLayout::Godot) {
        const auto& slices = textures[0];
        writeStack(folder / "room.exr", {&slices[0], &slices[1], &slices[2], &slices[3]}, cooked.reference);
        return folder / "room.exr";
    }
    const std::vector<std::string> endings =
        layout == LightMapLayout::MonoSh ? std::vector<std::string>{"L0", "L1"} : std::vector<std::string>{"L0", "L1x", "L1y", "L1z"};
    for (std::size_t t = 0; t < textures.size(); ++t)
        writeStack(folder / ("room_" + endings[t] + ".exr"), {&textures[t][0]}, cooked.reference);
    return folder / "room_L0.exr";
}

double shown(const lighting::ShRgb& sh, int channel, const glm::dvec3& n) {
    const auto at = [&](std::size_t i) { return static_cast<double>(sh[i][channel]); };
    return 0.28209479177 * at(0) + 0.32573500793 * (at(1) * n.y + at(2) * n.z + at(3) * n.x);
}

struct Case {
    LightMapLayout layout;
    const char* bake;
    double step;  ///< of L1 over L0 in target float: half a step of a half in [0.5, 1], or of a 16-bit number, times the layout's range
};
class EngineLayouts : public testing::TestWithParam<Case> {};

TEST_P(EngineLayouts, AreReadBackAsTheEngineShowsThem) {
    const Case& tested = GetParam();
    for (const Target target : {Target::Float, Target::Bc}) {
        const test::Cooked cooked = test::cook(bakeFor(tested.layout), tested.layout, target, 5);
        const formats::TemporaryFolder folder;
        formats::LightMapDescription description;
        description.bake = tested.bake;
        const auto reader = formats::LightMapReader::open(writeBake(folder, tested.layout, cooked), description);
        ASSERT_TRUE(reader.has_value()) << reader.error().line();
        const auto strip = reader->read(0, kEngineHeight);
        ASSERT_TRUE(strip.has_value()) << strip.error().line();
        ASSERT_EQ(strip->sh.height(), kEngineHeight);
        const Image<lighting::ShRgb> decoded = cooked.verifier().reconstruct(cooked.texels, 0, kEngineHeight);
        int covered = 0;
        for (int y = 0; y < kEngineHeight; ++y)
            for (int x = 0; x < kEngineWidth; ++x) {
                ASSERT_EQ(strip->covered.at(x, y), cooked.reference.covered.at(x, y));
                if (strip->covered.at(x, y) == 0) continue;
                ++covered;
                for (int c = 0; c < 3; ++c) {
                    const lighting::ShRgb &read = strip->sh.at(x, y), &ours = decoded.at(x, y), &bake = cooked.reference.sh.at(x, y);
                    const double first = 0.28209479177 * static_cast<double>(bake[0][c]);
                    // Rounding of L0 is seen in L0, and in L1 that is solved for it.
                    const double allowed = first * (3 * 0x1p-11 + std::sqrt(3.0) * tested.step);
                    for (const glm::dvec3& n :
                         {glm::dvec3(0, 0, 1), glm::dvec3(0, -1, 0), glm::dvec3(1, 0, 0), glm::normalize(glm::dvec3(-3, 1, 0.5))}) {
                        EXPECT_NEAR(shown(read, c, n), shown(ours, c, n), 1e-6 * first);
                        if (target == Target::Float) {
                            EXPECT_NEAR(shown(read, c, n), shown(bake, c, n), allowed) << x << ' ' << y << ' ' << c;
                        }
                    }
                }
            }
        EXPECT_GT(covered, 1000);
    }
}

INSTANTIATE_TEST_SUITE_P(All, EngineLayouts,
                         testing::Values(Case{LightMapLayout::Godot, "godot", 8 * 0x1p-12},
                                         Case{LightMapLayout::MonoSh, "bakery-mono-sh", 4 * 0x1p-17},
                                         Case{LightMapLayout::Bakery, "bakery-sh", 4 * 0x1p-17}),
                         [](const auto& each) {
                             std::string name(formats::info(each.param.layout).name);
                             std::erase(name, '-');
                             return name;
                         });

/// Unreal's exporter writes both textures into one picture, and of the constants those of the upper half: what its reader sees is our
/// decode without directions, for which the engine has 0.6 in place of the first basis function.
TEST(UnrealHqLayout, IsReadBackFromThePictureOfTheExporter) {
    constexpr double kFlatDirectionality = 0.6, kFirst = 0.28209479;
    for (const Target target : {Target::Float, Target::Bc}) {
        test::Cooked cooked = test::cook(bakeFor(LightMapLayout::MonoSh), LightMapLayout::UnrealHq, target, 3);
        for (auto& texture : cooked.texels.textures)
            for (glm::vec4& texel : texture[0].texels()) texel = glm::round(255.0f * texel) / 255.0f;
        const formats::TemporaryFolder folder;
        formats::writePng(folder / "light map.png", kEngineWidth, 2 * kEngineHeight, 4, [&](int channel, int x, int y) {
            const auto& half = cooked.texels.textures[y < kEngineHeight ? 0 : 1][0];
            return static_cast<int>(std::lround(255 * half.at(x, y % kEngineHeight)[channel]));
        });
        const auto four = [&](const char* name) {
            const std::vector<float>& v = cooked.map.constants.at(name);
            return glm::dvec4(v[0], v[1], v[2], v[3]);
        };
        const formats::UnrealImage image(kEngineWidth, kEngineHeight);
        const nlohmann::json lightMap =
            formats::unrealLightMap(image, {0, 0, kEngineWidth, kEngineHeight}, {four("scale0"), four("add0")}, 0);
        const nlohmann::json gltf =
            formats::unrealGltf(nlohmann::json::array({{{"name", "HQ"}, {"uri", "light%20map.png"}}}), nlohmann::json::array({lightMap}));
        formats::writeContent(folder / "room.gltf", gltf.dump());
        const auto reader = formats::LightMapReader::open(folder / "room.gltf", {});
        ASSERT_TRUE(reader.has_value()) << reader.error().line();
        EXPECT_EQ(reader->bake(), "unreal-hq");
        const auto strip = reader->read(0, kEngineHeight);
        ASSERT_TRUE(strip.has_value()) << strip.error().line();
        const Image<lighting::ShRgb> decoded = cooked.verifier().reconstruct(cooked.texels, 0, kEngineHeight);
        double brightest = 0;
        for (int y = 0; y < kEngineHeight; ++y)
            for (int x = 0; x < kEngineWidth; ++x)
                for (int c = 0; c < 3; ++c) {
                    const auto read = static_cast<double>(strip->sh.at(x, y)[0][c]), ours = static_cast<double>(decoded.at(x, y)[0][c]);
                    brightest = std::max(brightest, read);
                    // The reader clamps light at 0.
                    EXPECT_NEAR(kFirst / kFlatDirectionality * read, std::max(ours, 0.0), 1e-5 * ours + 1e-6) << x << ' ' << y;
                }
        EXPECT_GT(brightest, 0.1);
    }
}

/// A surface has normals of its own hemisphere alone: there L0 and L1 follow much of the band that they lack.
TEST(EngineLayoutFit, ShowsMoreOfBand2ThanBands0And1Alone) {
    const auto errorOf = [](LightMapLayout layout) {
        return test::cook(synthetic::makeBand(Kind::Gradient, kEngineWidth, 0, kEngineHeight), layout, Target::Float, 3).total();
    };
    const verify::StageError truncated = errorOf(LightMapLayout::Sh4);
    for (const LightMapLayout layout : {LightMapLayout::Godot, LightMapLayout::Bakery}) {
        const verify::StageError fitted = errorOf(layout);
        EXPECT_LT(fitted.diffuse.relRms, 0.8 * truncated.diffuse.relRms) << formats::info(layout).name;
        EXPECT_LT(fitted.specular.relRms, truncated.specular.relRms) << formats::info(layout).name;
    }
}

}  // namespace
}  // namespace lightcook
