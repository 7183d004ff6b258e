#include "pipeline/report/scene_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "lighting/sphere.h"
#include "pipeline/assets/lut/light_moments.h"
#include "pipeline/report/report.h"
#include "shaders/lightcook_cpp.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using ::testing::HasSubstr;

Json figuresOf(double relRms) {
    return {{"rel_rms", relRms}, {"p99", 0.1}, {"max_sampled", 0.2}, {"max_bound", 0.4}};
}
Json stage(const char* name, double diffuse, double specular) {
    return {{"name", name}, {"seconds", 0.0}, {"error", {{"diffuse", figuresOf(diffuse)}, {"specular", figuresOf(specular)}}}};
}
Json asset(const char* name, const char* kind, double diffuse, double specular, const Json& light) {
    Json row = {{"name", name},
                {"kind", kind},
                {"layout", "any"},
                {"width", 4},
                {"height", 4},
                {"bytes_in", 1},
                {"bytes_gpu", 1},
                {"bytes_disk", 1},
                {"bits_per_texel", 8.0},
                {"seconds", 0.0},
                {"stages", Json::array({stage("first", 2 * diffuse, specular / 2), stage("total", diffuse, specular)})},
                {"limit", {{"metric", "rel_rms"}, {"value", 0.1}}},
                {"passed", true},
                {"textures", Json::array()}};
    if (!light.is_null()) row["light"] = light;
    return row;
}
Json firstMoment(double value) {
    Json moments(10, 0.0);
    moments[0] = value;
    return moments;
}
Json lightMap(const char* name, double diffuse, double specular, double diffuseRms, double specularRms, double texels = 100,
              const char* bake = "a.exr") {
    return asset(
        name, "light-map", diffuse, specular,
        {{"diffuse_rms", diffuseRms}, {"specular_rms", specularRms}, {"texels", texels}, {"bake", bake}, {"moments", firstMoment(4)}});
}
Json dominant(const char* name, double relRms, double rms, const char* bake = "a.exr") {
    return asset(name, "dominant", 0, relRms, {{"specular_rms", rms}, {"bake", bake}});
}
Json probe(const char* name, double ratioRelRms, double ratioRms) {
    return asset(name, "cubemap", 0, 0.5, {{"ratio_rms", ratioRms}, {"ratio_rel_rms", ratioRelRms}});
}
Json tables(double relRms) {
    return asset("specular", "lut", 0, 0.5, {{"kernel_moments", firstMoment(9)}, {"error_moments", firstMoment(9 * relRms * relRms)}});
}
Json mesh(const char* name, double relRms, double rms) {
    return asset(name, "mesh", relRms, 0, {{"diffuse_rms", rms}, {"bake", "a.exr"}});
}

std::vector<ReportRow> rowsOf(const std::vector<Json>& assets) {
    std::vector<ReportRow> rows;
    // The text form of JSON holds null for figures that are not finite.
    for (const Json& each : assets) rows.push_back(fromJson<ReportRow>(parseJson(each.dump()), "row").value());
    return rows;
}
/// Returns the scene error of rows of report.json, as the report has it; null without one.
Json wholeOf(const std::vector<Json>& assets) {
    const auto whole = sceneError(rowsOf(assets));
    return whole ? toJson(*whole) : Json();
}
SceneError readWhole(const Json& whole) {
    return fromJson<SceneError>(whole, "whole").value();
}
Json wholeReport(const std::vector<Json>& assets) {
    return toJson(makeReport({"scene", 1, 1, std::nullopt}, rowsOf(assets), {}));
}

double at(const Json& json, const char* key) {
    return json.at(key).get<double>();
}
double shareSum(const Json& whole) {
    double sum = 0;
    for (const Json& part : whole.at("parts")) sum += at(part, "share");
    return sum;
}
const Json& partOf(const Json& whole, const std::string& name, const std::string& shading) {
    for (const Json& part : whole.at("parts"))
        if (part.at("asset") == name && part.at("shading") == shading) return part;
    static const Json kNone;
    ADD_FAILURE() << "no part " << name << ", " << shading;
    return kNone;
}

