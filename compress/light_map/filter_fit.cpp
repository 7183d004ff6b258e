#include "compress/light_map/filter_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/common.hpp>
#include <limits>

#include "formats/padding.h"
#include "lighting/radiometry.h"

namespace lightcook::compress::rows {

namespace {

using formats::Image;
using formats::LightMapFamily;

/// Sweeps over the unknowns. Each reaches two rows, and the equations of a texel one more on either side. Layouts that divide by
/// coefficient 0 have sweeps for coefficient 0, then as many for the ratios.
constexpr int kSweeps = 4, kSweepsOfProducts = 2;
static_assert(kLightMapContextRows >= 2 * kSweeps + 2 && kLightMapContextRows >= 2 * (2 * kSweepsOfProducts + 1));

/// Share of the key that is added to light in the weight of a place.
constexpr float kFloor = 0.05f;
/// Weight of the mean of the covered neighbours, over that of the places.
constexpr float kRegularization = 1e-3f;
/// Coefficient 0 of layouts that divide by it is at least this share of the mean of the covered neighbours.
constexpr float kLeastShare = 0x1p-8f;

/// Weight of solved texels for the encoder, over that of covered ones: the integral of (w_k)^2 over the places beyond a straight rim, over
/// that around a covered texel. Layouts that divide by coefficient 0 lose more between texels elsewhere. Their weight is half of that of
/// padding: at 1/256 the light source of the test scene `interior` loses levels of its block to the padding.
constexpr float kSolvedCoverage = 1.0f / 16, kDividedCoverage = 1.0f / 512;

/// Least product, in a quad, of the spread of coefficient 0 over its sum and of the spread of a ratio, for which covered texels are fitted:
/// the product is about the relative error of the product of filtered factors.
constexpr float kEdge = 0.01f;
/// Weight of the centre of a covered texel, over that of a place. A quad has 16 places, so that a centre counts as much as a quad. With a
/// smaller weight, texel centres lose more than the places between them gain.
constexpr float kCentre = 16;

constexpr std::size_t kFilterChannels = 3, kFilterRatios = kFilterChannels * (lighting::kShCount - 1);

/// Gauss points of [0, 1/2].
constexpr std::array<float, 2> kPlaces = {0.10566243f, 0.39433757f};

/// Range of the ratios to coefficient 0 that a layout can store.
struct RatioRange {
    float low = -std::numeric_limits<float>::infinity(), high = std::numeric_limits<float>::infinity();
};

class FilterFit {
public:
    FilterFit(const LightMapPlan& plan, const formats::LightMapStrip& strip, int firstRow, Source& source)
        : plan_(plan),
          strip_(strip),
          source_(source),
          sourceRow_(firstRow - strip.firstRow),
          family_(formats::info(plan.layout).family),
          count_(source.values.size()),
          hasFreeValues_(family_ == LightMapFamily::Raw || family_ == LightMapFamily::Rnm),
          fitsCovered_(formats::info(plan.layout).hasObjective() && plan.objective),
          dividesByFirst_(!hasFreeValues_ && family_ != LightMapFamily::Flat && family_ != LightMapFamily::Hdr),
          floor_(std::max(kFloor * static_cast<float>(plan.key), 1e-12f)) {
        top_ = std::max(0, sourceRow_ - kLightMapContextRows);
        rows_ = std::min(strip.sh.height(), sourceRow_ + source.height + kLightMapContextRows) - top_;
    }

    void solve() {
        setRanges();
        findUnknowns();
        if (!unknowns_.empty()) solveValues(0, dividesByFirst_ ? 1 : count_, false);
        if (dividesByFirst_) {
            if (fitsCovered_) findEdges();
            if (!unknowns_.empty()) solveValues(1, count_, true);
        }
        store();
    }

private:
    /// An uncovered texel beside a covered one, or a covered one at an edge of light. The row of its normal equation: by 3 x 3 neighbours,
    /// itself in the middle.
    struct Unknown {
        int x, y;
        std::array<glm::vec3, 9> row;
        bool isSeen = false;  ///< a filter on a surface reads it
        bool isCovered = false;
    };

