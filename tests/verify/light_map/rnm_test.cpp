// Layout rnm: the verifier shades by the formula of the engine, its bounds hold, and our reader of Bakery's files reads the textures back.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "compress/encode.h"
#include "formats/light_map.h"
#include "formats/plain_image.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "tests/compress/synthetic_light_map.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/surface_fixture.h"
#include "tests/formats/temporary_folder.h"
#include "tests/verify/cooked_light_map.h"
#include "tests/verify/public_scenes.h"
#include "tests/verify/visible_sampler.h"
#include "verify/assets/random.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using formats::LightMapStrip;
using formats::Target;
using glm::dvec3;
using synthetic::Kind;

constexpr int kRnmWidth = 46, kRnmHeight = 38, kTangentNormals = 32;

/// The engine's formula, written out: n in the frame of tangent, bitangent (up the picture) and normal.
dvec3 engineShows(const std::array<dvec3, 3>& light, const dvec3& n) {
    const double a = std::sqrt(2.0 / 3), b = 1 / std::sqrt(6.0), c = 1 / std::sqrt(2.0), z = n.z / std::sqrt(3.0);
    return light[0] * std::max(0.0, a * n.x + z) + light[1] * std::max(0.0, -b * n.x - c * n.y + z) +
           light[2] * std::max(0.0, -b * n.x + c * n.y + z);
}
std::array<dvec3, 3> texelsAt(const test::Cooked& cooked, int x, int y) {
    std::array<dvec3, 3> light;
    for (std::size_t i = 0; i < 3; ++i) light[i] = dvec3(glm::vec3(cooked.texels.textures[i][0].at(x, y)));
    return light;
}
/// Returns tangent, bitangent and normal of a texel.
glm::dmat3 tangentsAt(const LightMapStrip& bake, int x, int y) {
    const dvec3 normal(bake.normal.at(x, y)), tangent(glm::vec3(bake.tangent.at(x, y)));
    return {tangent, static_cast<double>(bake.tangent.at(x, y).w) * glm::cross(normal, tangent), normal};
}
dvec3 exitOf(const lighting::ShRgb& sh, const dvec3& n) {
    return dvec3(lighting::lambertExitRadiance(sh, glm::vec3(n), glm::vec3(1)).value);
}

/// The charts of the gradient, whose tangents turn from texel to texel: a curved surface.
LightMapStrip curvedBake() {
    LightMapStrip bake = synthetic::makeBand(Kind::Gradient, kRnmWidth, 0, kRnmHeight);
    for (int y = 0; y < kRnmHeight; ++y)
        for (int x = 0; x < kRnmWidth; ++x) {
            const dvec3 bent = glm::normalize(dvec3(bake.normal.at(x, y)) + 0.3 * dvec3(std::sin(0.2 * x), std::cos(0.3 * y), 0.2));
            const dvec3 along(glm::vec3(bake.tangent.at(x, y)));
            bake.normal.at(x, y) = glm::vec3(bent);
            bake.tangent.at(x, y) = glm::vec4(glm::vec3(glm::normalize(along - glm::dot(along, bent) * bent)), bake.tangent.at(x, y).w);
        }
    return bake;
}

