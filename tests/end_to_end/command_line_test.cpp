// The command line as users type it: help, output formats, limits that hold, and what a terminal shows.
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "formats/plain_image.h"
#include "pipeline/command/outputs.h"
#include "pipeline/report/bundle.h"
#include "pipeline/report/report.h"
#include "tests/end_to_end/command_fixture.h"
#include "tests/pipeline/report_parts.h"

namespace lightcook::pipeline {
namespace {

using formats::contentOf;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class CommandLine : public Command {
protected:
    /// Runs the program in a pseudo-terminal and returns everything that it shows.
    std::string onTerminal(const std::string& arguments, const std::string& environment = "") const {
        const std::string command = fmt::format(
            "cd '{0}' && TERM=xterm {1} LIGHTCOOK_CACHE='{2}' script -qec \"'{3}' {4}\" '{0}/typescript' >/dev/null 2>&1 </dev/null",
            (scene_ / "").string(), environment, cache_.string(), LIGHTCOOK_PROGRAM, arguments);
        EXPECT_NE(runShell(command), -1);
        return contentOf(scene_ / "typescript");
    }
};

TEST_F(CommandLine, HelpIsThereInEveryWay) {
    const Ended all = run("help");
    EXPECT_EQ(all.code, 0) << all.err;
    EXPECT_THAT(all.out, AllOf(HasSubstr("cook"), HasSubstr("--threads")));
    EXPECT_EQ(run("--help").out, all.out);
    EXPECT_EQ(run("-V").out, run("--version").out);
    EXPECT_EQ(run("help cook").out, run("cook --help").out);
    const Ended none = run("");
    EXPECT_EQ(none.code, 2) << "a script with an empty variable is a mistake";
    EXPECT_THAT(none.out, StartsWith(all.out));
    EXPECT_THAT(none.err, HasSubstr("A subcommand is required"));
    EXPECT_THAT(run("help cok").err, HasSubstr("nearest is 'cook'"));
    EXPECT_EQ(run("help cok").code, 2);
}

TEST_F(CommandLine, EveryCommandHasJsonOnStandardOutput) {
    ASSERT_EQ(run("cook scene.toml -o out").code, 0);
    ASSERT_EQ(run("encode probe.exr probe.ktx2 --format bc6h-uf16").code, 0);
    std::vector<std::pair<std::string, std::string>> commands = {{"cook scene.toml -o out", "assets"},
                                                                 {"plan scene.toml --ninja scene.ninja", "parts"},
                                                                 {"verify out", "assets"},
                                                                 {"report out", "budget"},
                                                                 {"lightmap map.exr lm", "assets"},
                                                                 {"dominant map.exr dom --report", "explanation"},
                                                                 {"cubemap probe.exr cube", "assets"},
                                                                 {"cubemap probe.exr sh.json --filter sh", "sh"},
                                                                 {"lut tables --m 0.3,0.6", "assets"},
                                                                 {"rsrm sky.exr refl --exponents 1,8", "assets"},
                                                                 {"encode probe.exr p.ktx2 --format bc6h-uf16", "bytes"},
                                                                 {"decode probe.ktx2 back.exr", "channels"},
                                                                 {"reconstruct out map map_back.exr", "light_map"},
                                                                 {"compare out out", "assets"},
                                                                 {"info probe.ktx2", "format"},
                                                                 {"help cook", "commands"}};
    if (!viewerBundle().empty()) commands.emplace_back("view out --export page", "folder");
    for (const auto& [command, key] : commands) {
        SCOPED_TRACE(command);
        const Ended ended = run(command + " --json -");
        EXPECT_EQ(ended.code, 0) << ended.err;
        ASSERT_TRUE(nlohmann::json::accept(ended.out)) << ended.out;
        EXPECT_TRUE(nlohmann::json::parse(ended.out).contains(key)) << ended.out;
        EXPECT_FALSE(std::filesystem::exists(scene_ / "-"));
    }
    const Ended failed = run("info nowhere.exr --json -");
    EXPECT_EQ(failed.code, 3);
    EXPECT_EQ(nlohmann::json::parse(failed.out).at("exit_code"), 3);
    EXPECT_EQ(nlohmann::json::parse(failed.out).at("passed"), false);
    EXPECT_FALSE(nlohmann::json::parse(failed.out).contains("results"));
    const auto list = nlohmann::json::parse(run("info probe.ktx2 nowhere.exr --json -").out);
    EXPECT_EQ(list.at("passed"), false);
    EXPECT_EQ(list.at("results").size(), 1u);
    EXPECT_THAT(nlohmann::json::parse(failed.out).at("errors")[0].at("subject").get<std::string>(), HasSubstr("nowhere.exr"));
    EXPECT_EQ(run("verify out --json - --junit -").code, 2);
    EXPECT_THAT(run("verify out --junit -").out, StartsWith("<?xml"));
}

TEST_F(CommandLine, InfoTakesSeveralFilesAndPatterns) {
    const Ended several = run("info map.exr probe.exr --json -");
    EXPECT_EQ(several.code, 0) << several.err;
    const nlohmann::json list = nlohmann::json::parse(several.out);
    ASSERT_EQ(list.size(), 2u);
    EXPECT_EQ(list[0].at("file"), "map.exr");
    EXPECT_EQ(list[1].at("height"), 96);
    EXPECT_EQ(nlohmann::json::parse(run("info '*.exr' --json -").out).size(), 3u) << "map, probe and sky";
    EXPECT_THAT(run("info '*.exr'").out, AllOf(HasSubstr("map.exr:\n  light_map: sh9"), HasSubstr("sky.exr:\n  width: 64")));
    const Ended none = run("info '*.png'");
    EXPECT_EQ(none.code, 3);
    EXPECT_THAT(none.err, HasSubstr("*.png: found no file of this pattern"));
    const Ended partly = run("info nowhere.exr sky.exr");
    EXPECT_EQ(partly.code, 3);
    EXPECT_THAT(partly.out, HasSubstr("width: 64"));
}

TEST_F(CommandLine, DecodeWritesNoExrUnderAnotherName) {
    ASSERT_EQ(run("encode probe.exr probe.ktx2 --format bc6h-uf16").code, 0);
    expectRefused("decode probe.ktx2 probe.png", 2, {"probe.png: found the extension '.png', expected .exr"});
    EXPECT_FALSE(std::filesystem::exists(scene_ / "probe.png"));
    expectRefused("reconstruct nowhere map map.png", 2, {"map.png: found the extension '.png', expected .exr"});
}

TEST_F(CommandLine, ADdsFileIsRefusedWhereItWouldLoseConstants) {
    for (const char* command : {"cubemap probe.exr x.dds", "cubemap probe.exr x.dds --layout prefiltered", "rsrm sky.exr x.dds",
                                "rsrm sky.exr deep/x.DDS --format rgba16f", "lightmap map.exr x.dds --layout raw"})
        expectRefused(command, 2, {"found a DDS file", "expected a .ktx2 file, or a folder with --container dds"});
    expectRefused("cubemap probe.exr x.dds --filter irradiance", 2, {"x.dds: found a DDS file", "expected a .ktx2 file\n"});
    // The layout of a flat bake is known only after it was read.
    formats::Image<glm::vec4> flat(16, 16);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) flat.at(x, y) = glm::vec4(1 + static_cast<float>(x), 1 + static_cast<float>(y), 2, 1);
    ASSERT_TRUE(formats::writeExr(scene_ / "flat.exr", flat.view(), 3));
    expectRefused("lightmap flat.exr x.dds --bake flat --max-error 1", 2, {"x.dds: found a DDS file"});
    EXPECT_FALSE(std::filesystem::exists(scene_ / "x.dds"));
    EXPECT_FALSE(std::filesystem::exists(scene_ / "deep"));
    ASSERT_EQ(run("rsrm sky.exr refl --container dds").code, 0);
    const auto manifest = nlohmann::json::parse(contentOf(scene_ / "refl" / "cooked.json"));
    EXPECT_EQ(manifest.at("assets").at(0).at("constants").at("color").size(), 3u);
    EXPECT_EQ(run("lightmap map.exr godot.dds --layout godot --max-error 1").code, 0) << "it has no constants";
}

TEST_F(CommandLine, AFolderIsNotNamedLikeAFile) {
    for (const auto& [command, name] : std::vector<std::pair<std::string, std::string>>{{"cubemap probe.exr pr.json", "pr.json"},
                                                                                        {"lightmap map.exr x.png", "x.png"},
                                                                                        {"rsrm sky.exr a/x.EXR", "a/x.EXR"},
                                                                                        {"lut tables.json", "tables.json"},
                                                                                        {"cook scene.toml -o small.html", "small.html"},
                                                                                        {"plan scene.toml --ninja n -o x.glb", "x.glb"}}) {
        expectRefused(command, 2, {name + ": found the extension '.", "expected a folder, such as "});
        EXPECT_FALSE(std::filesystem::exists(scene_ / name)) << command;
    }
    EXPECT_FALSE(std::filesystem::exists(scene_ / "a"));
    expectRefused("cubemap probe.exr pr.json", 2, {"such as pr, or a .ktx2 file, or a .json file with --filter sh"});
    for (const char* name : {"v1.2", "small.cooked"}) {
        EXPECT_EQ(run(fmt::format("rsrm sky.exr {}", name)).code, 0);
        EXPECT_TRUE(std::filesystem::is_directory(scene_ / name)) << name;
    }
    std::filesystem::create_directory(scene_ / "mine.json");
    EXPECT_EQ(run("rsrm sky.exr mine.json").code, 0) << "a folder that is there";
}

TEST_F(CommandLine, AFolderIsNotPrinted) {
    for (const char* command : {"cook scene.toml -o -", "view nothing --export -", "repack map.exr map.glb -o -"})
        EXPECT_THAT(run(command).err, HasSubstr(": found -, expected a folder: its files are not printed")) << command;
    EXPECT_EQ(run("cook scene.toml -o -").code, 2);
    EXPECT_FALSE(std::filesystem::exists(scene_ / "-"));
}

TEST_F(CommandLine, MakeIsNamedWhereItDoesNotReadADepfile) {
    const Ended ended = run("cook scene.toml -o o%1 --depfile o.d");
    EXPECT_EQ(ended.code, 0);
    EXPECT_THAT(ended.err, HasSubstr("warning: o%1/cooked.json: found '%' in a path of the depfile"));
    EXPECT_THAT(run("cook scene.toml -o o%1 --depfile o.d -q").err, Not(HasSubstr("depfile"))) << "as plan has it run";
    EXPECT_THAT(run("cook scene.toml -o o%1").err, Not(HasSubstr("depfile")));
}

TEST_F(CommandLine, AnOutputThatCannotBeMadeIsRefusedAtOnce) {
    std::filesystem::create_symlink("nowhere", scene_ / "link");
    for (const char* command : {"cook scene.toml -o link", "rsrm sky.exr link", "rsrm sky.exr link/deep", "decode nothing.ktx2 link/x.exr"})
        expectRefused(command, 2, {"link: found a symbolic link to nothing, expected a folder, or no such name"});
    expectRefused(fmt::format("cook scene.toml -o {}", std::string(300, 'x')), 2, {"found a name of 300 bytes, expected at most 255"});
    expectRefused("decode nothing.ktx2 x.exr --mip 99999999999", 2, {"99999999999"});
}

using CommandLineSoak = CommandLine;
TEST_F(CommandLineSoak, ALimitThatIsGivenIsTheLimitOfTheAsset) {
    scene_.writeSceneFile("light_map_layout = \"ratio\"");  // all layouts would be tried
    // The next test runs the same commands within their limits.
    for (const char* command : {"cubemap probe.exr a", "lut b --m 0.3,0.6", "rsrm sky.exr c --exponents 1,8", "dominant map.exr d",
                                "cubemap probe.exr e.ktx2 --filter irradiance", "lightmap map.exr f --layout ratio"}) {
        SCOPED_TRACE(command);
        const Ended failed = run(std::string(command) + " --max-error 0.00001%");
        EXPECT_EQ(failed.code, 4) << failed.out;
        EXPECT_THAT(failed.err, HasSubstr("expected at most 1e-07"));
    }
    EXPECT_EQ(run("cook scene.toml -o out --max-converter-error 1e-7").code, 4);
    EXPECT_EQ(run("cook scene.toml -o out --max-error 90% --max-converter-error 1e-7").code, 4) << "not the larger of both";
}

TEST_F(CommandLineSoak, ConvertersKeepABudgetAndRefuseWhatWouldNotAct) {
    for (const char* command : {"cubemap probe.exr a", "lut b --m 0.3,0.6", "rsrm sky.exr c --exponents 1,8", "dominant map.exr d",
                                "cubemap probe.exr e.ktx2 --filter irradiance", "lightmap map.exr f --layout ratio"}) {
        SCOPED_TRACE(command);
        const Ended over = run(std::string(command) + " --budget 16");
        EXPECT_EQ(over.code, 5) << over.out;
        EXPECT_THAT(over.err, HasSubstr("expected at most 16"));
        EXPECT_EQ(run(std::string(command) + " --budget '64 MiB' --max-error 60%").code, 0);
    }
    EXPECT_FALSE(std::filesystem::exists(scene_ / "sh.json"));
    for (const char* option : {"--target bc", "--container ktx2", "--zstd", "--budget 16", "--max-error 1%", "--effort 3", "--rdo 1%"})
        expectRefused(std::string("cubemap probe.exr sh.json --filter sh ") + option, 2,
                      {"--filter sh", "expected --filter specular or irradiance"});
    for (const char* filter : {"sh", "irradiance"})
        expectRefused(fmt::format("cubemap probe.exr sh.{0} --filter {1} --max-visible 1e-9", filter[0] == 's' ? "json" : "ktx2", filter),
                      2, {"--max-visible: found it with --filter ", "expected --filter specular"});
    for (const char* target : {"astc", "float"})
        expectRefused(fmt::format("cubemap probe.exr x.ktx2 --filter irradiance --rdo 1% --target {}", target), 2,
                      {"--rdo: found output.rdo with target"});
    expectRefused("rsrm probe.exr x --axis 0,1,0 --encoding srgb", 2,
                  {"--encoding: found gradient.encoding beside an axis", "painted gradients alone"});
    // The bake has normals: no action would read the mesh.
    for (const char* command : {"lightmap", "dominant"}) {
        expectRefused(fmt::format("{} map.exr x --mesh nowhere.glb", command), 3, {"nowhere.glb: found \"No such file or directory\""});
        expectRefused(fmt::format("{} map.exr x --mesh scene.toml", command), 3, {"scene.toml"});
    }
    expectRefused("cubemap probe.exr x.dds --container ktx2", 2, {"--container", "x.dds"});
    expectRefused("cubemap probe.exr x.dds --filter irradiance --container ktx2", 2, {"--container", "x.dds"});
    expectRefused("rsrm sky.exr x --effort 3", 2, {"--effort", "--format rgba8", "bc7, bc4, bc6h, or auto"});
    expectRefused("rsrm sky.exr x --layout raw", 2, {"unknown option '--layout'"});
}

TEST_F(CommandLine, OutputsDoNotReplaceInputsOrEachOther) {
    const std::string scene = contentOf(scene_ / "scene.toml"), map = contentOf(scene_ / "map.exr");
    const std::vector<std::pair<std::string, std::string>> refused = {
        {"cook scene.toml -o out --depfile scene.toml", "--depfile: found the same file as scene (scene.toml), expected another one"},
        {"cook scene.toml -o out --json ./map.exr", "--json: found the same file as an input of the scene (./map.exr)"},
        {"cook scene.toml -o out --json both.x --junit both.x", "--junit: found the same file as --json (both.x)"},
        {"cook scene.toml -o out --json out/cooked.json", "--json: found the same file as one of the cooked folder"},
        {"cook scene.toml -o out --depfile out/lightcook.glsl", "--depfile: found the same file as one of the cooked folder"},
        {"cook scene.toml -o out --json out/report.html", "--json: found the same file as the report of the output folder"},
        {"cook scene.toml -o out --depfile out/report.json", "--depfile: found the same file as the report of the output folder"},
        {"cook scene.toml -o out --json out", "found the same file as"},
        {"cook scene.toml --json small.cooked", "--json: found the same file as the output folder (small.cooked)"},
        {"cook scene.toml -o map.exr/out", "map.exr/out: found the file map.exr in place of a folder"},
        {"lint scene.toml --json probe.exr", "--json: found the same file as an input of the scene (probe.exr)"},
        {"plan scene.toml --ninja scene.toml", "--ninja: found the same file as scene (scene.toml)"},
        {"plan scene.toml --ninja map.exr", "--ninja: found the same file as an input of the scene (map.exr)"},
        {"plan scene.toml --ninja x.ninja --json map.exr", "--json: found the same file as an input of the scene (map.exr)"},
        {"init . --json map.exr -o new.toml", "--json: found the same file as an input (map.exr)"},
        {"init map.exr -o map.exr --force", "--output: found the same file as inputs (map.exr)"},
        {"info map.exr --json map.exr", "--json: found the same file as files (map.exr)"},
        {"info scene.toml --json map.exr", "--json: found the same file as an input of the scene (map.exr)"},
        {"info '*.exr' --json map.exr", "--json: found the same file as a file of the pattern (map.exr)"},
        {"plan scene.toml --ninja - --json -", "--ninja, --json: found - for both, expected one document on standard output"},
        {"cook scene.toml -o out --depfile -", "--depfile: found -, expected the name of a file"},
        {"cook scene.toml -o out --history -", "--history: found -, expected the name of a file"},
        {"init map.exr -o -", "--output: found -, expected the name of a file"},
        {"compare map.exr probe.exr --json probe.exr", "--json: found the same file as b (probe.exr)"},
        {"compare probe.exr probe.exr --metric rel_rms --json -", "--metric: found rel_rms, which images and textures do not have"},
        {"encode probe.exr x.ktx2 --format bc7 --json x.ktx2", "--json: found the same file as output (x.ktx2)"},
        {"lightmap map.exr out --json map.exr", "--json: found the same file as input (map.exr)"},
        {"lightmap map.exr out --json .", ".: found a folder, expected the name of a file to write"},
    };
    for (const auto& [command, words] : refused) expectRefused(command, 2, {words});
    formats::writeContent(scene_ / "room.gltf", R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "room.bin", "byteLength": 4}]})");
    formats::writeContent(scene_ / "room.bin", "mesh");
    for (const char* command : {"lightmap map.exr out --mesh room.gltf --json room.bin", "repack map.exr room.gltf -o out --json room.bin"})
        expectRefused(command, 2, {"--json: found the same file as a file of room.gltf (room.bin), expected another one"});
    EXPECT_EQ(contentOf(scene_ / "room.bin"), "mesh");
    EXPECT_EQ(contentOf(scene_ / "scene.toml"), scene);
    EXPECT_EQ(contentOf(scene_ / "map.exr"), map);
    EXPECT_FALSE(std::filesystem::exists(scene_ / "x.ktx2"));

    ASSERT_EQ(run("cook scene.toml -o cooked --json /dev/null --junit /dev/null").code, 0) << "nothing is lost there";
    const std::string manifest = contentOf(scene_ / "cooked" / "cooked.json"), sky = contentOf(scene_ / "cooked" / "sky.ktx2");
    std::filesystem::create_symlink("cooked/sky.ktx2", scene_ / "link.html");
    expectRefused("verify cooked --json cooked/cooked.json", 2, {"--json: found the same file as one of the cooked folder"});
    expectRefused("report cooked --html cooked/sky.ktx2", 2, {"--html: found the same file as one of the cooked folder"});
    expectRefused("report cooked --html link.html", 2, {"--html: found the same file as one of the cooked folder"});
    const std::string source = "found the same file as a source of the cooked folder";
    expectRefused("reconstruct cooked map map.exr", 2, {"output: " + source});
    expectRefused("verify cooked --json map.exr", 2, {"--json: " + source});
    expectRefused("report cooked --html scene.toml", 2, {"--html: " + source});
    std::filesystem::create_directories(scene_ / "elsewhere" / "deep");
    std::filesystem::copy(scene_ / "cooked", scene_ / "elsewhere" / "deep" / "cooked");
    expectRefused("verify elsewhere/deep/cooked --sources . --json map.exr", 2, {"--json: " + source});
    EXPECT_EQ(contentOf(scene_ / "scene.toml"), scene);
    EXPECT_EQ(contentOf(scene_ / "map.exr"), map);
    EXPECT_EQ(contentOf(scene_ / "cooked" / "cooked.json"), manifest);
    EXPECT_EQ(contentOf(scene_ / "cooked" / "sky.ktx2"), sky);
    EXPECT_EQ(run("report cooked --json cooked/report.json --html cooked/report.html").code, 0);
}

