#include "formats/container/dds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

#include "formats/container/foreign_formats.h"

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
constexpr std::uint32_t kFlagsAlways = 0x1 | 0x2 | 0x4 | 0x1000, kFlagPitch = 0x8, kFlagMipCount = 0x20000, kFlagLinearSize = 0x80000,
                        kFlagDepth = 0x800000;
constexpr std::uint32_t kCapsTexture = 0x1000, kCapsComplex = 0x8, kCapsMipMap = 0x400000;
constexpr std::uint32_t kCaps2Cube = 0x200, kCaps2AllFaces = 0xfc00, kCaps2Volume = 0x200000;
constexpr std::uint32_t kPixelFormatFourCc = 0x4, kTexture2d = 3, kTexture3d = 4, kMiscCube = 4;

// Offsets of the header's fields from the start of the file.
constexpr std::size_t kSizeAt = 4, kFlagsAt = 8, kHeightAt = 12, kWidthAt = 16, kDepthAt = 24, kMipCountAt = 28, kPixelFormatSizeAt = 76,
                      kPixelFormatFlagsAt = 80, kFourCcAt = 84, kBitCountAt = 88, kCaps2At = 112;
constexpr std::size_t kDxgiAt = 128, kDimensionAt = 132, kMiscAt = 136, kArraySizeAt = 140;

std::uint32_t legacyFourCc(const TextureShape& shape) {
    if (shape.isArray) return 0;
    if (shape.format == PixelFormat::Bc1) return kDxt1;
    if (shape.format == PixelFormat::Bc3) return kDxt5;
    return 0;
}

template <class Found>
tl::unexpected<Error> refuse(const FileBytes& file, ErrorCode code, std::string_view field, const Found& found, std::string_view expected) {
    return failure(code, Subject(file.path()).at("DDS header, " + std::string(field)),
                   fmt::format("found {}, expected {}", found, expected));
}

/// A header whose format, extents and dimension can be read.
struct DdsHeader {
    TextureShape shape;        ///< of one layer, face and mip
    std::size_t bytes = 0;     ///< of the header
    std::uint32_t mips = 1;    ///< dwMipMapCount; 1 for 0
    std::uint32_t layers = 1;  ///< arraySize
    bool hasMipFlag = false;   ///< DDSD_MIPMAPCOUNT
    bool isCube = false;       ///< the six faces of dwCaps2, or miscFlag
};

/// Reads the format that a header of before Direct3D 10 names.
Result<PixelFormat> legacyFormat(const FileBytes& file, std::span<const std::byte> header) {
    if ((loadU32(header, kPixelFormatFlagsAt) & kPixelFormatFourCc) == 0)
        return refuse(file, ErrorCode::FormatUnsupported, "ddspf",
                      fmt::format("uncompressed texels of {} bits with masks of channels", loadU32(header, kBitCountAt)),
                      "a format of Direct3D 10. Write it as one: texconv -dx10 -f R8G8B8A8_UNORM");
    const LegacyDdsFormat legacy = legacyDdsFormat(loadU32(header, kFourCcAt));
    if (!legacy.format)
        return refuse(file, ErrorCode::FormatUnsupported, "ddspf.dwFourCC", legacy.name,
                      fmt::format("DX10, DXT1, DXT5, ATI1, BC4U, BC4S, BC5U, BC5S, A16B16G16R16 or A16B16G16R16F. {}", legacy.remedy));
    return *legacy.format;
}

