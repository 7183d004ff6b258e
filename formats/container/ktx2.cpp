#include "formats/container/ktx2.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include "formats/container/foreign_formats.h"

namespace lightcook::formats {
namespace {

constexpr std::array<unsigned char, 12> kIdentifier = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};
constexpr std::size_t kHeaderBytes = 80, kLevelIndexBytes = 24;
constexpr std::uint32_t kSupercompressionNone = 0, kSupercompressionBasisLz = 1, kSupercompressionZstd = 2, kSupercompressionZlib = 3;
constexpr std::uint32_t kBc1Rgb = 131, kBc1Rgba = 133;  ///< VkFormat
constexpr std::uint32_t kMaxKeyValueBytes = 64u << 20;  // far beyond any range constants; a corrupt length must not ask for gigabytes
// A block of Zstandard has at least a header of 3 bytes and one byte that repeats, and at most 128 KiB of content.
constexpr std::uint64_t kLeastZstdBlock = 4, kLargestZstdBlock = 128u << 10;
constexpr std::string_view kWriterKey = "KTXwriter", kOrientationKey = "KTXorientation", kSwizzleKey = "KTXswizzle";

// Offsets of the header's fields from the start of the file.
constexpr std::size_t kVkFormatAt = 12, kTypeSizeAt = 16, kWidthAt = 20, kHeightAt = 24, kDepthAt = 28, kLayersAt = 32, kFacesAt = 36,
                      kLevelsAt = 40, kSupercompressionAt = 44, kDfdOffsetAt = 48, kDfdLengthAt = 52, kKvdOffsetAt = 56, kKvdLengthAt = 60,
                      kSgdLengthAt = 72;

// Khronos Data Format 1.3: colour models, channels and qualifiers of a sample.
enum ColorModel : std::uint8_t {
    kRgbsda = 1,
    kBc1a = 128,
    kBc3 = 130,
    kBc4 = 131,
    kBc5 = 132,
    kBc6h = 133,
    kBc7 = 134,
    kAstc = 162,
    kEtc1s = 163,
    kUastc = 166
};
constexpr std::uint8_t kRed = 0, kGreen = 1, kBlue = 2, kAlpha = 15, kWholeBlock = 0;
constexpr std::uint8_t kLinear = 0x10, kExponent = 0x20, kSigned = 0x40, kFloat = 0x80;
constexpr std::uint8_t kPrimariesBt709 = 1, kTransferLinear = 1, kTransferSrgb = 2;

struct Sample {
    int bitOffset, bitCount;
    std::uint8_t channelAndQualifiers;
    std::uint32_t lower, upper;
};
struct Description {
    ColorModel model;
    std::uint32_t typeSize;  ///< bytes of the unit that a big-endian machine would have to swap
    std::vector<Sample> samples;
};

constexpr std::uint32_t kOne = std::bit_cast<std::uint32_t>(1.0f), kMinusOne = std::bit_cast<std::uint32_t>(-1.0f);

/// One sample that stands for a piece of a block: the range is that of 32 bits, whatever the block holds.
Sample blockSample(int bitOffset, int bitCount, std::uint8_t channel) {
    return {bitOffset, bitCount, channel, 0, 0xffffffffu};
}
/// The same for values that have a sign.
Sample signedBlockSample(int bitOffset, int bitCount, std::uint8_t channel) {
    return {bitOffset, bitCount, static_cast<std::uint8_t>(channel | kSigned), 0x80000000u, 0x7fffffffu};
}
Sample unsignedFloat(int bitOffset, int bitCount, std::uint8_t channel) {
    return {bitOffset, bitCount, static_cast<std::uint8_t>(channel | kFloat), 0, kOne};
}
Sample signedFloat(int bitOffset, int bitCount, std::uint8_t channel) {
    return {bitOffset, bitCount, static_cast<std::uint8_t>(channel | kFloat | kSigned), kMinusOne, kOne};
}

constexpr std::array<std::uint8_t, 4> kRgba = {kRed, kGreen, kBlue, kAlpha};

Description unorm(int channelCount, int bits, bool isSrgb) {
    Description description{kRgbsda, static_cast<std::uint32_t>(bits / 8), {}};
    for (int c = 0; c < channelCount; ++c) {
        // Alpha stays linear where the transfer function of the colours is not, and has to say so.
        const std::uint8_t qualifier = isSrgb && c == 3 ? kLinear : 0;
        description.samples.push_back(
            {c * bits, bits, static_cast<std::uint8_t>(kRgba[static_cast<std::size_t>(c)] | qualifier), 0, (1u << bits) - 1});
    }
    return description;
}

Description halfs(int channelCount) {
    Description description{kRgbsda, 2, {}};
    for (int c = 0; c < channelCount; ++c) description.samples.push_back(signedFloat(16 * c, 16, kRgba[static_cast<std::size_t>(c)]));
    return description;
}

/// Each channel is a mantissa of 9 bits and the exponent that all three share. 8448 = 33 * 256 and the exponent range 15..31 are the
/// specification's own example: mantissa 256 with exponent 16 (bias 15, 9 fraction bits) is 1.0.
Description sharedExponent() {
    Description description{kRgbsda, 4, {}};
    for (int c = 0; c < 3; ++c) {
        const std::uint8_t channel = kRgba[static_cast<std::size_t>(c)];
        description.samples.push_back({9 * c, 9, channel, 0, 8448});
        description.samples.push_back({27, 5, static_cast<std::uint8_t>(channel | kExponent), 15, 31});
    }
    return description;
}

Description describe(PixelFormat format) {
    switch (format) {
        case PixelFormat::Bc1:
            return {kBc1a, 1, {blockSample(0, 64, kWholeBlock)}};
        case PixelFormat::Bc3:
            return {kBc3, 1, {blockSample(0, 64, kAlpha), blockSample(64, 64, kWholeBlock)}};
        case PixelFormat::Bc4:
            return {kBc4, 1, {blockSample(0, 64, kWholeBlock)}};
        case PixelFormat::Bc4Snorm:
            return {kBc4, 1, {signedBlockSample(0, 64, kWholeBlock)}};
        case PixelFormat::Bc5:
            return {kBc5, 1, {blockSample(0, 64, kRed), blockSample(64, 64, kGreen)}};
        case PixelFormat::Bc5Snorm:
            return {kBc5, 1, {signedBlockSample(0, 64, kRed), signedBlockSample(64, 64, kGreen)}};
        case PixelFormat::Bc6hUf16:
            return {kBc6h, 1, {unsignedFloat(0, 128, kWholeBlock)}};
        case PixelFormat::Bc6hSf16:
            return {kBc6h, 1, {signedFloat(0, 128, kWholeBlock)}};
        case PixelFormat::Bc7:
            return {kBc7, 1, {blockSample(0, 128, kWholeBlock)}};
        case PixelFormat::Astc4x4Hdr:
        case PixelFormat::Astc6x6Hdr:
        case PixelFormat::Astc8x8Hdr:
            return {kAstc, 1, {signedFloat(0, 128, kWholeBlock)}};
        case PixelFormat::Astc4x4Ldr:
            return {kAstc, 1, {blockSample(0, 128, kWholeBlock)}};
        case PixelFormat::Rgb9e5:
            return sharedExponent();
        case PixelFormat::R11g11b10f:
            return {kRgbsda, 4, {unsignedFloat(0, 11, kRed), unsignedFloat(11, 11, kGreen), unsignedFloat(22, 10, kBlue)}};
        case PixelFormat::Rgba16f:
            return halfs(4);
        case PixelFormat::Rgb16f:
            return halfs(3);
        case PixelFormat::R16Unorm:
            return unorm(1, 16, false);
        case PixelFormat::Rg16Unorm:
            return unorm(2, 16, false);
        case PixelFormat::Rgba16Unorm:
            return unorm(4, 16, false);
        case PixelFormat::Rgba8Unorm:
            return unorm(4, 8, false);
        case PixelFormat::Rgba8Srgb:
            return unorm(4, 8, true);
    }
    return {};
}

std::uint64_t alignUp(std::uint64_t value, std::uint64_t alignment) {
    return (value + alignment - 1) / alignment * alignment;
}

void appendKeyValue(std::vector<std::byte>& bytes, std::string_view key, std::string_view value) {
    appendU32(bytes, static_cast<std::uint32_t>(key.size() + value.size() + 2));
    for (const std::string_view text : {key, value}) {
        for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
        bytes.push_back(std::byte{0});
    }
    while (bytes.size() % 4 != 0) bytes.push_back(std::byte{0});
}

std::vector<std::byte> keyValueBytes(const std::map<std::string, std::string>& metadata) {
    std::vector<std::byte> bytes;
    for (const auto& [key, value] : metadata) appendKeyValue(bytes, key, value);  // a std::map is sorted by unsigned bytes, as KTX wants it
    return bytes;
}

Result<void> checkMetadata(const TextureFileOptions& options, const Subject& subject) {
    std::size_t total = 0;
    for (const auto& [key, value] : options.metadata) {
        if (key.empty() || key.find('\0') != std::string::npos || key.starts_with("KTX") || key.starts_with("ktx"))
            return failure(
                ErrorCode::InvalidRequest, subject,
                fmt::format("found metadata key \"{}\", expected one that is not empty, holds no NUL and does not begin with KTX", key));
        total += key.size() + value.size() + 16;
    }
    if (total > kMaxKeyValueBytes / 2)
        return failure(ErrorCode::InvalidRequest, subject,
                       fmt::format("found {} bytes of metadata, expected at most {}", total, kMaxKeyValueBytes / 2));
    return {};
}

// ---- reading ----

class HeaderReader {
public:
    explicit HeaderReader(const FileBytes& file) : file_(file) {}

