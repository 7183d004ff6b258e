#include "formats/digest.h"

#include <fmt/format.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace lightcook::formats {
namespace {

std::string hex(XXH128_hash_t hash) {
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace

struct Digest::State {
    XXH3_state_t xxh;
};

std::string digestOfText(std::string_view text) {
    return hex(XXH3_128bits(text.data(), text.size()));
}

Digest::Digest() : state_(std::make_unique<State>()) {
    XXH3_128bits_reset(&state_->xxh);
}
Digest::Digest(Digest&&) noexcept = default;
Digest& Digest::operator=(Digest&&) noexcept = default;
Digest::~Digest() = default;

void Digest::addBytes(std::span<const std::byte> bytes) {
    XXH3_128bits_update(&state_->xxh, bytes.data(), bytes.size());
}

std::string Digest::text() const {
    return hex(XXH3_128bits_digest(&state_->xxh));
}

}  // namespace lightcook::formats
