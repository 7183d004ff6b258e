#include "verify/light_map/worst.h"

#include <tuple>

namespace lightcook::verify::lightmap {

void WorstBound::raise(double by, const ErrorPlace& at) {
    const auto order = [](const ErrorPlace& p) { return std::tuple(p.y, p.x, p.channel); };
    if (!(by > bound || (by == bound && by > 0 && order(at) < order(place)))) return;
    bound = by;
    place = at;
}

BoundJudge::BoundJudge(const ShadingSetup& setup, float perKey) : setup_(setup), unit_(1 / static_cast<double>(perKey)) {
    for (std::size_t l = 0; l < 3; ++l) {
        exitNorms_[l] = kOutward * static_cast<float>(kExitResponse.norms()[l]);
        glossyNorms_[l] = kOutward * static_cast<float>(setup.largestResponse[l]);
    }
}

bool BoundJudge::isCertainlyWithin(const Worst& worst, const Squares& error, const ChannelSlack& slack) const {
    static const lighting::ShBands kExitNorms = kExitResponse.norms();
    for (std::size_t c = 0; c < kChannels; ++c) {
        lighting::ShBands lengths = slack[c];
        for (std::size_t l = 0; l < 3; ++l) lengths[l] += outwardLength(error[l][static_cast<int>(c)]) + kTiny;
        // Not "greater": what is not a number has to be looked at.
        if (!(bandSum(lengths, kExitNorms) <= kFloor * worst.diffuse.bound)) return false;
        if (!(bandSum(lengths, setup_.largestResponse) <= kFloor * worst.specular.bound)) return false;
    }
    return true;
}

Most BoundJudge::mostOf(const BandLengths& lengths, std::size_t channel) const {
    Most most;
    for (std::size_t l = 0; l < 3; ++l) {
        most.diffuse += exitNorms_[l] * lengths[3 * l + channel];
        most.specular += glossyNorms_[l] * lengths[3 * l + channel];
    }
    return most;
}

Most BoundJudge::mostOf(const BandLengths& lengths) const {
    Most most;
    for (std::size_t c = 0; c < kChannels; ++c) most.raise(mostOf(lengths, c));
    return most;
}

Most BoundJudge::besideLight(const Most& most, float light) const {
    const auto floor = static_cast<float>(kFloor);
    return {most.diffuse / (floor + exitNorms_[0] * light), most.specular / (floor + glossyNorms_[0] * light)};
}

void BoundJudge::raise(Worst& worst, std::span<const ErrorPair> pairs, const lighting::ShBands& slack, const PairPlaces& places) const {
    const auto take = [&](std::span<const Response> responses, WorstBound& largest) {
        if (staysWithin(pairs, responses, kFloor, slack, kClearly * largest.bound)) return;
        BoundPlace found;
        const double bound = localErrorBound(pairs, responses, kFloor, slack, std::numeric_limits<double>::infinity(), &found);
        largest.raise(bound, placeOf(found, bound, places));
    };
    take({&kExitResponse, 1}, worst.diffuse);
    take(setup_.responses, worst.specular);
}

ErrorPlace BoundJudge::placeOf(const BoundPlace& found, double bound, const PairPlaces& places) const {
    ErrorPlace place;
    const double step = places.nodes > 1 ? places.size / static_cast<double>(places.nodes - 1) : 0;
    place.x = places.x + step * static_cast<double>(found.pair % places.nodes);
    place.y = places.y + step * static_cast<double>(found.pair / places.nodes);
    place.channel = places.channel;
    place.normal = found.direction;
    place.reference = unit_ * found.reference;
    place.found = unit_ * (found.reference + found.error);
    place.local = bound;
    return place;
}

}  // namespace lightcook::verify::lightmap
