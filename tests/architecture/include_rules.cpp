#include "tests/architecture/include_rules.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "tests/formats/temporary_folder.h"

namespace lightcook::architecture {
namespace {

using Rooms = std::set<std::string>;

const std::map<std::string, Rooms> kBelow = {
    {"lighting", {}},
    {"shaders", {}},
    {"formats", {"lighting"}},
    {"compress", {"formats", "lighting"}},
    {"fit", {"formats", "lighting"}},
    {"verify", {"formats", "lighting", "shaders"}},
    {"pipeline", {"compress", "fit", "verify", "formats", "lighting", "shaders"}},
};

struct Library {
    std::string prefix;  // of the included name; ends in '/' for a folder of headers
    Rooms homes;         // empty: everywhere
};

// A library that is not named here has no home yet: give it one in architecture.md first.
const std::vector<Library> kLibraries = {
    {"OpenImageIO/", {"formats"}},
    {"OpenEXR/", {"formats"}},
    {"Imath/", {"formats"}},
    {"OpenColorIO/", {"formats"}},
    {"draco/", {"formats"}},
    {"tiny_gltf.h", {"formats"}},
    {"zstd.h", {"formats"}},
    {"ceres/", {"fit"}},
    {"Eigen/", {"compress", "fit"}},
    {"hwy/", {"compress"}},
    {"astcenc.h", {"compress"}},
    {"tbb/", {"pipeline"}},
    {"oneapi/", {"pipeline"}},
    {"toml++/", {"pipeline"}},
    {"CLI/", {"pipeline"}},
    {"xxhash.h", {"pipeline"}},
    {"nlohmann/", {"formats", "pipeline"}},
    {"tl/", {"formats", "compress", "fit", "verify", "pipeline"}},
    {"fmt/", {}},
    {"glm/", {}},
    // Not libraries, but the machine: files and threads have their rooms as well. A mutex is allowed where a reader is shared.
    {"sys/", {"formats", "pipeline"}},
    {"dlfcn.h", {"formats"}},
    {"fcntl.h", {"formats", "pipeline"}},
    {"unistd.h", {"formats", "pipeline"}},
    {"filesystem", {"formats", "verify", "pipeline"}},
    {"fstream", {"formats", "verify", "pipeline"}},
    {"thread", {"pipeline"}},
    {"future", {"pipeline"}},
    {"execution", {"pipeline"}},
};

bool isStandard(std::string_view name) {
    return std::all_of(name.begin(), name.end(), [](char c) { return ('a' <= c && c <= 'z') || ('0' <= c && c <= '9') || c == '_'; });
}

const Library* findLibrary(std::string_view name) {
    for (const Library& library : kLibraries) {
        const bool isFolder = library.prefix.back() == '/';
        if (isFolder ? name.starts_with(library.prefix) : name == library.prefix) return &library;
    }
    return nullptr;
}

std::string joined(const Rooms& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
}

/// What is wrong with `room` including `name`, if anything.
std::optional<std::string> objection(const std::string& room, const std::string& name, bool quoted) {
    const std::size_t slash = name.find('/');
    const std::string first = slash == std::string::npos ? "" : name.substr(0, slash);
    if (kBelow.contains(first)) {
        if (first == room || kBelow.at(room).contains(first)) return std::nullopt;
        return "room " + first + " is not below " + room;
    }
    if (const Library* library = findLibrary(name)) {
        if (library->homes.empty() || library->homes.contains(room)) return std::nullopt;
        return "it lives in " + joined(library->homes);
    }
    if (!quoted && isStandard(name)) return std::nullopt;
    // Shader sources are handed to engines as one folder, so they name each other without the room.
    if (quoted && first.empty() && room == "shaders") return std::nullopt;
    return quoted && first.empty() ? "ours are included as room/file.h" : "no room is its home";
}

struct Include {
    std::string name;
    bool quoted;
};

/// The name that a line includes, if it is an #include line.
std::optional<Include> parseInclude(std::string_view line) {
    const auto skipBlanks = [&line] { line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size())); };
    const auto skip = [&line](std::string_view word) {
        const bool found = line.starts_with(word);
        if (found) line.remove_prefix(word.size());
        return found;
    };
    skipBlanks();
    if (!skip("#")) return std::nullopt;
    skipBlanks();
    if (!skip("include")) return std::nullopt;
    skipBlanks();
    const bool quoted = skip("\"");
    if (!quoted && !skip("<")) return std::nullopt;
    const std::size_t end = line.find(quoted ? '"' : '>');
    if (end == std::string_view::npos) return std::nullopt;
    return Include{std::string(line.substr(0, end)), quoted};
}

/// visit(line number from 1, Include) for each #include line of a text.
template <class Visit>
void forEachInclude(std::string_view text, Visit visit) {
    for (int lineNumber = 1; !text.empty(); ++lineNumber) {
        const std::size_t lineEnd = std::min(text.find('\n'), text.size());
        if (const std::optional<Include> include = parseInclude(text.substr(0, lineEnd))) visit(lineNumber, *include);
        text.remove_prefix(std::min(lineEnd + 1, text.size()));
    }
}

bool isSource(const std::filesystem::path& file) {
    static const std::set<std::string> extensions = {".h",    ".hpp",  ".inl",  ".cpp",  ".cc",  ".glsl",
                                                     ".hlsl", ".vert", ".frag", ".comp", ".inc", ".in"};
    return extensions.contains(file.extension().string());
}

}  // namespace

const std::vector<std::string>& rooms() {
    static const std::vector<std::string> names = {"lighting", "shaders", "formats", "compress", "fit", "verify", "pipeline"};
    return names;
}

std::vector<Violation> checkIncludes(const std::filesystem::path& file, std::string_view text) {
    const std::string room = file.begin()->string();
    std::vector<Violation> violations;
    forEachInclude(text, [&](int lineNumber, const Include& include) {
        if (const auto why = objection(room, include.name, include.quoted))
            violations.push_back(
                {file.generic_string() + ":" + std::to_string(lineNumber), room + " may not include " + include.name + ": " + *why});
    });
    return violations;
}

std::vector<std::string> quotedIncludes(std::string_view text) {
    std::vector<std::string> names;
    forEachInclude(text, [&](int, const Include& include) {
        if (include.quoted) names.push_back(include.name);
    });
    return names;
}

TreeCheck checkTree(const std::filesystem::path& tree) {
    TreeCheck check;
    for (const std::string& room : rooms()) {
        if (!std::filesystem::is_directory(tree / room)) continue;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(tree / room)) {
            if (entry.is_regular_file() && isSource(entry.path())) check.read.push_back(entry.path().lexically_relative(tree));
        }
    }
    std::sort(check.read.begin(), check.read.end());
    for (const std::filesystem::path& file : check.read) {
        const std::vector<Violation> found = checkIncludes(file, formats::contentOf(tree / file));
        check.violations.insert(check.violations.end(), found.begin(), found.end());
    }
    return check;
}

}  // namespace lightcook::architecture
