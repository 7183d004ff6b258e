// The program's operator new: see last_resort.h. The sanitizers bring one of their own.
#include <cstdlib>
#include <new>

#include "pipeline/command/last_resort.h"

#if defined(__has_feature)  // of Clang
#define LIGHTCOOK_IS_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LIGHTCOOK_IS_SANITIZED 1
#else
#define LIGHTCOOK_IS_SANITIZED 0
#endif
#if !LIGHTCOOK_IS_SANITIZED

namespace {

/// Returns what was allocated, if anything was.
void* checked(void* allocated, std::size_t bytes) {
    using namespace lightcook::pipeline;
    if (allocated != nullptr) return allocated;
    if (bytes <= kSmallAllocation) endOutOfMemory();
    throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t bytes) {
    return checked(std::malloc(bytes == 0 ? 1 : bytes), bytes);
}

void* operator new(std::size_t bytes, std::align_val_t alignment) {
    const auto step = static_cast<std::size_t>(alignment);
    return checked(std::aligned_alloc(step, (bytes + step - 1) / step * step), bytes);
}

void operator delete(void* allocated) noexcept {
    std::free(allocated);
}

void operator delete(void* allocated, std::size_t /*bytes*/) noexcept {
    std::free(allocated);
}

void operator delete(void* allocated, std::align_val_t /*alignment*/) noexcept {
    std::free(allocated);
}

void operator delete(void* allocated, std::size_t /*bytes*/, std::align_val_t /*alignment*/) noexcept {
    std::free(allocated);
}

#endif
