// The public scenes between their texels: a million random places each, filtered and shaded here, held against what the verifier proved.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <random>

#include "lighting/brdf.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "tests/verify/cooked_light_map.h"
#include "verify/light_map_layouts.h"

namespace {

using compress::LightMapLayout;
using test::Cooked;

constexpr int kPlaces = 1'000'000, kStripRows = 16;
constexpr std::size_t kDirections = 256, kDirectionsAPlace = 2;

struct Place {
    int x, y;
    float u, v;
    int corner;  ///< whose decode a surface there brings along
};

/// Factors of the nine coefficients of light, in the world's frame.
using Shading = std::vector<lighting::ShDouble>;

class Shadings {
public:
    explicit Shadings(std::mt19937_64& random) {
        std::normal_distribution<double> gauss;
        std::uniform_real_distribution<double> uniform;
        const auto direction = [&] { return glm::normalize(glm::dvec3(gauss(random), gauss(random), gauss(random))); };
        for (std::size_t i = 0; i < kDirections; ++i) {
            lighting::ShDouble normal = lighting::evaluateBasis(direction());
            for (std::size_t k = 0; k < normal.size(); ++k)
                normal[k] *= lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[k])];
            diffuse.push_back(normal);
            const double m = 0.1 + 0.4 * uniform(random), f0 = 0.04 + 0.56 * uniform(random), NoV = std::max(1e-3, uniform(random));
            const auto kernel = lighting::integrateAreaSpecular(NoV, m, lighting::NormalDistribution::Beckmann,
                                                                lighting::CookTorranceNormalization::Energy, 64);
            lighting::ShDouble sum;
            for (std::size_t k = 0; k < sum.size(); ++k) sum[k] = f0 * kernel.c[k] + (1 - f0) * kernel.d[k];
            specular.push_back(lighting::ShRotation(lighting::worldFromTangentFrame(direction())).apply(sum));
        }
    }
    Shading diffuse, specular;
};

template <class Get>
auto filtered(const Place& p, Get&& get) {
    return (1 - p.v) * ((1 - p.u) * get(p.x, p.y) + p.u * get(p.x + 1, p.y)) +
           p.v * ((1 - p.u) * get(p.x, p.y + 1) + p.u * get(p.x + 1, p.y + 1));
}

/// The shipped shader's coefficients at a place.
shaders::LcSh decodedAt(const verify::layouts::Layout& any, const Cooked& cooked, const Place& place) {
    return std::visit(
        [&](const auto& layout) {
            verify::layouts::Texels<std::decay_t<decltype(layout)>::kLayers> texels{};
            std::size_t next = 0;
            for (const auto& texture : cooked.texels.textures)
                for (const auto& image : texture)
                    texels[next++] = filtered(place, [&](int x, int y) -> const glm::vec4& { return image.at(x, y); });
            return verify::layouts::decodeAt(layout, place.x + place.corner % 2, place.y + place.corner / 2).decode(texels);
        },
        any);
}

/// Largest local errors by strips of rows.
struct Worst {
    std::vector<double> diffuse, specular;
};

Worst sampled(const Cooked& cooked, const Shadings& shadings, int places, std::mt19937_64& random) {
    const auto strips = static_cast<std::size_t>((cooked.map.height + kStripRows - 1) / kStripRows);
    Worst worst{std::vector<double>(strips), std::vector<double>(strips)};
    std::vector<Place> quads;
    const auto covered = [&](int x, int y) { return cooked.reference.covered.at(x, y) != 0; };
    for (int y = 0; y + 1 < cooked.map.height; ++y)
        for (int x = 0; x + 1 < cooked.map.width; ++x)
            if (covered(x, y) && covered(x + 1, y) && covered(x, y + 1) && covered(x + 1, y + 1)) quads.push_back({x, y, 0, 0, 0});
    const auto layout = verify::layouts::layoutOf(cooked.map);
    std::uniform_real_distribution<float> fraction;
    for (int i = 0; i < places; ++i) {
        Place place = quads[random() % quads.size()];
        place.u = fraction(random);
        place.v = fraction(random);
        place.corner = static_cast<int>(random() % 4);
        const shaders::LcSh decoded = decodedAt(*layout, cooked, place);
        lighting::ShRgb reference;
        for (std::size_t k = 0; k < reference.size(); ++k)
            reference[k] = filtered(place, [&](int x, int y) -> const glm::vec3& { return cooked.reference.sh.at(x, y)[k]; });
        const auto raise = [&](const lighting::ShDouble& shading, double& largest) {
            glm::dvec3 error(0), light(0);
            for (std::size_t k = 0; k < reference.size(); ++k) {
                light += shading[k] * glm::dvec3(reference[k]);
                error += shading[k] * (glm::dvec3(decoded.c[k]) - glm::dvec3(reference[k]));
            }
            for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(error[c]) / (std::abs(light[c]) + 0.02 * cooked.key));
        };
        const auto strip = static_cast<std::size_t>(place.y / kStripRows);
        for (std::size_t k = 0; k < kDirectionsAPlace; ++k) {
            raise(shadings.diffuse[random() % kDirections], worst.diffuse[strip]);
            raise(shadings.specular[random() % kDirections], worst.specular[strip]);
        }
    }
    return worst;
}

