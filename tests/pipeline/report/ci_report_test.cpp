// JUnit and SARIF of runs that passed, failed and broke off: against their schemas, and the text of a check.
#include "pipeline/report/ci_report.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>

#include "pipeline/document/json.h"
#include "tests/pipeline/shell.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

const std::filesystem::path kSchemas = std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "tests/pipeline/report/schemas";

/// Expects a text to keep a schema; skips the test without the validator.
/// trial  command that succeeds where the validator is installed
void expectValid(const std::string& text, const std::string& suffix, const std::string& trial, const std::string& validator) {
    if (runShell(trial + " >/dev/null 2>&1") != 0) GTEST_SKIP() << "not installed: " << trial;
    const formats::TemporaryFolder folder;
    formats::writeContent(folder / ("report" + suffix), text);
    const std::string messages = (folder / "messages").string();
    EXPECT_EQ(runShell(fmt::format("{} '{}' >'{}' 2>&1", validator, (folder / ("report" + suffix)).string(), messages)), 0)
        << formats::contentOf(messages) << text;
}
void expectJunit(const std::string& xml) {
    expectValid(xml, ".xml", "xmllint --version", fmt::format("xmllint --noout --schema '{}'", (kSchemas / "junit.xsd").string()));
}
void expectSarif(const std::string& json) {
    expectValid(json, ".json", "python3 -c 'import jsonschema'",
                fmt::format("python3 -c 'import json, jsonschema, sys; jsonschema.Draft4Validator(json.load(open(\"{}\"))).validate("
                            "json.load(open(sys.argv[1])))'",
                            (kSchemas / "sarif-2.1.0.json").string()));
}

class CiReport : public testing::Test {
protected:
    void cook(const std::string& output = "") {
        scene_.writeSceneFile(output);
        outcome_ = cookScene(scene_.options(), state_);
    }
    void verify() { outcome_ = verifyCooked({scene_ / "out", {}, {}}, state_); }

    CiRun run() const { return ciRun({"verify", scene_ / "out", {}, {}, outcome_.report, outcome_.errors, &outcome_.findings}); }

    /// Returns the names of the checks of an asset that failed.
    static std::vector<std::string> failed(const CiRun& run, const std::string& suite) {
        std::vector<std::string> names;
        for (const CiSuite& each : run.suites)
            if (each.name == suite)
                for (const CiCheck& check : each.checks)
                    if (!check.findings.empty()) names.emplace_back(info(check.rule).name);
        return names;
    }

    /// Expects one finding, at the line of the scene file that has a text.
    void expectOneFindingAt(const CiRun& run, const std::string& text) const {
        const std::string scene = formats::contentOf(scene_.sceneFile());
        const auto line = 1 + std::count(scene.begin(), scene.begin() + static_cast<std::ptrdiff_t>(scene.find(text)), '\n');
        int findings = 0;
        for (const CiSuite& suite : run.suites)
            for (const CiCheck& check : suite.checks)
                for (const CiFinding& finding : check.findings) {
                    EXPECT_EQ(finding.at.line, line) << finding.message;
                    ++findings;
                }
        EXPECT_EQ(findings, 1);
    }

    SmallScene scene_{SmallScene::Parts::All};
    RunState state_;
    Outcome outcome_;
};

TEST_F(CiReport, HasACaseForEachAssetAndCheckOfARunThatPassed) {
    cook();
    verify();
    const CiRun run = this->run();
    ASSERT_EQ(run.suites.size(), 1 + outcome_.report.at("assets").size());
    const std::string junit = junitReport(run), sarif = sarifReport(run);
    EXPECT_THAT(junit, HasSubstr("<testsuites name=\"lightcook verify "));
    EXPECT_THAT(junit, HasSubstr("<testcase classname=\"small.map\" name=\"diffuse-error\" "));
    EXPECT_THAT(junit, HasSubstr("<testcase classname=\"small.probe\" name=\"unchanged-files\" "));
    EXPECT_THAT(junit, HasSubstr("<testcase classname=\"small.(scene)\" name=\"memory-budget\" "));
    EXPECT_THAT(junit, Not(HasSubstr("<failure")));
    EXPECT_THAT(junit, Not(HasSubstr("<skipped")));
    EXPECT_TRUE(parseJson(sarif).at("runs")[0].at("results").empty());
    expectJunit(junit);
    expectSarif(sarif);
}

