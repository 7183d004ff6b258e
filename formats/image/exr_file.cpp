#include "formats/image/exr_file.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <fstream>
#include <mutex>

#include "formats/file/descriptor.h"
#include "formats/file/file_kind.h"
#include "formats/file/one_line.h"
#include "formats/image/exr_source.h"
#include "formats/image/out_of_memory.h"
#include "formats/pending_file.h"
#include "formats/reader/reader_process.h"

namespace lightcook::formats {
namespace {

constexpr int kTileExtent = 64;
}  // namespace

bool isExrFile(const std::filesystem::path& file) {
    std::array<unsigned char, 4> bytes{};
    if (whyNoFile(file)) return false;
    std::ifstream(file, std::ios::binary).read(reinterpret_cast<char*>(bytes.data()), bytes.size());
    return bytes == std::array<unsigned char, 4>{0x76, 0x2f, 0x31, 0x01};
}

bool ExrInfo::has(const std::string& channel) const {
    return std::find(channels.begin(), channels.end(), channel) != channels.end();
}

struct ExrReader::State {
    std::filesystem::path file;
    Descriptor descriptor;
    ExrInfo info;
    std::mutex mutex;
    std::vector<std::unique_ptr<ExrSource>> idle;  ///< guarded by mutex

    Result<std::unique_ptr<ExrSource>> open() const {
        return areReadersChildren() ? openExrInChild(descriptor.number(), file) : openExrHere(descriptor.number(), file);
    }
    Result<std::unique_ptr<ExrSource>> take() {
        {
            const std::lock_guard lock(mutex);
            if (!idle.empty()) {
                auto source = std::move(idle.back());
                idle.pop_back();
                return source;
            }
        }
        LC_TRY(source, open());
        const ExrInfo& found = (*source)->info();
        if (found.width != info.width || found.height != info.height || found.channels != info.channels)
            return failure(ErrorCode::FileUnreadable, file,
                           "found another image than before, expected a file that nobody writes meanwhile");
        return source;
    }
    void giveBack(std::unique_ptr<ExrSource> source) {
        const std::lock_guard lock(mutex);
        idle.push_back(std::move(source));
    }
};

ExrReader::ExrReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
ExrReader::ExrReader(ExrReader&&) noexcept = default;
ExrReader& ExrReader::operator=(ExrReader&&) noexcept = default;
ExrReader::~ExrReader() = default;

const ExrInfo& ExrReader::info() const {
    return state_->info;
}

Result<ExrReader> ExrReader::open(const std::filesystem::path& file) {
    auto state = std::make_unique<State>();
    state->file = file;
    LC_TRY(descriptor, openForeignFile(file, "an OpenEXR image"));
    state->descriptor = std::move(*descriptor);
    LC_TRY(source, state->open());
    state->info = (*source)->info();
    state->giveBack(std::move(*source));
    return ExrReader(std::move(state));
}

Result<void> ExrReader::readRows(int firstRow, int rowCount, std::span<const ExrPlane> planes) const {
    const ExrInfo& info = state_->info;
    assert(0 <= firstRow && 0 <= rowCount && firstRow + rowCount <= info.height);
    if (rowCount == 0 || planes.empty()) return {};
    for (const ExrPlane& plane : planes)
        if (std::find(info.integerChannels.begin(), info.integerChannels.end(), plane.channel) != info.integerChannels.end())
            return failure(ErrorCode::FormatUnsupported, Subject(state_->file).at("channel " + plane.channel),
                           "found 32-bit integers (UINT), expected half or float");
    LC_TRY(source, state_->take());
    LC_CHECK((*source)->readRows(firstRow, rowCount, planes));
    state_->giveBack(std::move(*source));
    return {};
}

Result<std::string> ExrReader::storedDigest(int firstRow, int rowCount) const {
    assert(0 <= firstRow && 0 < rowCount && firstRow + rowCount <= state_->info.height);
    LC_TRY(source, state_->take());
    LC_TRY(digest, (*source)->storedDigest(firstRow, rowCount));
    state_->giveBack(std::move(*source));
    return digest;
}

struct ExrWriter::State {
    PendingFile pending;
    std::vector<std::string> channels;
    int width = 0, height = 0, rowsWritten = 0;
    std::ofstream stream;
    std::unique_ptr<Imf::StdOFStream> sink;
    std::unique_ptr<Imf::OutputFile> scanLines;
    std::unique_ptr<Imf::TiledOutputFile> tiles;

