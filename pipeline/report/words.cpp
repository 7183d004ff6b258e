#include "pipeline/report/words.h"

#include <fmt/format.h>

#include <cmath>

namespace lightcook::pipeline {

std::string counted(std::uint64_t count, std::string_view what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

std::string sizeWords(std::uint64_t bytes) {
    return sizeWords(bytes, bytes);
}

std::string sizeWords(std::uint64_t bytes, std::uint64_t inUnitOf) {
    const auto value = static_cast<double>(bytes);
    if (inUnitOf < 1 << 10) return counted(bytes, "byte");
    return inUnitOf < 1 << 20 ? fmt::format("{:.2f} KiB", value / 0x1p10) : fmt::format("{:.2f} MiB", value / 0x1p20);
}

std::string overBudgetWords(std::uint64_t usedBytes, std::uint64_t limitBytes) {
    return fmt::format("found {} of GPU memory, expected at most {}: {} too much", sizeWords(usedBytes), sizeWords(limitBytes),
                       sizeWords(usedBytes - limitBytes));
}

std::string humanPercent(double ratio) {
    if (!std::isfinite(ratio)) return "not finite";
    const double percent = 100 * ratio, size = std::abs(percent);
    if (percent == 0) return "0 %";
    if (size < 0.001) return percent > 0 ? "< 0.001 %" : "> -0.001 %";
    if (size >= 1e6) return fmt::format("{:.3g} %", percent);
    // The limits are the values from which rounding carries into the next decade.
    return fmt::format("{:.{}f} %", percent, size >= 99.95 ? 0 : size >= 9.995 ? 1 : size >= 0.9995 ? 2 : 3);
}

}  // namespace lightcook::pipeline
