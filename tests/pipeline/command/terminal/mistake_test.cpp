// The error line of a command line that is refused: the first mistake in the order typed, with the nearest known name.
#include "pipeline/command/terminal/mistake.h"

#include <gmock/gmock.h>

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <algorithm>
#include <sstream>
#include <vector>

#include "pipeline/command/command.h"
#include "pipeline/command/session.h"

namespace lightcook::pipeline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// Returns the error line of arguments that are separated by spaces.
std::string mistakeOf(const std::string& line) {
    std::istringstream words(line);
    std::vector<std::string> arguments;
    for (std::string word; words >> word;) arguments.push_back(word);
    const formats::Error error = firstMistake(arguments, "");
    EXPECT_EQ(error.code, formats::ErrorCode::InvalidRequest);
    return error.line();
}

TEST(Mistake, NamesTheNearestOptionOrCommand) {
    EXPECT_EQ(mistakeOf("cook scene.toml --max-eror 0.1"),
              "command line: found the unknown option '--max-eror', expected an option of cook; nearest is '--max-error'");
    EXPECT_THAT(mistakeOf("cok scene.toml"), AllOf(HasSubstr("the unknown command 'cok'"), HasSubstr("nearest is 'cook'")));
    EXPECT_THAT(mistakeOf("cook scene.toml --efort=3"), HasSubstr("'--efort', expected an option of cook; nearest is '--effort'"));
    EXPECT_THAT(mistakeOf("--quite info a.exr"), HasSubstr("nearest is '--quiet'"));
    EXPECT_THAT(mistakeOf("cook scene.toml --no-such-flag"), AllOf(HasSubstr("'--no-such-flag'"), Not(HasSubstr("nearest"))));
    EXPECT_THAT(mistakeOf("rsrm sky.exr out --layout raw"), HasSubstr("unknown option '--layout'"));
}

TEST(Mistake, IsTheFirstOneThatWasTyped) {
    EXPECT_THAT(mistakeOf("cook --efort 9 --target tin"), HasSubstr("'--efort'"));
    EXPECT_THAT(mistakeOf("cook --target tin --efort 9"), StartsWith("--target: found 'tin'"));
    EXPECT_THAT(mistakeOf("cook --effort 11"), StartsWith("--effort: found '11', expected 0 to 9"));
    EXPECT_THAT(mistakeOf("-j 0 cok"), StartsWith("-j: found '0', expected 1 to 1024"));
    EXPECT_THAT(mistakeOf("cook --effort --efort 9"), StartsWith("--effort: found no value"));
}

TEST(Mistake, SaysWhatAValueMayBe) {
    EXPECT_THAT(mistakeOf("cook scene.toml --target atsc"),
                AllOf(StartsWith("--target: found 'atsc', expected one of: bc, astc, float"), HasSubstr("nearest is 'astc'")));
    EXPECT_THAT(mistakeOf("cook scene.toml --max-error much"),
                StartsWith("--max-error: found 'much', expected a fraction such as 0.02 or 2%"));
    EXPECT_THAT(mistakeOf("cook scene.toml --max-error -2%"), StartsWith("--max-error: found '-2%'"));
    EXPECT_THAT(mistakeOf("cook scene.toml --rdo 150%"), AllOf(StartsWith("--rdo: found '150%'"), HasSubstr("at most 1")));
    EXPECT_THAT(mistakeOf("report out --baseline old --fail-over=lots"), StartsWith("--fail-over: found 'lots', expected a percentage"));
    EXPECT_THAT(mistakeOf("encode a b --format bc7 --weights 1,2,3"), StartsWith("--weights: found too few values, expected R,G,B,A"));
    EXPECT_THAT(mistakeOf("encode a b --format bc7 --effort"), StartsWith("--effort: found no value, expected 0 to 9"));
    EXPECT_EQ(mistakeOf("decode a.ktx2 b.exr --mip x"), "--mip: found 'x', expected a whole number, at least 0");
    EXPECT_EQ(mistakeOf("decode a.ktx2 b.exr --mip 99999999999"),
              "--mip: found '99999999999', expected a whole number, at least 0, at most 2147483647");
    EXPECT_EQ(mistakeOf("decode a.ktx2 b.exr --layer -1"), "--layer: found '-1', expected a whole number, at least 0");
    EXPECT_EQ(mistakeOf("cubemap a b --size 1.5"), "--size: found '1.5', expected a whole number");
    EXPECT_EQ(mistakeOf("repack a b -o c --firefly-limit x"), "--firefly-limit: found 'x', expected a number");
    EXPECT_EQ(mistakeOf("cook scene.toml --max-visible low"), "--max-visible: found 'low', expected a number");
    EXPECT_EQ(mistakeOf("encode a b --format rgb9e5 --metric-scale x"), "--metric-scale: found 'x', expected a number");
}

