#include "pipeline/graph/http_client.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <future>
#include <istream>
#include <thread>
#include <vector>

#include "pipeline/graph/version.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;
using Clock = HttpConnection::Clock;

constexpr std::chrono::milliseconds kPoll{5};
constexpr std::uint64_t kMostHeadBytes = 32 << 10;
constexpr std::uint64_t kMostDroppedBytes = 64 << 10;  ///< body of an answer that is no success; a longer one ends the connection
/// A body may take kBase and a second for each kSlowest bytes of it.
constexpr std::chrono::seconds kBase{10};
constexpr std::uint64_t kSlowest = 64 << 10;

struct Address {
    sockaddr_storage bytes{};
    socklen_t size = 0;
};
using Addresses = std::vector<Address>;

Addresses lookUp(const std::string& host, const std::string& port, int flags) {
    addrinfo hints{}, *found = nullptr;
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = flags;
    Addresses addresses;
    if (::getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) return addresses;
    for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
        Address& address = addresses.emplace_back();
        std::memcpy(&address.bytes, each->ai_addr, each->ai_addrlen);
        address.size = each->ai_addrlen;
    }
    ::freeaddrinfo(found);
    return addresses;
}

/// Looks an address up in a thread of its own. Nothing can stop getaddrinfo(), so the thread is not waited for: it has nothing of ours.
std::shared_future<Addresses> startLookUp(const std::string& host, const std::string& port) {
    std::promise<Addresses> promise;
    std::shared_future<Addresses> addresses = promise.get_future().share();
    if (Addresses numeric = lookUp(host, port, AI_NUMERICHOST); !numeric.empty())
        promise.set_value(std::move(numeric));
    else
        std::thread([host, port, promise = std::move(promise)]() mutable { promise.set_value(lookUp(host, port, 0)); }).detach();
    return addresses;
}

std::string lower(std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(),
                   [](char c) { return 'A' <= c && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return result;
}

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t");
    return first == std::string_view::npos ? "" : text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::optional<std::uint64_t> numberOf(std::string_view text, int base = 10) {
    std::uint64_t value = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    return fault == std::errc() && end == text.data() + text.size() && !text.empty() ? std::optional(value) : std::nullopt;
}

/// Head of an answer.
struct Head {
    int status = 0;
    std::optional<std::uint64_t> length;
    bool isChunked = false, isLast = false;  ///< isLast: the server closes the connection
};
std::optional<Head> parseHead(std::string_view text) {
    Head head;
    const std::string_view line = text.substr(0, text.find("\r\n"));
    const auto status = line.size() >= 12 && line.starts_with("HTTP/1.") && line[8] == ' ' ? numberOf(line.substr(9, 3)) : std::nullopt;
    if (!status || *status < 100) return std::nullopt;
    head.status = static_cast<int>(*status);
    head.isLast = line[7] == '0';
    for (text.remove_prefix(std::min(text.size(), line.size() + 2)); !text.empty();) {
        const std::string_view field = text.substr(0, text.find("\r\n"));
        text.remove_prefix(std::min(text.size(), field.size() + 2));
        const std::size_t colon = field.find(':');
        if (colon == std::string_view::npos) return std::nullopt;
        const std::string name = lower(field.substr(0, colon)), value = lower(trimmed(field.substr(colon + 1)));
        if (name == "content-length") {
            const auto length = numberOf(value);
            if (!length || (head.length && head.length != length)) return std::nullopt;
            head.length = length;
        } else if (name == "transfer-encoding") {
            head.isChunked = true;
            if (value != "chunked") return std::nullopt;
        } else if (name == "connection" && value == "close") {
            head.isLast = true;
        }
    }
    return head;
}

}  // namespace

