// Verification of some rows of a map, for a layout known at compile time. Private to verify/.
//
//   1. Every covered texel: each stage is decoded at its centre, shaded, compared with the reference and bounded.
//   2. Every quad of covered texels: random positions are decoded, shaded and compared ("magnified").
//   3. Every quad is bounded (quads.h), beginning with those that had the worst samples: large bounds found early save refinements.
//
// Templates of one layout each: only the sources that instantiate them (rows_direct.cpp, rows_learned.cpp, rows_residual.cpp) include
// this header. Others include verified_rows.h.
#pragma once

#include "verify/light_map/quads.h"
#include "verify/light_map/verified_rows.h"

namespace lightcook::verify::lightmap {

/// Returns a pseudorandom number in [0, 1) that depends on seed and place only.
inline float hashedFraction(std::uint64_t seed, std::uint64_t place) {
    std::uint64_t z = seed * 0x9e3779b97f4a7c15u + place * 0xbf58476d1ce4e5b9u + 0x94d049bb133111ebu;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return static_cast<float>((z ^ (z >> 31)) >> 40) * 0x1p-24f;
}

/// Relative rounding error of shading: float sums of nine products.
inline constexpr double kShadingRounding = 2e-6;

template <class Layout>
class RowVerifier {
public:
    /// errors  empty, with one stage for each of the layout's and "magnified"
    RowVerifier(const Layout& layout, LightMapErrors errors, const RowInputs& inputs)
        : rows_(layout, inputs.map, inputs.perKey, inputs.texels, inputs.reference),
          sampling_(inputs.sampling),
          tolerance_(rows_, inputs.setup.tolerance),
          evaluator_(inputs.setup, inputs.perKey),
          quads_(rows_, tolerance_, evaluator_),
          errors_(std::move(errors)),
          largest_(kStages),
          shader_(inputs.setup.matrices, 1 / static_cast<double>(inputs.perKey)) {}

    LightMapErrors run(int firstRow, int rowCount) {
        rows_.forEachTexel(firstRow, rowCount, [&](const Row& row, int x, int y) { centre(row, x, y); });
        if (sampling_.bounds) {
            if (sampling_.positionsPerQuad > 0)
                rows_.forEachQuad(firstRow, rowCount, [&](const Corners& corners, int x, int y) {
                    for (int sample = 0; sample < sampling_.positionsPerQuad; ++sample) magnified(corners, x, y, sample);
                });
            for (const auto& [x, y] : worstSampled_)
                if (x >= 0) quads_.boundQuad(x, y);
            quads_.boundRows(firstRow, rowCount);
            quads_.refineDeferred();
        }
        for (std::size_t stage = 0; stage < kStages; ++stage) addBounds(errors_.accumulators[stage], largest_[stage]);
        LargestBounds quads = quads_.largest();
        decodeAt(quads.diffuse);
        decodeAt(quads.specular);
        addBounds(errors_.accumulators.back(), quads);
        return std::move(errors_);
    }

    LightMapVerifier::QuadBound oneQuad(int x, int y) {
        quads_.boundQuad(x, y);
        return {quads_.largest().diffuse.bound, quads_.largest().specular.bound};
    }

private:
    using Row = typename MapRows<Layout>::Row;
    using Corners = typename MapRows<Layout>::Corners;
    static constexpr std::size_t kStages = Layout::kStages;  ///< at texel centres

    void addBounds(LightMapErrors::Stage& stage, const LargestBounds& largest) const {
        stage.errors.diffuse.addBound(largest.diffuse.bound, largest.diffuse.place);
        if (evaluator_.setup().hasSpecular()) stage.errors.specular.addBound(largest.specular.bound, largest.specular.place);
    }
    /// Sets the light of the place of a quad's bound: what filtered bake and textures decode to there, shaded in the bound's direction. The
    /// bound was reached by control vectors, which are no values of the map.
    void decodeAt(LargestBound& largest) const {
        ErrorPlace& place = largest.place;
        if (!place.isKnown() || rows_.width() < 2) return;
        const int x = std::min(static_cast<int>(place.x), rows_.width() - 2);
        const int y = std::min(static_cast<int>(place.y), rows_.lastRow() - 1);
        const auto u = static_cast<float>(place.x - x), v = static_cast<float>(place.y - y);
        rows_.withQuad(x, y, [&](const Corners& corners) {
            const auto filter = [&](const auto& at) { return blend(blend(*at[0], *at[1], u), blend(*at[2], *at[3], u), v); };
            const LcSh seen = rows_.decoded(filter(corners.texels), x + (u > 0.5f ? 1 : 0), y + (v > 0.5f ? 1 : 0));
            const auto light = [&](const LcSh& sh) {
                return shadedAbout(channelsOf(sh)[index(place.channel)], largest.bands, place.normal) / static_cast<double>(rows_.perKey());
            };
            place.reference = light(filter(corners.references));
            place.found = light(seen);
        });
    }
    void addErrors(std::size_t stage, const LcSh& error) { shader_.add(error, errors_.accumulators[stage].errors); }