/// The bounds assume a largest difference between the light of the coefficients and that of the engine's formula: samples stay within it.
TEST(RnmLayout, TheCoefficientsAreWithinTheResidualOverTheHemisphere) {
    LightMapStrip one;
    one.normal = formats::Image<glm::vec3>(1, 1, glm::vec3(0, 0, 1));
    one.tangent = formats::Image<glm::vec4>(1, 1, glm::vec4(1, 0, 0, 1));
    verify::layouts::Rnm layout;
    layout.frames.strip = &one;
    for (std::size_t i = 0; i < 3; ++i) {
        verify::layouts::Rnm::LayerTexels texels{};
        texels[i] = glm::vec4(1);
        const shaders::LcSh sh = layout.at(0, 0).decode(texels);
        double largest = 0;
        // The largest difference lies at the rim of the hemisphere.
        for (int k = 0; k < 20000; ++k) {
            dvec3 n = lighting::fibonacciHemisphere(k, 20000);
            if (k % 4 == 0) n = dvec3(std::cos(0.001 * k), std::sin(0.001 * k), 0);
            const auto shown = static_cast<double>(shaders::lcExitRadiance(sh, glm::vec3(n)).x),
                       exact = static_cast<double>(layout.at(0, 0).exitRadiance(texels, glm::vec3(n)).x);
            std::array<dvec3, 3> light{};
            light[i] = dvec3(1);
            ASSERT_NEAR(exact, engineShows(light, n).x, 1e-6);
            largest = std::max(largest, std::abs(shown - exact));
        }
        EXPECT_LE(largest, static_cast<double>(verify::layouts::Rnm::kResidual));
        EXPECT_GT(largest, static_cast<double>(verify::layouts::Rnm::kResidual) - 5e-4);
        EXPECT_NEAR(static_cast<double>(shaders::lcExitRadiance(sh, glm::vec3(0, 0, 1)).x), 1 / std::sqrt(3.0), 1e-5)
            << "the surface's own normal is exact";
    }
}

/// Over the normals around one, the difference is in the range that the visible bound takes.
TEST(RnmLayout, TheResidualAroundANormalIsWithinItsRange) {
    LightMapStrip one;
    one.normal = formats::Image<glm::vec3>(1, 1, glm::vec3(0, 0, 1));
    one.tangent = formats::Image<glm::vec4>(1, 1, glm::vec4(1, 0, 0, 1));
    verify::layouts::Rnm layout;
    layout.frames.strip = &one;
    verify::Random random(9);
    double nearest = 0, lowest = 0, highest = 0;
    const auto inHemisphere = [](dvec3 n) { return dvec3(n.x, n.y, std::abs(n.z)); };
    for (int k = 0; k < 4000; ++k) {
        const dvec3 middle = lighting::fibonacciHemisphere(k, 4000);
        const double reach = 0.001 + 0.3 * random.next() * random.next();
        const verify::RnmResidual range = verify::RnmResidual::around(middle, reach);
        for (int turn = 0; turn < 16; ++turn) {
            const dvec3 across = glm::normalize(glm::cross(middle, dvec3(random.next(), random.next(), random.next()) - 0.5));
            const double angle = turn % 4 == 0 ? reach : reach * random.next();
            const dvec3 n = inHemisphere(std::cos(angle) * middle + std::sin(angle) * across);
            for (std::size_t i = 0; i < 3; ++i) {
                verify::layouts::Rnm::LayerTexels texels{};
                texels[i] = glm::vec4(1);
                const double off = static_cast<double>(layout.at(0, 0).exitRadiance(texels, glm::vec3(n)).x -
                                                       shaders::lcExitRadiance(layout.at(0, 0).decode(texels), glm::vec3(n)).x);
                ASSERT_LE(std::abs(off - range.centre[i]), range.radius[i] + 1e-6);
                nearest = std::max(nearest, std::abs(off - range.centre[i]) / range.radius[i]);
                lowest = std::min(lowest, off);
                highest = std::max(highest, off);
            }
        }
    }
    EXPECT_GT(nearest, 0.9);
    EXPECT_LT(lowest, verify::RnmResidual::kLowest + 2e-3);
    EXPECT_GT(highest, verify::RnmResidual::kHighest - 2e-3);
}

TEST(RnmLayout, DiffuseErrorsAreThoseOfTheEnginesFormula) {
    for (const Target target : {Target::Bc, Target::Float}) {
        const test::Cooked cooked = test::cook(curvedBake(), LightMapLayout::Rnm, target, 3);
        double errors = 0, references = 0;
        for (int y = 0; y < kRnmHeight; ++y)
            for (int x = 0; x < kRnmWidth; ++x) {
                if (cooked.reference.covered.at(x, y) == 0) continue;
                const glm::dmat3 tangents = tangentsAt(cooked.reference, x, y);
                const glm::dmat3 frame = lighting::worldFromTangentFrame(tangents[2]);
                for (int k = 0; k < kTangentNormals; ++k) {
                    const dvec3 world = frame * lighting::fibonacciHemisphere(k, kTangentNormals);
                    const dvec3 reference = exitOf(cooked.reference.sh.at(x, y), world),
                                error = engineShows(texelsAt(cooked, x, y), glm::transpose(tangents) * world) - reference;
                    errors += glm::dot(error, error);
                    references += glm::dot(reference, reference);
                }
            }
        const verify::StageError stage = cooked.stages().front();
        EXPECT_EQ(stage.name, "rnm");
        EXPECT_NEAR(stage.diffuse.relRms, std::sqrt(errors / references), 1e-5);
        EXPECT_GT(stage.diffuse.relRms, 0.01);
    }
}

