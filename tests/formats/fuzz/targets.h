// Parsers of formats that are ours, as targets of a fuzzer: each takes the bytes of a file, whatever they are, and reads all that the file
// claims to hold. A result or an error is right; a crash, a hang, or memory beyond the file's own size by far is not.
//
// Two programs use them: replay_test.cpp reads the corpora again in every build, and Clang's libFuzzer looks for new inputs
// (fuzz_main.cpp, preset `fuzz`). OpenEXR, OpenImageIO, OpenColorIO and Draco are other people's code and no targets.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace lightcook::formats {

struct FuzzTarget {
    std::string_view name;       ///< also of the folder of its corpus
    std::string_view extension;  ///< of the file
    void (*read)(const std::filesystem::path& file);
};

std::span<const FuzzTarget> fuzzTargets();

/// Writes the bytes to a file of the extension, and lets the target read it.
void readAsFile(const FuzzTarget& target, std::span<const std::byte> bytes);

}  // namespace lightcook::formats
