// lightcook plan: a scene as a Ninja file.
#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "formats/process.h"
#include "pipeline/command/command.h"
#include "pipeline/command/launcher_option.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/remote.h"
#include "pipeline/command/session.h"
#include "pipeline/cook/ninja.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

struct PlanCommand {
    std::filesystem::path scene, ninja, output, cache;
    std::string launcher;
    RemoteOptions remote;
    JsonOutput json;
};

std::filesystem::path absolutePath(const std::filesystem::path& path) {
    return std::filesystem::absolute(path).lexically_normal();
}

formats::Result<Json> writePlan(const PlanCommand& options, Session& session) {
    LC_CHECK(checkLauncher(options.launcher));
    LC_TRY(scenes, readScenes(options.scene));
    if (const std::string why = whyNothing(scenes->front()); !why.empty())
        return formats::failure(formats::ErrorCode::InvalidRequest, options.scene, why);
    LC_TRY(program, formats::programFile());
    std::filesystem::path output;
    std::vector<std::string> targets;
    for (const Scene& scene : *scenes) {
        output = cookedFolder(scene, options.output);
        LC_CHECK(session.paths.checkAgainstScene(scene, output));
        if (!scene.isOfTargets) continue;
        targets.push_back(output.filename());
        output = output.parent_path();
    }
    Scene& scene = scenes->front();
    scene.file = absolutePath(options.scene);
    const NinjaOptions ninja{*program,         absolutePath(output),   options.cache.empty() ? options.cache : absolutePath(options.cache),
                             options.launcher, options.remote.words(), targets};
    LC_CHECK(checkNinjaPaths(scene, ninja));
    if (const auto warning = warningOfDepfiles(scene, ninja)) session.terminal.warning(warning->subject, warning->detail);
    LC_CHECK(session.write(options.ninja, ninjaFileOf(scene, ninja)));
    return Json{
        {"scene", scene.name}, {"ninja", options.ninja.string()}, {"output", ninja.output.string()}, {"parts", ninjaPartsOf(scene)}};
}

}  // namespace

CommandFunction definePlan(CLI::App& app) {
    const auto options = std::make_shared<PlanCommand>();
    addFileOption(app, "scene", options->scene, "The scene file (scene.toml)")->required();
    declareWritten(addFileOption(app, "--ninja", options->ninja, "The Ninja file to write; -: standard output"), Written::File)->required();
    declareWritten(addFolderOption(app, "-o,--output", options->output, "Output folder of the cook; default: <scene name>.cooked"),
                   Written::Folder);
    app.add_option("--launcher", options->launcher, "Run what takes long on other machines: --launcher of `cook`, for every command")
        ->type_name("COMMAND");
    addFolderOption(app, "--cache", options->cache, "Cache folder of the commands; default: that of their environment");
    options->remote.add(app, false);
    options->json.add(app, "the parts of the scene that have a command each");
    app.footer(R"(Each light map with what derives from it, each probe, each gradient and the specular tables are cooked and
verified by a command of their own, in DIR.assets/NAME. A last command puts the scene together in DIR: it
finds what the others did in the cache, and has the same result as `cook`. Each command has a depfile,
so ninja runs those alone whose inputs changed:

  lightcook plan scene.toml --ninja scene.ninja -o out
  ninja -f scene.ninja

Paths in the file are absolute. The commands run on this machine. With --launcher, they put what takes
long on others, and wait: give ninja as many jobs (-j) as the cluster takes at once. See `cook --help`.

Settings are those of the scene file. A scene file with other assets needs another plan.)");
    return [options](Session& session) {
        if (options->ninja == kStandardOutput && options->json.isStandardOutput())
            return session.finish(
                {{formats::ErrorCode::InvalidRequest, "--ninja, --json", "found - for both, expected one document on standard output"}});
        options->json.prepare(session);
        return options->json.finish(session, writePlan(*options, session));
    };
}

}  // namespace lightcook::pipeline
