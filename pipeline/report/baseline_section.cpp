#include "pipeline/report/baseline_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "pipeline/report/baseline.h"
#include "pipeline/report/page_parts.h"

namespace lightcook::pipeline {
namespace {

/// Returns "+2.50 %", "-10.00 %" or a dash.
Html percentChange(const Json& percent) {
    const double value = percent.is_number() ? percent.get<double>() : std::nan("");
    return std::isfinite(value) ? withTitle(fmt::format("{:+.2f} %", value), exactNumber(value)) : text("–");
}

Html bytesCell(const Json& figures) {
    return numberCell(figures.is_object() ? bytesMarkup(count(member(figures, "bytes_gpu"))) : text("–"));
}

/// Returns "1.20 % → 1.31 %", and one of both where they read the same.
Html changeCell(const Html& before, const Html& now) {
    return numberCell(before.markup() == now.markup() ? now : before + text(" → ") + now);
}

/// Returns "1.20 % → 1.31 %"; a dash for light that the asset does not have.
Html errorCell(const Json& asset, const char* name) {
    const auto one = [&](const char* report) {
        const Json& figures = member(asset, report);
        return member(figures, name).is_number() ? percentMarkup(number(member(figures, name))) : text("–");
    };
    return changeCell(one("before"), one("now"));
}

/// Returns "3.10 → 3.25"; a dash for assets without visible errors.
Html visibleCell(const Json& asset) {
    const auto one = [&](const char* report) {
        const double value = number(member(member(asset, report), "visible_p99"));
        return std::isfinite(value) ? withTitle(fmt::format("{:.2f}", value), exactNumber(value)) : text("–");
    };
    return changeCell(one("before"), one("now"));
}

/// Returns a picture of the errors of an asset, or words where the file is gone.
Html pictureFigure(const Json& file, const char* role, const std::string& name) {
    const std::filesystem::path path = words(file);
    const auto picture = loadPicture(path.parent_path(), path.filename().string());
    const Html content = picture ? voidElement("img", {{"src", picture->dataUri},
                                                       {"alt", fmt::format("errors of {}, {}", name, role)},
                                                       {"width", std::to_string(picture->width)},
                                                       {"height", std::to_string(picture->height)}})
                                 : element("div", {{"class", "missing"}}, text(words(file).empty() ? "no picture is left" : words(file)));
    return element("figure", content + element("figcaption", element("b", text(name)) + text(std::string(", ") + role)));
}

}  // namespace

Html grownErrorPictures(const Json& asset, const std::string& name) {
    if (!asset.is_object() || !asset.contains("picture_now")) return {};
    const Html before =
        asset.contains("picture_before") ? pictureFigure(member(asset, "picture_before"), "errors in the baseline", name) : Html();
    return element("div", {{"class", "pictures grown"}}, before + pictureFigure(member(asset, "picture_now"), "errors now", name));
}

Html baselineRow(const Json& asset, const std::string& shownName) {
    const Json &before = member(asset, "before"), &now = member(asset, "now");
    const std::string layouts = words(member(before, "layout")) == words(member(now, "layout")) || !before.is_object() || !now.is_object()
                                    ? ""
                                    : words(member(before, "layout")) + " → " + words(member(now, "layout"));
    const Html name = text(shownName) + (layouts.empty() ? Html() : element("span", {{"class", "sub"}}, text(layouts)));
    std::string change = words(member(asset, "change"));
    if (before.is_object() && now.is_object() && passed(before) != passed(now)) change += passed(now) ? ", passes now" : ", fails now";
    return element("tr", element("th", {{"scope", "row"}}, name) + bytesCell(before) + bytesCell(now) +
                             numberCell(percentChange(member(asset, "growth_percent"))) + errorCell(asset, "diffuse_rel_rms") +
                             errorCell(asset, "specular_rel_rms") + visibleCell(asset) + element("td", text(change)));
}

Html baselineTable(const Html& rows) {
    const Html head = headCell("Asset") + headCell("GPU before", "num") + headCell("GPU now", "num") + headCell("Growth", "num") +
                      headCell("Diffuse rel_rms", "num") + headCell("Specular rel_rms", "num") + headCell("Visible p99", "num") +
                      headCell("Change");
    return table("baseline", element("tr", head), rows);
}

Html baselineSection(const Json& baseline) {
    if (!baseline.is_object()) return {};
    // The largest growth stands first.
    std::vector<const Json*> assets;
    for (const Json& asset : list(baseline, "assets")) assets.push_back(&asset);
    const auto growth = [](const Json& asset) {
        const auto bytes = [&](const char* report) { return static_cast<std::int64_t>(count(member(member(asset, report), "bytes_gpu"))); };
        return bytes("now") - bytes("before");
    };
    std::ranges::stable_sort(assets, [&](const Json* a, const Json* b) { return growth(*a) > growth(*b); });
    Html rows, pictures;
    for (const Json* asset : assets) {
        rows += baselineRow(*asset, words(member(*asset, "name")));
        pictures += grownErrorPictures(*asset, words(member(*asset, "name")));
    }
    const std::uint64_t before = count(member(baseline, "bytes_before")), now = count(member(baseline, "bytes_now"));
    rows += element("tr", {{"class", "total"}},
                    element("th", {{"scope", "row"}}, word("Together")) + numberCell(bytesMarkup(before)) + numberCell(bytesMarkup(now)) +
                        numberCell(isNew(before, now) ? word("new") : percentChange(member(baseline, "growth_percent"))) +
                        element("td", {}) + element("td", {}) + element("td", {}) + element("td", verdictChip(passed(baseline))));
    const Json& allowed = member(baseline, "allowed_percent");
    const Html limit = allowed.is_number() ? text("At most ") + percentChange(allowed) + text(" of GPU memory passes.")
                                           : word("No growth was forbidden (--fail-over).");
    return card("Compared with the baseline", element("p", {{"class", "soft"}}, text(words(member(baseline, "file")) + ". ") + limit) +
                                                  baselineTable(rows) +
                                                  (pictures.isEmpty() ? Html() : element("h3", word("Where errors grew")) + pictures));
}

}  // namespace lightcook::pipeline