    Result<TextureFileLayout> readAll() {
        if (file_.size() < kHeaderBytes) return bad("size", file_.size(), fmt::format("at least {} bytes", kHeaderBytes));
        header_.resize(kHeaderBytes);
        if (Result<void> read = file_.readAt(0, header_); !read) return tl::make_unexpected(read.error());
        layout_.container = Container::Ktx2;
        Result<void> done = readShape();
        if (done) done = readLevels();
        if (done) done = checkDescriptor();
        if (done) done = readKeyValues();
        if (!done) return tl::make_unexpected(done.error());
        return std::move(layout_);
    }

private:
    template <class Value>
    tl::unexpected<Error> bad(std::string_view field, Value found, std::string_view expected,
                              ErrorCode code = ErrorCode::FileUnreadable) const {
        return failure(code, Subject(file_.path()).at("KTX2 " + std::string(field)), fmt::format("found {}, expected {}", found, expected));
    }
    std::uint32_t field(std::size_t offset) const { return loadU32(header_, offset); }

    Result<void> readShape() {
        const std::uint32_t vkFormat = field(kVkFormatAt);
        const auto formats = allPixelFormats();
        // The two kinds of BC1 differ in what one of its colours means.
        const std::uint32_t sought = vkFormat == kBc1Rgba ? kBc1Rgb : vkFormat;
        const auto found = std::find_if(formats.begin(), formats.end(), [&](const PixelFormatInfo& f) { return f.vkFormat == sought; });
        if (found == formats.end()) return foreignFormat(vkFormat);
        layout_.hasBc1Alpha = vkFormat == kBc1Rgba;
        const std::uint32_t width = field(kWidthAt), height = field(kHeightAt), layers = field(kLayersAt), levels = field(kLevelsAt);
        const std::uint32_t typeSize = describe(found->format).typeSize;
        if (field(kTypeSizeAt) != typeSize) return bad("typeSize", field(kTypeSizeAt), fmt::format("{}", typeSize));
        if (width < 1 || width > kMaxTextureExtent) return bad("pixelWidth", width, fmt::format("1 to {}", kMaxTextureExtent));
        if (height < 1 || height > kMaxTextureExtent) return bad("pixelHeight", height, fmt::format("1 to {}", kMaxTextureExtent));
        if (field(kDepthAt) != 0) return bad("pixelDepth", field(kDepthAt), "0 (no volume textures)", ErrorCode::FormatUnsupported);
        if (layers > kMaxTextureLayers) return bad("layerCount", layers, fmt::format("at most {}", kMaxTextureLayers));
        if (field(kFacesAt) != 1 && field(kFacesAt) != 6) return bad("faceCount", field(kFacesAt), "1 or 6");
        if (levels > 17) return bad("levelCount", levels, "at most 17");
        TextureShape& shape = layout_.shape;
        shape.format = found->format;
        shape.width = static_cast<int>(width);
        shape.height = static_cast<int>(height);
        shape.isArray = layers != 0;
        shape.layerCount = std::max(1, static_cast<int>(layers));
        shape.faceCount = static_cast<int>(field(kFacesAt));
        shape.mipCount = std::max(1, static_cast<int>(levels));  // 0: one level, and a wish that the loader make the others
        if (Result<void> checked = checkShape(shape, file_.path()); !checked) {
            Error error = checked.error();
            error.code = ErrorCode::FileUnreadable;
            return tl::make_unexpected(error);
        }
        const std::uint32_t scheme = field(kSupercompressionAt);
        if (scheme == kSupercompressionZlib)
            return bad("supercompressionScheme", "ZLIB (3)",
                       "none (0) or Zstandard (2). Compress it again: ktx deflate --zstd 18 in.ktx2 out.ktx2",
                       ErrorCode::FormatUnsupported);
        if (scheme != kSupercompressionNone && scheme != kSupercompressionZstd)
            return bad("supercompressionScheme", scheme, "0 (none) or 2 (Zstandard)", ErrorCode::FormatUnsupported);
        layout_.zstd = scheme == kSupercompressionZstd;
        if (loadU64(header_, kSgdLengthAt) != 0) return bad("sgdByteLength", loadU64(header_, kSgdLengthAt), "0");
        return {};
    }

