// An OpenEXR file that is open, here or behind a wall.
#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "formats/image/exr_file.h"

namespace lightcook::formats {

inline constexpr std::size_t kMostExrChannels = 1024;

inline int ceilDivide(int a, int b) {
    return (a + b - 1) / b;
}

/// One thread at a time reads from it.
class ExrSource {
public:
    virtual ~ExrSource() = default;
    virtual const ExrInfo& info() const = 0;
    /// Returns how many rows are decoded together: those of a tile, or of a chunk of scan lines.
    virtual int chunkRows() const = 0;
    /// See ExrReader::readRows().
    virtual Result<void> readRows(int firstRow, int rowCount, std::span<const ExrPlane> planes) = 0;
    /// See ExrReader::storedDigest().
    virtual Result<std::string> storedDigest(int firstRow, int rowCount) = 0;
};

/// Checks magic number and version of a file, without OpenEXR.
Result<void> checkExrVersion(int descriptor, const std::filesystem::path& file);

/// Opens a file in this process. The descriptor stays open as long as the source.
Result<std::unique_ptr<ExrSource>> openExrHere(int descriptor, const std::filesystem::path& file);
/// Opens a file in a child process.
Result<std::unique_ptr<ExrSource>> openExrInChild(int descriptor, const std::filesystem::path& file);

}  // namespace lightcook::formats
