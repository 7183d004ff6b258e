#include "fit/filtered_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <span>
#include <vector>

#include "formats/light_map.h"

namespace lightcook::fit {
namespace {

/// Half the mean of 1 / (8 m^2) over m = 0.1, 0.25 and 0.5, each weighed by the energy of its highlight, 1 / m^2.
constexpr double kSharpness = 5.35;
/// A sweep that lowers the sum by less than this share is the last.
constexpr double kLeastGain = 0.01;
/// A light dimmer than this share of the floor counts as none.
constexpr double kLeastLight = 1.0 / 256;

struct Light {
    glm::dvec3 direction{0}, intensity{0};
};

/// A place that up to four texels meet at, and the light of the bake there.
struct Place {
    std::array<int, 4> texels{};  ///< indices; the filter takes their mean
    int count = 0;
    glm::vec3 direction{0}, intensity{0};  ///< direction unit
    double weight = 0;
};

/// Returns g^(-1/2) for the cosine between two directions.
double spreadOf(double cosine) {
    return 1 + kSharpness * std::max(0.0, 2 - 2 * cosine);
}

/// Returns the same for a filtered direction and a unit one. A filtered direction of length 0 counts as opposite.
double spreadOf(const glm::dvec3& filtered, const glm::dvec3& unit) {
    const double length = glm::length(filtered);
    return spreadOf(length > 0 ? glm::dot(filtered, unit) / length : -1);
}

/// Returns E of a light against a unit direction and an intensity.
double differenceOf(const Light& found, const glm::dvec3& direction, const glm::dvec3& intensity) {
    const double spread = spreadOf(found.direction, direction);
    const glm::dvec3 off = found.intensity - intensity;
    return glm::dot(off, off) + 2 * (1 - 1 / (spread * spread)) * glm::dot(found.intensity, intensity);
}

double differenceOf(const Light& found, const Place& place) {
    return differenceOf(found, glm::dvec3(place.direction), glm::dvec3(place.intensity));
}

/// Lights of some rows, and the places whose light depends on the unknown ones.
class FilteredFit {
public:
    FilteredFit(const DominantLightRows& rows, const FilteredLightOptions& options)
        : rows_(rows), options_(options), width_(rows.sh.width), height_(rows.sh.height) {
        lights_.reserve(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x) lights_.push_back({glm::dvec3(rows.direction.at(x, y)), glm::dvec3(rows.intensity.at(x, y))});
        places_.assign(lights_.size(), {kUntried, kUntried, kUntried, kUntried});
    }

    void setLengths() {
        std::vector<double> luminances(lights_.size());
        std::vector<glm::dvec3> units(lights_.size());
        for (std::size_t i = 0; i < lights_.size(); ++i) {
            const double length = glm::length(lights_[i].direction);
            luminances[i] = glm::dot(lights_[i].intensity, glm::dvec3(options_.light.luminanceWeights));
            units[i] = length > 0 ? lights_[i].direction / length : lights_[i].direction;
        }
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x)
                if (isCovered(x, y)) lightAt(x, y).direction = lengthOf(units, luminances, x, y) * units[at(x, y)];
    }

    /// Finds the unknown texels of some rows, and the places that depend on them.
    void findUnknowns(int firstRow, int rowCount) {
        std::vector<std::uint8_t> isUnknown(lights_.size());
        for (int y = std::max(0, firstRow - 1); y < std::min(height_ - 1, firstRow + rowCount); ++y)
            for (int x = 0; x + 1 < width_; ++x)
                if (isOff(x, y))
                    for (const int texel : texelsOf(Quad, x, y).texels) isUnknown[static_cast<std::size_t>(texel)] = 1;
        for (int y = firstRow; y < firstRow + rowCount; ++y)
            for (int x = 0; x < width_; ++x)
                if (isUnknown[at(x, y)] != 0) addUnknown(x, y);
    }

    void solve() {
        double left = sumOfDifferences();
        for (int sweep = 0; sweep < options_.mostSweeps && left > 0; ++sweep) {
            for (const Unknown& unknown : unknowns_) {
                moveDirection(unknown);
                setIntensity(unknown);
            }
            const double before = left;
            left = sumOfDifferences();
            if (before - left < kLeastGain * before) break;
        }
    }

    /// Sets solved lights that are too dim to see to zero, since encoders would spend their range on them.
    void removeTraces() {
        for (const Unknown& unknown : unknowns_) {
            glm::dvec3& intensity = lights_[unknown.texel].intensity;
            if (std::max({intensity.x, intensity.y, intensity.z}) < kLeastLight * options_.floor) intensity = glm::dvec3(0);
        }
    }

