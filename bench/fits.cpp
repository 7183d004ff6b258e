// lightcook_fit_bench: run time against error of the fits, as Markdown tables, CSV and a page of scatter plots. Dominant lights
// (fit_dominant.h), specular tables (fit_tables.h), reflection maps (fit_rsrm.h) and cubemaps (fit_cubemaps.h).
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "bench/fit_cubemaps.h"
#include "bench/fit_curves.h"
#include "bench/fit_dominant.h"
#include "bench/fit_rsrm.h"
#include "bench/fit_tables.h"

int main(int argc, char** argv) {
    lightcook::bench::DominantBenchOptions options;
    options.data = LIGHTCOOK_SHARED_DATA;
    CLI::App app("Run time against error of the fits", "lightcook_fit_bench");
    app.add_option("--data", options.data, "folder of the shared data")->capture_default_str();
    app.add_option("--scene", options.scene, "measure only scenes whose name contains this");
    app.add_option("--csv", options.csv,
                   "write the table of dominant lights to this file as CSV, and those of reflection maps and cubemaps beside it");
    app.add_option("--runs", options.runs, "report the best of this many runs")->check(CLI::Range(1, 100))->capture_default_str();
    app.add_option("--samples", options.samples, "number of texels of a map that are searched densely")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    std::filesystem::path tables, curvesFolder;
    app.add_option("--tables", tables,
                   "measure only the specular tables (time against error, and axes) and write them to this file as CSV");
    app.add_option("--curves", curvesFolder, "write run time against error of every fit to this folder: fits.csv, fits.html");
    CLI11_PARSE(app, argc, argv);
    try {
        lightcook::bench::FitCurves curves;
        if (!tables.empty()) {
            lightcook::bench::benchTables(tables, options.runs, curves);
            return 0;
        }
        if (!curvesFolder.empty()) {
            std::filesystem::create_directories(curvesFolder);
            if (options.csv.empty()) options.csv = curvesFolder / "dominant.csv";
            lightcook::bench::benchTables(curvesFolder / "tables.csv", options.runs, curves);
        }
        lightcook::bench::benchDominantLights(options, curves);
        lightcook::bench::benchRsrm(options.data, options.csv, options.runs, curves);
        lightcook::bench::benchCubemaps(options.data,
                                        options.csv.empty() ? options.csv : std::filesystem::path(options.csv.string() + ".cubemaps.csv"),
                                        options.runs, curves);
        if (!curvesFolder.empty()) curves.write(curvesFolder);
    } catch (const std::exception& fault) {
        fmt::print(stderr, "{}\n", fault.what());
        return 1;
    }
    return 0;
}
