#include "verify/light_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

#include "lighting/radiometry.h"
#include "verify/light_map/bound.h"
#include "verify/light_map/bound_evaluator.h"
#include "verify/light_map/layouts.h"
#include "verify/light_map/shading.h"
#include "verify/light_map/verified_rows.h"

namespace lightcook::verify {

namespace {

constexpr double kLogUnits = 1 << 24;

}  // namespace

void LightMapKey::add(const formats::LightMapStrip& strip, int firstRow, int rowCount) {
    assert(firstRow >= strip.firstRow && firstRow + rowCount <= strip.firstRow + strip.sh.height());
    for (int y = firstRow - strip.firstRow; y < firstRow - strip.firstRow + rowCount; ++y)
        for (int x = 0; x < strip.sh.width(); ++x) {
            if (strip.covered.at(x, y) == 0) continue;
            const lighting::ShRgb exit = lighting::convolve(strip.sh.at(x, y), lighting::kExitRadianceBands);
            const float luminance = glm::dot(lighting::evaluate(exit, strip.normal.at(x, y)), luminanceWeights_);
            logLuminanceSum_ += std::llround(std::log(std::max(static_cast<double>(luminance), 1e-12)) * kLogUnits);
            ++coveredTexels_;
        }
}

void LightMapKey::merge(const LightMapKey& other) {
    logLuminanceSum_ += other.logLuminanceSum_;
    coveredTexels_ += other.coveredTexels_;
}

double LightMapKey::key() const {
    return coveredTexels_ == 0 ? 0 : std::exp(static_cast<double>(logLuminanceSum_) / kLogUnits / static_cast<double>(coveredTexels_));
}

void LightMapErrors::merge(const LightMapErrors& other) {
    if (accumulators.empty()) {
        accumulators = other.accumulators;
        return;
    }
    assert(accumulators.size() == other.accumulators.size());
    for (std::size_t i = 0; i < accumulators.size(); ++i) {
        accumulators[i].diffuse.merge(other.accumulators[i].diffuse);
        accumulators[i].specular.merge(other.accumulators[i].specular);
    }
}

std::vector<StageError> LightMapErrors::stages() const {
    std::vector<StageError> out;
    for (const Stage& stage : accumulators) out.push_back({stage.name, stage.diffuse.figures(), stage.specular.figures(), 0});
    if (out.size() < 2) return out;
    // The verdict: the last stage at texel centres, raised to the maxima between them.
    StageError total = out[out.size() - 2];
    const StageError& magnified = out.back();
    takeLarger(total.diffuse, magnified.diffuse);
    takeLarger(total.specular, magnified.specular);
    total.name = "total";
    out.push_back(total);
    return out;
}

struct LightMapVerifier::State {
    CookedLightMap map;
    LightMapShading shading;
    LightMapSampling sampling;
    float perKey = 1;  ///< light in units of the key
    layouts::Layout layout;
    std::vector<TextureNeed> textures;
    ShadingSetup setup;

