// lightcook_bench: time, memory, bytes and error of cooking the light maps of ../shared/data, as Markdown tables. The first has a row for
// each scene and layout; a change to any module must not worsen these figures. The second has the scenes as `init` writes them, with their
// meshes and probes: the table of the README. It runs the program as a user would, with a new cache, so that seconds and memory are those
// of a whole cook with its verification.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "bench/markdown_table.h"
#include "bench/run_program.h"
#include "bench/scene_files.h"
#include "bench/tiled_map.h"
#include "formats/light_map_layout.h"
#include "formats/temporary_folder.h"

namespace lightcook::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using formats::TemporaryFolder;

struct Options {
    fs::path data = LIGHTCOOK_SHARED_DATA;
    std::vector<std::string> layouts = {"basis-4", "basis-8", "ratio", "hdr-2"};
    std::string scene;                ///< only scenes whose name contains this
    fs::path json;                    ///< file of the rows as JSON; empty: none
    TiledMap tiled = {.columns = 0};  ///< cook these maps of copies; 0: the maps themselves
    fs::path write;                   ///< a folder: write such maps there, and cook nothing
    int runs = 1;                     ///< cooks of each scene and layout
};

/// Writes a scene of one light map whose materials need all shading, with a maximum error that no layout exceeds: the figures are wanted
/// here, not a verdict.
void writeScene(const fs::path& file, const std::string& name, const fs::path& lightMap, const std::string& layout) {
    std::ofstream(file) << fmt::format(
        "schema = 1\nname = \"{0}\"\n[output]\nmax_error = 1000.0\nlight_map_layout = \"{1}\"\n"
        "[[light_map]]\nname = \"lightmap\"\nfile = \"{2}\"\n"
        "[[material]]\nname = \"*\"\nnormal_map = true\nspecular = true\nm = [0.1, 0.5]\nf0 = [0.04, 0.6]\n",
        name, layout, fs::absolute(lightMap).string());
}

struct Row {
    std::string scene, layout;
    Json lightMap = {};       ///< the light map's entry of report.json
    double seconds = 0;       ///< median of the runs
    double userSeconds = 0;   ///< processor time of a run, median
    double secondsAgain = 0;  ///< of a second cook of the unchanged scene
    std::int64_t peakRssBytes = 0;
    std::int64_t gpuBytes = 0;  ///< of the scene
};