    /// Ratios of coefficients 1 to 8 to coefficient 0, [coefficient][channel]: loops over them run in vector lanes. Those that the layout
    /// does not have are 0.
    using Ratios = std::array<float, kFilterRatios>;

    bool isCovered(int x, int y) const { return strip_.covered.at(x, top_ + y) != 0; }
    /// Returns true if a surface may lie in the quad whose top left texel is (x, y).
    bool mayHoldSurface(int x, int y) const {
        if (strip_.chart.width() == 0) return true;
        const auto chart = [&](int k) { return strip_.chart.at(x + k % 2, top_ + y + k / 2); };
        return formats::mayHoldSurface({chart(0), chart(1), chart(2), chart(3)});
    }
    void findUnknowns() {
        const auto covered = strip_.covered.view();
        index_ = Image<int>(plan_.width, rows_, -1);
        for (int y = 0; y < rows_; ++y)
            for (int x = 0; x < plan_.width; ++x) {
                if (isCovered(x, y) || formats::visitNearestCovered(covered, x, top_ + y, 1, [](int, int) {}) == 0) continue;
                index_.at(x, y) = static_cast<int>(unknowns_.size());
                unknowns_.push_back({x, y, {}});
            }
    }
    /// Adds the covered texels of quads in which the product of filtered factors is far from the filtered product.
    void findEdges() {
        std::vector<Ratios> above, below;
        for (int y = 0; y + 1 < rows_; ++y) {
            if (y == 0) loadRatios(y, above);
            loadRatios(y + 1, below);
            for (int x = 0; x + 1 < plan_.width; ++x)
                if (mayHoldSurface(x, y) && isEdge(x, y, above, below))
                    forEachCorner(x, y, [&](int cornerX, int cornerY) { addCovered(cornerX, cornerY); });
            std::swap(above, below);
        }
    }
    /// above, below  ratios of the covered texels of rows y and y + 1
    bool isEdge(int x, int y, const std::vector<Ratios>& above, const std::vector<Ratios>& below) const {
        float low = std::numeric_limits<float>::infinity(), high = 0;
        forEachCorner(x, y, [&](int cornerX, int cornerY) {
            const glm::vec3 dc = valueAt(0, cornerX, cornerY);
            const float light = std::max({dc.x, dc.y, dc.z, 0.0f});
            low = std::min(low, light);
            high = std::max(high, light);
        });
        if (!(high > low)) return false;
        const float least = kEdge * (high + low) / (high - low);
        Ratios smallest, largest;
        smallest.fill(std::numeric_limits<float>::infinity());
        largest.fill(-std::numeric_limits<float>::infinity());
        forEachCorner(x, y, [&](int cornerX, int cornerY) {
            const Ratios& ratios = (cornerY == y ? above : below)[index(cornerX)];
            for (std::size_t j = 0; j < ratios.size(); ++j) {
                smallest[j] = ratios[j] < smallest[j] ? ratios[j] : smallest[j];
                largest[j] = ratios[j] > largest[j] ? ratios[j] : largest[j];
            }
        });
        float widest = 0;
        for (std::size_t j = 0; j < smallest.size(); ++j) widest = std::max(widest, largest[j] - smallest[j]);
        return widest > least;
    }
    /// Calls visit(x, y) for the covered corners of a quad.
    template <class Visit>
    void forEachCorner(int x, int y, Visit visit) const {
        for (int k = 0; k < 4; ++k)
            if (isCovered(x + k % 2, y + k / 2)) visit(x + k % 2, y + k / 2);
    }
    void addCovered(int x, int y) {
        if (index_.at(x, y) >= 0) return;
        index_.at(x, y) = static_cast<int>(unknowns_.size());
        unknowns_.push_back({x, y, {}, false, true});
        values_.resize(unknowns_.size() * count_);
        at(values_, unknowns_.size() - 1, 0) = valueAt(0, x, y);
    }
    /// Returns the ratios of a covered texel.
    Ratios ratiosAt(int x, int y) const {
        const lighting::ShRgb& sh = strip_.sh.at(x, top_ + y);
        const Ratios dc = repeated(sh[0]);
        Ratios out;
        std::memcpy(out.data(), &sh[1], sizeof(out));
        for (std::size_t j = 0; j < out.size(); ++j) {
            const float ratio = out[j] / dc[j], low = lows_[j], high = highs_[j], clamped = ratio < low ? low : high < ratio ? high : ratio;
            out[j] = dc[j] > 0 ? clamped : 0.0f;
        }
        return out;
    }
    /// Sets the ratios of the covered texels of a row.
    void loadRatios(int y, std::vector<Ratios>& row) const {
        row.resize(index(plan_.width));
        for (int x = 0; x < plan_.width; ++x)
            if (isCovered(x, y)) row[index(x)] = ratiosAt(x, y);
    }
    /// Returns a number for each channel, repeated for each coefficient. Chosen in lanes: stores of single floats would delay the vector
    /// loads that follow.
    static Ratios repeated(const glm::vec3& channels) {
        constexpr auto kChannelOf = [] {
            std::array<std::int32_t, kFilterRatios> out{};
            for (std::size_t j = 0; j < out.size(); ++j) out[j] = static_cast<std::int32_t>(j % kFilterChannels);
            return out;
        }();
        const float red = channels.x, green = channels.y, blue = channels.z;
        Ratios out;
        for (std::size_t j = 0; j < out.size(); ++j) out[j] = kChannelOf[j] == 0 ? red : kChannelOf[j] == 1 ? green : blue;
        return out;
    }

