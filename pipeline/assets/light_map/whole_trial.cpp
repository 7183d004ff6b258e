#include "pipeline/assets/light_map/whole_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "pipeline/graph/parallel_for.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

void append(std::vector<float>& all, const std::vector<float>& more) {
    all.insert(all.end(), more.begin(), more.end());
}

std::vector<float> sumOf(const std::vector<float>& a, const std::vector<float>& b) {
    std::vector<float> sum = a;
    for (std::size_t i = 0; i < b.size(); ++i) sum[i] += b[i];
    return sum;
}

/// Returns the RMS difference of two lights over the RMS of the first; no light counts as zeros.
double relRmsOf(const std::vector<float>& reference, const std::vector<float>& found) {
    double squares = 0, error = 0;
    for (std::size_t i = 0; i < reference.size(); ++i) {
        const double truth = static_cast<double>(reference[i]), off = truth - (found.empty() ? 0.0 : static_cast<double>(found[i]));
        squares += truth * truth;
        error += off * off;
    }
    return error == 0 ? 0 : std::sqrt(error / squares);
}

formats::Image<glm::vec4> decoded(formats::PixelFormat format, const std::vector<std::byte>& bytes, const DominantEncoder& encoder,
                                  const EncodedDominantRows& rows) {
    formats::Image<glm::vec4> image(encoder.size().x, rows.rowCount);
    verify::decodeRows(format, bytes, image.view());
    return image;
}

/// Decodes encoded rows with the verifier's own decoders, with or without the residual.
verify::DecodedDominantRows decodedRows(const DominantEncoder& encoder, const EncodedDominantRows& rows, bool hasResidual) {
    verify::DecodedDominantRows out{rows.firstRow, decoded(encoder.formats().direction, rows.direction, encoder, rows),
                                    decoded(encoder.formats().intensity, rows.intensity, encoder, rows)};
    if (hasResidual && encoder.hasResidual())
        addResidual(out.direction, decoded(encoder.formats().direction, rows.residual, encoder, rows), encoder.constants());
    return out;
}

/// Returns the first layout of each set that gives the same textures: a target without residuals has half as many.
std::vector<const DominantLayoutInfo*> distinctLayouts(const std::vector<std::string>& names, formats::Target target) {
    std::vector<const DominantLayoutInfo*> layouts;
    for (const DominantLayoutInfo& layout : allDominantLayouts()) {
        if (std::ranges::find(names, layout.name) == names.end()) continue;
        const auto isSame = [&](const DominantLayoutInfo* other) { return other->divisor == layout.divisor; };
        if (layout.divisor > 0 && !dominantFormatsOf(target).hasResidual && std::ranges::any_of(layouts, isSame)) continue;
        layouts.push_back(&layout);
    }
    return layouts;
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
    const std::size_t count = 3 * shader_.stride(), each = isDerivedTried_ ? 2 * count : count;
    std::vector<float> samples(places.size() * each);
    std::vector<lighting::ShRgb> light(verifier.lightCount());
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (!verifier.lightAt(decoded, texels, places[i].at, light)) continue;
        for (glm::vec3& coefficient : light.back()) coefficient *= static_cast<float>(key);
        const auto out = std::span(samples).subspan(i * each, each);
        shader_.shadeLightMap(light.back(), places[i].normal, out.first(count));
        if (isDerivedTried_) shader_.shadeDominant(verify::derivedLight(light.back(), places[i].normal), places[i].normal, out.last(count));
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

template <class Shade, class Append>
Result<void> WholeTrial::shadeStrips(const ActionContext& context, const std::string& what, Shade shade, Append append) const {
    std::vector<LitRows> rest;
    auto shaded = foldInOrder<LitStrip>(
        static_cast<int>(strips_.size()), context, what, [&](int index) { return shade(strips_[static_cast<std::size_t>(index)]); },
        [&](LitStrip&& strip) {
            append(strip.first);
            rest.push_back(std::move(strip.rest));
        });
    for (const LitRows& each : rest) append(each);
    return shaded;
}

/// Shades places by the bake and, with a fit, by its light.
WholeTrial::LitRows WholeTrial::shadeBake(const std::vector<SurfacePlace>& places, const std::optional<verify::DominantFit>& fit) const {
    const std::size_t count = 3 * shader_.stride();
    LitRows lit{std::vector<float>(places.size() * count),
                std::vector<float>(fit ? places.size() * count : 0),
                std::vector<float>(isDerivedTried_ ? places.size() * count : 0),
                {},
                {}};
    const int tilesAcross = formats::coverageSize(source_->width(), 1).x;
    verify::CookedDominant map;
    map.fit = fit.value_or(map.fit);
    const verify::DominantVerifier verifier(map, {}, source_->luminanceWeights(), 0);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const SurfacePlace& place = places[i];
        shader_.shadeLightMap(place.bake, place.normal, std::span(lit.bake).subspan(i * count, count));
        const glm::ivec2 texel(glm::floor(place.at + 0.5));
        lit.tiles.push_back(
            static_cast<std::uint32_t>(texel.y / formats::kCoverageRows * tilesAcross + texel.x / formats::kCoverageColumns));
        if (!fit) continue;
        const verify::DominantLightSample towardsNormal{glm::dvec3(place.normal), glm::dvec3(0)};  // decides between equally good lights
        shader_.shadeDominant(verifier.reference(place.bake, glm::dvec3(place.normal), towardsNormal), place.normal,
                              std::span(lit.light).subspan(i * count, count));
        if (isDerivedTried_)
            shader_.shadeDominant(verify::derivedLight(place.bake, place.normal), place.normal,
                                  std::span(lit.derived).subspan(i * count, count));
    }
    return lit;
}

