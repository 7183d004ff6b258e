// The first mistake of a command line, in the order in which it was typed.
//
// CLI11 reports required options before unknown ones, and values before both. So the arguments are parsed again one more at a time, with
// nothing required: the argument after which parsing first fails is the mistake. What is only missing is reported last.
#pragma once

#include <span>
#include <string>

#include "formats/error.h"

namespace lightcook::pipeline {

/// Returns the error of a command line that CLI11 refuses. Unknown commands and options come with the nearest known one, values with what
/// is expected.
/// arguments   without the program's name
/// message     of CLI11, where it says more than we know
formats::Error firstMistake(std::span<const std::string> arguments, const std::string& message);

}  // namespace lightcook::pipeline
