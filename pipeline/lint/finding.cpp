#include "pipeline/lint/finding.h"

#include <fmt/format.h>

namespace lightcook::pipeline {

std::string subjectOf(const Finding& finding) {
    return fmt::format("{}, {}", finding.file, info(finding.check).name);
}

std::string detailOf(const Finding& finding) {
    const std::string place = finding.line ? fmt::format(" ({}:{})", finding.sceneFile.value_or(""), *finding.line) : "";
    return fmt::format("{}. {}{}", finding.found, finding.advice, place);
}

std::vector<formats::Error> errorsOf(const std::vector<Finding>& findings) {
    std::vector<formats::Error> errors;
    for (const Finding& finding : findings)
        if (finding.isFailure()) {
            formats::Error& error = errors.emplace_back(formats::ErrorCode::Implausible, subjectOf(finding), detailOf(finding));
            error.asset = finding.asset;
            error.file = finding.file;
        }
    return errors;
}

}  // namespace lightcook::pipeline