    void store(formats::ImageView<std::uint8_t> solved) const {
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x) {
                rows_.direction.at(x, y) = glm::vec3(lightAt(x, y).direction);
                rows_.intensity.at(x, y) = glm::vec3(lightAt(x, y).intensity);
                solved.at(x, y) = 0;
            }
        for (const Unknown& unknown : unknowns_) {
            const int texel = static_cast<int>(unknown.texel);
            solved.at(texel % width_, texel / width_) = 1;
        }
    }

private:
    /// Places of a texel: its centre, and the midpoints whose first texel it is.
    enum Kind : std::size_t { Centre, Right, Below, Quad, kKindCount };
    static constexpr int kUntried = -1, kNone = -2;

    struct Unknown {
        std::size_t texel = 0;
        std::array<int, 9> places{};  ///< the texel's centre first
        std::size_t count = 0;
        glm::dvec3 brightest{0};  ///< largest intensities of its places
    };

    std::size_t at(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    Light& lightAt(int x, int y) { return lights_[at(x, y)]; }
    const Light& lightAt(int x, int y) const { return lights_[at(x, y)]; }
    bool isCovered(int x, int y) const { return rows_.covered.at(x, y) != 0; }

    /// Returns true if a filter on a surface may blend these texels: no surface lies between charts that touch.
    bool areBlended(std::span<const int> texels) const {
        if (rows_.chart.width == 0 || texels.size() < 2) return true;
        std::array<std::uint32_t, 4> charts{};
        for (std::size_t i = 0; i < charts.size(); ++i) {
            const int texel = texels[i % texels.size()];
            charts[i] = rows_.chart.at(texel % width_, texel / width_);
        }
        return formats::mayHoldSurface(charts);
    }

    /// Calls visit(index) for each covered texel next to (x, y) of its chart, and for that itself.
    template <class Visit>
    void visitNeighbours(int x, int y, const Visit& visit) const {
        for (int nearY = std::max(0, y - 1); nearY <= std::min(height_ - 1, y + 1); ++nearY)
            for (int nearX = std::max(0, x - 1); nearX <= std::min(width_ - 1, x + 1); ++nearX)
                if (isCovered(nearX, nearY)) {
                    const std::array<int, 2> both = {static_cast<int>(at(x, y)), static_cast<int>(at(nearX, nearY))};
                    if (both[0] == both[1] || areBlended(both)) visit(at(nearX, nearY));
                }
    }

    /// Returns the length of a direction for the filter.
    /// units  unit directions of all texels
    double lengthOf(const std::vector<glm::dvec3>& units, const std::vector<double>& luminances, int x, int y) const {
        double brightest = 0, farthest = 0;
        visitNeighbours(x, y, [&](std::size_t near) {
            brightest = std::max(brightest, luminances[near]);
            farthest = std::max(farthest, glm::distance(units[near], units[at(x, y)]));
        });
        if (!(brightest > 0)) return 1;
        const double share = std::clamp((farthest - options_.turn) / options_.turn, 0.0, 1.0);
        return 1 - share + share * std::max(options_.shortest, std::sqrt(std::max(0.0, luminances[at(x, y)] / brightest)));
    }

    Light filteredAt(const Place& place) const {
        Light sum;
        for (int i = 0; i < place.count; ++i) {
            const Light& light = lights_[static_cast<std::size_t>(place.texels[static_cast<std::size_t>(i)])];
            sum.direction += light.direction;
            sum.intensity += light.intensity;
        }
        return {sum.direction / static_cast<double>(place.count), sum.intensity / static_cast<double>(place.count)};
    }

    /// Returns a place without its light; of no texels if the map or the chart ends before it.
    Place texelsOf(Kind kind, int x, int y) const {
        const int right = kind == Right || kind == Quad, below = kind == Below || kind == Quad;
        Place place;
        if (x < 0 || y < 0 || x + right >= width_ || y + below >= height_) return place;
        for (int i = 0; i <= below; ++i)
            for (int j = 0; j <= right; ++j) {
                if (!isCovered(x + j, y + i)) return {};
                place.texels[static_cast<std::size_t>(place.count++)] = static_cast<int>(at(x + j, y + i));
            }
        return areBlended(std::span(place.texels).first(static_cast<std::size_t>(place.count))) ? place : Place{};
    }

    /// Returns the light of the filtered bake at a place; without a direction where no surface lies between opposite normals.
    DominantLight bakedAt(const Place& place) const {
        const auto column = [&](int i) { return place.texels[static_cast<std::size_t>(i)] % width_; };
        const auto row = [&](int i) { return place.texels[static_cast<std::size_t>(i)] / width_; };
        if (place.count == 1)
            return {.direction = rows_.direction.at(column(0), row(0)), .intensity = rows_.intensity.at(column(0), row(0))};
        lighting::ShRgb sh{};
        glm::vec3 normal(0);
        for (int i = 0; i < place.count; ++i) {
            normal += rows_.normal.at(column(i), row(i));
            for (std::size_t k = 0; k < sh.size(); ++k) sh[k] += rows_.sh.at(column(i), row(i))[k] / static_cast<float>(place.count);
        }
        if (glm::length(normal) < 1e-3f) return {};
        return dominantLight(sh, glm::normalize(normal), options_.light);
    }

    /// Sets the light that is wanted at a place. Returns false if none is.
    bool setWanted(Place& place, double weight) const {
        const DominantLight light = bakedAt(place);
        const double length = glm::length(glm::dvec3(light.direction));
        if (!(length > 0)) return false;
        place.direction = glm::vec3(glm::dvec3(light.direction) / length);
        place.intensity = light.intensity;
        const double scale = glm::length(glm::dvec3(place.intensity)) + options_.floor;
        place.weight = weight / (scale * scale);
        return scale > 0 && std::isfinite(place.weight);
    }

    /// Returns the index of a place, or kNone if nothing is wanted there.
    int placeAt(Kind kind, int x, int y) {
        if (x < 0 || y < 0) return kNone;
        int& index = places_[at(x, y)][kind];
        if (index != kUntried) return index;
        Place place = texelsOf(kind, x, y);
        const bool isWanted = place.count > 0 && setWanted(place, kind == Centre ? options_.centreWeight : 1);
        index = isWanted ? static_cast<int>(wanted_.size()) : kNone;
        if (isWanted) wanted_.push_back(place);
        return index;
    }

    /// Returns true if the four lights of a quad differ from their mean, and that from the light of the bake.
    bool isOff(int x, int y) {
        const Place quad = texelsOf(Quad, x, y);
        if (quad.count == 0) return false;
        const Light mean = filteredAt(quad);
        const double length = glm::length(mean.direction), scale = glm::length(mean.intensity) + options_.floor;
        const glm::dvec3 towards = length > 0 ? mean.direction / length : mean.direction;
        const double least = options_.tolerance * options_.tolerance * scale * scale;
        if (std::ranges::none_of(quad.texels, [&](int texel) {
                return differenceOf(lights_[static_cast<std::size_t>(texel)], towards, mean.intensity) > least;
            }))
            return false;
        const int index = placeAt(Quad, x, y);
        if (index == kNone) return false;
        const Place& place = wanted_[static_cast<std::size_t>(index)];
        return place.weight * differenceOf(mean, place) > options_.tolerance * options_.tolerance;
    }

    void addUnknown(int x, int y) {
        if (placeAt(Centre, x, y) == kNone) return;
        Unknown unknown;
        unknown.texel = at(x, y);
        const auto add = [&](Kind kind, int placeX, int placeY) {
            const int index = placeAt(kind, placeX, placeY);
            if (index == kNone) return;
            unknown.places[unknown.count++] = index;
            unknown.brightest = glm::max(unknown.brightest, glm::dvec3(wanted_[static_cast<std::size_t>(index)].intensity));
        };
        add(Centre, x, y);
        add(Right, x, y), add(Right, x - 1, y);
        add(Below, x, y), add(Below, x, y - 1);
        add(Quad, x, y), add(Quad, x - 1, y), add(Quad, x, y - 1), add(Quad, x - 1, y - 1);
        unknowns_.push_back(unknown);
    }

    /// Returns a term of the sum.
    double differenceAt(const Place& place) const { return place.weight * differenceOf(filteredAt(place), place); }
    /// Returns the terms that depend on a texel.
    double differenceAt(const Unknown& unknown) const {
        double sum = 0;
        for (std::size_t i = 0; i < unknown.count; ++i) sum += differenceAt(placeOf(unknown, i));
        return sum;
    }

    /// Returns true if the light is as good as it has to be at the centre of its texel.
    bool isNearItsOwn(const Unknown& unknown) const {
        const Place& centre = placeOf(unknown, 0);
        const double scale = glm::length(glm::dvec3(centre.intensity)) + options_.floor;
        return differenceOf(lights_[unknown.texel], centre) <= options_.mostAtCentre * options_.mostAtCentre * scale * scale;
    }

    double sumOfDifferences() const {
        double sum = 0;
        for (const Place& place : wanted_) sum += differenceAt(place);
        return sum;
    }

    const Place& placeOf(const Unknown& unknown, std::size_t i) const { return wanted_[static_cast<std::size_t>(unknown.places[i])]; }

    /// Moves the direction of a texel by a Gauss-Newton step. E is concave in |d - d*|^2, so its tangent is an upper bound: a sum of
    /// squares of |d - d*|, which Gauss-Newton minimises.
    void moveDirection(const Unknown& unknown) {
        glm::dvec3 gradient(0);
        glm::dmat3 hessian(0);
        for (std::size_t i = 0; i < unknown.count; ++i) {
            const Place& place = placeOf(unknown, i);
            const Light seen = filteredAt(place);
            const double length = glm::length(seen.direction);
            if (!(length > 0)) continue;
            const glm::dvec3 towards = seen.direction / length, wanted(place.direction);
            const double cosine = glm::dot(towards, wanted), spread = spreadOf(cosine), share = 1 / (length * place.count);
            const double slope =
                4 * kSharpness * place.weight * glm::dot(seen.intensity, glm::dvec3(place.intensity)) / (spread * spread * spread);
            gradient -= 2 * slope * share * (wanted - cosine * towards);
            hessian += 2 * slope * share * share * (glm::dmat3(1) - glm::outerProduct(towards, towards));
        }
        const double trace = hessian[0][0] + hessian[1][1] + hessian[2][2];
        if (!(trace > 0) || !std::isfinite(trace)) return;
        constexpr double kDamping = 0.01;
        follow(unknown, -(glm::inverse(hessian / trace + glm::dmat3(kDamping)) * (gradient / trace)));
    }

    /// Turns the direction by the longest tried share of a step that lowers the sum, or not at all. Its length stays.
    void follow(const Unknown& unknown, glm::dvec3 step) {
        constexpr int kMostAttempts = 3;
        glm::dvec3& direction = lights_[unknown.texel].direction;
        const glm::dvec3 before = direction;
        const double left = differenceAt(unknown), length = glm::length(step), longest = 0.5 * glm::length(before) + options_.shortest;
        if (length > longest) step *= longest / length;
        for (int attempt = 0; attempt < kMostAttempts; ++attempt, step *= 0.3) {
            direction = before + step;
            const double found = glm::length(direction);
            if (!(found > 0)) continue;
            direction *= glm::length(before) / found;
            if (differenceAt(unknown) < left && isNearItsOwn(unknown)) return;
        }
        direction = before;
    }

    /// Moves the intensity of a texel to the minimum of the sum within its limits. The sum is a quadratic in each channel of the intensity.
    void setIntensity(const Unknown& unknown) {
        const glm::dvec3 intensity = lights_[unknown.texel].intensity;
        glm::dvec3 sum(0);
        double weight = 0;
        for (std::size_t i = 0; i < unknown.count; ++i) {
            const Place& place = placeOf(unknown, i);
            const Light seen = filteredAt(place);
            const double share = 1.0 / place.count, spread = spreadOf(seen.direction, glm::dvec3(place.direction));
            const glm::dvec3 others = seen.intensity - share * intensity;
            sum += place.weight * share * (glm::dvec3(place.intensity) / (spread * spread) - others);
            weight += place.weight * share * share;
        }
        if (weight > 0 && std::isfinite(weight)) approach(unknown, glm::clamp(sum / weight, glm::dvec3(0), unknown.brightest));
    }

    /// Moves the intensity towards a better one, as far as the texel's own centre allows.
    void approach(const Unknown& unknown, const glm::dvec3& better) {
        constexpr int kMostAttempts = 5;
        glm::dvec3& intensity = lights_[unknown.texel].intensity;
        const glm::dvec3 before = intensity;
        double share = 1;
        for (int attempt = 0; attempt < kMostAttempts; ++attempt, share *= 0.5) {
            intensity = glm::mix(before, better, share);
            if (isNearItsOwn(unknown)) return;
        }
        intensity = before;
    }

    DominantLightRows rows_;
    const FilteredLightOptions& options_;
    int width_, height_;
    std::vector<Light> lights_;
    std::vector<std::array<int, kKindCount>> places_;  ///< of each texel: indices into wanted_
    std::vector<Place> wanted_;
    std::vector<Unknown> unknowns_;
};

}  // namespace

void fitForFilter(const DominantLightRows& rows, formats::ImageView<std::uint8_t> solved, int firstRow, int rowCount,
                  const FilteredLightOptions& options) {
    FilteredFit fit(rows, options);
    fit.setLengths();
    fit.findUnknowns(firstRow, rowCount);
    fit.solve();
    fit.removeTraces();
    fit.store(solved);
}

}  // namespace lightcook::fit
