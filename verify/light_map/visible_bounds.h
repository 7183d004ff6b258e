// Upper bounds of the visible error everywhere on a map, rims of charts included. Private to verify/.
//
// Each covered texel has a quarter of each of the four quads around it: the places nearest to it. A surface there has a normal within the
// scene's tilt of the texel's own, or, for specular light, the texel's own normal and any view, m and F0. The bound of a map is the maximum
// over these quarters:
//   1. quick coarse bound of every quad: band lengths of the error (quad_coarse_bound.h), against the darkest reference over all kernels
//      (CoarseKernels), or in any light (visible_any_light.h); quads that may exceed what was sampled are kept
//   2. what has the largest bound is refined: a quad of a plane on a coarse grid of kernels (visible_grid.h), a quad to its quarters with
//      coarse bounds of their own, a quarter on the coarse grid and on a fine one, and then by a short and a long search
//      (visible_search.h), the last of which raises the maximum; until none may raise it
// The work on a strip has a budget, so that time is bounded whatever the light: under even light all quarters are alike, and nearly all
// would be searched to the end. When it is spent, the largest bound that is left is that of all. Looser, but proven.
// Whatever is not searched to the end is proven to be below the maximum of its strip, and a map is always cut into the same strips. Ties
// go to the smaller (y, x), except at the largest difference of the display, which ends the search.
#pragma once

#include <algorithm>
#include <cassert>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>
#include <vector>

#include "lighting/sphere.h"
#include "verify/light_map/place_light.h"
#include "verify/light_map/quad_coarse_bound.h"
#include "verify/light_map/visible_bound_setup.h"

namespace lightcook::verify::lightmap {

enum class ShadingKind { Diffuse, Specular };
inline constexpr std::array kShadingKinds = {ShadingKind::Diffuse, ShadingKind::Specular};

/// A value for each kind of shading.
template <class T>
struct PerKind {
    std::array<T, kShadingKinds.size()> values;
    T& operator[](ShadingKind kind) { return values[static_cast<std::size_t>(kind)]; }
    const T& operator[](ShadingKind kind) const { return values[static_cast<std::size_t>(kind)]; }
};

/// One kind of shading of a map: its kernels, the balls that cover them, and the largest bound so far.
class VisibleKind {
public:
    VisibleKind(const VisibleMetric& metric, const AnyLightBound& anyLight, const VisibleKernels& kernels, double sampled)
        : metric_(metric),
          anyLight_(anyLight),
          kernels_(kernels),
          search_(metric, kernels.tree),
          grid_(metric, anyLight, kernels.grids),
          threshold_(sampled),
          shaded_(kernels.centres.stride()) {}
    bool isNone() const { return kernels_.isNone(); }
    const VisibleMaximum& largest() const { return largest_; }
    double threshold() const { return threshold_; }

