// A file as an array of bytes, with positioned reads and writes that are safe from several threads; little-endian integers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "formats/error.h"

namespace lightcook::formats {

class FileBytes {
public:
    static Result<FileBytes> openForReading(const std::filesystem::path& file);
    /// Opens an existing file. Errors name `shownAs`, because `file` is a temporary that will get that name.
    static Result<FileBytes> openForUpdate(const std::filesystem::path& file, const std::filesystem::path& shownAs);
    FileBytes(FileBytes&& other) noexcept;
    FileBytes& operator=(FileBytes&& other) noexcept;
    ~FileBytes();

    const std::filesystem::path& path() const { return shownAs_; }
    /// [bytes], as it was when the file was opened
    std::uint64_t size() const { return size_; }

    /// Fills all of `out` from the given offset, or fails.
    Result<void> readAt(std::uint64_t offset, std::span<std::byte> out) const;
    Result<void> writeAt(std::uint64_t offset, std::span<const std::byte> bytes) const;
    /// Cuts or extends (with zeros) to the given size.
    Result<void> resize(std::uint64_t bytes);
    /// Waits until the disk has the content.
    Result<void> sync() const;
    void close();

private:
    FileBytes(int descriptor, std::filesystem::path shownAs, std::uint64_t size);
    int descriptor_ = -1;
    std::filesystem::path shownAs_;
    std::uint64_t size_ = 0;
};

/// Little-endian integers. The buffer must hold all of their bytes.
std::uint32_t loadU32(std::span<const std::byte> bytes, std::size_t offset);
std::uint64_t loadU64(std::span<const std::byte> bytes, std::size_t offset);
void appendU32(std::vector<std::byte>& bytes, std::uint32_t value);
void appendU64(std::vector<std::byte>& bytes, std::uint64_t value);

}  // namespace lightcook::formats
