#include "pipeline/ci_report.h"

#include <fmt/format.h>

#include "pipeline/json_shape.h"
#include "pipeline/version.h"

namespace pipeline {
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
    for (const formats::Error& error : errors) {
        ++count;
        cases += fmt::format("  <testcase classname=\"{}\" name=\"{}\"><failure message=\"{}\"/></testcase>\n", ruleOf(error.code),
                             xmlEscaped(error.subject), xmlEscaped(error.detail));
    }
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"{} verify {}\" tests=\"{}\" failures=\"{}\">\n{}</testsuite>\n",
        kToolName, xmlEscaped(folder), count, errors.size(), cases);
}

std::string sarifReport(const std::vector<formats::Error>& errors) {
    Json results = Json::array();
    for (const formats::Error& error : errors)
        results.push_back(
            {{"ruleId", ruleOf(error.code)},
             {"level", "error"},
             {"message", {{"text", error.line()}}},
             {"locations", Json::array({{{"physicalLocation",
                                          {{"artifactLocation", {{"uri", error.subject.substr(0, error.subject.find(", "))}}}}}}})}});
    Json rules = Json::array();
    for (const char* id : {"shaded-error", "memory-budget", "input"}) rules.push_back({{"id", id}});
    const Json sarif = {{"$schema", "https://json.schemastore.org/sarif-2.1.0.json"},
                        {"version", "2.1.0"},
                        {"runs", Json::array({{{"tool", {{"driver", {{"name", kToolName}, {"version", kToolVersion}, {"rules", rules}}}}},
                                               {"results", results}}})}};
    return textOf(sarif) + "\n";
}

}  // namespace pipeline
