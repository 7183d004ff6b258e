// Cooked assets as an engine uses them: cooked files and shader include on a GPU's sampler, against the verifier's texture unit and the
// same source compiled as C++.
#include <gmock/gmock.h>

#include "formats/light_map_detail.h"
#include "lighting/cube.h"
#include "tests/formats/light_map_layouts.h"
#include "tests/samplers/cooked_scene.h"
#include "tests/samplers/layout_glsl.h"
#include "tests/samplers/second_opinion.h"
#include "verify/light_map/layouts.h"

namespace lightcook::samplers {
namespace {

using glm::vec3;
using glm::vec4;
using pipeline::Json;
using pipeline::SmallScene;

// ---- light maps ----

struct LightMapCase {
    std::string target, layout;
    double detail = 0;  ///< visible error that it keeps; 0: the map has none
};

/// Light maps shaded with random normals, at random places and at texel centres.
class LightMapShading : public Samplers {
protected:
    /// No place may differ by more than the sum of the tolerances of all channels of all texels. Roundings cancel, so that the RMS
    /// difference is a fraction of that.
    void expectShadedAsOurs(const CookedScene& scene, const std::string& name, const std::string& label);
    static constexpr double kWholeShare = 0.15;
};
class LightMaps : public LightMapShading, public testing::WithParamInterface<LightMapCase> {};

/// Returns the tolerance of a texel, apart from the filter's fractions: see formats_test.cpp.
float texelSlack(const std::string& format) {
    if (format == "bc1" || format == "bc3") return 4.0f / 255;
    return format == "bc7" || format == "rgba8-unorm" ? 2.0f / 255 : 0.0f;
}

/// The light that a place of a map shows, and how far that of a device may be from it.
struct Shown {
    vec3 light, allowed;
};

/// The decoded textures of a map's detail.
struct DetailTexels {
    verify::layouts::Layout layout;
    Image places;               ///< the second layer of texture "coverage"
    std::vector<Image> layers;  ///< in the order of the layout's textures
    std::vector<float> slack;   ///< [layer]

    /// Returns the texel that the shader takes in place of one of the map.
    std::optional<glm::ivec2> placeOf(const glm::ivec2& texel) const {
        const glm::ivec4 tile(glm::round(255.0f * places.at(texel.x / 8, texel.y / 4)));
        if (tile.w != 255) return std::nullopt;
        return glm::ivec2(8 * tile.x + texel.x % 8, 4 * (tile.y + 256 * tile.z) + texel.y % 4);
    }
};

/// The decoded textures of a light map. Each layer has the tolerance of its texels, and the side of the squares of the map that read them.
struct MapTexels {
    int width = 0, height = 0;
    std::vector<Image> layers;
    std::vector<float> slack;
    std::vector<int> sides;
    Image coverage;  ///< of a map whose filter is decoded
    std::shared_ptr<const DetailTexels> detail = {};

