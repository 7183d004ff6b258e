#include "verify/light_map.h"

#include <cassert>

#include "verify/light_map/shading.h"

namespace lightcook::verify {

struct LightMapScore::State {
    ShadingMatrices matrices;
    float perKey = 1;
};

formats::Result<LightMapScore> LightMapScore::create(const LightMapShading& shading, double key, const std::optional<Viewing>& viewing) {
    if (auto error = checkShading(shading)) return tl::make_unexpected(*error);
    auto state = std::make_unique<State>();
    state->perKey = key > 0 ? static_cast<float>(1 / key) : 1.0f;
    state->matrices = shadingMatrices(shading, 1 / static_cast<double>(state->perKey), viewing);
    return LightMapScore(std::move(state));
}

LightMapScore::LightMapScore(std::unique_ptr<const State> state) : state_(std::move(state)) {}
LightMapScore::LightMapScore(LightMapScore&&) noexcept = default;
LightMapScore& LightMapScore::operator=(LightMapScore&&) noexcept = default;
LightMapScore::~LightMapScore() = default;

namespace {

/// Adds the errors at one place. Both lights are converted to units of the key before the subtraction, as in LightMapVerifier.
void addPlace(const LightMapScore::Place& place, float perKey, ErrorShader& shader, ShadedErrors& errors) {
    shaders::LcSh inUnits{}, error{};
    for (std::size_t i = 0; i < lighting::kShCount; ++i) {
        inUnits.c[i] = perKey * place.reference[i];
        error.c[i] = perKey * place.found[i] - inUnits.c[i];
    }
    shader.setReference(inUnits, place.normal, place.texel);
    shader.add(error, errors);
}

}  // namespace

ShadedErrors LightMapScore::score(const formats::LightMapStrip& reference, formats::ImageView<const lighting::ShRgb> result,
                                  int firstRow) const {
    assert(reference.sh.width() == result.width && reference.firstRow <= firstRow &&
           firstRow + result.height <= reference.firstRow + reference.sh.height());
    ShadedErrors errors;
    ErrorShader shader(state_->matrices, 1 / static_cast<double>(state_->perKey));
    for (int y = 0; y < result.height; ++y) {
        const int stripRow = firstRow - reference.firstRow + y;
        for (int x = 0; x < result.width; ++x)
            if (reference.covered.at(x, stripRow) != 0)
                addPlace({glm::dvec2(x, firstRow + y), reference.sh.at(x, stripRow), result.at(x, y), reference.normal.at(x, stripRow)},
                         state_->perKey, shader, errors);
    }
    return errors;
}

ShadedErrors LightMapScore::score(std::span<const Place> places) const {
    ShadedErrors errors;
    ErrorShader shader(state_->matrices, 1 / static_cast<double>(state_->perKey));
    for (const Place& place : places) addPlace(place, state_->perKey, shader, errors);
    return errors;
}

}  // namespace lightcook::verify