    lightmap::RowInputs inputs(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference) const {
        return {map, sampling, setup, perKey, texels, reference};
    }
};

formats::Result<LightMapVerifier> LightMapVerifier::create(const CookedLightMap& map, const LightMapShading& shading,
                                                           const LightMapSampling& sampling, double key) {
    if (map.width < 1 || map.height < 1)
        return formats::failure(formats::ErrorCode::WrongShape, "light map layout " + map.layout,
                                "found " + std::to_string(map.width) + "x" + std::to_string(map.height) + " texels, expected at least 1x1");
    if (auto error = checkShading(shading)) return tl::make_unexpected(*error);
    auto layout = layouts::layoutOf(map);
    if (!layout) return tl::make_unexpected(layout.error());

    auto state = std::make_unique<State>();
    state->map = map;
    state->shading = shading;
    state->sampling = sampling;
    state->perKey = key > 0 ? static_cast<float>(1 / key) : 1.0f;
    state->layout = *layout;
    state->textures = layouts::texturesOf(*layout);
    ShadingSetup& setup = state->setup;
    if (!map.formats.empty()) {
        if (map.formats.size() != state->textures.size())
            return formats::failure(
                formats::ErrorCode::WrongShape, "light map layout " + map.layout,
                "found formats of " + std::to_string(map.formats.size()) + " textures, expected " + std::to_string(state->textures.size()));
        for (std::size_t i = 0; i < map.formats.size(); ++i)
            setup.tolerance.insert(setup.tolerance.end(), static_cast<std::size_t>(state->textures[i].layerCount),
                                   toleranceOf(map.formats[i]));
    }
    auto* flat = std::get_if<layouts::Flat>(&state->layout);
    if (flat != nullptr) flat->isOwnNormalOnly = !shading.needsDirections();
    if (flat != nullptr && flat->isOwnNormalOnly) {
        setup.diffuse = flatMatrix();
    } else {
        setup.diffuse = diffuseMatrix(shading.normalCount);
        if (shading.specular) setup.specular = specularMatrix(shading);
        if (shading.specular && sampling.bounds) setup.responses = specularResponses(shading);
        for (const Response& response : setup.responses)
            for (std::size_t l = 0; l < 3; ++l) setup.largestResponse[l] = std::max(setup.largestResponse[l], response.norms()[l]);
    }
    return LightMapVerifier(std::move(state));
}

LightMapVerifier::LightMapVerifier(std::unique_ptr<const State> state) : state_(std::move(state)) {}
LightMapVerifier::LightMapVerifier(LightMapVerifier&&) noexcept = default;
LightMapVerifier& LightMapVerifier::operator=(LightMapVerifier&&) noexcept = default;
LightMapVerifier::~LightMapVerifier() = default;

formats::Result<std::vector<LightMapVerifier::TextureNeed>> LightMapVerifier::texturesOf(const CookedLightMap& map) {
    const auto layout = layouts::layoutOf(map);
    if (!layout) return tl::make_unexpected(layout.error());
    return layouts::texturesOf(*layout);
}

const std::vector<LightMapVerifier::TextureNeed>& LightMapVerifier::textures() const {
    return state_->textures;
}

LightMapErrors LightMapVerifier::noErrors() const {
    std::vector<LightMapErrors::Stage> stages;
    const auto add = [&](std::string_view name) { stages.push_back({std::string(name), ErrorAccumulator(1), ErrorAccumulator(1)}); };
    for (const std::string_view name : layouts::infoOf(state_->layout).stages) add(name);
    add("magnified");
    return LightMapErrors(std::move(stages));
}

LightMapErrors LightMapVerifier::verifyRows(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference, int firstRow,
                                            int rowCount) const {
    assert(texels.textures.size() == state_->textures.size());
    assert(reference.sh.width() == state_->map.width && firstRow >= reference.firstRow && firstRow >= texels.firstRow);
    assert(reference.firstRow + reference.sh.height() >= std::min(state_->map.height, firstRow + rowCount + state_->sampling.bounds));
    return std::visit(
        [&](const auto& layout) { return lightmap::verifyRows(layout, noErrors(), state_->inputs(texels, reference), firstRow, rowCount); },
        state_->layout);
}

LightMapVerifier::QuadBound LightMapVerifier::boundQuad(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference, int x,
                                                        int y) const {
    return std::visit([&](const auto& layout) { return lightmap::boundQuad(layout, noErrors(), state_->inputs(texels, reference), x, y); },
                      state_->layout);
}

formats::Image<lighting::ShRgb> LightMapVerifier::reconstruct(const DecodedLightMapRows& texels, int firstRow, int rowCount) const {
    assert(texels.textures.size() == state_->textures.size() && firstRow >= texels.firstRow);
    formats::Image<lighting::ShRgb> out(state_->map.width, rowCount);
    std::visit(
        [&](const auto& layout) {
            using Layout = std::decay_t<decltype(layout)>;
            for (int y = 0; y < rowCount; ++y)
                for (int x = 0; x < state_->map.width; ++x) {
                    layouts::Texels<Layout::kLayers> filtered{};
                    std::size_t layer = 0;
                    for (const auto& texture : texels.textures)
                        for (const formats::Image<glm::vec4>& image : texture)
                            filtered[layer++] = image.at(x, firstRow - texels.firstRow + y);
                    const shaders::LcSh sh = layouts::decodeAt(layout, x, firstRow + y).decode(filtered);
                    std::copy_n(sh.c, lighting::kShCount, out.at(x, y).begin());
                }
        },
        state_->layout);
    return out;
}

}  // namespace lightcook::verify
