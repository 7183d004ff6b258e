#include "formats/bakes/file_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <system_error>
#include <utility>

namespace lightcook::formats {

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
        if (each == file || std::filesystem::exists(each, code)) continue;
        for (const char* extension : {".exr", ".hdr", ".tga", ".png"}) {
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
                     std::string_view format) {
    std::vector<std::string> missing;
    for (const std::filesystem::path& each : files) {
        std::error_code code;
        if (each != file && !std::filesystem::exists(each, code)) missing.push_back(each.filename().string());
    }
    const int present = static_cast<int>(files.size() - missing.size()), count = static_cast<int>(files.size());
    if (missing.empty())
        return {BakeMatch::Kind::Certain, numberCount,
                fmt::format("the {} files {} to {}", count, files.front().filename().string(), files.back().filename().string())};
    // A file on its own may have that ending by chance.
    const std::string others = missing.size() == 1 ? " is missing" : fmt::format(" and {} more are missing", missing.size() - 1);
    return {BakeMatch::Kind::Partial, present == 1 ? 0 : numberCount * present / count,
            fmt::format("found {} of the {} files of bake format {}, {}{}, expected it in the same folder", present, count, format,
                        missing.front(), others)};
}

}  // namespace lightcook::formats
