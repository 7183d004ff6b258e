// Views of a mesh around a texel of its light map, lit by the bake and by the cooked map. A mesh may have several light maps.
#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <optional>
#include <string>

#include "pipeline/assets/light_map/compared_map.h"
#include "pipeline/assets/results.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Smallest visible error that gets a picture.
inline constexpr float kLeastShown = 0.5f;
/// Returns the luminance that the display shows as a grey card.
double shownKey(const verify::Viewing& viewing);

/// A texel of one of several light maps.
struct MapTexel {
    std::size_t map = 0;  ///< number of the light map
    glm::ivec2 texel{0};
};

/// Draws the mesh as a camera in front of a texel sees it, and writes both pictures into the action's folder. A pixel shows the exit
/// radiance of a white surface with the map's own normal, as the verifier measures it: the bake filtered between covered texels alone, the
/// cooked map decoded from filtered texels; shownKey() is middle grey. Empty if the mesh does not have the texel.
/// name  of the files, before their endings
formats::Result<std::optional<RenderedView>> writeRenderedView(const LitSurface& surface, const MapTexel& texel,
                                                               const ActionContext& context, const std::string& name);

}  // namespace lightcook::pipeline
