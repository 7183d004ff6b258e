#include "pipeline/cook/cook.h"

#include <gmock/gmock.h>
#include <tbb/task_arena.h>

#include <set>

#include "pipeline/cook/plan.h"
#include "pipeline/cook/verdicts.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/manifest/self_digest.h"
#include "pipeline/report/collection.h"
#include "pipeline/report/exit_codes.h"
#include "pipeline/report/report.h"
#include "pipeline/report/words.h"
#include "tests/pipeline/report_parts.h"
#include "tests/pipeline/small_scene.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using testing::HasSubstr;

/// Every file of a folder but the reports (they hold seconds), by name: what has to be the same bytes.
std::map<std::string, std::string> digestsOf(const std::filesystem::path& folder) {
    std::map<std::string, std::string> digests;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        const std::string name = entry.path().lexically_relative(folder).generic_string();
        if (entry.is_regular_file() && name != kReportName && name != kReportHtmlName) digests[name] = *digestOfFile(entry.path());
    }
    return digests;
}

std::set<std::string> filesIn(const std::filesystem::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) names.insert(entry.path().filename().string());
    return names;
}

void expectCooks(const SmallScene& scene, const CookOptions& options) {
    const Outcome outcome = cook(options);
    for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
    ASSERT_TRUE(outcome.report.is_object());
    EXPECT_TRUE(outcome.report.at("passed").get<bool>());
    for (const char* file : {kManifestName, kReportName, kReportHtmlName, kShaderName})
        EXPECT_TRUE(std::filesystem::exists(scene / "out" / file)) << file;
}

using Parts = SmallScene::Parts;

void expectCooksInFull(const std::string& target, const std::string& layout) {
    SCOPED_TRACE(fmt::format("{} {}", target, layout));
    const SmallScene scene(Parts::LightMap);
    scene.writeSceneFile(fmt::format("target = \"{}\"\nlight_map_layout = \"{}\"", target, layout));
    expectCooks(scene, scene.options());
    const auto manifest = readManifest(scene / "out");
    ASSERT_TRUE(manifest.has_value());
    EXPECT_EQ(manifest->at("assets").size(), 3u);
    for (const FileRecord& file : filesOf(*loadManifest(scene / "out")))
        EXPECT_EQ(digestOfFile(scene / "out" / file.name), file.digest) << file.name;
}

TEST(CookScene, EveryTargetPassesAndIsDescribedInFull) {
    expectCooksInFull("bc", "ratio");
    expectCooksInFull("astc", "halo3");
    expectCooksInFull("float", "raw");
}

TEST(CookSceneSoak, EveryLayoutAndTargetPassesAndIsDescribedInFull) {
    for (const char* target : {"bc", "astc", "float"})
        for (const char* layout : {"ratio", "halo3", "raw"}) expectCooksInFull(target, layout);
}

/// Two lamps and a sky: where band 1 points there is no light.
glm::vec3 twoLamps(const glm::dvec3& direction, const glm::dvec2& place) {
    const auto lamp = [&](const glm::dvec3& towards) { return std::pow(std::max(0.0, glm::dot(direction, glm::normalize(towards))), 40); };
    const double first = 9 * lamp({0.7, 0.1, 0.7}), second = (3 + 4 * place.x) * lamp({-0.8, 0.2, 0.4});
    return glm::vec3(first * glm::dvec3(1, 0.9, 0.7) + second * glm::dvec3(0.6, 0.8, 1) + glm::dvec3(0.05, 0.06, 0.08) * (1 + place.y));
}

TEST(CookSceneSoak, RefinedDominantLightsExplainMoreAndAreHeldAgainstTheBestLight) {
    const SmallScene scene(Parts::LightMap, twoLamps);
    std::map<std::string, double> unexplained;
    for (const std::string fit : {"halo3", "refined", "explained", "refined-ambient"}) {
        SCOPED_TRACE(fit);
        formats::writeContent(scene.sceneFile(),
                              fmt::format("schema = 1\nname = \"small\"\n[output]\nkeep_unused = true\nlight_map_layout = \"raw\"\n"
                                          "[[light_map]]\nname = \"map\"\nfile = \"map.exr\"\ndominant_fit = \"{}\"\n"
                                          "dominant_layout = \"full\"\n",
                                          fit));
        const Outcome outcome = cook(scene.options());
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        const Json& asset = assetOf(outcome.report, "map_dominant");
        const Json& notes = asset.at("notes");
        EXPECT_EQ(notes.at("fit"), fit);
        EXPECT_EQ(notes.contains("refined"), fit != "halo3");
        if (fit != "halo3") {
            EXPECT_GT(notes.at("refined").get<int>(), 100);
            EXPECT_GE(notes.at("skipped").get<int>(), 0);
        }
        unexplained[fit] = asset.at("measures").at("unexplained_energy_stored").get<double>();
        EXPECT_NEAR(unexplained[fit], asset.at("measures").at("unexplained_energy_reference").get<double>(), 5e-3);
        const auto manifest = readManifest(scene / "out");
        ASSERT_TRUE(manifest.has_value());
        EXPECT_EQ(assetOf(*manifest, "map_dominant").at("fit"), fit);
    }
    EXPECT_LT(unexplained["refined"], 0.9 * unexplained["halo3"]);
    EXPECT_LT(unexplained["refined-ambient"], unexplained["refined"]);
}

TEST(CookScene, TheReportHoldsWhatTheProductPromises) {
    const SmallScene scene(Parts::All);
    const Outcome outcome = cook(scene.optionsWithOwnCache());
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    const Json& report = outcome.report;
    for (const char* key : {"scene", "tool", "passed", "seconds", "peak_rss_bytes", "assets", "skipped", "budget"})
        EXPECT_TRUE(report.contains(key)) << key;
    std::uint64_t sum = 0;
    for (const Json& asset : report.at("assets")) {
        for (const char* key : {"name", "kind", "width", "height", "bytes_in", "bytes_gpu", "bytes_disk", "bits_per_texel", "layout",
                                "seconds", "stages", "limit", "passed"})
            EXPECT_TRUE(asset.contains(key)) << key;
        sum += asset.at("bytes_gpu").get<std::uint64_t>();
        ASSERT_FALSE(asset.at("stages").empty());
        for (const Json& stage : asset.at("stages"))
            for (const char* kind : {"diffuse", "specular"})
                for (const char* figure : {"rel_rms", "p99", "max_sampled", "max_bound"})
                    EXPECT_TRUE(stage.at("error").at(kind).at(figure).is_number()) << asset.at("name") << figure;
        const Json& error = asset.at("stages").back().at("error");
        for (const char* kind : {"diffuse", "specular"})
            EXPECT_LE(error.at(kind).at("max_sampled").get<double>(), error.at(kind).at("max_bound").get<double>()) << asset.at("name");
    }
    EXPECT_EQ(report.at("budget").at("used_bytes").get<std::uint64_t>(), sum);
    EXPECT_GT(report.at("peak_rss_bytes").get<std::uint64_t>(), 1u << 20);
    EXPECT_EQ(*readReport(scene / "out" / kReportName), report);
}

