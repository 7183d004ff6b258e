#include "verify/texture_unit.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>

#include "formats/memory.h"
#include "verify/texture/decode.h"

namespace lightcook::verify {
namespace {

using formats::PixelFormat;

/// Returns a block or texel of exactly N bytes.
template <std::size_t N>
std::span<const std::byte, N> fixed(std::span<const std::byte> block) {
    return block.first<N>();
}
Texels4x4 texels4x4(std::span<glm::vec4> out) {
    return out.first<16>();
}

/// The two nearest texels along one axis and the weight of the second.
struct Taps {
    int first, second;
    double weight;
};

Taps tapsAt(double coordinate, int size, Wrap wrap) {
    const double position = coordinate * size - 0.5, below = std::floor(position);
    const auto index = [&](double i) {
        if (wrap == Wrap::Repeat) {
            const int wrapped = static_cast<int>(std::fmod(i, size));
            return wrapped < 0 ? wrapped + size : wrapped;
        }
        return static_cast<int>(std::clamp(i, 0.0, static_cast<double>(size - 1)));
    };
    return {index(below), index(below + 1), position - below};
}

glm::dvec4 mix(const glm::dvec4& t00, const glm::dvec4& t10, const glm::dvec4& t01, const glm::dvec4& t11, double x, double y) {
    return (t00 * (1 - x) + t10 * x) * (1 - y) + (t01 * (1 - x) + t11 * x) * y;
}

// ---- cube: u runs right, v down, both in [-1, 1] inside a face (lighting/cube.h has the drawing) ----

struct FacePoint {
    int face;
    double u, v;
};

glm::dvec3 directionOf(const FacePoint& p) {
    switch (p.face) {
        case 0:
            return {1, -p.v, -p.u};
        case 1:
            return {-1, -p.v, p.u};
        case 2:
            return {p.u, 1, p.v};
        case 3:
            return {p.u, -1, -p.v};
        case 4:
            return {p.u, -p.v, 1};
        default:
            return {-p.u, -p.v, -1};
    }
}

FacePoint facePointOf(const glm::dvec3& d) {
    const glm::dvec3 a = glm::abs(d);
    if (a.x >= a.y && a.x >= a.z) return d.x > 0 ? FacePoint{0, -d.z / a.x, -d.y / a.x} : FacePoint{1, d.z / a.x, -d.y / a.x};
    if (a.y >= a.z) return d.y > 0 ? FacePoint{2, d.x / a.y, d.z / a.y} : FacePoint{3, d.x / a.y, -d.z / a.y};
    return d.z > 0 ? FacePoint{4, d.x / a.z, -d.y / a.z} : FacePoint{5, -d.x / a.z, -d.y / a.z};
}

/// Returns the texel at (x, y) of a face. One step outside the face, this is the adjacent texel of the neighbour face: seen from the cube's
/// centre, the point half a texel beyond the edge is in that texel, at every size.
glm::dvec4 texelAcrossEdges(std::span<const formats::Image<glm::vec4>> faces, int face, int x, int y) {
    const int size = faces[0].width();
    if (x >= 0 && x < size && y >= 0 && y < size) return faces[static_cast<std::size_t>(face)].at(x, y);
    const FacePoint outside{face, (2 * x + 1.0) / size - 1, (2 * y + 1.0) / size - 1};
    const FacePoint inside = facePointOf(directionOf(outside));
    const auto index = [&](double t) { return std::clamp(static_cast<int>((t + 1) / 2 * size), 0, size - 1); };
    return faces[static_cast<std::size_t>(inside.face)].at(index(inside.u), index(inside.v));
}

}  // namespace

void decodeBlock(PixelFormat format, std::span<const std::byte> block, std::span<glm::vec4> out) {
    const formats::PixelFormatInfo& info = formats::info(format);
    assert(block.size() == static_cast<std::size_t>(info.bytesPerBlock));
    assert(out.size() == static_cast<std::size_t>(info.blockWidth * info.blockHeight));
    switch (format) {
        case PixelFormat::Bc1:
            return decodeBc1(fixed<8>(block), texels4x4(out));
        case PixelFormat::Bc3:
            return decodeBc3(fixed<16>(block), texels4x4(out));
        case PixelFormat::Bc4:
            return decodeBc4(fixed<8>(block), texels4x4(out));
        case PixelFormat::Bc4Snorm:
            return decodeBc4Snorm(fixed<8>(block), texels4x4(out));
        case PixelFormat::Bc5:
            return decodeBc5(fixed<16>(block), texels4x4(out));
        case PixelFormat::Bc5Snorm:
            return decodeBc5Snorm(fixed<16>(block), texels4x4(out));
        case PixelFormat::Bc6hUf16:
            return decodeBc6h(fixed<16>(block), false, texels4x4(out));
        case PixelFormat::Bc6hSf16:
            return decodeBc6h(fixed<16>(block), true, texels4x4(out));
        case PixelFormat::Bc7:
            return decodeBc7(fixed<16>(block), texels4x4(out));
        case PixelFormat::Astc4x4Hdr:
        case PixelFormat::Astc6x6Hdr:
        case PixelFormat::Astc8x8Hdr:
            return decodeAstc(fixed<16>(block), info.blockWidth, info.blockHeight, true, out);
        case PixelFormat::Astc4x4Ldr:
            return decodeAstc(fixed<16>(block), info.blockWidth, info.blockHeight, false, out);
        case PixelFormat::Rgb9e5:
            out[0] = decodeRgb9e5(fixed<4>(block));
            return;
        case PixelFormat::R11g11b10f:
            out[0] = decodeR11g11b10f(fixed<4>(block));
            return;
        case PixelFormat::Rgba16f:
            out[0] = decodeHalfs(block, 4);
            return;
        case PixelFormat::Rgb16f:
            out[0] = decodeHalfs(block, 3);
            return;
        case PixelFormat::R16Unorm:
            out[0] = decodeUnorm16(block, 1);
            return;
        case PixelFormat::Rg16Unorm:
            out[0] = decodeUnorm16(block, 2);
            return;
        case PixelFormat::Rgba16Unorm:
            out[0] = decodeUnorm16(block, 4);
            return;
        case PixelFormat::Rgba8Unorm:
            out[0] = decodeUnorm8(fixed<4>(block));
            return;
        case PixelFormat::Rgba8Srgb:
            out[0] = decodeSrgb8(fixed<4>(block));
            return;
    }
}

namespace {

/// Calls decode(block, texels) for each block of an image.
template <class Decode>
void forEachBlock(PixelFormat format, std::span<const std::byte> blocks, formats::ImageView<glm::vec4> out, const Decode& decode) {
    const formats::PixelFormatInfo& info = formats::info(format);
    assert(blocks.size() == formats::bytesPerImage(format, out.width, out.height));
    const std::size_t bytes = static_cast<std::size_t>(info.bytesPerBlock),
                      texelCount = static_cast<std::size_t>(info.blockWidth * info.blockHeight);
    std::array<glm::vec4, 144> texels;
    for (int y = 0; y < out.height; y += info.blockHeight)
        for (int x = 0; x < out.width; x += info.blockWidth, blocks = blocks.subspan(bytes)) {
            decode(blocks.first(bytes), std::span(texels).first(texelCount));
            // The last column and row of blocks may extend beyond the image.
            const int width = std::min(info.blockWidth, out.width - x), height = std::min(info.blockHeight, out.height - y);
            for (int row = 0; row < height; ++row) std::copy_n(texels.data() + row * info.blockWidth, width, out.row(y + row) + x);
        }
}

}  // namespace

void decodeRows(PixelFormat format, std::span<const std::byte> blocks, formats::ImageView<glm::vec4> out) {
    forEachBlock(format, blocks, out,
                 [format](std::span<const std::byte> block, std::span<glm::vec4> texels) { decodeBlock(format, block, texels); });
}

formats::Result<formats::Image<glm::vec4>> decodeImage(const formats::TextureReader& texture, formats::SubImage image) {
    const formats::Result<std::vector<std::byte>> blocks = texture.readImage(image);
    if (!blocks) return tl::make_unexpected(blocks.error());
    const formats::TextureShape& shape = texture.shape();
    const std::uint64_t texels =
        static_cast<std::uint64_t>(shape.mipWidth(image.mip)) * static_cast<std::uint64_t>(shape.mipHeight(image.mip));
    LC_CHECK(formats::checkMemory(texels * sizeof(glm::vec4), "a level of a texture"));
    formats::Image<glm::vec4> decoded(shape.mipWidth(image.mip), shape.mipHeight(image.mip));
    if (texture.hasBc1Alpha())
        forEachBlock(shape.format, *blocks, decoded.view(),
                     [](std::span<const std::byte> block, std::span<glm::vec4> out) { decodeBc1Alpha(fixed<8>(block), texels4x4(out)); });
    else
        decodeRows(shape.format, *blocks, decoded.view());
    return decoded;
}

glm::vec4 sampleBilinear(formats::ImageView<const glm::vec4> image, glm::dvec2 uv, Wrap wrapX, Wrap wrapY) {
    const Taps x = tapsAt(uv.x, image.width, wrapX), y = tapsAt(uv.y, image.height, wrapY);
    return mix(image.at(x.first, y.first), image.at(x.second, y.first), image.at(x.first, y.second), image.at(x.second, y.second), x.weight,
               y.weight);
}

glm::vec4 sampleCube(std::span<const formats::Image<glm::vec4>> faces, glm::dvec3 direction) {
    assert(faces.size() == 6);
    const int size = faces[0].width();
    const FacePoint point = facePointOf(direction);
    const double px = (point.u + 1) / 2 * size - 0.5, py = (point.v + 1) / 2 * size - 0.5;
    const int x = static_cast<int>(std::floor(px)), y = static_cast<int>(std::floor(py));
    std::array<glm::dvec4, 4> texels{};
    int missing = -1;
    for (int i = 0; i < 4; ++i) {
        const int tx = x + i % 2, ty = y + i / 2;
        const bool isOutsideX = tx < 0 || tx >= size, isOutsideY = ty < 0 || ty >= size;
        if (isOutsideX && isOutsideY)
            missing = i;
        else
            texels[static_cast<std::size_t>(i)] = texelAcrossEdges(faces, point.face, tx, ty);
    }
    if (missing >= 0) {
        glm::dvec4 sum(0);
        for (const glm::dvec4& texel : texels) sum += texel;
        texels[static_cast<std::size_t>(missing)] = sum / 3.0;
    }
    return mix(texels[0], texels[1], texels[2], texels[3], px - x, py - y);
}

}  // namespace lightcook::verify
