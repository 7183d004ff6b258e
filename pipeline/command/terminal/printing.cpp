#include "pipeline/command/terminal/printing.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "pipeline/assets/light_map/detailed_layout.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/command/remote.h"
#include "pipeline/report/limit_use.h"
#include "pipeline/report/words.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

std::string percent(double value) {
    constexpr double kWidest = 10000;  // in fixed notation
    if (!std::isfinite(value)) return "     not finite";
    return std::abs(100 * value) < kWidest ? fmt::format("{:8.3f} %", 100 * value) : fmt::format("{:8.1e} %", 100 * value);
}

/// Stands in place of a rel_rms of light that an asset or a scene does not have, as wide as percent().
constexpr const char* kNoRelRms = "         -";

/// Returns the 99th percentile of the visible errors; a dash for assets without them.
std::string visibleWord(const std::optional<double>& p99) {
    return p99 ? fmt::format("{:.2f}", *p99) : "-";
}

/// Returns a size in MiB with three digits: "27.0", "0.139", "<0.001".
std::string mebibytes(std::uint64_t bytes) {
    const double value = static_cast<double>(bytes) / 0x1p20;
    if (bytes > 0 && value < 0.0005) return "<0.001";
    // The limits are the values from which rounding carries into the next decade.
    return fmt::format("{:.{}f}", value, value >= 99.95 ? 0 : value >= 9.995 ? 1 : value >= 0.9995 ? 2 : 3);
}

/// Returns the error of a stage without a limit: its visible error, or rel_rms of an asset that has none.
std::string errorWords(const verify::StageError& stage) {
    if (const auto p99 = visibleP99(stage)) return fmt::format("visible {:.2f}", *p99);
    return "error " + humanPercent(std::max(stage.diffuse.relRms, stage.specular.relRms));
}

/// Returns a line for the mip levels of a light map: their number, why there are no more, and the one with the largest visible error.
std::string mipLine(const ReportRow& row) {
    std::string line = fmt::format("  {}: {}", row.name, counted(row.mips.size() + 1, "mip level"));
    if (row.mipsEnd) line += fmt::format(" ({})", *row.mipsEnd);
    const verify::StageError* worst = nullptr;
    for (const auto* levels : {&row.mips, &row.mipBlends})
        for (const verify::StageError& each : *levels)
            if (worst == nullptr || visibleP99(each) > visibleP99(*worst)) worst = &each;
    return worst == nullptr ? line : line + fmt::format("; the worst is {}: {}", worst->name, errorWords(*worst));
}

StyledText verdictWord(bool passed) {
    return passed ? StyledText{Style::Good, "passed"} : StyledText{Style::Bad, "FAILED"};
}

/// Returns words on the largest step at the edges of charts, if it shows and no limit counts it. Empty: there is none.
std::string seamWords(const ReportRow& row) {
    if (row.verdict.limits[Limit::Seam] || !row.seams || row.seams->stages.empty()) return "";
    const double step = row.seams->largestAdded();
    return step > row.verdict.limits[Limit::Visible].value_or(kDefaultMaxVisible) ? fmt::format(", seam {:.1f}", step) : "";
}

/// Returns ", diffuse 1.20 % -> 1.31 %"; a report that does not have the asset or the light shows as a dash. Empty if neither has it.
std::string changeOf(const AssetChange& asset, const char* name, std::optional<double> AssetFigures::*figure, double unit,
                     const char* unitName) {
    const auto valueOf = [&](const std::optional<AssetFigures>& figures) { return figures ? (*figures).*figure : std::nullopt; };
    const auto words = [&](const std::optional<double>& value) {
        if (!value) return std::string("-");
        return std::isfinite(*value) ? fmt::format("{:.3f}{}", *value / unit, unitName) : std::string("not finite");
    };
    const std::optional<double> before = valueOf(asset.before), now = valueOf(asset.now);
    return before || now ? fmt::format(", {} {} -> {}", name, words(before), words(now)) : "";
}

