#include "pipeline/report/platform_section.h"

#include <fmt/format.h>

#include <algorithm>

namespace lightcook::pipeline {
namespace {

double shareOf(const Json& check) {
    const std::uint64_t limit = count(member(check, "limit_bytes")), used = count(member(check, "used_bytes"));
    if (limit == 0) return used > 0 ? 1e9 : 0;
    return static_cast<double>(used) / static_cast<double>(limit);
}

std::string limitWords(const Json& check) {
    const std::string scene = words(member(check, "scene")), of = words(member(check, "of"));
    return scene.empty() ? "all scenes together" : scene + (of.empty() ? "" : ", " + of);
}

Html checkRow(const Json& check) {
    const double share = shareOf(check);
    const Html bar =
        element("span", {{"class", "meter long"}}, element("i", {{"style", fmt::format("width:{:.1f}%", 100 * std::min(share, 1.0))}}, {}));
    const bool isKept = passed(check);
    return element("tr", element("th", {{"scope", "row"}}, text(limitWords(check))) +
                             numberCell(bytesMarkup(count(member(check, "used_bytes")))) +
                             numberCell(bytesMarkup(count(member(check, "limit_bytes")))) +
                             element("td", {{"class", isKept ? "num" : "num over"}}, text(humanPercent(share)) + bar) +
                             element("td", verdictChip(isKept)));
}

/// Returns the limits that are passed, and the fullest of the others.
Html checkTable(const Json& platform) {
    constexpr std::size_t kKept = 5, kMost = 40;
    std::vector<const Json*> checks;
    for (const Json& check : list(platform, "checks")) checks.push_back(&check);
    std::ranges::stable_sort(checks, [](const Json* a, const Json* b) { return shareOf(*a) > shareOf(*b); });
    Html rows;
    std::size_t shown = 0, kept = 0;
    for (const Json* check : checks) {
        kept += passed(*check) ? 1 : 0;
        if (kept > kKept || shown == kMost) break;
        rows += checkRow(*check);
        ++shown;
    }
    const Html rest = shown < checks.size()
                          ? element("p", {{"class", "soft"}}, text(fmt::format("The fullest {} of {} limits.", shown, checks.size())))
                          : Html();
    return table("checks",
                 element("tr", headCell("Limit") + headCell("GPU memory", "num") + headCell("Budget", "num") + headCell("Used", "num") +
                                   headCell("Verdict")),
                 rows) +
           rest;
}

}  // namespace

Html platformSection(const Json& platforms) {
    if (!platforms.is_array() || platforms.empty()) return {};
    Html content;
    for (const Json& platform : platforms) {
        const std::string target = words(member(platform, "target"));
        content +=
            element("div", {{"class", "title small"}},
                    element("h3", text(words(member(platform, "name")))) + verdictChip(passed(platform))) +
            element("p", {{"class", "soft"}},
                    text(fmt::format("{} in {} scene{}{}.", humanBytes(count(member(platform, "used_bytes"))),
                                     groupedCount(count(member(platform, "scenes"))), count(member(platform, "scenes")) == 1 ? "" : "s",
                                     target.empty() ? "" : " cooked for " + target))) +
            (list(platform, "checks").empty() ? Html() : checkTable(platform));
    }
    return card("Budgets of platforms", content);
}

}  // namespace lightcook::pipeline