/// A baker stores the irradiance of each direction. The fit errs less.
TEST(RnmLayout, TheFitIsBetterThanTheLightOfTheDirections) {
    test::Cooked cooked = test::cook(synthetic::makeBand(Kind::Gradient, kRnmWidth, 0, kRnmHeight), LightMapLayout::Rnm, Target::Float, 3);
    const double fitted = cooked.stages().front().diffuse.relRms;
    const double b = 1 / std::sqrt(6.0), c = 1 / std::sqrt(2.0), z = 1 / std::sqrt(3.0);
    const std::array<dvec3, 3> basis = {dvec3(std::sqrt(2.0 / 3), 0, z), dvec3(-b, -c, z), dvec3(-b, c, z)};
    for (int y = 0; y < kRnmHeight; ++y)
        for (int x = 0; x < kRnmWidth; ++x)
            for (std::size_t i = 0; i < 3 && cooked.reference.covered.at(x, y) != 0; ++i) {
                const dvec3 towards = tangentsAt(cooked.reference, x, y) * basis[i];
                cooked.texels.textures[i][0].at(x, y) = glm::vec4(glm::vec3(exitOf(cooked.reference.sh.at(x, y), towards)), 1);
            }
    EXPECT_LT(fitted, 0.9 * cooked.stages().front().diffuse.relRms);
}

void expectBoundsOfQuads(LightMapStrip bake, int quads, int placesAQuad) {
    const test::Cooked cooked = test::cook(std::move(bake), LightMapLayout::Rnm, Target::Bc, 1);
    const verify::LightMapVerifier verifier = cooked.verifier(test::sampledShading());
    const test::VisibleSampler sampler(cooked, test::viewingOf(cooked));
    verify::Random random(11);
    const auto perKey = 1 / cooked.key;
    std::int64_t above = 0, shadings = 0;
    double nearest = 0;
    for (int quad = 0; quad < quads; ++quad) {
        const auto [x, y] = sampler.covered[static_cast<std::size_t>(random.next() * static_cast<double>(sampler.covered.size()))];
        for (int place = 0; place < placesAQuad; ++place) {
            const test::SampledPlace at = sampler.placeAt(x, y, random);
            const auto bound = verifier.boundQuad(cooked.texels, cooked.reference, at.quadX(), at.quadY());
            const test::SampledLight light = sampler.lightAt(at);
            for (int k = 0; k < 16; ++k) {
                const double height = random.next() < 0.2 ? 0 : random.next(), r = std::sqrt(1 - height * height),
                             azimuth = 2 * std::numbers::pi * random.next();
                const dvec3 n(r * std::cos(azimuth), r * std::sin(azimuth), height);
                const test::ShadingRow row = test::diffuseRow(n);
                const glm::vec3 shown = light.shown(n);
                for (std::size_t channel = 0; channel < 3; ++channel) {
                    double reference = 0;
                    for (std::size_t i = 0; i < row.size(); ++i) reference += row[i] * static_cast<double>(light.reference[channel][i]);
                    const double local = std::abs(static_cast<double>(shown[static_cast<int>(channel)]) - reference) /
                                         (std::abs(reference) + lighting::kLocalErrorFloor);
                    above += !(local <= bound.diffuse);
                    nearest = std::max(nearest, local / bound.diffuse);
                    ++shadings;
                }
            }
        }
    }
    EXPECT_GT(perKey, 0);
    EXPECT_EQ(above, 0) << "of " << shadings;
    EXPECT_GT(nearest, 0.1) << "a bound far above all errors would always hold";
}

