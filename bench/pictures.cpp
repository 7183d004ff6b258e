#include "bench/pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>

#include "compress/texel/half.h"
#include "formats/light_map.h"
#include "formats/plain_image.h"

namespace lightcook::bench {
namespace {

namespace fs = std::filesystem;

float roundedToHalf(float value) {
    return compress::floatFromHalf(compress::halfFromFloat(value));
}

/// Rounds colours and makes alpha 1; negative values become zero except in SH bands.
void roundToHalves(Picture& picture) {
    const float least = picture.kind == PictureKind::ShBand ? -65504.0f : 0.0f;
    for (glm::vec4& texel : picture.texels.texels()) {
        for (int c = 0; c < 3; ++c) texel[c] = roundedToHalf(std::max(texel[c], least));
        texel.a = 1;
    }
}

void printError(const formats::Error& error) {
    std::fprintf(stderr, "bench: %s\n", error.line().c_str());
}

/// Returns the part of an image that starts at (left, top), at most size x size texels.
template <class T>
formats::Image<T> cropped(const formats::Image<T>& image, int left, int top, int size) {
    const int width = std::min(size, image.width() - left), height = std::min(size, image.height() - top);
    formats::Image<T> part(width, height);
    for (int y = 0; y < height; ++y) std::copy_n(image.view().row(top + y) + left, width, part.view().row(y));
    return part;
}

void addImage(const fs::path& file, std::vector<Picture>& pictures) {
    formats::Result<formats::PlainImage> image = formats::readImage(file);
    if (!image) return printError(image.error());
    Picture picture{file.stem(), PictureKind::Panorama, std::move(image->texels), {}};
    picture.significance = formats::Image<float>(picture.texels.width(), picture.texels.height(), 1.0f);
    roundToHalves(picture);
    pictures.push_back(std::move(picture));
}

/// Adds coefficients 0 (band 0), 2 (band 1) and 6 (band 2) of a light map.
void addLightMap(const fs::path& file, const std::string& name, std::vector<Picture>& pictures) {
    const formats::Result<formats::LightMapReader> reader = formats::LightMapReader::open(file, {});
    if (!reader) return printError(reader.error());
    const formats::Result<formats::LightMapStrip> strip = reader->read(0, reader->height());
    if (!strip) return printError(strip.error());
    for (const std::size_t coefficient : {std::size_t{0}, std::size_t{2}, std::size_t{6}}) {
        const int width = reader->width(), height = reader->height();
        Picture picture{(coefficient == 0 ? "l0_of_" : "sh" + std::to_string(coefficient) + "_of_") + name,
                        coefficient == 0 ? PictureKind::LightMap : PictureKind::ShBand, formats::Image<glm::vec4>(width, height),
                        formats::Image<float>(width, height)};
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                picture.texels.at(x, y) = glm::vec4(strip->sh.at(x, y)[coefficient], 1.0f);
                picture.significance.at(x, y) = strip->covered.at(x, y) != 0 ? 1.0f : 0.0f;
            }
        roundToHalves(picture);
        pictures.push_back(std::move(picture));
    }
}

std::vector<fs::path> filesEndingWith(const fs::path& folder, const std::string& ending) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().filename().string().ends_with(ending)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

/// Returns a pseudo-random number in [0, 1) of a place, the same on every machine.
float hash(int x, int y, int seed) {
    std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8da6b343u ^ static_cast<std::uint32_t>(y) * 0xd8163841u ^
                      static_cast<std::uint32_t>(seed) * 0xcb1ab31fu;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return static_cast<float>((h ^ h >> 15) >> 8) * 0x1p-24f;
}

/// Returns value noise of one octave, in [0, 1): random numbers at integer places, interpolated by a smooth step.
float valueNoise(float x, float y, int seed) {
    const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
    const auto smooth = [](float t) { return t * t * (3 - 2 * t); };
    const float u = smooth(x - static_cast<float>(left)), v = smooth(y - static_cast<float>(top));
    const float above = hash(left, top, seed) * (1 - u) + hash(left + 1, top, seed) * u;
    const float below = hash(left, top + 1, seed) * (1 - u) + hash(left + 1, top + 1, seed) * u;
    return above * (1 - v) + below * v;
}

/// Returns the sum of five octaves of value noise.
float octaves(float x, float y, int seed) {
    float sum = 0;
    for (int octave = 0; octave < 5; ++octave) {
        const float frequency = std::exp2(static_cast<float>(octave)) / 24;
        sum += valueNoise(x * frequency, y * frequency, seed + octave) / std::exp2(0.8f * static_cast<float>(octave));
    }
    return sum;
}

/// Returns the light of texel (x, y) of an image of `size` x `size` texels.
using Formula = std::function<glm::vec3(float x, float y, float size)>;

glm::vec3 skyWithSun(float x, float y, float size) {
    const float up = 1 - y / size, dx = x - 0.7f * size, dy = y - 0.3f * size, d2 = dx * dx + dy * dy;
    const glm::vec3 sky = glm::vec3(0.25f, 0.45f, 0.9f) * (0.4f + up * up) + glm::vec3(0.9f, 0.6f, 0.3f) * std::exp2(-14 * up);
    const float glow = 4 / (1 + d2 / 30), disc = d2 < 5 ? 60000.0f : 0;
    return sky + glm::vec3(1, 0.85f, 0.6f) * (glow + disc);
}

glm::vec3 lampsInTheDark(float x, float y, float) {
    glm::vec3 light(0.002f, 0.002f, 0.004f);
    const int cellX = static_cast<int>(x) / 23, cellY = static_cast<int>(y) / 23;
    for (int j = cellY - 1; j <= cellY + 1; ++j)
        for (int i = cellX - 1; i <= cellX + 1; ++i) {
            const float dx = x - 23 * (static_cast<float>(i) + hash(i, j, 1)), dy = y - 23 * (static_cast<float>(j) + hash(i, j, 2));
            const float power = std::exp2(12 * hash(i, j, 3) - 2);
            light += power * glm::vec3(1, 0.4f + 0.6f * hash(i, j, 4), 0.2f + 0.8f * hash(i, j, 5)) / (1 + dx * dx + dy * dy);
        }
    return light;
}

glm::vec3 foliage(float x, float y, float) {
    const float shade = std::exp2(5 * octaves(x, y, 11) - 7), tint = octaves(x, y, 31);
    return shade * glm::vec3(0.3f + 0.5f * tint, 0.6f + 0.2f * tint, 0.15f + 0.3f * octaves(x, y, 51));
}

glm::vec3 hardEdges(float x, float y, float) {
    const int stripe = static_cast<int>(std::floor((x + 0.6f * y) / 7)), tile = static_cast<int>(x) / 13 + 5 * (static_cast<int>(y) / 11);
    const float level = stripe % 2 == 0 ? 0.08f : 2.5f;
    return level * glm::vec3(0.2f + hash(tile, stripe, 6), 0.2f + hash(tile, stripe, 7), 0.2f + hash(tile, stripe, 8));
}

glm::vec3 softLight(float x, float y, float size) {
    const float u = x / size, v = y / size;
    return {0.6f + 0.5f * std::sin(3 * u + 2 * v), 0.5f + 0.4f * std::cos(4 * v - u), 0.3f + 0.25f * std::sin(5 * u * v + 1)};
}

glm::vec3 grainyLight(float x, float y, float size) {
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const auto grain = [&](int seed) { return 1 + 0.15f * (hash(i, j, seed) + hash(i, j, seed + 10) - 1); };
    return 1.5f * softLight(y, x, size) * glm::vec3(grain(61), grain(62), grain(63));
}

}  // namespace

