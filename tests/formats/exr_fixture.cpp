#include "tests/formats/exr_fixture.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfEnvmapAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <fmt/format.h>

#include <Imath/half.h>

namespace lightcook::formats {
namespace {

/// One channel's texels in the file's own type.
struct Plane {
    std::vector<float> floats;
    std::vector<half> halves;
};

}  // namespace

void writeRecipe(const std::filesystem::path& file, const ExrRecipe& recipe) {
    const Imath::Box2i window({recipe.corner.x, recipe.corner.y},
                              {recipe.corner.x + recipe.width - 1, recipe.corner.y + recipe.height - 1});
    Imf::Header header(window, window);
    header.compression() = recipe.isZip ? Imf::ZIP_COMPRESSION : Imf::NO_COMPRESSION;
    if (recipe.chromaticities) {
        const std::array<float, 8>& xy = *recipe.chromaticities;
        Imf::addChromaticities(header, {{xy[0], xy[1]}, {xy[2], xy[3]}, {xy[4], xy[5]}, {xy[6], xy[7]}});
    }
    if (recipe.environment) Imf::addEnvmap(header, *recipe.environment == ExrEnvironment::Cube ? Imf::ENVMAP_CUBE : Imf::ENVMAP_LATLONG);
    const Imf::PixelType type = recipe.isHalf ? Imf::HALF : Imf::FLOAT;
    std::map<std::string, Plane> planes;
    Imf::FrameBuffer buffer;
    for (const auto& [name, value] : recipe.channels) {
        header.channels().insert(name, Imf::Channel(type));
        Plane& plane = planes[name];
        for (int y = 0; y < recipe.height; ++y) {
            for (int x = 0; x < recipe.width; ++x) {
                plane.floats.push_back(value(x, y));
                plane.halves.emplace_back(value(x, y));
            }
        }
        const void* texels = recipe.isHalf ? static_cast<const void*>(plane.halves.data()) : plane.floats.data();
        buffer.insert(name, Imf::Slice::Make(type, texels, window));
    }
    if (recipe.isTiled) {
        const auto extent = static_cast<unsigned>(recipe.tileExtent);
        header.setTileDescription(Imf::TileDescription(extent, extent, Imf::ONE_LEVEL));
        Imf::TiledOutputFile output(file.c_str(), header);
        output.setFrameBuffer(buffer);
        output.writeTiles(0, output.numXTiles() - 1, 0, output.numYTiles() - 1);
    } else {
        Imf::OutputFile output(file.c_str(), header);
        output.setFrameBuffer(buffer);
        output.writePixels(recipe.height);
    }
}

float seededSh(int index, int channel, int x, int y) {
    const unsigned hash = static_cast<unsigned>(x * 7919 + y * 104729 + index * 31 + channel * 17) * 2654435761u;
    const float value = static_cast<float>(hash >> 22) / 512.0f - 1.0f;  // [-1, 1), steps of 1/512: exact in half
    return index == 0 ? value + 2.0f : value;
}

std::map<std::string, ChannelValue> seededShChannels() {
    std::map<std::string, ChannelValue> channels;
    for (int index = 0; index < 9; ++index) {
        for (int channel = 0; channel < 3; ++channel) {
            channels[fmt::format("sh{:02}.{}", index, "RGB"[channel])] = [index, channel](int x, int y) {
                return seededSh(index, channel, x, y);
            };
        }
    }
    return channels;
}

void poke(ExrRecipe& recipe, const std::string& channel, int x, int y, float value) {
    const ChannelValue before = recipe.channels.at(channel);
    recipe.channels[channel] = [=](int atX, int atY) { return atX == x && atY == y ? value : before(atX, atY); };
}

}  // namespace lightcook::formats
