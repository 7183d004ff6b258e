// Sizes in bytes and fractions as scene files, budgets and options state them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "formats/error.h"

namespace lightcook::pipeline {

/// Parses "2 MiB", "1.5 GB" or "4096" to bytes: a decimal number and a unit. Rounds down, since a size is a limit: "1.3 MiB" is 1363148
/// bytes. "1.5" is refused: bytes without a larger unit are whole.
formats::Result<std::uint64_t> parseByteCount(std::string_view text, const formats::Subject& subject);

/// Parses a fraction: "0.02", "2%" or "2 %". Returns nothing for other texts and for numbers that are not finite.
std::optional<double> parseFraction(std::string_view text);

}  // namespace lightcook::pipeline
