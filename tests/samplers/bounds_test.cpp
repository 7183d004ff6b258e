// The certified bound of every quad of texels against a real sampler: cooked light maps are fetched between their texels by Mesa and shaded
// by the cooked shader include, for random normals, views, roughnesses and F0. The result may not be farther from the filtered float bake
// than the bound.
#include <glm/geometric.hpp>

#include "lighting/brdf.h"
#include "lighting/radiometry.h"
#include "tests/formats/light_map_layouts.h"
#include "tests/samplers/cooked_scene.h"
#include "tests/samplers/layout_glsl.h"
#include "verify/light_map.h"
#include "verify/light_map/layouts.h"
#include "verify/sampler_tolerance.h"

namespace lightcook::samplers {
namespace {

using glm::vec3;
using glm::vec4;
using lighting::ShDouble;
using pipeline::Json;
using pipeline::SmallScene;

constexpr double kLowM = 0.1, kHighM = 0.5, kLowF0 = 0.04, kHighF0 = 0.6;

/// Random surfaces: as the shader reads them, and as nine factors of the light in the world frame.
class Surfaces {
public:
    static constexpr int kCount = 2048, kFloats = 19;
    explicit Surfaces(std::mt19937& random) {
        std::uniform_real_distribution<double> number;
        std::normal_distribution<double> normal;
        const auto direction = [&] { return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))); };
        for (int i = 0; i < kCount; ++i) {
            const double m = kLowM + (kHighM - kLowM) * number(random), f0 = kLowF0 + (kHighF0 - kLowF0) * number(random),
                         NoV = i % 8 == 0 ? 0.01 + 0.02 * number(random) : 0.01 + 0.98 * number(random);
            const glm::dvec3 n = direction(), x = glm::normalize(glm::cross(n, direction())), y = glm::cross(n, x);
            add(n, NoV * n + std::sqrt(1 - NoV * NoV) * x, f0, kernelOf(NoV, m));
            specular.push_back(lighting::ShRotation(glm::dmat3(x, y, n)).apply(sumOf(kernelOf(NoV, m), f0)));
            ShDouble row = lighting::evaluateBasis(n);
            for (std::size_t k = 0; k < row.size(); ++k)
                row[k] *= lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[k])];
            diffuse.push_back(row);
        }
    }
    std::vector<float> table;
    std::vector<ShDouble> diffuse, specular;

private:
    static lighting::AreaSpecularKernel kernelOf(double NoV, double m) {
        return lighting::integrateAreaSpecular(NoV, m, lighting::NormalDistribution::Beckmann, lighting::CookTorranceNormalization::Energy,
                                               48);
    }
    static ShDouble sumOf(const lighting::AreaSpecularKernel& kernel, double f0) {
        ShDouble sum;
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] = f0 * kernel.c[k] + (1 - f0) * kernel.d[k];
        return sum;
    }
    void add(const glm::dvec3& normal, const glm::dvec3& view, double f0, const lighting::AreaSpecularKernel& kernel) {
        for (const glm::dvec3& v : {normal, view})
            for (int i = 0; i < 3; ++i) table.push_back(static_cast<float>(v[i]));
        table.push_back(static_cast<float>(f0));
        for (const ShDouble* values : {&kernel.c, &kernel.d})
            for (const std::size_t k : {0, 2, 3, 6, 7, 8}) table.push_back(static_cast<float>((*values)[k]));
    }
};

