// Right work passes and is warned of nowhere: a matrix of kinds of light x layouts x targets x settings, cooked with no limit but those
// that the program sets itself. Each cook must end without an error, and lint must find nothing.
//
// The settings of a cook are effort, objective and materials. RightWorkSoak runs the whole product in random order, and the public scenes
// under every layout. RightWork runs a tenth of the kinds x layouts x targets, with one of the settings each: another tenth and other
// settings every day, so that ten days of CI see every place of the matrix. LIGHTCOOK_RIGHT_WORK_DAY names a day, to repeat what failed on
// it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "bench/light_kinds.h"
#include "formats/light_map_layout.h"
#include "formats/light_map_objective.h"
#include "formats/target.h"
#include "pipeline/cook/cook.h"
#include "tests/formats/temporary_folder.h"
#include "tests/soak/soak.h"

namespace lightcook::pipeline {
namespace {

constexpr int kSize = 48;  ///< of a map [texels]
constexpr int kEfforts[] = {0, 5, 9};
/// Tables of a scene: every shading, no direction at all, a range of roughness.
constexpr const char* kMaterials[] = {
    "", "[[material]]\nname = \"*\"\nnormal_map = false\nspecular = false\n",
    "[[material]]\nname = \"*\"\nnormal_map = true\nspecular = true\nm = [0.3, 0.6]\nf0 = [0.04, 0.04]\n"};
constexpr int kSettings = 3 * 2 * 3;

/// A place of the matrix.
struct Cell {
    std::string kind, layout;
    formats::Target target;
    int setting;  ///< 0 .. kSettings - 1
};

/// The days since 1970.
int today() {
    if (const char* day = std::getenv("LIGHTCOOK_RIGHT_WORK_DAY")) return std::atoi(day);
    return static_cast<int>(std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now()).time_since_epoch().count());
}

/// Returns all layouts that need no mesh, and "auto".
std::vector<std::string> layoutsWithoutMesh() {
    std::vector<std::string> layouts = {kAutoLayout};
    for (const std::string& layout : lightMapLayoutNames())
        if (!formats::isInTangentSpace(layout)) layouts.push_back(layout);
    return layouts;
}

/// Returns true for layouts of engines, whose halves hold light in the engine's unit: other units are no right work for them.
bool isInEngineUnit(const std::string& layout) {
    const auto known = formats::lightMapLayoutFromName(layout);
    return known && formats::info(*known).isForEngine;
}

std::vector<Cell> cellsOf(std::span<const bench::LightKind> kinds) {
    std::vector<Cell> cells;
    for (const bench::LightKind& kind : kinds)
        for (const std::string& layout : layoutsWithoutMesh())
            for (const formats::TargetInfo& target : formats::allTargets())
                if (!isInEngineUnit(layout) || (kind.name != "tiny" && kind.name != "huge"))
                    cells.push_back({std::string(kind.name), layout, target.id, 0});
    return cells;
}

class Matrix {
public:
    /// Cooks a place, and reports what is refused or warned of.
    void cook(const Cell& cell) {
        const std::filesystem::path file = fileOf(cell.kind);
        const std::string materials = kMaterials[cell.setting / 6];
        // A scene in another unit says what white is.
        const std::string display = cell.kind == "tiny"   ? "[display]\nwhite = 1e-6\n"
                                    : cell.kind == "huge" ? "[display]\nwhite = 1e6\n"
                                                          : "";
        // Texels of charts of one texel have no neighbours, beside which a firefly could be told.
        const char* entry = cell.kind == "single-texels" ? "firefly_limit = 0\n" : "";
        formats::writeContent(folder_ / "scene.toml", fmt::format("schema = 1\nname = \"right\"\n{}[[light_map]]\nname = \"map\"\nfile = "
                                                                  "\"{}\"\n{}{}",
                                                                  display, file.string(), entry, materials));
        CookOptions options;
        options.scene = folder_ / "scene.toml";
        options.output = folder_ / "out";
        options.cache = folder_ / "cache";
        options.onlyKind = "light-map";
        options.given.set("output.target", std::string(formats::info(cell.target).name));
        if (cell.target != formats::Target::Float) options.given.set("output.effort", kEfforts[cell.setting % 3]);
        options.given.set("output.objective", cell.setting / 3 % 2 == 0 ? "visible" : "energy");
        if (cell.layout != kAutoLayout) options.given.set("output.light_map_layout", cell.layout);
        const RunState state;
        const Outcome outcome = cookScene(options, state);
        const std::string words =
            fmt::format("{}, {}, {}, effort {}, {}, materials {}", cell.kind, cell.layout, formats::info(cell.target).name,
                        kEfforts[cell.setting % 3], cell.setting / 3 % 2 == 0 ? "visible" : "energy", cell.setting / 6);
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << words << ": " << error.line();
        std::vector<Finding> warnings = outcome.findings;
        std::erase_if(warnings, [](const Finding& finding) { return finding.severity == LintSeverity::Note; });
        for (const Finding& finding : warnings) ADD_FAILURE() << words << ": " << info(finding.check).name << ": " << finding.found;
        Count& count = counts_[cell.layout];
        ++count.cooks;
        count.refused += outcome.errors.empty() ? 0 : 1;
        count.warned += warnings.empty() ? 0 : 1;
        if (outcome.report.is_object() && !outcome.report.at("assets").empty())
            if (const auto worst = outcome.report.at("assets")[0].find("worst_block"); worst != outcome.report.at("assets")[0].end())
                count.worstBlock = std::max(count.worstBlock, worst->at("visible").get<double>());
    }

