#include "bench/class_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <glm/geometric.hpp>
#include <stdexcept>
#include <utility>

#include "bench/or_throw.h"
#include "bench/pictures.h"
#include "compress/texel/half.h"
#include "formats/light_map.h"
#include "formats/plain_image.h"

namespace lightcook::bench {
namespace {

namespace fs = std::filesystem;
using formats::Image;

constexpr PictureClassInfo kClasses[] = {
    {"photographs", PictureClass::Photographs, PictureContent::Colour}, {"panoramas", PictureClass::Panoramas, PictureContent::Light},
    {"light maps", PictureClass::LightMaps, PictureContent::Light},     {"SH ratios", PictureClass::ShRatios, PictureContent::Vectors},
    {"normals", PictureClass::Normals, PictureContent::Vectors},        {"directions", PictureClass::Directions, PictureContent::Vectors}};

/// Sets texels without significance to the nearest significant one, by breadth-first search over the four neighbours.
void fillUncovered(ClassPicture& picture) {
    const int width = picture.texels.width(), height = picture.texels.height();
    Image<std::uint8_t> isFilled(width, height);
    std::deque<std::pair<int, int>> border;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (picture.significance.at(x, y) > 0) {
                isFilled.at(x, y) = 1;
                border.emplace_back(x, y);
            }
    for (; !border.empty(); border.pop_front()) {
        const auto [x, y] = border.front();
        for (const auto& [nextX, nextY] : {std::pair(x - 1, y), std::pair(x + 1, y), std::pair(x, y - 1), std::pair(x, y + 1)}) {
            if (nextX < 0 || nextY < 0 || nextX >= width || nextY >= height || isFilled.at(nextX, nextY) != 0) continue;
            isFilled.at(nextX, nextY) = 1;
            picture.texels.at(nextX, nextY) = picture.texels.at(x, y);
            border.emplace_back(nextX, nextY);
        }
    }
}

/// Reduces a picture to side x side texels: evenly spread tiles of kPictureTile. Tiles of smaller pictures overlap.
ClassPicture tiled(const ClassPicture& whole, int side) {
    const int across = side / kPictureTile;
    ClassPicture part{whole.name, whole.pictureClass, Image<glm::vec4>(side, side), Image<float>(side, side)};
    const auto firstOf = [across](int tile, int extent) {
        const int room = std::max(0, extent - kPictureTile);
        return across == 1 ? room / 2 : static_cast<int>(static_cast<std::int64_t>(room) * tile / (across - 1));
    };
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const int fromX = firstOf(x / kPictureTile, whole.texels.width()) + x % kPictureTile;
            const int fromY = firstOf(y / kPictureTile, whole.texels.height()) + y % kPictureTile;
            const int insideX = std::min(fromX, whole.texels.width() - 1), insideY = std::min(fromY, whole.texels.height() - 1);
            part.texels.at(x, y) = whole.texels.at(insideX, insideY);
            part.significance.at(x, y) = whole.significance.at(insideX, insideY);
        }
    return part;
}

/// Adds a picture, reduced to side x side texels, unless none of them is significant.
void add(ClassPicture whole, int side, std::vector<ClassPicture>& pictures) {
    const auto counts = [](float significance) { return significance > 0; };
    fillUncovered(whole);
    ClassPicture part = tiled(whole, side);
    if (std::any_of(part.significance.texels().begin(), part.significance.texels().end(), counts)) pictures.push_back(std::move(part));
}

ClassPicture copyOf(const Picture& picture, PictureClass pictureClass) {
    return {picture.name, pictureClass, picture.texels.copy(), picture.significance.copy()};
}

/// Tone-maps light into a photograph.
ClassPicture photographOf(const Picture& picture) {
    ClassPicture photograph = copyOf(picture, PictureClass::Photographs);
    for (glm::vec4& texel : photograph.texels.texels())
        for (int c = 0; c < 3; ++c) texel[c] = std::pow(texel[c] / (1 + texel[c]), 1 / 2.2f);
    return photograph;
}

/// Adds three pictures of a light map: the ratio of coefficient 2 to coefficient 0, the direction of band 1, and the normals.
void addVectors(const fs::path& file, const std::string& name, int side, std::vector<ClassPicture>& pictures) {
    const formats::Result<formats::LightMapReader> reader = formats::LightMapReader::open(file, {});
    const auto strip = reader ? reader->read(0, reader->height()) : tl::make_unexpected(reader.error());
    if (!strip) {
        std::fprintf(stderr, "bench: %s\n", strip.error().line().c_str());
        return;
    }
    const int width = reader->width(), height = reader->height();
    const auto make = [&](const std::string& what, PictureClass pictureClass, const auto& valueAt) {
        ClassPicture picture{what + "_of_" + name, pictureClass, Image<glm::vec4>(width, height), Image<float>(width, height)};
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                if (strip->covered.at(x, y) == 0) continue;
                picture.texels.at(x, y) = glm::vec4(valueAt(x, y), 1.0f);
                picture.significance.at(x, y) = 1;
            }
        add(std::move(picture), side, pictures);
    };
    // |L1m / L0| is at most sqrt(3) for light that is nowhere negative.
    make("ratio", PictureClass::ShRatios, [&](int x, int y) {
        const auto& sh = strip->sh.at(x, y);
        return glm::clamp(sh[2] / glm::max(sh[0] * std::sqrt(3.0f), glm::vec3(1e-6f)), -1.0f, 1.0f);
    });
    make("direction", PictureClass::Directions, [&](int x, int y) {
        const auto& sh = strip->sh.at(x, y);
        const auto sum = [&sh](std::size_t k) { return sh[k].r + sh[k].g + sh[k].b; };
        const glm::vec3 direction(sum(3), sum(1), sum(2));
        const float length = glm::length(direction);
        return length > 1e-6f ? direction / length : glm::vec3(0, 0, 1);
    });
    if (reader->hasNormals()) make("normal", PictureClass::Normals, [&](int x, int y) { return strip->normal.at(x, y); });
}

