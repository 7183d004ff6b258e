#include "pipeline/report/frontier.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/assets/light_map/detailed_layout.h"

namespace lightcook::pipeline {

std::vector<FrontierPoint> asCooked(std::vector<FrontierPoint> points, const std::vector<ReportRow>& rows) {
    const auto chosen = std::ranges::find(points, true, &FrontierPoint::isChosen);
    if (chosen == points.end()) return points;
    std::uint64_t bytes = 0;
    double visible = 0;
    std::size_t measured = 0;
    for (const ReportRow& row : rows) {
        bytes += row.bytesGpu;
        if (!row.whole) continue;
        visible = std::max(visible, row.whole->visible.p99);
        ++measured;
    }
    if (measured != chosen->layouts.size()) return points;
    chosen->bytesGpu = bytes;
    chosen->visible = visible;
    std::erase_if(points, [&](const FrontierPoint& each) { return !each.isChosen && each.bytesGpu >= bytes && each.visible >= visible; });
    std::ranges::stable_sort(points, {}, &FrontierPoint::bytesGpu);
    return points;
}

std::string layoutWords(const FrontierPoint& point) {
    std::string out;
    for (const AllocatedLayout& each : point.layouts)
        out += fmt::format("{}{}: {}", out.empty() ? "" : "; ", each.lightMap, DetailedLayout::ofName(each.layout).words(true));
    return out;
}

}  // namespace lightcook::pipeline