TEST(SceneError, PartsAddUpAsSquaresAndAtMostAsTheyAre) {
    // Light 4 and 3: 5 in all. Errors 0.04 and 0.03: 0.05 as squares, 0.07 at worst.
    const Json whole = wholeOf({lightMap("map", 0.01, 0, 4, 0), dominant("map_dominant", 0.01, 3)});
    EXPECT_NEAR(at(whole, "rel_rms"), 0.05 / 5, 1e-15);
    EXPECT_NEAR(at(whole, "rel_rms_bound"), 0.07 / 5, 1e-15);
    EXPECT_NEAR(at(whole, "light_rms"), 5, 1e-14);
    EXPECT_NEAR(at(partOf(whole, "map", "diffuse"), "share"), 0.64, 1e-14);
    EXPECT_NEAR(at(partOf(whole, "map_dominant", "analytic specular"), "share"), 0.36, 1e-14);
    // The stage before the last has twice the error and four times the share of the last one.
    EXPECT_NEAR(at(partOf(whole, "map", "diffuse").at("stages").at(0), "share"), 4 * 0.64, 1e-14);
    EXPECT_FALSE(whole.contains("light_maps"));
    EXPECT_TRUE(whole.at("apart").empty());
}

TEST(SceneError, APlainCubemapIsSeenWhateverTheAreaSpecular) {
    const Json plain = asset("room", "cubemap", 0, 0.02, {{"specular_rms", 3}});
    const Json whole = wholeOf({lightMap("map", 0, 0.1, 4, 0.5), plain});
    EXPECT_NEAR(at(whole.at("lights"), "environment"), 3, 1e-14);
    const double area = 0.1 * 0.5, environment = 0.02 * 3, squares = area * area + environment * environment;
    EXPECT_NEAR(at(whole, "rel_rms"), std::sqrt(squares) / std::sqrt(16 + 0.25 + 9), 1e-15) << "no error of S is reflected";
    EXPECT_NEAR(at(partOf(whole, "room", "environment"), "share"), environment * environment / squares, 1e-14);
    // Beside a divided one of R = 2: each is seen by half of the pixels.
    const Json both = wholeOf({lightMap("map", 0, 0.1, 4, 0.5), plain, probe("hall", 0.04, 2)});
    EXPECT_NEAR(at(both.at("lights"), "environment"), std::sqrt((9.0 + 1) / 2), 1e-14);
    EXPECT_NEAR(at(partOf(both, "room", "environment"), "rel_rms"), 0.02, 1e-14);
}

TEST(SceneError, APlainCubemapIsSeenOnABlackMap) {
    const Json plain = asset("room", "cubemap", 0, 0.02, {{"specular_rms", 3}});
    const Json whole = wholeOf({lightMap("map", 0, 0, 0, 0), plain, probe("hall", 0.04, 2), tables(0.1)});
    EXPECT_NEAR(whole["lights"]["environment"].get<double>(), std::sqrt(9.0 / 2), 1e-12) << "a pixel sees one of the two";
    EXPECT_NEAR(whole["rel_rms"].get<double>(), 0.02, 1e-12) << "all light is that of the plain one";
    EXPECT_EQ(whole["parts"][0]["asset"], "room");
    EXPECT_NEAR(whole["parts"][0]["share"].get<double>(), 1, 1e-12);
    std::vector<std::string> apart;
    for (const Json& each : whole["apart"]) apart.push_back(each["asset"].get<std::string>());
    EXPECT_THAT(apart, ::testing::UnorderedElementsAre("hall", "specular")) << "they shade light that is not there";
}

