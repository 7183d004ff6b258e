// lightcook_verify_bench: processor time of cook and verification of a light map for each kind of light (light_kinds.h) and layout, beside
// that of the example's map, as a Markdown table. Verification promises at most 0.1 ms a texel on any map. It runs the program as a user
// would, on one thread and without its cache.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/light_kinds.h"
#include "bench/markdown_table.h"
#include "bench/or_throw.h"
#include "bench/run_program.h"
#include "formats/light_map.h"
#include "formats/light_map_layout.h"
#include "formats/temporary_folder.h"

namespace lightcook::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using formats::TemporaryFolder;

struct Options {
    int size = 128;
    std::vector<std::string> kinds;  ///< empty: all
    std::vector<std::string> layouts = {"ratio", "basis-4", "halo3", "sh4", "hdr-2", "flat"};
    fs::path beside = fs::path(LIGHTCOOK_SOURCE_DIR) / "examples/cornell/cornell_lightmap.exr";  ///< the map to compare with
    bool isUnity = false;  ///< inputs are those of bake format unity-directional
    fs::path write;        ///< a folder: write the inputs there, and do nothing else
    double limit = 0;      ///< most verification may take [ms a texel]; 0: no limit
};

struct Row {
    double cook = 0, verify = 0;  ///< user CPU [ms a texel]
    Json diffuse, specular;       ///< figures of the visible error of the whole
};

/// Runs a command of lightcook. Throws std::runtime_error with its output if it fails.
ProgramRun runChecked(const std::vector<std::string>& command, const fs::path& log) {
    const ProgramRun done = runProgram(command, log);
    if (done.exitCode != 0)
        throw std::runtime_error(fmt::format("{}: exit code {}: {}", fmt::join(command, " "), done.exitCode, contentOf(log)));
    return done;
}

/// Returns the number of texels of a bake: what is cooked may be smaller, for example of one colour.
double texelsOf(const fs::path& lightMap) {
    const auto reader = orThrow(formats::LightMapReader::open(lightMap, {}));
    return static_cast<double>(reader.width()) * reader.height();
}

/// Cooks and verifies a map on one thread.
Row measure(const fs::path& lightMap, const std::string& layout) {
    const TemporaryFolder folder;
    const fs::path out = folder.path() / "out", report = folder.path() / "report.json", log = folder.path() / "log";
    ::setenv("LIGHTCOOK_CACHE", (folder.path() / "cache").c_str(), 1);
    const std::string program = lightcookProgram().string();
    const ProgramRun cooked = runChecked({program, "lightmap", lightMap.string(), out.string(), "-j", "1", "--layout", layout,
                                          "--max-error", "1000", "--json", report.string()},
                                         log);
    const ProgramRun verified = runChecked({program, "verify", out.string(), "-j", "1"}, log);
    const Json json = Json::parse(contentOf(report));
    for (const Json& asset : json.at("assets")) {
        if (asset.at("kind") != "light-map") continue;
        const double perTexel = 1000 / texelsOf(lightMap);
        const Json& error = asset.at("stages").back().at("error");
        return {perTexel * cooked.userSeconds, perTexel * verified.userSeconds, error.at("diffuse").value("visible", Json()),
                error.at("specular").value("visible", Json())};
    }
    throw std::runtime_error(lightMap.string() + ": no light map in the report");
}

std::string boundOf(const Json& visible) {
    return visible.is_null() ? "-" : fmt::format("{:.3g}", visible.at("bound").get<double>());
}

/// Writes the input of a kind into a folder, and returns its first file.
fs::path writeInput(const fs::path& folder, const std::string& kind, const Options& options) {
    if (options.isUnity) {
        writeUnityLightKind(folder, kind, kind, options.size);
        return folder / (kind + "_light.exr");
    }
    const fs::path file = folder / (kind + ".exr");
    writeLightKind(file, kind, options.size);
    return file;
}

/// Returns false if a verification took longer than the limit.
bool benchVerification(const Options& options) {
    std::vector<std::string> kinds = options.kinds;
    if (kinds.empty())
        for (const LightKind& kind : lightKinds()) kinds.emplace_back(kind.name);
    if (!options.write.empty()) {
        fs::create_directories(options.write);
        for (const std::string& kind : kinds) writeInput(options.write, kind, options);
        return true;
    }
    std::vector<std::string> layouts = options.layouts;
    if (layouts == std::vector<std::string>{"all"}) {
        layouts.clear();
        for (const formats::LightMapLayoutInfo& layout : formats::kLightMapLayouts) layouts.emplace_back(layout.name);
    }
    const std::string beside = options.beside.stem().string();
    fmt::print("User CPU of whole commands on one thread, {} x {} texels, beside {}.\n\n", options.size, options.size, beside);
    printTableHead({"light", "layout", ">cook ms/texel", ">of that beside", ">verify ms/texel", ">of that beside", ">visible bound"});
    bool isWithin = true;
    std::map<std::string, Row> rowsBeside;
    const auto print = [&](const std::string& name, const std::string& layout, const Row& row) {
        const Row& other = rowsBeside.at(layout);
        printTableRow("{} | {} | {:.3f} | {:.2f} | {:.3f} | {:.2f} | {} / {}", name, layout, row.cook, row.cook / other.cook, row.verify,
                      row.verify / other.verify, boundOf(row.diffuse), boundOf(row.specular));
        isWithin = isWithin && (options.limit == 0 || row.verify <= options.limit);
    };
    for (const std::string& layout : layouts) {
        rowsBeside[layout] = measure(options.beside, layout);
        print(beside, layout, rowsBeside[layout]);
    }
    for (const std::string& kind : kinds) {
        const TemporaryFolder folder;
        const fs::path input = writeInput(folder.path(), kind, options);
        for (const std::string& layout : layouts) print(kind, layout, measure(input, layout));
    }
    return isWithin;
}

}  // namespace
}  // namespace lightcook::bench

int main(int argumentCount, char** arguments) {
    lightcook::bench::Options options;
    CLI::App app("Processor time of cook and verification for each kind of light and layout");
    app.add_option("--size", options.size, "texels a side of the generated maps")->check(CLI::Range(1, 8192))->capture_default_str();
    app.add_option("--kinds", options.kinds, "kinds of light; default: all")->delimiter(',');
    app.add_option("--layouts", options.layouts, "layouts of light maps, or all")->delimiter(',');
    app.add_option("--beside", options.beside, "the light map to compare with; default: that of the example")->check(CLI::ExistingFile);
    app.add_flag("--unity", options.isUnity, "bake the light as Unity does: bake format unity-directional");
    app.add_option("--limit", options.limit, "end with exit code 1 if a verification takes more than this [ms a texel]");
    app.add_option("--write", options.write, "write the generated maps to this folder, and measure nothing");
    CLI11_PARSE(app, argumentCount, arguments);
    try {
        return lightcook::bench::benchVerification(options) ? 0 : 1;
    } catch (const std::exception& error) {
        fmt::print(stderr, "lightcook_verify_bench: {}\n", error.what());
        return 1;
    }
}
