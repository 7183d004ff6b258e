// The reflection maps' part of lightcook_fit_bench: run time against error.
#pragma once

#include <filesystem>

#include "bench/fit_curves.h"

namespace lightcook::bench {

/// Prints CPU seconds against the error of a 256 x 8 map, and writes them as CSV beside `csv` (name_rsrm.csv; not for an empty path): the
/// Legendre series, and the sum over zones and azimuths of Stone's paper at several counts.
/// data  the shared data, for their gradients and panoramas; without them, only a synthetic gradient is measured
void benchRsrm(const std::filesystem::path& data, const std::filesystem::path& csv, int runs, FitCurves& curves);

}  // namespace lightcook::bench
