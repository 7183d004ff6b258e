// The program as users and build systems run it: exit codes, one line for each error, quiet on pipes, nothing left behind.
#include <gmock/gmock.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <limits>

#include "formats/plain_image.h"
#include "tests/end_to_end/command_fixture.h"
#include "tests/formats/opens.h"

namespace lightcook::pipeline {
namespace {

using formats::contentOf;
using testing::HasSubstr;
using testing::StartsWith;

/// Standard error has a line for each asset that was not in the cache.
TEST_F(Command, CookIsOneLineOnAPipeAndVerifyAndReportAreTables) {
    startWithoutCache();
    const Ended cook = run("cook scene.toml -o out");
    EXPECT_EQ(cook.code, 0) << cook.err;
    EXPECT_EQ(std::count(cook.out.begin(), cook.out.end(), '\n'), 1) << cook.out;
    EXPECT_THAT(cook.out, testing::AllOf(StartsWith("passed: 5 assets, "), HasSubstr(" of GPU memory, "),
                                         HasSubstr(" on disk, 0 of 10 actions from the cache: out")));
    for (const char* asset : {"map", "map_dominant", "probe", "sky", "specular"})
        EXPECT_THAT(cook.err, testing::ContainsRegex(fmt::format("lightcook: {}: done in [0-9]+\\.[0-9][0-9] s\n", asset)));
    EXPECT_EQ(std::count(cook.err.begin(), cook.err.end(), '\n'), 5) << cook.err;
    const Ended again = run("cook scene.toml -o out");
    EXPECT_THAT(again.out, HasSubstr(" 10 of 10 actions from the cache: out"));
    EXPECT_EQ(again.err, "");
    EXPECT_THAT(run("--log json cook scene.toml -o out --only sky --force").err, testing::Not(HasSubstr("done in")));
    const Ended quiet = run("cook scene.toml -o out -q");
    EXPECT_EQ(quiet.out + quiet.err, "");
    const Ended verify = run("verify out --json verify.json --junit verify.xml --sarif verify.sarif");
    EXPECT_EQ(verify.code, 0) << verify.err;
    EXPECT_THAT(verify.out, HasSubstr("passed"));
    EXPECT_THAT(contentOf(scene_ / "verify.xml"), HasSubstr("<testsuite"));
    EXPECT_THAT(contentOf(scene_ / "verify.sarif"), HasSubstr("\"2.1.0\""));
    EXPECT_THAT(contentOf(scene_ / "verify.json"), HasSubstr("\"passed\": true"));
    EXPECT_EQ(run("report out --json report.json --html report.html --baseline out/report.json --fail-over 0").code, 0);
    EXPECT_THAT(contentOf(scene_ / "report.html"), HasSubstr("small"));
    EXPECT_EQ(run("reconstruct out map back.exr").code, 0);
    EXPECT_EQ(run("info out").code, 0);
    EXPECT_EQ(run("compare out out").code, 0);
    // No limit of the light map was asked for.
    const std::string table = run("report out").out;
    EXPECT_THAT(table, testing::ContainsRegex("cubemap +pre-divided +[0-9.]+ -> +[0-9.]+ +error [0-9.]+ % of 50 % +passed"));
    EXPECT_THAT(table, testing::ContainsRegex("light-map +[a-z0-9-]+ +[0-9.]+ -> +[0-9.]+ +visible [0-9.]+ +passed"));
}

TEST_F(Command, CookVerifyAndReportTakeSeveralTargets) {
    scene_.writeSceneFile("targets = [\"bc\", \"astc\"]\nlight_map_layout = \"ratio\"\n\n[target.bc]\nbudget = \"100\"");
    const Ended cook = run("cook scene.toml -o out --json cook.json --junit cook.xml --sarif cook.sarif --history history.jsonl");
    EXPECT_EQ(cook.code, 5) << cook.err;
    EXPECT_THAT(cook.out,
                testing::AllOf(StartsWith("FAILED: over the budget"), HasSubstr(": out/bc\npassed: "), HasSubstr(": out/astc\n")));
    EXPECT_THAT(cook.err, HasSubstr("lightcook: error: bc, scene.toml:9, budget: found "));
    EXPECT_THAT(contentOf(scene_ / "cook.json"), testing::AllOf(HasSubstr("\"folder\": \"out/astc\""), HasSubstr("\"exit_code\": 5")));
    for (const char* file : {"cook.xml", "cook.sarif"})
        EXPECT_THAT(contentOf(scene_ / file), testing::AllOf(HasSubstr("small.bc"), HasSubstr("small.astc"))) << file;
    EXPECT_THAT(contentOf(scene_ / "history.jsonl"), testing::AllOf(HasSubstr("\"bc\""), HasSubstr("\"astc\"")));
    const Ended verify = run("verify out --json verify.json");
    EXPECT_EQ(verify.code, 5) << verify.err;
    EXPECT_THAT(contentOf(scene_ / "verify.json"), testing::AllOf(HasSubstr("\"target\": \"bc\""), HasSubstr("\"target\": \"astc\"")));
    const Ended report = run("report out --html report.html");
    EXPECT_EQ(report.code, 5) << report.err;
    EXPECT_THAT(report.out, testing::AllOf(HasSubstr("bc"), HasSubstr("astc")));
    EXPECT_EQ(run("verify out --json out/bc/cooked.json").code, 2);
    EXPECT_EQ(run("diff out/bc out/astc").code, 0);
    EXPECT_EQ(run("cook scene.toml -o out --targets bc --target astc").code, 2);
    EXPECT_THAT(run("info scene.toml --json -").out, HasSubstr("\"targets\""));

    scene_.writeSceneFile("targets = [\"bc\", \"astc\"]\nlight_map_layout = \"ratio\"");
    ASSERT_EQ(run("plan scene.toml --ninja scene.ninja -o planned").code, 0);
    EXPECT_EQ(run("--version >/dev/null && ninja -f scene.ninja").code, 0);
    EXPECT_EQ(run("verify planned").code, 0);
    EXPECT_THAT(run("--version >/dev/null && ninja -f scene.ninja").out, HasSubstr("no work to do")) << "it reads the depfile of both";
}

/// A cook without changes may look at the outputs of another user, or at those of a file system that is mounted read-only.
TEST_F(Command, ACookThatIsUpToDateNeedsNoFolderThatItMayWriteTo) {
    startWithoutCache();
    std::string program = LIGHTCOOK_PROGRAM;
    if (::geteuid() == 0) {  // who may write anywhere
        if (!isInstalled("setpriv")) GTEST_SKIP() << "no setpriv";
        program = scene_ / "as_other_user";
        formats::writeContent(program,
                              "#!/bin/sh\nexec setpriv --reuid=65534 --regid=65534 --clear-groups '" LIGHTCOOK_PROGRAM "' \"$@\"\n");
    }
    ASSERT_EQ(run("cook scene.toml -o out").code, 0);
    const std::string folder = (scene_ / "").string();
    if (program != LIGHTCOOK_PROGRAM) {
        ASSERT_EQ(runShell(fmt::format("chmod +x '{}'", program)), 0);
    }
    ASSERT_EQ(runShell(fmt::format("chmod -R a+rwX '{0}' && chmod -R a-w '{0}/out'", folder)), 0);
    if (run("--version", program).code != 0) GTEST_SKIP() << "the other user may not run the program";
    const Ended again = run("cook scene.toml -o out", program);
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_THAT(again.out, HasSubstr(" 10 of 10 actions from the cache: out"));
    for (const char* changed : {"--effort 1", "--force", "--layout raw", "--only sky --effort 2"}) {
        const Ended refused = run(std::string("cook scene.toml -o out ") + changed, program);
        EXPECT_EQ(refused.code, 1) << changed << refused.out;
        EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
        EXPECT_THAT(refused.err, HasSubstr("expected a folder that this user may write to"));
    }
    EXPECT_EQ(run("cook scene.toml -o out", program).code, 0) << "nothing was changed";
    EXPECT_EQ(runShell(fmt::format("chmod -R u+w '{}/out'", folder)), 0);
}

/// All files of a bake count, also where an editor gives one back its time and size.
TEST_F(Command, AnEditedFileBesideABakeIsCookedAgain) {
    namespace fs = std::filesystem;
    startWithoutCache();
    for (const char* name : {"hall_L0", "hall_L1x", "hall_L1y", "hall_L1z"}) {
        formats::Image<glm::vec4> picture(8, 8);
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 8; ++x) picture.at(x, y) = glm::vec4(0.5f + 0.01f * static_cast<float>(x + y));
        ASSERT_TRUE(formats::writeExr(scene_ / (std::string(name) + ".exr"), picture.view(), 3));
    }
    const std::string cook = "lightmap hall_L0.exr hall --layout raw";
    ASSERT_EQ(run(cook).code, 0);
    EXPECT_TRUE(fs::exists(scene_ / "hall/hall_sh.ktx2")) << "the asset has the name of the bake, as init gives it";
    ASSERT_THAT(run(cook).out, HasSubstr("2 of 2 actions from the cache"));
    for (const char* name : {"hall_L1z", "hall_L1x", "hall_L0"}) {
        const fs::path file = scene_ / (std::string(name) + ".exr");
        const auto time = fs::last_write_time(file);
        formats::Image<glm::vec4> picture(8, 8, glm::vec4(0.625f));
        ASSERT_TRUE(formats::writeExr(file, picture.view(), 3));
        fs::last_write_time(file, time);
        EXPECT_THAT(run(cook).out, HasSubstr("0 of 2 actions from the cache")) << name;
    }
}

TEST_F(Command, ACookOfOneAssetSaysThatItIsNotTheWholeScene) {
    const std::string line = "not the whole scene small: --only left out map, map_dominant, probe, specular\n";
    const Ended cook = run("cook scene.toml -o part --only sky");
    EXPECT_EQ(cook.code, 0) << cook.err;
    EXPECT_THAT(cook.out, StartsWith(line + "passed: 1 asset (without 4 of the scene), "));
    for (const char* command : {"verify part", "report part"}) {
        const Ended said = run(command);
        EXPECT_EQ(said.code, 0) << said.err;
        EXPECT_THAT(said.out, HasSubstr(line)) << command;
    }
    const auto summary = nlohmann::json::parse(run("--log json cook scene.toml -o part --only sky").err);
    EXPECT_EQ(summary.at("partial").size(), 4u);
}

/// A folder that a shell was to expand would be made here, under that name.
TEST_F(Command, ACacheWithATildeIsRefused) {
    cache_ = "~/cache";
    for (const char* command : {"cook scene.toml -o out", "lint scene.toml", "lightmap map.exr out"})
        expectRefused(command, 2, {"$LIGHTCOOK_CACHE: found '~' in the path '~/cache'"});
    EXPECT_EQ(run("info map.exr").code, 0) << "it needs no cache";
    EXPECT_FALSE(std::filesystem::exists(scene_ / "~"));
}

TEST_F(Command, TheConfigurationFileOfAUserGivesTheCaches) {
    cache_ = "";
    const auto file = scene_ / "configuration/lightcook/config.toml";
    std::filesystem::create_directories(file.parent_path());
    formats::writeContent(file, "[cache]\nfolder = \"kept\"\nremote_cache = \"http://127.0.0.1:1/cache\"\n");
    const Ended cook = run("cook scene.toml -o cooked --only sky");
    EXPECT_EQ(cook.code, 0);
    EXPECT_THAT(cook.err, HasSubstr("warning: http://127.0.0.1:1/cache: found "));
    EXPECT_TRUE(std::filesystem::exists(file.parent_path() / "kept/ac"));
    formats::writeContent(file, "[cache]\nfoldre = \"kept\"\n");
    for (const char* command : {"cook scene.toml -o out", "lint scene.toml", "rsrm sky.exr out"})
        expectRefused(command, 2, {"configuration/lightcook/config.toml:2:1: found unknown key 'foldre' in cache"});
    EXPECT_EQ(run("info map.exr").code, 0) << "it needs no cache";
}

/// 8 bits hold a gradient of one colour exactly.
TEST_F(Command, ATinyErrorIsNotZero) {
    std::string gradient = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 64\n";
    for (int i = 0; i < 64; ++i) gradient += "\x80\x80\x80\x81";
    formats::writeContent(scene_ / "even.hdr", gradient);
    ASSERT_EQ(run("rsrm even.hdr even --exponents 1,65536").code, 0);
    EXPECT_THAT(run("report even").out, testing::ContainsRegex("rsrm +rsrm +<0\\.001 -> +[0-9.]+ +error < 0\\.001 % of 10 %"));
}

/// Two reads could be of two scenes, if the file is saved in between.
TEST_F(Command, CookAndLintReadTheSceneFileOnce) {
    const auto opensOf = [&](const std::string& arguments) {
        const formats::Opens opens(scene_.sceneFile());
        EXPECT_EQ(run(arguments).code, 0);
        return opens.count();
    };
    const int once = opensOf("info scene.toml");
    EXPECT_GT(once, 0);
    EXPECT_EQ(opensOf("cook scene.toml -o out"), once);
    EXPECT_EQ(opensOf("lint scene.toml"), once);
}

TEST_F(Command, InfoParsesTheManifestOfAFolderOnce) {
    ASSERT_EQ(run("cook scene.toml -o out").code, 0);
    const formats::Opens opens(scene_ / "out/cooked.json");
    EXPECT_EQ(run("info out").code, 0);
    EXPECT_EQ(opens.count(), 2) << "for its content and for its digest";
}

/// Ninja is what builds this project, so that it is there.
TEST_F(Command, PlanIsANinjaFileThatCooksTheSame) {
    namespace fs = std::filesystem;
    startWithoutCache();
    formats::writeContent(scene_ / "launch.sh", "#!/bin/sh\necho \"$@\" >>launched\nexec \"$@\"\n");
    fs::permissions(scene_ / "launch.sh", fs::perms::owner_all);
    writeSlowRates(scene_ / "cache", {"light-map", "cubemap", "rsrm", "verify-cubemap", "verify-rsrm"});
    const Ended plan = run("plan scene.toml --ninja scene.ninja -o 'out $1' --cache cache --launcher \"'$PWD/launch.sh'\"");
    ASSERT_EQ(plan.code, 0) << plan.err;
    EXPECT_EQ(plan.out + plan.err, "");
    const auto ninja = [&](const std::string& arguments) { return run("--version >/dev/null && ninja -f scene.ninja " + arguments).out; };
    EXPECT_THAT(ninja(""), HasSubstr("[5/5] cook the scene small"));
    const std::string launched = formats::contentOf(scene_ / "launched");
    EXPECT_EQ(std::count(launched.begin(), launched.end(), '\n'), 5) << launched;
    EXPECT_THAT(launched, HasSubstr(" work "));
    EXPECT_THAT(ninja(""), HasSubstr("no work to do"));
    EXPECT_THAT(run("cook scene.toml -o 'out $1'").out, HasSubstr("10 of 10 actions from the cache")) << "nothing was left for it to do";
    EXPECT_EQ(run("verify 'out $1'").code, 0);
    cache_ = LIGHTCOOK_TEST_CACHE;  // textures that another run of the program has made, or makes now
    ASSERT_EQ(run("cook scene.toml -o direct").code, 0);
    for (const auto& entry : fs::directory_iterator(scene_ / "direct")) {
        const fs::path name = entry.path().filename();
        if (entry.is_regular_file() && name.extension() == ".ktx2") {
            EXPECT_EQ(contentOf(entry.path()), contentOf(scene_ / "out $1" / name)) << name;
        }
    }
    fs::last_write_time(scene_ / "sky.exr", fs::file_time_type::clock::now() + std::chrono::seconds(2));
    EXPECT_THAT(contentOf(scene_ / "out $1.assets/map.d"), testing::AllOf(HasSubstr("map.exr"), testing::Not(HasSubstr("sky.exr"))));
    const std::string again = ninja("-n");
    EXPECT_THAT(again, testing::AllOf(HasSubstr("cook sky"), HasSubstr("cook the scene small"), testing::Not(HasSubstr("cook map"))));
}

TEST_F(Command, PlanRefusesWhatCookRefuses) {
    expectRefused("plan absent.toml --ninja out", 2, {"absent.toml"});
    expectRefused("plan scene.toml", 2, {"--ninja"});
    expectRefused("plan scene.toml --ninja out -o 'a\nb'", 2, {"a\\nb: found a control character in the path"});
    formats::writeContent(scene_ / "wrong.toml", "schema = 1\nname = \"x\"\nsize = 3\n");
    expectRefused("plan wrong.toml --ninja out", 2, {"found the key 'size' in the scene, expected it in [[probe]]"});
}

TEST_F(Command, HelpAndVersionAreNoErrors) {
    EXPECT_EQ(run("--help").code, 0);
    EXPECT_THAT(run("--version").out, HasSubstr("lightcook"));
    for (const char* command : {"cook", "plan", "verify", "report", "reconstruct", "info", "compare", "encode", "decode", "lightmap",
                                "dominant", "cubemap", "lut", "rsrm", "demo"}) {
        const Ended help = run(std::string(command) + " --help");
        EXPECT_EQ(help.code, 0) << command;
        EXPECT_THAT(help.out, HasSubstr("--help")) << command;
    }
}

/// The image library is loaded from the folder of the program or from the installation's, for what is no EXR, Radiance HDR or PNG.
TEST_F(Command, LoadsItsImageLibraryOnlyToReadOtherImages) {
    namespace fs = std::filesystem;
    const fs::path program = scene_ / "bin/lightcook", installed = scene_ / "lib/lightcook/lightcook_images.so";
    fs::create_directories(program.parent_path());
    fs::create_directories(installed.parent_path());
    fs::copy_file(LIGHTCOOK_PROGRAM, program);
    fs::copy_file(LIGHTCOOK_PROGRAM "-read", scene_ / "bin/lightcook-read");
    formats::writeContent(scene_ / "grey.ppm", "P6\n2 2\n255\n" + std::string(12, 'x'));
    for (const char* command : {"--version", "info probe.exr", "cook scene.toml -o out"})  // a cook writes PNG
        EXPECT_EQ(run(command, program).code, 0) << command;
    const auto expectOneLine = [&](const std::string& words) {
        const Ended ended = run("info grey.ppm", program);
        EXPECT_EQ(ended.code, 1) << ended.err;
        EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
        EXPECT_THAT(ended.err, testing::AllOf(HasSubstr("lightcook_images.so"), HasSubstr("found"), HasSubstr(words)));
    };
    expectOneLine("expected the library that reads images");
    formats::writeContent(installed, "no library");
    expectOneLine(installed.string());
    fs::copy_file(fs::path(LIGHTCOOK_PROGRAM).parent_path() / installed.filename(), installed, fs::copy_options::overwrite_existing);
    EXPECT_EQ(run("info grey.ppm", program).code, 0);
}

TEST_F(Command, BadCommandLinesAndSceneFilesEndWithTwo) {
    expectRefused("", 2, {"error"});
    expectRefused("bake scene.toml", 2, {"bake"});
    expectRefused("cook scene.toml -o out --effort 11", 2, {"11"});
    expectRefused("cook scene.toml -o out --no-such-flag", 2, {"--no-such-flag"});
    expectRefused("cook nowhere.toml -o out", 2, {"nowhere.toml"});
    scene_.writeSceneFile("efort = 3");
    expectRefused("cook scene.toml -o out", 2, {"scene.toml:5:1", "unknown key 'efort'", "nearest is 'effort'"});
}

TEST_F(Command, InitWritesASceneThatIsCookedAsItIs) {
    std::filesystem::create_directory(scene_ / "mine");
    for (const char* file : {"map.exr", "probe.exr", "sky.exr"}) std::filesystem::rename(scene_ / file, scene_ / "mine" / file);
    const Ended made = run("init mine --json made.json");
    ASSERT_EQ(made.code, 0) << made.err;
    EXPECT_THAT(made.out, testing::HasSubstr("mine/map.exr: light map, read as sh9"));
    EXPECT_THAT(made.out, testing::HasSubstr("next: lightcook cook mine/scene.toml"));
    const Json json = Json::parse(formats::contentOf(scene_ / "made.json"));
    EXPECT_EQ(json.at("scene"), "mine/scene.toml");
    EXPECT_EQ(json.at("probes").size(), 1u);
    const Ended again = run("init mine");
    EXPECT_EQ(again.code, 2);
    EXPECT_THAT(again.err, testing::HasSubstr("--force replaces it"));
    EXPECT_EQ(run("init mine --force --quiet").out, "");
    EXPECT_THAT(run("init mine -o 'mine/it'\"'\"'s a room.toml'").out,
                testing::HasSubstr("next: lightcook cook 'mine/it'\\''s a room.toml'\n"));
    EXPECT_EQ(run("lint mine/scene.toml --strict").code, 0);
    const Ended cooked = run("cook mine/scene.toml -o out --max-converter-error 1 --effort 1");
    EXPECT_EQ(cooked.code, 0) << cooked.err;
    EXPECT_EQ(run("init map.exr -o none/scene.toml").code, 3) << "the map has moved";
    EXPECT_FALSE(std::filesystem::exists(scene_ / "none")) << "nothing is left of a refused command";
}

TEST_F(Command, BadInputEndsWithThree) {
    std::filesystem::rename(scene_ / "map.exr", scene_ / "whole.exr");
    expectRefused("cook scene.toml -o out", 3, {"map.exr", "found", "expected"});
    const std::string whole = contentOf(scene_ / "whole.exr");
    formats::writeContent(scene_ / "map.exr", whole.substr(0, whole.size() / 2));
    expectRefused("cook scene.toml -o out", 3, {"map.exr", "found", "expected"});
    formats::writeContent(scene_ / "map.exr", "no EXR");
    expectRefused("cook scene.toml -o out", 3, {"map.exr", "found", "expected"});
    std::filesystem::copy_file(scene_ / "probe.exr", scene_ / "map.exr", std::filesystem::copy_options::overwrite_existing);
    expectRefused("cook scene.toml -o out", 3, {"map.exr", "sh00"});
    std::string map = whole;
    map.replace(map.find("sh05.G"), 6, "sh05.H");  // the list stays sorted, and one coefficient is gone
    formats::writeContent(scene_ / "map.exr", map);
    expectRefused("cook scene.toml -o out", 3, {"map.exr", "found 26", "sh05.G"});
    expectRefused("encode nowhere.exr out --format bc7", 2, {"out"});
    expectRefused("encode nowhere.exr out.ktx2 --format bc7", 3, {"nowhere.exr"});
    expectRefused("verify nowhere", 3, {"nowhere"});
    expectRefused("decode whole.ktx2 out.exr", 3, {"whole.ktx2"});
}

TEST_F(Command, ANanTexelEndsWithThreeAndIsNamedOrRepaired) {
    formats::Image<lighting::ShRgb> rows(8, 8, lighting::ShRgb{glm::vec3(1)});
    rows.at(5, 3)[4].y = std::numeric_limits<float>::quiet_NaN();
    auto writer = formats::LightMapWriter::create(scene_ / "map.exr", 8, 8);
    ASSERT_TRUE(writer && writer->append(rows.view()) && writer->commit());
    expectRefused("cook scene.toml -o out", 3, {"map.exr", "sh04.G", "(5, 3)", "nan", "expected"});
    EXPECT_EQ(run("cook scene.toml -o out --repair").code, 0);
    EXPECT_THAT(contentOf(scene_ / "out" / "report.json"), HasSubstr("\"repaired_not_finite\": 1"));
}

TEST_F(Command, ANonLinearColourSpaceIsRefusedByName) {
    std::string text = contentOf(scene_.sceneFile());
    formats::writeContent(scene_.sceneFile(), text + "\n[color]\nsource = \"srgb_texture\"\n");
    expectRefused("cook scene.toml -o out", 2, {"scene.toml:", "color.source", "srgb_texture", "linear"});
}

TEST_F(Command, FailedVerificationEndsWithFourAndAnExceededBudgetWithFive) {
    EXPECT_EQ(run("cook scene.toml -o out --max-error 1e-7").code, 4);
    EXPECT_EQ(run("cook scene.toml -o out").code, 0);
    EXPECT_EQ(run("cook scene.toml -o out --budget 100").code, 5);
    EXPECT_EQ(run("report out").code, 5);
    std::fstream(scene_ / "out" / "sky.ktx2", std::ios::in | std::ios::out | std::ios::binary).seekp(300).put('x');
    const Ended damaged = run("verify out");
    EXPECT_EQ(damaged.code, 4);
    EXPECT_THAT(damaged.err, HasSubstr("sky.ktx2"));
}

TEST_F(Command, EncodeTakesAMetricWeightsAndSignificanceOrSaysWhatIsWrong) {
    const std::string encode = "encode probe.exr out.ktx2 --format bc6h-uf16 ";
    formats::Image<glm::vec4> weights(16, 96, glm::vec4(2));
    ASSERT_TRUE(formats::writeExr(scene_ / "weights.exr", weights.view(), 3).has_value());
    weights.at(3, 50).x = -1;
    ASSERT_TRUE(formats::writeExr(scene_ / "negative.exr", weights.view(), 3).has_value());
    expectRefused(encode + "--metric square", 2, {"--metric", "square"});
    expectRefused(encode + "--metric-scale 0", 2, {"--metric-scale", "found 0", "expected"});
    expectRefused(encode + "--metric-scale much", 2, {"--metric-scale", "much"});
    expectRefused(encode + "--metric-scale 1 --metric linear", 2, {"--metric-scale: found it with --metric linear"});
    expectRefused("encode probe.exr out.ktx2 --format bc7 --metric log", 2, {"--metric: found it with --format bc7"});
    expectRefused(encode + "--weights 1,2,3", 2, {"--weights"});
    expectRefused(encode + "--weights 1,2,-3,4", 2, {"--weights", "found 1,2,-3,4"});
    expectRefused(encode + "--significance nowhere.exr", 3, {"nowhere.exr"});
    expectRefused(encode + "--significance sky.exr", 3, {"sky.exr", "found 64 x 1", "expected 16 x 96"});
    expectRefused(encode + "--significance negative.exr", 3, {"negative.exr, texel (3, 50)", "found", "expected"});
    expectRefused("encode negative.exr out.ktx2 --format bc7", 3, {"negative.exr, channel R, texel (3, 50)", "--repair"});
    EXPECT_FALSE(std::filesystem::exists(scene_ / "out.ktx2"));
    const Ended repaired = run("encode negative.exr repaired.ktx2 --format bc7 --repair --json repaired.json");
    EXPECT_EQ(repaired.code, 0);
    EXPECT_THAT(repaired.err, HasSubstr("found 1 values repaired"));
    EXPECT_THAT(repaired.err, HasSubstr("values beyond the range of the format, which became its end"));
    EXPECT_THAT(contentOf(scene_ / "repaired.json"), HasSubstr("\"repaired\": 1"));
    for (const char* metric : {"log", "linear", "relative"}) {
        const std::string scale = metric == std::string_view("linear") ? "" : "--metric-scale 0.25 ";
        const Ended ended = run(encode + fmt::format("--metric {} {}--weights 2,4,1,1 --significance weights.exr", metric, scale));
        EXPECT_EQ(ended.code, 0) << ended.err;
        EXPECT_EQ(ended.err, "");
    }
    EXPECT_THAT(run("info out.ktx2").out, HasSubstr("bc6h-uf16"));
}

TEST_F(Command, ErrorsAreJsonWhereAskedFor) {
    const Ended ended = run("--log json cook nowhere.toml");
    EXPECT_EQ(ended.code, 2);
    EXPECT_THAT(ended.err, StartsWith("{"));
    EXPECT_THAT(ended.err, HasSubstr("\"code\":2"));
}

TEST_F(Command, AStandardStreamThatIsClosedOrFullIsNoOutputFile) {
    ASSERT_EQ(run("rsrm sky.exr out").code, 0);
    const auto shell = [&](const std::string& arguments) {
        return runShell(fmt::format("cd '{}' && '{}' {}", (scene_ / "").string(), LIGHTCOOK_PROGRAM, arguments));
    };
    EXPECT_EQ(shell("report out --json closed.json <&- >&- 2>&-"), 0);
    EXPECT_EQ(contentOf(scene_ / "closed.json").substr(0, 1), "{");
    EXPECT_EQ(shell("report out --json full.json >/dev/full 2>'stderr'"), 1);
    EXPECT_THAT(contentOf(scene_ / "stderr"), HasSubstr("standard output"));
    EXPECT_EQ(contentOf(scene_ / "full.json"), contentOf(scene_ / "closed.json"));
}

TEST_F(Command, NamesThatAreNoUtf8AndAFolderForTemporaryFilesThatIsNotThere) {
    std::filesystem::copy_file(scene_ / "sky.exr", scene_ / "sk\xff.exr");
    EXPECT_EQ(run("rsrm 'sk\xff.exr' out").code, 0);
    const Ended missing = run("--log json rsrm 'no\xff.exr' other");
    EXPECT_EQ(missing.code, 3);
    EXPECT_THAT(missing.err, StartsWith("{"));
    EXPECT_EQ(runShell(fmt::format("cd '{}' && TMPDIR=/nowhere '{}' verify out >/dev/null 2>'{}'", (scene_ / "").string(),
                                   LIGHTCOOK_PROGRAM, (scene_ / "stderr").string())),
              1);
    EXPECT_THAT(contentOf(scene_ / "stderr"), HasSubstr("TMPDIR"));
    // The manifest cannot name this folder, so that the page has no bake to show, and says so.
    std::filesystem::create_directory(scene_ / "in\xff");
    for (const char* name : {"scene.toml", "map.exr", "probe.exr", "sky.exr"})
        std::filesystem::copy_file(scene_ / name, scene_ / "in\xff" / name);
    ASSERT_EQ(run("cook 'in\xff/scene.toml' -o cooked").code, 0);
    const Ended exported = run("view cooked --export page");
    EXPECT_EQ(exported.code, 0) << exported.err;
}

TEST_F(Command, EachConverterRunsWithoutAScene) {
    EXPECT_EQ(run("lightmap map.exr lm").code, 0);
    EXPECT_TRUE(std::filesystem::exists(scene_ / "lm" / "map_l0.ktx2"));
    EXPECT_EQ(run("lightmap map.exr raw.ktx2 --layout raw").code, 0);
    EXPECT_TRUE(std::filesystem::exists(scene_ / "raw.ktx2"));
    EXPECT_EQ(run("dominant map.exr dom").code, 0);
    EXPECT_EQ(run("dominant map.exr dom2 --fit better").code, 2);
    const Ended explained = run("--log json dominant map.exr dom2 --fit refined --report");
    EXPECT_EQ(explained.code, 0);
    const auto explanation = nlohmann::json::parse(explained.out);
    EXPECT_GT(explanation.at("texels").get<int>(), 0);
    const auto left = [&](const char* fit) { return explanation.at(fit).at("unexplained_energy").get<double>(); };
    EXPECT_LE(left("best_light"), left("closed_form"));
    EXPECT_LT(left("two_lights"), left("best_light"));
    EXPECT_FALSE(explanation.at("worst_texels").empty());
    EXPECT_THAT(run("dominant map.exr dom2 --fit refined --report").out, testing::AllOf(HasSubstr("best light"), HasSubstr("texel ")));
    EXPECT_EQ(run("cubemap probe.exr probe.ktx2").code, 0);
    EXPECT_THAT(run("info probe.ktx2").out, HasSubstr("faces: 6"));
    EXPECT_EQ(run("rsrm sky.exr sky.ktx2 --exponents 1,8").code, 0);
    EXPECT_THAT(run("info sky.ktx2").out, HasSubstr("height: 2"));
    EXPECT_EQ(run("lut tables --m 0.3,0.6").code, 0);
    EXPECT_TRUE(std::filesystem::exists(scene_ / "tables" / "specular_c0236.ktx2"));
    EXPECT_EQ(run("lut tables.ktx2").code, 2) << "three textures do not fit one file";
}

using CommandSoak = Command;
/// Engines that read a layout load its files: Godot one DDS file with an array of four slices.
TEST_F(CommandSoak, LayoutsOfEnginesAreFilesThatTheyLoad) {
    ASSERT_EQ(run("lightmap map.exr room.dds --layout godot --max-error 1 --no-specular").code, 0);
    EXPECT_THAT(run("info room.dds").out, testing::AllOf(HasSubstr("bc6h-uf16"), HasSubstr("layers: 4")));
    EXPECT_EQ(run("decode room.dds slice.exr --layer 3").code, 0);
    const std::map<std::string, std::vector<std::string>> layouts = {
        {"mono-sh", {"l0", "l1"}}, {"bakery", {"l0", "l1x", "l1y", "l1z"}}, {"unreal-hq", {"lightmap0", "lightmap1"}}};
    for (const auto& [layout, files] : layouts) {
        ASSERT_EQ(run(fmt::format("lightmap map.exr {0} --layout {0} --container dds --max-error 1 --no-specular", layout)).code, 0);
        for (const std::string& file : files) EXPECT_TRUE(std::filesystem::exists(scene_ / layout / ("map_" + file + ".dds"))) << layout;
        EXPECT_EQ(run(fmt::format("verify {}", layout)).code, 0);
    }
    EXPECT_EQ(run("lightmap map.exr tight --layout godot --max-error 0.001 --no-specular").code, 4) << "it lacks band 2";
}

TEST_F(Command, TablesOfOtherLobesAndSizesAreVerifiedToo) {
    for (const char* options :
         {"--lobe ggx --normalization halo3 --m 0.05,1 --rows 12 --views 10", "--lobe phong --view-axis NoV --views 16",
          "--lobe phong-power --exponents 1,1000 --rows 9 --roughness-axis 'sqrt(m)'", "--m 0.3,0.3 --rows 1"}) {
        std::filesystem::remove_all(scene_ / "tables");
        EXPECT_EQ(run(fmt::format("lut tables {}", options)).code, 0) << options;
        const auto manifest = nlohmann::json::parse(contentOf(scene_ / "tables" / "cooked.json"));
        const auto& constants = manifest.at("assets").at(0).at("constants");
        EXPECT_EQ(constants.at("view").at("factors").size(), 4u);
        const auto report = nlohmann::json::parse(contentOf(scene_ / "tables" / "report.json"));
        const auto& figures = report.at("assets").at(0).at("stages").back().at("error").at("specular");
        EXPECT_GE(figures.at("max_bound").get<double>(), figures.at("max_sampled").get<double>()) << options;
    }
    EXPECT_EQ(run("lut tables --lobe phong --normalization halo3").code, 2);
    EXPECT_EQ(run("lut tables --exponents 1,8").code, 2);
    EXPECT_EQ(run("lut tables --m 0,1 --rows 16").code, 2) << "no distribution has a roughness of 0";
    EXPECT_EQ(run("lut tables --m 0.1,0.5 --rows 1").code, 2);
    EXPECT_EQ(run("lut tables --view-axis m").code, 2);
}

TEST_F(Command, ARefinedFitIsTheSameBytesOnAnyNumberOfThreads) {
    startWithoutCache();
    std::map<std::string, std::string> first;
    for (const char* threads : {"1", "3"}) {
        std::filesystem::remove_all(cache_);
        ASSERT_EQ(run(fmt::format("-j {} dominant map.exr dom --fit refined-ambient", threads)).code, 0);
        std::map<std::string, std::string> contents;
        for (const auto& entry : std::filesystem::directory_iterator(scene_ / "dom"))
            if (entry.path().extension() == ".ktx2") contents[entry.path().filename().string()] = contentOf(entry.path());
        EXPECT_EQ(contents.size(), 3u);
        if (first.empty()) first = contents;
        EXPECT_EQ(contents, first);
    }
}

TEST_F(Command, ThreadsAndInstructionSetsDoNotChangeAByte) {
    std::map<std::string, std::string> first;
    for (const char* variant : {"-j 1 --instructions avx2", "-j 3"}) {
        ASSERT_EQ(run(fmt::format("cook scene.toml -o out --force {}", variant)).code, 0);
        std::map<std::string, std::string> contents;
        for (const auto& entry : std::filesystem::directory_iterator(scene_ / "out"))
            if (entry.is_regular_file() && entry.path().stem() != "report")
                contents[entry.path().filename().string()] = contentOf(entry.path());
        EXPECT_GT(contents.size(), 5u) << variant;
        if (first.empty()) first = contents;
        EXPECT_EQ(contents, first) << variant;
    }
}

}  // namespace
}  // namespace lightcook::pipeline
