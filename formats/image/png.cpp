#include "formats/png.h"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <new>
#include <string_view>
#include <utility>

#include "formats/file/one_line.h"
#include "formats/image/image_claims.h"
#include "formats/read_file.h"

namespace lightcook::formats {
namespace {

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";

/// The first error of libpng, which may not throw: its functions are C.
class PngError {
public:
    void keep(const char* text) { std::strncpy(text_.data(), text, text_.size() - 1); }
    std::string_view text() const { return text_.data(); }

private:
    std::array<char, 128> text_{};
};

void keepErrorAndJump(png_structp png, png_const_charp text) {
    static_cast<PngError*>(png_get_error_ptr(png))->keep(text);
    png_longjmp(png, 1);
}

/// Warnings are of chunks that hold no texels, such as a colour profile.
void ignoreWarning(png_structp /*png*/, png_const_charp /*text*/) {}

void readBytes(png_structp png, png_bytep out, std::size_t count) {
    auto& rest = *static_cast<std::span<const std::byte>*>(png_get_io_ptr(png));
    if (count > rest.size()) png_error(png, "it ends too early");
    std::memcpy(out, rest.data(), count);
    rest = rest.subspan(count);
}

void appendBytes(png_structp png, png_bytep bytes, std::size_t count) {
    auto& out = *static_cast<std::vector<std::byte>*>(png_get_io_ptr(png));
    bool isAppended = true;
    try {
        const auto added = std::as_bytes(std::span(bytes, count));
        out.insert(out.end(), added.begin(), added.end());
    } catch (const std::bad_alloc&) {
        isAppended = false;  // no jump out of a handler, which would leave its exception alive
    }
    if (!isAppended) png_error(png, "no memory for its bytes");
}

/// Describes the decoded rows of a PNG. Channels are interleaved, and no bytes lie between rows.
struct PngRows {
    int width = 0, height = 0, channelCount = 0;
    int bytesPerChannel = 1;
    bool hasAlpha = false;           ///< in the last channel
    std::size_t storedRowBytes = 0;  ///< of palettes and of 1 to 4 bits as the file has them

    std::size_t rowBytes() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(channelCount) * static_cast<std::size_t>(bytesPerChannel);
    }
};

// libpng reports an error by a jump to where setjmp was called. The functions below that call it own nothing that has a destructor.

/// Reads everything before the texels, and asks for 8 or 16 bits a channel in the byte order of this machine.
bool readHeader(png_structp png, png_infop info, PngRows& rows) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    png_read_info(png, info);
    const std::size_t storedRowBytes = png_get_rowbytes(png, info);
    png_set_expand(png);  // palettes, 1 to 4 bits, and transparent colours
    if (png_get_bit_depth(png, info) == 16) png_set_swap(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    rows = {.width = static_cast<int>(std::min<png_uint_32>(png_get_image_width(png, info), PNG_USER_WIDTH_MAX)),
            .height = static_cast<int>(std::min<png_uint_32>(png_get_image_height(png, info), PNG_USER_HEIGHT_MAX)),
            .channelCount = png_get_channels(png, info),
            .bytesPerChannel = png_get_bit_depth(png, info) / 8,
            .hasAlpha = (png_get_color_type(png, info) & PNG_COLOR_MASK_ALPHA) != 0,
            .storedRowBytes = storedRowBytes};
    return true;
}

bool readRows(png_structp png, png_bytepp rows) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_read_image(png, rows);
    png_read_end(png, nullptr);
    return true;
}

bool writeRows(png_structp png, png_infop info, const PngRows& rows, png_bytepp rowStarts) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_IHDR(png, info, static_cast<png_uint_32>(rows.width), static_cast<png_uint_32>(rows.height), 8,
                 rows.hasAlpha ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    png_write_image(png, rowStarts);
    png_write_end(png, info);
    return true;
}

/// The structures of libpng for one picture.
class PngReading {
public:
    explicit PngReading(std::span<const std::byte> bytes) : rest_(bytes) {
        png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &error_, keepErrorAndJump, ignoreWarning);
        if (png_ == nullptr) throw std::bad_alloc();
        info_ = png_create_info_struct(png_);
        png_set_read_fn(png_, &rest_, readBytes);
    }
    PngReading(const PngReading&) = delete;
    PngReading& operator=(const PngReading&) = delete;
    ~PngReading() { png_destroy_read_struct(&png_, &info_, nullptr); }

    bool readHeader(PngRows& rows) { return formats::readHeader(png_, info_, rows); }
    bool readRows(std::vector<png_bytep>& rowStarts) { return formats::readRows(png_, rowStarts.data()); }
    std::string_view error() const { return error_.text(); }

private:
    std::span<const std::byte> rest_;
    PngError error_;
    png_structp png_ = nullptr;
    png_infop info_ = nullptr;
};

