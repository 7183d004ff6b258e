#include "pipeline/report/visible_histogram.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "pipeline/report/plot.h"
#include "verify/visible.h"

namespace lightcook::pipeline {

namespace {

constexpr PlotArea kHistogramArea{.width = 480, .height = 220, .left = 70, .right = 466, .top = 12, .bottom = 182};
constexpr double kLeastShare = 1e-6;
constexpr int kOctaves = verify::VisibleFigures::kHighestOctave - verify::VisibleFigures::kLowestOctave + 2;

double leftOf(int octave) {
    return kHistogramArea.left + (kHistogramArea.right - kHistogramArea.left) * octave / kOctaves;
}

/// Draws the bars of one kind of shading.
Html bars(const char* kind, const std::vector<std::int64_t>& counts, const Axis& share, double inset) {
    Html out;
    const std::int64_t sum = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
    if (counts.size() != kOctaves || sum <= 0) return out;
    for (int octave = 0; octave < kOctaves; ++octave) {
        const double part = static_cast<double>(counts[static_cast<std::size_t>(octave)]) / static_cast<double>(sum);
        if (!(part > kLeastShare)) continue;
        const double top = share.at(part);
        out += element("rect",
                       {{"class", kind},
                        {"x", place(leftOf(octave) + inset)},
                        {"y", place(top)},
                        {"width", place(leftOf(octave + 1) - leftOf(octave) - 2 * inset)},
                        {"height", place(kHistogramArea.bottom - top)}},
                       element("title", text(fmt::format("{}: {:.3g} % of {} samples", kind, 100 * part, sum))));
    }
    return out;
}

}  // namespace

Html visibleHistogram(const std::vector<std::int64_t>& diffuse, const std::vector<std::int64_t>& specular, double limit) {
    const Axis share(kHistogramArea.bottom, kHistogramArea.top, kLeastShare, 1, 0);
    const Html drawn = bars("diffuse", diffuse, share, 2) + bars("specular", specular, share, 5);
    if (drawn.isEmpty()) return {};
    Html drawing;
    for (const double tick : {1.0, 1e-2, 1e-4, 1e-6}) {
        drawing += line("grid", kHistogramArea.left, share.at(tick), kHistogramArea.right, share.at(tick));
        drawing += label("tick end", kHistogramArea.left - 7, share.at(tick) + 4, fmt::format("{:g} %", 100 * tick));
    }
    for (const int octave : {1, 4, 7, 10, 13})
        drawing += label("tick middle", leftOf(octave), kHistogramArea.bottom + 15,
                         fmt::format("{:g}", std::ldexp(1, verify::VisibleFigures::kLowestOctave + octave - 1)));
    drawing += label("tick middle", (kHistogramArea.left + kHistogramArea.right) / 2, kHistogramArea.height - 4,
                     "visible error (filled: diffuse, outlined: specular)");
    drawing += drawn;
    if (limit > 0) {
        const double x = leftOf(1) + (leftOf(2) - leftOf(1)) * (std::log2(limit) - verify::VisibleFigures::kLowestOctave);
        if (x > kHistogramArea.left && x < kHistogramArea.right) {
            drawing += line("limit", x, kHistogramArea.top, x, kHistogramArea.bottom);
            drawing += label("tick limit", x + 4, kHistogramArea.top + 10, "limit on p99");
        }
    }
    return element("svg",
                   {{"class", "curve histogram"},
                    {"viewBox", fmt::format("0 0 {} {}", kHistogramArea.width, kHistogramArea.height)},
                    {"role", "img"},
                    {"aria-label", "Share of the samples in each octave of visible error: filled diffuse, outlined specular"}},
                   drawing);
}

}  // namespace lightcook::pipeline
