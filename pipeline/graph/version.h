// Who wrote a file.
#pragma once

namespace pipeline {

inline constexpr const char* kToolName = "lightcook";
inline constexpr const char* kToolVersion = LIGHTCOOK_VERSION;

}  // namespace pipeline
