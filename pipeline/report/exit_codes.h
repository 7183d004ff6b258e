// The exit codes of the program: one table, and the code of each error.
#pragma once

#include <span>
#include <string_view>

#include "formats/error.h"

namespace lightcook::pipeline {

struct ExitCodeInfo {
    int code;
    std::string_view meaning;
};

/// Returns every exit code with its meaning, in ascending order.
std::span<const ExitCodeInfo> allExitCodes();

/// Returns the exit code of an error.
int exitCode(formats::ErrorCode code);

/// Returns an error code that has an exit code.
formats::ErrorCode errorCodeFor(int exitCode);

}  // namespace lightcook::pipeline
