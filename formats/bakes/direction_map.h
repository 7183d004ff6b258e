// Bakes of two images: a colour a texel, and a direction map that the three colours share. What a white surface shows is linear in its
// normal, so order 1 of SH holds it exactly.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

/// Exit radiance of a texel as a multiple of its colour: E(n) / pi = colour * (constant + n . linear).
struct DirectedResponse {
    float constant = 0;
    glm::vec3 linear{0};  ///< world axes of the bake
};

/// Decodes the direction map of one format.
struct DirectionMapDecode {
    /// Returns the response of a stored texel (R, G, B, A; A is 1 without alpha). Empty: such a texel is no direction.
    std::optional<DirectedResponse> (*response)(const glm::vec4& stored);
    bool needsAlpha = false;
    std::string_view expected;  ///< completes "expected ..." of an error; errors need it only where a response can be empty
};

/// Opens a bake whose first image is the colour, exit radiance, and whose second is the direction map. Coverage is coverage.Y or alpha of
/// the first. Fails if the map lacks the alpha that the format needs. A covered texel with light but no direction fails when it is read.
Result<std::unique_ptr<BakeReader>> openDirectionMap(std::vector<BakeImage> images, const DirectionMapDecode& decode);

}  // namespace lightcook::formats