TEST_F(CommandLineSoak, DocumentsDoNotReplaceFilesOfACookedFolder) {
    // Before a first cook, no manifest lists the files that it will write.
    for (const char* option : {"--json", "--junit", "--sarif", "--depfile", "--history"})
        expectRefused(fmt::format("cook scene.toml -o out {} out/map_l0.ktx2", option), 2,
                      {fmt::format("{}: found the same file as one of the cooked folder (out/map_l0.ktx2), expected another one", option)});
    expectRefused("lightmap map.exr out --layout ratio --json out/map_ratio.ktx2", 2,
                  {"--json: found the same file as one of the cooked folder"});
    expectRefused("lightmap map.exr out --json out/cooked.json", 2, {"--json: found the same file as one of the cooked folder"});
    expectRefused("demo -o out --json out/report.json", 2, {"--json: found the same file as the report of the output folder"});

    expectRefused("demo --json demo.cooked/report.json", 2, {"--json: found the same file as the report of the output folder"});
    expectRefused("demo --json demo.cooked/cooked.json", 2, {"--json: found the same file as one of the cooked folder"});

    ASSERT_EQ(run("cook scene.toml -o cooked").code, 0);
    const auto report = loadReport(scene_ / "cooked" / kReportName);
    ASSERT_TRUE(report && report->files);
    std::map<std::string, std::string> before = {{kReportName, contentOf(scene_ / "cooked" / kReportName)}};
    for (const ReportFile& file : *report->files) before[file.file] = contentOf(scene_ / "cooked" / file.file);
    ASSERT_GT(before.size(), 2u) << "no pictures";
    for (const char* command :
         {"verify cooked --json cooked/report.json", "verify cooked --junit cooked/report.html", "info cooked --json cooked/report.json",
          "compare cooked cooked --json cooked/report.json", "view cooked --export page --json cooked/report.json",
          "plan scene.toml --ninja x.ninja -o cooked --json cooked/report.json", "report cooked --html cooked/report.json",
          "report cooked cooked --json cooked/report.json", "report cooked --baseline cooked --json cooked/report.json",
          "verify cooked --samples 0x --json cooked/report.json"})
        EXPECT_EQ(run(command).code, 2) << command;
    for (const auto& [file, content] : before) {
        if (file.starts_with("preview")) expectRefused(fmt::format("verify cooked --json cooked/{}", file), 2, {kCookedFile});
        EXPECT_EQ(contentOf(scene_ / "cooked" / file), content) << file;
    }
    EXPECT_EQ(run("verify cooked").code, 0);
    EXPECT_EQ(run("cook scene.toml -o cooked --json cooked/report.json").code, 0);
    EXPECT_EQ(run("verify cooked --json report.json --junit cooked/junit.xml --sources .").code, 0) << "no file of the cook";
}

