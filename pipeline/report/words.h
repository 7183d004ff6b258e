// Words for counts, sizes and ratios.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace lightcook::pipeline {

/// Returns "1 asset" or "2 assets".
/// what  one of them
std::string counted(std::uint64_t count, std::string_view what);

/// Returns "812 bytes", "1.50 KiB" or "2.25 MiB".
std::string sizeWords(std::uint64_t bytes);
/// Returns a size in the unit that sizeWords() gives another one.
std::string sizeWords(std::uint64_t bytes, std::uint64_t inUnitOf);

/// Returns "found 1.53 MiB of GPU memory, expected at most 1.50 MiB: 30.70 KiB too much".
std::string overBudgetWords(std::uint64_t usedBytes, std::uint64_t limitBytes);

/// Returns a ratio in percent, three significant digits: "1.23 %", "0.412 %", "< 0.001 %", "340 %"; "not finite" for NaN and infinities.
std::string humanPercent(double ratio);

}  // namespace lightcook::pipeline
