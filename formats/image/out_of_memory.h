// Memory that runs out inside a library is no fault of the file that it reads.
#pragma once

#include <exception>
#include <new>
#include <string_view>

namespace lightcook::formats {

/// Throws std::bad_alloc if a library's exception says that memory ran out. OpenEXR and OpenColorIO keep only the text of some.
inline void throwIfOutOfMemory(const std::exception& exception) {
    if (std::string_view(exception.what()).find("bad_alloc") != std::string_view::npos) throw std::bad_alloc();
}

}  // namespace lightcook::formats
