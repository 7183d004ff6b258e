// A whole scene, small enough to cook in a fraction of a second: light map, probe, gradient, scene.toml, in a folder of its own.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <string>

#include "formats/light_map.h"
#include "formats/plain_image.h"
#include "lighting/cube.h"
#include "pipeline/cook/cook.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {

/// Radiance from a direction, at a place of the light map in [0, 1]^2.
using LightField = std::function<glm::vec3(const glm::dvec3& direction, const glm::dvec2& place)>;

/// A warm sun over a blue sky, whose strength changes over the map.
inline glm::vec3 sunAndSky(const glm::dvec3& direction, const glm::dvec2& place) {
    const double sun = std::pow(std::max(0.0, glm::dot(direction, glm::normalize(glm::dvec3(0.4, 0.3, 0.86)))), 8) * (1 + 3 * place.x);
    const glm::dvec3 sky = glm::dvec3(0.2, 0.3, 0.5) * (0.6 + 0.4 * direction.z) * (0.5 + place.y);
    return glm::vec3(sun * glm::dvec3(1.0, 0.8, 0.6) + sky);
}
/// The grey test of "PI or not to PI": radiance 0.5 from everywhere.
inline glm::vec3 grey(const glm::dvec3&, const glm::dvec2&) {
    return glm::vec3(0.5f);
}

/// SH of a light field at a place, by a sum over cube texels.
inline lighting::ShRgb shOf(const LightField& light, const glm::dvec2& place) {
    constexpr int kSize = 8;
    std::array<glm::dvec3, 9> sums{};
    for (int face = 0; face < 6; ++face)
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) {
                const glm::dvec3 direction = lighting::cubeTexelDirection(face, x, y, kSize);
                const lighting::ShDouble basis = lighting::evaluateBasis(direction);
                const glm::dvec3 radiance = lighting::cubeTexelSolidAngle(x, y, kSize) * glm::dvec3(light(direction, place));
                for (std::size_t i = 0; i < 9; ++i) sums[i] += basis[i] * radiance;
            }
    lighting::ShRgb sh;
    for (std::size_t i = 0; i < 9; ++i) sh[i] = glm::vec3(sums[i]);
    return sh;
}

/// Cooks without reporting progress.
inline Outcome cook(const CookOptions& options) {
    const RunState state;
    return cookScene(options, state);
}

class SmallScene {
public:
    static constexpr int kWidth = 12, kHeight = 72;  ///< more than one band, and no whole number of them

    /// The light map alone (with what derives from it), or a probe and a gradient too: their brute-force verification takes seconds.
    enum class Parts { LightMap, All };

    /// height  of the light map; fewer texels for tests that verify it many times
    explicit SmallScene(Parts parts, const LightField& light = sunAndSky, int height = kHeight) : parts_(parts), height_(height) {
        writeLightMap(light);
        if (parts == Parts::All) {
            writeProbe(light);
            writeGradient(light);
        }
        writeSceneFile("light_map_layout = \"ratio\"");
    }

    std::filesystem::path operator/(const std::filesystem::path& name) const { return folder_ / name; }
    std::filesystem::path sceneFile() const { return folder_ / "scene.toml"; }

    /// The dominant light has textures, so that the scene has it as an asset, unless `materials` names its layout.
    /// output  lines for [output]; materials  keys of the light map, and whole tables; root  lines before the first table
    void writeSceneFile(const std::string& output, const std::string& materials = "", const std::string& root = "") const {
        const std::string others = parts_ == Parts::LightMap
                                       ? ""
                                       : "[[probe]]\nname = \"probe\"\nfile = \"probe.exr\"\nsize = 16\n\n"
                                         "[[gradient]]\nname = \"sky\"\nfile = \"sky.exr\"\nexponents = [1, 16, 256]\n\n";
        const bool isNamed = materials.find("dominant_layout") != std::string::npos;
        formats::writeContent(sceneFile(), fmt::format("schema = 1\nname = \"small\"\n{}\n[output]\n{}\n\n"
                                                       "[[light_map]]\nname = \"map\"\nfile = \"map.exr\"\n{}\n{}{}\n",
                                                       root, output, isNamed ? "" : "dominant_layout = \"full\"\n", others, materials));
    }

    /// Options of a cook into the folder "out", with the cache that all tests share: one run of an action serves every test.
    CookOptions options() const {
        CookOptions options;
        options.scene = sceneFile();
        options.output = folder_ / "out";
        options.cache = LIGHTCOOK_TEST_CACHE;
        return options;
    }
    /// The same with an empty cache, for tests of what runs again, of measured times, and of runs that end early.
    CookOptions optionsWithOwnCache() const {
        CookOptions own = options();
        own.cache = folder_ / "cache";
        return own;
    }

private:
    void writeLightMap(const LightField& light) const {
        auto writer = formats::LightMapWriter::create(folder_ / "map.exr", kWidth, height_);
        formats::Image<lighting::ShRgb> rows(kWidth, height_);
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < kWidth; ++x) rows.at(x, y) = shOf(light, {(x + 0.5) / kWidth, (y + 0.5) / height_});
        (void)writer->append(rows.view());
        (void)writer->commit();
    }
    void writeProbe(const LightField& light) const {
        constexpr int kSize = 16;
        formats::Image<glm::vec4> strip(kSize, 6 * kSize);
        for (int face = 0; face < 6; ++face)
            for (int y = 0; y < kSize; ++y)
                for (int x = 0; x < kSize; ++x)
                    strip.at(x, face * kSize + y) = glm::vec4(light(lighting::cubeTexelDirection(face, x, y, kSize), {0.5, 0.5}), 1.0f);
        (void)formats::writeExr(folder_ / "probe.exr", strip.view(), 3);
    }
    void writeGradient(const LightField& light) const {
        constexpr int kZones = 64;
        formats::Image<glm::vec4> zones(kZones, 1);
        for (int i = 0; i < kZones; ++i) {
            const double z = 1 - (2 * i + 1.0) / kZones;
            zones.at(i, 0) = glm::vec4(light({std::sqrt(1 - z * z), 0, z}, {0.5, 0.5}), 1.0f);
        }
        (void)formats::writeExr(folder_ / "sky.exr", zones.view(), 3);
    }

    Parts parts_;
    int height_;
    formats::TemporaryFolder folder_;
};

}  // namespace lightcook::pipeline
