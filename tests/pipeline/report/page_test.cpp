#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "formats/png.h"
#include "pipeline/graph/files.h"
#include "pipeline/report/html.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Json figures(double relRms) {
    return {{"rel_rms", relRms}, {"p99", 0.0412}, {"max_sampled", 0.0987}, {"max_bound", 1.23}};
}

Json assetWith(const Json& diffuse, const Json& specular) {
    return {{"name", "lobby"},
            {"kind", "light-map"},
            {"width", 1024},
            {"height", 512},
            {"bytes_in", 56623104},
            {"bytes_gpu", 1572864},
            {"bytes_disk", 1573376},
            {"bits_per_texel", 24.0},
            {"layout", "luvw"},
            {"seconds", 3.21},
            {"verify_seconds", 125.0},
            {"stages", Json::array({{{"name", "encode"}, {"seconds", 0.34}, {"error", {{"diffuse", diffuse}, {"specular", specular}}}}})},
            {"limit", {{"metric", "rel_rms"}, {"value", 0.02}}},
            {"passed", true},
            {"textures", Json::array({{{"role", "l0"}, {"file", "lobby_l0.ktx2"}, {"format", "bc6h-uf16"}, {"bytes_gpu", 1572864}}})}};
}

Json reportOf(const Json& assets) {
    std::uint64_t used = 0;
    for (const Json& asset : assets) used += asset.at("bytes_gpu").get<std::uint64_t>();
    return {{"scene", "lobby"},
            {"tool", {{"name", "lightcook"}, {"version", "0.1.0"}}},
            {"passed", true},
            {"seconds", 12.5},
            {"peak_rss_bytes", 123456789},
            {"assets", assets},
            {"skipped", Json::array()},
            {"budget",
             {{"limit_bytes", nullptr},
              {"used_bytes", used},
              {"by_kind", assets.empty() ? Json::object() : Json{{"light-map", used}}},
              {"by_format", assets.empty() ? Json::object() : Json{{"bc6h-uf16", used}}}}}};
}

Json plainReport() {
    return reportOf(Json::array({assetWith(figures(0.0123), figures(0.00412))}));
}

std::size_t occurrences(const std::string& haystack, const std::string& needle) {
    std::size_t count = 0;
    for (std::size_t at = haystack.find(needle); at != std::string::npos; at = haystack.find(needle, at + 1)) ++count;
    return count;
}

/// Every tag that opens is closed, in order; void elements aside.
bool isBalanced(const std::string& page) {
    std::vector<std::string> open;
    for (std::size_t at = page.find('<'); at != std::string::npos; at = page.find('<', at + 1)) {
        const std::string name = page.substr(at + 1, page.find_first_of(" >", at) - at - 1);
        if (name == "!DOCTYPE" || name == "meta" || name == "img") continue;
        if (name[0] != '/') {
            open.push_back(name);
        } else {
            if (open.empty() || "/" + open.back() != name) return false;
            open.pop_back();
        }
    }
    return open.empty();
}

class ReportHtml : public ::testing::Test {
protected:
    std::string render(const Json& report) const { return renderReportHtml(report, folder_.path()); }
    void write(const std::string& name, std::string_view bytes) const { ASSERT_TRUE(writeFile(folder_ / name, bytes)); }
    static std::string smallPng() {
        formats::Image<glm::u8vec3> image(3, 2);
        for (glm::u8vec3& texel : image.texels()) texel = {200, 100, 50};
        const auto png = formats::encodePng(image.view());
        EXPECT_TRUE(png.has_value());
        return std::string(reinterpret_cast<const char*>(png->data()), png->size());
    }
    const formats::TemporaryFolder folder_;
};

