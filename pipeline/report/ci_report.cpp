#include "pipeline/report/ci_report.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <string_view>

#include "pipeline/graph/version.h"

namespace lightcook::pipeline {
namespace {

/// Escapes UTF-8 for XML 1.0, which has no control characters other than tabs and line ends, and neither U+FFFE nor U+FFFF.
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
    for (const std::string_view noCharacter : {"\xEF\xBF\xBE", "\xEF\xBF\xBF"})
        for (std::size_t at = 0; (at = escaped.find(noCharacter, at)) != std::string::npos;)
            escaped.replace(at, noCharacter.size(), "\xEF\xBF\xBD");  // U+FFFD
    return escaped;
}

std::string attribute(const std::string& text) {
    return xmlEscaped(asUtf8(text));
}

// --- JUnit ----------------------------------------------------------------------------------------------------------------------------

struct Counts {
    std::size_t tests = 0, failures = 0, errors = 0, skipped = 0;
    double seconds = 0;
    void add(const CiCheck& check) {
        ++tests;
        seconds += check.seconds;
        if (!check.isDone) ++skipped;
        if (!check.findings.empty()) ++(check.rule == CiRule::Fault ? errors : failures);
    }
};

Counts countsOf(const CiSuite& suite) {
    Counts counts;
    for (const CiCheck& check : suite.checks) counts.add(check);
    return counts;
}

/// Returns the findings of a check as text: line, place in the scene file, facts; then the rule's help.
std::string bodyOf(const CiCheck& check) {
    std::string body;
    for (const CiFinding& finding : check.findings) {
        body += fmt::format("{}\n  at: {}:{}\n", finding.message, finding.at.file.string(), finding.at.line);
        for (const auto& [key, value] : finding.properties.items())
            body += fmt::format("  {}: {}\n", key,
                                value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, Json::error_handler_t::replace));
    }
    return fmt::format("{}\n{}\n", body, info(check.rule).help);
}

std::string caseOf(const CiRun& run, const CiSuite& suite, const CiCheck& check) {
    std::string text = fmt::format("    <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"", attribute(run.scene + "." + suite.name),
                                   info(check.rule).name, check.seconds);
    if (!check.findings.empty()) {
        const char* element = check.rule == CiRule::Fault ? "error" : "failure";
        const std::string more = check.findings.size() > 1 ? fmt::format(" (and {} more)", check.findings.size() - 1) : "";
        return text + fmt::format("><{0} type=\"{1}\" message=\"{2}\">{3}</{0}></testcase>\n", element, info(check.rule).name,
                                  attribute(check.findings.front().message + more), attribute(bodyOf(check)));
    }
    if (!check.isDone)
        return text + fmt::format("><skipped message=\"{}\"/></testcase>\n", attribute("not measured: " + run.reasonNotDone));
    return text + "/>\n";
}

std::string suiteOf(const CiRun& run, const CiSuite& suite, std::size_t id, const std::string& timestamp) {
    const Counts counts = countsOf(suite);
    const std::string name = suite.kind.empty() ? run.scene : fmt::format("{} ({})", suite.name, suite.kind);
    std::string text = fmt::format(
        "  <testsuite id=\"{}\" name=\"{}\" package=\"{}\" timestamp=\"{}\" hostname=\"localhost\" tests=\"{}\" failures=\"{}\" "
        "errors=\"{}\" skipped=\"{}\" time=\"{:.3f}\">\n    <properties/>\n",
        id, attribute(name), attribute(run.scene), timestamp, counts.tests, counts.failures, counts.errors, counts.skipped, counts.seconds);
    for (const CiCheck& check : suite.checks) text += caseOf(run, suite, check);
    return text + "    <system-out/>\n    <system-err/>\n  </testsuite>\n";
}

