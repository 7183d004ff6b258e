#include "formats/gpu_texture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <mutex>
#include <optional>

#include "formats/container/dds.h"
#include "formats/container/ktx2.h"
#include "formats/container/texture_file.h"
#include "formats/container/zstd_stream.h"
#include "formats/file/file_bytes.h"
#include "formats/file/file_kind.h"
#include "formats/memory.h"
#include "formats/pending_file.h"

namespace lightcook::formats {
namespace {

constexpr std::size_t kMagicBytes = 12;

/// Returns the container whose first bytes these are.
std::optional<Container> containerOf(const std::array<std::byte, kMagicBytes>& magic) {
    constexpr std::array<unsigned char, kMagicBytes> kKtx2 = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};
    constexpr std::array<unsigned char, 4> kDds = {'D', 'D', 'S', ' '};
    const auto same = [](unsigned char a, std::byte b) { return a == std::to_integer<unsigned char>(b); };
    if (std::equal(kKtx2.begin(), kKtx2.end(), magic.begin(), same)) return Container::Ktx2;
    if (std::equal(kDds.begin(), kDds.end(), magic.begin(), same)) return Container::Dds;
    return std::nullopt;
}

bool isKtx1(const std::array<std::byte, kMagicBytes>& magic) {
    constexpr std::string_view kText = "KTX 11";
    return std::equal(kText.begin(), kText.end(), magic.begin() + 1, [](char a, std::byte b) { return a == std::to_integer<char>(b); });
}

/// Returns the offset inside an image of the rows of blocks from firstBlockRow on. Fails unless `bytes` bytes are whole rows of the image:
/// a mistake of the caller is never read or written.
Result<std::uint64_t> rowsOffset(const TextureShape& shape, SubImage image, int firstBlockRow, std::size_t bytes, const Subject& subject) {
    const auto mistake = [&](std::string detail) { return failure(ErrorCode::Internal, subject, std::move(detail)); };
    if (image.mip < 0 || image.mip >= shape.mipCount || image.layer < 0 || image.layer >= shape.layerCount || image.face < 0 ||
        image.face >= shape.faceCount)
        return mistake(fmt::format("found mip {}, layer {}, face {}, expected less than {}, {}, {}", image.mip, image.layer, image.face,
                                   shape.mipCount, shape.layerCount, shape.faceCount));
    const std::size_t rowBytes = bytesPerBlockRow(shape.format, shape.mipWidth(image.mip));
    const std::size_t rows = static_cast<std::size_t>(blocksDown(shape.format, shape.mipHeight(image.mip)));
    if (firstBlockRow < 0 || static_cast<std::size_t>(firstBlockRow) > rows || bytes % rowBytes != 0 ||
        bytes / rowBytes > rows - static_cast<std::size_t>(firstBlockRow))
        return mistake(fmt::format("found {} bytes from block row {} of mip {}, expected whole rows of {} bytes among {}", bytes,
                                   firstBlockRow, image.mip, rowBytes, rows));
    return static_cast<std::uint64_t>(firstBlockRow) * rowBytes;
}

}  // namespace

int TextureShape::mipWidth(int mip) const {
    return std::max(1, width >> mip);
}
int TextureShape::mipHeight(int mip) const {
    return std::max(1, height >> mip);
}
std::size_t TextureShape::imageBytes(int mip) const {
    return bytesPerImage(format, mipWidth(mip), mipHeight(mip));
}
std::size_t TextureShape::gpuBytes() const {
    return mipChainBytes(*this) * static_cast<std::size_t>(layerCount) * static_cast<std::size_t>(faceCount);
}

