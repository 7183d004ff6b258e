#include "bench/fit_cubemaps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "bench/cpu_time.h"
#include "bench/markdown_table.h"
#include "bench/or_throw.h"
#include "fit/cubemap.h"
#include "fit/environment_sh.h"
#include "fit/irradiance.h"
#include "fit/pre_divide.h"
#include "lighting/cube.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"

namespace lightcook::bench {
namespace {

namespace fs = std::filesystem;
using fit::PrefilterKernel;
using formats::Environment;
using Strip = formats::Image<glm::vec3>;

struct Light {
    glm::dvec3 direction;
    double solidAngle;
    glm::dvec3 radiance;
};

/// Returns the lights that brute force sums over: the centres of pieces x pieces parts of every texel.
std::vector<Light> lightsOf(const Environment& environment, int pieces) {
    const int width = environment.texels.width() * pieces, height = environment.texels.height() * pieces;
    const bool isPanorama = environment.projection == Environment::Projection::Equirectangular;
    std::vector<Light> lights;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            lights.push_back({isPanorama ? lighting::directionFromEquirectangular({(x + 0.5) / width, (y + 0.5) / height})
                                         : lighting::cubeTexelDirection(y / width, x, y % width, width),
                              isPanorama ? lighting::equirectangularTexelSolidAngle(y, width, height)
                                         : lighting::cubeTexelSolidAngle(x, y % width, width),
                              glm::dvec3(environment.texels.at(x / pieces, y / pieces))});
    return lights;
}

/// Returns the mean radiance over the hemisphere around a direction, weighted by kernel(cosine of the angle to it).
glm::dvec3 bruteForce(const std::vector<Light>& lights, const std::function<double(double)>& kernel, const glm::dvec3& direction) {
    glm::dvec3 sum(0);
    double weightSum = 0;
    for (const Light& light : lights) {
        const double c = glm::dot(direction, light.direction);
        if (c <= 0) continue;
        const double weight = light.solidAngle * kernel(c);
        sum += weight * light.radiance;
        weightSum += weight;
    }
    return sum / weightSum;
}

/// Returns the prefilter kernel of roughness m as a function of the cosine of the angle between view and light, for a view along the
/// normal: the half vector h has (n . h)^2 = (1 + cosine) / 2.
std::function<double(double)> kernelOf(PrefilterKernel kernel, double m) {
    return [=](double c) {
        const double NoH2 = (1 + c) / 2, tan2 = (1 - c) / (1 + c), ggxRoot = NoH2 * (m * m - 1) + 1;
        if (kernel == PrefilterKernel::Beckmann) return std::exp(-tan2 / (m * m)) / (NoH2 * NoH2) * c;
        return kernel == PrefilterKernel::Ggx ? c / (ggxRoot * ggxRoot) : std::pow(c, (1 / (m * m) + 1) / 2);
    };
}

glm::dvec3 meanOf(const Strip& strip) {
    glm::dvec3 sum(0);
    const int size = strip.width();
    for (int y = 0; y < strip.height(); ++y)
        for (int x = 0; x < size; ++x) sum += lighting::cubeTexelSolidAngle(x, y % size, size) * glm::dvec3(strip.at(x, y));
    return sum / (4 * std::numbers::pi);
}

struct Errors {
    double median = 0, p95 = 0, worst = 0;
};

/// Returns the relative errors of `count` random texels of a mip level against brute force.
Errors errorsOf(const Strip& strip, const std::vector<Light>& lights, const std::function<double(double)>& kernel, int count) {
    const int size = strip.width();
    std::mt19937 random(static_cast<unsigned>(size));
    std::vector<double> errors;
    for (int i = 0; i < count; ++i) {
        const int x = static_cast<int>(random() % static_cast<unsigned>(size)),
                  row = static_cast<int>(random() % static_cast<unsigned>(6 * size));
        const glm::dvec3 expected = bruteForce(lights, kernel, lighting::cubeTexelDirection(row / size, x, row % size, size));
        for (int channel = 0; channel < 3; ++channel) errors.push_back(std::abs(strip.at(x, row)[channel] / expected[channel] - 1));
    }
    std::sort(errors.begin(), errors.end());
    return {errors[errors.size() / 2], errors[errors.size() * 95 / 100], errors.back()};
}

Environment load(const fs::path& file) {
    return orThrow(formats::loadEnvironment(file, {})).environment;
}

void benchChains(const std::string& name, const Environment& environment, int runs, std::ofstream& csv, FitCurves& curves) {
    constexpr const char* kNames[] = {"beckmann", "ggx", "phong"};
    const std::vector<Light> lights = lightsOf(environment, 1), fine = lightsOf(environment, 2);
    glm::dvec3 mean(0);
    for (const Light& light : lights) mean += light.solidAngle / (4 * std::numbers::pi) * light.radiance;
    for (const PrefilterKernel kernel : {PrefilterKernel::Beckmann, PrefilterKernel::Ggx, PrefilterKernel::Phong})
        for (const double cells : {2.0, 3.0, 4.0, 6.0}) {
            fit::CubemapOptions options;
            options.kernel = kernel;
            options.cellsPerKernelWidth = cells;
            std::vector<Strip> strips;
            std::vector<fit::MipKernel> mips;
            const double seconds = cpuSeconds(runs, [&] {
                const auto filter = fit::CubemapPrefilter::create(environment, options);
                mips = filter->mips();
                strips.clear();
                for (int mip = 0; mip < filter->mipCount(); ++mip) strips.push_back(filter->filterMip(mip));
            });
            Errors all, smallest;
            double energy = 0;
            for (std::size_t mip = 0; mip < strips.size(); ++mip) {
                const glm::dvec3 off = glm::abs(meanOf(strips[mip]) / mean - 1.0);
                energy = std::max({energy, off.x, off.y, off.z});
                if (mips[mip].m == 0) continue;
                const Errors errors = errorsOf(strips[mip], mip == 1 ? fine : lights, kernelOf(kernel, mips[mip].m), 24);
                Errors& into = mips[mip].size >= 4 ? all : smallest;
                into = {std::max(into.median, errors.median), std::max(into.p95, errors.p95), std::max(into.worst, errors.worst)};
            }
            printTableRow("{} | {} | {:g} | {:.2f} | {:.3f} | {:.3f} | {:.3f} | {:.2f} / {:.2f} | {:.1e}", name,
                          kNames[static_cast<int>(kernel)], cells, seconds, 100 * all.median, 100 * all.p95, 100 * all.worst,
                          100 * smallest.median, 100 * smallest.worst, energy);
            const std::string panel = fmt::format("cubemap chain, {} to 128 x 128 x 6, 8 levels", name);
            curves.describe(panel, "worst level's median against brute force");
            curves.add({panel, kNames[static_cast<int>(kernel)], fmt::format("{:g} cells", cells), seconds, all.median,
                        cells == fit::CubemapOptions{}.cellsPerKernelWidth});
            const std::string tail = fmt::format("cubemap chain, {}: 95th percentile", name);
            curves.describe(tail, "worst level's 95th percentile");
            curves.add({tail, kNames[static_cast<int>(kernel)], fmt::format("{:g} cells", cells), seconds, all.p95,
                        cells == fit::CubemapOptions{}.cellsPerKernelWidth});
            if (csv.is_open())
                csv << fmt::format("{},{},{},{},{},{},{},{},{},{}\n", name, kNames[static_cast<int>(kernel)], cells, seconds, all.median,
                                   all.p95, all.worst, smallest.median, smallest.worst, energy);
        }
}

/// Projects an environment onto SH by a sum over points x points directions a texel.
lighting::ShRgb shOfPoints(const Environment& environment, int points) {
    std::array<glm::dvec3, lighting::kShCount> sum{};
    for (const Light& light : lightsOf(environment, points)) {
        const lighting::ShDouble basis = lighting::evaluateBasis(light.direction);
        for (std::size_t i = 0; i < basis.size(); ++i) sum[i] += basis[i] * light.solidAngle * light.radiance;
    }
    lighting::ShRgb sh;
    for (std::size_t i = 0; i < sh.size(); ++i) sh[i] = glm::vec3(sum[i]);
    return sh;
}

/// Returns the largest difference of a coefficient, over coefficient 0 of b.
double differenceOf(const lighting::ShRgb& a, const lighting::ShRgb& b) {
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (int channel = 0; channel < 3; ++channel)
            worst = std::max(worst, std::abs(static_cast<double>(a[i][channel]) - b[i][channel]) / b[0][channel]);
    return worst;
}

void benchSh(const std::string& name, const Environment& environment, int runs, FitCurves& curves) {
    const std::string panel = "nine SH coefficients, " + name;
    curves.describe(panel, "largest error, over coefficient 0");
    // The error of the midpoint rule is of second order in the distance of the points. Richardson extrapolation of 4 and 8 points a side
    // leaves the fourth order.
    const lighting::ShRgb four = shOfPoints(environment, 4), eight = shOfPoints(environment, 8);
    lighting::ShRgb truth;
    for (std::size_t i = 0; i < truth.size(); ++i) truth[i] = glm::vec3((4.0 * glm::dvec3(eight[i]) - glm::dvec3(four[i])) / 3.0);
    lighting::ShRgb found;
    const double seconds = cpuSeconds(runs, [&] { found = fit::projectEnvironment(environment); });
    curves.add({panel, "exact integrals of the texels", "exact", seconds, differenceOf(found, truth), true});
    for (const int points : {1, 2, 4}) {
        const double each = cpuSeconds(1, [&] { found = shOfPoints(environment, points); });
        curves.add({panel, "sum over points", fmt::format("{} x {} a texel", points, points), each, differenceOf(found, truth)});
    }
}

/// Returns the exit radiance that nine coefficients give, as a cubemap.
Strip irradianceOfNine(const Environment& environment, int size) {
    const lighting::ShRgb exit = lighting::convolve(fit::projectEnvironment(environment), lighting::wrappedLambertBands(0));
    Strip strip(size, 6 * size);
    for (int row = 0; row < 6 * size; ++row)
        for (int x = 0; x < size; ++x) {
            const lighting::ShDouble basis = lighting::evaluateBasis(lighting::cubeTexelDirection(row / size, x, row % size, size));
            for (std::size_t i = 0; i < exit.size(); ++i) strip.at(x, row) += static_cast<float>(basis[i]) * exit[i];
        }
    return strip;
}

/// Measures projection onto SH and irradiance cubemaps.
void benchIrradiance(const std::string& name, const Environment& environment, int runs, FitCurves& curves) {
    const double sh = cpuSeconds(runs, [&] { fit::projectEnvironment(environment); });
    const std::string panel = fmt::format("irradiance, {} to 32 x 32 x 6", name);
    curves.describe(panel, "95th percentile against brute force");
    const std::vector<Light> lights = lightsOf(environment, 1);
    Strip strip(1, 6);
    const auto measure = [&](const char* series, const std::string& way, bool isDefault, const auto& make) {
        const double seconds = cpuSeconds(runs, [&] { strip = make(); });
        const Errors errors = errorsOf(
            strip, lights, [](double c) { return c; }, 60);
        curves.add({panel, series, way, seconds, errors.p95, isDefault});
        return std::pair(seconds, errors);
    };
    measure("nine SH coefficients", "9 coefficients", false, [&] { return irradianceOfNine(environment, 32); });
    measure("prefilter by Phong of exponent 1", "3 cells", false, [&] {
        fit::CubemapOptions options;
        options.size = 32;
        options.mipCount = 1;
        options.kernel = PrefilterKernel::Phong;
        options.roughness = {1};
        return fit::CubemapPrefilter::create(environment, options)->filterMip(0);
    });
    for (const int cells : {4, 8, 16, 32, 64}) {
        const bool isDefault = cells == fit::IrradianceOptions{}.cellsPerSide;
        const auto [seconds, errors] = measure("cells with exact moments", fmt::format("{} a side", cells), isDefault, [&] {
            return *fit::irradianceCubemap(environment, {32, 0, cells});
        });
        if (isDefault) printTableRow("{} | {:.4f} | {:.4f} | {:.4f} | {:.4f}", name, sh, seconds, 100 * errors.median, 100 * errors.worst);
    }
}

/// Sums over texels of the squared errors of three ways to shade a place without its own cubemap, and of its own squared values.
struct Relit {
    double divided = 0;    ///< the divided cubemap of another place, times the area specular of this place
    double unchanged = 0;  ///< the cubemap of another place as it is
    double area = 0;       ///< the area specular of this place alone
    double reference = 0;  ///< the cubemap of this place
    void add(double own, double relit, double other, double areaOnly) {
        divided += (relit - own) * (relit - own);
        unchanged += (other - own) * (other - own);
        area += (areaOnly - own) * (areaOnly - own);
        reference += own * own;
    }
    std::string line() const {
        return fmt::format("{:.1f} / {:.1f} / {:.1f}", 100 * std::sqrt(divided / reference), 100 * std::sqrt(unchanged / reference),
                           100 * std::sqrt(area / reference));
    }
};

/// Prints the errors of relighting: the divided cubemap of each probe of a scene times the area specular of each other probe, against the
/// cubemap of that other probe.
void benchRelighting(const fs::path& data, const std::string& scene) {
    std::vector<std::vector<Strip>> levels;
    std::vector<fit::PreDivide> divides, own;  // own: with SH that are not windowed, as those of a light map
    for (int probe = 0; fs::exists(data / "scenes" / fmt::format("{}_probe{}.exr", scene, probe)); ++probe) {
        const Environment environment = load(data / "scenes" / fmt::format("{}_probe{}.exr", scene, probe));
        fit::CubemapOptions options;
        options.size = 32;
        options.mipCount = 4;
        options.roughness = {0.08, 0.18, 0.33, 0.51};
        const auto filter = fit::CubemapPrefilter::create(environment, options);
        std::vector<lighting::ShBands> bands;
        levels.emplace_back();
        for (int mip = 0; mip < filter->mipCount(); ++mip) {
            levels.back().push_back(filter->filterMip(mip));
            bands.push_back(filter->mips()[static_cast<std::size_t>(mip)].bands);
        }
        divides.push_back(fit::makePreDivide(fit::projectEnvironment(environment), bands, {}));
        own.push_back(divides.back());
        own.back().windowedSh = fit::projectEnvironment(environment);
    }
    if (levels.size() < 2) return;
    std::vector<std::string> cells = {scene};
    for (std::size_t mip = 0; mip < levels[0].size(); ++mip) {
        Relit relit;
        const int size = levels[0][mip].width();
        for (std::size_t a = 0; a < levels.size(); ++a)
            for (std::size_t b = 0; b < levels.size(); ++b)
                for (int row = 0; row < (a == b ? 0 : 6 * size); ++row)
                    for (int x = 0; x < size; ++x) {
                        const glm::dvec3 direction = lighting::cubeTexelDirection(row / size, x, row % size, size);
                        const glm::dvec3 from = divides[a].denominator(static_cast<int>(mip), direction);
                        const glm::dvec3 to = glm::max(own[b].denominator(static_cast<int>(mip), direction), 0.0);
                        for (int c = 0; c < 3; ++c) {
                            const double other = levels[a][mip].at(x, row)[c];
                            relit.add(levels[b][mip].at(x, row)[c], other / from[c] * to[c], other, to[c]);
                        }
                    }
        cells.push_back(relit.line());
    }
    printTableRow(cells);
}

}  // namespace

void benchCubemaps(const fs::path& data, const fs::path& csvFile, int runs, FitCurves& curves) {
    std::ofstream csv;
    if (!csvFile.empty()) {
        csv.open(csvFile);
        csv << "panorama,kernel,cells_per_kernel_width,cpu_seconds,median,p95,worst,median_2x2_1x1,worst_2x2_1x1,mean_off\n";
    }
    std::vector<std::pair<std::string, Environment>> panoramas;
    for (const char* name : {"rooitou_park_1k", "kiara_1_dawn_1k"})
        if (fs::exists(data / "env" / (std::string(name) + ".hdr")))
            panoramas.emplace_back(name, load(data / "env" / (std::string(name) + ".hdr")));
    if (panoramas.empty()) return;
    fmt::print(
        "\nCubemaps: CPU seconds of one thread from panorama to 128x128x6 with 8 levels, best of {}; worst level of 4 x 4 texels and more, "
        "24 "
        "texels each, against brute force, %; the same of 2 x 2 and 1 x 1, which have the source's mean instead; mean of any level against "
        "the source's.\n\n",
        runs);
    printTableHead({"panorama", "kernel", ">cells", ">s", ">median %", ">p95 %", ">worst %", ">2x2, 1x1: median / worst %", ">mean off"});
    for (const auto& [name, environment] : panoramas) benchChains(name, environment, runs, csv, curves);
    // Figures of other programs for a chain of the same size: whole processes, see docs/lab/fit.md.
    for (const auto& [name, environment] : panoramas) {
        const std::string panel = fmt::format("cubemap chain, {} to 128 x 128 x 6, 8 levels", name);
        curves.add({panel, "others, GGX, quoted", "cmgen 1.9.25", 2.26, 0.01, false, true});
        curves.add({panel, "others, GGX, quoted", "glTF-IBL-Sampler", 5.2, 0.0175, false, true});
    }
    fmt::print("\n");
    printTableHead({"panorama", ">SH, s", ">irradiance 32x32x6, s", ">median %", ">worst %"});
    for (const auto& [name, environment] : panoramas) benchIrradiance(name, environment, runs, curves);
    if (const fs::path probe = data / "scenes" / "cornell_probe0.exr"; fs::exists(probe))
        panoramas.emplace_back("cornell_probe0", load(probe));
    for (const auto& [name, environment] : panoramas) benchSh(name, environment, runs, curves);
    fmt::print(
        "\nRelighting, all pairs of a scene's probes, relative RMS in %: divided cubemap of a place times another's area specular / the "
        "place's cubemap as it is / area specular alone.\n\n");
    printTableHead({"scene", ">m 0.08", ">0.18", ">0.33", ">0.51"});
    for (const char* scene : {"cornell", "interior", "outdoor", "zdm2_sun"}) benchRelighting(data, scene);
}

}  // namespace lightcook::bench