TEST_F(ReportHtml, ChartsOfFewTexelsAreNamedInTheWordsOfTheViewer) {
    Json asset = assetWith(figures(0.0123), figures(0.00412));
    for (const char* shading : {"diffuse", "specular"})
        asset["stages"][0]["error"][shading]["visible"] = {{"max", 80.5}, {"max_at", {{"texel", {12.5, 7}}}}};
    asset["charts"] = {{"count", 1}, {"largest", Json::array()}, {"few_texels", Json::array({{{"shading", "specular"}, {"texels", 3.2}}})}};
    const std::string page = render(reportOf(Json::array({asset})));
    const std::string rest = " and filters read those beside it: no layout lowers this error much. Give the chart more texels in the bake.";
    EXPECT_EQ(occurrences(page, "Its chart has 3 texels," + rest), 1u) << "of specular light alone";
    const auto viewer = readFile(std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "viewer/src/main.js");
    ASSERT_TRUE(viewer.has_value());
    EXPECT_THAT(*viewer, HasSubstr(rest));
    asset["charts"]["few_texels"] = {1, {{"shading", "specular"}, {"texels", "many"}}};
    EXPECT_THAT(render(reportOf(Json::array({asset}))), Not(HasSubstr("Its chart has"))) << "a damaged report";
}

