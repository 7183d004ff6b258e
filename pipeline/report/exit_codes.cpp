#include "pipeline/report/exit_codes.h"

#include <array>

namespace lightcook::pipeline {
namespace {

constexpr std::array kExitCodes = {
    ExitCodeInfo{0, "success"},
    ExitCodeInfo{1, "internal error, or an error of the system, such as a full disk"},
    ExitCodeInfo{2, "mistake on the command line or in the scene file"},
    ExitCodeInfo{3, "input refused: unreadable, not finite, of the wrong shape or not plausible"},
    ExitCodeInfo{4, "verification failed: an error over its limit, or a file that is not the one that was cooked"},
    ExitCodeInfo{5, "over the memory budget"},
    ExitCodeInfo{6, "interrupted"},
};

}  // namespace

std::span<const ExitCodeInfo> allExitCodes() {
    return kExitCodes;
}

int exitCode(formats::ErrorCode code) {
    using formats::ErrorCode;
    switch (code) {
        case ErrorCode::Internal:
            return 1;
        case ErrorCode::InvalidRequest:
            return 2;
        case ErrorCode::FileUnreadable:
        case ErrorCode::FormatUnsupported:
        case ErrorCode::UnknownBake:
        case ErrorCode::WrongShape:
        case ErrorCode::ValueNotFinite:
        case ErrorCode::ValueOutOfRange:
        case ErrorCode::Implausible:
        case ErrorCode::ColorSpace:
            return 3;
        case ErrorCode::Verification:
        case ErrorCode::OverLimit:
            return 4;
        case ErrorCode::OverBudget:
            return 5;
        case ErrorCode::Interrupted:
            return 6;
    }
    return 1;
}

formats::ErrorCode errorCodeFor(int exitCode) {
    using formats::ErrorCode;
    for (const ErrorCode code :
         {ErrorCode::InvalidRequest, ErrorCode::FileUnreadable, ErrorCode::Verification, ErrorCode::OverBudget, ErrorCode::Interrupted})
        if (pipeline::exitCode(code) == exitCode) return code;
    return ErrorCode::Internal;
}

}  // namespace lightcook::pipeline
