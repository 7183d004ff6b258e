// Rules of what a file may include: the layers of cmake/arrows.cmake, the public headers of each module, and the modules that may use each
// third-party library, all read from the sources. Links alone cannot check this: the modules share one include folder, so a header-only
// use of a forbidden module would build.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lightcook::architecture {

struct Violation {
    std::string place;  ///< "compress/bc6h/encode.cpp:12", relative to the tree
    std::string what;   ///< "compress may not include verify/texture/decode.h: module verify is not below compress"
    friend bool operator==(const Violation&, const Violation&) = default;
};

/// A subfolder of a module that some files outside the module may include.
struct IncludeException {
    std::string from;      ///< path of a file or of a folder with its '/'
    std::string included;  ///< the same
    std::string reason;
};

/// Returns the modules, lowest first. They are folders of the tree.
const std::vector<std::string>& modules();
std::span<const IncludeException> includeExceptions();

/// Checks the includes of one file. A file of a module follows the layers. Every file includes only the root headers of other modules;
/// a file of tests/<module>/ may include the subfolders of that module.
/// file   relative to the tree; its first folder is its module, "tests" or "bench"
/// text   its contents; lines of the form  #include <...>  or  #include "..."  count, whatever #if they stand in
std::vector<Violation> checkIncludes(const std::filesystem::path& file, std::string_view text);

/// Returns the names between quotes of the #include lines of a text, in their order.
std::vector<std::string> quotedIncludes(std::string_view text);

struct UsedInclude {
    std::string file, name;
};
struct TreeCheck {
    std::vector<Violation> violations;        ///< in order of path and line; modules first, then bench and tests
    std::vector<std::filesystem::path> read;  ///< the sources of the modules, relative to the tree, sorted
    std::vector<UsedInclude> includes;        ///< quoted includes of modules, bench and tests
};

/// Checks every C++ and shader source of the modules, bench/ and tests/ of `tree`.
TreeCheck checkTree(const std::filesystem::path& tree);

/// Returns the rows of includeExceptions() that no include needs.
std::vector<std::string> unusedExceptions(const TreeCheck& check);

/// Returns the files at the root of a module that do not belong there: files that are no header, and headers that nothing outside the
/// module includes, neither directly nor through other public headers.
std::vector<std::string> rootViolations(const std::filesystem::path& tree, const TreeCheck& check);

}  // namespace lightcook::architecture
