#include "bench/fit_rsrm.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <glm/common.hpp>
#include <numbers>
#include <vector>

#include "bench/cpu_time.h"
#include "bench/markdown_table.h"
#include "fit/azimuthal_average.h"
#include "fit/cubemap/gauss_legendre.h"
#include "fit/rsrm.h"
#include "formats/environment.h"

namespace lightcook::bench {
namespace {

namespace fs = std::filesystem;
using Gradient = std::vector<glm::vec3>;
using std::numbers::pi;

/// The reference is computed for one texel of this many in each row.
constexpr int kReferenceStep = 17;

/// Returns the mean of max(0, r . l)^exponent over the azimuth of light directions l of height z, for a reflection vector r of height zo.
double azimuthMean(double z, double zo, double exponent) {
    static const fit::GaussRule<20> rule = fit::gaussLegendre<20>();
    const double level = z * zo, swing = std::sqrt(std::max(0.0, (1 - z * z) * (1 - zo * zo)));
    if (level + swing <= 0) return 0;
    const double least = (level + swing) * std::pow(1e-17, 1 / exponent);
    const double reach = swing == 0 || (least - level) / swing <= -1 ? pi : std::acos(std::min(1.0, (least - level) / swing));
    constexpr int kPieces = 3;
    double sum = 0;
    for (int piece = 0; piece < kPieces; ++piece)
        for (std::size_t i = 0; i < 20; ++i) {
            const double phi = reach * (piece + rule.point[i]) / kPieces;
            sum += rule.weight[i] / kPieces * std::pow(std::max(0.0, level + swing * std::cos(phi)), exponent);
        }
    return sum * reach / pi;
}

/// Returns a texel of the map by Gauss quadrature of its definition, in pieces between the edges of the zones and the kinks of the
/// integrand.
glm::dvec3 truth(const Gradient& gradient, double zo, double exponent) {
    static const fit::GaussRule<20> rule = fit::gaussLegendre<20>();
    const int count = static_cast<int>(gradient.size());
    const double reach = std::acos(std::pow(1e-16, 1 / exponent)), theta = std::acos(zo);
    const double high = std::cos(std::max(0.0, theta - reach)), low = std::cos(std::min(pi, theta + reach)), bend = std::sqrt(1 - zo * zo);
    std::vector<double> cuts = {low, high, zo, bend, -bend};
    for (int zone = 0; zone <= count; ++zone) cuts.push_back(1 - 2.0 * zone / count);
    for (int piece = 1; piece < 16; ++piece) cuts.push_back(low + (high - low) * piece / 16);
    std::sort(cuts.begin(), cuts.end());
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        const double from = std::max(low, cuts[i]), to = std::min(high, cuts[i + 1]);
        if (to <= from) continue;
        const int zone = std::clamp(static_cast<int>((1 - 0.5 * (from + to)) / 2 * count), 0, count - 1);
        double weight = 0;
        for (std::size_t k = 0; k < 20; ++k) weight += rule.weight[k] * azimuthMean(from + (to - from) * rule.point[k], zo, exponent);
        sum += (exponent + 1) * (to - from) * weight * glm::dvec3(gradient[static_cast<std::size_t>(zone)]);
    }
    return sum;
}

/// Returns the map by equation 1 of Stone's paper with its errata: one sample for each zone and azimuth, r . l clamped at 0, azimuths over
/// half a turn.
formats::Image<glm::dvec3> papersSum(const Gradient& gradient, const fit::RsrmOptions& options, int azimuths) {
    formats::Image<glm::dvec3> values(options.width, static_cast<int>(options.exponents.size()), glm::dvec3(0));
    const double zones = static_cast<double>(gradient.size());
    for (int row = 0; row < values.height(); ++row)
        for (int x = 0; x < options.width; ++x) {
            const double exponent = options.exponents[static_cast<std::size_t>(row)], zo = 1 - (2.0 * x + 1) / options.width;
            for (std::size_t zone = 0; zone < gradient.size(); ++zone) {
                const double z = 1 - (2.0 * static_cast<double>(zone) + 1) / zones;
                const double level = z * zo, swing = std::sqrt((1 - z * z) * (1 - zo * zo));
                double lobe = 0;
                for (int k = 0; k < azimuths; ++k)
                    lobe += std::pow(std::max(0.0, level + swing * std::cos(pi * (k + 0.5) / azimuths)), exponent);
                values.at(x, row) += (exponent + 1) * 2 / zones * lobe / azimuths * glm::dvec3(gradient[zone]);
            }
        }
    return values;
}

/// Reference values of some texels of a map.
struct Truths {
    std::vector<glm::ivec2> places;
    std::vector<glm::dvec3> values;
    glm::dvec3 largest{0};  ///< largest value of the whole map: code 255 of each channel
};
Truths truthsOf(const Gradient& gradient, const fit::RsrmOptions& options) {
    Truths truths;
    for (std::size_t row = 0; row < options.exponents.size(); ++row)
        for (int x = static_cast<int>(row) % kReferenceStep; x < options.width; x += kReferenceStep) {
            truths.places.emplace_back(x, static_cast<int>(row));
            truths.values.push_back(truth(gradient, 1 - (2.0 * x + 1) / options.width, options.exponents[row]));
        }
    const auto whole = fit::convolveGradient(gradient, options);
    for (const glm::dvec3& value : whole.texels()) truths.largest = glm::max(truths.largest, value);
    return truths;
}

struct Error {
    double relative = 0;  ///< largest of |error| / (value + 1e-3 of the channel's largest)
    double codes = 0;     ///< largest |error| in 8-bit codes
};
Error errorOf(const Truths& truths, const std::function<glm::dvec3(int x, int y)>& value) {
    Error error;
    for (std::size_t i = 0; i < truths.places.size(); ++i) {
        const glm::dvec3 off = glm::abs(value(truths.places[i].x, truths.places[i].y) - truths.values[i]);
        for (int channel = 0; channel < 3; ++channel) {
            if (!(truths.largest[channel] > 0)) continue;
            error.relative = std::max(error.relative, off[channel] / (truths.values[i][channel] + 1e-3 * truths.largest[channel]));
            error.codes = std::max(error.codes, 255 * off[channel] / truths.largest[channel]);
        }
    }
    return error;
}

/// Writes the measurements of maps to standard output, to the CSV file and to the curves.
class Table {
public:
    Table(const fs::path& csv, FitCurves& curves) : curves_(curves) {
        if (!csv.empty()) {
            csv_.open(csv.parent_path() / (csv.stem().string() + "_rsrm.csv"));
            csv_ << "gradient,way,cpu_seconds,largest_relative_error,largest_error_codes\n";
        }
        fmt::print(
            "\nReflection maps, 256 x 8 texels, exponents 1 to 16384. CPU seconds of one thread; error at {} texels a row: relative to "
            "value "
            "and 0.001 of the largest, and in codes of 255.\n\n",
            256 / kReferenceStep);
        printTableHead({"gradient", "way", ">ms", ">relative error", ">codes"});
    }
    void add(const std::string& gradient, const std::string& way, double seconds, const Error& error) {
        printTableRow("{} | {} | {:.2f} | {:.1e} | {:.3g}", gradient, way, 1e3 * seconds, error.relative, error.codes);
        if (csv_.is_open()) csv_ << fmt::format("{},{},{},{},{}\n", gradient, way, seconds, error.relative, error.codes);
        const std::string panel = "reflection map, 256 zones to 256 x 8, " + gradient;
        curves_.describe(panel, "largest error, over the channel's largest value");
        const bool isSum = way.starts_with("paper");
        curves_.add({panel, isSum ? "paper's sum" : way, isSum ? way.substr(way.find("of ") + 3) : way, seconds, error.codes / 255,
                     way == "series at 8 bits"});
    }

private:
    std::ofstream csv_;
    FitCurves& curves_;
};

void benchGradient(const std::string& name, const Gradient& gradient, int runs, Table& table) {
    const fit::RsrmOptions options;
    const Truths truths = truthsOf(gradient, options);
    for (const bool dither : {false, true}) {
        fit::RsrmOptions each = options;
        each.dither = dither;
        fit::Rsrm map;
        const double seconds = cpuSeconds(runs, [&] { map = fit::makeRsrm(gradient, each); });
        if (!dither) table.add(name, "Legendre series", seconds, errorOf(truths, [&](int x, int y) { return map.values.at(x, y); }));
        table.add(name, dither ? "series at 8 bits dithered" : "series at 8 bits", seconds,
                  errorOf(truths, [&](int x, int y) { return glm::dvec3(map.codes.at(x, y)) / 255.0 * glm::dvec3(map.color); }));
    }
    for (const int azimuths : {8, 32, 128}) {
        formats::Image<glm::dvec3> values;
        const double seconds = cpuSeconds(1, [&] { values = papersSum(gradient, options, azimuths); });
        table.add(name, fmt::format("paper's sum of {} azimuths", azimuths), seconds,
                  errorOf(truths, [&](int x, int y) { return values.at(x, y); }));
    }
}

/// Returns a synthetic gradient: a ramp, a kink, and one bright zone.
Gradient madeGradient() {
    Gradient gradient;
    for (int i = 0; i < 256; ++i) {
        const float z = 1 - (2 * static_cast<float>(i) + 1) / 256;
        gradient.emplace_back(0.5f + 0.4f * z, std::abs(z), i == 40 ? 20.0f : 0.1f);
    }
    return gradient;
}

}  // namespace

