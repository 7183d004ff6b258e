// lightcook init: a first scene file for the files of a user.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/draft/inputs.h"
#include "pipeline/draft/scene_text.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/shell_word.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;

struct InitOptions {
    std::vector<fs::path> inputs;
    fs::path output;
    bool force = false;
    JsonOutput json;
};

/// Returns the scene file to write: that of the option, else scene.toml in the one folder that was named, or here.
fs::path sceneFileOf(const InitOptions& options) {
    std::error_code code;
    if (!options.output.empty()) return options.output;
    const bool isFolder = options.inputs.size() == 1 && fs::is_directory(options.inputs.front(), code);
    return isFolder ? options.inputs.front() / "scene.toml" : fs::path("scene.toml");
}

Json jsonOf(const DraftInputs& inputs, const fs::path& scene) {
    Json json = {{"scene", scene.string()},
                 {"light_maps", Json::array()},
                 {"probes", Json::array()},
                 {"gradients", Json::array()},
                 {"left_out", Json::array()}};
    for (const DraftLightMap& map : inputs.lightMaps) {
        Json& made = json["light_maps"].emplace_back(
            Json{{"file", map.file.string()}, {"bake", map.reading.bake}, {"evidence", map.reading.evidence}, {"guess", map.isGuess}});
        if (map.mesh) made["mesh"] = map.mesh->string();
    }
    for (const DraftProbe& probe : inputs.probes) {
        Json& made = json["probes"].emplace_back(Json{{"file", probe.file.string()}});
        if (probe.sh) made["sh"] = probe.sh->string();
    }
    for (const fs::path& gradient : inputs.gradients) json["gradients"].push_back(gradient.string());
    for (const LeftOut& each : inputs.leftOut) json["left_out"].push_back({{"file", each.file.string()}, {"why", each.why}});
    return json;
}

/// Says what each file is taken for.
void print(Terminal& terminal, const DraftInputs& inputs, const fs::path& scene) {
    const auto say = [&](const fs::path& file, const std::string& what) { terminal.say(fmt::format("{}: {}", file.string(), what)); };
    for (const DraftLightMap& map : inputs.lightMaps) {
        say(map.file, fmt::format("light map, read as {} ({}){}{}{}", map.reading.bake, map.reading.evidence,
                                  map.isGuess ? ", a guess" : "", map.mesh ? ", on " + map.mesh->filename().string() : "",
                                  map.gaps > 0 ? fmt::format(", {:.0f} % of it black gaps", 100 * map.gaps) : ""));
        for (const std::string& set : map.reading.incompleteSets) say(map.file, set);
        if (!map.reading.otherReadings.empty())
            say(map.file, fmt::format("would also fit: {}", fmt::join(map.reading.otherReadings, ", ")));
    }
    for (const DraftProbe& probe : inputs.probes)
        say(probe.file, probe.sh ? fmt::format("environment, with SH of {}", probe.sh->filename().string()) : "environment");
    for (const fs::path& gradient : inputs.gradients) say(gradient, "gradient of a sky");
    for (const LeftOut& each : inputs.leftOut) say(each.file, "left out: " + each.why);
    terminal.say(fmt::format("wrote {}; next: lightcook cook {}", scene.string(), shellWord(scene.string())));
}

/// Returns the files that the scene file will name.
std::vector<fs::path> filesNamedBy(const DraftInputs& inputs) {
    std::vector<fs::path> files = inputs.gradients;
    for (const DraftLightMap& map : inputs.lightMaps) {
        files.push_back(map.file);
        if (map.mesh) files.push_back(*map.mesh);
    }
    for (const DraftProbe& probe : inputs.probes) {
        files.push_back(probe.file);
        if (probe.sh) files.push_back(*probe.sh);
    }
    return files;
}

formats::Result<Json> writeScene(const InitOptions& options, Session& session) {
    const fs::path scene = sceneFileOf(options);
    std::error_code code;
    if (fs::exists(scene, code) && !options.force)
        return formats::failure(formats::ErrorCode::InvalidRequest, scene,
                                "found a file, expected none; --force replaces it, -o FILE writes another");
    LC_TRY(inputs, findInputs(options.inputs));
    LC_CHECK(session.paths.checkAgainst(filesNamedBy(*inputs), "an input"));
    if (options.output.empty()) LC_CHECK(session.paths.checkAgainst({scene}, "the scene file"));
    const fs::path folder = fs::absolute(scene).parent_path();
    LC_TRY(text, draftScene(*inputs, folder));
    LC_CHECK(makeFolder(folder));
    LC_CHECK(writeFile(scene, *text, OutputLink::Follow));
    if (session.terminal.verbosity() != Verbosity::Quiet) print(session.terminal, *inputs, scene);
    return jsonOf(*inputs, scene);
}

}  // namespace

CommandFunction defineInit(CLI::App& app) {
    const auto options = std::make_shared<InitOptions>();
    addFilesOption(app, "inputs", options->inputs, "Light maps, meshes, environments and gradients, or folders that hold them")->required();
    declareWritten(
        addFileOption(app, "-o,--output", options->output, "The scene file; default: scene.toml in the folder that is named, else here"),
        Written::File);
    app.add_flag("--force", options->force, "Replace the scene file if it exists");
    options->json.add(app, "what each file was taken for");
    app.footer(R"(init looks at the files as info does, and writes a scene file with a comment at each key. A light map
gets the mesh whose name its own begins with, a probe the JSON file that states its SH. Of a picture
that nothing but its shape tells, HDR files shaped like an environment become probes and others flat
light maps, unless the name says "lightmap" or is that of a mesh; the comment says that it is a guess.
What no part of the scene names is listed, with the reason. Folders are not searched below the files
that lie in them.)");
    return [options](Session& session) {
        options->json.prepare(session);
        if (auto checked = checkIsFile("--output", options->output); !checked) return options->json.finish(session, {}, {checked.error()});
        return options->json.finish(session, writeScene(*options, session));
    };
}

}  // namespace lightcook::pipeline
