#include "pipeline/graph/file_list.h"

#include "pipeline/document/json.h"
#include "pipeline/graph/files.h"

namespace lightcook::pipeline {
namespace {

/// Returns true for a path that stays inside the folder that it is relative to.
bool isPlainName(const std::filesystem::path& name) {
    return !name.empty() && name.is_relative() && name == name.lexically_normal() && name.has_filename() && *name.begin() != "..";
}

}  // namespace

std::string listText(const FileNames& names) {
    return Json(names).dump(1) + "\n";
}

std::optional<FileNames> readFileList(const std::filesystem::path& list) {
    const auto text = readFile(list);
    if (!text) return std::nullopt;
    const Json json = parseJson(*text);
    if (!json.is_array()) return std::nullopt;
    FileNames names;
    for (const Json& name : json) {
        if (!name.is_string() || !isPlainName(name.get<std::string>())) return std::nullopt;
        names.insert(name.get<std::string>());
    }
    return names;
}

}  // namespace lightcook::pipeline
