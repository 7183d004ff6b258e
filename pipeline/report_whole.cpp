#include "pipeline/report_whole.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/whole_error.h"

namespace pipeline {
namespace {

const Json& member(const Json& object, const char* key) {
    static const Json kAbsent;
    const auto found = object.find(key);
    return found == object.end() ? kAbsent : *found;
}
double number(const Json& object, const char* key) {
    const Json& found = member(object, key);
    return found.is_number() ? found.get<double>() : std::numeric_limits<double>::quiet_NaN();
}
std::string words(const Json& object, const char* key) {
    const Json& found = member(object, key);
    return found.is_string() ? found.get<std::string>() : "";
}
/// An empty array stands for what is no array.
const Json& list(const Json& object, const char* key) {
    static const Json kEmpty = Json::array();
    const Json& found = member(object, key);
    return found.is_array() ? found : kEmpty;
}

Html percentMarkup(double ratio) {
    return element("span", {{"title", exactNumber(ratio)}}, text(humanPercent(ratio)));
}
Html numberCell(const Html& content) {
    return element("td", {{"class", "num"}}, content);
}
Html head(std::initializer_list<std::pair<const char*, const char*>> columns) {
    Html cells;
    for (const auto& [name, kind] : columns) cells += element("th", {{"scope", "col"}, {"class", kind}}, text(name));
    return element("thead", element("tr", cells));
}
Html table(const Html& headRow, const Html& rows) {
    return element("div", {{"class", "scroll"}}, element("table", {{"class", "shares"}}, headRow + element("tbody", rows)));
}
/// A name, and smaller under it what else is to be said.
Html nameCell(const Html& name, const std::string& more) {
    return element("th", {{"scope", "row"}}, name + (more.empty() ? Html() : element("span", {{"class", "sub"}}, text(more))));
}

Html bar(const Json& whole) {
    Html segments;
    for (const Json& part : list(whole, "parts")) {
        const double share = number(part, "share");
        if (!(share > 0)) continue;
        const std::string style = fmt::format("width:{:.3f}%;background:{}", 100 * std::min(share, 1.0), kindColor(words(part, "kind")));
        const std::string title = fmt::format("{}, {}: {}", words(part, "asset"), words(part, "shading"), humanPercent(share));
        segments += element("i", {{"style", style}, {"title", title}}, {});
    }
    return element("div", {{"class", "bar"}, {"role", "img"}, {"aria-label", adviceOf(whole)}}, segments);
}

/// "alone: l0 3.00 %, code 98.0 %"
std::string stageWords(const Json& part) {
    std::string stages;
    for (const Json& stage : list(part, "stages"))
        if (const double share = number(stage, "share"); share > 0)
            stages += fmt::format("{}{} {}", stages.empty() ? "alone: " : ", ", words(stage, "name"), humanPercent(share));
    return stages;
}

Html partRow(const Json& part, double light) {
    const double own = number(part, "light_rms");
    const Html swatch = element("span", {{"class", "swatch"}, {"style", "background:" + kindColor(words(part, "kind"))}}, {});
    return element("tr", nameCell(swatch + text(words(part, "asset")), stageWords(part)) +
                             element("td", {{"class", "shading"}}, text(words(part, "shading"))) +
                             numberCell(percentMarkup(number(part, "share"))) + numberCell(percentMarkup(number(part, "rel_rms"))) +
                             numberCell(percentMarkup(light > 0 ? own / light : std::numeric_limits<double>::quiet_NaN())));
}

Html parts(const Json& whole) {
    Html rows;
    for (const Json& part : list(whole, "parts")) rows += partRow(part, number(whole, "light_rms"));
    return table(head({{"Asset", ""}, {"Light", ""}, {"Share of the error", "num"}, {"rel_rms of its light", "num"}, {"Its light", "num"}}),
                 rows);
}

Html lightMaps(const Json& whole) {
    Html rows;
    for (const Json& map : list(whole, "light_maps"))
        rows +=
            element("tr", nameCell(text(words(map, "name")), adviceOf(map)) + numberCell(percentMarkup(number(map, "weight"))) +
                              numberCell(percentMarkup(number(map, "rel_rms"))) + numberCell(percentMarkup(number(map, "rel_rms_bound"))));
    if (rows.isEmpty()) return {};
    return table(head({{"Light map", ""}, {"Of the texels", "num"}, {"Whole error", "num"}, {"At most", "num"}}), rows);
}

Html apart(const Json& whole) {
    std::string names;
    for (const Json& asset : list(whole, "apart"))
        names += fmt::format("{}{} ({}, {})", names.empty() ? "" : ", ", words(asset, "asset"), words(asset, "kind"),
                             humanPercent(number(asset, "rel_rms")));
    if (names.empty()) return {};
    return element("p", {{"class", "soft"}}, text("No part of what the light maps' pixels show: " + names + "."));
}

}  // namespace

Html wholeSection(const Json& whole) {
    if (!whole.is_object()) return {};
    const Html facts =
        element("div", element("dt", text("Error of the whole shading, RMS")) + element("dd", percentMarkup(number(whole, "rel_rms")))) +
        element("div",
                element("dt", text("At most, if all errors went together")) + element("dd", percentMarkup(number(whole, "rel_rms_bound"))));
    return element("section", {{"class", "card"}},
                   element("h2", text("Whole shading")) + element("dl", {{"class", "facts whole-facts"}}, facts) + bar(whole) +
                       element("p", {{"class", "sentence"}}, text(adviceOf(whole))) + parts(whole) + lightMaps(whole) + apart(whole));
}

}  // namespace pipeline