    /// Returns the darkest light of all kernels, by channel.
    glm::dvec3 lowest(const Channels& local, const BandLengths& lengths) {
        glm::dvec3 out(0);
        for (std::size_t c = 0; c < kChannels; ++c) {
            kernels_.centres.apply(local[c], shaded_.data());
            const float first = lengths[c], second = lengths[3 + c], third = lengths[6 + c];
            const float *zonal = kernels_.radii[0].data(), *linear = kernels_.radii[1].data(), *quadratic = kernels_.radii[2].data();
            // Each lane has its own minimum: the compiler keeps the order of one.
            std::array<float, ShadingMatrix::kLanes> lows;
            lows.fill(std::numeric_limits<float>::max());
            for (std::size_t k = 0; k < shaded_.size(); k += lows.size())
                for (std::size_t lane = 0; lane < lows.size(); ++lane) {
                    const float darkest =
                        shaded_[k + lane] - zonal[k + lane] * first - linear[k + lane] * second - quadratic[k + lane] * third;
                    lows[lane] = darkest < lows[lane] ? darkest : lows[lane];
                }
            const float low = std::ranges::min(lows);
            out[static_cast<int>(c)] = static_cast<double>(low);
        }
        return out;
    }
    /// Returns lower bounds, by channel, of the shaded reference, for all references whose bands differ by at most `step` from one with the
    /// lower bounds `darkest`.
    glm::dvec3 lowered(const glm::dvec3& darkest, const BandLengths& step) const {
        glm::dvec3 low = darkest;
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t l = 0; l < 3; ++l) low[static_cast<int>(c)] -= kernels_.lengths[l] * static_cast<double>(step[3 * l + c]);
        return low;
    }
    /// Returns a bound from the lengths of the error, for references with these darkest channels, rounded up; 0 where less work proves that
    /// it is below the threshold.
    float coarseBoundIfAbove(const glm::dvec3& low, const BandLengths& error) const {
        if (isNone()) return 0;
        const glm::dvec3 off = errorOf(error);
        if (metric_.cannotExceedCheaply(low, off, threshold_)) return 0;
        const double coarse = metric_.coarseBound(low, off);
        if (coarse < threshold_) return 0;
        // Specular light is that of a kernel times a number that may be 0.
        const glm::dvec3 darkest = kernels_.tree.isSpecular() ? glm::dvec3(0) : low - off;
        Intervals errors;
        for (std::size_t c = 0; c < kChannels; ++c) errors[c] = Interval::around(0, off[static_cast<int>(c)]);
        const double any = anyLight_.bound(std::min({darkest.x, darkest.y, darkest.z}), errors);
        const float bound = kOutwardFloat * static_cast<float>(std::min(any, coarse));
        return static_cast<double>(bound) < threshold_ ? 0 : bound;
    }
    /// Returns true if an upper bound is below the threshold.
    bool cannotExceed(float bound) const { return isNone() || static_cast<double>(bound) < threshold_; }
    /// Returns a bound of this light on a grid of kernels; 0 if it is not above the threshold.
    double gridBound(const CellLight& light, bool isFine) {
        const double bound = grid_.bound(light, threshold_, isFine);
        budget_.spend(grid_.work());
        return bound > threshold_ ? bound : 0;
    }
    /// Searches a quarter.
    VisibleMaximum bound(const PlaceRectangle& whole, const LightOver& lightOver, int effort) {
        // After the last search its own place is reported, with the bound of all others.
        return search_.bound(whole, lightOver, budget_.isSpent() ? 0 : threshold_, budget_, effort);
    }
    void setBudget(const SearchBudget& budget) { budget_ = budget; }
    bool isBudgetSpent() const { return budget_.isSpent(); }
    void spend(double work) { budget_.spend(work); }
    void raise(const VisibleMaximum& found) {
        // Nothing but light that is not finite, whose samples are beyond all limits, differs by more than any two lights.
        if (const double most = metric_.mostVisible(); found.bound >= most - kVisibleRounding && found.bound <= most) {
            largest_ = found;
            largest_.bound = most;
            threshold_ = std::numeric_limits<double>::max();
            return;
        }
        const auto order = [](const VisiblePlace& place) { return std::tuple(place.y, place.x); };
        if (found.bound < threshold_ || found.bound < largest_.bound) return;
        if (found.bound == largest_.bound && !(order(found.place) < order(largest_.place))) return;
        largest_ = found;
        threshold_ = std::max(threshold_, std::nextafter(found.bound, 0.0));
    }

private:
    /// Returns the largest error of each channel over all kernels.
    glm::dvec3 errorOf(const BandLengths& error) const {
        glm::dvec3 off(0);
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t l = 0; l < 3; ++l) off[static_cast<int>(c)] += kernels_.lengths[l] * static_cast<double>(error[3 * l + c]);
        return off;
    }

    const VisibleMetric& metric_;
    const AnyLightBound& anyLight_;
    const VisibleKernels& kernels_;
    VisibleSearch search_;
    GridBound grid_;
    SearchBudget budget_{0};
    double threshold_;  ///< bounds below it cannot be the maximum
    VisibleMaximum largest_;
    std::vector<float> shaded_;
};

/// Bounds over the quads of some rows.
class VisibleBounds {
public:
    /// sampledDiffuse, sampledSpecular  visible errors that were found in these rows: the bounds are at least as large
    VisibleBounds(const MapRows& rows, const SamplerTolerance& tolerance, const BoundEvaluator& evaluator, const VisibleBoundSetup& setup,
                  double sampledDiffuse, double sampledSpecular)
        : rows_(rows),
          tolerance_(tolerance),
          coarse_(rows, tolerance, evaluator),
          kinds_{{VisibleKind(setup.metric, *setup.anyLight, setup.diffuse, sampledDiffuse),
                  VisibleKind(setup.metric, *setup.anyLight, setup.specular, sampledSpecular)}} {}

