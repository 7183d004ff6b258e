// GPU textures in KTX2 and DDS files. They are written and read by rows of blocks, so that a texture may be larger than memory.
// Blocks are plain bytes here: compress/ encodes them, verify/ decodes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/pixel_format.h"

namespace lightcook::formats {

enum class Container { Ktx2, Dds };

/// Returns the container that a file is by its first bytes, whatever its name. Empty: neither.
std::optional<Container> containerOfContent(const std::filesystem::path& file);
/// Returns the error of a texture in place of an image, and the way from one to the other. Empty: the file is no texture.
/// expected  "OpenEXR or Radiance HDR"
std::optional<Error> textureForImage(const std::filesystem::path& file, const std::string& expected);

/// A 2-D texture, an array of them or a cubemap, with mips. Mip m has max(1, width >> m) by max(1, height >> m) texels.
struct TextureShape {
    PixelFormat format = PixelFormat::Rgba16f;
    int width = 0, height = 0;  ///< of mip 0 [texels]
    int mipCount = 1;
    int layerCount = 1;
    bool isArray = false;  ///< an array of one layer differs from a plain texture
    int faceCount = 1;     ///< 1, or 6 for a cubemap: +X -X +Y -Y +Z -Z

    int mipWidth(int mip) const;
    int mipHeight(int mip) const;
    std::size_t imageBytes(int mip) const;  ///< one layer and face of one mip
    std::size_t gpuBytes() const;           ///< everything, as it lies in GPU memory
};

struct TextureFileOptions {
    Container container = Container::Ktx2;
    bool zstd = false;                            ///< KTX2 only: Zstandard supercompression, per mip level
    int zstdLevel = 19;                           ///< blocks repeat in short matches, which levels below 17 do not search for
    std::map<std::string, std::string> metadata;  ///< KTX2 key-values (text); DDS has no room for them and drops them
};

/// Identifies one image of a texture.
struct SubImage {
    int mip = 0, layer = 0, face = 0;
};

/// Writes a texture by rows of blocks, in any order. Several threads may write different rows at once.
/// The file gets its name at commit() (written beside it, synced, renamed); without commit() it is removed.
class TextureWriter {
public:
    static Result<TextureWriter> create(const std::filesystem::path& file, const TextureShape& shape, const TextureFileOptions& options);
    TextureWriter(TextureWriter&&) noexcept;
    TextureWriter& operator=(TextureWriter&&) noexcept;
    ~TextureWriter();

    /// bytes  whole rows of blocks: rowCount * bytesPerBlockRow(format, mipWidth)
    Result<void> writeBlockRows(SubImage image, int firstBlockRow, std::span<const std::byte> bytes);
    Result<void> commit();

private:
    struct State;
    explicit TextureWriter(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// Reads a texture by rows of blocks. Safe from several threads. Every header field is checked before it is used; the error for a truncated
/// or inconsistent file names the field, the value found and the value expected.
/// Memory: rows are read directly into `out`. A level under Zstandard is decompressed whole at its first use and kept until the reader is
/// destroyed; while a level is decompressed, it takes up to twice its size.
class TextureReader {
public:
    static Result<TextureReader> open(const std::filesystem::path& file);
    TextureReader(TextureReader&&) noexcept;
    TextureReader& operator=(TextureReader&&) noexcept;
    ~TextureReader();

    const TextureShape& shape() const;
    Container container() const;
    bool isZstd() const;
    const std::map<std::string, std::string>& metadata() const;
    std::size_t fileBytes() const;
    /// Returns true if the data format descriptor names the transfer function that TextureWriter gives the format: sRGB of rgba8-srgb, else
    /// linear. DDS has none; true.
    bool hasOwnTransfer() const;
    /// Returns true for BC1 whose fourth colour of three is transparent: DXGI's BC1 and Vulkan's BC1_RGBA. In Vulkan's BC1_RGB it is opaque
    /// black.
    bool hasBc1Alpha() const;

    /// out  whole rows of blocks, as writeBlockRows takes them
    Result<void> readBlockRows(SubImage image, int firstBlockRow, std::span<std::byte> out) const;
    Result<std::vector<std::byte>> readImage(SubImage image) const;

private:
    struct State;
    explicit TextureReader(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace lightcook::formats
