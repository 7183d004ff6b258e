// Views of a mesh around a texel of its light map, lit by the bake and by the cooked map.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <string>

#include "formats/error.h"
#include "pipeline/assets/rendered_view_files.h"
#include "verify/visible.h"

namespace lightcook::pipeline {

/// Smallest visible error that gets a picture.
inline constexpr float kLeastShown = 0.5f;
/// Returns the luminance that the display shows as a grey card.
double shownKey(const verify::Viewing& viewing);

struct CheckedLightMap;

/// Draws the mesh as a camera in front of a texel sees it, and writes both pictures into the action's folder. A pixel shows the exit
/// radiance of a white surface with the map's own normal, as the verifier measures it: the bake filtered between covered texels alone, the
/// cooked map decoded from filtered texels; shownKey() is middle grey. Empty if the mesh does not have the texel.
/// name  of the files, before their endings
formats::Result<std::optional<RenderedView>> writeRenderedView(const CheckedLightMap& map, const glm::ivec2& texel,
                                                               const std::string& name);

}  // namespace lightcook::pipeline
