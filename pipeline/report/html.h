// Markup that what is put into it cannot break, and numbers as people read them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lightcook::pipeline {

/// Finished markup. Text becomes markup only through text(), which escapes it, so nothing gets in unescaped by oversight.
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

/// & < > " ' become entities; control characters that HTML does not allow become U+FFFD. Right inside elements and attributes.
Html text(std::string_view plain);
/// Markup of our own, as it stands: a style sheet, a doctype. Never anything that came from a file.
Html raw(std::string_view markup);

using Attributes = std::vector<std::pair<std::string_view, std::string>>;  ///< names are ours, values are escaped
Html element(std::string_view name, const Attributes& attributes, const Html& content);
Html element(std::string_view name, const Html& content);
/// img, meta, col, ...: no content, no end tag.
Html voidElement(std::string_view name, const Attributes& attributes);

/// A CSS colour. Kinds of assets keep theirs from page to page; a kind that is not ours is grey.
std::string kindColor(const std::string& kind);

/// The style sheet of the report.
std::string_view reportStyle();

std::string base64(std::string_view bytes);

struct Picture {
    std::string dataUri;
    std::uint32_t width = 0, height = 0;  ///< [pixels]
};
/// A PNG under `folder`, ready for src="". Nothing if it is missing, is no PNG, or if `name` leads out of the folder.
std::optional<Picture> loadPicture(const std::filesystem::path& folder, const std::string& name);

/// "1,234,567"
std::string groupedCount(std::uint64_t count);
/// Three significant digits in the unit that fits: "0 B", "21.3 KiB", "2.00 MiB", "1020 KiB".
std::string humanBytes(std::uint64_t bytes);
/// "0 s", "0.25 ms", "340 ms", "12.3 s", "2 min 05 s", "1 h 02 min"; "not finite" for NaN and infinities.
std::string humanSeconds(double seconds);
/// A ratio in percent, three significant digits: "1.23 %", "0.412 %", "< 0.001 %", "340 %"; "not finite" for NaN and infinities.
std::string humanPercent(double ratio);
/// Three significant digits without a unit: "8.00", "0.0123"; "not finite" for NaN and infinities.
std::string humanNumber(double value);
/// The shortest digits that give the same double back.
std::string exactNumber(double value);

}  // namespace lightcook::pipeline
