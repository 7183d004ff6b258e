// The other side of the wall: the program lightcook-read, which decodes files for lightcook (reader_process.h) and can do nothing else.
//
// A server opens no file. It waits for requests, forks a reader for each file, and tells how a reader ended. A fork takes a fraction of
// the time in which a program starts, and no file meets a process that another one had. A reader has the file, the socket and the window;
// it puts up its walls (walls.h) before it looks at the file, and ends when the program closes the socket or ends itself, however.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <span>

#include "formats/error.h"
#include "formats/reader/frames.h"
#include "formats/reader/wire.h"

namespace lightcook::formats {

/// The file that a reader decodes.
struct ForeignInput {
    int descriptor = -1;
    std::filesystem::path path;  ///< as errors name it; nothing can be opened by it
};

/// Decodes one file.
class ForeignDecoder {
public:
    virtual ~ForeignDecoder() = default;
    /// Reads the arguments, opens the file, and describes it.
    virtual Result<void> open(WireReader& arguments, WireWriter& description) = 0;
    /// Fills `out` with what the arguments ask for.
    virtual Result<void> read(WireReader& arguments, std::span<std::byte> out) = 0;
};

/// The decoders of a reader program.
struct ReaderProgram {
    using Make = std::unique_ptr<ForeignDecoder> (*)(const ForeignInput& input);
    std::array<Make, kForeignKinds> decoders;
    /// Called in a server before it forks, to load what all of its readers need.
    Result<void> (*prepare)(ReaderFamily family);
    /// Called in a reader of images before its walls stand.
    void (*beforeWalls)(const ForeignInput& input);
};

/// Tells the program that the reader is still at work, at most twice a second.
void reportProgress();

/// Runs a server until the program ends. Returns the exit code of lightcook-read.
int serveReaders(ReaderFamily family, const ReaderProgram& program);

}  // namespace lightcook::formats
