#include "pipeline/assets/mesh/mesh_inputs.h"

#include <fmt/format.h>

namespace lightcook::pipeline {

std::map<std::string, std::filesystem::path> meshInputs(const std::string& role, const std::filesystem::path& mesh,
                                                        formats::GltfFiles which) {
    std::map<std::string, std::filesystem::path> inputs = {{role, mesh}};
    int index = 0;
    for (const std::filesystem::path& beside : formats::gltfFilesBeside(mesh, which))
        inputs[fmt::format("{}_file{}", role, index++)] = beside;
    return inputs;
}

}  // namespace lightcook::pipeline
