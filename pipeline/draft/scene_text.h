// The text of a first scene file for some inputs: every key that a newcomer may want to change, with its meaning beside it.
#pragma once

#include <filesystem>
#include <string>

#include "formats/error.h"
#include "pipeline/draft/inputs.h"

namespace lightcook::pipeline {

/// Returns the text of a scene file. Names of assets are those of the files, with other letters than names may have replaced by '_'; of two
/// equal ones the second gets a number.
/// folder  of the scene file: paths are relative to it
/// Fails for a file whose name is no UTF-8.
formats::Result<std::string> draftScene(const DraftInputs& inputs, const std::filesystem::path& folder);

}  // namespace lightcook::pipeline