TEST_F(CommandLine, ADocumentThatCannotBeWrittenIsInTheVerdict) {
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
    for (const char* command : {"cook scene.toml -o cooked --json /dev/full", "rsrm sky.exr refl --exponents 1,8 --json /dev/full",
                                "dominant map.exr dom --report --json /dev/full"}) {
        const Ended ended = run(command);
        EXPECT_EQ(ended.code, 1) << ended.err;
        EXPECT_THAT(ended.out, AllOf(HasSubstr("FAILED: "), Not(HasSubstr("passed: ")))) << command;
    }
}

TEST_F(CommandLine, AConverterThatMakesNothingSaysWhy) {
    const SmallScene greyScene(SmallScene::Parts::LightMap, grey);
    for (const char* quiet : {"", " -q"}) {
        const Ended ended = run(fmt::format("dominant {} nothing{}", (greyScene / "map.exr").string(), quiet));
        EXPECT_EQ(ended.code, 0) << ended.err;
        EXPECT_THAT(ended.err, HasSubstr("warning: dominant light of 'map': not made: ")) << quiet;
    }
}

/// A script reads the file of --json: one that an earlier run left would say that all is well.
TEST_F(CommandLine, AnEarlyFailureIsInTheFilesThatWereAskedForToo) {
    scene_.writeSceneFile("efort = 3");
    formats::writeContent(scene_ / "st.json", "{\"passed\": true}");
    EXPECT_EQ(run("cook scene.toml -o out --json st.json --junit st.xml --sarif st.sarif").code, 2);
    const auto failed = nlohmann::json::parse(contentOf(scene_ / "st.json"));
    EXPECT_EQ(failed.at("passed"), false);
    EXPECT_EQ(failed.at("exit_code"), 2);
    EXPECT_THAT(failed.at("errors").at(0).at("detail").get<std::string>(), HasSubstr("unknown key 'efort'"));
    EXPECT_THAT(contentOf(scene_ / "st.xml"), HasSubstr("<failure type=\"request\" message=\"scene.toml:"));
    EXPECT_THAT(contentOf(scene_ / "st.sarif"), HasSubstr("unknown key 'efort'"));
    EXPECT_EQ(nlohmann::json::parse(run("verify nowhere --json -").out).at("passed"), false);
}

