#include "formats/bakes/file_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <system_error>
#include <utility>

#include "formats/lower_extension.h"

namespace lightcook::formats {
namespace {

constexpr std::array<std::string_view, 4> kMixedExtensions = {".exr", ".hdr", ".tga", ".png"};

/// Returns the name of a file that does not exist, with the extensions that were looked for: "room_L1x (.exr, .hdr, .tga or .png)".
std::string nameOfMissing(const std::filesystem::path& file, FileKinds kinds) {
    if (kinds == FileKinds::Same) return file.filename().string();
    const std::string own = file.extension().string();
    const bool isOther = std::ranges::find(kMixedExtensions, lowerExtension(file)) == kMixedExtensions.end();
    return fmt::format("{} ({}{} or {})", file.stem().string(), isOther ? own + ", " : "",
                       fmt::join(kMixedExtensions.begin(), kMixedExtensions.end() - 1, ", "), kMixedExtensions.back());
}

std::string changed(std::string_view text, int (*change)(int)) {
    std::string out(text);
    std::ranges::transform(out, out.begin(), [&](unsigned char letter) { return static_cast<char>(change(letter)); });
    return out;
}
std::string inLowerCase(std::string_view text) {
    return changed(text, std::tolower);
}
std::string inCapitals(std::string_view text) {
    return changed(text, std::toupper);
}
/// "_Dir" of "_dir".
std::string withFirstCapital(std::string_view ending) {
    std::string out = inLowerCase(ending);
    const auto letter = std::ranges::find_if(out, [](unsigned char each) { return std::isalpha(each) != 0; });
    if (letter != out.end()) *letter = static_cast<char>(std::toupper(static_cast<unsigned char>(*letter)));
    return out;
}

/// Returns an ending in the case that another one is written in.
/// own    as in a name of a file
/// known  the same ending as its table has it
std::string spelledAs(std::string_view ending, std::string_view own, std::string_view known) {
    if (own == known) return std::string(ending);
    if (own == inCapitals(known)) return inCapitals(ending);
    return own == withFirstCapital(known) ? withFirstCapital(ending) : inLowerCase(ending);
}

/// Returns the member of a set that exists; else the name that it would have.
/// base        name without ending and extension
/// spelled     ending in the case of that of the named file
/// extensions  the first is that of the named file
std::filesystem::path memberOf(const std::filesystem::path& folder, const std::string& base, const std::string& spelled,
                               std::string_view ending, std::span<const std::string> extensions) {
    const std::array<std::string, 7> stems = {base + spelled,
                                              base + std::string(ending),
                                              base + withFirstCapital(ending),
                                              base + inCapitals(ending),
                                              base + inLowerCase(ending),
                                              inCapitals(base + spelled),
                                              inLowerCase(base + spelled)};
    for (const std::string& extension : extensions)
        for (const std::string& each : {extension, inLowerCase(extension), inCapitals(extension)})
            for (const std::string& stem : stems) {
                std::filesystem::path file = folder / (stem + each);
                std::error_code code;
                if (std::filesystem::exists(file, code)) return file;
            }
    return folder / (base + spelled + extensions.front());
}

/// Returns the files of the set that `file` belongs to.
/// others  extensions that a member may have beside that of `file`
std::vector<std::filesystem::path> filesWith(const std::filesystem::path& file, std::span<const std::string_view> endings,
                                             std::span<const std::string_view> others) {
    const std::string stem = file.stem().string();
    // The longest: an ending may be empty.
    std::optional<std::string_view> known;
    for (const std::string_view ending : endings)
        if (endsInAnyCase(stem, ending) && (!known || ending.size() > known->size())) known = ending;
    std::vector<std::filesystem::path> files;
    if (!known) return files;
    const std::string base = stem.substr(0, stem.size() - known->size()), own = stem.substr(base.size());
    std::vector<std::string> extensions = {file.extension().string()};
    extensions.insert(extensions.end(), others.begin(), others.end());
    std::error_code code;
    const bool exists = std::filesystem::exists(file, code);
    for (const std::string_view ending : endings)
        files.push_back(
            ending == *known && exists ? file : memberOf(file.parent_path(), base, spelledAs(ending, own, *known), ending, extensions));
    return files;
}

}  // namespace

bool endsInAnyCase(std::string_view text, std::string_view ending) {
    return text.size() >= ending.size() && inLowerCase(text.substr(text.size() - ending.size())) == inLowerCase(ending);
}

std::vector<std::filesystem::path> filesOfSet(const std::filesystem::path& file, std::span<const std::string_view> endings) {
    return filesWith(file, endings, {});
}

std::vector<std::filesystem::path> filesOfMixedSet(const std::filesystem::path& file, std::span<const std::string_view> endings) {
    return filesWith(file, endings, kMixedExtensions);
}

BakeMatch matchFiles(const std::filesystem::path& file, std::span<const std::filesystem::path> files, int numberCount,
                     std::string_view format, FileKinds kinds) {
    std::vector<std::string> missing;
    for (const std::filesystem::path& each : files) {
        std::error_code code;
        if (each != file && !std::filesystem::exists(each, code)) missing.push_back(nameOfMissing(each, kinds));
    }
    const int present = static_cast<int>(files.size() - missing.size()), count = static_cast<int>(files.size());
    if (missing.empty())
        return {BakeMatch::Kind::Certain, numberCount,
                fmt::format("the {} files {} to {}", count, files.front().filename().string(), files.back().filename().string())};
    // A file on its own may have that ending by chance.
    const std::string others = missing.size() == 1 ? " is missing" : fmt::format(" and {} more are missing", missing.size() - 1);
    return {BakeMatch::Kind::Partial, present == 1 ? 0 : numberCount * present / count,
            fmt::format("found {} of the {} files of bake format {}, {}{}, expected {} in the same folder", present, count, format,
                        missing.front(), others, missing.size() == 1 ? "it" : "them"),
            count - present};
}

BakeMatch matchWithDirections(const std::filesystem::path& file, std::span<const std::filesystem::path> files, int numberCount,
                              std::string_view format) {
    BakeMatch match = matchFiles(file, files, numberCount, format, FileKinds::Mixed);
    if (match.kind == BakeMatch::Kind::Partial && file == files.front()) match.kind = BakeMatch::Kind::None;
    return match;
}

}  // namespace lightcook::formats
