#include "bench/fit_dominant.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include "bench/cpu_time.h"
#include "bench/markdown_table.h"
#include "bench/or_throw.h"
#include "fit/dominant_light.h"
#include "fit/light_search.h"
#include "formats/light_map.h"
#include "lighting/brdf.h"
#include "lighting/sphere.h"

namespace lightcook::bench {
namespace {

namespace fs = std::filesystem;
using fit::DominantFit;

/// A whole light map.
struct Map {
    std::string name;
    formats::LightMapStrip strip;
    glm::vec3 weights;
    fs::path reference;  ///< brute-force values; empty if there are none
};

Map readMap(const std::string& name, const fs::path& file, const fs::path& reference) {
    const auto reader = orThrow(formats::LightMapReader::open(file, {}));
    return {name, orThrow(reader.read(0, reader.height())), reader.luminanceWeights(), reference};
}

/// Returns a synthetic map of 1024 x 1024 covered texels: three light sources whose directions vary over the map, ambient light and noise.
Map madeMap() {
    constexpr int kSize = 1024;
    Map map{"made", {}, lighting::kRec709Luminance, {}};
    map.strip.sh = formats::Image<lighting::ShRgb>(kSize, kSize);
    map.strip.covered = formats::Image<std::uint8_t>(kSize, kSize, 1);
    map.strip.normal = formats::Image<glm::vec3>(kSize, kSize, glm::vec3(0, 0, 1));
    std::mt19937 random(1);
    const auto noise = [&random] { return static_cast<float>(random()) / 4294967296.0f - 0.5f; };
    const std::array<glm::vec3, 3> colors = {glm::vec3(3, 2.5f, 2), glm::vec3(1, 2, 2.5f), glm::vec3(1.5f, 0.5f, 0.3f)};
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            lighting::ShRgb& sh = map.strip.sh.at(x, y);
            for (std::size_t source = 0; source < colors.size(); ++source) {
                const glm::vec3 towards(std::sin(0.01 * x + 2.0 * static_cast<double>(source)),
                                        std::cos(0.007 * y + static_cast<double>(source)), 0.8);
                const lighting::ShRgb light = lighting::projectDirectional(glm::normalize(towards), colors[source]);
                for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += light[i];
            }
            sh[0] += glm::vec3(0.5f, 0.6f, 0.8f);
            for (glm::vec3& c : sh) c += 0.1f * glm::vec3(noise(), noise(), noise());
        }
    return map;
}

/// Returns the light maps of the shared data, and a synthetic one.
std::vector<Map> readMaps(const DominantBenchOptions& options) {
    const std::string ending = "_lightmap.exr";
    std::map<std::string, fs::path> files;
    if (fs::is_directory(options.data / "scenes"))
        for (const auto& entry : fs::directory_iterator(options.data / "scenes")) {
            const std::string name = entry.path().filename();
            if (name.ends_with(ending)) files[name.substr(0, name.size() - ending.size())] = entry.path();
        }
    std::vector<Map> maps;
    for (const auto& [name, file] : files)
        if (name.find(options.scene) != std::string::npos)
            maps.push_back(readMap(name, file, file.parent_path() / (name + "_reference_a.csv")));
    maps.push_back(madeMap());
    return maps;
}

/// Returns the sum of the squared coefficients.
double energyOf(const lighting::ShRgb& sh) {
    double energy = 0;
    for (const glm::vec3& c : sh) energy += glm::dot(glm::dvec3(c), glm::dvec3(c));
    return energy;
}

/// Searches many directions, then around the best one in ever smaller steps. Returns fit::LightFit::unexplained of the result.
double denseSearch(const lighting::ShRgb& sh, bool hasAmbient) {
    constexpr int kDirections = 20000;
    double least = 2;
    glm::dvec3 best(0, 0, 1);
    const auto consider = [&](const glm::dvec3& direction) {
        const double unexplained = fit::lightTowards(sh, direction, hasAmbient).unexplained;
        if (unexplained >= least) return false;
        least = unexplained;
        best = direction;
        return true;
    };
    for (int i = 0; i < kDirections; ++i) consider(lighting::fibonacciSphere(i, kDirections));
    double step = 0.01;
    for (int halving = 0; halving < 14; ++halving, step *= 0.5)  // down to 1e-6
        for (bool improved = true; improved;) {
            improved = false;
            const glm::dmat3 frame = lighting::worldFromTangentFrame(best);
            const glm::dvec3 centre = best;
            for (int side = 0; side < 4; ++side)
                improved = consider(glm::normalize(centre + (side % 2 == 0 ? step : -step) * frame[side / 2])) || improved;
        }
    return least;
}

/// Measurements of a fit on a map.
struct Figures {
    double seconds = 0;                 ///< CPU, best of the runs, for 1024 x 1024 covered texels
    double skipped = 0;                 ///< share of covered texels that were not searched
    double unexplained = 0;             ///< share of the energy of the map
    std::array<double, 5> residuals{};  ///< at kPercentiles
    double worst = 0;                   ///< largest difference of a sample's residual from that of dense search
    int over = 0, samples = 0;          ///< samples with a difference above 1e-3, and all samples
};
constexpr std::array<double, 5> kPercentiles = {0.1, 0.25, 0.5, 0.75, 0.99};

/// Returns fit::LightFit::unexplained of a texel for the direction of a fit, without the fade of the textures.
double unexplainedBy(const Map& map, int x, int y, DominantFit which) {
    fit::DominantLightOptions options;
    options.luminanceWeights = map.weights;
    options.fadeStart = 0;
    options.fadeEnd = 1e-6f;
    options.fit = which;
    const fit::DominantLight light = fit::dominantLight(map.strip.sh.at(x, y), map.strip.normal.at(x, y), options);
    return fit::lightTowards(map.strip.sh.at(x, y), glm::normalize(glm::dvec3(light.direction)), which == DominantFit::RefinedAmbient)
        .unexplained;
}

/// Sets the seconds and the share of skipped texels.
void time(const Map& map, DominantFit which, int runs, Figures& figures) {
    fit::DominantLightOptions options;
    options.luminanceWeights = map.weights;
    options.fit = which;
    const int width = map.strip.sh.width(), height = map.strip.sh.height();
    formats::Image<glm::vec3> direction(width, height), intensity(width, height);
    fit::DominantCounts counts;
    const double best = cpuSeconds(runs, [&] {
        counts = fit::fitDominantLights(
            {map.strip.sh.view(), map.strip.covered.view(), map.strip.normal.view(), direction.view(), intensity.view()}, options);
    });
    const double texels = static_cast<double>(counts.refined + counts.skipped);
    figures.seconds = best * 1024 * 1024 / texels;
    figures.skipped = static_cast<double>(counts.skipped) / texels;
}

Figures measure(const Map& map, DominantFit which, const DominantBenchOptions& options) {
    Figures figures;
    time(map, which, options.runs, figures);
    std::vector<double> residuals;
    std::vector<std::array<int, 2>> places;
    double left = 0, energy = 0;
    for (int y = 0; y < map.strip.sh.height(); ++y)
        for (int x = 0; x < map.strip.sh.width(); ++x) {
            if (map.strip.covered.at(x, y) == 0) continue;
            const double unexplained = unexplainedBy(map, x, y, which), own = energyOf(map.strip.sh.at(x, y));
            places.push_back({x, y});
            residuals.push_back(std::sqrt(unexplained));
            left += unexplained * own;
            energy += own;
        }
    figures.unexplained = energy > 0 ? left / energy : 0;
    const std::size_t step = std::max<std::size_t>(1, places.size() / static_cast<std::size_t>(options.samples));
    for (std::size_t i = 0; i < places.size(); i += step) {
        const auto [x, y] = places[i];
        const double above = residuals[i] - std::sqrt(denseSearch(map.strip.sh.at(x, y), which == DominantFit::RefinedAmbient));
        figures.worst = std::max(figures.worst, above);
        figures.over += above > 1e-3 ? 1 : 0;
        ++figures.samples;
    }
    std::sort(residuals.begin(), residuals.end());
    for (std::size_t i = 0; i < kPercentiles.size() && !residuals.empty(); ++i)
        figures.residuals[i] = residuals[static_cast<std::size_t>(kPercentiles[i] * static_cast<double>(residuals.size() - 1))];
    return figures;
}

const char* nameOf(DominantFit which) {
    return which == DominantFit::Closed ? "halo3" : which == DominantFit::Refined ? "refined" : "refined-ambient";
}

/// Adds points for fits that the program does not offer, measured on evenly spread texels. Seconds are scaled to 1024 x 1024 texels,
/// residuals by the ratio of the refined fit's residual on the whole map and on these texels.
void addSampledWays(const Map& map, const std::string& panel, int sampleCount, double refinedLeft, FitCurves& curves) {
    std::vector<const lighting::ShRgb*> samples;
    for (std::size_t i = 0; i < map.strip.sh.texels().size(); ++i)
        if (map.strip.covered.texels()[i] != 0) samples.push_back(&map.strip.sh.texels()[i]);
    if (samples.empty()) return;
    const std::size_t step = std::max<std::size_t>(1, samples.size() / static_cast<std::size_t>(sampleCount));
    double refined = 0;
    for (std::size_t i = 0; i < samples.size(); i += step)
        refined += fit::bestLight(*samples[i], {0, 0, 1}, false).unexplained * energyOf(*samples[i]);
    if (!(refined > 0)) return;
    const auto add = [&](const char* way, const auto& unexplained) {
        double left = 0;
        std::size_t count = 0;
        const double seconds = cpuSeconds(1, [&] {
            for (std::size_t i = 0; i < samples.size(); i += step, ++count) {
                left += unexplained(*samples[i]) * energyOf(*samples[i]);
            }
        });
        curves.add({panel, map.name, way, seconds * 1024 * 1024 / static_cast<double>(count), std::sqrt(refinedLeft * left / refined)});
    };
    add("dense search", [](const lighting::ShRgb& sh) { return denseSearch(sh, false); });
    add("two lights", [](const lighting::ShRgb& sh) { return fit::bestTwoLights(sh, {0, 0, 1}, false).unexplained; });
}

void benchMaps(const std::vector<Map>& maps, const DominantBenchOptions& options, FitCurves& curves) {
    const std::string panel = "dominant light, 1024 x 1024 texels";
    curves.describe(panel, "root of the share of the SH's energy that is left");
    std::ofstream csv;
    if (!options.csv.empty()) {
        csv.open(options.csv);
        csv << "map,fit,cpu_seconds_per_1024x1024,skipped,unexplained_energy,residual_p10,residual_p25,residual_p50,residual_p75,residual_"
               "p99,samples,samples_over_1e-3,worst_above_dense_search\n";
    }
    fmt::print(
        "CPU seconds of one thread for 1024 x 1024 covered texels, best of {}. Residual: root of the squared error over the norm of the "
        "coefficients.\n\n",
        options.runs);
    printTableHead({"map", "fit", ">s", ">skipped %", ">energy left %", ">residual p10", ">p25", ">p50", ">p75", ">p99",
                    ">samples over 1e-3 above dense search", ">worst"});
    for (const Map& map : maps)
        for (const DominantFit which : {DominantFit::Closed, DominantFit::Refined, DominantFit::RefinedAmbient}) {
            const Figures f = measure(map, which, options);
            printTableRow("{} | {} | {:.3f} | {:.1f} | {:.2f} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {} of {} | {:.1e}", map.name,
                          nameOf(which), f.seconds, 100 * f.skipped, 100 * f.unexplained, f.residuals[0], f.residuals[1], f.residuals[2],
                          f.residuals[3], f.residuals[4], f.over, f.samples, f.worst);
            if (which == DominantFit::Refined) addSampledWays(map, panel, options.samples, f.unexplained, curves);
            curves.add({panel, map.name, nameOf(which), f.seconds, std::sqrt(f.unexplained), which == fit::DominantLightOptions{}.fit});
            if (csv.is_open())
                csv << fmt::format("{},{},{},{},{},{},{},{},{}\n", map.name, nameOf(which), f.seconds, f.skipped, f.unexplained,
                                   fmt::join(f.residuals, ","), f.samples, f.over, f.worst);
        }
}

/// A line of the brute-force values: reflected radiance towards a view.
struct Shaded {
    int x = 0, y = 0;
    double m = 0, f0 = 0;
    glm::dvec3 view{0}, radiance{0};
};

std::vector<Shaded> readShaded(const fs::path& file) {
    std::ifstream in(file);
    std::vector<Shaded> all;
    std::string line;
    while (std::getline(in, line)) {
        Shaded s;
        char kind[16];
        if (std::sscanf(line.c_str(), "%d,%d,%15[a-z],%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &s.x, &s.y, kind, &s.m, &s.f0, &s.view.x, &s.view.y,
                        &s.view.z, &s.radiance.x, &s.radiance.y, &s.radiance.z) == 11 &&
            std::string(kind) == "spec")
            all.push_back(s);
    }
    return all;
}

/// A shading point and the shading of a light source there.
class Surface {
public:
    Surface(const Shaded& shaded, const glm::dvec3& normal, const lighting::AreaSpecularKernel& kernel)
        : shaded_(shaded), normal_(normal), kernel_(kernel) {}
    glm::dvec3 fromLight(const fit::LightFit& light) const {
        return std::max(0.0, glm::dot(light.direction, normal_)) *
               lighting::cookTorrance(shaded_.view, light.direction, normal_, shaded_.m, shaded_.f0, lighting::NormalDistribution::Beckmann,
                                      lighting::CookTorranceNormalization::Energy) *
               light.intensity;
    }
    glm::dvec3 fromSh(const lighting::ShRgb& sh) const {
        const glm::dvec3 x = glm::normalize(shaded_.view - glm::dot(shaded_.view, normal_) * normal_);
        const lighting::ShRgb local = lighting::ShRotation(glm::transpose(glm::dmat3(x, glm::cross(normal_, x), normal_))).apply(sh);
        glm::dvec3 sum(0);
        for (std::size_t i = 0; i < local.size(); ++i)
            sum += (shaded_.f0 * kernel_.c[i] + (1 - shaded_.f0) * kernel_.d[i]) * glm::dvec3(local[i]);
        return sum;
    }
    /// Returns the specular light of a light source, and area specular light of the rest of the SH.
    glm::dvec3 fromBoth(const fit::LightFit& light, lighting::ShRgb sh) const {
        const lighting::ShRgb delta = lighting::projectDirectional(glm::vec3(light.direction), glm::vec3(light.intensity));
        for (std::size_t i = 0; i < sh.size(); ++i) sh[i] -= delta[i];
        return fromLight(light) + fromSh(sh);
    }

private:
    const Shaded& shaded_;
    glm::dvec3 normal_;
    const lighting::AreaSpecularKernel& kernel_;
};

/// Ways to shade specular light, in the order of the values of shadeAll().
const std::array<const char*, 9> kWays = {"area specular of the SH alone",
                                          "halo3",
                                          "refined",
                                          "refined-ambient, light alone",
                                          "two lights",
                                          "two lights and ambient, lights alone",
                                          "closed, and area specular of the rest",
                                          "refined, and area specular of the rest",
                                          "refined-ambient, and area specular of the rest"};

/// Sums of squared errors and of squared reference values, by way and m.
struct Sums {
    std::array<std::map<double, std::array<double, 2>>, kWays.size()> byM;
    void add(std::size_t way, const Shaded& shaded, const glm::dvec3& found) {
        const glm::dvec3 error = found - shaded.radiance;
        auto& sums = byM[way][shaded.m];
        sums[0] += glm::dot(error, error);
        sums[1] += glm::dot(shaded.radiance, shaded.radiance);
    }
};

Sums shadeAll(const Map& map) {
    Sums sums;
    std::map<std::array<int, 2>, lighting::AreaSpecularKernel> kernels;
    for (const Shaded& shaded : readShaded(map.reference)) {
        const lighting::ShRgb& sh = map.strip.sh.at(shaded.x, shaded.y);
        const glm::vec3 normal = map.strip.normal.at(shaded.x, shaded.y);
        const double NoV = glm::dot(glm::dvec3(normal), shaded.view);
        const auto [kernel, isNew] =
            kernels.try_emplace({static_cast<int>(std::lround(1000 * NoV)), static_cast<int>(std::lround(1000 * shaded.m))});
        if (isNew)
            kernel->second = lighting::integrateAreaSpecular(NoV, shaded.m, lighting::NormalDistribution::Beckmann,
                                                             lighting::CookTorranceNormalization::Energy, 256);
        const Surface surface(shaded, glm::dvec3(normal), kernel->second);
        fit::DominantLightOptions options;
        options.luminanceWeights = map.weights;
        const glm::dvec3 towards = glm::normalize(glm::dvec3(fit::dominantLight(sh, normal, options).direction));
        const fit::LightFit closed = fit::lightTowards(sh, towards, false), refined = fit::bestLight(sh, towards, false),
                            ambient = fit::bestLight(sh, towards, true);
        const fit::TwoLights two = fit::bestTwoLights(sh, towards, false), twoAmbient = fit::bestTwoLights(sh, towards, true);
        const std::array<glm::dvec3, kWays.size()> found = {surface.fromSh(sh),
                                                            surface.fromLight(closed),
                                                            surface.fromLight(refined),
                                                            surface.fromLight(ambient),
                                                            surface.fromLight(two.first) + surface.fromLight(two.second),
                                                            surface.fromLight(twoAmbient.first) + surface.fromLight(twoAmbient.second),
                                                            surface.fromBoth(closed, sh),
                                                            surface.fromBoth(refined, sh),
                                                            surface.fromBoth(ambient, sh)};
        for (std::size_t way = 0; way < found.size(); ++way) sums.add(way, shaded, found[way]);
    }
    return sums;
}

void benchSpecular(const std::vector<Map>& maps) {
    fmt::print("\nSpecular light against brute force, relative RMS in percent: all, and m of 0.1 / 0.25 / 0.5.\n\n| way |");
    std::vector<Sums> sums;
    for (const Map& map : maps)
        if (fs::exists(map.reference)) {
            fmt::print(" {} |", map.name);
            sums.push_back(shadeAll(map));
        }
    fmt::print("\n|---|");
    for (std::size_t i = 0; i < sums.size(); ++i) fmt::print("---|");
    for (std::size_t way = 0; way < kWays.size(); ++way) {
        fmt::print("\n| {} |", kWays[way]);
        for (const Sums& each : sums) {
            std::array<double, 2> all{};
            std::vector<std::string> byM;
            for (const auto& [m, parts] : each.byM[way]) {
                all[0] += parts[0];
                all[1] += parts[1];
                byM.push_back(fmt::format("{:.0f}", 100 * std::sqrt(parts[0] / parts[1])));
            }
            fmt::print(" {:.1f} ({}) |", 100 * std::sqrt(all[0] / all[1]), fmt::join(byM, " / "));
        }
    }
    fmt::print("\n");
}

}  // namespace

void benchDominantLights(const DominantBenchOptions& options, FitCurves& curves) {
    const std::vector<Map> maps = readMaps(options);
    benchMaps(maps, options, curves);
    if (std::any_of(maps.begin(), maps.end(), [](const Map& map) { return fs::exists(map.reference); })) benchSpecular(maps);
}

}  // namespace lightcook::bench
