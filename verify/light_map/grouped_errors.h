// Errors of a quad together with sampler deviations that are known as signed vectors (Deviation::groups). Private to verify/.
//
// A group's deviation g is long where light is and short in the dark. Adding its largest length to the slack of every error would count the
// brightest texel's deviation against the darkest texel's reference. Instead, by the triangle inequality,
//   |e + g| / (|r| + floor) <= |e| / (|r| + floor) + |g| / (|r| + floor),
// and both terms are bounded separately, g against the references of the corners: they are bilinear, so the corners are all control
// vectors.
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "verify/light_map/bound_evaluator.h"
#include "verify/light_map/map_decoder.h"

namespace lightcook::verify::lightmap {

/// The signed sums of each group and the references of the corners, by channel.
struct SignedGroups {
    std::vector<std::array<Channels, kSigns>> sums;  ///< [group][signs]
    std::array<Channels, 4> corners;

    SignedGroups(const Deviation& deviation, const std::array<const LcSh*, 4>& references, float perKey) : sums(deviation.groups.size()) {
        for (std::size_t group = 0; group < sums.size(); ++group) {
            const std::array<LcSh, kSigns> signedSums = signedSumsOf(deviation.groups[group]);
            for (std::size_t i = 0; i < kSigns; ++i) sums[group][i] = channelsOf(scaled(signedSums[i], perKey));
        }
        for (std::size_t i = 0; i < 4; ++i) corners[i] = channelsOf(*references[i]);
    }
};

/// The errors of one channel over a quad, bounded with all slack, or with the groups apart, whichever is less.
class GroupedErrors {
public:
    /// pairs  control vectors of error and reference
    /// all    slack, the lengths of the groups included
    /// slack  the same without the groups
    GroupedErrors(std::span<const ErrorPair> pairs, const lighting::ShBands& all, const lighting::ShBands& slack,
                  const SignedGroups& groups, std::size_t channel)
        : pairs_(pairs), all_(all), slack_(slack), signed_(groups), channel_(channel) {}

    /// Returns true if the bound is proven not to exceed `limit`.
    bool cannotExceed(std::span<const Response> responses, double limit) {
        if (verify::cannotExceed(pairs_, responses, kFloor, all_, limit)) return true;
        return !signed_.sums.empty() && cannotExceedInParts(responses, limit);
    }
    /// Returns the bound.
    /// threshold  bounds below it need not be tight
    /// place      receives the place where it is reached
    double bound(std::span<const Response> responses, double threshold, BoundPlace& place) {
        const double bound = localErrorBound(pairs_, responses, kFloor, all_, std::numeric_limits<double>::infinity(), &place);
        if (signed_.sums.empty() || bound < threshold) return bound;
        double sum = localErrorBound(pairs_, responses, kFloor, slack_, bound);
        for (const Group& group : groups())
            if (sum < bound) sum += localErrorBound(group.pairs, responses, kFloor, group.rounding, bound - sum);
        return std::min(bound, sum);
    }

private:
    /// Signed sums of a group, each paired with the reference of each corner.
    struct Group {
        std::array<ErrorPair, 4 * kSigns> pairs;
        lighting::ShBands rounding{};
        void set(std::size_t i, const ErrorPair& pair) {
            pairs[i] = pair;
            const lighting::ShBands lengths = lighting::bandLengths(pair.error);
            for (std::size_t l = 0; l < 3; ++l) rounding[l] = std::max(rounding[l], kControlRounding * lengths[l]);
        }
    };
    const std::vector<Group>& groups() {
        if (groups_.empty()) {
            groups_.resize(signed_.sums.size());
            for (std::size_t group = 0; group < groups_.size(); ++group)
                for (std::size_t i = 0; i < groups_[group].pairs.size(); ++i)
                    groups_[group].set(i, {signed_.sums[group][i / 4][channel_], signed_.corners[i % 4][channel_]});
        }
        return groups_;
    }
    /// Tests errors and groups separately, each against a share of the limit in proportion to its length.
    bool cannotExceedInParts(std::span<const Response> responses, double limit) {
        const lighting::ShBands norms = responses.front().norms();
        const double error = bandSum(largestLengths(pairs_), norms) + bandSum(slack_, norms);
        std::vector<double> parts;
        double sum = error;
        for (const Group& group : groups()) {
            parts.push_back(bandSum(largestLengths(group.pairs), norms) + bandSum(group.rounding, norms));
            sum += parts.back();
        }
        if (!verify::cannotExceed(pairs_, responses, kFloor, slack_, limit * (error / sum))) return false;
        for (std::size_t group = 0; group < parts.size(); ++group)
            if (!verify::cannotExceed(groups()[group].pairs, responses, kFloor, groups()[group].rounding, limit * (parts[group] / sum)))
                return false;
        return true;
    }
    static lighting::ShBands largestLengths(std::span<const ErrorPair> pairs) {
        lighting::ShBands largest{};
        for (const ErrorPair& pair : pairs) {
            const lighting::ShBands lengths = lighting::bandLengths(pair.error);
            for (std::size_t l = 0; l < 3; ++l) largest[l] = std::max(largest[l], lengths[l]);
        }
        return largest;
    }

    std::span<const ErrorPair> pairs_;
    const lighting::ShBands &all_, &slack_;
    const SignedGroups& signed_;
    std::size_t channel_;
    std::vector<Group> groups_;  ///< made when first needed
};

}  // namespace lightcook::verify::lightmap