/// Errors are then those of texel centres, and so is the light that they are a part of.
TEST(CookScene, WithoutPlacesOnTheSurfaceTheWholeShadingHasTheErrorOfTheTexels) {
    const SmallScene scene(SmallScene::Parts::LightMap);
    scene.writeSceneFile("light_map_layout = \"ratio\"");
    CookOptions options = scene.options();
    options.samples = 0;
    const Outcome outcome = cook(options);
    ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
    EXPECT_GT(outcome.report.at("whole").at("lights").at("diffuse").get<double>(), 0.05);
    EXPECT_GT(outcome.report.at("whole").at("rel_rms").get<double>(), 0);
}

TEST(CookScene, OneThreadAndThreeGiveTheSameBytes) {
    const SmallScene scene(Parts::All);
    CookOptions options = scene.optionsWithOwnCache();
    std::vector<std::map<std::string, std::string>> digests;
    for (const int threads : {1, 3}) {
        options.output = scene / fmt::format("out{}", threads);
        options.force = true;
        tbb::task_arena arena(threads);
        const Outcome outcome = arena.execute([&] { return cook(options); });
        ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
        digests.push_back(digestsOf(options.output));
    }
    EXPECT_GT(digests[0].size(), 8u);
    EXPECT_EQ(digests[0], digests[1]);
}

TEST(CookScene, NothingChangedMeansNothingDoneAndNoFileTouched) {
    const SmallScene scene(Parts::LightMap);
    ASSERT_TRUE(cook(scene.optionsWithOwnCache()).errors.empty());
    std::map<std::filesystem::path, std::filesystem::file_time_type> times;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(scene / "out")) times[entry.path()] = entry.last_write_time();
    const Outcome again = cook(scene.optionsWithOwnCache());
    ASSERT_TRUE(again.errors.empty());
    EXPECT_EQ(again.actionsRun, 0);
    EXPECT_GT(again.actionsReused, 0);
    for (const auto& [path, time] : times) EXPECT_EQ(std::filesystem::last_write_time(path), time) << path;
}

TEST(CookScene, OnlyWhatChangedIsDoneAgain) {
    const SmallScene scene(Parts::LightMap);
    const Outcome first = cook(scene.optionsWithOwnCache());
    scene.writeSceneFile("light_map_layout = \"ratio\"", "[[material]]\nname = \"*\"\nm = [0.1, 0.5]\n");  // the tables' range as before
    EXPECT_EQ(cook(scene.optionsWithOwnCache()).actionsRun, 0);
    scene.writeSceneFile("light_map_layout = \"hdr-2\"");
    const Outcome hdr2 = cook(scene.optionsWithOwnCache());
    EXPECT_EQ(hdr2.actionsRun, 2) << "the light map and its verification";
    EXPECT_FALSE(std::filesystem::exists(scene / "out" / "map_l0.ktx2")) << "what the manifest no longer names is gone";
    scene.writeSceneFile("light_map_layout = \"ratio\"");
    EXPECT_EQ(cook(scene.optionsWithOwnCache()).actionsRun, 0) << "the cache still knows the first layout";
    EXPECT_TRUE(std::filesystem::exists(scene / "out" / "map_l0.ktx2"));
    CookOptions forced = scene.optionsWithOwnCache();
    forced.force = true;
    EXPECT_EQ(cook(forced).actionsRun, first.actionsRun);
}

TEST(CookScene, PicturesOfAssetsThatAreGoneAreRemoved) {
    const SmallScene scene(Parts::All);
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    const std::filesystem::path pictures = scene / "out" / "preview";
    ASSERT_TRUE(std::filesystem::exists(pictures / "sky_cooked.png"));
    formats::writeContent(pictures / "notes.png", "the user's own");
    std::string text = formats::contentOf(scene.sceneFile());
    text.replace(text.find("\"sky\""), 5, "\"dusk\"");
    formats::writeContent(scene.sceneFile(), text);
    const Outcome outcome = cook(scene.options());
    ASSERT_TRUE(outcome.errors.empty());
    std::set<std::string> expected = {"preview/notes.png"}, found;
    for (const Json& file : outcome.report.at("files"))
        if (const std::string name = file.at("file"); name.starts_with("preview/")) expected.insert(name);
    for (const auto& entry : std::filesystem::directory_iterator(pictures)) found.insert("preview/" + entry.path().filename().string());
    EXPECT_TRUE(expected.contains("preview/dusk_cooked.png"));
    EXPECT_EQ(found, expected);
}

/// Someone may have edited the report. Nothing outside the folder of pictures is removed for it.
TEST(CookScene, NothingButPicturesIsRemovedForAnOldReport) {
    const SmallScene scene(Parts::All);
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    formats::writeContent(scene / "out" / "notes.png", "the user's own");
    Json report = parseJson(formats::contentOf(scene / "out" / kReportName));
    for (Json& asset : report.at("assets")) asset.at("preview").at("cooked") = "notes.png";
    formats::writeContent(scene / "out" / kReportName, withSelfDigest(report));
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    EXPECT_TRUE(std::filesystem::exists(scene / "out" / "notes.png"));
}

TEST(CookScene, PicturesBehindALinkStay) {
    const SmallScene scene(Parts::All);
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    std::filesystem::rename(scene / "out" / "preview", scene / "elsewhere");
    std::filesystem::create_directory_symlink("../elsewhere", scene / "out" / "preview");
    const auto before = filesIn(scene / "elsewhere");
    // Without the gradient its pictures belong to no asset.
    std::string text = formats::contentOf(scene.sceneFile());
    const std::size_t begin = text.find("[[gradient]]");
    formats::writeContent(scene.sceneFile(), text.erase(begin, text.find("\n\n", begin) - begin));
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    EXPECT_EQ(filesIn(scene / "elsewhere"), before);
}

TEST(CookScene, ALostOrDamagedOutputIsRestored) {
    const SmallScene scene(Parts::All);
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    const auto before = digestsOf(scene / "out");
    std::filesystem::remove(scene / "out" / "probe.ktx2");
    formats::writeContent(scene / "out" / "sky.ktx2", "damaged");
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    EXPECT_EQ(digestsOf(scene / "out"), before);
}

