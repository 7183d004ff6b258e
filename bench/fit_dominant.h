// The dominant lights' part of lightcook_fit_bench.
#pragma once

#include <filesystem>
#include <string>

#include "bench/fit_curves.h"

namespace lightcook::bench {

struct DominantBenchOptions {
    std::filesystem::path data;  ///< the shared data
    std::string scene;           ///< only scenes whose name contains this
    std::filesystem::path csv;   ///< file of the first table; empty: none
    int runs = 3;                ///< times are the best of so many runs
    int samples = 500;           ///< number of texels of a map that are searched densely
};

/// Prints seconds and residual of each fit on each light map, with a dense search on samples as reference, and writes them as CSV. Then
/// prints the errors of the specular light of each fit against brute-force values, where the shared data hold them.
void benchDominantLights(const DominantBenchOptions& options, FitCurves& curves);

}  // namespace lightcook::bench