    /// Bounds the quads that begin in these rows and columns, and those that reach over the edges of the map there.
    void boundArea(const TexelArea& area) {
        Measured above, below;
        for (const ShadingKind kind : kShadingKinds)
            kinds_[kind].setBudget(SearchBudget(kWorkOfArea + kWorkPerTexel * static_cast<double>(area.width) * area.height));
        const int first = area.y == 0 ? -1 : area.y, last = std::min(area.y + area.height, rows_.height()) - 1;
        const int firstX = area.x == 0 ? -1 : area.x, lastX = std::min(area.x + area.width, rows_.width()) - 1;
        for (int y = first; y <= last; ++y) {
            if (y == first) load(std::max(y, 0), above);
            load(std::min(y + 1, rows_.height() - 1), below);
            for (int x = firstX; x <= lastX; ++x)
                if (x == firstX || tolerance_.isOfBlocks() || !rows_.repeatsLeft(above.row, below.row, x)) boundQuad(above, below, x, y);
            std::swap(above, below);
        }
        for (const ShadingKind kind : kShadingKinds) search(kind);
    }
    const VisibleMaximum& diffuse() const { return kinds_[ShadingKind::Diffuse].largest(); }
    const VisibleMaximum& specular() const { return kinds_[ShadingKind::Specular].largest(); }

private:
    /// Work of the searches of each kind of shading, for an area and for each of its texels [cells]. docs/lab/verify.md, "What does
    /// verification cost", has the figures.
    static constexpr double kWorkOfArea = 40000, kWorkPerTexel = 4, kWorkOfQuad = 4;
    static constexpr int kLongSearch = 8;  ///< cells of a second search, relative to the first

    /// A row with what its coarse bounds need.
    struct Measured {
        MapRows::Row row;
        std::vector<TexelLengths> lengths;
        std::vector<PerKind<glm::dvec3>> lowest;  ///< [texel]
    };
    using KindBounds = PerKind<float>;  ///< rounded up
    struct KeptQuad {
        int x, y;
        KindBounds bound;
    };
    struct Quarter {
        int x, y;
        std::int8_t corner, decode;
        float bound;  ///< of one kind
    };
    /// Inputs of the coarse bounds of a quad.
    struct MeasuredQuad {
        CornerLengths lengths;
        std::array<PerKind<glm::dvec3>, 4> low{};  ///< [corner], darkest references of its quarter
        PerKind<glm::dvec3> darkest{};             ///< of all quarters
    };

