// Light maps of Unreal in a glTF, encoded as Unreal quantizes them: for tests of bake format unreal-hq.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "formats/image.h"
#include "tests/formats/gltf/glb.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {

/// L UVW of a texel: the colour before directions count.
using UnrealLight = std::function<glm::dvec3(int x, int y)>;

/// Light between 0.02 and 40 of changing hue.
inline glm::dvec3 seededUnrealLight(int x, int y) {
    const double bright = 0.02 * std::exp2(11.0 * (0.5 + 0.5 * std::sin(0.7 * x + 1.3 * y)));
    return bright * glm::dvec3(0.6 + 0.4 * std::sin(0.9 * x), 0.6 + 0.4 * std::cos(0.5 * y), 0.6 + 0.4 * std::sin(0.4 * (x + y)));
}

/// The rectangle of a mesh in an image, in texels of the upper half.
struct UnrealRectangle {
    int x = 0, y = 0, width = 0, height = 0;
};

/// The constants of a mesh, as the exporter writes them.
struct UnrealConstants {
    glm::dvec4 scale{1}, add{0};
};

/// An image of light maps, as bytes.
class UnrealImage {
public:
    UnrealImage(int width, int height) : bytes_(width, 2 * height, std::array{0, 0, 0, 0}) {}

    int width() const { return bytes_.width(); }
    int height() const { return bytes_.height() / 2; }
    const std::array<int, 4>& upper(int x, int y) const { return bytes_.at(x, y); }
    const std::array<int, 4>& lower(int x, int y) const { return bytes_.at(x, y + height()); }

    /// Quantizes the light of a rectangle: U, V and W are the colour over the luminance, each brought to [0, 1] by its range over the
    /// rectangle, and stored as its square root. So is the logarithm of the luminance, without a root; what rounding takes from it goes to
    /// the alpha of the lower half.
    UnrealConstants encode(const UnrealRectangle& part, const UnrealLight& light) {
        glm::dvec4 low(1e9), high(-1e9);
        const auto visit = [&](const auto& action) {
            for (int y = part.y; y < part.y + part.height; ++y)
                for (int x = part.x; x < part.x + part.width; ++x) action(x, y, logLuvw(light(x, y)));
        };
        visit([&](int, int, const glm::dvec4& value) { low = glm::min(low, value), high = glm::max(high, value); });
        const glm::dvec4 range = glm::max(high - low, glm::dvec4(1e-6));
        visit([&](int x, int y, const glm::dvec4& value) {
            const glm::dvec4 unit = (value - low) / range;
            auto &above = bytes_.at(x, y), &below = bytes_.at(x, y + height());
            for (int c = 0; c < 3; ++c) above.at(static_cast<std::size_t>(c)) = rounded(std::sqrt(unit[c]));
            above[3] = rounded(unit.w);
            below = {17 + x, 130, 200 - y, rounded(255 * unit.w - std::round(255 * unit.w) + 0.5)};
        });
        return {range, low};
    }

    void writeTo(const std::filesystem::path& file, int channelCount = 4) const {
        writePng(file, bytes_.width(), bytes_.height(), channelCount,
                 [&](int channel, int x, int y) { return bytes_.at(x, y).at(static_cast<std::size_t>(channel)); });
    }

private:
    static int rounded(double unit) { return static_cast<int>(std::clamp(std::lround(255 * unit), 0L, 255L)); }
    static glm::dvec4 logLuvw(const glm::dvec3& colour) {
        const double luminance = glm::dot(colour, glm::dvec3(0.3, 0.59, 0.11));
        return glm::dvec4(luminance < 1e-4 ? glm::dvec3(1) : colour / luminance, std::log2(luminance + std::exp2(-5.75)));
    }

    Image<std::array<int, 4>> bytes_;
};

/// Returns an entry of the extension's `lightmaps`.
inline nlohmann::json unrealLightMap(const UnrealImage& image, const UnrealRectangle& part, const UnrealConstants& constants, int texture) {
    const auto four = [](const glm::dvec4& v) { return nlohmann::json::array({v.x, v.y, v.z, v.w}); };
    const double w = image.width(), h = image.height();
    return {{"name", "StaticMeshComponent0"},
            {"texture", {{"index", texture}, {"texCoord", 1}}},
            {"lightmapScale", four(constants.scale)},
            {"lightmapAdd", four(constants.add)},
            {"coordinateScaleBias", four({part.width / w, part.height / h, part.x / w, part.y / h})}};
}

/// Returns a glTF with light maps, a node for each, and no geometry.
/// images  entries of the document's `images`; texture i shows image i
inline nlohmann::json unrealGltf(nlohmann::json images, nlohmann::json lightMaps) {
    nlohmann::json textures = nlohmann::json::array(), nodes = nlohmann::json::array();
    for (std::size_t i = 0; i < images.size(); ++i) textures.push_back({{"source", i}});
    for (std::size_t i = 0; i < lightMaps.size(); ++i) {
        nodes.push_back({{"name", "Wall_" + std::to_string(i)}});
        nodes.back()["extensions"]["EPIC_lightmap_textures"]["lightmap"] = i;
    }
    return {{"asset", {{"version", "2.0"}}},
            {"extensionsUsed", {"EPIC_lightmap_textures"}},
            {"extensions", {{"EPIC_lightmap_textures", {{"lightmaps", std::move(lightMaps)}}}}},
            {"images", std::move(images)},
            {"textures", std::move(textures)},
            {"nodes", std::move(nodes)}};
}

}  // namespace lightcook::formats
