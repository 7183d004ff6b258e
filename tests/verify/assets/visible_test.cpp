// Visible errors of cubemaps, tables, reflection maps and meshes on made inputs whose errors have a closed form. The truth of the metric
// is in long double (itp_truth.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <random>
#include <span>
#include <string_view>

#include "lighting/cube.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "tests/verify/itp_truth.h"
#include "verify/cubemap.h"
#include "verify/lut.h"
#include "verify/mesh.h"
#include "verify/rsrm.h"

namespace lightcook::verify {
namespace {

using formats::Image;

const glm::dvec3 kLight(0.375, 0.625, 0.9375);
constexpr double kGrayNits = 0.18 * 203;
/// Returns how far the program may be from the truth: its curve is within 0.01 %, and it adds light in floats.
double toleranceOf(double expected) {
    return 0.002 + 1e-3 * expected;
}
double luminanceOf(const glm::dvec3& light) {
    return glm::dot(light, glm::dvec3(lighting::kRec709Luminance));
}
Viewing viewingOf(double key) {
    return {lighting::DisplaySettings{}.of(key)};
}

TEST(VisiblePairs, AgreeWithTheTruthInAnyGroups) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> exponent(-8, 6), change(-0.3, 0.3);
    VisiblePairs whole(viewingOf(1)), first(viewingOf(1)), second(viewingOf(1));
    double squares = 0, largest = 0;
    constexpr int kCount = 203;
    for (int i = 0; i < kCount; ++i) {
        glm::dvec3 reference, found;
        for (int c = 0; c < 3; ++c) {
            reference[c] = std::exp2(exponent(random));
            found[c] = reference[c] * (1 + change(random));
        }
        const VisiblePlace place{.x = static_cast<double>(i), .y = 2, .mip = 1};
        whole.add(reference, found, place);
        (i < 37 ? first : second).add(reference, found, place);
        const double truth = visibleTruth(reference, found, kGrayNits);
        squares += truth * truth;
        largest = std::max(largest, truth);
    }
    first.merge(second);
    for (const VisiblePairs* each : {&whole, &first}) {
        const VisibleFigures figures = each->figures().value();
        EXPECT_NEAR(figures.rms, std::sqrt(squares / kCount), 1e-3 * figures.rms);
        EXPECT_NEAR(figures.max, largest, toleranceOf(largest));
        EXPECT_EQ(figures.maxAt.mip, 1);
        EXPECT_NEAR(visibleTruth(figures.maxAt.reference, figures.maxAt.found, kGrayNits), largest, toleranceOf(largest));
        EXPECT_EQ(figures.maxAt.x, whole.figures()->maxAt.x);
    }
    EXPECT_FALSE(VisiblePairs(viewingOf(1)).figures().has_value());
}

TEST(VisiblePairs, LightThatIsNotFiniteIsTheLargestError) {
    VisiblePairs pairs(viewingOf(1));
    pairs.add(kLight, glm::dvec3(std::numeric_limits<double>::quiet_NaN()), {.x = 4, .y = 5});
    EXPECT_GT(pairs.figures()->max, 1e30);
    EXPECT_EQ(pairs.figures()->maxAt.x, 4);
}

TEST(DisplayKeyOf, RaisesDarkLuminancesToAShareOfTheMean) {
    EXPECT_NEAR(displayKeyOf(std::vector{2.0, 8.0}), 4, 1e-12);
    EXPECT_NEAR(displayKeyOf(std::vector{0.0, 2.0}), std::sqrt(2.0 / 1024), 1e-12);
    EXPECT_EQ(displayKeyOf(std::vector{0.0, 0.0}), 0);
    EXPECT_EQ(displayKeyOf({}), 0);
}

formats::Environment environmentOf(const std::function<glm::dvec3(const glm::dvec3&)>& radiance) {
    constexpr int kHeight = 24;
    formats::Environment environment;
    environment.texels = Image<glm::vec3>(2 * kHeight, kHeight);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < 2 * kHeight; ++x)
            environment.texels.at(x, y) =
                glm::vec3(radiance(lighting::directionFromEquirectangular({(x + 0.5) / (2 * kHeight), (y + 0.5) / kHeight})));
    return environment;
}

