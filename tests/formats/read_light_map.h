// Reads a whole light map in a test.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <utility>

#include "formats/light_map.h"

namespace lightcook::formats {

/// Returns all rows of a map; a failure of the test and nothing where it cannot be read.
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

}  // namespace lightcook::formats
