// A light map of any size: copies of another, each with its light times a factor of its own.
#pragma once

#include <filesystem>

namespace lightcook::bench {

struct TiledMap {
    int columns = 1, rows = 1;  ///< of copies
    int period = 1;             ///< of the copies that are there, in a row and in a column; the rest of the map is empty
    bool isTiled = true;        ///< tiles of 64 x 64 texels, or else scan lines
};

/// Writes an OpenEXR file, a strip of rows at a time. Channels of light (sh...) are rounded to halves, so that the file is no larger than
/// one of halves; the others are copied. The same arguments give the same bytes.
/// Throws std::runtime_error if a file cannot be read or written.
void writeTiledMap(const std::filesystem::path& source, const std::filesystem::path& file, const TiledMap& map);

}  // namespace lightcook::bench
