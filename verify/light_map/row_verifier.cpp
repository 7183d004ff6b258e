// Verification of some rows of a map.
//
//   1. Every covered texel: each stage is decoded at its centre, shaded, compared with the reference and bounded.
//   2. Every quad with a covered texel: random places on the surface are decoded, shaded and compared. A place that is nearest to a texel
//      outside charts is on no surface, so each covered texel has as many places as another.
//   3. Every quad is bounded (quad_bounds.h, rim_bounds.h), beginning with those that had the worst samples: large bounds found early save
//      refinements.
#include "verify/light_map/verified_rows.h"

#include "verify/light_map/places.h"
#include "verify/light_map/quad_bounds.h"
#include "verify/light_map/rim_bounds.h"
#include "verify/light_map/visible_bounds.h"

namespace lightcook::verify::lightmap {

namespace {

class RowVerifier {
public:
    /// errors  empty, with one stage for each of the layout's
    RowVerifier(LightMapErrors errors, const RowInputs& inputs)
        : decoder_(inputs.decoder),
          rows_(*decoder_, inputs.map, inputs.texels, inputs.reference, !inputs.sampling.isForTrial()),
          sampling_(inputs.sampling),
          tolerance_(rows_, inputs.setup.tolerance),
          evaluator_(inputs.setup, rows_.perKey()),
          quads_(rows_, tolerance_, evaluator_),
          errors_(std::move(errors)),
          largest_(stages()),
          shader_(inputs.setup.matrices, 1 / static_cast<double>(rows_.perKey())),
          tiles_(formats::coverageSize(rows_.width(), rows_.height())) {}

    LightMapErrors run(int firstRow, int rowCount) {
        const double mostWork = kWorkOfStrip + kWorkPerTexel * static_cast<double>(rows_.width()) * rowCount;
        for (LargestBounds& largest : largest_) largest.mostWork = kShareOfCentres * mostWork;
        quads_.setMostWork(mostWork);
        countTiles(firstRow, rowCount);
        if (!sampling_.isForTrial())
            rows_.forEachTexel(firstRow, rowCount, [&](const MapRows::Row& row, int x, int y) { shadeCentre(row, x, y); });
        if (sampling_.placesPerTexel > 0)
            forEachCoveredQuad(rows_, firstRow, rowCount, [&](const CoveredQuad& quad) {
                for (int sample = 0; sample < sampling_.placesPerTexel; ++sample) shadePlace(quad, sample);
            });
        if (sampling_.isForTrial()) return std::move(errors_);
        for (std::size_t stage = 0; stage < stages(); ++stage) addBounds(errors_.stages[stage].errors, largest_[stage]);
        if (!sampling_.hasBounds()) return std::move(errors_);
        LargestBounds bounds = boundPlaces(firstRow, rowCount);
        decodeAt(bounds.diffuse);
        decodeAt(bounds.specular);
        addBounds(errors_.surface, bounds);
        boundVisible(firstRow, rowCount);
        return std::move(errors_);
    }

    LightMapVerifier::QuadBound oneQuad(int x, int y) {
        LargestBounds bounds;
        withCoveredQuad(rows_, x, y, [&](const CoveredQuad& quad) {
            if (quad.isInside()) {
                quads_.boundQuad(x, y);
                bounds = quads_.largest();
            } else {
                RimBounds(rows_, tolerance_, evaluator_).raise(quad, bounds);
            }
        });
        return {bounds.diffuse.bound, bounds.specular.bound};
    }

    LightMapVerifier::AreaVisibleBound visibleBound(const TexelArea& area) {
        const auto& visible = evaluator_.setup().visible;
        if (!visible) return {};
        VisibleBounds bounds(rows_, tolerance_, evaluator_, *visible, 0, 0);
        bounds.boundArea(area);
        return {bounds.diffuse().bound, bounds.specular().bound, bounds.diffuse().place, bounds.specular().place};
    }

private:
    /// Work of the exact bounds of local relative errors (LargestBounds) for a strip and for each of its texels, and the share of it that
    /// the texel centres of each stage have. The example under basis-4 needs 24 a texel, other public scenes less.
    static constexpr double kWorkOfStrip = 200000, kWorkPerTexel = 32, kShareOfCentres = 0.25;
    static constexpr double kHardlyVisible = 0.5;  ///< [just noticeable differences]