    /// Reads a bit of texture "coverage".
    bool isCovered(const glm::ivec2& texel) const {
        const float stored = coverage.at(texel.x / 8, texel.y / 4)[texel.y % 4];
        return (static_cast<int>(std::lround(255 * stored)) >> texel.x % 8 & 1) != 0;
    }
};

/// To first order, the tolerance is the sum of the effects of each channel of each texel; half more for products of two.
/// off  of each texel
template <class Texels, class Shade>
Shown shownWithin(const Texels& texels, const Texels& off, const Shade& shade) {
    Shown shown{shade(texels), {}};
    shown.allowed = 1e-5f * glm::abs(shown.light) + 1e-7f;
    for (std::size_t layer = 0; layer < texels.size(); ++layer)
        for (int channel = 0; channel < 4; ++channel) {
            Texels moved = texels;
            moved[layer][channel] += off[layer][channel];
            shown.allowed += 1.5f * glm::abs(shade(moved) - shown.light);
        }
    return shown;
}

/// Shades the filtered texels of a place.
template <class Layout>
Shown shadeFiltered(const Layout& layout, const MapTexels& map, const glm::dvec2& uv, const vec3& normal) {
    verify::layouts::Texels<Layout::kLayers> texels{}, off{};
    const glm::ivec2 texel(static_cast<int>(uv.x * map.width), static_cast<int>(uv.y * map.height));
    for (std::size_t layer = 0; layer < texels.size(); ++layer) {
        const auto sample = [&](const glm::dvec2& at) { return verify::sampleBilinear(map.layers[layer].view(), at); };
        texels[layer] = sample(uv);
        off[layer] = filterSlack(sample, uv, {1.0 / map.width, 1.0 / map.height}) + map.slack[layer];
    }
    return shownWithin(texels, off, [&](const auto& moved) {
        return shaders::lcExitRadiance(verify::layouts::decodeAt(layout, texel.x, texel.y).decode(moved), normal);
    });
}

/// Shades a texel: that of its layers at `at`, which is divided by their sides.
template <class Layout>
Shown shadeTexel(const Layout& layout, const std::vector<Image>& layers, const std::vector<float>& slack, const std::vector<int>& sides,
                 const glm::ivec2& at, const vec3& normal) {
    verify::layouts::Texels<Layout::kLayers> texels{}, off{};
    for (std::size_t layer = 0; layer < texels.size(); ++layer) {
        texels[layer] = layers[layer].at(at.x / sides[layer], at.y / sides[layer]);
        off[layer] = vec4(slack[layer]);
    }
    return shownWithin(texels, off, [&](const auto& moved) {
        return shaders::lcExitRadiance(verify::layouts::decodeAt(layout, at.x, at.y).decode(moved), normal);
    });
}
/// Shades the detail of a texel.
Shown shadeDetail(const DetailTexels& detail, const glm::ivec2& at, const vec3& normal) {
    const std::vector<int> sides(detail.layers.size(), 1);
    return std::visit([&](const auto& layout) { return shadeTexel(layout, detail.layers, detail.slack, sides, at, normal); },
                      detail.layout);
}

/// Mixes what the covered texels around a place show.
template <class Layout>
Shown shadeMixed(const Layout& layout, const MapTexels& map, const glm::dvec2& uv, const vec3& normal) {
    const glm::dvec2 place = uv * glm::dvec2(map.width, map.height) - 0.5, low = glm::floor(place), f = place - low;
    Shown sums[2] = {};  // of all texels, and of the covered ones
    double weights[2] = {};
    for (int corner = 0; corner < 4; ++corner) {
        const glm::ivec2 texel =
            glm::clamp(glm::ivec2(low) + glm::ivec2(corner % 2, corner / 2), glm::ivec2(0), glm::ivec2(map.width, map.height) - 1);
        const double weight = (corner % 2 ? f.x : 1 - f.x) * (corner / 2 ? f.y : 1 - f.y);
        const auto detailed = map.detail ? map.detail->placeOf(texel) : std::nullopt;
        const Shown shown =
            detailed ? shadeDetail(*map.detail, *detailed, normal) : shadeTexel(layout, map.layers, map.slack, map.sides, texel, normal);
        for (int i = 0; i < (map.isCovered(texel) ? 2 : 1); ++i) {
            weights[i] += weight;
            sums[i].light += static_cast<float>(weight) * shown.light;
            // The weights of the shader are floats of places up to 100 texels from the origin.
            sums[i].allowed += static_cast<float>(weight) * shown.allowed + 1e-5f * glm::abs(shown.light);
        }
    }
    const int i = weights[1] > 0 ? 1 : 0;
    return {sums[i].light / static_cast<float>(weights[i]), sums[i].allowed / static_cast<float>(weights[i])};
}

/// Returns the detail of a map without its texels; null if it has none.
std::shared_ptr<DetailTexels> detailOf(const Json& asset) {
    if (!asset.contains("detail")) return nullptr;
    verify::CookedLightMap map;
    map.layout = asset.at("detail").at("layout").get<std::string>();
    map.constants = asset.at("detail").at("constants").get<pipeline::LightMapConstants>();
    return std::make_shared<DetailTexels>(DetailTexels{valueOf(verify::layouts::layoutOf(map)), {}, {}, {}});
}

void LightMapShading::expectShadedAsOurs(const CookedScene& scene, const std::string& name, const std::string& label) {
    const Json& asset = scene.asset(name);
    verify::CookedLightMap map;
    map.layout = asset.at("layout").get<std::string>();
    map.constants = scene.constants(asset);
    map.width = asset.at("width").get<int>();
    map.height = asset.at("height").get<int>();
    map.clusterOfBlock = scene.clusters(asset);
    const auto layout = valueOf(verify::layouts::layoutOf(map));
    MapTexels texels{map.width, map.height, {}, {}, {}, {}};
    const std::shared_ptr<DetailTexels> detail = detailOf(asset);
    texels.detail = detail;
    int unit = 0;
    for (const Json& texture : asset.at("textures")) {
        const std::string role = texture.at("role").get<std::string>();
        if (!LayoutGlsl::hasUnit(role)) continue;
        ASSERT_TRUE(gl_->upload(unit++, scene.ktx2(texture)));
        std::vector<Image> layers = scene.decoded(asset, role);
        if (role == formats::kCoverageRole) {
            texels.coverage = std::move(layers[0]);
            if (detail) detail->places = std::move(layers[1]);
            continue;
        }
        if (formats::isOfDetail(role)) {
            for (Image& image : layers) {
                detail->layers.push_back(std::move(image));
                detail->slack.push_back(texelSlack(texture.at("format").get<std::string>()));
            }
            continue;
        }
        for (Image& image : layers) {
            texels.layers.push_back(std::move(image));
            texels.slack.push_back(texelSlack(texture.at("format").get<std::string>()));
            texels.sides.push_back(formats::findByName(verify::layouts::infoOf(layout).textures, role)->side);
        }
    }
    const auto clusterAt = [&](const glm::dvec2& uv) {
        const auto at = [](double coordinate, int size) { return std::clamp(static_cast<int>(coordinate * size), 0, size - 1); };
        return std::visit(
            [&](const auto& each) -> std::size_t {
                if constexpr (requires { each.tables; }) return each.tables->clusterAt(at(uv.x, map.width), at(uv.y, map.height));
                return 0;
            },
            layout);
    };
    std::vector<vec4> places, normals;
    for (int i = 0; i < 3000; ++i) {
        const glm::dvec2 uv = i % 4 == 0 ? glm::dvec2((i * 7 % map.width + 0.5) / map.width, (i * 11 % map.height + 0.5) / map.height)
                                         : glm::dvec2(uniform(0, 1), uniform(0, 1));
        places.emplace_back(static_cast<float>(uv.x), static_cast<float>(uv.y), static_cast<float>(clusterAt(uv)), 0);
        normals.emplace_back(vec3(direction()), 0);
    }
    const LayoutGlsl glsl(asset, scene.constants(asset));
    const auto shaded = gl_->run(scene.shader() + glsl.samplers(), glsl.decode() + "result = vec4(lcExitRadiance(sh, direction.xyz), 1.0);",
                                 places, normals, glsl.tables());

    Agreement agreement;
    double squares = 0, errors = 0, most = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const glm::dvec2 uv(places[i]);
        const auto [ours, allowed] = std::visit(
            [&](const auto& each) {
                const bool isMixed = verify::layouts::DecodedBeforeFilter<std::decay_t<decltype(each)>> || detail;
                return isMixed ? shadeMixed(each, texels, uv, vec3(normals[i])) : shadeFiltered(each, texels, uv, vec3(normals[i]));
            },
            layout);
        for (int channel = 0; channel < 3; ++channel) {
            agreement.add(ours[channel], shaded[i][channel], static_cast<double>(allowed[channel]),
                          fmt::format("place ({}, {}), channel {}", uv.x * map.width, uv.y * map.height, channel));
            squares += static_cast<double>(ours[channel]) * static_cast<double>(ours[channel]);
            const double error = static_cast<double>(ours[channel]) - static_cast<double>(shaded[i][channel]);
            errors += error * error;
            most += static_cast<double>(allowed[channel]) * static_cast<double>(allowed[channel]);
        }
    }
    const double share = std::sqrt(errors / most);
    std::printf("figures %-24s rms of the difference %.3g %%, largest %.3g, %.2f of what is allowed, the whole %.2f\n", label.c_str(),
                100 * std::sqrt(errors / squares), agreement.difference, agreement.part, share);
    EXPECT_LE(agreement.part, 1) << agreement.worst;
    EXPECT_LE(share, kWholeShare) << label;
}

TEST_P(LightMaps, ShadeAsOursBetweenTexels) {
    const auto [target, layout, detail] = GetParam();
    const CookedScene scene(SmallScene::Parts::LightMap, target, layout, detail);
    EXPECT_EQ(scene.asset("map").contains("detail"), detail > 0);
    expectShadedAsOurs(scene, "map", fmt::format("{} {}{}", target, layout, detail > 0 ? " and detail" : ""));
}

/// Returns every layout for target bc, three for target float, and two with detail.
std::vector<LightMapCase> lightMapCases() {
    std::vector<LightMapCase> cases;
    // A layout in tangent space needs a mesh, and is shaded as the engine does (tests/shaders).
    for (const formats::LightMapLayoutInfo& row : formats::allLightMapLayouts())
        if (!row.isInTangentSpace) cases.push_back({"bc", std::string(row.name)});
    for (const char* layout : {"basis-8", "ratio", "halo3"}) cases.push_back({"float", layout});
    cases.push_back({"bc", "basis-4", 2.2});
    cases.push_back({"bc", "lit-half", 2});
    return cases;
}

/// One test, because starting a browser is slow.
class BrowserLightMaps : public InABrowser<LightMapShading> {
protected:
    void expectShadedInABrowserAsOurs(const LightMapCase& each) {
        SCOPED_TRACE(each.layout);
        const CookedScene scene(SmallScene::Parts::LightMap, each.target, each.layout, each.detail);
        expectShadedAsOurs(scene, "map", fmt::format("{} {}, browser", each.target, each.layout));
    }
};
using BrowserLightMapsSoak = BrowserLightMaps;

TEST_F(BrowserLightMaps, ShadeAsOursBetweenTexels) {
    expectShadedInABrowserAsOurs({"bc", "basis-8"});
}
TEST_F(BrowserLightMapsSoak, OfEveryLayoutShadeAsOursBetweenTexels) {
    for (const LightMapCase& each : lightMapCases()) {
        if (each.target == "float") continue;           // 16-bit unorms
        if (each.layout.starts_with("lit-")) continue;  // sides that are no multiples of 4: WebGL2 takes none in BC formats
        expectShadedInABrowserAsOurs(each);
    }
}

/// Returns the cases that CI runs, a layout of each family, `float` once and detail, or those that it leaves to the soak.
std::vector<LightMapCase> casesOf(bool isSoak) {
    const std::vector<formats::LightMapLayout> first = test::layoutsOfEveryFamily();
    std::vector<LightMapCase> cases;
    bool hasFloat = false;
    for (const LightMapCase& each : lightMapCases()) {
        const bool isFloat = each.target == "float";
        const bool isFirst = std::ranges::count(first, *formats::lightMapLayoutFromName(each.layout)) > 0;
        const bool isInCi = isFloat ? !hasFloat : isFirst || each.detail > 0;
        hasFloat = hasFloat || isFloat;
        if (isInCi != isSoak) cases.push_back(each);
    }
    return cases;
}
std::string nameOfCase(const testing::TestParamInfo<LightMapCase>& tested) {
    std::string name = fmt::format("{}_{}{}", tested.param.target, tested.param.layout, tested.param.detail > 0 ? "_detail" : "");
    std::ranges::replace(name, '-', '_');
    return name;
}
INSTANTIATE_TEST_SUITE_P(EveryFamily, LightMaps, testing::ValuesIn(casesOf(false)), nameOfCase);
INSTANTIATE_TEST_SUITE_P(Soak, LightMaps, testing::ValuesIn(casesOf(true)), nameOfCase);

// ---- cubemap, reflection map, every texture ----

class Converters : public LightMapShading {
protected:
    void expectCubemapAsOurs(const CookedScene& scene, const std::string& name);
    void expectReflectionMapAsOurs(const CookedScene& scene, const std::string& name);
    /// Compares fetches at texel centres, and filtered ones between them.
    void expectTextureAsOurs(const CookedScene& scene, const Json& asset, const Json& texture);
    /// Cooks a public scene, if its data exist.
    void expectPublicSceneAsOurs(const std::string& scene);
    void expectEveryTextureAsOurs(const CookedScene& scene) {
        for (const Json& asset : scene.assets())
            for (const Json& texture : asset.at("textures"))
                if (asset.at("kind") == "cubemap")
                    expectCubemapAsOurs(scene, asset.at("name"));
                else
                    expectTextureAsOurs(scene, asset, texture);
    }
};

constexpr float kHalfRounding = 1.0f / 4096;  ///< half a step of ten bits, relative

/// Compares samples across faces and mips, and shaded radiance.
void Converters::expectCubemapAsOurs(const CookedScene& scene, const std::string& name) {
    const Json& asset = scene.asset(name);
    const Json& constants = asset.at("constants");
    ASSERT_TRUE(gl_->upload(0, scene.ktx2(asset.at("textures")[0])));
    const std::vector<Image> images = scene.decoded(asset, "cubemap");
    const int mipCount = static_cast<int>(images.size()) / 6;
    const auto facesOf = [&](int mip) { return std::span(images).subspan(6 * static_cast<std::size_t>(mip), 6); };
    shaders::LcSh sh;
    std::string declarations = scene.shader() + "layout(binding = 0) uniform samplerCube probe;\n", body = "LcSh sh;\n";
    const auto range = constants.at("range").get<float>();
    for (std::size_t i = 0; i < 9; ++i) {
        const auto values = constants.at("windowed_sh")[i].get<std::vector<float>>();
        sh.c[i] = vec3(values[0], values[1], values[2]);
        body += fmt::format("sh.c[{}] = {};\n", i, glslVector(values, 0, 3));
    }
    const auto bands = constants.at("mips")[0].at("bands").get<std::vector<float>>();
    body += fmt::format("vec3 S = lcZonalSpecular(sh, normalize(direction.xyz), {});\n", glslVector(bands, 0, 3)) +
            fmt::format("result = vec4(lcEnvironment({} * textureLod(probe, direction.xyz, place.x).xyz, S), 1.0);",
                        glslFloat(static_cast<double>(range)));

    std::vector<vec4> places, directions;
    for (int i = 0; i < 12000; ++i) {
        glm::dvec3 d = direction();
        if (i % 3 == 0) d /= std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
        if (i % 3 == 0)
            d[i / 3 % 3] = (d[i / 3 % 3] < 0 ? -1 : 1) * (1 - 1e-3 * static_cast<double>(uniform()));  // near an edge or a corner
        const int mip = i % mipCount;
        places.emplace_back(i % 2 == 0 || mip + 1 == mipCount ? mip : static_cast<float>(mip) + uniform(), 0, 0, 0);
        directions.emplace_back(vec3(d), 0);
    }
    const auto shaded = gl_->run(declarations, body, places, directions);

    Agreement agreement;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const vec3 d(directions[i]);
        const vec3 s = shaders::lcZonalSpecular(sh, glm::normalize(d), vec3(bands[0], bands[1], bands[2]));
        const int mip = static_cast<int>(places[i].x);
        const float fraction = places[i].x - static_cast<float>(mip);
        vec4 value(0), allowed(0);
        std::array<vec4, 2> levels{};
        for (int level = 0; level < (fraction > 0 ? 2 : 1); ++level) {
            const auto faces = facesOf(mip + level);
            const auto sample = [&](const glm::dvec3& at) { return verify::sampleCube(faces, at); };
            // Steps of 1/256 texel in the plane of the face, on both axes.
            const glm::dvec3 direct(d), major = glm::abs(direct);
            const int axis = major.x >= major.y && major.x >= major.z ? 0 : major.y >= major.z ? 1 : 2;
            const double step = 2 * kFraction / faces[0].width() * major[axis];
            const vec4 here = sample(direct);
            vec4 slack(0);
            for (const double u : {-step, step})
                for (const double v : {-step, step}) {
                    glm::dvec3 moved = direct;
                    moved[(axis + 1) % 3] += u;
                    moved[(axis + 2) % 3] += v;
                    slack = glm::max(slack, glm::abs(sample(moved) - here));
                }
            levels[static_cast<std::size_t>(level)] = here;
            const float weight = level == 0 ? 1 - fraction : fraction;
            value += weight * here;
            allowed += weight * slack;
        }
        if (fraction > 0) allowed += static_cast<float>(kFraction) * glm::abs(levels[1] - levels[0]);
        // The fetch may return halves, and does at a corner of the cube, where three texels meet.
        allowed += kHalfRounding * glm::abs(value);
        const vec3 ours = shaders::lcEnvironment(range * vec3(value), s);
        for (int channel = 0; channel < 3; ++channel)
            agreement.add(ours[channel], shaded[i][channel],
                          static_cast<double>(range * allowed[channel] * s[channel] + 1e-5f * std::abs(ours[channel])),
                          fmt::format("({}, {}, {}), level {}, channel {}", d.x, d.y, d.z, places[i].x, channel));
    }
    std::printf("figures %-26s largest difference %.3g, %.2f of what is allowed\n", name.c_str(), agreement.difference, agreement.part);
    EXPECT_LE(agreement.part, 1) << agreement.worst;
}