Result<HttpUrl> parseHttpUrl(const std::string& text) {
    const auto refuse = [](const std::string& found) {
        return failure(ErrorCode::InvalidRequest, "--remote-cache",
                       fmt::format("found {}, expected the address of a cache, such as https://cache.example.org/lightcook", found));
    };
    if (text.find('@') != std::string::npos)  // not shown: a log would have it
        return failure(
            ErrorCode::InvalidRequest, "--remote-cache",
            "found an address with credentials or an @, expected one without: credentials come from --remote-credentials FILE or "
            "$LIGHTCOOK_REMOTE_CREDENTIALS");
    HttpUrl url;
    url.isTls = text.starts_with("https://");
    if (!url.isTls && !text.starts_with("http://")) return refuse("'" + text + "'");
    const std::string rest = text.substr(url.isTls ? 8 : 7), authority = rest.substr(0, rest.find('/'));
    url.prefix = rest.substr(authority.size());
    while (url.prefix.ends_with('/')) url.prefix.pop_back();
    const bool isBracketed = authority.starts_with('[');
    const std::size_t hostEnd = isBracketed ? authority.find(']') : authority.find(':');
    url.host = isBracketed ? authority.substr(1, std::min(hostEnd, authority.size()) - 1) : authority.substr(0, hostEnd);
    const std::string after = hostEnd == std::string::npos ? "" : authority.substr(hostEnd + (isBracketed ? 1 : 0));
    url.port = after.empty() ? (url.isTls ? "443" : "80") : after.substr(1);
    const auto port = numberOf(url.port);
    const auto isPlain = [](char c) { return c > ' ' && c < 0x7f && c != '?' && c != '#'; };
    if (url.host.empty() || (isBracketed && hostEnd == std::string::npos) || (!after.empty() && after[0] != ':') || !port || *port == 0 ||
        *port > 65535 || !std::all_of(text.begin(), text.end(), isPlain))
        return refuse("'" + text + "'");
    return url;
}

std::string authorizationOf(const std::string& credentials) {
    if (credentials.find(':') == std::string::npos) return "Bearer " + credentials;
    std::string encoded(4 * ((credentials.size() + 2) / 3) + 1, '\0');
    encoded.resize(static_cast<std::size_t>(EVP_EncodeBlock(reinterpret_cast<unsigned char*>(encoded.data()),
                                                            reinterpret_cast<const unsigned char*>(credentials.data()),
                                                            static_cast<int>(credentials.size()))));
    return "Basic " + encoded;
}

struct HttpServer::Parts {
    HttpUrl url;
    std::string authorization;
    std::shared_future<Addresses> addresses;
    std::unique_ptr<SSL_CTX, void (*)(SSL_CTX*)> tls{nullptr, SSL_CTX_free};
};

HttpServer::HttpServer(const HttpUrl& url, std::string authorization)
    : parts_(new Parts{url, std::move(authorization), startLookUp(url.host, url.port)}) {
    if (!url.isTls) return;
    parts_->tls.reset(SSL_CTX_new(TLS_client_method()));
    SSL_CTX_set_min_proto_version(parts_->tls.get(), TLS1_2_VERSION);
    SSL_CTX_set_default_verify_paths(parts_->tls.get());
    SSL_CTX_set_verify(parts_->tls.get(), SSL_VERIFY_PEER, nullptr);
}
HttpServer::~HttpServer() = default;

/// The bytes on the way: a socket that never blocks, TLS over it if the server has it, and the rest of what was received.
class HttpConnection::Wire {
public:
    Wire(const HttpServer::Parts& server, std::function<bool()> isStopped, Clock::duration silence)
        : server_(server), isStopped_(std::move(isStopped)), silence_(silence) {}
    ~Wire() { close(); }

    struct Request {
        const char* method;
        const std::string& path;
        std::istream* body = nullptr;
        std::uint64_t bodyBytes = 0;
        std::uint64_t limitBytes = 0;
        const Sink* sink = nullptr;
    };

