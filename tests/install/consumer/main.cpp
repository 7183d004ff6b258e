// A project that knows lightcook only as an installed package: encodes a texture to BC6H, writes it as KTX2, reads it back, decodes it
// with the verifier's own decoder, and evaluates a function of the shader include in C++.
#include <cmath>
#include <cstdio>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>
#include <vector>

#include "lightcook/compress/encode.h"
#include "lightcook/formats/gpu_texture.h"
#include "lightcook/shaders/include.h"
#include "lightcook/shaders/lightcook_cpp.h"
#include "lightcook/verify/texture_unit.h"

namespace {

using namespace lightcook;

constexpr int kSize = 64;

/// A smooth gradient with values above 1, as radiance has.
formats::Image<glm::vec4> gradient() {
    formats::Image<glm::vec4> image(kSize, kSize);
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) image.at(x, y) = {4.0f + 0.05f * x, 3.0f + 0.03f * x, 2.0f + 0.02f * x + 0.01f * y, 1.0f};
    return image;
}

formats::Result<void> encodeTo(const std::string& file, formats::ImageView<const glm::vec4> texels) {
    formats::TextureShape shape;
    shape.format = formats::PixelFormat::Bc6hUf16;
    shape.width = shape.height = kSize;
    std::vector<std::byte> blocks(shape.imageBytes(0));
    compress::encodeRows(shape.format, texels, {}, {}, blocks, {});
    auto writer = formats::TextureWriter::create(file, shape, {});
    if (!writer) return tl::make_unexpected(writer.error());
    if (auto written = writer->writeBlockRows({}, 0, blocks); !written) return written;
    return writer->commit();
}

/// The largest difference relative to the original, over all channels.
double maxRelativeError(formats::ImageView<const glm::vec4> original, formats::ImageView<const glm::vec4> decoded) {
    double worst = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x)
            for (int c = 0; c < 3; ++c)
                worst = std::max(worst, std::abs(double(decoded.at(x, y)[c]) - original.at(x, y)[c]) / original.at(x, y)[c]);
    return worst;
}

int fail(const std::string& why) {
    std::fprintf(stderr, "consumer: %s\n", why.c_str());
    return 1;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return fail("usage: consumer TEXTURE.ktx2");
    const formats::Image<glm::vec4> original = gradient();
    if (auto encoded = encodeTo(argv[1], original.view()); !encoded) return fail(encoded.error().subject + ": " + encoded.error().detail);

    const auto reader = formats::TextureReader::open(argv[1]);
    if (!reader) return fail(reader.error().detail);
    const auto decoded = verify::decodeImage(*reader, {});
    if (!decoded) return fail(decoded.error().detail);
    const double error = maxRelativeError(original.view(), decoded->view());
    if (error > 0.02) return fail("BC6H of a gradient is off by " + std::to_string(error) + ", expected at most 0.02");

    // Radiance 1 from everywhere leaves a white surface with exit radiance 1.
    shaders::LcSh sh{};
    sh.c[0] = glm::vec3(std::sqrt(4 * 3.14159265f));
    if (std::abs(shaders::lcExitRadiance(sh, {0, 0, 1}).x - 1) > 1e-5f) return fail("lcExitRadiance of constant light is not 1");
    bool hasSh = false;
    for (const shaders::ShaderSource& source : shaders::allSources()) hasSh |= source.name == "sh.glsl" && !source.text.empty();
    if (!hasSh) return fail("allSources() has no sh.glsl");

    std::printf("consumer: BC6H within %.2f %% of the original\n", 100 * error);
    return 0;
}