/// Returns the suite of lint: a case for each check of plausibility. A case is red if a finding is an error, and skipped if the scene file
/// allows what was found; warnings and notes are the output of the suite.
std::string lintSuite(const CiRun& run, std::size_t id, const std::string& timestamp, Counts& whole) {
    Counts counts;
    std::string cases, warnings;
    const std::string whyNotLinted = "not looked for" + (run.reasonNotDone.empty() ? " by this command" : ": " + run.reasonNotDone);
    for (const LintCheckInfo& check : allLintChecks()) {
        std::string failures, allowed;
        for (const Finding& finding : run.lint) {
            if (finding.check != check.id) continue;
            const std::string line = fmt::format("{}: {}\n", subjectOf(finding), detailOf(finding));
            if (finding.allowed) allowed += fmt::format("allowed ({}): {}", *finding.allowed, line);
            (finding.isFailure() ? failures : warnings) += finding.allowed ? "" : line;
        }
        ++counts.tests;
        std::string result = "/>";
        if (!run.isLinted || (!allowed.empty() && failures.empty())) {
            ++counts.skipped;
            result = fmt::format("><skipped message=\"{}\"/></testcase>", attribute(run.isLinted ? allowed : whyNotLinted));
        }
        if (!failures.empty()) {
            ++counts.failures;
            result = fmt::format("><failure type=\"{0}\" message=\"{1}\">{1}{2}</failure></testcase>", check.name, attribute(failures),
                                 attribute(std::string(check.advice)));
        }
        cases +=
            fmt::format("    <testcase classname=\"{}\" name=\"{}\" time=\"0\"{}\n", attribute(run.scene + ".lint"), check.name, result);
    }
    whole.tests += counts.tests;
    whole.failures += counts.failures;
    return fmt::format(
        "  <testsuite id=\"{}\" name=\"lint\" package=\"{}\" timestamp=\"{}\" hostname=\"localhost\" tests=\"{}\" failures=\"{}\" "
        "errors=\"0\" skipped=\"{}\" time=\"0\">\n    <properties/>\n{}    <system-out>{}</system-out>\n    <system-err/>\n  "
        "</testsuite>\n",
        id, attribute(run.scene), timestamp, counts.tests, counts.failures, counts.skipped, cases, attribute(warnings));
}

// --- SARIF ----------------------------------------------------------------------------------------------------------------------------

constexpr const char* kSourceRoot = "%SRCROOT%";

std::string percentEncoded(const std::string& path) {
    std::string encoded;
    for (const char c : path) {
        const bool isPlain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                             std::string_view("-._~/").find(c) != std::string_view::npos;
        encoded += isPlain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
    return encoded;
}

/// Returns the location of a file: relative to the current folder if it is below it, which in CI is the checkout.
Json artifactLocation(const std::filesystem::path& file) {
    const std::filesystem::path absolute = std::filesystem::absolute(file).lexically_normal();
    const std::filesystem::path relative = absolute.lexically_relative(std::filesystem::current_path());
    if (relative.empty() || *relative.begin() == "..") return {{"uri", "file://" + percentEncoded(absolute.generic_string())}};
    return {{"uri", percentEncoded(relative.generic_string())}, {"uriBaseId", kSourceRoot}};
}

Json resultOf(const CiRun& run, const CiSuite& suite, const CiCheck& check, const CiFinding& finding) {
    const std::string place = finding.stage.empty() ? suite.name : suite.name + "/" + finding.stage;
    const std::string detail = finding.properties.value("shading", finding.properties.value("place", std::string()));
    return {
        {"ruleId", info(check.rule).name},
        {"ruleIndex", static_cast<int>(check.rule)},
        {"kind", "fail"},
        {"level", "error"},
        {"message", {{"text", asUtf8(finding.message)}}},
        {"locations",
         Json::array({{{"physicalLocation",
                        {{"artifactLocation", artifactLocation(finding.at.file)}, {"region", {{"startLine", finding.at.line}}}}},
                       {"logicalLocations", Json::array({{{"name", suite.name}, {"fullyQualifiedName", place}, {"kind", "resource"}}})}}})},
        {"partialFingerprints",
         {{"lightcookFinding/v1", asUtf8(fmt::format("{}/{}/{}/{}", run.scene, info(check.rule).name, place, detail))}}},
        {"properties", finding.properties}};
}

/// Returns the level that SARIF has for a severity.
std::string levelOf(LintSeverity severity) {
    return enumNames<LintSeverity>()[static_cast<std::size_t>(severity)];
}

/// Returns the result of a finding of lint: at its line of the scene file, or at the input that it is about.
Json resultOf(const CiRun& run, const Finding& finding) {
    const std::string code(info(finding.check).name), place = finding.asset.empty() ? kSceneSuite : finding.asset;
    const SourceLine at = finding.line && finding.sceneFile ? SourceLine{*finding.sceneFile, *finding.line} : run.scenePlace;
    Json result = {
        {"ruleId", code},
        {"ruleIndex", allCiRules().size() + static_cast<std::size_t>(finding.check)},
        {"kind", "fail"},
        {"level", levelOf(finding.severity)},
        {"message", {{"text", asUtf8(fmt::format("{}: {}", subjectOf(finding), detailOf(finding)))}}},
        {"locations",
         Json::array({{{"physicalLocation", {{"artifactLocation", artifactLocation(at.file)}, {"region", {{"startLine", at.line}}}}},
                       {"logicalLocations", Json::array({{{"name", place}, {"fullyQualifiedName", place}, {"kind", "resource"}}})}}})},
        {"partialFingerprints", {{"lightcookFinding/v1", asUtf8(fmt::format("{}/{}/{}", run.scene, code, place))}}},
        {"properties", jsonOf(finding.figures)}};
    if (finding.allowed) result["suppressions"] = Json::array({{{"kind", "external"}, {"justification", asUtf8(*finding.allowed)}}});
    return result;
}

/// Returns "WrongPhase" for "wrong-phase".
std::string titleOf(std::string_view code) {
    std::string title;
    bool isFirst = true;
    for (const char c : code) {
        if (c != '-') title += isFirst ? static_cast<char>(c - 'a' + 'A') : c;
        isFirst = c == '-';
    }
    return title;
}

Json sarifRules() {
    Json rules = Json::array();
    for (const CiRuleInfo& rule : allCiRules())
        rules.push_back({{"id", rule.name},
                         {"name", rule.title},
                         {"shortDescription", {{"text", rule.brief}}},
                         {"fullDescription", {{"text", rule.brief}}},
                         {"help", {{"text", rule.help}, {"markdown", rule.help}}},
                         {"defaultConfiguration", {{"level", "error"}}}});
    for (const LintCheckInfo& check : allLintChecks())
        rules.push_back({{"id", check.name},
                         {"name", titleOf(check.name)},
                         {"shortDescription", {{"text", check.meaning}}},
                         {"fullDescription", {{"text", check.meaning}}},
                         {"help", {{"text", check.advice}, {"markdown", check.advice}}},
                         {"defaultConfiguration", {{"level", levelOf(check.severity)}}}});
    return rules;
}

}  // namespace