/// Prints a table of assets: bytes of bake and cooked asset, the error that uses most of its limit, the verdict. It has 100 columns at
/// most: names that leave no room have a line of their own.
void printAssets(Terminal& terminal, const std::vector<ReportRow>& rows) {
    enum Column { Name, Kind, Layout, Bake, Gpu, Error, Judged, ColumnCount };
    constexpr std::size_t kMostColumns = 100, kGap = 2, kArrow = 4;
    std::vector<std::array<std::string, ColumnCount>> table = {
        {"asset", "kind", "layout", "bake", "GPU, MiB", "error of its limit", "verdict"}};
    for (const ReportRow& row : rows) {
        const auto use = mostUsedLimit(row);
        table.push_back({row.name, std::string(info(row.kind).name), DetailedLayout::ofName(row.triedLayout()).words(),
                         row.bytesIn > 0 ? mebibytes(row.bytesIn) : "-", mebibytes(row.bytesGpu),
                         use ? use->brief : errorWords(row.verdict.stages.back()), verdictWord(row.verdict.passed).text + seamWords(row)});
    }
    std::array<std::size_t, ColumnCount> widths{};
    for (const auto& cells : table)
        for (std::size_t i = 0; i < ColumnCount; ++i) widths[i] = std::max(widths[i], cells[i].size());
    const bool isNamedAbove = std::accumulate(widths.begin(), widths.end(), kArrow + 5 * kGap) > kMostColumns;
    if (isNamedAbove) widths[Name] = 0;
    for (std::size_t i = 0; i < table.size(); ++i) {
        const auto& cells = table[i];
        const ReportRow* const row = i > 0 ? &rows[i - 1] : nullptr;
        if (isNamedAbove) terminal.say(StyledLine{{row == nullptr ? Style::Faint : Style::Plain, cells[Name]}});
        const std::string line = fmt::format("{:{}}  {:{}}  {:{}}  {:>{}} -> {:>{}}  {:{}}  ", isNamedAbove ? "" : cells[Name],
                                             widths[Name], cells[Kind], widths[Kind], cells[Layout], widths[Layout], cells[Bake],
                                             widths[Bake], cells[Gpu], widths[Gpu], cells[Error], widths[Error]);
        if (row == nullptr) {
            terminal.say(StyledLine{{Style::Faint, line + cells[Judged]}});
            continue;
        }
        terminal.say(StyledLine{{Style::Plain, line}, verdictWord(row->verdict.passed), {Style::Warning, seamWords(*row)}});
        if (row->mipsEnd) terminal.say(mipLine(*row));
    }
    if (std::ranges::any_of(rows, [](const ReportRow& row) { return !seamWords(row).empty(); }))
        terminal.say(StyledLine{{Style::Faint, "seam: cooking adds a step that shows where two charts meet, and no max_seam limits it"}});
}

/// Returns a line that names what a folder lacks of its scene.
std::string partialLine(const std::string& scene, const std::vector<std::string>& partial) {
    return fmt::format("not the whole scene {}: --only left out {}", scene, fmt::join(partial, ", "));
}

/// Says what the next smaller and the next larger scene would be.
void printFrontier(Terminal& terminal, const std::vector<FrontierPoint>& frontier) {
    const auto chosen = std::ranges::find(frontier, true, &FrontierPoint::isChosen);
    if (chosen == frontier.end()) return;
    const auto say = [&](const char* name, const FrontierPoint& point) {
        terminal.say(fmt::format("{}: {}, visible error {:.2f} ({})", name, sizeWords(point.bytesGpu), point.visible, layoutWords(point)));
    };
    if (chosen != frontier.begin()) say("next smaller scene", *(chosen - 1));
    say("chosen", *chosen);
    if (chosen + 1 != frontier.end()) say("next better scene", *(chosen + 1));
}

/// Returns ", at most 2 % allowed"; empty where any growth passes.
std::string allowedWords(const std::optional<double>& allowedPercent) {
    return allowedPercent ? fmt::format(", at most {} % allowed", *allowedPercent) : "";
}

}  // namespace

