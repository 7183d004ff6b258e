#include "pipeline/report/ci_report.h"

#include <fmt/format.h>

#include <map>

#include "pipeline/graph/version.h"
#include "pipeline/json/json.h"

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

/// Returns the properties of each failure of the report, by its error line.
std::map<std::string, Json> factsByLine(const Json& report) {
    std::map<std::string, Json> facts;
    if (!report.is_object()) return facts;
    for (const Json& asset : report.at("assets"))
        for (const Json& failure : asset.value("failures", Json::array())) {
            Json properties = failure;
            for (const char* key : {"subject", "detail", "message"}) properties.erase(key);
            facts[failure.at("message").get<std::string>()] = std::move(properties);
        }
    return facts;
}

std::string junitProperties(const Json& facts) {
    std::string properties;
    for (const auto& [key, value] : facts.items())
        properties += fmt::format("<property name=\"{}\" value=\"{}\"/>", xmlEscaped(key),
                                  xmlEscaped(value.is_string() ? value.get<std::string>() : value.dump()));
    return properties.empty() ? "" : "<properties>" + properties + "</properties>";
}

}  // namespace

std::string junitReport(const Json& report, const std::vector<formats::Error>& errors, const std::string& folder) {
    std::string cases;
    std::size_t count = 0;
    if (report.is_object())
        for (const Json& asset : report.at("assets")) {
            ++count;
            cases +=
                fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"/>\n", xmlEscaped(asset.at("kind").get<std::string>()),
                            xmlEscaped(asset.at("name").get<std::string>()), asset.value("verify_seconds", 0.0));
        }
    const std::map<std::string, Json> facts = factsByLine(report);
    for (const formats::Error& error : errors) {
        ++count;
        const auto found = facts.find(error.line());
        cases +=
            fmt::format("  <testcase classname=\"{}\" name=\"{}\">{}<failure message=\"{}\"/></testcase>\n", ruleOf(error.code),
                        xmlEscaped(error.subject), found == facts.end() ? "" : junitProperties(found->second), xmlEscaped(error.detail));
    }
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"{} verify {}\" tests=\"{}\" failures=\"{}\">\n{}</testsuite>\n",
        kToolName, xmlEscaped(folder), count, errors.size(), cases);
}

std::string sarifReport(const Json& report, const std::vector<formats::Error>& errors) {
    Json results = Json::array();
    const std::map<std::string, Json> facts = factsByLine(report);
    for (const formats::Error& error : errors) {
        results.push_back(
            {{"ruleId", ruleOf(error.code)},
             {"level", "error"},
             {"message", {{"text", error.line()}}},
             {"locations", Json::array({{{"physicalLocation",
                                          {{"artifactLocation", {{"uri", error.subject.substr(0, error.subject.find(", "))}}}}}}})}});
        const auto found = facts.find(error.line());
        if (found == facts.end()) continue;
        const std::string asset = found->second.at("asset").get<std::string>();
        results.back()["locations"][0]["logicalLocations"] = Json::array(
            {{{"name", asset}, {"fullyQualifiedName", asset + "/" + found->second.at("stage").get<std::string>()}, {"kind", "resource"}}});
        results.back()["properties"] = found->second;
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
