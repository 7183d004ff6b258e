// Documents made from the tables of the program: pages of docs/reference and the manual page.
#pragma once

#include <string>
#include <vector>

#include "pipeline/command/reference/program_doc.h"

namespace lightcook::pipeline {

/// A generated page of docs/reference.
struct ReferencePage {
    std::string name;  ///< "commands.md"
    std::string text;
};

/// Returns every page that is made from tables: commands, scene file, manifest, report.
std::vector<ReferencePage> referencePages();

/// Returns docs/reference/commands.md.
std::string commandReference(const ProgramDoc& program);

/// Returns docs/reference/scene-file.md, from pipeline/scene/scene.h.
std::string sceneFileReference();
/// Returns docs/reference/budgets.md, from pipeline/report/budgets.cpp.
std::string budgetsReference();
/// Returns docs/reference/configuration-file.md, from pipeline/graph/user_settings.h.
std::string configurationReference();

/// Returns docs/reference/light-map-layouts.md, from formats/light_map_layout.h.
std::string layoutReference();

/// Returns lightcook.1 in the man macros of troff.
std::string manPage(const ProgramDoc& program);

}  // namespace lightcook::pipeline
