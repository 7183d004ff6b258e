#include "pipeline/assets/mesh/mesh_inputs.h"

#include <fmt/format.h>

#include <algorithm>

namespace lightcook::pipeline {
namespace {

std::string lmbakeRole(const std::string& role) {
    return role + "_lmbake";
}

}  // namespace

std::map<std::string, std::filesystem::path> meshInputs(const std::string& role, const std::filesystem::path& mesh,
                                                        const std::filesystem::path& lmbake, formats::GltfFiles which) {
    std::map<std::string, std::filesystem::path> inputs = {{role, mesh}};
    int index = 0;
    for (const std::filesystem::path& beside : formats::gltfFilesBeside(mesh, which))
        inputs[fmt::format("{}_file{}", role, index++)] = beside;
    if (!lmbake.empty()) inputs[lmbakeRole(role)] = lmbake;
    return inputs;
}

std::filesystem::path lmbakeOf(const std::map<std::string, std::filesystem::path>& inputs, const std::string& role) {
    const auto found = inputs.find(lmbakeRole(role));
    return found != inputs.end() ? found->second : std::filesystem::path();
}

formats::Result<formats::GltfScene> loadMesh(const std::map<std::string, std::filesystem::path>& inputs, const std::string& role,
                                             const std::vector<formats::NodePlace>& places) {
    return formats::GltfScene::load(inputs.at(role), lmbakeOf(inputs, role), places);
}

std::string countOfNames(const std::vector<std::string>& names, std::string_view what) {
    constexpr std::size_t kMostShown = 8;
    std::string text = fmt::format("{} {}: ", names.size(), what);
    for (std::size_t i = 0; i < std::min(names.size(), kMostShown); ++i)
        text += fmt::format("{}'{}'", i > 0 ? ", " : "", formats::withoutControls(names[i]));
    if (names.size() > kMostShown) text += fmt::format(" and {} more", names.size() - kMostShown);
    return text;
}

}  // namespace lightcook::pipeline