TEST(CubemapKey, IsTheExitRadianceOfWhiteSurfaces) {
    const formats::Environment constant = environmentOf([](const glm::dvec3&) { return kLight; });
    EXPECT_NEAR(CubemapReference(constant).displayKey(lighting::kRec709Luminance), luminanceOf(kLight), 1e-5);
    // Radiance 1 + z / 2 leaves a white surface with 1 + n.z / 3: the mean logarithm over the sphere is an elementary integral.
    const formats::Environment slanted = environmentOf([](const glm::dvec3& d) { return glm::dvec3(1 + d.z / 2); });
    const auto primitive = [](double u) { return u * std::log(u) - u; };
    const double expected = std::exp(1.5 * (primitive(4.0 / 3) - primitive(2.0 / 3)));
    EXPECT_NEAR(CubemapReference(slanted).displayKey(lighting::kRec709Luminance), expected, 3e-3 * expected);
}

TEST(CubemapReflectance, IsTheAlbedoOfAWhiteSurface) {
    EXPECT_EQ(cubemapReflectance(0, lighting::NormalDistribution::Beckmann), 1);
    for (const auto lobe : {lighting::NormalDistribution::Beckmann, lighting::NormalDistribution::Ggx})
        for (const double m : {0.05, 0.3, 0.7, 1.0}) {
            const auto kernel = lighting::integrateAreaSpecular(1, m, lobe, lighting::CookTorranceNormalization::Energy, 256);
            const double expected = kernel.c[0] * std::sqrt(4 * std::numbers::pi);
            EXPECT_NEAR(cubemapReflectance(m, lobe), expected, 1e-3) << m;
            EXPECT_LE(expected, 1.0001);
        }
}

/// Returns a plain cubemap of one colour.
CookedCubemap plainCubemap() {
    CookedCubemap map;
    map.isDivided = false;
    map.range = 2;
    for (int level = 0; level < 3; ++level) {
        CookedCubemap::Mip mip;
        mip.m = std::array{0.2, 0.5, 1.0}[static_cast<std::size_t>(level)];
        for (int face = 0; face < 6; ++face) mip.faces.emplace_back(4 >> level, 4 >> level, glm::vec4(glm::vec3(kLight / 2.0), 1));
        map.mips.push_back(std::move(mip));
    }
    return map;
}

/// Returns the stages of a map of a constant environment, without places between texels.
std::vector<StageError> stagesOf(const CookedCubemap& map, const CubemapReference& reference, const glm::dvec3& light,
                                 const std::optional<Viewing>& viewing) {
    const double key = glm::dot(reference.mean(), glm::dvec3(lighting::kRec709Luminance));
    std::vector<CubemapErrors> levels;
    for (int mip = 0; mip < static_cast<int>(map.mips.size()); ++mip) {
        const int size = map.mips[static_cast<std::size_t>(mip)].faces[0].width();
        const Image<glm::vec3> references(size, size, glm::vec3(light));
        levels.emplace_back(key, viewing);
        for (int face = 0; face < 6; ++face) levels.back().merge(compareCubemapFace(map, mip, face, references.view(), key, viewing));
    }
    return cubemapStages(map, reference, levels, {}, {}, lighting::kRec709Luminance, viewing);
}

