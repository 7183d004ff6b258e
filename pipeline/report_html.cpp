// report.html from report.json. Every reading of the JSON tolerates what is absent or of another type: a page with a dash in it says more
// than no page.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pipeline/html.h"
#include "pipeline/report.h"
#include "pipeline/report_curve.h"
#include "pipeline/report_whole.h"

namespace pipeline {
namespace {

constexpr const char* kDash = "\u2013";
constexpr std::array kShadings = {"diffuse", "specular"};
constexpr std::array kFigures = {"rel_rms", "p99", "max_sampled", "max_bound"};

// Reading the report

const Json& member(const Json& object, const char* key) {
    static const Json kAbsent;
    if (!object.is_object()) return kAbsent;
    const auto found = object.find(key);
    return found == object.end() ? kAbsent : *found;
}

/// An empty array stands for what is no array.
const Json& list(const Json& object, const char* key) {
    static const Json kEmpty = Json::array();
    const Json& value = member(object, key);
    return value.is_array() ? value : kEmpty;
}

std::string words(const Json& value) {
    if (value.is_null()) return "";
    return value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// NaN for what is no finite number: JSON writes NaN and infinities as null, and a report in memory shows as the one in the file does.
double number(const Json& value) {
    const double found = value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
    return std::isfinite(found) ? found : std::numeric_limits<double>::quiet_NaN();
}

std::uint64_t count(const Json& value) {
    if (value.is_number_unsigned()) return value.get<std::uint64_t>();
    if (value.is_number_integer()) return static_cast<std::uint64_t>(std::max<std::int64_t>(0, value.get<std::int64_t>()));
    return value.is_number_float() && value.get<double>() > 0 && value.get<double>() < 1e18
               ? static_cast<std::uint64_t>(value.get<double>())
               : 0;
}

bool passed(const Json& object) {
    const Json& value = member(object, "passed");
    return value.is_boolean() && value.get<bool>();
}

// Small pieces

Html word(const char* plain) {
    return text(plain);
}

Html withTitle(const std::string& shown, const std::string& exact) {
    return element("span", {{"title", exact}}, text(shown));
}

Html bytesMarkup(std::uint64_t bytes) {
    return withTitle(humanBytes(bytes), groupedCount(bytes) + " bytes");
}

Html secondsMarkup(const Json& seconds) {
    return withTitle(seconds.is_null() ? kDash : humanSeconds(number(seconds)), exactNumber(number(seconds)) + " s");
}

Html numberCell(const Html& content, const Attributes& more = {}) {
    Attributes attributes = {{"class", "num"}};
    attributes.insert(attributes.end(), more.begin(), more.end());
    return element("td", attributes, content);
}

Html headCell(const char* name, const char* kind = "", const Attributes& more = {}) {
    Attributes attributes = {{"scope", "col"}, {"class", kind}};
    attributes.insert(attributes.end(), more.begin(), more.end());
    return element("th", attributes, word(name));
}

Html table(const char* kind, const Html& head, const Html& body) {
    const Html grid = element("table", {{"class", kind}}, element("thead", head) + element("tbody", body));
    return element("div", {{"class", "scroll"}}, grid);
}

Html card(const char* title, const Html& content) {
    return element("section", {{"class", "card"}}, element("h2", word(title)) + content);
}

Html verdictChip(bool isPassed) {
    return element("span", {{"class", isPassed ? "verdict passed" : "verdict failed"}}, word(isPassed ? "✓ passed" : "✗ failed"));
}

/// One term and what it is, in a list of facts.
Html fact(const char* name, const Html& value) {
    return element("div", element("dt", word(name)) + element("dd", value));
}

Html swatch(const std::string& kind) {
    return element("span", {{"class", "swatch"}, {"style", "background:" + kindColor(kind)}}, {});
}

std::string assetAnchor(std::size_t index) {
    return fmt::format("asset-{}", index + 1);
}

std::string sizeWords(const Json& asset) {
    const std::uint64_t width = count(member(asset, "width")), height = count(member(asset, "height"));
    if (width == 0 || height == 0) return "";
    return fmt::format("{} × {}{}", width, height, member(asset, "kind") == "cubemap" ? " × 6" : "");
}

const Json& lastStage(const Json& asset) {
    static const Json kNone;
    const Json& stages = list(asset, "stages");
    return stages.empty() ? kNone : stages.back();
}

double limitOf(const Json& asset) {
    return number(member(member(asset, "limit"), "value"));
}

Html figureMarkup(const Json& figures, const char* name) {
    const Json& value = member(figures, name);
    if (!figures.is_object() || !figures.contains(name)) return withTitle(kDash, "not measured");
    return withTitle(humanPercent(number(value)), exactNumber(number(value)));
}

bool isOver(double figure, double limit) {
    return !std::isfinite(figure) || figure > limit;
}

/// rel_rms with a thin meter under it that is full at the limit.
Html limitedCell(const Json& figures, double limit) {
    const double figure = number(member(figures, "rel_rms"));
    Html content = figureMarkup(figures, "rel_rms");
    const bool isMeasured = figures.is_object() && figures.contains("rel_rms");
    if (isMeasured && limit > 0) {
        const double share = std::isfinite(figure) ? std::clamp(figure / limit, 0.0, 1.0) : 1.0;
        content += element("span", {{"class", "meter"}}, element("i", {{"style", fmt::format("width:{:.1f}%", 100 * share)}}, {}));
    }
    return element("td", {{"class", isMeasured && isOver(figure, limit) ? "num over" : "num"}}, content);
}

// The head of the page

std::string budgetSentence(const Json& budget) {
    const std::uint64_t used = count(member(budget, "used_bytes"));
    if (member(budget, "limit_bytes").is_null()) return humanBytes(used) + " used; no limit was set";
    const std::uint64_t limit = count(member(budget, "limit_bytes"));
    std::string sentence = fmt::format("{} of {} used", humanBytes(used), humanBytes(limit));
    if (limit > 0) sentence += fmt::format(" ({})", humanPercent(static_cast<double>(used) / static_cast<double>(limit)));
    return sentence +
           (used > limit ? fmt::format(", {} over", humanBytes(used - limit)) : fmt::format(", {} free", humanBytes(limit - used)));
}

Html header(const Json& report) {
    const Json &assets = list(report, "assets"), &tool = member(report, "tool"), &budget = member(report, "budget");
    const auto passedCount = std::count_if(assets.begin(), assets.end(), passed);
    const Html title = element("h1", text(words(member(report, "scene")))) + verdictChip(passed(report));
    const Html facts = fact("GPU memory", bytesMarkup(count(member(budget, "used_bytes")))) +
                       fact("Assets passed", text(fmt::format("{} of {}", passedCount, assets.size()))) +
                       fact("Time", secondsMarkup(member(report, "seconds"))) +
                       fact("Peak memory", bytesMarkup(count(member(report, "peak_rss_bytes")))) +
                       fact("Tool", text(words(member(tool, "name")) + " " + words(member(tool, "version"))));
    return element("header", element("p", {{"class", "eyebrow"}}, word("Cooked lighting")) + element("div", {{"class", "title"}}, title) +
                                 element("dl", {{"class", "facts"}}, facts));
}

// Why it failed

/// "rel_rms, p99": which of the figures are no finite numbers.
std::string notFiniteNames(const Json& figures) {
    std::string names;
    for (const char* name : kFigures)
        if (figures.is_object() && figures.contains(name) && !std::isfinite(number(figures.at(name))))
            names += (names.empty() ? "" : ", ") + std::string(name);
    return names;
}

std::vector<std::string> reasonsOf(const Json& asset) {
    std::vector<std::string> reasons;
    const Json& stages = list(asset, "stages");
    if (stages.empty()) reasons.emplace_back("nothing was measured");
    for (const Json& stage : stages)
        for (const char* shading : kShadings)
            if (const std::string names = notFiniteNames(member(member(stage, "error"), shading)); !names.empty())
                reasons.push_back(fmt::format("{} after stage {} is not finite ({})", shading, words(member(stage, "name")), names));
    const double limit = limitOf(asset);
    for (const char* shading : kShadings) {
        const double relRms = number(member(member(member(lastStage(asset), "error"), shading), "rel_rms"));
        if (relRms > limit)
            reasons.push_back(fmt::format("{} rel_rms is {}, the limit is {}", shading, humanPercent(relRms), humanPercent(limit)));
    }
    if (reasons.empty()) reasons.emplace_back("the verifier refused it; its section has the figures");
    return reasons;
}

Html failedAsset(const Json& asset, std::size_t index) {
    const std::vector<std::string> reasons = reasonsOf(asset);
    Html line = element("a", {{"href", "#" + assetAnchor(index)}}, text(words(member(asset, "name")))) + word(": ");
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

/// Largest first, so that the bar and its table tell the same story.
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
        const Html name = (hasSwatches ? swatch(share.name) : Html()) + text(share.name);
        rows += element("tr", element("td", name) + numberCell(bytesMarkup(share.bytes)) +
                                  numberCell(withTitle(fmt::format("{:.1f} %", 100 * part), exactNumber(part))));
    }
    if (rows.isEmpty()) rows = element("tr", element("td", {{"colspan", "3"}, {"class", "soft"}}, word("nothing")));
    return table("shares", element("tr", headCell(title) + headCell("GPU memory", "num") + headCell("Share", "num")), rows);
}

Html memory(const Json& report) {
    const Json& budget = member(report, "budget");
    const std::uint64_t used = count(member(budget, "used_bytes"));
    const Html tables =
        shareTable("By kind", member(budget, "by_kind"), used, true) + shareTable("By format", member(budget, "by_format"), used, false);
    return card("Memory", budgetBar(budget) + element("div", {{"class", "pair"}}, tables));
}

// All assets

Html limitNote(const Json& asset) {
    const double limit = limitOf(asset);
    return element("span", {{"class", "sub"}}, word("limit ") + withTitle(humanPercent(limit), exactNumber(limit)));
}

/// Every row speaks of one shading; what both share spans the two.
Html assetRow(const Json& asset, std::size_t index, std::size_t shading) {
    const Json& figures = member(member(lastStage(asset), "error"), kShadings[shading]);
    const Attributes both = {{"rowspan", "2"}};
    Html cells;
    if (shading == 0) {
        const std::string kind = words(member(asset, "kind")), size = sizeWords(asset);
        const Html name = element("a", {{"href", "#" + assetAnchor(index)}}, text(words(member(asset, "name"))));
        const std::string facts = kind + (size.empty() ? "" : ", " + size) + ", " + words(member(asset, "layout"));
        cells += element("th", {{"scope", "rowgroup"}, {"rowspan", "2"}},
                         name + element("span", {{"class", "sub"}}, swatch(kind) + text(facts)));
        const double bits = number(member(asset, "bits_per_texel"));
        cells += numberCell(bytesMarkup(count(member(asset, "bytes_gpu"))), both) +
                 numberCell(bytesMarkup(count(member(asset, "bytes_disk"))), both) +
                 numberCell(withTitle(bits > 0 ? humanNumber(bits) : kDash, exactNumber(bits)), both);
    }
    cells += element("td", {{"class", "shading"}}, word(kShadings[shading])) + limitedCell(figures, limitOf(asset));
    for (const char* name : {"p99", "max_sampled", "max_bound"}) cells += numberCell(figureMarkup(figures, name));
    if (shading == 0) cells += element("td", both, verdictChip(passed(asset)) + limitNote(asset));
    return element("tr", cells);
}

Html allAssets(const Json& report) {
    const Json& assets = list(report, "assets");
    if (assets.empty()) return card("Assets", element("p", {{"class", "soft"}}, word("No assets were cooked.")));
    const Html head = headCell("Asset") + headCell("GPU", "num") + headCell("Disk", "num") + headCell("Bits per texel", "num") +
                      headCell("Shading") + headCell("rel_rms", "num") + headCell("p99", "num") + headCell("max sampled", "num") +
                      headCell("proven bound", "num") + headCell("Verdict");
    const Html grid = element("thead", element("tr", head));
    Html bodies;
    for (std::size_t i = 0; i < assets.size(); ++i) bodies += element("tbody", assetRow(assets[i], i, 0) + assetRow(assets[i], i, 1));
    const Html whole = element("table", {{"class", "assets"}}, grid + bodies);
    return card("Assets", element("div", {{"class", "scroll"}}, whole) +
                              element("p", {{"class", "soft"}},
                                      word("Thin lines show rel_rms on the way to its limit. All figures are of "
                                           "the last stage; point at a number for its exact value.")));
}

// One asset

Html pictureFigure(const std::filesystem::path& folder, const Json& preview, const char* role, const Html& caption) {
    constexpr std::uint32_t kSmoothFrom = 256;  // [pixels] smaller pictures are enlarged: as squares, since their texels are the subject
    const std::string file = words(member(preview, role));
    const auto picture = loadPicture(folder, file);
    Html content;
    if (picture) {
        const char* scaling = std::max(picture->width, picture->height) < kSmoothFrom ? "pixels" : "smooth";
        content = voidElement("img", {{"src", picture->dataUri},
                                      {"alt", role},
                                      {"class", scaling},
                                      {"width", std::to_string(picture->width)},
                                      {"height", std::to_string(picture->height)}});
    } else {
        content = element("div", {{"class", "missing"}}, text(file.empty() ? "no picture" : "picture missing: " + file));
    }
    return element("figure", content + element("figcaption", caption));
}

Html pictures(const std::filesystem::path& folder, const Json& asset) {
    const Json& preview = member(asset, "preview");
    if (!preview.is_object()) return {};
    // The ramp of this scale is that of preview.cpp.
    const Html ramp = word("0") + element("span", {{"class", "heat"}}, {}) + word("10 % or more");
    const Html differenceCaption = element("b", word("Difference")) + word(": local relative error, the worst under each pixel") +
                                   element("span", {{"class", "scale"}}, ramp);
    return element("div", {{"class", "pictures"}},
                   pictureFigure(folder, preview, "reference", element("b", word("Reference")) + word(": the float bake")) +
                       pictureFigure(folder, preview, "cooked", element("b", word("Cooked")) + word(": as the shader reads it")) +
                       pictureFigure(folder, preview, "difference", differenceCaption));
}

Html stageRow(const Json& stage, bool isLast, double limit) {
    Html cells = element("th", {{"scope", "row"}}, text(words(member(stage, "name"))));
    for (const char* shading : kShadings) {
        const Json& figures = member(member(stage, "error"), shading);
        cells += isLast ? limitedCell(figures, limit) : numberCell(figureMarkup(figures, "rel_rms"));
        for (const char* name : {"p99", "max_sampled", "max_bound"}) cells += numberCell(figureMarkup(figures, name));
    }
    return element("tr", {{"class", isLast ? "last" : ""}}, cells + numberCell(secondsMarkup(member(stage, "seconds"))));
}

Html stageTable(const Json& asset) {
    const Json& stages = list(asset, "stages");
    if (stages.empty()) return element("p", {{"class", "soft"}}, word("No stage was measured."));
    const Html groups = headCell("Stage", "", {{"rowspan", "2"}}) + headCell("diffuse", "group", {{"colspan", "4"}}) +
                        headCell("specular", "group", {{"colspan", "4"}}) + headCell("Time", "num", {{"rowspan", "2"}});
    Html names, rows;
    for (int i = 0; i < 2; ++i)
        names += headCell("rel_rms", "num first") + headCell("p99", "num") + headCell("max sampled", "num") + headCell("bound", "num");
    for (const Json& stage : stages) rows += stageRow(stage, &stage == &stages.back(), limitOf(asset));
    return table("stages", element("tr", groups) + element("tr", names), rows);
}

Html textureTable(const Json& asset) {
    Html rows;
    for (const Json& texture : list(asset, "textures"))
        rows += element("tr", element("th", {{"scope", "row"}}, text(words(member(texture, "role")))) +
                                  element("td", text(words(member(texture, "format")))) +
                                  numberCell(bytesMarkup(count(member(texture, "bytes_gpu")))) +
                                  element("td", {{"class", "file"}}, text(words(member(texture, "file")))));
    if (rows.isEmpty()) return {};
    return table("textures", element("tr", headCell("Texture") + headCell("Format") + headCell("GPU", "num") + headCell("File")), rows);
}

/// What a note's count counts.
std::string noteWords(const std::string& key) {
    static const std::array<std::pair<const char*, const char*>, 9> kNotes = {
        {{"covered_texels", "Texels inside charts"},
         {"beyond_positive_bounds", "Texels whose coefficients no positive light could give"},
         {"repaired_not_finite", "Texels set to zero because a coefficient was not finite"},
         {"repaired_negative_dc", "Channels set to zero because their mean was negative"},
         {"repaired_texels", "Texels repaired because they were negative or not finite"},
         {"negative_after_gamut", "Values negative in the working colour space"},
         {"clamped_high", "Values clamped to the format's largest"},
         {"clamped_negative", "Negative values clamped to zero, all an unsigned format holds"},
         {"window_lambda", "Strength of the window against ringing (lambda)"}}};
    for (const auto& [name, meaning] : kNotes)
        if (key == name) return meaning;
    std::string spaced = key;
    std::replace(spaced.begin(), spaced.end(), '_', ' ');
    return spaced;
}

Html valueMarkup(const Json& value) {
    if (value.is_number_integer()) return text(groupedCount(count(value)));
    if (value.is_number_float() || value.is_null()) return withTitle(humanNumber(number(value)), exactNumber(number(value)));
    return text(words(value));
}

/// Term and value for each of an object's entries; objects inside give their entries "outer inner". Zeros say nothing and are left out.
Html entries(const Json& object, const std::string& prefix) {
    Html rows;
    if (!object.is_object()) return rows;
    for (const auto& [key, value] : object.items()) {
        if (value.is_object())
            rows += entries(value, prefix + noteWords(key) + " ");
        else if (!value.is_number() || value.get<double>() != 0)
            rows += element("div", element("dt", text(prefix + noteWords(key))) + element("dd", valueMarkup(value)));
    }
    return rows;
}

Html meshError(const Json& error) {
    Html rows;
    constexpr std::array<std::pair<const char*, const char*>, 3> kTerms = {
        {{"position", "Largest shift of a position [scene units]"},
         {"normal_radians", "Largest turn of a normal [rad]"},
         {"light_map_uv", "Largest shift of a light-map UV [of the map's side]"}}};
    if (error.is_object())
        for (const auto& [key, meaning] : kTerms)
            if (error.contains(key)) rows += fact(meaning, valueMarkup(error.at(key)));
    return rows;
}

Html notes(const Json& asset) {
    const Html rows = entries(member(asset, "notes"), "") + meshError(member(asset, "mesh_error")) + entries(member(asset, "measures"), "");
    return rows.isEmpty() ? Html() : element("div", {{"class", "notes"}}, element("h3", word("Notes")) + element("dl", rows));
}

double relRms(const Json& candidate, const char* shading) {
    return number(member(candidate, shading));
}
/// What a bound on both errors would ask of it.
double worseError(const Json& candidate) {
    return std::max(relRms(candidate, "diffuse"), relRms(candidate, "specular"));
}

/// Of the candidates: the chosen one, the best of the smaller, and the smallest of those that are better.
struct Alternatives {
    const Json *chosen = nullptr, *cheaper = nullptr, *better = nullptr;

