#include "pipeline/report/findings_section.h"

#include "pipeline/report/page_parts.h"

namespace lightcook::pipeline {
namespace {

/// Returns what became of a finding: an error, a warning, or allowed with its reason.
std::string standingOf(const Json& finding) {
    if (!finding.is_object() || !finding.contains("allowed")) return words(member(finding, "severity"));
    const std::string reason = words(member(finding, "allowed"));
    return reason.empty() ? "allowed" : "allowed: " + reason;
}

Html findingRow(const Json& finding) {
    const std::string asset = words(member(finding, "asset"));
    return element("tr", element("th", {{"scope", "row"}}, text(words(member(finding, "code")))) +
                             element("td", text(asset.empty() ? "the scene" : asset)) +
                             element("td", text(words(member(finding, "found"))) +
                                               element("span", {{"class", "sub"}}, text(words(member(finding, "advice"))))) +
                             element("td", text(standingOf(finding))));
}

}  // namespace

Html findingsSection(const Json& report) {
    const Json& findings = list(report, "findings");
    if (findings.empty()) return {};
    Html rows;
    for (const Json& finding : findings) rows += findingRow(finding);
    const Html head = headCell("Code") + headCell("Of") + headCell("Found, and what to do") + headCell("Severity");
    return card("Plausibility of the inputs", table("findings", element("tr", head), rows));
}

}  // namespace lightcook::pipeline
