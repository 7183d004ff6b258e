// Lines of a command: names with control characters, and colours.
#include "pipeline/command/terminal/terminal.h"

#include <gmock/gmock.h>

#include "pipeline/command/terminal/printing.h"

namespace lightcook::pipeline {
namespace {

TerminalOptions with(ColorChoice color) {
    return {LogFormat::Text, Verbosity::Normal, color};
}

/// Returns what is printed on standard output.
template <class Print>
std::string outputOf(Print print) {
    testing::internal::CaptureStdout();
    print();
    return testing::internal::GetCapturedStdout();
}

TEST(Terminal, SaysNamesWithoutTheirControlCharacters) {
    Terminal terminal(with(ColorChoice::Always));
    EXPECT_EQ(outputOf([&] { terminal.say("lob\nby\x1b[31m: caf\xc3\xa9"); }), "lob\\nby\\x1b[31m: caf\xc3\xa9\n");
    EXPECT_EQ(outputOf([&] { printJson(terminal, Json{{"a\tb", "c\rd"}}); }), "a\\tb: c\\rd\n");
}

TEST(PrintJson, SaysFiguresWithSixDigitsAndNothingAsNone) {
    Terminal terminal(with(ColorChoice::Never));
    const Json facts = {{"bytes", 123456789}, {"error", {{"rel_rms", 0.009685650025458209}}}, {"assumed", Json::array()}, {"ok", true}};
    EXPECT_EQ(outputOf([&] { printJson(terminal, facts); }), "bytes: 123456789\nerror:\n  rel_rms: 0.00968565\nassumed: none\nok: true\n");
}

TEST(Terminal, DetailsHaveNoControlCharactersEither) {
    Terminal terminal(with(ColorChoice::Never));
    testing::internal::CaptureStderr();
    terminal.detail("lightcook: cook/lob\x1b[2Jby: 1 s");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "lightcook: cook/lob\\x1b[2Jby: 1 s\n");
}

TEST(Terminal, ColoursThePiecesOfALine) {
    const StyledLine line = {{Style::Good, "passed\x1b[0m"}, {Style::Plain, ": a\x1b[31m"}};
    Terminal colored(with(ColorChoice::Always)), plain(with(ColorChoice::Never));
    EXPECT_EQ(outputOf([&] { colored.say(line); }), "\x1b[32mpassed\\x1b[0m\x1b[0m: a\\x1b[31m\n");
    EXPECT_EQ(outputOf([&] { plain.say(line); }), "passed\\x1b[0m: a\\x1b[31m\n");
}

}  // namespace
}  // namespace lightcook::pipeline