TEST(Html, EscapesWhatCouldBecomeMarkup) {
    EXPECT_EQ(text("<a href=\"x\">'&'</a>").markup(), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
    EXPECT_EQ(text(std::string_view("a\0b\x1b", 4)).markup(), "a\uFFFDb\uFFFD");
    EXPECT_EQ(text("21 × 3\n").markup(), "21 × 3\n");
    EXPECT_EQ(element("p", {{"title", "\"><script>"}}, text("<b>")).markup(), "<p title=\"&quot;&gt;&lt;script&gt;\">&lt;b&gt;</p>");
}

TEST(Html, Base64AsInRfc4648) {
    EXPECT_EQ(base64(""), "");
    EXPECT_EQ(base64("f"), "Zg==");
    EXPECT_EQ(base64("fo"), "Zm8=");
    EXPECT_EQ(base64("foo"), "Zm9v");
    EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
    EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
}

TEST(Html, BytesInTheUnitThatFits) {
    EXPECT_EQ(humanBytes(0), "0 B");
    EXPECT_EQ(humanBytes(1023), "1023 B");
    EXPECT_EQ(humanBytes(1024), "1.00 KiB");
    EXPECT_EQ(humanBytes(21811), "21.3 KiB");
    EXPECT_EQ(humanBytes(1023 * 1024), "1023 KiB");
    EXPECT_EQ(humanBytes(1024 * 1024 - 1), "1.00 MiB");
    EXPECT_EQ(humanBytes(std::uint64_t{3} << 40), "3.00 TiB");
    EXPECT_EQ(humanBytes(std::numeric_limits<std::uint64_t>::max()), "16.0 EiB");
    EXPECT_EQ(groupedCount(0), "0");
    EXPECT_EQ(groupedCount(999), "999");
    EXPECT_EQ(groupedCount(1000), "1,000");
    EXPECT_EQ(groupedCount(1234567), "1,234,567");
}

TEST(Html, SecondsInTheUnitThatFits) {
    EXPECT_EQ(humanSeconds(0), "0 s");
    EXPECT_EQ(humanSeconds(0.00025), "0.250 ms");
    EXPECT_EQ(humanSeconds(0.34), "340 ms");
    EXPECT_EQ(humanSeconds(0.9999), "1.00 s");
    EXPECT_EQ(humanSeconds(12.34), "12.3 s");
    EXPECT_EQ(humanSeconds(59.97), "1 min 00 s");
    EXPECT_EQ(humanSeconds(125), "2 min 05 s");
    EXPECT_EQ(humanSeconds(3725), "1 h 02 min");
    EXPECT_EQ(humanSeconds(kNan), "not finite");
}

TEST(Html, RatiosInPercent) {
    EXPECT_EQ(humanPercent(0), "0 %");
    EXPECT_EQ(humanPercent(0.0123), "1.23 %");
    EXPECT_EQ(humanPercent(0.00412), "0.412 %");
    EXPECT_EQ(humanPercent(1e-6), "< 0.001 %");
    EXPECT_EQ(humanPercent(0.09996), "10.0 %");
    EXPECT_EQ(humanPercent(3.4), "340 %");
    EXPECT_EQ(humanPercent(2e7), "2e+09 %");
    EXPECT_EQ(humanPercent(kNan), "not finite");
    EXPECT_EQ(humanPercent(kInfinity), "not finite");
    EXPECT_EQ(exactNumber(0.1), "0.1");
}

TEST_F(ReportHtml, SaysWhatTheReportSays) {
    const std::string page = render(plainReport());
    EXPECT_TRUE(isBalanced(page));
    EXPECT_THAT(page, HasSubstr("<title>lobby: passed</title>"));
    EXPECT_THAT(page, HasSubstr("✓ passed"));
    EXPECT_THAT(page, Not(HasSubstr("✗ failed")));
    EXPECT_THAT(page, HasSubstr("<span title=\"1,572,864 bytes\">1.50 MiB</span>"));
    EXPECT_THAT(page, HasSubstr("<span title=\"0.0123\">1.23 %</span>"));
    EXPECT_THAT(page, HasSubstr("<span title=\"0.00412\">0.412 %</span>"));
    EXPECT_THAT(page, Not(HasSubstr("title=\"1.23\""))) << "a relative bound, which says nothing of what is seen";
    EXPECT_THAT(page, HasSubstr("1024 × 512"));
    EXPECT_THAT(page, HasSubstr("2 min 05 s"));
    EXPECT_THAT(page, HasSubstr("118 MiB"));
    EXPECT_THAT(page, HasSubstr("lightcook 0.1.0"));
    EXPECT_THAT(page, HasSubstr("lobby_l0.ktx2"));
    EXPECT_THAT(page, HasSubstr("the scene has no memory budget"));
    EXPECT_THAT(page, HasSubstr("Nothing was skipped."));
}

TEST_F(ReportHtml, NeedsNoOtherFile) {
    const std::string page = render(plainReport());
    for (const char* outside : {"<link", "http:", "https:", "@import", "src=\"/", "src=\"h"}) EXPECT_THAT(page, Not(HasSubstr(outside)));
    EXPECT_EQ(occurrences(page, "url("), occurrences(page, "url(#")) << "filters of the page itself";
    EXPECT_EQ(occurrences(page, "<script"), 1u) << "our own";
    EXPECT_THAT(page, HasSubstr("<script>\n\"use strict\";"));
}

TEST_F(ReportHtml, EscapesEverythingThatCameFromOutside) {
    const std::string evil = "<script>alert(\"x\")</script>&'";
    Json asset = assetWith(figures(0.5), figures(kNan));
    for (const char* key : {"name", "kind", "layout"}) asset[key] = evil;
    asset["passed"] = false;
    asset["stages"][0]["name"] = evil;
    for (const char* key : {"role", "file", "format"}) asset["textures"][0][key] = evil;
    asset["notes"] = {{evil, 3}, {"said", evil}};
    asset["measures"] = {{evil, {{evil, evil}}}};
    asset["preview"] = {{"reference", evil}, {"cooked", evil}, {"difference", evil}};
    Json report = reportOf(Json::array({asset}));
    report["scene"] = evil;
    report["tool"] = {{"name", evil}, {"version", evil}};
    report["passed"] = false;
    report["budget"]["by_kind"] = {{evil, 10}};
    report["budget"]["by_format"] = {{evil, 10}};
    report["skipped"] = Json::array({{{"what", evil}, {"why", evil}, {"bytes_saved", 1}, {"seconds_saved", 1}}});
    const std::string page = render(report);
    EXPECT_EQ(occurrences(page, "<script"), 1u) << "our own";
    EXPECT_THAT(page, Not(HasSubstr("alert(\"")));
    EXPECT_TRUE(isBalanced(page));
    EXPECT_THAT(page, HasSubstr("<title>&lt;script&gt;alert(&quot;x&quot;)&lt;/script&gt;&amp;&#39;: failed</title>"));
}

TEST_F(ReportHtml, ShowsTheCandidatesBesideTheChosenLayout) {
    const auto candidate = [](const char* layout, int bytes, double bits, double diffuse, double specular) {
        return Json{{"layout", layout}, {"bytes_gpu", bytes}, {"bits_per_texel", bits}, {"diffuse", diffuse}, {"specular", specular}};
    };
    Json asset = assetWith(figures(0.01), figures(0.015));
    asset["trial_candidates"] = Json::array({candidate("tiny", 100, 8, 0.2, 0.3), candidate("small", 150, 12, 0.03, 0.05),
                                             candidate("luvw", 200, 24, 0.01, 0.015), candidate("odd", 300, 40, 0.008, 0.02),
                                             candidate("large", 400, 48, 0.002, 0.014), candidate("<b>&", 500, 72, 0.001, 0.002)});
    const std::string page = render(reportOf(Json::array({asset})));
    EXPECT_TRUE(isBalanced(page));
    EXPECT_THAT(page, HasSubstr("luvw (chosen)"));
    EXPECT_THAT(page, HasSubstr("small (next cheaper)"));
    EXPECT_THAT(page, HasSubstr("large (next better)"));
    EXPECT_EQ(occurrences(page, "(next"), 2u);
    EXPECT_EQ(occurrences(page, "class=\"dot\""), 6u);
    EXPECT_EQ(occurrences(page, "class=\"ring\""), 6u);
    EXPECT_EQ(occurrences(page, "<g class=\"chosen\">"), 1u);
    EXPECT_EQ(occurrences(page, "<line class=\"limit\""), 1u);
    EXPECT_THAT(page, HasSubstr("&lt;b&gt;&amp;</text>"));
    // Points that cannot be drawn are left out; one point makes no curve.
    for (std::size_t i = 0; i < 5; ++i) asset["trial_candidates"][i]["diffuse"] = i % 2 == 0 ? Json(nullptr) : Json(kInfinity);
    EXPECT_EQ(occurrences(render(reportOf(Json::array({asset}))), "<svg class=\"curve"), 0u);
}

TEST_F(ReportHtml, ShowsVisibleErrorsAsTablePlotAndPlaces) {
    const Json visible = {{"rms", 1.5},
                          {"p50", 0.5},
                          {"p95", 3.0},
                          {"p99", 5.25},
                          {"p999", 9.0},
                          {"max", 40.0},
                          {"histogram", {0, 100, 0, 60, 30, 9, 1, 0, 0, 0, 0, 0, 0, 0}}};
    Json diffuse = figures(0.01), specular = figures(0.02);
    diffuse["visible"] = specular["visible"] = visible;
    Json asset = assetWith(diffuse, specular);
    asset["limit"]["max_visible"] = 8.0;
    write("lobby_worst_1.png", smallPng());
    const auto placeOf = [](const char* file) {
        return Json{
            {"file", file}, {"texel", {192, 43}}, {"visible", 20.5}, {"reference", {0.25, 0.5, 1.0}}, {"found", {0.125, 0.5, nullptr}}};
    };
    asset["preview"] = {{"reference", ""},
                        {"cooked", ""},
                        {"difference", ""},
                        {"worst", {placeOf("lobby_worst_1.png"), placeOf("../outside.png"), Json(3)}}};
    EXPECT_THAT(render(reportOf(Json::array({asset}))), Not(HasSubstr("<details")));
    asset["preview"]["any_normal"] = "lobby_worst_1.png";
    const std::string page = render(reportOf(Json::array({asset})));
    EXPECT_TRUE(isBalanced(page));
    EXPECT_EQ(occurrences(page, "<summary>Visible error at any normal</summary>"), 1u);
    EXPECT_EQ(occurrences(page, "<rect class=\"diffuse\""), 5u);
    EXPECT_EQ(occurrences(page, "<rect class=\"specular\""), 5u);
    EXPECT_THAT(page, HasSubstr("diffuse: 50 % of 200 samples"));
    EXPECT_EQ(occurrences(page, "limit on p99"), 1u);
    EXPECT_THAT(page, HasSubstr("<b>Texel 192, 43</b>: visible error 20.5; bake (0.250, 0.500, 1.00), cooked (0.125, 0.500, not finite)"));
    EXPECT_THAT(page, HasSubstr("picture missing: ../outside.png"));
    EXPECT_EQ(occurrences(page, "data:image/png"), 2u);
    // A histogram of another size is not drawn.
    asset["stages"][0]["error"]["diffuse"]["visible"]["histogram"] = {1, 2, 3};
    EXPECT_EQ(occurrences(render(reportOf(Json::array({asset}))), "<rect class=\"diffuse\""), 0u);
}

TEST_F(ReportHtml, DrawsLayoutsInBothUnits) {
    Json asset = assetWith(figures(0.01), figures(0.015));
    asset["limit"]["max_visible"] = 5.0;
    for (int i = 0; i < 3; ++i)
        asset["trial_candidates"].push_back({{"layout", fmt::format("layout-{}", i)},
                                             {"bytes_gpu", 100 * (i + 1)},
                                             {"bits_per_texel", 8 << i},
                                             {"diffuse", 0.04 / (i + 1)},
                                             {"specular", 0.05 / (i + 1)},
                                             {"visible_diffuse", 9.0 / (i + 1)},
                                             {"visible_specular", 12.0 / (i + 1)}});
    const std::string page = render(reportOf(Json::array({asset})));
    EXPECT_TRUE(isBalanced(page));
    EXPECT_EQ(occurrences(page, "<svg class=\"curve\""), 2u) << "without figures of run time, two of four";
    EXPECT_EQ(occurrences(page, "class=\"dot\""), 6u);
    EXPECT_EQ(occurrences(page, "<line class=\"limit\""), 2u);
    EXPECT_THAT(page, HasSubstr("aria-label=\"Visible error of each layout"));
    EXPECT_THAT(page, HasSubstr(">12.00</span>"));
}

TEST_F(ReportHtml, SaysNotFiniteForNullAndForNan) {
    Json report = reportOf(Json::array({assetWith(figures(kNan), figures(kInfinity))}));
    report["assets"][0]["passed"] = false;
    const std::string inMemory = render(report);
    const std::string fromFile = render(Json::parse(report.dump()));
    EXPECT_EQ(inMemory, fromFile);
    EXPECT_THAT(fromFile, HasSubstr("diffuse after stage encode is not finite (rel_rms)"));
    EXPECT_THAT(fromFile, HasSubstr("specular after stage encode is not finite (rel_rms)"));
    EXPECT_THAT(fromFile, HasSubstr("<span title=\"not finite\">not finite</span>"));
    for (const char* wrong : {">nan", "\"nan", ">inf", "\"inf", "-nan"}) EXPECT_THAT(fromFile, Not(HasSubstr(wrong)));
}

TEST_F(ReportHtml, FiguresThatAreAbsentAreADash) {
    Json diffuse = figures(0.01);
    diffuse.erase("p99");
    const std::string page = render(reportOf(Json::array({assetWith(diffuse, nullptr)})));
    // p99 of both tables, and both visible errors; specular light, of which nothing was measured, has no rows.
    EXPECT_EQ(occurrences(page, "<span title=\"not measured\">–</span>"), 4u);
    EXPECT_THAT(page, Not(HasSubstr("<td class=\"shading\">specular</td>")));
    EXPECT_THAT(page, Not(HasSubstr("not finite")));
}

TEST_F(ReportHtml, SaysWhyItFailed) {
    Json report = reportOf(Json::array({assetWith(figures(0.01), figures(0.031))}));
    report["passed"] = report["assets"][0]["passed"] = false;
    const std::string page = render(report);
    EXPECT_THAT(page, HasSubstr("What failed"));
    EXPECT_THAT(page, HasSubstr("specular rel_rms is 3.10 %, the limit is 2.00 %"));
    EXPECT_THAT(page, Not(HasSubstr("diffuse rel_rms is")));
    EXPECT_THAT(page, HasSubstr("✗ failed"));
    EXPECT_THAT(page, HasSubstr("0 of 1"));
}

TEST_F(ReportHtml, PutsPicturesInside) {
    write("preview/lobby_cooked.png", smallPng());
    write("preview/lobby_difference.png", "no picture at all, but longer than a header of a PNG file is");
    Json report = plainReport();
    report["assets"][0]["preview"] = {{"reference", "preview/lobby_reference.png"},
                                      {"cooked", "preview/lobby_cooked.png"},
                                      {"difference", "preview/lobby_difference.png"}};
    const std::string page = render(report);
    EXPECT_EQ(occurrences(page, "<img "), 1u);
    EXPECT_THAT(page, HasSubstr("src=\"data:image/png;base64,iVBORw0KGgo"));
    EXPECT_THAT(page, HasSubstr("width=\"3\" height=\"2\""));
    EXPECT_THAT(page, HasSubstr("picture missing: preview/lobby_reference.png"));
    EXPECT_THAT(page, HasSubstr("picture missing: preview/lobby_difference.png"));
}

TEST_F(ReportHtml, TakesNoPictureFromOutsideTheFolder) {
    write("secret.png", smallPng());
    std::filesystem::create_directory(folder_ / "cooked");
    EXPECT_TRUE(loadPicture(folder_.path(), "secret.png").has_value());
    EXPECT_FALSE(loadPicture(folder_ / "cooked", "../secret.png").has_value());
    EXPECT_FALSE(loadPicture(folder_ / "cooked", (folder_ / "secret.png").string()).has_value());
    EXPECT_FALSE(loadPicture(folder_.path(), "cooked").has_value());
    EXPECT_FALSE(loadPicture(folder_.path(), "").has_value());
}

TEST_F(ReportHtml, BudgetOfNothingAndBudgetOverrun) {
    Json empty = reportOf(Json::array());
    empty["budget"]["limit_bytes"] = 0;
    const std::string nothing = render(empty);
    EXPECT_THAT(nothing, HasSubstr("0 B of 0 B used, 0 B free"));
    EXPECT_THAT(nothing, HasSubstr("No assets were cooked."));
    EXPECT_THAT(nothing, Not(HasSubstr("What failed")));
    EXPECT_TRUE(isBalanced(nothing));

    Json report = plainReport();
    report["passed"] = false;
    report["budget"]["limit_bytes"] = 0;
    EXPECT_THAT(render(report), HasSubstr("memory budget: 1.50 MiB of 0 B used, 1.50 MiB over"));
    report["budget"]["limit_bytes"] = 1048576;
    const std::string over = render(report);
    EXPECT_THAT(over, HasSubstr("1.50 MiB of 1.00 MiB used (150 %), 512 KiB over"));
    EXPECT_THAT(over, HasSubstr("left:66.667%"));
    for (const char* wrong : {"nan%", "inf%"}) EXPECT_THAT(over, Not(HasSubstr(wrong)));
    report["budget"]["limit_bytes"] = 3145728;
    EXPECT_THAT(render(report), HasSubstr("1.50 MiB of 3.00 MiB used (50.0 %), 1.50 MiB free"));
}

TEST_F(ReportHtml, NotesInWordsAndOnlyWhereThereIsSomethingToSay) {
    Json report = plainReport();
    report["assets"][0]["notes"] = {{"covered_texels", 812345}, {"clamped_high", 0}, {"repaired_not_finite", 7}, {"window_lambda", 0.0}};
    report["assets"][0]["mesh_error"] = {{"position", 0.000012}, {"normal_radians", 0.0}, {"light_map_uv", 0.00001}};
    const std::string page = render(report);
    EXPECT_THAT(page, HasSubstr("<dt>Texels inside charts</dt><dd>812,345</dd>"));
    EXPECT_THAT(page, HasSubstr("<dt>Texels set to zero because a coefficient was not finite</dt><dd>7</dd>"));
    EXPECT_THAT(page, Not(HasSubstr("clamped")));
    EXPECT_THAT(page, Not(HasSubstr("lambda")));
    EXPECT_THAT(page, HasSubstr("Largest shift of a position"));
}

TEST_F(ReportHtml, SkipsAreAddedUp) {
    Json report = plainReport();
    report["skipped"] = Json::array({{{"what", "dominant"}, {"why", "no specular"}, {"bytes_saved", 1024}, {"seconds_saved", 1.5}},
                                     {{"what", "lut"}, {"why", "no specular"}, {"bytes_saved", 2048}, {"seconds_saved", 0.75}}});
    const std::string page = render(report);
    EXPECT_THAT(page, HasSubstr("<span title=\"3,072 bytes\">3.00 KiB</span>"));
    EXPECT_THAT(page, HasSubstr("<span title=\"2.25 s\">2.25 s</span>"));
}

TEST_F(ReportHtml, SurvivesAReportOfAnotherShape) {
    for (const char* shape :
         {"null", "3", "[]", "{}", R"({"assets": {}, "budget": 3, "skipped": "none", "scene": 5})",
          R"({"assets": [null, 7, [], {"stages": [1, {"error": "x"}], "textures": [2], "notes": 3, "preview": {"cooked": 4}}],
                                  "budget": {"limit_bytes": "x", "used_bytes": -4, "by_kind": [1], "by_format": {"a": "b"}},
                                  "skipped": [1]})"}) {
        const std::string page = render(Json::parse(shape));
        EXPECT_TRUE(isBalanced(page)) << shape;
        EXPECT_THAT(page, HasSubstr("What the figures mean")) << shape;
    }
}

