// HTML markup whose content is always escaped, and numbers formatted for people.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lightcook::pipeline {

/// Markup. Text becomes markup only through text(), which escapes it, so unescaped text cannot get in by oversight.
class Html {
public:
    Html() = default;
    const std::string& markup() const { return markup_; }
    bool isEmpty() const { return markup_.empty(); }
    Html& operator+=(const Html& next) {
        markup_ += next.markup_;
        return *this;
    }
    friend Html operator+(Html first, const Html& second) { return first += second; }

private:
    explicit Html(std::string markup) : markup_(std::move(markup)) {}
    std::string markup_;

    friend Html text(std::string_view plain);
    friend Html raw(std::string_view markup);
};

/// Escapes text for elements and attributes: & < > " ' become entities, control characters that HTML forbids become U+FFFD.
Html text(std::string_view plain);
/// Returns constant markup unescaped, such as a style sheet or a doctype. Never for text that comes from a file.
Html raw(std::string_view markup);

using Attributes = std::vector<std::pair<std::string_view, std::string>>;  ///< names are ours, values are escaped
Html element(std::string_view name, const Attributes& attributes, const Html& content);
Html element(std::string_view name, const Html& content);
/// Returns an element without content and end tag: img, meta, col.
Html voidElement(std::string_view name, const Attributes& attributes);

/// Returns the CSS colour of a kind of assets, the same on every page; grey for an unknown kind.
std::string kindColor(const std::string& kind);

/// Returns the style sheet of the report.
std::string_view reportStyle();

std::string base64(std::string_view bytes);

struct Picture {
    std::string dataUri;
    std::uint32_t width = 0, height = 0;  ///< [pixels]
};
/// Returns a PNG file under `folder` as a data URL for src="". Nothing if it is missing or not a PNG, or if `name` leads out of the folder.
std::optional<Picture> loadPicture(const std::filesystem::path& folder, const std::string& name);

/// Returns "1,234,567".
std::string groupedCount(std::uint64_t count);
/// Returns three significant digits in the unit that fits: "0 B", "21.3 KiB", "2.00 MiB", "1020 KiB".
std::string humanBytes(std::uint64_t bytes);
/// Returns "0 s", "0.25 ms", "340 ms", "12.3 s", "2 min 05 s", "1 h 02 min"; "not finite" for NaN and infinities.
std::string humanSeconds(double seconds);
/// Returns a ratio in percent, three significant digits: "1.23 %", "0.412 %", "< 0.001 %", "340 %"; "not finite" for NaN and infinities.
std::string humanPercent(double ratio);
/// Returns three significant digits without a unit: "8.00", "0.0123"; "not finite" for NaN and infinities.
std::string humanNumber(double value);
/// Returns the shortest decimal text that parses to the same double.
std::string exactNumber(double value);

}  // namespace lightcook::pipeline
