// The parts that the HTML pages of the benchmarks share.
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

namespace lightcook::bench {

/// Returns a text with the characters replaced that HTML and SVG reserve.
inline std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
    return out;
}

/// Returns the start of a page: its head, the title, and the notes as paragraphs.
inline std::string pageStart(const std::string& title, const char* style, const std::vector<std::string>& notes) {
    std::string page = fmt::format(
        "<!doctype html>\n<html lang=en><head><meta charset=utf-8><meta name=viewport content=\"width=device-width\"><title>{0}</title>\n"
        "<style>{1}</style></head><body>\n<h1>{0}</h1>\n",
        escaped(title), style);
    for (const std::string& note : notes) page += fmt::format("<p class=note>{}</p>\n", escaped(note));
    return page;
}

}  // namespace lightcook::bench
