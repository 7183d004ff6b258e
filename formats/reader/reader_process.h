// A file that a child process decodes: the wall between this process and libraries that parse what others made.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

#include "formats/error.h"
#include "formats/file/descriptor.h"
#include "formats/reader/frames.h"
#include "formats/reader/wire.h"

namespace lightcook::formats {

/// Bytes that are asked of a reader at once, more or less: the memory that it shares with this process.
inline constexpr std::size_t kPieceBytes = std::size_t{4} << 20;

/// Returns true after readInChildProcesses() (foreign_files.h).
bool areReadersChildren();

/// Opens a regular file. `expected` ends the error: "an image".
Result<Descriptor> openForeignFile(const std::filesystem::path& file, const char* expected);

/// Returns bytes as a file in memory; one that is not open, with the cause in errno.
Descriptor makeMemoryFile(std::span<const std::byte> bytes);

/// A reader, which has one file. One thread at a time. Its answers are bytes that a hostile file may have chosen: check them.
class ReaderProcess {
public:
    /// Starts a reader.
    /// file  its descriptor, which the reader reads at any place
    /// path  of the file, for errors
    static Result<ReaderProcess> start(ForeignKind kind, int file, const std::filesystem::path& path);
    ReaderProcess(ReaderProcess&&) noexcept;
    ReaderProcess& operator=(ReaderProcess&&) noexcept;
    ~ReaderProcess();

    /// Opens the file. Returns its description.
    Result<std::unique_ptr<WireReader>> open(const WireWriter& arguments);
    /// Reads so many bytes, which are valid until the next call.
    Result<std::span<const std::byte>> read(const WireWriter& arguments, std::size_t bytes);
    /// Returns the error of an answer that no reader gives.
    tl::unexpected<Error> senseless() const;

private:
    struct State;
    explicit ReaderProcess(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace lightcook::formats
