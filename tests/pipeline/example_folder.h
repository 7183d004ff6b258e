// The folder of the example scene that ships in the repository.
#pragma once

#include <filesystem>

namespace lightcook::pipeline {

inline std::filesystem::path exampleFolder() {
    return std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "examples/cornell";
}

}  // namespace lightcook::pipeline
