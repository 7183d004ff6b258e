#include "pipeline/report/asset_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/assets/asset_kind.h"
#include "pipeline/assets/light_map/small_charts.h"
#include "pipeline/assets/light_map/unpacked_errors.h"
#include "pipeline/report/alternatives.h"
#include "pipeline/report/captions.h"
#include "pipeline/report/chart_section.h"
#include "pipeline/report/failures.h"
#include "pipeline/report/layout_curve.h"
#include "pipeline/report/page_parts.h"
#include "pipeline/report/picture_figure.h"
#include "pipeline/report/seam_section.h"
#include "pipeline/report/visible_histogram.h"

namespace lightcook::pipeline {
namespace {

Html pictures(const StagedFolder& folder, const Json& asset) {
    const Json& preview = member(asset, "preview");
    if (!preview.is_object()) return {};
    const std::string kind = words(member(asset, "kind"));
    // Pictures of other assets show local errors, also beside visible figures.
    const bool isVisible =
        kind == info(AssetKind::LightMap).name && member(member(member(lastStage(asset), "error"), "diffuse"), "visible").is_object();
    // This scale shows the colour ramp of preview.cpp.
    const Html ramp = word("0") + element("span", {{"class", "heat"}}, {}) + word(isVisible ? "10 or more" : "10 % or more");
    const char *reference = ": the float bake", *cooked = ": as the shader reads it", *difference = "";
    if (kind == "lut") {
        reference = ": integrated; NoV from grazing (left) to facing, m from smooth (top) to rough, constant light off F0 0.04";
        difference = "; RMS over all lights and F0";
    } else if (kind == "mesh") {
        reference = ": the float bake, over the light map";
        cooked = ": light-map UVs moved and normals turned by the most that quantization did";
    }
    const Html differenceCaption = element("b", word("Difference")) +
                                   text(isVisible ? std::string(": visible error at the texel's own normal, the worst under each pixel")
                                                  : ": local relative error, the worst under each pixel" + std::string(difference)) +
                                   element("span", {{"class", "scale"}}, ramp);
    const auto figure = [&](const char* role, const Html& caption) {
        return pictureFigure(folder, words(member(preview, role)), role, caption,
                             role == std::string_view("reference") || role == std::string_view("cooked"));
    };
    Html anyNormal;
    if (preview.contains("any_normal"))
        anyNormal =
            element("details", element("summary", word("Visible error at any normal")) +
                                   element("div", {{"class", "pictures"}},
                                           figure("any_normal", word("The largest over the normals that a normal map can turn to, of "
                                                                     "every texel that the other pictures show; same scale"))));
    return element("div", {{"class", "pictures lit"}},
                   figure("reference", element("b", word("Reference")) + word(reference)) +
                       figure("cooked", element("b", word("Cooked")) + word(cooked)) + figure("difference", differenceCaption)) +
           anyNormal;
}

std::string colourWords(const Json& colour) {
    std::string out;
    for (std::size_t c = 0; c < 3; ++c)
        out += (c == 0 ? "" : ", ") + (colour.is_array() && c < colour.size() ? humanNumber(number(colour[c])) : std::string(kDash));
    return "(" + out + ")";
}

/// Returns the two pictures of a place as a camera sees it; empty without a rendered view.
Html renderedView(const StagedFolder& folder, const Json& view, const std::string& where) {
    if (!view.is_object()) return {};
    const auto figure = [&](const char* role, const char* name) {
        return pictureFigure(folder, words(member(view, role)), std::string(name) + ", seen around texel " + where,
                             element("b", word(name)) + text(", the mesh around texel " + where), true);
    };
    return element("div", element("div", {{"class", "pictures lit views"}}, figure("reference", "Bake") + figure("cooked", "Cooked")));
}

/// Returns pictures of what lies around the texels with the largest visible errors.
Html worstPlaces(const StagedFolder& folder, const Json& asset) {
    Html figures, views;
    for (const Json& place : list(member(asset, "preview"), "worst")) {
        const Json& texel = list(place, "texel");
        const std::string where = texel.size() == 2 ? fmt::format("{}, {}", count(texel[0]), count(texel[1])) : std::string(kDash);
        const Html caption = element("b", text("Texel " + where)) +
                             text(fmt::format(": visible error {}; bake {}, cooked {}", humanNumber(number(member(place, "visible"))),
                                              colourWords(member(place, "reference")), colourWords(member(place, "found"))));
        figures += pictureFigure(folder, words(member(place, "file")), "bake, cooked and visible error around texel " + where, caption);
        views += renderedView(folder, member(place, "view"), where);
    }
    if (figures.isEmpty()) return {};
    if (!views.isEmpty())
        views = element(
            "div", {{"class", "notes"}},
            element("h3", word("The worst places in the scene: the mesh from in front of each, as a white surface under the bake and "
                               "under the cooked map")) +
                element("div", {{"class", "columns"}}, views));
    return views +
           element("div", {{"class", "notes"}},
                   element("h3", word("Worst places, at the texels' own normals: bake, cooked and visible error, 24 texels across")) +
                       element("div", {{"class", "pictures worst-places"}}, figures));
}

std::vector<std::int64_t> countsOf(const Json& figures) {
    std::vector<std::int64_t> counts;
    for (const Json& each : list(member(figures, "visible"), "histogram")) counts.push_back(static_cast<std::int64_t>(count(each)));
    return counts;
}

/// Returns the histogram of the visible errors of the last stage.
Html histogram(const Json& asset) {
    const Json& error = member(lastStage(asset), "error");
    return visibleHistogram(countsOf(member(error, "diffuse")), countsOf(member(error, "specular")),
                            number(member(member(asset, "limit"), "max_visible")));
}

/// Returns the caption and the name of a stage. "On the surface" is added where the report has figures of texel centres, too.
Html stageName(const Json& stage) {
    const std::string name = words(member(stage, "name")), caption = stageCaption(name);
    const Html more = caption == name ? Html() : element("span", {{"class", "sub"}}, text(name));
    return text(caption + (stage.contains("at_texels") ? ", on the surface" : "")) + more;
}

Html stageRow(const Json& stage, bool isLast, double limit, const std::vector<const char*>& shadings) {
    Html cells = element("th", {{"scope", "row"}}, stageName(stage));
    for (const char* shading : shadings) {
        const Json& figures = member(member(stage, "error"), shading);
        cells += isLast ? limitedCell(figures, limit) : numberCell(figureMarkup(figures, "rel_rms"));
        for (const char* name : {"p99", "max_sampled"}) cells += numberCell(figureMarkup(figures, name));
    }
    return element("tr", {{"class", isLast ? "last" : ""}}, cells + numberCell(secondsMarkup(member(stage, "seconds"))));
}

Html stageTable(const Json& asset) {
    const Json& stages = list(asset, "stages");
    if (stages.empty()) return element("p", {{"class", "soft"}}, word("No stage was measured."));
    const std::vector<const char*> shadings = shadingsOf(asset);
    Html groups = headCell("After the stage", "", {{"rowspan", "2"}});
    for (const char* shading : shadings) groups += headCell(shading, "group", {{"colspan", "3"}});
    groups += headCell("Time", "num", {{"rowspan", "2"}});
    Html names, rows;
    for (std::size_t i = 0; i < shadings.size(); ++i)
        names += headCell("rel_rms", "num first") + headCell("p99", "num") + headCell("max sampled", "num");
    for (const Json& stage : stages) rows += stageRow(stage, &stage == &stages.back(), limitOf(asset), shadings);
    return table(shadings.size() == 1 ? "stages one" : "stages", element("tr", groups) + element("tr", names), rows);
}

/// Returns a table of the visible errors of each stage. Empty for assets without them.
Html visibleTable(const Json& asset) {
    constexpr std::array<std::array<const char*, 2>, 6> kFigures = {
        {{"rms", "rms"}, {"p50", "median"}, {"p99", "p99"}, {"p999", "p99.9"}, {"max", "max"}, {"bound", "bound"}}};
    const std::vector<const char*> shadings = shadingsOf(asset);
    Html names, rows;
    for (std::size_t i = 0; i < shadings.size(); ++i)
        for (const auto& [key, name] : kFigures) names += headCell(name, key == kFigures[0][0] ? "num first" : "num");
    for (const Json& stage : list(asset, "stages")) {
        const Json& error = member(stage, "error");
        if (!member(member(error, "diffuse"), "visible").is_object() && !member(member(error, "specular"), "visible").is_object()) continue;
        Html cells = element("th", {{"scope", "row"}}, stageName(stage));
        const bool isLast = &stage == &list(asset, "stages").back();
        for (const char* shading : shadings)
            for (const auto& [key, name] : kFigures) {
                const Json& figures = member(error, shading);
                const bool isLimited = isLast && (std::string_view(key) == "p99" || std::string_view(key) == "bound");
                cells += isLimited ? limitedVisibleCell(figures, key, asset) : numberCell(visibleMarkup(figures, key));
            }
        rows += element("tr", {{"class", isLast ? "last" : ""}}, cells);
    }
    if (rows.isEmpty()) return {};
    Html groups = headCell("Visible error", "", {{"rowspan", "2"}});
    for (const char* shading : shadings) groups += headCell(shading, "group", {{"colspan", "6"}});
    return table(shadings.size() == 1 ? "stages visible one" : "stages visible", element("tr", groups) + element("tr", names), rows) +
           element("div", {{"class", "curve-frame"}}, histogram(asset)) +
           element("p", {{"class", "soft"}},
                   word("In just noticeable differences (Delta E ITP): 1 is at the threshold of a trained eye, 10 is plain to see."));
}

/// Returns the errors of a light map and its dominant light together, in words. Empty where they were not verified together.
Html wholeVisible(const Json& asset) {
    const Json &whole = member(asset, "whole"), &visible = member(whole, "visible");
    if (!visible.is_object()) return {};
    const auto figure = [&](const char* key) { return humanNumber(number(member(visible, key))); };
    const Json &limit = member(whole, "max_visible"), &errorLimit = member(whole, "max_error");
    return element("p",
                   text(fmt::format("Together with its dominant light, at {} places of the surface: visible error {} (p99{}), median {}, "
                                    "p99.9 {}, max {}; rel_rms {}{}.",
                                    groupedCount(count(member(whole, "places"))), figure("p99"),
                                    limit.is_number() ? ", limit " + humanNumber(number(limit)) : "", figure("p50"), figure("p999"),
                                    figure("max"), humanPercent(number(member(whole, "rel_rms"))),
                                    errorLimit.is_number() ? " (limit " + humanPercent(number(errorLimit)) + ")" : "")));
}

/// Returns a table of the mip levels of a light map from level 1 on, with the mix of each with the larger one, and why there are no more.
/// Empty for assets that were not asked for them.
Html mipTable(const Json& asset) {
    constexpr std::array<std::array<const char*, 2>, 3> kFigures = {{{"p99", "visible p99"}, {"p999", "p99.9"}, {"bound", "bound"}}};
    const std::string end = words(member(asset, "mips_end"));
    const Json& mips = list(asset, "mips");
    if (end.empty() && mips.empty()) return {};
    const std::vector<const char*> shadings = shadingsOf(asset);
    Html groups = headCell("Mip level", "", {{"rowspan", "2"}}), names, rows;
    for (const char* shading : shadings) {
        groups += headCell(shading, "group", {{"colspan", "4"}});
        names += headCell("rel_rms", "num first");
        for (const auto& [key, name] : kFigures) names += headCell(name, "num");
    }
    const auto addRow = [&](const Json& mip) {
        Html cells = element("th", {{"scope", "row"}}, text(words(member(mip, "name"))));
        for (const char* shading : shadings) {
            const Json& figures = member(member(mip, "error"), shading);
            cells += limitedCell(figures, limitOf(asset));
            for (const auto& [key, name] : kFigures)
                cells +=
                    key == std::string_view("p999") ? numberCell(visibleMarkup(figures, key)) : limitedVisibleCell(figures, key, asset);
        }
        rows += element("tr", cells);
    };
    const Json& blends = list(asset, "mip_blends");
    for (std::size_t i = 0; i < mips.size(); ++i) {
        if (i < blends.size()) addRow(blends[i]);
        addRow(mips[i]);
    }
    const Html levels =
        rows.isEmpty() ? rows : table(shadings.size() == 1 ? "stages one" : "stages", element("tr", groups) + element("tr", names), rows);
    return element(
        "div", {{"class", "notes"}},
        element("h3", word("Mip levels")) + levels +
            element("p", {{"class", "soft"}},
                    text(fmt::format("{} level{} with level 0; no further one: {}.", mips.size() + 1, mips.empty() ? "" : "s", end))));
}

/// Returns why no layout helps the place of the largest visible error, if it lies in a chart that filters read past; else "". The page of
/// `view` says the same (viewer/src/main.js).
std::string fewTexelsWords(const Json& charts, const char* shading) {
    for (const Json& few : list(charts, "few_texels")) {
        const double texels = number(member(few, "texels"));
        if (member(few, "shading") != shading || !(texels < kFewTexels)) continue;
        return fmt::format(
            "Its chart has {}, and filters read those beside it: no layout lowers this error much. Give the chart more texels in the bake.",
            counted(static_cast<std::uint64_t>(std::max(1.0, std::round(texels))), "texel"));
    }
    return "";
}

/// Returns a row with the place of the largest visible error and both colours. Empty without one.
Html visibleRow(const char* shading, const Json& visible, const Json& charts) {
    const Json& at = member(visible, "max_at");
    if (placeWords(at).empty()) return {};
    Html where = text(placeWords(at));
    if (const std::string remark = fewTexelsWords(charts, shading); !remark.empty())
        where += element("span", {{"class", "sub"}}, text(remark));
    return element("tr", element("th", {{"scope", "row"}}, text(fmt::format("{}, largest visible error", shading))) +
                             numberCell(visibleNumber(visible, "max")) + element("td", where) +
                             numberCell(text(colourWords(member(at, "reference")))) + numberCell(text(colourWords(member(at, "found")))));
}

/// Returns a table of the places of the worst samples of the last stage, as far as they are reported. Where charts were packed, samples lie
/// in the bake as it was.
Html worstTable(const Json& asset) {
    const bool isPacked =
        std::ranges::any_of(list(asset, "stages"), [](const Json& stage) { return member(stage, "name") == kRepackedStage; });
    Html rows;
    for (const char* shading : kShadings) {
        const Json& error = member(member(lastStage(asset), "error"), shading);
        if (const Json& at = member(error, "sampled_at"); !placeWords(at).empty()) {
            const auto light = [&](const char* which) {
                const Json& value = member(at, which);
                return value.is_number() ? withTitle(humanNumber(number(value)), exactNumber(number(value))) : text(kDash);
            };
            rows += element("tr", element("th", {{"scope", "row"}}, text(fmt::format("{}, largest sample", shading))) +
                                      numberCell(figureMarkup(error, "max_sampled")) + element("td", text(placeWords(at))) +
                                      numberCell(light("reference")) + numberCell(light("found")));
        }
        rows += visibleRow(shading, member(error, "visible"), member(asset, "charts"));
    }
    if (rows.isEmpty()) return {};
    const Html head = headCell("Worst") + headCell("Error", "num") + headCell(isPacked ? "Where, in the bake" : "Where") +
                      headCell("Light", "num") + headCell("Cooked", "num");
    return table("worst", element("tr", head), rows);
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

Html valueMarkup(const Json& value) {
    if (value.is_number_integer()) return text(groupedCount(count(value)));
    if (value.is_number_float() || value.is_null()) return withTitle(humanNumber(number(value)), exactNumber(number(value)));
    return text(words(value));
}

/// Returns term and value of each entry of an object; entries of inner objects are named "outer inner". Zeros are left out.
Html entries(const Json& object, const std::string& prefix) {
    Html rows;
    if (!object.is_object()) return rows;
    for (const auto& [key, value] : object.items()) {
        if (value.is_object())
            rows += entries(value, prefix + noteCaption(key) + " ");
        else if (!value.is_number() || value.get<double>() != 0)
            rows += element("div", element("dt", text(prefix + noteCaption(key))) + element("dd", valueMarkup(value)));
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
            if (error.contains(key)) rows += fact(meaning, valueMarkup(member(error, key)));
    return rows;
}

Html notes(const Json& asset) {
    const Html rows = entries(member(asset, "notes"), "") + meshError(member(asset, "mesh_error")) + entries(member(asset, "measures"), "");
    return rows.isEmpty() ? Html() : element("div", {{"class", "notes"}}, element("h3", word("Notes")) + element("dl", rows));
}

/// Returns the role of a candidate among those that were tried, for its row.
const char* roleOf(const Json& candidate, const Alternatives& alternatives) {
    return &candidate == alternatives.chosen    ? " (chosen)"
           : &candidate == alternatives.cheaper ? " (next cheaper)"
           : &candidate == alternatives.better  ? " (next better)"
           : isExcluded(candidate)              ? " (not in layouts)"
                                                : "";
}

/// cost  member of a candidate: bits_per_texel, decode_ops or fetches
Html candidateCurve(const Json& asset, CurveUnit unit, CurveCost cost) {
    const bool isVisible = unit == CurveUnit::Visible;
    const char* const key = cost == CurveCost::BitsPerTexel ? "bits_per_texel" : cost == CurveCost::Fetches ? "fetches" : "decode_ops";
    std::vector<CurvePoint> points;
    for (const Json& each : list(asset, "trial_candidates"))
        points.push_back({words(member(each, "layout")), number(member(each, key)),
                          number(member(each, isVisible ? "visible_diffuse" : "diffuse")),
                          number(member(each, isVisible ? "visible_specular" : "specular")),
                          words(member(each, "layout")) == words(member(asset, "layout"))});
    return errorCurve(points, number(member(member(asset, "limit"), isVisible ? "max_visible" : "value")), unit, cost);
}

/// Returns error against memory and run time of the layouts that were tried.
Html candidateCurves(const Json& asset) {
    const auto titled = [](const char* title, const Html& curve) {
        return curve.isEmpty()
                   ? curve
                   : element("div", element("p", {{"class", "soft"}}, word(title)) + element("div", {{"class", "curve-frame"}}, curve));
    };
    return element("div", {{"class", "columns"}},
                   titled("Error (rel_rms) against memory", candidateCurve(asset, CurveUnit::RelRms, CurveCost::BitsPerTexel)) +
                       titled("Visible error (p99) against memory", candidateCurve(asset, CurveUnit::Visible, CurveCost::BitsPerTexel)) +
                       titled("Error against run time: operations", candidateCurve(asset, CurveUnit::RelRms, CurveCost::Operations)) +
                       titled("Error against run time: fetches", candidateCurve(asset, CurveUnit::RelRms, CurveCost::Fetches)));
}

/// Returns a table of all layouts that were tried, smallest first.
Html candidateTable(const Json& asset) {
    const Json& candidates = list(asset, "trial_candidates");
    if (candidates.empty()) return {};
    const Alternatives alternatives(asset);
    Html rows;
    for (const Json& each : candidates) {
        rows += element("tr", &each == alternatives.chosen ? Attributes{{"class", "total"}} : Attributes{},
                        element("th", {{"scope", "row"}}, text(words(member(each, "layout")) + roleOf(each, alternatives))) +
                            numberCell(bytesMarkup(bytesOfCandidate(each))) +
                            numberCell(text(humanNumber(number(member(each, "bits_per_texel"))))) +
                            numberCell(text(groupedCount(count(member(each, "fetches"))))) +
                            numberCell(text(groupedCount(count(member(each, "decode_ops"))))) + numberCell(figureMarkup(each, "diffuse")) +
                            numberCell(figureMarkup(each, "specular")) + numberCell(visibleNumber(each, "visible_diffuse")) +
                            numberCell(visibleNumber(each, "visible_specular")));
    }
    const Html head = headCell("Candidate") + headCell("GPU", "num") + headCell("Bits per texel", "num") + headCell("Fetches", "num") +
                      headCell("Operations", "num") + headCell("Diffuse rel_rms", "num") + headCell("Specular rel_rms", "num") +
                      headCell("Diffuse visible p99", "num") + headCell("Specular visible p99", "num");
    return element("div", {{"class", "notes"}},
                   element("h3", word("Layouts tried")) + candidateCurves(asset) + table("candidates", element("tr", head), rows));
}

constexpr std::array kTruthParts = {"truncation", "fit", "quantization", "total", "with_rest", "two_lights"};

Html truthRow(const std::string& name, const Json& errors) {
    Html cells = element("th", {{"scope", "row"}}, text(name));
    for (const char* part : kTruthParts) cells += numberCell(errors.contains(part) ? figureMarkup(errors, part) : text(kDash));
    return element("tr", cells);
}

/// Returns the rows of one kind of shading: one for all values, and one for each roughness.
Html truthRows(const std::string& name, const Json& errors) {
    if (!errors.is_object()) return {};
    Html rows = truthRow(name, errors);
    for (const Json& each : list(errors, "by_m"))
        if (each.is_object()) rows += truthRow("m " + humanNumber(number(member(each, "m"))), each);
    return rows;
}

/// Returns the comparison with traced light, divided among truncation, fit and quantization.
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
    Html conclusion;
    if (isFit.is_boolean() && isFit.get<bool>())
        conclusion = element(
            "p", text(fmt::format("One light cannot explain this scene: its fit is the largest of the three parts. A second light "
                                  "would take it from {} to {}.",
                                  humanPercent(number(member(specular, "fit"))), humanPercent(number(member(specular, "two_lights"))))));
    return element("div", {{"class", "notes"}},
                   element("h3", text(fmt::format("Ground truth: {} values", groupedCount(count(member(truth, "values")))))) +
                       table("truth", element("tr", head), rows) + conclusion);
}

Html assetFacts(const Json& asset) {
    const std::string size = sizeWords(asset);
    const double bits = number(member(asset, "bits_per_texel"));
    Html facts = fact("Kind", swatch(words(member(asset, "kind"))) + text(kindCaption(words(member(asset, "kind"))))) +
                 fact("Layout", text(words(member(asset, "layout"))));
    if (!size.empty()) facts += fact("Size", text(size));
    if (count(member(asset, "bytes_in")) > 0) facts += fact("Read", bytesMarkup(count(member(asset, "bytes_in"))));
    facts += fact("GPU", bytesMarkup(count(member(asset, "bytes_gpu")))) + fact("Disk", bytesMarkup(count(member(asset, "bytes_disk"))));
    if (bits > 0) facts += fact("Bits/texel", withTitle(humanNumber(bits), exactNumber(bits)));
    facts +=
        fact("Cooked in", secondsMarkup(member(asset, "seconds"))) + fact("Verified in", secondsMarkup(member(asset, "verify_seconds")));
    if (const Json& key = member(asset, "key"); key.is_number())
        facts += fact("Key", withTitle(humanNumber(number(key)), exactNumber(number(key))));
    if (const Json& worst = member(asset, "worst_block"); worst.is_object()) {
        const double visible = number(member(worst, "visible"));
        facts += fact("Worst block",
                      withTitle(fmt::format("{} at {}", humanNumber(visible), vectorWords(member(worst, "block"))), exactNumber(visible)));
    }
    return element("dl", {{"class", "facts small"}}, facts);
}

}  // namespace

Html assetSection(const StagedFolder& folder, const Json& asset, std::size_t index) {
    const Html title = element("div", {{"class", "title"}}, element("h2", text(words(member(asset, "name")))) + verdictChip(passed(asset)));
    const Html lists = textureTable(asset) + notes(asset);
    return element("section", {{"class", "card asset"}, {"id", assetAnchor(index)}},
                   title + assetFacts(asset) + pictures(folder, asset) + worstPlaces(folder, asset) + stageTable(asset) +
                       visibleTable(asset) + wholeVisible(asset) + mipTable(asset) + seamSection(folder, asset) +
                       splitSeamSection(folder, asset) + chartSection(asset) + worstTable(asset) + groundTruth(asset) +
                       candidateTable(asset) + (lists.isEmpty() ? lists : element("div", {{"class", "pair"}}, lists)));
}

}  // namespace lightcook::pipeline