TEST(Mistake, TakesFilesThatHaveTheNameOfACommand) {
    EXPECT_THAT(mistakeOf("verify demo --samples -1"), StartsWith("--samples: found '-1', expected 0 to 1000000"));
    EXPECT_THAT(mistakeOf("reconstruct out lightmap x.exr --supersample 17"), StartsWith("--supersample: found '17', expected 1 to 16"));
    EXPECT_THAT(mistakeOf("verify out demo"), HasSubstr("found 'demo' after everything that verify takes"));
    EXPECT_THAT(mistakeOf("-q report demo lut --no-such"), HasSubstr("'--no-such', expected an option of report"));
}

TEST(Mistake, AnEmptyValueIsRefused) {
    const auto mistakeOfAll = [](const std::vector<std::string>& arguments) { return firstMistake(arguments, "").line(); };
    EXPECT_EQ(mistakeOfAll({"encode", "", "out.ktx2", "--format", "bc7"}), "command line: found '', expected a path");
    EXPECT_EQ(mistakeOfAll({"cook", "scene.toml", "-o", ""}), "-o: found '', expected a path");
    EXPECT_EQ(mistakeOfAll({"report", "out", ""}), "command line: found '', expected a path");
    EXPECT_EQ(mistakeOfAll({"cook", "scene.toml", "--cache="}), "--cache: found no value, expected FOLDER");
    EXPECT_EQ(mistakeOfAll({"info", ""}), "command line: found '', expected a path");
    EXPECT_EQ(mistakeOfAll({"rsrm", "sky.exr", "out", "--exponents", ""}), "--exponents: found '', expected S,S,...");
    EXPECT_THAT(mistakeOfAll({"cook", "scene.toml", "--max-error", ""}), StartsWith("--max-error: found '', expected a fraction"));
    EXPECT_THAT(mistakeOfAll({"cook", "scene.toml", "--only", ""}), StartsWith("--only: found '', expected "));
    // Every option of every command that takes a value.
    for (const CommandInfo& command : allCommands()) {
        CLI::App app;
        command.define(app);
        for (const CLI::Option* option : app.get_options())
            if (option->get_items_expected_max() > 0 && option->get_name().starts_with("-")) {
                EXPECT_THAT(mistakeOfAll({std::string(command.name), option->get_name(), ""}),
                            StartsWith(option->get_name() + ": found '', expected "));
            }
    }
}

TEST(Mistake, AGlobalOptionWithoutItsValueIsNamed) {
    EXPECT_EQ(mistakeOf("-j"), "-j: found no value, expected 1 to 1024");
    EXPECT_EQ(mistakeOf("--threads"), "--threads: found no value, expected 1 to 1024");
    EXPECT_THAT(mistakeOf("--log"), StartsWith("--log: found no value, expected one of: text, json"));
    EXPECT_THAT(mistakeOf("--color"), StartsWith("--color: found no value, expected one of: auto"));
    EXPECT_THAT(mistakeOf("--instructions"), StartsWith("--instructions: found no value, expected one of: widest"));
    EXPECT_THAT(mistakeOf("--version --log"), StartsWith("--log: found no value"));
    for (const char* line : {"-q -j", "--log json -j", "-h -j", "-qj", "cook scene.toml -j", "-qj cook"})
        EXPECT_THAT(mistakeOf(line), AllOf(StartsWith("-j: found "), HasSubstr(", expected 1 to 1024"))) << line;
    EXPECT_EQ(mistakeOf("-qj0 cook"), "-j: found '0', expected 1 to 1024");
}