TEST(CookScene, OnlyLeavesTheOtherAssetsAsTheyWere) {
    const SmallScene scene(Parts::All);
    CookOptions options = scene.options();
    ASSERT_TRUE(cook(options).errors.empty());
    options.only = "sky";
    options.force = true;
    const Outcome outcome = cook(options);
    ASSERT_TRUE(outcome.errors.empty());
    EXPECT_EQ(outcome.actionsRun, 2);
    EXPECT_EQ(readManifest(scene / "out")->at("assets").size(), 5u);
    EXPECT_EQ(outcome.report.at("assets").size(), 5u);
}

TEST(CookScene, AsksBeforeItPublishesFilesThatTheCommandWouldReplace) {
    const SmallScene scene(Parts::LightMap);
    RunState state;
    std::vector<std::filesystem::path> asked;
    state.checkOutputs = [&](const std::vector<std::filesystem::path>& files) -> formats::Result<void> {
        asked = files;
        return formats::failure(ErrorCode::InvalidRequest, "--json", "found the same file");
    };
    const Outcome outcome = cookScene(scene.options(), state);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].line(), "--json: found the same file");
    EXPECT_THAT(asked, testing::Contains(scene / "out" / "map_ratio.ktx2"));
    EXPECT_FALSE(std::filesystem::exists(scene / "out"));
}

TEST(CookScene, OnlyNamesWhatTheFolderLacksOfTheScene) {
    const SmallScene scene(Parts::All);
    CookOptions options = scene.options();
    options.only = "sky";
    const Outcome outcome = cook(options);
    ASSERT_TRUE(outcome.errors.empty());
    EXPECT_EQ(outcome.report.at("passed"), true);
    const Json others = Json::array({"map", "map_dominant", "probe", "specular"});
    EXPECT_EQ(outcome.report.at("partial"), others);
    EXPECT_EQ(readManifest(scene / "out")->at("partial"), others);
    const auto folder = readCookedFolder(scene / "out");
    ASSERT_TRUE(folder) << folder.error().line();
    EXPECT_TRUE(folder->errors.empty());
    EXPECT_EQ(summaryOf(*folder).partial, folder->report.partial);
    const Outcome verified = verifyCooked({scene / "out", {}, {}}, RunState());
    EXPECT_TRUE(verified.errors.empty());
    EXPECT_EQ(verified.report.at("partial"), others);
    // Each cook of another asset shortens the list.
    options.only = "map";
    const Json report = cook(options).report, manifest = *readManifest(scene / "out");
    EXPECT_EQ(report.at("partial"), Json::array({"probe", "specular"}));
    for (const Json* file : {&report, &manifest}) {
        std::vector<std::string> names;
        for (const Json& asset : file->at("assets")) names.push_back(asset.at("name"));
        EXPECT_EQ(names, (std::vector<std::string>{"map", "map_dominant", "sky"})) << "in the order of the scene, not of the cooks";
    }
    options.only = {};
    const Outcome whole = cook(options);
    EXPECT_TRUE(whole.errors.empty());
    EXPECT_FALSE(whole.report.contains("partial"));
    EXPECT_FALSE(readManifest(scene / "out")->contains("partial"));
}

TEST(CookScene, OnlyDoesNotMissWhatTheSceneDoesNotNeed) {
    const SmallScene scene(Parts::All);
    scene.writeSceneFile("", "[[material]]\nname = \"*\"\nspecular = false\n");
    CookOptions options = scene.options();
    options.only = "map";
    EXPECT_EQ(cook(options).report.at("partial"), Json::array({"sky"})) << "nothing reflects: no dominant light, probe or tables";
}

/// Returns the skips of assets in a report; those of actions, whose results were reused, are left out.
std::set<std::string> assetSkipsOf(const Json& report) {
    std::set<std::string> skips;
    for (const Json& skip : report.at("skipped"))
        if (const auto what = skip.at("what").get<std::string>(); what.find('/') == std::string::npos)
            skips.insert(what + ": " + skip.at("why").get<std::string>());
    return skips;
}

TEST(CookScene, OnlyKeepsFindingsAndSkipsOfTheOtherAssets) {
    // The map is grey, and gets no dominant light for it; the probe, at the middle, is clipped.
    const SmallScene scene(Parts::All, [](const glm::dvec3& direction, const glm::dvec2& place) {
        return place == glm::dvec2(0.5) ? glm::vec3(direction.z > 0 ? 1.0f : 0.3f) : glm::vec3(0.5f);
    });
    CookOptions options = scene.options();
    const Outcome whole = cook(options);
    ASSERT_TRUE(whole.errors.empty()) << whole.errors.front().line();
    const auto isDominant = [](const Json& asset) { return asset.at("name") == "map_dominant"; };
    ASSERT_TRUE(std::ranges::none_of(whole.report.at("assets"), isDominant));
    ASSERT_FALSE(whole.report.at("findings").empty());
    EXPECT_THAT(assetSkipsOf(whole.report), testing::Contains(testing::StartsWith("dominant light of 'map': ")));
    for (const char* only : {"sky", "probe", "sky"}) {
        options.only = only;
        const Outcome outcome = cook(options);
        ASSERT_TRUE(outcome.errors.empty()) << outcome.errors.front().line();
        EXPECT_FALSE(outcome.report.contains("partial")) << only;
        EXPECT_FALSE(readManifest(scene / "out")->contains("partial")) << only;
        EXPECT_EQ(outcome.report.at("findings"), whole.report.at("findings")) << only;
        EXPECT_EQ(assetSkipsOf(outcome.report), assetSkipsOf(whole.report)) << only;
        EXPECT_EQ(outcome.report.at("assets").size(), whole.report.at("assets").size()) << only;
    }
}

TEST(CookScene, OnlyRefusesAssetsThatAnotherTargetLeft) {
    const SmallScene scene(Parts::All);
    CookOptions options = scene.options();
    ASSERT_TRUE(cook(options).errors.empty());
    const auto before = digestsOf(scene / "out");
    options.only = "sky";
    options.given.set("output.target", "astc");
    const Outcome outcome = cook(options);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, ErrorCode::InvalidRequest);
    EXPECT_THAT(outcome.errors[0].line(), testing::MatchesRegex("--only: found '.*' of an earlier cook with target = \"bc\", expected "
                                                                "\"astc\" of this one: cook the whole scene, without --only"));
    EXPECT_EQ(digestsOf(scene / "out"), before);
}

/// Gives the scene another name.
void renameScene(const SmallScene& scene) {
    std::string text = formats::contentOf(scene.sceneFile());
    formats::writeContent(scene.sceneFile(), text.replace(text.find("\"small\""), 7, "\"large\""));
}

