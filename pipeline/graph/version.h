// Name and version of the program, as the files that it writes state them.
#pragma once

namespace lightcook::pipeline {

inline constexpr const char* kToolName = "lightcook";
inline constexpr const char* kToolVersion = LIGHTCOOK_VERSION;

}  // namespace lightcook::pipeline