    Error fault(const std::exception& exception) const {
        throwIfOutOfMemory(exception);
        return fault(exception.what());
    }
    Error fault(const char* found) const {
        return {ErrorCode::Internal, pending.target(),
                fmt::format("found {} while writing, expected room for the file", quotedLine(found))};
    }
};

ExrWriter::ExrWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
ExrWriter::ExrWriter(ExrWriter&&) noexcept = default;
ExrWriter& ExrWriter::operator=(ExrWriter&&) noexcept = default;
ExrWriter::~ExrWriter() = default;

Result<ExrWriter> ExrWriter::create(const std::filesystem::path& file, int width, int height, std::vector<std::string> channels,
                                    ExrLayout layout) {
    assert(0 < width && 0 < height && !channels.empty());
    Result<PendingFile> pending = PendingFile::create(file);
    if (!pending) return tl::make_unexpected(pending.error());
    std::unique_ptr<State> state(new State{std::move(*pending), std::move(channels), width, height, 0, {}, {}, {}, {}});
    try {
        Imf::Header header(width, height);
        header.compression() = Imf::ZIP_COMPRESSION;
        for (const std::string& channel : state->channels) header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
        // Use our own stream: OpenEXR writes the offset table in destructors, which hide errors; the stream keeps its error state.
        state->stream.open(state->pending.temporary(), std::ios::binary | std::ios::trunc);
        state->sink = std::make_unique<Imf::StdOFStream>(state->stream, file.c_str());
        constexpr int kThreadCount = 0;
        if (layout == ExrLayout::Tiles64) {
            header.setTileDescription(Imf::TileDescription(kTileExtent, kTileExtent, Imf::ONE_LEVEL));
            state->tiles = std::make_unique<Imf::TiledOutputFile>(*state->sink, header, kThreadCount);
        } else {
            state->scanLines = std::make_unique<Imf::OutputFile>(*state->sink, header, kThreadCount);
        }
    } catch (const std::exception& exception) {
        return tl::make_unexpected(state->fault(exception));
    }
    return ExrWriter(std::move(state));
}

Result<void> ExrWriter::append(const float* texels, std::ptrdiff_t rowStride, int rowCount) {
    State& state = *state_;
    assert(0 <= rowCount && state.rowsWritten + rowCount <= state.height);
    const int channelCount = static_cast<int>(state.channels.size());
    try {
        Imf::FrameBuffer buffer;
        for (int channel = 0; channel < channelCount; ++channel) {
            buffer.insert(state.channels[static_cast<std::size_t>(channel)],
                          Imf::Slice::Make(Imf::FLOAT, texels + channel, Imath::V2i(0, state.rowsWritten), state.width, rowCount,
                                           static_cast<std::size_t>(channelCount) * sizeof(float),
                                           static_cast<std::size_t>(rowStride) * sizeof(float)));
        }
        if (state.tiles) {
            assert(state.rowsWritten % kTileExtent == 0 && (rowCount == kTileExtent || state.rowsWritten + rowCount == state.height));
            const int firstTileRow = state.rowsWritten / kTileExtent;
            state.tiles->setFrameBuffer(buffer);
            state.tiles->writeTiles(0, state.tiles->numXTiles() - 1, firstTileRow, firstTileRow + ceilDivide(rowCount, kTileExtent) - 1);
        } else {
            state.scanLines->setFrameBuffer(buffer);
            state.scanLines->writePixels(rowCount);
        }
    } catch (const std::exception& exception) {
        return tl::make_unexpected(state.fault(exception));
    }
    state.rowsWritten += rowCount;
    return {};
}

Result<void> ExrWriter::commit() {
    State& state = *state_;
    if (state.rowsWritten != state.height) {
        return failure(ErrorCode::Internal, state.pending.target(),
                       fmt::format("found {} rows written, expected {}", state.rowsWritten, state.height));
    }
    state.tiles.reset();
    state.scanLines.reset();
    state.sink.reset();
    state.stream.close();
    if (state.stream.fail()) return tl::make_unexpected(state.fault("a write that failed"));
    return state.pending.commit();
}

}  // namespace lightcook::formats