TEST(SceneError, EveryKindOfLightTakesPartByItsOwnRms) {
    const Json whole =
        wholeOf({lightMap("map", 0.02, 0.03, 2, 1), dominant("map_dominant", 0.05, 3), mesh("room_mesh", 0.01, 1.5), probe("left", 0.04, 1),
                 probe("right", 0.08, 2), tables(0.002), asset("sky", "rsrm", 0.006, 0.004, nullptr)});
    const double ratio = std::sqrt((1.0 + 4.0) / 2), reflected = 1 + ratio;  // S, and the environment's light R S
    const double light = std::sqrt(4 + 1 + 9 + ratio * ratio);
    const double diffuse = 0.02 * 2, moved = 0.01 * 1.5, area = 0.03 * reflected, table = 0.002 * reflected, analytic = 0.05 * 3;
    const double environment = std::sqrt((0.04 * 0.04 + 0.16 * 0.16) / 2);
    const double squares =
        diffuse * diffuse + moved * moved + area * area + table * table + analytic * analytic + environment * environment;
    EXPECT_NEAR(at(whole, "light_rms"), light, 1e-14);
    EXPECT_NEAR(at(whole, "rel_rms"), std::sqrt(squares) / light, 1e-15);
    EXPECT_NEAR(at(whole, "rel_rms_bound"), (diffuse + moved + area + table + analytic + environment) / light, 1e-15);
    EXPECT_NEAR(at(whole.at("lights"), "environment"), ratio, 1e-14);
    EXPECT_NEAR(at(partOf(whole, "right", "environment"), "share"), 0.16 * 0.16 / 2 / squares, 1e-14);
    EXPECT_NEAR(at(partOf(whole, "right", "environment"), "rel_rms"), 0.08, 1e-14);
    EXPECT_NEAR(shareSum(whole), 1, 1e-14);
    ASSERT_EQ(whole.at("apart").size(), 1u);
    EXPECT_EQ(whole.at("apart").at(0).at("asset"), "sky");
    EXPECT_EQ(at(whole.at("apart").at(0), "rel_rms"), 0.006);
    // Largest first, and the sentence names it.
    EXPECT_EQ(whole.at("parts").at(0).at("asset"), "map_dominant");
    EXPECT_THAT(readWhole(whole).shading.advice, HasSubstr("the dominant light 'map_dominant', in analytic specular light"));
}

TEST(SceneError, AdvisesTheNextBetterLayoutThatWasTried) {
    Json tried = lightMap("map", 0.1, 0, 1, 0);
    tried["layout"] = "basis-4";
    tried["trial_candidates"] = Json::array();
    for (const auto& [layout, bytes, visible] : {std::tuple("basis-4", 4096, 9.0), std::tuple("basis-8", 6144, 5.5)})
        tried["trial_candidates"].push_back(
            toJson(TrialCandidate{layout, static_cast<std::uint64_t>(bytes), 1, 0.1, 0.1, visible, visible, 1, 1, 0, false}));
    EXPECT_THAT(readWhole(wholeOf({tried})).shading.advice,
                HasSubstr("light. light_map_layout = \"basis-8\" has less (visible error 5.5 when it was tried, 2.00 KiB more)."));
    tried["trial_candidates"][1]["visible_diffuse"] = tried["trial_candidates"][1]["visible_specular"] = 6.5;
    EXPECT_THAT(readWhole(wholeOf({tried})).shading.advice, ::testing::EndsWith("in diffuse light.")) << "it costs more than it gains";
}

TEST(SceneError, AdvisesAutoWhereNoLayoutWasTried) {
    Json named = lightMap("map", 0.1, 0, 1, 0);
    named["layout"] = "basis-4";
    EXPECT_THAT(readWhole(wholeOf({named})).shading.advice,
                HasSubstr("light. light_map_layout = \"auto\" with max_visible measures what the other layouts give."));
}

/// Finer codes of a dominant light do not reduce what filtering between its texels makes.
TEST(SceneError, AdvisesMoreTexelsWhereFilteringIsTheError) {
    const auto advice = [](double magnified, double total) {
        Json light = dominant("map_dominant", total, 3);
        light["stages"][0] = stage("magnified", 0, magnified);
        return readWhole(wholeOf({lightMap("map", 0.001, 0, 1, 0), light})).shading.advice;
    };
    EXPECT_THAT(advice(0.11, 0.1), HasSubstr("makes the error: only more texels in the bake lower it."));
    EXPECT_THAT(advice(0.09, 0.1), ::testing::EndsWith("in analytic specular light.")) << "nothing is known to help";
    for (const std::string& each : {advice(0.2, 0.1), advice(0.03, 0.1), readWhole(wholeOf({lightMap("map", 0.1, 0, 1, 0)})).shading.advice,
                                    readWhole(wholeOf({lightMap("map", 0, 0.001, 1, 1), probe("p", 0.5, 1)})).shading.advice})
        EXPECT_THAT(each, ::testing::Not(HasSubstr("effort")));
}

