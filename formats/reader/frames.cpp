#include "formats/reader/frames.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>

#include "formats/system_calls.h"

namespace lightcook::formats {
namespace {

constexpr std::size_t kMostDescriptors = 2;

constexpr std::size_t kHeadBytes = sizeof(std::uint32_t) + sizeof(FrameType);  // bytes of the content, and the type

/// Place for the descriptors of one message.
union Control {
    char bytes[CMSG_SPACE(sizeof(int) * kMostDescriptors)];
    cmsghdr alignment;
};

/// Receives what has come, at most out.size() bytes, and keeps descriptors that come along. Returns what recvmsg(2) does.
ssize_t receiveSome(int socket, std::span<std::byte> out, std::vector<Descriptor>& descriptors) {
    Control control;
    iovec piece{out.data(), out.size()};
    msghdr message{};
    message.msg_iov = &piece;
    message.msg_iovlen = 1;
    message.msg_control = control.bytes;
    message.msg_controllen = sizeof control.bytes;
    const ssize_t count = retried([&] { return ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC); });
    if (count < 0) return count;
    for (cmsghdr* each = CMSG_FIRSTHDR(&message); each != nullptr; each = CMSG_NXTHDR(&message, each)) {
        if (each->cmsg_level != SOL_SOCKET || each->cmsg_type != SCM_RIGHTS) continue;
        const std::size_t found = (each->cmsg_len - CMSG_LEN(0)) / sizeof(int);
        for (std::size_t i = 0; i < found; ++i) {
            int number = -1;
            std::memcpy(&number, CMSG_DATA(each) + i * sizeof number, sizeof number);
            descriptors.emplace_back(number);
        }
    }
    return count;
}

bool receiveAll(int socket, std::span<std::byte> out, std::vector<Descriptor>& descriptors, int tickMs,
                const std::function<bool()>& onTick) {
    while (!out.empty()) {
        pollfd wait{socket, POLLIN, 0};
        if (onTick && retried([&] { return ::poll(&wait, 1, tickMs); }) == 0) {
            if (!onTick()) return false;
            continue;
        }
        const ssize_t count = receiveSome(socket, out, descriptors);
        if (count <= 0) return false;
        out = out.subspan(static_cast<std::size_t>(count));
    }
    return true;
}

}  // namespace

bool sendFrame(int socket, FrameType type, std::span<const std::byte> content, std::span<const int> descriptors) {
    std::byte head[kHeadBytes];
    const auto bytes = static_cast<std::uint32_t>(content.size());
    std::memcpy(head, &bytes, sizeof bytes);
    head[sizeof bytes] = static_cast<std::byte>(type);
    Control control{};
    iovec pieces[] = {{head, sizeof head}, {const_cast<std::byte*>(content.data()), content.size()}};
    msghdr message{};
    message.msg_iov = pieces;
    message.msg_iovlen = 2;
    if (!descriptors.empty()) {
        message.msg_control = control.bytes;
        message.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
        cmsghdr* const rights = CMSG_FIRSTHDR(&message);
        rights->cmsg_level = SOL_SOCKET;
        rights->cmsg_type = SCM_RIGHTS;
        rights->cmsg_len = CMSG_LEN(descriptors.size_bytes());
        std::memcpy(CMSG_DATA(rights), descriptors.data(), descriptors.size_bytes());
    }
    for (std::size_t left = sizeof head + content.size();;) {
        const ssize_t count = retried([&] { return ::sendmsg(socket, &message, MSG_NOSIGNAL); });
        if (count <= 0) return false;
        left -= static_cast<std::size_t>(count);
        if (left == 0) return true;
        message.msg_control = nullptr;  // went with the first byte
        message.msg_controllen = 0;
        auto sent = static_cast<std::size_t>(count);
        for (iovec& piece : pieces) {
            const std::size_t part = std::min(sent, piece.iov_len);
            piece.iov_base = static_cast<std::byte*>(piece.iov_base) + part;
            piece.iov_len -= part;
            sent -= part;
        }
    }
}

std::optional<Frame> receiveFrame(int socket, int tickMs, const std::function<bool()>& onTick) {
    Frame frame;
    std::array<std::byte, kHeadBytes> head{};
    if (!receiveAll(socket, head, frame.descriptors, tickMs, onTick)) return std::nullopt;
    std::uint32_t bytes = 0;
    std::memcpy(&bytes, head.data(), sizeof bytes);
    frame.type = static_cast<FrameType>(head[sizeof bytes]);
    if (bytes > kLongestFrame) return std::nullopt;
    frame.content.resize(bytes);
    if (!receiveAll(socket, frame.content, frame.descriptors, tickMs, onTick)) return std::nullopt;
    return frame;
}

}  // namespace lightcook::formats
