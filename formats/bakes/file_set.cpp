#include "formats/bakes/file_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <system_error>
#include <utility>

namespace lightcook::formats {
namespace {

constexpr std::array<std::string_view, 4> kMixedExtensions = {".exr", ".hdr", ".tga", ".png"};

/// Returns the name of a file that does not exist, with the extensions that were looked for: "room_L1x (.exr, .hdr, .tga or .png)".
std::string nameOfMissing(const std::filesystem::path& file, FileKinds kinds) {
    if (kinds == FileKinds::Same) return file.filename().string();
    const std::string own = file.extension().string();
    const bool isOther = std::ranges::find(kMixedExtensions, own) == kMixedExtensions.end();
    return fmt::format("{} ({}{} or {})", file.stem().string(), isOther ? own + ", " : "",
                       fmt::join(kMixedExtensions.begin(), kMixedExtensions.end() - 1, ", "), kMixedExtensions.back());
}

}  // namespace

std::vector<std::filesystem::path> filesOfSet(const std::filesystem::path& file, std::span<const std::string_view> endings) {
    const std::string stem = file.stem().string();
    // The longest: an ending may be empty.
    std::optional<std::string_view> own;
    for (const std::string_view ending : endings)
        if (stem.ends_with(ending) && (!own || ending.size() > own->size())) own = ending;
    std::vector<std::filesystem::path> files;
    if (!own) return files;
    for (const std::string_view ending : endings)
        files.push_back(file.parent_path() /
                        fmt::format("{}{}{}", stem.substr(0, stem.size() - own->size()), ending, file.extension().string()));
    return files;
}

std::vector<std::filesystem::path> filesOfMixedSet(const std::filesystem::path& file, std::span<const std::string_view> endings) {
    std::vector<std::filesystem::path> files = filesOfSet(file, endings);
    for (std::filesystem::path& each : files) {
        std::error_code code;
        if (std::filesystem::exists(each, code)) continue;
        for (const std::string_view extension : kMixedExtensions) {
            std::filesystem::path other = each;
            other.replace_extension(extension);
            if (!std::filesystem::exists(other, code)) continue;
            each = std::move(other);
            break;
        }
    }
    return files;
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

}  // namespace lightcook::formats