TEST_F(CommandLine, AMistakeOnTheCommandLineWritesNothing) {
    formats::writeContent(scene_ / "st.json", "older");
    for (const char* mistaken : {"verify cooked --json st.json --samples 0x", "verfy cooked --json st.json", "verify --json st.json",
                                 "encode probe.exr probe.exr --format bc7 --json st.json", "verify cooked --jsn x --json st.json"}) {
        EXPECT_EQ(run(mistaken).code, 2) << mistaken;
        EXPECT_EQ(contentOf(scene_ / "st.json"), "older") << mistaken;
    }
    EXPECT_EQ(run("verify cooked --json - --samples 0x").out, "");
}

TEST_F(CommandLine, OutputsGetTheirFolderAndARefusalLeavesNone) {
    namespace fs = std::filesystem;
    ASSERT_EQ(run("cook scene.toml -o cooked").code, 0);
    for (const char* command :
         {"encode probe.exr a/b/x.ktx2 --format bc6h-uf16", "decode a/b/x.ktx2 c/d/x.exr", "reconstruct cooked map e/f/x.exr"}) {
        const Ended ended = run(command);
        EXPECT_EQ(ended.code, 0) << command << ": " << ended.err;
    }
    EXPECT_TRUE(fs::exists(scene_ / "a/b/x.ktx2") && fs::exists(scene_ / "c/d/x.exr") && fs::exists(scene_ / "e/f/x.exr"));
    EXPECT_EQ(run("encode nowhere.exr g/x.ktx2 --format bc7").code, 3);
    EXPECT_EQ(run("decode nowhere.ktx2 g/x.exr").code, 3);
    EXPECT_NE(run("reconstruct cooked nothing g/h/x.exr").code, 0);
    expectRefused("encode probe.exr g/x.dds --format astc-4x4-hdr", 2, {"--format: found astc-4x4-hdr for g/x.dds"});
    EXPECT_FALSE(fs::exists(scene_ / "g"));
    expectRefused("encode probe.exr map.exr/x.ktx2 --format bc7", 2, {"map.exr/x.ktx2: found the file map.exr in place of a folder"});
}

