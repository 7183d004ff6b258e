// Synthetic images for the tests of the encoders, and error measures.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/vec4.hpp>
#include <string>
#include <vector>

#include "compress/encode.h"

namespace lightcook::compress::test {

using TexelImage = formats::Image<glm::vec4>;

/// A random number generator with the same numbers on every platform (xorshift64*).
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ull + 1) {}
    std::uint32_t bits() {
        state_ ^= state_ >> 12;
        state_ ^= state_ << 25;
        state_ ^= state_ >> 27;
        return static_cast<std::uint32_t>((state_ * 0x2545F4914F6CDD1Dull) >> 32);
    }
    float unit() { return static_cast<float>(bits() >> 8) * 0x1p-24f; }
    int below(int limit) { return static_cast<int>(bits() % static_cast<std::uint32_t>(limit)); }

private:
    std::uint64_t state_;
};

inline TexelImage imageOf(int width, int height, const std::function<glm::vec4(int, int)>& texel) {
    TexelImage image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) image.at(x, y) = texel(x, y);
    return image;
}

struct NamedImage {
    std::string name;
    TexelImage image;
};

/// Returns images of 64 x 64 values in [0, 1].
inline std::vector<NamedImage> unitImages() {
    std::vector<NamedImage> images;
    const auto add = [&](const char* name, const std::function<glm::vec4(int, int)>& texel) {
        images.push_back({name, imageOf(64, 64, texel)});
    };
    add("gradient", [](int x, int y) {
        const float u = static_cast<float>(x) / 63, v = static_cast<float>(y) / 63;
        return glm::vec4(u, v, (u + v) / 2, 1 - u * v);
    });
    add("waves", [](int x, int y) {
        const auto wave = [&](float a, float b) { return 0.5f + 0.4f * std::sin(a * static_cast<float>(x) + b * static_cast<float>(y)); };
        return glm::vec4(wave(0.21f, 0.1f), wave(-0.05f, 0.3f), wave(0.4f, 0.4f), wave(0.1f, -0.2f));
    });
    Random random(11);
    add("noise", [&](int, int) { return glm::vec4(random.unit(), random.unit(), random.unit(), random.unit()); });
    add("saturated", [](int x, int y) { return glm::vec4((x / 3) & 1, (y / 5) & 1, ((x + y) / 7) & 1, 1); });
    return images;
}

/// Returns images of 64 x 64 values of light.
inline std::vector<NamedImage> lightImages() {
    std::vector<NamedImage> images;
    const auto add = [&](const char* name, const std::function<glm::vec4(int, int)>& texel) {
        images.push_back({name, imageOf(64, 64, texel)});
    };
    add("gradient", [](int x, int y) {
        const float u = static_cast<float>(x) / 63, v = static_cast<float>(y) / 63;
        return glm::vec4(std::exp2(8 * u - 4), std::exp2(6 * v - 3), u + v, 1);
    });
    Random random(12);
    add("noise", [&](int, int) { return glm::vec4(random.unit() * 4, random.unit() * 4, random.unit() * 4, 1); });
    add("spikes", [](int x, int y) {
        const bool spike = (x * 7 + y * 13) % 29 == 0;
        return spike ? glm::vec4(65504, 65504, 65504, 1) : glm::vec4(0, 0, 0, 1);
    });
    add("saturated", [](int x, int y) { return glm::vec4(((x / 5) & 1) * 10.0f, ((y / 3) & 1) * 0.1f, (((x + y) / 6) & 1) * 100.0f, 1); });
    add("denormals", [](int x, int y) {
        return glm::vec4(static_cast<float>(x) * 0x1p-24f, static_cast<float>(y) * 0x1p-24f, static_cast<float>(x + y) * 0x1p-25f, 1);
    });
    return images;
}

struct Encoded {
    std::vector<std::byte> bytes;
    TexelImage decoded;
    EncodeReport report;
};

inline Encoded encode(formats::PixelFormat format, const TexelImage& image, const EncodeOptions& options = {},
                      formats::ImageView<const float> significance = {}) {
    Encoded result;
    result.bytes.resize(formats::bytesPerImage(format, image.width(), image.height()));
    result.decoded = TexelImage(image.width(), image.height());
    result.report = encodeRows(format, image.view(), significance, options, result.bytes, result.decoded.view());
    return result;
}

inline EncodeOptions effort(int level) {
    EncodeOptions options;
    options.effort = level;
    return options;
}

/// Returns the RMS difference over the first channelCount channels.
inline double rmsError(const TexelImage& a, const TexelImage& b, int channelCount) {
    double sum = 0;
    for (std::size_t i = 0; i < a.texels().size(); ++i)
        for (int c = 0; c < channelCount; ++c)
            sum += std::pow(static_cast<double>(a.texels()[i][c]) - static_cast<double>(b.texels()[i][c]), 2);
    return std::sqrt(sum / static_cast<double>(a.texels().size()) / channelCount);
}

/// Returns the RMS difference of log2(1 + x).
inline double logRmsError(const TexelImage& a, const TexelImage& b, int channelCount) {
    double sum = 0;
    const auto metric = [](float x) { return std::copysign(std::log2(1 + std::abs(static_cast<double>(x))), static_cast<double>(x)); };
    for (std::size_t i = 0; i < a.texels().size(); ++i)
        for (int c = 0; c < channelCount; ++c) sum += std::pow(metric(a.texels()[i][c]) - metric(b.texels()[i][c]), 2);
    return std::sqrt(sum / static_cast<double>(a.texels().size()) / channelCount);
}

}  // namespace lightcook::compress::test
