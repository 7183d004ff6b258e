#include "verify/light_map/visible_search.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <queue>

#include "verify/light_map/bound.h"
#include "verify/light_map/rnm_residual.h"

namespace lightcook::verify {
namespace {

using lightmap::ChannelSlack;
using lightmap::kChannels;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
/// Sums of nine products in double err by at most this part of their largest value.
constexpr double kSumRounding = 1e-12;

/// Widths that each kind of range adds to an interval.
struct Spread {
    double places = 0, profile = 0, azimuth = 0;
    void add(double factor, const Spread& other) {
        places += factor * other.places;
        profile += factor * other.profile;
        azimuth += factor * other.azimuth;
    }
    double sum() const { return places + profile + azimuth; }
};

struct Enclosed {
    Interval interval;
    Spread spread;
};

/// Four numbers side by side. Every lane is computed as a scalar would be.
using Lanes = double __attribute__((vector_size(32)));
static_assert(sizeof(Lanes) == LightVectors::kLanes * sizeof(double) && LightVectors::kMost % LightVectors::kLanes == 0);

Lanes absolute(Lanes x) {
    return x < 0 ? -x : x;
}
Lanes largerOf(Lanes a, Lanes b) {
    return a < b ? b : a;
}
Lanes smallerOf(Lanes a, Lanes b) {
    return b < a ? b : a;
}
double largestIn(Lanes x) {
    return std::max(std::max(x[0], x[1]), std::max(x[2], x[3]));
}
double smallestIn(Lanes x) {
    return -largestIn(-x);
}

/// Control vectors under the kernels of a cell: products with the centre and the tangents, by channel.
class ShadedControls {
public:
    ShadedControls(const LightVectors& controls, const ChannelSlack& slack, const KernelCell& kernels)
        : groups_(controls.stride() / LightVectors::kLanes), tangents_(kernels.tangents) {
        for (std::size_t c = 0; c < kChannels; ++c) {
            shade(controls, c, kernels.centre, centre_[c]);
            shade(controls, c, kernels.alongAzimuth, along_[0][c]);
            for (std::size_t t = 0; t < tangents_; ++t) shade(controls, c, kernels.alongProfile[t], along_[1 + t][c]);
            const lighting::ShBands& largest = controls.largest(c);
            for (std::size_t l = 0; l < 3; ++l) {
                profile_[c] += kernels.profileRadius[l] * largest[l];
                azimuth_[c] += kernels.azimuthRadius[l] * largest[l];
                slack_[c] += kernels.lengths[l] * (slack[c][l] + kSumRounding * largest[l]);
            }
        }
    }
    /// Adds what a layout in tangent space shows beside the vectors.
    void addResidual(const LightVectors& directions, const KernelCell& kernels) {
        const double reach = kernels.profileAngle + kernels.azimuthAngle;
        const RnmResidual residual = RnmResidual::around(kernels.normal, reach);
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t i = 0; i < residual.centre.size(); ++i) {
                double largest = 0;
                for (std::size_t k = 0; k < directions.count(); ++k) largest = std::max(largest, std::abs(directions.value(k, c, i)));
                for (std::size_t g = 0; g < groups_; ++g) centre_[c][g] += residual.centre[i] * lanesOf(directions, c, i, g);
                const double off = residual.radius[i] * largest, ofProfile = reach > 0 ? kernels.profileAngle / reach : 0;
                profile_[c] += ofProfile * off;
                azimuth_[c] += (1 - ofProfile) * off;
            }
    }
    /// Returns an enclosure of the sum of the channels times these weights.
    Enclosed enclose(const glm::dvec3& weights) const {
        const Lanes none = {}, infinite = none + kInfinite;
        Lanes low = infinite, high = -infinite, lowCentre = infinite, highCentre = -infinite, widestProfile = none, widestAzimuth = none;
        for (std::size_t g = 0; g < groups_; ++g) {
            const Lanes centre = combined(centre_, weights, g), azimuth = absolute(combined(along_[0], weights, g));
            Lanes profile = none;
            for (std::size_t t = 0; t < tangents_; ++t) profile += absolute(combined(along_[1 + t], weights, g));
            const Lanes width = profile + azimuth;
            low = smallerOf(low, centre - width);
            high = largerOf(high, centre + width);
            lowCentre = smallerOf(lowCentre, centre);
            highCentre = largerOf(highCentre, centre);
            widestProfile = largerOf(widestProfile, profile);
            widestAzimuth = largerOf(widestAzimuth, azimuth);
        }
        Enclosed out;
        out.spread = {0.5 * (largestIn(highCentre) - smallestIn(lowCentre)), largestIn(widestProfile), largestIn(widestAzimuth)};
        double slack = 0;
        for (std::size_t c = 0; c < kChannels; ++c) {
            const double weight = std::abs(weights[static_cast<int>(c)]);
            slack += weight * (slack_[c] + profile_[c] + azimuth_[c]);
            out.spread.profile += weight * profile_[c];
            out.spread.azimuth += weight * azimuth_[c];
        }
        out.interval = {smallestIn(low) - slack, largestIn(high) + slack};
        return out;
    }
    /// Returns an upper bound of the sum of the first vectors, each times any number in [-1, 1].
    double sumOfAll(const glm::dvec3& weights, std::size_t count) const {
        double sum = 0;
        for (std::size_t first = 0; first < count; first += LightVectors::kLanes) {
            const std::size_t g = first / LightVectors::kLanes;
            Lanes sums = absolute(combined(centre_, weights, g));
            for (std::size_t t = 0; t <= tangents_; ++t) sums += absolute(combined(along_[t], weights, g));
            for (std::size_t k = first; k < std::min(first + LightVectors::kLanes, count); ++k) sum += sums[k - first];
        }
        for (std::size_t c = 0; c < kChannels; ++c)
            sum += std::abs(weights[static_cast<int>(c)]) * static_cast<double>(count) * (slack_[c] + profile_[c] + azimuth_[c]);
        return sum;
    }

private:
    using Groups = std::array<Lanes, LightVectors::kMost / LightVectors::kLanes>;
    using Planes = std::array<Groups, kChannels>;
    void shade(const LightVectors& controls, std::size_t c, const lighting::ShDouble& kernel, Groups& out) const {
        for (std::size_t g = 0; g < groups_; ++g) {
            Lanes sum = kernel[0] * lanesOf(controls, c, 0, g);
            for (std::size_t i = 1; i < kernel.size(); ++i) sum += kernel[i] * lanesOf(controls, c, i, g);
            out[g] = sum;
        }
    }
    static Lanes lanesOf(const LightVectors& controls, std::size_t c, std::size_t i, std::size_t group) {
        Lanes out;
        std::memcpy(&out, controls.values(c, i) + group * LightVectors::kLanes, sizeof(out));
        return out;
    }
    static Lanes combined(const Planes& planes, const glm::dvec3& w, std::size_t group) {
        return w.x * planes[0][group] + w.y * planes[1][group] + w.z * planes[2][group];
    }

