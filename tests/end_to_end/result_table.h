// Tests compare what the program prints with tables of Markdown, row by row.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {

/// The cells of a row; the first one is its name.
using Cells = std::vector<std::string>;

/// Returns true if the line is the pattern, in which "..." stands for anything.
inline bool matches(std::string_view line, std::string_view pattern) {
    const std::size_t gap = pattern.find("...");
    if (gap == std::string_view::npos) return line == pattern;
    if (!line.starts_with(pattern.substr(0, gap))) return false;
    for (std::size_t at = gap; at <= line.size(); ++at)
        if (matches(line.substr(at), pattern.substr(gap + 3))) return true;
    return false;
}

/// The table of a file. Its first cells are plain text, numbers are plain, all else is a code span.
class ResultTable {
public:
    explicit ResultTable(std::filesystem::path file) : file_(std::move(file)) {}

    std::map<std::string, Cells> rows() const {
        std::map<std::string, Cells> rows;
        bool isBelowHead = false;
        for (const std::string& line : lines()) {
            if (Cells cells = cellsOf(line); isBelowHead && !cells.empty()) rows[cells[0]] = std::move(cells);
            isBelowHead = line.starts_with('|') && (isBelowHead || line.starts_with("| ---"));
        }
        return rows;
    }

    /// Writes a row: in place of the one of its name, or after the last row.
    void write(const Cells& cells) const {
        std::vector<std::string> text = lines();
        std::size_t last = 0, old = 0;
        for (std::size_t i = 0; i < text.size(); ++i) {
            const Cells found = cellsOf(text[i]);
            if (!found.empty()) last = i;
            if (!found.empty() && found[0] == cells[0]) old = i;
        }
        if (old != 0)
            text[old] = lineOf(cells);
        else
            text.insert(text.begin() + static_cast<std::ptrdiff_t>(last) + 1, lineOf(cells));
        std::string content;
        for (const std::string& line : text) content += line + "\n";
        formats::writeContent(file_, content);
    }

    /// Returns the row of the name; with LIGHTCOOK_UPDATE_DOCS=1, after it was written if it is another one than `found`.
    Cells rowFor(const Cells& found) const {
        const auto row = [&] {
            const auto all = rows();
            const auto at = all.find(found[0]);
            return at == all.end() ? Cells() : at->second;
        };
        const Cells written = row();
        if (std::getenv("LIGHTCOOK_UPDATE_DOCS") == nullptr || std::ranges::equal(found, written, matches)) return written;
        write(found);
        return row();
    }

private:
    std::vector<std::string> lines() const {
        std::vector<std::string> lines;
        std::istringstream table(formats::contentOf(file_));
        for (std::string line; std::getline(table, line);) lines.push_back(line);
        return lines;
    }

    static bool isNumber(const std::string& cell) {
        return !cell.empty() && std::ranges::all_of(cell, [](unsigned char c) { return std::isdigit(c) != 0; });
    }

    /// Returns the cells of a line of the table; none of another line.
    static Cells cellsOf(const std::string& line) {
        if (!line.starts_with("| ")) return {};
        Cells cells(1);
        for (std::size_t i = 1; i + 1 < line.size(); ++i) {
            if (line[i] == '\\' && line[i + 1] == '|') {
                cells.back() += line[++i];
            } else if (line[i] == '|') {
                cells.emplace_back();
            } else {
                cells.back() += line[i];
            }
        }
        for (std::string& cell : cells) {
            cell.erase(0, cell.find_first_not_of(' '));
            cell.erase(cell.find_last_not_of(' ') + 1);
            // Code spans: `text`, or `` text ` `` around back quotes
            const std::size_t quote = cell.starts_with("`` ") ? 3 : cell.starts_with('`') ? 1 : 0;
            if (cell.size() >= 2 * quote) cell = cell.substr(quote, cell.size() - 2 * quote);
        }
        return cells;
    }

    static std::string lineOf(const Cells& cells) {
        std::string line = "|";
        for (std::size_t i = 0; i < cells.size(); ++i) {
            std::string escaped;
            for (const char c : cells[i]) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
            const char* quote = i == 0 || isNumber(cells[i]) ? "" : escaped.find('`') == std::string::npos ? "`" : "``";
            const char* gap = std::string_view(quote).size() == 2 ? " " : "";
            line += fmt::format(" {}{}{}{}{} |", quote, gap, escaped, gap, quote);
        }
        return line;
    }

    std::filesystem::path file_;
};

}  // namespace lightcook::pipeline
