#include "verify/light_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

#include "lighting/radiometry.h"
#include "verify/light_map/bound.h"
#include "verify/light_map/light_map_state.h"

namespace lightcook::verify {

namespace {

constexpr double kLogUnits = 1 << 24;

}  // namespace

LightMapKey::LightMapKey(const glm::vec3& luminanceWeights, bool isCoverageKnown)
    : luminanceWeights_(luminanceWeights),
      isCoverageKnown_(isCoverageKnown),
      bins_(static_cast<std::size_t>((kHighestExponent - kLowestExponent) * kBinsPerOctave)) {}

void LightMapKey::add(const formats::LightMapStrip& strip, int firstRow, int rowCount) {
    assert(firstRow >= strip.firstRow && firstRow + rowCount <= strip.firstRow + strip.sh.height());
    for (int y = firstRow - strip.firstRow; y < firstRow - strip.firstRow + rowCount; ++y)
        for (int x = 0; x < strip.sh.width(); ++x) {
            if (strip.covered.at(x, y) == 0 || (!isCoverageKnown_ && strip.sh.at(x, y) == lighting::ShRgb{})) continue;
            const lighting::ShRgb exit = lighting::convolve(strip.sh.at(x, y), lighting::kExitRadianceBands);
            const float luminance = glm::dot(lighting::evaluate(exit, strip.normal.at(x, y)), luminanceWeights_);
            const double logarithm = std::log(std::max(static_cast<double>(luminance), 1e-12));
            const int bin = static_cast<int>(std::floor((logarithm / std::numbers::ln2 - kLowestExponent) * kBinsPerOctave));
            Bin& found = bins_[static_cast<std::size_t>(std::clamp(bin, 0, static_cast<int>(bins_.size()) - 1))];
            found.logSum += std::llround(logarithm * kLogUnits);
            ++found.texels;
        }
}

void LightMapKey::merge(const LightMapKey& other) {
    for (std::size_t i = 0; i < bins_.size(); ++i) {
        bins_[i].texels += other.bins_[i].texels;
        bins_[i].logSum += other.bins_[i].logSum;
    }
}

LightMapKey::Bin LightMapKey::sum() const {
    Bin all;
    for (const Bin& bin : bins_) {
        all.texels += bin.texels;
        all.logSum += bin.logSum;
    }
    return all;
}

double LightMapKey::key() const {
    const Bin all = sum();
    return all.texels == 0 ? 0 : std::exp(static_cast<double>(all.logSum) / kLogUnits / static_cast<double>(all.texels));
}

double LightMapKey::displayKey() const {
    const std::int64_t texels = coveredTexels();
    if (texels == 0) return 0;
    const auto meanLog = [](const Bin& bin) { return static_cast<double>(bin.logSum) / kLogUnits / static_cast<double>(bin.texels); };
    // The luminances of a bin are so close that their geometric mean is their mean.
    double mean = 0;
    for (const Bin& bin : bins_)
        if (bin.texels > 0) mean += static_cast<double>(bin.texels) / static_cast<double>(texels) * std::exp(meanLog(bin));
    if (mean < kBlackMean) return 0;
    double logSum = 0;
    for (const Bin& bin : bins_)
        if (bin.texels > 0) logSum += static_cast<double>(bin.texels) * std::max(meanLog(bin), std::log(kDarkestShare * mean));
    return std::exp(logSum / static_cast<double>(texels));
}

void ShadedErrors::merge(const ShadedErrors& other) {
    diffuse.merge(other.diffuse);
    specular.merge(other.specular);
    visibleDiffuse.merge(other.visibleDiffuse);
    visibleSpecular.merge(other.visibleSpecular);
}

namespace {
ErrorFigures figuresOf(const ErrorAccumulator& energy, const VisibleAccumulator& visible) {
    ErrorFigures figures = energy.figures();
    if (visible.sampleCount() > 0) figures.visible = visible.figures();
    return figures;
}
}  // namespace

ErrorFigures ShadedErrors::diffuseFigures() const {
    return figuresOf(diffuse, visibleDiffuse);
}

ErrorFigures ShadedErrors::specularFigures() const {
    return figuresOf(specular, visibleSpecular);
}

void DiffuseSquares::merge(const DiffuseSquares& other) {
    error += other.error;
    reference += other.reference;
}

double DiffuseSquares::relRms() const {
    return reference > 0 ? std::sqrt(error / reference) : 0;
}

void LightMapErrors::merge(const LightMapErrors& other) {
    if (stages.empty()) {
        *this = other;
        return;
    }
    assert(stages.size() == other.stages.size());
    for (std::size_t i = 0; i < stages.size(); ++i) {
        stages[i].errors.merge(other.stages[i].errors);
        stages[i].surface.merge(other.stages[i].surface);
        stages[i].tiles.merge(other.stages[i].tiles);
    }
    surface.merge(other.surface);
}

std::vector<StageError> LightMapErrors::figures() const {
    std::vector<StageError> out;
    for (const Stage& stage : stages) out.push_back({stage.name, stage.errors.diffuseFigures(), stage.errors.specularFigures()});
    if (out.empty()) return out;
    const bool isOnSurface = surface.diffuse.sampleCount() > 0;
    ShadedErrors whole = surface;
    if (!isOnSurface) whole.merge(stages.back().errors);
    StageError total{"total", whole.diffuseFigures(), whole.specularFigures()};
    if (isOnSurface) {
        total.atTexels = {out.back().diffuse, out.back().specular};
        takeLargerMaxima(total.diffuse, total.atTexels->diffuse);
        takeLargerMaxima(total.specular, total.atTexels->specular);
    }
    out.push_back(std::move(total));
    return out;
}

namespace {

/// Returns the tolerance of each layer of a map's textures. None without formats, and where the shader filters.
formats::Result<std::vector<FormatTolerance>> tolerancesOf(const CookedLightMap& map,
                                                           const std::vector<LightMapVerifier::TextureNeed>& textures) {
    std::vector<FormatTolerance> tolerances;
    if (map.formats.empty() || map.filter == formats::LightMapFilter::Decoded) return tolerances;
    if (map.formats.size() != textures.size())
        return formats::failure(
            formats::ErrorCode::WrongShape, "light map layout " + map.layout,
            "found formats of " + std::to_string(map.formats.size()) + " textures, expected " + std::to_string(textures.size()));
    for (std::size_t i = 0; i < map.formats.size(); ++i)
        tolerances.insert(tolerances.end(), static_cast<std::size_t>(textures[i].layerCount), toleranceOf(map.formats[i]));
    return tolerances;
}

/// Returns the setup of the shading, without tolerances.
/// key              of the light that is shaded
/// isOwnNormalOnly  the map is shaded at its own normals alone, from a flat layout
ShadingSetup shadingSetup(const LightMapShading& shading, bool hasBounds, bool isOwnNormalOnly, double key,
                          const std::optional<Viewing>& viewing) {
    ShadingSetup setup;
    setup.matrices = shadingMatrices(shading, key, viewing);
    std::optional<ScannedKernels> scanned;
    if (isOwnNormalOnly) {
        setup.matrices.diffuse = flatMatrix();
        if (setup.matrices.visible) setup.matrices.visible->cap = flatMatrix();
    } else if (shading.specular && hasBounds) {
        scanned.emplace(shading);
        setup.responses = specularResponses(shading, *scanned);
    }
    for (const Response& response : setup.responses)
        for (std::size_t l = 0; l < 3; ++l) setup.largestResponse[l] = std::max(setup.largestResponse[l], response.norms()[l]);
    if (viewing && hasBounds) {
        const bool hasCap = shading.normalCount > 1 && !isOwnNormalOnly;
        setup.visible = visibleBoundSetup(shading, *viewing, key, hasCap ? shading.normalMapTilt : 0, scanned ? &*scanned : nullptr);
    }
    return setup;
}

}  // namespace

formats::Result<LightMapVerifier> LightMapVerifier::create(const CookedLightMap& map, const LightMapShading& shading,
                                                           const LightMapSampling& sampling, double key,
                                                           const std::optional<Viewing>& viewing) {
    if (map.width < 1 || map.height < 1)
        return formats::failure(formats::ErrorCode::WrongShape, "light map layout " + map.layout,
                                "found " + std::to_string(map.width) + "x" + std::to_string(map.height) + " texels, expected at least 1x1");
    if (auto error = checkShading(shading)) return tl::make_unexpected(*error);
    LC_TRY(layout, layouts::layoutOf(map));

    auto state = std::make_unique<State>();
    state->map = map;
    state->shading = shading;
    state->sampling = sampling;
    state->perKey = key > 0 ? static_cast<float>(1 / key) : 1.0f;
    state->layout = *layout;
    state->textures = layouts::texturesOf(*layout);
    state->map.filter = layouts::infoOf(*layout).filterFor(map.filter);
    if (!layouts::infoOf(*layout).mayHave(state->map.filter))
        return formats::failure(formats::ErrorCode::WrongShape, "light map layout " + map.layout,
                                "found the filter decoded, expected hardware, that of the engine's shader");
    LC_TRY(tolerances, tolerancesOf(state->map, state->textures));
    const bool isOwnNormalOnly = layouts::infoOf(state->layout).isFlat() && !shading.needsDirections();
    std::visit(
        [&](auto& each) {
            if constexpr (requires { each.isOwnNormalOnly; }) each.isOwnNormalOnly = isOwnNormalOnly;
        },
        state->layout);
    state->decoder = lightmap::mapDecoder(state->layout, state->perKey);
    if (map.detail) {
        const CookedLightMap detail{std::string(formats::info(formats::kDetailLayout).name), map.detail->constants};
        LC_TRY(ofDetail, layouts::layoutOf(detail));
        state->detail = std::move(*ofDetail);
    }
    if (state->map.filter == formats::LightMapFilter::Decoded)
        state->decoder =
            lightmap::mixedDecoder(state->decoder, state->detail ? lightmap::mapDecoder(*state->detail, state->perKey) : nullptr);
    state->setup = shadingSetup(shading, sampling.hasBounds(), isOwnNormalOnly, 1 / static_cast<double>(state->perKey), viewing);
    state->setup.tolerance = std::move(*tolerances);
    return LightMapVerifier(std::move(state));
}

LightMapVerifier::LightMapVerifier(std::unique_ptr<const State> state) : state_(std::move(state)) {}
LightMapVerifier::LightMapVerifier(LightMapVerifier&&) noexcept = default;
LightMapVerifier& LightMapVerifier::operator=(LightMapVerifier&&) noexcept = default;
LightMapVerifier::~LightMapVerifier() = default;

formats::Result<std::vector<LightMapVerifier::TextureNeed>> LightMapVerifier::texturesOf(const CookedLightMap& map) {
    LC_TRY(layout, layouts::layoutOf(map));
    return layouts::texturesOf(*layout);
}

const std::vector<LightMapVerifier::TextureNeed>& LightMapVerifier::textures() const {
    return state_->textures;
}

LightMapErrors LightMapVerifier::noErrors() const {
    std::vector<LightMapErrors::Stage> stages;
    for (const std::string_view name : layouts::infoOf(state_->layout).stages) stages.push_back({std::string(name), {}, {}});
    return LightMapErrors(std::move(stages));
}

LightMapErrors LightMapVerifier::verifyRows(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference, int firstRow,
                                            int rowCount) const {
    [[maybe_unused]] const bool needsRowBelow = state_->sampling.hasBounds() || state_->sampling.placesPerTexel > 0;
    assert(texels.textures.size() == state_->textures.size());
    assert(reference.sh.width() == state_->map.width && firstRow >= reference.firstRow && firstRow >= texels.firstRow);
    assert(reference.firstRow + reference.sh.height() >= std::min(state_->map.height, firstRow + rowCount + needsRowBelow));
    return lightmap::verifyRows(noErrors(), state_->inputs(texels, reference), firstRow, rowCount);
}

LightMapVerifier::QuadBound LightMapVerifier::boundQuad(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference, int x,
                                                        int y) const {
    return lightmap::boundQuad(noErrors(), state_->inputs(texels, reference), x, y);
}

LightMapVerifier::AreaVisibleBound LightMapVerifier::visibleBound(const DecodedLightMapRows& texels,
                                                                  const formats::LightMapStrip& reference, const TexelArea& area) const {
    return lightmap::visibleBound(noErrors(), state_->inputs(texels, reference), area);
}

formats::Image<lighting::ShRgb> LightMapVerifier::reconstruct(const DecodedLightMapRows& texels, int firstRow, int rowCount,
                                                              int placesPerTexel, const formats::LightMapStrip* surface) const {
    std::vector<int> columns(static_cast<std::size_t>(placesPerTexel) * static_cast<std::size_t>(state_->map.width));
    std::iota(columns.begin(), columns.end(), 0);
    return reconstructColumns(texels, firstRow, rowCount, placesPerTexel, surface, columns);
}

formats::Image<lighting::ShRgb> LightMapVerifier::reconstructColumns(const DecodedLightMapRows& texels, int firstRow, int rowCount,
                                                                     int placesPerTexel, const formats::LightMapStrip* surface,
                                                                     std::span<const int> columns) const {
    assert(texels.textures.size() == state_->textures.size() && firstRow >= texels.firstRow && placesPerTexel >= 1);
    const int width = state_->map.width, height = state_->map.height;
    formats::Image<lighting::ShRgb> out(static_cast<int>(columns.size()), placesPerTexel * rowCount);
    // The texels on both sides of a place along one axis, and the weight of the second.
    struct Between {
        int first, second;
        float weight;
        Between(int place, int placesPerTexel, int count) {
            const float at = (static_cast<float>(place) + 0.5f) / static_cast<float>(placesPerTexel) - 0.5f;
            const float below = std::floor(at);
            first = std::clamp(static_cast<int>(below), 0, count - 1);
            second = std::clamp(static_cast<int>(below) + 1, 0, count - 1);
            weight = at - below;
        }
    };
    const bool isInTangentSpace = layouts::infoOf(state_->layout).isInTangentSpace, isMixed = state_->decoder->isMixed();
    assert(!isInTangentSpace || surface != nullptr);
    assert(!isMixed || texels.covered.width() > 0);
    // In the units of the map.
    const std::shared_ptr<const lightmap::MapDecoder> decoder =
        isInTangentSpace ? lightmap::tangentDecoder(state_->layout, 1, *surface) : lightmap::mapDecoder(state_->layout, 1);
    const auto detail = state_->detail ? lightmap::mapDecoder(*state_->detail, 1) : nullptr;
    lightmap::FilteredTexels filtered;
    const auto decodedAt = [&](int x, int y) {
        std::size_t layer = 0;
        if (detail && texels.detail.has.at(x, y - texels.firstRow) != 0) {
            for (const auto& texture : texels.detail.textures)
                for (const formats::Image<glm::vec4>& image : texture) filtered[layer++] = image.at(x, y - texels.firstRow);
            return detail->decode(filtered.data(), 0);
        }
        for (std::size_t texture = 0; texture < texels.textures.size(); ++texture) {
            const int side = state_->textures[texture].side;
            for (const formats::Image<glm::vec4>& image : texels.textures[texture])
                filtered[layer++] = image.at(x / side, (y - texels.firstRow) / side);
        }
        return decoder->decode(filtered.data(), decoder->clusterAt(x, y));
    };
    // The light of the covered texels around a place; of all where none is.
    const auto mixedAt = [&](const Between& x, const Between& y) {
        const std::array<glm::ivec2, 4> at = {{{x.first, y.first}, {x.second, y.first}, {x.first, y.second}, {x.second, y.second}}};
        const glm::vec4 all((1 - x.weight) * (1 - y.weight), x.weight * (1 - y.weight), (1 - x.weight) * y.weight, x.weight * y.weight);
        glm::vec4 weights = all;
        for (int i = 0; i < 4; ++i)
            if (texels.covered.at(at[static_cast<std::size_t>(i)].x, at[static_cast<std::size_t>(i)].y - texels.firstRow) == 0)
                weights[i] = 0;
        const float sum = weights.x + weights.y + weights.z + weights.w;
        weights = sum > 0 ? weights / sum : all;
        shaders::LcSh mix{};
        for (int i = 0; i < 4; ++i) {
            if (!(weights[i] > 0)) continue;
            const shaders::LcSh each = decodedAt(at[static_cast<std::size_t>(i)].x, at[static_cast<std::size_t>(i)].y);
            for (std::size_t k = 0; k < lighting::kShCount; ++k) mix.c[k] += weights[i] * each.c[k];
        }
        return mix;
    };
    for (int row = 0; row < out.height(); ++row) {
        const int placeY = placesPerTexel * firstRow + row;
        const Between y(placeY, placesPerTexel, height);
        for (int index = 0; index < out.width(); ++index) {
            const int column = columns[static_cast<std::size_t>(index)];
            const Between x(column, placesPerTexel, width);
            if (isMixed) {
                const shaders::LcSh sh = placesPerTexel == 1 ? decodedAt(x.first, y.first) : mixedAt(x, y);
                std::copy_n(sh.c, lighting::kShCount, out.at(index, row).begin());
                continue;
            }
            std::size_t layer = 0;
            for (const auto& texture : texels.textures)
                for (const formats::Image<glm::vec4>& image : texture) {
                    const auto at = [&](int tx, int ty) { return image.at(tx, ty - texels.firstRow); };
                    const auto along = [&](int ty) { return glm::mix(at(x.first, ty), at(x.second, ty), x.weight); };
                    filtered[layer++] = placesPerTexel == 1 ? at(x.first, y.first) : glm::mix(along(y.first), along(y.second), y.weight);
                }
            const std::size_t cluster = decoder->clusterAt(column / placesPerTexel, placeY / placesPerTexel);
            const shaders::LcSh sh = decoder->decode(filtered.data(), cluster);
            std::copy_n(sh.c, lighting::kShCount, out.at(index, row).begin());
        }
    }
    return out;
}

}  // namespace lightcook::verify