void Converters::expectTextureAsOurs(const CookedScene& scene, const Json& asset, const Json& texture) {
    const std::string file = texture.at("file").get<std::string>();
    if (!gl_->upload(0, scene.ktx2(texture))) {
        if (!mayLack(texture.at("format"))) ADD_FAILURE() << file << ": " << gl_->name() << " does not take its format";
        return;
    }
    const std::vector<Image> layers = scene.decoded(asset, texture.at("role"));
    const int width = layers[0].width(), height = layers[0].height(), count = static_cast<int>(layers.size());
    std::vector<vec4> places;
    for (int i = 0; i < 30000; ++i) {
        const int x = static_cast<int>(uniform() * static_cast<float>(width)), y = static_cast<int>(uniform() * static_cast<float>(height));
        const bool isCentre = i % 3 == 0;
        places.emplace_back((static_cast<float>(x) + (isCentre ? 0.5f : uniform())) / static_cast<float>(width),
                            (static_cast<float>(y) + (isCentre ? 0.5f : uniform())) / static_cast<float>(height), i % count, 0);
    }
    const auto sampled =
        gl_->run("layout(binding = 0) uniform sampler2DArray layers;\n", "result = textureLod(layers, place.xyz, 0.0);", places);
    const auto format = *formats::pixelFormatFromName(texture.at("format").get<std::string>());
    const double slack = static_cast<double>(texelSlack(texture.at("format").get<std::string>()));
    Agreement agreement;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const Image& image = layers[static_cast<std::size_t>(places[i].z)];
        const auto sample = [&](const glm::dvec2& at) { return verify::sampleBilinear(image.view(), at); };
        const glm::dvec2 uv(places[i]);
        const vec4 ours = sample(uv), allowed = filterSlack(sample, uv, {1.0 / width, 1.0 / height});
        for (int channel = 0; channel < formats::info(format).channelCount; ++channel)
            agreement.add(ours[channel], sampled[i][channel],
                          static_cast<double>(allowed[channel]) + slack + 1e-6 * static_cast<double>(std::abs(ours[channel])),
                          fmt::format("{} at ({}, {}), layer {}, channel {}", file, uv.x * width, uv.y * height, places[i].z, channel));
    }
    std::printf("figures %-26s largest difference %.3g, %.2f of what is allowed\n", file.c_str(), agreement.difference, agreement.part);
    EXPECT_LE(agreement.part, 1) << agreement.worst;
}

