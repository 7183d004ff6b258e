// A server of a shared cache on loopback, in this process, with the faults that servers have.
#pragma once

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

namespace lightcook::pipeline {

/// Ways in which a server answers.
enum class ServerFault {
    None,
    Silent,       ///< never answers
    Slow,         ///< answers after CacheServer::delay
    HangsInBody,  ///< sends half a body, then nothing
    TornBody,     ///< sends half a body, then closes
    OtherBody,    ///< as long as the right one
    ShortBody,    ///< states a length that is one byte less
    LongBody,     ///< sends one byte more, and states so
    HugeBody,     ///< 10 GiB
    HugeChunks,   ///< the same without stating it
    Empty,        ///< no bytes, status 200
    Redirects,    ///< to another place of the server, where everything is
    NotHttp,
    LongHead,  ///< of 1 GiB
    Missing,   ///< 404
    Refuses,   ///< 403
    Closes,    ///< without an answer
};

class CacheServer {
public:
    using FaultOf = std::function<ServerFault(const std::string& method, const std::string& path)>;

    /// tls   null: plain HTTP
    explicit CacheServer(SSL_CTX* tls = nullptr) : tls_(tls) {
        listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        std::ignore = ::bind(listener_, reinterpret_cast<const sockaddr*>(&address), size);
        ::listen(listener_, 64);
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
        port_ = ntohs(address.sin_port);
        acceptor_ = std::thread([this] { accept(); });
    }
    ~CacheServer() {
        isEnding_ = true;
        acceptor_.join();
        for (std::thread& thread : threads_) thread.join();
        ::close(listener_);
    }
    CacheServer(const CacheServer&) = delete;
    CacheServer& operator=(const CacheServer&) = delete;

    std::string url() const { return fmt::format("{}://127.0.0.1:{}/cache", tls_ == nullptr ? "http" : "https", port_); }
    void setFault(FaultOf fault) {
        const std::lock_guard lock(mutex_);
        faultOf_ = std::move(fault);
    }
    /// The same fault for every request of a method below a folder: "GET", "ac".
    void setFault(ServerFault fault, const std::string& method, const std::string& folder) {
        setFault([=](const std::string& of, const std::string& path) {
            return of == method && path.starts_with("/cache/" + folder) ? fault : ServerFault::None;
        });
    }
    /// Returns "PUT /cache/ac/..." for each request, in their order.
    std::vector<std::string> requests() const {
        const std::lock_guard lock(mutex_);
        return requests_;
    }
    /// Returns the head of the last request.
    std::string lastHead() const {
        const std::lock_guard lock(mutex_);
        return lastHead_;
    }
    /// Changes what is stored, by path.
    void change(const std::function<void(std::map<std::string, std::string>&)>& edit) {
        const std::lock_guard lock(mutex_);
        edit(stored_);
    }
    std::size_t storedCount() const {
        const std::lock_guard lock(mutex_);
        return stored_.size();
    }
    int connectionCount() const { return connections_; }
    std::uint64_t sentBytes() const { return sent_; }

    std::chrono::milliseconds delay{0};
    bool isChunked = false;  ///< answers in chunks

private:
    struct Connection {
        int descriptor = -1;
        std::unique_ptr<SSL, void (*)(SSL*)> tls{nullptr, SSL_free};
        std::string received;
    };

    void accept() {
        while (!isEnding_) {
            pollfd polled{listener_, POLLIN, 0};
            if (::poll(&polled, 1, 5) <= 0) continue;
            const int descriptor = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
            ++connections_;
            threads_.emplace_back([this, descriptor] { serve(descriptor); });
        }
    }

    void serve(int descriptor) {
        Connection connection;
        connection.descriptor = descriptor;
        bool isOpen = true;
        if (tls_ != nullptr) {
            connection.tls.reset(SSL_new(tls_));
            SSL_set_fd(connection.tls.get(), descriptor);
            isOpen = SSL_accept(connection.tls.get()) == 1;
        }
        while (isOpen && answer(connection)) {
        }
        connection.tls.reset();
        ::close(descriptor);
    }

    bool receive(Connection& connection) {
        char piece[65536];
        while (connection.tls == nullptr || SSL_pending(connection.tls.get()) == 0) {
            pollfd polled{connection.descriptor, POLLIN, 0};
            if (isEnding_) return false;
            if (::poll(&polled, 1, 5) > 0) break;
        }
        const auto count = connection.tls != nullptr ? SSL_read(connection.tls.get(), piece, sizeof piece)
                                                     : ::recv(connection.descriptor, piece, sizeof piece, 0);
        if (count <= 0) return false;
        connection.received.append(piece, static_cast<std::size_t>(count));
        return true;
    }

