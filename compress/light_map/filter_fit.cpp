#include "compress/light_map/filter_fit.h"

#include <algorithm>
#include <cmath>
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
          fitsCovered_(formats::info(plan.layout).hasObjective() && plan.objective),
          dividesByFirst_(family_ != LightMapFamily::Raw && family_ != LightMapFamily::Flat && family_ != LightMapFamily::Hdr),
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
        for (int y = 0; y + 1 < rows_; ++y)
            for (int x = 0; x + 1 < plan_.width; ++x)
                if (mayHoldSurface(x, y) && isEdge(x, y))
                    forEachCorner(x, y, [&](int cornerX, int cornerY) { addCovered(cornerX, cornerY); });
    }
    bool isEdge(int x, int y) const {
        float low = std::numeric_limits<float>::infinity(), high = 0;
        forEachCorner(x, y, [&](int cornerX, int cornerY) {
            const glm::vec3 dc = valueAt(0, cornerX, cornerY, false);
            const float light = std::max({dc.x, dc.y, dc.z, 0.0f});
            low = std::min(low, light);
            high = std::max(high, light);
        });
        if (!(high > low)) return false;
        const float least = kEdge * (high + low) / (high - low);
        for (std::size_t i = 1; i < count_; ++i) {
            glm::vec3 smallest(std::numeric_limits<float>::infinity()), largest(-std::numeric_limits<float>::infinity());
            forEachCorner(x, y, [&](int cornerX, int cornerY) {
                const glm::vec3 ratio = valueAt(i, cornerX, cornerY, true);
                smallest = glm::min(smallest, ratio);
                largest = glm::max(largest, ratio);
            });
            const glm::vec3 spread = largest - smallest;
            if (std::max({spread.x, spread.y, spread.z}) > least) return true;
        }
        return false;
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
        at(values_, unknowns_.size() - 1, 0) = valueAt(0, x, y, false);
    }
    void setRanges() {
        ranges_.assign(count_, {});
        for (std::size_t i = 1; i < count_; ++i) {
            if (family_ == LightMapFamily::Ratio) {
                const float bias = constant(plan_, "bias", i - 1);
                ranges_[i] = {bias, bias + constant(plan_, "scale", i - 1)};
            } else if (family_ == LightMapFamily::Hdr) {
                ranges_[i].low = constant(plan_, "bias", i - 1);
            } else if (family_ != LightMapFamily::Raw) {
                const float largest = 1.25f * std::sqrt(2.0f * static_cast<float>(lighting::kShBand[i]) + 1);
                ranges_[i] = {-largest, largest};
            }
        }
    }

    /// Returns value i of a covered texel: a coefficient, or its ratio to coefficient 0.
    glm::vec3 valueAt(std::size_t i, int x, int y, bool isRatio) const {
        const lighting::ShRgb& sh = strip_.sh.at(x, top_ + y);
        if (family_ == LightMapFamily::Flat)
            return lighting::evaluate(lighting::convolve(sh, lighting::kExitRadianceBands), strip_.normal.at(x, top_ + y));
        if (!isRatio) return sh[i];
        glm::vec3 ratio(0);
        for (int c = 0; c < 3; ++c)
            if (sh[0][c] > 0) ratio[c] = std::clamp(sh[i][c] / sh[0][c], ranges_[i].low, ranges_[i].high);
        return ratio;
    }
    glm::vec3& at(std::vector<glm::vec3>& all, std::size_t unknown, std::size_t i) const { return all[unknown * count_ + i]; }

    /// Sets values [first, end) of the unknowns to their own or to the means of their covered neighbours, then solves them.
    void solveValues(std::size_t first, std::size_t end, bool isRatio) {
        if (values_.empty()) values_.resize(unknowns_.size() * count_);
        start_.assign(unknowns_.size() * count_, glm::vec3(0));
        for (std::size_t u = 0; u < unknowns_.size(); ++u) {
            unknowns_[u].row.fill(glm::vec3(0));
            if (unknowns_[u].isCovered) {
                for (std::size_t i = first; i < end; ++i)
                    at(values_, u, i) = at(start_, u, i) = valueAt(i, unknowns_[u].x, unknowns_[u].y, isRatio);
                continue;
            }
            const int count =
                formats::visitNearestCovered(strip_.covered.view(), unknowns_[u].x, top_ + unknowns_[u].y, 1, [&](int x, int y) {
                    for (std::size_t i = first; i < end; ++i) at(start_, u, i) += valueAt(i, x, y - top_, isRatio);
                });
            for (std::size_t i = first; i < end; ++i) at(values_, u, i) = at(start_, u, i) /= static_cast<float>(count);
        }
        wanted_.assign(unknowns_.size() * count_, glm::vec3(0));
        for (int y = 0; y + 1 < rows_; ++y)
            for (int x = 0; x + 1 < plan_.width; ++x) addQuad(x, y, first, end, isRatio);
        if (isRatio) addCentres(first, end);
        for (int sweep = 0; sweep < (dividesByFirst_ ? kSweepsOfProducts : kSweeps); ++sweep)
            for (int colour = 0; colour < 4; ++colour)
                for (std::size_t u = 0; u < unknowns_.size(); ++u)
                    if (unknowns_[u].x % 2 == colour % 2 && (strip_.firstRow + top_ + unknowns_[u].y) % 2 == colour / 2)
                        update(u, first, end, isRatio);
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
            dc[index(k)] = covered[index(k)] ? valueAt(0, x + k % 2, y + k / 2, false)
                           : isRatio         ? at(values_, static_cast<std::size_t>(unknown[index(k)]), 0)
                                             : glm::vec3(0);
        std::array<std::array<glm::vec3, 4>, 4> form{}, from{};
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
                for (std::size_t u = 0; u < 4; ++u) {
                    if (!free[u]) continue;
                    for (std::size_t k = 0; k < 4; ++k) {
                        const glm::vec3 both = weights[u] * weights[k] / exit * slope;
                        if (covered[k]) from[u][k] += both * ((isRatio ? dc[k] : glm::vec3(1)) / sum - (free[k] ? glm::vec3(0) : length));
                        if (free[k]) form[u][k] += both * length;
                    }
                }
            }
        }
        for (int u = 0; u < 4; ++u) {
            if (!free[index(u)]) continue;
            const auto to = static_cast<std::size_t>(unknown[index(u)]);
            unknowns_[to].isSeen = true;
            for (int k = 0; k < 4; ++k) {
                if (covered[index(k)])
                    for (std::size_t i = first; i < end; ++i)
                        at(wanted_, to, i) += from[index(u)][index(k)] * valueAt(i, x + k % 2, y + k / 2, isRatio);
                if (!free[index(k)]) continue;
                const int step = 3 * (k / 2 - u / 2 + 1) + k % 2 - u % 2 + 1;
                unknowns_[to].row[index(step)] += form[index(u)][index(k)];
            }
        }
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
            for (std::size_t i = first; i < end; ++i) rest[i] -= factor * at(values_, neighbour, i);
        }
        for (std::size_t i = first; i < end; ++i)
            for (int c = 0; c < 3; ++c) {
                if (!(diagonal[c] > 0)) continue;
                float value = rest[i][c] / ((1 + kRegularization) * diagonal[c]);
                const float dc = isRatio ? 1 : at(values_, u, 0)[c];
                if (i > 0) {
                    if (family_ != LightMapFamily::Raw) value = std::clamp(value, ranges_[i].low * dc, ranges_[i].high * dc);
                } else if (family_ != LightMapFamily::Raw) {
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
    bool fitsCovered_;     ///< ratios of covered texels are fitted, too
    bool dividesByFirst_;  ///< the layout filters coefficient 0 and ratios to it
    float floor_;
    Image<int> index_;  ///< of the unknown; -1
    std::vector<Unknown> unknowns_;
    std::vector<RatioRange> ranges_;
    std::vector<glm::vec3> values_, start_, wanted_;  ///< [unknown][value]
};

}  // namespace

void fitToFilter(const LightMapPlan& plan, const formats::LightMapStrip& strip, int firstRow, Source& source) {
    FilterFit(plan, strip, firstRow, source).solve();
}

}  // namespace lightcook::compress::rows
