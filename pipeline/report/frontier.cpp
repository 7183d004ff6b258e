#include "pipeline/report/frontier.h"

#include <fmt/format.h>

namespace lightcook::pipeline {

std::string layoutWords(const FrontierPoint& point) {
    std::string out;
    for (const AllocatedLayout& each : point.layouts) out += fmt::format("{}{}: {}", out.empty() ? "" : "; ", each.lightMap, each.layout);
    return out;
}

}  // namespace lightcook::pipeline
