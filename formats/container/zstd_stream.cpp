#include "formats/container/zstd_stream.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

#include "formats/memory.h"

namespace lightcook::formats {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;
/// From this level on, Zstandard's tables would take 60 MiB and more beside the window. Limiting them to 2^22 entries costs 0.2 % in size.
constexpr int kFirstLevelOfLargeTables = 18, kLargestTableLog = 22;

struct FreeContext {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

tl::unexpected<Error> zstdFailure(ErrorCode code, const Subject& subject, std::size_t result) {
    return failure(code, subject, fmt::format("found \"{}\" (Zstandard), expected a good stream", ZSTD_getErrorName(result)));
}

}  // namespace

Result<void> checkZstdLevel(int level, const Subject& subject) {
    if (level < 1 || level > ZSTD_maxCLevel())
        return failure(ErrorCode::InvalidRequest, subject,
                       fmt::format("found Zstandard level {}, expected 1 to {}", level, ZSTD_maxCLevel()));
    return {};
}

Result<std::uint64_t> zstdCompress(const FileBytes& source, std::uint64_t sourceOffset, std::uint64_t sourceLength,
                                   const FileBytes& destination, std::uint64_t offset, int level) {
    const Subject subject(destination.path());
    const std::unique_ptr<ZSTD_CCtx, FreeContext> context(ZSTD_createCCtx());
    if (!context) return failure(ErrorCode::Internal, subject, "found no memory for Zstandard, expected some");
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, level);
    if (level >= kFirstLevelOfLargeTables)
        for (const ZSTD_cParameter table : {ZSTD_c_chainLog, ZSTD_c_hashLog})
            ZSTD_CCtx_setParameter(context.get(), table, kLargestTableLog);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
    ZSTD_CCtx_setPledgedSrcSize(context.get(), sourceLength);
    std::vector<std::byte> in(kPiece), out(kPiece);
    std::uint64_t written = 0;
    for (std::uint64_t done = 0; done < sourceLength;) {
        const std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, sourceLength - done));
        if (Result<void> read = source.readAt(sourceOffset + done, std::span(in).first(count)); !read)
            return tl::make_unexpected(read.error());
        done += count;
        const ZSTD_EndDirective directive = done == sourceLength ? ZSTD_e_end : ZSTD_e_continue;
        ZSTD_inBuffer input{in.data(), count, 0};
        for (bool isFlushed = false; !isFlushed;) {
            ZSTD_outBuffer output{out.data(), out.size(), 0};
            const std::size_t left = ZSTD_compressStream2(context.get(), &output, &input, directive);
            if (ZSTD_isError(left)) return zstdFailure(ErrorCode::Internal, subject, left);
            if (Result<void> wrote = destination.writeAt(offset + written, std::span(out).first(output.pos)); !wrote)
                return tl::make_unexpected(wrote.error());
            written += output.pos;
            isFlushed = directive == ZSTD_e_end ? left == 0 : input.pos == input.size;
        }
    }
    return written;
}

Result<std::vector<std::byte>> zstdDecompress(const FileBytes& source, std::uint64_t offset, std::uint64_t length,
                                              std::uint64_t expectedLength, const Subject& subject) {
    const std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
    if (!context) return failure(ErrorCode::Internal, subject, "found no memory for Zstandard, expected some");
    const auto wrongLength = [&](std::string_view found) {
        return failure(ErrorCode::FileUnreadable, subject,
                       fmt::format("found {} in the Zstandard stream, expected one frame of {} bytes", found, expectedLength));
    };
    std::vector<std::byte> in(static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, length))), out(kPiece), bytes;
    // The frame's header is checked before any large allocation.
    if (Result<void> read = source.readAt(offset, in); !read) return tl::make_unexpected(read.error());
    const unsigned long long claimed = ZSTD_getFrameContentSize(in.data(), in.size());
    if (claimed == ZSTD_CONTENTSIZE_ERROR) return wrongLength("no frame");
    if (claimed != ZSTD_CONTENTSIZE_UNKNOWN && claimed != expectedLength) return wrongLength(fmt::format("a frame of {} bytes", claimed));
    if (Result<void> fits = checkMemory(expectedLength, subject); !fits) return tl::make_unexpected(fits.error());
    std::size_t left = 1;  // last result of ZSTD_decompressStream: 0 at the end of a frame
    for (std::uint64_t done = 0; done < length;) {
        const std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(in.size(), length - done));
        if (Result<void> read = source.readAt(offset + done, std::span(in).first(count)); !read) return tl::make_unexpected(read.error());
        done += count;
        ZSTD_inBuffer input{in.data(), count, 0};
        for (bool isDrained = false; !isDrained;) {
            if (left == 0) return wrongLength("bytes after the end of the frame");
            ZSTD_outBuffer output{out.data(), out.size(), 0};
            left = ZSTD_decompressStream(context.get(), &output, &input);
            if (ZSTD_isError(left)) return zstdFailure(ErrorCode::FileUnreadable, subject, left);
            if (output.pos > expectedLength - bytes.size()) return wrongLength("more bytes");
            bytes.insert(bytes.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(output.pos));
            isDrained = input.pos == input.size && output.pos < output.size;
            if (left == 0 && input.pos == input.size) isDrained = true;
        }
    }
    if (left != 0) return wrongLength("no end");
    if (bytes.size() != expectedLength) return wrongLength(fmt::format("{} bytes", bytes.size()));
    return bytes;
}

}  // namespace lightcook::formats
