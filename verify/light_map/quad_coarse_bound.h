// Whether a quad is certainly under the worst so far, from lengths that are taken once a texel. Private to verify/.
#pragma once

#include <numbers>
#include <span>
#include <vector>

#include "verify/light_map/coarse_bound.h"
#include "verify/light_map/rows.h"
#include "verify/light_map/tolerance.h"
#include "verify/light_map/worst.h"

namespace lightcook::verify::lightmap {

/// Of a texel, in units of the key.
struct TexelLengths {
    BandLengths error, reference;  ///< error: under its own decode; of zonal layouts the coefficient that is all of band 2, as it is
};

template <class Layout>
class QuadGlance {
public:
    using Rows = MapRows<Layout>;
    using Row = typename Rows::Row;
    using Corners = typename Rows::Corners;

    QuadGlance(const Rows& rows, const Liberties<Layout>& liberties, const BoundJudge& judge)
        : rows_(rows), isIdeal_(liberties.isNone()), judge_(judge), glances_(rows.layout(), liberties.formats()), liberties_(liberties) {}

    void measure(const Row& row, int y, std::vector<TexelLengths>& out) const {
        if (!glances_.isKnown()) return;
        const int width = rows_.width();
        out.resize(index(width));
        for (int x = 0; x < width; ++x) {
            const std::size_t i = index(x);
            if (row.covered[i] == 0) continue;
            const LcSh& reference = row.reference[i];
            out[i].error = bandLengths(errorOf(row.texels[i], reference, x, y));
            out[i].reference = bandLengths(reference);
        }
    }
    bool isKnown() const { return glances_.isKnown(); }
    struct Seen {
        Most most;   ///< no less than QuadBounds would find of the quad's errors, under every decode of its corners
        Most order;  ///< the more, the more it could raise the worst
    };
    /// Of the quad at (x, y). rows: two texels each of the row above and of the row below. No closer than it takes to settle it.
    Seen look(const Worst& worst, const Corners& corners, const std::array<const TexelLengths*, 2>& rows, int x, int y) const {
        const std::array<const TexelLengths*, 4> texels = {rows[0], rows[0] + 1, rows[1], rows[1] + 1};
        const BandLengths light = largestOf(texels, &TexelLengths::reference);
        // Neighbours differ by no more than they are.
        BandLengths beside{};
        for (std::size_t lane = 0; lane < kBandLanes; ++lane)
            beside[lane] = (kFloatRounding + (hasEdges() ? 4 * kFractionFreedom : 0)) * light[lane];
        Seen seen;
        for (int corner = 0; corner < 4; ++corner) {
            if (!rows_.isNewDecode(x, y, corner)) continue;
            const auto& decode = layouts::decodeAt(rows_.layout(), x + corner % 2, y + corner / 2);
            const BandLengths error = largestError(decode, corners, texels, x, y, corner);
            Seen each;
            const auto settles = [&](const layouts::Glance& glance, const BandLengths& besideError) {
                each = seenOf(error, glance, besideError, light);
                return judge_.isCertainlyWithin(worst, each.most);
            };
            bool isSettled = false;
            if constexpr (requires { glances_.roughly(decode, corners.texels); })
                isSettled = settles(glances_.roughly(decode, corners.texels), beside);
            if (!isSettled) {
                const layouts::Glance glance =
                    glances_.of(decode, corners.texels, [&](std::size_t layer) { return liberties_.freedomAt(layer, x, y); });
                if (!settles(glance, beside) && hasEdges()) settles(glance, besideOf(corners.references, light));
            }
            seen.most.raise(each.most);
            seen.order.raise(each.order);
        }
        return seen;
    }

private:
    /// Twice over: of this glance's floats, and of those that a closer look is made of.
    static constexpr auto kFloatRounding = static_cast<float>(2.5 * kRounding);