TEST(VisibleCubemap, OneTexelChangedByFivePercentIsFoundWithItsColours) {
    const formats::Environment constant = environmentOf([](const glm::dvec3&) { return kLight; });
    const CubemapReference reference(constant);
    const Viewing viewing = viewingOf(reference.displayKey(lighting::kRec709Luminance));
    CookedCubemap map = plainCubemap();
    map.mips[0].faces[3].at(2, 1) *= 1.05f;
    const auto stages = stagesOf(map, reference, kLight, viewing);
    const double part = cubemapReflectance(0.2, map.lobe);
    const double expected = visibleTruth(part * kLight, 1.05 * part * kLight, kGrayNits / luminanceOf(kLight));
    EXPECT_GT(expected, 1);
    for (const char* name : {"divide", "total"}) {
        const auto stage = std::ranges::find(stages, name, &StageError::name);
        const VisibleFigures& visible = stage->specular.visible.value();
        EXPECT_NEAR(visible.max, expected, toleranceOf(expected)) << name;
        EXPECT_NEAR(visible.rms, expected / std::sqrt(96.0), 0.01 + 1e-3 * expected) << name << ", of level 0";
        EXPECT_LT(visible.p50, 0.01) << name;
        EXPECT_EQ(visible.maxAt.mip, 0);
        EXPECT_EQ(visible.maxAt.face, 3);
        EXPECT_EQ(visible.maxAt.x, 2);
        EXPECT_EQ(visible.maxAt.y, 1);
        EXPECT_EQ(visible.maxAt.m, 0.2);
        EXPECT_NEAR(visible.maxAt.found.y, 1.05 * part * kLight.y, 1e-5);
        EXPECT_EQ(visible.bound.has_value(), name == std::string_view("total"));
    }
    const VisibleFigures& total = stages[2].specular.visible.value();
    EXPECT_GE(total.bound.value(), total.max);
    EXPECT_LT(*total.bound, 1.5 * total.max) << "every other direction has the light of the reference";
    EXPECT_EQ(total.boundAt.mip, 0);
    EXPECT_FALSE(stagesOf(map, reference, kLight, std::nullopt)[2].specular.visible.has_value()) << "without a display";
}

TEST(VisibleCubemap, RoughLevelsAreDarkerAndSoTheirErrorsSmaller) {
    const formats::Environment constant = environmentOf([](const glm::dvec3&) { return glm::dvec3(0.01); });
    const CubemapReference reference(constant);
    double before = std::numeric_limits<double>::infinity();
    for (std::size_t level = 0; level < 3; ++level) {
        CookedCubemap map = plainCubemap();
        for (auto& mip : map.mips)
            for (auto& face : mip.faces) face = Image<glm::vec4>(face.width(), face.height(), glm::vec4(0.005f));
        map.mips[level].faces[0].at(0, 0) *= 1.05f;
        const double found = stagesOf(map, reference, glm::dvec3(0.01), viewingOf(0.01))[2].specular.visible->max;
        EXPECT_LT(found, before);
        before = found;
    }
}

TEST(VisibleLut, AKernelWrongByFivePercentIsSeenUnderEachLight) {
    LutResult result;
    result.reference[0] = 0.25;
    result.cooked[0] = 0.2625;
    const std::vector<LutSample> samples = {{0.5, 0.3, true, false}};
    const auto stages = lutStages({}, samples, {result}, {1.0}, {}, viewingOf(1));
    // Every light has radiance 1 in the mean; the white surface below it differs (a light from d has the Legendre sum of d.z).
    const double reflected = 0.25 * std::sqrt(4 * std::numbers::pi);
    double squares = 0, largest = 0;
    for (int light = 0; light <= 12; ++light) {
        const double z = light == 0 ? 0 : lighting::fibonacciHemisphere(light - 1, 12).z;
        const double white = light == 0 ? 1 : 0.5 + 0.5 * (1 + 2 * z + 1.25 * (1.5 * z * z - 0.5));
        const double truth = visibleTruth(glm::dvec3(reflected / white), glm::dvec3(1.05 * reflected / white), kGrayNits);
        squares += truth * truth;
        largest = std::max(largest, truth);
    }
    const VisibleFigures& visible = stages[2].specular.visible.value();
    EXPECT_NEAR(visible.max, largest, toleranceOf(largest));
    EXPECT_NEAR(visible.rms, std::sqrt(squares / 13), toleranceOf(largest));
    EXPECT_EQ(visible.maxAt.m, 0.3);
    EXPECT_EQ(visible.maxAt.f0, 1);
    EXPECT_NEAR(visible.maxAt.view.z, 0.5, 1e-12);
    EXPECT_FALSE(stages[0].specular.visible.has_value()) << "entries are no light";
}