TEST(CookScene, WarnsWhereItReplacesAnotherScene) {
    const SmallScene scene(Parts::LightMap);
    std::vector<std::string> warnings;
    RunState state;
    state.warning = [&](const std::string& subject, const std::string& detail) { warnings.push_back(subject + ": " + detail); };
    ASSERT_TRUE(cookScene(scene.options(), state).errors.empty());
    EXPECT_THAT(warnings, testing::IsEmpty());
    renameScene(scene);
    for ([[maybe_unused]] const int run : {1, 2}) {  // the second one finds its own
        ASSERT_TRUE(cookScene(scene.options(), state).errors.empty());
        EXPECT_THAT(warnings, testing::ElementsAre(HasSubstr("found the cooked scene 'small', expected 'large' or none")));
    }
}

TEST(CookScene, WarnsWhereItReplacesTheSceneOfAnotherFileOfTheSameName) {
    const SmallScene scene(Parts::LightMap);
    std::vector<std::string> warnings;
    RunState state;
    state.warning = [&](const std::string&, const std::string& detail) { warnings.push_back(detail); };
    ASSERT_TRUE(cookScene(scene.options(), state).errors.empty());
    CookOptions other = scene.options();
    other.scene = scene / "other.toml";
    std::filesystem::copy_file(scene.sceneFile(), other.scene);
    ASSERT_TRUE(cookScene(other, state).errors.empty());
    EXPECT_THAT(warnings, testing::ElementsAre(HasSubstr("found the cooked scene 'small' of " + scene.sceneFile().string() +
                                                         ", expected that of " + other.scene.string() + " or none")));
    // A scene file that is gone was renamed.
    std::filesystem::rename(other.scene, scene / "renamed.toml");
    other.scene = scene / "renamed.toml";
    ASSERT_TRUE(cookScene(other, state).errors.empty());
    EXPECT_EQ(warnings.size(), 1u);
}

TEST(CookScene, OnlyRefusesAssetsOfAnotherScene) {
    const SmallScene scene(Parts::LightMap);
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    const std::string manifest = formats::contentOf(scene / "out" / kManifestName);
    renameScene(scene);
    CookOptions options = scene.options();
    options.only = "map";
    const Outcome outcome = cook(options);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, ErrorCode::InvalidRequest);
    EXPECT_THAT(outcome.errors[0].line(), HasSubstr("--only: found 'specular' of the scene 'small'"));
    EXPECT_EQ(formats::contentOf(scene / "out" / kManifestName), manifest);
    options.only = "specular";
    options.output = scene / "part";
    ASSERT_TRUE(cook(options).errors.empty());
    EXPECT_TRUE(cook(options).errors.empty());
}

TEST(CookScene, AFailureLeavesNothingBehind) {
    const SmallScene scene(Parts::All);
    std::filesystem::remove(scene / "probe.exr");
    const auto before = filesIn(scene / "");
    const Outcome outcome = cook(scene.optionsWithOwnCache());
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_EQ(outcome.errors.front().code, ErrorCode::FileUnreadable);
    EXPECT_THAT(outcome.errors.front().line(), HasSubstr("probe.exr"));
    auto after = filesIn(scene / "");
    after.erase("cache");
    EXPECT_EQ(after, before);
}

/// A full disk may end a cook while it writes. A folder in place of the shader stands for it.
TEST(CookScene, FilesOfTheManifestThatStaysAreNotRemoved) {
    const SmallScene scene(Parts::LightMap);
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    const std::string manifest = formats::contentOf(scene / "out" / kManifestName);
    std::filesystem::remove(scene / "out" / kShaderName);
    std::filesystem::create_directories(scene / "out" / kShaderName / "in the way");
    CookOptions other = scene.options();
    other.given.set("output.light_map_layout", "hdr-2");
    EXPECT_FALSE(cook(other).errors.empty());
    EXPECT_EQ(formats::contentOf(scene / "out" / kManifestName), manifest);
    for (const char* file : {"map_l0.ktx2", "map_ratio.ktx2"}) EXPECT_TRUE(std::filesystem::exists(scene / "out" / file)) << file;

    std::filesystem::remove_all(scene / "out" / kShaderName);
    ASSERT_TRUE(cook(other).errors.empty());
    EXPECT_FALSE(std::filesystem::exists(scene / "out" / "map_ratio.ktx2"));
}

/// A folder in place of the page stands for a disk that is full once the textures are there.
TEST(CookScene, OutputsAppearTogetherWithTheirReportOrNotAtAll) {
    const SmallScene scene(Parts::LightMap);
    CookOptions first = scene.options();
    first.output = scene / "new";
    std::filesystem::create_directories(first.output / kReportHtmlName / "in the way");
    EXPECT_FALSE(cook(first).errors.empty());
    EXPECT_EQ(filesIn(first.output), std::set<std::string>{kReportHtmlName});

    ASSERT_TRUE(cook(scene.options()).errors.empty());
    std::filesystem::remove(scene / "out" / kReportHtmlName);
    const auto before = digestsOf(scene / "out");
    std::filesystem::create_directories(scene / "out" / kReportHtmlName / "in the way");
    CookOptions other = scene.options();
    other.given.set("output.light_map_layout", "hdr-2");
    EXPECT_FALSE(cook(other).errors.empty());
    EXPECT_EQ(digestsOf(scene / "out"), before);
}

TEST(CookScene, KeepGoingDoesTheRest) {
    const SmallScene scene(Parts::All);
    std::filesystem::remove(scene / "probe.exr");
    CookOptions options = scene.options();
    options.keepGoing = true;
    const Outcome outcome = cook(options);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors.front().code, ErrorCode::FileUnreadable);
    EXPECT_EQ(readManifest(scene / "out")->at("assets").size(), 4u);
}