TEST(SceneError, TwiceAnErrorIsFourTimesItsSquare) {
    const auto whole = [](double relRms) {
        return wholeOf({lightMap("map", 0.01, 0.02, 4, 1), dominant("map_dominant", relRms, 3), tables(0.01)});
    };
    const Json once = whole(0.01), twice = whole(0.02);
    const double share = at(partOf(once, "map_dominant", "analytic specular"), "share");
    EXPECT_NEAR(at(twice, "rel_rms") / at(once, "rel_rms"), std::sqrt(1 + 3 * share), 1e-14);
    EXPECT_NEAR(at(partOf(twice, "map_dominant", "analytic specular"), "share"), 4 * share / (1 + 3 * share), 1e-14);
    EXPECT_NEAR(shareSum(twice), 1, 1e-14);
}

TEST(SceneError, SeveralLightMapsCountByTheirTexels) {
    const Json whole = wholeOf({lightMap("map", 0.01, 0, 2, 0, 300), lightMap("map_b", 0.05, 0, 4, 0, 100, "b.exr"),
                                dominant("map_dominant", 0.1, 1), dominant("map_b_dominant", 0.2, 3, "b.exr")});
    ASSERT_EQ(whole.at("light_maps").size(), 2u);
    const Json &first = whole.at("light_maps").at(0), &second = whole.at("light_maps").at(1);
    EXPECT_NEAR(at(first, "weight"), 0.75, 1e-15);
    EXPECT_NEAR(at(first, "rel_rms"), std::sqrt((0.0004 + 0.01) / 5), 1e-15);
    EXPECT_NEAR(at(second, "rel_rms"), std::sqrt((0.04 + 0.36) / 25), 1e-15);
    EXPECT_NEAR(at(whole, "rel_rms"), std::sqrt((0.75 * 0.0104 + 0.25 * 0.4) / (0.75 * 5 + 0.25 * 25)), 1e-15);
    EXPECT_NEAR(at(whole, "rel_rms_bound"), std::sqrt((0.75 * 0.12 * 0.12 + 0.25 * 0.8 * 0.8) / 10), 1e-15);
    EXPECT_NEAR(shareSum(whole), 1, 1e-14);
    EXPECT_NEAR(shareSum(first), 1, 1e-14);
    EXPECT_EQ(whole.at("parts").size(), 4u);
}

TEST(SceneError, MapsOfOneBakeAreDistinguishedByName) {
    const Json whole = wholeOf({lightMap("a", 0.01, 0, 1, 0), lightMap("a_b", 0.01, 0, 1, 0), dominant("a_b_dominant", 0.1, 1)});
    EXPECT_EQ(whole.at("light_maps").at(0).at("parts").size(), 1u);
    EXPECT_EQ(whole.at("light_maps").at(1).at("parts").size(), 2u);
}

TEST(SceneError, WhatIsMissingTakesNoPart) {
    EXPECT_TRUE(wholeOf({}).is_null());
    EXPECT_TRUE(wholeOf({probe("left", 0.04, 1), tables(0.01)}).is_null());
    EXPECT_TRUE(wholeOf({asset("map", "light-map", 0.1, 0.1, nullptr)}).is_null()) << "a row of an older tool";
    // No specular material: nothing of tables, nor of cubemaps, is seen.
    const Json whole = wholeOf({lightMap("map", 0.01, 0, 4, 0), tables(0.5), dominant("b_dominant", 0.5, 1, "b.exr")});
    EXPECT_NEAR(at(whole, "rel_rms"), 0.01, 1e-15);
    EXPECT_EQ(whole.at("parts").size(), 1u);
    EXPECT_EQ(whole.at("apart").size(), 2u);
}