void printSummary(Terminal& terminal, const Report& report, const Outcome& outcome) {
    std::uint64_t disk = 0;
    std::size_t failed = 0;
    for (const ReportRow& row : report.assets) {
        disk += row.bytesDisk;
        failed += row.verdict.passed ? 0 : 1;
    }
    const int actions = outcome.actionsRun + outcome.actionsReused;
    const bool passed = outcome.errors.empty() && report.passed;
    if (terminal.format() == LogFormat::JsonLines) {
        Json summary = {{"level", "summary"},
                        {"passed", passed},
                        {"assets", report.assets.size()},
                        {"assets_failed", failed},
                        {"partial", report.partial},
                        {"bytes_gpu", report.budget.usedBytes},
                        {"bytes_disk", disk},
                        {"actions", actions},
                        {"actions_from_cache", outcome.actionsReused},
                        {"output", outcome.output.string()}};
        if (outcome.remote) summary["remote_cache"] = jsonOf(*outcome.remote);
        return terminal.jsonDetail(summary.dump(-1, ' ', false, Json::error_handler_t::replace));
    }
    printFrontier(terminal, report.budget.frontier);
    for (const ReportRow& row : report.assets)
        if (row.notes && row.notes->contains(note_keys::kPacking))
            terminal.say(fmt::format("charts of {} packed anew: {}", row.name, (*row.notes)[note_keys::kPacking].get<std::string>()));
    // On a terminal the table has said it.
    if (!report.partial.empty() && !terminal.isInteractive()) terminal.say(partialLine(report.scene, report.partial));
    if (!outcome.candidates.empty()) terminal.say(fmt::format("candidates kept for view: {}", fmt::join(outcome.candidates, ", ")));
    if (outcome.remote) terminal.say(lineOf(*outcome.remote));
    const std::string all = counted(report.assets.size(), "asset");
    // A scene may fail as a whole where each asset passed.
    const std::string assets = failed > 0 ? fmt::format("{} of {}", failed, all)
                               : passed   ? all
                                          : fmt::format("{}{} passed", report.budget.isKept() ? "" : "over the budget, ", all);
    const std::string without = report.partial.empty() ? "" : fmt::format(" (without {} of the scene)", report.partial.size());
    // Both sizes are in the unit of the smaller one.
    const std::uint64_t used = report.budget.usedBytes, limit = report.budget.limitBytes.value_or(used), unit = std::min(used, limit);
    const std::string budget = report.budget.limitBytes ? fmt::format(" of {}", sizeWords(limit, unit)) : "";
    terminal.say(StyledLine{verdictWord(passed),
                            {Style::Plain, fmt::format(": {}{}, {}{} of GPU memory, {} on disk, {} of {} actions from the cache: {}",
                                                       assets, without, sizeWords(used, unit), budget, sizeWords(disk),
                                                       outcome.actionsReused, actions, outcome.output.string())}});
}

void printComparison(Terminal& terminal, const BaselineComparison& comparison) {
    std::size_t same = 0;
    for (const AssetChange& asset : comparison.assets) {
        if (asset.change == "same") {
            ++same;
            continue;
        }
        const auto bytes = [](const std::optional<AssetFigures>& figures) {
            return figures ? sizeWords(figures->bytesGpu) : std::string("-");
        };
        const std::string growth = asset.growthPercent ? fmt::format(" ({:+.2f} %)", *asset.growthPercent) : "";
        StyledLine line = {
            {Style::Plain, fmt::format("{:24} {:8} {} -> {}{}{}{}{}", asset.name, asset.change, bytes(asset.before), bytes(asset.now),
                                       growth, changeOf(asset, "diffuse", &AssetFigures::diffuse, 0.01, " %"),
                                       changeOf(asset, "specular", &AssetFigures::specular, 0.01, " %"),
                                       changeOf(asset, "visible", &AssetFigures::visible, 1, ""))}};
        if (asset.before && asset.now && asset.before->passed != asset.now->passed)
            line.insert(line.end(),
                        {{Style::Plain, ", "}, verdictWord(asset.before->passed), {Style::Plain, " -> "}, verdictWord(asset.now->passed)});
        terminal.say(line);
    }
    terminal.say(fmt::format("{} -> {} since {} ({}{}); {} of {} unchanged", sizeWords(comparison.bytesBefore),
                             sizeWords(comparison.bytesNow), comparison.file, growthWords(comparison.bytesBefore, comparison.bytesNow),
                             allowedWords(comparison.allowed.memory), same, counted(comparison.assets.size(), "asset")));
}

