// What a patch of a cooked folder has to carry: the byte ranges in which the files that an engine reads differ from those of an older cook.
//
// These files are the manifest and what it names. A byte differs if the old file of that name has another one at the same offset, or none.
// Ranges less than kLeastGap bytes apart are one: to name a range takes about as much.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"
#include "pipeline/manifest/manifest.h"

namespace lightcook::pipeline {

inline constexpr std::uint64_t kLeastGap = 16;

struct ByteRange {
    std::uint64_t offset = 0, length = 0;
};
template <class Fields, Is<ByteRange> Self>
void describe(Fields& fields, Self& range) {
    fields.required("offset", range.offset, "first byte, of the new file");
    fields.required("length", range.length, "number of bytes");
}

enum class FileChange { Changed, Added, Removed };
template <>
struct EnumNames<FileChange> {
    static std::vector<std::string> all() { return {"changed", "added", "removed"}; }
};

struct FileDifference {
    std::string file;
    FileChange change = FileChange::Changed;
    std::uint64_t bytesOld = 0, bytesNew = 0;
    std::uint64_t bytesChanged = 0;      ///< of the ranges
    std::vector<ByteRange> ranges = {};  ///< of an added file: all of it
};
template <class Fields, Is<FileDifference> Self>
void describe(Fields& fields, Self& file) {
    fields.required("file", file.file, kFileInFolder, "name in the folder");
    fields.required("change", file.change, "what became of the file");
    fields.required("bytes_old", file.bytesOld, "size of the old file [bytes]; 0 for an added one");
    fields.required("bytes_new", file.bytesNew, "size of the new file [bytes]; 0 for a removed one: what lies behind it goes");
    fields.required("bytes_changed", file.bytesChanged, "bytes of the ranges");
    fields.required("ranges", file.ranges, "ranges of the new file that the old one does not have at the same place, in ascending order");
}

struct FolderDifference {
    std::uint64_t bytesOld = 0, bytesNew = 0;  ///< of all files
    std::uint64_t bytesChanged = 0;
    std::uint64_t filesAdded = 0, filesRemoved = 0, filesChanged = 0, filesSame = 0;
    std::vector<FileDifference> files = {};  ///< without those that are the same, by name
};
template <class Fields, Is<FolderDifference> Self>
void describe(Fields& fields, Self& folder) {
    fields.required("bytes_old", folder.bytesOld, "size of all files of the old folder that an engine reads [bytes]");
    fields.required("bytes_new", folder.bytesNew, "size of all files of the new folder that an engine reads [bytes]");
    fields.required("bytes_changed", folder.bytesChanged, "bytes of all ranges: those of a patch");
    fields.required("files_added", folder.filesAdded, "files that the old folder lacks");
    fields.required("files_removed", folder.filesRemoved, "files that the new folder lacks");
    fields.required("files_changed", folder.filesChanged, "files that differ");
    fields.required("files_same", folder.filesSame, "files that do not differ");
    fields.required("files", folder.files, "files that were added, removed or changed, by name");
}

/// A cooked folder with its manifest.
struct FolderWithManifest {
    std::filesystem::path folder;
    Manifest manifest;
};

/// Compares two cooked folders. Files are read; digests of the manifests say only which need not be.
formats::Result<FolderDifference> differenceOf(const FolderWithManifest& old, const FolderWithManifest& updated, const RunState& state);

}  // namespace lightcook::pipeline