std::string junitReport(const std::vector<CiRun>& runs) {
    const std::string timestamp =
        fmt::format("{:%Y-%m-%dT%H:%M:%S}", fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
    Counts counts;
    std::string suites;
    std::size_t id = 0;
    for (const CiRun& run : runs) {
        for (const CiSuite& suite : run.suites) {
            for (const CiCheck& check : suite.checks) counts.add(check);
            suites += suiteOf(run, suite, id++, timestamp);
        }
        suites += lintSuite(run, id++, timestamp, counts);
    }
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" "
        "time=\"{:.3f}\">\n{}</testsuites>\n",
        attribute(runs.front().title), counts.tests, counts.failures, counts.errors, counts.seconds, suites);
}

std::string sarifReport(const std::vector<CiRun>& runs) {
    const Json driver = {{"name", kToolName}, {"version", kToolVersion}, {"semanticVersion", kToolVersion}, {"rules", sarifRules()}};
    Json all = Json::array();
    for (const CiRun& run : runs) {
        Json results = Json::array();
        for (const CiSuite& suite : run.suites)
            for (const CiCheck& check : suite.checks)
                for (const CiFinding& finding : check.findings) results.push_back(resultOf(run, suite, check, finding));
        for (const Finding& finding : run.lint) results.push_back(resultOf(run, finding));
        all.push_back({{"tool", {{"driver", driver}}},
                       {"automationDetails", {{"id", asUtf8(fmt::format("lightcook/{}/", run.scene))}}},
                       {"originalUriBaseIds", {{kSourceRoot, {{"description", {{"text", "The folder that lightcook ran in"}}}}}}},
                       {"columnKind", "utf16CodeUnits"},
                       {"results", std::move(results)}});
    }
    const Json sarif = {{"$schema", "https://json.schemastore.org/sarif-2.1.0.json"}, {"version", "2.1.0"}, {"runs", std::move(all)}};
    return textOf(sarif) + "\n";
}

}  // namespace lightcook::pipeline
