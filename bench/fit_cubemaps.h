// The cubemap part of lightcook_fit_bench: run time against error, and what relighting with another place's area specular gives.
#pragma once

#include <filesystem>

#include "bench/fit_curves.h"

namespace lightcook::bench {

/// Prints Markdown tables; csv (may be empty) gets the first for machines. Nothing where data holds no panoramas and no probes.
void benchCubemaps(const std::filesystem::path& data, const std::filesystem::path& csv, int runs, FitCurves& curves);

}  // namespace lightcook::bench
