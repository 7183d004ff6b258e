// The files that a scene is made of. No command writes over one of them.
#pragma once

#include <filesystem>
#include <set>
#include <vector>

#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns the scene file and the files that it names.
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
