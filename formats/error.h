// Errors of files, scenes and requests are values that name the place and the fault.
#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace lightcook::formats {

enum class ErrorCode {
    InvalidRequest,     ///< fault in the command line or the scene file: exit code 2
    FileUnreadable,     ///< missing, truncated, not the format it claims to be: 3
    FormatUnsupported,  ///< readable, but not something that we read or write: 3
    WrongShape,         ///< channels, size or faces differ from those required: 3
    ValueNotFinite,     ///< NaN or infinity: 3
    ValueOutOfRange,    ///< negative energy, beyond the format: 3
    Implausible,        ///< lint: a finding that is an error, or any finding with --strict: 3
    ColorSpace,         ///< unknown, or not linear where it has to be: 3
    Verification,       ///< error over its limit, or content that differs from the cooked one: 4
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

/// Users read one line, "subject: detail". The detail says what was found and what was expected, or what to do.
struct Error {
    ErrorCode code = ErrorCode::Internal;
    std::string subject;  ///< file and place: "lobby.exr, channel sh03.G, texel (12, 7)"
    std::string detail;   ///< "found NaN, expected a finite value"

    std::string line() const { return withoutControls(subject + ": " + detail); }
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> failure(ErrorCode code, std::string subject, std::string detail) {
    return tl::make_unexpected(Error{code, std::move(subject), std::move(detail)});
}

}  // namespace lightcook::formats

/// Sets a new variable `name` to a Result, and returns its error from the function if it has one.
#define LC_TRY(name, ...)    \
    auto name = __VA_ARGS__; \
    if (!name) return tl::make_unexpected(std::move(name).error())

/// Returns the error of a Result from the function if it has one.
#define LC_CHECK(...) \
    if (auto lcChecked = __VA_ARGS__; !lcChecked) return tl::make_unexpected(std::move(lcChecked).error())