    HttpResult exchange(const Request& request) {
        deadline_ = Clock::now() + kBase + std::chrono::seconds((request.bodyBytes + request.limitBytes) / kSlowest);
        for (bool mayBeStale = descriptor_ >= 0;; mayBeStale = false) {
            failure_.clear();
            received_.clear();
            hasAnswered_ = isOver_ = false;
            std::optional<HttpAnswer> answer;
            if (descriptor_ >= 0 || connect()) {
                const bool isSent = send(request);
                answer = isOver_ ? std::nullopt : receive(request);  // a server may refuse a body before it has all of it
                if (!answer || !isSent) close();
            }
            if (answer) return *answer;
            close();
            // The server may have closed the connection since the last exchange.
            if (!mayBeStale || hasAnswered_ || isOver_) return tl::make_unexpected(failure_);
        }
    }

private:
    bool fail(std::string why) {
        if (failure_.empty()) failure_ = std::move(why);
        return false;
    }

    /// Returns false if the exchange has to end.
    bool mayGoOn() {
        if (isStopped_()) {
            isOver_ = true;
            return fail("stopped");
        }
        if (Clock::now() < deadline_) return true;
        isOver_ = true;
        return fail("no end of the answer in time");
    }

    /// Waits until the socket can be read or written.
    bool wait(short events) {
        const Clock::time_point silentAt = Clock::now() + silence_;
        while (mayGoOn()) {
            pollfd polled{descriptor_, events, 0};
            if (::poll(&polled, 1, static_cast<int>(kPoll.count())) > 0) return true;
            if (Clock::now() < silentAt) continue;
            isOver_ = true;
            return fail(fmt::format("no answer within {:.0f} s", std::chrono::duration<double>(silence_).count()));
        }
        return false;
    }

    bool connect() {
        while (server_.addresses.wait_for(kPoll) != std::future_status::ready)
            if (!mayGoOn()) return fail("no address");
        if (server_.addresses.get().empty()) return fail(fmt::format("no address of {}", server_.url.host));
        for (const Address& address : server_.addresses.get()) {
            descriptor_ = ::socket(address.bytes.ss_family, SOCK_STREAM, 0);
            ::fcntl(descriptor_, F_SETFD, FD_CLOEXEC);
            ::fcntl(descriptor_, F_SETFL, O_NONBLOCK);
            const int on = 1;
            ::setsockopt(descriptor_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
            int error = ::connect(descriptor_, reinterpret_cast<const sockaddr*>(&address.bytes), address.size) == 0 ? 0 : errno;
            if (error == EINPROGRESS && wait(POLLOUT)) {
                socklen_t size = sizeof error;
                ::getsockopt(descriptor_, SOL_SOCKET, SO_ERROR, &error, &size);
            }
            if (error == 0) {
                failure_.clear();
                return server_.tls == nullptr || startTls();
            }
            if (!isOver_) failure_ = lower(std::strerror(error));
            close();
            if (isOver_) break;
        }
        return false;
    }

    bool startTls() {
        tls_.reset(SSL_new(server_.tls.get()));
        SSL_set_fd(tls_.get(), descriptor_);
        const std::string& host = server_.url.host;
        // A certificate may be for a name or for an address.
        if (X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(tls_.get()), host.c_str()) != 1) {
            SSL_set1_host(tls_.get(), host.c_str());
            SSL_set_tlsext_host_name(tls_.get(), host.c_str());
        }
        if (repeat(
                POLLIN, [](int) { return -1; }, [](SSL* tls) { return SSL_connect(tls); }) > 0)
            return true;
        const long verdict = SSL_get_verify_result(tls_.get());
        if (verdict != X509_V_OK) failure_ = fmt::format("its certificate is refused: {}", X509_verify_cert_error_string(verdict));
        return false;
    }

    void close() {
        tls_.reset();
        if (descriptor_ >= 0) ::close(descriptor_);
        descriptor_ = -1;
    }

