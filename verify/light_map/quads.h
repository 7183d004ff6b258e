// Bounds of everything between four texels. Private to verify/.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <span>
#include <variant>
#include <vector>

#include "verify/light_map/controls.h"
#include "verify/light_map/quad_coarse_bound.h"
#include "verify/light_map/tolerance.h"
#include "verify/light_map/zonal.h"

namespace lightcook::verify::lightmap {

/// The worst quads of some rows, found with few close looks: most quads are settled at a glance by the worst so far, what is left is put
/// down and looked at later, the worst first.
template <class Layout>
class QuadBounds {
public:
    using LayerTexels = typename MapRows<Layout>::LayerTexels;
    using QuadTexels = typename MapRows<Layout>::QuadTexels;
    using QuadReferences = typename MapRows<Layout>::QuadReferences;
    using Corners = typename MapRows<Layout>::Corners;

    QuadBounds(const MapRows<Layout>& rows, const Liberties<Layout>& liberties, const BoundJudge& judge)
        : rows_(rows), liberties_(liberties), judge_(judge), zonal_(zonalOf(rows, liberties, judge)) {}
    const Worst& worst() const { return worst_; }

    /// Takes the quad at (x, y) into the worst so far.
    void look(int x, int y) {
        rows_.withQuad(x, y, [&](const Corners& corners) { bound(corners.texels, corners.references, x, y, false); });
    }
    /// Every quad that begins in these rows, at a glance; what that does not settle is put down.
    void glance(int firstRow, int rowCount) {
        const QuadGlance<Layout> glances(rows_, liberties_, judge_);
        std::vector<TexelLengths> upper, lower;
        rows_.forEachPairOfRows(firstRow, rowCount, [&](const auto& above, const auto& below, int y) {
            if (y == firstRow) glances.measure(above, y, upper);
            glances.measure(below, y + 1, lower);
            for (int x = 0; x + 1 < rows_.width(); ++x) {
                if (!rows_.isQuad(above, below, x)) continue;
                const Corners corners = rows_.cornersOf(above, below, x);
                if (!glances.isKnown()) {
                    bound(corners.texels, corners.references, x, y, true);
                    continue;
                }
                const auto seen = glances.look(worst_, corners, {&upper[index(x)], &lower[index(x)]}, x, y);
                if (!judge_.isCertainlyWithin(worst_, seen.most)) glanced_.push_back({x, y, seen.most, seen.order});
            }
            std::swap(upper, lower);
        });
    }
    /// Looks at what was put down, closer and closer: first at what could raise the worst most, so that fewer are left after it.
    void settle() {
        settleGlanced();
        constexpr std::size_t kFirst = 4;
        std::vector<Doubtful> doubtful = std::move(doubtful_);
        std::ranges::stable_sort(doubtful, std::greater{}, &Doubtful::diffuse);
        for (std::size_t i = 0; i < std::min(kFirst, doubtful.size()); ++i) look(doubtful[i].x, doubtful[i].y);
        std::ranges::stable_sort(doubtful, std::greater{}, &Doubtful::specular);
        for (const Doubtful& each : doubtful) look(each.x, each.y);
    }

private:
    using Quad = QuadControls<Layout>;

    static auto zonalOf(const MapRows<Layout>& rows, const Liberties<Layout>& liberties, const BoundJudge& judge) {
        if constexpr (layouts::Zonal<Layout>)
            return ZonalBounds<Layout>(rows, liberties, judge);
        else
            return std::monostate{};
    }

