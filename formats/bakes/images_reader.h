// The part that readers of a bake of one or several images share. All images have the size of the first, which may have coverage and
// normals.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/bakes/bake_reader.h"
#include "formats/bakes/surface_channels.h"

namespace lightcook::formats {

class ImagesReader : public BakeReader {
public:
    int width() const override { return images_.front().info().width; }
    int height() const override { return images_.front().info().height; }
    int tileHeight() const override { return images_.front().tileHeight(); }
    bool hasNormals() const override { return surface_.hasNormals(); }
    bool hasCoverage() const override { return surface_.hasCoverage(); }
    std::string coverageChannel() const override { return surface_.coverageChannel(); }
    /// Of a map whose row y is row y of every image.
    Result<std::string> storedDigest(int firstRow, int rowCount) const override;
    /// Looks in every image for a number that is not finite; then, for coefficient 0, for a negative colour. Without any, returns the
    /// number that the coefficient is in proportion to.
    std::optional<StoredNumber> placeOf(std::size_t coefficient, int colour, int x, int y) const override;

protected:
    struct ChannelOfImage {
        std::size_t image = 0;
        std::string channel;
    };
    static std::string colourName(int colour) { return std::string(1, "RGB"[colour]); }
    /// Returns the channel of which a colour of a coefficient is made, beside coefficient 0. By default that of the colour in the first
    /// image.
    virtual ChannelOfImage sourceOf([[maybe_unused]] std::size_t coefficient, int colour) const { return {0, colourName(colour)}; }
    /// Returns a place in an image with its value.
    std::optional<StoredNumber> numberAt(const ChannelOfImage& place, int x, int y) const;

    /// A texel is 27 floats in a row.
    static constexpr int kFloatsPerTexel = 3 * lighting::kShCount;
    static_assert(sizeof(lighting::ShRgb) == kFloatsPerTexel * sizeof(float), "OpenEXR reads a texel as 27 floats in a row");

    ImagesReader(std::vector<BakeImage> images, SurfaceChannels surface) : images_(std::move(images)), surface_(std::move(surface)) {}
    const std::vector<BakeImage>& images() const { return images_; }

    /// Returns a strip whose coefficients are 0.
    RawStrip emptyStrip(int rowCount) const {
        RawStrip raw;
        raw.sh = Image<lighting::ShRgb>(width(), rowCount);
        return raw;
    }
    /// Makes room in a strip for coverage and normals, and appends them to the planes to read from the first image.
    void addSurface(RawStrip& raw, std::vector<ExrPlane>& planes) const { surface_.prepare(raw, width(), raw.sh.height(), planes); }
    /// Returns the plane that reads a channel to float `index` of each texel, from a row of the strip on.
    ExrPlane planeOf(RawStrip& raw, std::string channel, std::size_t index, int firstRow = 0) const {
        return {std::move(channel), &raw.sh.at(0, firstRow).front().x + index, kFloatsPerTexel, width() * kFloatsPerTexel};
    }
    /// Appends the planes that read R, G and B to a coefficient.
    void addColours(RawStrip& raw, std::size_t coefficient, std::vector<ExrPlane>& planes, int firstRow = 0) const {
        for (std::size_t colour = 0; colour < 3; ++colour)
            planes.push_back(planeOf(raw, std::string(1, "RGB"[colour]), 3 * coefficient + colour, firstRow));
    }

private:
    /// Returns a number of an image. Empty: it has no such channel.
    std::optional<float> valueAt(const ChannelOfImage& place, int x, int y) const;

    std::vector<BakeImage> images_;
    SurfaceChannels surface_;
};

/// Returns the images of a bake of one.
inline std::vector<BakeImage> onlyImage(BakeImage image) {
    std::vector<BakeImage> images;
    images.push_back(std::move(image));
    return images;
}

}  // namespace lightcook::formats
