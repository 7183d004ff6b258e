// The functions of all actions: of each asset kind those that cook and verify, and those that make no asset (action_kind.h).
#pragma once

#include <string>

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Returns the function of an action kind: of each asset kind "<name>" and "verify-<name>", and of the actions before a plan. An unknown
/// kind gets a function that fails.
ActionFunction actionFunction(const std::string& kind);

}  // namespace lightcook::pipeline
