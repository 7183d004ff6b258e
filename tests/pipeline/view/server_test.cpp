#include "pipeline/view/server.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <thread>

#include "tests/pipeline/view/cooked_site.h"

namespace lightcook::pipeline {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// A server that runs in a thread, asked through a plain socket: clients of a library would tidy up what is sent.
class RunningServer : public CookedSite {
protected:
    void SetUp() override {
        CookedSite::SetUp();
        auto site = open();
        ASSERT_TRUE(site.has_value()) << site.error().line();
        site_.emplace(std::move(*site));
        auto server = SiteServer::open(*site_, 0, [this] { return open(); });
        ASSERT_TRUE(server.has_value()) << server.error().line();
        server_.emplace(std::move(*server));
        thread_ = std::thread([this] { server_->run(serving_); });
    }
    void TearDown() override {
        serving_.interrupted = true;
        if (thread_.joinable()) thread_.join();
    }

    /// Returns the whole answer to a request, head and body.
    std::string ask(const std::string& head) const {
        const int descriptor = ::socket(AF_INET, SOCK_STREAM, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(server_->port()));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        std::string answer;
        const std::string request = head + "Connection: close\r\n\r\n";
        if (::connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
            ::send(descriptor, request.data(), request.size(), 0) == static_cast<ssize_t>(request.size())) {
            char piece[65536];
            for (ssize_t count; (count = ::recv(descriptor, piece, sizeof piece, 0)) > 0;)
                answer.append(piece, static_cast<std::size_t>(count));
        }
        ::close(descriptor);
        return answer;
    }
    std::string ourHost() const { return fmt::format("Host: 127.0.0.1:{}\r\n", server_->port()); }
    std::string get(const std::string& path, const std::string& more = "") const {
        return ask(fmt::format("GET {} HTTP/1.1\r\n{}{}", path, ourHost(), more));
    }

    RunState serving_;
    std::optional<Site> site_;
    std::optional<SiteServer> server_;
    std::thread thread_;
};

TEST_F(RunningServer, SendsEveryFileAsItIs) {
    EXPECT_THAT(get("/"), AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("text/html"),
                                HasSubstr("Content-Security-Policy: default-src 'self'"), EndsWith(std::string(kPage[0].bytes))));
    EXPECT_THAT(get("/index.html?view=1"), EndsWith(std::string(kPage[0].bytes)));
    EXPECT_THAT(get("/cooked/cooked.json"), EndsWith(formats::contentOf(folder() / "cooked.json")));
    EXPECT_THAT(get("/cooked/lightcook.glsl"), EndsWith(formats::contentOf(folder() / "lightcook.glsl")));
    EXPECT_THAT(get("/viewer/map.reference.ktx2"),
                EndsWith(formats::contentOf(std::get<std::filesystem::path>(site_->files().at("viewer/map.reference.ktx2").content))));
    EXPECT_THAT(get("/cooked/cooked.json", "Range: bytes=0-0\r\n"), AllOf(StartsWith("HTTP/1.1 206"), EndsWith("\r\n\r\n{")));
    EXPECT_THAT(get("/cooked/cooked.json", "Range: bytes=99999999-\r\n"),
                AllOf(StartsWith("HTTP/1.1 416"), HasSubstr("Content-Range: bytes */"), EndsWith("\r\n\r\n")));
    for (const char* const path : {"/cooked/cooked.json", "/assets/page.js"})
        EXPECT_THAT(get(path, "Range: bytes=0-,0-\r\n"), StartsWith("HTTP/1.1 416")) << "of several ranges";
    EXPECT_THAT(ask("HEAD /cooked/cooked.json HTTP/1.1\r\n" + ourHost()), AllOf(StartsWith("HTTP/1.1 200"), EndsWith("\r\n\r\n")));
}

