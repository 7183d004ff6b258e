// A layout of a light map and the detail that its tiles get, as the choice of layouts names both: "basis-4+lit@5".
#pragma once

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <string>
#include <string_view>

#include "formats/light_map_detail.h"

namespace lightcook::pipeline {

struct DetailedLayout {
    std::string layout;
    std::optional<double> limit = {};  ///< DetailParameters::limit; empty: no tile has detail

    std::string name() const {
        return limit ? fmt::format("{}+{}@{:.6g}", layout, formats::info(formats::kDetailLayout).name, *limit) : layout;
    }
    /// Returns the layout for people: "basis-4, detail", or "basis-4, detail above 5" where layouts differ in the limit alone.
    std::string words(bool withLimit = false) const {
        if (!limit) return layout;
        return withLimit ? fmt::format("{}, detail above {:.2g}", layout, *limit) : layout + ", detail";
    }
    /// Returns the layout of a name. One without a number is the layout alone.
    static DetailedLayout ofName(std::string_view name) {
        const std::size_t plus = name.find('+'), at = name.find('@');
        DetailedLayout out{std::string(name.substr(0, plus))};
        double limit = 0;
        if (plus != name.npos && at != name.npos &&
            std::from_chars(name.data() + at + 1, name.data() + name.size(), limit).ec == std::errc())
            out.limit = limit;
        return out;
    }
};

}  // namespace lightcook::pipeline
