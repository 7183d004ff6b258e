// Errors of files, scenes and requests are values that name the place and the fault.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

namespace lightcook::formats {

enum class ErrorCode {
    InvalidRequest,     ///< fault in the command line or the scene file: exit code 2
    FileUnreadable,     ///< missing, truncated, not the format it claims to be: 3
    FormatUnsupported,  ///< readable, but not something that we read or write: 3
    UnknownBake,        ///< an image that has nothing of a bake format: 3
    WrongShape,         ///< channels, size or faces differ from those required: 3
    ValueNotFinite,     ///< NaN or infinity: 3
    ValueOutOfRange,    ///< negative energy, beyond the format: 3
    Implausible,        ///< lint: a finding that is an error, or any finding with --strict: 3
    ColorSpace,         ///< unknown, or not linear where it has to be: 3
    Verification,       ///< content that differs from the cooked one: 4
    OverLimit,          ///< figures of an asset that did not pass: each is a Failure of report.json: 4
    OverBudget,         ///< 5
    Interrupted,        ///< 6
    Internal,           ///< fault of lightcook or of the machine (disk full): 1
};

/// Returns true if UTF-8 text begins with a control of the direction of text, U+202A to U+202E or U+2066 to U+2069: three bytes. Such a
/// letter reorders how a terminal shows the rest of the line.
inline bool beginsWithDirectionControl(std::string_view text) {
    if (text.size() < 3 || text[0] != '\xe2') return false;
    const auto second = static_cast<unsigned char>(text[1]), third = static_cast<unsigned char>(text[2]);
    return (second == 0x80 && third >= 0xaa && third <= 0xae) || (second == 0x81 && third >= 0xa6 && third <= 0xa9);
}

/// Replaces control characters by escapes (\n, \t, \r, \x1b, \u202e): names of files may hold them. Other UTF-8 stays.
inline std::string withoutControls(std::string_view text) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string line;
    line.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char character = text[i];
        const auto code = static_cast<unsigned char>(character);
        if (beginsWithDirectionControl(text.substr(i))) {
            const unsigned second = static_cast<unsigned char>(text[i + 1]), third = static_cast<unsigned char>(text[i + 2]);
            const unsigned low = (second & 3) << 6 | (third & 0x3f);
            line += "\\u20";
            line += kDigits[low / 16];
            line += kDigits[low % 16];
            i += 2;
        } else if (code >= ' ' && code != 0x7f) {
            line += character;
        } else if (character == '\n' || character == '\t' || character == '\r') {
            line += character == '\n' ? "\\n" : character == '\t' ? "\\t" : "\\r";
        } else {
            line += "\\x";
            line += kDigits[code / 16];
            line += kDigits[code % 16];
        }
    }
    return line;
}

/// What an error is about, as users read it: a file and a place in it, an option, or an asset.
struct Subject {
    Subject(const std::filesystem::path& about) : text(about.string()), file(about) {}
    Subject(std::string words) : text(std::move(words)) {}
    Subject(const char* words) : text(words) {}

    /// Returns a line of a text file, and a column of it: "scene.toml:12:3".
    static Subject inLine(const std::filesystem::path& file, int line, int column = 0) {
        Subject place(file);
        place.text += ":" + std::to_string(line) + (column > 0 ? ":" + std::to_string(column) : "");
        place.lineNumber = line;
        return place;
    }
    /// Returns a place in it: "lobby.exr, channel R"; itself without one.
    Subject at(std::string_view place) const {
        Subject inside = *this;
        if (!place.empty()) inside.text.append(", ").append(place);
        return inside;
    }

    std::string text;
    std::filesystem::path file;          ///< empty: it is no file, or in none
    std::optional<int> lineNumber = {};  ///< of a text file, from 1
};

/// Users read one line, "subject: detail". The detail says what was found and what was expected, or what to do.
struct Error {
    Error() = default;
    Error(ErrorCode what, Subject about, std::string words)
        : code(what), subject(std::move(about.text)), detail(std::move(words)), file(std::move(about.file)), lineNumber(about.lineNumber) {}

    ErrorCode code = ErrorCode::Internal;
    std::string subject;  ///< file and place: "lobby.exr, channel sh03.G, texel (12, 7)"
    std::string detail;   ///< "found NaN, expected a finite value"
    // The same for programs.
    std::string asset = {};              ///< that could not be cooked, or did not pass; empty: none, or not one alone
    std::filesystem::path file = {};     ///< of the subject; empty: none
    std::optional<int> lineNumber = {};  ///< of that file

    std::string line() const { return withoutControls(subject + ": " + detail); }
};

/// Appends an error unless there is one of the same line, and returns true then: one bad input can stop several actions.
inline bool addOnce(std::vector<Error>& errors, const Error& error) {
    for (const Error& each : errors)
        if (each.line() == error.line()) return false;
    errors.push_back(error);
    return true;
}

template <class T>
using Result = tl::expected<T, Error>;

/// Returns a result whose error, if it has one, names the asset that it stopped.
template <class T>
Result<T> ofAsset(const std::string& asset, Result<T> result) {
    if (!result && result.error().asset.empty()) result.error().asset = asset;
    return result;
}

inline tl::unexpected<Error> failure(ErrorCode code, Subject about, std::string detail) {
    return tl::make_unexpected(Error(code, std::move(about), std::move(detail)));
}

}  // namespace lightcook::formats

/// Sets a new variable `name` to a Result, and returns its error from the function if it has one.
#define LC_TRY(name, ...)    \
    auto name = __VA_ARGS__; \
    if (!name) return tl::make_unexpected(std::move(name).error())

/// Returns the error of a Result from the function if it has one.
#define LC_CHECK(...) \
    if (auto lcChecked = __VA_ARGS__; !lcChecked) return tl::make_unexpected(std::move(lcChecked).error())