TEST_F(CommandLine, ALinkInTheOutputFolderIsReplacedAndANamedOneIsFollowed) {
    namespace fs = std::filesystem;
    const auto isFile = [&](const char* name) { return fs::is_regular_file(fs::symlink_status(scene_ / name)); };
    ASSERT_EQ(run("cook scene.toml -o cooked").code, 0);
    const std::string texture = contentOf(scene_ / "cooked/sky.ktx2");
    for (const char* name : {"sky.ktx2", "cooked.json", "report.json", "report.html", "lightcook.glsl"}) {
        const std::string mine = std::string("mine_") + name;
        formats::writeContent(scene_ / mine, "mine");
        fs::remove(scene_ / "cooked" / name);
        fs::create_symlink("../" + mine, scene_ / "cooked" / name);
    }
    const Ended again = run("cook scene.toml -o cooked");
    EXPECT_EQ(again.code, 0) << again.err;
    for (const char* name : {"sky.ktx2", "cooked.json", "report.json", "report.html", "lightcook.glsl"}) {
        EXPECT_TRUE(isFile((std::string("cooked/") + name).c_str())) << name;
        EXPECT_EQ(contentOf(scene_ / (std::string("mine_") + name)), "mine");
    }
    EXPECT_EQ(contentOf(scene_ / "cooked/sky.ktx2"), texture);
    EXPECT_EQ(run("verify cooked").code, 0);

    // A name of the command line means the file behind the link.
    const std::vector<std::pair<std::string, std::string>> named = {
        {"encode probe.exr link.ktx2 --format bc6h-uf16", "link.ktx2"},
        {"rsrm sky.exr link_sky.ktx2 --exponents 1,8 --json link_sky.json", "link_sky.ktx2"},
        {"decode cooked/sky.ktx2 link.exr", "link.exr"},
        {"reconstruct cooked map link_map.exr", "link_map.exr"},
        {"cook scene.toml -o cooked --depfile link.d --junit link.xml", "link.d"},
        {"cook scene.toml -o cooked --junit link2.xml", "link2.xml"},
        {"plan scene.toml --ninja link.ninja", "link.ninja"},
        {"init map.exr -o link.toml --force", "link.toml"}};
    for (const auto& [command, link] : named) {
        SCOPED_TRACE(command);
        formats::writeContent(scene_ / ("behind_" + link), "old");
        fs::create_symlink("behind_" + link, scene_ / link);
        const Ended ended = run(command);
        EXPECT_EQ(ended.code, 0) << ended.err;
        EXPECT_TRUE(fs::is_symlink(scene_ / link));
        EXPECT_NE(contentOf(scene_ / ("behind_" + link)), "old");
    }
}

TEST_F(CommandLine, AFileThatMayNotGrowIsAnErrorAndLeavesNothing) {
    const std::string limited = "--version >/dev/null; ulimit -f 8; exec '" LIGHTCOOK_PROGRAM "' ";
    for (const char* command : {"encode probe.exr large.ktx2 --format rgba16f", "encode probe.exr large.ktx2 --format rgba16f --zstd"}) {
        SCOPED_TRACE(command);
        const Ended ended = run(limited + command);
        EXPECT_EQ(ended.code, 1) << ended.err;
        EXPECT_THAT(ended.err, StartsWith("lightcook: error: "));
        EXPECT_FALSE(std::filesystem::exists(scene_ / "large.ktx2"));
        for (const auto& entry : std::filesystem::directory_iterator(scene_ / ""))
            EXPECT_THAT(entry.path().filename().string(), Not(StartsWith(".")));
    }
}

TEST_F(CommandLine, ControlCharactersDoNotReachTheTerminal) {
    expectRefused("info \"$(printf 'no\\nwhere\\033[31m.exr')\"", 3, {"no\\nwhere\\x1b[31m.exr: "});
    const std::string name = "map\x1b[31m.exr";
    std::filesystem::copy_file(scene_ / "map.exr", scene_ / name);
    const Ended shown = run("info map.exr \"$(printf 'map\\033[31m.exr')\"");
    EXPECT_EQ(shown.code, 0) << shown.err;
    EXPECT_THAT(shown.out, HasSubstr("map\\x1b[31m.exr:"));
    EXPECT_EQ(shown.out.find('\x1b'), std::string::npos);
    expectRefused("plan scene.toml --ninja scene.ninja --launcher \"$(printf 'a\\nb')\"", 2, {"--launcher: found 'a\\nb', expected "});
    EXPECT_FALSE(std::filesystem::exists(scene_ / "scene.ninja"));
    expectRefused("lut tables --rows 1", 2, {"--rows: found 1, expected 2 to 1024"});
}

/// Settings of charts are checked by a cook before it works; plan and lint say the same beforehand.
TEST_F(CommandLine, PlanAndLintRefuseChartsThatACookRefuses) {
    std::string text = contentOf(scene_ / "scene.toml");
    const std::string output = "[output]\n";
    ASSERT_NE(text.find(output), std::string::npos);
    formats::writeContent(scene_ / "charts.toml", text.insert(text.find(output) + output.size(), "charts_max_visible = 1\n"));
    for (const char* command : {"cook charts.toml -o out", "plan charts.toml --ninja charts.ninja", "lint charts.toml"})
        expectRefused(command, 2, {"found charts_max_visible where no charts are packed"});
    EXPECT_FALSE(std::filesystem::exists(scene_ / "charts.ninja"));
}

TEST_F(CommandLine, ReportFailsWhereTheFolderFailed) {
    EXPECT_EQ(run("cook scene.toml -o out --max-error 1e-7").code, 4);
    const Ended failed = run("report out");
    EXPECT_EQ(failed.code, 4);
    EXPECT_THAT(failed.err, HasSubstr("map, stage "));
    EXPECT_THAT(failed.out, HasSubstr("FAILED"));
    EXPECT_EQ(run("cook scene.toml -o out").code, 0);
    EXPECT_EQ(run("report out").code, 0);
    formats::writeContent(scene_ / "out" / "sky.ktx2", "x");
    const Ended changed = run("report out");
    EXPECT_EQ(changed.code, 4) << "changed since the cook";
    EXPECT_THAT(changed.err, HasSubstr("sky.ktx2"));
}

TEST_F(CommandLine, ABaselineIsComparedAndFailsOnlyWhereAsked) {
    ASSERT_EQ(run("cook scene.toml -o old").code, 0);
    scene_.writeSceneFile("light_map_layout = \"raw\"");
    ASSERT_EQ(run("cook scene.toml -o out").code, 0);
    const Ended compared = run("report out --baseline old/report.json --json report.json --html report.html");
    EXPECT_EQ(compared.code, 0) << "without --fail-over growth is no failure: " << compared.err;
    EXPECT_THAT(compared.out, AllOf(HasSubstr("map                      changed "), HasSubstr(" of 5 assets unchanged")));
    const Json report = Json::parse(contentOf(scene_ / "report.json"));
    const Json& baseline = report.at("baseline");
    EXPECT_GT(baseline.at("growth_percent").get<double>(), 0);
    const Json& map = assetOf(baseline, "map");
    EXPECT_EQ(map.at("before").at("layout"), "ratio");
    EXPECT_LT(map.at("now").at("diffuse_rel_rms").get<double>(), map.at("before").at("diffuse_rel_rms").get<double>());
    EXPECT_THAT(contentOf(scene_ / "report.html"), HasSubstr("\"baseline\":{"));
    const Ended grown = run("report out --baseline old --fail-over 2%");
    EXPECT_EQ(grown.code, 5);
    EXPECT_THAT(grown.err, HasSubstr("expected at most 2 % more"));
    EXPECT_EQ(run("report out --baseline old --fail-over 10000").code, 0);
    EXPECT_EQ(run("report old --baseline out --fail-over 0").code, 0) << "it shrank";
    EXPECT_EQ(run("report out --fail-over 2").code, 2);
}

