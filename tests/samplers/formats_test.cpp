// Every format that the device supports: its decoder and filter against the verifier's texture unit.
#include <gmock/gmock.h>

#include "compress/encode.h"
#include "formats/gpu_texture.h"
#include "tests/formats/temporary_folder.h"
#include "tests/samplers/second_opinion.h"
#include "verify/texture_unit.h"

namespace lightcook::samplers {
namespace {

using formats::PixelFormat;
using glm::vec4;
using Image = formats::Image<vec4>;

/// Content of a test image: texels within the format's range, with edges and ramps; or random bytes as blocks, which cover every mode.
enum class Content { Picture, AnyBlocks };
struct FormatCase {
    PixelFormat format;
    Content content;
};

/// Formats whose texels a GPU may keep in 8 bits.
bool isEightBit(PixelFormat format) {
    switch (format) {
        case PixelFormat::Bc1:
        case PixelFormat::Bc3:
        case PixelFormat::Bc4:
        case PixelFormat::Bc4Snorm:
        case PixelFormat::Bc5:
        case PixelFormat::Bc5Snorm:
        case PixelFormat::Bc7:
        case PixelFormat::Astc4x4Ldr:
        case PixelFormat::Rgba8Unorm:
        case PixelFormat::Rgba8Srgb:
            return true;
        default:
            return false;
    }
}
/// Returns the tolerance of a decoded texel. For BC1 to BC5, Direct3D 11.3 (functional specification, 19.5.2) allows 1/255 and 0.03 of the
/// difference of the endpoints (tests/verify/texture/sampler_tolerance_test.cpp has GPUs that use it). These devices need only two codes:
/// they interpolate between 8-bit endpoints (half a code) and truncate (one). ASTC keeps the upper 8 bits of 16, sRGB is exact to half a
/// step. BC6H, BC7 and floats are exact; a unorm is a division.
double decodeSlack(PixelFormat format) {
    switch (format) {
        case PixelFormat::Bc1:
        case PixelFormat::Bc3:
        case PixelFormat::Bc4:
        case PixelFormat::Bc5:
            return 2.0 / 255;
        case PixelFormat::Bc4Snorm:
        case PixelFormat::Bc5Snorm:
            return 2.0 / 127;
        case PixelFormat::Rgba8Srgb:
            return 0.5 / 255;
        case PixelFormat::Astc4x4Ldr:
            return 1.0 / 255;
        default:
            return formats::info(format).isFloat ? 0 : 1e-7;
    }
}

class FormatOpinions : public Samplers {
protected:
    /// Returns false if the device does not support the format.
    bool expectAsOurs(const FormatCase& format);

private:
    static constexpr int kWidth = 40, kHeight = 28, kLayers = 2;

    std::vector<std::byte> blocksOf(const FormatCase& asked, int layer) {
        const PixelFormat format = asked.format;
        std::vector<std::byte> blocks(formats::bytesPerImage(format, kWidth, kHeight));
        if (asked.content == Content::Picture) {
            const formats::PixelFormatInfo& info = formats::info(format);
            Image picture(kWidth, kHeight);
            for (int y = 0; y < kHeight; ++y)
                for (int x = 0; x < kWidth; ++x) {
                    vec4 texel(x / 40.0f, y / 28.0f, ((x / 7 + y / 5 + layer) % 2) * 0.8f + 0.1f, uniform(0.2, 1));
                    if (info.isFloat) texel *= std::exp2(uniform(-3, 3));
                    if (info.isSigned) texel = 2.0f * texel - 1.0f;
                    picture.at(x, y) = texel;
                }
            compress::EncodeOptions options;
            options.effort = 5;
            compress::encodeRows(format, picture.view(), {}, options, blocks, {});
        } else {
            for (std::byte& byte : blocks) byte = static_cast<std::byte>(random_());
            avoidReserved(format, blocks);
        }
        return blocks;
    }
    /// Reserved modes are undefined in OpenGL. Our decoders follow Direct3D (tests/verify/texture/decode_bc_test.cpp).
    static void avoidReserved(PixelFormat format, std::vector<std::byte>& blocks) {
        const auto low = [&](std::size_t at) { return std::to_integer<unsigned>(blocks[at]) & 0x1f; };
        for (std::size_t at = 0; at + 16 <= blocks.size(); at += 16) {
            const bool isBc6h = format == PixelFormat::Bc6hUf16 || format == PixelFormat::Bc6hSf16;
            if (isBc6h && (low(at) == 0x13 || low(at) == 0x17 || low(at) == 0x1b || low(at) == 0x1f)) blocks[at] &= std::byte{0xfe};
            if (format == PixelFormat::Bc7 && blocks[at] == std::byte{0}) blocks[at] = std::byte{0x40};
        }
    }
    std::vector<Image> uploadAndDecode(const FormatCase& asked, bool& isTaken) {
        formats::TextureShape shape;
        shape.format = asked.format;
        shape.width = kWidth;
        shape.height = kHeight;
        shape.layerCount = kLayers;
        shape.isArray = true;
        const formats::TemporaryFolder folder;
        auto writer = valueOf(formats::TextureWriter::create(folder / "texture.ktx2", shape, {}));
        for (int layer = 0; layer < kLayers; ++layer)
            if (auto written = writer.writeBlockRows({0, layer, 0}, 0, blocksOf(asked, layer)); !written)
                ADD_FAILURE() << written.error().line();
        if (auto written = writer.commit(); !written) ADD_FAILURE() << written.error().line();
        isTaken = gl_->upload(0, readKtx2(folder / "texture.ktx2"));
        const auto reader = valueOf(formats::TextureReader::open(folder / "texture.ktx2"));
        std::vector<Image> layers;
        for (int layer = 0; layer < kLayers; ++layer) layers.push_back(valueOf(verify::decodeImage(reader, {0, layer, 0})));
        return layers;
    }
};

bool FormatOpinions::expectAsOurs(const FormatCase& asked) {
    bool isTaken = false;
    const std::vector<Image> layers = uploadAndDecode(asked, isTaken);
    const std::string name(formats::info(asked.format).name);
    if (!isTaken) return false;
    const int channelCount = std::clamp(formats::info(asked.format).channelCount, 1, 4);

    std::vector<vec4> places;
    for (int layer = 0; layer < kLayers; ++layer)
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) places.emplace_back((x + 0.5f) / kWidth, (y + 0.5f) / kHeight, layer, 0);
    const std::size_t centres = places.size();
    for (int i = 0; i < 4000; ++i) places.emplace_back(uniform(-0.05, 1.05), uniform(-0.05, 1.05), i % kLayers, 1);
    const std::string sampler = "layout(binding = 0) uniform sampler2DArray layers;\n";
    const auto fetched =
        gl_->run(sampler, "result = texelFetch(layers, ivec3(place.xy * vec2(textureSize(layers, 0).xy), int(place.z)), 0);",
                 std::span(places).first(centres));
    const auto sampled = gl_->run(sampler, "result = textureLod(layers, place.xyz, 0.0);", places);