/// Shades the places of a strip by the dominant layouts of one size.
Result<WholeTrial::LitStrip> WholeTrial::shadeDominants(int strip, const DominantEncoder& encoder,
                                                        const std::vector<const DominantLayoutInfo*>& layouts,
                                                        verify::DominantFit fit) const {
    LC_TRY(rows, encoder.encode(strip));
    const std::size_t count = 3 * shader_.stride();
    const DominantConstants& k = encoder.constants();
    const verify::CookedDominant map{k.directionScale, k.directionBias, k.intensityRange, source_->width(), source_->height(), fit,
                                     encoder.size().x, encoder.size().y};
    const verify::DominantVerifier verifier(map, {}, source_->luminanceWeights(), 0);
    return shadeStrip(strip, [&](const std::vector<SurfacePlace>& places) {
        LitRows lit;
        for (const DominantLayoutInfo* layout : layouts) {
            const verify::DecodedDominantRows decoded = decodedRows(encoder, *rows, layout->hasResidual);
            std::vector<float>& samples = lit.dominants.emplace_back(places.size() * count);
            for (std::size_t i = 0; i < places.size(); ++i)
                shader_.shadeDominant(verifier.decode(decoded, places[i].at.x, places[i].at.y), places[i].normal,
                                      std::span(samples).subspan(i * count, count));
        }
        return lit;
    });
}

Result<void> WholeTrial::shadeReference(const std::optional<verify::DominantFit>& fit, const ActionContext& context) {
    auto shaded = shadeStrips(
        context, fmt::format("shade {}", context.action.asset),
        [&](int strip) { return shadeStrip(strip, [&](const std::vector<SurfacePlace>& places) { return shadeBake(places, fit); }); },
        [&](const LitRows& rows) {
            append(bake_, rows.bake);
            append(light_, rows.light);
            append(derived_, rows.derived);
            tiles_.insert(tiles_.end(), rows.tiles.begin(), rows.tiles.end());
        });
    if (shaded) reference_ = sumOf(bake_, light_);
    return shaded;
}

Result<void> WholeTrial::tryDivisor(const DominantEncoder& encoder, const std::vector<const DominantLayoutInfo*>& layouts,
                                    verify::DominantFit fit, const ActionContext& context) {
    std::vector<std::vector<float>> samples(layouts.size());
    auto shaded = shadeStrips(
        context, fmt::format("try dominant light {} of {}", layouts.front()->name, context.action.asset),
        [&](int strip) { return shadeDominants(strip, encoder, layouts, fit); },
        [&](const LitRows& rows) {
            for (std::size_t i = 0; i < layouts.size(); ++i) append(samples[i], rows.dominants[i]);
        });
    if (!shaded) return shaded;
    for (std::size_t i = 0; i < layouts.size(); ++i)
        addDominant(layouts[i]->name, encoder.gpuBytes(layouts[i]->hasResidual), std::move(samples[i]));
    return {};
}

void WholeTrial::add(const std::string& layout, const std::vector<float>& samples) {
    const auto known = std::ranges::find(lightMaps_, layout, &Lit::layout);
    Lit& lit = known == lightMaps_.end() ? lightMaps_.emplace_back(Lit{layout}) : *known;
    const std::size_t count = 3 * shader_.stride();
    if (!isDerivedTried_) return append(lit.samples, samples);
    for (auto place = samples.begin(); place != samples.end(); place += static_cast<std::ptrdiff_t>(2 * count)) {
        const auto derived = place + static_cast<std::ptrdiff_t>(count);
        lit.samples.insert(lit.samples.end(), place, derived);
        lit.derived.insert(lit.derived.end(), derived, derived + static_cast<std::ptrdiff_t>(count));
    }
}

