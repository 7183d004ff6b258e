// Shell completions: commands, options, their values, files and folders.
#pragma once

#include <string>

#include "pipeline/command/reference/program_doc.h"

namespace lightcook::pipeline {

std::string bashCompletion(const ProgramDoc& program);
std::string zshCompletion(const ProgramDoc& program);
std::string fishCompletion(const ProgramDoc& program);

}  // namespace lightcook::pipeline
