// A scene cooked into its own folder, and opened as an engine and as the verifier do.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/light_map_layout.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/textures.h"
#include "pipeline/manifest/manifest.h"
#include "tests/pipeline/small_scene.h"
#include "tests/samplers/second_opinion.h"
#include "verify/texture_unit.h"

namespace lightcook::samplers {

using Image = formats::Image<glm::vec4>;

/// A lamp near the map behind bars, below a dim sky. Its direction differs from texel to texel, which suits the layout of detail.
inline glm::vec3 lampBehindBars(const glm::dvec3& direction, const glm::dvec2& place) {
    const glm::dvec3 towards(0.5 * (0.5 - place.x), 3 * (0.4 - place.y), 0.35);
    const double squared = glm::dot(towards, towards);
    const double lamp = std::fmod(place.x + 6 * place.y, 1.7) > 0.5 ? 1 / (0.2 + squared) : 0;
    const double lobe = std::pow(std::max(0.0, glm::dot(direction, towards) / std::sqrt(squared)), 16);
    const glm::dvec3 sky = glm::dvec3(0.2, 0.3, 0.5) * (0.6 + 0.4 * direction.z) * (0.5 + place.y);
    return glm::vec3(lamp * lobe * glm::dvec3(1.0, 0.8, 0.6) + sky);
}

/// A cooked folder, and its sources while they are needed.
class CookedScene {
public:
    /// detail  visible error that detail of the light map, of lampBehindBars(), keeps; 0: it has none
    CookedScene(pipeline::SmallScene::Parts parts, const std::string& target, const std::string& layout, double detail = 0)
        : small_(std::make_unique<pipeline::SmallScene>(parts, detail > 0 ? lampBehindBars : pipeline::sunAndSky)) {
        const std::string keys = detail > 0 ? fmt::format("\ndetail = true\nmax_visible = {}", detail) : "";
        small_->writeSceneFile(fmt::format("target = \"{}\"\nlight_map_layout = \"{}\"{}", target, layout, keys),
                               layout.starts_with("flat") ? "[[material]]\nname = \"*\"\nnormal_map = false\nspecular = false\n" : "");
        pipeline::CookOptions options = small_->options();
        const auto known = formats::lightMapLayoutFromName(layout);
        if (known && formats::info(*known).lacks == "band 2") options.given.set("output.max_error", 1);
        cook(options);
    }
    CookedScene(const std::filesystem::path& scene, const std::string& layout, std::optional<std::string> onlyKind = {},
                double maxError = 0.1) {
        pipeline::CookOptions options;
        options.scene = scene;
        options.cache = LIGHTCOOK_TEST_CACHE;
        options.given.set("output.light_map_layout", layout);
        options.onlyKind = std::move(onlyKind);
        options.given.set("output.max_error", maxError);
        options.given.set("output.effort", 3);
        cook(options);
    }
    std::filesystem::path folder() const { return own_ / "out"; }
    std::string shader() const { return formats::contentOf(folder() / pipeline::kShaderName); }
    const pipeline::Json& assets() const { return manifest_.at("assets"); }
    const pipeline::Json& asset(const std::string& name) const {
        for (const pipeline::Json& each : assets())
            if (each.at("name") == name) return each;
        throw std::runtime_error("no asset " + name);
    }
    Ktx2 ktx2(const pipeline::Json& texture) const { return readKtx2(folder() / texture.at("file").get<std::string>()); }
    /// Returns the texture, read by formats/ and decoded by verify/: mip by mip, layer by layer, face by face.
    std::vector<Image> decoded(const pipeline::Json& asset, const std::string& role) const {
        const auto reader =
            valueOf(pipeline::openTexture(folder(), valueOf(pipeline::fromJson<pipeline::CookedAsset>(asset, "manifest")), role));
        std::vector<Image> images;
        for (int mip = 0; mip < reader.shape().mipCount; ++mip)
            for (int layer = 0; layer < reader.shape().layerCount; ++layer)
                for (int face = 0; face < reader.shape().faceCount; ++face)
                    images.push_back(valueOf(verify::decodeImage(reader, {mip, layer, face})));
        return images;
    }

    /// Returns the constants of a light map, with those that a texture holds.
    pipeline::LightMapConstants constants(const pipeline::Json& asset) const {
        return valueOf(pipeline::constantsOf(folder(), valueOf(pipeline::fromJson<pipeline::CookedAsset>(asset, "manifest"))));
    }
    /// Returns the clusters of a light map whose texture names them.
    std::vector<std::uint8_t> clusters(const pipeline::Json& asset) const {
        return valueOf(pipeline::clustersOfBlocks(folder(), valueOf(pipeline::fromJson<pipeline::CookedAsset>(asset, "manifest"))));
    }

private:
    void cook(pipeline::CookOptions options) {
        options.output = folder();
        const pipeline::RunState state;
        const pipeline::Outcome outcome = pipeline::cookScene(options, state);
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        manifest_ = valueOf(pipeline::readManifest(folder()));
    }

    std::unique_ptr<pipeline::SmallScene> small_;
    formats::TemporaryFolder own_;
    pipeline::Json manifest_;
};

}  // namespace lightcook::samplers