TEST(VisibleRsrm, OneTexelChangedByFivePercentIsFoundWithItsColours) {
    const std::vector<glm::vec3> gradient(16, glm::vec3(kLight));
    const double key = rsrmDisplayKey(gradient, lighting::kRec709Luminance);
    EXPECT_NEAR(key, luminanceOf(kLight), 1e-3 * key);
    CookedRsrm map;
    map.color = 1.05f * glm::vec3(kLight);
    map.exponents = {1, 16};
    map.texels = Image<glm::vec4>(8, 2, glm::vec4(1 / 1.05f));
    map.texels.at(3, 1) = glm::vec4(1);
    std::vector<RsrmRow> rows;
    for (int row = 0; row < 2; ++row) rows.push_back(compareRsrmRow(map, {gradient}, row, 1));
    const auto stages = rsrmStages(map, {gradient}, rows, lighting::kRec709Luminance, viewingOf(key));
    const double expected = visibleTruth(kLight, 1.05 * kLight, kGrayNits / key);
    EXPECT_LT(stages[0].diffuse.visible.value().max, 0.02);
    for (const StageError& stage : stages) {
        const VisibleFigures& visible = stage.specular.visible.value();
        EXPECT_NEAR(visible.max, expected, 0.01 + 2e-3 * expected);
        EXPECT_EQ(visible.maxAt.x, 3);
        EXPECT_EQ(visible.maxAt.y, 1);
        EXPECT_NEAR(visible.maxAt.found.x, 1.05 * kLight.x, 1e-4);
    }
    EXPECT_NEAR(stages[0].specular.visible->rms, expected / std::sqrt(8.0), 0.01 + 2e-3 * expected);
    EXPECT_FALSE(rsrmStages(map, {gradient}, rows, lighting::kRec709Luminance)[1].specular.visible.has_value());
}

/// Returns a strip of constant light that brightens by one unit a texel to the right.
formats::LightMapStrip ramp(int width, int height) {
    formats::LightMapStrip strip;
    strip.sh = Image<lighting::ShRgb>(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) strip.sh.at(x, y)[0] = static_cast<float>(1 + x) * glm::vec3(kLight);
    strip.covered = Image<std::uint8_t>(width, height, 1);
    strip.normal = Image<glm::vec3>(width, height, glm::vec3(0, 0, 1));
    return strip;
}

TEST(VisibleMesh, AShiftShowsTheLightBesideAndPositionsAddToIt) {
    const formats::LightMapStrip strip = ramp(5, 3);
    VisiblePairs pairs(viewingOf(1));
    addMeshShiftVisible(strip, 0, 3, {0.1, 0, 0}, 0.15, pairs);
    const double exit = 1 / std::sqrt(4 * std::numbers::pi);  // of a coefficient 1
    double largest = 0, squares = 0;
    for (int x = 0; x < 4; ++x)
        for (const double shift : {-0.25, 0.25}) {
            const double truth = visibleTruth(exit * (x + 1.5) * kLight, exit * (x + 1.5 + shift) * kLight, kGrayNits);
            largest = std::max(largest, truth);
            squares += truth * truth / 8;
        }
    const VisibleFigures figures = pairs.figures().value();
    EXPECT_NEAR(figures.max, largest, toleranceOf(largest));
    EXPECT_NEAR(figures.rms, std::sqrt(squares), toleranceOf(figures.rms));
    EXPECT_EQ(figures.maxAt.x, 0.5) << "the darkest quad";
}