TEST(CookScene, WhatKeepGoingLeftOutFailsItsReportAndVerification) {
    const SmallScene scene(Parts::All);
    std::filesystem::rename(scene / "probe.exr", scene / "probe");
    CookOptions options = scene.options();
    options.keepGoing = true;
    const Outcome outcome = cook(options);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.report.at("passed"), false);
    const Json& incomplete = outcome.report.at("incomplete");
    EXPECT_EQ(incomplete.at("assets"), Json::array({"probe"}));
    ASSERT_EQ(incomplete.at("errors").size(), 1u);
    EXPECT_EQ(incomplete.at("errors")[0].at("exit_code"), 3);
    EXPECT_THAT(formats::contentOf(scene / "out" / kReportHtmlName), HasSubstr("<li>probe: not cooked</li>"));
    const auto folder = readCookedFolder(scene / "out");
    ASSERT_TRUE(folder) << folder.error().line();
    ASSERT_EQ(folder->errors.size(), 1u);
    EXPECT_EQ(exitCode(folder->errors[0].code), 3);
    EXPECT_EQ(folder->errors[0].line(), outcome.errors[0].line());
    const Outcome verified = verifyCooked({scene / "out", {}, {}}, RunState());
    ASSERT_EQ(verified.errors.size(), 1u);
    EXPECT_EQ(verified.errors[0].line(), outcome.errors[0].line());
    EXPECT_EQ(verified.report.at("passed"), false);
    // The manifest says it too, to a folder whose report is gone.
    const formats::TemporaryFolder kept;
    std::filesystem::rename(scene / "out" / kReportName, kept / kReportName);
    const Outcome unreported = verifyCooked({scene / "out", {}, {}}, RunState());
    ASSERT_EQ(unreported.errors.size(), 1u);
    EXPECT_EQ(unreported.errors[0].code, ErrorCode::Verification);
    EXPECT_EQ(unreported.errors[0].line(),
              (scene / "out" / kManifestName).string() +
                  ": found a cook that went on after an error, without 'probe', expected all assets of the scene: cook it again");
    std::filesystem::rename(kept / kReportName, scene / "out" / kReportName);
    // A cook of another asset does not make the folder complete; one of the missing asset does.
    std::filesystem::rename(scene / "probe", scene / "probe.exr");
    options.only = "sky";
    EXPECT_EQ(cook(options).report.at("passed"), false);
    options.only = "probe";
    const Outcome complete = cook(options);
    EXPECT_TRUE(complete.errors.empty());
    EXPECT_EQ(complete.report.at("passed"), true);
    EXPECT_FALSE(complete.report.contains("incomplete"));
}

TEST(CookScene, WithoutAnythingToCookIsRefused) {
    const SmallScene scene(Parts::LightMap);
    formats::writeContent(scene.sceneFile(), "schema = 1\nname = \"small\"\n[tables]\nviews = 8\n");
    const Outcome outcome = cook(scene.optionsWithOwnCache());
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, ErrorCode::InvalidRequest);
    EXPECT_THAT(outcome.errors[0].line(),
                HasSubstr("scene.toml: found nothing to cook, expected at least one table [[light_map]], [[probe]]"));
    EXPECT_FALSE(std::filesystem::exists(scene / "out"));
    const Outcome linted = lintScene({scene.sceneFile(), scene / "cache", false, false}, RunState());
    ASSERT_EQ(linted.errors.size(), 1u);
    EXPECT_EQ(linted.errors[0].code, ErrorCode::InvalidRequest);
    // Nothing is specular: the tables are skipped, and the scene has passed.
    formats::writeContent(scene.sceneFile(), "schema = 1\nname = \"small\"\n[[material]]\nname = \"*\"\nspecular = false\n");
    const Outcome skipped = cook(scene.optionsWithOwnCache());
    EXPECT_TRUE(skipped.errors.empty());
    EXPECT_TRUE(skipped.report.at("assets").empty());
}

/// Windows and macOS would hold the files of both for one.
TEST(CookScene, RefusesFilesThatDifferInCaseAlone) {
    const SmallScene scene(Parts::All);
    std::string text = formats::contentOf(scene.sceneFile());
    text.replace(text.find("\"probe\""), 7, "\"Map_Dominant\"");
    formats::writeContent(scene.sceneFile(), text);
    const Outcome outcome = cook(scene.optionsWithOwnCache());
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, ErrorCode::InvalidRequest);
    EXPECT_THAT(outcome.errors[0].line(), HasSubstr("found two assets that would both write 'Map_Dominant"));
}

TEST(CookScene, RefusesDdsForAstcBeforeItWorks) {
    const SmallScene scene(Parts::LightMap);
    CookOptions options = scene.optionsWithOwnCache();
    options.given.set("output.target", "astc");
    options.given.set("output.container", "dds");
    const Outcome outcome = cook(options);
    ASSERT_EQ(outcome.errors.size(), 1u);
    EXPECT_EQ(outcome.errors[0].code, ErrorCode::InvalidRequest);
    EXPECT_EQ(outcome.errors[0].line(),
              "--container: found container dds with target astc, expected container ktx2: DDS has no ASTC formats");
    EXPECT_EQ(outcome.actionsRun, 0);
}

TEST(CookScene, RefusesALimitOnPackedChartsWhereNoneArePacked) {
    const SmallScene scene(Parts::LightMap);
    CookOptions options = scene.optionsWithOwnCache();
    options.given.set("output.charts_max_visible", 1);
    for (const bool areKept : {false, true}) {
        if (areKept) options.given.set("output.charts", "keep");
        const Outcome outcome = cook(options);
        ASSERT_EQ(outcome.errors.size(), 1u);
        EXPECT_EQ(outcome.errors[0].code, ErrorCode::InvalidRequest);
        EXPECT_EQ(outcome.errors[0].line(),
                  "--charts-max-visible: found charts_max_visible where no charts are packed, expected charts = \"pack\"");
        EXPECT_EQ(outcome.actionsRun, 0);
    }
    options.given.set("output.charts", "pack");
    EXPECT_THAT(cook(options).errors.front().line(), HasSubstr("--charts: found charts of 'map' to pack without a mesh"));
}

TEST(ReadCookedFolder, RefusesAFolderWithoutAManifestThatCanBeRead) {
    const SmallScene scene(Parts::LightMap);
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    const std::filesystem::path out = scene / "out", manifest = out / kManifestName;
    const std::string whole = formats::contentOf(manifest);
    ASSERT_TRUE(readCookedFolder(out));
    EXPECT_TRUE(readCookedFolder(out)->errors.empty());
    Json other = parseJson(whole), wrong = other;
    other["schema"] = 2;
    wrong["target"] = 3;
    for (const std::string& text : {std::string(), whole.substr(0, whole.size() / 2), std::string("{}"), other.dump(), wrong.dump()}) {
        SCOPED_TRACE(text.substr(0, 40));
        formats::writeContent(manifest, text);
        const auto folder = readCookedFolder(out);
        ASSERT_FALSE(folder);
        EXPECT_EQ(exitCode(folder.error().code), 3);
        EXPECT_EQ(folder.error().line(), verifyCooked({out, {}, {}}, RunState()).errors.at(0).line()) << "as verify has it";
    }
    std::filesystem::remove(manifest);
    EXPECT_FALSE(readCookedFolder(out)) << "no file";
    std::filesystem::create_directory(manifest);
    EXPECT_FALSE(readCookedFolder(out)) << "a folder in its place";
}

