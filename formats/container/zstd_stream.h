// Zstandard compression from file to file, and decompression from file to memory, in pieces of constant size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/file/file_bytes.h"

namespace lightcook::formats {

Result<void> checkZstdLevel(int level, const Subject& subject);

/// Compresses a range of `source` into one frame (content size and checksum in it) at `offset` of `destination`; returns its length
/// [bytes]. The same bytes give the same frame: pieces are of one size, and there is one thread.
Result<std::uint64_t> zstdCompress(const FileBytes& source, std::uint64_t sourceOffset, std::uint64_t sourceLength,
                                   const FileBytes& destination, std::uint64_t offset, int level);

/// Decompresses a range of a file to exactly `expectedLength` bytes. Memory grows with the decompressed data, not with the length that the
/// file claims. Fails for a corrupt stream and for one that is too short, too long or followed by other bytes.
/// subject  the place that the error names
Result<std::vector<std::byte>> zstdDecompress(const FileBytes& source, std::uint64_t offset, std::uint64_t length,
                                              std::uint64_t expectedLength, const Subject& subject);

}  // namespace lightcook::formats