    LcSh errorOf(const typename Rows::LayerTexels& texels, const LcSh& reference, int x, int y) const {
        if constexpr (layouts::Zonal<Layout>) {
            LcSh error = scaled(rows_.layout().bands(texels), rows_.perKey());
            for (std::size_t i = 0; i < 4; ++i) error.c[i] -= reference.c[i];
            return error;
        } else {
            return difference(rows_.decoded(texels, x, y), reference);
        }
    }
    bool hasEdges() const { return !isIdeal_ && !layouts::Zonal<Layout>; }
    /// What is beside the error: floats, and what the filter's fractions make of the reference.
    static BandLengths besideOf(const typename Rows::QuadReferences& references, const BandLengths& light) {
        const auto steps = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
            const std::array<LcSh, 2> edges = {difference(*references[a], *references[b]), difference(*references[c], *references[d])};
            return largestLengths(edges);
        };
        const BandLengths across = steps(1, 0, 3, 2), down = steps(2, 0, 3, 1);
        BandLengths beside;
        for (std::size_t lane = 0; lane < kBandLanes; ++lane)
            beside[lane] = kFloatRounding * light[lane] + kFractionFreedom * (across[lane] + down[lane]);
        return beside;
    }
    static void raise(BandLengths& largest, const BandLengths& lengths) {
        // What is not a number stays: no comparison with it is true.
        for (std::size_t lane = 0; lane < kBandLanes; ++lane)
            largest[lane] = lengths[lane] <= largest[lane] ? largest[lane] : lengths[lane];
    }
    static BandLengths largestOf(const std::array<const TexelLengths*, 4>& texels, BandLengths TexelLengths::*which) {
        BandLengths largest{};
        for (const TexelLengths* texel : texels) raise(largest, texel->*which);
        return largest;
    }
    /// At the corners, under the decode of one of them.
    template <class Decode>
    BandLengths largestError(const Decode& decode, const Corners& corners, const std::array<const TexelLengths*, 4>& texels, int x, int y,
                             int corner) const {
        BandLengths error{};
        for (int i = 0; i < 4; ++i) {
            const auto at = static_cast<std::size_t>(i);
            if (rows_.hasSameDecode(x, y, corner, i)) {
                raise(error, texels[at]->error);
            } else {
                const LcSh decoded = scaled(decode.decode(*corners.texels[at]), rows_.perKey());
                raise(error, bandLengths(difference(decoded, *corners.references[at])));
            }
        }
        return error;
    }
    Seen seenOf(const BandLengths& error, const layouts::Glance& glance, const BandLengths& beside, const BandLengths& light) const {
        const float fractions = isIdeal_ ? 0 : kFractionFreedom * 4 * Layout::kDegree, perKey = rows_.perKey();
        BandLengths all;
        for (std::size_t lane = 0; lane < kBandLanes; ++lane) {
            const float bend = perKey * glance.bend[lane];
            float own = error[lane] + bend, moved = own;
            if constexpr (layouts::Zonal<Layout>) {
                // The fractions move the decode itself. Its band 2 is a number times a vector of length 1 about an axis, which another may
                // be sqrt 3 away from.
                const bool isNumber = lane >= 2 * kChannels;
                moved = isNumber ? own : own + light[lane];
                if (isNumber) own = (1 + std::numbers::sqrt3_v<float>)*own + light[lane];
            }
            all[lane] = kOutward * ((1 + kFloatRounding) * own + fractions * moved + beside[lane] + perKey * glance.freedom[lane]);
        }
        Seen seen;
        for (std::size_t c = 0; c < kChannels; ++c) {
            const Most most = judge_.mostOf(all, c);
            seen.most.raise(most);
            seen.order.raise(judge_.besideLight(most, light[c]));
        }
        return seen;
    }

    const Rows& rows_;
    bool isIdeal_;
    const BoundJudge& judge_;
    layouts::Glances<Layout> glances_;
    const Liberties<Layout>& liberties_;
};

}  // namespace lightcook::verify::lightmap