TEST_F(CommandLine, ABaselineIsOfTheSameSceneAndTarget) {
    ASSERT_EQ(run("cook scene.toml -o out").code, 0);
    ASSERT_EQ(run("cook scene.toml -o float --target float").code, 0);
    const Ended target = run("report out --baseline float --fail-over 1000%");
    EXPECT_EQ(target.code, 3) << target.out;
    EXPECT_THAT(target.err, HasSubstr("found the scene 'small' for target 'float', expected one named 'small' for target 'bc'"));
    std::filesystem::copy_file(scene_ / "out" / "report.json", scene_ / "old.json");
    EXPECT_EQ(run("report float --baseline old.json").code, 0) << "without its manifest a report does not say its target";
}

TEST_F(CommandLine, ABudgetForASceneThatIsNotThereIsAWarning) {
    ASSERT_EQ(run("cook scene.toml -o out").code, 0);
    formats::writeContent(scene_ / "budgets.toml", "schema = 1\n[[platform]]\nname = \"a\"\nscenes = { smal = \"1 KiB\" }\n");
    const Ended ended = run("-q report out --budgets budgets.toml");
    EXPECT_EQ(ended.code, 0);
    EXPECT_EQ(ended.err,
              "lightcook: warning: budgets.toml, scenes: found limits for 'smal' (nearest is 'small'), expected names of cooked scenes: "
              "other limits are not checked\n");
    formats::writeContent(scene_ / "budgets.toml", "schema = 1\n[[platform]]\nname = \"a\"\ntarget = \"astc\"\ntotal = \"1 KiB\"\n");
    const Ended platform = run("-q report out --budgets budgets.toml");
    EXPECT_EQ(platform.code, 0);
    EXPECT_EQ(platform.err,
              "lightcook: warning: budgets.toml, platforms: found limits for 'a' (target astc), expected scenes that were cooked for that "
              "target: other limits are not checked\n");
}

// A report of one scene says "failed" wherever its exit code does, as a report of several scenes.
TEST_F(CommandLine, ASceneOverTheBudgetOfAPlatformDoesNotPass) {
    ASSERT_EQ(run("cook scene.toml -o out").code, 0);
    const auto passes = [&](const char* total) {
        formats::writeContent(scene_ / "budgets.toml", fmt::format("schema = 1\n[[platform]]\nname = \"a\"\ntotal = \"{}\"\n", total));
        const int code = run("-q report out --budgets budgets.toml --json report.json --html report.html").code;
        const bool passed = nlohmann::json::parse(contentOf(scene_ / "report.json")).at("passed").get<bool>();
        EXPECT_EQ(code, passed ? 0 : 5);
        EXPECT_THAT(contentOf(scene_ / "report.html"), HasSubstr(passed ? "small: passed" : "small: failed"));
        return passed;
    };
    EXPECT_TRUE(passes("1 GiB"));
    EXPECT_FALSE(passes("1 KiB"));
}

TEST_F(CommandLine, CompareLooksIntoTheFilesOfCookedFolders) {
    ASSERT_EQ(run("cook scene.toml -o a").code, 0);
    ASSERT_EQ(run("cook scene.toml -o b").code, 0);
    const auto compare = [&] { return nlohmann::json::parse(run("compare a b --json -").out); };
    const nlohmann::json same = compare();
    EXPECT_EQ(same.at("assets").size(), 5u);
    for (const auto& asset : same.at("assets")) EXPECT_TRUE(asset.at("same").get<bool>()) << asset;
    EXPECT_TRUE(same.at("different_files").empty() && same.at("changed_since_cook").empty()) << same;

    std::fstream(scene_ / "b" / "sky.ktx2", std::ios::in | std::ios::out | std::ios::binary).seekp(300).put('x');
    const nlohmann::json changed = compare();
    EXPECT_EQ(changed.at("assets").size(), 5u);
    for (const auto& asset : changed.at("assets")) EXPECT_EQ(asset.at("same").get<bool>(), asset.at("name") != "sky") << asset;
    EXPECT_EQ(changed.at("different_files"), nlohmann::json::array({"sky.ktx2"}));
    ASSERT_EQ(changed.at("changed_since_cook").size(), 1u) << changed;
    EXPECT_THAT(changed.at("changed_since_cook")[0].get<std::string>(), StartsWith("b/sky.ktx2: found content "));
    EXPECT_EQ(changed.at("exit_code"), 4);
    EXPECT_EQ(changed.at("passed"), false);
    for (const char* command : {"compare a b", "compare b a", "compare b b", "compare a b --json -"}) {
        const Ended ended = run(command);
        EXPECT_EQ(ended.code, 4) << command << ": a file is not the one that was cooked";
        EXPECT_THAT(ended.out, HasSubstr("b/sky.ktx2: found content ")) << command;
        EXPECT_THAT(ended.err, StartsWith("lightcook: error: b/sky.ktx2: found content ")) << command;
    }
}

