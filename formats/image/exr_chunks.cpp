#include "formats/image/exr_chunks.h"

#include <OpenEXR/openexr.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "formats/digest.h"
#include "formats/image/exr_source.h"
#include "formats/system_calls.h"

namespace lightcook::formats {
namespace {

int descriptorOf(const void* user) {
    return *static_cast<const int*>(user);
}

std::int64_t readAt(exr_const_context_t, void* user, void* out, std::uint64_t count, std::uint64_t place, exr_stream_error_func_ptr_t) {
    std::uint64_t done = 0;
    while (done < count) {
        const ssize_t found = retried(
            [&] { return ::pread(descriptorOf(user), static_cast<char*>(out) + done, count - done, static_cast<off_t>(place + done)); });
        if (found <= 0) break;
        done += static_cast<std::uint64_t>(found);
    }
    return done > 0 || count == 0 ? static_cast<std::int64_t>(done) : -1;
}

std::int64_t sizeOf(exr_const_context_t, void* user) {
    struct stat status {};
    return ::fstat(descriptorOf(user), &status) == 0 ? status.st_size : -1;
}

/// Errors are told by results alone.
void ignore(exr_const_context_t, exr_result_t, const char*) {}

}  // namespace

struct ExrChunks::State {
    State(int file, ExrInfo ofFile) : descriptor(file), info(std::move(ofFile)) {}
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() {
        if (context != nullptr) exr_finish(&context);
    }

    int descriptor;
    ExrInfo info;
    exr_context_t context = nullptr;
    std::string encoding;   ///< of the texels; empty: the file was not opened
    int firstScanLine = 0;  ///< number of row 0
    int tilesAcross = 0, rowsPerChunk = 0;

    bool open() {
        exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
        start.error_handler_fn = ignore;
        start.user_data = &descriptor;
        start.read_fn = readAt;
        start.size_fn = sizeOf;
        if (exr_start_read(&context, "bake", &start) != EXR_ERR_SUCCESS) return false;
        exr_attr_box2i_t window{};
        exr_compression_t compression{};
        const exr_attr_chlist_t* channels = nullptr;
        std::int32_t rows = 0;
        if (exr_get_data_window(context, 0, &window) != EXR_ERR_SUCCESS || exr_get_channels(context, 0, &channels) != EXR_ERR_SUCCESS ||
            exr_get_compression(context, 0, &compression) != EXR_ERR_SUCCESS)
            return false;
        firstScanLine = window.min.y;
        std::string text = fmt::format("{} {} {}", static_cast<int>(compression), info.width, info.height);
        if (info.isTiled) {
            std::uint32_t width = 0, height = 0;
            if (exr_get_tile_descriptor(context, 0, &width, &height, nullptr, nullptr) != EXR_ERR_SUCCESS || width == 0 || height == 0)
                return false;
            tilesAcross = ceilDivide(info.width, static_cast<int>(width));
            rows = static_cast<std::int32_t>(height);
            text += fmt::format(" {} {}", width, height);
        } else if (exr_get_scanlines_per_chunk(context, 0, &rows) != EXR_ERR_SUCCESS) {
            return false;
        }
        rowsPerChunk = rows;
        for (int i = 0; i < channels->num_channels; ++i) {
            const exr_attr_chlist_entry_t& channel = channels->entries[i];
            text += fmt::format("\n{} {} {}", channel.name.str, static_cast<int>(channel.pixel_type), channel.p_linear);
        }
        for (const float number : info.chromaticities.value_or(StatedChromaticities())) text += fmt::format(" {}", number);
        encoding = std::move(text);
        return rowsPerChunk > 0;
    }

    /// Returns false if the file does not have the chunk whole.
    bool add(const exr_chunk_info_t& chunk, Digest& digest) const {
        std::array<std::byte, 1 << 16> piece;
        for (std::uint64_t done = 0; done < chunk.packed_size;) {
            const std::uint64_t wanted = std::min<std::uint64_t>(piece.size(), chunk.packed_size - done);
            int user = descriptor;
            if (readAt(nullptr, &user, piece.data(), wanted, chunk.data_offset + done, nullptr) != static_cast<std::int64_t>(wanted))
                return false;
            digest.add(std::span(piece).first(wanted));
            done += wanted;
        }
        digest.add(std::span(&chunk.packed_size, 1));
        return true;
    }
};

ExrChunks::ExrChunks(int descriptor, const ExrInfo& info) : state_(std::make_unique<State>(descriptor, info)) {
    if (!state_->open()) state_->encoding.clear();
}

ExrChunks::~ExrChunks() = default;

std::string ExrChunks::digestOf(int firstRow, int rowCount) const {
    const State& state = *state_;
    if (state.encoding.empty()) return "";
    Digest digest;
    digest.add(std::span(state.encoding));
    for (int row = firstRow / state.rowsPerChunk; row * state.rowsPerChunk < firstRow + rowCount; ++row) {
        exr_chunk_info_t chunk{};
        if (!state.info.isTiled) {
            if (exr_read_scanline_chunk_info(state.context, 0, state.firstScanLine + row * state.rowsPerChunk, &chunk) != EXR_ERR_SUCCESS ||
                !state.add(chunk, digest))
                return "";
            continue;
        }
        for (int column = 0; column < state.tilesAcross; ++column)
            if (exr_read_tile_chunk_info(state.context, 0, column, row, 0, 0, &chunk) != EXR_ERR_SUCCESS || !state.add(chunk, digest))
                return "";
    }
    return digest.text();
}

}  // namespace lightcook::formats
