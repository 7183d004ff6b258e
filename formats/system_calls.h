// System calls that a signal may interrupt (EINTR) are made again: a process that is traced, stopped and continued, or that reads from a
// network's file system, meets this.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <string_view>

namespace lightcook::formats {

/// Makes a call that returns -1 and sets errno until it is not interrupted. Returns its result.
template <class Call>
auto retried(Call call) {
    for (;;) {
        const auto result = call();
        if (result != -1 || errno != EINTR) return result;
    }
}

/// Writes all bytes to a file, pipe or terminal at its current place. Returns false with the cause in errno. Allocates nothing.
inline bool writeWhole(int descriptor, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t count = retried([&] { return ::write(descriptor, bytes.data(), bytes.size()); });
        if (count <= 0) {
            if (count == 0) errno = ENOSPC;
            return false;
        }
        bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
}

}  // namespace lightcook::formats
