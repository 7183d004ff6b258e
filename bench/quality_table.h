// The committed table of encoder quality, tests/quality/encoders.csv: figures of every block format and effort on the pictures that the
// repository contains or makes. A change to an encoder changes the table.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/figures.h"
#include "bench/pictures.h"
#include "formats/error.h"

namespace lightcook::bench {

/// Side of the pictures of the table [texels]: enough for every kind of block, few enough for the slowest efforts.
inline constexpr int kTablePictureSize = 64;

struct QualityRow {
    std::string format, picture;
    int effort = 0;
    Figures figures;
};

/// Returns the formats of the table: all block formats with an effort.
std::vector<formats::PixelFormat> tableFormats();

/// Encodes and decodes a picture.
Figures encodeAndMeasure(formats::PixelFormat format, int effort, const Picture& picture);

/// Returns the rows of one format and effort, one for each picture.
std::vector<QualityRow> qualityRows(formats::PixelFormat format, int effort, const std::vector<Picture>& pictures);

/// Returns the mean of the decibels of rows.
double meanDb(const std::vector<QualityRow>& rows);

std::string csvOf(const std::vector<QualityRow>& rows);
/// Reads a table that csvOf() wrote. The error for a bad line names its number.
formats::Result<std::vector<QualityRow>> readQualityTable(const std::filesystem::path& file);

}  // namespace lightcook::bench
