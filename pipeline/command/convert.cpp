#include "pipeline/command/convert.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "pipeline/graph/files.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/explained_light.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;

/// A name for the asset: the input's, as far as a name may hold it.
std::string assetName(const ConvertOptions& options) {
    std::string name = options.converter == "lut" ? "specular" : options.input.stem().string();
    for (char& c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '-' && c != '.') c = '_';
    return name.empty() || name.front() == '.' ? options.converter : name;
}

formats::LightMapDescription descriptionOf(const ConvertOptions& options) {
    formats::LightMapDescription description;
    description.phase = options.phase == "none" ? formats::ShPhase::None : formats::ShPhase::CondonShortley;
    description.frame = options.frame == "world" ? formats::ShFrame::World : formats::ShFrame::Tangent;
    description.quantity = options.quantity == "radiance" ? formats::ShQuantity::Radiance : formats::ShQuantity::Irradiance;
    description.lightUnits = options.lightUnits == "radiometric" ? formats::LightUnits::Radiometric : formats::LightUnits::Game;
    description.fireflyLimit = options.fireflyLimit;
    return description;
}

/// The m of a cosine power: s = 2 / m^2 - 2.
double roughnessOf(double exponent) {
    return std::sqrt(2 / (exponent + 2));
}

/// What no table can be made of, told in the words of the command line.
std::optional<Error> tableMistake(const ConvertOptions& options) {
    const auto mistake = [](const char* option, const std::string& found, const std::string& expected) {
        return Error{ErrorCode::InvalidRequest, option, fmt::format("found {}, expected {}", found, expected)};
    };
    const bool isPower = options.tables.lobe == "phong-power";
    if (!options.exponents.empty()) {
        const double low = options.exponents[0], high = options.exponents[1];
        if (!isPower) return mistake("--exponents", "lobe " + options.tables.lobe, "--lobe phong-power, or --m");
        if (!options.m.empty()) return mistake("--exponents", "--m beside it", "one of them");
        if (!(0 <= low && low <= high && high <= 1e8))
            return mistake("--exponents", fmt::format("{},{}", low, high), "0 <= low <= high <= 1e8");
    }
    if (options.tables.lobe.starts_with("phong") && options.tables.normalization != "energy")
        return mistake("--normalization", options.tables.normalization, "energy, the only one of a Phong lobe");
    return std::nullopt;
}

Scene sceneOf(const ConvertOptions& options, const std::string& name) {
    Scene scene;
    scene.name = name;
    scene.directory = options.input.parent_path();
    if (options.converter == "lightmap" || options.converter == "dominant") {
        LightMapEntry entry;
        entry.name = name;
        entry.file = options.input;
        entry.description = descriptionOf(options);
        entry.dominantFit = options.fit;
        scene.lightMaps.push_back(entry);
    } else if (options.converter == "cubemap") {
        scene.probes.push_back({name, options.input, options.sh.empty() ? std::nullopt : std::optional(options.sh)});
    } else if (options.converter == "rsrm") {
        GradientEntry entry{name, options.input};
        if (!options.exponents.empty()) entry.exponents = options.exponents;
        entry.encoding = options.encoding;
        if (options.axis.size() == 3) entry.axis = glm::dvec3(options.axis[0], options.axis[1], options.axis[2]);
        entry.zones = options.zones;
        entry.format = options.rsrmFormat;
        entry.dither = options.dither;
        scene.gradients.push_back(entry);
    } else {
        MaterialEntry material;
        material.name = "*";
        if (options.m.size() == 2) material.m = Range{options.m[0], options.m[1]};
        if (options.exponents.size() == 2) material.m = Range{roughnessOf(options.exponents[1]), roughnessOf(options.exponents[0])};
        scene.materials.push_back(material);
        scene.tables = options.tables;
    }
    return scene;
}

Outcome failed(Error error) {
    return {{std::move(error)}, {}, {}, 0, 0};
}

/// Moves the asset's only texture out of the folder it was cooked into.
Outcome keepTexture(Outcome outcome, const std::filesystem::path& output) {
    const auto manifest = readManifest(outcome.output);
    if (!manifest) return failed(manifest.error());
    const Json& textures = manifest->at("assets").at(0).at("textures");
    if (textures.size() != 1)
        return failed({ErrorCode::InvalidRequest, output.string(),
                       fmt::format("found {} textures to write, expected a folder for them", textures.size())});
    const std::string file = textures[0].at("file").get<std::string>();
    if (auto copied = copyFile(outcome.output / file, output); !copied) return failed(copied.error());
    outcome.output = output;
    return outcome;
}

}  // namespace

formats::Result<Json> explain(const ConvertOptions& options, const RunState& state) {
    formats::LightMapDescription description = descriptionOf(options);
    description.repair = options.repair;
    return explainDominant(options.input, description, options.fit == "refined-ambient", state);
}

Outcome convert(const ConvertOptions& options, const RunState& state) {
    if (!formats::isFireflyLimit(options.fireflyLimit))
        return failed({ErrorCode::InvalidRequest, "--firefly-limit",
                       fmt::format("found {}, expected a number from 1, or 0 to believe all", options.fireflyLimit)});
    if (options.m.size() == 2 && !(0 <= options.m[0] && options.m[0] <= options.m[1] && options.m[1] <= 1))
        return failed(
            {ErrorCode::InvalidRequest, "--m", fmt::format("found {},{}, expected 0 <= low <= high <= 1", options.m[0], options.m[1])});
    if (options.converter == "lut")
        if (const auto mistake = tableMistake(options)) return failed(*mistake);
    const std::string name = assetName(options);
    CookOptions cook = options.cook;
    cook.repair = options.repair;
    cook.onlyKind = options.converter == "lightmap" ? "light-map" : options.converter;
    const std::string extension = options.output.extension().string();
    const bool isFile = extension == ".ktx2" || extension == ".dds";
    if (!isFile) {
        cook.output = options.output;
        return cookScene(sceneOf(options, name), cook, state);
    }
    cook.container = extension == ".dds" ? formats::Container::Dds : formats::Container::Ktx2;
    auto folder = TemporaryFolder::create();
    if (!folder) return failed(folder.error());
    cook.output = folder->path() / "cooked";
    Outcome outcome = cookScene(sceneOf(options, name), cook, state);
    return outcome.errors.empty() ? keepTexture(std::move(outcome), options.output) : outcome;
}

}  // namespace lightcook::pipeline
