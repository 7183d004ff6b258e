// lightcook_peers: compares light-map layouts of other engines with our own, by the same bakes, block encoders and score. It reports the
// error of a layout's basis, before any encoding, apart from the whole error.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/curve.h"
#include "bench/markdown_table.h"
#include "bench/or_throw.h"
#include "bench/our_layouts.h"
#include "bench/output_file.h"
#include "bench/peer_layouts.h"
#include "bench/scene_files.h"
#include "verify/light_map.h"

namespace lightcook::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Options {
    fs::path data = LIGHTCOOK_SHARED_DATA, json, csv, html;
    std::string scene;                 ///< only scenes whose name contains this
    std::vector<std::string> layouts;  ///< layouts to measure; empty: all
    int effort = 5;
};

struct Score {
    verify::ErrorFigures diffuse, specular;
};
struct Row {
    std::string scene, layout, what;
    bool ours = false;
    double bits = 0;
    Score basis, total;
};

/// A figure of a row, in tables and files: a fraction, or else just noticeable differences.
struct Column {
    const char* name;
    double (*value)(const Row&);
    bool isPercent = true;
};
constexpr std::array<Column, 12> kFigures = {{
    {"diffuse_rel_rms", [](const Row& row) { return row.total.diffuse.relRms; }},
    {"diffuse_p99", [](const Row& row) { return row.total.diffuse.p99; }},
    {"specular_rel_rms", [](const Row& row) { return row.total.specular.relRms; }},
    {"specular_p99", [](const Row& row) { return row.total.specular.p99; }},
    {"visible_diffuse_p99", [](const Row& row) { return row.total.diffuse.visible->p99; }, false},
    {"visible_diffuse_p999", [](const Row& row) { return row.total.diffuse.visible->p999; }, false},
    {"visible_specular_p99", [](const Row& row) { return row.total.specular.visible->p99; }, false},
    {"visible_specular_p999", [](const Row& row) { return row.total.specular.visible->p999; }, false},
    {"basis_diffuse_rel_rms", [](const Row& row) { return row.basis.diffuse.relRms; }},
    {"basis_diffuse_p99", [](const Row& row) { return row.basis.diffuse.p99; }},
    {"basis_specular_rel_rms", [](const Row& row) { return row.basis.specular.relRms; }},
    {"basis_specular_p99", [](const Row& row) { return row.basis.specular.p99; }},
}};

/// Measures the shading of a decoded bake against the bake itself.
Score scoreOf(const verify::LightMapScore& score, const Bake& bake, const formats::Image<lighting::ShRgb>& result) {
    constexpr int kRows = 64;  // of a task
    std::vector<verify::ShadedErrors> parts(static_cast<std::size_t>((bake.height() + kRows - 1) / kRows));
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
        const int firstRow = static_cast<int>(i) * kRows;
        parts[i] = score.score(bake.strip, result.view().rows(firstRow, std::min(kRows, bake.height() - firstRow)), firstRow);
    });
    verify::ShadedErrors whole;
    for (const auto& part : parts) whole.merge(part);
    return {whole.diffuseFigures(), whole.specularFigures()};
}

/// Returns a fraction in percent.
std::string percent(double fraction) {
    return 100 * fraction < 0.00005 ? "0" : threeDigits(100 * fraction);
}

std::vector<std::string> cellsOf(const Row& row) {
    std::vector<std::string> cells = {row.layout, fmt::format("{:.{}f}", row.bits, row.bits == std::round(row.bits) ? 0 : 2)};
    for (const Column& column : kFigures)
        cells.push_back(column.isPercent ? percent(column.value(row)) : fmt::format("{:.1f}", column.value(row)));
    return cells;
}

