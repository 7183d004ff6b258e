#include "pipeline/manifest/folder_difference.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <set>
#include <system_error>
#include <utility>

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Bytes of both files that are compared at a time.
constexpr std::size_t kChunkBytes = 1 << 16;

/// Adds [offset, offset + length) to ranges that end before it.
void addRange(std::vector<ByteRange>& ranges, std::uint64_t offset, std::uint64_t length) {
    if (!ranges.empty() && offset < ranges.back().offset + ranges.back().length + kLeastGap)
        ranges.back().length = offset + length - ranges.back().offset;
    else
        ranges.push_back({offset, length});
}

Result<std::uint64_t> bytesInFile(const std::filesystem::path& file) {
    std::error_code code;
    const std::uintmax_t bytes = std::filesystem::file_size(file, code);
    if (code) return failure(ErrorCode::FileUnreadable, file, "found no such file, expected that of the manifest");
    return bytes;
}

/// Returns the bytes of a file from an offset on, as many as there are.
Result<std::size_t> readChunk(std::ifstream& stream, const std::filesystem::path& file, std::array<char, kChunkBytes>& chunk) {
    stream.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
    if (stream.bad() || (stream.fail() && !stream.eof()))
        return failure(ErrorCode::FileUnreadable, file, "found a read that failed, expected the whole file");
    return static_cast<std::size_t>(stream.gcount());
}

Result<std::vector<ByteRange>> changedRanges(const std::filesystem::path& old, const std::filesystem::path& updated,
                                             const RunState& state) {
    std::ifstream oldStream(old, std::ios::binary), newStream(updated, std::ios::binary);
    std::vector<ByteRange> ranges;
    std::array<char, kChunkBytes> oldChunk, newChunk;
    for (std::uint64_t offset = 0;; offset += kChunkBytes) {
        if (state.interrupted) return failure(ErrorCode::Interrupted, updated, "interrupted");
        LC_TRY(newBytes, readChunk(newStream, updated, newChunk));
        LC_TRY(oldBytes, readChunk(oldStream, old, oldChunk));
        for (std::size_t i = 0; i < *newBytes; ++i)
            if (i >= *oldBytes || newChunk[i] != oldChunk[i]) addRange(ranges, offset + i, 1);
        if (*newBytes < kChunkBytes) return ranges;
    }
}

/// Returns the digest of each file that an engine reads, by name. That of the manifest is empty: nothing has one.
std::map<std::string, std::string> digestsOf(const Manifest& manifest) {
    std::map<std::string, std::string> digests = {{kManifestName, ""}};
    for (const FileRecord& file : filesOf(manifest)) digests[file.name] = file.digest;
    return digests;
}

}  // namespace

Result<FolderDifference> differenceOf(const FolderWithManifest& old, const FolderWithManifest& updated, const RunState& state) {
    const std::map<std::string, std::string> oldDigests = digestsOf(old.manifest), newDigests = digestsOf(updated.manifest);
    std::set<std::string> names;
    for (const auto* digests : {&oldDigests, &newDigests})
        for (const auto& [name, digest] : *digests) names.insert(name);
    FolderDifference difference;
    for (const std::string& name : names) {
        FileDifference file{.file = name};
        const auto oldDigest = oldDigests.find(name), newDigest = newDigests.find(name);
        const bool isOld = oldDigest != oldDigests.end(), isNew = newDigest != newDigests.end();
        if (isOld) {
            LC_TRY(bytes, bytesInFile(old.folder / name));
            file.bytesOld = *bytes;
        }
        if (isNew) {
            LC_TRY(bytes, bytesInFile(updated.folder / name));
            file.bytesNew = *bytes;
        }
        difference.bytesOld += file.bytesOld;
        difference.bytesNew += file.bytesNew;
        if (!isNew) {
            file.change = FileChange::Removed;
            ++difference.filesRemoved;
        } else if (!isOld) {
            file.change = FileChange::Added;
            if (file.bytesNew > 0) file.ranges = {{0, file.bytesNew}};
            ++difference.filesAdded;
        } else {
            if (name == kManifestName || oldDigest->second != newDigest->second) {
                LC_TRY(ranges, changedRanges(old.folder / name, updated.folder / name, state));
                file.ranges = std::move(*ranges);
            }
            const bool isSame = file.ranges.empty() && file.bytesOld == file.bytesNew;
            ++(isSame ? difference.filesSame : difference.filesChanged);
            if (isSame) continue;
        }
        for (const ByteRange& range : file.ranges) file.bytesChanged += range.length;
        difference.bytesChanged += file.bytesChanged;
        difference.files.push_back(std::move(file));
    }
    return difference;
}

}  // namespace lightcook::pipeline
