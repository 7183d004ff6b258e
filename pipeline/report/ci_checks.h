// The checks of a run and their findings: the form that JUnit and SARIF are written from (ci_report.h).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/document/json.h"
#include "pipeline/lint/finding.h"
#include "pipeline/report/ci_rules.h"

namespace lightcook::pipeline {

/// A line of a file, from 1.
struct SourceLine {
    std::filesystem::path file;
    int line = 1;
};

/// A reason why a check failed.
struct CiFinding {
    std::string message;  ///< the error line
    std::string stage;    ///< of the asset; empty: the whole asset
    Json properties;      ///< facts of a Failure; empty object for other errors
    SourceLine at;
};

struct CiCheck {
    CiRule rule;
    bool isDone = true;  ///< false if an earlier error kept it from being made
    double seconds = 0;
    std::vector<CiFinding> findings;
};

/// The checks of an asset, or those of the scene.
struct CiSuite {
    std::string name;  ///< of the asset; kSceneSuite
    std::string kind;  ///< of the asset; empty for the scene
    SourceLine at;     ///< its table in the scene file; without a scene file its manifest
    std::vector<CiCheck> checks;
};
inline constexpr const char* kSceneSuite = "(scene)";

struct CiRun {
    std::string title;  ///< "lightcook verify out"
    std::string scene;
    std::vector<CiSuite> suites;  ///< the scene, then its assets
    std::string reasonNotDone;    ///< the error that kept checks from being made
    bool isLinted = false;        ///< the checks of plausibility were made
    std::vector<Finding> lint;    ///< what they found
    SourceLine scenePlace;        ///< of findings without a line
};

/// Results of a command, from which the checks are made.
struct CiInputs {
    std::string command;              ///< "verify"
    std::filesystem::path folder;     ///< of the cooked scene; its manifest lists the assets
    std::filesystem::path sceneFile;  ///< empty: the one that the manifest names
    std::filesystem::path sources;    ///< folder of the scene file if it has moved; empty: as the manifest says
    const Json& report;               ///< report.json; null if the job ended before there was one
    const std::vector<formats::Error>& errors;
    const std::vector<Finding>* findings = nullptr;  ///< of lint; null if the inputs were not looked at
};
/// Returns every check of the scene and its assets. Each failure of report.json and each other error is a finding of one of them.
CiRun ciRun(const CiInputs& inputs);

}  // namespace lightcook::pipeline
