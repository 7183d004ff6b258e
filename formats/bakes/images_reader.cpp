#include "formats/bakes/images_reader.h"

#include <cmath>

#include "formats/digest.h"

namespace lightcook::formats {

std::optional<float> ImagesReader::valueAt(const ChannelOfImage& place, int x, int y) const {
    const BakeImage& image = images_[place.image];
    if (!image.info().has(place.channel)) return std::nullopt;
    std::vector<float> row(static_cast<std::size_t>(image.info().width));
    const ExrPlane plane{place.channel, row.data(), 1, image.info().width};
    if (!image.readRows(y, 1, {&plane, 1})) return std::nullopt;
    return row[static_cast<std::size_t>(x)];
}

std::optional<StoredNumber> ImagesReader::numberAt(const ChannelOfImage& place, int x, int y) const {
    return StoredNumber{images_[place.image].subject(), place.channel, x, y, valueAt(place, x, y)};
}

Result<std::string> ImagesReader::storedDigest(int firstRow, int rowCount) const {
    std::string digests;
    for (const BakeImage& image : images_) {
        LC_TRY(digest, image.storedDigest(firstRow, rowCount));
        if (digest->empty()) return digest;
        digests += *digest;
    }
    return digestOfText(digests);
}

std::optional<StoredNumber> ImagesReader::placeOf(std::size_t coefficient, int colour, int x, int y) const {
    for (std::size_t image = 0; image < images_.size(); ++image)
        for (const char channel : {'R', 'G', 'B', 'A'}) {
            const ChannelOfImage place{image, std::string(1, channel)};
            if (const auto value = valueAt(place, x, y); value && !std::isfinite(*value)) return numberAt(place, x, y);
        }
    if (coefficient == 0)
        for (std::size_t image = 0; image < images_.size(); ++image) {
            const ChannelOfImage place{image, colourName(colour)};
            if (const auto value = valueAt(place, x, y); value && *value < 0) return numberAt(place, x, y);
        }
    return numberAt(sourceOf(coefficient, colour), x, y);
}

}  // namespace lightcook::formats