/// Adds pictures of vectors by formula: normals of two bumpy surfaces, directions to a light source above the surface, and the ratio of its
/// coefficient 2 to coefficient 0 beside light of the sky.
void addVectorFormulas(int side, std::vector<ClassPicture>& pictures) {
    const auto make = [&](const char* name, PictureClass pictureClass, const auto& valueAt) {
        ClassPicture picture{name, pictureClass, Image<glm::vec4>(side, side), Image<float>(side, side, 1.0f)};
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) picture.texels.at(x, y) = glm::vec4(valueAt(static_cast<float>(x), static_cast<float>(y)), 1.0f);
        pictures.push_back(std::move(picture));
    };
    make("waves", PictureClass::Normals, [](float x, float y) {
        const float u = 0.6f * std::cos(0.35f * x + 0.1f * y) + 0.3f * std::cos(0.9f * x - 0.7f * y), v = 0.5f * std::sin(0.3f * y);
        return glm::normalize(glm::vec3(u, v, 1));
    });
    make("tiles", PictureClass::Normals, [](float x, float y) {
        // Flat tiles with round edges.
        const auto slope = [](float at) {
            const float inside = std::fmod(at, 23.0f) / 23 * 2 - 1;
            return std::copysign(std::max(0.0f, std::abs(inside) - 0.7f) * 4, inside);
        };
        return glm::normalize(glm::vec3(slope(x), slope(y), 1));
    });
    const auto toLight = [](float x, float y) {
        return glm::vec3(40 + 25 * std::sin(0.02f * y) - x, 30 + 20 * std::cos(0.03f * x) - y, 18);
    };
    make("passing_light", PictureClass::Directions, [&](float x, float y) { return glm::normalize(toLight(x, y)); });
    make("light_and_sky", PictureClass::ShRatios, [&](float x, float y) {
        const glm::vec3 direction = toLight(x, y);
        const float power = 900 / glm::dot(direction, direction), cosine = glm::normalize(direction).z;
        const glm::vec3 sky(0.2f, 0.3f, 0.5f), light(1.0f, 0.7f, 0.4f);
        return (light * (power * cosine) + sky * 0.5f) / (light * power + sky);
    });
}

/// Rounds each channel to a multiple of 1 / steps.
glm::vec4 rounded(glm::vec4 texel, float steps) {
    for (int c = 0; c < 4; ++c) texel[c] = std::round(texel[c] * steps) / steps;
    return texel;
}

