// Sizes in bytes as scene files, budgets and options state them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "formats/error.h"

namespace lightcook::pipeline {

/// Parses "2 MiB", "1.5 GB" or "4096" to bytes: a decimal number and a unit. Rounds down, since a size is a limit: "1.3 MiB" is 1363148
/// bytes. "1.5" is refused: bytes without a larger unit are whole.
formats::Result<std::uint64_t> parseByteCount(std::string_view text, const std::string& subject);

}  // namespace lightcook::pipeline