TEST(SceneError, ABlackMapHasNoErrorUnlessItShines) {
    const Json black = wholeOf({lightMap("map", 0, 0, 0, 0)});
    EXPECT_EQ(at(black, "rel_rms"), 0);
    EXPECT_EQ(shareSum(black), 0);
    EXPECT_EQ(readWhole(black).shading.advice, "There is no error.");
    const Json shines = wholeOf({lightMap("map", std::numeric_limits<double>::max(), 0, 0, 0)});
    EXPECT_TRUE(shines.at("rel_rms").is_null());
}

TEST(SceneError, WhatIsNotFiniteIsNull) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), std::numeric_limits<double>::max()}) {
        const Json whole = wholeOf({lightMap("map", 0.01, 0, 4, 0), dominant("map_dominant", bad, 3)});
        EXPECT_TRUE(whole.at("rel_rms").is_null());
        EXPECT_TRUE(whole.at("rel_rms_bound").is_null());
        EXPECT_NEAR(at(whole, "light_rms"), 5, 1e-14) << "the light is known all the same";
        EXPECT_TRUE(partOf(whole, "map", "diffuse").at("share").is_null());
        EXPECT_THAT(readWhole(whole).shading.advice, HasSubstr("not finite"));
        EXPECT_THAT(lineOf(readWhole(whole)), HasSubstr("not finite"));
        const Json dark = wholeOf({lightMap("map", 0.01, 0, bad, 0)});
        EXPECT_TRUE(dark.at("light_rms").is_null());
        EXPECT_TRUE(dark.at("rel_rms").is_null());
    }
    // A figure that a file holds as null.
    Json map = lightMap("map", 0.01, 0, 4, 0);
    map["stages"][1]["error"]["diffuse"]["rel_rms"] = nullptr;
    EXPECT_TRUE(wholeOf({map}).at("rel_rms").is_null());
}

/// Pixels of invented light that is nowhere negative and invented errors, shaded as the definition says.
struct Simulated {
    double relRms = 0;
    Json whole;
};
Simulated simulate(unsigned seed, bool areCorrelated) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::gamma_distribution<double> gamma(0.7, 1.3);
    constexpr int kPixels = 200000;
    std::array<double, 4> light{}, error{};  // diffuse, S, analytic, R: sums of squares
    double whole = 0, off = 0;
    for (int i = 0; i < kPixels; ++i) {
        const double d = 2 * gamma(random), s = gamma(random), a = 3 * gamma(random), r = 0.8 * gamma(random);
        const double common = normal(random);
        const auto noise = [&] { return areCorrelated ? std::abs(common) : normal(random); };
        const double de = 0.02 * noise(), se = 0.03 * noise(), ae = 0.05 * noise(), re = 0.02 * noise();
        const std::array<double, 4> lights = {d, s, a, r}, errors = {de, se, ae, re};
        for (std::size_t k = 0; k < 4; ++k) {
            light[k] += lights[k] * lights[k];
            error[k] += errors[k] * errors[k];
        }
        const double shown = d + s + a + r * s, seen = (d + de) + (s + se) + (a + ae) + r * (s + se) + re * s;
        whole += shown * shown;
        off += (seen - shown) * (seen - shown);
    }
    const auto rms = [](double sum) { return std::sqrt(sum / kPixels); };
    const auto rel = [&](std::size_t k) { return std::sqrt(error[k] / light[k]); };
    return {std::sqrt(off / whole), wholeOf({lightMap("map", rel(0), rel(1), rms(light[0]), rms(light[1])),
                                             dominant("map_dominant", rel(2), rms(light[2])), probe("probe", rel(3), rms(light[3]))})};
}

TEST(SceneError, SimulatedPixelsAreWithinIt) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
        const Simulated apart = simulate(seed, false), together = simulate(seed, true);
        // Independent errors: the estimate, whose light counts as squares and is therefore less than what the pixels show.
        EXPECT_LE(apart.relRms, at(apart.whole, "rel_rms"));
        EXPECT_GE(apart.relRms, 0.5 * at(apart.whole, "rel_rms"));
        // Errors that go together pass the share of the estimate that is theirs, never the bound.
        EXPECT_LE(together.relRms, at(together.whole, "rel_rms_bound"));
        EXPECT_GT(together.relRms, 1.2 * apart.relRms);
    }
}