Result<void> checkShape(const TextureShape& shape, const Subject& subject) {
    const auto bad = [&](std::string_view what, int found, std::string_view expected) {
        return failure(ErrorCode::InvalidRequest, subject, fmt::format("found {} {}, expected {}", what, found, expected));
    };
    if (shape.width < 1 || shape.width > kMaxTextureExtent) return bad("width", shape.width, fmt::format("1 to {}", kMaxTextureExtent));
    if (shape.height < 1 || shape.height > kMaxTextureExtent) return bad("height", shape.height, fmt::format("1 to {}", kMaxTextureExtent));
    const int mostMips = std::bit_width(static_cast<unsigned>(std::max(shape.width, shape.height)));
    if (shape.mipCount < 1 || shape.mipCount > mostMips) return bad("mip count", shape.mipCount, fmt::format("1 to {}", mostMips));
    if (shape.layerCount < 1 || shape.layerCount > kMaxTextureLayers)
        return bad("layer count", shape.layerCount, fmt::format("1 to {}", kMaxTextureLayers));
    if (!shape.isArray && shape.layerCount != 1) return bad("layer count", shape.layerCount, "1 where the texture is no array");
    if (shape.faceCount != 1 && shape.faceCount != 6) return bad("face count", shape.faceCount, "1 or 6");
    if (shape.faceCount == 6 && shape.width != shape.height)
        return bad("cubemap height", shape.height, fmt::format("{}, its width", shape.width));
    return {};
}

std::uint64_t levelBytes(const TextureShape& shape, int mip) {
    return shape.imageBytes(mip) * static_cast<std::uint64_t>(shape.layerCount) * static_cast<std::uint64_t>(shape.faceCount);
}

std::uint64_t mipChainBytes(const TextureShape& shape) {
    std::uint64_t bytes = 0;
    for (int mip = 0; mip < shape.mipCount; ++mip) bytes += shape.imageBytes(mip);
    return bytes;
}

std::uint64_t TextureFileLayout::fileBytes() const {
    std::uint64_t end = 0;
    for (const LevelPlace& place : levels) end = std::max(end, place.offset + place.length);
    return end;
}

std::uint64_t TextureFileLayout::imageOffset(SubImage image) const {
    const std::uint64_t index =
        static_cast<std::uint64_t>(image.layer) * static_cast<std::uint64_t>(shape.faceCount) + static_cast<std::uint64_t>(image.face);
    if (container == Container::Ktx2) {
        const std::uint64_t start = zstd ? 0 : levels[static_cast<std::size_t>(image.mip)].offset;
        return start + index * shape.imageBytes(image.mip);
    }
    std::uint64_t offset = levels.front().offset + index * mipChainBytes(shape);
    for (int mip = 0; mip < image.mip; ++mip) offset += shape.imageBytes(mip);
    return offset;
}

// ---- writing ----

struct TextureWriter::State {
    TextureFileLayout layout;  ///< of the uncompressed bytes
    TextureFileOptions options;
    PendingFile pending;                 ///< renamed to the final name by commit()
    std::optional<PendingFile> staging;  ///< with Zstandard: the uncompressed bytes until commit()
    FileBytes texels;                    ///< the file of the two that block rows go to
    std::atomic<std::uint64_t> bytesWritten = 0;

    Subject subject() const { return pending.target(); }
    Result<void> compressLevels();
};

TextureWriter::TextureWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
TextureWriter::TextureWriter(TextureWriter&&) noexcept = default;
TextureWriter& TextureWriter::operator=(TextureWriter&&) noexcept = default;
TextureWriter::~TextureWriter() = default;

Result<TextureWriter> TextureWriter::create(const std::filesystem::path& file, const TextureShape& shape,
                                            const TextureFileOptions& options) {
    const bool isKtx2 = options.container == Container::Ktx2;
    Result<TextureFileLayout> layout = isKtx2 ? layOutKtx2(shape, options, file) : layOutDds(shape, options, file);
    if (!layout) return tl::make_unexpected(layout.error());
    if (options.zstd)
        if (Result<void> checked = checkZstdLevel(options.zstdLevel, file); !checked) return tl::make_unexpected(checked.error());
    Result<PendingFile> pending = PendingFile::create(file);
    if (!pending) return tl::make_unexpected(pending.error());
    std::optional<PendingFile> staging;
    if (options.zstd) {
        Result<PendingFile> created = PendingFile::create(file);
        if (!created) return tl::make_unexpected(created.error());
        staging = std::move(*created);
    }
    Result<FileBytes> texels = FileBytes::openForUpdate(staging ? staging->temporary() : pending->temporary(), file);
    if (!texels) return tl::make_unexpected(texels.error());
    // All of its size at once: padding is zero, and rows may come in any order.
    if (Result<void> sized = texels->resize(layout->fileBytes()); !sized) return tl::make_unexpected(sized.error());
    return TextureWriter(
        std::unique_ptr<State>(new State{std::move(*layout), options, std::move(*pending), std::move(staging), std::move(*texels), 0}));
}