TEST_F(CommandLine, ReconstructAndInfoReportAChangedFile) {
    namespace fs = std::filesystem;
    ASSERT_EQ(run("cook scene.toml -o cooked").code, 0);
    ASSERT_EQ(run("reconstruct cooked map first.exr").code, 0);
    const auto withChange = [&](const std::string& file, const auto& then) {
        SCOPED_TRACE(file);
        const std::string before = contentOf(scene_ / "cooked" / file);
        std::string changed = before;
        if (const std::size_t figure = before.find("\"rel_rms\": "); file == "report.json" && figure != std::string::npos)
            changed[figure + 11] = before[figure + 11] == '9' ? '8' : '9';
        else
            changed[before.size() * 3 / 4] = static_cast<char>(before[before.size() * 3 / 4] ^ 1);
        formats::writeContent(scene_ / "cooked" / file, changed);
        then();
        formats::writeContent(scene_ / "cooked" / file, before);
    };
    std::string texture;
    for (const auto& entry : fs::directory_iterator(scene_ / "cooked")) {
        const std::string name = entry.path().filename();
        if (name.starts_with("map_") && name.ends_with(".ktx2") && name.find("dominant") == std::string::npos) texture = name;
    }
    ASSERT_FALSE(texture.empty());
    withChange(texture, [&] {
        expectRefused("reconstruct cooked map back.exr", 4, {texture + ": found content ", " as cooked"});
        EXPECT_FALSE(fs::exists(scene_ / "back.exr"));
        const Ended info = run("info cooked");
        EXPECT_EQ(info.code, 4);
        EXPECT_THAT(info.err, AllOf(HasSubstr(texture + ": found content "), HasSubstr(" as cooked")));
        EXPECT_THAT(info.out, HasSubstr("scene: small")) << "described all the same";
        const Ended json = run("info cooked --json -");
        EXPECT_EQ(nlohmann::json::parse(json.out).at("exit_code"), 4);
        EXPECT_EQ(nlohmann::json::parse(json.out).at("passed"), false);
    });
    for (const char* other : {"report.json", "sky.ktx2"})
        withChange(other, [&] {
            const Ended info = run("info cooked");
            EXPECT_EQ(info.code, 4);
            EXPECT_THAT(info.err, HasSubstr(std::string(other) + ": found content "));
            EXPECT_EQ(run("reconstruct cooked map back.exr").code, 0) << "which does not read it";
        });
    const std::string manifest = contentOf(scene_ / "cooked/cooked.json");
    std::string changed = manifest;
    changed.replace(changed.find("\"small\""), 7, "\"smell\"");
    formats::writeContent(scene_ / "cooked/cooked.json", changed);
    expectRefused("reconstruct cooked map other.exr", 4, {"cooked.json: found content "});
    EXPECT_EQ(run("info cooked").code, 4);
    formats::writeContent(scene_ / "cooked/cooked.json", manifest);
    EXPECT_EQ(run("info cooked").code, 0);
}

TEST_F(CommandLine, ViewPrintsItsAddressAtOnce) {
    if (viewerBundle().empty()) GTEST_SKIP() << "no viewer in this build";
    ASSERT_EQ(run("cook scene.toml -o out").code, 0);
    for (const char* options : {"--port 0", "--port 0 --json -"}) {
        SCOPED_TRACE(options);
        // Standard output is a file, which no terminal flushes. The server is ended after its address was there, or after 20 s.
        const std::string script = fmt::format(
            "cd '{0}' && rm -f v.txt seen.txt && {{ '{1}' view out {2} >v.txt 2>/dev/null & }} && pid=$! && "
            "for i in $(seq 200); do [ -s v.txt ] && break; sleep 0.1; done; cp v.txt seen.txt; kill $pid; wait $pid; true",
            (scene_ / "").string(), LIGHTCOOK_PROGRAM, options);
        ASSERT_EQ(runShell(script), 0);
        EXPECT_THAT(contentOf(scene_ / "seen.txt"), HasSubstr("http://127.0.0.1:"));
    }
}

TEST_F(CommandLineSoak, ACacheThatCannotBeWrittenIsOneWarning) {
    formats::writeContent(scene_ / "nocache", "a file in place of the folder");
    const Ended ended = run("-q cook scene.toml -o out --cache nocache");
    EXPECT_EQ(ended.code, 0) << ended.err;
    const std::size_t first = ended.err.find("lightcook: warning: nocache: found a cache that cannot be written (nocache/");
    ASSERT_NE(first, std::string::npos) << ended.err;
    EXPECT_EQ(ended.err.find("warning: nocache", first + 20), std::string::npos) << "once: " << ended.err;
    EXPECT_THAT(ended.err, AllOf(HasSubstr("Not a directory"), HasSubstr("nothing is kept")));
    EXPECT_EQ(run("verify out").code, 0);
}

TEST_F(CommandLine, VerifyOfAMovedFolderNamesTheOptionForItsSources) {
    ASSERT_EQ(run("rsrm sky.exr out").code, 0);
    std::filesystem::create_directory(scene_ / "moved");
    std::filesystem::rename(scene_ / "out", scene_ / "moved/out");
    const Ended lost = run("verify moved/out --json lost.json");
    EXPECT_EQ(lost.code, 3);
    EXPECT_THAT(lost.err,
                HasSubstr("sky.exr: found No such file or directory, expected a readable file. Has the scene moved? --sources DIR"));
    EXPECT_THAT(contentOf(scene_ / "lost.json"), HasSubstr("--sources DIR"));
    EXPECT_EQ(run("verify moved/out --sources .").code, 0);
    std::filesystem::remove(scene_ / "moved/out/sky.ktx2");
    EXPECT_THAT(run("verify moved/out --sources .").err, Not(HasSubstr("--sources"))) << "not a source";
}

TEST_F(CommandLineSoak, LightThatTheTexelsCannotHoldIsAWarning) {
    formats::Image<lighting::ShRgb> rows(8, 8);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) rows.at(x, y)[0] = glm::vec3(1e6f * static_cast<float>(8 + x + y));
    auto writer = formats::LightMapWriter::create(scene_ / "bright.exr", 8, 8);
    ASSERT_TRUE(writer && writer->append(rows.view()) && writer->commit());
    const Ended clamped = run("-q lightmap bright.exr bright --layout godot --max-error 1");
    EXPECT_THAT(clamped.err,
                testing::ContainsRegex("warning: bright: found [0-9]+ values of light above 65504, expected none: layout godot "));
    EXPECT_THAT(clamped.err, HasSubstr("light_units"));
    EXPECT_THAT(run("-q lightmap bright.exr ranged --layout raw --max-error 1").err, Not(HasSubstr("65504"))) << "it has a range";
    EXPECT_THAT(run("-q lightmap map.exr dim --layout godot --max-error 1").err, Not(HasSubstr("65504")));
}

TEST_F(CommandLine, VerboseNamesEachActionAndQuietNothing) {
    startWithoutCache();
    const Ended verbose = run("-v cook scene.toml -o out");
    EXPECT_THAT(verbose.err, AllOf(HasSubstr("lightcook: cook/map: "), HasSubstr("lightcook: verify/probe: ")));
    EXPECT_THAT(run("cook scene.toml -o out -v").err, HasSubstr("cook/map: from the cache ("));
    EXPECT_EQ(run("verify out -q").out, "");
    EXPECT_EQ(run("-q report out").out, "");
    EXPECT_EQ(run("-q lightmap map.exr lm").out, "");
    EXPECT_THAT(run("-q info map.exr").out, HasSubstr("sh9")) << "what was asked for";
    EXPECT_EQ(run("-q -v cook scene.toml -o out").code, 2);
    const Ended log = run("--log json cook scene.toml -o out");
    EXPECT_EQ(log.out, "");
    EXPECT_EQ(nlohmann::json::parse(log.err).at("actions_from_cache"), 10);
}

