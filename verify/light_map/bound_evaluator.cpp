#include "verify/light_map/bound_evaluator.h"

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
    const auto raiseTo = [&](std::span<const Response> responses, LargestBound& current) {
        if (verify::cannotExceed(pairs, responses, kFloor, slack, kTieFactor * current.bound)) return;
        BoundPlace found;
        const double bound = localErrorBound(pairs, responses, kFloor, slack, std::numeric_limits<double>::infinity(), &found);
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
