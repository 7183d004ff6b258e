// EXR files made by a test with OpenEXR itself, channel by channel.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/plain_image.h"

namespace lightcook::formats {

/// The value of a channel at texel (x, y) of the image.
using ChannelValue = std::function<float(int x, int y)>;

struct ExrRecipe {
    int width = 8, height = 8;
    bool isHalf = false;
    bool isTiled = false;
    int tileExtent = 64;
    bool isZip = true;
    glm::ivec2 corner{0};  ///< of the data window
    std::optional<std::array<float, 8>> chromaticities = {};
    std::optional<ExrEnvironment> environment = {};  ///< attribute `envmap`
    std::map<std::string, ChannelValue> channels;
};

void writeRecipe(const std::filesystem::path& file, const ExrRecipe& recipe);

/// All 27 channels of an SH map: seeded values, sh00 positive; different at every texel and in every channel, exact in half.
std::map<std::string, ChannelValue> seededShChannels();
/// Returns the value of seededShChannels() in coefficient `index`, channel 0, 1 or 2.
float seededSh(int index, int channel, int x, int y);

/// One channel set to `value` at one texel.
void poke(ExrRecipe& recipe, const std::string& channel, int x, int y, float value);

}  // namespace lightcook::formats
