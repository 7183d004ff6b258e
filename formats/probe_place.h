// Position and region of a probe, read from the list of probes (JSON) beside the images.
#pragma once

#include <array>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "formats/error.h"

namespace lightcook::formats {

/// World space, scene units. Absent members are not known.
struct ProbePlace {
    std::optional<glm::dvec3> position;
    std::optional<std::array<glm::dvec3, 2>> box;  ///< lowest and highest corner of the room that reflections are corrected for
    std::optional<double> radius;                  ///< of the sphere that the probe lights
    bool isKnown() const { return position || box || radius; }
};
/// Loads "position" ([x, y, z]), "box" ([lowest, highest]) and "radius" of the probe whose "file" has this name.
Result<ProbePlace> loadProbePlace(const std::filesystem::path& json, const std::string& probeFileName);

/// Returns what is wrong with a box or a radius as an expectation, or an empty text.
std::string objectionToProbePlace(const ProbePlace& place);

}  // namespace lightcook::formats
