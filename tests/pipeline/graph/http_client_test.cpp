#include "pipeline/graph/http_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <cstdlib>
#include <sstream>

#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/graph/cache_server.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;
using testing::Not;
using namespace std::chrono_literals;

/// Two connections to one server, one of which does not wait long.
class HttpClient : public testing::Test {
protected:
    /// Returns the body, or why there is none.
    std::string get(const std::string& path, std::uint64_t limit = 1 << 20) { return getBy(connection_, path, limit); }
    std::string getBy(HttpConnection& connection, const std::string& path, std::uint64_t limit) {
        std::string body;
        last_ = connection.get(path, limit, [&](std::string_view piece) {
            body += piece;
            return true;
        });
        return !last_ ? "failed: " + last_.error() : last_->status == 200 ? body : fmt::format("status {}", last_->status);
    }
    int put(const std::string& path, const std::string& content) {
        std::istringstream body(content);
        last_ = connection_.put(path, body, content.size());
        return last_ ? last_->status : 0;
    }

    CacheServer server_;
    HttpServer address_{*parseHttpUrl(server_.url()), authorizationOf("reader:secret")};
    std::atomic<bool> isStopped_{false};
    HttpConnection connection_{address_, [this] { return isStopped_.load(); }};
    HttpConnection hasty_{address_, [this] { return isStopped_.load(); }, 100ms};
    HttpResult last_;
};

TEST_F(HttpClient, WritesReadsAndKeepsItsConnection) {
    const std::string content = std::string(1000000, 'a') + '\0' + "\r\n\r\n";
    EXPECT_EQ(get("cas/one"), "status 404");
    EXPECT_EQ(put("cas/one", content), 201);
    EXPECT_EQ(get("cas/one"), content);
    EXPECT_EQ(put("cas/none", ""), 201);
    EXPECT_EQ(get("cas/none"), "");
    const HttpResult head = connection_.head("cas/one");
    ASSERT_TRUE(head.has_value());
    EXPECT_EQ(head->length, content.size());
    server_.isChunked = true;
    EXPECT_EQ(get("cas/one"), content);
    EXPECT_EQ(server_.connectionCount(), 1);
    EXPECT_THAT(server_.requests(), testing::Contains("PUT /cache/cas/one"));
    EXPECT_THAT(server_.lastHead(), HasSubstr("Authorization: Basic cmVhZGVyOnNlY3JldA==\r\n"));
    EXPECT_EQ(authorizationOf("a-token"), "Bearer a-token");
}

TEST_F(HttpClient, ConnectsAnewWhereTheServerClosedAnIdleConnection) {
    put("cas/one", "content");
    int requests = 0;
    server_.setFault([&](const std::string&, const std::string&) { return ++requests == 1 ? ServerFault::Closes : ServerFault::None; });
    EXPECT_EQ(get("cas/one"), "content");
    EXPECT_EQ(server_.connectionCount(), 2);
    server_.setFault(ServerFault::Closes, "GET", "cas");
    EXPECT_EQ(get("cas/one"), "failed: the connection ended within the answer") << "but not for ever";
}

TEST_F(HttpClient, EveryFaultEndsInTime) {
    put("cas/one", "0123456789");
    const auto with = [&](ServerFault fault) {
        server_.setFault(fault, "GET", "cas");
        return get("cas/one", 10);
    };
    for (const ServerFault hang : {ServerFault::Silent, ServerFault::HangsInBody}) {
        server_.setFault(hang, "GET", "cas");
        EXPECT_THAT(getBy(hasty_, "cas/one", 10), HasSubstr("no answer within"));
    }
    EXPECT_THAT(with(ServerFault::TornBody), HasSubstr("the connection ended"));
    EXPECT_THAT(with(ServerFault::LongBody), HasSubstr("a body of 11 bytes, of which at most 10 are expected"));
    EXPECT_THAT(with(ServerFault::HugeBody), HasSubstr("a body of 10737418240 bytes"));
    EXPECT_THAT(with(ServerFault::HugeChunks), HasSubstr("longer than expected"));
    EXPECT_THAT(with(ServerFault::NotHttp), HasSubstr("not HTTP"));
    EXPECT_THAT(with(ServerFault::LongHead), HasSubstr("a head of more than"));
    EXPECT_EQ(with(ServerFault::Redirects), "status 302");
    EXPECT_EQ(with(ServerFault::Refuses), "status 403");
    EXPECT_EQ(with(ServerFault::Empty), "");
    EXPECT_EQ(with(ServerFault::None), "0123456789") << "after all of them";
    EXPECT_LT(server_.sentBytes(), 64u << 20);
    for (const std::string& request : server_.requests()) EXPECT_THAT(request, Not(HasSubstr("moved")));
}

TEST_F(HttpClient, AnExchangeIsStopped) {
    server_.setFault(ServerFault::Silent, "GET", "cas");
    const HttpServer patient(*parseHttpUrl(server_.url()), "");
    HttpConnection connection(patient, [this] { return isStopped_.load(); });
    std::thread stopping([this] {
        std::this_thread::sleep_for(30ms);
        isStopped_ = true;
    });
    const HttpResult result = connection.get("cas/one", 10, [](std::string_view) { return true; });
    stopping.join();
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error(), "stopped") << "before the server's time is over";
}

