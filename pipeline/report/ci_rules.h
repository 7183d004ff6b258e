// Checks that a run is made of, as JUnit and SARIF name them: one row each.
#pragma once

#include <span>
#include <string_view>

#include "formats/error.h"

namespace lightcook::pipeline {

enum class CiRule {
    UnchangedFiles,
    Contract,
    FiniteFigures,
    DiffuseError,
    SpecularError,
    VisibleError,
    Seam,
    LocalError,
    MemoryBudget,
    Input,
    Request,
    Fault
};

struct CiRuleInfo {
    CiRule id;
    std::string_view name;   ///< "diffuse-error": rule id of SARIF, case of JUnit
    std::string_view title;  ///< PascalCase name of SARIF
    std::string_view brief;  ///< what holds if the check passes, as a sentence
    std::string_view help;   ///< causes of a failure, and what to do
    bool isOfAsset;          ///< each asset has this check; else the scene
};

/// Returns every rule, in the order of the enumeration.
std::span<const CiRuleInfo> allCiRules();
const CiRuleInfo& info(CiRule rule);

/// Returns the rule of an error that no failure of an asset explains.
CiRule ruleOf(formats::ErrorCode code);

}  // namespace lightcook::pipeline