TEST(RnmLayout, NoShadingOfAQuadIsAboveItsBound) {
    expectBoundsOfQuads(curvedBake(), 40, 8);
}
TEST(RnmLayoutSoak, NoShadingOfAQuadIsAboveItsBound) {
    expectBoundsOfQuads(curvedBake(), 1000, 10);
    expectBoundsOfQuads(synthetic::makeBand(Kind::Spikes, kRnmWidth, 0, kRnmHeight), 1000, 10);
    expectBoundsOfQuads(synthetic::makeBand(Kind::NegativeBands, kRnmWidth, 0, kRnmHeight), 1000, 10);
}

/// Returns the figures at texels of textures that hold the light of the three directions, through the same encoder.
verify::StageError figuresOfDirections(const test::Cooked& cooked, const verify::Viewing& viewing, int effort) {
    const double b = 1 / std::sqrt(6.0), c = 1 / std::sqrt(2.0), z = 1 / std::sqrt(3.0);
    const std::array<dvec3, 3> basis = {dvec3(std::sqrt(2.0 / 3), 0, z), dvec3(-b, -c, z), dvec3(-b, c, z)};
    const int width = cooked.map.width, height = cooked.map.height;
    verify::DecodedLightMapRows texels;
    formats::Image<float> significance(width, height, 0);
    for (std::size_t i = 0; i < 3; ++i) {
        formats::Image<glm::vec4> light(width, height, glm::vec4(0, 0, 0, 1));
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                if (cooked.reference.covered.at(x, y) == 0) continue;
                significance.at(x, y) = 1;
                const dvec3 towards = tangentsAt(cooked.reference, x, y) * basis[i];
                light.at(x, y) = glm::vec4(glm::max(glm::vec3(exitOf(cooked.reference.sh.at(x, y), towards)), 0.0f), 1);
            }
        compress::EncodeOptions options;
        options.effort = effort;
        options.hdrMetric = compress::HdrMetric::Log;
        options.hdrScale = 0.1f * static_cast<float>(cooked.key);
        std::vector<std::byte> bytes(static_cast<std::size_t>((height + 3) / 4) *
                                     formats::bytesPerBlockRow(formats::PixelFormat::Bc6hUf16, width));
        compress::encodeRows(formats::PixelFormat::Bc6hUf16, light.view(), significance.view(), options, bytes, {});
        texels.textures.emplace_back();
        texels.textures.back().emplace_back(width, height);
        verify::decodeRows(formats::PixelFormat::Bc6hUf16, bytes, texels.textures.back().back().view());
    }
    verify::LightMapSampling sampling;
    sampling.figures = verify::LightMapFigures::Sampled;
    sampling.placesPerTexel = 0;
    const auto verifier = verify::LightMapVerifier::create(cooked.map, {}, sampling, cooked.key, viewing);
    return verifier->verifyRows(texels, cooked.reference, 0, height).figures().front();
}

class RnmScenesSoak : public testing::TestWithParam<const char*> {};

/// A baker stores E(b_i). The fit errs by a tenth less at least, and its p99 is no larger.
TEST_P(RnmScenesSoak, TheFitIsBetterThanWhatABakerStores) {
    constexpr int kEffort = 5;
    if (!std::filesystem::exists(test::lightMapOf(GetParam()))) GTEST_SKIP() << "the shared scenes are not here";
    const auto reader = formats::LightMapReader::open(test::lightMapOf(GetParam()), test::descriptionFor(GetParam(), LightMapLayout::Rnm));
    ASSERT_TRUE(reader.has_value()) << reader.error().line();
    auto bake = reader->read(0, reader->height());
    ASSERT_TRUE(bake.has_value()) << bake.error().line();
    const test::Cooked cooked = test::cook(std::move(*bake), LightMapLayout::Rnm, Target::Bc, kEffort);
    const verify::Viewing viewing = test::viewingOf(cooked);
    verify::LightMapSampling sampling;
    sampling.figures = verify::LightMapFigures::Sampled;
    sampling.placesPerTexel = 0;
    const auto verifier = verify::LightMapVerifier::create(cooked.map, {}, sampling, cooked.key, viewing);
    const verify::StageError fitted = verifier->verifyRows(cooked.texels, cooked.reference, 0, cooked.map.height).figures().front(),
                             stored = figuresOfDirections(cooked, viewing, kEffort);
    for (const auto& [name, stage] : {std::pair("fit", &fitted), std::pair("E(b_i)", &stored)})
        fmt::print("rnm {:9} {:7} rel_rms {:.2f} / {:.2f} %, visible p99 {:.1f} / {:.1f}, p99.9 {:.1f} / {:.1f}\n", GetParam(), name,
                   100 * stage->diffuse.relRms, 100 * stage->specular.relRms, stage->diffuse.visible->p99, stage->specular.visible->p99,
                   stage->diffuse.visible->p999, stage->specular.visible->p999);
    EXPECT_LE(fitted.diffuse.relRms, 0.9 * stored.diffuse.relRms);
    EXPECT_LE(fitted.diffuse.visible->p99, stored.diffuse.visible->p99);
}
INSTANTIATE_TEST_SUITE_P(Scenes, RnmScenesSoak, testing::ValuesIn(test::kPublicScenes));