    Planes centre_;
    std::array<Planes, 1 + kProfileTangents> along_;
    std::array<double, kChannels> profile_{}, azimuth_{}, slack_{};
    std::size_t groups_, tangents_;
};

glm::dvec3 unit(std::size_t channel) {
    glm::dvec3 out(0);
    out[static_cast<int>(channel)] = 1;
    return out;
}

/// The bound of a cell, and what widens it.
struct Bounded {
    double bound = 0;
    Spread spread;
};

/// Returns an enclosure of numbers in either.
Enclosed unionOf(const Enclosed& a, const Enclosed& b) {
    return {{std::min(a.interval.low, b.interval.low), std::max(a.interval.high, b.interval.high)},
            {std::max(a.spread.places, b.spread.places), std::max(a.spread.profile, b.spread.profile),
             std::max(a.spread.azimuth, b.spread.azimuth)}};
}

/// Bounds one cell.
class CellBound {
public:
    CellBound(const VisibleMetric& metric, const CellLight& light, const KernelCell& kernels)
        : errors_(light.errors, light.errorSlack, kernels),
          references_(light.references, light.referenceSlack, kernels),
          found_(light.found, lightmap::sumOf(light.errorSlack, light.referenceSlack), kernels),
          metric_(metric) {
        if (light.directions.count() > 0 && kernels.isDiffuse) {
            errors_.addResidual(light.directions, kernels);
            found_.addResidual(light.directions, kernels);
        }
        if (light.deviations.count() > 0) {
            deviations_.emplace(light.deviations, ChannelSlack{}, kernels);
            deviationCount_ = light.deviations.count();
        }
        for (std::size_t c = 0; c < kChannels; ++c) {
            const Interval reference = references_.enclose(unit(c)).interval, found = enclose(Light::Found, unit(c)).interval;
            lowReference_[static_cast<int>(c)] = reference.low;
            lowFound_[static_cast<int>(c)] = found.low;
            if (reference.low < 0 || found.low < 0) clamped_ |= 1u << c;
            if (reference.high <= 0) dark_[0] |= 1u << c;
            if (found.high <= 0) dark_[1] |= 1u << c;
        }
        dark_[2] = dark_[0] & dark_[1];
    }

