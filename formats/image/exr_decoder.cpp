#include "formats/image/exr_source.h"

#include <OpenEXR/Iex.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfEnvmap.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfTiledInputFile.h>
#include <OpenEXR/ImfVersion.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <limits>

#include "formats/file/one_line.h"
#include "formats/image/exr_chunks.h"
#include "formats/image/exr_windows.h"
#include "formats/image/out_of_memory.h"
#include "formats/memory.h"
#include "formats/system_calls.h"

namespace lightcook::formats {
namespace {

constexpr int kLargestTile = 1 << 22;            // texels; a light map's are 64 x 64
constexpr std::uintmax_t kLeastChunkBytes = 16;  // of a chunk: an entry of the offset table, its position and its length

tl::unexpected<Error> unreadable(const std::filesystem::path& file, std::string detail) {
    return failure(ErrorCode::FileUnreadable, file, std::move(detail));
}
tl::unexpected<Error> unreadable(const std::filesystem::path& file, const std::exception& exception) {
    throwIfOutOfMemory(exception);
    return unreadable(file, fmt::format("found {}, expected a whole OpenEXR file", quotedLine(exception.what())));
}

/// A descriptor as OpenEXR reads it, at a place of its own: several may read one.
class DescriptorStream : public Imf::IStream {
public:
    DescriptorStream(int descriptor, const std::filesystem::path& file)
        : Imf::IStream(file.c_str()), descriptor_(descriptor), buffer_(kBufferBytes) {}

    bool read(char out[], int count) override {
        const auto wanted = static_cast<std::size_t>(std::max(count, 0));
        std::size_t done = 0;
        while (done < wanted) {
            if (place_ < bufferPlace_ || place_ >= bufferPlace_ + filled_) {
                const std::size_t left = wanted - done;
                const bool isLarge = left >= buffer_.size();
                const ssize_t found = readAt(isLarge ? out + done : buffer_.data(), isLarge ? left : buffer_.size());
                if (found == 0) throw Iex::InputExc(fmt::format("Early end of file: read {} out of {} requested bytes.", done, wanted));
                if (isLarge) {
                    done += static_cast<std::size_t>(found);
                    place_ += static_cast<std::uint64_t>(found);
                    continue;
                }
                bufferPlace_ = place_;
                filled_ = static_cast<std::size_t>(found);
            }
            const auto from = static_cast<std::size_t>(place_ - bufferPlace_);
            const std::size_t part = std::min(wanted - done, filled_ - from);
            std::memcpy(out + done, buffer_.data() + from, part);
            done += part;
            place_ += part;
        }
        return true;
    }
    std::uint64_t tellg() override { return place_; }
    void seekg(std::uint64_t place) override { place_ = place; }

private:
    static constexpr std::size_t kBufferBytes = 16384;  // an offset table is read eight bytes at a time

    ssize_t readAt(char* out, std::size_t count) const {
        if (place_ > static_cast<std::uint64_t>(std::numeric_limits<off_t>::max())) return 0;
        const ssize_t found = retried([&] { return ::pread(descriptor_, out, count, static_cast<off_t>(place_)); });
        if (found < 0) throw Iex::InputExc(std::strerror(errno));
        return found;
    }

