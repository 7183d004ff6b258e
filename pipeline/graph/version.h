// Who wrote a file.
#pragma once

namespace lightcook::pipeline {

inline constexpr const char* kToolName = "lightcook";
inline constexpr const char* kToolVersion = LIGHTCOOK_VERSION;

}  // namespace lightcook::pipeline