    /// threshold  a bound below it need not be tight
    Bounded run(double threshold) const {
        Intervals references, found, differences, codes;
        std::array<Spread, 3> spreads;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto row = static_cast<int>(k);
            const Enclosed x = encloseClamped(Light::Reference, metric_.lms(row)), y = encloseClamped(Light::Found, metric_.lms(row)),
                           difference = encloseClamped(Light::Error, metric_.lms(row));
            references[k] = luminance(x.interval, metric_.lowest(row, lowReference_));
            found[k] = luminance(y.interval, metric_.lowest(row, lowFound_));
            differences[k] = intersection(difference.interval, {found[k].low - references[k].high, found[k].high - references[k].low});
            spreads[k] = x.spread;
        }
        for (std::size_t k = 0; k < 3; ++k)
            codes[k] = VisibleMetric::codes(references[k], found[k], differences[k], VisibleMetric::slopes(references[k], found[k]));
        const double fromCodes = VisibleMetric::roundedUp(metric_.largest(codes));
        if (fromCodes < threshold) return {fromCodes, {}};
        std::array<Interval, 3> shares = {Interval{1, 1}};
        for (std::size_t k = 1; k < 3; ++k) shares[k] = slopeShare(k, references, found);
        // Where luminances are clamped, secants have no such ratio.
        double slope = VisibleMetric::slopes(references[0], found[0]).high;
        for (std::size_t k = 0; k < 3; ++k)
            if (!VisibleMetric::isWithinCurve(references[k]) || !VisibleMetric::isWithinCurve(found[k])) slope = kInfinite;
        return boundOf(slope, shares, differences, codes, spreads, references[0]);
    }

private:
    enum class Light { Reference, Found, Error };

