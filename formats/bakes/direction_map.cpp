#include "formats/bakes/direction_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "formats/bakes/exit_radiance.h"
#include "formats/bakes/images_reader.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;

/// Coefficients of x, y and z.
constexpr std::array<std::size_t, 3> kAxes = {3, 1, 2};
/// Coefficient to whose red the alpha of the direction map is read.
constexpr std::size_t kAlpha = 4;

class DirectionMapReader final : public ImagesReader {
public:
    DirectionMapReader(std::vector<BakeImage> images, SurfaceChannels surface, const DirectionMapDecode& decode)
        : ImagesReader(std::move(images), std::move(surface)), decode_(decode) {}

    Result<RawStrip> read(int firstRow, int rowCount) const override {
        RawStrip raw = emptyStrip(rowCount);
        std::vector<ExrPlane> colours, directions;
        addColours(raw, 0, colours);
        addSurface(raw, colours);
        // A component is read to the red of its coefficient.
        for (std::size_t axis = 0; axis < kAxes.size(); ++axis)
            directions.push_back(planeOf(raw, std::string(1, "RGB"[axis]), 3 * kAxes.at(axis)));
        if (decode_.needsAlpha) directions.push_back(planeOf(raw, "A", 3 * kAlpha));
        LC_CHECK(images()[0].readRows(firstRow, rowCount, colours));
        LC_CHECK(images()[1].readRows(firstRow, rowCount, directions));
        for (int y = 0; y < rowCount; ++y)
            for (int x = 0; x < width(); ++x)
                if (!decode(raw, x, y))
                    return failure(
                        ErrorCode::ValueOutOfRange, images()[1].subject().at(fmt::format("texel ({}, {})", x, firstRow + y)),
                        fmt::format("found ({}), expected {} where {} has light. A texel outside the charts? Set the alpha of {} "
                                    "to 0 there",
                                    asText(storedAt(raw, x, y)), decode_.expected, colourFile(), colourFile()));
        return raw;
    }

private:
    ChannelOfImage sourceOf(std::size_t coefficient, int colour) const override {
        const auto axis = std::ranges::find(kAxes, coefficient);
        if (axis == kAxes.end()) return {0, colourName(colour)};
        return {1, colourName(static_cast<int>(axis - kAxes.begin()))};
    }

    static std::string asText(const glm::vec4& stored) {
        return fmt::format("{:.3g}, {:.3g}, {:.3g}, {:.3g}", stored.r, stored.g, stored.b, stored.a);
    }
    std::string colourFile() const { return images()[0].file().filename().string(); }

    glm::vec4 storedAt(const RawStrip& raw, int x, int y) const {
        const ShRgb& sh = raw.sh.at(x, y);
        return {sh[kAxes[0]].x, sh[kAxes[1]].x, sh[kAxes[2]].x, decode_.needsAlpha ? sh[kAlpha].x : 1};
    }

    /// Replaces colour and direction of a texel by coefficients. Returns false if a covered texel with light has no direction.
    bool decode(RawStrip& raw, int x, int y) const {
        const std::optional<DirectedResponse> response = decode_.response(storedAt(raw, x, y));
        ShRgb& sh = raw.sh.at(x, y);
        const glm::vec3 colour = sh[0];
        const bool isCovered = raw.coverage.width() == 0 || raw.coverage.at(x, y) > 0.5f, isDark = colour == glm::vec3(0);
        if (!response && isCovered && !isDark) return false;
        sh = ShRgb{};
        if (!response || isDark) return true;
        sh[0] = kFirstOfExit * response->constant * colour;
        for (std::size_t axis = 0; axis < kAxes.size(); ++axis)
            sh[kAxes.at(axis)] = kLinearOfExit * response->linear[static_cast<int>(axis)] * colour;
        return true;
    }

    DirectionMapDecode decode_;
};

}  // namespace

Result<std::unique_ptr<BakeReader>> openDirectionMap(std::vector<BakeImage> images, const DirectionMapDecode& decode) {
    if (decode.needsAlpha && !images[1].info().has("A"))
        return failure(ErrorCode::WrongShape, images[1].subject(),
                       fmt::format("found no alpha, expected R, G, B and A: {}. Export the map with its alpha channel", decode.expected));
    Result<SurfaceChannels> surface = SurfaceChannels::of(images.front(), "A");
    if (!surface) return tl::make_unexpected(surface.error());
    return std::make_unique<DirectionMapReader>(std::move(images), std::move(*surface), decode);
}

}  // namespace lightcook::formats
