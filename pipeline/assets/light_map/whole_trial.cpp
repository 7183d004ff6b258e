#include "pipeline/assets/light_map/whole_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "pipeline/assets/light_map/whole_errors.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/scene/dominant_layout.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

template <class T>
void append(std::vector<T>& all, const std::vector<T>& more) {
    all.insert(all.end(), more.begin(), more.end());
}

formats::Image<glm::vec4> decoded(formats::PixelFormat format, const std::vector<std::byte>& bytes, const DominantEncoder& encoder,
                                  const EncodedDominantRows& rows) {
    formats::Image<glm::vec4> image(encoder.size().x, rows.rowCount);
    verify::decodeRows(format, bytes, image.view());
    return image;
}

/// Decodes encoded rows with the verifier's own decoders.
verify::DecodedDominantRows decodedRows(const DominantEncoder& encoder, const EncodedDominantRows& rows) {
    verify::DecodedDominantRows out{rows.firstRow, decoded(encoder.formats().direction, rows.direction, encoder, rows),
                                    decoded(encoder.formats().intensity, rows.intensity, encoder, rows)};
    if (encoder.hasResidual())
        addResidual(out.direction, decoded(encoder.formats().direction, rows.residual, encoder, rows), encoder.constants());
    return out;
}

}  // namespace

WholeTrial::WholeTrial(LightMapSource& source, std::vector<TrialRows> first, std::vector<TrialRows> rest, verify::WholeShader shader,
                       const verify::Viewing& viewing)
    : source_(&source),
      first_(std::move(first)),
      rest_(std::move(rest)),
      shader_(std::move(shader)),
      viewing_(viewing),
      places_(source.width(), source.height()) {
    std::set<int> strips;
    for (const auto* rows : {&first_, &rest_})
        for (const TrialRows& each : *rows) strips.insert(each.strip);
    strips_.assign(strips.begin(), strips.end());
}

Result<WholeTrial> WholeTrial::create(LightMapSource& source, std::vector<TrialRows> first, std::vector<TrialRows> rest,
                                      const verify::LightMapShading& shading, const verify::Viewing& viewing) {
    LC_TRY(shader, verify::WholeShader::create(shading));
    return WholeTrial(source, std::move(first), std::move(rest), std::move(*shader), viewing);
}

std::vector<float> WholeTrial::shadeLightMap(const verify::LightMapVerifier& verifier, double key,
                                             const verify::DecodedLightMapRows& decoded, const formats::LightMapStrip& texels,
                                             const TrialRows& rows) const {
    const std::vector<SurfacePlace> places = places_.of(texels, source_->stripFirstRow(rows.strip), source_->stripRows(rows.strip),
                                                        rows.firstRow, rows.firstRow + rows.rowCount);
    const std::size_t count = 3 * shader_.stride();
    std::vector<float> samples(places.size() * count), derived(count);
    std::vector<lighting::ShRgb> light(verifier.lightCount());
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (!verifier.lightAt(decoded, texels, places[i].at, light)) continue;
        for (glm::vec3& coefficient : light.back()) coefficient *= static_cast<float>(key);
        const auto out = std::span(samples).subspan(i * count, count);
        shader_.shadeLightMap(light.back(), places[i].normal, out);
        if (!isDerived_) continue;
        shader_.shadeDominant(verify::derivedLight(light.back(), places[i].normal), places[i].normal, derived);
        for (std::size_t k = 0; k < count; ++k) out[k] += derived[k];
    }
    return samples;
}

Result<WholeTrial::LitStrip> WholeTrial::shadeStrip(int strip, const ShadeRows& shade) const {
    LC_TRY(texels, source_->stripWithMargin(strip, 0, 0));
    LitStrip lit;
    for (const auto& [rows, out] : {std::pair(&first_, &lit.first), std::pair(&rest_, &lit.rest)}) {
        std::vector<SurfacePlace> places;
        for (const TrialRows& each : *rows) {
            if (each.strip != strip) continue;
            std::vector<SurfacePlace> more =
                places_.of(*texels, source_->stripFirstRow(strip), source_->stripRows(strip), each.firstRow, each.firstRow + each.rowCount);
            std::ranges::move(more, std::back_inserter(places));
        }
        *out = shade(places);
    }
    return lit;
}

template <class Shade>
Result<WholeTrial::LitRows> WholeTrial::shadeStrips(const ActionContext& context, const std::string& what, Shade shade) const {
    LitRows all, rest;
    const auto add = [](LitRows& to, const LitRows& rows) {
        append(to.samples, rows.samples);
        append(to.tiles, rows.tiles);
    };
    LC_CHECK(foldInOrder<LitStrip>(
        static_cast<int>(strips_.size()), context, what, [&](int index) { return shade(strips_[static_cast<std::size_t>(index)]); },
        [&](const LitStrip& strip) {
            add(all, strip.first);
            add(rest, strip.rest);
        }));
    add(all, rest);
    return all;
}

