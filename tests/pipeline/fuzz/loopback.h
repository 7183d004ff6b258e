// Sockets of fuzzers on loopback: one end is the code under test, the other sends the bytes of the fuzzer.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

namespace lightcook::fuzz {

/// A socket that this process uses as a plain one.
class Socket {
public:
    explicit Socket(int descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) : descriptor_(descriptor) {}
    ~Socket() { ::close(descriptor_); }
    Socket(const Socket&) = delete;
    Socket& operator=(const Socket&) = delete;

    static sockaddr_in loopback(int port) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(port));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        return address;
    }
    /// Returns the port that it listens at.
    int listen() const {
        sockaddr_in address = loopback(0);
        socklen_t size = sizeof address;
        if (::bind(descriptor_, reinterpret_cast<const sockaddr*>(&address), size) != 0 || ::listen(descriptor_, 64) != 0 ||
            ::getsockname(descriptor_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
            throw std::runtime_error("no port on loopback");
        return ntohs(address.sin_port);
    }
    int accept() const { return ::accept4(descriptor_, nullptr, nullptr, SOCK_CLOEXEC); }
    void connect(int port) const {
        const sockaddr_in address = loopback(port);
        if (::connect(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
            throw std::runtime_error("no connection on loopback");
    }
    /// Sends the bytes. The other end may have closed.
    void sendAll(std::string_view bytes) const {
        while (!bytes.empty()) {
            const ssize_t sent = ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
            if (sent <= 0) break;
            bytes.remove_prefix(static_cast<std::size_t>(sent));
        }
    }
    void sendNoMore() const { ::shutdown(descriptor_, SHUT_WR); }
    /// Lets receiving end after so long, less than a second, without a byte.
    void limitSilence(std::chrono::microseconds limit) const {
        const timeval most{0, static_cast<suseconds_t>(limit.count())};
        ::setsockopt(descriptor_, SOL_SOCKET, SO_RCVTIMEO, &most, sizeof most);
    }
    /// Returns what arrives until it ends so, or until nothing more comes.
    std::string receiveUntil(std::string_view ending) const {
        std::string received;
        std::array<char, 1 << 14> piece;
        while (ending.empty() || received.find(ending) == std::string::npos) {
            const ssize_t count = ::recv(descriptor_, piece.data(), piece.size(), 0);
            if (count <= 0) break;
            received.append(piece.data(), static_cast<std::size_t>(count));
        }
        return received;
    }
    std::string receiveAll() const { return receiveUntil(""); }
    /// Wakes a thread that waits in accept().
    void stop() const { ::shutdown(descriptor_, SHUT_RDWR); }

private:
    int descriptor_;
};

/// A server that answers every request with the same bytes and closes.
class AnsweringServer {
public:
    AnsweringServer() : port_(listener_.listen()), thread_([this] { serve(); }) {}
    ~AnsweringServer() {
        listener_.stop();
        thread_.join();
    }
    AnsweringServer(const AnsweringServer&) = delete;
    AnsweringServer& operator=(const AnsweringServer&) = delete;

    int port() const { return port_; }
    void setAnswer(std::string answer) {
        const std::lock_guard lock(mutex_);
        answer_ = std::move(answer);
    }

private:
    void serve() {
        for (int descriptor = listener_.accept(); descriptor >= 0; descriptor = listener_.accept()) {
            const Socket connection(descriptor);
            if (connection.receiveUntil("\r\n\r\n").empty()) continue;
            {
                const std::lock_guard lock(mutex_);
                connection.sendAll(answer_);
                connection.sendNoMore();
            }
            connection.receiveAll();  // else the kernel may drop what was sent
        }
    }

    Socket listener_;
    int port_;
    std::mutex mutex_;
    std::string answer_;
    std::thread thread_;
};

}  // namespace lightcook::fuzz
