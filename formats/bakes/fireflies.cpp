#include "formats/fireflies.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace lightcook::formats {
namespace {

float lightOf(const lighting::ShRgb& sh) {
    return std::max({sh[0].x, sh[0].y, sh[0].z});
}

/// Returns the colour of lightOf().
int colourOf(const lighting::ShRgb& sh) {
    int largest = 0;
    for (int colour = 1; colour < 3; ++colour)
        if (sh[0][colour] > sh[0][largest]) largest = colour;
    return largest;
}

/// Returns the 90th percentile of the light of the covered texels. A mean would follow the firefly itself.
float brightLight(const LightMapStrip& strip) {
    std::vector<float> light;
    for (int y = 0; y < strip.sh.height(); ++y)
        for (int x = 0; x < strip.sh.width(); ++x)
            if (strip.covered.at(x, y)) light.push_back(lightOf(strip.sh.at(x, y)));
    if (light.empty()) return 0;
    const auto ninth = light.begin() + static_cast<std::ptrdiff_t>(light.size() * 9 / 10);
    std::nth_element(light.begin(), ninth, light.end());
    return *ninth;
}

/// Calls visit with each neighbour of (x, y) in the strip.
template <class Visit>
void forEachNeighbour(const LightMapStrip& strip, int x, int y, Visit&& visit) {
    for (int v = std::max(0, y - 1); v <= std::min(y + 1, strip.sh.height() - 1); ++v)
        for (int u = x - 1; u <= x + 1; ++u)
            if (u != x || v != y) visit(u, v);
}

/// Returns the light of the brightest neighbour; nothing at the edge of a chart or of the map, where too few neighbours are covered.
std::optional<float> brightestAround(const LightMapStrip& strip, int x, int y) {
    if (x == 0 || x == strip.sh.width() - 1 || strip.sh.height() < 2) return std::nullopt;
    bool isInside = true;
    float brightest = 0;
    forEachNeighbour(strip, x, y, [&](int u, int v) {
        isInside = isInside && strip.covered.at(u, v);
        brightest = std::max(brightest, lightOf(strip.sh.at(u, v)));
    });
    return isInside ? std::optional(brightest) : std::nullopt;
}

lighting::ShRgb meanAround(const LightMapStrip& strip, int x, int y) {
    lighting::ShRgb sum{};
    float count = 0;
    forEachNeighbour(strip, x, y, [&](int u, int v) {
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += strip.sh.at(u, v)[i];
        ++count;
    });
    for (glm::vec3& coefficient : sum) coefficient /= count;
    return sum;
}

}  // namespace

std::vector<Firefly> findFireflies(const LightMapStrip& strip, double limit) {
    std::vector<Firefly> found;
    const float bright = brightLight(strip);
    for (int y = 0; y < strip.sh.height(); ++y)
        for (int x = 0; x < strip.sh.width(); ++x) {
            const float light = lightOf(strip.sh.at(x, y));
            if (!strip.covered.at(x, y) || !(light > bright)) continue;
            const auto brightest = brightestAround(strip, x, y);
            if (brightest && light > limit * *brightest)
                found.push_back({x, strip.firstRow + y, colourOf(strip.sh.at(x, y)), light, *brightest});
        }
    return found;
}

Result<void> checkFireflies(LightMapStrip& strip, double limit, bool repair, const std::function<Subject(const Firefly&)>& placeOf) {
    for (const Firefly& each : findFireflies(strip, limit)) {
        if (!repair)
            return failure(ErrorCode::ValueOutOfRange, placeOf(each),
                           fmt::format("found light of {}, expected at most {} times that of its brightest neighbour ({}): a firefly "
                                       "(firefly_limit = 0 keeps it)",
                                       each.found, limit, each.brightest));
        strip.sh.at(each.x, each.y - strip.firstRow) = meanAround(strip, each.x, each.y - strip.firstRow);
        ++strip.repairs.fireflies;
    }
    return {};
}

}  // namespace lightcook::formats