TEST_F(CommandLine, ExplainAndTraceNameEachAction) {
    startWithoutCache();
    run("-q cook scene.toml -o out");
    scene_.writeSceneFile("light_map_layout = \"ratio\"\neffort = 2");
    const Ended again = run("cook scene.toml -o out --explain --trace trace.json");
    EXPECT_THAT(again.err, AllOf(HasSubstr("lightcook: cook/map runs: parameter "), HasSubstr(" -> 2"),
                                 HasSubstr("lightcook: verify/probe does not run: nothing has changed\n")));
    std::map<std::string, std::string> results;
    const auto trace = nlohmann::json::parse(contentOf(scene_ / "trace.json"));
    for (const auto& event : trace.at("traceEvents"))
        results[event.at("name").get<std::string>()] = event.at("args").at("result").get<std::string>();
    EXPECT_EQ(results["cook/map"], "run");
    EXPECT_EQ(results["verify/probe"], "local cache");
    const std::string log = run("--log json cook scene.toml -o out --explain").err;
    const auto line = nlohmann::json::parse(log.substr(0, log.find('\n')));
    EXPECT_EQ(line.at("level"), "explain");
    EXPECT_EQ(line.at("runs"), false);
    EXPECT_EQ(line.at("why"), "nothing has changed");
    // A cache that is not there costs a warning.
    const Ended without = run("cook scene.toml -o out2 --force --remote-cache http://127.0.0.1:1/cache --remote-upload");
    EXPECT_EQ(without.code, 0) << without.err;
    EXPECT_THAT(without.err, HasSubstr("warning: http://127.0.0.1:1/cache: found "));
    EXPECT_THAT(without.out, HasSubstr("remote cache: 0 results read"));
}

TEST_F(CommandLine, TerminalsGetColourAndOneLineOfProgress) {
    if (!isInstalled("script")) GTEST_SKIP() << "no script (util-linux) for a pseudo-terminal";
    startWithoutCache();
    scene_.writeSceneFile("light_map_layout = \"ratio\"");  // all layouts would be tried
    const std::string cook = onTerminal("cook scene.toml -o out");
    EXPECT_THAT(cook, AllOf(HasSubstr("\r\x1b[K["), HasSubstr(" %  "), testing::ContainsRegex("[0-9]+/[0-9]+ ")));
    EXPECT_THAT(cook, HasSubstr("\x1b[32mpassed\x1b[0m: 5 assets"));
    EXPECT_THAT(onTerminal("cook scene.toml -o out", "NO_COLOR=1"), Not(HasSubstr("\x1b[32m")));
    EXPECT_THAT(onTerminal("--color never cook scene.toml -o out"), Not(HasSubstr("\x1b[32m")));
    EXPECT_THAT(onTerminal("cook scene.toml -o out --force", "TERM=dumb"), AllOf(HasSubstr("passed: 5 assets"), Not(HasSubstr("\x1b"))));
    EXPECT_THAT(onTerminal("cook nowhere.toml"), HasSubstr("lightcook: \x1b[31merror:\x1b[0m nowhere.toml"));
    EXPECT_THAT(run("--color always report out").out, HasSubstr("\x1b[32mpassed\x1b[0m"));
    EXPECT_THAT(run("report out").out, AllOf(HasSubstr("passed"), Not(HasSubstr("\x1b["))));
    EXPECT_EQ(onTerminal("-q cook scene.toml -o out").find("passed"), std::string::npos);
}

TEST_F(CommandLine, ErrorsNameWhatAFileHoldsInsteadOfALightMap) {
    expectRefused("encode map.exr x.ktx2 --format rgba16f", 3, {"map.exr: found the layers sh00, sh01, sh02", "`lightcook lightmap`"});
    std::filesystem::create_directory(scene_ / "folder");
    expectRefused("cook folder", 2, {"folder: found a folder, expected a scene file"});
    expectRefused("cook scene.toml --cache='~/cache'", 2, {"--cache: found '~' in the path '~/cache', which only a shell expands"});
    expectRefused("cook 'folder\\scene.toml'", 2, {"scene: found '\\' in the path", "expected '/' between folders: folder/scene.toml"});
    expectRefused("report folder", 3, {"report.json: found no report, expected the output folder of `lightcook cook`"});
    expectRefused("lightmap probe.exr x", 3, {"probe.exr", "it holds R, G, B", "The six faces of a probe?", "bake = \"flat\""});
}

TEST_F(CommandLine, CompareWarnsOfChannelsThatItDoesNotCompare) {
    const formats::Image<glm::vec4> texels(4, 4, glm::vec4(0.5f));
    ASSERT_TRUE(formats::writeExr(scene_ / "rgba.exr", texels.view(), 4));
    ASSERT_TRUE(formats::writeExr(scene_ / "rgb.exr", texels.view(), 3));
    const Ended ended = run("compare rgba.exr rgb.exr -q");
    EXPECT_EQ(ended.code, 0);
    EXPECT_THAT(ended.err, HasSubstr("rgb.exr: found 3 channels, expected 4 as in the reference: only the first 3 are compared"));
    EXPECT_EQ(run("compare rgb.exr rgb.exr").err, "");
    expectRefused("compare rgb.exr rgb.exr --second canonical", 2, {"--second: found canonical beside files that are no light maps"});
}

TEST_F(CommandLine, CompareTakesTwoLightMaps) {
    EXPECT_EQ(run("compare map.exr map.exr --metric visible_p99").out, "0\n");
    EXPECT_THAT(run("compare map.exr map.exr").out, HasSubstr("specular"));
    const Ended refused = run("compare map.exr map.exr --metric rmse");
    EXPECT_EQ(refused.code, 2);
    EXPECT_THAT(refused.err, HasSubstr("warning: map.exr: found no coverage"));
    EXPECT_THAT(refused.err, HasSubstr("--metric: found rmse, which light maps do not have, expected rel_rms or visible_p99"));
    expectRefused("compare map.exr probe.exr", 3, {"probe.exr: found no light map"});
}

TEST_F(CommandLine, CookWritesItsChecksForContinuousIntegration) {
    const Ended cook = run("cook scene.toml -o out --max-error 1e-7 --junit cook.xml --sarif cook.sarif --json cook.json");
    EXPECT_EQ(cook.code, 4);
    EXPECT_THAT(contentOf(scene_ / "cook.xml"), HasSubstr("name=\"diffuse-error\" time=\"0.000\"><failure"));
    const nlohmann::json sarif = nlohmann::json::parse(contentOf(scene_ / "cook.sarif"));
    const nlohmann::json place = sarif.at("runs")[0].at("results")[0].at("locations")[0].at("physicalLocation");
    EXPECT_EQ(place.at("artifactLocation"), nlohmann::json({{"uri", "scene.toml"}, {"uriBaseId", "%SRCROOT%"}}));
    EXPECT_EQ(place.at("region").at("startLine"), 7) << "[[light_map]]";
    EXPECT_EQ(nlohmann::json::parse(contentOf(scene_ / "cook.json")).at("exit_code"), 4);
    scene_.writeSceneFile("efort = 3");
    EXPECT_EQ(run("cook scene.toml -o out --sarif cook.sarif").code, 2);
    const nlohmann::json mistake = nlohmann::json::parse(contentOf(scene_ / "cook.sarif")).at("runs")[0].at("results")[0];
    EXPECT_EQ(mistake.at("ruleId"), "request");
    EXPECT_EQ(mistake.at("locations")[0].at("physicalLocation").at("region").at("startLine"), 5);
}

}  // namespace
}  // namespace lightcook::pipeline
