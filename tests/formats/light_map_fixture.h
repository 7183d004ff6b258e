// Light maps of seeded coefficients, for the tests of bake formats.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>

#include "formats/light_map.h"
#include "tests/formats/exr_fixture.h"
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

inline LightMapStrip readAll(const std::filesystem::path& file, const LightMapDescription& description = {}) {
    auto reader = LightMapReader::open(file, description);
    if (!reader) {
        ADD_FAILURE() << reader.error().line();
        return {};
    }
    auto strip = reader->read(0, reader->height());
    if (!strip) {
        ADD_FAILURE() << strip.error().line();
        return {};
    }
    return std::move(*strip);
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

inline lighting::ShRgb seededTexel(int x, int y) {
    lighting::ShRgb sh{};
    for (int index = 0; index < 9; ++index) {
        for (int channel = 0; channel < 3; ++channel) sh[static_cast<std::size_t>(index)][channel] = seededSh(index, channel, x, y);
    }
    return sh;
}

}  // namespace lightcook::formats
