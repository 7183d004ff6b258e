#include "pipeline/assets/source_colors.h"

namespace lightcook::pipeline {

formats::ColorSpaces withConfig(const formats::ColorSpaces& colors, const Action& action) {
    const auto config = action.inputs.find(kColorConfigRole);
    return {colors.source, colors.working, config == action.inputs.end() ? std::filesystem::path() : config->second};
}

formats::EnvironmentOptions environmentOptions(const AssetSource& source, const Action& action) {
    return {withConfig(source.colors.value_or(formats::ColorSpaces{}), action), source.repair.value_or(false)};
}

}  // namespace lightcook::pipeline
