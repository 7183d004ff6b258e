// Parsers of ours as targets of a fuzzer: each takes any bytes and reads all that they claim to hold. A result or an error is right; a
// crash, a hang, memory beyond the input's own size by far, or a broken promise (require) is not.
//
// A module has one table, tests/MODULE/fuzz/targets.cpp, and inputs for each target in tests/MODULE/fuzz/corpus/TARGET. Two programs use
// them: MODULE_fuzz_tests (replay_test.cpp) takes the inputs again in every build, and MODULE_fuzz (fuzz_main.cpp, preset `fuzz`) looks for
// new ones with Clang's libFuzzer, helped by the words in tests/MODULE/fuzz/words/TARGET if there are any. OpenEXR, OpenImageIO,
// OpenColorIO and Draco are other people's code and no targets.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "tests/formats/temporary_folder.h"

namespace lightcook::fuzz {

using Bytes = std::span<const std::byte>;

struct Target {
    std::string_view name;  ///< also of the folder of its corpus
    void (*take)(Bytes bytes);
};

/// Returns the targets of this program.
std::span<const Target> targets();

/// Throws if a target finds that a promise of the code does not hold.
inline void require(bool holds, const char* promise) {
    if (!holds) throw std::logic_error(promise);
}

inline std::string textOf(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Returns the folder in which targets write.
inline const formats::TemporaryFolder& inputFolder() {
    static const formats::TemporaryFolder folder;
    return folder;
}

/// Writes the bytes to a file of this name, and returns its path.
inline std::filesystem::path asFile(std::string_view name, Bytes bytes) {
    std::filesystem::path file = inputFolder() / std::string(name);
    formats::writeContent(file, textOf(bytes));
    return file;
}

}  // namespace lightcook::fuzz
