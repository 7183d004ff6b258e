// Faults of baked lighting, each planted in a copy of the example scene.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "lighting/radiometry.h"
#include "tests/pipeline/lint/planted_scene.h"

namespace lightcook::pipeline::faults {

// Conventions of the light map

inline void otherPhase(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) {
        map.forEachCoefficient([](int i, float& value) {
            if (i == 1 || i == 3 || i == 5 || i == 7) value = -value;
        });
    });
}

/// Coefficients of light in axes (x, z, y), as a baker that is Z up writes them, beside normals that somebody had turned already.
inline void swappedAxes(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) {
        for (const char channel : {'R', 'G', 'B'}) {
            const auto sh = [&](int i) -> std::vector<float>& { return map[fmt::format("sh0{}.{}", i, channel)]; };
            std::swap(sh(1), sh(2));
            std::swap(sh(4), sh(7));
            // 3 y^2 - 1 and x^2 - y^2 become 3 z^2 - 1 and x^2 - z^2.
            for (std::size_t i = 0; i < sh(6).size(); ++i) {
                const double a = sh(6)[i], b = sh(8)[i];
                sh(6)[i] = static_cast<float>(-0.5 * a - 0.5 * std::sqrt(3.0) * b);
                sh(8)[i] = static_cast<float>(-0.5 * std::sqrt(3.0) * a + 0.5 * b);
            }
        }
    });
}

inline void otherFrame(const PlantedScene& scene) {
    scene.replaceInScene("frame = \"world\"", "frame = \"tangent\"");
}

inline void someNormalsTurned(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) {
        for (const char axis : {'X', 'Y', 'Z'})
            for (std::size_t i = 0; i < map[fmt::format("normal.{}", axis)].size(); i += 3) map[fmt::format("normal.{}", axis)][i] *= -1;
    });
}

inline void irradiance(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) {
        map.forEachCoefficient([](int i, float& value) {
            value *= static_cast<float>(lighting::kIrradianceBands[i == 0 ? 0 : i < 4 ? 1 : 2]);
        });
    });
}

inline void statedIrradiance(const PlantedScene& scene) {
    scene.replaceInScene("quantity = \"radiance\"", "quantity = \"irradiance\"");
}

inline void gameUnits(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) { map.forEachCoefficient([](int, float& value) { value /= std::numbers::pi_v<float>; }); });
}

inline float underCurve(float value) {
    return std::copysign(std::pow(std::abs(value), 1 / 2.2f), value);
}

inline void gammaCurve(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) { map.forEachCoefficient([](int, float& value) { value = underCurve(value); }); });
}

inline void otherPrimaries(const PlantedScene& scene) {
    scene.statePrimaries({0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f});
}

// Probe

inline void editProbeValues(const PlantedScene& scene, float (*edit)(float)) {
    scene.editProbe([&](Channels& probe) {
        for (auto& [name, texels] : probe.values) std::ranges::transform(texels, texels.begin(), edit);
    });
}

inline void gammaCurveOnProbe(const PlantedScene& scene) {
    editProbeValues(scene, underCurve);
}

inline void eightBitProbe(const PlantedScene& scene) {
    editProbeValues(scene, [](float value) { return std::round(255 * std::min(1.0f, underCurve(value))) / 255; });
}

/// No light above 1, in floats.
inline void clippedProbe(const PlantedScene& scene) {
    editProbeValues(scene, [](float value) { return std::min(1.0f, value); });
}

inline void blackProbe(const PlantedScene& scene) {
    editProbeValues(scene, [](float) { return 0.0f; });
}

inline void blackGradient(const PlantedScene& scene) {
    scene.editGradient([](Channels& gradient) {
        for (auto& [name, texels] : gradient.values) std::ranges::fill(texels, 0.0f);
    });
}

inline void probeOfAnotherPlace(const PlantedScene& scene) {
    scene.editProbe([](Channels& probe) {
        for (auto& [name, texels] : probe.values) std::ranges::reverse(texels);
    });
}

/// SH of a list that somebody has not filled in.
inline void zeroShOfProbe(const PlantedScene& scene) {
    std::string rows = "[0, 0, 0]";
    for (int i = 1; i < 9; ++i) rows += ", [0, 0, 0]";
    formats::writeContent(scene / "cornell_probes.json",
                          fmt::format(R"({{"probes": [{{"file": "cornell_probe0.exr", "sh": [{}]}}]}})", rows));
}

// Coverage and normals

inline void coverageOfOneHalf(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) {
        for (float& value : map["coverage.Y"]) value *= 0.5f;
    });
}

inline void noCoverageChannel(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) { map.values.erase("coverage.Y"); });
}

inline void chartOfOneHalf(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) {
        map.values["chart.Y"] = map["coverage.Y"];
        map["chart.Y"][map.index(100, 7)] = 0.5f;
    });
}

inline void coverageOfNan(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) { map["coverage.Y"][map.index(100, 7)] = NAN; });
}

inline void zeroNormals(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) {
        for (const char* name : {"normal.X", "normal.Y", "normal.Z"}) map[name].assign(map[name].size(), 0);
    });
}

inline void editNormals(const PlantedScene& scene, float (*edit)(float)) {
    scene.editLightMap([&](Channels& map) {
        for (const char* name : {"normal.X", "normal.Y", "normal.Z"}) std::ranges::transform(map[name], map[name].begin(), edit);
    });
}

inline void encodedNormals(const PlantedScene& scene) {
    editNormals(scene, [](float value) { return 0.5f * value + 0.5f; });
}

inline void longNormals(const PlantedScene& scene) {
    editNormals(scene, [](float value) { return 3 * value; });
}

