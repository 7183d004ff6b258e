#include "pipeline/view/server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <mutex>
#include <thread>
#include <vector>

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

constexpr const char* kLoopback = "127.0.0.1";
constexpr std::size_t kPieceBytes = std::size_t{1} << 20;
constexpr std::chrono::milliseconds kPoll{20};

/// The page loads nothing from elsewhere. Draco's decoder is WebAssembly in a worker.
constexpr const char* kPagePolicy =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self' blob:; connect-src 'self' blob: data:; img-src 'self' "
    "blob: data:; style-src 'self' 'unsafe-inline'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

/// Returns true if a request names this server. A page of another site whose name resolves to 127.0.0.1 names that site.
bool isOurHost(const std::string& host, int port) {
    for (const char* name : {"127.0.0.1", "localhost", "[::1]"})
        if (host == fmt::format("{}:{}", name, port) || (port == 80 && host == name)) return true;
    return false;
}

void refuse(httplib::Response& response, int status, const std::string& line) {
    response.status = status;
    response.set_content(line + "\n", "text/plain; charset=utf-8");
}

/// Returns true, with status 416, for a request of bytes past the end of a file, and for one of several ranges: cpp-httplib would make all
/// of them in memory, as often as they name the same bytes.
bool refusesRange(const httplib::Request& request, std::uintmax_t size, httplib::Response& response) {
    const auto isPastEnd = [&](const httplib::Range& range) {
        return range.first >= 0 && static_cast<std::uintmax_t>(range.first) >= size;
    };
    if (request.ranges.size() < 2 && std::ranges::none_of(request.ranges, isPastEnd)) return false;
    response.status = 416;
    response.set_header("Content-Range", fmt::format("bytes */{}", size));
    return true;
}

void sendFile(const std::filesystem::path& file, std::string_view mediaType, const httplib::Request& request, httplib::Response& response) {
    std::error_code code;
    const std::uintmax_t size = std::filesystem::file_size(file, code);
    auto stream = std::make_shared<std::ifstream>(file, std::ios::binary);
    if (code || !*stream) {
        refuse(response, 404, "this file can no longer be read");
        return;
    }
    if (refusesRange(request, size, response)) return;
    response.set_content_provider(static_cast<std::size_t>(size), std::string(mediaType),
                                  [stream](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                                      std::vector<char> piece(std::min(length, kPieceBytes));
                                      stream->clear();
                                      stream->seekg(static_cast<std::streamoff>(offset));
                                      stream->read(piece.data(), static_cast<std::streamsize>(piece.size()));
                                      const auto count = static_cast<std::size_t>(stream->gcount());
                                      return count > 0 && sink.write(piece.data(), count);
                                  });
}

/// Returns the path of the file on the site that a request asks for.
std::string pathOf(const httplib::Request& request) {
    return request.path == "/" ? kPageName : request.path.substr(1);
}

void answer(const Site& site, const httplib::Request& request, httplib::Response& response) {
    const std::string path = pathOf(request);
    const auto found = site.files().find(path);
    if (found == site.files().end()) {
        refuse(response, 404, "this is no file of the scene");
        return;
    }
    const SiteFile& file = found->second;
    if (file.onDisk() != nullptr) {
        sendFile(*file.onDisk(), file.mediaType, request, response);
        return;
    }
    const std::string_view bytes = file.inMemory();
    if (refusesRange(request, bytes.size(), response)) return;
    if (path == kPageName) response.set_header("Content-Security-Policy", kPagePolicy);
    response.set_content(bytes.data(), bytes.size(), std::string(file.mediaType));
}

}  // namespace

struct SiteServer::State {
    State(const Site& shown, std::function<Result<Site>()> open) : reopen(std::move(open)), site(std::shared_ptr<const Site>(), &shown) {}

    /// Returns the site to answer from. A request for the page opens the folder anew if it was cooked again.
    Result<std::shared_ptr<const Site>> siteFor(const httplib::Request& request) {
        const std::lock_guard lock(mutex);
        if (!reopen || pathOf(request) != kPageName || site->isCurrent()) return site;
        LC_TRY(opened, reopen());
        site = std::make_shared<const Site>(std::move(*opened));
        return site;
    }

    const std::function<Result<Site>()> reopen;
    std::mutex mutex;  ///< of `site`
    std::shared_ptr<const Site> site;
    httplib::Server server;
    int port = 0;
};

SiteServer::SiteServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
SiteServer::SiteServer(SiteServer&&) noexcept = default;
SiteServer& SiteServer::operator=(SiteServer&&) noexcept = default;
SiteServer::~SiteServer() = default;

Result<SiteServer> SiteServer::open(const Site& site, std::optional<int> port, std::function<Result<Site>()> reopen) {
    auto state = std::make_unique<State>(site, std::move(reopen));
    httplib::Server& server = state->server;
    // The library's default lets a second server take the same port.
    server.set_socket_options([](int socket) {
        const int yes = 1;
        ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    server.set_default_headers(
        {{"Cache-Control", "no-cache"}, {"X-Content-Type-Options", "nosniff"}, {"Cross-Origin-Resource-Policy", "same-origin"}});
    server.set_pre_routing_handler([state = state.get()](const httplib::Request& request, httplib::Response& response) {
        if (!isOurHost(request.get_header_value("Host"), state->port))
            refuse(response, 403, fmt::format("this server answers to http://{}:{}/ only", kLoopback, state->port));
        else if (request.method != "GET" && request.method != "HEAD")
            refuse(response, 405, "this server answers GET and HEAD only");
        else if (const auto shown = state->siteFor(request))
            answer(**shown, request, response);
        else
            refuse(response, 503, shown.error().line() + ". Reload this page when the folder is cooked");
        return httplib::Server::HandlerResponse::Handled;
    });
    const auto take = [&](int wanted) {
        if (wanted == 0) return server.bind_to_any_port(kLoopback);
        return server.bind_to_port(kLoopback, wanted) ? wanted : -1;
    };
    state->port = take(port.value_or(kDefaultPort));
    if (state->port <= 0 && !port) state->port = take(0);
    if (state->port <= 0)
        return failure(ErrorCode::InvalidRequest, "--port",
                       port.value_or(0) == 0 ? std::string("found no free port on 127.0.0.1")
                                             : fmt::format("found port {} in use or not allowed; name another, or 0 for any", *port));
    return SiteServer(std::move(state));
}

int SiteServer::port() const {
    return state_->port;
}

void SiteServer::run(const RunState& state) {
    std::atomic<bool> isOver{false};
    std::thread watcher([&] {
        // A server that does not listen yet ignores stop(), and would never end.
        while (!isOver && !(state.interrupted && state_->server.is_running())) std::this_thread::sleep_for(kPoll);
        state_->server.stop();
    });
    state_->server.listen_after_bind();
    isOver = true;
    watcher.join();
}

}  // namespace lightcook::pipeline
