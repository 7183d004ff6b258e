#include "pipeline/assets/source_colors.h"

#include <fmt/format.h>

#include <mutex>
#include <tuple>
#include <vector>

namespace lightcook::pipeline {
namespace {

using Files = std::vector<std::filesystem::path>;

/// Returns formats::filesOfConversion(). Keeps the result until the configuration changes: a plan asks for the inputs of every action, and
/// large configurations take a while to parse.
Files configFiles(const formats::ColorSpaces& colors) {
    using Key = std::tuple<std::filesystem::path, std::string, std::string, std::filesystem::file_time_type>;
    static std::mutex mutex;
    static std::map<Key, Files> known;
    std::error_code code;
    const auto written = std::filesystem::last_write_time(colors.config, code);
    if (code) return {};
    const std::lock_guard lock(mutex);
    const auto [place, isNew] = known.try_emplace({colors.config, colors.source, colors.working, written});
    if (isNew) place->second = formats::filesOfConversion(colors);
    return place->second;
}

}  // namespace

bool isColorConfigRole(std::string_view role) {
    return role == kColorConfigRole || role.starts_with(fmt::format("{}-", kColorConfigRole));
}

std::map<std::string, std::filesystem::path> sourceInputs(const std::filesystem::path& file, const formats::ColorSpaces& colors) {
    std::map<std::string, std::filesystem::path> inputs = {{"source", file}};
    if (colors.config.empty()) return inputs;
    inputs[kColorConfigRole] = colors.config;
    int number = 0;
    for (const std::filesystem::path& each : configFiles(colors)) inputs[fmt::format("{}-{}", kColorConfigRole, ++number)] = each;
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
