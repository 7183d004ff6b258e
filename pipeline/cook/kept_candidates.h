// Candidates that a cook keeps beside the scene that it chose: the scene with another layout of its light maps, in DIR/candidates/LAYOUT.
// Each is a cooked folder of its own, which `verify`, `report` and `view` open like any other.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "pipeline/manifest/manifest.h"
#include "pipeline/scene/named_files.h"

namespace lightcook::pipeline {

/// Returns the folder of a candidate. Its name is that of the layout.
std::filesystem::path candidateFolder(const std::filesystem::path& cooked, const std::string& layout);

/// Returns the layouts whose candidates lie in a cooked folder, in the order of the table. Nothing is said of what they hold.
std::vector<std::string> candidatesIn(const std::filesystem::path& cooked);

/// Removes the candidates of an earlier cook, but for these layouts: the files that their manifests and reports name, and folders that are
/// empty then. Other files stay, as do inputs of the scene and everything behind a symbolic link.
void removeCandidates(const std::filesystem::path& cooked, const std::set<std::string>& kept, const NamedPlaces& inputs);

/// Returns true if a candidate was cooked of the same scene and of the same bakes.
bool isCandidateOf(const Manifest& candidate, const Manifest& cooked);

}  // namespace lightcook::pipeline
