// Encodes a picture to BC6H and writes it as KTX2, with all mip levels: encode_example TEXTURE.ktx2
#include <cstdio>
#include <glm/vec4.hpp>
#include <vector>

#include "lightcook/compress/encode.h"
#include "lightcook/formats/gpu_texture.h"

namespace {

using namespace lightcook;

constexpr int kSize = 256, kMips = 9;
constexpr formats::PixelFormat kFormat = formats::PixelFormat::Bc6hUf16;

/// A smooth gradient with values above 1, as radiance has.
formats::Image<glm::vec4> gradient(int size) {
    formats::Image<glm::vec4> image(size, size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const float u = (static_cast<float>(x) + 0.5f) / static_cast<float>(size),
                        v = (static_cast<float>(y) + 0.5f) / static_cast<float>(size);
            image.at(x, y) = {4 + 3 * u, 3 + 2 * v, 2 + u * v, 1};
        }
    return image;
}

formats::Result<void> write(const char* file) {
    formats::TextureShape shape;
    shape.format = kFormat;
    shape.width = shape.height = kSize;
    shape.mipCount = kMips;
    auto writer = formats::TextureWriter::create(file, shape, {});
    if (!writer) return tl::make_unexpected(writer.error());
    for (int mip = 0; mip < kMips; ++mip) {
        const formats::Image<glm::vec4> texels = gradient(shape.mipWidth(mip));
        std::vector<std::byte> blocks(shape.imageBytes(mip));
        // Pure: rows of blocks may be encoded on any threads, and the bytes do not depend on the cut.
        compress::encodeRows(kFormat, texels.view(), {}, {}, blocks, {});
        if (auto written = writer->writeBlockRows({mip, 0, 0}, 0, blocks); !written) return written;
    }
    return writer->commit();  // the file appears here, whole
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: encode_example TEXTURE.ktx2\n");
        return 2;
    }
    const auto written = write(argv[1]);
    if (!written) std::fprintf(stderr, "encode_example: %s: %s\n", written.error().subject.c_str(), written.error().detail.c_str());
    return written ? 0 : 1;
}