    Alternatives(const Json& candidates, const std::string& layout) {
        const auto bytes = [](const Json* candidate) { return count(member(*candidate, "bytes_gpu")); };
        for (const Json& each : candidates)
            if (words(member(each, "layout")) == layout) chosen = &each;
        if (chosen == nullptr) return;
        for (const Json& each : candidates) {
            if (bytes(&each) < bytes(chosen) && (cheaper == nullptr || worseError(each) < worseError(*cheaper))) cheaper = &each;
            if (worseError(each) < worseError(*chosen) && (better == nullptr || bytes(&each) < bytes(better))) better = &each;
        }
    }
    const char* roleOf(const Json& candidate) const {
        return &candidate == chosen    ? " (chosen)"
               : &candidate == cheaper ? " (next cheaper)"
               : &candidate == better  ? " (next better)"
                                       : "";
    }
};

Html candidateCurve(const Json& asset) {
    std::vector<CurvePoint> points;
    for (const Json& each : list(asset, "trial_candidates"))
        points.push_back({words(member(each, "layout")), number(member(each, "bits_per_texel")), relRms(each, "diffuse"),
                          relRms(each, "specular"), words(member(each, "layout")) == words(member(asset, "layout"))});
    return errorCurve(points, number(member(member(asset, "limit"), "value")));
}

/// What else this map could have been, smallest first.
Html candidateTable(const Json& asset) {
    const Json& candidates = list(asset, "trial_candidates");
    if (candidates.empty()) return {};
    const Alternatives alternatives(candidates, words(member(asset, "layout")));
    Html rows;
    for (const Json& each : candidates) {
        rows += element("tr", &each == alternatives.chosen ? Attributes{{"class", "total"}} : Attributes{},
                        element("th", {{"scope", "row"}}, text(words(member(each, "layout")) + alternatives.roleOf(each))) +
                            numberCell(bytesMarkup(count(member(each, "bytes_gpu")))) +
                            numberCell(text(humanNumber(number(member(each, "bits_per_texel"))))) +
                            numberCell(figureMarkup(each, "diffuse")) + numberCell(figureMarkup(each, "specular")));
    }
    const Html head = headCell("Candidate") + headCell("GPU", "num") + headCell("Bits per texel", "num") +
                      headCell("Diffuse rel_rms", "num") + headCell("Specular rel_rms", "num");
    return element("div", {{"class", "notes"}},
                   element("h3", word("Layouts tried")) + candidateCurve(asset) + table("candidates", element("tr", head), rows));
}

constexpr std::array kTruthParts = {"truncation", "fit", "quantization", "total", "with_rest", "two_lights"};

Html truthRow(const std::string& name, const Json& errors) {
    Html cells = element("th", {{"scope", "row"}}, text(name));
    for (const char* part : kTruthParts) cells += numberCell(errors.contains(part) ? figureMarkup(errors, part) : text(kDash));
    return element("tr", cells);
}

/// Of one way to shade: all values, and those of each roughness.
Html truthRows(const std::string& name, const Json& errors) {
    if (!errors.is_object()) return {};
    Html rows = truthRow(name, errors);
    for (const Json& each : list(errors, "by_m"))
        if (each.is_object()) rows += truthRow("m " + humanNumber(number(member(each, "m"))), each);
    return rows;
}

/// Traced light, and whose the difference is.
Html groundTruth(const Json& asset) {
    const Json& truth = member(asset, "ground_truth");
    const Html rows = truthRows("Lambert", member(truth, "lambert")) +
                      truthRows("Area specular of the nine coefficients", member(truth, "area_specular")) +
                      truthRows("Specular of the dominant light", member(truth, "specular"));
    if (rows.isEmpty()) return {};
    const Html head = headCell("Against traced light, rel_rms") + headCell("Nine coefficients", "num") + headCell("One light", "num") +
                      headCell("Cooking", "num") + headCell("Total", "num") + headCell("With area specular of the rest", "num") +
                      headCell("Two lights", "num");
    const Json &specular = member(truth, "specular"), &isFit = member(truth, "fit_is_largest");
    Html told;
    if (isFit.is_boolean() && isFit.get<bool>())
        told = element(
            "p", text(fmt::format("One light cannot explain this scene: its fit is the largest of the three parts. A second light "
                                  "would take it from {} to {}.",
                                  humanPercent(number(member(specular, "fit"))), humanPercent(number(member(specular, "two_lights"))))));
    return element("div", {{"class", "notes"}},
                   element("h3", text(fmt::format("Ground truth: {} values", groupedCount(count(member(truth, "values")))))) +
                       table("truth", element("tr", head), rows) + told);
}

Html assetFacts(const Json& asset) {
    const std::string size = sizeWords(asset);
    const double bits = number(member(asset, "bits_per_texel"));
    Html facts = fact("Kind", swatch(words(member(asset, "kind"))) + text(words(member(asset, "kind")))) +
                 fact("Layout", text(words(member(asset, "layout"))));
    if (!size.empty()) facts += fact("Size", text(size));
    if (count(member(asset, "bytes_in")) > 0) facts += fact("Read", bytesMarkup(count(member(asset, "bytes_in"))));
    facts += fact("GPU", bytesMarkup(count(member(asset, "bytes_gpu")))) + fact("Disk", bytesMarkup(count(member(asset, "bytes_disk"))));
    if (bits > 0) facts += fact("Bits/texel", withTitle(humanNumber(bits), exactNumber(bits)));
    facts +=
        fact("Cooked in", secondsMarkup(member(asset, "seconds"))) + fact("Verified in", secondsMarkup(member(asset, "verify_seconds")));
    if (const Json& key = member(asset, "key"); key.is_number())
        facts += fact("Key", withTitle(humanNumber(number(key)), exactNumber(number(key))));
    return element("dl", {{"class", "facts small"}}, facts);
}

Html assetSection(const std::filesystem::path& folder, const Json& asset, std::size_t index) {
    const Html title = element("div", {{"class", "title"}}, element("h2", text(words(member(asset, "name")))) + verdictChip(passed(asset)));
    const Html lists = textureTable(asset) + notes(asset);
    return element("section", {{"class", "card asset"}, {"id", assetAnchor(index)}},
                   title + assetFacts(asset) + pictures(folder, asset) + stageTable(asset) + groundTruth(asset) + candidateTable(asset) +
                       (lists.isEmpty() ? lists : element("div", {{"class", "pair"}}, lists)));
}

// What was left out, and what the words mean

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
         {"local relative error", "|error| / (|reference| + 0.02 key). p99, max sampled and the proven bound are of this one"},
         {"key", "the log-average, over the map, of the luminance of the exit radiance at each texel's own normal"},
         {"p99, max sampled", "99 of 100 samples are below p99; max sampled is the largest that was seen"},
         {"proven bound", "no normal, view, material or sub-texel position can exceed it: computed, not sampled"}}};
    Html terms;
    for (const auto& [term, meaning] : kTerms) terms += element("dt", word(term)) + element("dd", word(meaning));
    return element("footer", element("h2", word("What the figures mean")) + element("dl", terms));
}

Html pageHead(const Json& report) {
    const std::string title = words(member(report, "scene")) + (passed(report) ? ": passed" : ": failed");
    return element("head", voidElement("meta", {{"charset", "utf-8"}}) +
                               voidElement("meta", {{"name", "viewport"}, {"content", "width=device-width, initial-scale=1"}}) +
                               voidElement("meta", {{"name", "color-scheme"}, {"content", "light dark"}}) + element("title", text(title)) +
                               element("style", raw(reportStyle())));
}

}  // namespace

std::string renderReportHtml(const Json& report, const std::filesystem::path& folder) {
    const Json& assets = list(report, "assets");
    Html main = header(report) + failures(report) + memory(report) + wholeSection(member(report, "whole")) + allAssets(report);
    for (std::size_t i = 0; i < assets.size(); ++i) main += assetSection(folder, assets[i], i);
    main += skips(report) + footnote();
    const Html page = element("html", {{"lang", "en"}}, pageHead(report) + element("body", element("main", main)));
    return "<!DOCTYPE html>\n" + page.markup() + "\n";
}

}  // namespace pipeline
