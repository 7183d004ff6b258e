// The web server of `lightcook view`: the files of a site, on loopback only.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "formats/error.h"
#include "pipeline/graph/action.h"
#include "pipeline/view/site.h"

namespace lightcook::pipeline {

/// Serves a site to browsers of this machine. A request must be a GET or HEAD, name this server as its host (a page of another site that
/// resolves its own name to 127.0.0.1 is refused), and ask for a file of the site. A request for the page opens a folder anew that was
/// cooked again; all further requests are answered from that site. While a cook is writing, the page is the error of its folder.
class SiteServer {
public:
    static constexpr int kDefaultPort = 8710;

    /// Takes the port of 127.0.0.1. 0: any that is free. Empty: kDefaultPort, or any other if that is in use.
    /// site    outlives the server
    /// reopen  opens the folder of the site anew; empty: never
    static formats::Result<SiteServer> open(const Site& site, std::optional<int> port, std::function<formats::Result<Site>()> reopen = {});
    SiteServer(SiteServer&&) noexcept;
    SiteServer& operator=(SiteServer&&) noexcept;
    ~SiteServer();

    int port() const;
    /// Answers requests until state.interrupted.
    void run(const RunState& state);

private:
    struct State;
    explicit SiteServer(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace lightcook::pipeline
