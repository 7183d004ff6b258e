// report.html: its data, and the page without scripts. tests/viewer/report_test.py has the page in a browser.
#include "pipeline/report/page.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <limits>

#include "formats/light_map_layout.h"
#include "formats/png.h"
#include "pipeline/report/bundle.h"
#include "pipeline/report/failures.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kEvil = "</script><!--<script>alert(\"x\")</script>&'\u2028";

ReportRow pageRow(const std::string& name, double error) {
    ReportRow row;
    row.name = name;
    row.layout = "ratio";
    row.bytesGpu = 1572864;
    row.verdict.limits[Limit::Error] = 0.02;
    verify::StageError stage;
    stage.name = "total";
    stage.diffuse.relRms = 0.001;
    stage.specular.relRms = error;
    row.verdict.stages = {stage};
    row.verdict.passed = error <= 0.02;
    if (!row.verdict.passed) row.failures = failuresOf(row, LimitsFrom::SceneFile);
    return row;
}

Report pageReport(std::vector<ReportRow> rows) {
    return makeReport({"lobby", 1.5, 0, std::nullopt, {{"2026-11-01T10:00:00.000Z", 1.5, 1, 1}}}, std::move(rows), {});
}

CookedFolder pageFolder(const std::string& scene, std::vector<ReportRow> rows) {
    CookedFolder folder;
    folder.folder = "cooked/" + scene;
    folder.target = "bc";
    folder.report = pageReport(std::move(rows));
    folder.report.scene = scene;
    return folder;
}

/// Returns the data of a page as its script reads them.
Json dataOn(const std::string& page) {
    constexpr std::string_view kStart = "<script type=\"application/json\" id=\"data\">";
    const std::size_t at = page.find(kStart) + kStart.size();
    return Json::parse(page.substr(at, page.find("</script>", at) - at));
}

std::size_t countOf(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
}

TEST(ReportPage, HoldsTheReportAndItsHistory) {
    Report report = pageReport({pageRow("map", 0.01)});
    report.files.emplace().push_back({"cooked.json", "0"});
    const std::vector<HistoryLine> history = {historyLine(report, "bc")};
    const Json data = dataOn(renderReportHtml(report, {""}, history));
    Json expected = toJson(report);
    expected.erase("files");  // the page is one of the files
    EXPECT_EQ(data.at("report"), expected);
    EXPECT_EQ(data.at("history"), jsonOf(history));
    EXPECT_EQ(data.at("uses"), Json::parse(R"([{"share": 0.5, "words": "rel_rms 1.00 % of 2 %"}])"));
    EXPECT_EQ(data.at("kinds").at("light-map"), "light map");
    EXPECT_EQ(data.at("formats").at("bc7"), (Json{{"side", 4}, {"bytes", 16}}));
    EXPECT_EQ(renderReportHtml(report, {""}, history), renderReportHtml(report, {""}, history));
}

TEST(ReportPage, HasVerdictFailuresAndTableWithoutScripts) {
    Report report = pageReport({pageRow("map", 0.01), pageRow("other", 0.031), pageRow("third", std::nan(""))});
    report.incomplete = IncompleteCook{{"sky"}, {}};
    const std::string page = renderReportHtml(report, {""});
    EXPECT_THAT(page, AllOf(HasSubstr("<title>lobby: failed</title>"),
                            HasSubstr("<h1>lobby</h1>\n<p>failed: 1 of 3 assets passed, 4.50 MiB of GPU memory</p>"),
                            HasSubstr("<li>sky: not cooked</li>"),
                            HasSubstr("<li>other, stage total, specular: found rel_rms 0.031, expected at most 0.02 (max_error). "),
                            HasSubstr(" A limit of 0.031 allows it.</li>"),
                            HasSubstr("<tr><td>map</td><td>1572864</td><td>1.00 %</td><td>2.00 %</td><td>passed</td></tr>"),
                            HasSubstr("<tr><td>other</td><td>1572864</td><td>3.10 %</td><td>2.00 %</td><td>failed</td></tr>"),
                            HasSubstr("<tr><td>third</td><td>1572864</td><td>not finite</td><td>2.00 %</td><td>failed</td></tr>")));
}

TEST(ReportPage, NothingThatCameFromOutsideBecomesMarkup) {
    ReportRow row = pageRow(kEvil, 0.5);
    row.layout = kEvil;
    row.notes = Json{{kEvil, kEvil}};
    row.verdict.stages.back().name = kEvil;
    row.textures = {{kEvil, kEvil, kEvil, 1}};
    row.failures = failuresOf(row, LimitsFrom::SceneFile);
    Report report = pageReport({row});
    report.scene = kEvil;
    const std::string template_(reportTemplate());
    const std::string page = renderReportHtml(report, {""});
    for (const char* markup : {"<script", "</script", "<!--"})
        EXPECT_EQ(countOf(page, markup), countOf(template_, markup) - (std::string_view(markup) == "<!--" ? 3 : 0)) << markup;
    EXPECT_EQ(countOf(page, "\u2028"), countOf(template_, "\u2028") + 5)
        << "only as text: title, heading, asset and stage of the failure, table";
    EXPECT_EQ(dataOn(page).at("report").at("scene"), kEvil);
    CollectionReport collection = makeCollection({pageFolder(kEvil, {row})});
    collection.scenes[0].errors = {kEvil};
    EXPECT_EQ(countOf(renderCollectionHtml(collection, "all.html", {}), "</script"), countOf(template_, "</script"));
}