    int descriptor_;
    std::vector<char> buffer_;
    std::uint64_t place_ = 0, bufferPlace_ = 0;
    std::size_t filled_ = 0;
};

/// Returns "R, G, B" of the channels of a header, and how many more there are.
std::string namesOf(const Imf::ChannelList& channels) {
    constexpr std::size_t kMostNames = 8;
    std::vector<std::string> names;
    for (auto channel = channels.begin(); channel != channels.end(); ++channel) names.push_back(oneLine(channel.name()));
    const std::size_t left = names.size() - std::min(names.size(), kMostNames);
    names.resize(names.size() - left);
    return fmt::format("{}{}", fmt::join(names, ", "), left > 0 ? fmt::format(" and {} more", left) : "");
}

/// Returns the error of a file of several parts, or of deep texels, with its parts.
tl::unexpected<Error> severalParts(const std::vector<Imf::Header>& parts, const std::filesystem::path& file) {
    constexpr std::size_t kMostParts = 16;
    const bool isDeep = std::ranges::any_of(parts, [](const Imf::Header& part) { return part.hasType() && Imf::isDeepData(part.type()); });
    if (isDeep && parts.size() == 1)
        return failure(ErrorCode::FormatUnsupported, file,
                       fmt::format("found a deep image ({}), expected a flat one. Flatten it: oiiotool in.exr --flatten -o out.exr",
                                   namesOf(parts.front().channels())));
    std::vector<std::string> names;
    for (std::size_t i = 0; i < std::min(parts.size(), kMostParts); ++i) {
        const Imf::Header& part = parts[i];
        names.push_back(fmt::format("{} ({}{})", part.hasName() ? quotedLine(part.name()) : fmt::format("{}", i),
                                    part.hasType() && Imf::isDeepData(part.type()) ? "deep: " : "", namesOf(part.channels())));
    }
    if (parts.size() > kMostParts) names.push_back("...");
    return failure(ErrorCode::FormatUnsupported, file,
                   fmt::format("found {} part{}, {}, expected one flat image. Take one out: oiiotool in.exr --subimage {} -o out.exr",
                               parts.size(), parts.size() == 1 ? "" : "s", fmt::join(names, ", "), parts.front().hasName() ? "NAME" : "0"));
}

/// Reads the headers of a file, of which only those of several parts have more than one.
std::vector<Imf::Header> readHeaders(Imf::IStream& source, int version) {
    constexpr std::size_t kMostParts = 4096;
    std::vector<Imf::Header> headers;
    do {
        Imf::Header& header = headers.emplace_back();
        header.readFrom(source, version);
        if (Imf::isMultiPart(version) && header.readsNothing()) {  // the end of the list
            headers.pop_back();
            break;
        }
    } while (Imf::isMultiPart(version) && headers.size() < kMostParts);
    return headers;
}

/// Returns the rows that a chunk of a scan-line file holds.
int rowsPerChunk(Imf::Compression compression) {
    switch (compression) {
        case Imf::NO_COMPRESSION:
        case Imf::RLE_COMPRESSION:
        case Imf::ZIPS_COMPRESSION:
            return 1;
        case Imf::ZIP_COMPRESSION:
        case Imf::PXR24_COMPRESSION:
            return 16;
        case Imf::PIZ_COMPRESSION:
        case Imf::B44_COMPRESSION:
        case Imf::B44A_COMPRESSION:
        case Imf::DWAA_COMPRESSION:
            return 32;
        default:
            return 256;  // DWAB, the most that any has
    }
}

/// Adds the channels of the header. Returns the bytes of one texel.
Result<std::uintmax_t> readChannels(const Imf::ChannelList& channels, const std::filesystem::path& file, ExrInfo& info) {
    std::uintmax_t texelBytes = 0;
    for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
        if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1) {
            if (channels.findChannel("Y") != nullptr && (channels.findChannel("RY") != nullptr || channels.findChannel("BY") != nullptr))
                return failure(ErrorCode::FormatUnsupported, file,
                               fmt::format("found luminance and chroma ({}), expected R, G and B. Export it as RGB", namesOf(channels)));
            return failure(
                ErrorCode::FormatUnsupported, Subject(file).at("channel " + oneLine(channel.name())),
                fmt::format("found a sampling of {} x {}, expected every texel", channel.channel().xSampling, channel.channel().ySampling));
        }
        info.channels.emplace_back(channel.name());
        if (channel.channel().type == Imf::UINT) info.integerChannels.emplace_back(channel.name());
        texelBytes += channel.channel().type == Imf::HALF ? 2 : 4;
    }
    if (info.channels.size() > kMostExrChannels)
        return failure(ErrorCode::WrongShape, file,
                       fmt::format("found {} channels, expected at most {}", info.channels.size(), kMostExrChannels));
    return texelBytes;
}

ExrWindow windowOf(const Imath::Box2i& box) {
    return {box.min.x, box.min.y, std::int64_t{box.max.x} - box.min.x + 1, std::int64_t{box.max.y} - box.min.y + 1};
}

std::optional<ExrEnvironment> environmentOf(const Imf::Header& header) {
    if (!Imf::hasEnvmap(header)) return std::nullopt;
    return Imf::envmap(header) == Imf::ENVMAP_CUBE ? ExrEnvironment::Cube : ExrEnvironment::LatLong;
}