    Interval luminance(const Interval& light, double lowest) const {
        const double low = std::max(metric_.black() + light.low, lowest);
        return {low, std::max(low, metric_.black() + light.high)};
    }
    /// Returns an enclosure of a sum of the channels as they are, the sampler's deviations included.
    Enclosed enclose(Light light, const glm::dvec3& weights) const {
        if (light == Light::Reference) return references_.enclose(weights);
        Enclosed out = (light == Light::Found ? found_ : errors_).enclose(weights);
        if (deviations_) {
            const double deviation = deviations_->sumOfAll(weights, deviationCount_);
            out.interval = {out.interval.low - deviation, out.interval.high + deviation};
        }
        return out;
    }
    /// Returns an enclosure of a sum of the clamped channels. Clamping multiplies a number, or the difference of two, by a factor in [0,
    /// 1]: the sum is linear in these factors, so that it is largest where each is 0 or 1.
    Enclosed encloseClamped(Light light, const glm::dvec3& weights) const {
        const unsigned dark = dark_[static_cast<std::size_t>(light)], either = clamped_ & ~dark;
        Enclosed out = encloseWithout(dark, light, weights);
        for (unsigned zeros = either; zeros > 0; zeros = (zeros - 1) & either)
            out = unionOf(out, encloseWithout(dark | zeros, light, weights));
        return out;
    }
    Enclosed encloseWithout(unsigned zeros, Light light, glm::dvec3 weights) const {
        if (zeros == 7) return {};
        for (int c = 0; c < 3; ++c)
            if ((zeros >> c & 1u) != 0) weights[c] = 0;
        return enclose(light, weights);
    }
    /// Returns an interval of the ratio of the curve's secant at M or S to that at L.
    Interval slopeShare(std::size_t k, const Intervals& references, const Intervals& found) const {
        return VisibleMetric::secantRatio(hullOf(ratioOf(Light::Reference, k, references), ratioOf(Light::Found, k, found)),
                                          hullOf(hullOf(references[0], references[k]), hullOf(found[0], found[k])));
    }
    /// Returns an interval of M or S over L.
    Interval ratioOf(Light light, std::size_t k, const Intervals& lms) const {
        const glm::dvec3 &l = metric_.lms(0), &other = metric_.lms(static_cast<int>(k));
        // The ratio of any light is between those of the channels and that of black.
        Interval any = {1, 1};
        for (int c = 0; c < 3; ++c) any = {std::min(any.low, other[c] / l[c]), std::max(any.high, other[c] / l[c])};
        const double guess = (lms[k].low + lms[k].high) / (lms[0].low + lms[0].high);
        const Interval off = encloseClamped(light, other - guess * l).interval;
        const double black = metric_.black() * (1 - guess);
        const auto over = [&](double difference, bool isLow) {
            return guess + difference / ((difference < 0) == isLow ? lms[0].low : lms[0].high);
        };
        return intersection(any, {over(off.low + black, true), over(off.high + black, false)});
    }
    /// slope   largest secant of the curve at L
    /// shares  of the secants at L, M and S relative to it
    Bounded boundOf(double slope, const std::array<Interval, 3>& shares, const Intervals& differences, const Intervals& codes,
                    const std::array<Spread, 3>& spreads, const Interval& luminance) const {
        Bounded out;
        double squares = 0;
        for (int row = 0; row < 3; ++row) {
            const glm::dvec3& itp = VisibleMetric::itp(row);
            glm::dvec3 weights(0);
            double rest = 0;
            Interval fromCodes;
            for (int k = 0; k < 3; ++k) {
                const auto at = static_cast<std::size_t>(k);
                const double mean = 0.5 * (shares[at].low + shares[at].high), half = 0.5 * (shares[at].high - shares[at].low);
                weights += itp[k] * mean * metric_.lms(k);
                const double off = std::abs(itp[k]) * half * differences[at].largest();
                rest += off;
                fromCodes = fromCodes + itp[k] * codes[at];
                out.spread.add(std::min(slope, 1.0) * off / std::max(spreads[at].sum(), 1e-30), spreads[at]);
            }
            const Enclosed main = encloseClamped(Light::Error, weights);
            const double fromSlopes = slope * (main.interval.largest() + rest),
                         largest = std::min(fromSlopes, std::max(std::abs(fromCodes.low), std::abs(fromCodes.high)));
            out.spread.add(std::min(slope, 1.0), main.spread);
            // The slope changes with the luminance by at most this.
            out.spread.add(largest / luminance.low, spreads[0]);
            squares += largest * largest;
        }
        out.bound = VisibleMetric::roundedUp(std::min(std::sqrt(squares), metric_.largest(codes)));
        return out;
    }
    ShadedControls errors_, references_, found_;
    std::optional<ShadedControls> deviations_;
    const VisibleMetric& metric_;
    std::size_t deviationCount_ = 0;
    glm::dvec3 lowReference_{0}, lowFound_{0};
    unsigned clamped_ = 0;            ///< a bit for each channel that may be negative
    std::array<unsigned, 3> dark_{};  ///< [light]: a bit for each channel that is never positive
};

/// A rectangle of places with its light, made when first needed, and its quarters.
struct PlaceNode {
    PlaceRectangle rectangle;
    CellLight light;
    int depth = 0, children = -1;
};

struct Cell {
    double bound = 0;
    Spread spread;
    int order = 0, place = 0, range = 0;
    double azimuth = std::numbers::pi, half = std::numbers::pi;
    bool operator<(const Cell& other) const { return bound != other.bound ? bound < other.bound : order > other.order; }
};

class Search {
public:
    Search(const VisibleMetric& metric, const KernelTree& tree, const LightOver& lightOver)
        : metric_(metric), tree_(tree), lightOver_(lightOver) {}