    Agreement decode, filter;
    const double slack = decodeSlack(asked.format);
    const double rounding = isEightBit(asked.format) ? 2.0 / (name.ends_with("snorm") ? 127 : 255) : 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const Image& image = layers[static_cast<std::size_t>(places[i].z)];
        const auto sample = [&](const glm::dvec2& uv) { return verify::sampleBilinear(image.view(), uv); };
        const glm::dvec2 uv(places[i]);
        const vec4 ours = sample(uv), allowed = filterSlack(sample, uv, {1.0 / kWidth, 1.0 / kHeight});
        for (int channel = 0; channel < channelCount; ++channel) {
            const std::string where =
                fmt::format("{} at ({}, {}), layer {}, channel {}", name, uv.x * kWidth, uv.y * kHeight, places[i].z, channel);
            if (i < centres) {
                const vec4 texel = image.at(static_cast<int>(i) % kWidth, static_cast<int>(i) / kWidth % kHeight);
                decode.add(texel[channel], fetched[i][channel], slack, where);
            }
            filter.add(ours[channel], sampled[i][channel],
                       static_cast<double>(allowed[channel]) + slack + rounding + 1e-6 * static_cast<double>(std::abs(ours[channel])),
                       where);
        }
    }
    std::printf("figures %-14s %-9s decode %.3g (allowed %.3g)  filter %.3g, %.2f of what is allowed\n", name.c_str(),
                asked.content == Content::Picture ? "picture" : "any bytes", decode.difference, slack, filter.difference, filter.part);
    EXPECT_LE(decode.difference, slack) << decode.worst;
    EXPECT_LE(filter.part, 1) << filter.worst;
    return true;
}

/// Returns the cases of CI: any blocks where a format has some, else a picture.
std::vector<FormatCase> formatCases() {
    std::vector<FormatCase> cases;
    for (const formats::PixelFormatInfo& info : formats::allPixelFormats()) {
        const bool hasBlocks = info.blockWidth > 1 && (!info.name.starts_with("astc") || !info.isFloat);
        cases.push_back({info.format, hasBlocks ? Content::AnyBlocks : Content::Picture});
    }
    return cases;
}
/// Returns pictures of the formats of which CI has any blocks.
std::vector<FormatCase> otherCases() {
    std::vector<FormatCase> cases;
    for (const FormatCase& each : formatCases())
        if (each.content == Content::AnyBlocks) cases.push_back({each.format, Content::Picture});
    return cases;
}

class FormatsOfADevice : public FormatOpinions, public testing::WithParamInterface<FormatCase> {};
TEST_P(FormatsOfADevice, DecodeAndFilterAsOurs) {
    if (!expectAsOurs(GetParam())) GTEST_SKIP() << formats::info(GetParam().format).name << " is not supported by " << gl_->name();
}

/// One test, because starting a browser is slow. SwiftShader supports all of our formats except ASTC and 16-bit unorms.
using FormatsOfABrowserSoak = InABrowser<FormatOpinions>;
TEST_F(FormatsOfABrowserSoak, DecodeAndFilterAsOurs) {
    int taken = 0;
    for (const auto& cases : {formatCases(), otherCases()})
        for (const FormatCase& asked : cases) taken += expectAsOurs(asked) ? 1 : 0;
    std::printf("figures %s knows %d of %zu\n", gl_->name().c_str(), taken, formatCases().size() + otherCases().size());
    EXPECT_GE(taken, 20);
}

const auto nameOfFormatCase = [](const auto& each) {
    std::string name(formats::info(each.param.format).name);
    std::ranges::replace(name, '-', '_');
    return name + (each.param.content == Content::Picture ? "_picture" : "_any_blocks");
};
INSTANTIATE_TEST_SUITE_P(Every, FormatsOfADevice, testing::ValuesIn(formatCases()), nameOfFormatCase);
INSTANTIATE_TEST_SUITE_P(Soak, FormatsOfADevice, testing::ValuesIn(otherCases()), nameOfFormatCase);

}  // namespace
}  // namespace lightcook::samplers