std::optional<StatedChromaticities> chromaticitiesOf(const Imf::Header& header) {
    if (!Imf::hasChromaticities(header)) return std::nullopt;
    const Imf::Chromaticities& found = Imf::chromaticities(header);
    return std::array{found.red.x, found.red.y, found.green.x, found.green.y, found.blue.x, found.blue.y, found.white.x, found.white.y};
}

/// The header as ours, if it can be believed. fileBytes guards against offset tables larger than the file that should hold them, and the
/// memory of one chunk is checked before OpenEXR allocates it.
Result<ExrInfo> checkedInfo(const Imf::Header& header, bool isTiled, std::uintmax_t fileBytes, const std::filesystem::path& file) {
    const ExrWindow window = windowOf(header.dataWindow());
    const std::int64_t width = window.width, height = window.height;
    if (width < 1 || height < 1 || width > kLargestExtent || height > kLargestExtent) {
        return failure(ErrorCode::WrongShape, file,
                       fmt::format("found {} x {} texels, expected 1 to {} a side", width, height, kLargestExtent));
    }
    ExrInfo info;
    info.width = static_cast<int>(width);
    info.height = static_cast<int>(height);
    info.isTiled = isTiled;
    info.chromaticities = chromaticitiesOf(header);
    info.environment = environmentOf(header);
    LC_TRY(texelBytes, readChannels(header.channels(), file, info));
    const int chunkRows = rowsPerChunk(header.compression());
    std::uintmax_t chunkCount = static_cast<std::uintmax_t>(ceilDivide(info.height, chunkRows));
    std::uintmax_t chunkTexels = static_cast<std::uintmax_t>(width) * static_cast<std::uintmax_t>(chunkRows);
    if (isTiled) {
        const Imf::TileDescription& tile = header.tileDescription();
        if (tile.xSize < 1 || tile.ySize < 1 || std::uint64_t{tile.xSize} * tile.ySize > kLargestTile) {
            return failure(
                ErrorCode::FormatUnsupported, file,
                fmt::format("found tiles of {} x {} texels, expected at most {} texels a tile", tile.xSize, tile.ySize, kLargestTile));
        }
        info.tileHeight = static_cast<int>(tile.ySize);
        chunkCount = static_cast<std::uintmax_t>(ceilDivide(info.width, static_cast<int>(tile.xSize))) *
                     static_cast<std::uintmax_t>(ceilDivide(info.height, static_cast<int>(tile.ySize)));
        chunkTexels = std::uintmax_t{tile.xSize} * tile.ySize;
    }
    if (chunkCount * kLeastChunkBytes > fileBytes) {
        return unreadable(
            file, fmt::format("found {} bytes, expected more for {} x {} texels: truncated, or a broken header", fileBytes, width, height));
    }
    LC_CHECK(checkMemory(2 * chunkTexels * *texelBytes, file));
    return info;
}

/// Reads the header alone: OpenEXR believes it when it allocates.
Result<ExrInfo> readInfo(int descriptor, const std::filesystem::path& file) {
    try {
        DescriptorStream source(descriptor, file);
        std::array<char, 8> words{};  // magic number and version, which readExrVersion() has checked
        source.read(words.data(), words.size());
        std::int32_t version = 0;
        std::memcpy(&version, &words[4], sizeof version);
        const std::vector<Imf::Header> headers = readHeaders(source, version);
        if (headers.size() != 1 || Imf::isMultiPart(version) || Imf::isNonImage(version)) return severalParts(headers, file);
        const Imf::Header& header = headers.front();
        header.sanityCheck(Imf::isTiled(version));
        struct stat status {};
        if (::fstat(descriptor, &status) != 0) return unreadable(file, quotedLine(std::strerror(errno)));
        return checkedInfo(header, Imf::isTiled(version), static_cast<std::uintmax_t>(status.st_size), file);
    } catch (const std::exception& exception) {  // std::bad_alloc too: a damaged header may ask for gigabytes
        return unreadable(file, fmt::format("found {}, expected a whole OpenEXR file", quotedLine(exception.what())));
    }
}

