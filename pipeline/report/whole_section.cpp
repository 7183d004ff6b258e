#include "pipeline/report/whole_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/report/captions.h"
#include "pipeline/report/page_parts.h"
#include "pipeline/report/scene_error.h"

namespace lightcook::pipeline {
namespace {

/// Returns a name over a smaller second line.
Html nameCell(const Html& name, const std::string& more) {
    return element("th", {{"scope", "row"}}, name + (more.empty() ? Html() : element("span", {{"class", "sub"}}, text(more))));
}

bool isPositive(double share) {
    return std::isfinite(share) && share > 0;
}

Html bar(const ShadingError& shading) {
    Html segments;
    for (const ErrorPart& part : shading.parts) {
        if (!isPositive(part.share)) continue;
        const std::string style =
            fmt::format("width:{:.3f}%;background:{}", 100 * std::min(part.share, 1.0), kindColor(std::string(info(part.kind).name)));
        const std::string title = fmt::format("{}, {}: {}", part.asset, part.shading, humanPercent(part.share));
        segments += element("i", {{"style", style}, {"title", title}}, {});
    }
    return element("div", {{"class", "bar"}, {"role", "img"}, {"aria-label", adviceOf(shading)}}, segments);
}

/// Returns "each alone: mean light 3.00 %, directions 98.0 %", of the squared error. Errors of stages cancel in part, so that one alone can
/// be larger than the whole.
std::string stageWords(const ErrorPart& part) {
    std::string stages;
    for (const StageShare& stage : part.stages) {
        if (!isPositive(stage.share)) continue;
        const std::string share = stage.share <= 1 ? humanPercent(stage.share) : humanNumber(stage.share) + " times";
        stages += fmt::format("{}{} {}", stages.empty() ? "each alone: " : ", ", stageCaption(stage.name), share);
    }
    return stages;
}

Html partRow(const ErrorPart& part, double light) {
    const double ownShare = isPositive(light) ? part.lightRms / light : std::numeric_limits<double>::quiet_NaN();
    return element("tr", nameCell(swatch(std::string(info(part.kind).name)) + text(part.asset), stageWords(part)) +
                             element("td", {{"class", "shading"}}, text(part.shading)) + numberCell(percentMarkup(part.share)) +
                             numberCell(percentMarkup(part.relRms)) + numberCell(percentMarkup(ownShare)));
}

Html parts(const ShadingError& shading) {
    Html rows;
    for (const ErrorPart& part : shading.parts)
        if (part.share != 0) rows += partRow(part, shading.lightRms);
    if (rows.isEmpty()) return {};
    const Html head = headCell("Asset") + headCell("Light") + headCell("Share of the squared error", "num") +
                      headCell("rel_rms of its light", "num") + headCell("Its light, of all", "num");
    return table("shares", element("tr", head), rows);
}

/// Returns what "each alone" means, if the table has it.
Html stageNote(const ShadingError& shading) {
    if (std::ranges::none_of(shading.parts, [](const ErrorPart& part) { return part.share != 0 && !stageWords(part).empty(); })) return {};
    return element(
        "p", {{"class", "soft"}},
        word("Each alone: the squared error of the scene if only that stage erred. Errors of stages cancel in part, so one can be "
             "larger than the sum."));
}

Html lightMaps(const SceneError& whole) {
    Html rows;
    for (const LightMapError& map : whole.lightMaps)
        rows += element("tr", nameCell(text(map.name), adviceOf(map.shading)) + numberCell(percentMarkup(map.weight)) +
                                  numberCell(percentMarkup(map.shading.relRms)) + numberCell(percentMarkup(map.shading.relRmsBound)));
    if (rows.isEmpty()) return {};
    const Html head =
        headCell("Light map") + headCell("Of the texels", "num") + headCell("Whole error", "num") + headCell("At most", "num");
    return table("shares", element("tr", head), rows);
}

Html apart(const SceneError& whole) {
    std::string names;
    for (const ApartError& each : whole.apart)
        names += fmt::format("{}{} ({}, {})", names.empty() ? "" : ", ", each.asset, kindCaption(info(each.kind).name),
                             humanPercent(each.relRms));
    if (names.empty()) return {};
    return element("p", {{"class", "soft"}}, text("No part of what the light maps' pixels show: " + names + "."));
}

/// Returns the whole error, or one without figures if the report has it in another shape.
SceneError readWhole(const Json& json) {
    auto whole = fromJson<SceneError>(json, "whole");
    if (whole) return std::move(*whole);
    SceneError unknown;
    unknown.shading.relRms = unknown.shading.relRmsBound = std::numeric_limits<double>::quiet_NaN();
    return unknown;
}

}  // namespace

Html wholeSection(const Json& json) {
    if (!json.is_object()) return {};
    const SceneError whole = readWhole(json);
    Html facts = fact("Error of the whole shading, RMS", percentMarkup(whole.shading.relRms)) +
                 fact("At most, if all errors went together", percentMarkup(whole.shading.relRmsBound));
    if (whole.shading.visibleRms)
        facts += fact("Visible error, RMS", text(humanNumber(*whole.shading.visibleRms))) +
                 fact("At most, if all errors went together", text(humanNumber(whole.shading.visibleRmsBound.value_or(0))));
    return card("Error of the whole shading", element("dl", {{"class", "facts whole-facts"}}, facts) + bar(whole.shading) +
                                                  element("p", {{"class", "sentence"}}, text(adviceOf(whole.shading))) +
                                                  parts(whole.shading) + stageNote(whole.shading) + lightMaps(whole) + apart(whole));
}

}  // namespace lightcook::pipeline