void Converters::expectReflectionMapAsOurs(const CookedScene& scene, const std::string& name) {
    const Json& asset = scene.asset(name);
    ASSERT_TRUE(gl_->upload(0, scene.ktx2(asset.at("textures")[0])));
    const Image image = std::move(scene.decoded(asset, "rsrm")[0]);
    const auto color = asset.at("constants").at("color").get<std::vector<float>>();
    std::vector<vec4> places, directions;
    for (int i = 0; i < 4000; ++i) {
        places.emplace_back(uniform(0, static_cast<double>(image.height() - 1)), 0, 0, 0);
        directions.emplace_back(vec3(direction()), 0);
    }
    const auto shaded = gl_->run(scene.shader() + "layout(binding = 0) uniform sampler2DArray sky;\n",
                                 fmt::format("vec2 uv = lcRsrmUv(direction.xyz, vec3(0.0, 0.0, 1.0), place.x, {}.0);\n"
                                             "result = vec4(lcRsrm(textureLod(sky, vec3(uv, 0.0), 0.0).xyz, {}), 1.0);",
                                             image.height(), glslVector(color, 0, 3)),
                                 places, directions);
    Agreement agreement;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const glm::dvec2 uv(shaders::lcRsrmUv(vec3(directions[i]), vec3(0, 0, 1), places[i].x, static_cast<float>(image.height())));
        const auto sample = [&](const glm::dvec2& at) { return verify::sampleBilinear(image.view(), at); };
        const vec3 hdr(color[0], color[1], color[2]), ours = shaders::lcRsrm(vec3(sample(uv)), hdr);
        const vec3 allowed = hdr * (vec3(filterSlack(sample, uv, {1.0 / image.width(), 1.0 / image.height()})) + 2.0f / 255);
        for (int channel = 0; channel < 3; ++channel)
            agreement.add(ours[channel], shaded[i][channel], static_cast<double>(allowed[channel]), fmt::format("row {}", places[i].x));
    }
    std::printf("figures reflection map     largest difference %.3g, %.2f of what is allowed\n", agreement.difference, agreement.part);
    EXPECT_LE(agreement.part, 1) << agreement.worst;
}