    /// Returns the error of a format that lightcook does not read. Basis Universal has no VkFormat; the colour model of the descriptor
    /// names it.
    tl::unexpected<Error> foreignFormat(std::uint32_t vkFormat) const {
        std::array<std::byte, 1> model{};
        const std::uint64_t modelAt = std::uint64_t{field(kDfdOffsetAt)} + 12;
        if (vkFormat == 0 && modelAt + model.size() <= file_.size() && !file_.readAt(modelAt, model)) model = {};
        const int found = std::to_integer<int>(model[0]);
        if (vkFormat != 0 || (found != kEtc1s && found != kUastc && field(kSupercompressionAt) != kSupercompressionBasisLz))
            return bad("vkFormat", vkFormatName(vkFormat),
                       "a format that `lightcook encode` writes. Encode the source of the texture again, in one of them",
                       ErrorCode::FormatUnsupported);
        return bad("vkFormat", found == kUastc ? "UASTC of Basis Universal" : "ETC1S of Basis Universal (BasisLZ)",
                   "a format of GPUs. Transcode it first: ktx transcode --target rgba8 in.ktx2 out.ktx2", ErrorCode::FormatUnsupported);
    }

    Result<void> readLevels() {
        const std::size_t count = static_cast<std::size_t>(layout_.shape.mipCount);
        endOfIndex_ = kHeaderBytes + count * kLevelIndexBytes;
        if (file_.size() < endOfIndex_) return bad("size", file_.size(), fmt::format("a level index up to byte {}", endOfIndex_));
        std::vector<std::byte> index(count * kLevelIndexBytes);
        if (Result<void> done = file_.readAt(kHeaderBytes, index); !done) return done;
        for (std::size_t mip = 0; mip < count; ++mip) {
            const std::size_t at = mip * kLevelIndexBytes;
            const LevelPlace place{loadU64(index, at), loadU64(index, at + 8), loadU64(index, at + 16)};
            if (Result<void> checked = checkLevel(static_cast<int>(mip), place); !checked) return checked;
            layout_.levels.push_back(place);
        }
        return {};
    }

