// Checks of plausibility, one row each: the fault that lint looks for in the inputs of a scene, its probable cause, and the remedy.
// Findings, the key `allow`, the rules of SARIF and docs/guide/lint.md derive from the rows.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

enum class LintCheck {
    WrongPhase,
    WrongFrame,
    WrongAxes,
    LitFromBehind,
    WrongQuantity,
    ImpossibleBands,
    ImpossibleDirections,
    GammaCurve,
    WrongPrimaries,
    LightUnits,
    GroundTruthUnits,
    NoCoverage,
    CoverageRange,
    MissingCoverage,
    MissingNormals,
    IncompleteSet,
    ZeroNormals,
    SomeZeroNormals,
    EncodedNormals,
    NormalLength,
    RimFirefly,
    BlackCharts,
    Exposure,
    DisplayExposure,
    WrongMesh,
    FlippedV,
    NoLmbake,
    NodesWithoutMap,
    UvOutside,
    UvOverlap,
    DrawnTwice,
    UnplacedNodes,
    UnreadRectangles,
    FlatTriangles,
    MeshNormals,
    UnknownMaterial,
    MaterialExtension,
    StaleBake,
    EightBitProbe,
    ClippedProbe,
    BlackProbe,
    ProbeSh,
    BlackGradient,
    LimitAboveOne,
};

/// Severity of what a check finds.
///   Error    refuses the input: it holds nothing that could be cooked
///   Warning  contradicts the scene, or what light and surfaces can be: a proof, with the tolerance of numbers and of bakers. The scene
///   file
///            can allow it, and --strict makes it an error
///   Note     is likely a fault, and may be right: dark rooms, real lamps, other units. It is printed and in the reports, and fails nothing
enum class LintSeverity { Warning, Error, Note };

struct LintCheckInfo {
    LintCheck id;
    std::string_view name;  ///< the code: "wrong-phase"
    LintSeverity severity;
    std::string_view meaning;  ///< one line: what was found
    std::string_view advice;   ///< what to look at, and what to write
};

/// Share of texels without light or normal in a file without coverage.Y above which they are gaps. Deep shadows are black and right.
inline constexpr double kMostGapsWithoutCoverage = 0.01;

/// Returns every check, in the order of the enumeration.
std::span<const LintCheckInfo> allLintChecks();
const LintCheckInfo& info(LintCheck check);

template <>
struct EnumNames<LintCheck> {
    static std::vector<std::string> all();
};
template <>
struct EnumNames<LintSeverity> {
    static_assert(static_cast<int>(LintSeverity::Error) == 1 && static_cast<int>(LintSeverity::Note) == 2);
    static std::vector<std::string> all() { return {"warning", "error", "note"}; }
};

/// A warning or note that the scene file allows: an element of the key `allow`.
struct Allowance {
    LintCheck check = LintCheck::WrongPhase;
    std::string asset = {};   ///< light map or probe; empty: all
    std::string reason = {};  ///< shown in the report
};
template <class Fields, Is<Allowance> Self>
void describe(Fields& fields, Self& allowance) {
    fields.required("code", allowance.check, "check of plausibility");
    fields.required("asset", allowance.asset, "light map or probe; empty for all");
    fields.required("reason", allowance.reason, "reason of the scene file");
}

/// Returns the checks as a Markdown table, for docs/guide/lint.md.
std::string lintCheckTable();

}  // namespace lightcook::pipeline