    void setRanges() {
        ranges_.assign(count_, {});
        for (std::size_t i = 1; i < count_; ++i) {
            if (family_ == LightMapFamily::Ratio) {
                const float bias = constant(plan_, "bias", i - 1);
                ranges_[i] = {bias, bias + constant(plan_, "scale", i - 1)};
            } else if (family_ == LightMapFamily::Hdr) {
                ranges_[i].low = constant(plan_, "bias", i - 1);
            } else if (!hasFreeValues_) {
                const float largest = 1.25f * std::sqrt(2.0f * static_cast<float>(lighting::kShBand[i]) + 1);
                ranges_[i] = {-largest, largest};
            }
            for (std::size_t c = 0; c < kFilterChannels; ++c) {
                lows_[kFilterChannels * (i - 1) + c] = ranges_[i].low;
                highs_[kFilterChannels * (i - 1) + c] = ranges_[i].high;
            }
        }
    }

    /// Returns value i of a covered texel.
    glm::vec3 valueAt(std::size_t i, int x, int y) const {
        const lighting::ShRgb& sh = strip_.sh.at(x, top_ + y);
        if (family_ == LightMapFamily::Flat)
            return lighting::evaluate(lighting::convolve(sh, lighting::kExitRadianceBands), strip_.normal.at(x, top_ + y));
        return sh[i];
    }
    /// Values [first, end) of a texel, [value][channel].
    using Values = std::array<float, kFilterChannels * lighting::kShCount>;
    /// Returns values [first, end) of a covered texel: coefficients, or their ratios to coefficient 0.
    Values valuesAt(std::size_t first, std::size_t end, int x, int y, bool isRatio) const {
        Values out;
        if (isRatio) {
            const Ratios ratios = ratiosAt(x, y);
            std::memcpy(out.data(), ratios.data(), sizeof(ratios));
            return out;
        }
        for (std::size_t i = first; i < end; ++i) {
            const glm::vec3 value = valueAt(i, x, y);
            std::memcpy(&out[kFilterChannels * (i - first)], &value, sizeof(value));
        }
        return out;
    }
    static float* floatsOf(std::vector<glm::vec3>& all, std::size_t place) { return &all[place].x; }
    glm::vec3& at(std::vector<glm::vec3>& all, std::size_t unknown, std::size_t i) const { return all[unknown * count_ + i]; }