/// Returns GLSL that shades `sh` with surface place.w, whose numbers begin at `first` of the table.
std::string surfaceGlsl(std::size_t first, bool isSpecular) {
    const std::string read = fmt::format("int at = {} + {} * int(place.w);\nvec3 n = vec3(TABLE(at), TABLE(at + 1), TABLE(at + 2));\n",
                                         first, Surfaces::kFloats);
    if (!isSpecular) return read + "result = vec4(lcExitRadiance(sh, n), 1.0);\n";
    const auto at = [](int i) { return fmt::format("TABLE(at + {})", i); };
    const auto four = [&](int a, int b, int c, int d) { return fmt::format("vec4({}, {}, {}, {})", at(a), at(b), at(c), at(d)); };
    return read +
           fmt::format(
               "LcFrame frame = lcViewFrame(n, vec3({}, {}, {}));\nLcSpecularKernel kernel;\nkernel.c0236 = {};\nkernel.d0236 = {};\n"
               "kernel.cd78 = {};\n"
               "result = vec4(lcAreaSpecular(lcLocalSh(sh, frame.x, frame.y, frame.z), kernel, vec3({})), 1.0);\n",
               at(3), at(4), at(5), four(7, 8, 9, 10), four(13, 14, 15, 16), four(11, 12, 17, 18), at(6));
}

/// A whole cooked map, as the verifier reads it.
struct Verified {
    verify::CookedLightMap map;
    verify::DecodedLightMapRows texels;
    formats::LightMapStrip reference;
    double key = 0;
    std::vector<glm::ivec2> quads;  ///< top left texels of covered quads

    Verified(const CookedScene& scene, const Json& asset, const std::filesystem::path& bake)
        : reference(valueOf(valueOf(formats::LightMapReader::open(bake, {})).read(0, asset.at("height").get<int>()))) {
        map.layout = asset.at("layout").get<std::string>();
        map.constants = scene.constants(asset);
        map.width = asset.at("width").get<int>();
        map.height = asset.at("height").get<int>();
        map.clusterOfBlock = scene.clusters(asset);
        for (const Json& texture : asset.at("textures")) {
            if (pipeline::isLookupRole(texture.at("role").get<std::string>())) continue;
            map.formats.push_back(*formats::pixelFormatFromName(texture.at("format").get<std::string>()));
            texels.textures.push_back(scene.decoded(asset, texture.at("role")));
            texels.spans.emplace_back();
            const auto reader = valueOf(pipeline::openTexture(
                scene.folder(), valueOf(pipeline::fromJson<pipeline::CookedAsset>(asset, "manifest")), texture.at("role")));
            for (int layer = 0; layer < reader.shape().layerCount; ++layer)
                texels.spans.back().push_back(
                    verify::blockSpans(map.formats.back(), valueOf(reader.readImage({0, layer, 0})), reader.shape().width));
        }
        layout_ = valueOf(verify::layouts::layoutOf(map));
        verify::LightMapKey measure;
        measure.add(reference, 0, map.height);
        key = measure.key();
        const auto covered = [&](int x, int y) { return reference.covered.at(x, y) != 0; };
        for (int y = 0; y + 1 < map.height; ++y)
            for (int x = 0; x + 1 < map.width; ++x)
                if (covered(x, y) && covered(x + 1, y) && covered(x, y + 1) && covered(x + 1, y + 1)) quads.emplace_back(x, y);
    }
    verify::LightMapVerifier verifier() const {
        verify::LightMapShading shading;
        shading.m = {kLowM, kHighM};
        shading.f0 = {kLowF0, kHighF0};
        shading.normalCount = shading.viewCount = 1;
        return valueOf(verify::LightMapVerifier::create(map, shading, {}, key));
    }
    /// Returns the cluster of a texel, 0 for layouts without clusters.
    int clusterOf(int x, int y) const {
        return std::visit(
            [&](const auto& each) {
                if constexpr (requires { each.tables; }) return static_cast<int>(each.tables->clusterAt(x, y));
                return 0;
            },
            layout_);
    }
    /// Returns the filtered bake at `at` [texels from the quad's top left centre].
    lighting::ShRgb referenceAt(const glm::ivec2& quad, const glm::dvec2& at) const {
        lighting::ShRgb sum{};
        for (int corner = 0; corner < 4; ++corner) {
            const auto weight = static_cast<float>((corner % 2 ? at.x : 1 - at.x) * (corner / 2 ? at.y : 1 - at.y));
            const lighting::ShRgb& texel = reference.sh.at(quad.x + corner % 2, quad.y + corner / 2);
            for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += weight * texel[k];
        }
        return sum;
    }

private:
    verify::layouts::Layout layout_;
};

