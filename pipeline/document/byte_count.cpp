#include "pipeline/document/byte_count.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>

namespace lightcook::pipeline {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

Result<std::uint64_t> parseByteCount(std::string_view text, const formats::Subject& subject) {
    const auto refuse = [&] {
        return failure(ErrorCode::InvalidRequest, subject,
                       fmt::format("found '{}', expected a size such as \"4096\", \"512 KiB\", \"2 MiB\" or \"1.5 GB\"", text));
    };
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed);
    // from_chars takes a sign, and names such as "inf".
    const bool isDecimal = !text.empty() && ((text[0] >= '0' && text[0] <= '9') || text[0] == '.');
    if (!isDecimal || error != std::errc()) return refuse();
    std::string_view asked = text.substr(static_cast<std::size_t>(end - text.data()));
    while (asked.starts_with(' ')) asked.remove_prefix(1);
    static const std::pair<std::string_view, double> kUnits[] = {{"", 1},         {"B", 1},       {"kB", 1e3},     {"KB", 1e3},
                                                                 {"MB", 1e6},     {"GB", 1e9},    {"KiB", 0x1p10}, {"MiB", 0x1p20},
                                                                 {"GiB", 0x1p30}, {"TiB", 0x1p40}};
    for (const auto& [unit, scale] : kUnits) {
        if (asked != unit) continue;
        const double bytes = number * scale, nearest = std::round(bytes);
        // 2.007 kB is 2006.9999999999998 in doubles.
        const bool isWhole = std::abs(bytes - nearest) <= 4 * std::numeric_limits<double>::epsilon() * bytes;
        const double whole = isWhole ? nearest : std::floor(bytes);
        const bool isFraction = !isWhole && (scale == 1 || whole == 0);
        if (isFraction)
            return failure(ErrorCode::InvalidRequest, subject, fmt::format("found '{}', expected a whole number of bytes", text));
        if (!(bytes < 0x1p63)) return refuse();
        return static_cast<std::uint64_t>(whole);
    }
    return refuse();
}

std::optional<double> parseFraction(std::string_view text) {
    const bool isPercent = text.ends_with('%');
    if (isPercent) text.remove_suffix(1);
    while (isPercent && text.ends_with(' ')) text.remove_suffix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
    return isPercent ? value / 100 : value;
}

}  // namespace lightcook::pipeline
