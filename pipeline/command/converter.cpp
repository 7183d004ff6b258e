#include "pipeline/command/converter.h"

#include <fmt/format.h>

#include "formats/light_map_layout.h"
#include "pipeline/assets/asset_kind.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/texture_file.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/scene/lint_checks.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;

constexpr const char* kOutputsWithConstants = "a .ktx2 file, or a folder with --container dds, whose cooked.json has them";

/// Returns true if the only texture of an asset is known to have constants before it is cooked. Light maps of engines may have none, and
/// the layout of others may be chosen by the cook.
bool isKnownToHaveConstants(const std::string& kind, const CookOptions& cook) {
    if (kind != info(AssetKind::LightMap).name) return true;
    const auto layout = formats::lightMapLayoutFromName(cook.lightMapLayout.value_or(""));
    return layout && formats::info(*layout).textures.size() == 1 && !formats::info(*layout).isForEngine;
}

/// Copies the asset's only texture from the folder that it was cooked into to `output`.
Outcome keepTexture(Outcome outcome, const std::filesystem::path& output) {
    const auto manifest = readManifest(outcome.output);
    if (!manifest) return failedOutcome(manifest.error());
    if (manifest->at("assets").empty())
        return failedOutcome({ErrorCode::InvalidRequest, output.string(), "found nothing to write: the cook left the asset out"});
    const Json& asset = manifest->at("assets").at(0);
    const Json& textures = asset.at("textures");
    if (textures.size() != 1)
        return failedOutcome({ErrorCode::InvalidRequest, output.string(),
                              fmt::format("found {} textures to write, expected a folder for them", textures.size())});
    if (containerOf(output) == formats::Container::Dds && !asset.value("constants", Json::object()).empty())
        return failedOutcome(constantsAreLost(output, kOutputsWithConstants));
    const std::string file = textures[0].at("file").get<std::string>();
    if (auto copied = copyFile(outcome.output / file, output, OutputLink::Follow); !copied) return failedOutcome(copied.error());
    outcome.output = output;
    return outcome;
}

}  // namespace

Outcome failedOutcome(formats::Error error) {
    return {{std::move(error)}, {}, {}, 0, 0};
}

formats::ColorSpaces colorsOf(const std::optional<std::string>& source) {
    formats::ColorSpaces colors;
    colors.source = source.value_or(formats::kStatedSource);
    return colors;
}

formats::Result<void> checkSource(const std::optional<std::string>& source) {
    if (!source) return {};
    const auto checked = formats::checkColorSpace(*source, {});
    if (checked) return {};
    return formats::failure(ErrorCode::InvalidRequest, "--source", checked.error().detail);
}

Scene sceneFor(const ConverterOptions& options) {
    Scene scene;
    scene.colors = colorsOf(options.source);
    if (options.source) scene.allowances.push_back({LintCheck::WrongPrimaries, {}, "--source"});
    scene.directory = options.input.parent_path();
    return scene;
}

formats::Result<void> checkContainer(const CookOptions& cook, const std::filesystem::path& output) {
    if (!cook.container || *cook.container == containerOf(output)) return {};
    return formats::failure(ErrorCode::InvalidRequest, "--container",
                            fmt::format("found another container than that of {}, expected the same, or no --container", output.string()));
}

formats::Error constantsAreLost(const std::filesystem::path& output, const std::string& otherwise) {
    return {ErrorCode::InvalidRequest, output.string(),
            fmt::format("found a DDS file, which cannot hold the constants that its texels are decoded with, expected {}", otherwise)};
}

Outcome convertScene(Scene scene, const std::string& kind, const ConverterOptions& options, const RunState& state) {
    CookOptions cook = options.cook;
    cook.onlyKind = kind;
    if (!isTextureFile(options.output)) {
        if (auto checked = checkFolderName(options.output, "or a .ktx2 file"); !checked) return failedOutcome(checked.error());
        cook.output = options.output;
        return cookScene(std::move(scene), cook, state);
    }
    if (auto checked = checkContainer(options.cook, options.output); !checked) return failedOutcome(checked.error());
    cook.container = containerOf(options.output);
    if (cook.container == formats::Container::Dds && isKnownToHaveConstants(kind, options.cook))
        return failedOutcome(constantsAreLost(options.output, kOutputsWithConstants));
    auto folder = TemporaryFolder::create();
    if (!folder) return failedOutcome(folder.error());
    cook.output = folder->path() / "cooked";
    Outcome outcome = cookScene(std::move(scene), cook, state);
    return outcome.errors.empty() ? keepTexture(std::move(outcome), options.output) : outcome;
}

}  // namespace lightcook::pipeline
