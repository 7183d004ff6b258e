// Run time against error of the specular tables: of the integrals by points a piece, and of the axes.
#pragma once

#include <filesystem>

#include "bench/fit_curves.h"

namespace lightcook::bench {

/// Prints both tables as Markdown and leaves them as CSV: PATH, and PATH with "_axes" before its extension.
void benchTables(const std::filesystem::path& csv, int runs, FitCurves& curves);

}  // namespace lightcook::bench