    /// Sets values [first, end) of the unknowns to their own or to the means of their covered neighbours, then solves them.
    void solveValues(std::size_t first, std::size_t end, bool isRatio) {
        if (values_.empty()) values_.resize(unknowns_.size() * count_);
        start_.assign(unknowns_.size() * count_, glm::vec3(0));
        for (std::size_t u = 0; u < unknowns_.size(); ++u) {
            unknowns_[u].row.fill(glm::vec3(0));
            float* start = floatsOf(start_, u * count_ + first);
            const std::size_t floats = kFilterChannels * (end - first);
            if (unknowns_[u].isCovered) {
                const Values own = valuesAt(first, end, unknowns_[u].x, unknowns_[u].y, isRatio);
                std::copy_n(own.data(), floats, start);
            } else {
                const int count =
                    formats::visitNearestCovered(strip_.covered.view(), unknowns_[u].x, top_ + unknowns_[u].y, 1, [&](int x, int y) {
                        const Values near = valuesAt(first, end, x, y - top_, isRatio);
                        for (std::size_t j = 0; j < floats; ++j) start[j] += near[j];
                    });
                for (std::size_t i = first; i < end; ++i) at(start_, u, i) /= static_cast<float>(count);
            }
            std::copy_n(start, floats, floatsOf(values_, u * count_ + first));
        }
        wanted_.assign(unknowns_.size() * count_, glm::vec3(0));
        for (int y = 0; y + 1 < rows_; ++y)
            for (int x = 0; x + 1 < plan_.width; ++x) addQuad(x, y, first, end, isRatio);
        if (isRatio) addCentres(first, end);
        std::array<std::vector<std::size_t>, 4> ofColour;
        for (std::size_t u = 0; u < unknowns_.size(); ++u)
            ofColour[index(unknowns_[u].x % 2 + 2 * ((strip_.firstRow + top_ + unknowns_[u].y) % 2))].push_back(u);
        for (int sweep = 0; sweep < (dividesByFirst_ ? kSweepsOfProducts : kSweeps); ++sweep)
            for (const std::vector<std::size_t>& colour : ofColour)
                for (const std::size_t u : colour) update(u, first, end, isRatio);
    }