TEST(Mistake, NumbersAreFinite) {
    // The texts that an option may take in place of numbers; a new placeholder belongs to one of both lists.
    const std::vector<std::string> texts = {"TEXT", "NAME", "COMMAND", "FILE", "FOLDER", "SPACE"};
    const std::vector<std::string> numbers = {"FLOAT",   "INT",  "UINT",    "NUMBER",   "JND",     "X",     "N",
                                              "R,G,B,A", "SIZE", "PERCENT", "FRACTION", "S,S,...", "X,Y,Z", "LOW,HIGH"};
    int count = 0;
    for (const CommandInfo& command : allCommands()) {
        CLI::App app;
        command.define(app);
        for (const CLI::Option* option : app.get_options()) {
            if (option->get_items_expected_max() == 0 || !option->get_name().starts_with("-")) continue;
            const std::string type = option->get_type_name(), placeholder = type.substr(0, type.find(':'));
            if (std::ranges::find(texts, placeholder) != texts.end()) continue;
            EXPECT_THAT(numbers, testing::Contains(placeholder)) << command.name << " " << option->get_name();
            // The option gets as many values as it takes.
            std::string values = "nan";
            for (int i = 1; i < option->get_items_expected_min(); ++i) values += ",nan";
            EXPECT_THAT(mistakeOf(fmt::format("{} {} {}", command.name, option->get_name(), values)),
                        StartsWith(option->get_name() + ": found 'nan"));
            ++count;
        }
    }
    EXPECT_GT(count, 40);
    EXPECT_EQ(mistakeOf("cubemap p.exr sh.json --filter sh --wrap nan"), "--wrap: found 'nan', expected a finite number");
    EXPECT_EQ(mistakeOf("repack a b -o c --firefly-limit inf"), "--firefly-limit: found 'inf', expected a finite number");
    EXPECT_EQ(mistakeOf("repack a b -o c --firefly-limit=-nan"), "--firefly-limit: found '-nan', expected a finite number");
    EXPECT_EQ(mistakeOf("repack a b -o c --firefly-limit 1e999"), "--firefly-limit: found '1e999', expected a finite number");
}

TEST(Mistake, NumbersAreDecimal) {
    EXPECT_EQ(mistakeOf("cook a.toml --max-visible 0x10"), "--max-visible: found '0x10', expected a number in decimal digits");
    EXPECT_EQ(mistakeOf("cook a.toml --max-visible +0.02"), "--max-visible: found '+0.02', expected a number in decimal digits");
    EXPECT_EQ(mistakeOf("cook a.toml --effort 0x3"), "--effort: found '0x3', expected a number in decimal digits");
    EXPECT_EQ(mistakeOf("cook a.toml --effort=+3"), "--effort: found '+3', expected a number in decimal digits");
    EXPECT_EQ(mistakeOf("lut out --m 0.3,+0.4"), "--m: found '+0.4', expected a number in decimal digits");
    EXPECT_THAT(mistakeOf("cook a.toml --max-error 0x10"), StartsWith("--max-error: found '0x10', expected a fraction"));
    EXPECT_THAT(mistakeOf("cook a.toml --max-error +0.02"), StartsWith("--max-error: found '+0.02', expected a fraction"));
}