TEST(VisibleMesh, NoPlaceExceedsTheBoundAndALargerShiftRaisesIt) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(-1, 1), positive(0, 1);
    constexpr int kMapSize = 8;
    formats::LightMapStrip strip = ramp(kMapSize, kMapSize);
    for (int y = 0; y < kMapSize; ++y)
        for (int x = 0; x < kMapSize; ++x) {
            lighting::ShRgb& sh = strip.sh.at(x, y);
            for (std::size_t i = 0; i < sh.size(); ++i)
                for (int c = 0; c < 3; ++c) sh[i][c] = static_cast<float>(i == 0 ? 2 + unit(random) : 0.4 * unit(random));
            strip.normal.at(x, y) = glm::vec3(glm::normalize(glm::dvec3(0.3 * unit(random), 0.3 * unit(random), 1)));
        }
    strip.covered.at(3, 3) = 0;
    const auto isInside = [&](const glm::ivec2& quad) {
        for (int corner = 0; corner < 4; ++corner)
            if (strip.covered.at(quad.x + corner % 2, quad.y + corner / 2) == 0) return false;
        return true;
    };
    const auto quadOf = [](const glm::dvec2& place) {
        return glm::ivec2(std::min(static_cast<int>(place.x), kMapSize - 2), std::min(static_cast<int>(place.y), kMapSize - 2));
    };
    const auto lightAt = [&](const glm::dvec2& place, const glm::dvec3& normal) {
        const glm::ivec2 quad = quadOf(place);
        lighting::ShRgb sum{};
        for (int corner = 0; corner < 4; ++corner) {
            const glm::dvec2 f = place - glm::dvec2(quad);
            const double weight = (corner % 2 == 1 ? f.x : 1 - f.x) * (corner / 2 == 1 ? f.y : 1 - f.y);
            for (std::size_t i = 0; i < sum.size(); ++i)
                sum[i] += static_cast<float>(weight) * strip.sh.at(quad.x + corner % 2, quad.y + corner / 2)[i];
        }
        return glm::dvec3(lighting::lambertExitRadiance(sum, glm::vec3(normal), glm::vec3(1)).value);
    };
    const Viewing viewing = viewingOf(0.5);
    double before = 0;
    for (const double size : {0.001, 0.05, 0.6}) {
        const MeshShift shift{0.6 * size, 0.8 * size, 0.1 * size};
        const double position = 0.2 * size;
        VisiblePairs pairs(viewing);
        addMeshShiftVisible(strip, 0, kMapSize, shift, position, pairs);
        addMeshShiftVisibleBound(strip, 0, kMapSize, shift, position, viewing, pairs);
        const VisibleFigures figures = pairs.figures().value();
        const double bound = figures.bound.value();
        EXPECT_GE(bound, figures.max);
        EXPECT_GT(bound, before);
        EXPECT_TRUE(figures.boundAt.isKnown());
        before = bound;
        double largest = 0;
        for (int i = 0; i < 20000; ++i) {
            const glm::dvec2 place(7 * positive(random), 7 * positive(random));
            // The corners of the shift are the worst.
            const glm::dvec2 moved = glm::clamp(place + glm::dvec2((unit(random) < 0 ? -1 : 1) * (shift.uTexels + position),
                                                                   (unit(random) < 0 ? -1 : 1) * (shift.vTexels + position)),
                                                glm::dvec2(0), glm::dvec2(7));
            if (!isInside(quadOf(place)) || !isInside(quadOf(moved))) continue;
            const glm::ivec2 quad = quadOf(place);
            const glm::dvec3 normal(strip.normal.at(quad.x + (unit(random) < 0 ? 0 : 1), quad.y + (unit(random) < 0 ? 0 : 1)));
            const glm::dmat3 frame = lighting::worldFromTangentFrame(normal);
            const double phi = std::numbers::pi * unit(random), angle = shift.normalRadians;
            const glm::dvec3 turned = frame * glm::dvec3(std::sin(angle) * std::cos(phi), std::sin(angle) * std::sin(phi), std::cos(angle));
            largest = std::max(largest, lighting::visibleDifference(lightAt(place, normal), lightAt(moved, turned), viewing.display));
        }
        EXPECT_LE(largest, bound) << size;
        EXPECT_GT(largest, 0.1 * bound) << size;
    }
    VisiblePairs far(viewing);
    addMeshShiftVisible(strip, 0, kMapSize, {3, 0, 0}, 0, far);
    addMeshShiftVisibleBound(strip, 0, kMapSize, {3, 0, 0}, 0, viewing, far);
    EXPECT_GT(far.figures()->bound.value(), 600) << "the largest difference of the display";
}

