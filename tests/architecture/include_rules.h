// Which room may include what: the arrows of cmake/arrows.cmake and the one home of each third-party library, read from the sources
// themselves. Links alone cannot hold the arrows: all rooms share one include folder, so a header-only use of a forbidden room would build.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace lightcook::architecture {

struct Violation {
    std::string place;  ///< "compress/bc6h/encode.cpp:12", relative to the tree
    std::string what;   ///< "compress may not include verify/texture/decode.h: room verify is not below compress"
    friend bool operator==(const Violation&, const Violation&) = default;
};

/// The rooms, lowest first; folders of the tree. Other folders (tests, bench, examples) may include what they like.
const std::vector<std::string>& rooms();

/// Holds the includes of one file against the rules.
/// file   relative to the tree; its first folder is its room
/// text   its contents; lines of the form  #include <...>  or  #include "..."  count, whatever #if they stand in
std::vector<Violation> checkIncludes(const std::filesystem::path& file, std::string_view text);

/// The names between quotes of the #include lines of a text, in their order.
std::vector<std::string> quotedIncludes(std::string_view text);

struct TreeCheck {
    std::vector<Violation> violations;        ///< in order of path and line
    std::vector<std::filesystem::path> read;  ///< the files that were looked at, relative to the tree, sorted
};

/// Checks every C++ and shader source under each room's folder of `tree`.
TreeCheck checkTree(const std::filesystem::path& tree);

}  // namespace lightcook::architecture
