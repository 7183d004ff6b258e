#include "pipeline/assets/source_colors.h"

namespace lightcook::pipeline {

std::map<std::string, std::filesystem::path> sourceInputs(const std::filesystem::path& file, const formats::ColorSpaces& colors) {
    std::map<std::string, std::filesystem::path> inputs = {{"source", file}};
    if (!colors.config.empty()) inputs[kColorConfigRole] = colors.config;
    return inputs;
}

std::map<std::string, std::filesystem::path> environmentInputs(const std::filesystem::path& file, const formats::ColorSpaces& colors) {
    std::map<std::string, std::filesystem::path> inputs = sourceInputs(file, colors);
    std::error_code code;
    for (const std::filesystem::path& face : formats::faceFiles(file))
        if (face != file && std::filesystem::exists(face, code)) inputs["source-" + face.stem().string()] = face;
    return inputs;
}

formats::ColorSpaces withConfig(const formats::ColorSpaces& colors, const Action& action) {
    const auto config = action.inputs.find(kColorConfigRole);
    return {colors.source, colors.working, config == action.inputs.end() ? std::filesystem::path() : config->second};
}

formats::EnvironmentOptions environmentOptions(const AssetSource& source, const Action& action) {
    return {withConfig(source.colors.value_or(formats::ColorSpaces{}), action), source.repair.value_or(false)};
}

}  // namespace lightcook::pipeline
