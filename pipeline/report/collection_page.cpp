// The page of several scenes: verdict, budgets, growth, trend, memory, and a table of the scenes.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "pipeline/report/baseline_section.h"
#include "pipeline/report/captions.h"
#include "pipeline/report/collection.h"
#include "pipeline/report/page_frame.h"
#include "pipeline/report/page_parts.h"
#include "pipeline/report/platform_section.h"
#include "pipeline/report/treemap.h"
#include "pipeline/report/trend_section.h"

namespace lightcook::pipeline {
namespace {

/// Returns the link to the page of a scene, relative to this page; empty without one.
std::string linkOf(const SceneSummary& scene, const std::filesystem::path& page) {
    if (page.empty()) return "";
    std::error_code code;
    const std::filesystem::path target = std::filesystem::absolute(std::filesystem::path(scene.folder) / kReportHtmlName, code);
    const std::filesystem::path from = std::filesystem::absolute(page, code).parent_path();
    // Percent signs and other reserved characters of folder names are encoded.
    std::string link;
    for (const char c : target.lexically_normal().lexically_relative(from.lexically_normal()).generic_string()) {
        const bool isPlain =
            std::isalnum(static_cast<unsigned char>(c)) != 0 || std::string_view("-._~/").find(c) != std::string_view::npos;
        link += isPlain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
    return link;
}

/// Returns the asset of a scene that uses the largest part of one of its limits. Null: none has a limit.
const AssetSummary* worstOf(const SceneSummary& scene) {
    const AssetSummary* worst = nullptr;
    for (const AssetSummary& asset : scene.assets)
        if (asset.limitUse && (worst == nullptr || asset.limitUse->share > worst->limitUse->share)) worst = &asset;
    return worst;
}

/// Returns the largest visible error of the assets. Empty: they have none.
std::optional<double> visibleOf(const SceneSummary& scene) {
    std::optional<double> visible;
    for (const AssetSummary& asset : scene.assets)
        if (asset.figures.visible) visible = std::max(visible.value_or(0), *asset.figures.visible);
    return visible;
}

constexpr double kSortedFirst = -1;  ///< value of a cell without a figure

Html valueCell(double value, const Html& content, const char* kind = "num") {
    return element("td", {{"class", kind}, {"data-value", fmt::format("{}", std::isfinite(value) ? value : 1e300)}}, content);
}

Html header(const CollectionReport& report) {
    const auto count = std::ranges::count_if(report.scenes, [](const SceneSummary& scene) { return scene.passed; });
    const Html title = element("h1", text(counted(report.scenes.size(), "scene"))) + verdictChip(report.passed);
    double seconds = 0;
    for (const SceneSummary& scene : report.scenes) seconds += scene.seconds;
    const Html facts = fact("Scenes passed", text(fmt::format("{} of {}", count, report.scenes.size()))) +
                       fact("GPU memory", bytesMarkup(report.totals.bytesGpu)) + fact("Disk", bytesMarkup(report.totals.bytesDisk)) +
                       fact("Saved by skipping", bytesMarkup(report.totals.bytesSaved)) +
                       fact("Time of the cooks", secondsMarkup(seconds)) + fact("Tool", text(report.tool.name + " " + report.tool.version));
    return element("header", element("p", {{"class", "eyebrow"}}, word("Cooked lighting")) + element("div", {{"class", "title"}}, title) +
                                 element("dl", {{"class", "facts"}}, facts));
}

Html failures(const CollectionReport& report) {
    constexpr std::size_t kMost = 30;
    Html lines;
    std::size_t count = 0;
    for (const SceneSummary& scene : report.scenes)
        for (const std::string& error : scene.errors)
            if (++count <= kMost) lines += element("li", element("b", text(scene.name)) + text(": " + error));
    if (report.platforms)
        for (const formats::Error& error : errorsOf(*report.platforms, "budgets"))
            if (++count <= kMost) lines += element("li", text(error.line()));
    if (count == 0) return {};
    if (count > kMost) lines += element("li", text(fmt::format("and {} more", count - kMost)));
    return element("section", {{"class", "card failures"}}, element("h2", word("What failed")) + element("ul", lines));
}

Html changeRow(const SceneChange& scene, const AssetChange& asset) {
    return baselineRow(jsonOf(asset), scene.name + ": " + asset.name);
}

Html growth(const CollectionComparison& baseline) {
    constexpr std::size_t kMostRows = 100, kMostPictures = 12;
    Html rows, pictures;
    std::size_t changed = 0, shown = 0, pictured = 0;
    for (const SceneChange& scene : baseline.scenes) {
        changed += scene.change == "same" ? 0 : 1;
        for (const AssetChange& asset : scene.assets) {
            if (++shown <= kMostRows) rows += changeRow(scene, asset);
            if (!asset.pictureNow || ++pictured > kMostPictures) continue;
            pictures += grownErrorPictures(jsonOf(asset), scene.name + ": " + asset.name);
        }
    }
    const std::string allowed = baseline.allowedPercent ? fmt::format("; at most {} % passes", *baseline.allowedPercent) : "";
    const std::string more = shown > kMostRows ? fmt::format(" The table shows {} of {} assets that changed.", kMostRows, shown) : "";
    const std::string sentence = fmt::format("{}: {} of {} scenes changed, {} to {} ({}{}).{}", baseline.file, changed,
                                             baseline.scenes.size(), humanBytes(baseline.bytesBefore), humanBytes(baseline.bytesNow),
                                             growthWords(baseline.bytesBefore, baseline.bytesNow), allowed, more);
    return card("Compared with the baseline", element("p", {{"class", baseline.passed ? "soft" : "over"}}, text(sentence)) +
                                                  (rows.isEmpty() ? Html() : baselineTable(rows)) +
                                                  (pictures.isEmpty() ? Html() : element("h3", word("Where errors grew")) + pictures));
}

Html shares(const char* title, const std::map<std::string, std::uint64_t>& bytesByName, std::uint64_t whole, bool hasSwatches) {
    std::vector<std::pair<std::string, std::uint64_t>> sorted(bytesByName.begin(), bytesByName.end());
    std::ranges::stable_sort(sorted, [](const auto& a, const auto& b) { return a.second > b.second; });
    Html rows;
    for (const auto& [name, bytes] : sorted)
        rows +=
            element("tr", element("td", (hasSwatches ? swatch(name) : Html()) + text(name.empty() ? "unknown" : kindCaption(name))) +
                              numberCell(bytesMarkup(bytes)) +
                              numberCell(text(humanPercent(whole > 0 ? static_cast<double>(bytes) / static_cast<double>(whole) : 0.0))));
    return table("shares", element("tr", headCell(title) + headCell("GPU memory", "num") + headCell("Share", "num")), rows);
}

Html memory(const CollectionReport& report, const std::filesystem::path& page) {
    std::vector<TreemapTile> tiles;
    for (const SceneSummary& scene : report.scenes) {
        TreemapTile tile = {scene.name, scene.target, "var(--track)", linkOf(scene, page), scene.budget.usedBytes};
        for (const auto& [kind, bytes] : scene.budget.byKind)
            tile.parts.push_back({kindCaption(kind), scene.name, kindColor(kind), "", bytes});
        if (tile.parts.size() == 1) tile.color = tile.parts[0].color;
        tiles.push_back(std::move(tile));
    }
    return card("Memory", treemap(std::move(tiles), "GPU memory of every scene, by kind of asset; the table below has the figures") +
                              element("div", {{"class", "pair"}},
                                      shares("By kind", report.totals.byKind, report.totals.bytesGpu, true) +
                                          shares("By format", report.totals.byFormat, report.totals.bytesGpu, false) +
                                          shares("By target", report.totals.byTarget, report.totals.bytesGpu, false)));
}

Html sceneRow(const SceneSummary& scene, std::uint64_t most, const std::filesystem::path& page) {
    const std::string link = linkOf(scene, page);
    const Html name = link.empty() ? text(scene.name) : element("a", {{"href", link}}, text(scene.name));
    const AssetSummary* const worst = worstOf(scene);
    const double used = worst != nullptr ? worst->limitUse->share : 0;
    const std::optional<double> visible = visibleOf(scene);
    const double share = most > 0 ? static_cast<double>(scene.budget.usedBytes) / static_cast<double>(most) : 0;
    const Html bar = element("span", {{"class", "meter long"}}, element("i", {{"style", fmt::format("width:{:.1f}%", 100 * share)}}, {}));
    std::optional<double> ofBudget;
    if (scene.budget.limitBytes && *scene.budget.limitBytes > 0)
        ofBudget = static_cast<double>(scene.budget.usedBytes) / static_cast<double>(*scene.budget.limitBytes);
    const std::string folder = scene.folder + (scene.partial.empty() ? "" : fmt::format(", without {}", fmt::join(scene.partial, ", ")));
    return element(
        "tr", element("th", {{"scope", "row"}}, name + element("span", {{"class", "sub"}}, text(folder))) +
                  element("td", text(scene.target)) +
                  valueCell(static_cast<double>(scene.budget.usedBytes), bytesMarkup(scene.budget.usedBytes) + bar) +
                  valueCell(ofBudget.value_or(kSortedFirst), text(ofBudget ? humanPercent(*ofBudget) : "none"),
                            ofBudget.value_or(0) > 1 ? "num over" : "num") +
                  valueCell(used,
                            worst == nullptr ? text(kDash)
                                             : text(humanPercent(used)) +
                                                   element("span", {{"class", "sub"}}, text(worst->name + ": " + worst->limitUse->words)),
                            used > 1 ? "num over" : "num") +
                  valueCell(visible.value_or(kSortedFirst), text(visible ? humanNumber(*visible) : kDash)) +
                  valueCell(scene.sceneError.value_or(kSortedFirst), text(scene.sceneError ? humanPercent(*scene.sceneError) : kDash)) +
                  valueCell(static_cast<double>(scene.bytesDisk), bytesMarkup(scene.bytesDisk)) +
                  valueCell(scene.findingCount, text(groupedCount(static_cast<std::uint64_t>(scene.findingCount)))) +
                  element("td", verdictChip(scene.passed)));
}

Html scenes(const CollectionReport& report, const std::filesystem::path& page) {
    Html rows;
    const std::uint64_t most = report.scenes.empty() ? 0 : report.scenes.front().budget.usedBytes;
    for (const SceneSummary& scene : report.scenes) rows += sceneRow(scene, most, page);
    const Html head = headCell("Scene") + headCell("Target") + headCell("GPU memory", "num") + headCell("Of its budget", "num") +
                      headCell("Largest error, of its limit", "num") + headCell("Visible error, p99", "num") +
                      headCell("Error of the whole scene", "num") + headCell("Disk", "num") + headCell("Findings", "num") +
                      headCell("Verdict");
    return card("Scenes",
                table("scenes sortable", element("tr", head), rows) +
                    element("p", {{"class", "soft"}},
                            word("The largest error is that of the asset that uses most of one of its limits. Visible errors are in "
                                 "just noticeable differences: 1 is at the threshold of a trained eye.")));
}

}  // namespace

std::string renderCollectionHtml(const CollectionReport& report, const std::filesystem::path& page,
                                 const std::vector<HistoryLine>& history) {
    const Html main = header(report) + failures(report) + platformSection(report.platforms ? jsonOf(*report.platforms) : Json()) +
                      (report.baseline ? growth(*report.baseline) : Html()) + trendSection(history, false) + memory(report, page) +
                      scenes(report, page);
    return pageText(counted(report.scenes.size(), "scene") + (report.passed ? ": passed" : ": failed"), main);
}

}  // namespace lightcook::pipeline