/// Sorts pictures of light into classes, and adds photographs made of them.
void addLight(const std::vector<Picture>& light, int side, std::vector<ClassPicture>& pictures) {
    for (const Picture& picture : light) {
        if (picture.kind == PictureKind::ShBand) continue;
        const bool isMap = picture.kind == PictureKind::LightMap || picture.name == "soft_light" || picture.name == "grainy_light";
        const bool isPanorama =
            picture.kind == PictureKind::Panorama || picture.name == "sky_with_sun" || picture.name == "lamps_in_the_dark";
        if (isMap) add(copyOf(picture, PictureClass::LightMaps), side, pictures);
        if (isPanorama) add(copyOf(picture, PictureClass::Panoramas), side, pictures);
        if (picture.kind == PictureKind::Panorama || (!isMap && !isPanorama)) add(photographOf(picture), side, pictures);
    }
}

}  // namespace

std::span<const PictureClassInfo> allPictureClasses() {
    return kClasses;
}
const PictureClassInfo& info(PictureClass pictureClass) {
    return kClasses[static_cast<std::size_t>(pictureClass)];
}

std::vector<ClassPicture> ownClassPictures(const fs::path& sources, int side) {
    std::vector<ClassPicture> pictures;
    addLight(ownPictures(sources, side), side, pictures);
    addVectors(sources / "examples/cornell/cornell_lightmap.exr", "example", side, pictures);
    addVectorFormulas(side, pictures);
    return pictures;
}

std::vector<ClassPicture> sharedClassPictures(const fs::path& data, const fs::path& sources, int side) {
    std::vector<ClassPicture> pictures;
    const std::vector<Picture> light = sharedPictures(data);
    if (light.empty()) return pictures;
    addLight(light, side, pictures);
    const std::string ending = "_lightmap.exr";
    std::vector<fs::path> maps;
    for (const auto& entry : fs::directory_iterator(data / "scenes"))
        if (entry.path().filename().string().ends_with(ending)) maps.push_back(entry.path());
    std::sort(maps.begin(), maps.end());
    for (const fs::path& file : maps) {
        const std::string name = file.filename();
        addVectors(file, name.substr(0, name.size() - ending.size()), side, pictures);
    }
    addVectors(sources / "examples/cornell/cornell_lightmap.exr", "example", side, pictures);
    addVectorFormulas(side, pictures);
    return pictures;
}

std::vector<ClassPicture> photographsOf(const fs::path& folder, int side) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder))
        if (formats::isPictureFile(entry.path())) files.push_back(entry.path());
    if (files.empty()) throw std::runtime_error(folder.string() + ": holds no PNG, JPEG, TGA or BMP");
    std::sort(files.begin(), files.end());
    std::vector<ClassPicture> pictures;
    for (const fs::path& file : files) {
        formats::PlainImage image = orThrow(formats::readImage(file));
        for (glm::vec4& texel : image.texels.texels()) texel.a = 1;
        const int width = image.texels.width(), height = image.texels.height();
        add({file.stem(), PictureClass::Photographs, std::move(image.texels), Image<float>(width, height, 1.0f)}, side, pictures);
    }
    return pictures;
}

bool suits(PictureContent content, formats::PixelFormat format) {
    const formats::PixelFormatInfo& form = formats::info(format);
    switch (content) {
        case PictureContent::Colour:
            return !form.isFloat && !form.isSigned;
        case PictureContent::Light:
            return form.isFloat;
        case PictureContent::Vectors:
            break;
    }
    return !form.isFloat || form.isSigned;
}

formats::Image<glm::vec4> texelsFor(const ClassPicture& picture, formats::PixelFormat format) {
    const formats::PixelFormatInfo& form = formats::info(format);
    const bool isVectors = info(picture.pictureClass).content == PictureContent::Vectors;
    formats::Image<glm::vec4> texels = picture.texels.copy();
    for (glm::vec4& texel : texels.texels()) {
        if (form.isFloat) {
            for (int c = 0; c < 4; ++c) texel[c] = compress::floatFromHalf(compress::halfFromFloat(texel[c]));
        } else if (form.isSigned) {
            texel = rounded(texel, 127);
        } else {
            if (isVectors) texel = glm::vec4(glm::vec3(texel) * 0.5f + 0.5f, 1.0f);
            texel = rounded(texel, 255);
        }
    }
    return texels;
}

}  // namespace lightcook::bench
