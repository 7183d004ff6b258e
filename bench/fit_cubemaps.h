// The cubemap part of lightcook_fit_bench: run time against error, and relighting with the area specular of another place.
#pragma once

#include <filesystem>

#include "bench/fit_curves.h"

namespace lightcook::bench {

/// Prints Markdown tables and writes the first as CSV (unless `csv` is empty). Prints nothing if `data` holds no panoramas and no probes.
void benchCubemaps(const std::filesystem::path& data, const std::filesystem::path& csv, int runs, FitCurves& curves);

}  // namespace lightcook::bench