/// One open file: an OpenEXR file object serves one thread at a time.
struct Handle {
    std::unique_ptr<DescriptorStream> stream;  ///< that the others read
    std::unique_ptr<Imf::InputFile> scanLines;
    std::unique_ptr<Imf::TiledInputFile> tiles;

    const Imf::Header& header() const { return tiles ? tiles->header() : scanLines->header(); }
    bool isComplete() const { return tiles ? tiles->isComplete() : scanLines->isComplete(); }
};

Handle openHandle(int descriptor, const std::filesystem::path& file, bool isTiled) {
    constexpr int kThreadCount = 0;  // threads belong to the caller
    Handle handle;
    handle.stream = std::make_unique<DescriptorStream>(descriptor, file);
    if (isTiled) {
        handle.tiles = std::make_unique<Imf::TiledInputFile>(*handle.stream, kThreadCount);
    } else {
        handle.scanLines = std::make_unique<Imf::InputFile>(*handle.stream, kThreadCount);
    }
    return handle;
}

/// Slices for planes whose texel (0, 0) is texel `origin` of the file.
Imf::FrameBuffer frameBuffer(std::span<const ExrPlane> planes, const Imath::V2i& origin, int width, int rowCount) {
    Imf::FrameBuffer buffer;
    for (const ExrPlane& plane : planes) {
        buffer.insert(plane.channel, Imf::Slice::Make(Imf::FLOAT, plane.texels, origin, width, rowCount,
                                                      static_cast<std::size_t>(plane.texelStride) * sizeof(float),
                                                      static_cast<std::size_t>(plane.rowStride) * sizeof(float)));
    }
    return buffer;
}

/// The same planes, beginning at a later row.
std::vector<ExrPlane> fromRow(std::span<const ExrPlane> planes, int row) {
    std::vector<ExrPlane> moved(planes.begin(), planes.end());
    for (ExrPlane& plane : moved) plane.texels += row * plane.rowStride;
    return moved;
}

/// Reads whole rows of tiles straight into the planes.
void readTileRows(Imf::TiledInputFile& file, int firstTileRow, int tileRowCount, const ExrInfo& info, std::span<const ExrPlane> planes) {
    const Imath::V2i corner = file.header().dataWindow().min;
    const int firstRow = firstTileRow * info.tileHeight;
    const int rowCount = std::min(info.height - firstRow, tileRowCount * info.tileHeight);
    file.setFrameBuffer(frameBuffer(planes, {corner.x, corner.y + firstRow}, info.width, rowCount));
    file.readTiles(0, file.numXTiles() - 1, firstTileRow, firstTileRow + tileRowCount - 1);
}

/// Reads one row of tiles aside, and copies the rows [begin, end) of the file to planes whose first row is file row `begin`.
void readPartOfTileRow(Imf::TiledInputFile& file, int tileRow, int begin, int end, const ExrInfo& info, std::span<const ExrPlane> planes) {
    const std::size_t planeSize = static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.tileHeight);
    std::vector<float> texels(planeSize * planes.size());
    std::vector<ExrPlane> aside;
    for (const ExrPlane& plane : planes) aside.push_back({plane.channel, texels.data() + aside.size() * planeSize, 1, info.width});
    readTileRows(file, tileRow, 1, info, aside);
    for (std::size_t index = 0; index < planes.size(); ++index) {
        for (int row = begin; row < end; ++row) {
            const float* from = aside[index].texels + (row - tileRow * info.tileHeight) * aside[index].rowStride;
            float* to = planes[index].texels + (row - begin) * planes[index].rowStride;
            for (int x = 0; x < info.width; ++x) to[x * planes[index].texelStride] = from[x];
        }
    }
}

void readTiled(Imf::TiledInputFile& file, int firstRow, int rowCount, const ExrInfo& info, std::span<const ExrPlane> planes) {
    const int endRow = firstRow + rowCount;
    for (int row = firstRow; row < endRow;) {
        const int tileRow = row / info.tileHeight;
        const int tileEnd = std::min(info.height, (tileRow + 1) * info.tileHeight);
        const auto rest = fromRow(planes, row - firstRow);
        if (row != tileRow * info.tileHeight || endRow < tileEnd) {
            const int end = std::min(endRow, tileEnd);
            readPartOfTileRow(file, tileRow, row, end, info, rest);
            row = end;
        } else {
            const int wholeTileRows = endRow == info.height ? ceilDivide(endRow - row, info.tileHeight) : (endRow - row) / info.tileHeight;
            readTileRows(file, tileRow, wholeTileRows, info, rest);
            row = std::min(info.height, row + wholeTileRows * info.tileHeight);
        }
    }
}

