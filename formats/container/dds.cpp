#include "formats/container/dds.h"

#include <fmt/format.h>

#include <array>

namespace lightcook::formats {
namespace {

constexpr std::uint32_t fourCc(const char (&text)[5]) {
    std::uint32_t value = 0;
    for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(text[i]);
    return value;
}

constexpr std::uint32_t kMagic = fourCc("DDS "), kDx10 = fourCc("DX10"), kDxt1 = fourCc("DXT1"), kDxt5 = fourCc("DXT5");
constexpr std::size_t kLegacyBytes = 4 + 124, kDx10Bytes = kLegacyBytes + 20;

// DDS_HEADER.dwFlags, dwCaps, dwCaps2; D3D10_RESOURCE_DIMENSION; misc flags.
constexpr std::uint32_t kFlagsAlways = 0x1 | 0x2 | 0x4 | 0x1000, kFlagPitch = 0x8, kFlagMipCount = 0x20000, kFlagLinearSize = 0x80000;
constexpr std::uint32_t kCapsTexture = 0x1000, kCapsComplex = 0x8, kCapsMipMap = 0x400000;
constexpr std::uint32_t kCaps2Cube = 0x200, kCaps2AllFaces = 0xfc00, kCaps2Volume = 0x200000;
constexpr std::uint32_t kPixelFormatFourCc = 0x4, kTexture2d = 3, kMiscCube = 4;

// Offsets of the header's fields from the start of the file.
constexpr std::size_t kSizeAt = 4, kFlagsAt = 8, kHeightAt = 12, kWidthAt = 16, kMipCountAt = 28, kPixelFormatSizeAt = 76,
                      kPixelFormatFlagsAt = 80, kFourCcAt = 84, kCaps2At = 112;
constexpr std::size_t kDxgiAt = 128, kDimensionAt = 132, kMiscAt = 136, kArraySizeAt = 140;

std::uint32_t legacyFourCc(const TextureShape& shape) {
    if (shape.isArray) return 0;
    if (shape.format == PixelFormat::Bc1) return kDxt1;
    if (shape.format == PixelFormat::Bc3) return kDxt5;
    return 0;
}

tl::unexpected<Error> refuse(const FileBytes& file, ErrorCode code, std::string_view field, std::uint64_t found,
                             std::string_view expected) {
    return failure(code, fmt::format("{}, DDS header, {}", file.path().string(), field),
                   fmt::format("found {}, expected {}", found, expected));
}

/// Format, layers and the cube flag, from whichever kind of header there is.
Result<void> readKind(const FileBytes& file, std::span<const std::byte> header, std::uint32_t fourCcFound, TextureShape& shape) {
    if (fourCcFound == kDxt1 || fourCcFound == kDxt5) {
        shape.format = fourCcFound == kDxt1 ? PixelFormat::Bc1 : PixelFormat::Bc3;
        shape.faceCount = (loadU32(header, kCaps2At) & kCaps2Cube) != 0 ? 6 : 1;
        return {};
    }
    const std::uint32_t dxgi = loadU32(header, kDxgiAt);
    const PixelFormatInfo* found = nullptr;
    for (const PixelFormatInfo& candidate : allPixelFormats())
        if (candidate.dxgiFormat == dxgi && dxgi != 0) found = &candidate;
    if (found == nullptr) return refuse(file, ErrorCode::FormatUnsupported, "dxgiFormat", dxgi, "a format that lightcook writes");
    shape.format = found->format;
    const std::uint32_t dimension = loadU32(header, kDimensionAt), misc = loadU32(header, kMiscAt), layers = loadU32(header, kArraySizeAt);
    if (dimension != kTexture2d) return refuse(file, ErrorCode::FormatUnsupported, "resourceDimension", dimension, "3 (2-D textures)");
    if ((misc & ~kMiscCube) != 0) return refuse(file, ErrorCode::FormatUnsupported, "miscFlag", misc, "0, or 4 (a cubemap)");
    if (layers < 1 || layers > kMaxTextureLayers)
        return refuse(file, ErrorCode::FileUnreadable, "arraySize", layers, fmt::format("1 to {}", kMaxTextureLayers));
    shape.faceCount = misc == kMiscCube ? 6 : 1;
    shape.layerCount = static_cast<int>(layers);
    shape.isArray = layers > 1;
    return {};
}

/// The fields both kinds of header share; the mip count and extents are believed only inside our limits.
Result<std::uint32_t> readCommon(const FileBytes& file, std::span<const std::byte> header, TextureShape& shape) {
    const auto bad = [&](std::string_view field, std::uint64_t found, std::string_view expected) {
        return refuse(file, ErrorCode::FileUnreadable, field, found, expected);
    };
    const std::uint32_t size = loadU32(header, kSizeAt), formatSize = loadU32(header, kPixelFormatSizeAt);
    const std::uint32_t formatFlags = loadU32(header, kPixelFormatFlagsAt), fourCcFound = loadU32(header, kFourCcAt);
    const std::uint32_t width = loadU32(header, kWidthAt), height = loadU32(header, kHeightAt);
    const std::uint32_t caps2 = loadU32(header, kCaps2At);
    if (size != 124) return bad("dwSize", size, "124");
    if (formatSize != 32) return bad("ddspf.dwSize", formatSize, "32");
    if ((formatFlags & kPixelFormatFourCc) == 0 || (fourCcFound != kDx10 && fourCcFound != kDxt1 && fourCcFound != kDxt5))
        return refuse(file, ErrorCode::FormatUnsupported, "ddspf.dwFourCC", fourCcFound, "DX10, DXT1 or DXT5");
    if (width < 1 || width > kMaxTextureExtent) return bad("dwWidth", width, fmt::format("1 to {}", kMaxTextureExtent));
    if (height < 1 || height > kMaxTextureExtent) return bad("dwHeight", height, fmt::format("1 to {}", kMaxTextureExtent));
    if ((caps2 & kCaps2Volume) != 0) return refuse(file, ErrorCode::FormatUnsupported, "dwCaps2", caps2, "no volume texture");
    if ((caps2 & kCaps2Cube) != 0 && (caps2 & kCaps2AllFaces) != kCaps2AllFaces)
        return refuse(file, ErrorCode::FormatUnsupported, "dwCaps2", caps2, "all six faces of a cubemap");
    const bool hasMips = (loadU32(header, kFlagsAt) & kFlagMipCount) != 0;
    const std::uint32_t mips = hasMips ? loadU32(header, kMipCountAt) : 1;
    if (mips < 1 || mips > 17) return bad("dwMipMapCount", mips, "1 to 17");
    shape.width = static_cast<int>(width);
    shape.height = static_cast<int>(height);
    shape.mipCount = static_cast<int>(mips);
    return fourCcFound;
}

TextureFileLayout layOut(const TextureShape& shape, std::uint64_t headerBytes) {
    TextureFileLayout layout{.container = Container::Dds, .shape = shape, .zstd = false, .metadata = {}, .levels = {}};
    const std::uint64_t bytes =
        mipChainBytes(shape) * static_cast<std::uint64_t>(shape.layerCount) * static_cast<std::uint64_t>(shape.faceCount);
    layout.levels.push_back({headerBytes, bytes, bytes});
    return layout;
}

}  // namespace

Result<TextureFileLayout> layOutDds(const TextureShape& shape, const TextureFileOptions& options, const std::string& subject) {
    if (Result<void> checked = checkShape(shape, subject); !checked) return tl::make_unexpected(checked.error());
    if (info(shape.format).dxgiFormat == 0)
        return failure(ErrorCode::FormatUnsupported, subject,
                       fmt::format("found format {}, expected one that DDS has (ASTC and rgb16f need KTX2)", info(shape.format).name));
    if (options.zstd) return failure(ErrorCode::InvalidRequest, subject, "found Zstandard asked for, expected none with DDS (KTX2 has it)");
    return layOut(shape, legacyFourCc(shape) != 0 ? kLegacyBytes : kDx10Bytes);
}

std::vector<std::byte> ddsPrefix(const TextureShape& shape) {
    const PixelFormatInfo& format = info(shape.format);
    const bool isBlocks = format.blockWidth > 1, isCube = shape.faceCount == 6, hasMips = shape.mipCount > 1;
    const std::uint32_t legacy = legacyFourCc(shape);
    // dwPitchOrLinearSize is 32 bits and only a hint: readers compute it from the format.
    const std::size_t pitch = isBlocks ? shape.imageBytes(0) : bytesPerBlockRow(shape.format, shape.width);
    std::vector<std::byte> bytes;
    const auto put = [&](std::uint32_t value) { appendU32(bytes, value); };
    put(kMagic);
    put(124);
    put(kFlagsAlways | (isBlocks ? kFlagLinearSize : kFlagPitch) | (hasMips ? kFlagMipCount : 0));
    put(static_cast<std::uint32_t>(shape.height));
    put(static_cast<std::uint32_t>(shape.width));
    put(static_cast<std::uint32_t>(pitch));
    put(0);  // depth
    put(static_cast<std::uint32_t>(shape.mipCount));
    for (int reserved = 0; reserved < 11; ++reserved) put(0);
    put(32);
    put(kPixelFormatFourCc);
    put(legacy != 0 ? legacy : kDx10);
    for (int masks = 0; masks < 5; ++masks) put(0);
    put(kCapsTexture | (hasMips ? kCapsMipMap : 0) | (hasMips || isCube || shape.isArray ? kCapsComplex : 0));
    put(isCube ? kCaps2Cube | kCaps2AllFaces : 0);
    for (int rest = 0; rest < 3; ++rest) put(0);
    if (legacy == 0) {
        put(format.dxgiFormat);
        put(kTexture2d);
        put(isCube ? kMiscCube : 0);
        put(static_cast<std::uint32_t>(shape.layerCount));
        put(0);
    }
    return bytes;
}

Result<TextureFileLayout> readDds(const FileBytes& file) {
    std::array<std::byte, kDx10Bytes> header{};
    const auto need = [&](std::size_t bytes) -> Result<void> {
        if (file.size() < bytes)
            return failure(ErrorCode::FileUnreadable, file.path().string(),
                           fmt::format("found {} bytes, expected a DDS header of {}", file.size(), bytes));
        return file.readAt(0, std::span(header).first(bytes));
    };
    if (Result<void> read = need(kLegacyBytes); !read) return tl::make_unexpected(read.error());
    TextureShape shape;
    const Result<std::uint32_t> fourCcFound = readCommon(file, header, shape);
    if (!fourCcFound) return tl::make_unexpected(fourCcFound.error());
    const std::size_t headerBytes = *fourCcFound == kDx10 ? kDx10Bytes : kLegacyBytes;
    if (Result<void> read = need(headerBytes); !read) return tl::make_unexpected(read.error());
    if (Result<void> read = readKind(file, header, *fourCcFound, shape); !read) return tl::make_unexpected(read.error());
    if (Result<void> checked = checkShape(shape, file.path().string()); !checked) {
        Error error = checked.error();
        error.code = ErrorCode::FileUnreadable;
        return tl::make_unexpected(error);
    }
    TextureFileLayout layout = layOut(shape, headerBytes);
    if (file.size() < layout.fileBytes())
        return failure(ErrorCode::FileUnreadable, file.path().string(),
                       fmt::format("found {} bytes, expected {} for what its header says", file.size(), layout.fileBytes()));
    return layout;
}

}  // namespace lightcook::formats