    /// Prints a line for each layout.
    void print() const {
        Count all;
        for (const auto& [layout, count] : counts_) {
            fmt::print("{:14} {:5} cooks, {} refused, {} warned of, worst block {:.1f}\n", layout, count.cooks, count.refused, count.warned,
                       count.worstBlock);
            all.cooks += count.cooks;
            all.refused += count.refused;
            all.warned += count.warned;
        }
        fmt::print("{:14} {:5} cooks, {} refused, {} warned of\n", "all", all.cooks, all.refused, all.warned);
        test::countInSoak(all.cooks, "cooks of right work");
    }

private:
    struct Count {
        int cooks = 0, refused = 0, warned = 0;
        double worstBlock = 0;  ///< [just noticeable differences]
    };
    /// Returns the map of a kind, or the bake of a public scene.
    std::filesystem::path fileOf(const std::string& kind) {
        if (kind.ends_with(".exr")) return kind;
        const std::filesystem::path file = folder_ / (kind + ".exr");
        if (!std::filesystem::exists(file)) bench::writeLightKind(file, kind, kSize);
        return file;
    }

    formats::TemporaryFolder folder_;
    std::map<std::string, Count> counts_;
};

TEST(RightWork, ATenthOfTheMatrixPassesWithoutAWarning) {
    const int day = today();
    Matrix matrix;
    std::vector<Cell> cells = cellsOf(bench::lightKinds());
    for (std::size_t i = static_cast<std::size_t>(day % 10); i < cells.size(); i += 10) {
        cells[i].setting = static_cast<int>((i / 10 + static_cast<std::size_t>(day / 10)) % kSettings);
        matrix.cook(cells[i]);
    }
    matrix.print();
    fmt::print("day {}\n", day);
}

/// Cooks the places in random order, as many as there is time for.
void cookInTime(Matrix& matrix, std::vector<Cell> cells) {
    const test::SoakTime time;
    std::ranges::shuffle(cells, std::mt19937_64(test::soakSeed()));
    for (std::size_t i = 0; i < cells.size() && (i == 0 || !time.isOver()); ++i) matrix.cook(cells[i]);
    matrix.print();
}

TEST(RightWorkSoak, TheWholeMatrixPassesWithoutAWarning) {
    Matrix matrix;
    std::vector<Cell> cells;
    for (const Cell& cell : cellsOf(bench::lightKinds()))
        for (int setting = 0; setting < kSettings; ++setting) cells.push_back({cell.kind, cell.layout, cell.target, setting});
    cookInTime(matrix, std::move(cells));
}

TEST(RightWorkSoak, ThePublicScenesPassUnderEveryLayout) {
    const std::filesystem::path scenes = std::filesystem::path(LIGHTCOOK_SHARED_DATA) / "scenes";
    if (!std::filesystem::exists(scenes)) GTEST_SKIP() << "no shared data at " << scenes;
    Matrix matrix;
    std::vector<Cell> cells;
    for (const char* scene : {"cornell", "interior", "outdoor", "zdm2_sun"})
        for (const std::string& layout : layoutsWithoutMesh())
            cells.push_back({(scenes / (std::string(scene) + "_lightmap.exr")).string(), layout, formats::Target::Bc, 1});
    cookInTime(matrix, std::move(cells));
}

}  // namespace
}  // namespace lightcook::pipeline
