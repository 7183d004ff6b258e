#include "pipeline/scene/named_files.h"

#include <system_error>

#include "formats/bake_format.h"
#include "formats/environment.h"
#include "formats/gltf_scene.h"

namespace lightcook::pipeline {
namespace {

/// Returns the canonical folder of a file, with the name of the file as it is.
std::filesystem::path placeOf(const std::filesystem::path& file) {
    std::error_code code;
    const std::filesystem::path absolute = std::filesystem::absolute(file, code);
    return std::filesystem::weakly_canonical(absolute.parent_path(), code) / absolute.filename();
}

}  // namespace

std::vector<std::filesystem::path> filesNamedBy(const Scene& scene) {
    std::vector<std::filesystem::path> files;
    const auto add = [&](const std::filesystem::path& file) {
        if (!file.empty()) files.push_back(file);
    };
    const auto addMesh = [&](const std::filesystem::path& mesh) {
        add(mesh);
        for (const std::filesystem::path& beside : formats::gltfFilesBeside(mesh)) add(beside);
    };
    add(scene.file);
    for (const LightMapEntry& map : scene.lightMaps) {
        add(map.file);
        if (map.description.parts.empty())
            for (const std::filesystem::path& beside : formats::bakeFilesBeside(map.file, map.description.bake)) add(beside);
        if (!map.description.mesh.empty()) addMesh(map.description.mesh);
        add(map.description.lmbake);
        for (const auto& [part, file] : map.description.partFiles) add(file);
        if (map.mesh && *map.mesh != map.description.mesh) addMesh(*map.mesh);
        if (map.groundTruth) add(*map.groundTruth);
    }
    const auto addEnvironment = [&](const std::filesystem::path& file) {
        add(file);
        std::error_code code;
        for (const std::filesystem::path& face : formats::faceFiles(file))
            if (face != file && std::filesystem::exists(face, code)) add(face);
    };
    for (const ProbeEntry& probe : scene.probes) {
        addEnvironment(probe.file);
        if (probe.sh) add(*probe.sh);
    }
    for (const GradientEntry& gradient : scene.gradients) addEnvironment(gradient.file);
    add(scene.colors.config);
    return files;
}

NamedPlaces::NamedPlaces(const Scene& scene) {
    for (const std::filesystem::path& file : filesNamedBy(scene)) places_.insert(placeOf(file));
}

bool NamedPlaces::contains(const std::filesystem::path& file) const {
    return places_.contains(placeOf(file));
}

}  // namespace lightcook::pipeline
