// The end of a process that cannot go on, such as one whose memory has run out: one line and the exit code of an internal error. Temporary
// files go, and no half output appears.
//
// Memory: an allocation of up to kSmallAllocation bytes that fails ends the process on the spot (operator_new.cpp), as a signal does. An
// exception would pass through libraries that are not made for it: OpenEXR 3.1 and oneTBB 2021 then wait for ever, OpenColorIO 2.1 ends
// the process. A larger one throws std::bad_alloc: a file may ask for too much, and whoever reads it says so.
#pragma once

#include <cstddef>

#include "pipeline/command/terminal/terminal.h"

namespace lightcook::pipeline {

/// The program says this where memory runs out.
inline constexpr const char* kMemorySubject = "memory";
inline constexpr const char* kTooLittleMemory = "found too little of it, expected more: free some, or use fewer threads (-j N)";
inline constexpr std::size_t kSmallAllocation = std::size_t{64} << 20;  ///< [bytes]

/// Ends the process in this way where std::terminate would end it with SIGABRT.
void installLastResort();
/// Sets the form of the line. Text before the first call.
void setLastResortLog(LogFormat log);
/// Ends the process, whose memory has run out. Allocates nothing.
[[noreturn]] void endOutOfMemory();

}  // namespace lightcook::pipeline
