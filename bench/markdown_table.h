// Markdown tables on standard output, printed row by row as the figures arrive, and the format of their numbers.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lightcook::bench {

/// Prints the head of a table. A title that begins with '>' is the title of a column of numbers, aligned to the right.
inline void printTableHead(const std::vector<std::string>& titles) {
    std::string head = "|", rule = "|";
    for (std::string_view title : titles) {
        const bool isNumber = title.starts_with('>');
        if (isNumber) title.remove_prefix(1);
        head += fmt::format(" {} |", title);
        rule += isNumber ? " ---: |" : " --- |";
    }
    fmt::print("{}\n{}\n", head, rule);
    std::fflush(stdout);
}

/// Returns about three significant digits of a value, without powers of ten.
inline std::string threeDigits(double value) {
    return fmt::format("{:.{}f}", value, value >= 100 ? 0 : value >= 10 ? 1 : value >= 1 ? 2 : value >= 0.1 ? 3 : 4);
}

/// Prints one row of cells that are formatted already.
inline void printTableRow(std::span<const std::string> cells) {
    fmt::print("| {} |\n", fmt::join(cells, " | "));
    std::fflush(stdout);
}

/// Prints one row: printTableRow("{} | {:.2f}", name, seconds). The format stands for the cells, with " | " between them.
template <class... Values>
void printTableRow(fmt::format_string<Values...> format, Values&&... values) {
    fmt::print("| {} |\n", fmt::format(format, std::forward<Values>(values)...));
    std::fflush(stdout);
}

}  // namespace lightcook::bench