    /// Adds the centres of covered texels to the equations.
    void addCentres(std::size_t first, std::size_t end) {
        for (std::size_t u = 0; u < unknowns_.size(); ++u) {
            if (!unknowns_[u].isCovered) continue;
            const glm::vec3 dc = at(values_, u, 0), length = dc / (exitOf(dc) + floor_), weight = kCentre * length * length;
            unknowns_[u].row[4] += weight;
            for (std::size_t i = first; i < end; ++i) at(wanted_, u, i) += weight * at(start_, u, i);
        }
    }
    /// Adds the places of the quad whose top left texel is (x, y) to the equations.
    void addQuad(int x, int y, std::size_t first, std::size_t end, bool isRatio) {
        std::array<bool, 4> covered{}, free{};
        std::array<int, 4> unknown{};
        int coveredCount = 0, freeCount = 0;
        for (int k = 0; k < 4; ++k) {
            covered[index(k)] = isCovered(x + k % 2, y + k / 2);
            unknown[index(k)] = index_.at(x + k % 2, y + k / 2);
            free[index(k)] = unknown[index(k)] >= 0;
            coveredCount += covered[index(k)] ? 1 : 0;
            freeCount += free[index(k)] ? 1 : 0;
        }
        if (coveredCount == 0 || freeCount == 0 || !mayHoldSurface(x, y)) return;
        std::array<glm::vec3, 4> dc;  // coefficient 0, or the exit radiance
        for (int k = 0; k < 4; ++k)
            dc[index(k)] = covered[index(k)] ? valueAt(0, x + k % 2, y + k / 2)
                           : isRatio         ? at(values_, static_cast<std::size_t>(unknown[index(k)]), 0)
                                             : glm::vec3(0);
        // [channel][unknown][corner]: corners are the lanes.
        using Products = std::array<std::array<std::array<float, 4>, 4>, kFilterChannels>;
        Products form{}, from{};
        for (int corner = 0; corner < 4; ++corner) {
            if (!covered[index(corner)]) continue;
            for (int place = 0; place < 4; ++place) {
                const float px = corner % 2 == 0 ? kPlaces[index(place % 2)] : 1 - kPlaces[index(place % 2)];
                const float py = corner / 2 == 0 ? kPlaces[index(place / 2)] : 1 - kPlaces[index(place / 2)];
                const std::array<float, 4> weights = {(1 - px) * (1 - py), px * (1 - py), (1 - px) * py, px * py};
                float sum = 0;
                glm::vec3 reference(0), filtered(0);
                for (std::size_t k = 0; k < 4; ++k) {
                    filtered += weights[k] * dc[k];
                    if (!covered[k]) continue;
                    sum += weights[k];
                    reference += weights[k] * dc[k];
                }
                const float exit = exitOf(reference / sum) + floor_;
                const glm::vec3 length = isRatio ? filtered : glm::vec3(1);
                const glm::vec3 slope = length / exit;
                std::array<std::array<float, 4>, kFilterChannels> wanted;  // the reference, less what is no unknown of the filtered light
                for (std::size_t k = 0; k < 4; ++k) {
                    const glm::vec3 own = (isRatio ? dc[k] : glm::vec3(1)) / sum - (free[k] ? glm::vec3(0) : length);
                    for (std::size_t c = 0; c < kFilterChannels; ++c) wanted[c][k] = own[static_cast<int>(c)];
                }
                for (std::size_t u = 0; u < 4; ++u) {
                    if (!free[u]) continue;
                    std::array<float, 4> share;
                    for (std::size_t k = 0; k < 4; ++k) share[k] = weights[u] * weights[k] / exit;
                    for (std::size_t c = 0; c < kFilterChannels; ++c) {
                        const float slopeOf = slope[static_cast<int>(c)], lengthOf = length[static_cast<int>(c)];
                        for (std::size_t k = 0; k < 4; ++k) {
                            const float both = share[k] * slopeOf;
                            from[c][u][k] += both * wanted[c][k];
                            form[c][u][k] += both * lengthOf;
                        }
                    }
                }
            }
        }
        const auto of = [](const Products& products, int u, int k) {
            return glm::vec3(products[0][index(u)][index(k)], products[1][index(u)][index(k)], products[2][index(u)][index(k)]);
        };
        std::array<Values, 4> values;
        for (int k = 0; k < 4; ++k)
            if (covered[index(k)]) values[index(k)] = valuesAt(first, end, x + k % 2, y + k / 2, isRatio);
        for (int u = 0; u < 4; ++u) {
            if (!free[index(u)]) continue;
            const auto to = static_cast<std::size_t>(unknown[index(u)]);
            unknowns_[to].isSeen = true;
            for (int k = 0; k < 4; ++k) {
                if (covered[index(k)])
                    addTimes(of(from, u, k), values[index(k)].data(), floatsOf(wanted_, to * count_ + first), end - first);
                if (!free[index(k)]) continue;
                const int step = 3 * (k / 2 - u / 2 + 1) + k % 2 - u % 2 + 1;
                unknowns_[to].row[index(step)] += of(form, u, k);
            }
        }
    }
    /// Adds values times a factor for each channel.
    static void addTimes(const glm::vec3& factor, const float* __restrict values, float* __restrict out, std::size_t count) {
        if (count == kFilterRatios / kFilterChannels) {
            const Ratios factors = repeated(factor);
            for (std::size_t j = 0; j < kFilterRatios; ++j) out[j] += factors[j] * values[j];
            return;
        }
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t c = 0; c < kFilterChannels; ++c)
                out[kFilterChannels * i + c] += factor[static_cast<int>(c)] * values[kFilterChannels * i + c];
    }
    float exitOf(const glm::vec3& v) const { return rows::exitOf(family_, v); }

