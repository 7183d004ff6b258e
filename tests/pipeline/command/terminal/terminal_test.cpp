// Lines of a command: names with control characters, and colours.
#include "pipeline/command/terminal/terminal.h"

#include <gmock/gmock.h>

#include <sstream>

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

ReportRow rowOf(const std::string& name, AssetKind kind, const std::string& layout, std::uint64_t bytes) {
    ReportRow row;
    row.name = name;
    row.kind = kind;
    row.layout = layout;
    row.bytesIn = 27 << 20;
    row.bytesGpu = bytes;
    verify::StageError stage;
    stage.name = "total";
    stage.diffuse.relRms = stage.specular.relRms = 0.0138;
    stage.specular.visible.emplace().p99 = 4.387;
    row.verdict = makeVerdict({stage}, {{Limit::Error, 0.02}, {Limit::Visible, 5}});
    return row;
}

std::string tableOf(const std::vector<ReportRow>& rows) {
    Terminal terminal(with(ColorChoice::Never));
    return outputOf([&] { printReport(terminal, makeReport({"scene", 1.5, 0, std::nullopt}, rows, {})); });
}

TEST(PrintReport, SaysBytesOfBakeAndAssetAndTheErrorNearestToItsLimit) {
    EXPECT_EQ(tableOf({rowOf("hall", AssetKind::LightMap, "basis-4", 146432), rowOf("sky", AssetKind::Rsrm, "rsrm", 300)}),
              "asset  kind       layout   bake -> GPU, MiB  error of its limit  verdict\n"
              "hall   light-map  basis-4  27.0 ->    0.140  visible 4.39 of 5   passed\n"
              "sky    rsrm       rsrm     27.0 ->   <0.001  visible 4.39 of 5   passed\n"
              "143.29 KiB of GPU memory, 1.50 s, 0 MiB resident at most\n");
}

TEST(PrintReport, SaysTheVisibleErrorWhereNoLimitWasAskedFor) {
    ReportRow row = rowOf("hall", AssetKind::LightMap, "basis-4", 146432);
    row.verdict.limits = {{Limit::Error, kNoErrorLimit}};
    EXPECT_THAT(tableOf({row}), testing::HasSubstr("  visible 4.39        passed\n"));
}

TEST(PrintReport, HasAHundredColumnsAtMost) {
    const std::string name(40, 'x');
    const std::string table = tableOf({rowOf(name, AssetKind::Dominant, "direction-intensity", 196608)});
    EXPECT_THAT(table, testing::HasSubstr("\n" + name + "\n  dominant  direction-intensity"));
    std::istringstream lines(table);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
}

TEST(PrintReport, NamesASeamThatShowsWhereNoLimitHoldsIt) {
    const auto verdictWith = [](double step, std::optional<double> limit) {
        ReportRow row = rowOf("hall", AssetKind::LightMap, "basis-4", 146432);
        row.verdict.limits[Limit::Seam] = limit;
        row.seams.emplace().stages = {{"total", {{1, step}, {1, step}}, {}}};
        const std::string table = tableOf({row});
        const std::size_t at = table.find("passed");
        return table.substr(at, table.find('\n', at) - at);
    };
    EXPECT_EQ(verdictWith(8.12, {}), "passed, seam 8.1");
    EXPECT_EQ(verdictWith(4.9, {}), "passed");
    EXPECT_EQ(verdictWith(8.12, 10), "passed") << "a limit says what is bad";
}

}  // namespace
}  // namespace lightcook::pipeline