TEST(VisibleMesh, StripsHaveTheBoundOfTheWholeMap) {
    formats::LightMapStrip strip = ramp(5, 9);
    strip.sh.at(2, 6)[3] = glm::vec3(0.5f);
    const Viewing viewing = viewingOf(1);
    VisiblePairs whole(viewing), merged(viewing);
    addMeshShiftVisible(strip, 0, 9, {0.1, 0.2, 0}, 0, whole);
    addMeshShiftVisibleBound(strip, 0, 9, {0.1, 0.2, 0}, 0, viewing, whole);
    for (const auto& [first, count] : {std::pair{0, 4}, std::pair{4, 2}, std::pair{6, 3}}) {
        VisiblePairs part(viewing);
        addMeshShiftVisible(strip, first, count, {0.1, 0.2, 0}, 0, part);
        addMeshShiftVisibleBound(strip, first, count, {0.1, 0.2, 0}, 0, viewing, part);
        merged.merge(part);
    }
    EXPECT_NEAR(merged.figures()->bound.value(), whole.figures()->bound.value(), 1e-12);
}

TEST(VisibleMesh, ATurnedNormalShowsTheLightOfItsDirection) {
    formats::LightMapStrip strip = ramp(2, 2);
    const lighting::ShRgb light = lighting::projectDirectional(glm::vec3(0.6f, 0, 0.8f), glm::vec3(kLight));
    for (lighting::ShRgb& sh : strip.sh.texels()) sh = light;
    VisiblePairs pairs(viewingOf(1));
    addMeshShiftVisible(strip, 0, 2, {0, 0, 0.05}, 0, pairs);
    // The exit radiance of a light from d on a surface with normal n is its Legendre sum of n.d over 4 pi.
    const auto exit = [](const glm::dvec3& normal) {
        const double c = glm::dot(normal, glm::dvec3(0.6, 0, 0.8));
        return (1 + 2 * c + 1.25 * (1.5 * c * c - 0.5)) / (4 * std::numbers::pi);
    };
    double largest = 0;
    for (const double side : {-1.0, 1.0}) {
        const double off = std::tan(0.05) / std::numbers::sqrt2;
        const glm::dvec3 turned = glm::normalize(glm::dvec3(side * off, off, 1));
        largest = std::max(largest, visibleTruth(exit({0, 0, 1}) * kLight, exit(turned) * kLight, kGrayNits));
    }
    EXPECT_NEAR(pairs.figures()->max, largest, toleranceOf(largest) + 0.01 * largest);
}

/// Returns a unit square of two triangles, in the lower left quarter of a light map.
formats::TriangleMesh squareInAQuarter() {
    const auto attribute = [](const char* semantic, int components, const std::vector<float>& values) {
        formats::MeshAttribute result;
        result.semantic = semantic;
        result.componentCount = components;
        const auto bytes = std::as_bytes(std::span(values));
        result.values.assign(bytes.begin(), bytes.end());
        return result;
    };
    formats::TriangleMesh mesh;
    mesh.attributes = {attribute("POSITION", 3, {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}),
                       attribute("TEXCOORD_1", 2, {0, 0, 0.5f, 0, 0, 0.5f, 0.5f, 0.5f})};
    mesh.indices = {0, 1, 2, 1, 3, 2};
    return mesh;
}

TEST(VisibleMesh, TrianglesHaveTheirTexelsAndAreFoundByPlace) {
    const formats::TriangleMesh square = squareInAQuarter(), bare;
    const std::vector<const formats::TriangleMesh*> meshes = {&bare, &square};
    EXPECT_NEAR(texelsPerUnit(meshes, 64, 32), std::sqrt(32.0 * 16), 1e-5);
    EXPECT_EQ(texelsPerUnit({}, 64, 32), 0);
    const auto triangleAt = [&](double x, double y) {
        VisiblePlace place{.x = x, .y = y};
        findTriangle(meshes, 64, 32, place);
        return place.triangle;
    };
    EXPECT_EQ(triangleAt(4, 3), (MeshTriangle{1, 0}));
    EXPECT_EQ(triangleAt(30, 14), (MeshTriangle{1, 1}));
    EXPECT_EQ(triangleAt(50, 3), std::nullopt);
}

}  // namespace
}  // namespace lightcook::verify