Result<void> TextureWriter::writeBlockRows(SubImage image, int firstBlockRow, std::span<const std::byte> bytes) {
    const Result<std::uint64_t> offset = rowsOffset(state_->layout.shape, image, firstBlockRow, bytes.size(), state_->subject());
    if (!offset) return tl::make_unexpected(offset.error());
    if (Result<void> written = state_->texels.writeAt(state_->layout.imageOffset(image) + *offset, bytes); !written) return written;
    state_->bytesWritten += bytes.size();
    return {};
}

/// Compresses each level of the staging file into the pending one, smallest first and without padding, in memory that does not grow with
/// the texture (at the default level 45 MiB of Zstandard's, less for a small level).
Result<void> TextureWriter::State::compressLevels() {
    Result<FileBytes> compressed = FileBytes::openForUpdate(pending.temporary(), pending.target());
    if (!compressed) return tl::make_unexpected(compressed.error());
    TextureFileLayout packed = layout;
    packed.zstd = true;
    std::uint64_t end = ktx2Prefix(packed).size();
    for (int mip = layout.shape.mipCount - 1; mip >= 0; --mip) {
        const LevelPlace& source = layout.levels[static_cast<std::size_t>(mip)];
        const Result<std::uint64_t> length = zstdCompress(texels, source.offset, source.length, *compressed, end, options.zstdLevel);
        if (!length) return tl::make_unexpected(length.error());
        packed.levels[static_cast<std::size_t>(mip)] = {end, *length, source.length};
        end += *length;
    }
    return compressed->writeAt(0, ktx2Prefix(packed));
}

Result<void> TextureWriter::commit() {
    if (state_->bytesWritten < state_->layout.shape.gpuBytes())
        return failure(
            ErrorCode::Internal, state_->subject(),
            fmt::format("found {} bytes of texels written, expected {}", state_->bytesWritten.load(), state_->layout.shape.gpuBytes()));
    Result<void> done;
    if (state_->staging)
        done = state_->compressLevels();
    else if (state_->layout.container == Container::Ktx2)
        done = state_->texels.writeAt(0, ktx2Prefix(state_->layout));
    else
        done = state_->texels.writeAt(0, ddsPrefix(state_->layout.shape));
    state_->texels.close();
    if (!done) return done;
    return state_->pending.commit();
}

// ---- reading ----

struct TextureReader::State {
    FileBytes file;
    TextureFileLayout layout;
    std::mutex mutex;                                             ///< guards inflated
    std::vector<std::optional<std::vector<std::byte>>> inflated;  ///< by mip, with Zstandard

    /// The uncompressed bytes of a level: inflated at the first call, kept until the reader goes.
    Result<std::span<const std::byte>> level(int mip);
};

Result<std::span<const std::byte>> TextureReader::State::level(int mip) {
    const std::lock_guard lock(mutex);
    std::optional<std::vector<std::byte>>& kept = inflated[static_cast<std::size_t>(mip)];
    if (!kept) {
        const LevelPlace& place = layout.levels[static_cast<std::size_t>(mip)];
        Result<std::vector<std::byte>> bytes = zstdDecompress(file, place.offset, place.length, place.uncompressedLength,
                                                              Subject(file.path()).at(fmt::format("level {}", mip)));
        if (!bytes) return tl::make_unexpected(bytes.error());
        kept = std::move(*bytes);
    }
    return std::span<const std::byte>(*kept);
}

std::optional<Container> containerOfContent(const std::filesystem::path& file) {
    if (whyNoFile(file)) return std::nullopt;
    const Result<FileBytes> bytes = FileBytes::openForReading(file);
    std::array<std::byte, kMagicBytes> magic{};
    if (!bytes || bytes->size() < magic.size() || !bytes->readAt(0, magic)) return std::nullopt;
    return containerOf(magic);
}