class CertifiedBounds : public Samplers {
protected:
    /// Shades kPlacesAQuad places of each of `quadCount` quads, diffuse and specular.
    void expectInside(const CookedScene& scene, const std::string& name, const std::filesystem::path& bake, int quadCount,
                      const std::string& label);
    static constexpr int kPlacesAQuad = 50;
};

void CertifiedBounds::expectInside(const CookedScene& scene, const std::string& name, const std::filesystem::path& bake, int quadCount,
                                   const std::string& label) {
    const Json& asset = scene.asset(name);
    const Verified cooked(scene, asset, bake);
    ASSERT_FALSE(cooked.quads.empty());
    int unit = 0;
    for (const Json& texture : asset.at("textures"))
        if (LayoutGlsl::hasUnit(texture.at("role").get<std::string>())) {
            ASSERT_TRUE(gl_->upload(unit++, scene.ktx2(texture)));
        }

    const Surfaces surfaces(random_);
    const LayoutGlsl glsl(asset, scene.constants(asset));
    std::vector<float> table = glsl.tables();
    const std::size_t firstSurface = table.size();
    table.insert(table.end(), surfaces.table.begin(), surfaces.table.end());
    std::vector<glm::ivec2> quads;
    std::vector<vec4> places;
    for (int i = 0; i < quadCount; ++i) {
        quads.push_back(cooked.quads[random_() % cooked.quads.size()]);
        for (int place = 0; place < kPlacesAQuad; ++place) {
            const glm::dvec2 inside(uniform(), uniform());
            const glm::dvec2 uv =
                (glm::dvec2(quads.back()) + 0.5 + inside) / glm::dvec2(static_cast<double>(cooked.map.width), cooked.map.height);
            const int corner = place % 4;
            places.emplace_back(glm::vec2(uv), cooked.clusterOf(quads.back().x + corner % 2, quads.back().y + corner / 2),
                                random_() % Surfaces::kCount);
        }
    }
    const auto shade = [&](bool isSpecular) {
        return gl_->run(scene.shader() + glsl.samplers(), glsl.decode() + surfaceGlsl(firstSurface, isSpecular), places, {}, table);
    };
    const std::array<std::vector<vec4>, 2> shaded = {shade(false), shade(true)};
    const verify::LightMapVerifier verifier = cooked.verifier();
    std::array<double, 2> nearest{};
    int above = 0;
    verify::LightMapVerifier::QuadBound bound;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const std::size_t q = i / static_cast<std::size_t>(kPlacesAQuad);
        if (i % static_cast<std::size_t>(kPlacesAQuad) == 0)
            bound = verifier.boundQuad(cooked.texels, cooked.reference, quads[q].x, quads[q].y);
        const glm::dvec2 at = glm::dvec2(places[i]) * glm::dvec2(cooked.map.width, cooked.map.height) - 0.5 - glm::dvec2(quads[q]);
        const lighting::ShRgb light = cooked.referenceAt(quads[q], at);
        for (const bool isSpecular : {false, true}) {
            const auto surface = static_cast<std::size_t>(places[i].w);
            const ShDouble& row = isSpecular ? surfaces.specular[surface] : surfaces.diffuse[surface];
            const double allowed = isSpecular ? bound.specular : bound.diffuse;
            for (int channel = 0; channel < 3; ++channel) {
                double reference = 0;
                for (std::size_t k = 0; k < row.size(); ++k) reference += row[k] * static_cast<double>(light[k][channel]);
                const double local = std::abs(static_cast<double>(shaded[isSpecular][i][channel]) - reference) /
                                     (std::abs(reference) + lighting::kLocalErrorFloor * cooked.key);
                nearest[isSpecular] = std::max(nearest[isSpecular], local / allowed);
                // Not ">": NaN must fail.
                if (!(local <= allowed) && ++above == 1)
                    ADD_FAILURE() << fmt::format("{}, quad ({}, {}), {} of it, channel {}, {}: off by {:.6g}, proven {:.6g}", label,
                                                 quads[q].x, quads[q].y, at.x, channel, isSpecular ? "specular" : "diffuse", local,
                                                 allowed);
            }
        }
    }
    std::printf("figures %-22s %zu places, two shadings each: nearest to the bound %.2f diffuse, %.2f specular\n", label.c_str(),
                places.size(), nearest[0], nearest[1]);
    EXPECT_EQ(above, 0) << "of " << places.size();
    // Some error must come near its bound. The tolerance of float formats is that of the filter's fractions, which Mesa computes exactly.
    EXPECT_GE(std::max(nearest[0], nearest[1]), cooked.map.layout == "raw" ? 0.0 : 0.02) << label;
}