TEST(ReadCookedFolder, AFileThatIsGoneOrShorterFailsByName) {
    for (const char* name : {"map_l0.ktx2", "lightcook.glsl"})
        for (const bool isGone : {true, false}) {
            const SmallScene scene(Parts::LightMap);
            ASSERT_TRUE(cook(scene.options()).errors.empty());
            if (isGone) std::filesystem::remove(scene / "out" / name);
            if (!isGone) std::filesystem::resize_file(scene / "out" / name, 10);
            const auto folder = readCookedFolder(scene / "out");
            ASSERT_TRUE(folder);
            ASSERT_EQ(folder->errors.size(), 1u);
            EXPECT_EQ(folder->errors[0].code, ErrorCode::Verification) << "as verify has it";
            EXPECT_THAT(folder->errors[0].line(), HasSubstr(name));
            EXPECT_EQ(folder->json.at("passed"), false);
        }
}

TEST(CookScene, ABoundThatIsNotHeldFailsButIsReported) {
    const SmallScene scene(Parts::LightMap);
    CookOptions options = scene.options();
    options.given.set("output.max_error", 1e-7);
    const Outcome outcome = cook(options);
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_EQ(outcome.errors.front().code, ErrorCode::OverLimit);
    EXPECT_FALSE(outcome.report.at("passed").get<bool>());
    EXPECT_TRUE(std::filesystem::exists(scene / "out" / kReportName));
}

/// A scene under budgets, and the views of its tables.
class TablesUnderABudget : public testing::Test {
protected:
    static Outcome cookWithin(const SmallScene& scene, std::uint64_t budget) {
        CookOptions options = scene.options();
        options.given.set("output.budget", budget);
        return cook(options);
    }
    static int views(const Outcome& outcome) { return assetOf(outcome.report, kTablesName).at("width").get<int>(); }
    static std::uint64_t used(const Outcome& outcome) { return outcome.report.at("budget").at("used_bytes").get<std::uint64_t>(); }
    /// Returns the bytes that the fine tables take more than the usual ones of a cook.
    static std::uint64_t moreBytes(const Outcome& outcome) {
        return assetOf(outcome.report, kTablesName).at("bytes_gpu").get<std::uint64_t>() / kLeastViewCount *
               (kFineViewCount - kLeastViewCount);
    }
    static const Json& frontierOf(const Outcome& outcome) { return outcome.report.at("budget").at("frontier"); }
    static std::uint64_t bytesOf(const Json& point) { return point.at("bytes_gpu").get<std::uint64_t>(); }
    static double visible(const Outcome& outcome) {
        for (const Json& point : frontierOf(outcome))
            if (point.at("chosen").get<bool>()) return point.at("visible").get<double>();
        throw std::runtime_error("no allocation is marked as chosen");
    }
    static void expectOverBudget(const Outcome& outcome) {
        ASSERT_EQ(outcome.errors.size(), 1u);
        EXPECT_EQ(outcome.errors[0].code, ErrorCode::OverBudget);
        EXPECT_THAT(outcome.errors[0].line(), HasSubstr(fmt::format("found {} of GPU memory", sizeWords(used(outcome)))));
        EXPECT_EQ(views(outcome), kLeastViewCount) << "the least bytes that are possible";
    }
};

TEST_F(TablesUnderABudget, TakeNoBytesFromBetterLayouts) {
    const SmallScene scene(Parts::LightMap);
    scene.writeSceneFile("");
    const Outcome smallest = cookWithin(scene, 100);
    expectOverBudget(smallest);
    const Json frontier = frontierOf(smallest);
    const std::uint64_t least = used(smallest), more = moreBytes(smallest);
    ASSERT_GT(frontier.size(), 2u);
    ASSERT_EQ(bytesOf(frontier[0]), least);
    ASSERT_LT(bytesOf(frontier[1]), least + more) << "a better layout costs less than the views";
    expectOverBudget(cookWithin(scene, least - 1));
    // With one byte more the smallest layouts would have room for more views: the error does not grow.
    double before = HUGE_VAL;
    for (const std::uint64_t budget : {least, least + more - 1, least + more}) {
        const Outcome within = cookWithin(scene, budget);
        for (const formats::Error& error : within.errors) ADD_FAILURE() << error.line();
        EXPECT_LE(used(within), budget);
        EXPECT_LE(visible(within), before);
        before = visible(within);
    }
    EXPECT_LE(before, frontier[1].at("visible").get<double>());
    // Every layout is at its best: the tables get the rest of the budget.
    const std::uint64_t most = bytesOf(frontier.back()) + more;
    const Outcome almost = cookWithin(scene, most - 1), roomy = cookWithin(scene, most);
    EXPECT_EQ(views(almost), kLeastViewCount);
    EXPECT_EQ(views(roomy), kFineViewCount);
    EXPECT_EQ(visible(roomy), visible(almost));
    EXPECT_EQ(used(roomy), most);
    EXPECT_EQ(bytesOf(frontierOf(roomy).back()), most) << "the frontier counts the tables of the cook";
    EXPECT_EQ(cookWithin(scene, most).actionsRun, 0);
}

TEST_F(TablesUnderABudget, HaveTheViewsThatFitWhereNoLayoutIsOpen) {
    const SmallScene scene(Parts::LightMap, grey);  // one block
    const Outcome smallest = cookWithin(scene, 100);
    expectOverBudget(smallest);
    EXPECT_FALSE(smallest.report.at("budget").contains("frontier"));
    const std::uint64_t least = used(smallest), most = least + moreBytes(smallest);
    for (const std::uint64_t budget : {least, most - 1, most}) {
        const Outcome within = cookWithin(scene, budget);
        for (const formats::Error& error : within.errors) ADD_FAILURE() << error.line();
        EXPECT_EQ(views(within), budget < most ? kLeastViewCount : kFineViewCount);
        EXPECT_EQ(used(within), budget < most ? least : most);
    }
    CookOptions alone = scene.options();
    alone.given.set("output.budget", 1 << 20);
    alone.only = kTablesName;
    EXPECT_EQ(views(cook(alone)), kFineViewCount);
}

TEST_F(TablesUnderABudget, HaveMoreViewsWhereALimitOfTheirsAsksForThem) {
    const SmallScene scene(Parts::LightMap);
    scene.writeSceneFile("");
    const Outcome smallest = cookWithin(scene, 100);
    const auto errorOfTables = [](const Outcome& outcome) {
        return assetOf(outcome.report, kTablesName).at("stages").back().at("error").at("specular").at("visible").at("p99").get<double>();
    };
    const double usual = errorOfTables(smallest), fine = errorOfTables(cookWithin(scene, 1 << 20));
    ASSERT_LT(fine, usual);
    scene.writeSceneFile("", fmt::format("[tables]\nmax_visible = {}\n", (usual + fine) / 2));
    const Outcome limited = cookWithin(scene, used(smallest) + moreBytes(smallest));
    for (const formats::Error& error : limited.errors) ADD_FAILURE() << error.line();
    EXPECT_EQ(views(limited), kFineViewCount);
    EXPECT_EQ(visible(limited), visible(smallest)) << "the smallest layouts are left";
    const Outcome within = cookWithin(scene, used(smallest));
    ASSERT_EQ(within.errors.size(), 1u);
    EXPECT_EQ(within.errors[0].code, ErrorCode::OverLimit) << "within the budget, but not within the limit";
}