/// A file that this process decodes.
class ExrDecoder : public ExrSource {
public:
    ExrDecoder(int descriptor, std::filesystem::path file, ExrInfo info, Handle handle)
        : descriptor_(descriptor), file_(std::move(file)), info_(std::move(info)), handle_(std::move(handle)) {}
    const ExrInfo& info() const override { return info_; }
    int chunkRows() const override { return info_.isTiled ? info_.tileHeight : rowsPerChunk(handle_.header().compression()); }
    Result<void> readRows(int firstRow, int rowCount, std::span<const ExrPlane> planes) override {
        try {
            if (handle_.tiles) {
                readTiled(*handle_.tiles, firstRow, rowCount, info_, planes);
            } else {
                const Imath::V2i corner = handle_.header().dataWindow().min;
                const int first = corner.y + firstRow;
                handle_.scanLines->setFrameBuffer(frameBuffer(planes, {corner.x, first}, info_.width, rowCount));
                handle_.scanLines->readPixels(first, first + rowCount - 1);
            }
            return {};
        } catch (const std::exception& exception) {
            throwIfOutOfMemory(exception);
            return failure(ErrorCode::FileUnreadable, Subject(file_).at(fmt::format("rows {} to {}", firstRow, firstRow + rowCount - 1)),
                           fmt::format("found {}, expected whole pixel data", quotedLine(exception.what())));
        }
    }
    Result<std::string> storedDigest(int firstRow, int rowCount) override {
        if (!chunks_) chunks_ = std::make_unique<ExrChunks>(descriptor_, info_);
        return chunks_->digestOf(firstRow, rowCount);
    }

private:
    int descriptor_;
    std::filesystem::path file_;
    ExrInfo info_;
    Handle handle_;
    std::unique_ptr<ExrChunks> chunks_;  ///< once they were asked for
};

}  // namespace

Result<void> checkExrVersion(int descriptor, const std::filesystem::path& file) {
    std::array<unsigned char, 8> bytes{};
    const ssize_t count = retried([&] { return ::pread(descriptor, bytes.data(), bytes.size(), 0); });
    if (count < static_cast<ssize_t>(bytes.size()))
        return unreadable(file, fmt::format("found {} bytes, expected an OpenEXR file", std::max<ssize_t>(count, 0)));
    const auto word = [&bytes](std::size_t at) { return bytes[at] | bytes[at + 1] << 8 | bytes[at + 2] << 16 | bytes[at + 3] << 24; };
    if (word(0) != Imf::MAGIC) {
        return unreadable(file, fmt::format("found the first bytes {:02x} {:02x} {:02x} {:02x}, expected 76 2f 31 01 of an OpenEXR file",
                                            bytes[0], bytes[1], bytes[2], bytes[3]));
    }
    const int version = word(4);
    if (Imf::getVersion(version) > Imf::EXR_VERSION || !Imf::supportsFlags(Imf::getFlags(version))) {
        return failure(ErrorCode::FormatUnsupported, file,
                       fmt::format("found OpenEXR version word {:#x}, expected version 2 or older", version));
    }
    return {};
}

Result<std::unique_ptr<ExrSource>> openExrHere(int descriptor, const std::filesystem::path& file) {
    LC_CHECK(checkExrVersion(descriptor, file));
    // The header alone first: OpenEXR believes it when it allocates.
    LC_TRY(info, readInfo(descriptor, file));
    try {
        Handle handle = openHandle(descriptor, file, info->isTiled);
        if (!handle.isComplete()) return unreadable(file, "found pixel data missing, expected a whole file: truncated");
        const Imf::Header& header = handle.header();
        LC_CHECK(checkWindows(file, windowOf(header.dataWindow()), windowOf(header.displayWindow())));
        return std::make_unique<ExrDecoder>(descriptor, file, std::move(*info), std::move(handle));
    } catch (const std::exception& exception) {
        return unreadable(file, exception);
    }
}

}  // namespace lightcook::formats
