// The specular tables' part of lightcook_fit_bench: run time against error by the number of points of the integrals, and the error of
// mappings of the axes.
#pragma once

#include <filesystem>

#include "bench/fit_curves.h"

namespace lightcook::bench {

/// Prints both tables as Markdown and writes them as CSV: to `csv`, and to `csv` with "_axes" before its extension.
void benchTables(const std::filesystem::path& csv, int runs, FitCurves& curves);

}  // namespace lightcook::bench
