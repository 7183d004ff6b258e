// lightcook view: the cooked scene in the browser, beside its bake.
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <memory>
#include <optional>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/view/server.h"
#include "pipeline/view/site.h"

namespace lightcook::pipeline {
namespace {

struct ViewOptions {
    SiteOptions site;
    std::filesystem::path exported;
    std::optional<int> port;
    JsonOutput json;
};

void say(Session& session, const std::string& line) {
    if (session.terminal.verbosity() != Verbosity::Quiet) session.terminal.say(line);
}

int exportTo(Session& session, const ViewOptions& options, const Site& site) {
    if (auto written = exportSite(site, options.exported, session.state); !written)
        return options.json.finish(session, {}, {written.error()});
    const std::string folder = std::filesystem::absolute(options.exported).lexically_normal().string();
    say(session, fmt::format("the page of {} is {}/index.html; any web server shows that folder", site.scene(), folder));
    return options.json.finish(session, Json{{"scene", site.scene()}, {"folder", folder}, {"files", site.files().size()}});
}

int serve(Session& session, const ViewOptions& options, const Site& site) {
    auto server = SiteServer::open(site, options.port, [&] { return Site::open(options.site, session.state); });
    if (!server) return options.json.finish(session, {}, {server.error()});
    const std::string url = fmt::format("http://127.0.0.1:{}/", server->port());
    say(session, fmt::format("{} is shown at {}; Ctrl-C ends it", site.scene(), url));
    if (auto written = options.json.write(session, Json{{"scene", site.scene()}, {"url", url}, {"port", server->port()}}, {}); !written)
        return session.finish(written);
    session.endOnSignal();  // as the line above said
    server->run(session.state);
    return 0;
}

}  // namespace

CommandFunction defineView(CLI::App& app) {
    const auto options = std::make_shared<ViewOptions>();
    addFolderOption(app, "folder", options->site.folder, "Output folder of cook")->required();
    CLI::Option* port = app.add_option("--port", options->port, "Port on 127.0.0.1; 0: any; default: 8710, or any other if that is in use");
    port->type_name("N")->check(CLI::Range(0, 65535));
    declareWritten(
        addFolderOption(app, "--export", options->exported, "Write the page as static files into this folder, and serve nothing"),
        Written::Folder)
        ->excludes(port);
    addFolderOption(app, "--sources", options->site.sources, "The scene's folder, if it has moved since the cook");
    options->json.add(app, "the address of the page, or the folder of --export");
    app.footer(R"(The page draws the cooked textures with the shader of the cooked folder, beside the float bake, and shows
where they differ. It is served to browsers of this machine only, until Ctrl-C, which ends the
command with exit code 0. After a new cook into the folder the page offers to reload.

--export writes the same files into a folder for any web server or artifact store. Browsers do not load
them from a disk directly. Over an earlier export it replaces the files of that one, and leaves
others.)");
    return [options](Session& session) {
        options->json.prepare(session);
        const auto site = Site::open(options->site, session.state);
        if (!site) return options->json.finish(session, {}, {site.error()});
        for (const std::string& note : site->notes()) session.terminal.warning(site->scene(), note);
        return options->exported.empty() ? serve(session, *options, *site) : exportTo(session, *options, *site);
    };
}

}  // namespace lightcook::pipeline
