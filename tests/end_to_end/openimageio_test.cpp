// A second opinion on the DDS files of a cook: OpenImageIO reads every texture, and each texel is held against verify's decoder of the same
// bytes. OpenImageIO 2.4 cannot read some of the files directly; the test lists and converts them:
//   - of an array it sees the first slice, and of a cubemap's smaller mips the wrong extent: every image is cut out, by offsets that are
//     reckoned here and not by formats/, and read as a plain texture of its own. Arrays of BC3 need the cutting too (a DX10 header, of
//     which it takes BC4 to BC7 only);
//   - 16-bit and 8-bit unorms and halves have a DX10 header in our files, which it refuses: their bytes are read as luminance of 8 bits,
//   put
//     together, and converted by its own convert_pixel_values.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/cook/cook.h"
#include "pipeline/manifest/manifest.h"
#include "tests/formats/temporary_folder.h"
#include "tests/soak/soak.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::PixelFormat;
using Bytes = std::span<const std::byte>;

template <class T>
T valueOf(formats::Result<T> result) {
    if (!result) throw std::runtime_error(result.error().line());
    return std::move(*result);
}

/// The image that OpenImageIO reads: rows of texels.
struct Seen {
    int width = 0, height = 0, channelCount = 0;
    std::vector<float> values;
    float at(int x, int y, int channel) const {
        return values[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
                          static_cast<std::size_t>(channelCount) +
                      static_cast<std::size_t>(channel)];
    }
};

std::optional<Seen> seenIn(const std::filesystem::path& file, std::string& whyNot) {
    const auto input = OIIO::ImageInput::open(file.string());
    if (!input) {
        whyNot = OIIO::geterror();
        return {};
    }
    const OIIO::ImageSpec& spec = input->spec();
    Seen seen{spec.width, spec.height, spec.nchannels, {}};
    seen.values.resize(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
                       static_cast<std::size_t>(spec.nchannels));
    if (input->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, seen.values.data())) return seen;
    whyNot = input->geterror();
    return {};
}

/// A DDS header for one plain image. fourCc 0: luminance of 8 bits.
std::vector<std::byte> headerOf(int width, int height, std::string_view fourCc, std::uint32_t dxgi, std::size_t bytes) {
    std::vector<std::uint32_t> words(32, 0);
    const auto characters = [](std::string_view text) {
        std::uint32_t word = 0;
        for (std::size_t i = 4; i-- > 0;) word = word << 8 | static_cast<unsigned char>(text[i]);
        return word;
    };
    const bool isBlocks = !fourCc.empty();
    words[0] = characters("DDS ");
    words[1] = 124;
    words[2] = 0x1007 | (isBlocks ? 0x80000u : 0x8u);
    words[3] = static_cast<std::uint32_t>(height);
    words[4] = static_cast<std::uint32_t>(width);
    words[5] = static_cast<std::uint32_t>(isBlocks ? bytes : static_cast<std::size_t>(width));
    words[19] = 32;
    words[20] = isBlocks ? 0x4 : 0x20000;
    if (isBlocks) words[21] = characters(fourCc);
    if (!isBlocks) words[22] = 8, words[23] = 0xff;
    words[27] = 0x1000;
    if (fourCc == "DX10") words.insert(words.end(), {dxgi, 3, 0, 1, 0});
    std::vector<std::byte> header(4 * words.size());
    for (std::size_t i = 0; i < header.size(); ++i) header[i] = static_cast<std::byte>(words[i / 4] >> (8 * (i % 4)));
    return header;
}

/// Returns the allowed difference between OpenImageIO's value of a channel and ours: 0 for formats with exact decodes, one code of 8 bits
/// where ours is exact and theirs rounds, and the rounding of a division in single precision.
double allowedOf(PixelFormat format) {
    switch (format) {
        case PixelFormat::Bc1:
        case PixelFormat::Bc3:
        case PixelFormat::Bc4:
        case PixelFormat::Bc5:
            return 1.0 / 255;
        case PixelFormat::Bc6hUf16:
        case PixelFormat::Bc6hSf16:
        case PixelFormat::Rgba16f:
            return 0;
        default:
            return 1e-7;
    }
}

class DdsThroughOpenImageIO : public testing::Test {
protected:
    struct Count {
        int textures = 0, whole = 0, images = 0;
        std::int64_t texels = 0;
        std::map<std::string, int> notWhole;  ///< why, and how often
    };