inline void coverageOf255(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) {
        for (float& value : map["coverage.Y"]) value *= 255;
    });
}

inline void negativeCoverage(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) { map["coverage.Y"][map.index(100, 7)] = -1; });
}

inline void someZeroNormals(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) {
        for (const char* name : {"normal.X", "normal.Y", "normal.Z"})
            for (std::size_t i = 0; i < map[name].size(); i += 100) map[name][i] = 0;
    });
}

// Light

/// Returns a texel inside a chart with a neighbour outside, whose neighbours are lit.
inline std::pair<int, int> rimTexel(Channels& map) {
    const auto covered = [&](int x, int y) { return map["coverage.Y"][map.index(x, y)] > 0.5f; };
    for (int y = 20; y < map.height - 1; ++y)
        for (int x = 1; x < map.width - 1; ++x)
            if (covered(x, y) && covered(x + 1, y) && !covered(x - 1, y) && map["sh00.R"][map.index(x + 1, y)] > 0.1f) return {x, y};
    throw std::invalid_argument("the map has no rim");
}

inline void rimFirefly(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) {
        const auto [x, y] = rimTexel(map);
        for (const char channel : {'R', 'G', 'B'}) map[fmt::format("sh00.{}", channel)][map.index(x, y)] = 1e6f;
    });
}

/// The lower half of the map: whole charts, and parts of others, which are not black then.
inline void blackHalf(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) {
        for (int i = 0; i < 9; ++i)
            for (const char channel : {'R', 'G', 'B'}) {
                std::vector<float>& values = map[fmt::format("sh0{}.{}", i, channel)];
                std::fill(values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end(), 0.0f);
            }
    });
}

inline void faintLight(const PlantedScene& scene) {
    scene.editLightMap([](Channels& map) { map.forEachCoefficient([](int, float& value) { value *= 1e-7f; }); });
}

// Mesh

inline void editUvs(const PlantedScene& scene, void (*edit)(glm::vec2&)) {
    scene.editMesh([&](Glb& glb) { glb.forEachUv(edit); });
}

inline void turnedUvs(const PlantedScene& scene) {
    editUvs(scene, [](glm::vec2& uv) { uv = glm::vec2(uv.y, 1 - uv.x); });
}

inline void flippedV(const PlantedScene& scene) {
    editUvs(scene, [](glm::vec2& uv) { uv.y = 1 - uv.y; });
}

inline void uvsOutside(const PlantedScene& scene) {
    editUvs(scene, [](glm::vec2& uv) { uv.x -= 1; });
}

inline void overlappingUvs(const PlantedScene& scene) {
    scene.editMesh([](Glb& glb) {
        auto& primitives = glb.json["meshes"][0]["primitives"];
        primitives.push_back(primitives[0]);
    });
}

/// No fault: a second mesh in the same place of the map, which no node draws.
inline void undrawnMesh(const PlantedScene& scene) {
    scene.editMesh([](Glb& glb) { glb.json["meshes"].push_back(glb.json["meshes"][0]); });
}

inline void drawnTwice(const PlantedScene& scene) {
    scene.editMesh([](Glb& glb) {
        glb.json["nodes"].push_back(glb.json["nodes"][0]);
        glb.json["scenes"][0]["nodes"].push_back(glb.json["nodes"].size() - 1);
    });
}

inline void drawnByInstances(const PlantedScene& scene) {
    scene.editMesh([](Glb& glb) {
        glb.json["accessors"].push_back({{"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
        glb.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = glb.json["accessors"].size() - 1;
        glb.json["extensionsUsed"].push_back("EXT_mesh_gpu_instancing");
    });
}

inline void flatTriangles(const PlantedScene& scene) {
    scene.editMesh([](Glb& glb) { glb.json["nodes"][0]["scale"] = {0, 0, 0}; });
}

inline void farTriangles(const PlantedScene& scene) {
    scene.editMesh([](Glb& glb) { glb.json["nodes"][0]["scale"] = {1, 1e12, 1}; });
}

inline void meshBelowItself(const PlantedScene& scene) {
    scene.editMesh([](Glb& glb) { glb.json["nodes"][0]["children"] = {0}; });
}

inline void noNodes(const PlantedScene& scene) {
    scene.editMesh([](Glb& glb) { glb.json["scenes"][0]["nodes"].clear(); });
}

inline void roughnessOfFive(const PlantedScene& scene) {
    scene.editMesh([](Glb& glb) { glb.json["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 5; });
}

inline void unknownMaterial(const PlantedScene& scene) {
    scene.replaceInScene("name = \"*\"", "name = \"whit\"");
}

/// A material whose extension is not read, in a scene that does not say how rough it is.
inline void materialExtension(const PlantedScene& scene) {
    scene.editMesh([](Glb& glb) { glb.json["materials"][0]["extensions"]["KHR_materials_sheen"]["sheenColorFactor"] = {1, 1, 1}; });
    scene.replaceInScene("\nm = [0.1, 0.5]", "\n# m = [0.1, 0.5]");
}

inline void staleBake(const PlantedScene& scene) {
    std::filesystem::last_write_time(scene / "cornell.glb",
                                     std::filesystem::last_write_time(scene / "cornell_lightmap.exr") + std::chrono::hours(26));
}

// Settings

inline void limitAboveOne(const PlantedScene& scene) {
    scene.replaceInScene("max_error = 0.02 ", "max_error = 2 ");
}

/// display  lines for [display]
inline void display(const PlantedScene& scene, const std::string& display) {
    scene.replaceInScene("[color]", "[display]\n" + display + "\n\n[color]");
}

}  // namespace lightcook::pipeline::faults
