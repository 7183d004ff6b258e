// Choice of the mappings of a table by interpolation error. Each mapping is tried with the nodes that it gives: the kernels are
// interpolated bilinearly to a grid of kPlaces x kPlaces places, and compared with exact kernels there. The view's mapping is chosen first,
// then that of roughness.
#include <algorithm>
#include <cassert>
#include <cmath>

#include "fit/specular_tables.h"

namespace lightcook::fit {
namespace {

/// Places of the reference along each axis, uniform in NoV and in m.
constexpr int kPlaces = 48;
/// Gauss points a piece of the integrals: their error of 1e-5 is a hundredth of the errors that are compared.
constexpr int kPoints = 8;
/// A mapping with a root replaces the plain axis only if its error is at most this share of the plain one's.
constexpr double kMostErrorOfRoot = 0.97;

/// Entries of a kernel that do not vanish: C for i = 0, 2, 3, 6, 7, 8, then D.
using Entries = std::array<double, 12>;

Entries entriesOf(const lighting::AreaSpecularKernel& kernel) {
    constexpr std::array<std::size_t, 6> kCoefficients = {0, 2, 3, 6, 7, 8};
    Entries entries;
    for (std::size_t i = 0; i < kCoefficients.size(); ++i) {
        entries[i] = kernel.c[kCoefficients[i]];
        entries[6 + i] = kernel.d[kCoefficients[i]];
    }
    return entries;
}

/// Position of a sample between two nodes of an axis.
struct Between {
    std::size_t first, second;
    double fraction;
};

class Axis {
public:
    Axis(const AxisMapping& mapping, int count, double low, double high)
        : mapping_(mapping), count_(count), minimum_(std::min(mapping.of(low), mapping.of(high))), low_(low), high_(high) {
        step_ = count > 1 ? (std::max(mapping.of(low), mapping.of(high)) - minimum_) / (count - 1) : 0;
    }
    double node(int index) const { return std::clamp(mapping_.inverse(minimum_ + step_ * index), low_, high_); }
    Between find(double t) const {
        if (!(step_ > 0)) return {0, 0, 0};
        const double place = (mapping_.of(t) - minimum_) / step_;
        const int first = std::clamp(static_cast<int>(place), 0, count_ - 2);
        return {static_cast<std::size_t>(first), static_cast<std::size_t>(first) + 1, place - first};
    }

private:
    const AxisMapping& mapping_;
    int count_;
    double minimum_, low_, high_, step_;
};

double place(int index, double low, double high) {
    return low + (high - low) * (index + 0.5) / kPlaces;
}

/// Measures pairs of mappings for a table of given size and range.
class Trial {
public:
    Trial(const SpecularTableOptions& options, double lowF0, double highF0) : options_(options), f0_{lowF0, highF0} {
        for (int x = 0; x < kPlaces; ++x) {
            const auto column = columnAt(place(x, 0, 1));
            for (int y = 0; y < kPlaces; ++y)
                reference_.push_back(entriesOf(column.kernel(place(y, options.minimumM, options.maximumM), options.normalization)));
        }
    }

