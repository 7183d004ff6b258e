#include "pipeline/report/ci_report.h"

#include <fmt/format.h>

#include <map>

#include "pipeline/graph/version.h"
#include "pipeline/json/json.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

std::string xmlEscaped(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        switch (c) {
            case '&':
                escaped += "&amp;";
                break;
            case '<':
                escaped += "&lt;";
                break;
            case '>':
                escaped += "&gt;";
                break;
            case '"':
                escaped += "&quot;";
                break;
            default:
                escaped += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? ' ' : c;
        }
    }
    return escaped;
}

std::string ruleOf(formats::ErrorCode code) {
    switch (code) {
        case formats::ErrorCode::Verification:
            return "shaded-error";
        case formats::ErrorCode::OverBudget:
            return "memory-budget";
        default:
            return "input";
    }
}

/// Returns the failures of the report by their error lines.
std::map<std::string, Failure> failuresByLine(const Report& report) {
    std::map<std::string, Failure> failures;
    for (const ReportRow& row : report.assets)
        for (const Failure& failure : row.failures) failures[failure.message] = failure;
    return failures;
}

/// Returns the facts of a failure without its texts.
Json propertiesOf(const Failure& failure) {
    Json properties = toJson(failure);
    for (const char* key : {"subject", "detail", "message"}) properties.erase(key);
    return properties;
}

/// Returns the report, or one without rows if the job ended before there was one.
Report reportOf(const Json& json) {
    return json.is_object() ? fromJson<Report>(json, kReportName).value_or(Report()) : Report();
}

std::string junitProperties(const Failure& failure) {
    std::string properties;
    const Json facts = propertiesOf(failure);
    for (const auto& [key, value] : facts.items())
        properties += fmt::format("<property name=\"{}\" value=\"{}\"/>", xmlEscaped(key),
                                  xmlEscaped(value.is_string() ? value.get<std::string>() : value.dump()));
    return properties.empty() ? "" : "<properties>" + properties + "</properties>";
}

}  // namespace

std::string junitReport(const Json& json, const std::vector<formats::Error>& errors, const std::string& folder) {
    std::string cases;
    std::size_t count = 0;
    const Report report = reportOf(json);
    for (const ReportRow& row : report.assets) {
        ++count;
        cases += fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"/>\n", xmlEscaped(std::string(info(row.kind).name)),
                             xmlEscaped(row.name), row.verifySeconds);
    }
    const std::map<std::string, Failure> failures = failuresByLine(report);
    for (const formats::Error& error : errors) {
        ++count;
        const auto found = failures.find(error.line());
        cases +=
            fmt::format("  <testcase classname=\"{}\" name=\"{}\">{}<failure message=\"{}\"/></testcase>\n", ruleOf(error.code),
                        xmlEscaped(error.subject), found == failures.end() ? "" : junitProperties(found->second), xmlEscaped(error.detail));
    }
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"{} verify {}\" tests=\"{}\" failures=\"{}\">\n{}</testsuite>\n",
        kToolName, xmlEscaped(folder), count, errors.size(), cases);
}

std::string sarifReport(const Json& json, const std::vector<formats::Error>& errors) {
    Json results = Json::array();
    const std::map<std::string, Failure> failures = failuresByLine(reportOf(json));
    for (const formats::Error& error : errors) {
        results.push_back(
            {{"ruleId", ruleOf(error.code)},
             {"level", "error"},
             {"message", {{"text", error.line()}}},
             {"locations", Json::array({{{"physicalLocation",
                                          {{"artifactLocation", {{"uri", error.subject.substr(0, error.subject.find(", "))}}}}}}})}});
        const auto found = failures.find(error.line());
        if (found == failures.end()) continue;
        const Failure& failure = found->second;
        results.back()["locations"][0]["logicalLocations"] =
            Json::array({{{"name", failure.asset}, {"fullyQualifiedName", failure.asset + "/" + failure.stage}, {"kind", "resource"}}});
        results.back()["properties"] = propertiesOf(failure);
    }
    Json rules = Json::array();
    for (const char* id : {"shaded-error", "memory-budget", "input"}) rules.push_back({{"id", id}});
    const Json sarif = {{"$schema", "https://json.schemastore.org/sarif-2.1.0.json"},
                        {"version", "2.1.0"},
                        {"runs", Json::array({{{"tool", {{"driver", {{"name", kToolName}, {"version", kToolVersion}, {"rules", rules}}}}},
                                               {"results", results}}})}};
    return textOf(sarif) + "\n";
}

}  // namespace lightcook::pipeline