    void centre(const Row& row, int x, int y) {
        const LcSh& reference = row.reference[index(x)];
        shader_.setReference(reference, rows_.normalAt(x, y), {x, y});
        std::size_t stage = 0;
        const auto stageError = [&](const LcSh& result) {
            const LcSh error = difference(result, reference);
            addErrors(stage, error);
            if (sampling_.bounds) {
                // Bounds of earlier stages are those of an ideal sampler.
                const bool isLast = stage == Layout::kEarlyStages;
                boundCentre(largest_[stage], error, reference, isLast ? tolerance_.centreSlack(row.texels[index(x)], x, y) : ChannelSlack{},
                            x, y);
            }
            ++stage;
        };
        if constexpr (Layout::kEarlyStages > 0) {
            const LcSh unscaledReference = scaled(reference, 1 / rows_.perKey());
            const auto& decode = layouts::decodeAt(rows_.layout(), x, y);
            for (std::size_t early = 0; early < Layout::kEarlyStages; ++early)
                stageError(scaled(decode.decodeEarly(early, row.texels[index(x)], unscaledReference), rows_.perKey()));
        }
        stageError(rows_.decoded(row.texels[index(x)], x, y));
    }
    void boundCentre(LargestBounds& largest, const LcSh& error, const LcSh& reference, const ChannelSlack& tolerance, int x, int y) const {
        BandLengths all = bandLengths(error);
        for (std::size_t l = 0; l < 3; ++l)
            for (std::size_t c = 0; c < kChannels; ++c)
                all[3 * l + c] = kOutward * (all[3 * l + c] + static_cast<float>(kShadingRounding) * all[3 * l + c] +
                                             static_cast<float>(tolerance[c][l]));
        if (evaluator_.cannotExceed(largest, evaluator_.errorBound(all))) return;
        ChannelSlack slack = tolerance;
        addLengths(slack, error, kShadingRounding);
        if (evaluator_.cannotExceed(largest, largestSquares({&error, 1}), slack)) return;
        const Channels errors = channelsOf(error), references = channelsOf(reference);
        for (std::size_t c = 0; c < kChannels; ++c) {
            const std::array<ErrorPair, 1> pair = {ErrorPair{errors[c], references[c]}};
            evaluator_.raise(largest, pair, slack[c], {static_cast<double>(x), static_cast<double>(y), 0, 1, static_cast<int>(c)});
        }
    }

    void magnified(const Corners& corners, int x, int y, int sample) {
        const auto place =
            2 * ((static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(rows_.width()) + static_cast<std::uint64_t>(x)) *
                     static_cast<std::uint64_t>(sampling_.positionsPerQuad) +
                 static_cast<std::uint64_t>(sample));
        const float u = hashedFraction(sampling_.seed, place), v = hashedFraction(sampling_.seed, place + 1);
        const auto filter = [&](const auto& at) { return blend(blend(*at[0], *at[1], u), blend(*at[2], *at[3], u), v); };
        const LcSh reference = filter(corners.references);
        shader_.setReference(reference, rows_.normalAt(x, y), glm::dvec2(x, y) + glm::dvec2(u, v));
        const ShadedErrors& errors = errors_.accumulators.back().errors;
        const std::array<double, 2> before = {errors.diffuse.maxSampled(), errors.specular.maxSampled()};
        addErrors(kStages, difference(rows_.decoded(filter(corners.texels), x, y), reference));
        const std::array<double, 2> after = {errors.diffuse.maxSampled(), errors.specular.maxSampled()};
        for (std::size_t kind = 0; kind < after.size(); ++kind)
            if (after[kind] > before[kind]) worstSampled_[kind] = {x, y};
    }

    const MapRows<Layout> rows_;
    const LightMapSampling& sampling_;
    const SamplerTolerance<Layout> tolerance_;
    const BoundEvaluator evaluator_;
    QuadBounds<Layout> quads_;
    LightMapErrors errors_;
    std::vector<LargestBounds> largest_;  ///< [stage], at texel centres
    ErrorShader shader_;
    std::array<std::pair<int, int>, 2> worstSampled_{{{-1, -1}, {-1, -1}}};  ///< quads with the worst diffuse and specular samples
};

template <class Layout>
LightMapErrors verifyRows(const Layout& layout, LightMapErrors errors, const RowInputs& inputs, int firstRow, int rowCount) {
    return RowVerifier(layout, std::move(errors), inputs).run(firstRow, rowCount);
}

template <class Layout>
LightMapVerifier::QuadBound boundQuad(const Layout& layout, LightMapErrors errors, const RowInputs& inputs, int x, int y) {
    return RowVerifier(layout, std::move(errors), inputs).oneQuad(x, y);
}

}  // namespace lightcook::verify::lightmap

/// Instantiates the functions of verified_rows.h for a layout of verify/light_map/layouts.h.
// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): a template cannot instantiate another
#define LIGHTCOOK_VERIFY_LAYOUT(LAYOUT)                                                                     \
    template LightMapErrors verifyRows(const layouts::LAYOUT&, LightMapErrors, const RowInputs&, int, int); \
    template LightMapVerifier::QuadBound boundQuad(const layouts::LAYOUT&, LightMapErrors, const RowInputs&, int, int)
