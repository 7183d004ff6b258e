#include "verify/light_map/bound_evaluator.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <tuple>

namespace lightcook::verify::lightmap {

void LargestBound::raise(double candidate, const ErrorPlace& at, const lighting::ShBands& response) {
    const auto order = [](const ErrorPlace& p) { return std::tuple(p.y, p.x, p.channel); };
    if (!(candidate > bound || (candidate == bound && candidate > 0 && order(at) < order(place)))) return;
    bound = candidate;
    place = at;
    bands = response;
}

BoundEvaluator::BoundEvaluator(const ShadingSetup& setup, float perKey) : setup_(setup), unit_(1 / static_cast<double>(perKey)) {
    for (std::size_t l = 0; l < 3; ++l) {
        exitNorms_[l] = kOutwardFloat * static_cast<float>(kExitResponse.norms()[l]);
        glossyNorms_[l] = kOutwardFloat * static_cast<float>(setup.largestResponse[l]);
    }
}

bool BoundEvaluator::cannotExceed(const LargestBounds& largest, const Squares& error, const ChannelSlack& slack) const {
    static const lighting::ShBands kExitNorms = kExitResponse.norms();
    for (std::size_t c = 0; c < kChannels; ++c) {
        lighting::ShBands lengths = slack[c];
        for (std::size_t l = 0; l < 3; ++l) lengths[l] += outwardLength(error[l][static_cast<int>(c)]) + kUnderflow;
        // Not ">": an error that is NaN must be refined.
        if (!(bandSum(lengths, kExitNorms) <= kFloor * largest.diffuse.bound)) return false;
        if (!(bandSum(lengths, setup_.largestResponse) <= kFloor * largest.specular.bound)) return false;
    }
    return true;
}

ErrorBound BoundEvaluator::errorBound(const BandLengths& lengths, std::size_t channel) const {
    ErrorBound bound;
    for (std::size_t l = 0; l < 3; ++l) {
        bound.diffuse += exitNorms_[l] * lengths[3 * l + channel];
        bound.specular += glossyNorms_[l] * lengths[3 * l + channel];
    }
    return bound;
}

ErrorBound BoundEvaluator::errorBound(const BandLengths& lengths) const {
    ErrorBound bound;
    for (std::size_t c = 0; c < kChannels; ++c) bound.raise(errorBound(lengths, c));
    return bound;
}

ErrorBound BoundEvaluator::relativeToLight(const ErrorBound& bound, float light) const {
    const auto floor = static_cast<float>(kFloor);
    return {bound.diffuse / (floor + exitNorms_[0] * light), bound.specular / (floor + glossyNorms_[0] * light)};
}

void BoundEvaluator::raise(LargestBounds& largest, std::span<const ErrorPair> pairs, const lighting::ShBands& slack,
                           const PairPlaces& places) const {
    if (largest.isSpent()) return raiseByLengths(largest, pairs, slack, places);
    largest.work += workOf(pairs.size());
    const auto raiseTo = [&](std::span<const Response> responses, LargestBound& current) {
        if (verify::cannotExceed(pairs, responses, kFloor, slack, kTieFactor * current.bound)) return;
        BoundPlace found;
        const double bound = localErrorBound(pairs, responses, kFloor, slack, std::numeric_limits<double>::infinity(), &found);
        current.raise(bound, placeOf(found, bound, places), found.bands);
    };
    raiseTo({&kExitResponse, 1}, largest.diffuse);
    raiseTo(setup_.responses, largest.specular);
}

void BoundEvaluator::raiseByLengths(LargestBounds& largest, std::span<const ErrorPair> pairs, const lighting::ShBands& slack,
                                    const PairPlaces& places) const {
    const auto raiseTo = [&](std::span<const Response> responses, LargestBound& current) {
        BoundPlace found;
        double bound = 0;
        for (const Response& response : responses)
            for (std::size_t i = 0; i < pairs.size(); ++i) {
                lighting::ShBands lengths = lighting::bandLengths(pairs[i].error);
                for (std::size_t l = 0; l < lengths.size(); ++l) lengths[l] = kOutward * (lengths[l] + slack[l]) + kUnderflow;
                const double candidate = bandSum(lengths, response.norms()) / kFloor;
                if (candidate <= bound) continue;
                // Not a number is above all.
                bound = candidate < std::numeric_limits<double>::infinity() ? candidate : std::numeric_limits<double>::infinity();
                found.pair = i;
                found.bands = response.bands;
                if (!std::isfinite(candidate)) break;
            }
        if (responses.empty() || bound < current.bound) return;
        const lighting::Sh& error = pairs[found.pair].error;
        const glm::dvec3 along(error[3], error[1], error[2]);
        found.direction = glm::length(along) > 0 ? glm::normalize(along) : glm::dvec3(0, 0, 1);
        found.error = shadedAbout(error, found.bands, found.direction);
        found.reference = shadedAbout(pairs[found.pair].reference, found.bands, found.direction);
        current.raise(bound, placeOf(found, bound, places), found.bands);
    };
    raiseTo({&kExitResponse, 1}, largest.diffuse);
    raiseTo(setup_.responses, largest.specular);
}

ErrorPlace BoundEvaluator::placeOf(const BoundPlace& found, double bound, const PairPlaces& places) const {
    ErrorPlace place;
    const double step = places.nodes > 1 ? places.size / static_cast<double>(places.nodes - 1) : 0;
    const std::size_t column = found.pair % places.nodes, row = found.pair / places.nodes;
    place.x = places.x + step * static_cast<double>(column);
    place.y = places.y + step * static_cast<double>(row);
    place.channel = places.channel;
    place.normal = found.direction;
    place.reference = unit_ * found.reference;
    place.found = unit_ * (found.reference + found.error);
    place.local = bound;
    return place;
}

}  // namespace lightcook::verify::lightmap
