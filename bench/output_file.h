// Writes the files of the benchmarks.
#pragma once

#include <filesystem>
#include <string>

#include "bench/or_throw.h"
#include "pipeline/graph/files.h"

namespace lightcook::bench {

/// Writes a file. Throws std::runtime_error, which names the file, if it cannot be written.
inline void writeOutput(const std::filesystem::path& file, const std::string& content) {
    orThrow(pipeline::writeFile(file, content));
}

}  // namespace lightcook::bench