/// The three textures as the files of Bakery, on a mesh: they are read as the light that the verifier decodes.
TEST(RnmLayout, IsReadBackAsTheBakeOfTheEngine) {
    constexpr int kSide = 16;
    for (const Target target : {Target::Bc, Target::Float}) {
        const formats::TemporaryFolder folder;
        formats::writeSquare(folder / "square.glb", {.texture = glm::mat2(0, 1, 1, 0)});
        LightMapStrip bake;
        bake.sh = formats::Image<lighting::ShRgb>(kSide, kSide);
        bake.covered = formats::Image<std::uint8_t>(kSide, kSide, 1);
        bake.normal = formats::Image<glm::vec3>(kSide, kSide, glm::vec3(0, 1, 0));
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) bake.sh.at(x, y) = synthetic::gradientLight(x, y);
        auto writer = formats::LightMapWriter::create(folder / "bake.exr", kSide, kSide, formats::SurfaceOutput::CoverageAndNormals);
        ASSERT_TRUE(writer.has_value());
        ASSERT_TRUE(writer->append(bake.sh.view(), {bake.covered.view(), bake.normal.view()}).has_value());
        ASSERT_TRUE(writer->commit().has_value());
        formats::LightMapDescription description;
        description.mesh = folder / "square.glb";
        description.takesTangents = true;
        const auto reader = formats::LightMapReader::open(folder / "bake.exr", description);
        ASSERT_TRUE(reader.has_value()) << reader.error().line();
        auto onMesh = reader->read(0, kSide);
        ASSERT_TRUE(onMesh.has_value()) << onMesh.error().line();
        // u = z and v = x: the tangent is z, and up the picture is -x.
        for (const glm::vec4& tangent : onMesh->tangent.texels()) ASSERT_EQ(tangent, glm::vec4(0, 0, 1, -1));

        const test::Cooked cooked = test::cook(std::move(*onMesh), LightMapLayout::Rnm, target, 5);
        for (std::size_t i = 0; i < 3; ++i)
            ASSERT_TRUE(formats::writeExr(folder / fmt::format("room_RNM{}.exr", i), cooked.texels.textures[i][0].view(), 3).has_value());
        formats::LightMapDescription engine;
        engine.mesh = description.mesh;
        engine.bake = "bakery-rnm";
        const auto back = formats::LightMapReader::open(folder / "room_RNM0.exr", engine);
        ASSERT_TRUE(back.has_value()) << back.error().line();
        const auto strip = back->read(0, kSide);
        ASSERT_TRUE(strip.has_value()) << strip.error().line();
        const auto decoded = cooked.verifier().reconstruct(cooked.texels, 0, kSide, 1, &cooked.reference);
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x)
                for (std::size_t i = 0; i < 9; ++i)
                    for (int c = 0; c < 3; ++c)
                        // Files are halves, as the texels of both targets are.
                        EXPECT_NEAR(strip->sh.at(x, y)[i][c], decoded.at(x, y)[i][c], 2e-6f * decoded.at(x, y)[0][c]) << i;
    }
}

}  // namespace
}  // namespace lightcook
