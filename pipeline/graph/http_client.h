// A client of HTTP/1.1, plain or over TLS, for servers that may be slow, broken or hostile.
//
// Every exchange has a deadline and can be stopped. Every length has a limit, which is checked before anything is kept. A redirect is an
// answer like any other: nothing is followed. The certificate of a server must be valid for its name, by the authorities that OpenSSL
// knows ($SSL_CERT_FILE and $SSL_CERT_DIR add others). The client of cpp-httplib has no limit for heads, runs a regular expression over a
// status line of any length, which overflows the stack, and cannot be stopped while it connects.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "formats/error.h"

namespace lightcook::pipeline {

struct HttpUrl {
    bool isTls = false;
    std::string host, port;
    std::string prefix;  ///< path, without a slash at its end
    bool operator==(const HttpUrl&) const = default;
};
/// Refuses what is no address of a server, and credentials in one.
formats::Result<HttpUrl> parseHttpUrl(const std::string& text);

/// Returns the value of an Authorization header.
/// credentials   "user:password", else a token
std::string authorizationOf(const std::string& credentials);

/// A server: its address, which is looked up beside everything else, and what all connections to it share.
class HttpServer {
public:
    /// authorization   empty: none
    HttpServer(const HttpUrl& url, std::string authorization);
    ~HttpServer();
    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

private:
    friend class HttpConnection;
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

struct HttpAnswer {
    int status = 0;
    std::optional<std::uint64_t> length;  ///< that the head states
    bool isGood() const { return status >= 200 && status < 300; }
};
/// An answer, or why there is none.
using HttpResult = tl::expected<HttpAnswer, std::string>;

/// A connection that is kept for the next exchange. For one thread.
class HttpConnection {
public:
    using Clock = std::chrono::steady_clock;
    /// Takes a piece of a body. Returns false to end the exchange.
    using Sink = std::function<bool(std::string_view piece)>;

    /// isStopped   asked every few milliseconds: ends an exchange at once
    /// silence     longest time without a byte
    HttpConnection(const HttpServer& server, std::function<bool()> isStopped, Clock::duration silence = std::chrono::seconds(5));
    ~HttpConnection();
    HttpConnection(const HttpConnection&) = delete;
    HttpConnection& operator=(const HttpConnection&) = delete;

    /// path        below the prefix of the server
    /// limitBytes  of the body: a longer one is refused before its first byte where its head states the length, else at the limit
    /// sink        takes the body of an answer with status 200; that of others is dropped
    HttpResult get(const std::string& path, std::uint64_t limitBytes, const Sink& sink);
    HttpResult head(const std::string& path);
    /// body   seekable, with `bytes` bytes
    HttpResult put(const std::string& path, std::istream& body, std::uint64_t bytes);

private:
    class Wire;
    std::unique_ptr<Wire> wire_;
};

}  // namespace lightcook::pipeline