/// Prints a Markdown table whose columns are also aligned on a terminal: the first to the left, numbers to the right.
void printTable(const std::string& title, const std::vector<Row>& rows) {
    std::vector<std::vector<std::string>> lines = {{"layout", "bits", "diffuse", "p99", "specular", "p99", "visible: diffuse p99", "p99.9",
                                                    "specular p99", "p99.9", "basis: diffuse", "p99", "specular", "p99"}};
    for (const Row& row : rows) lines.push_back(cellsOf(row));
    std::vector<std::size_t> widths(lines.front().size(), 3);
    for (const auto& line : lines)
        for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
    fmt::print("\n{}\n\n", title);
    for (std::size_t n = 0; n < lines.size(); ++n) {
        for (std::size_t i = 0; i < widths.size(); ++i)
            fmt::print(fmt::runtime(i == 0 ? "| {:<{}} " : "| {:>{}} "), lines[n][i], widths[i]);
        fmt::print("|\n");
        if (n > 0) continue;
        for (std::size_t i = 0; i < widths.size(); ++i) fmt::print("| {}{} ", std::string(widths[i] - 1, '-'), i == 0 ? '-' : ':');
        fmt::print("|\n");
    }
    std::fflush(stdout);
}

std::string csvOf(const std::vector<Row>& rows) {
    std::string text = "scene,layout,ours,bits_per_texel";
    for (const Column& column : kFigures) text += fmt::format(",{}", column.name);
    text += "\n";
    for (const Row& row : rows) {
        text += fmt::format("{},{},{},{:.6g}", row.scene, row.layout, row.ours ? 1 : 0, row.bits);
        for (const Column& column : kFigures) text += fmt::format(",{:.6g}", column.value(row));
        text += "\n";
    }
    return text;
}

Json toJson(const Row& row) {
    Json json = {{"scene", row.scene}, {"layout", row.layout}, {"what", row.what}, {"ours", row.ours}, {"bits_per_texel", row.bits}};
    for (const Column& column : kFigures) json[column.name] = column.value(row);
    return json;
}

CurvePanel panelOf(const std::string& scene, const std::vector<Row>& rows) {
    CurvePanel panel{scene, {}};
    for (const Row& row : rows)
        if (row.scene == scene)
            panel.points.push_back({row.layout,
                                    fmt::format("{}: {:.4g} bits, diffuse {} %, specular {} %; basis alone {} % and {} %", row.what,
                                                row.bits, percent(row.total.diffuse.relRms), percent(row.total.specular.relRms),
                                                percent(row.basis.diffuse.relRms), percent(row.basis.specular.relRms)),
                                    row.bits, 100 * row.total.diffuse.relRms, 100 * row.total.specular.relRms, row.ours});
    return panel;
}

/// Returns the light maps to measure. Throws if there is none.
std::map<std::string, fs::path> findScenes(const Options& options) {
    auto scenes = sceneFiles(options.data, options.scene);
    if (scenes.empty()) throw std::runtime_error("--scene: no scene has a name that contains '" + options.scene + "'");
    return scenes;
}

/// A layout to measure, of another engine or of ours.
struct Candidate {
    std::string name, what;
    bool ours = false;
    std::function<PeerMaps(const Bake&, const fs::path&, int)> make;
};
/// Returns the layouts to measure. Throws if one of options.layouts does not exist.
std::vector<Candidate> candidates(const Options& options) {
    std::vector<Candidate> all;
    for (const PeerLayout& peer : peerLayouts())
        all.push_back(
            {peer.name, peer.what, false, [&peer](const Bake& bake, const fs::path&, int effort) { return peer.make(bake, effort); }});
    for (const std::string& name : ourLayouts())
        all.push_back({name, "lightcook, layout " + name, true,
                       [name](const Bake& bake, const fs::path& file, int effort) { return cookLayout(bake, file, name, effort); }});
    for (const std::string& name : options.layouts)
        if (std::ranges::none_of(all, [&](const Candidate& each) { return each.name == name; })) {
            std::string known;
            for (const Candidate& each : all) known += (known.empty() ? "" : ", ") + each.name;
            throw std::runtime_error(fmt::format("--layouts: '{}' is none of {}", name, known));
        }
    std::erase_if(all, [&](const Candidate& each) {
        return !options.layouts.empty() && std::ranges::find(options.layouts, each.name) == options.layouts.end();
    });
    return all;
}

