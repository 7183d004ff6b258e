// The program and the one that decodes files for it: what a user sees of a file that harms its decoder.
#include "tests/end_to_end/command_fixture.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Reader : public Command {
protected:
    void SetUp() override {
        fs::create_directories(scene_ / "bin");
        fs::copy_file(LIGHTCOOK_PROGRAM, program_);
    }
    void takeReader(const fs::path& reader) const {
        fs::copy_file(reader, scene_ / "bin/lightcook-read", fs::copy_options::overwrite_existing);
    }
    /// Adds a light map at whose file the bad reader does something.
    void addMap(const std::string& order) const {
        formats::writeContent(scene_ / "bad.exr", std::string("\x76\x2f\x31\x01\x02\0\0\0", 8) + order);
        formats::writeContent(scene_.sceneFile(),
                              formats::contentOf(scene_.sceneFile()) + "\n[[light_map]]\nname = \"bad\"\nfile = \"bad.exr\"\n");
    }

    const fs::path program_ = scene_ / "bin/lightcook";
};

TEST_F(Reader, CrashIsOneLineAndTheOtherAssetsAreCooked) {
    takeReader(LIGHTCOOK_BAD_READER);
    addMap("crash");
    const std::string line =
        "lightcook: error: bad.exr: found content on which its reader crashed (SIGSEGV), expected one that it can read";
    const Ended stopped = run("cook scene.toml -o out", program_);
    EXPECT_EQ(stopped.code, 3) << stopped.err;
    EXPECT_THAT(stopped.err, HasSubstr(line));
    EXPECT_FALSE(fs::exists(scene_ / "out"));
    const Ended ended = run("cook scene.toml -o out --keep-going --json out.json", program_);
    EXPECT_EQ(ended.code, 3) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(line));
    const Json report = Json::parse(formats::contentOf(scene_ / "out.json"));
    EXPECT_EQ(report["incomplete"]["assets"], Json::array({"bad"}));
    EXPECT_EQ(report["errors"][0]["file"], "bad.exr");
    std::vector<std::string> cooked;
    for (const Json& row : report["assets"]) cooked.push_back(row["name"]);
    EXPECT_THAT(cooked, testing::IsSupersetOf({"map", "probe", "sky"}));
}

TEST_F(Reader, IsFoundBesideTheProgramOrNotNeeded) {
    const Ended missing = run("info probe.exr", program_);
    EXPECT_EQ(missing.code, 1);
    EXPECT_THAT(missing.err, HasSubstr("bin/lightcook-read: found \"No such file or directory\", expected the program that reads images"));
    EXPECT_EQ(run("--no-sandbox info probe.exr", program_).code, 0);
    takeReader(LIGHTCOOK_PROGRAM "-read");
    EXPECT_EQ(run("info probe.exr", program_).code, 0);
}

TEST_F(Reader, ReportNamesTheWalls) {
    startWithoutCache();
    const auto wallsOf = [&](const std::string& option) {
        EXPECT_LE(run(option + "cook scene.toml -o out --force --only map").code, 4);
        return Json::parse(formats::contentOf(scene_ / "out/report.json"))["runs"].back()["walls"];
    };
    EXPECT_EQ(wallsOf("").at(0), "process");
    EXPECT_EQ(wallsOf("--no-sandbox "), Json::array({"none"}));
}

}  // namespace
}  // namespace lightcook::pipeline
