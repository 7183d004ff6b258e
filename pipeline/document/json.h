// The JSON type of the program, and text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace lightcook::pipeline {

using Json = nlohmann::ordered_json;  ///< keys keep the order in which a reader wants to see them

/// Parses a text; the result is_discarded() if the text is not JSON, or nested deeper than any file of this program.
Json parseJson(const std::string& text);

/// Returns the text with every byte that is no UTF-8 replaced, as JSON output does it.
std::string asUtf8(const std::string& text);
/// Returns true for a text that JSON and TOML can hold as it is.
bool isUtf8(const std::string& text);

/// Returns indented text. Bytes of a file name that are not UTF-8 become U+FFFD.
std::string textOf(const Json& json);

}  // namespace lightcook::pipeline