TEST(LightMoments, AreTheMeanSquareOverViewsAllAround) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<verify::LutResult> kernels(3);
    for (auto& kernel : kernels)
        for (std::size_t i = 0; i < kernel.reference.size(); ++i) {
            kernel.reference[i] = normal(random);
            kernel.cooked[i] = kernel.reference[i] + 0.1 * normal(random);
        }
    const std::vector<double> f0 = {0.04, 0.6};
    LightMoments moments, half;
    double reference = 0, error = 0;
    int count = 0;
    for (int texel = 0; texel < 20; ++texel) {
        lighting::ShRgb sh;
        for (glm::vec3& each : sh) each = {normal(random), normal(random), normal(random)};
        const glm::dvec3 n = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
        (texel < 7 ? moments : half).add(sh, glm::vec3(n));
        const glm::dmat3 frame = lighting::worldFromTangentFrame(n);
        shaders::LcSh world;
        for (std::size_t i = 0; i < sh.size(); ++i) world.c[i] = sh[i];
        constexpr int kViews = 12;  // exact: the square is of order 4 in the azimuth
        for (int view = 0; view < kViews; ++view) {
            const double angle = 2 * std::numbers::pi * (view + 0.3) / kViews, c = std::cos(angle), s = std::sin(angle);
            const glm::vec3 x(c * frame[0] + s * frame[1]), y(c * frame[1] - s * frame[0]);
            const shaders::LcSh local = shaders::lcLocalSh(world, x, y, glm::vec3(n));
            for (const auto& kernel : kernels)
                for (const double f : f0)
                    for (int channel = 0; channel < 3; ++channel) {
                        const auto shaded = [&](const verify::SpecularKernelEntries& k) {
                            constexpr std::array<std::size_t, 6> kI = {0, 2, 3, 6, 7, 8}, kC = {0, 1, 2, 3, 8, 9},
                                                                 kD = {4, 5, 6, 7, 10, 11};
                            double sum = 0;
                            for (std::size_t i = 0; i < 6; ++i)
                                sum += static_cast<double>(local.c[kI[i]][channel]) * (f * k[kC[i]] + (1 - f) * k[kD[i]]);
                            return sum;
                        };
                        const double truth = shaded(kernel.reference), off = shaded(kernel.cooked) - truth;
                        reference += truth * truth;
                        error += off * off;
                        ++count;
                    }
        }
    }
    moments.merge(half);
    EXPECT_EQ(moments.texels(), 20);
    const TableMoments tables = tableMoments(kernels, f0);
    EXPECT_NEAR(meanSquare(tables.reference, moments.moments()) / (reference / count), 1, 1e-5);
    EXPECT_NEAR(meanSquare(tables.error, moments.moments()) / (error / count), 1, 1e-5);
    EXPECT_EQ(LightMoments().moments(), Moments());
}

TEST(SceneError, TablesAreWorthWhatTheyDoToTheMapsOwnLight) {
    // All the tables' error is in coefficient 2: nothing to light from everywhere, all to a light in the zenith.
    Json zonal(10, 0.0), constant(10, 0.0), error(10, 0.0);
    constant[0] = 4.0;
    zonal[0] = zonal[1] = zonal[3] = 2.0;  // coefficients 0 and 2 alike
    error[1] = 0.01;
    const auto whole = [&](const Json& light) {
        Json map = lightMap("map", 0, 0, 0, 1), lut = tables(0);
        map["light"]["moments"] = light;
        lut["light"]["error_moments"] = error;
        return wholeOf({map, lut});
    };
    EXPECT_EQ(at(whole(constant), "rel_rms"), 0);
    EXPECT_NEAR(at(whole(zonal), "rel_rms"), std::sqrt(0.01 * 2 / (9 * 2)), 1e-15);
    Json none = lightMap("map", 0, 0, 0, 1);
    none["light"].erase("moments");
    EXPECT_TRUE(wholeOf({none, tables(0.1)}).at("rel_rms").is_null());
}