TEST_F(HttpClient, AServerThatIsNotThereIsNamed) {
    const auto failureOf = [](const std::string& url) {
        const HttpServer server(*parseHttpUrl(url), "");
        HttpConnection connection(server, [] { return false; });
        const HttpResult result = connection.head("ac/none");
        return result ? "an answer" : result.error();
    };
    EXPECT_EQ(failureOf("http://127.0.0.1:1"), "connection refused");
    EXPECT_EQ(failureOf("http://no-such-host.invalid/cache"), "no address of no-such-host.invalid");
}

TEST(HttpUrl, AddressesAreTakenApart) {
    const auto url = parseHttpUrl("https://cache.example.org/team/lightcook/");
    ASSERT_TRUE(url.has_value());
    EXPECT_TRUE(url->isTls);
    EXPECT_EQ(url->host + " " + url->port + " " + url->prefix, "cache.example.org 443 /team/lightcook");
    const auto plain = parseHttpUrl("http://[::1]:8080");
    ASSERT_TRUE(plain.has_value());
    EXPECT_EQ(plain->host + " " + plain->port + " " + plain->prefix, "::1 8080 ");
    for (const char* wrong :
         {"", "cache", "ftp://cache", "http://", "http://cache:", "http://cache:0", "http://cache:70000", "http://cache:8x", "http://[::1",
          "http://[::1]8080", "http://cache/a b", "http://cache/a\r\nHost: b", "http://cache/?a"})
        EXPECT_FALSE(parseHttpUrl(wrong).has_value()) << wrong;
    const auto withPassword = parseHttpUrl("https://me:secret@cache.example.org/");
    ASSERT_FALSE(withPassword.has_value());
    EXPECT_THAT(withPassword.error().line(), Not(HasSubstr("secret")));
}

/// A certificate that signs itself, and a server that shows it.
class TlsServer {
public:
    /// name   "IP:127.0.0.1" or "DNS:other.example"
    explicit TlsServer(const char* name) {
        const std::unique_ptr<EVP_PKEY, void (*)(EVP_PKEY*)> key(EVP_EC_gen("P-256"), EVP_PKEY_free);
        certificate_.reset(X509_new());
        X509_set_version(certificate_.get(), 2);
        ASN1_INTEGER_set(X509_get_serialNumber(certificate_.get()), 1);
        X509_gmtime_adj(X509_getm_notBefore(certificate_.get()), -60);
        X509_gmtime_adj(X509_getm_notAfter(certificate_.get()), 3600);
        X509_set_pubkey(certificate_.get(), key.get());
        X509_NAME* const subject = X509_get_subject_name(certificate_.get());
        X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("test"), -1, -1, 0);
        X509_set_issuer_name(certificate_.get(), subject);
        X509_EXTENSION* const extension = X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, name);
        X509_add_ext(certificate_.get(), extension, -1);
        X509_EXTENSION_free(extension);
        X509_sign(certificate_.get(), key.get(), EVP_sha256());
        tls_.reset(SSL_CTX_new(TLS_server_method()));
        SSL_CTX_use_certificate(tls_.get(), certificate_.get());
        SSL_CTX_use_PrivateKey(tls_.get(), key.get());
        server_.emplace(tls_.get());
    }
    /// Returns why a client fails; empty: it does not.
    /// isTrusted   the client knows the certificate
    std::string failureOf(bool isTrusted) {
        const formats::TemporaryFolder folder;
        const std::string file = (folder / "authorities.pem").string();
        FILE* const stream = std::fopen(file.c_str(), "w");
        if (isTrusted) PEM_write_X509(stream, certificate_.get());
        std::fclose(stream);
        ::setenv("SSL_CERT_FILE", file.c_str(), 1);
        const HttpServer address(*parseHttpUrl(server_->url()), "");
        ::unsetenv("SSL_CERT_FILE");
        HttpConnection connection(address, [] { return false; });
        const std::string content(100000, 'b');
        std::istringstream body(content);
        const HttpResult written = connection.put("cas/one", body, content.size());
        if (!written) return written.error();
        std::string found;
        const HttpResult read = connection.get("cas/one", content.size(), [&](std::string_view piece) {
            found += piece;
            return true;
        });
        return read && found == content ? "" : "another content";
    }

private:
    std::unique_ptr<X509, void (*)(X509*)> certificate_{nullptr, X509_free};
    std::unique_ptr<SSL_CTX, void (*)(SSL_CTX*)> tls_{nullptr, SSL_CTX_free};
    std::optional<CacheServer> server_;
};

TEST(HttpTls, OnlyACertificateThatIsKnownAndOfThatNameIsTaken) {
    TlsServer server("IP:127.0.0.1"), other("DNS:other.example");
    EXPECT_EQ(server.failureOf(true), "");
    EXPECT_THAT(server.failureOf(false), HasSubstr("its certificate is refused: self-signed certificate"));
    EXPECT_THAT(other.failureOf(true), HasSubstr("its certificate is refused: IP address mismatch"));
}

}  // namespace
}  // namespace lightcook::pipeline