TEST(CookScene, AnExceededBudgetFailsButIsReported) {
    const SmallScene scene(Parts::LightMap);
    CookOptions options = scene.options();
    options.given.set("output.budget", 100);
    const Outcome outcome = cook(options);
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_EQ(outcome.errors.front().code, ErrorCode::OverBudget);
    EXPECT_EQ(outcome.report.at("budget").at("limit_bytes"), 100);
    EXPECT_THAT(outcome.errors.front().line(), testing::StartsWith("--budget: found "));
    // The manifest has the budget: verification holds the folder to it, with and without the report.
    for (int i = 0; i < 2; ++i) {
        const Outcome verified = verifyCooked({scene / "out", {}, {}}, RunState());
        ASSERT_EQ(verified.errors.size(), 1u);
        EXPECT_EQ(verified.errors[0].code, ErrorCode::OverBudget);
        EXPECT_THAT(verified.errors[0].line(), HasSubstr("cooked.json, budget: found "));
        EXPECT_EQ(verified.report.at("passed"), false);
        std::filesystem::remove(scene / "out" / kReportName);
    }
    scene.writeSceneFile("budget = \"100\"");
    EXPECT_THAT(cook(scene.options()).errors.front().line(), HasSubstr("scene.toml:5, budget: found "));
}

TEST(CookScene, AnInterruptIsReportedAndLeavesNoOutput) {
    const SmallScene scene(Parts::LightMap);
    RunState state;
    state.interrupted = true;
    const Outcome outcome = cookScene(scene.optionsWithOwnCache(), state);
    ASSERT_FALSE(outcome.errors.empty());
    EXPECT_EQ(outcome.errors.front().code, ErrorCode::Interrupted);
    EXPECT_FALSE(std::filesystem::exists(scene / "out"));
}

TEST(CookScene, TheDepfileNamesEveryInput) {
    const SmallScene scene(Parts::All);
    CookOptions options = scene.options();
    options.depfile = scene / "out.d";
    ASSERT_TRUE(cook(options).errors.empty());
    const std::string depfile = *readFile(*options.depfile);
    EXPECT_THAT(depfile, testing::StartsWith((scene / "out" / kManifestName).string() + ": "));
    for (const char* input : {"scene.toml", "map.exr", "probe.exr", "sky.exr"}) EXPECT_THAT(depfile, HasSubstr((scene / input).string()));
}

TEST(CookScene, DdsAndZstdAreWrittenAndVerified) {
    const SmallScene scene(Parts::LightMap);
    CookOptions options = scene.options();
    options.given.set("output.container", "dds");
    expectCooks(scene, options);
    EXPECT_TRUE(std::filesystem::exists(scene / "out" / "map_l0.dds"));
    options.given.set("output.container", "ktx2");
    options.given.set("output.zstd", true);
    expectCooks(scene, options);
    EXPECT_FALSE(std::filesystem::exists(scene / "out" / "map_l0.dds"));
}

TEST(VerifyCooked, AgreesWithTheCookAndNamesADamagedByte) {
    const SmallScene scene(Parts::All);
    const Outcome cooked = cook(scene.options());
    ASSERT_TRUE(cooked.errors.empty());
    const RunState state;
    const VerifyOptions options{scene / "out", {}, {}};
    const Outcome verified = verifyCooked(options, state);
    ASSERT_TRUE(verified.errors.empty()) << verified.errors.front().line();
    for (std::size_t i = 0; i < cooked.report.at("assets").size(); ++i) {
        const Json& a = cooked.report.at("assets")[i].at("stages").back().at("error");
        const Json& b = verified.report.at("assets")[i].at("stages").back().at("error");
        EXPECT_EQ(a, b) << cooked.report.at("assets")[i].at("name");
    }
    for (const FileRecord& file : filesOf(*loadManifest(scene / "out"))) {
        std::string content = *readFile(scene / "out" / file.name);
        content[content.size() / 2] = static_cast<char>(content[content.size() / 2] ^ 1);
        const std::string whole = *readFile(scene / "out" / file.name);
        formats::writeContent(scene / "out" / file.name, content);
        const Outcome damaged = verifyCooked(options, state);
        ASSERT_EQ(damaged.errors.size(), 1u) << file.name;
        EXPECT_EQ(damaged.errors[0].code, ErrorCode::Verification);
        EXPECT_THAT(damaged.errors[0].subject, HasSubstr(file.name));
        formats::writeContent(scene / "out" / file.name, whole);
    }
}

TEST(VerifyCooked, RefusesAChangedSourceAndAManifestOfAnotherShape) {
    const SmallScene scene(Parts::LightMap);
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    const RunState state;
    const VerifyOptions options{scene / "out", {}, {}};
    const SmallScene other(Parts::LightMap, grey);
    std::filesystem::copy_file(other / "map.exr", scene / "map.exr", std::filesystem::copy_options::overwrite_existing);
    const Outcome stale = verifyCooked(options, state);
    ASSERT_FALSE(stale.errors.empty());
    EXPECT_EQ(stale.errors[0].code, ErrorCode::Verification);
    EXPECT_THAT(stale.errors[0].line(), HasSubstr("the source changed"));
    formats::writeContent(scene / "out" / kManifestName, R"({"schema": 1, "assets": [{"name": 3}]})");
    const Outcome broken = verifyCooked(options, state);
    ASSERT_FALSE(broken.errors.empty());
    EXPECT_EQ(broken.errors[0].code, ErrorCode::FileUnreadable);
    EXPECT_EQ(verifyCooked({scene / "nowhere", {}, {}}, state).errors.at(0).code, ErrorCode::FileUnreadable);
}

TEST(ReconstructLightMap, IsTheBakeWithinTheCooksError) {
    const SmallScene scene(Parts::LightMap);
    ASSERT_TRUE(cook(scene.options()).errors.empty());
    const RunState state;
    ASSERT_TRUE(reconstructLightMap(scene / "out", "map", scene / "back.exr", 1, state).has_value());
    const auto bake = formats::LightMapReader::open(scene / "map.exr", {}), back = formats::LightMapReader::open(scene / "back.exr", {});
    ASSERT_TRUE(bake.has_value() && back.has_value());
    const auto a = bake->read(0, bake->height()), b = back->read(0, back->height());
    double error = 0, reference = 0;
    for (std::size_t t = 0; t < a->sh.texels().size(); ++t)
        for (std::size_t i = 0; i < 9; ++i) {
            const glm::dvec3 e = glm::dvec3(b->sh.texels()[t][i]) - glm::dvec3(a->sh.texels()[t][i]);
            error += glm::dot(e, e);
            reference += glm::dot(glm::dvec3(a->sh.texels()[t][i]), glm::dvec3(a->sh.texels()[t][i]));
        }
    EXPECT_LT(std::sqrt(error / reference), 0.02);
    const auto unknown = reconstructLightMap(scene / "out", "mop", scene / "no.exr", 1, state);
    ASSERT_FALSE(unknown.has_value());
    EXPECT_EQ(unknown.error().code, ErrorCode::InvalidRequest);
    EXPECT_FALSE(std::filesystem::exists(scene / "no.exr"));
}

