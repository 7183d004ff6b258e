#include "pipeline/scene/asset_name.h"

#include <algorithm>

#include "formats/bake_format.h"
#include "pipeline/scene/checks.h"

namespace lightcook::pipeline {
namespace {

bool isLatinLetter(char letter) {
    return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z');
}

std::string nameOfStem(std::string_view stem, std::string_view otherwise) {
    const bool isOtherScript = std::ranges::none_of(stem, isLatinLetter) &&
                               std::ranges::any_of(stem, [](char letter) { return (static_cast<unsigned char>(letter) & 0x80) != 0; });
    std::string name(isOtherScript ? otherwise : "");
    for (const char letter : stem) {
        const auto byte = static_cast<unsigned char>(letter);
        if (isNameLetter(letter))
            name += letter;
        else if (byte < 0x80 || (!isOtherScript && byte >= 0xC0))  // the first byte of a letter in UTF-8
            name += '_';
    }
    constexpr std::size_t kRoomForNumber = 8;
    name.resize(std::min(name.size(), kLongestName - kRoomForNumber));
    if (name.ends_with('.')) name.back() = '_';
    if (name.empty() || name.front() == '.' || isReservedOnWindows(name)) name.insert(name.begin(), '_');
    return name;
}

}  // namespace

std::string assetNameOf(const std::filesystem::path& file, std::string_view otherwise) {
    return nameOfStem(file.stem().string(), otherwise);
}

std::string lightMapNameOf(const std::filesystem::path& file, std::string_view bake) {
    return nameOfStem(formats::nameOfBake(file, bake), "lightmap");
}

}  // namespace lightcook::pipeline