TEST_F(Converters, TheReflectionMapIsFetchedAsOursAndTheSmallCubemapIsFiltered) {
    const CookedScene scene(SmallScene::Parts::All, "bc", "ratio");
    expectCubemapAsOurs(scene, "probe");
    expectReflectionMapAsOurs(scene, "sky");
}

const std::filesystem::path kShippedScene = std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "examples/cornell/scene.toml";

TEST_F(Converters, EveryTextureOfTheSceneThatShipsIsSampledAsOurs) {
    // The cook of tests/end_to_end/mutation_test.cpp, which the shared cache has.
    expectEveryTextureAsOurs(CookedScene(kShippedScene, "basis-8", {}, 0.02));
}

using BrowserConverters = InABrowser<Converters>;
using BrowserConvertersSoak = BrowserConverters;
TEST_F(BrowserConvertersSoak, TheReflectionMapIsFetchedAsOursAndTheSceneThatShipsIsSampledAsOurs) {
    expectReflectionMapAsOurs(CookedScene(SmallScene::Parts::All, "bc", "ratio"), "sky");
    expectEveryTextureAsOurs(CookedScene(kShippedScene, "basis-8"));
}

void Converters::expectPublicSceneAsOurs(const std::string& scene) {
    const std::filesystem::path data = std::filesystem::absolute(LIGHTCOOK_SHARED_DATA) / "scenes";
    if (!std::filesystem::exists(data / (scene + "_lightmap.exr"))) GTEST_SKIP() << "no shared data at " << data;
    const formats::TemporaryFolder folder;
    formats::writeContent(folder / "scene.toml",
                          fmt::format("schema = 1\nname = \"{1}\"\n[[light_map]]\nname = \"lightmap\"\nfile = \"{0}/{1}_lightmap.exr\"\n"
                                      "[[probe]]\nname = \"probe\"\nfile = \"{0}/{1}_probe0.exr\"\n"
                                      "[[material]]\nname = \"*\"\nnormal_map = true\nspecular = true\nm = [0.1, 0.5]\n",
                                      data.string(), scene));
    expectEveryTextureAsOurs(CookedScene(folder / "scene.toml", "basis-16"));
    for (const char* layout : {"basis-4", "ratio", "halo3", "raw"}) {
        const CookedScene cooked(folder / "scene.toml", layout, "light-map");
        expectEveryTextureAsOurs(cooked);
        expectShadedAsOurs(cooked, "lightmap", fmt::format("{} {}", scene, layout));
    }
}
class SamplersSoak : public Converters, public testing::WithParamInterface<const char*> {};
TEST_P(SamplersSoak, EveryTextureOfAPublicSceneIsSampledAsOurs) {
    expectPublicSceneAsOurs(GetParam());
}
class BrowserSamplersSoak : public InABrowser<Converters>, public testing::WithParamInterface<const char*> {};
TEST_P(BrowserSamplersSoak, EveryTextureOfAPublicSceneIsSampledAsOurs) {
    expectPublicSceneAsOurs(GetParam());
}
constexpr std::array kPublicScenes = {"cornell", "interior", "outdoor", "zdm2_sun"};
const auto kNameOfScene = [](const auto& each) { return std::string(each.param); };
INSTANTIATE_TEST_SUITE_P(Public, SamplersSoak, testing::ValuesIn(kPublicScenes), kNameOfScene);
INSTANTIATE_TEST_SUITE_P(Public, BrowserSamplersSoak, testing::ValuesIn(kPublicScenes), kNameOfScene);

}  // namespace
}  // namespace lightcook::samplers