    Result<void> checkLevel(int mip, const LevelPlace& place) const {
        const std::string name = fmt::format("level {}, ", mip);
        const std::uint64_t expected = levelBytes(layout_.shape, mip);
        if (place.uncompressedLength != expected)
            return bad(name + "uncompressedByteLength", place.uncompressedLength, fmt::format("{}", expected));
        if (!layout_.zstd && place.length != expected) return bad(name + "byteLength", place.length, fmt::format("{}", expected));
        if (layout_.zstd && (place.length / kLeastZstdBlock + 1) * kLargestZstdBlock < expected)
            return bad(name + "uncompressedByteLength", expected,
                       fmt::format("less: {} bytes of Zstandard cannot hold so much", place.length));
        if (place.offset < endOfIndex_ || place.offset > file_.size())
            return bad(name + "byteOffset", place.offset, fmt::format("{} to {}, the size of the file", endOfIndex_, file_.size()));
        if (place.length > file_.size() - place.offset)
            return bad(name + "byteLength", place.length,
                       fmt::format("at most {}, which is left in the file", file_.size() - place.offset));
        const std::uint64_t alignment = std::lcm(4, info(layout_.shape.format).bytesPerBlock);
        if (!layout_.zstd && place.offset % alignment != 0)
            return bad(name + "byteOffset", place.offset, fmt::format("a multiple of {}", alignment));
        return {};
    }