/// Parses a command line without its own checks of files.
GlobalOptions globalOptionsOf(const std::vector<const char*>& arguments) {
    GlobalOptions global;
    std::vector<const char*> all = {"lightcook"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    parseCommandLine(static_cast<int>(all.size()), all.data(), global);
    return global;
}

TEST(ParseCommandLine, ZerosAtTheFrontOfANumberMeanNothing) {
    for (const char* ten : {"10", "010", "00010"}) EXPECT_EQ(globalOptionsOf({"-j", ten, "help"}).threads, 10) << ten;
    EXPECT_EQ(globalOptionsOf({"-j08", "help"}).threads, 8);
    EXPECT_EQ(mistakeOf("cook a.toml --effort -01"), "--effort: found '-01', expected 0 to 9");
    EXPECT_EQ(mistakeOf("cook a.toml --effort 0010"), "--effort: found '0010', expected 0 to 9");
    EXPECT_EQ(mistakeOf("cook a.toml --effort 00x3"), "--effort: found '00x3', expected a number in decimal digits");
}

TEST(ParseCommandLine, AMistakeIsReportedInTheFormatThatIsAskedForBehindIt) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(globalOptionsOf({"--no-such-option", "--log=json", "help"}).log, "json");
    EXPECT_EQ(globalOptionsOf({"--no-such-option", "--log", "json", "help"}).log, "json");
    EXPECT_THAT(testing::internal::GetCapturedStderr(), Not(HasSubstr("lightcook: error")));
}

TEST(Mistake, SaysThatAnOptionWasGivenTwice) {
    EXPECT_EQ(mistakeOf("-j 1 -j 2 cook scene.toml"), "-j: found this option 2 times, expected it once");
    EXPECT_EQ(mistakeOf("cook scene.toml -o a --output b"), "--output: found this option 2 times, expected it once");
    EXPECT_EQ(mistakeOf("cook scene.toml --only a --only b"), "--only: found this option 2 times, expected it once");
    EXPECT_EQ(mistakeOf("lut out --m 0.3,0.4,0.5"), "--m: found 3 values, expected LOW,HIGH");
    EXPECT_EQ(mistakeOf("lut out --m 0.3"), "--m: found too few values, expected LOW,HIGH");
}

TEST(Mistake, IsOneLineWhateverItNames) {
    const formats::Error error = firstMistake(std::vector<std::string>{"co\nok\t\x1b[31m\x7f\xc3\xa9"}, "");
    EXPECT_THAT(error.line(), HasSubstr("'co\\nok\\t\\x1b[31m\\x7f\xc3\xa9'"));
}

TEST(Mistake, SaysWhichOptionsGoTogether) {
    const auto firstLine = [](std::vector<const char*> arguments) {
        GlobalOptions global;
        arguments.insert(arguments.begin(), "lightcook");
        testing::internal::CaptureStderr();
        EXPECT_EQ(parseCommandLine(static_cast<int>(arguments.size()), arguments.data(), global).exitCode, 2);
        return testing::internal::GetCapturedStderr();
    };
    EXPECT_THAT(firstLine({"report", "out", "--fail-over", "5"}),
                HasSubstr("--fail-over: found no --baseline, expected it beside this option"));
    EXPECT_THAT(firstLine({"plan", "scene.toml"}),
                HasSubstr("command line: found no --ninja, expected `lightcook plan scene [options]`: "));
}

TEST(Mistake, SaysWhatIsMissingLast) {
    EXPECT_THAT(mistakeOf(""), AllOf(HasSubstr("found no command"), HasSubstr("cook, init, lint, verify, report")));
    GlobalOptions global;
    const char* const arguments[] = {"lightcook", "cook"};
    testing::internal::CaptureStderr();
    EXPECT_EQ(parseCommandLine(2, arguments, global).exitCode, 2);
    EXPECT_THAT(testing::internal::GetCapturedStderr(),
                HasSubstr("command line: found no scene, expected `lightcook cook scene [options]`: The scene file (scene.toml)"));
    EXPECT_THAT(mistakeOf("verify a b"), HasSubstr("found 'b' after everything that verify takes"));
}

}  // namespace
}  // namespace lightcook::pipeline
