// Depth of nesting of a TOML text, found before it is parsed: toml++ and its destructors recurse as deep as the text goes.
#pragma once

#include <optional>
#include <string_view>

namespace lightcook::pipeline {

struct TomlPlace {
    int line = 1, column = 1;
};

/// Returns the place where brackets outside strings are nested deeper than `most`, or a dotted key or table name has more parts than that.
std::optional<TomlPlace> placeNestedDeeper(std::string_view toml, int most);

}  // namespace lightcook::pipeline
