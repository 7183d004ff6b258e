// Zstandard from file to file and from file to memory, a piece at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/file/file_bytes.h"

namespace lightcook::formats {

Result<void> checkZstdLevel(int level, const std::string& subject);

/// Compresses a range of `source` into one frame (content size and checksum in it) at `offset` of `destination`; returns its length
/// [bytes]. The same bytes give the same frame: pieces are of one size, and there is one thread.
Result<std::uint64_t> zstdCompress(const FileBytes& source, std::uint64_t sourceOffset, std::uint64_t sourceLength,
                                   const FileBytes& destination, std::uint64_t offset, int level);

/// Inflates a range of a file that must give exactly `expectedLength` bytes. Memory grows with what the file really holds, not with what it
/// claims; a corrupt, short, long or trailing stream is an error in the name of `subject`.
Result<std::vector<std::byte>> zstdDecompress(const FileBytes& source, std::uint64_t offset, std::uint64_t length,
                                              std::uint64_t expectedLength, const std::string& subject);

}  // namespace lightcook::formats
