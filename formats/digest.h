// Digests by which content is identified: XXH3 of 128 bits. They detect changes and corruption, not an attack.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace lightcook::formats {

/// Characters of a digest: hexadecimal digits.
inline constexpr std::size_t kDigestLength = 32;

std::string digestOfText(std::string_view text);

/// The digest of bytes that come in pieces.
class Digest {
public:
    Digest();
    Digest(Digest&&) noexcept;
    Digest& operator=(Digest&&) noexcept;
    ~Digest();
    /// Adds the elements of an array, as they lie in memory.
    template <class T, std::size_t Extent>
    void add(std::span<T, Extent> values) {
        addBytes(std::as_bytes(values));
    }
    /// Returns that of all bytes so far: digestOfText() of them.
    std::string text() const;

private:
    void addBytes(std::span<const std::byte> bytes);

    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace lightcook::formats
