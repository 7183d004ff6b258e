#include "pipeline/document/written_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <system_error>

namespace lightcook::pipeline {

std::string faultOfHome(const std::string& path) {
    if (path != "~" && !path.starts_with("~/")) return "";
    const char* const home = std::getenv("HOME");
    return fmt::format(
        "found '~' in the path '{}', which only a shell expands, expected the folder itself: {}{}; a folder of that name is ./~", path,
        home != nullptr && *home != 0 ? home : "/home/NAME", path.substr(1));
}

std::string faultOfInput(const std::string& path, const std::filesystem::path& file) {
    if (std::string fault = faultOfHome(path); !fault.empty()) return fault;
    std::error_code code;
    if (path.find('\\') == std::string::npos || std::filesystem::exists(file, code)) return "";
    std::string plain = path;
    std::ranges::replace(plain, '\\', '/');
    return fmt::format("found '\\' in the path '{}', expected '/' between folders: {}", path, plain);
}

}  // namespace lightcook::pipeline