/// Reads the extension of Direct3D 10.
Result<void> readDx10(const FileBytes& file, std::span<const std::byte> header, DdsHeader& read) {
    const std::uint32_t dxgi = loadU32(header, kDxgiAt);
    const PixelFormatInfo* found = nullptr;
    for (const PixelFormatInfo& candidate : allPixelFormats())
        if (candidate.dxgiFormat == dxgi && dxgi != 0) found = &candidate;
    if (found == nullptr)
        return refuse(
            file, ErrorCode::FormatUnsupported, "dxgiFormat", dxgiFormatName(dxgi),
            "a format that `lightcook encode` writes. Write it as one, for example with texconv -f R8G8B8A8_UNORM, or BC6H_UF16 for "
            "light");
    read.shape.format = found->format;
    const std::uint32_t dimension = loadU32(header, kDimensionAt), misc = loadU32(header, kMiscAt);
    if (dimension != kTexture2d)
        return refuse(file, ErrorCode::FormatUnsupported, "resourceDimension",
                      dimension == kTexture3d ? std::string("a volume texture (4)") : fmt::format("{}", dimension), "3 (2-D textures)");
    if ((misc & ~kMiscCube) != 0) return refuse(file, ErrorCode::FormatUnsupported, "miscFlag", misc, "0, or 4 (a cubemap)");
    read.layers = loadU32(header, kArraySizeAt);
    if (read.layers < 1 || read.layers > kMaxTextureLayers)
        return refuse(file, ErrorCode::FileUnreadable, "arraySize", read.layers, fmt::format("1 to {}", kMaxTextureLayers));
    read.isCube |= misc == kMiscCube;
    return {};
}

/// Reads the fields that both kinds of header have; the mip count and extents are believed only inside our limits.
/// Microsoft's guide tells readers not to rely on DDSD_MIPMAPCOUNT: dwMipMapCount counts without it.
Result<DdsHeader> readCommon(const FileBytes& file, std::span<const std::byte> header) {
    const auto bad = [&](std::string_view field, std::uint64_t found, std::string_view expected) {
        return refuse(file, ErrorCode::FileUnreadable, field, found, expected);
    };
    const std::uint32_t size = loadU32(header, kSizeAt), formatSize = loadU32(header, kPixelFormatSizeAt);
    const std::uint32_t width = loadU32(header, kWidthAt), height = loadU32(header, kHeightAt);
    const std::uint32_t flags = loadU32(header, kFlagsAt), caps2 = loadU32(header, kCaps2At);
    if (size != 124) return bad("dwSize", size, "124");
    if (formatSize != 32) return bad("ddspf.dwSize", formatSize, "32");
    if (width < 1 || width > kMaxTextureExtent) return bad("dwWidth", width, fmt::format("1 to {}", kMaxTextureExtent));
    if (height < 1 || height > kMaxTextureExtent) return bad("dwHeight", height, fmt::format("1 to {}", kMaxTextureExtent));
    if ((caps2 & kCaps2Volume) != 0 || ((flags & kFlagDepth) != 0 && loadU32(header, kDepthAt) > 1))
        return refuse(file, ErrorCode::FormatUnsupported, "dwCaps2", "a volume texture", "a 2-D texture, an array of them or a cubemap");
    if ((caps2 & kCaps2Cube) != 0 && (caps2 & kCaps2AllFaces) != kCaps2AllFaces)
        return refuse(file, ErrorCode::FormatUnsupported, "dwCaps2",
                      fmt::format("{} of the six faces of a cubemap", std::popcount(caps2 & kCaps2AllFaces)), "all six");
    DdsHeader read;
    read.shape.width = static_cast<int>(width);
    read.shape.height = static_cast<int>(height);
    read.hasMipFlag = (flags & kFlagMipCount) != 0;
    read.mips = std::max(loadU32(header, kMipCountAt), 1u);
    if (read.mips > 17) return bad("dwMipMapCount", read.mips, "1 to 17");
    read.isCube = (caps2 & kCaps2Cube) != 0;
    const bool isDx10 = (loadU32(header, kPixelFormatFlagsAt) & kPixelFormatFourCc) != 0 && loadU32(header, kFourCcAt) == kDx10;
    read.bytes = isDx10 ? kDx10Bytes : kLegacyBytes;
    if (isDx10) return read;
    const Result<PixelFormat> format = legacyFormat(file, header);
    if (!format) return tl::make_unexpected(format.error());
    read.shape.format = *format;
    return read;
}

TextureFileLayout layOut(const TextureShape& shape, std::uint64_t headerBytes) {
    TextureFileLayout layout{.container = Container::Dds, .shape = shape, .zstd = false, .metadata = {}, .levels = {}};
    const std::uint64_t bytes =
        mipChainBytes(shape) * static_cast<std::uint64_t>(shape.layerCount) * static_cast<std::uint64_t>(shape.faceCount);
    layout.levels.push_back({headerBytes, bytes, bytes});
    return layout;
}

}  // namespace

