// Textures of made-up bytes, for the tests of containers.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "formats/gpu_texture.h"

namespace lightcook::formats {

inline std::vector<std::byte> wholeFile(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::vector<std::byte> bytes(std::filesystem::file_size(file));
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return bytes;
}

inline void putFile(const std::filesystem::path& file, std::span<const std::byte> bytes) {
    std::ofstream stream(file, std::ios::binary | std::ios::trunc);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// Bytes of one image: another pattern for each mip, layer and face, half noise and half flat so that Zstandard has something to do.
inline std::vector<std::byte> patternImage(const TextureShape& shape, SubImage image) {
    std::mt19937 random(static_cast<unsigned>(image.mip * 10007 + image.layer * 101 + image.face));
    std::vector<std::byte> bytes(shape.imageBytes(image.mip));
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i < bytes.size() / 2 ? random() : image.face + 1);
    return bytes;
}

inline std::vector<SubImage> allImages(const TextureShape& shape) {
    std::vector<SubImage> images;
    for (int mip = 0; mip < shape.mipCount; ++mip)
        for (int layer = 0; layer < shape.layerCount; ++layer)
            for (int face = 0; face < shape.faceCount; ++face) images.push_back({mip, layer, face});
    return images;
}

/// Writes patternImage everywhere, row of blocks by row of blocks, last row first and images in reverse if asked.
inline Result<void> writePattern(const std::filesystem::path& file, const TextureShape& shape, const TextureFileOptions& options,
                                 bool backwards = false) {
    Result<TextureWriter> writer = TextureWriter::create(file, shape, options);
    if (!writer) return tl::make_unexpected(writer.error());
    std::vector<SubImage> images = allImages(shape);
    if (backwards) images = {images.rbegin(), images.rend()};
    for (const SubImage& image : images) {
        const std::vector<std::byte> bytes = patternImage(shape, image);
        const std::size_t rowBytes = bytesPerBlockRow(shape.format, shape.mipWidth(image.mip));
        const int rows = static_cast<int>(bytes.size() / rowBytes);
        for (int i = 0; i < rows; ++i) {
            const int row = backwards ? rows - 1 - i : i;
            const auto part = std::span(bytes).subspan(static_cast<std::size_t>(row) * rowBytes, rowBytes);
            if (Result<void> done = writer->writeBlockRows(image, row, part); !done) return done;
        }
    }
    return writer->commit();
}

struct NamedShape {
    std::string name;
    TextureShape shape;
};

/// Plain, array, array of one, cube and cube array, with and without mips, of extents that are no multiple of any block.
inline std::vector<NamedShape> shapesOf(PixelFormat format) {
    std::vector<NamedShape> shapes = {
        {"plain", {format, 37, 21, 1, 1, false, 1}},
        {"plain-mips", {format, 37, 21, 6, 1, false, 1}},
        {"array-mips", {format, 20, 9, 5, 3, true, 1}},
        {"array-of-one", {format, 5, 30, 1, 1, true, 1}},
        {"cube", {format, 8, 8, 1, 1, false, 6}},
        {"cube-mips", {format, 19, 19, 5, 1, false, 6}},
        {"cube-array-mips", {format, 13, 13, 2, 2, true, 6}},
        {"one-texel", {format, 1, 1, 1, 1, false, 1}},
    };
    return shapes;
}

}  // namespace lightcook::formats
