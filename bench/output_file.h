// Writes the files of the benchmarks.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "pipeline/graph/files.h"

namespace lightcook::bench {

/// Writes a file. Throws std::runtime_error, which names the file, if it cannot be written.
inline void writeOutput(const std::filesystem::path& file, const std::string& content) {
    if (const auto written = pipeline::writeFile(file, content); !written) throw std::runtime_error(written.error().line());
}

}  // namespace lightcook::bench
