// The reflection maps' part of `./dev bench fits`.
#pragma once

#include <filesystem>

#include "bench/fit_curves.h"

namespace lightcook::bench {

/// Prints, and leaves as CSV beside `csv` (name_rsrm.csv; none for an empty path), CPU seconds against the error of a 256 x 8 map: the
/// Legendre series, and the sum over zones and azimuths of Stone's paper at several counts. data: the shared data, for its gradients and
/// panoramas; without them a made gradient is all.
void benchRsrm(const std::filesystem::path& data, const std::filesystem::path& csv, int runs, FitCurves& curves);

}  // namespace lightcook::bench