    Json cook(const std::filesystem::path& scene, const std::string& layout, std::optional<std::string> onlyKind) {
        CookOptions options;
        options.scene = scene;
        options.output = out();
        options.cache = folder_ / "cache";
        options.given.set("output.container", "dds");
        options.given.set("output.light_map_layout", layout);
        options.given.set("output.mips", true);
        options.onlyKind = std::move(onlyKind);
        options.given.set("output.max_error", 1.0);  // no limit, so that small layouts pass too
        options.given.set("output.effort", 3);
        options.samples = 0;  // their errors are not looked at
        std::filesystem::remove_all(out());
        const RunState state;
        for (const formats::Error& error : cookScene(options, state).errors) ADD_FAILURE() << error.line();
        return valueOf(readManifest(out())).at("assets");
    }
    void expectEveryTextureAsOurs(const Json& assets) {
        for (const Json& asset : assets)
            for (const Json& texture : asset.at("textures")) {
                const std::string file = texture.at("file");
                SCOPED_TRACE(file);
                ++count_.textures;
                expectTextureAsOurs(file);
            }
    }
    void print(const std::string& what) const {
        std::printf("figures %s: %d textures, %d read whole, %d images cut out, %.3g million texels compared\n", what.c_str(),
                    count_.textures, count_.whole, count_.images, static_cast<double>(count_.texels) * 1e-6);
        for (const auto& [why, times] : count_.notWhole) std::printf("figures   not read whole, %d x: %s\n", times, why.c_str());
        for (const auto& [format, worst] : worst_)
            std::printf("figures   %-12s largest difference %.3g, allowed %.3g\n", std::string(formats::info(format).name).c_str(), worst,
                        allowedOf(format));
        test::countInSoak(count_.textures, "textures read by OpenImageIO");
    }
    std::filesystem::path out() const { return folder_ / "out"; }

    Count count_;
    formats::TemporaryFolder folder_;

private:
    void expectTextureAsOurs(const std::string& file) {
        const auto reader = valueOf(formats::TextureReader::open(out() / file));
        const formats::TextureShape& shape = reader.shape();
        const std::string bytes = formats::contentOf(out() / file);
        const Bytes content = std::as_bytes(std::span(bytes));
        const std::string_view format = formats::info(shape.format).name;
        std::string whyNot;
        const auto whole = seenIn(out() / file, whyNot);
        if (!whole) {
            ++count_.notWhole[fmt::format("{}{}: refused: {}", format, shape.isArray ? " array" : "", whyNot)];
        } else if (shape.isArray) {
            ++count_.notWhole[fmt::format("{} array: the first slice only", format)];
        } else {
            ++count_.whole;
            if (shape.mipCount > 1) ++count_.notWhole[fmt::format("{} cubemap: the first mip only", format)];
        }
        // Slices and faces follow each other with all of their mips.
        std::size_t at = bytes.compare(84, 4, "DX10") == 0 ? 148 : 128;
        for (int layer = 0; layer < shape.layerCount; ++layer)
            for (int face = 0; face < shape.faceCount; ++face)
                for (int mip = 0; mip < shape.mipCount; ++mip) {
                    const auto ours = valueOf(verify::decodeImage(reader, {mip, layer, face}));
                    const std::size_t size = bytesOf(shape, ours.width(), ours.height());
                    ASSERT_LE(at + size, content.size());
                    expectAsOurs(shape.format, ours, cutOut(shape.format, ours.width(), ours.height(), content.subspan(at, size)), 0,
                                 fmt::format("mip {}, layer {}, face {}", mip, layer, face));
                    ++count_.images;
                    at += size;
                    if (whole && mip == 0 && layer == 0)
                        expectAsOurs(shape.format, ours, *whole, face * ours.height(), fmt::format("face {} of the whole file", face));
                }
        EXPECT_EQ(at, content.size());
    }
    static std::size_t bytesOf(const formats::TextureShape& shape, int width, int height) {
        const formats::PixelFormatInfo& info = formats::info(shape.format);
        const auto blocks = [](int texels, int block) { return static_cast<std::size_t>((texels + block - 1) / block); };
        return blocks(width, info.blockWidth) * blocks(height, info.blockHeight) * static_cast<std::size_t>(info.bytesPerBlock);
    }
    /// One image as a plain texture.
    Seen cutOut(PixelFormat format, int width, int height, Bytes bytes) const {
        const formats::PixelFormatInfo& info = formats::info(format);
        const std::filesystem::path file = folder_ / "cut.dds";
        std::string whyNot;
        if (info.blockWidth > 1) {
            const int w = (width + 3) / 4 * 4, h = (height + 3) / 4 * 4;
            const std::string_view code = format == PixelFormat::Bc1 ? "DXT1" : format == PixelFormat::Bc3 ? "DXT5" : "DX10";
            write(file, headerOf(w, h, code, info.dxgiFormat, bytes.size()), bytes);
        } else {
            write(file, headerOf(width * info.bytesPerBlock, height, {}, 0, bytes.size()), bytes);
        }
        auto seen = seenIn(file, whyNot);
        EXPECT_TRUE(seen) << whyNot;
        return !seen ? Seen{} : info.blockWidth > 1 ? std::move(*seen) : assembled(format, width, height, *seen);
    }
    /// Luminance of 8 bits, put together again.
    static Seen assembled(PixelFormat format, int width, int height, const Seen& luminance) {
        std::vector<unsigned char> bytes(luminance.values.size());
        std::ranges::transform(luminance.values, bytes.begin(),
                               [](float value) { return static_cast<unsigned char>(std::lround(255 * value)); });
        const formats::PixelFormatInfo& info = formats::info(format);
        const OIIO::TypeDesc type = info.isFloat                                  ? OIIO::TypeDesc::HALF
                                    : info.bytesPerBlock == info.channelCount     ? OIIO::TypeDesc::UINT8
                                    : info.bytesPerBlock == 2 * info.channelCount ? OIIO::TypeDesc::UINT16
                                                                                  : OIIO::TypeDesc::UNKNOWN;
        Seen seen{width, height, info.channelCount, std::vector<float>(bytes.size() / type.size())};
        EXPECT_TRUE(
            OIIO::convert_pixel_values(type, bytes.data(), OIIO::TypeDesc::FLOAT, seen.values.data(), static_cast<int>(seen.values.size())))
            << info.name;
        return seen;
    }
    static void write(const std::filesystem::path& file, std::vector<std::byte> header, Bytes bytes) {
        header.insert(header.end(), bytes.begin(), bytes.end());
        formats::writeContent(file, std::string(reinterpret_cast<const char*>(header.data()), header.size()));
    }
    void expectAsOurs(PixelFormat format, const formats::Image<glm::vec4>& ours, const Seen& seen, int firstRow, const std::string& where) {
        const int channelCount = std::min(seen.channelCount, formats::info(format).channelCount);
        ASSERT_GE(channelCount, 1) << where;
        ASSERT_GE(seen.width, ours.width()) << where;
        ASSERT_GE(seen.height, firstRow + ours.height()) << where;
        const double allowed = allowedOf(format);
        double& worst = worst_[format];
        for (int y = 0; y < ours.height(); ++y)
            for (int x = 0; x < ours.width(); ++x)
                for (int channel = 0; channel < channelCount; ++channel) {
                    const float a = ours.at(x, y)[channel], b = seen.at(x, firstRow + y, channel);
                    const double difference = std::abs(static_cast<double>(a) - static_cast<double>(b));
                    worst = std::max(worst, difference);
                    // Not "greater than": not a number must not pass.
                    if (!(difference <= allowed)) {
                        ADD_FAILURE() << fmt::format("{}, texel ({}, {}), channel {}: ours {}, OpenImageIO's {}, allowed {}", where, x, y,
                                                     channel, a, b, allowed);
                        return;
                    }
                }
        count_.texels += static_cast<std::int64_t>(ours.width()) * ours.height();
    }

