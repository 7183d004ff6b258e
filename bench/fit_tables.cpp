#include "bench/fit_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <string_view>
#include <vector>

#include "bench/cpu_time.h"
#include "bench/markdown_table.h"
#include "fit/specular_tables.h"

namespace lightcook::bench {
namespace {

using lighting::SpecularLobe;
struct Lobe {
    const char* name;
    SpecularLobe lobe;
};
constexpr std::array<Lobe, 3> kLobes = {{{"beckmann", SpecularLobe::Beckmann}, {"ggx", SpecularLobe::Ggx}, {"phong", SpecularLobe::Phong}}};

constexpr auto kEnergy = lighting::CookTorranceNormalization::Energy;

/// Errors of the factors C and D of area specular light.
struct Errors {
    double c = 0, d = 0;
};

/// Returns the largest differences of entries from an integral with 32 points a piece.
/// foundAt  returns the kernel to be measured at (NoV, m)
template <class Found>
Errors errorsOf(SpecularLobe lobe, const std::vector<double>& roughnesses, const std::vector<double>& views, const Found& foundAt) {
    Errors errors;
    for (const double m : roughnesses)
        for (const double NoV : views) {
            const lighting::AreaSpecularKernel found = foundAt(NoV, m);
            const lighting::AreaSpecularKernel truth = lighting::areaSpecular(NoV, m, lobe, kEnergy, 32);
            for (std::size_t i = 0; i < found.c.size(); ++i) {
                errors.c = std::max(errors.c, std::abs(found.c[i] - truth.c[i]));
                errors.d = std::max(errors.d, std::abs(found.d[i] - truth.d[i]));
            }
        }
    return errors;
}

/// Returns the errors of an integral with `points` points a piece, over roughnesses and views of all sizes.
Errors errorsOfPoints(SpecularLobe lobe, int points) {
    return errorsOf(lobe, {1e-4, 1e-3, 0.005, 0.03, 1.0 / 16, 0.1, 0.25, 0.5, 0.8, 1.0},
                    {1e-3, 0.01, 0.05, 1.0 / 7, 0.3, 0.5, 0.75, 0.9, 0.99, 1.0},
                    [&](double NoV, double m) { return lighting::areaSpecular(NoV, m, lobe, kEnergy, points); });
}

/// Returns the errors of a sum over samples, over the roughnesses and views that such a sum can handle.
Errors errorsOfSums(lighting::NormalDistribution distribution, SpecularLobe lobe, int samples) {
    return errorsOf(lobe, {1.0 / 16, 0.1, 0.25, 0.5, 1.0}, {1e-3, 0.05, 1.0 / 7, 0.5, 0.9, 1.0},
                    [&](double NoV, double m) { return lighting::integrateAreaSpecular(NoV, m, distribution, kEnergy, samples); });
}

void benchIntegrals(const std::filesystem::path& file, int runs, FitCurves& curves) {
    std::ofstream csv(file);
    csv << "lobe,way,samples,cpu_seconds,largest_error_c,largest_error_d\n";
    fmt::print("Twelve tables of 16 x 8, CPU seconds of one thread, best of {}; errors against 32 points a piece.\n\n", runs);
    printTableHead({"lobe", "way", ">samples", ">s", ">C", ">D"});
    const std::string panel = "twelve specular tables, 16 x 8";
    curves.describe(panel, "largest error of an entry");
    const auto report = [&](const char* lobe, const char* way, int samples, double seconds, const Errors& errors) {
        printTableRow("{} | {} | {} | {:.5f} | {:.1e} | {:.1e}", lobe, way, samples, seconds, errors.c, errors.d);
        csv << fmt::format("{},{},{},{},{},{}\n", lobe, way, samples, seconds, errors.c, errors.d);
        const bool isSum = std::string_view(way) == "samples an axis";
        curves.add({panel, isSum ? fmt::format("{}, samples an axis", lobe) : fmt::format("{}, points a piece", lobe),
                    fmt::format("{}", samples), seconds, std::max(errors.c, errors.d),
                    !isSum && samples == fit::SpecularTableOptions{}.pointCount});
    };
    for (const Lobe& lobe : kLobes) {
        for (const int points : {4, 6, 8, 10, 12, 16, 20, 24}) {
            fit::SpecularTableOptions options;
            options.lobe = lobe.lobe;
            options.pointCount = points;
            const double seconds = cpuSeconds(runs, [&] { static_cast<void>(fit::makeSpecularTables(options)); });
            report(lobe.name, "points a piece", points, seconds, errorsOfPoints(lobe.lobe, points));
        }
        if (lobe.lobe == SpecularLobe::Phong) continue;
        const auto distribution =
            lobe.lobe == SpecularLobe::Ggx ? lighting::NormalDistribution::Ggx : lighting::NormalDistribution::Beckmann;
        for (const int samples : {64, 256, 512}) {
            const double seconds = cpuSeconds(runs, [&] {
                for (int y = 0; y < 16; ++y)
                    for (int x = 0; x < 8; ++x)
                        static_cast<void>(
                            lighting::integrateAreaSpecular(std::max(1e-3, x / 7.0), (y + 1) / 16.0, distribution, kEnergy, samples));
            });
            report(lobe.name, "samples an axis", samples, seconds, errorsOfSums(distribution, lobe.lobe, samples));
        }
    }
}

void benchAxes(std::filesystem::path file) {
    file.replace_filename(file.stem().string() + "_axes" + file.extension().string());
    std::ofstream csv(file);
    csv << "lobe,views,rows,view_axis,roughness_axis,rel_rms_c,rel_rms_d,rel_rms_reflected,largest\n";
    fmt::print("\nError of a bilinear filter between exact nodes, percent, m 1/16 to 1, F0 0.04 and 0.6: C, D, both; the plain m.\n\n");
    printTableHead({"lobe", "views x rows", "view axis", ">C", ">D", ">reflected", ">largest"});
    for (const Lobe& lobe : kLobes)
        for (const auto& [views, rows] : {std::array{8, 16}, std::array{16, 8}}) {
            fit::SpecularTableOptions options;
            options.lobe = lobe.lobe;
            options.viewCount = views;
            options.roughnessCount = rows;
            for (const fit::MappingFigure& f : fit::mappingFigures(options, 0.04, 0.6)) {
                csv << fmt::format("{},{},{},{},{},{},{},{},{}\n", lobe.name, views, rows, f.view, f.roughness, f.c, f.d, f.reflected,
                                   f.worst);
                if (f.roughness == "m")
                    printTableRow("{} | {} x {} | `{}` | {:.2f} | {:.2f} | {:.2f} | {:.4f}", lobe.name, views, rows, f.view, 100 * f.c,
                                  100 * f.d, 100 * f.reflected, f.worst);
            }
        }
}

}  // namespace

void benchTables(const std::filesystem::path& csv, int runs, FitCurves& curves) {
    benchIntegrals(csv, runs, curves);
    benchAxes(csv);
}

}  // namespace lightcook::bench