TEST_F(CiReport, FailedChecksHaveFindingsAtLinesOfTheSceneFile) {
    cook("max_error = \"0.0001%\"\nmax_converter_error = 1e-6\nbudget = \"100\"\nlight_map_layout = \"basis-3\"");
    verify();
    ASSERT_FALSE(outcome_.errors.empty());
    const CiRun run = this->run();
    EXPECT_THAT(failed(run, "map"), testing::IsSupersetOf({"diffuse-error", "specular-error"}));
    EXPECT_THAT(failed(run, "probe"), testing::Contains("specular-error"));
    EXPECT_THAT(failed(run, kSceneSuite), ElementsAre("memory-budget"));
    const std::string junit = junitReport(run), text = sarifReport(run);
    expectJunit(junit);
    expectSarif(text);
    for (const char* fact : {"asset: map", "stage: ", "texel: ", "normal: ", "found: ", "reference: ", "allowed: "})
        EXPECT_THAT(junit, HasSubstr(fmt::format("\n  {}", fact)));

    // schema, name, -, [output], four keys, -, [[light_map]] in line 10; [[probe]] in line 15.
    const Json sarif = parseJson(text);
    const Json& results = sarif.at("runs")[0].at("results");
    ASSERT_EQ(results.size(), outcome_.errors.size());
    for (const Json& result : results) {
        const Json& place = result.at("locations")[0].at("physicalLocation");
        EXPECT_THAT(place.at("artifactLocation").at("uri").get<std::string>(), testing::EndsWith("/scene.toml"));
        const std::string asset = result.at("locations")[0].at("logicalLocations")[0].at("name");
        const int line = place.at("region").at("startLine");
        const std::map<std::string, int> lines = {{"map", 10}, {"map_dominant", 10}, {"probe", 15}, {kSceneSuite, 7}};
        if (const auto expected = lines.find(asset); expected != lines.end()) {
            EXPECT_EQ(line, expected->second) << result.dump(2);
        }
        const Json& rule = sarif.at("runs")[0].at("tool").at("driver").at("rules").at(result.at("ruleIndex").get<std::size_t>());
        EXPECT_EQ(rule.at("id"), result.at("ruleId"));
        EXPECT_GT(rule.at("help").at("text").get<std::string>().size(), 40u);
        if (asset == kSceneSuite) continue;
        for (const char* key : {"asset", "stage", "found", "allowed"}) EXPECT_TRUE(result.at("properties").contains(key)) << result.dump(2);
    }
}

TEST_F(CiReport, SaysWhichFileChangedAndWhatWasNotMeasured) {
    cook();
    ASSERT_TRUE(outcome_.errors.empty()) << outcome_.errors.front().line();
    formats::writeContent(scene_ / "out" / "sky.ktx2", "x");
    verify();
    CiRun run = this->run();
    EXPECT_THAT(failed(run, "sky"), ElementsAre("unchanged-files"));
    EXPECT_THAT(failed(run, "map"), ElementsAre());
    const std::string junit = junitReport(run);
    EXPECT_THAT(junit, HasSubstr("name=\"diffuse-error\" time=\"0.000\"><skipped message=\"not measured: "));
    expectJunit(junit);
    expectSarif(sarifReport(run));

    std::filesystem::remove(scene_ / "out" / "cooked.json");
    verify();
    run = this->run();
    EXPECT_THAT(failed(run, kSceneSuite), ElementsAre("input"));
    expectJunit(junitReport(run));
    expectSarif(sarifReport(run));
}

TEST_F(CiReport, AChangedSourceIsTheFaultOfItsAsset) {
    cook();
    ASSERT_TRUE(outcome_.errors.empty()) << outcome_.errors.front().line();
    std::filesystem::copy_file(scene_ / "map.exr", scene_ / "probe.exr", std::filesystem::copy_options::overwrite_existing);
    verify();
    EXPECT_THAT(failed(run(), "probe"), ElementsAre("unchanged-files"));
    expectOneFindingAt(run(), "file = \"probe.exr\"");
}

/// An asset that was never cooked is in no manifest: the scene file says where its input is named.
TEST_F(CiReport, AnUnreadableInputIsAtTheLineThatNamesIt) {
    scene_.writeSceneFile("");
    formats::writeContent(scene_ / "sky.exr", "no picture");
    CookOptions options = scene_.options();
    options.keepGoing = true;
    outcome_ = cookScene(options, state_);
    ASSERT_FALSE(outcome_.errors.empty());
    const CiRun run = ciRun({"cook", scene_ / "out", scene_.sceneFile(), {}, outcome_.report, outcome_.errors, &outcome_.findings});
    expectOneFindingAt(run, "file = \"sky.exr\"");
}

TEST_F(CiReport, AMistakeOfTheSceneFileIsAtItsLine) {
    scene_.writeSceneFile("effort = 11");
    outcome_ = cookScene(scene_.options(), state_);
    const CiRun run = ciRun({"cook", scene_ / "out", scene_.sceneFile(), {}, outcome_.report, outcome_.errors, &outcome_.findings});
    EXPECT_THAT(failed(run, kSceneSuite), ElementsAre("request"));
    expectOneFindingAt(run, "effort = 11");
}

TEST_F(CiReport, EscapesNames) {
    Outcome outcome;
    outcome.errors.push_back({formats::ErrorCode::FileUnreadable, "a<b>&\"c\"\x01\xff\xEF\xBF\xBF.exr", "found nothing, expected light"});
    const CiRun run = ciRun({"cook", scene_ / "out", scene_.sceneFile(), {}, outcome.report, outcome.errors});
    EXPECT_THAT(junitReport(run), HasSubstr("a&lt;b&gt;&amp;&quot;c&quot;\\x01\xEF\xBF\xBD\xEF\xBF\xBD.exr"));
    expectJunit(junitReport(run));
    expectSarif(sarifReport(run));
}

TEST(CiRules, HaveABriefAndHelp) {
    for (const CiRuleInfo& rule : allCiRules()) {
        EXPECT_TRUE(rule.brief.ends_with('.')) << rule.name;
        EXPECT_TRUE(rule.help.ends_with('.')) << rule.name;
    }
}

}  // namespace
}  // namespace lightcook::pipeline
