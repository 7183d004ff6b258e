// Findings of lint: what looks wrong in the inputs of a scene.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/scene/lint_checks.h"

namespace lightcook::pipeline {

/// A place of the scene file: a key of a table, and of the element of that name in an array of tables.
struct ScenePlace {
    std::string section, name, key;
};
template <class Fields, Is<ScenePlace> Self>
void describe(Fields& fields, Self& place) {
    fields.required("section", place.section, "table: output, light_map, probe, material");
    fields.required("name", place.name, "element of an array of tables, else empty");
    fields.required("key", place.key, "key, or empty for the table");
}

struct Finding {
    LintCheck check = LintCheck::WrongPhase;
    std::string asset;  ///< light map or probe; empty for the scene
    LintSeverity severity = LintSeverity::Warning;
    std::string file;                            ///< the input, or the scene file
    std::string found;                           ///< one sentence with the figures
    std::map<std::string, double> figures = {};  ///< the same figures, by name
    std::string advice = {};                     ///< what to write, or to look at
    ScenePlace place = {};
    std::optional<std::string> sceneFile = {};
    std::optional<int> line = {};             ///< of the scene file, from 1
    std::optional<std::string> allowed = {};  ///< the reason, where the scene file allows it
    bool isNote() const { return severity == LintSeverity::Note; }
    bool isFailure() const { return severity == LintSeverity::Error && !allowed; }
};
template <class Fields, Is<Finding> Self>
void describe(Fields& fields, Self& finding) {
    fields.required("code", finding.check, "check of plausibility");
    fields.required("asset", finding.asset, "light map or probe; empty for the scene");
    fields.required("severity", finding.severity, "error: the input is refused; note: it may be right as it is");
    fields.required("file", finding.file, "input that was looked at");
    fields.required("found", finding.found, "what was found and what was expected");
    fields.required("figures", finding.figures, kNumberOrNull, "evidence, by name");
    fields.required("advice", finding.advice, "what to do");
    fields.required("place", finding.place, "place in the scene file");
    fields.optional("scene_file", finding.sceneFile, "scene file that the line is of");
    fields.optional("line", finding.line, "line of the scene file");
    fields.optional("allowed", finding.allowed, "reason of the scene file, where it allows this finding");
}

/// Returns the lines of a finding: subject (file and code) and detail (what was found, and what to do).
std::string subjectOf(const Finding& finding);
std::string detailOf(const Finding& finding);
/// Returns the errors among the findings, in their order.
std::vector<formats::Error> errorsOf(const std::vector<Finding>& findings);

}  // namespace lightcook::pipeline
