#include "pipeline/report/seam_section.h"

#include <fmt/format.h>

#include "pipeline/report/captions.h"
#include "pipeline/report/failures.h"
#include "pipeline/report/page_parts.h"
#include "pipeline/report/picture_figure.h"

namespace lightcook::pipeline {
namespace {

/// Returns the words for a seam: its kind of shading and the place in the world.
std::string seamName(const Json& seam) {
    const std::string maps = mapsOfSeam(seam), between = maps.empty() ? "" : ", " + maps;
    return fmt::format("{}, at {}{}", words(member(seam, "shading")), vectorWords(member(seam, "position")), between);
}

std::string sidesOf(const Json& pair) {
    if (!pair.is_array() || pair.size() != 2) return kDash;
    return vectorWords(pair[0]) + " | " + vectorWords(pair[1]);
}

/// Returns a row of figures: those of both kinds of shading.
Html stepCells(const Json& diffuse, const Json& specular, bool hasSpecular) {
    Html cells = numberCell(visibleNumber(diffuse, "p99")) + numberCell(visibleNumber(diffuse, "max"));
    if (hasSpecular) cells += numberCell(visibleNumber(specular, "p99")) + numberCell(visibleNumber(specular, "max"));
    return cells;
}

Html stepRow(const std::string& name, const Html& cells, bool isLast) {
    return element("tr", {{"class", isLast ? "last" : ""}}, element("th", {{"scope", "row"}}, text(name)) + cells);
}

Html stepTable(const Json& seams) {
    const Json& stages = list(seams, "stages");
    const bool hasSpecular = seams.contains("bake_specular");
    Html groups = headCell("Steps between both sides", "", {{"rowspan", "2"}}) + headCell("diffuse", "group", {{"colspan", "2"}});
    Html names = headCell("p99", "num first") + headCell("max", "num");
    if (hasSpecular) {
        groups += headCell("specular", "group", {{"colspan", "2"}});
        names += headCell("p99", "num first") + headCell("max", "num");
    }
    Html rows = stepRow("bake", stepCells(member(seams, "bake_diffuse"), member(seams, "bake_specular"), hasSpecular), false);
    for (const Json& stage : stages)
        for (const char* kind : {"cooked", "added"}) {
            const bool isLast = &stage == &stages.back() && std::string_view(kind) == "added";
            rows +=
                stepRow(fmt::format("{}, {}", kind, stageCaption(words(member(stage, "name")))),
                        stepCells(member(member(stage, "diffuse"), kind), member(member(stage, "specular"), kind), hasSpecular), isLast);
        }
    return table("stages seams", element("tr", groups) + element("tr", names), rows);
}

Html worstRows(const Json& seams, const char* key) {
    Html rows;
    for (const Json& seam : list(seams, key))
        rows += element("tr", element("th", {{"scope", "row"}}, text(seamName(seam))) + numberCell(visibleNumber(seam, "added")) +
                                  numberCell(visibleNumber(seam, "bake_step")) + numberCell(visibleNumber(seam, "cooked_step")) +
                                  element("td", text(sidesOf(member(seam, "texels")))) +
                                  element("td", text(sidesOf(member(seam, "reference")))) +
                                  element("td", text(sidesOf(member(seam, "found")))));
    return rows;
}

Html seamTable(const Json& seams, const char* key, const char* title) {
    const Html rows = worstRows(seams, key);
    if (rows.isEmpty()) return {};
    return table("worst seams",
                 element("tr", headCell(title) + headCell("Added", "num") + headCell("Bake", "num") + headCell("Cooked", "num") +
                                   headCell("Texels") + headCell("Light of the bake") + headCell("Cooked light")),
                 rows);
}

/// drawn  views of the worst seams, in their order
Html views(const StagedFolder& folder, const Json& drawn, const Json& seams) {
    const Json& worst = list(seams, "worst");
    Html content;
    for (std::size_t i = 0; i < drawn.size() && i < worst.size(); ++i) {
        const auto figure = [&](const char* role, const char* name) {
            return pictureFigure(folder, words(member(drawn[i], role)), std::string(name) + ", seen around the seam " + seamName(worst[i]),
                                 element("b", word(name)) + text(", the mesh around the seam " + seamName(worst[i])), true);
        };
        content +=
            element("div", element("div", {{"class", "pictures lit views"}}, figure("reference", "Bake") + figure("cooked", "Cooked")));
    }
    return content.isEmpty() ? content : element("div", {{"class", "columns"}}, content);
}

std::string countsOf(const Json& seams) {
    const auto number = [&](const char* key) { return groupedCount(count(member(seams, key))); };
    return fmt::format(
        "{} places of {} edges that two charts share; {} edges are inside charts, {} are hard, {} belong to one triangle alone.",
        number("places"), number("edges"), number("joined_edges"), number("hard_edges"), number("open_edges"));
}

}  // namespace

Html seamSection(const StagedFolder& folder, const Json& asset) {
    const Json& seams = member(asset, "seams");
    if (!seams.is_object()) return {};
    const std::string note = words(member(seams, "note"));
    Html content = element("h3", word("Seams, in just noticeable differences"));
    if (!note.empty())
        return element("div", {{"class", "notes"}}, content + element("p", {{"class", "soft"}}, text("Not measured: " + note + ".")));
    content += element("p", {{"class", "soft"}}, text(countsOf(seams))) + stepTable(seams) +
               seamTable(seams, "worst", "Largest steps that cooking adds") +
               views(folder, list(member(asset, "preview"), "seams"), seams) +
               seamTable(seams, "worst_of_bake", "Largest steps of the bake itself");
    return element("div", {{"class", "notes"}}, content);
}

std::string mapsOfSeam(const Json& seam) {
    const Json& maps = list(seam, "maps");
    return maps.size() == 2 ? fmt::format("between '{}' and '{}'", words(maps[0]), words(maps[1])) : "";
}

Html splitSeamSection(const StagedFolder& folder, const Json& asset) {
    const Json& seams = member(asset, "split_seams");
    if (!seams.is_object()) return {};
    std::string maps;
    for (const Json& map : list(seams, "maps")) maps += fmt::format("{}'{}'", maps.empty() ? "" : ", ", words(map));
    Html content = element("h3", text(fmt::format("Seams between the maps {}, in just noticeable differences", maps)));
    if (const std::string note = words(member(seams, "note")); !note.empty())
        return element("div", {{"class", "notes"}}, content + element("p", {{"class", "soft"}}, text("Not measured: " + note + ".")));
    const auto number = [&](const char* key) { return groupedCount(count(member(seams, key))); };
    const std::string counts = fmt::format(
        "{} places of {} edges whose sides lie in two of the maps. Of the edges of all maps together {} are hard, {} belong to "
        "one triangle alone.",
        number("places"), number("edges"), number("hard_edges"), number("open_edges"));
    content += element("p", {{"class", "soft"}}, text(counts)) + stepTable(seams) +
               seamTable(seams, "worst", "Largest steps that cooking adds") + views(folder, list(seams, "views"), seams) +
               seamTable(seams, "worst_of_bake", "Largest steps of the bake itself");
    return element("div", {{"class", "notes"}}, content);
}

}  // namespace lightcook::pipeline
