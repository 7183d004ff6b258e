// A bake from a text, for the fuzzer of the bake readers: its files are written by OpenEXR and our PNG fixture, since the bytes of such
// files are no business of these readers. What is fuzzed is which files there are, with which channels, sizes and numbers.
//
//   picture room_L0.exr 2x2 R G B      a file; the first one is the map. Also .png, of 8 bits
//   file room.exr.import text          a file of this line
//   part sh00.R room_red.exr           LightMapDescription::partFiles
//   bake bakery-sh                     a member of LightMapDescription by its key in a scene file; mesh is a square, lmbake its place
//   flags 5                            its booleans, as bits
//   (empty line)
//   numbers of all texels in turn, a byte each; after the last one they begin anew
#pragma once

#include <filesystem>
#include <string>

#include "formats/light_map.h"

namespace lightcook::formats {

struct WrittenBake {
    std::filesystem::path file;
    LightMapDescription description;
};

/// Replaces the files of the bake before it. Lines of other words are passed over.
WrittenBake writeBake(const std::string& text);

}  // namespace lightcook::formats