void printReport(Terminal& terminal, const Report& report) {
    printAssets(terminal, report.assets);
    const std::string limit = report.budget.limitBytes ? " of " + sizeWords(*report.budget.limitBytes) : "";
    terminal.say(fmt::format("{}{} of GPU memory, {:.2f} s, {:.0f} MiB resident at most", sizeWords(report.budget.usedBytes), limit,
                             report.seconds, static_cast<double>(report.peakRssBytes) / 0x1p20));
    if (report.whole) terminal.say(lineOf(*report.whole));
    if (!report.partial.empty()) terminal.say(partialLine(report.scene, report.partial));
}

void printPlatforms(Terminal& terminal, const std::vector<PlatformUse>& platforms) {
    for (const PlatformUse& platform : platforms) {
        const auto failed = std::ranges::count_if(platform.checks, [](const BudgetCheck& check) { return !check.passed; });
        terminal.say(StyledLine{
            {Style::Plain, fmt::format("platform {}: {} in {}, {} of {} limits exceeded  ", platform.name, sizeWords(platform.usedBytes),
                                       counted(static_cast<std::uint64_t>(platform.scenes), "scene"), failed, platform.checks.size())},
            verdictWord(platform.passed)});
    }
}

void printCollection(Terminal& terminal, const CollectionReport& report) {
    const auto relRmsOf = [](const std::optional<double>& relRms) { return relRms ? percent(*relRms) : kNoRelRms; };
    terminal.say(StyledLine{{Style::Faint, fmt::format("{:32} {:6} {:>9} {:>9} {:>10} {:>10} {:>8}  {}", "scene", "target", "GPU, MiB",
                                                       "disk, MiB", "diffuse", "specular", "visible", "verdict")}});
    std::size_t failed = 0;
    for (const SceneSummary& scene : report.scenes) {
        AssetFigures worst;
        for (const AssetSummary& asset : scene.assets) {
            for (const auto figure : {&AssetFigures::diffuse, &AssetFigures::specular, &AssetFigures::visible})
                if (asset.figures.*figure) worst.*figure = std::max((worst.*figure).value_or(0.0), *(asset.figures.*figure));
        }
        failed += scene.passed ? 0 : 1;
        terminal.say(StyledLine{{Style::Plain, fmt::format("{:32} {:6} {:>9} {:>9} {} {} {:>8}  ", scene.name, scene.target,
                                                           mebibytes(scene.budget.usedBytes), mebibytes(scene.bytesDisk),
                                                           relRmsOf(worst.diffuse), relRmsOf(worst.specular), visibleWord(worst.visible))},
                                verdictWord(scene.passed)});
    }
    for (const SceneSummary& scene : report.scenes)
        if (!scene.partial.empty()) terminal.say(partialLine(scene.name, scene.partial));
    if (report.platforms) printPlatforms(terminal, *report.platforms);
    if (report.baseline) {
        const CollectionComparison& baseline = *report.baseline;
        for (const SceneChange& scene : baseline.scenes)
            if (scene.change != "same")
                terminal.say(fmt::format("{:32} {:8} {} -> {} ({}), {}", scene.name, scene.change, sizeWords(scene.bytesBefore),
                                         sizeWords(scene.bytesNow), growthWords(scene.bytesBefore, scene.bytesNow),
                                         counted(scene.assets.size(), "asset")));
        const auto same = std::ranges::count(baseline.scenes, "same", &SceneChange::change);
        terminal.say(fmt::format("{} -> {} since {} ({}{}); {} of {} unchanged", sizeWords(baseline.bytesBefore),
                                 sizeWords(baseline.bytesNow), baseline.file, growthWords(baseline.bytesBefore, baseline.bytesNow),
                                 allowedWords(baseline.allowed.memory), same, counted(baseline.scenes.size(), "scene")));
    }
    terminal.say(fmt::format("{} of GPU memory in {}, {} failed", sizeWords(report.totals.bytesGpu), counted(report.scenes.size(), "scene"),
                             failed));
}