    Result<std::vector<std::byte>> readPart(std::string_view name, std::uint64_t offset, std::uint64_t length, std::uint64_t most) const {
        if (length > most) return bad(fmt::format("{}ByteLength", name), length, fmt::format("at most {}", most));
        if (offset < endOfIndex_ || offset > file_.size() || length > file_.size() - offset)
            return bad(fmt::format("{}ByteOffset", name), offset,
                       fmt::format("a place of {} bytes between byte {} and {}", length, endOfIndex_, file_.size()));
        std::vector<std::byte> bytes(length);
        if (Result<void> done = file_.readAt(offset, bytes); !done) return tl::make_unexpected(done.error());
        return bytes;
    }

    /// The descriptor must tell the same layout as vkFormat. Primaries, transfer and ranges are not ours to use and not judged; whether the
    /// transfer function is that of our own files is noted.
    Result<void> checkDescriptor() {
        const std::vector<std::byte> expected = ktx2DataFormatDescriptor(layout_.shape.format);
        const Result<std::vector<std::byte>> found = readPart("dfd", field(kDfdOffsetAt), field(kDfdLengthAt), 4096);
        if (!found) return tl::make_unexpected(found.error());
        if (found->size() < 44) return bad("dfdByteLength", found->size(), fmt::format("{}", expected.size()));
        if (loadU32(*found, 0) != found->size()) return bad("dfdTotalSize", loadU32(*found, 0), fmt::format("{}", found->size()));
        if (loadU32(*found, 4) != 0) return bad("data format descriptor, vendor and type", loadU32(*found, 4), "0 (a basic descriptor)");
        if ((*found)[12] != expected[12])
            return bad("data format descriptor, colorModel", std::to_integer<int>((*found)[12]),
                       fmt::format("{}", std::to_integer<int>(expected[12])));
        if (loadU32(*found, 16) != loadU32(expected, 16))
            return bad("data format descriptor, texelBlockDimension", loadU32(*found, 16), fmt::format("{}", loadU32(expected, 16)));
        const int plane = std::to_integer<int>((*found)[20]);
        if (plane != std::to_integer<int>(expected[20]) && !(layout_.zstd && plane == 0))
            return bad("data format descriptor, bytesPlane0", plane, fmt::format("{}", std::to_integer<int>(expected[20])));
        layout_.hasOwnTransfer = (*found)[14] == expected[14];
        return {};
    }