    bool send(Connection& connection, const std::string& bytes) {
        for (std::size_t done = 0; done < bytes.size();) {
            if (isEnding_) return false;
            const auto count = connection.tls != nullptr
                                   ? SSL_write(connection.tls.get(), bytes.data() + done, static_cast<int>(bytes.size() - done))
                                   : ::send(connection.descriptor, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
            if (count <= 0) return false;
            done += static_cast<std::size_t>(count);
            sent_ += static_cast<std::uint64_t>(count);
        }
        return true;
    }

    /// Waits until the client or the test has enough.
    bool hang(Connection& connection, std::chrono::milliseconds most = std::chrono::hours(1)) {
        const auto end = std::chrono::steady_clock::now() + most;
        while (!isEnding_ && std::chrono::steady_clock::now() < end) {
            pollfd polled{connection.descriptor, POLLIN | POLLRDHUP, 0};
            if (::poll(&polled, 1, 2) > 0 && (polled.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0) return false;
        }
        return !isEnding_;
    }

    static std::string head(int status, std::uint64_t length) {
        return fmt::format("HTTP/1.1 {} Word\r\nContent-Length: {}\r\n\r\n", status, length);
    }

    bool answer(Connection& connection) {
        std::size_t end = std::string::npos;
        while ((end = connection.received.find("\r\n\r\n")) == std::string::npos)
            if (!receive(connection)) return false;
        const std::string request = connection.received.substr(0, end + 2);
        connection.received.erase(0, end + 4);
        const std::string method = request.substr(0, request.find(' '));
        const std::string path = request.substr(method.size() + 1, request.find(' ', method.size() + 1) - method.size() - 1);
        std::size_t length = 0;
        if (const std::size_t at = request.find("Content-Length: "); at != std::string::npos) length = std::stoull(request.substr(at + 16));
        while (connection.received.size() < length)
            if (!receive(connection)) return false;
        const std::string body = connection.received.substr(0, length);
        connection.received.erase(0, length);
        ServerFault fault = ServerFault::None;
        std::string content;
        bool isStored = false;
        {
            const std::lock_guard lock(mutex_);
            requests_.push_back(method + " " + path);
            lastHead_ = request;
            if (faultOf_) fault = faultOf_(method, path);
            if (method == "PUT" && fault == ServerFault::None) stored_[path] = body;
            const auto found = stored_.find(path);
            isStored = found != stored_.end();
            if (isStored) content = found->second;
        }
        if (method == "PUT" && fault == ServerFault::None) return send(connection, head(201, 0));
        return sendAnswer(connection, fault, method, path, isStored ? &content : nullptr);
    }

    bool sendAnswer(Connection& connection, ServerFault fault, const std::string& method, const std::string& path,
                    const std::string* content) {
        const std::string body = content == nullptr ? "nothing here" : *content;
        const int status = content == nullptr ? 404 : 200;
        switch (fault) {
            case ServerFault::Silent:
                return hang(connection);
            case ServerFault::HangsInBody:
                return send(connection, head(status, body.size()) + body.substr(0, body.size() / 2)) && hang(connection);
            case ServerFault::TornBody:
                send(connection, head(status, body.size()) + body.substr(0, body.size() / 2));
                return false;
            case ServerFault::OtherBody: {
                std::string other = body;
                other[other.size() / 2] = static_cast<char>(other[other.size() / 2] ^ 1);
                return send(connection, head(status, other.size()) + other);
            }
            case ServerFault::ShortBody:
                return send(connection, head(status, body.size() - 1) + body.substr(1));
            case ServerFault::LongBody:
                return send(connection, head(status, body.size() + 1) + body + "x");
            case ServerFault::HugeBody:
            case ServerFault::HugeChunks: {
                const std::string piece(1 << 20, 'x');
                bool isOpen = send(connection, fault == ServerFault::HugeBody ? head(200, std::uint64_t{10} << 30)
                                                                              : "HTTP/1.1 200 Word\r\nTransfer-Encoding: chunked\r\n\r\n");
                for (int i = 0; isOpen && i < 10 << 10; ++i)
                    isOpen = send(connection, fault == ServerFault::HugeBody ? piece : fmt::format("{:x}\r\n{}\r\n", piece.size(), piece));
                return false;
            }
            case ServerFault::Empty:
                return send(connection, head(200, 0));
            case ServerFault::Redirects:
                return send(connection, fmt::format("HTTP/1.1 302 Word\r\nLocation: {}\r\nContent-Length: 0\r\n\r\n", path + "/moved"));
            case ServerFault::NotHttp:
                send(connection, "220 mail.example.org ESMTP\r\n\r\n");
                return false;
            case ServerFault::LongHead: {
                bool isOpen = send(connection, "HTTP/1.1 200 ");
                for (int i = 0; isOpen && i < 1 << 10; ++i) isOpen = send(connection, std::string(1 << 20, 'x'));
                return false;
            }
            case ServerFault::Missing:
                return send(connection, head(404, 0));
            case ServerFault::Refuses:
                return send(connection, head(403, 0));
            case ServerFault::Closes:
                return false;
            case ServerFault::Slow:
                if (!hang(connection, delay)) return false;
                break;
            case ServerFault::None:
                break;
        }
        if (method == "HEAD") return send(connection, head(status, body.size()));
        if (!isChunked) return send(connection, head(status, body.size()) + body);
        std::string chunks = fmt::format("HTTP/1.1 {} Word\r\nTransfer-Encoding: chunked\r\n\r\n", status);
        for (std::size_t at = 0; at < body.size(); at += 7)
            chunks += fmt::format("{:X};name=value\r\n{}\r\n", std::min<std::size_t>(7, body.size() - at), body.substr(at, 7));
        return send(connection, chunks + "0\r\nTrailer: value\r\n\r\n");
    }

    SSL_CTX* tls_;
    int listener_ = -1;
    int port_ = 0;
    mutable std::mutex mutex_;
    FaultOf faultOf_;
    std::map<std::string, std::string> stored_;
    std::vector<std::string> requests_;
    std::string lastHead_;
    std::atomic<bool> isEnding_{false};
    std::atomic<int> connections_{0};
    std::atomic<std::uint64_t> sent_{0};
    std::list<std::thread> threads_;
    std::thread acceptor_;
};

}  // namespace lightcook::pipeline