    std::size_t stages() const { return rows_.decoder().stages(); }
    /// Returns the largest bounds of local relative errors over the places of these rows.
    LargestBounds boundPlaces(int firstRow, int rowCount) {
        for (const auto& [x, y] : worstSampled_)
            if (x >= 0) quads_.boundQuad(x, y);
        quads_.boundRows(firstRow, rowCount);
        quads_.refineDeferred();
        LargestBounds bounds = quads_.largest();
        RimBounds(rows_, tolerance_, evaluator_).raiseRows(firstRow, rowCount, bounds);
        return bounds;
    }
    /// Makes room for the errors of tiles that a place of these rows is in.
    void countTiles(int firstRow, int rowCount) {
        if (!sampling_.isForTrial() || sampling_.tileLimits.empty()) return;
        const int first = firstRow / formats::kCoverageRows,
                  end = std::min(firstRow + rowCount, rows_.height() - 1) / formats::kCoverageRows + 1;
        for (LightMapErrors::Stage& stage : errors_.stages)
            stage.tiles = TileErrors(sampling_.tileLimits, index(first * tiles_.x), index((end - first) * tiles_.x));
    }
    /// Bounds the visible errors of the last stage, wherever its light is sampled.
    void boundVisible(int firstRow, int rowCount) {
        const auto& visible = evaluator_.setup().visible;
        if (!visible) return;
        ShadedErrors& surface = errors_.surface;
        const ShadedErrors& centres = errors_.stages.back().errors;
        // Bounds of at most this need not be tight: they are within the search's own accuracy of what was sampled, or hardly visible. Light
        // that is not finite differs by more than any two numbers.
        const auto enough = [&](VisibleAccumulator ShadedErrors::*kind) {
            const double largest = std::max((surface.*kind).largest(), (centres.*kind).largest()), most = visible->metric.mostVisible();
            const double within = std::max(VisibleSearch::kConvergedFactor * largest, kHardlyVisible);
            return largest <= most ? std::min(within, most) : within;
        };
        const double diffuse = enough(&ShadedErrors::visibleDiffuse), specular = enough(&ShadedErrors::visibleSpecular);
        VisibleBounds bounds(rows_, tolerance_, evaluator_, *visible, diffuse, specular);
        bounds.boundArea({0, firstRow, rows_.width(), rowCount});
        const auto raise = [](VisibleAccumulator& errors, const VisibleMaximum& found, double threshold) {
            errors.addBound(std::max(found.bound, threshold), found.bound < threshold ? errors.maxAt() : found.place);
        };
        raise(surface.visibleDiffuse, bounds.diffuse(), diffuse);
        if (!visible->specular.isNone()) raise(surface.visibleSpecular, bounds.specular(), specular);
    }
    void addBounds(ShadedErrors& errors, const LargestBounds& largest) const {
        errors.diffuse.addBound(largest.diffuse.bound, largest.diffuse.place);
        if (evaluator_.setup().hasSpecular()) errors.specular.addBound(largest.specular.bound, largest.specular.place);
    }
    /// Sets the light of the place of a quad's bound: what filtered bake and textures decode to there, shaded in the bound's direction. The
    /// bound was reached by control vectors, which are no values of the map.
    void decodeAt(LargestBound& largest) const {
        ErrorPlace& place = largest.place;
        if (!place.isKnown()) return;
        const int x = static_cast<int>(place.x);
        const int y = std::min(static_cast<int>(place.y), rows_.lastRow() - 1);
        const glm::vec2 at(place.x - x, place.y - y);
        withCoveredQuad(rows_, x, y, [&](const CoveredQuad& quad) {
            const int nearest = nearestCorner(at);
            const auto light = [&](const LcSh& sh) {
                return shadedAbout(channelsOf(sh)[index(*place.channel)], largest.bands, place.normal) /
                       static_cast<double>(rows_.perKey());
            };
            place.reference = light(quad.referenceAt(at).first);
            place.found = light(rows_.decoded(quad.texelsAt(at).data(), quad.texelX(nearest), quad.texelY(nearest)));
        });
    }
    /// Returns the diffuse light that the texels of a place show, whose surface is that of texel (x, y). Empty: coefficients have it.
    ShownLight shownBy(LayerTexels texels, int x, int y) const {
        const MapDecoder& decoder = rows_.decoder();
        if (!decoder.isInTangentSpace()) return {};
        return [&decoder, texels, cluster = decoder.clusterAt(x, y)](const glm::vec3& normal) {
            return decoder.exitRadiance(texels, cluster, normal);
        };
    }
    /// Calls work(stage, error) for the light that each stage decodes from the texels of a place, whose surface is that of texel (x, y).
    template <class Work>
    void forEachStage(LayerTexels texels, const LcSh& reference, int x, int y, Work&& work) const {
        std::array<LcSh, kMostStages> light;
        rows_.decoder().decodeStages(texels, reference, rows_.decoder().clusterAt(x, y), light);
        for (std::size_t stage = 0; stage < stages(); ++stage) work(stage, difference(light[stage], reference));
    }