class PngWriting {
public:
    PngWriting() {
        png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, &error_, keepErrorAndJump, ignoreWarning);
        if (png_ == nullptr) throw std::bad_alloc();
        info_ = png_create_info_struct(png_);
        png_set_write_fn(png_, &bytes_, appendBytes, nullptr);
    }
    PngWriting(const PngWriting&) = delete;
    PngWriting& operator=(const PngWriting&) = delete;
    ~PngWriting() { png_destroy_write_struct(&png_, &info_); }

    bool write(const PngRows& rows, std::vector<png_bytep>& rowStarts) { return writeRows(png_, info_, rows, rowStarts.data()); }
    std::vector<std::byte> takeBytes() { return std::move(bytes_); }
    std::string_view error() const { return error_.text(); }

private:
    std::vector<std::byte> bytes_;
    PngError error_;
    png_structp png_ = nullptr;
    png_infop info_ = nullptr;
};

/// Returns the channel of RGBA that a stored channel is.
int targetOf(int channel, const PngRows& rows) {
    return rows.hasAlpha && channel == rows.channelCount - 1 ? 3 : channel;
}

template <class Code>
void unpack(const std::vector<std::byte>& bytes, const PngRows& rows, std::vector<glm::vec4>& texels) {
    constexpr auto kLargest = static_cast<float>(std::numeric_limits<Code>::max());
    const bool isGrey = rows.channelCount < 3;
    const std::byte* next = bytes.data();
    for (glm::vec4& texel : texels) {
        for (int channel = 0; channel < rows.channelCount; ++channel, next += sizeof(Code)) {
            Code code;
            std::memcpy(&code, next, sizeof(code));
            texel[targetOf(channel, rows)] = static_cast<float>(code) / kLargest;
        }
        if (isGrey) texel.y = texel.z = texel.x;
    }
}

template <class Texel>
Result<std::vector<std::byte>> encode(ImageView<const Texel> texels) {
    const char* const subject = "PNG picture";
    if (texels.width < 1 || texels.height < 1) return failure(ErrorCode::WrongShape, subject, "found no texels, expected some");
    const PngRows rows{.width = texels.width, .height = texels.height, .channelCount = Texel::length(), .hasAlpha = Texel::length() == 4};
    std::vector<png_bytep> rowStarts;
    for (int y = 0; y < texels.height; ++y) rowStarts.push_back(const_cast<png_bytep>(&texels.row(y)->x));  // libpng reads them only
    PngWriting writing;
    if (!writing.write(rows, rowStarts))
        return failure(ErrorCode::Internal, subject, fmt::format("found {} while encoding, expected bytes", quotedLine(writing.error())));
    return writing.takeBytes();
}

}  // namespace

bool isPng(std::span<const std::byte> bytes) {
    return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).starts_with(kSignature);
}

bool isPngFile(const std::filesystem::path& file) {
    std::array<char, kSignature.size()> head{};
    std::ifstream(file, std::ios::binary).read(head.data(), head.size());
    return isPng(std::as_bytes(std::span(head)));
}

Result<PlainImage> decodePng(std::span<const std::byte> png, const Subject& subject) {
    if (!isPng(png)) return failure(ErrorCode::FormatUnsupported, subject, "found an image of another kind, expected PNG");
    PngReading reading(png);
    const auto damaged = [&] {
        return failure(ErrorCode::FileUnreadable, subject,
                       fmt::format("found a damaged PNG (\"{}\"), expected a whole image file", oneLine(reading.error())));
    };
    PngRows rows;
    if (!reading.readHeader(rows)) return damaged();
    LC_CHECK(checkExtent(rows.width, rows.height, rows.channelCount, kFloatsThroughLibrary, subject));
    const auto height = static_cast<std::size_t>(rows.height);
    constexpr std::uint64_t kDensestDeflate = 1032;  // 258 bytes in two bits
    LC_CHECK(checkFileHolds(rows.storedRowBytes * height, png.size(), kDensestDeflate, subject));
    std::vector<std::byte> bytes(rows.rowBytes() * height);
    std::vector<png_bytep> rowStarts(height);
    for (std::size_t y = 0; y < height; ++y) rowStarts[y] = reinterpret_cast<png_bytep>(bytes.data() + y * rows.rowBytes());
    if (!reading.readRows(rowStarts)) return damaged();
    PlainImage image{.texels = Image<glm::vec4>(rows.width, rows.height, glm::vec4(0, 0, 0, 1)),
                     .channelCount = rows.channelCount,
                     .hasAlpha = rows.hasAlpha};
    if (rows.bytesPerChannel == 2)
        unpack<std::uint16_t>(bytes, rows, image.texels.texels());
    else
        unpack<std::uint8_t>(bytes, rows, image.texels.texels());
    return image;
}

Result<PlainImage> readPng(const std::filesystem::path& file) {
    return readWholeFile(file).and_then([&](const std::vector<std::byte>& bytes) { return decodePng(bytes, file); });
}

Result<std::vector<std::byte>> encodePng(ImageView<const glm::u8vec3> texels) {
    return encode(texels);
}

Result<std::vector<std::byte>> encodePng(ImageView<const glm::u8vec4> texels) {
    return encode(texels);
}

}  // namespace lightcook::formats
