// The program, a server of readers and a reader send each other the messages that this file lists, through a socket.
//
// The program starts a server (lightcook-read), once for each ReaderFamily. For every file that is opened, the server forks a reader, and
// the program talks to that reader alone: it sends Open and Read, one at a time, and gets an Answer, a Failure or OutOfMemory, with any
// number of Progress before it. Texels come through the window, a memfd that the program made and whose size is sealed.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "formats/file/descriptor.h"

namespace lightcook::formats {

/// Kinds of files that readers decode. Each kind has a decoder (ForeignDecoder).
enum class ForeignKind : std::uint8_t { Exr, Image, DracoMesh, DracoLattices };
inline constexpr std::size_t kForeignKinds = 4;

/// Readers that one server forks: those of images carry the 250 libraries of OpenImageIO along.
enum class ReaderFamily : std::uint8_t { Files, Images };
constexpr ReaderFamily familyOf(ForeignKind kind) {
    return kind == ForeignKind::Image ? ReaderFamily::Images : ReaderFamily::Files;
}
constexpr std::array<std::string_view, 2> kFamilyNames = {"files", "images"};  ///< the argument of lightcook-read

enum class FrameType : std::uint8_t {
    Hello,        ///< server: its version
    Start,        ///< to the server: kind, memory, path; descriptors of the reader's socket and of the file. It answers with the process
    Release,      ///< to the server: a process that is no longer needed
    GetStatus,    ///< to the server: a process, which it ends. It answers with the status that waitpid(2) gave
    Open,         ///< to a reader: arguments of the decoder. Its Answer begins with the walls that are up
    Window,       ///< to a reader: bytes, and the descriptor of a window in place of the one before. No answer
    Read,         ///< to a reader: arguments of the decoder, which fills the window
    Answer,       ///< that it was done; of Open the description of the file
    Failure,      ///< an Error
    OutOfMemory,  ///< the reader has reached its limit and ends
    Progress      ///< the reader is still at it
};

/// The socket that a server finds open, and those that a reader does.
inline constexpr int kServerSocket = 3, kReaderSocket = 4, kReaderFile = 5;
inline constexpr std::size_t kLongestFrame = std::size_t{4} << 20;  ///< [bytes]; 1024 channels have names of 255

struct Frame {
    FrameType type = FrameType::Failure;
    std::vector<std::byte> content;
    std::vector<Descriptor> descriptors;
};

/// Sends a message, with up to two descriptors. Returns false if nobody reads.
bool sendFrame(int socket, FrameType type, std::span<const std::byte> content, std::span<const int> descriptors = {});

/// Receives a message of at most kLongestFrame. Nothing: the other side has ended, sent what is none, or `onTick` returned false.
/// onTick   called each `tickMs` without a byte; empty: waits for ever
std::optional<Frame> receiveFrame(int socket, int tickMs = -1, const std::function<bool()>& onTick = {});

}  // namespace lightcook::formats
