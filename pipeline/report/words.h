// Words for counts and ratios.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace lightcook::pipeline {

/// Returns "1 asset" or "2 assets".
/// what  one of them
std::string counted(std::uint64_t count, std::string_view what);

/// Returns a ratio in percent, three significant digits: "1.23 %", "0.412 %", "< 0.001 %", "340 %"; "not finite" for NaN and infinities.
std::string humanPercent(double ratio);

}  // namespace lightcook::pipeline