TEST_F(RunningServer, SendsNothingElse) {
    formats::writeContent(folder() / "secret.txt", "secret");
    std::filesystem::create_symlink("/etc/passwd", folder() / "link.txt");
    for (const char* path :
         {"/cooked/secret.txt", "/cooked/link.txt", "/cooked/../scene.toml", "/cooked/%2e%2e/scene.toml", "/../../../../etc/passwd",
          "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/cooked", "/cooked/", "/viewer/", "/cooked/cooked.json%00.txt", "/nothing"}) {
        SCOPED_TRACE(path);
        const std::string answer = get(path);
        EXPECT_THAT(answer, StartsWith("HTTP/1.1 4"));
        EXPECT_THAT(answer, Not(HasSubstr("root:")));
        EXPECT_THAT(answer, Not(HasSubstr("secret")));
    }
}

TEST_F(RunningServer, RefusesOtherHostsAndMethods) {
    for (const std::string host : {"evil.example", "127.0.0.1", "127.0.0.1:1", "localhost.evil.example"})
        EXPECT_THAT(ask(fmt::format("GET / HTTP/1.1\r\nHost: {}\r\n", host)), StartsWith("HTTP/1.1 403")) << host;
    EXPECT_THAT(ask("GET / HTTP/1.1\r\n"), StartsWith("HTTP/1.1 403")) << "no host";
    EXPECT_THAT(ask(fmt::format("GET / HTTP/1.1\r\nHost: localhost:{}\r\n", server_->port())), StartsWith("HTTP/1.1 200"));
    for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS"})
        EXPECT_THAT(ask(fmt::format("{} / HTTP/1.1\r\n{}Content-Length: 0\r\n", method, ourHost())), StartsWith("HTTP/1.1 405")) << method;
}

TEST_F(RunningServer, ShowsTheFolderThatWasCookedAgain) {
    EXPECT_THAT(get("/viewer/scene.json"), HasSubstr("\"map\""));
    EXPECT_THAT(get("/cooked/map_l0.ktx2"), StartsWith("HTTP/1.1 200"));
    scene_.writeSceneFile("light_map_layout = \"hdr\"");
    ASSERT_TRUE(cookScene(scene_.options(), state_).errors.empty());
    EXPECT_THAT(get("/cooked/map_sh.ktx2"), StartsWith("HTTP/1.1 404")) << "a page that is open sees no file of another cook";
    EXPECT_THAT(get("/cooked/cooked.json"), EndsWith(formats::contentOf(folder() / "cooked.json"))) << "but that there is one";
    EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));
    EXPECT_THAT(get("/cooked/map_sh.ktx2"), EndsWith(formats::contentOf(folder() / "map_sh.ktx2")));
    EXPECT_THAT(get("/cooked/map_l0.ktx2"), StartsWith("HTTP/1.1 404"));

    const std::string manifest = formats::contentOf(folder() / "cooked.json");
    formats::writeContent(folder() / "cooked.json", manifest.substr(0, 100));
    EXPECT_THAT(get("/"), AllOf(StartsWith("HTTP/1.1 503"), HasSubstr("cooked.json"), HasSubstr("Reload this page")));
    formats::writeContent(folder() / "cooked.json", manifest);
    EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));
}

TEST_F(RunningServer, TakesTheWantedPortOrSaysThatItIsInUse) {
    const auto second = SiteServer::open(*site_, server_->port());
    ASSERT_FALSE(second.has_value());
    EXPECT_EQ(second.error().code, formats::ErrorCode::InvalidRequest);
    EXPECT_THAT(second.error().line(), AllOf(HasSubstr("--port"), HasSubstr(std::to_string(server_->port()))));
    const auto first = SiteServer::open(*site_, std::nullopt), other = SiteServer::open(*site_, std::nullopt);
    ASSERT_TRUE(first.has_value());
    ASSERT_TRUE(other.has_value()) << "without --port, another port does";
    EXPECT_NE(first->port(), other->port());
}

/// The signal may come while the server is about to listen.
TEST_F(RunningServer, EndsWhenItIsInterruptedBeforeItListens) {
    RunState interrupted;
    interrupted.interrupted = true;
    auto server = SiteServer::open(*site_, 0);
    ASSERT_TRUE(server.has_value());
    server->run(interrupted);
}

}  // namespace
}  // namespace lightcook::pipeline
