// The files that a scene is made of. No command writes over one of them.
#pragma once

#include <filesystem>
#include <set>
#include <vector>

#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns the scene file, the files that it names, and those that are read beside them: the others of a bake in several files and of an
/// environment in six, and the buffers and images of a glTF.
std::vector<std::filesystem::path> filesNamedBy(const Scene& scene);

/// Places of these files in their folders. A symbolic link is a place of its own, whatever it names.
class NamedPlaces {
public:
    explicit NamedPlaces(const Scene& scene);
    bool contains(const std::filesystem::path& file) const;

private:
    std::set<std::filesystem::path> places_;
};

}  // namespace lightcook::pipeline