TEST(ReadCookedFolder, NamesACookedFolderInsideAnother) {
    const formats::TemporaryFolder folder;
    for (const char* name : {"b", "a", "other"}) std::filesystem::create_directory(folder / name);
    for (const char* name : {"b", "a"}) formats::writeContent(folder / name / kManifestName, "{}");
    const std::string expected = "expected the output folder of `lightcook cook`, such as " + (folder / "a").string();
    EXPECT_THAT(readCookedFolder(folder.path()).error().line(), testing::EndsWith("found no report, " + expected));
    EXPECT_THAT(loadManifest(folder.path()).error().line(), testing::EndsWith("found no manifest, " + expected));
    EXPECT_THAT(loadManifest(folder / "other").error().line(), testing::EndsWith("the output folder of `lightcook cook`"));
}

TEST(ReconstructLightMap, HasTheCoverageAndNormalsOfTheBake) {
    const formats::TemporaryFolder folder;
    constexpr int kBakeSide = 8;
    formats::Image<lighting::ShRgb> sh(kBakeSide, kBakeSide);
    formats::Image<std::uint8_t> covered(kBakeSide, kBakeSide);
    formats::Image<glm::vec3> normal(kBakeSide, kBakeSide, glm::vec3(0, 1, 0));
    for (int y = 0; y < kBakeSide; ++y)
        for (int x = 0; x < kBakeSide; ++x) {
            sh.at(x, y)[0] = glm::vec3(1.0f + 0.1f * static_cast<float>(x));
            covered.at(x, y) = y < 5 ? 1 : 0;
        }
    auto writer = formats::LightMapWriter::create(folder / "map.exr", kBakeSide, kBakeSide, formats::SurfaceOutput::CoverageAndNormals);
    ASSERT_TRUE(writer && writer->append(sh.view(), {covered.view(), normal.view()}) && writer->commit());
    formats::writeContent(folder / "scene.toml",
                          "schema = 1\nname = \"a\"\n[output]\nlight_map_layout = \"raw\"\ntarget = \"float\"\n"
                          "[[light_map]]\nname = \"map\"\nfile = \"map.exr\"\n");
    CookOptions options;
    options.scene = folder / "scene.toml";
    options.output = folder / "out";
    options.cache = folder / "cache";
    ASSERT_TRUE(cookScene(options, RunState{}).errors.empty());
    std::vector<std::string> warnings;
    RunState state;
    state.warning = [&](const std::string&, const std::string& detail) { warnings.push_back(detail); };
    const auto back = [&](int places) {
        EXPECT_TRUE(reconstructLightMap(folder / "out", "map", folder / "back.exr", places, state));
        return formats::LightMapReader::open(folder / "back.exr", {});
    };
    const auto doubled = back(2);
    ASSERT_TRUE(doubled && doubled->hasCoverage() && doubled->hasNormals());
    const auto rows = doubled->read(0, 2 * kBakeSide);
    ASSERT_TRUE(rows);
    for (int y = 0; y < 2 * kBakeSide; ++y) {
        ASSERT_EQ(rows->covered.at(3, y), y < 10 ? 1 : 0) << y;
        if (y >= 10) continue;
        ASSERT_EQ(rows->normal.at(3, y), glm::vec3(0, 1, 0)) << y;
    }
    EXPECT_TRUE(warnings.empty());

    // Without the bake, the light alone is known.
    std::filesystem::remove(folder / "map.exr");
    const auto alone = back(1);
    ASSERT_TRUE(alone);
    EXPECT_FALSE(alone->hasCoverage() || alone->hasNormals());
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_THAT(warnings[0], HasSubstr("wrote no coverage and no normals, which are those of the bake: "));
}

/// The middle of 3 x 3 places is the texel's centre; the places on its left and right are a third of the way to its neighbours, whose
/// textures the GPU filters before the decode.
TEST(ReconstructLightMap, WritesPlacesBetweenTexels) {
    const SmallScene scene(Parts::LightMap);
    CookOptions options = scene.options();
    options.given.set("output.light_map_layout", "raw");
    options.given.set("output.target", "float");
    options.given.set("output.max_error", 0.9);
    ASSERT_TRUE(cook(options).errors.empty());
    const RunState state;
    ASSERT_TRUE(reconstructLightMap(scene / "out", "map", scene / "centres.exr", 1, state).has_value());
    ASSERT_TRUE(reconstructLightMap(scene / "out", "map", scene / "places.exr", 3, state).has_value());
    const auto centres = formats::LightMapReader::open(scene / "centres.exr", {}),
               places = formats::LightMapReader::open(scene / "places.exr", {});
    ASSERT_TRUE(centres.has_value() && places.has_value());
    const auto a = centres->read(0, centres->height()), b = places->read(0, places->height());
    ASSERT_EQ(b->sh.width(), 3 * a->sh.width());
    ASSERT_EQ(b->sh.height(), 3 * a->sh.height());
    const auto near = [](const glm::vec3& found, const glm::vec3& expected) {
        return glm::length(found - expected) <= 1e-5f * (1 + glm::length(expected));
    };
    for (int y = 0; y < a->sh.height(); ++y)
        for (int x = 0; x < a->sh.width(); ++x) {
            const glm::vec3 own = a->sh.at(x, y)[0], right = a->sh.at(std::min(x + 1, a->sh.width() - 1), y)[0],
                            below = a->sh.at(x, std::min(y + 1, a->sh.height() - 1))[0];
            EXPECT_TRUE(near(b->sh.at(3 * x + 1, 3 * y + 1)[0], own)) << x << ' ' << y;
            EXPECT_TRUE(near(b->sh.at(3 * x + 2, 3 * y + 1)[0], (2.0f * own + right) / 3.0f)) << x << ' ' << y;
            EXPECT_TRUE(near(b->sh.at(3 * x + 1, 3 * y + 2)[0], (2.0f * own + below) / 3.0f)) << x << ' ' << y;
        }
}

}  // namespace
}  // namespace lightcook::pipeline