    MappingFigure measure(const AxisMapping& viewMapping, const AxisMapping& roughnessMapping) const {
        const Axis view(viewMapping, options_.viewCount, 0, 1);
        const Axis roughness(roughnessMapping, options_.roughnessCount, options_.minimumM, options_.maximumM);
        const std::size_t height = static_cast<std::size_t>(options_.roughnessCount);
        std::vector<Entries> nodes;
        for (int x = 0; x < options_.viewCount; ++x) {
            const auto column = columnAt(view.node(x));
            for (int y = 0; y < options_.roughnessCount; ++y)
                nodes.push_back(entriesOf(column.kernel(roughness.node(y), options_.normalization)));
        }
        Sums sums;
        for (int x = 0; x < kPlaces; ++x)
            for (int y = 0; y < kPlaces; ++y) {
                const Between h = view.find(place(x, 0, 1)), v = roughness.find(place(y, options_.minimumM, options_.maximumM));
                Entries found;
                for (std::size_t i = 0; i < found.size(); ++i) {
                    const double left = std::lerp(nodes[h.first * height + v.first][i], nodes[h.first * height + v.second][i], v.fraction);
                    const double right =
                        std::lerp(nodes[h.second * height + v.first][i], nodes[h.second * height + v.second][i], v.fraction);
                    found[i] = std::lerp(left, right, h.fraction);
                }
                sums.add(found, reference_[static_cast<std::size_t>(x * kPlaces + y)], f0_);
            }
        return sums.figure(viewMapping.name, roughnessMapping.name);
    }

private:
    /// Sums of squared errors and values: C, D, and F0 C + (1 - F0) D for each F0.
    struct Sums {
        std::array<double, 4> errors{}, values{};
        double worst = 0;

        void add(const Entries& found, const Entries& truth, const std::array<double, 2>& f0) {
            for (std::size_t i = 0; i < 6; ++i) {
                const std::array<double, 2> error = {found[i] - truth[i], found[6 + i] - truth[6 + i]};
                const std::array<double, 2> value = {truth[i], truth[6 + i]};
                worst = std::max({worst, std::abs(error[0]), std::abs(error[1])});
                for (std::size_t k = 0; k < 2; ++k) {
                    const double both = f0[k] * error[0] + (1 - f0[k]) * error[1], whole = f0[k] * value[0] + (1 - f0[k]) * value[1];
                    errors[k] += error[k] * error[k];
                    values[k] += value[k] * value[k];
                    errors[2 + k] += both * both;
                    values[2 + k] += whole * whole;
                }
            }
        }
        MappingFigure figure(const std::string& view, const std::string& roughness) const {
            const auto share = [&](std::size_t i) { return values[i] > 0 ? errors[i] / values[i] : 0; };
            return {view,
                    roughness,
                    std::sqrt(share(0)),
                    std::sqrt(share(1)),
                    worst,
                    std::sqrt((errors[2] + errors[3]) / std::max(values[2] + values[3], 1e-300))};
        }
    };

    lighting::AreaSpecularColumn columnAt(double NoV) const {
        return {std::max(kSmallestNoV, NoV), options_.minimumM, options_.maximumM, options_.lobe, kPoints};
    }

    const SpecularTableOptions& options_;
    std::array<double, 2> f0_;
    std::vector<Entries> reference_;  ///< [view][roughness], kPlaces of each
};

}  // namespace

std::vector<MappingFigure> mappingFigures(const SpecularTableOptions& options, double lowF0, double highF0) {
    const Trial trial(options, lowF0, highF0);
    std::vector<MappingFigure> figures;
    for (const AxisMapping& view : viewMappings())
        for (const AxisMapping& roughness : roughnessMappings()) figures.push_back(trial.measure(view, roughness));
    return figures;
}

void chooseMappings(SpecularTableOptions& options, double lowF0, double highF0) {
    assert(checkSpecularTableOptions(options).has_value());
    const Trial trial(options, lowF0, highF0);
    // One axis after the other: their errors hardly interact, and a pair need not be tried with every other.
    const auto best = [&](const std::vector<AxisMapping>& mappings, AxisMapping SpecularTableOptions::*member) {
        std::vector<double> losses;
        for (const AxisMapping& mapping : mappings) {
            options.*member = mapping;
            losses.push_back(trial.measure(options.view, options.roughness).reflected);
        }
        const auto least = std::ranges::min_element(losses);
        const auto chosen = static_cast<std::size_t>(least - losses.begin());
        options.*member = mappings[*least > kMostErrorOfRoot * losses.front() ? 0 : chosen];
    };
    best(viewMappings(), &SpecularTableOptions::view);
    if (options.roughnessCount > 1) best(roughnessMappings(), &SpecularTableOptions::roughness);
}

}  // namespace lightcook::fit
