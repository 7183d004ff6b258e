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

/// Calls visit with each neighbour of (x, y) in the strip, covered or not.
template <class Visit>
void forEachNeighbour(const LightMapStrip& strip, int x, int y, Visit&& visit) {
    for (int v = std::max(0, y - 1); v <= std::min(y + 1, strip.sh.height() - 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(x + 1, strip.sh.width() - 1); ++u)
            if (u != x || v != y) visit(u, v);
}

/// The covered neighbours of a texel.
struct Neighbours {
    int count = 0;
    float brightest = 0;
    bool isRim = false;  ///< the edge of the map or of a chart is beside the texel: not all neighbours are covered
};

Neighbours neighboursOf(const LightMapStrip& strip, int x, int y) {
    Neighbours found;
    found.isRim = x == 0 || x == strip.sh.width() - 1 || strip.sh.height() < 2;
    forEachNeighbour(strip, x, y, [&](int u, int v) {
        const bool isCovered = strip.covered.at(u, v) != 0;
        found.isRim = found.isRim || !isCovered;
        if (!isCovered) return;
        ++found.count;
        found.brightest = std::max(found.brightest, lightOf(strip.sh.at(u, v)));
    });
    return found;
}

/// Returns the mean of the covered neighbours.
lighting::ShRgb meanAround(const LightMapStrip& strip, int x, int y) {
    lighting::ShRgb sum{};
    float count = 0;
    forEachNeighbour(strip, x, y, [&](int u, int v) {
        if (strip.covered.at(u, v) == 0) return;
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
            const Neighbours neighbours = neighboursOf(strip, x, y);
            // A rim has fewer neighbours to tell by, and light sources of few texels. No scene has light of a ratio of 10^9: a sunlit wall
            // has 3 * 10^8 times that of a moonless night.
            const double ratio = neighbours.isRim ? limit * limit * limit : limit;
            const float beside = neighbours.isRim ? std::max(neighbours.brightest, bright) : neighbours.brightest;
            if (neighbours.count == 0 || (neighbours.isRim && beside == 0) || light <= ratio * beside) continue;
            found.push_back({x, strip.firstRow + y, colourOf(strip.sh.at(x, y)), light, beside, ratio, neighbours.isRim});
        }
    return found;
}

Result<void> checkFireflies(LightMapStrip& strip, double limit, bool repair, const std::function<Subject(const Firefly&)>& placeOf) {
    for (const Firefly& each : findFireflies(strip, limit)) {
        if (!repair)
            return failure(
                ErrorCode::ValueOutOfRange, placeOf(each),
                fmt::format("found light of {}, expected at most {} times that of {} ({}){}: a firefly (firefly_limit = 0 keeps it)",
                            each.found, each.ratio, each.isRim ? "its neighbours and of most texels" : "its brightest neighbour",
                            each.beside, each.isRim ? " at the rim of a chart" : ""));
        strip.sh.at(each.x, each.y - strip.firstRow) = meanAround(strip, each.x, each.y - strip.firstRow);
        ++strip.repairs.fireflies;
    }
    return {};
}

}  // namespace lightcook::formats
