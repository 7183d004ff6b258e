// lightcook work: one action of a cook, on a node of a cluster.
#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <string>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/remote.h"
#include "pipeline/command/session.h"
#include "pipeline/cook/action_functions.h"
#include "pipeline/graph/worker.h"
#include "pipeline/report/exit_codes.h"

namespace lightcook::pipeline {
namespace {

struct WorkCommand {
    std::string job;
    std::filesystem::path cache;
    RemoteOptions remote;
    JsonOutput json;
};

formats::Result<Json> work(WorkCommand& options, const RunState& state) {
    LC_TRY(folder, cacheFolder(options.cache));
    options.cache = *folder;
    const Cache cache(*folder, kCacheLimitBytes);
    LC_TRY(remote, options.remote.open(cache.root(), nullptr, true));
    LC_TRY(action, runJob(options.job, actionFunction, cache, remote->get(), state));
    cache.prune();
    return Json{{"action", *action}};
}

}  // namespace

CommandFunction defineWork(CLI::App& app) {
    const auto options = std::make_shared<WorkCommand>();
    app.add_option("job", options->job, "SHA-256 of the job")->type_name("NAME")->required();
    addCacheOption(app, options->cache, "Cache folder of this machine");
    options->remote.add(app, false);
    options->json.add(app, "the action, or why it did not run,");
    app.footer(R"(`cook --launcher` writes jobs and calls this command. Job, inputs and files of other actions come from the
remote cache, and the result goes there. Without a remote cache they are those of the cache folder, which
the machine that cooks has to share with this one, as it does the files of the scene.

A job of another version of lightcook is refused.)");
    return [options](Session& session) {
        options->json.prepare(session);
        const int code = options->json.finish(session, work(*options, session.state));
        if (code == exitCode(formats::ErrorCode::Internal)) holdIfFull({options->cache, kCacheLimitBytes}, session.state);
        return code;
    };
}

}  // namespace lightcook::pipeline