    Result<void> readKeyValues() {
        if (field(kKvdLengthAt) == 0) return {};
        const Result<std::vector<std::byte>> part = readPart("kvd", field(kKvdOffsetAt), field(kKvdLengthAt), kMaxKeyValueBytes);
        if (!part) return tl::make_unexpected(part.error());
        const std::string_view text(reinterpret_cast<const char*>(part->data()), part->size());
        for (std::size_t at = 0; at < text.size();) {
            if (text.size() - at < 4) return bad("key-value data", text.size() - at, "4 bytes of a length");
            const std::size_t length = loadU32(*part, at);
            at += 4;
            if (length > text.size() - at)
                return bad("key-value data, keyAndValueByteLength", length, fmt::format("at most {}", text.size() - at));
            if (Result<void> kept = keepKeyValue(text.substr(at, length)); !kept) return kept;
            at = std::min<std::size_t>(alignUp(at + length, 4), text.size());
        }
        return checkMeaning();
    }

    Result<void> keepKeyValue(std::string_view entry) {
        const std::size_t end = entry.find('\0');
        if (end == std::string_view::npos || end == 0) return bad("key-value data", "an entry without a key", "a key that ends in NUL");
        std::string_view value = entry.substr(end + 1);
        if (value.ends_with('\0')) value.remove_suffix(1);
        const auto [place, isNew] = layout_.metadata.emplace(std::string(entry.substr(0, end)), std::string(value));
        if (!isNew) return bad("key-value data", fmt::format("key \"{}\" twice", place->first), "each key once");
        return {};
    }

    /// Refuses orientations and swizzles that we do not support: ignoring them would change the meaning of the texels.
    Result<void> checkMeaning() const {
        const auto orientation = layout_.metadata.find(std::string(kOrientationKey));
        if (orientation != layout_.metadata.end() && orientation->second != "rd")
            return bad(kOrientationKey, orientation->second, "rd", ErrorCode::FormatUnsupported);
        const auto swizzle = layout_.metadata.find(std::string(kSwizzleKey));
        if (swizzle != layout_.metadata.end() && swizzle->second != "rgba")
            return bad(kSwizzleKey, swizzle->second, "rgba", ErrorCode::FormatUnsupported);
        return {};
    }

    const FileBytes& file_;
    std::vector<std::byte> header_;
    std::uint64_t endOfIndex_ = 0;
    TextureFileLayout layout_;
};

}  // namespace

std::vector<std::byte> ktx2DataFormatDescriptor(PixelFormat format) {
    const Description description = describe(format);
    const PixelFormatInfo& texel = info(format);
    const std::uint32_t blockBytes = static_cast<std::uint32_t>(24 + 16 * description.samples.size());
    const std::uint32_t transfer = format == PixelFormat::Rgba8Srgb ? kTransferSrgb : kTransferLinear;
    std::vector<std::byte> bytes;
    appendU32(bytes, blockBytes + 4);
    appendU32(bytes, 0);                     // vendor Khronos, type basic
    appendU32(bytes, 2 | blockBytes << 16);  // version of Data Format 1.3
    appendU32(bytes, description.model | kPrimariesBt709 << 8 | transfer << 16);
    appendU32(bytes, static_cast<std::uint32_t>(texel.blockWidth - 1) | static_cast<std::uint32_t>(texel.blockHeight - 1) << 8);
    appendU32(bytes, static_cast<std::uint32_t>(texel.bytesPerBlock));  // bytesPlane0..3
    appendU32(bytes, 0);
    for (const Sample& sample : description.samples) {
        appendU32(bytes, static_cast<std::uint32_t>(sample.bitOffset) | static_cast<std::uint32_t>(sample.bitCount - 1) << 16 |
                             static_cast<std::uint32_t>(sample.channelAndQualifiers) << 24);
        appendU32(bytes, 0);  // sample position: the block's corner
        appendU32(bytes, sample.lower);
        appendU32(bytes, sample.upper);
    }
    return bytes;
}