TEST(ReportPage, NeedsNoOtherFile) {
    const std::string page = renderReportHtml(pageReport({pageRow("map", 0.01)}), {""});
    for (const char* outside : {"<link", "https:", "@import", "src=\"", "fetch(", "XMLHttpRequest", "eval("})
        EXPECT_THAT(page, Not(HasSubstr(outside)));
    EXPECT_EQ(countOf(page, "http://"), countOf(page, "http://www.w3.org/2000/svg")) << "a name, not an address";
    EXPECT_EQ(countOf(page, "url("), countOf(page, "url(#")) << "filters of the page itself";
}

TEST(ReportPage, HoldsThePicturesOfItsFolder) {
    const formats::TemporaryFolder folder;
    formats::Image<glm::u8vec3> image(3, 2);
    const auto png = formats::encodePng(image.view());
    ASSERT_TRUE(png.has_value());
    for (const char* name : {"preview/cooked.png", "preview/old.png", "secret.png"})
        ASSERT_TRUE(writeFile(folder / name, std::string(reinterpret_cast<const char*>(png->data()), png->size())));
    ASSERT_TRUE(writeFile(folder / "preview/no.png", "no picture at all, but longer than a header of a PNG file is"));
    ReportRow row = pageRow("map", 0.01);
    row.preview = PreviewFiles{.reference = "secret.png", .cooked = "preview/cooked.png", .difference = "preview/no.png"};
    Report report = pageReport({row});
    AssetChange& change = report.baseline.emplace().assets.emplace_back();
    change.pictureNow = (folder / "preview/old.png").string();
    const Json pictures = dataOn(renderReportHtml(report, folder.path())).at("pictures");
    EXPECT_EQ(pictures.size(), 2u) << "no file outside the folder of pictures, and no other kind of file";
    EXPECT_THAT(pictures.at("preview/cooked.png").get<std::string>(), testing::StartsWith("data:image/png;base64,iVBORw0KGgo"));
    EXPECT_TRUE(pictures.contains((folder / "preview/old.png").string()));
}

TEST(CollectionPage, HasATableAndLinksToScenes) {
    ReportRow map = pageRow("map", 0.002), other = pageRow("other", 0.01);
    map.verdict.limits[Limit::Visible] = 1.1;
    map.verdict.stages.back().diffuse.visible.emplace().p99 = 1.04;
    CollectionReport report = makeCollection({pageFolder("hall", {map, other})});
    report.scenes[0].folder = "cooked/roof 100%";
    const std::string page = renderCollectionHtml(report, "cooked/all.html", {});
    const Json data = dataOn(page);
    EXPECT_EQ(data.at("collection"), toJson(report));
    EXPECT_EQ(data.at("links"), Json{"roof%20100%25/report.html"});
    EXPECT_EQ(dataOn(renderCollectionHtml(report, "", {})).at("links"), Json{""});
    EXPECT_EQ(data.at("uses").at(0).at(0).at("words"), "visible p99 1.04 of 1.1");
    EXPECT_THAT(page, AllOf(HasSubstr("<title>1 scene: passed</title>"),
                            HasSubstr("<tr><td>hall</td><td>bc</td><td>3145728</td><td></td><td>passed</td></tr>")));
}

TEST(ReportPage, EveryStageHasWords) {
    const auto captions = readFile(std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "viewer/report/captions.js");
    ASSERT_TRUE(captions.has_value());
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts())
        for (const std::string_view stage : layout.stages) EXPECT_THAT(*captions, HasSubstr(fmt::format("\n  \"{}\": \"", stage)));
}

TEST(Words, RatiosInPercent) {
    EXPECT_EQ(humanPercent(0), "0 %");
    EXPECT_EQ(humanPercent(0.0123), "1.23 %");
    EXPECT_EQ(humanPercent(0.00412), "0.412 %");
    EXPECT_EQ(humanPercent(1e-6), "< 0.001 %");
    EXPECT_EQ(humanPercent(0.09996), "10.0 %");
    EXPECT_EQ(humanPercent(3.4), "340 %");
    EXPECT_EQ(humanPercent(2e7), "2e+09 %");
    EXPECT_EQ(humanPercent(std::numeric_limits<double>::infinity()), "not finite");
}

}  // namespace
}  // namespace lightcook::pipeline