    VisibleMaximum run(const PlaceRectangle& whole, double threshold, SearchBudget& budget, int effort) {
        threshold_ = threshold;
        addPlace(whole, 0);
        const std::size_t controls = places_.front()->light.errors.count();
        const int mostCells = std::min(effort * mostCellsOf(controls), budget.cells(controls));
        add(Cell{});
        bool isFinal = true;
        for (;;) {
            const Cell top = cells_.top();
            if (top.bound < threshold || !(top.bound < kInfinite) || (order_ >= nextTest_ && isConverged(top))) break;
            isFinal = order_ < mostCells;
            if (!isFinal) break;
            if (order_ >= nextTest_) nextTest_ = order_ + kBetweenTests;
            cells_.pop();
            if (split(top)) continue;
            cells_.push(top);
            break;
        }
        budget.spend(order_, controls);
        VisibleMaximum found = resultOf(cells_.top());
        found.isFinal = isFinal;
        return found;
    }

private:
    static constexpr int kPlaceDepth = 4, kBetweenTests = 20;
    static constexpr double kNarrowest = 0.02;
    /// Cells of at most this half width of azimuth try both ways before they cut places or kernels; wider ones go by the spread, since one
    /// cut alone shows too little there [rad].
    static constexpr double kTrialHalf = 0.3;

