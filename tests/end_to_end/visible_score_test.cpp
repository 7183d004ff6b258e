// Visible errors of cooked light maps against an independent program, at texel centres.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>

#include "pipeline/cook/cook.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr int kEveryTexel = 1'000'000;

struct ScoreCase {
    const char* bake;  ///< path in the repository, or in the shared data
    const char* layout;
    const char* charts = "";  ///< lines of [[light_map]]: its mesh, and keys of charts
};

class VisibleScore : public testing::TestWithParam<ScoreCase> {
protected:
    static fs::path bake() {
        const fs::path shipped = fs::path(LIGHTCOOK_SOURCE_DIR) / GetParam().bake;
        return fs::absolute(fs::exists(shipped) ? shipped : fs::path(LIGHTCOOK_SHARED_DATA) / GetParam().bake);
    }
    /// Returns the lines of charts, whose mesh lies beside the bake.
    static std::string charts() {
        std::string mesh = bake().string();
        mesh.replace(mesh.rfind("_lightmap.exr"), std::string::npos, ".glb");
        return *GetParam().charts == 0 ? "" : fmt::format("mesh = \"{}\"\n{}", mesh, GetParam().charts);
    }
    static fs::path tool() { return fs::path(LIGHTCOOK_SHARED_DATA).parent_path() / "tools" / "score_visible.py"; }

    Json cookedStages() const {
        formats::writeContent(folder_ / "scene.toml",
                              fmt::format("schema = 1\nname = \"visible\"\n[output]\nmax_error = 0.9\nlight_map_layout = \"{}\"\n"
                                          "[[light_map]]\nname = \"map\"\nfile = \"{}\"\n{}[[material]]\nname = \"*\"\nnormal_map = true\n"
                                          "specular = true\nm = [0.1, 0.5]\nf0 = [0.04, 0.6]\n",
                                          GetParam().layout, bake().string(), charts()));
        CookOptions options;
        options.scene = folder_ / "scene.toml";
        options.output = folder_ / "out";
        options.cache = folder_ / "cache";
        options.onlyKind = "light-map";
        const Outcome cooked = cookScene(options, RunState());
        for (const formats::Error& error : cooked.errors) ADD_FAILURE() << error.line();
        return cooked.report.at("assets").at(0).at("stages");
    }
    /// Returns the scores over covered texels; null where Python or its libraries are missing.
    /// placesPerTexel  along each axis; 1: the texel centres
    /// texelCount      of them; fewer are chosen at random
    Json independentScore(int placesPerTexel, int texelCount) const {
        const fs::path decoded = folder_ / "decoded.exr", score = folder_ / "score.json";
        EXPECT_TRUE(reconstructLightMap(folder_ / "out", "map", decoded, placesPerTexel, RunState()).has_value());
        const std::string command = fmt::format("/usr/bin/python3 -B '{}' '{}' '{}' --texels {} --json > '{}' 2>/dev/null", tool().string(),
                                                bake().string(), decoded.string(), texelCount, score.string());
        return std::system(command.c_str()) == 0 ? Json::parse(formats::contentOf(score)) : Json();
    }
    const formats::TemporaryFolder folder_;
};

TEST_P(VisibleScore, AgreesWithAnIndependentProgram) {
    if (!fs::exists(bake()) || !fs::exists(tool())) GTEST_SKIP() << "no shared data at " << LIGHTCOOK_SHARED_DATA;
    const Json stages = cookedStages();
    const Json score = independentScore(1, kEveryTexel), surface = independentScore(2, 20'000);
    if (score.is_null()) GTEST_SKIP() << "no score without python3-numpy and python3-openimageio";
    const Json& total = stages.back();
    for (const char* kind : {"diffuse", "specular"}) {
        for (const char* figure : {"rms", "p50", "p95", "p99", "p999", "max"}) {
            const double theirs = score.at(kind).at(figure).get<double>();
            const double tolerance = std::string_view(figure) == "p999" ? 0.05 : 0.02;
            EXPECT_NEAR(total.at("at_texels").at(kind).at("visible").at(figure).get<double>(), theirs, tolerance * theirs)
                << kind << ' ' << figure;
        }
        // Each takes one random place of a texel, and not the same: percentiles differ by up to 8 %.
        for (const char* figure : {"rms", "p50", "p95", "p99"}) {
            const double theirs = surface.at(kind).at(figure).get<double>();
            EXPECT_NEAR(total.at("error").at(kind).at("visible").at(figure).get<double>(), theirs, 0.1 * theirs) << kind << ' ' << figure;
        }
    }
}

std::string nameOfScored(const testing::TestParamInfo<ScoreCase>& info) {
    std::string name = fs::path(info.param.bake).stem().string() + "_" + info.param.layout;
    if (*info.param.charts != 0) name += std::string("_packed_") + info.param.charts[std::string_view(info.param.charts).size() - 2];
    std::ranges::replace(name, '-', '_');
    return name;
}
INSTANTIATE_TEST_SUITE_P(Example, VisibleScore, testing::Values(ScoreCase{"examples/cornell/cornell_lightmap.exr", "basis-4"}),
                         nameOfScored);
INSTANTIATE_TEST_SUITE_P(
    Soak, VisibleScore,
    testing::Values(ScoreCase{"examples/cornell/cornell_lightmap.exr", "ratio"},
                    ScoreCase{"examples/cornell/cornell_lightmap.exr", "ratio", "charts = \"pack\"\ncharts_max_visible = 2\n"},
                    ScoreCase{"examples/cornell/cornell_lightmap.exr", "basis-4", "charts = \"pack\"\ncharts_max_visible = 0\n"},
                    ScoreCase{"scenes/cornell_lightmap.exr", "basis-8"}, ScoreCase{"scenes/interior_lightmap.exr", "hdr-2"},
                    ScoreCase{"scenes/outdoor_lightmap.exr", "basis-4"}, ScoreCase{"scenes/zdm2_sun_lightmap.exr", "ratio"}),
    nameOfScored);

}  // namespace
}  // namespace lightcook::pipeline
