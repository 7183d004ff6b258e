#include "pipeline/report/whole_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "pipeline/report/page_parts.h"
#include "pipeline/report/whole_error.h"

namespace lightcook::pipeline {
namespace {

/// Returns a name over a smaller second line.
Html nameCell(const Html& name, const std::string& more) {
    return element("th", {{"scope", "row"}}, name + (more.empty() ? Html() : element("span", {{"class", "sub"}}, text(more))));
}

Html bar(const Json& whole) {
    Html segments;
    for (const Json& part : list(whole, "parts")) {
        const double share = number(member(part, "share"));
        if (!(share > 0)) continue;
        const std::string style =
            fmt::format("width:{:.3f}%;background:{}", 100 * std::min(share, 1.0), kindColor(words(member(part, "kind"))));
        const std::string title =
            fmt::format("{}, {}: {}", words(member(part, "asset")), words(member(part, "shading")), humanPercent(share));
        segments += element("i", {{"style", style}, {"title", title}}, {});
    }
    return element("div", {{"class", "bar"}, {"role", "img"}, {"aria-label", adviceOf(whole)}}, segments);
}

/// Returns "alone: l0 3.00 %, code 98.0 %".
std::string stageWords(const Json& part) {
    std::string stages;
    for (const Json& stage : list(part, "stages"))
        if (const double share = number(member(stage, "share")); share > 0)
            stages += fmt::format("{}{} {}", stages.empty() ? "alone: " : ", ", words(member(stage, "name")), humanPercent(share));
    return stages;
}

Html partRow(const Json& part, double light) {
    const double own = number(member(part, "light_rms"));
    return element("tr", nameCell(swatch(words(member(part, "kind"))) + text(words(member(part, "asset"))), stageWords(part)) +
                             element("td", {{"class", "shading"}}, text(words(member(part, "shading")))) +
                             numberCell(percentMarkup(number(member(part, "share")))) +
                             numberCell(percentMarkup(number(member(part, "rel_rms")))) +
                             numberCell(percentMarkup(light > 0 ? own / light : std::numeric_limits<double>::quiet_NaN())));
}

Html parts(const Json& whole) {
    Html rows;
    for (const Json& part : list(whole, "parts")) rows += partRow(part, number(member(whole, "light_rms")));
    const Html head = headCell("Asset") + headCell("Light") + headCell("Share of the error", "num") +
                      headCell("rel_rms of its light", "num") + headCell("Its light", "num");
    return table("shares", element("tr", head), rows);
}

Html lightMaps(const Json& whole) {
    Html rows;
    for (const Json& map : list(whole, "light_maps"))
        rows += element("tr", nameCell(text(words(member(map, "name"))), adviceOf(map)) +
                                  numberCell(percentMarkup(number(member(map, "weight")))) +
                                  numberCell(percentMarkup(number(member(map, "rel_rms")))) +
                                  numberCell(percentMarkup(number(member(map, "rel_rms_bound")))));
    if (rows.isEmpty()) return {};
    const Html head =
        headCell("Light map") + headCell("Of the texels", "num") + headCell("Whole error", "num") + headCell("At most", "num");
    return table("shares", element("tr", head), rows);
}

Html apart(const Json& whole) {
    std::string names;
    for (const Json& asset : list(whole, "apart"))
        names += fmt::format("{}{} ({}, {})", names.empty() ? "" : ", ", words(member(asset, "asset")), words(member(asset, "kind")),
                             humanPercent(number(member(asset, "rel_rms"))));
    if (names.empty()) return {};
    return element("p", {{"class", "soft"}}, text("No part of what the light maps' pixels show: " + names + "."));
}

}  // namespace

Html wholeSection(const Json& whole) {
    if (!whole.is_object()) return {};
    const Html facts = fact("Error of the whole shading, RMS", percentMarkup(number(member(whole, "rel_rms")))) +
                       fact("At most, if all errors went together", percentMarkup(number(member(whole, "rel_rms_bound"))));
    return card("Whole shading", element("dl", {{"class", "facts whole-facts"}}, facts) + bar(whole) +
                                     element("p", {{"class", "sentence"}}, text(adviceOf(whole))) + parts(whole) + lightMaps(whole) +
                                     apart(whole));
}

}  // namespace lightcook::pipeline