    /// Returns how many cells a quarter may have. One with few control vectors comes from a decode of low degree: its cells cost less, and
    /// few of its quarters need them all.
    static int mostCellsOf(std::size_t controls) {
        constexpr std::size_t kFewest = 24, kMost = 384, kWork = 24 * 16 * 16;
        return static_cast<int>(std::clamp(kWork / (controls * controls), kFewest, kMost));
    }
    void addPlace(const PlaceRectangle& rectangle, int depth) {
        places_.push_back(std::make_unique<PlaceNode>(PlaceNode{rectangle, lightOver_(rectangle), depth}));
    }
    void add(Cell cell) {
        const KernelCell kernels = tree_.cell(cell.range, cell.azimuth, cell.half);
        const CellLight& light = places_[static_cast<std::size_t>(cell.place)]->light;
        const Bounded bounded = light.isFinite ? CellBound(metric_, light, kernels).run(threshold_) : Bounded{kInfinite, {}};
        // A part is never worse than the whole.
        cell.bound = cell.order == 0 && order_ == 0 ? bounded.bound : std::min(cell.bound, bounded.bound);
        cell.spread = bounded.spread;
        cell.order = order_++;
        cells_.push(cell);
    }
    /// Returns the kernel in the middle of a cell.
    KernelCell middleOf(const Cell& cell) const {
        KernelCell kernel = tree_.cell(cell.range, cell.azimuth, std::min(cell.half, KernelTree::kNarrow));
        kernel.tangents = 0;
        kernel.alongAzimuth = {};
        kernel.profileRadius = kernel.azimuthRadius = {};
        kernel.profileAngle = kernel.azimuthAngle = 0;
        return kernel;
    }
    CellLight middleLight(const Cell& cell) const {
        return lightOver_({places_[static_cast<std::size_t>(cell.place)]->rectangle.middle(), glm::vec2(0)});
    }
    bool isConverged(const Cell& cell) const {
        return cell.half <= KernelTree::kNarrow &&
               cell.bound <= VisibleSearch::kConvergedFactor * CellBound(metric_, middleLight(cell), middleOf(cell)).run(0).bound;
    }
    bool split(const Cell& cell) {
        PlaceNode& place = *places_[static_cast<std::size_t>(cell.place)];
        const ProfileRange& range = tree_.range(cell.range);
        double places = place.depth < kPlaceDepth ? cell.spread.places : -1;
        const double profile = range.isLeaf() ? -1 : cell.spread.profile, azimuth = cell.half > kNarrowest ? cell.spread.azimuth : -1;
        if (places >= 0 && place.light.isFinite && cell.half < kTrialHalf) places = isWidenedByPlaces(cell) ? kInfinite : -1;
        if (std::max({places, profile, azimuth}) < 0) return false;
        if (places >= profile && places >= azimuth)
            splitPlace(cell);
        else if (profile >= azimuth)
            for (const int each : {range.first, range.second}) {
                Cell part = cell;
                part.range = each;
                add(part);
            }
        else
            splitAzimuth(cell);
        return true;
    }
    /// Returns true if the middle of the cell's places under all of its kernels has a lower bound than its middle kernel at all of its
    /// places.
    bool isWidenedByPlaces(const Cell& cell) const {
        const CellLight& light = places_[static_cast<std::size_t>(cell.place)]->light;
        const KernelCell kernels = tree_.cell(cell.range, cell.azimuth, cell.half);
        return CellBound(metric_, middleLight(cell), kernels).run(0).bound < CellBound(metric_, light, middleOf(cell)).run(0).bound;
    }
    void splitPlace(const Cell& cell) {
        const auto at = static_cast<std::size_t>(cell.place);
        if (places_[at]->children < 0) {
            places_[at]->children = static_cast<int>(places_.size());
            const PlaceRectangle whole = places_[at]->rectangle;
            const glm::vec2 half = 0.5f * whole.size;
            for (int i = 0; i < 4; ++i) addPlace({whole.low + half * glm::vec2(i % 2, i / 2), half}, places_[at]->depth + 1);
        }
        for (int i = 0; i < 4; ++i) {
            Cell part = cell;
            part.place = places_[at]->children + i;
            add(part);
        }
    }
    void splitAzimuth(const Cell& cell) {
        const int count = cell.half > KernelTree::kNarrow ? 8 : 2;
        for (int i = 0; i < count; ++i) {
            Cell part = cell;
            part.half = cell.half / count;
            part.azimuth = cell.azimuth - cell.half + (2 * i + 1) * part.half;
            add(part);
        }
    }
    VisibleMaximum resultOf(const Cell& cell) const {
        if (cell.bound < threshold_) return {cell.bound, {}};
        const CellLight light = middleLight(cell);
        const KernelCell kernel = middleOf(cell);
        const ProfileRange& range = tree_.range(cell.range);
        const glm::dvec3 direction(std::sin(range.angle) * std::cos(cell.azimuth), std::sin(range.angle) * std::sin(cell.azimuth),
                                   std::cos(range.angle));
        VisibleMaximum out{cell.bound, {}};
        VisiblePlace& place = out.place;
        const glm::vec2 middle = places_[static_cast<std::size_t>(cell.place)]->rectangle.middle();
        place.x = static_cast<double>(middle.x);
        place.y = static_cast<double>(middle.y);
        place.normal = tree_.isSpecular() ? glm::dvec3(0, 0, 1) : direction;
        if (tree_.isSpecular()) place.view = direction;
        place.m = range.m;
        place.f0 = range.f0;
        place.difference = cell.bound;
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t i = 0; i < lighting::kShCount; ++i) {
                const double reference = light.references.value(0, c, i), error = light.errors.value(0, c, i);
                place.reference[static_cast<int>(c)] += kernel.centre[i] * reference;
                place.found[static_cast<int>(c)] += kernel.centre[i] * (reference + error);
            }
        return out;
    }

    const VisibleMetric& metric_;
    const KernelTree& tree_;
    const LightOver& lightOver_;
    std::vector<std::unique_ptr<PlaceNode>> places_;
    std::priority_queue<Cell> cells_;
    int order_ = 0, nextTest_ = 0;
    double threshold_ = 0;  ///< bounds below it need not be tight
};

}  // namespace

void LightVectors::add(const std::array<lighting::Sh, 3>& light) {
    assert(count_ < kMost);
    for (std::size_t c = 0; c < kChannels; ++c) {
        for (std::size_t i = 0; i < lighting::kShCount; ++i)
            for (std::size_t k = count_; k < (count_ / kLanes + 1) * kLanes; ++k) values_[c][i][k] = static_cast<double>(light[c][i]);
        const lighting::ShBands lengths = lighting::bandLengths(light[c]);
        for (std::size_t l = 0; l < 3; ++l) largest_[c][l] = std::max(largest_[c][l], lengths[l]);
    }
    ++count_;
}

VisibleMaximum VisibleSearch::bound(const PlaceRectangle& whole, const LightOver& lightOver, double threshold, SearchBudget& budget,
                                    int effort) const {
    return Search(metric_, tree_, lightOver).run(whole, threshold, budget, effort);
}

double VisibleSearch::cellBound(const CellLight& light, const KernelCell& kernels) const {
    return CellBound(metric_, light, kernels).run(0).bound;
}

}  // namespace lightcook::verify
