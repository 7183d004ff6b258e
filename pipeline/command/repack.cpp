// lightcook repack: the charts of a light map packed anew, at the resolution that each needs.
#include "pipeline/repack/repack.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/converter.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"

namespace lightcook::pipeline {
namespace {

double percent(std::int64_t part, const glm::ivec2& size) {
    return 100.0 * static_cast<double>(part) / (static_cast<double>(size.x) * size.y);
}

void print(Terminal& terminal, const Repacked& made) {
    const double texels = static_cast<double>(made.size.x) * made.size.y,
                 before = static_cast<double>(made.sizeBefore.x) * made.sizeBefore.y;
    terminal.say(fmt::format("{} x {} texels, {:.1f} % of {} x {}; {:.1f} % of them are read, {:.1f} % before", made.size.x, made.size.y,
                             100 * texels / before, made.sizeBefore.x, made.sizeBefore.y, percent(made.read, made.size),
                             percent(made.readBefore, made.sizeBefore)));
    terminal.say(fmt::format("{} charts, {} with fewer texels: visible error p99 {:.2f}, largest {:.2f}; rel_rms {:.2f} %", made.charts,
                             made.reducedCharts, made.visible.p99, made.visible.max, 100 * made.relRms));
    terminal.say(fmt::format("wrote {}", made.map.string()));
    for (const std::filesystem::path& mesh : made.meshes) terminal.say(fmt::format("wrote {}", mesh.string()));
}

}  // namespace

CommandFunction defineRepack(CLI::App& app) {
    struct Options : RepackRequest {
        GivenKeys given;
        JsonOutput json;
        bool isRepaired = false;
    };
    const auto options = std::make_shared<Options>();
    addFileOption(app, "input", options->map, "The bake")->required();
    addFilesOption(app, "meshes", options->meshes, "glTF files whose TEXCOORD_1 are UVs in the bake: all that use it")->required();
    declareWritten(addFolderOption(app, "-o,--output", options->folder, "Folder that gets the bake and the meshes"), Written::Folder)
        ->required();
    app.add_option("--max-visible", options->maxVisible,
                   "Largest visible error that fewer texels may add to 99 % of a chart's samples; 0: charts are moved only, without loss")
        ->type_name("JND")
        ->check(CLI::Range(0.0, 100.0))
        ->capture_default_str();
    addRepairOption(app, options->isRepaired);
    addKeyOptions(app, options->given, conventionOptions());
    options->json.add(app, "what changed");
    app.footer(R"(repack writes a bake in form sh9 and the meshes with new light-map UVs; cook and lightmap take them in
place of the originals. A chart is what triangles use that share vertices or texels. Each gets the
lowest resolution at which the exit radiance of a white surface keeps the limit, at its own normal and
at four that lie 45 degrees from it. Charts are then packed into the least rectangle that is found.
Charts that keep their resolution keep their texels bit for bit, and the light between them. A later
repack into the same folder replaces the files that repacked.json lists there; any other file of the
same name is refused.)");
    return [options](Session& session) {
        auto description = describeBake(options->map, options->given, options->meshes);
        if (!description) return session.finish(description);
        options->description = std::move(*description);
        options->description.repair = options->isRepaired;
        options->lmbake = options->description.lmbake;
        options->keepsOthers = true;
        options->json.prepare(session);
        const auto made = repack(*options, session.state);
        if (!made) return options->json.finish(session, {}, {made.error()});
        if (session.terminal.verbosity() != Verbosity::Quiet) print(session.terminal, *made);
        return options->json.finish(session, made->toJson(), {});
    };
}

}  // namespace lightcook::pipeline
