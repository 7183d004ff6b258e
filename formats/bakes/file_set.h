// Bakes of several files whose names differ in the end before the extension: room_L0.exr, room_L1x.exr, ...
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/bake_format.h"

namespace lightcook::formats {

/// Returns the files of the set that `file` belongs to, in the order of the endings. Empty if its name has none of them.
std::vector<std::filesystem::path> filesOfSet(const std::filesystem::path& file, std::span<const std::string_view> endings);

/// Returns these files for a set whose files may be of different kinds: a file that does not exist with the extension of `file` has the
/// first of .exr, .hdr, .tga and .png with which it exists.
std::vector<std::filesystem::path> filesOfMixedSet(const std::filesystem::path& file, std::span<const std::string_view> endings);

/// Kinds of the files of a set: all that of the named file, or any that filesOfMixedSet() looks for.
enum class FileKinds { Same, Mixed };

/// Returns how well a file and those beside it fit a set: Certain if all exist, else Partial, which names the first that is missing.
/// files        of the set, `file` among them
/// numberCount  numbers of a texel that the whole set has
/// kinds        of the files, with whose extensions one that is missing is named
BakeMatch matchFiles(const std::filesystem::path& file, std::span<const std::filesystem::path> files, int numberCount,
                     std::string_view format, FileKinds kinds);

}  // namespace lightcook::formats
