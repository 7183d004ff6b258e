// Reads TOML files: scene files, and budgets.
#pragma once

#include <fmt/format.h>

#include <toml++/toml.h>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

#include "formats/error.h"

namespace lightcook::pipeline {

/// Thrown while the tables of a file are read, and never leaves catchTomlMistakes.
struct TomlMistake {
    formats::Error error;
};

/// Returns the text of a file. Fails if it has more than `mostBytes`, or a key of more parts than any file needs.
/// expected  "budgets, which are 3 deep", for that error
formats::Result<std::string> readTomlText(const std::filesystem::path& file, std::uint64_t mostBytes, const char* expected);

/// Returns ": ..." with what to write for a mistake that paths of Windows make; else an empty text.
std::string hintOfSyntax(const toml::parse_error& mistake);

/// Returns what `read` makes of a document. Errors of its syntax name file, line and column.
/// read  may throw TomlMistake
template <class Read>
auto catchTomlMistakes(const std::filesystem::path& file, Read read) -> formats::Result<decltype(read())> {
    try {
        return read();
    } catch (const TomlMistake& mistake) {
        return tl::make_unexpected(mistake.error);
    } catch (const toml::parse_error& mistake) {
        const toml::source_position at = mistake.source().begin;
        return formats::failure(formats::ErrorCode::InvalidRequest,
                                formats::Subject::inLine(file, static_cast<int>(at.line), static_cast<int>(at.column)),
                                fmt::format("found a syntax error ({}), expected TOML{}", mistake.description(), hintOfSyntax(mistake)));
    }
}

/// Returns what `read` makes of the root table of a file. Errors name file, line and column.
/// mostBytes, expected  see readTomlText
/// read                 takes a toml::table, and may throw TomlMistake
template <class Read>
auto readToml(const std::filesystem::path& file, std::uint64_t mostBytes, const char* expected, Read read)
    -> formats::Result<decltype(read(std::declval<toml::table>()))> {
    LC_TRY(text, readTomlText(file, mostBytes, expected));
    return catchTomlMistakes(file, [&] { return read(toml::parse(*text, file.string())); });
}

}  // namespace lightcook::pipeline
