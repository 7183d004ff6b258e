// Bakes of several files whose names differ in the end before the extension: room_L0.exr, room_L1x.exr, ... Endings and extensions count
// whatever their case: Room_Light.exr and Room_Dir.PNG are a pair, and so are ROOM_LIGHT.EXR and ROOM_DIR.PNG. File systems tell case
// apart, so a member is looked for under the spellings that bakers and archives write: as in the table, in capitals, in small letters, with
// a first capital; and the whole name in capitals or in small letters.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/bake_format.h"

namespace lightcook::formats {

/// Returns true if a text ends so, whatever the case of its letters.
bool endsInAnyCase(std::string_view text, std::string_view ending);

/// Returns the files of the set that `file` belongs to, in the order of the endings: each under the first spelling that exists, else under
/// that of `file`. Empty if its name has none of them.
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

/// Does the same for a set whose first file is a whole light map without the others: bakers write it alone where directions are off, so
/// only the scene file can say that they are missing. Then the match is None, with the evidence of Partial.
BakeMatch matchWithDirections(const std::filesystem::path& file, std::span<const std::filesystem::path> files, int numberCount,
                              std::string_view format);

}  // namespace lightcook::formats
