#include "pipeline/scene/asset_name.h"

#include <algorithm>

#include "formats/bake_format.h"
#include "pipeline/scene/checks.h"

namespace lightcook::pipeline {
namespace {

std::string nameOfStem(std::string_view stem) {
    std::string name;
    for (const char letter : stem) {
        // The later bytes of a letter in UTF-8 give no '_' of their own.
        if (isNameLetter(letter))
            name += letter;
        else if ((static_cast<unsigned char>(letter) & 0xC0) != 0x80)
            name += '_';
    }
    constexpr std::size_t kRoomForNumber = 8;
    name.resize(std::min(name.size(), kLongestName - kRoomForNumber));
    if (name.ends_with('.')) name.back() = '_';
    if (name.empty() || name.front() == '.' || isReservedOnWindows(name)) name.insert(name.begin(), '_');
    return name;
}

}  // namespace

std::string assetNameOf(const std::filesystem::path& file) {
    return nameOfStem(file.stem().string());
}

std::string lightMapNameOf(const std::filesystem::path& file, std::string_view bake) {
    return nameOfStem(formats::nameOfBake(file, bake));
}

}  // namespace lightcook::pipeline
