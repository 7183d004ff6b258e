// OpenEXR files, read and written by channel name and by rows. Exceptions of OpenEXR become errors here.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/plain_image.h"

namespace lightcook::formats {

/// Largest width and height that is accepted [texels]; a larger one means a broken or hostile header.
inline constexpr int kLargestExtent = 65536;

struct ExrInfo {
    int width = 0, height = 0;  ///< of both windows [texels]; their corner is (0, 0) here wherever the file puts it
    bool isTiled = false;
    int tileHeight = 0;                        ///< [texels]; 0 for scan-line files
    std::vector<std::string> channels;         ///< sorted as the file has them
    std::vector<std::string> integerChannels;  ///< those of them that hold 32-bit integers (UINT), which are no light
    /// Primaries and white point as the file states them, which may be any floats. Empty: none are stated, and the format means Rec.709.
    std::optional<StatedChromaticities> chromaticities = {};
    std::optional<ExrEnvironment> environment = {};  ///< attribute `envmap`

    bool has(const std::string& channel) const;
};

/// Returns true if the first bytes of a file are those of OpenEXR; false if it cannot be read.
bool isExrFile(const std::filesystem::path& file);

/// Destination of one channel: texel (x, y) of the rows read goes to texels + x * texelStride + y * rowStride [floats].
struct ExrPlane {
    std::string channel;
    float* texels = nullptr;
    std::ptrdiff_t texelStride = 1, rowStride = 0;
};

/// Reads rows of chosen channels, half or float, as float. Keeps a file open for each thread that reads at the same time.
class ExrReader {
public:
    /// Opens a flat EXR file. Refuses by name deep, multi-part, subsampled, absurdly large and visibly truncated files. The error of a
    /// header that claims more than this library reads, or more than the memory holds, is ErrorCode::WrongShape, and so is that of a data
    /// window that is not the display window.
    static Result<ExrReader> open(const std::filesystem::path& file);
    ExrReader(ExrReader&&) noexcept;
    ExrReader& operator=(ExrReader&&) noexcept;
    ~ExrReader();

    const ExrInfo& info() const;
    /// Reads rows [firstRow, firstRow + rowCount) of channels that exist. Refuses channels of integers. Safe from several threads.
    Result<void> readRows(int firstRow, int rowCount, std::span<const ExrPlane> planes) const;
    /// Returns a digest of the bytes that the file has for rows [firstRow, firstRow + rowCount), as they are compressed. Rows of equal
    /// digests have equal texels in all channels, also those of two files. Empty: nobody knows. Safe from several threads.
    Result<std::string> storedDigest(int firstRow, int rowCount) const;

private:
    struct State;
    explicit ExrReader(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

enum class ExrLayout { ScanLines, Tiles64 };

/// Writes float channels, ZIP, from rows that come in order. The file appears whole at commit().
class ExrWriter {
public:
    /// channels  in the order in which a texel holds them
    static Result<ExrWriter> create(const std::filesystem::path& file, int width, int height, std::vector<std::string> channels,
                                    ExrLayout layout);
    ExrWriter(ExrWriter&&) noexcept;
    ExrWriter& operator=(ExrWriter&&) noexcept;
    ~ExrWriter();

    /// texels  row by row, channels interleaved; row y starts at texels + y * rowStride [floats]. Tiles64 wants 64 rows at a time, and the
    /// rest at the end.
    Result<void> append(const float* texels, std::ptrdiff_t rowStride, int rowCount);
    Result<void> commit();

private:
    struct State;
    explicit ExrWriter(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace lightcook::formats
