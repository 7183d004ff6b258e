// report.html from report.json: the page, and its sections about all assets together.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/assets/verdict.h"
#include "pipeline/report/advice_section.h"
#include "pipeline/report/asset_section.h"
#include "pipeline/report/baseline_section.h"
#include "pipeline/report/captions.h"
#include "pipeline/report/failures.h"
#include "pipeline/report/findings_section.h"
#include "pipeline/report/frontier_section.h"
#include "pipeline/report/html.h"
#include "pipeline/report/limit_use.h"
#include "pipeline/report/page_frame.h"
#include "pipeline/report/page_parts.h"
#include "pipeline/report/platform_section.h"
#include "pipeline/report/report.h"
#include "pipeline/report/seam_section.h"
#include "pipeline/report/treemap.h"
#include "pipeline/report/trend_section.h"
#include "pipeline/report/whole_section.h"

namespace lightcook::pipeline {
namespace {

constexpr std::array kFigures = {"rel_rms", "p99", "max_sampled", "max_bound"};

// The head of the page

std::string budgetSentence(const Json& budget) {
    const std::uint64_t used = count(member(budget, "used_bytes"));
    if (member(budget, "limit_bytes").is_null()) return humanBytes(used) + " used; the scene has no memory budget";
    const std::uint64_t limit = count(member(budget, "limit_bytes"));
    std::string sentence = fmt::format("{} of {} used", humanBytes(used), humanBytes(limit));
    if (limit > 0) sentence += fmt::format(" ({})", humanPercent(static_cast<double>(used) / static_cast<double>(limit)));
    return sentence +
           (used > limit ? fmt::format(", {} over", humanBytes(used - limit)) : fmt::format(", {} free", humanBytes(limit - used)));
}

/// Returns the runs that time and memory are of.
Html runsMarkup(const Json& runs) {
    std::string names;
    for (const Json& run : runs) {
        const std::string at = words(member(run, "at"));
        if (!at.empty()) names += (names.empty() ? "the run of " : ", ") + at;
    }
    return text(names.empty() ? "this run" : names);
}

std::string namesIn(const Json& assets) {
    std::string names;
    for (const Json& name : assets) names += (names.empty() ? "" : ", ") + words(name);
    return names;
}

/// Returns the verdict in a sentence: assets, the one nearest to a limit of its own, memory.
std::string verdictSentence(const Json& report) {
    const Json& assets = list(report, "assets");
    const auto passedCount = static_cast<std::size_t>(std::count_if(assets.begin(), assets.end(), passed));
    std::string sentence = passedCount == assets.size()
                               ? "Every asset keeps its limit"
                               : fmt::format("{} of {} failed", assets.size() - passedCount, counted(assets.size(), "asset"));
    const Json& missing = list(member(report, "incomplete"), "assets");
    if (const std::string names = namesIn(missing); !names.empty()) sentence = "Not cooked: " + names + ". " + sentence;
    if (const std::string names = namesIn(list(report, "partial")); !names.empty())
        sentence = "This is a part of the scene; cook --only left out: " + names + ". " + sentence;
    const Json* nearest = nullptr;
    LimitUse most;
    for (const Json& asset : assets)
        if (const auto use = mostUsedLimit(asset); use && use->share > most.share) {
            most = *use;
            nearest = &asset;
        }
    if (nearest != nullptr) {
        const std::string share = std::isfinite(most.share) ? fmt::format(" ({})", humanPercent(most.share)) : "";
        sentence += fmt::format("; {} uses most of its limit: {}{}", words(member(*nearest, "name")), most.words, share);
    }
    return sentence + ". " + budgetSentence(member(report, "budget")) + ".";
}

Html header(const Json& report) {
    const Json &assets = list(report, "assets"), &tool = member(report, "tool"), &budget = member(report, "budget");
    const auto passedCount = std::count_if(assets.begin(), assets.end(), passed);
    const Html title = element("h1", text(words(member(report, "scene")))) + verdictChip(passed(report));
    const Html facts = fact("GPU memory", bytesMarkup(count(member(budget, "used_bytes")))) +
                       fact("Assets passed", text(fmt::format("{} of {}", passedCount, assets.size()))) +
                       fact("Time", secondsMarkup(member(report, "seconds"))) +
                       fact("Peak memory", bytesMarkup(count(member(report, "peak_rss_bytes")))) +
                       fact("Made by", runsMarkup(list(report, "runs"))) +
                       fact("Tool", text(words(member(tool, "name")) + " " + words(member(tool, "version"))));
    return element("header", element("p", {{"class", "eyebrow"}}, word("Cooked lighting")) + element("div", {{"class", "title"}}, title) +
                                 element("p", {{"class", "lead"}}, text(verdictSentence(report))) +
                                 element("dl", {{"class", "facts"}}, facts));
}

// Why it failed

/// Returns "rel_rms, p99": the names of the figures that are not finite.
std::string notFiniteNames(const Json& figures) {
    std::string names;
    for (const char* name : kFigures)
        if (figures.is_object() && figures.contains(name) && !std::isfinite(number(figures.at(name))))
            names += (names.empty() ? "" : ", ") + std::string(name);
    return names;
}

/// Returns "; worst at ...": where a figure is largest. Empty if the report has no place.
std::string worstWords(const Json& at) {
    const std::string place = placeWords(at);
    return place.empty() ? place : "; worst at " + place;
}

/// Adds the figures of one kind of shading that are over the limits of an asset.
void addOverLimits(const Json& asset, const char* shading, std::vector<std::string>& reasons) {
    const Json &error = member(member(lastStage(asset), "error"), shading), &limits = member(asset, "limit");
    const double relRms = number(member(error, "rel_rms")), maxError = limitOf(asset);
    if (relRms > maxError)
        reasons.push_back(fmt::format("{} rel_rms is {}, the limit is {}{}", shading, humanPercent(relRms), humanPercent(maxError),
                                      worstWords(member(error, "sampled_at"))));
    const Json& visible = member(error, "visible");
    const double p99 = number(member(visible, "p99")), maxVisible = number(member(limits, "max_visible"));
    if (p99 > maxVisible)
        reasons.push_back(fmt::format("the visible error of {} light is {:.2f} (p99), the limit is {:.3g}{}", shading, p99, maxVisible,
                                      worstWords(member(visible, "max_at"))));
    const double bound = number(member(visible, "bound")), maxVisibleBound = number(member(limits, "max_visible_bound"));
    if (bound > maxVisibleBound)
        reasons.push_back(fmt::format("the visible error of {} light is up to {:.2f} (proven bound), the limit is {:.3g}{}", shading, bound,
                                      maxVisibleBound, worstWords(member(visible, "bound_at"))));
}

/// Adds the largest seam if it is over its limit.
/// holder  has the limit, as `max_seam`
void addSeamOverLimit(const Json& seams, const Json& holder, std::vector<std::string>& reasons) {
    const Json& worst = list(seams, "worst");
    const double maxSeam = number(member(holder, "max_seam"));
    if (worst.empty() || number(member(worst[0], "added")) <= maxSeam || !std::isfinite(maxSeam)) return;
    const std::string maps = mapsOfSeam(worst[0]), between = maps.empty() ? "" : " " + maps;
    reasons.push_back(fmt::format("cooking adds a {} seam of {:.2f}{}, the limit is {:.3g}{}", words(member(worst[0], "shading")),
                                  number(member(worst[0], "added")), between, maxSeam, worstWords(worst[0])));
}

/// Returns why an asset did not pass.
std::vector<std::string> reasonsOf(const Json& asset) {
    std::vector<std::string> reasons;
    const Json& stages = list(asset, "stages");
    if (stages.empty()) reasons.emplace_back("nothing was measured");
    for (const Json& stage : stages)
        for (const char* shading : kShadings)
            if (const std::string names = notFiniteNames(member(member(stage, "error"), shading)); !names.empty())
                reasons.push_back(fmt::format("{} after {} is not finite ({})", shading, stageWords(words(member(stage, "name"))), names));
    for (const char* shading : kShadings) addOverLimits(asset, shading, reasons);
    addSeamOverLimit(member(asset, "seams"), member(asset, "limit"), reasons);
    addSeamOverLimit(member(asset, "split_seams"), member(asset, "split_seams"), reasons);
    for (const Json& violation : list(asset, "violations"))
        reasons.push_back(fmt::format("{}: found {}, expected {}{}", words(member(violation, "place")), words(member(violation, "found")),
                                      words(member(violation, "expected")), worstWords(member(violation, "at"))));
    if (reasons.empty()) reasons.emplace_back("the verifier refused it; its section has the figures");
    return reasons;
}

Html failedAsset(const Json& asset, std::size_t index) {
    const std::vector<std::string> reasons = reasonsOf(asset);
    Html line = element("a", {{"href", fmt::format("#{}", assetAnchor(index))}}, text(words(member(asset, "name")))) + word(": ");
    for (std::size_t i = 0; i < reasons.size(); ++i) line += text((i > 0 ? "; " : "") + reasons[i]);
    return element("li", line);
}

Html failures(const Json& report) {
    const Json& assets = list(report, "assets");
    Html lines;
    for (std::size_t i = 0; i < assets.size(); ++i)
        if (!passed(assets[i])) lines += failedAsset(assets[i], i);
    const Json& budget = member(report, "budget");
    if (!member(budget, "limit_bytes").is_null() && count(member(budget, "used_bytes")) > count(member(budget, "limit_bytes")))
        lines += element("li", text("memory budget: " + budgetSentence(budget)));
    if (lines.isEmpty()) return {};
    return element("section", {{"class", "card failures"}}, element("h2", word("What failed")) + element("ul", lines));
}

// Memory

struct Share {
    std::string name;
    std::uint64_t bytes;
};

/// Returns the shares of memory, largest first, for the bar and its table.
std::vector<Share> sharesOf(const Json& bytesByName) {
    std::vector<Share> shares;
    if (bytesByName.is_object())
        for (const auto& [name, bytes] : bytesByName.items()) shares.push_back({name, count(bytes)});
    std::stable_sort(shares.begin(), shares.end(), [](const Share& a, const Share& b) { return a.bytes > b.bytes; });
    return shares;
}

double ratio(std::uint64_t part, std::uint64_t whole) {
    return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

Html budgetBar(const Json& budget) {
    const std::uint64_t used = count(member(budget, "used_bytes")), limit = count(member(budget, "limit_bytes"));
    const std::uint64_t whole = std::max(used, limit);
    Html segments;
    for (const Share& share : sharesOf(member(budget, "by_kind"))) {
        if (share.bytes == 0) continue;
        const std::string style = fmt::format("width:{:.3f}%;background:{}", 100 * ratio(share.bytes, whole), kindColor(share.name));
        segments += element("i", {{"style", style}, {"title", fmt::format("{}: {}", share.name, humanBytes(share.bytes))}}, {});
    }
    const bool isOverLimit = !member(budget, "limit_bytes").is_null() && used > limit;
    if (isOverLimit) {
        const std::string place = fmt::format("left:{:.3f}%", 100 * ratio(limit, whole));
        segments += element("b", {{"style", place}, {"title", "limit: " + humanBytes(limit)}}, {});
    }
    const std::string sentence = budgetSentence(budget);
    const Html bar = element("div", {{"class", isOverLimit ? "bar over" : "bar"}, {"role", "img"}, {"aria-label", sentence}}, segments);
    return bar + element("p", {{"class", isOverLimit ? "sentence over" : "sentence"}}, text(sentence));
}

Html shareTable(const char* title, const Json& bytesByName, std::uint64_t used, bool hasSwatches) {
    Html rows;
    for (const Share& share : sharesOf(bytesByName)) {
        const double part = ratio(share.bytes, used);
        const Html name = (hasSwatches ? swatch(share.name) : Html()) + text(kindCaption(share.name));
        rows += element("tr", element("td", name) + numberCell(bytesMarkup(share.bytes)) +
                                  numberCell(withTitle(fmt::format("{:.1f} %", 100 * part), exactNumber(part))));
    }
    if (rows.isEmpty()) rows = element("tr", element("td", {{"colspan", "3"}, {"class", "soft"}}, word("nothing")));
    return table("shares", element("tr", headCell(title) + headCell("GPU memory", "num") + headCell("Share", "num")), rows);
}

/// Returns a treemap of the assets, each divided into its textures. Of light maps, texels outside charts stand apart.
Html assetTreemap(const Json& report) {
    const Json& assets = list(report, "assets");
    std::vector<TreemapTile> tiles;
    for (std::size_t i = 0; i < assets.size(); ++i) {
        const Json& asset = assets[i];
        const std::string color = kindColor(words(member(asset, "kind")));
        TreemapTile tile = {words(member(asset, "name")), kindCaption(words(member(asset, "kind"))), color, "#" + assetAnchor(i),
                            count(member(asset, "bytes_gpu"))};
        for (const Json& texture : list(asset, "textures")) {
            const std::uint64_t bytes = std::min(count(member(texture, "bytes_gpu")), tile.bytes);
            const std::uint64_t unused = std::min(bytesOutsideCharts(asset, texture), bytes);
            const std::string name = words(member(texture, "role")) + ", " + words(member(texture, "format"));
            tile.parts.push_back({name, unused > 0 ? "inside charts" : "", color, "", bytes - unused});
            if (unused > 0) tile.parts.push_back({"outside charts", name, "var(--track)", "", unused});
        }
        tiles.push_back(std::move(tile));
    }
    return treemap(std::move(tiles), "GPU memory of each asset and of its textures; the tables below have the figures");
}

Html memory(const Json& report) {
    const Json& budget = member(report, "budget");
    const std::uint64_t used = count(member(budget, "used_bytes"));
    const Html tables =
        shareTable("By kind", member(budget, "by_kind"), used, true) + shareTable("By format", member(budget, "by_format"), used, false);
    return card("Memory", budgetBar(budget) + assetTreemap(report) + element("div", {{"class", "pair"}}, tables));
}

// All assets

Html limitNote(const Json& asset) {
    Html note = word("limit ") + percentMarkup(limitOf(asset));
    constexpr std::array<std::pair<const char*, const char*>, 3> kLimits = {
        {{"max_visible", "visible"}, {"max_visible_bound", "bound"}, {"max_seam", "seam"}}};
    for (const auto& [key, name] : kLimits)
        if (const double limit = number(member(member(asset, "limit"), key)); std::isfinite(limit))
            note += text(fmt::format(", {} {:.3g}", name, limit));
    return element("span", {{"class", "sub"}}, note);
}

/// Returns a row of an asset, for one kind of shading. The first has the cells that all share.
/// rowCount  kinds of shading that the asset has
Html assetRow(const Json& asset, std::size_t index, const char* shading, bool isFirst, std::size_t rowCount) {
    const Json& figures = member(member(lastStage(asset), "error"), shading);
    const Attributes both = {{"rowspan", std::to_string(rowCount)}};
    Html cells;
    if (isFirst) {
        const std::string kind = words(member(asset, "kind")), size = sizeWords(asset);
        const Html name = element("a", {{"href", fmt::format("#{}", assetAnchor(index))}}, text(words(member(asset, "name"))));
        const std::string facts = kindCaption(kind) + (size.empty() ? "" : ", " + size) + ", " + words(member(asset, "layout"));
        cells += element("th", {{"scope", "rowgroup"}, {"rowspan", std::to_string(rowCount)}},
                         name + element("span", {{"class", "sub"}}, swatch(kind) + text(facts)));
        const double bits = number(member(asset, "bits_per_texel"));
        cells += numberCell(bytesMarkup(count(member(asset, "bytes_gpu"))), both) +
                 numberCell(bytesMarkup(count(member(asset, "bytes_disk"))), both) +
                 numberCell(withTitle(bits > 0 ? humanNumber(bits) : kDash, exactNumber(bits)), both);
    }
    cells += element("td", {{"class", "shading"}}, word(shading)) + limitedCell(figures, limitOf(asset));
    for (const char* name : {"p99", "max_sampled"}) cells += numberCell(figureMarkup(figures, name));
    for (const char* name : {"p99", "bound"}) cells += limitedVisibleCell(figures, name, asset);
    if (isFirst) cells += element("td", both, verdictChip(passed(asset)) + limitNote(asset));
    return element("tr", cells);
}

Html allAssets(const Json& report) {
    const Json& assets = list(report, "assets");
    if (assets.empty()) return card("Assets", element("p", {{"class", "soft"}}, word("No assets were cooked.")));
    const Html head = headCell("Asset") + headCell("GPU", "num") + headCell("Disk", "num") + headCell("Bits per texel", "num") +
                      headCell("Shading") + headCell("rel_rms", "num") + headCell("p99", "num") + headCell("max sampled", "num") +
                      headCell("Visible p99", "num") + headCell("Visible bound", "num") + headCell("Verdict");
    const Html grid = element("thead", element("tr", head));
    Html bodies;
    for (std::size_t i = 0; i < assets.size(); ++i) {
        const std::vector<const char*> shadings = shadingsOf(assets[i]);
        Html rows;
        for (const char* shading : shadings) rows += assetRow(assets[i], i, shading, shading == shadings.front(), shadings.size());
        bodies += element("tbody", rows);
    }
    const Html whole = element("table", {{"class", "assets"}}, grid + bodies);
    return card("Assets", element("div", {{"class", "scroll"}}, whole) +
                              element("p", {{"class", "soft"}},
                                      word("Thin lines show rel_rms and visible errors on the way to their limits. All figures are of "
                                           "the last stage; point at a number for its exact value.")));
}

// Skipped work, and the meaning of the terms

Html skips(const Json& report) {
    const Json& skipped = list(report, "skipped");
    if (skipped.empty()) return card("Skipped", element("p", {{"class", "soft"}}, word("Nothing was skipped.")));
    std::uint64_t bytes = 0;
    double seconds = 0;
    Html rows;
    for (const Json& skip : skipped) {
        bytes += count(member(skip, "bytes_saved"));
        if (member(skip, "seconds_saved").is_number()) seconds += number(member(skip, "seconds_saved"));
        rows += element("tr", element("th", {{"scope", "row"}}, text(words(member(skip, "what")))) +
                                  element("td", text(words(member(skip, "why")))) +
                                  numberCell(bytesMarkup(count(member(skip, "bytes_saved")))) +
                                  numberCell(secondsMarkup(member(skip, "seconds_saved"))));
    }
    rows += element("tr", {{"class", "total"}},
                    element("th", {{"scope", "row"}}, word("Together")) + element("td", {}) + numberCell(bytesMarkup(bytes)) +
                        numberCell(secondsMarkup(seconds)));
    const Html head = headCell("What") + headCell("Why") + headCell("Memory saved", "num") + headCell("Time saved", "num");
    return card("Skipped", table("skips", element("tr", head), rows));
}

Html footnote() {
    constexpr std::array<std::pair<const char*, const char*>, 6> kTerms = {
        {{"error",
          "of shaded exit radiance on a white surface, against the float bake, at texels inside charts; bilinear magnification is "
          "part of it"},
         {"rel_rms",
          "the RMS of the error over the RMS of the reference, over texels, directions and channels. The limit is on this "
          "figure of the last stage, diffuse and specular"},
         {"local relative error", "|error| / (|reference| + 0.02 key). p99 and max sampled are of this one"},
         {"key", "the log-average, over the map, of the luminance of the exit radiance at each texel's own normal"},
         {"p99, max sampled", "99 of 100 samples are below p99; max sampled is the largest that was seen"},
         {"bound", "of visible errors: no place, normal, view, material or allowed sampler can exceed it; computed, not sampled"}}};
    Html terms;
    for (const auto& [term, meaning] : kTerms) terms += element("dt", word(term)) + element("dd", word(meaning));
    return element("footer", element("h2", word("What the figures mean")) + element("dl", terms));
}

}  // namespace

std::string renderReportHtml(const Json& report, const StagedFolder& folder, const std::vector<HistoryLine>& history) {
    const Json& assets = list(report, "assets");
    Html main = header(report) + failures(report) + findingsSection(report) + platformSection(member(report, "platforms")) +
                baselineSection(member(report, "baseline")) + trendSection(history, true) + memory(report) +
                frontierSection(member(report, "budget")) + adviceSection(report) + wholeSection(member(report, "whole")) +
                allAssets(report);
    for (std::size_t i = 0; i < assets.size(); ++i) main += assetSection(folder, assets[i], i);
    main += skips(report) + footnote();
    return pageText(words(member(report, "scene")) + (passed(report) ? ": passed" : ": failed"), main);
}

}  // namespace lightcook::pipeline