Result<TextureFileLayout> layOutDds(const TextureShape& shape, const TextureFileOptions& options, const Subject& subject) {
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

namespace {

/// Returns the shapes that a header may mean, the most trusted first: the one that it states; an array of six images in place of one
/// cubemap; and one without mips, where only dwMipMapCount names them.
std::vector<TextureShape> readings(const DdsHeader& header) {
    std::vector<TextureShape> shapes;
    for (const std::uint32_t mips : {header.mips, 1u}) {
        if (mips != header.mips && header.hasMipFlag) break;
        TextureShape shape = header.shape;
        shape.mipCount = static_cast<int>(mips);
        shape.faceCount = header.isCube ? 6 : 1;
        for (const std::uint32_t layers : {header.layers, header.layers / 6}) {
            if (layers != header.layers && (!header.isCube || header.layers % 6 != 0)) break;
            shape.layerCount = static_cast<int>(layers);
            shape.isArray = layers > 1;
            shapes.push_back(shape);
        }
        if (header.mips == 1) break;
    }
    return shapes;
}

/// Returns the error of a file that is longer or shorter than its header says.
tl::unexpected<Error> wrongSize(const FileBytes& file, const TextureFileLayout& layout) {
    const TextureShape& shape = layout.shape;
    const auto counted = [](int count, const char* what) { return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s"); };
    std::string text = fmt::format("found {} bytes, expected {} for what its header says: {} x {} texels of {}, {}, {}, {}", file.size(),
                                   layout.fileBytes(), shape.width, shape.height, info(shape.format).name, counted(shape.mipCount, "mip"),
                                   counted(shape.faceCount, "face"), counted(shape.layerCount, "layer"));
    if (file.size() < layout.fileBytes()) return failure(ErrorCode::FileUnreadable, file.path(), std::move(text));
    for (TextureFileLayout other = layout; other.shape.mipCount < 17;) {
        ++other.shape.mipCount;
        if (!checkShape(other.shape, "")) break;
        if (layOut(other.shape, layout.levels.front().offset).fileBytes() == file.size())
            return failure(ErrorCode::FileUnreadable, file.path(),
                           fmt::format("{}. {} mips would fill it: correct dwMipMapCount (the 4 bytes at {})", text, other.shape.mipCount,
                                       kMipCountAt));
    }
    return failure(ErrorCode::FileUnreadable, file.path(),
                   fmt::format("{}. If the rest is no part of it, cut it off: truncate -s {} FILE", text, layout.fileBytes()));
}

}  // namespace

Result<TextureFileLayout> readDds(const FileBytes& file) {
    std::array<std::byte, kDx10Bytes> bytes{};
    const auto need = [&](std::size_t count) -> Result<void> {
        if (file.size() < count)
            return failure(ErrorCode::FileUnreadable, file.path(),
                           fmt::format("found {} bytes, expected a DDS header of {}", file.size(), count));
        return file.readAt(0, std::span(bytes).first(count));
    };
    if (Result<void> read = need(kLegacyBytes); !read) return tl::make_unexpected(read.error());
    Result<DdsHeader> header = readCommon(file, bytes);
    if (!header) return tl::make_unexpected(header.error());
    if (Result<void> read = need(header->bytes); !read) return tl::make_unexpected(read.error());
    if (header->bytes == kDx10Bytes)
        if (Result<void> read = readDx10(file, bytes, *header); !read) return tl::make_unexpected(read.error());
    const std::vector<TextureShape> shapes = readings(*header);
    if (Result<void> checked = checkShape(shapes.front(), file.path()); !checked) {
        Error error = checked.error();
        error.code = ErrorCode::FileUnreadable;
        return tl::make_unexpected(error);
    }
    for (const TextureShape& shape : shapes) {
        TextureFileLayout layout = layOut(shape, header->bytes);
        layout.hasBc1Alpha = shape.format == PixelFormat::Bc1;
        if (file.size() == layout.fileBytes()) return layout;
    }
    return wrongSize(file, layOut(shapes.front(), header->bytes));
}

}  // namespace lightcook::formats
