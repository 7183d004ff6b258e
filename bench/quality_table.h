// The committed table of encoder quality, tests/quality/encoders.csv: figures of every block format and effort on the pictures that the
// repository carries or makes, so that a change to an encoder shows what it does to them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/figures.h"
#include "bench/pictures.h"
#include "formats/error.h"

namespace lightcook::bench {

/// Texels of a side of the table's pictures: enough for every kind of block, few enough for the slowest efforts.
inline constexpr int kTablePictureSize = 64;

struct QualityRow {
    std::string format, picture;
    int effort = 0;
    Figures figures;
};

/// The formats of the table, those with an effort: all made of blocks.
std::vector<formats::PixelFormat> tableFormats();

/// Encodes and decodes a picture.
Figures encodeAndMeasure(formats::PixelFormat format, int effort, const Picture& picture);

/// Rows of one format and effort, a picture each.
std::vector<QualityRow> qualityRows(formats::PixelFormat format, int effort, const std::vector<Picture>& pictures);

/// Mean of the decibels of rows.
double meanDb(const std::vector<QualityRow>& rows);

std::string csvOf(const std::vector<QualityRow>& rows);
/// Any line that is not as csvOf writes it is refused with its number.
formats::Result<std::vector<QualityRow>> readQualityTable(const std::filesystem::path& file);

}  // namespace lightcook::bench
