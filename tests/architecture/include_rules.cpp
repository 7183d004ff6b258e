#include "tests/architecture/include_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "tests/formats/temporary_folder.h"

namespace lightcook::architecture {
namespace {

using Modules = std::set<std::string>;

const std::map<std::string, Modules> kBelow = {
    {"lighting", {}},
    {"shaders", {}},
    {"formats", {"lighting"}},
    {"atlas", {"formats", "lighting"}},
    {"compress", {"formats", "lighting"}},
    {"fit", {"formats", "lighting"}},
    {"verify", {"formats", "lighting", "shaders"}},
    {"pipeline", {"atlas", "compress", "fit", "verify", "formats", "lighting", "shaders"}},
};

/// Folders of pipeline in their order: each includes only those of rows before its own, and itself.
const std::vector<std::vector<std::string>> kPipelineOrder = {
    {"document"}, {"graph"}, {"limits"},           {"scene"},  {"assets"}, {"repack", "lint", "draft"}, {"manifest"},
    {"report"},   {"cook"},  {"view", "estimate"}, {"command"}};

/// Includes of a module's subfolders from outside the module that are allowed. A row that no file needs any more fails a test.
const std::vector<IncludeException> kExceptions = {
    {"tests/end_to_end/", "pipeline/", "end-to-end tests are tests of pipeline: they cook in this process and open what was written"},
    {"tests/samplers/", "pipeline/", "cooks the small scene of tests/pipeline in this process to sample it on real devices"},
    {"tests/samplers/", "verify/light_map/layouts.h", "needs the sample positions and decoders of the verifier, texel by texel"},
    {"tests/pipeline/assets/mesh/", "formats/image/exr_file.h", "writes a bake with coverage; LightMapWriter writes coefficients only"},
    {"tests/pipeline/cook/", "formats/image/exr_file.h", "writes a bake with coverage; LightMapWriter writes coefficients only"},
    {"tests/pipeline/lint/", "formats/image/exr_file.h", "plants faults in single channels of a bake"},
    {"tests/pipeline/command/", "formats/image/exr_file.h", "writes a bake that lacks a channel; LightMapWriter writes whole ones"},
    {"tests/verify/", "compress/block/decode.h", "compares the verifier's decoders with the encoders' own, which are written apart"},
    {"bench/", "pipeline/", "cooks single assets in this process; pipeline is a program and has no public headers"},
    {"bench/", "compress/texel/half.h", "rounds test pictures to halves as the encoders do"},
    {"bench/", "formats/image/exr_file.h", "writes copies of a bake with all its channels; LightMapWriter writes whole images"},
    {"bench/", "fit/cubemap/gauss_legendre.h", "integrates the reference of a fit with the points of the fit itself"},
};

/// Headers at the root of a module that nothing in this repository includes from outside the module.
const std::map<std::string, std::string> kUnusedRootHeaders = {};

struct Library {
    std::string prefix;  // of the included name; ends in '/' for a folder of headers
    Modules homes;       // empty: everywhere
};

// The modules that may include a library. A library that is missing here is refused everywhere.
const std::vector<Library> kLibraries = {
    {"OpenImageIO/", {"formats"}},
    {"OpenEXR/", {"formats"}},
    {"Imath/", {"formats"}},
    {"png.h", {"formats"}},
    {"OpenColorIO/", {"formats"}},
    {"draco/", {"formats"}},
    {"zstd.h", {"formats"}},
    {"ceres/", {"fit"}},
    {"Eigen/", {"compress", "fit"}},
    {"hwy/", {"compress"}},
    {"astcenc.h", {"compress"}},
    {"tbb/", {"pipeline"}},
    {"oneapi/", {"pipeline"}},
    {"toml++/", {"pipeline"}},
    {"CLI/", {"pipeline"}},
    {"httplib.h", {"pipeline"}},
    {"openssl/", {"pipeline"}},
    {"xxhash.h", {"formats"}},
    {"nlohmann/", {"formats", "pipeline"}},
    {"tl/", {"formats", "atlas", "compress", "fit", "verify", "pipeline"}},
    {"fmt/", {}},
    {"glm/", {}},
    // Headers of the system: only some modules use files and threads. A mutex is allowed everywhere, for readers that threads share.
    {"sys/", {"formats", "pipeline"}},
    {"linux/", {"formats"}},
    {"cxxabi.h", {"pipeline"}},
    {"dirent.h", {"formats"}},
    {"dlfcn.h", {"formats"}},
    {"fcntl.h", {"formats", "pipeline"}},
    {"glob.h", {"pipeline"}},
    {"netdb.h", {"pipeline"}},
    {"netinet/", {"pipeline"}},
    {"poll.h", {"formats", "pipeline"}},
    {"pthread.h", {"pipeline"}},
    {"sched.h", {"formats"}},
    {"semaphore.h", {"pipeline"}},
    {"signal.h", {"pipeline"}},
    {"spawn.h", {"formats"}},
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

std::string joined(const Modules& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
}

/// Returns the module of a path such as "compress/bc6h/encode.h"; empty if its first folder is none.
std::string moduleOf(const std::string& name) {
    const std::string first = name.substr(0, name.find('/'));
    return name.find('/') != std::string::npos && kBelow.contains(first) ? first : "";
}

/// True for "compress/encode.h", false for "compress/bc6h/encode.h".
bool isRootHeader(const std::string& name) {
    return std::count(name.begin(), name.end(), '/') == 1;
}

/// Returns the module whose subfolders a file may include: its own or, for a test, the one that it tests.
std::string homeOf(const std::string& file) {
    const std::string prefix = "tests/";
    return moduleOf(file.starts_with(prefix) ? file.substr(prefix.size()) : file);
}

/// Returns what is wrong with `file` including the subfolder header `name` of another module, if anything.
std::optional<std::string> objectionToSubfolder(const std::string& file, const std::string& name) {
    const std::string module = moduleOf(name);
    if (module.empty() || isRootHeader(name) || module == homeOf(file)) return std::nullopt;
    for (const IncludeException& row : kExceptions)
        if (file.starts_with(row.from) && name.starts_with(row.included)) return std::nullopt;
    return "only the headers at the root of " + module + " are public";
}

/// Returns the row of kPipelineOrder of a path such as "pipeline/cook/plan.h"; empty for a path elsewhere.
std::optional<std::size_t> rowInPipeline(const std::string& name) {
    const std::string prefix = "pipeline/";
    const std::size_t end = name.find('/', prefix.size());
    if (!name.starts_with(prefix) || end == std::string::npos) return std::nullopt;
    const std::string folder = name.substr(prefix.size(), end - prefix.size());
    for (std::size_t row = 0; row < kPipelineOrder.size(); ++row)
        if (std::ranges::find(kPipelineOrder[row], folder) != kPipelineOrder[row].end()) return row;
    return kPipelineOrder.size();  // a folder that the order lacks comes after all
}

/// Returns what is wrong with a file of pipeline including the header `name` of another of its folders, if anything.
std::optional<std::string> objectionToOrder(const std::string& file, const std::string& name) {
    const auto from = rowInPipeline(file), to = rowInPipeline(name);
    const auto folderOf = [](const std::string& path) { return path.substr(0, path.find('/', path.find('/') + 1)); };
    if (!from || !to || *to < *from || folderOf(file) == folderOf(name)) return std::nullopt;
    return "folder " + folderOf(name) + " does not come before " + folderOf(file);
}

/// Returns what is wrong with a file of `module` including `name`, if anything.
std::optional<std::string> objectionToLayer(const std::string& module, const std::string& name, bool quoted) {
    const std::string first = moduleOf(name);
    if (!first.empty()) {
        if (first == module || kBelow.at(module).contains(first)) return std::nullopt;
        return "module " + first + " is not below " + module;
    }
    if (const Library* library = findLibrary(name)) {
        if (library->homes.empty() || library->homes.contains(module)) return std::nullopt;
        return "it lives in " + joined(library->homes);
    }
    if (!quoted && isStandard(name)) return std::nullopt;
    const bool hasFolder = name.find('/') != std::string::npos;
    // Shader sources are handed to engines as one folder, so they name each other without the module.
    if (quoted && !hasFolder && module == "shaders") return std::nullopt;
    return quoted && !hasFolder ? "ours are included as module/file.h" : "no module is its home";
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

const std::vector<std::string>& modules() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const auto& [module, below] : kBelow) all.push_back(module);
        return all;
    }();
    return names;
}

std::span<const IncludeException> includeExceptions() {
    return kExceptions;
}

std::vector<Violation> checkIncludes(const std::filesystem::path& file, std::string_view text) {
    const std::string first = file.begin()->string();
    const bool isModule = kBelow.contains(first);
    std::vector<Violation> violations;
    forEachInclude(text, [&](int lineNumber, const Include& include) {
        std::optional<std::string> why = isModule ? objectionToLayer(first, include.name, include.quoted) : std::nullopt;
        if (!why) why = objectionToSubfolder(file.generic_string(), include.name);
        if (!why) why = objectionToOrder(file.generic_string(), include.name);
        if (why)
            violations.push_back(
                {file.generic_string() + ":" + std::to_string(lineNumber),
                 (isModule ? first : file.parent_path().generic_string()) + " may not include " + include.name + ": " + *why});
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

namespace {

/// Returns the sources below a folder of the tree, relative to the tree, sorted.
std::vector<std::filesystem::path> sourcesBelow(const std::filesystem::path& tree, const std::string& folder) {
    std::vector<std::filesystem::path> files;
    if (!std::filesystem::is_directory(tree / folder)) return files;
    for (auto entry = std::filesystem::recursive_directory_iterator(tree / folder);
         entry != std::filesystem::recursive_directory_iterator(); ++entry) {
        if (entry->path().filename() == "node_modules") {
            entry.disable_recursion_pending();
        } else if (entry->is_regular_file() && isSource(entry->path())) {
            files.push_back(entry->path().lexically_relative(tree));
        }
    }
    std::sort(files.begin(), files.end());
    return files;
}

}  // namespace

TreeCheck checkTree(const std::filesystem::path& tree) {
    TreeCheck check;
    for (const std::string& module : modules()) {
        const auto files = sourcesBelow(tree, module);
        check.read.insert(check.read.end(), files.begin(), files.end());
    }
    std::sort(check.read.begin(), check.read.end());
    std::vector<std::filesystem::path> users = check.read;
    for (const char* folder : {"bench", "tests"}) {
        const auto files = sourcesBelow(tree, folder);
        users.insert(users.end(), files.begin(), files.end());
    }
    for (const std::filesystem::path& file : users) {
        const std::string text = formats::contentOf(tree / file);
        const std::vector<Violation> found = checkIncludes(file, text);
        check.violations.insert(check.violations.end(), found.begin(), found.end());
        for (const std::string& name : quotedIncludes(text)) check.includes.push_back({file.generic_string(), name});
    }
    return check;
}

std::vector<std::string> unusedExceptions(const TreeCheck& check) {
    std::vector<std::string> unused;
    for (const IncludeException& row : kExceptions) {
        const auto needsIt = [&](const UsedInclude& use) {
            return use.file.starts_with(row.from) && use.name.starts_with(row.included) && !isRootHeader(use.name);
        };
        if (std::none_of(check.includes.begin(), check.includes.end(), needsIt)) unused.push_back(row.from + " -> " + row.included);
    }
    return unused;
}

std::vector<std::string> rootViolations(const std::filesystem::path& tree, const TreeCheck& check) {
    std::set<std::string> usedOutside;
    for (const UsedInclude& use : check.includes)
        if (moduleOf(use.name) != homeOf(use.file)) usedOutside.insert(use.name);
    // A public header is public with the headers that it includes.
    for (bool isGrowing = true; isGrowing;) {
        isGrowing = false;
        for (const UsedInclude& use : check.includes)
            if (usedOutside.contains(use.file)) isGrowing |= usedOutside.insert(use.name).second;
    }
    std::vector<std::string> violations;
    for (const std::string& module : modules()) {
        if (!std::filesystem::is_directory(tree / module)) continue;
        for (const auto& entry : std::filesystem::directory_iterator(tree / module)) {
            const std::filesystem::path name = entry.path().filename();
            const std::string file = module + "/" + name.string();
            if (!entry.is_regular_file() || name == "CMakeLists.txt") continue;
            if (module == "shaders" && (name.extension() == ".glsl" || name == "embed.cmake"))
                continue;  // the headers that engines include
            if (name.extension() != ".h") {
                violations.push_back(file + " is no header: move it into a subfolder");
            } else if (!usedOutside.contains(file) && !kUnusedRootHeaders.contains(file)) {
                violations.push_back(fmt::format("{} is included by nobody outside {}: move it into a subfolder", file, module));
            }
        }
    }
    std::sort(violations.begin(), violations.end());
    return violations;
}

}  // namespace lightcook::architecture
