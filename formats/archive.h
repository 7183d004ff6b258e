// Values as bytes, and back: for caches, which the same build of the program reads again. A class with pointers inside lists its members
// once, for both directions:
//   template <class Archive, class Self>
//   static void members(Archive& archive, Self& self) { archive(self.name, self.values); }
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "formats/image.h"

namespace lightcook::formats {

/// A value whose bytes in memory are all of it.
template <class T>
concept PlainBytes = std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>;

class ArchiveWriter {
public:
    template <class... T>
    void operator()(const T&... values) {
        (add(values), ...);
    }
    /// Adds counts most of which are 0: seven bits in a byte, the lowest first, as LEB128 has them.
    void sparse(const std::vector<std::int64_t>& counts) {
        add(static_cast<std::uint64_t>(counts.size()));
        for (const std::int64_t count : counts) {
            auto rest = static_cast<std::uint64_t>(count);
            for (; rest >= 128; rest >>= 7) bytes_ += static_cast<char>(rest | 128);
            bytes_ += static_cast<char>(rest);
        }
    }
    std::string take() { return std::move(bytes_); }

private:
    template <class T>
    void add(const T& value) {
        if constexpr (PlainBytes<T>)
            bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
        else
            T::members(*this, value);
    }
    template <class Range>
    void addAll(const Range& values) {
        add(static_cast<std::uint64_t>(values.size()));
        for (const auto& value : values) add(value);
    }
    template <class T>
    void add(const std::vector<T>& values) {
        if constexpr (PlainBytes<T>) {
            add(static_cast<std::uint64_t>(values.size()));
            bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        } else {
            addAll(values);
        }
    }
    void add(const std::string& text) {
        add(static_cast<std::uint64_t>(text.size()));
        bytes_ += text;
    }
    template <class Key, class T>
    void add(const std::map<Key, T>& values) {
        addAll(values);
    }
    template <class A, class B>
    void add(const std::pair<A, B>& pair) {
        (*this)(pair.first, pair.second);
    }
    template <class T>
    void add(const Image<T>& image) {
        (*this)(image.width(), image.height(), image.texels());
    }
    template <class T>
    void add(const std::optional<T>& value) {
        add(value.has_value());
        if (value) add(*value);
    }

    std::string bytes_;
};

class ArchiveReader {
public:
    explicit ArchiveReader(std::string_view bytes) : rest_(bytes) {}
    /// Reads values. After a value that the bytes do not hold whole, nothing is read any more.
    template <class... T>
    void operator()(T&... values) {
        (take(values), ...);
    }
    /// Reads counts most of which are 0.
    void sparse(std::vector<std::int64_t>& counts) {
        counts.resize(takeCount(1));
        for (std::int64_t& count : counts) {
            std::uint64_t bits = 0;
            std::uint8_t byte = 128;
            for (int shift = 0; byte >= 128 && isWhole_; shift += 7) {
                isWhole_ = shift < 64;
                take(byte);
                if (isWhole_) bits |= static_cast<std::uint64_t>(byte & 127) << shift;
            }
            count = static_cast<std::int64_t>(bits);
        }
    }
    /// Returns true if the values that were read are all that the bytes hold.
    bool isDone() const { return isWhole_ && rest_.empty(); }

private:
    void take(void* to, std::size_t count) {
        isWhole_ = isWhole_ && count <= rest_.size();
        if (!isWhole_ || count == 0) return;
        std::memcpy(to, rest_.data(), count);
        rest_.remove_prefix(count);
    }
    template <class T>
    void take(T& value) {
        if constexpr (PlainBytes<T>)
            take(&value, sizeof(T));
        else
            T::members(*this, value);
    }
    /// Returns a number of elements, of which each takes this many bytes at least.
    std::size_t takeCount(std::size_t bytes) {
        std::uint64_t count = 0;
        take(count);
        isWhole_ = isWhole_ && count <= rest_.size() / bytes;
        return isWhole_ ? static_cast<std::size_t>(count) : 0;
    }
    template <class T>
    void take(std::vector<T>& values) {
        if constexpr (PlainBytes<T>) {
            values.resize(takeCount(sizeof(T)));
            take(values.data(), values.size() * sizeof(T));
        } else {
            values.clear();
            for (std::size_t left = takeCount(1); left > 0; --left) take(values.emplace_back());
        }
    }
    void take(std::string& text) {
        text.resize(takeCount(1));
        take(text.data(), text.size());
    }
    template <class Key, class T>
    void take(std::map<Key, T>& values) {
        values.clear();
        for (std::size_t left = takeCount(1); left > 0; --left) {
            std::pair<Key, T> value;
            take(value);
            values.insert(std::move(value));
        }
    }
    template <class A, class B>
    void take(std::pair<A, B>& pair) {
        (*this)(pair.first, pair.second);
    }
    template <class T>
    void take(Image<T>& image) {
        int width = 0, height = 0;
        std::vector<T> texels;
        (*this)(width, height, texels);
        isWhole_ =
            isWhole_ && width >= 0 && height >= 0 && texels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
        if (!isWhole_) return;
        image = Image<T>(width, height);
        image.texels() = std::move(texels);
    }
    template <class T>
    void take(std::optional<T>& value) {
        bool isThere = false;
        take(isThere);
        value.reset();
        if (isThere) take(value.emplace());
    }

    std::string_view rest_;
    bool isWhole_ = true;
};

/// Returns a value as bytes.
template <class T>
std::string archived(const T& value) {
    ArchiveWriter writer;
    writer(value);
    return writer.take();
}

/// Returns the value of these bytes, or nothing if they are not those of one.
template <class T>
std::optional<T> unarchived(std::string_view bytes) {
    ArchiveReader reader(bytes);
    std::optional<T> value(std::in_place);
    reader(*value);
    return reader.isDone() ? std::move(value) : std::nullopt;
}

}  // namespace lightcook::formats