void benchRsrm(const fs::path& data, const fs::path& csv, int runs, FitCurves& curves) {
    Table table(csv, curves);
    benchGradient("made", madeGradient(), runs, table);
    for (const char* name : {"clear_sky_256x1", "sun_glow_256x1"})
        if (const auto gradient = formats::loadPaintedGradient(data / "gradients" / (std::string(name) + ".exr"), {}))
            benchGradient(name, gradient->zones, runs, table);
    fmt::print("\nAveraging a panorama around an axis, 256 zones.\n\n");
    printTableHead({"panorama", "axis", ">s", ">energy lost %"});
    for (const char* name : {"kiara_1_dawn_1k", "potsdamer_platz_1k", "rooitou_park_1k", "st_fagans_interior_1k"}) {
        const auto loaded = formats::loadEnvironment(data / "env" / (std::string(name) + ".hdr"), {});
        if (!loaded) continue;
        for (const glm::dvec3& axis : {glm::dvec3(0, 1, 0), glm::dvec3(0.3, 0.8, 0.2)}) {
            fit::AzimuthalAverage average;
            const double seconds = cpuSeconds(runs, [&] { average = fit::averageAroundAxis(loaded->environment, axis, 256); });
            printTableRow("{} | {}, {}, {} | {:.3f} | {:.1f}", name, axis.x, axis.y, axis.z, seconds, 100 * average.asymmetricEnergy);
        }
    }
}

}  // namespace lightcook::bench