TEST(SceneError, AReportIsReadWithAndWithoutIt) {
    Json report = wholeReport({lightMap("map", 0.01, 0.02, 4, 1), lightMap("b", 0.01, 0.02, 4, 1), tables(0.01)});
    ASSERT_TRUE(report.contains("whole"));
    EXPECT_TRUE(fromJson<Report>(report, "report"));
    for (const char* key : {"rel_rms", "light_rms", "lights", "parts", "apart"}) {
        Json broken = report;
        broken["whole"][key] = "text";
        EXPECT_FALSE(fromJson<Report>(broken, "report")) << key;
    }
    Json broken = report;
    broken["whole"]["light_maps"][1]["parts"][0]["share"] = -1;
    EXPECT_FALSE(fromJson<Report>(broken, "report"));
    report.erase("whole");
    EXPECT_TRUE(fromJson<Report>(report, "report"));
    for (const char* key : {"diffuse_rms", "texels", "bake"}) {
        broken = report;
        broken["assets"][0]["light"][key] = Json::array();
        EXPECT_FALSE(fromJson<Report>(broken, "report")) << key;
    }
}

TEST(SceneError, OfACookedSceneLiesBetweenItsLargestPartAndTheirSum) {
    const SmallScene scene(SmallScene::Parts::All);
    const RunState state;
    const Outcome cooked = cookScene(scene.options(), state);
    ASSERT_TRUE(cooked.errors.empty()) << cooked.errors[0].line();
    const Json& whole = cooked.report.at("whole");
    const double relRms = at(whole, "rel_rms"), light = at(whole, "light_rms");
    double largest = 0, sum = 0;
    for (const Json& part : whole.at("parts")) {
        const double error = at(part, "rel_rms") * at(part, "light_rms") / light;
        largest = std::max(largest, error);
        sum += error;
    }
    EXPECT_GT(largest, 0);
    EXPECT_GE(relRms, largest * (1 - 1e-12));
    EXPECT_LE(relRms, at(whole, "rel_rms_bound"));
    EXPECT_NEAR(at(whole, "rel_rms_bound"), sum, 1e-12);
    EXPECT_NEAR(shareSum(whole), 1, 1e-12);
    EXPECT_EQ(whole.at("parts").size(), 5u);  // diffuse, area specular, analytic specular, tables, environment
    ASSERT_EQ(whole.at("apart").size(), 1u);
    EXPECT_EQ(whole.at("apart").at(0).at("kind"), "rsrm");
    for (const char* kind : {"diffuse", "area_specular", "analytic_specular", "environment"}) EXPECT_GT(at(whole.at("lights"), kind), 0);

    const Outcome verified = verifyCooked({scene.options().output, {}, {}}, state);
    ASSERT_TRUE(verified.errors.empty()) << verified.errors[0].line();
    EXPECT_EQ(verified.report.at("whole"), whole);
}

TEST(SceneError, OfGreyLightReportsItsRadiance) {
    // Radiance 0.5 from everywhere: exit radiance 0.5, whatever the key is that the verifier works with.
    const SmallScene scene(SmallScene::Parts::LightMap, grey);
    const Outcome cooked = cookScene(scene.options(), RunState());
    ASSERT_TRUE(cooked.errors.empty()) << cooked.errors[0].line();
    const Json& lights = cooked.report.at("whole").at("lights");
    EXPECT_NEAR(at(lights, "diffuse"), 0.5, 1e-3);
    EXPECT_GT(at(lights, "area_specular"), 0.02);  // F0 alone reflects 0.02 to 0.3 of it
    EXPECT_LT(at(lights, "area_specular"), 0.5);
    EXPECT_EQ(cooked.report.at("assets").at(0).at("light").at("texels"), SmallScene::kWidth * SmallScene::kHeight);
}

}  // namespace
}  // namespace lightcook::pipeline
