// OpenImageIO opens files by name, and behind the walls no file can be opened. So lightcook-read has functions of the C library of its own
// (open, fopen, stat, access and their kin, which every library then calls): from allowOneFile() on they know one name, that of the image,
// and give out descriptors of it that were opened before.
#pragma once

#include <filesystem>

namespace lightcook::formats {

/// Lets the file be opened by this name, several times, and no other. To be called before putUpWalls(), and once.
/// descriptor   of the file
void allowOneFile(const std::filesystem::path& name, int descriptor);

}  // namespace lightcook::formats