    void shadeCentre(const MapRows::Row& row, int x, int y) {
        const LcSh& reference = row.reference[index(x)];
        const LayerTexels texels = row.texelsAt(index(x));
        shader_.setReference(reference, rows_.normalAt(x, y), {x, y});
        const ShownLight shown = shownBy(texels, x, y);
        forEachStage(texels, reference, x, y, [&](std::size_t stage, const LcSh& error) {
            shader_.add(error, errors_.stages[stage].errors, shown);
            if (!sampling_.hasBounds()) return;
            // Bounds of earlier stages are those of an ideal sampler.
            const bool isLast = stage + 1 == stages();
            ChannelSlack slack = isLast ? tolerance_.centreSlack(texels, x, y) : ChannelSlack{};
            addBesideSh(slack, rows_.decoder(), {texels, texels, texels, texels});
            boundCentre(largest_[stage], error, reference, slack, x, y);
        });
    }
    void boundCentre(LargestBounds& largest, const LcSh& error, const LcSh& reference, const ChannelSlack& tolerance, int x, int y) const {
        BandLengths all = bandLengths(error);
        for (std::size_t l = 0; l < 3; ++l)
            for (std::size_t c = 0; c < kChannels; ++c)
                all[3 * l + c] = kOutwardFloat * (all[3 * l + c] + static_cast<float>(kShadingRounding) * all[3 * l + c] +
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

    /// Shades a random place of a quad, if it is on a surface.
    void shadePlace(const CoveredQuad& quad, int sample) {
        const glm::vec2 at = RandomPlace(sampling_.seed, quad, sampling_.placesPerTexel, sample).inQuad();
        const int nearest = nearestCorner(at);
        if (!quad.hasQuarter(nearest)) return;
        const int x = quad.texelX(nearest), y = quad.texelY(nearest);
        const LcSh reference = quad.referenceAt(at).first;
        const FilteredTexels texels = quad.texelsAt(at);
        shader_.setReference(reference, rows_.normalAt(x, y), quad.inMap(glm::dvec2(at)));
        const ShownLight shown = shownBy(texels.data(), x, y);
        if (sampling_.isForTrial()) {
            const std::size_t tile = index(y / formats::kCoverageRows * tiles_.x + x / formats::kCoverageColumns);
            forEachStage(texels.data(), reference, x, y, [&](std::size_t stage, const LcSh& error) {
                LightMapErrors::Stage& errors = errors_.stages[stage];
                if (sampling_.isLastStageAlone && stage + 1 < stages()) return;
                shader_.add(error, errors.errors, shown, errors.tiles.isEmpty() ? nullptr : &errors.tiles, tile);
            });
            return;
        }
        ShadedErrors& errors = errors_.surface;
        const std::array<double, 2> before = {errors.diffuse.maxSampled(), errors.specular.maxSampled()};
        const double light = diffuseSquare(reference);
        forEachStage(texels.data(), reference, x, y, [&](std::size_t stage, const LcSh& error) {
            DiffuseSquares& squares = errors_.stages[stage].surface;
            squares.error += diffuseSquare(error);
            squares.reference += light;
            if (stage + 1 == stages()) shader_.add(error, errors, shown);
        });
        const std::array<double, 2> after = {errors.diffuse.maxSampled(), errors.specular.maxSampled()};
        for (std::size_t kind = 0; kind < after.size(); ++kind)
            if (after[kind] > before[kind] && quad.isInside()) worstSampled_[kind] = {quad.x, quad.y};
    }

    const std::shared_ptr<const MapDecoder> decoder_;
    const MapRows rows_;
    const LightMapSampling& sampling_;
    const SamplerTolerance tolerance_;
    const BoundEvaluator evaluator_;
    QuadBounds quads_;
    LightMapErrors errors_;
    std::vector<LargestBounds> largest_;  ///< [stage], at texel centres
    ErrorShader shader_;
    glm::ivec2 tiles_;                                                       ///< of the map, along each axis
    std::array<std::pair<int, int>, 2> worstSampled_{{{-1, -1}, {-1, -1}}};  ///< quads with the worst diffuse and specular samples
};

}  // namespace

LightMapErrors verifyRows(LightMapErrors errors, const RowInputs& inputs, int firstRow, int rowCount) {
    return RowVerifier(std::move(errors), inputs).run(firstRow, rowCount);
}

LightMapVerifier::QuadBound boundQuad(LightMapErrors errors, const RowInputs& inputs, int x, int y) {
    return RowVerifier(std::move(errors), inputs).oneQuad(x, y);
}

LightMapVerifier::AreaVisibleBound visibleBound(LightMapErrors errors, const RowInputs& inputs, const TexelArea& area) {
    return RowVerifier(std::move(errors), inputs).visibleBound(area);
}

}  // namespace lightcook::verify::lightmap