double medianOf(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

/// Runs a cook. Throws std::runtime_error with its output if it fails.
/// what  the name of the cook for the error
ProgramRun cookOnce(const std::vector<std::string>& command, const fs::path& log, const std::string& what) {
    const ProgramRun cooked = runProgram(command, log);
    if (cooked.exitCode != 0) throw std::runtime_error(fmt::format("{}: exit code {}: {}", what, cooked.exitCode, contentOf(log)));
    return cooked;
}

/// Cooks a scene of one light map `runs` times with an empty cache, and once more unchanged.
/// more  further words of the command
Row cook(const Options& options, const fs::path& program, const std::string& scene, const fs::path& sceneFile, const std::string& layout,
         const std::vector<std::string>& more = {}) {
    const TemporaryFolder folder;
    const fs::path out = folder.path() / "out", log = folder.path() / "log";
    ::setenv("LIGHTCOOK_CACHE", (folder.path() / "cache").c_str(), 1);
    std::vector<std::string> command = {program.string(), "cook", sceneFile.string(), "-o", out.string()};
    command.insert(command.end(), more.begin(), more.end());
    const std::string what = fmt::format("{} {}", scene, layout);
    Row row{scene, layout};
    std::vector<double> seconds, userSeconds;
    for (int i = 0; i < options.runs; ++i) {
        fs::remove_all(folder.path() / "cache");
        fs::remove_all(out);
        const ProgramRun cooked = cookOnce(command, log, what);
        seconds.push_back(cooked.seconds);
        userSeconds.push_back(cooked.userSeconds);
        row.peakRssBytes = std::max(row.peakRssBytes, cooked.peakRssBytes);
    }
    row.seconds = medianOf(std::move(seconds));
    row.userSeconds = medianOf(std::move(userSeconds));
    row.secondsAgain = cookOnce(command, log, what + ", again").seconds;
    const Json report = Json::parse(contentOf(out / "report.json"));
    row.gpuBytes = report.at("budget").at("used_bytes").get<std::int64_t>();
    for (const Json& asset : report.at("assets")) {
        if (asset.at("kind") == "light-map") row.lightMap = asset;
    }
    if (row.lightMap.is_null()) throw std::runtime_error(fmt::format("{} {}: no light map in report.json", scene, layout));
    return row;
}

/// Returns a figure of the error of the last stage, which is the verdict.
/// kind  "diffuse" or "specular"
double verdict(const Row& row, const char* kind, const char* figure) {
    return row.lightMap.at("stages").back().at("error").at(kind).at(figure).get<double>();
}

std::string percent(double fraction) {
    const double value = 100 * fraction;
    return fmt::format("{:.{}f}", value, value < 10 ? 2 : 1);
}

void printHead() {
    printTableHead({"scene", ">size", "layout", ">bits/texel", ">GPU KiB", ">disk KiB", ">diffuse %", ">specular %", ">p99 %",
                    ">max sampled %", ">max bound %", ">s", ">CPU us/texel", ">unchanged s", ">peak MiB"});
}

void printRow(const Row& row) {
    const auto pair = [&row](const char* figure) {
        return percent(verdict(row, "diffuse", figure)) + " / " + percent(verdict(row, "specular", figure));
    };
    const int width = row.lightMap.at("width").get<int>(), height = row.lightMap.at("height").get<int>();
    printTableRow("{} | {} | {} | {:g} | {} | {} | {} | {} | {} | {} | {} | {:.2f} | {:.2f} | {:.3f} | {}", row.scene, width, row.layout,
                  row.lightMap.at("bits_per_texel").get<double>(), row.lightMap.at("bytes_gpu").get<std::int64_t>() / 1024,
                  row.lightMap.at("bytes_disk").get<std::int64_t>() / 1024, percent(verdict(row, "diffuse", "rel_rms")),
                  percent(verdict(row, "specular", "rel_rms")), pair("p99"), pair("max_sampled"), pair("max_bound"), row.seconds,
                  1e6 * row.userSeconds / width / height, row.secondsAgain, row.peakRssBytes >> 20);
}

/// Returns the visible error (p99) of what a pixel shows; of a map without directions, that of its diffuse light.
double visibleOf(const Json& map) {
    if (map.contains("whole")) return map.at("whole").at("visible").at("p99").get<double>();
    return map.at("stages").back().at("error").at("diffuse").at("visible").at("p99").get<double>();
}

/// Writes and cooks the scene of a light map and of the files beside it whose names begin with its own, as a new user would; then with the
/// layouts that were chosen, and no others.
void benchDraft(const Options& options, const fs::path& program, const std::string& scene, const fs::path& lightMap) {
    const TemporaryFolder folder;
    const fs::path inputs = folder.path() / "scene", file = folder.path() / "scene.toml";
    fs::create_directory(inputs);
    for (const auto& entry : fs::directory_iterator(fs::absolute(lightMap).parent_path()))
        if (entry.path().filename().string().starts_with(scene)) fs::create_symlink(entry.path(), inputs / entry.path().filename());
    cookOnce({program.string(), "init", inputs.string(), "-o", file.string()}, folder.path() / "log", scene + ", init");
    const Row row = cook(options, program, scene, file, "as init writes it");
    const Json& map = row.lightMap;
    const std::string layout = map.at("layout").get<std::string>();
    const Row alone = cook(options, program, scene, file, layout, {"--layout", layout});
    const auto texels = map.at("width").get<std::int64_t>() * map.at("height").get<std::int64_t>();
    const int floats = formats::isFlat(layout) ? 3 : 27;
    printTableRow("{} | {:.4g} MiB | {:.2f} MiB | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f}", scene,
                  floats * 4 * static_cast<double>(texels) / (1 << 20), static_cast<double>(row.gpuBytes) / (1 << 20), layout,
                  visibleOf(map), row.seconds, alone.seconds, row.userSeconds, alone.userSeconds);
}

/// Returns the light maps that engines baked, without the ending of their names, of the shared data.
std::map<std::string, fs::path> engineMaps(const Options& options) {
    std::map<std::string, fs::path> maps;
    const fs::path folder = options.data / "engine_lightmaps";
    if (!fs::is_directory(folder)) return maps;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == ".exr" && entry.path().stem().string().find(options.scene) != std::string::npos)
            maps[entry.path().stem()] = entry.path();
    return maps;
}