/// Measures all layouts on one light map and prints them as a table.
std::vector<Row> measureScene(const Options& options, const std::string& scene, const fs::path& file) {
    const Bake bake = readBake(file);
    verify::LightMapKey key;
    key.add(bake.strip, 0, bake.height());
    const verify::Viewing viewing{lighting::DisplaySettings{}.of(key.displayKey())};
    const auto score = orThrow(verify::LightMapScore::create({}, bake.measure.key(), viewing));
    std::vector<Row> rows;
    for (const Candidate& each : candidates(options)) {
        const PeerMaps maps = each.make(bake, file, options.effort);
        rows.push_back(
            {scene, each.name, each.what, each.ours, maps.bitsPerTexel, scoreOf(score, bake, maps.ideal), scoreOf(score, bake, maps.seen)});
    }
    std::ranges::stable_sort(rows, {}, &Row::bits);
    printTable(fmt::format("{}, {} x {}", scene, bake.width(), bake.height()), rows);
    return rows;
}

void measureAll(const Options& options) {
    fmt::print(
        "Percent of shaded exit radiance at texel centres, against the float bake: rel_rms and 99th percentile of the local relative "
        "error. 'visible': 99th and 99.9th percentile in just noticeable differences (Delta E ITP).\n"
        "Block encoders at effort {}. 'basis' is the layout's form without coding (ours: with 16 bits a channel).\n",
        options.effort);
    std::vector<Row> rows;
    std::vector<CurvePanel> panels;
    Json json = Json::array();
    for (const auto& [scene, file] : findScenes(options)) {
        const std::vector<Row> fresh = measureScene(options, scene, file);
        panels.push_back(panelOf(scene, fresh));
        for (const Row& row : fresh) json.push_back(toJson(row));
        rows.insert(rows.end(), fresh.begin(), fresh.end());
    }
    if (!options.json.empty()) writeOutput(options.json, json.dump(1) + "\n");
    if (!options.csv.empty()) writeOutput(options.csv, csvOf(rows));
    if (!options.html.empty())
        writeOutput(
            options.html,
            curvePage("Light-map layouts: bits against error",
                      {fmt::format("rel_rms of shaded exit radiance at texel centres against the float bake, every layout scored by the "
                                   "same code. All blocks by lightcook's encoders at effort {}.",
                                   options.effort),
                       "Other engines' layouts are written from what is published of them. l1-truncation and nine-rgba16f are no "
                       "engine's: four coefficients in floats, and nine in halfs."},
                      "diffuse", "area specular", panels));
}

}  // namespace
}  // namespace lightcook::bench

int main(int argumentCount, char** arguments) {
    lightcook::bench::Options options;
    CLI::App app("Light-map layouts of other engines and our own: bits a texel against error, on the same bakes by the same score.");
    app.add_option("--data", options.data, "folder that contains scenes/");
    app.add_option("--scene", options.scene, "measure only scenes whose name contains this");
    app.add_option("--layouts", options.layouts, "layouts to measure")->delimiter(',');
    app.add_option("--effort", options.effort, "effort of the block encoders")->check(CLI::Range(0, 9));
    app.add_option("--json", options.json, "write a row for each scene and layout to this file");
    app.add_option("--csv", options.csv, "write the same as CSV; errors are fractions");
    app.add_option("--html", options.html, "write the curves to this page");
    CLI11_PARSE(app, argumentCount, arguments);
    try {
        lightcook::bench::measureAll(options);
        return 0;
    } catch (const std::exception& error) {
        fmt::print(stderr, "lightcook_peers: {}\n", error.what());
        return 1;
    }
}