    void load(int y, Measured& out) {
        rows_.load(0, rows_.width(), y, out.row);
        out.lengths.resize(index(rows_.width()));
        out.lowest.resize(index(rows_.width()));
        for (int x = 0; x < rows_.width(); ++x) {
            const std::size_t i = index(x);
            if (out.row.covered[i] == 0) continue;
            if (out.row.repeats[i] != 0) {
                out.lengths[i] = out.lengths[i - 1];
                out.lowest[i] = out.lowest[i - 1];
            } else {
                measure(out.row.texelsAt(i), out.row.reference[i], x, y, out.lengths[i], out.lowest[i]);
            }
        }
    }
    /// Measures a covered texel.
    void measure(LayerTexels texels, const LcSh& reference, int x, int y, TexelLengths& lengths, PerKind<glm::dvec3>& lowest) {
        const glm::vec3& normal = rows_.normalAt(x, y);
        if (normal != normal_) {
            const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(normal));
            frame_ = {glm::vec3(frame[0]), glm::vec3(frame[1]), glm::vec3(frame[2])};
            normal_ = normal;
        }
        if (coarse_.isKnown())
            lengths = coarse_.lengthsOf(texels, reference, x, y);
        else
            lengths.reference = bandLengths(reference);
        const Channels local = channelsOf(shaders::lcLocalSh(reference, frame_[0], frame_[1], frame_[2]));
        for (const ShadingKind kind : kShadingKinds)
            lowest[kind] = kinds_[kind].isNone() ? glm::dvec3(0) : kinds_[kind].lowest(local, lengths.reference);
    }
    MeasuredQuad measuredQuad(const CoveredQuad& quad, const std::array<const TexelLengths*, 4>& lengths,
                              const std::array<const PerKind<glm::dvec3>*, 4>& lowest) const {
        MeasuredQuad out{{lengths, {}}};
        // Differences of the references of covered corners: of each corner from the others.
        std::array<std::array<BandLengths, 4>, 4> steps{};
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = i + 1; j < 4; ++j) {
                if (!quad.covered[i] || !quad.covered[j]) continue;
                steps[i][j] = steps[j][i] = bandLengths(difference(*quad.corners.references[i], *quad.corners.references[j]));
                QuadCoarseBound::raise(out.lengths.step, steps[i][j]);
            }
        out.darkest.values.fill(glm::dvec3(std::numeric_limits<double>::max()));
        for (int corner = 0; corner < 4; ++corner) {
            if (!quad.hasQuarter(corner)) continue;
            const BandLengths off = farthest(steps[index(corner)], corner, quad.coveredCount());
            for (const ShadingKind kind : kShadingKinds) {
                out.low[index(corner)][kind] = kinds_[kind].lowered((*lowest[index(corner)])[kind], off);
                out.darkest[kind] = glm::min(out.darkest[kind], out.low[index(corner)][kind]);
            }
        }
        return out;
    }
    /// Keeps a quad whose coarse bound exceeds the largest error known so far.
    void boundQuad(const Measured& above, const Measured& below, int x, int y) {
        const CoveredQuad quad(rows_, above.row, below.row, x, y);
        if (quad.coveredCount() == 0) return;
        constexpr float kInfinite = std::numeric_limits<float>::infinity();
        if (!coarse_.isKnown()) {
            quads_.push_back({x, y, {kInfinite, kInfinite}});
            return;
        }
        std::array<const TexelLengths*, 4> lengths;
        std::array<const PerKind<glm::dvec3>*, 4> lowest;
        for (int corner = 0; corner < 4; ++corner) {
            const Measured& row = corner < 2 ? above : below;
            lengths[index(corner)] = &row.lengths[index(quad.texelX(corner))];
            lowest[index(corner)] = &row.lowest[index(quad.texelX(corner))];
        }
        const MeasuredQuad measured = measuredQuad(quad, lengths, lowest);
        KeptQuad kept{x, y, {}};
        bool isKept = false;
        for (int decode = 0; decode < 4; ++decode) {
            if (!quad.isNewDecode(rows_, decode)) continue;
            KindBounds bounds{};
            for (const bool isQuick : {true, false}) {
                const BandLengths error = coarse_.errorLengths(quad, measured.lengths, decode, isQuick);
                bool isAbove = false;
                for (const ShadingKind kind : kShadingKinds) {
                    bounds[kind] = kinds_[kind].coarseBoundIfAbove(measured.darkest[kind], error);
                    isAbove = isAbove || !kinds_[kind].cannotExceed(bounds[kind]);
                }
                if (!isAbove) break;
            }
            for (const ShadingKind kind : kShadingKinds) {
                // NaN, of which nothing is known, is above all.
                if (!(bounds[kind] <= kept.bound[kind])) kept.bound[kind] = bounds[kind] <= kInfinite ? bounds[kind] : kInfinite;
                isKept = isKept || !kinds_[kind].cannotExceed(bounds[kind]);
            }
        }
        if (isKept) quads_.push_back(kept);
    }
    /// Calls work(quad, what its coarse bounds need) for a quad.
    template <class Work>
    void withMeasuredQuad(int x, int y, Work&& work) {
        withCoveredQuad(rows_, x, y, [&](const CoveredQuad& quad) {
            std::array<TexelLengths, 4> lengths{};
            std::array<PerKind<glm::dvec3>, 4> lowest{};
            std::array<const TexelLengths*, 4> lengthsAt;
            std::array<const PerKind<glm::dvec3>*, 4> lowestAt;
            for (int corner = 0; corner < 4; ++corner) {
                const std::size_t i = index(corner);
                lengthsAt[i] = &lengths[i];
                lowestAt[i] = &lowest[i];
                if (quad.covered[i])
                    measure(quad.corners.texels[i], *quad.corners.references[i], quad.texelX(corner), quad.texelY(corner), lengths[i],
                            lowest[i]);
            }
            work(quad, measuredQuad(quad, lengthsAt, lowestAt));
        });
    }
    /// Appends to quarters_ those of a quad whose coarse bounds exceed the largest error known so far.
    void addQuartersOf(ShadingKind kind, const KeptQuad& kept) {
        withMeasuredQuad(kept.x, kept.y, [&](const CoveredQuad& quad, const MeasuredQuad& measured) {
            for (int decode = 0; decode < 4; ++decode) {
                if (!quad.isNewDecode(rows_, decode)) continue;
                BandLengths error{};
                if (coarse_.isKnown()) error = coarse_.errorLengths(quad, measured.lengths, decode, false);
                for (int corner = 0; corner < 4; ++corner) {
                    if (!quad.hasQuarter(corner)) continue;
                    // The surface nearest to a texel has its frame.
                    if (rows_.decoder().isInTangentSpace() && !rows_.hasSameDecode(quad.x, quad.y, corner, decode)) continue;
                    assert(coarse_.isKnown() || !rows_.decoder().isInTangentSpace());
                    if (!coarse_.isKnown()) error = lightOf(quad, corner, decode).errorLengths();
                    const float bound = kinds_[kind].coarseBoundIfAbove(measured.low[index(corner)][kind], error);
                    if (!kinds_[kind].cannotExceed(bound))
                        quarters_.push_back({quad.x, quad.y, static_cast<std::int8_t>(corner), static_cast<std::int8_t>(decode), bound});
                }
            }
        });
    }
    /// Returns the bound of a quarter.
    VisibleMaximum boundOf(ShadingKind kind, const Quarter& quarter, int effort) {
        VisibleMaximum out;
        withCoveredQuad(rows_, quarter.x, quarter.y, [&](const CoveredQuad& quad) {
            const glm::dmat3 frame = frameOf(quad, quarter.corner);
            const QuarterLight light = lightOf(quad, quarter.corner, quarter.decode);
            out = kinds_[kind].bound(
                light.whole(), [&](const PlaceRectangle& place) { return light.over(place); }, effort);
            VisiblePlace& place = out.place;
            const glm::dvec2 inMap = quad.inMap({place.x, place.y});
            place.x = inMap.x;
            place.y = inMap.y;
            place.normal = frame * place.normal;
            place.view = frame * place.view;
            const auto unit = 1 / static_cast<double>(rows_.perKey());
            place.reference *= unit;
            place.found *= unit;
        });
        return out;
    }

    /// Returns how far the reference of a quarter is from that of its texel. At the corners of the quarter it is the mean of the texel and
    /// one neighbour, or of all covered corners; elsewhere it lies between those.
    /// steps  differences from the texel, 0 for corners that are not covered
    static BandLengths farthest(const std::array<BandLengths, 4>& steps, int corner, int coveredCount) {
        const BandLengths &across = steps[index(corner ^ 1)], &down = steps[index(corner ^ 2)], &diagonal = steps[index(corner ^ 3)];
        BandLengths out{};
        const float share = kOutwardFloat / static_cast<float>(coveredCount);
        for (std::size_t lane = 0; lane < kBandLanes; ++lane)
            out[lane] = std::max({0.5f * kOutwardFloat * across[lane], 0.5f * kOutwardFloat * down[lane],
                                  share * (across[lane] + down[lane] + diagonal[lane])});
        return out;
    }
    /// Returns the tangent frame of a corner's texel.
    glm::dmat3 frameOf(const CoveredQuad& quad, int corner) const { return rows_.frameAt(quad.texelX(corner), quad.texelY(corner)); }
    QuarterLight lightOf(const CoveredQuad& quad, int corner, int decode) const {
        const glm::dmat3 frame = frameOf(quad, corner);
        return {rows_, tolerance_, quad, corner, decode, {glm::vec3(frame[0]), glm::vec3(frame[1]), glm::vec3(frame[2])}};
    }
    /// Searches quads and their quarters, those with the largest bound first.
    void search(ShadingKind kind) {
        if (kinds_[kind].isNone()) return;
        VisibleKind& of = kinds_[kind];
        enum class Stage { Quad, Whole, OnCoarseGrid, OnFineGrid, Searched };
        struct Entry {
            float bound;
            Stage stage;
            std::size_t at;  ///< in quads_, or in quarters_
            bool operator<(const Entry& other) const {
                return std::tuple(bound, other.stage, other.at) < std::tuple(other.bound, stage, at);
            }
        };
        std::priority_queue<Entry> queue;
        const auto push = [&](const Entry& entry) {
            if (!of.cannotExceed(entry.bound)) queue.push(entry);
        };
        quarters_.clear();
        for (std::size_t i = 0; i < quads_.size(); ++i) push({quads_[i].bound[kind], Stage::Quad, i});
        while (!queue.empty() && !of.cannotExceed(queue.top().bound)) {
            const Entry top = queue.top();
            queue.pop();
            const bool isLast = of.isBudgetSpent();
            if (top.stage == Stage::Quad) {
                const KeptQuad& quad = quads_[top.at];
                const float bound = std::min(top.bound, boundOfPlane(kind, quad));
                of.spend(kWorkOfQuad);
                if (of.cannotExceed(bound)) continue;
                const std::size_t first = quarters_.size();
                addQuartersOf(kind, quad);
                for (std::size_t i = first; i < quarters_.size(); ++i) push({std::min(bound, quarters_[i].bound), Stage::Whole, i});
                continue;
            }
            const Quarter& quarter = quarters_[top.at];
            const auto lower = [&](double bound, Stage stage) {
                push({std::min(top.bound, kOutwardFloat * static_cast<float>(bound)), stage, top.at});
            };
            if (isLast || top.stage >= Stage::OnFineGrid) {
                const bool isLong = isLast || top.stage == Stage::Searched;
                VisibleMaximum found = boundOf(kind, quarter, isLong ? kLongSearch : 1);
                // No other quad or quarter has a larger bound.
                found.bound = isLast ? static_cast<double>(top.bound) : std::min(found.bound, static_cast<double>(top.bound));
                if (isLong || found.isFinal)
                    of.raise(found);
                else
                    lower(found.bound, Stage::Searched);
                if (isLast) break;
            } else if (top.stage == Stage::Whole) {
                lower(gridBoundOf(kind, quarter, false), Stage::OnCoarseGrid);
            } else {
                lower(gridBoundOf(kind, quarter, true), Stage::OnFineGrid);
            }
        }
    }
    /// Returns a bound of a quad all of whose quarters have one frame, under the kernels of the coarse grid; infinite for others. Most
    /// quads are of a plane, and few of these need their quarters.
    float boundOfPlane(ShadingKind kind, const KeptQuad& kept) {
        float out = std::numeric_limits<float>::infinity();
        withCoveredQuad(rows_, kept.x, kept.y, [&](const CoveredQuad& quad) {
            const auto hasFrameOfFirst = [&](int corner) {
                return rows_.normalAt(quad.texelX(corner), quad.texelY(corner)) == rows_.normalAt(quad.texelX(0), quad.texelY(0));
            };
            if (rows_.decoder().isInTangentSpace() || !quad.isInside() || !std::ranges::all_of(std::array{1, 2, 3}, hasFrameOfFirst))
                return;
            double largest = 0;
            for (int decode = 0; decode < 4; ++decode)
                if (quad.isNewDecode(rows_, decode))
                    largest = std::max(largest, kinds_[kind].gridBound(lightOf(quad, 0, decode).over(PlaceRectangle{}), false));
            out = kOutwardFloat * static_cast<float>(largest);
        });
        return out;
    }
    /// Returns a bound of a quarter under the kernels of the grids.
    double gridBoundOf(ShadingKind kind, const Quarter& quarter, bool isFine) {
        double out = 0;
        withCoveredQuad(rows_, quarter.x, quarter.y, [&](const CoveredQuad& quad) {
            const QuarterLight light = lightOf(quad, quarter.corner, quarter.decode);
            out = kinds_[kind].gridBound(light.over(light.whole()), isFine);
        });
        return out;
    }

    const MapRows& rows_;
    const SamplerTolerance& tolerance_;
    QuadCoarseBound coarse_;
    PerKind<VisibleKind> kinds_;
    std::vector<KeptQuad> quads_;
    std::vector<Quarter> quarters_;
    glm::vec3 normal_{0};
    std::array<glm::vec3, 3> frame_{};
};

}  // namespace lightcook::verify::lightmap