    /// Solves for one unknown with the current values of its neighbours, and clamps it to the range of the layout.
    void update(std::size_t u, std::size_t first, std::size_t end, bool isRatio) {
        const Unknown& unknown = unknowns_[u];
        const glm::vec3 diagonal = unknown.row[4];
        std::array<glm::vec3, lighting::kShCount> rest;
        for (std::size_t i = first; i < end; ++i) rest[i] = at(wanted_, u, i) + kRegularization * diagonal * at(start_, u, i);
        for (int step = 0; step < 9; ++step) {
            const glm::vec3& factor = unknown.row[index(step)];
            if (step == 4 || factor == glm::vec3(0)) continue;
            const auto neighbour = static_cast<std::size_t>(index_.at(unknown.x + step % 3 - 1, unknown.y + step / 3 - 1));
            // a - f b is a + (-f) b, to the bit.
            addTimes(-factor, floatsOf(values_, neighbour * count_ + first), &rest[first].x, end - first);
        }
        for (std::size_t i = first; i < end; ++i)
            for (int c = 0; c < 3; ++c) {
                if (!(diagonal[c] > 0)) continue;
                float value = rest[i][c] / ((1 + kRegularization) * diagonal[c]);
                const float dc = isRatio ? 1 : at(values_, u, 0)[c];
                if (i > 0) {
                    if (!hasFreeValues_) value = std::clamp(value, ranges_[i].low * dc, ranges_[i].high * dc);
                } else if (!hasFreeValues_) {
                    value = std::max(value, kLeastShare * at(start_, u, 0)[c]);
                }
                at(values_, u, i)[c] = value;
            }
    }

    void store() {
        for (std::size_t u = 0; u < unknowns_.size(); ++u) {
            const int x = unknowns_[u].x, y = unknowns_[u].y + top_ - sourceRow_;
            if (y < 0 || y >= source_.height || !unknowns_[u].isSeen) continue;
            for (std::size_t i = 0; i < count_; ++i)
                source_.values[i].at(x, y) = at(values_, u, i) * (dividesByFirst_ && i > 0 ? at(values_, u, 0) : glm::vec3(1));
            if (unknowns_[u].isCovered) continue;
            source_.coverage.at(x, y) = dividesByFirst_ ? kDividedCoverage : kSolvedCoverage;
            weigh(plan_, source_, x, y);
        }
    }

    static std::size_t index(int i) { return static_cast<std::size_t>(i); }

    const LightMapPlan& plan_;
    const formats::LightMapStrip& strip_;
    Source& source_;
    int sourceRow_;           ///< first row of the source in the strip
    int top_ = 0, rows_ = 0;  ///< first row and number of rows of the strip that are read; the y of all members count from top_
    LightMapFamily family_;
    std::size_t count_;    ///< of values: coefficients, or 1
    bool hasFreeValues_;   ///< coefficients have no range
    bool fitsCovered_;     ///< ratios of covered texels are fitted, too
    bool dividesByFirst_;  ///< the layout filters coefficient 0 and ratios to it
    float floor_;
    Image<int> index_;  ///< of the unknown; -1
    std::vector<Unknown> unknowns_;
    std::vector<RatioRange> ranges_;
    Ratios lows_{}, highs_{};                         ///< ranges_ of the ratios
    std::vector<glm::vec3> values_, start_, wanted_;  ///< [unknown][value]
};

}  // namespace

void fitToFilter(const LightMapPlan& plan, const formats::LightMapStrip& strip, int firstRow, Source& source) {
    FilterFit(plan, strip, firstRow, source).solve();
}

}  // namespace lightcook::compress::rows
