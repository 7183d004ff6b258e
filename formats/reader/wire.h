// Values as the bytes of a message between the program and a reader (reader_process.h). Both run on one machine and are of one version, so
// numbers are in the order of the machine. WireReader trusts no byte: a reader that a hostile file has taken over may send any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace lightcook::formats {

class WireWriter {
public:
    template <class T>
    requires std::is_arithmetic_v<T> || std::is_enum_v<T>
    void put(T value) {
        char bytes[sizeof(T)];
        std::memcpy(bytes, &value, sizeof value);
        bytes_.append(bytes, sizeof value);
    }
    void put(std::string_view text) {
        put(static_cast<std::uint32_t>(text.size()));
        bytes_ += text;
    }
    void put(const std::vector<std::string>& texts) {
        put(static_cast<std::uint32_t>(texts.size()));
        for (const std::string& each : texts) put(std::string_view(each));
    }
    std::span<const std::byte> bytes() const { return std::as_bytes(std::span(bytes_)); }

private:
    std::string bytes_;
};

/// Reads values in the order in which they were put. Past the end, numbers are 0 and texts empty, and isWhole() is false.
class WireReader {
public:
    explicit WireReader(std::vector<std::byte> bytes) : bytes_(std::move(bytes)), rest_(bytes_) {}
    WireReader(const WireReader&) = delete;
    WireReader& operator=(const WireReader&) = delete;

    template <class T>
    requires std::is_arithmetic_v<T> || std::is_enum_v<T> T get() {
        T value{};
        const auto bytes = take(sizeof(T));
        if constexpr (std::is_same_v<T, bool>) {  // not every byte is one
            value = !bytes.empty() && bytes.front() != std::byte{0};
        } else if (!bytes.empty()) {
            std::memcpy(&value, bytes.data(), sizeof value);
        }
        return value;
    }
    std::string text() {
        const auto bytes = take(get<std::uint32_t>());
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    std::vector<std::string> texts() {
        std::vector<std::string> all;
        for (auto count = get<std::uint32_t>(); count > 0 && !isShort_; --count) all.push_back(text());
        return all;
    }
    bool hasMore() const { return !rest_.empty(); }
    /// Returns true if every value was there, and nothing is left.
    bool isWhole() const { return !isShort_ && rest_.empty(); }

private:
    std::span<const std::byte> take(std::size_t count) {
        if (count > rest_.size()) {
            isShort_ = true;
            rest_ = {};
            return {};
        }
        const auto taken = rest_.first(count);
        rest_ = rest_.subspan(count);
        return taken;
    }

    std::vector<std::byte> bytes_;
    std::span<const std::byte> rest_;
    bool isShort_ = false;
};

}  // namespace lightcook::formats