/// Shades places by the bake and, with a fit, by its light.
WholeTrial::LitRows WholeTrial::shadeBake(const std::vector<SurfacePlace>& places, const std::optional<verify::DominantFit>& fit) const {
    LitRows lit{shadeReference(shader_, places, fit, source_->luminanceWeights()), {}};
    const int tilesAcross = formats::coverageSize(source_->width(), 1).x;
    for (const SurfacePlace& place : places) {
        const glm::ivec2 texel(glm::floor(place.at + 0.5));
        lit.tiles.push_back(
            static_cast<std::uint32_t>(texel.y / formats::kCoverageRows * tilesAcross + texel.x / formats::kCoverageColumns));
    }
    return lit;
}

/// Shades the places of a strip by the stored light.
Result<WholeTrial::LitStrip> WholeTrial::shadeStored(int strip, const DominantEncoder& encoder, verify::DominantFit fit) const {
    LC_TRY(rows, encoder.encode(strip));
    const std::size_t count = 3 * shader_.stride();
    const DominantConstants& k = encoder.constants();
    const verify::CookedDominant map{k.directionScale, k.directionBias, k.intensityRange, source_->width(), source_->height(), fit};
    const verify::DominantVerifier verifier(map, {}, source_->luminanceWeights(), 0);
    const verify::DecodedDominantRows decoded = decodedRows(encoder, *rows);
    return shadeStrip(strip, [&](const std::vector<SurfacePlace>& places) {
        LitRows lit{std::vector<float>(places.size() * count), {}};
        for (std::size_t i = 0; i < places.size(); ++i)
            shader_.shadeDominant(verifier.decode(decoded, places[i].at.x, places[i].at.y), places[i].normal,
                                  std::span(lit.samples).subspan(i * count, count));
        return lit;
    });
}

Result<void> WholeTrial::start(const std::optional<DominantTrial>& dominant, const DominantParameters& parameters,
                               const ActionContext& context) {
    std::optional<verify::DominantFit> fit;
    if (dominant) {
        LC_TRY(known, dominantFitOf(context.action.asset, dominant->fit));
        fit = (*known)->verified;
    }
    isDerived_ = dominant && dominant->layout == kDerivedDominant;
    const bool isStored = dominant && dominant->layout == kStoredDominant;
    const double reference = isStored ? 0.1 : 1;  // of the time, about
    LC_TRY(lit, shadeStrips(context.between(0, reference), fmt::format("shade {}", context.action.asset), [&](int strip) {
               return shadeStrip(strip, [&](const std::vector<SurfacePlace>& places) { return shadeBake(places, fit); });
           }));
    reference_ = std::move(lit->samples);
    tiles_ = std::move(lit->tiles);
    if (!isStored) return {};
    LC_TRY(encoder, DominantEncoder::create(*source_, parameters, context.between(reference, 0.2)));
    LC_TRY(stored, shadeStrips(context.between(0.2, 1), fmt::format("try the dominant light of {}", context.action.asset),
                               [&](int strip) { return shadeStored(strip, *encoder, *fit); }));
    stored_ = std::move(stored->samples);
    return {};
}

void WholeTrial::add(const std::string& layout, const std::vector<float>& samples) {
    verify::WholeErrors& errors = errors_[layout];
    const std::size_t first = 3 * shader_.stride() * errors.squaredErrors.size();
    const auto light = stored_.empty() ? std::span<const float>() : std::span(stored_).subspan(first, samples.size());
    errors.append(verify::wholeErrors(std::span(reference_).subspan(first, samples.size()), samples, light, shader_.sampleCount(),
                                      shader_.stride(), viewing_));
}

WholeCandidate WholeTrial::candidateOf(const std::string& layout) const {
    const verify::WholeErrors& errors = errors_.at(layout);
    return {layout, errors.visibleFigures().p99, errors.relRms()};
}

WholeCandidate WholeTrial::candidateWith(const std::string& name, const std::string& layout, const std::string& detail,
                                         const std::vector<std::uint32_t>& tiles) const {
    const verify::WholeErrors &coarse = errors_.at(layout), &fine = errors_.at(detail);
    const std::size_t count = shader_.sampleCount(), places = std::min(coarse.squaredErrors.size(), fine.squaredErrors.size());
    verify::WholeErrors mixed;
    for (std::size_t place = 0; place < places; ++place) {
        const verify::WholeErrors& from = std::ranges::binary_search(tiles, tiles_[place]) ? fine : coarse;
        const auto visible = std::span(from.visible).subspan(place * count, count);
        mixed.visible.insert(mixed.visible.end(), visible.begin(), visible.end());
        mixed.squaredErrors.push_back(from.squaredErrors[place]);
        mixed.squaredLights.push_back(from.squaredLights[place]);
    }
    return {name, mixed.visibleFigures().p99, mixed.relRms()};
}

}  // namespace lightcook::pipeline