    /// Repeats an operation until the socket lets it. Returns its bytes, 0 at the end of the connection, -1 after a failure.
    template <class Plain, class Tls>
    int repeat(short events, Plain plain, Tls tls) {
        while (mayGoOn()) {
            short needed = events;
            if (tls_ != nullptr) {
                ERR_clear_error();
                const int done = tls(tls_.get());
                if (done > 0) return done;
                const int error = SSL_get_error(tls_.get(), done);
                if (error == SSL_ERROR_ZERO_RETURN) return 0;
                if (error != SSL_ERROR_WANT_READ && error != SSL_ERROR_WANT_WRITE) {
                    fail("the TLS connection broke");
                    return -1;
                }
                needed = error == SSL_ERROR_WANT_READ ? POLLIN : POLLOUT;
            } else {
                const ssize_t done = plain(descriptor_);
                if (done >= 0) return static_cast<int>(done);
                if (errno == EINTR) continue;
                if (errno != EAGAIN && errno != EWOULDBLOCK) {
                    fail(lower(std::strerror(errno)));
                    return -1;
                }
            }
            if (!wait(needed)) return -1;
        }
        return -1;
    }

    bool sendAll(std::string_view bytes) {
        while (!bytes.empty()) {
            const int sent = repeat(
                POLLOUT, [&](int socket) { return ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL); },
                [&](SSL* tls) { return SSL_write(tls, bytes.data(), static_cast<int>(bytes.size())); });
            if (sent <= 0) return false;
            bytes.remove_prefix(static_cast<std::size_t>(sent));
        }
        return true;
    }

    bool send(const Request& request) {
        const HttpUrl& url = server_.url;
        const std::string host = url.host.find(':') == std::string::npos ? url.host : "[" + url.host + "]";
        std::string head =
            fmt::format("{} {}/{} HTTP/1.1\r\nHost: {}:{}\r\nUser-Agent: {}/{}\r\nAccept: */*\r\nAccept-Encoding: identity\r\n",
                        request.method, url.prefix, request.path, host, url.port, kToolName, kToolVersion);
        if (!server_.authorization.empty()) head += fmt::format("Authorization: {}\r\n", server_.authorization);
        if (request.body != nullptr)
            head += fmt::format("Content-Type: application/octet-stream\r\nContent-Length: {}\r\n", request.bodyBytes);
        if (!sendAll(head + "\r\n")) return false;
        if (request.body == nullptr) return true;
        request.body->clear();
        request.body->seekg(0);
        std::vector<char> piece(std::min(request.bodyBytes, std::uint64_t{256} << 10));
        for (std::uint64_t left = request.bodyBytes; left > 0;) {
            const std::size_t size = std::min<std::uint64_t>(left, piece.size());
            if (!request.body->read(piece.data(), static_cast<std::streamsize>(size))) {
                isOver_ = true;
                return fail("the file to send was not readable to its end");
            }
            if (!sendAll({piece.data(), size})) return false;
            left -= size;
        }
        return true;
    }

    /// Adds what has arrived to received_. Returns false at the end of the connection and after a failure.
    bool receiveMore() {
        std::array<char, 64 << 10> piece;
        const int size = repeat(
            POLLIN, [&](int socket) { return ::recv(socket, piece.data(), piece.size(), 0); },
            [&](SSL* tls) { return SSL_read(tls, piece.data(), static_cast<int>(piece.size())); });
        if (size <= 0) return fail("the connection ended within the answer");
        hasAnswered_ = true;
        received_.append(piece.data(), static_cast<std::size_t>(size));
        return true;
    }

    /// Takes a text up to an ending, which is dropped.
    std::optional<std::string> takeUntil(std::string_view ending, std::uint64_t limit) {
        for (std::size_t from = 0;;) {
            if (const std::size_t end = received_.find(ending, from); end != std::string::npos) {
                std::string text = received_.substr(0, end);
                received_.erase(0, end + ending.size());
                return text;
            }
            if (received_.size() > limit) {
                fail(fmt::format("a head of more than {} bytes", limit));
                return std::nullopt;
            }
            from = received_.size() - std::min(received_.size(), ending.size() - 1);
            if (!receiveMore()) return std::nullopt;
        }
    }

    /// Passes `count` bytes of the body on.
    bool pass(std::uint64_t count, const Sink& sink) {
        while (count > 0) {
            if (received_.empty() && !receiveMore()) return false;
            const std::string_view piece = std::string_view(received_).substr(0, count);
            if (!sink(piece)) return fail("a body that is not the expected one");
            count -= piece.size();
            received_.erase(0, piece.size());
        }
        return true;
    }

    bool passChunks(std::uint64_t limit, const Sink& sink) {
        constexpr std::uint64_t kMostLine = 1024;
        while (true) {
            const auto line = takeUntil("\r\n", kMostLine);
            if (!line) return false;
            const auto size = numberOf(trimmed(line->substr(0, line->find(';'))), 16);
            if (!size) return fail("a chunk without a size");
            if (*size > limit) return fail("a body longer than expected");
            limit -= *size;
            if (*size > 0) {
                if (!pass(*size, sink) || takeUntil("\r\n", 2) != "") return fail("a chunk without an end");
                continue;
            }
            for (auto trailer = takeUntil("\r\n", kMostLine);; trailer = takeUntil("\r\n", kMostLine)) {
                if (!trailer) return false;
                if (trailer->empty()) return true;
            }
        }
    }

    bool passToEnd(std::uint64_t limit, const Sink& sink) {
        do {
            if (received_.size() > limit) return fail("a body longer than expected");
            limit -= received_.size();
            if (!received_.empty() && !sink(received_)) return fail("a body that is not the expected one");
            received_.clear();
        } while (receiveMore());
        if (isOver_) return false;
        failure_.clear();
        return true;
    }

    std::optional<HttpAnswer> receive(const Request& request) {
        std::optional<Head> head;
        do {  // 1xx: the answer comes later
            const auto text = takeUntil("\r\n\r\n", kMostHeadBytes);
            if (!text) return std::nullopt;
            head = parseHead(*text);
            if (!head) {
                fail("an answer that is not HTTP");
                return std::nullopt;
            }
        } while (head->status < 200);
        const HttpAnswer answer{head->status, head->length};
        const bool hasBody = std::string_view(request.method) != "HEAD" && head->status != 204 && head->status != 304;
        if (hasBody && !receiveBody(*head, request)) {
            if (head->status == 200) return std::nullopt;
            head->isLast = true;  // the status says enough
        }
        if (head->isLast || (hasBody && !head->isChunked && !head->length)) close();
        return answer;
    }

    bool receiveBody(const Head& head, const Request& request) {
        const bool isWanted = head.status == 200 && request.sink != nullptr;
        const std::uint64_t limit = isWanted ? request.limitBytes : kMostDroppedBytes;
        const Sink drop = [](std::string_view) { return true; };
        const Sink& sink = isWanted ? *request.sink : drop;
        if (head.isChunked) return passChunks(limit, sink);
        if (!head.length) return passToEnd(limit, sink);
        return *head.length <= limit ? pass(*head.length, sink)
                                     : fail(fmt::format("a body of {} bytes, of which at most {} are expected", *head.length, limit));
    }

    const HttpServer::Parts& server_;
    std::function<bool()> isStopped_;
    Clock::duration silence_;
    Clock::time_point deadline_;
    int descriptor_ = -1;
    std::unique_ptr<SSL, void (*)(SSL*)> tls_{nullptr, SSL_free};
    std::string received_;  ///< that the answer still has to be read from
    std::string failure_;
    bool hasAnswered_ = false;
    bool isOver_ = false;  ///< stopped, or too late: a new connection would not help
};

HttpConnection::HttpConnection(const HttpServer& server, std::function<bool()> isStopped, Clock::duration silence)
    : wire_(std::make_unique<Wire>(*server.parts_, std::move(isStopped), silence)) {}
HttpConnection::~HttpConnection() = default;

HttpResult HttpConnection::get(const std::string& path, std::uint64_t limitBytes, const Sink& sink) {
    return wire_->exchange({.method = "GET", .path = path, .limitBytes = limitBytes, .sink = &sink});
}
HttpResult HttpConnection::head(const std::string& path) {
    return wire_->exchange({.method = "HEAD", .path = path});
}
HttpResult HttpConnection::put(const std::string& path, std::istream& body, std::uint64_t bytes) {
    return wire_->exchange({.method = "PUT", .path = path, .body = &body, .bodyBytes = bytes});
}

}  // namespace lightcook::pipeline