void printFindings(Terminal& terminal, const std::vector<Finding>& findings) {
    for (const Finding& finding : findings)
        if (!finding.allowed && !finding.isFailure())
            finding.isNote() ? terminal.note(subjectOf(finding), detailOf(finding))
                             : terminal.warning(subjectOf(finding), detailOf(finding));
}

void printClampedLight(Terminal& terminal, const Report& report) {
    for (const ReportRow& row : report.assets)
        if (row.notes && row.notes->contains(note_keys::kClampedLight))
            terminal.warning(row.name, fmt::format("found {} values of light above 65504, expected none: layout {} stores no more, and "
                                                   "they became 65504. Check light_units and the scale of the bake",
                                                   row.notes->at(note_keys::kClampedLight).get<std::int64_t>(), row.layout));
}

void printRepairs(Terminal& terminal, const Report& report) {
    constexpr std::array kFaults = {
        std::pair{note_keys::kRepairedNotFinite, "infinite or NaN"}, std::pair{note_keys::kRepairedNegativeDc, "negative light"},
        std::pair{note_keys::kRepairedBands, "bands longer than their light"}, std::pair{note_keys::kRepairedFireflies, "fireflies"}};
    for (const ReportRow& row : report.assets) {
        if (!row.notes) continue;
        const auto countOf = [&](const char* key) { return row.notes->value(key, std::int64_t{0}); };
        warnOfRepairs(terminal, row.name, countOf(note_keys::kRepairedTexels));
        std::string words;
        for (const auto& [key, what] : kFaults)
            if (const std::int64_t count = countOf(key); count > 0)
                words += fmt::format("{}{} ({})", words.empty() ? "" : ", ", count, what);
        if (!words.empty()) terminal.warning(row.name, fmt::format("found faults of the bake, which were repaired: {}", words));
    }
}

void warnOfRepairs(Terminal& terminal, const std::string& subject, std::int64_t texels) {
    if (texels > 0)
        terminal.warning(
            subject,
            fmt::format(
                "found {} with values that are no light (infinite, NaN, or negative in the file or after the conversion of its colours), "
                "which were repaired",
                counted(static_cast<std::size_t>(texels), "texel")));
}

void printSkipped(Terminal& terminal, const Report& report) {
    for (const Skip& skip : report.skipped) terminal.warning(skip.what, fmt::format("not made: {}", skip.why));
}

void printReport(Terminal& terminal, const Json& json) {
    if (const auto report = fromJson<Report>(json, kReportName)) printReport(terminal, *report);
}

void printJson(Terminal& terminal, const Json& json, const std::string& indent) {
    const auto wordOf = [](const Json& value) {
        if (value.is_string()) return value.get<std::string>();
        if (value.is_structured()) return std::string("none");
        return value.is_number_float() ? fmt::format("{:.6g}", value.get<double>()) : textOf(value);
    };
    for (const auto& [key, value] : json.items()) {
        const bool hasLines = value.is_structured() && !value.empty();
        terminal.say(fmt::format("{}{}:{}", indent, key, hasLines ? "" : " " + wordOf(value)));
        if (hasLines) printJson(terminal, value, indent + "  ");
    }
}

}  // namespace lightcook::pipeline
