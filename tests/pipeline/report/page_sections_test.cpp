// Sections and parts of report.html: treemap, captions, advice, rendered views, script.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <limits>
#include <numeric>

#include "formats/light_map_layout.h"
#include "pipeline/report/advice_section.h"
#include "pipeline/report/captions.h"
#include "pipeline/report/chart_section.h"
#include "pipeline/report/frontier_section.h"
#include "pipeline/report/page_frame.h"
#include "pipeline/report/page_parts.h"
#include "pipeline/report/report.h"
#include "pipeline/report/treemap.h"

namespace lightcook::pipeline {
namespace {

using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST(FrontierSection, NamesTheNextStepsAndMarksTheChoice) {
    const auto point = [](int bytes, double visible, bool isChosen, const char* layout, const char* dominant) -> Json {
        return {{"bytes_gpu", bytes},
                {"visible", visible},
                {"chosen", isChosen},
                {"layouts", {{{"light_map", "map"}, {"layout", layout}, {"dominant_layout", dominant}}}}};
    };
    Json budget = {{"limit_bytes", 300 << 10},
                   {"frontier",
                    {point(100 << 10, 20, false, "basis-3", "none"), point(200 << 10, 8, true, "basis-4", "half"),
                     point(400 << 10, 0, false, "raw", "full")}}};
    const std::string section = frontierSection(budget).markup();
    EXPECT_THAT(section, HasSubstr("200 KiB more take the visible error from 8.00 to 0"));
    EXPECT_THAT(section, HasSubstr("100 KiB less take the visible error from 8.00 to 20.0 (map: basis-3, dominant light none)."));
    EXPECT_THAT(section, HasSubstr("map: basis-4, dominant light half (chosen)"));
    EXPECT_THAT(section, HasSubstr(">budget<"));
    EXPECT_THAT(section, Not(ContainsRegex("(nan|inf)[,\"]"))) << "a coordinate";
    // Without a budget, with one allocation alone, or in a damaged report there is nothing to choose from.
    budget["frontier"].erase(2);
    budget["frontier"].erase(0);
    EXPECT_TRUE(frontierSection(budget).isEmpty());
    EXPECT_TRUE(frontierSection(Json{{"limit_bytes", nullptr}}).isEmpty());
    EXPECT_TRUE(frontierSection(Json{{"frontier", {1, "x", nullptr}}}).isEmpty());
}

TEST(Treemap, AreasAreAsTheValuesAndFillTheWhole) {
    const TreemapArea whole = {10, 20, 600, 400};
    for (const std::vector<double>& values :
         {std::vector<double>{6, 6, 4, 3, 2, 2, 1}, std::vector<double>{1}, std::vector<double>{1e9, 1, 1}}) {
        const auto areas = squarified(whole, values);
        const double sum = std::accumulate(values.begin(), values.end(), 0.0);
        for (std::size_t i = 0; i < areas.size(); ++i) {
            const TreemapArea& area = areas[i];
            EXPECT_NEAR(area.width * area.height, values[i] / sum * whole.width * whole.height, 1e-6 * whole.width * whole.height);
            EXPECT_GE(area.x, whole.x - 1e-4);
            EXPECT_LE(area.x + area.width, whole.x + whole.width + 1e-4);
            EXPECT_LE(area.y + area.height, whole.y + whole.height + 1e-4);
            for (std::size_t j = 0; j < i; ++j) {
                const double across = std::min(area.x + area.width, areas[j].x + areas[j].width) - std::max(area.x, areas[j].x);
                const double down = std::min(area.y + area.height, areas[j].y + areas[j].height) - std::max(area.y, areas[j].y);
                EXPECT_TRUE(across < 1e-4 || down < 1e-4) << i << " covers part of " << j;
            }
        }
    }
}

TEST(Treemap, FirstTilesLieAsInThePapersExample) {
    // Bruls, Huizing and van Wijk 2000, figure 4: 6, 6, 4, 3, 2, 2, 1 in 6 x 4. The first strip holds both sixes, 3 wide and 2 high each.
    const auto areas = squarified({0, 0, 6, 4}, {6, 6, 4, 3, 2, 2, 1});
    EXPECT_NEAR(areas[0].width, 3, 1e-9);
    EXPECT_NEAR(areas[0].height, 2, 1e-9);
    EXPECT_NEAR(areas[1].y, 2, 1e-9);
    EXPECT_NEAR(areas[2].x, 3, 1e-9);
    EXPECT_NEAR(areas[2].height, 7.0 / 3, 1e-9);
}

TEST(Treemap, ZeroBytesAndEmptyListsDrawNothing) {
    EXPECT_TRUE(treemap({}, "x").isEmpty());
    EXPECT_TRUE(treemap({{"a", "", "red", "", 0}}, "x").isEmpty());
    const std::string drawn = treemap({{"a<b", "", "red", "#x", 100}, {"c", "", "red", "", 0}}, "x").markup();
    EXPECT_THAT(drawn, HasSubstr("a&lt;b"));
    EXPECT_THAT(drawn, Not(HasSubstr(">c<")));
}

TEST(Advice, CubemapsOfOneSizeShareASentence) {
    const auto cubemap = [](const char* name, int width) -> Json {
        return {{"name", name},
                {"kind", "cubemap"},
                {"width", width},
                {"bytes_gpu", 4 * width * width * 6},
                {"textures", Json::array({{{"format", "bc6h-uf16"}}})}};
    };
    const auto sentences = [](const std::vector<Json>& assets) {
        std::vector<std::string> found;
        for (const std::string& sentence : adviceOf({{"assets", assets}, {"budget", {{"used_bytes", 1 << 20}}}}))
            if (sentence.find("largest level") != std::string::npos) found.push_back(sentence);
        return found;
    };
    // A level of BC6H has a byte a texel: 6 * 128 * 128 bytes are 96 KiB.
    EXPECT_THAT(sentences({cubemap("hall", 128)}),
                ElementsAre(HasSubstr("Cubemap 'hall': size = 64 in place of 128 saves 96.0 KiB, its largest level.")));
    EXPECT_THAT(sentences({cubemap("a", 128), cubemap("b", 64), cubemap("c", 128), cubemap("d", 128)}),
                ElementsAre(HasSubstr("3 cubemaps, 'a' and others: size = 64 in place of 128 saves 288 KiB, their largest levels."),
                            HasSubstr("Cubemap 'b': size = 32 in place of 64 saves 24.0 KiB")));
}

TEST(Advice, LevelsThatNoMaterialReadsAreNamedByWhatTheySave) {
    const auto cubemap = [](const char* name, int unread, std::uint64_t bytes) -> Json {
        return {{"name", name},
                {"kind", "cubemap"},
                {"width", 128},
                {"bytes_gpu", 131168},
                {"notes", {{"unread_levels", unread}, {"unread_bytes", bytes}}},
                {"textures", Json::array({{{"format", "bc6h-uf16"}}})}};
    };
    const auto advice = adviceOf(
        {{"assets", {cubemap("a", 2, 122880), cubemap("b", 2, 122880), cubemap("c", 1, 98304)}}, {"budget", {{"used_bytes", 1 << 20}}}});
    EXPECT_THAT(advice,
                testing::IsSupersetOf(
                    {testing::Matcher<std::string>(HasSubstr("2 cubemaps, 'a' and others: no material is smooth enough to read their 2 "
                                                             "largest levels. size = \"auto\" leaves them out and saves 240 KiB")),
                     testing::Matcher<std::string>(HasSubstr("Cubemap 'c': no material is smooth enough to read its largest level. "
                                                             "size = \"auto\" leaves it out and saves 96.0 KiB. The other levels may be "
                                                             "encoded anew"))}));
}

Json chartOf(int number, int texels, int bytes, double p99) {
    return {{"number", number}, {"first", {8, 16}},   {"size", {30, 20}},       {"texels", texels},
            {"bytes", bytes},   {"visible_p99", p99}, {"visible_max", 2 * p99}, {"worst", {12, 19}}};
}

TEST(ChartSection, TilesAreBytesAndColoursAreErrors) {
    const Json asset = {{"bytes_gpu", 10000},
                        {"charts",
                         {{"count", 9},
                          {"largest", {chartOf(3, 3000, 6000, 0.4), chartOf(1, 1000, 2000, 12.5), chartOf(2, 500, 1000, 1.5)}},
                          {"rest", chartOf(0, 200, 400, 3)}}}};
    const std::string section = chartSection(asset).markup();
    EXPECT_THAT(section, HasSubstr("9 charts."));
    EXPECT_THAT(section, HasSubstr("chart 1: 1.95 KiB, 1,000 texels, visible error 12.5 for 99 %, at most 25.0 at texel 12, 19"));
    EXPECT_THAT(section, HasSubstr("6 smaller charts: 400 B"));
    EXPECT_THAT(section, HasSubstr("between charts: 600 B")) << "what is left of 10000 bytes";
    EXPECT_THAT(section, ContainsRegex("<title>chart 3:[^<]*</title><rect[^>]*--error-0"));
    EXPECT_THAT(section, ContainsRegex("<title>chart 1:[^<]*</title><rect[^>]*--error-4"));
    EXPECT_THAT(section, ContainsRegex("<title>6 smaller charts:[^<]*</title><rect[^>]*--error-2"));
    // The table names charts whose errors can be seen, the worst first.
    const std::string rows = section.substr(section.find("Most visible"));
    EXPECT_LT(rows.find("chart 1<"), rows.find("chart 2<"));
    EXPECT_THAT(rows, Not(HasSubstr("chart 3<")));
}

TEST(ChartSection, NothingWithoutChartsAndNoFaultInADamagedReport) {
    EXPECT_TRUE(chartSection(Json::object()).isEmpty());
    EXPECT_TRUE(chartSection({{"charts", {{"count", 0}, {"largest", Json::array()}}}}).isEmpty());
    EXPECT_TRUE(chartSection({{"charts", {{"count", "many"}, {"largest", {1, "x", nullptr}}}}}).isEmpty());
    const std::string infinite =
        chartSection({{"charts", {{"count", 1}, {"largest", {chartOf(1, 10, 100, std::numeric_limits<double>::quiet_NaN())}}}}}).markup();
    EXPECT_THAT(infinite, Not(ContainsRegex("(nan|inf)[,\"]")));
}

TEST(Captions, EveryStageAndKindHasWords) {
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts())
        for (const std::string_view stage : layout.stages) EXPECT_TRUE(hasStageCaption(stage)) << stage;
    for (const AssetKindInfo& kind : allAssetKinds()) EXPECT_FALSE(kindCaption(kind.name).empty());
    EXPECT_EQ(kindCaption("light-map"), "light map");
    EXPECT_EQ(stageCaption("no such stage"), "no such stage");
    EXPECT_EQ(noteCaption("a_new_note"), "a new note");
}

Json candidate(const char* layout, std::uint64_t bytes, double error) {
    return {{"layout", layout},      {"bytes_gpu", bytes}, {"diffuse", error},
            {"specular", error / 2}, {"fetches", 2},       {"decode_ops", bytes / 100}};
}

Json twoAssets() {
    const Json map = {{"name", "hall"},
                      {"kind", "light-map"},
                      {"layout", "basis-4"},
                      {"width", 100},
                      {"height", 100},
                      {"bytes_gpu", 10240},
                      {"passed", true},
                      {"limit", {{"value", 0.02}}},
                      {"textures", Json::array({{{"role", "l0"}, {"bytes_gpu", 8192}}})},
                      {"notes", {{"covered_texels", 7500}}},
                      {"trial_share", 0.25},
                      {"trial_candidates", Json::array({candidate("basis-3", 8192, 0.03), candidate("basis-4", 10240, 0.015),
                                                        candidate("ratio", 40960, 0.005)})}};
    const Json light = {{"name", "hall_dominant"}, {"kind", "dominant"}, {"bytes_gpu", 30720}, {"passed", true}};
    return {{"assets", Json::array({map, light})},
            {"budget", {{"used_bytes", 40960}}},
            {"whole",
             {{"parts", Json::array({{{"asset", "hall"}, {"share", 0.6}},
                                     {{"asset", "hall"}, {"share", 0.3}},
                                     {{"asset", "hall_dominant"}, {"share", 0.1}}})}}}};
}

TEST(Advice, NamesBytesAndErrorsThatWereMeasured) {
    const std::vector<std::string> advice = adviceOf(twoAssets());
    ASSERT_EQ(advice.size(), 5u);
    EXPECT_EQ(advice[0],
              "Dominant light 'hall_dominant' (30.0 KiB): 75.0 % of the memory, 10.0 % of the squared error of the whole shading. Look "
              "here first to save memory.");
    EXPECT_THAT(advice[1], HasSubstr("Look here first to reduce the error"));
    EXPECT_THAT(advice[2],
                HasSubstr("layout basis-3 in place of basis-4 saves 2.00 KiB; the error (rel_rms, measured on 25.0 % of the map) goes "
                          "from 1.50 % to 3.00 %, over the limit of 2.00 %"));
    EXPECT_THAT(advice[3], HasSubstr("layout ratio costs 30.0 KiB more"));
    EXPECT_THAT(advice[4], HasSubstr("texels outside charts take 25.0 % of its textures: 2.00 KiB"));
}

/// Two layouts of which the smaller one has less rel_rms, and more visible error.
Json mapWithVisibleLimit() {
    const auto candidate = [](const char* layout, std::uint64_t bytes, double relRms, double visible) {
        return Json{{"layout", layout},       {"bytes_gpu", bytes},          {"diffuse", relRms}, {"specular", relRms / 2},
                    {"visible_diffuse", 1.0}, {"visible_specular", visible}, {"fetches", 2},      {"decode_ops", 40}};
    };
    return {{"name", "hall"},
            {"kind", "light-map"},
            {"layout", "ratio"},
            {"passed", true},
            {"limit", {{"metric", "rel_rms"}, {"value", 0.1}, {"max_visible", 5.0}}},
            {"trial_candidates", Json::array({candidate("basis-24", 1024, 0.01, 7.5), candidate("ratio", 3072, 0.02, 4.25)})}};
}

TEST(Advice, ComparesLayoutsByTheErrorThatIsLimited) {
    Json map = mapWithVisibleLimit();
    EXPECT_THAT(
        adviceOf({{"assets", Json::array({map})}}),
        ElementsAre(HasSubstr("layout basis-24 in place of ratio saves 2.00 KiB; the error (visible error, p99, measured) goes from "
                              "4.25 to 7.50, over the limit of 5.00.")));
    map["limit"].erase("max_visible");
    EXPECT_THAT(adviceOf({{"assets", Json::array({map})}}), ElementsAre(HasSubstr("(rel_rms, measured) goes from 2.00 % to 1.00 %.")));
}

TEST(Advice, PacksChartsOnlyWhereTheSceneMayDoIt) {
    Json map = {{"name", "hall"}, {"kind", "light-map"}, {"width", 8}, {"height", 8}, {"notes", {{"covered_texels", 32}}}};
    map["textures"] = Json::array({{{"role", "l0"}, {"bytes_gpu", 4096}}});
    EXPECT_THAT(
        adviceOf({{"assets", Json::array({map})}}),
        ElementsAre(HasSubstr("texels outside charts take 50.0 % of its textures: 2.00 KiB. Name its mesh in [[light_map]]: charts")));
    map["charts"] = Json::object();
    EXPECT_THAT(adviceOf({{"assets", Json::array({map})}}), ElementsAre(HasSubstr("2.00 KiB. charts = \"pack\" packs the light-map UVs")));
    for (const char* refusing : {"packing", "ground_truth"}) {
        Json other = map;
        if (std::string(refusing) == "packing") other["notes"]["packing"] = "8 x 8 texels of 16 x 16";
        if (std::string(refusing) == "ground_truth") other["ground_truth"] = Json::object();
        EXPECT_TRUE(adviceOf({{"assets", Json::array({other})}}).empty()) << refusing;
    }
}

TEST(Advice, SaysNothingWithoutFigures) {
    EXPECT_TRUE(adviceOf(Json::object()).empty());
    EXPECT_TRUE(adviceOf({{"assets", 3}, {"budget", "x"}}).empty());
    EXPECT_TRUE(adviceSection({{"assets", Json::array({{{"name", "a"}}})}}).isEmpty());
}

TEST(Shadings, RowsOfZerosAreLeftOut) {
    const Json zero = {{"rel_rms", 0.0}, {"p99", 0.0}, {"max_sampled", 0.0}}, some = {{"rel_rms", 0.0}, {"p99", 0.0}, {"max_sampled", 0.1}};
    const auto assetOf = [](const Json& diffuse, const Json& specular) {
        return Json{{"stages", Json::array({{{"name", "total"}, {"error", {{"diffuse", diffuse}, {"specular", specular}}}}})}};
    };
    EXPECT_THAT(shadingsOf(assetOf(zero, some)), ElementsAre(testing::StrEq("specular")));
    EXPECT_THAT(shadingsOf(assetOf(some, zero)), ElementsAre(testing::StrEq("diffuse")));
    EXPECT_EQ(shadingsOf(assetOf(zero, zero)).size(), 2u);
    EXPECT_EQ(shadingsOf(assetOf({{"rel_rms", nullptr}}, zero)).size(), 1u) << "not finite is not zero";
    const Json measured = {{"rel_rms", 0.0}, {"visible", {{"p99", 0.0}}}};
    EXPECT_EQ(shadingsOf(assetOf(some, measured)).size(), 2u) << "an error of 0 that was measured";
}

TEST(Script, FetchesNothing) {
    const std::string script(reportScript());
    for (const char* outside : {"fetch", "XMLHttpRequest", "import", "http", "eval", "<"}) EXPECT_THAT(script, Not(HasSubstr(outside)));
}

}  // namespace
}  // namespace lightcook::pipeline