    std::map<PixelFormat, double> worst_;
};

/// Every kind of asset, and BC3's arrays.
TEST_F(DdsThroughOpenImageIO, EveryTextureOfTheSceneThatShipsDecodesAsOurs) {
    const std::filesystem::path scene = std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "examples/cornell/scene.toml";
    expectEveryTextureAsOurs(cook(scene, "basis-8", {}));
    expectEveryTextureAsOurs(cook(scene, "halo3", "light-map"));
    print("the scene that ships");
    EXPECT_GE(count_.whole, 4);
    EXPECT_GT(count_.images, count_.textures);
}

class DdsThroughOpenImageIOSoak : public DdsThroughOpenImageIO, public testing::WithParamInterface<const char*> {};

TEST_P(DdsThroughOpenImageIOSoak, EveryTextureOfAPublicSceneDecodesAsOurs) {
    const std::string name = GetParam();
    const std::filesystem::path data = std::filesystem::absolute(LIGHTCOOK_SHARED_DATA), scenes = data / "scenes";
    if (!std::filesystem::exists(scenes / (name + "_lightmap.exr"))) GTEST_SKIP() << "no shared data at " << scenes;
    std::string text = fmt::format(
        "schema = 1\nname = \"{1}\"\n[output]\nmax_converter_error = 1.0\n[[light_map]]\nname = \"lightmap\"\nfile = "
        "\"{0}/{1}_lightmap.exr\"\n",
        scenes.string(), name);
    for (int probe = 0; probe < 8; ++probe)
        text += fmt::format("[[probe]]\nname = \"probe{2}\"\nfile = \"{0}/{1}_probe{2}.exr\"\n", scenes.string(), name, probe);
    for (const char* sky : {"clear_sky", "overcast_cie", "sun_glow"})
        text += fmt::format("[[gradient]]\nname = \"{1}\"\nfile = \"{0}/gradients/{1}_256x1.exr\"\nexponents = [1, 16, 1024]\n",
                            data.string(), sky);
    formats::writeContent(folder_ / "scene.toml",
                          text + "[[material]]\nname = \"*\"\nnormal_map = true\nspecular = true\nm = [0.1, 0.5]\n");
    expectEveryTextureAsOurs(cook(folder_ / "scene.toml", "basis-16", {}));
    for (const char* layout : {"basis-3", "basis-4", "ratio", "halo3", "hdr-2", "raw"})
        expectEveryTextureAsOurs(cook(folder_ / "scene.toml", layout, "light-map"));
    print(name);
}
INSTANTIATE_TEST_SUITE_P(Public, DdsThroughOpenImageIOSoak, testing::Values("cornell", "interior", "outdoor", "zdm2_sun"),
                         [](const auto& each) { return std::string(each.param); });

}  // namespace
}  // namespace lightcook::pipeline
