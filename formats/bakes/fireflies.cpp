#include "formats/fireflies.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace lightcook::formats {
namespace {

float lightOf(const lighting::ShRgb& sh) {
    return std::max({sh[0].x, sh[0].y, sh[0].z});
}

/// Returns the 90th percentile of the light of the covered texels. A mean would follow the firefly itself.
float brightLight(const LightMapStrip& band) {
    std::vector<float> light;
    for (int y = 0; y < band.sh.height(); ++y)
        for (int x = 0; x < band.sh.width(); ++x)
            if (band.covered.at(x, y)) light.push_back(lightOf(band.sh.at(x, y)));
    if (light.empty()) return 0;
    const auto ninth = light.begin() + static_cast<std::ptrdiff_t>(light.size() * 9 / 10);
    std::nth_element(light.begin(), ninth, light.end());
    return *ninth;
}

/// Calls visit with each neighbour of (x, y) in the band.
template <class Visit>
void forEachNeighbour(const LightMapStrip& band, int x, int y, Visit&& visit) {
    for (int v = std::max(0, y - 1); v <= std::min(y + 1, band.sh.height() - 1); ++v)
        for (int u = x - 1; u <= x + 1; ++u)
            if (u != x || v != y) visit(u, v);
}

/// Returns the light of the brightest neighbour; nothing at the edge of a chart or of the map, where too few neighbours are covered.
std::optional<float> brightestAround(const LightMapStrip& band, int x, int y) {
    if (x == 0 || x == band.sh.width() - 1 || band.sh.height() < 2) return std::nullopt;
    bool isInside = true;
    float brightest = 0;
    forEachNeighbour(band, x, y, [&](int u, int v) {
        isInside = isInside && band.covered.at(u, v);
        brightest = std::max(brightest, lightOf(band.sh.at(u, v)));
    });
    return isInside ? std::optional(brightest) : std::nullopt;
}

lighting::ShRgb meanAround(const LightMapStrip& band, int x, int y) {
    lighting::ShRgb sum{};
    float count = 0;
    forEachNeighbour(band, x, y, [&](int u, int v) {
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += band.sh.at(u, v)[i];
        ++count;
    });
    for (glm::vec3& coefficient : sum) coefficient /= count;
    return sum;
}

}  // namespace

std::vector<Firefly> findFireflies(const LightMapStrip& band, double limit) {
    std::vector<Firefly> found;
    const float bright = brightLight(band);
    for (int y = 0; y < band.sh.height(); ++y)
        for (int x = 0; x < band.sh.width(); ++x) {
            const float light = lightOf(band.sh.at(x, y));
            if (!band.covered.at(x, y) || !(light > bright)) continue;
            const auto brightest = brightestAround(band, x, y);
            if (brightest && light > limit * *brightest) found.push_back({x, band.firstRow + y, light, *brightest});
        }
    return found;
}

Result<void> checkFireflies(LightMapStrip& band, double limit, bool repair, const std::string& file) {
    for (const Firefly& each : findFireflies(band, limit)) {
        if (!repair)
            return failure(ErrorCode::ValueOutOfRange, fmt::format("{}, channel sh00, texel ({}, {})", file, each.x, each.y),
                           fmt::format("found {}, expected at most {} times its brightest neighbour ({}): a firefly (firefly_limit = 0 "
                                       "keeps it)",
                                       each.found, limit, each.brightest));
        band.sh.at(each.x, each.y - band.firstRow) = meanAround(band, each.x, each.y - band.firstRow);
        ++band.repairs.fireflies;
    }
    return {};
}

}  // namespace lightcook::formats
