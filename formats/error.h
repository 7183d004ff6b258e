// The one way in which a bad file, recipe or request travels: as a value that names where and what.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace lightcook::formats {

enum class ErrorCode {
    InvalidRequest,     ///< command line or scene file: exit code 2
    FileUnreadable,     ///< missing, truncated, not the format it claims to be: 3
    FormatUnsupported,  ///< readable, but not something that we read or write: 3
    WrongShape,         ///< channels, size, faces or layout differ from what was asked for: 3
    ValueNotFinite,     ///< NaN or infinity: 3
    ValueOutOfRange,    ///< negative energy, beyond the format: 3
    ColorSpace,         ///< unknown, or not linear where it has to be: 3
    Verification,       ///< error over its bound, content not what was cooked: 4
    OverBudget,         ///< 5
    Interrupted,        ///< 6
    Internal,           ///< a fault of ours, or of the machine (disk full): 1
};

/// One line for the user reads "subject: found ..., expected ...".
struct Error {
    ErrorCode code = ErrorCode::Internal;
    std::string subject;  ///< file and place: "lobby.exr, channel sh03.G, texel (12, 7)"
    std::string detail;   ///< "found NaN, expected a finite value"

    std::string line() const { return subject + ": " + detail; }
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> failure(ErrorCode code, std::string subject, std::string detail) {
    return tl::make_unexpected(Error{code, std::move(subject), std::move(detail)});
}

}  // namespace lightcook::formats
