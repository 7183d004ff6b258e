#include "pipeline/report/baseline_section.h"

#include <fmt/format.h>

#include <cmath>

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

/// Returns "1.20 % → 1.31 %".
Html errorCell(const Json& asset, const char* name) {
    const auto one = [&](const char* report) {
        const Json& figures = member(asset, report);
        return figures.is_object() ? percentMarkup(number(member(figures, name))) : text("–");
    };
    return numberCell(one("before") + text(" → ") + one("now"));
}

/// Returns "3.10 → 3.25"; empty for assets without visible errors.
Html visibleCell(const Json& asset) {
    const auto one = [&](const char* report) {
        const double value = number(member(member(asset, report), "visible_p99"));
        return std::isfinite(value) ? withTitle(fmt::format("{:.2f}", value), exactNumber(value)) : text("–");
    };
    return numberCell(one("before") + text(" → ") + one("now"));
}

Html row(const Json& asset) {
    const Json &before = member(asset, "before"), &now = member(asset, "now");
    const std::string layouts = words(member(before, "layout")) == words(member(now, "layout")) || !before.is_object() || !now.is_object()
                                    ? ""
                                    : words(member(before, "layout")) + " → " + words(member(now, "layout"));
    const Html name = text(words(member(asset, "name"))) + (layouts.empty() ? Html() : element("span", {{"class", "sub"}}, text(layouts)));
    std::string change = words(member(asset, "change"));
    if (before.is_object() && now.is_object() && passed(before) != passed(now)) change += passed(now) ? ", passes now" : ", fails now";
    return element("tr", element("th", {{"scope", "row"}}, name) + bytesCell(before) + bytesCell(now) +
                             numberCell(percentChange(member(asset, "growth_percent"))) + errorCell(asset, "diffuse_rel_rms") +
                             errorCell(asset, "specular_rel_rms") + visibleCell(asset) + element("td", text(change)));
}

}  // namespace

Html baselineSection(const Json& baseline) {
    if (!baseline.is_object()) return {};
    Html rows;
    for (const Json& asset : list(baseline, "assets")) rows += row(asset);
    rows += element("tr", {{"class", "total"}},
                    element("th", {{"scope", "row"}}, word("Together")) + numberCell(bytesMarkup(count(member(baseline, "bytes_before")))) +
                        numberCell(bytesMarkup(count(member(baseline, "bytes_now")))) +
                        numberCell(percentChange(member(baseline, "growth_percent"))) + element("td", {}) + element("td", {}) +
                        element("td", {}) + element("td", verdictChip(passed(baseline))));
    const Json& allowed = member(baseline, "allowed_percent");
    const Html limit = allowed.is_number() ? text("At most ") + percentChange(allowed) + text(" of GPU memory passes.")
                                           : word("No growth was forbidden (--fail-over).");
    const Html head = headCell("Asset") + headCell("GPU before", "num") + headCell("GPU now", "num") + headCell("Growth", "num") +
                      headCell("Diffuse rel_rms", "num") + headCell("Specular rel_rms", "num") + headCell("Visible p99", "num") +
                      headCell("Change");
    return card("Compared with the baseline", element("p", {{"class", "soft"}}, text(words(member(baseline, "file")) + ". ") + limit) +
                                                  table("baseline", element("tr", head), rows));
}

}  // namespace lightcook::pipeline
