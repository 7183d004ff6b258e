// Light maps of seeded coefficients, for the tests of bake formats.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>

#include "formats/light_map.h"
#include "tests/formats/exr_fixture.h"
#include "tests/formats/read_light_map.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::formats {

/// A map of seeded coefficients in a folder of its own.
struct MapFile {
    TemporaryFolder folder;
    std::filesystem::path path = folder / "map.exr";

    explicit MapFile(const ExrRecipe& recipe) { writeRecipe(path, recipe); }
};

inline ExrRecipe seededMap(int width, int height) {
    ExrRecipe recipe;
    recipe.width = width;
    recipe.height = height;
    recipe.channels = seededShChannels();
    return recipe;
}

/// Returns the error of opening and reading a whole map.
inline Error refusal(const std::filesystem::path& file, const LightMapDescription& description = {}) {
    auto reader = LightMapReader::open(file, description);
    if (!reader) return reader.error();
    const auto strip = reader->read(0, reader->height());
    if (!strip) return strip.error();
    ADD_FAILURE() << file << " was not refused";
    return {};
}

/// Tests compare the light that an engine shows with the light that we read at these normals.
inline const std::array<glm::dvec3, 4> kShadedNormals = {glm::dvec3(0, 0, 1), glm::dvec3(0, -1, 0), glm::normalize(glm::dvec3(1, 2, -2)),
                                                         glm::normalize(glm::dvec3(-3, 1, 0.5))};

/// Exit radiance of a white surface under radiance SH of order 1, written out: Y of bands 0 and 1, times the 1 and 2/3 of the cosine.
inline double exitRadianceOfOrder1(const lighting::ShRgb& sh, int c, const glm::dvec3& n) {
    const auto at = [&](std::size_t i) { return static_cast<double>(sh[i][c]); };
    const double first = 1 / std::sqrt(4 * std::numbers::pi), linear = std::sqrt(3 / (4 * std::numbers::pi));
    return first * at(0) + 2.0 / 3 * linear * (at(1) * n.y + at(2) * n.z + at(3) * n.x);
}

inline lighting::ShRgb seededTexel(int x, int y) {
    lighting::ShRgb sh{};
    for (int index = 0; index < 9; ++index) {
        for (int channel = 0; channel < 3; ++channel) sh[static_cast<std::size_t>(index)][channel] = seededSh(index, channel, x, y);
    }
    return sh;
}

}  // namespace lightcook::formats
