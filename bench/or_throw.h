// Errors of the library as exceptions: a bench has nobody to hand them to.
#pragma once

#include <stdexcept>
#include <type_traits>
#include <utility>

#include "formats/error.h"

namespace lightcook::bench {

template <class T>
T orThrow(formats::Result<T> result) {
    if (!result) throw std::runtime_error(result.error().line());
    if constexpr (!std::is_void_v<T>) return std::move(*result);
}

}  // namespace lightcook::bench
