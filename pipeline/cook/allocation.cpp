#include "pipeline/cook/allocation.h"

#include <algorithm>
#include <set>
#include <tuple>

namespace lightcook::pipeline {
namespace {

/// Returns the smallest choice within an error, of equal ones that of the smaller error; nullptr without any.
const AllocationChoice* smallestWithin(const std::vector<AllocationChoice>& choices, double error) {
    const AllocationChoice* best = nullptr;
    for (const AllocationChoice& each : choices) {
        if (!(each.visible <= error)) continue;
        if (best == nullptr || std::tie(each.bytes, each.visible) < std::tie(best->bytes, best->visible)) best = &each;
    }
    return best;
}

/// Returns the smallest scene within an error; nothing if a map has no choice within it.
std::optional<AllocationPoint> smallestSceneWithin(const AllocationChoices& choices, double error, std::uint64_t otherBytes) {
    AllocationPoint point{otherBytes, 0, {}};
    for (const auto& [map, each] : choices) {
        const AllocationChoice* const smallest = smallestWithin(each, error);
        if (smallest == nullptr) return std::nullopt;
        point.bytes += smallest->bytes;
        point.visible = std::max(point.visible, smallest->visible);
        point.choices[map] = *smallest;
    }
    return point;
}

}  // namespace

std::vector<AllocationPoint> allocationFrontier(const AllocationChoices& choices, std::uint64_t otherBytes) {
    std::set<double, std::greater<>> errors;
    for (const auto& [map, each] : choices)
        for (const AllocationChoice& choice : each) errors.insert(choice.visible);
    std::vector<AllocationPoint> frontier;
    for (const double error : errors) {
        auto point = smallestSceneWithin(choices, error, otherBytes);
        if (!point) break;
        // The same bytes with a smaller error replace the earlier point.
        if (!frontier.empty() && point->bytes == frontier.back().bytes && point->visible <= frontier.back().visible) frontier.pop_back();
        if (frontier.empty() || point->visible < frontier.back().visible) frontier.push_back(std::move(*point));
    }
    return frontier;
}

std::size_t pointWithin(const std::vector<AllocationPoint>& frontier, std::uint64_t budgetBytes) {
    const auto over = std::ranges::find_if(frontier, [&](const AllocationPoint& point) { return point.bytes > budgetBytes; });
    return over == frontier.begin() ? 0 : static_cast<std::size_t>(over - frontier.begin()) - 1;
}

BudgetChoice choiceWithin(const std::vector<AllocationPoint>& frontier, const TableBytes& tables, std::uint64_t budgetBytes,
                          std::size_t lastPoint, bool isFineOnly) {
    const auto pointBeside = [&](std::uint64_t bytes) {
        return std::min(lastPoint, pointWithin(frontier, budgetBytes - std::min(bytes, budgetBytes)));
    };
    const std::size_t least = pointBeside(tables.least), fine = pointBeside(tables.fine);
    const bool isFineWithin = frontier[fine].bytes + tables.fine <= budgetBytes;
    return isFineWithin && (fine == least || isFineOnly) ? BudgetChoice{fine, true} : BudgetChoice{least, false};
}

std::size_t pointOfError(const std::vector<AllocationPoint>& frontier, double visible) {
    const auto within = std::ranges::find_if(frontier, [&](const AllocationPoint& point) { return point.visible <= visible; });
    return within == frontier.end() ? frontier.size() - 1 : static_cast<std::size_t>(within - frontier.begin());
}

}  // namespace lightcook::pipeline