void WholeTrial::addDetailed(const std::string& name, const std::string& layout, const std::string& detail,
                             const std::vector<std::uint32_t>& tiles) {
    const Lit& fine = *std::ranges::find(lightMaps_, detail, &Lit::layout);
    Lit lit = *std::ranges::find(lightMaps_, layout, &Lit::layout);
    lit.layout = name;
    const std::size_t count = 3 * shader_.stride();
    for (std::vector<float> Lit::*part : {&Lit::samples, &Lit::derived}) {
        std::vector<float>& samples = lit.*part;
        samples.resize(std::min(samples.size(), (fine.*part).size()));
        for (std::size_t place = 0; place < samples.size() / count; ++place)
            if (std::ranges::binary_search(tiles, tiles_[place]))
                std::ranges::copy(std::span(fine.*part).subspan(place * count, count),
                                  samples.begin() + static_cast<std::ptrdiff_t>(place * count));
    }
    lightMaps_.push_back(std::move(lit));
}

void WholeTrial::addDominant(std::string_view layout, std::uint64_t bytes, std::vector<float> samples) {
    dominants_.push_back({std::string(layout), bytes, relRmsOf(light_, samples)});
    lights_.push_back({std::string(layout), std::move(samples)});
}

Result<void> WholeTrial::tryDominants(const std::optional<DominantTrial>& dominant, const DominantParameters& parameters,
                                      const ActionContext& context) {
    if (!dominant) return shadeReference({}, context);
    LC_TRY(fit, dominantFitOf(context.action.asset, dominant->fit));
    std::vector<const DominantLayoutInfo*> layouts = distinctLayouts(dominant->layouts, parameters.target);
    const auto derived = std::ranges::find(layouts, true, &DominantLayoutInfo::isDerived);
    isDerivedTried_ = derived != layouts.end() && (*fit)->verified == verify::DominantFit::Explained;
    if (derived != layouts.end()) layouts.erase(derived);
    constexpr double kReference = 0.05;  // of the time, about
    LC_CHECK(shadeReference((*fit)->verified, context.between(0, kReference)));
    const auto none = std::ranges::find(layouts, 0, &DominantLayoutInfo::divisor);
    if (none != layouts.end()) {
        addDominant((*none)->name, 0, {});
        layouts.erase(none);
        if (visibleOf(bake_, {}) < kUnseenDominant) return {};
    }
    if (isDerivedTried_) addDominant(std::ranges::find(allDominantLayouts(), true, &DominantLayoutInfo::isDerived)->name, 0, derived_);
    // A size costs as much as it has texels, and the measurement of the map.
    const auto lengthOf = [](const DominantLayoutInfo* layout) { return 0.25 + 1.0 / (layout->divisor * layout->divisor); };
    const auto endOfSize = [&](auto first) {
        return std::find_if(first, layouts.end(), [&](const auto* each) { return each->divisor != (*first)->divisor; });
    };
    double length = 0, from = kReference;
    for (auto first = layouts.begin(); first != layouts.end(); first = endOfSize(first)) length += lengthOf(*first);
    for (auto first = layouts.begin(); first != layouts.end();) {
        const auto end = endOfSize(first);
        const double to = from + (1 - kReference) * lengthOf(*first) / length;
        LC_TRY(encoder, DominantEncoder::create(*source_, parameters, **first, context.between(from, from + 0.1 * (to - from))));
        LC_CHECK(tryDivisor(*encoder, {first, end}, (*fit)->verified, context.between(from + 0.1 * (to - from), to)));
        from = to;
        first = end;
    }
    return {};
}

double WholeTrial::visibleOf(std::span<const float> a, std::span<const float> b) const {
    return verify::visibleErrorsOfSum(std::span(reference_).first(a.size()), a, b, shader_.sampleCount(), shader_.stride(), viewing_).p99;
}

std::vector<WholeCandidate> WholeTrial::pairsOf(const std::string& layout, const ActionContext& context) const {
    static const std::vector<Lit> kNoLights(1);
    const Lit& lit = *std::ranges::find(lightMaps_, layout, &Lit::layout);
    const std::vector<float>& map = lit.samples;
    const std::vector<Lit>& lights = lights_.empty() ? kNoLights : lights_;
    std::vector<WholeCandidate> pairs(lights.size());
    forEachIndex(lights.size(), context, fmt::format("compare layouts of {}", context.action.asset), [&](std::size_t i) {
        const DominantLayoutInfo* const dominant = dominantLayoutFromName(lights[i].layout);
        const std::vector<float>& samples = dominant != nullptr && dominant->isDerived ? lit.derived : lights[i].samples;
        const auto light = std::span(samples).first(std::min(map.size(), samples.size()));
        pairs[i] = {layout, lights[i].layout, visibleOf(map, light),
                    verify::relRmsOfSum(std::span(reference_).first(map.size()), map, light, shader_.sampleCount(), shader_.stride())};
    });
    return pairs;
}

}  // namespace lightcook::pipeline