TEST_F(ReportHtml, SameReportSamePage) {
    EXPECT_EQ(render(plainReport()), render(plainReport()));
}

/// The limit that is used most may be that of another figure than rel_rms.
TEST_F(ReportHtml, NamesTheLimitThatIsUsedMost) {
    Json visible = {{"rms", 0.3}, {"p50", 0.2}, {"p95", 0.8}, {"p99", 1.04}, {"p999", 2.0}, {"max", 6.0}, {"bound", 9.0}};
    Json diffuse = figures(0.002), asset = assetWith(diffuse, figures(0.001));
    EXPECT_THAT(render(reportOf(Json::array({asset}))), HasSubstr("lobby uses most of its limit: rel_rms 0.200 % of 2.00 % (10.0 %)"));
    diffuse["visible"] = visible;
    asset["stages"][0]["error"]["diffuse"] = diffuse;
    asset["limit"]["max_visible"] = 1.1;
    const std::string page = render(reportOf(Json::array({asset})));
    EXPECT_THAT(page, HasSubstr("lobby uses most of its limit: visible p99 1.04 of 1.1 (94.5 %)"));
    EXPECT_THAT(page, HasSubstr("limit <span title=\"0.02\">2.00 %</span>, visible 1.1"));
    EXPECT_THAT(page, HasSubstr("1.04</span><span class=\"meter\"><i style=\"width:94.5%\">")) << "under the visible p99 as well";
    asset["limit"]["max_visible_bound"] = 9.2;
    EXPECT_THAT(render(reportOf(Json::array({asset}))), HasSubstr("visible bound 9.00 of 9.2 (97.8 %)"));
    asset["limit"]["max_seam"] = 2;
    asset["seams"] = {{"worst", Json::array({{{"added", 1.99}}})}};
    EXPECT_THAT(render(reportOf(Json::array({asset}))), HasSubstr("seam 1.99 of 2 (99.5 %)"));
    asset["whole"] = {{"visible", visible}, {"rel_rms", 0.3}, {"max_visible", 1}, {"max_error", 0.1}};
    EXPECT_THAT(render(reportOf(Json::array({asset}))), HasSubstr("rel_rms with its dominant light 30.0 % of 10.0 % (300 %)"));
    asset["stages"][0]["error"]["diffuse"]["visible"]["p99"] = kNan;
    EXPECT_THAT(render(reportOf(Json::array({asset}))), HasSubstr("visible p99 not finite of 1.1."));
}

}  // namespace
}  // namespace lightcook::pipeline