    void bound(const QuadTexels& texels, const QuadReferences& references, int x, int y, bool mayPutDown) {
        if constexpr (layouts::Zonal<Layout>) {
            zonal_.bound(texels, references, x, y, worst_);
        } else {
            for (int corner = 0; corner < 4; ++corner)
                if (rows_.isNewDecode(x, y, corner) && !boundDecode(texels, references, x, y, corner, mayPutDown)) return;
        }
    }
    /// Under the decode of one corner. False: put down for later, with the decodes after it.
    bool boundDecode(const QuadTexels& texels, const QuadReferences& references, int x, int y, int corner, bool mayPutDown) {
        const int cornerX = x + corner % 2, cornerY = y + corner / 2;
        const Quad quad(texels, references, {}, [&](const LayerTexels& t, const LcSh& reference) {
            return difference(rows_.decoded(t, cornerX, cornerY), reference);
        });
        const Squares squares = largestSquares(quad.values);
        ChannelSlack slack{};
        addRounding(slack, squares, referenceSquares(references));
        if (liberties_.isNone()) {
            if (judge_.isCertainlyWithin(worst_, squares, slack)) return true;
            if (mayPutDown) return putDown(x, y, squares, slack, references);
            const auto pairs = quad.pairs();
            for (std::size_t c = 0; c < kChannels; ++c) judge_.raise(worst_, pairs[c], slack[c], placesOf(x, y, c));
            return true;
        }
        Liberties<Layout>::addFractions(slack, references, squares);
        const auto off = liberties_.ofQuad(texels, x, y, corner);
        if (judge_.isCertainlyWithin(worst_, squares, sumOf(slack, liberties_.lengthsOf(off, false)))) return true;
        const ChannelSlack all = sumOf(slack, liberties_.lengthsOf(off, true));
        if (judge_.isCertainlyWithin(worst_, squares, all)) return true;
        if (mayPutDown) return putDown(x, y, squares, all, references);
        addLengths(slack, off.absolute, static_cast<double>(rows_.perKey()));
        raiseFree(quad.pairs(), references, all, slack, off, x, y);
        return true;
    }
    static PairPlaces placesOf(int x, int y, std::size_t channel) {
        return {static_cast<double>(x), static_cast<double>(y), 1, static_cast<std::size_t>(Quad::kNodes), static_cast<int>(channel)};
    }

    /// A quad that is not settled at a glance.
    struct Glanced {
        int x, y;
        Most most, order;
    };
    void settleGlanced() {
        constexpr std::ptrdiff_t kFirst = 16;
        const auto drop = [&] {
            std::erase_if(glanced_, [&](const Glanced& each) { return judge_.isCertainlyWithin(worst_, each.most); });
        };
        const auto lookAtFirst = [&](auto&& before) {
            const auto end = glanced_.begin() + std::min(kFirst, std::ssize(glanced_));
            std::partial_sort(glanced_.begin(), end, glanced_.end(), before);
            for (auto each = glanced_.begin(); each != end; ++each) look(each->x, each->y);
            drop();
        };
        // Numbers that are none come first.
        const auto above = [](float a, float b) { return !std::isnan(b) && !(a <= b); };
        const auto byDiffuse = [&](const Glanced& a, const Glanced& b) { return above(a.order.diffuse, b.order.diffuse); };
        const auto bySpecular = [&](const Glanced& a, const Glanced& b) { return above(a.order.specular, b.order.specular); };
        drop();
        lookAtFirst(byDiffuse);
        lookAtFirst(bySpecular);
        std::ranges::stable_sort(glanced_, bySpecular);
        for (const Glanced& each : glanced_)
            if (!judge_.isCertainlyWithin(worst_, each.most))
                rows_.withQuad(each.x, each.y,
                               [&](const Corners& corners) { bound(corners.texels, corners.references, each.x, each.y, true); });
        glanced_.clear();
    }

    /// A quad that lengths of its control vectors do not settle either, and its place in the queue.
    struct Doubtful {
        int x, y;
        double diffuse, specular;
    };
    bool putDown(int x, int y, const Squares& error, const ChannelSlack& slack, const QuadReferences& references) {
        constexpr double kAll = std::numeric_limits<double>::max();
        Doubtful out{x, y, 0, 0};
        const auto raise = [](double& largest, double value) {
            largest = value <= largest ? largest : std::isfinite(value) ? value : kAll;
        };
        for (std::size_t c = 0; c < kChannels; ++c) {
            lighting::ShBands lengths = slack[c];
            for (std::size_t l = 0; l < 3; ++l) lengths[l] += outwardLength(error[l][static_cast<int>(c)]);
            double light = 0;
            for (const LcSh* reference : references) light += 0.25 * static_cast<double>(reference->c[0][static_cast<int>(c)]);
            light = std::max(light, 0.0);
            const lighting::ShBands& glossy = judge_.setup().largestResponse;
            raise(out.diffuse, bandSum(lengths, kExitNorm) / (kFloor + kExitNorm[0] * light));
            raise(out.specular, bandSum(lengths, glossy) / (kFloor + glossy[0] * light));
        }
        doubtful_.push_back(out);
        return false;
    }

