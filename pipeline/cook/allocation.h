// Allocation of a scene's memory among all its light maps together, by what each byte buys in the visible error of the whole shading; and
// the views of the Cook-Torrance tables beside them.
//
// Method: each light map has measured choices, its layouts (assets/light_map/whole_trial.h). The error of a scene is the largest 99th
// percentile of its maps, so under an error E every map takes its smallest choice within E, and no other allocation of at most that error
// is smaller. The frontier has one point for each E that any choice has, less the points that cost more without a smaller error: it is
// exact, not only a hull. A budget selects the last point that fits beside tables of the fewest views, so the error never grows with the
// budget. The tables have more views only where that same point still fits: light maps come first. The error of the tables, which `visible`
// leaves out, may therefore grow where the light maps take a next step.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace lightcook::pipeline {

/// A layout for one light map.
struct AllocationChoice {
    std::string layout;
    std::uint64_t bytes = 0;
    double visible = 0;  ///< 99th percentile of visible errors of the whole shading
    double relRms = 0;   ///< of the whole shading
};
/// Choices by the name of the light map; none is empty.
using AllocationChoices = std::map<std::string, std::vector<AllocationChoice>>;

/// A scene under one choice for each light map.
struct AllocationPoint {
    std::uint64_t bytes = 0;  ///< of the whole scene
    double visible = 0;       ///< of the worst light map
    std::map<std::string, AllocationChoice> choices;
};

/// Returns the allocations that no other beats in bytes and error, the smallest first: bytes grow, errors fall.
/// otherBytes  GPU memory of everything that has no choice
std::vector<AllocationPoint> allocationFrontier(const AllocationChoices& choices, std::uint64_t otherBytes);

/// Returns the index of the last point within a budget; 0, the smallest, where none is.
std::size_t pointWithin(const std::vector<AllocationPoint>& frontier, std::uint64_t budgetBytes);

/// GPU memory of the tables with the fewest views and with more [bytes].
struct TableBytes {
    std::uint64_t least = 0, fine = 0;
};
/// A point of a frontier and the tables beside it.
struct BudgetChoice {
    std::size_t point = 0;  ///< index
    bool areTablesFine = false;
};
/// Returns the point of a budget and whether the fine tables are taken: they are if they fit without a smaller point than the smaller ones
/// leave. Where nothing fits, it is the smallest point with the smaller tables.
/// frontier    its bytes count no tables
/// lastPoint   index of the largest point that is wanted
/// isFineOnly  the smaller tables miss a limit of theirs, so that the fine ones are taken wherever they fit beside any point
BudgetChoice choiceWithin(const std::vector<AllocationPoint>& frontier, const TableBytes& tables, std::uint64_t budgetBytes,
                          std::size_t lastPoint, bool isFineOnly = false);
/// Returns the index of the first point within an error; the last, of least error, where none is.
std::size_t pointOfError(const std::vector<AllocationPoint>& frontier, double visible);

}  // namespace lightcook::pipeline