void expectWithinTheBound(const std::string& scene, LightMapLayout layout, int effort) {
    const std::filesystem::path file = std::filesystem::path(LIGHTCOOK_SHARED_DATA) / "scenes" / (scene + "_lightmap.exr");
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "the shared scenes are not here";
    const auto reader = formats::LightMapReader::open(file, {});
    ASSERT_TRUE(reader.has_value()) << reader.error().line();
    auto band = reader->read(0, reader->height());
    ASSERT_TRUE(band.has_value()) << band.error().line();
    const Cooked cooked = test::cook(std::move(*band), layout, compress::LightMapTarget::Bc, effort);
    std::mt19937_64 random(23);
    const Shadings shadings(random);
    const Worst worst = sampled(cooked, shadings, kPlaces, random);
    verify::LightMapSampling sampling;
    sampling.positionsPerQuad = 0;
    // Bounds are of the whole ranges and of every view: what the verifier would sample itself is not asked for.
    verify::LightMapShading shading;
    shading.m = {0.1, 0.5};
    shading.normalCount = shading.viewCount = 1;
    const verify::LightMapVerifier verifier = cooked.verifier(shading, sampling);
    double nearest = 0;
    for (std::size_t strip = 0; strip < worst.diffuse.size(); ++strip) {
        const int firstRow = static_cast<int>(strip) * kStripRows, rowCount = std::min(kStripRows, cooked.map.height - firstRow);
        const verify::StageError total = verifier.verifyRows(cooked.texels, cooked.reference, firstRow, rowCount).stages().back();
        EXPECT_LE(worst.diffuse[strip], total.diffuse.maxBound) << scene << ' ' << cooked.map.layout << ", row " << firstRow;
        EXPECT_LE(worst.specular[strip], total.specular.maxBound) << scene << ' ' << cooked.map.layout << ", row " << firstRow;
        if (total.diffuse.maxBound > 0) nearest = std::max(nearest, worst.diffuse[strip] / total.diffuse.maxBound);
    }
    // A bound that nothing comes near would hold anything. Halfs of a bake in halfs (raw) have no error to come near with.
    if (std::ranges::max(worst.diffuse) > 1e-6) {
        EXPECT_GT(nearest, 0.1);
    }
}

using SceneAndLayout = std::tuple<const char*, LightMapLayout>;
std::string nameOf(const testing::TestParamInfo<SceneAndLayout>& tested) {
    std::string name = std::string(std::get<0>(tested.param)) + "_" + std::string(compress::lightMapLayoutName(std::get<1>(tested.param)));
    std::ranges::replace(name, '-', '_');
    return name;
}

class MagnifiedScenes : public testing::TestWithParam<SceneAndLayout> {};
TEST_P(MagnifiedScenes, NoPlaceExceedsTheBoundOfItsRows) {
    expectWithinTheBound(std::get<0>(GetParam()), std::get<1>(GetParam()), 1);
}
constexpr auto kScenes = {"cornell", "interior", "outdoor", "zdm2_sun"};
INSTANTIATE_TEST_SUITE_P(Scenes, MagnifiedScenes,
                         testing::Combine(testing::ValuesIn(kScenes), testing::Values(LightMapLayout::Ratio, LightMapLayout::Basis4)),
                         nameOf);

class MagnifiedScenesSoak : public testing::TestWithParam<SceneAndLayout> {};
TEST_P(MagnifiedScenesSoak, NoPlaceExceedsTheBoundOfItsRows) {
    expectWithinTheBound(std::get<0>(GetParam()), std::get<1>(GetParam()), 3);
}
INSTANTIATE_TEST_SUITE_P(Scenes, MagnifiedScenesSoak,
                         testing::Combine(testing::ValuesIn(kScenes),
                                          testing::Values(LightMapLayout::Raw, LightMapLayout::Luvw, LightMapLayout::LuvwLinear,
                                                          LightMapLayout::Zh3, LightMapLayout::Basis3, LightMapLayout::Basis8,
                                                          LightMapLayout::Basis12, LightMapLayout::Basis16)),
                         nameOf);

}  // namespace