std::string_view nameOf(PictureKind kind) {
    switch (kind) {
        case PictureKind::Panorama:
            return "panoramas";
        case PictureKind::LightMap:
            return "light maps";
        case PictureKind::ShBand:
            return "SH bands";
        case PictureKind::Generated:
            break;
    }
    return "made by formula";
}

std::vector<Picture> sharedPictures(const fs::path& data) {
    std::vector<Picture> pictures;
    if (!fs::is_directory(data / "env") || !fs::is_directory(data / "scenes")) return pictures;
    for (const fs::path& file : filesEndingWith(data / "env", ".hdr")) addImage(file, pictures);
    const std::string ending = "_lightmap.exr";
    for (const fs::path& file : filesEndingWith(data / "scenes", ending)) {
        const std::string name = file.filename();
        addLightMap(file, name.substr(0, name.size() - ending.size()), pictures);
    }
    return pictures;
}

std::vector<Picture> ownPictures(const fs::path& sources, int size) {
    std::vector<Picture> pictures;
    addImage(sources / "examples/cornell/cornell_probe0.exr", pictures);
    addLightMap(sources / "examples/cornell/cornell_lightmap.exr", "example", pictures);
    for (Picture& picture : pictures) {
        const int left = std::max(0, (picture.texels.width() - size) / 2), top = std::max(0, (picture.texels.height() - size) / 2);
        picture.texels = cropped(picture.texels, left, top, size);
        picture.significance = cropped(picture.significance, left, top, size);
    }
    const std::pair<const char*, Formula> formulas[] = {{"sky_with_sun", skyWithSun}, {"lamps_in_the_dark", lampsInTheDark},
                                                        {"foliage", foliage},         {"hard_edges", hardEdges},
                                                        {"soft_light", softLight},    {"grainy_light", grainyLight}};
    for (const auto& [name, formula] : formulas) {
        Picture picture{name, PictureKind::Generated, formats::Image<glm::vec4>(size, size), formats::Image<float>(size, size, 1.0f)};
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                picture.texels.at(x, y) = glm::vec4(formula(static_cast<float>(x), static_cast<float>(y), static_cast<float>(size)), 1.0f);
        roundToHalves(picture);
        pictures.push_back(std::move(picture));
    }
    return pictures;
}

bool suits(const Picture& picture, formats::PixelFormat format) {
    return picture.kind != PictureKind::ShBand || formats::info(format).isSigned;
}

formats::Image<glm::vec4> texelsFor(const Picture& picture, formats::PixelFormat format) {
    formats::Image<glm::vec4> texels = picture.texels.copy();
    if (formats::info(format).isFloat) return texels;
    for (glm::vec4& texel : texels.texels()) {
        // SH bands, which only signed formats encode, keep their sign.
        for (int c = 0; c < 3; ++c) texel[c] = std::copysign(std::pow(std::abs(texel[c]) / (1 + std::abs(texel[c])), 1 / 2.2f), texel[c]);
        texel.a = 1 - (texel.r + 2 * texel.g + texel.b) / 4;
    }
    return texels;
}

}  // namespace lightcook::bench
