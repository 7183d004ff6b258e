#include "pipeline/cook/verdicts.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/cook/integrity.h"
#include "pipeline/manifest/cooked_folder.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/exit_codes.h"
#include "pipeline/report/failures.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {

using formats::Error;
using formats::ErrorCode;
using formats::failure;
using formats::Result;

namespace {

/// Returns the errors of a cooked folder as its cook or verification found them, and files that were changed since.
std::vector<Error> verdictOf(const std::filesystem::path& folder, const Manifest& manifest, const Report& report) {
    std::vector<Error> errors = checkDigests(folder, manifest);
    appendErrorsOf(report, budgetPlace(folder), errors);
    if (errors.empty() && !report.passed)
        errors.push_back({ErrorCode::Verification, folder / kReportName, "found passed: false, expected a folder that passed"});
    return errors;
}

}  // namespace

void appendErrorsOf(const Report& report, const formats::Subject& budgetPlace, std::vector<Error>& errors) {
    if (report.incomplete)
        for (const FailedAction& failed : report.incomplete->errors) formats::addOnce(errors, failed.error());
    for (const ReportRow& row : report.assets)
        for (Error& error : errorsOf(row.failures)) errors.push_back(std::move(error));
    if (!report.budget.isKept())
        errors.push_back({ErrorCode::OverBudget, budgetPlace,
                          overBudgetWords(report.budget.usedBytes, *report.budget.limitBytes) +
                              (report.budget.advice.empty() ? "" : ". " + report.budget.advice)});
}

formats::Subject budgetPlace(const std::filesystem::path& folder) {
    return formats::Subject(folder / kReportName).at("budget");
}

Result<CookedFolder> readCookedFolder(const std::filesystem::path& folder) {
    std::error_code code;
    if (std::filesystem::is_regular_file(folder, code))
        return failure(ErrorCode::FileUnreadable, folder, "found a file, expected the output folder of `lightcook cook`");
    if (!std::filesystem::exists(folder / kReportName, code))
        return failure(ErrorCode::FileUnreadable, folder / kReportName, "found no report, expected " + expectedCookedFolder(folder));
    LC_TRY(json, readReport(folder / kReportName));
    LC_TRY(report, loadReport(folder / kReportName));
    LC_TRY(manifest, loadManifest(folder));
    // Members that `lightcook report` adds are no part of a folder.
    for (const char* made : {"baseline", "platforms"}) json->erase(made);
    report->baseline.reset();
    report->platforms.reset();
    std::vector<Error> errors = verdictOf(folder, *manifest, *report);
    if (!errors.empty()) {  // also a folder that was changed after its cook passed
        (*json)["passed"] = false;
        report->passed = false;
    }
    return CookedFolder{folder, std::move(*json), std::move(*report), manifest->target, std::move(errors)};
}

}  // namespace lightcook::pipeline