/// Returns light that changes from texel to texel, with dark texels beside bright ones.
vec3 harshLight(const glm::dvec3& direction, const glm::dvec2& place) {
    const double ring = std::sin(40 * place.x + 23 * place.y) * std::sin(61 * place.y), lamp = std::exp(6 * ring);
    const double towards =
        std::max(0.0, glm::dot(direction, glm::normalize(glm::dvec3(std::cos(9 * place.x), std::sin(9 * place.y), 0.5))));
    return vec3(lamp * towards * glm::dvec3(1.0, 0.7, 0.4) + glm::dvec3(0.02, 0.03, 0.05));
}

/// Returns a layout by formula and a learned one, or the others for the soak: tests/verify holds the bounds of each family.
std::vector<formats::LightMapLayout> layoutsOf(bool isSoak) {
    std::vector<formats::LightMapLayout> layouts = test::directionalLayouts();
    std::erase_if(layouts, [&](formats::LightMapLayout layout) {
        const bool isInCi = layout == formats::LightMapLayout::Ratio || layout == formats::LightMapLayout::Basis4;
        return isInCi == isSoak;
    });
    return layouts;
}

class CertifiedBoundsOf : public CertifiedBounds, public testing::WithParamInterface<formats::LightMapLayout> {};
TEST_P(CertifiedBoundsOf, HoldForWhatMesaShadesBetweenTexels) {
    const std::string layout(formats::info(GetParam()).name);
    const SmallScene made(SmallScene::Parts::LightMap, harshLight);
    const CookedScene scene(made.sceneFile(), layout, "light-map", 1.0);
    expectInside(scene, "map", made / "map.exr", 400, layout);
}
INSTANTIATE_TEST_SUITE_P(Some, CertifiedBoundsOf, testing::ValuesIn(layoutsOf(false)), test::nameOfLayout);
INSTANTIATE_TEST_SUITE_P(Soak, CertifiedBoundsOf, testing::ValuesIn(layoutsOf(true)), test::nameOfLayout);

class CertifiedBoundsSoak : public CertifiedBounds, public testing::WithParamInterface<const char*> {};
TEST_P(CertifiedBoundsSoak, HoldForWhatMesaShadesOfAPublicScene) {
    const std::filesystem::path bake =
        std::filesystem::absolute(LIGHTCOOK_SHARED_DATA) / "scenes" / (std::string(GetParam()) + "_lightmap.exr");
    if (!std::filesystem::exists(bake)) GTEST_SKIP() << "no shared data at " << bake;
    const formats::TemporaryFolder folder;
    formats::writeContent(folder / "scene.toml", fmt::format("schema = 1\nname = \"{}\"\n[[light_map]]\nname = \"map\"\nfile = \"{}\"\n",
                                                             GetParam(), bake.string()));
    for (const std::string& layout : test::namesOf(test::directionalLayouts()))
        expectInside(CookedScene(folder / "scene.toml", layout, "light-map", 1.0), "map", bake, 2000,
                     fmt::format("{} {}", GetParam(), layout));
}
INSTANTIATE_TEST_SUITE_P(Public, CertifiedBoundsSoak, testing::Values("cornell", "interior", "outdoor", "zdm2_sun"),
                         [](const auto& each) { return std::string(each.param); });

}  // namespace
}  // namespace lightcook::samplers