Result<TextureFileLayout> layOutKtx2(const TextureShape& shape, const TextureFileOptions& options, const Subject& subject) {
    if (Result<void> checked = checkShape(shape, subject); !checked) return tl::make_unexpected(checked.error());
    if (Result<void> checked = checkMetadata(options, subject); !checked) return tl::make_unexpected(checked.error());
    TextureFileLayout layout{.container = Container::Ktx2, .shape = shape, .zstd = false, .metadata = options.metadata, .levels = {}};
    layout.metadata[std::string(kWriterKey)] = "lightcook " LIGHTCOOK_VERSION;
    layout.metadata[std::string(kOrientationKey)] = "rd";
    layout.levels.resize(static_cast<std::size_t>(shape.mipCount));
    const std::uint64_t alignment = std::lcm(4, info(shape.format).bytesPerBlock);
    std::uint64_t end = ktx2Prefix(layout).size();
    for (int mip = shape.mipCount - 1; mip >= 0; --mip) {
        LevelPlace& place = layout.levels[static_cast<std::size_t>(mip)];
        place.offset = alignUp(end, alignment);
        place.length = place.uncompressedLength = levelBytes(shape, mip);
        end = place.offset + place.length;
    }
    return layout;
}

std::vector<std::byte> ktx2Prefix(const TextureFileLayout& layout) {
    const TextureShape& shape = layout.shape;
    const std::vector<std::byte> descriptor = ktx2DataFormatDescriptor(shape.format), keyValues = keyValueBytes(layout.metadata);
    const std::uint32_t descriptorAt = static_cast<std::uint32_t>(kHeaderBytes + kLevelIndexBytes * layout.levels.size());
    std::vector<std::byte> bytes;
    for (const unsigned char c : kIdentifier) bytes.push_back(static_cast<std::byte>(c));
    const auto put = [&](std::size_t value) { appendU32(bytes, static_cast<std::uint32_t>(value)); };
    put(info(shape.format).vkFormat);
    put(describe(shape.format).typeSize);
    put(static_cast<std::size_t>(shape.width));
    put(static_cast<std::size_t>(shape.height));
    put(0);  // depth
    put(shape.isArray ? static_cast<std::size_t>(shape.layerCount) : 0);
    put(static_cast<std::size_t>(shape.faceCount));
    put(static_cast<std::size_t>(shape.mipCount));
    put(layout.zstd ? kSupercompressionZstd : kSupercompressionNone);
    put(descriptorAt);
    put(descriptor.size());
    put(descriptorAt + descriptor.size());
    put(keyValues.size());
    appendU64(bytes, 0);  // no supercompression global data
    appendU64(bytes, 0);
    for (const LevelPlace& place : layout.levels) {
        appendU64(bytes, place.offset);
        appendU64(bytes, place.length);
        appendU64(bytes, place.uncompressedLength);
    }
    bytes.insert(bytes.end(), descriptor.begin(), descriptor.end());
    bytes.insert(bytes.end(), keyValues.begin(), keyValues.end());
    return bytes;
}

Result<TextureFileLayout> readKtx2(const FileBytes& file) {
    return HeaderReader(file).readAll();
}

}  // namespace lightcook::formats