    /// The signed sums of a group, each with the references of the corners.
    struct FreeGroup {
        std::array<ErrorPair, 4 * kSigns> pairs;
        lighting::ShBands rounding{};
        void set(std::size_t i, const ErrorPair& pair) {
            pairs[i] = pair;
            const lighting::ShBands lengths = bandNorms(pair.error);
            for (std::size_t l = 0; l < 3; ++l) rounding[l] = std::max(rounding[l], kRounding * lengths[l]);
        }
    };
    /// Takes the pairs into the worst so far, with what a sampler is free to do.
    /// all  the lengths of all that errors may have beyond their numbers; slack: but for the groups of `off`
    /// Groups are long where light is, and short in the dark: |e + g| / (|r| + floor) is at most the sum of the bounds of |e| and of |g|
    /// over the same, which is often far less than the bound of |e| with the group's length beside it. g's reference is bilinear, so that
    /// its corners are all that it takes.
    template <std::size_t kGroups>
    void raiseFree(const typename Quad::Pairs& pairs, const QuadReferences& references, const ChannelSlack& all, const ChannelSlack& slack,
                   const layouts::Deviation<kGroups>& off, int x, int y) {
        std::vector<std::array<Channels, kSigns>> sums(kGroups);
        for (std::size_t group = 0; group < kGroups; ++group) {
            const std::array<LcSh, kSigns> signedSums = signedSumsOf(off.groups[group]);
            for (std::size_t i = 0; i < kSigns; ++i) sums[group][i] = channelsOf(scaled(signedSums[i], rows_.perKey()));
        }
        std::array<Channels, 4> corners;
        for (std::size_t i = 0; i < 4; ++i) corners[i] = channelsOf(*references[i]);
        for (std::size_t c = 0; c < kChannels; ++c) {
            std::array<FreeGroup, kGroups> groups;
            bool hasGroups = false;
            const auto makeGroups = [&] {
                for (std::size_t group = 0; group < kGroups && !hasGroups; ++group)
                    for (std::size_t i = 0; i < groups[group].pairs.size(); ++i)
                        groups[group].set(i, {sums[group][i / 4][c], corners[i % 4][c]});
                hasGroups = true;
            };
            const auto take = [&](std::span<const Response> responses, WorstBound& largest) {
                const double clearly = kClearly * largest.bound;
                if (responses.empty() || staysWithin(pairs[c], responses, kFloor, all[c], clearly)) return;
                if constexpr (kGroups > 0) {
                    makeGroups();
                    if (staysWithinInParts(pairs[c], slack[c], groups, responses, clearly)) return;
                }
                BoundPlace found;
                double bound = localErrorBound(pairs[c], responses, kFloor, all[c], std::numeric_limits<double>::infinity(), &found);
                if (bound < largest.bound) return;
                if constexpr (kGroups > 0) {
                    double sum = localErrorBound(pairs[c], responses, kFloor, slack[c], bound);
                    for (const FreeGroup& group : groups)
                        if (sum < bound) sum += localErrorBound(group.pairs, responses, kFloor, group.rounding, bound - sum);
                    bound = std::min(bound, sum);
                }
                largest.raise(bound, judge_.placeOf(found, bound, placesOf(x, y, c)));
            };
            take({&kExitResponse, 1}, worst_.diffuse);
            take(judge_.setup().responses, worst_.specular);
        }
    }
    /// Whether errors and groups each stay within a part of the limit, dealt out by their lengths.
    template <std::size_t kGroups>
    static bool staysWithinInParts(std::span<const ErrorPair> pairs, const lighting::ShBands& slack,
                                   const std::array<FreeGroup, kGroups>& groups, std::span<const Response> responses, double limit) {
        const lighting::ShBands norms = responses.front().norms();
        const double error = bandSum(largestLengths(pairs), norms) + bandSum(slack, norms);
        std::array<double, kGroups> parts;
        double sum = error;
        for (std::size_t group = 0; group < kGroups; ++group)
            sum += parts[group] = bandSum(largestLengths(groups[group].pairs), norms) + bandSum(groups[group].rounding, norms);
        if (!staysWithin(pairs, responses, kFloor, slack, limit * (error / sum))) return false;
        for (std::size_t group = 0; group < kGroups; ++group)
            if (!staysWithin(groups[group].pairs, responses, kFloor, groups[group].rounding, limit * (parts[group] / sum))) return false;
        return true;
    }
    static lighting::ShBands largestLengths(std::span<const ErrorPair> pairs) {
        lighting::ShBands largest{};
        for (const ErrorPair& pair : pairs) {
            const lighting::ShBands lengths = bandNorms(pair.error);
            for (std::size_t l = 0; l < 3; ++l) largest[l] = std::max(largest[l], lengths[l]);
        }
        return largest;
    }

    const MapRows<Layout>& rows_;
    const Liberties<Layout>& liberties_;
    const BoundJudge& judge_;
    decltype(zonalOf(std::declval<const MapRows<Layout>&>(), std::declval<const Liberties<Layout>&>(),
                     std::declval<const BoundJudge&>())) zonal_;
    Worst worst_;
    std::vector<Glanced> glanced_;
    std::vector<Doubtful> doubtful_;
};

}  // namespace lightcook::verify::lightmap