Json toJson(const Row& row) {
    return {{"scene", row.scene},
            {"layout", row.layout},
            {"seconds", row.seconds},
            {"seconds_unchanged", row.secondsAgain},
            {"peak_rss_bytes", row.peakRssBytes},
            {"light_map", row.lightMap}};
}

/// Returns the light maps to cook. Writes those of the option --copies into a folder.
std::map<std::string, fs::path> mapsOf(const Options& options, const fs::path& folder) {
    std::map<std::string, fs::path> maps = sceneFiles(options.data, options.scene);
    if (options.tiled.columns == 0) return maps;
    for (auto& [scene, lightMap] : maps) {
        const fs::path tiled = folder / lightMap.filename();
        writeTiledMap(lightMap, tiled, options.tiled);
        lightMap = tiled;
    }
    return maps;
}

int benchScenes(const Options& options) {
    const TemporaryFolder written;
    const std::map<std::string, fs::path> maps = mapsOf(options, options.write.empty() ? written.path() : options.write);
    if (!options.write.empty()) return 0;
    const fs::path program = lightcookProgram();
    fmt::print(
        "Whole cooks with their verification, {} processors, {}. Errors are the verdict's; diffuse / specular where there are two.\n\n",
        ::sysconf(_SC_NPROCESSORS_ONLN), options.runs == 1 ? "one run" : fmt::format("median of {} runs", options.runs));
    printHead();
    Json rows = Json::array();
    for (const auto& [scene, lightMap] : maps) {
        for (const std::string& layout : options.layouts) {
            const TemporaryFolder folder;
            writeScene(folder.path() / "scene.toml", scene, lightMap, layout);
            const Row row = cook(options, program, scene, folder.path() / "scene.toml", layout);
            printRow(row);
            rows.push_back(toJson(row));
        }
    }
    if (!options.json.empty()) std::ofstream(options.json) << rows.dump(1) << '\n';
    if (options.tiled.columns > 0) return 0;
    fmt::print("\nWhole scenes as init writes them: a visible error (p99) of what a pixel shows within 5.\n\n");
    printTableHead({"scene", ">float bake", ">GPU", "light map, dominant light", ">visible", ">s", ">s of these alone", ">CPU s",
                    ">CPU s of these alone"});
    for (const auto& [scene, lightMap] : maps)
        if (fs::exists(lightMap.parent_path() / (scene + ".glb"))) benchDraft(options, program, scene, lightMap);
    for (const auto& [scene, lightMap] : engineMaps(options)) benchDraft(options, program, scene, lightMap);
    return 0;
}

}  // namespace
}  // namespace lightcook::bench

int main(int argumentCount, char** arguments) {
    lightcook::bench::Options options;
    CLI::App app("Time, memory, bytes and error of cooking light maps");
    app.add_option("--data", options.data, "folder that contains scenes/");
    app.add_option("--layouts", options.layouts, "light-map layouts to cook")->delimiter(',');
    app.add_option("--scene", options.scene, "cook only scenes whose name contains this");
    app.add_option("--runs", options.runs, "number of cooks of each; the median is reported")->check(CLI::Range(1, 99));
    app.add_option("--json", options.json, "write the rows to this file too");
    CLI::Option* const copies =
        app.add_option("--copies", options.tiled.columns,
                       "cook maps of this many copies in a row, each with its own factor, for time and memory at any size")
            ->check(CLI::Range(1, 64));
    CLI::Option* const rows = app.add_option("--rows", options.tiled.rows, "rows of copies in these maps; default: as many as columns")
                                  ->check(CLI::Range(1, 64))
                                  ->needs(copies);
    app.add_option("--period", options.tiled.period, "leave these maps empty but for each N-th copy of a row")
        ->check(CLI::Range(1, 64))
        ->needs(copies);
    app.add_flag("!--scan-lines", options.tiled.isTiled, "write these maps without tiles of OpenEXR")->needs(copies);
    app.add_option("--write", options.write, "write these maps to this folder, and cook nothing")->needs(copies);
    CLI11_PARSE(app, argumentCount, arguments);
    if (rows->empty()) options.tiled.rows = options.tiled.columns;
    try {
        return lightcook::bench::benchScenes(options);
    } catch (const std::exception& error) {
        fmt::print(stderr, "lightcook_bench: {}\n", error.what());
        return 1;
    }
}