std::optional<Error> textureForImage(const std::filesystem::path& file, const std::string& expected) {
    const std::optional<Container> container = containerOfContent(file);
    if (!container) return std::nullopt;
    return Error{ErrorCode::FormatUnsupported, file,
                 fmt::format("found a GPU texture ({}), expected {}. Name the image that it was cooked from; `lightcook decode` writes a "
                             "texture as OpenEXR",
                             *container == Container::Ktx2 ? "KTX2" : "DDS", expected)};
}

TextureReader::TextureReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
TextureReader::TextureReader(TextureReader&&) noexcept = default;
TextureReader& TextureReader::operator=(TextureReader&&) noexcept = default;
TextureReader::~TextureReader() = default;

Result<TextureReader> TextureReader::open(const std::filesystem::path& file) {
    Result<FileBytes> bytes = FileBytes::openForReading(file);
    if (!bytes) return tl::make_unexpected(bytes.error());
    std::array<std::byte, kMagicBytes> magic{};
    if (bytes->size() < magic.size())
        return failure(ErrorCode::FileUnreadable, file, fmt::format("found {} bytes, expected a KTX2 or DDS file", bytes->size()));
    if (Result<void> read = bytes->readAt(0, magic); !read) return tl::make_unexpected(read.error());
    const std::optional<Container> container = containerOf(magic);
    if (!container)
        return failure(ErrorCode::FormatUnsupported, file,
                       isKtx1(magic) ? "found a file of KTX 1, expected KTX2 or DDS. Convert it: ktx2ktx2 in.ktx -o out.ktx2"
                                     : "found neither container's first bytes, expected a KTX2 or DDS file");
    Result<TextureFileLayout> layout = *container == Container::Ktx2 ? readKtx2(*bytes) : readDds(*bytes);
    if (!layout) return tl::make_unexpected(layout.error());
    auto state = std::unique_ptr<State>(new State{std::move(*bytes), std::move(*layout), {}, {}});
    if (state->layout.zstd) state->inflated.resize(state->layout.levels.size());
    return TextureReader(std::move(state));
}

const TextureShape& TextureReader::shape() const {
    return state_->layout.shape;
}
Container TextureReader::container() const {
    return state_->layout.container;
}
bool TextureReader::isZstd() const {
    return state_->layout.zstd;
}
const std::map<std::string, std::string>& TextureReader::metadata() const {
    return state_->layout.metadata;
}
bool TextureReader::hasOwnTransfer() const {
    return state_->layout.hasOwnTransfer;
}
bool TextureReader::hasBc1Alpha() const {
    return state_->layout.hasBc1Alpha;
}
std::size_t TextureReader::fileBytes() const {
    return state_->file.size();
}

Result<void> TextureReader::readBlockRows(SubImage image, int firstBlockRow, std::span<std::byte> out) const {
    const Result<std::uint64_t> rows = rowsOffset(shape(), image, firstBlockRow, out.size(), state_->file.path());
    if (!rows) return tl::make_unexpected(rows.error());
    const std::uint64_t offset = state_->layout.imageOffset(image) + *rows;
    if (!state_->layout.zstd) return state_->file.readAt(offset, out);
    const Result<std::span<const std::byte>> level = state_->level(image.mip);
    if (!level) return tl::make_unexpected(level.error());
    const std::span<const std::byte> source = level->subspan(offset, out.size());
    std::copy(source.begin(), source.end(), out.begin());
    return {};
}

Result<std::vector<std::byte>> TextureReader::readImage(SubImage image) const {
    if (image.mip < 0 || image.mip >= shape().mipCount)
        return tl::make_unexpected(rowsOffset(shape(), image, 0, 0, state_->file.path()).error());
    if (state_->layout.zstd)  // damage is found before there is memory for the image
        LC_CHECK(state_->level(image.mip));
    LC_CHECK(checkMemory(shape().imageBytes(image.mip), state_->file.path()));
    std::vector<std::byte> bytes(shape().imageBytes(image.mip));
    if (Result<void> read = readBlockRows(image, 0, bytes); !read) return tl::make_unexpected(read.error());
    return bytes;
}

}  // namespace lightcook::formats
