// The error line of a command line that is refused, and numbers as options take them.
#include "pipeline/command/command.h"

#include <gmock/gmock.h>

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <algorithm>
#include <sstream>
#include <vector>

#include "pipeline/command/session.h"

namespace lightcook::pipeline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// Returns the text that the program prints for a command line that it refuses.
std::string refusalOf(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "lightcook");
    std::vector<const char*> argv;
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    GlobalOptions global;
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    EXPECT_EQ(parseCommandLine(static_cast<int>(argv.size()), argv.data(), global).exitCode, 2);
    (void)testing::internal::GetCapturedStdout();
    return testing::internal::GetCapturedStderr();
}

/// The same for arguments that are separated by spaces.
std::string refusalOf(const std::string& line) {
    std::istringstream words(line);
    std::vector<std::string> arguments;
    for (std::string word; words >> word;) arguments.push_back(word);
    return refusalOf(arguments);
}

TEST(ParseCommandLine, NamesTheNearestOptionOrCommand) {
    EXPECT_EQ(refusalOf("cook scene.toml --max-eror 0.1"),
              "lightcook: error: command line: found the unknown option '--max-eror', expected an option of cook; nearest is "
              "'--max-error'\n");
    EXPECT_THAT(refusalOf("cok scene.toml"), AllOf(HasSubstr("the unknown command 'cok'"), HasSubstr("nearest is 'cook'")));
    EXPECT_THAT(refusalOf("cook scene.toml --efort=3"), HasSubstr("'--efort', expected an option of cook; nearest is '--effort'"));
    EXPECT_THAT(refusalOf("cook scene.toml --light-map-layout sh4"),
                HasSubstr("'--light-map-layout', expected an option of cook; nearest is '--layout'"))
        << "the key of the scene file";
    EXPECT_THAT(refusalOf("--cache x cook scene.toml"), HasSubstr("found '--cache' before 'cook', expected it after the command"));
    EXPECT_THAT(refusalOf("--quite info a.exr"), HasSubstr("'--quite', expected an option of info; nearest is '--quiet'"));
    EXPECT_THAT(refusalOf("cook scene.toml --no-such-flag"), AllOf(HasSubstr("'--no-such-flag'"), Not(HasSubstr("nearest"))));
    EXPECT_THAT(refusalOf("verify out demo"), HasSubstr("command line: found 'demo', expected no further argument of verify"));
}

TEST(ParseCommandLine, NamesTheOptionOfAValue) {
    EXPECT_THAT(refusalOf("cook scene.toml --target atsc"),
                HasSubstr("error: --target: found 'atsc', expected one of: bc, astc, float; nearest is 'astc'"));
    EXPECT_THAT(refusalOf("cook scene.toml --effort 11"), HasSubstr("error: --effort: found '11', expected an integer from 0 to 9"));
    EXPECT_THAT(refusalOf("verify demo --samples -1"), HasSubstr("error: --samples: found '-1', expected 0 to 1000000"));
    EXPECT_THAT(refusalOf("cook scene.toml --max-error much"), HasSubstr("error: --max-error: found 'much', expected a positive fraction"));
    EXPECT_THAT(refusalOf("cook scene.toml --rdo 150%"), AllOf(HasSubstr("error: --rdo: found '150%'"), HasSubstr("from 0 to 1")));
    EXPECT_THAT(refusalOf("encode a b --format bc7 --effort"), HasSubstr("error: --effort: found no value, expected 0 to 9"));
    EXPECT_THAT(refusalOf("cook scene.toml --only a --only b"), HasSubstr("error: --only: At Most 1 required but received 2"));
    EXPECT_THAT(refusalOf("lut out --m 0.3"), HasSubstr("--m: "));
    EXPECT_THAT(refusalOf("-j"), HasSubstr("error: --threads: found no value, expected 1 to 1024"));
}

TEST(ParseCommandLine, SaysWhatIsMissing) {
    EXPECT_THAT(refusalOf(""), HasSubstr("command line: A subcommand is required"));
    EXPECT_THAT(refusalOf("cook"), HasSubstr("command line: scene is required"));
    EXPECT_THAT(refusalOf("report out --fail-over 5"), HasSubstr("--fail-over requires --baseline"));
    EXPECT_THAT(refusalOf("plan scene.toml"), HasSubstr("--ninja is required"));
}

/// Every option of every command that takes a value: an empty one is that of a script's variable that is not set.
TEST(ParseCommandLine, AnEmptyValueIsRefused) {
    for (const CommandInfo& command : allCommands()) {
        CLI::App app;
        command.define(app);
        for (const CLI::Option* option : app.get_options())
            if (option->get_items_expected_max() > 0 && option->get_name().starts_with("-")) {
                EXPECT_THAT(refusalOf(std::vector<std::string>{std::string(command.name), option->get_name(), ""}),
                            HasSubstr(option->get_name() + ": found '', expected "));
            }
    }
    EXPECT_THAT(refusalOf(std::vector<std::string>{"info", ""}), HasSubstr("found '', expected a value"));
}

TEST(ParseCommandLine, NumbersAreFiniteAndDecimal) {
    // The texts that an option may take in place of numbers; a new placeholder belongs to one of both lists.
    const std::vector<std::string> texts = {"TEXT", "NAME", "COMMAND", "URL", "SPACE", "FILE", "FOLDER", "NAME,..."};
    const std::vector<std::string> numbers = {"FLOAT",   "INT",  "UINT",    "NUMBER",   "JND",     "X",       "N",
                                              "R,G,B,A", "SIZE", "PERCENT", "FRACTION", "N,N,...", "LOW,HIGH"};
    int count = 0;
    for (const CommandInfo& command : allCommands()) {
        CLI::App app;
        command.define(app);
        for (const CLI::Option* option : app.get_options()) {
            if (option->get_items_expected_max() == 0 || !option->get_name().starts_with("-")) continue;
            const std::string type = option->get_type_name(), placeholder = type.substr(0, type.find(':'));
            if (std::ranges::find(texts, placeholder) != texts.end()) continue;
            EXPECT_THAT(numbers, testing::Contains(placeholder)) << command.name << " " << option->get_name();
            if (placeholder == "SIZE") continue;  // read by the command, in the words of a scene file
            for (const char* bad : {"nan", "inf", "1e999", "0x10", "+2", "1_000"}) {
                // The option gets as many values as it takes.
                std::string values = bad;
                for (int i = 1; i < option->get_items_expected_min(); ++i) values += fmt::format(",{}", bad);
                EXPECT_THAT(refusalOf(fmt::format("{} {}={}", command.name, option->get_name(), values)),
                            HasSubstr(fmt::format("{}: found '{}', expected ", option->get_name(), bad)));
            }
            ++count;
        }
    }
    EXPECT_GT(count, 40);
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
}

TEST(ParseCommandLine, AMistakeIsReportedInTheFormatThatIsAskedForBehindIt) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(globalOptionsOf({"--no-such-option", "--log=json", "help"}).log, "json");
    EXPECT_EQ(globalOptionsOf({"--no-such-option", "--log", "json", "help"}).log, "json");
    EXPECT_THAT(testing::internal::GetCapturedStderr(), Not(HasSubstr("lightcook: error")));
}

TEST(ParseCommandLine, IsOneLineWhateverItNames) {
    EXPECT_THAT(refusalOf(std::vector<std::string>{"co\nok\t\x1b[31m\x7f\xc3\xa9"}), HasSubstr("'co\\nok\\t\\x1b[31m\\x7f\xc3\xa9'"));
}

}  // namespace
}  // namespace lightcook::pipeline
