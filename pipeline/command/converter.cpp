#include "pipeline/command/converter.h"

#include <fmt/format.h>

#include <cctype>

#include "pipeline/graph/files.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/scene/checks.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;

/// Copies the asset's only texture from the folder that it was cooked into to `output`.
Outcome keepTexture(Outcome outcome, const std::filesystem::path& output) {
    const auto manifest = readManifest(outcome.output);
    if (!manifest) return failedOutcome(manifest.error());
    const Json& textures = manifest->at("assets").at(0).at("textures");
    if (textures.size() != 1)
        return failedOutcome({ErrorCode::InvalidRequest, output.string(),
                              fmt::format("found {} textures to write, expected a folder for them", textures.size())});
    const std::string file = textures[0].at("file").get<std::string>();
    if (auto copied = copyFile(outcome.output / file, output); !copied) return failedOutcome(copied.error());
    outcome.output = output;
    return outcome;
}

}  // namespace

Outcome failedOutcome(formats::Error error) {
    return {{std::move(error)}, {}, {}, 0, 0};
}

Scene sceneFor(const ConverterOptions& options) {
    Scene scene;
    scene.directory = options.input.parent_path();
    return scene;
}

std::string assetNameFor(const std::filesystem::path& input, const std::string& otherwise) {
    std::string name = input.stem().string();
    for (char& c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '-' && c != '.') c = '_';
    if (name.size() > kLongestName) name.resize(kLongestName);
    return name.empty() || name.front() == '.' ? otherwise : name;
}

formats::Result<void> checkContainer(const CookOptions& cook, const std::filesystem::path& output) {
    const auto named = output.extension() == ".dds" ? formats::Container::Dds : formats::Container::Ktx2;
    if (!cook.container || *cook.container == named) return {};
    return formats::failure(ErrorCode::InvalidRequest, "--container",
                            fmt::format("found another container than that of {}, expected the same, or no --container", output.string()));
}

Outcome convertScene(Scene scene, const std::string& kind, const ConverterOptions& options, const RunState& state) {
    CookOptions cook = options.cook;
    cook.onlyKind = kind;
    const std::string extension = options.output.extension().string();
    if (extension != ".ktx2" && extension != ".dds") {
        cook.output = options.output;
        return cookScene(std::move(scene), cook, state);
    }
    if (auto checked = checkContainer(options.cook, options.output); !checked) return failedOutcome(checked.error());
    cook.container = extension == ".dds" ? formats::Container::Dds : formats::Container::Ktx2;
    auto folder = TemporaryFolder::create();
    if (!folder) return failedOutcome(folder.error());
    cook.output = folder->path() / "cooked";
    Outcome outcome = cookScene(std::move(scene), cook, state);
    return outcome.errors.empty() ? keepTexture(std::move(outcome), options.output) : outcome;
}

}  // namespace lightcook::pipeline
