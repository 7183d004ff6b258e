// Probes that the meshes of a scene use. Engines light a place by the probes around it, at most four (those of a tetrahedron); a probe
// that is not among the four nearest of any place of the meshes is never seen.
#pragma once

#include <cstddef>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/gltf_scene.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

inline constexpr std::size_t kProbesOfAPlace = 4;

/// Marks probes by the places of surfaces.
class ProbeUse {
public:
    /// positions  of the probes, in world space
    explicit ProbeUse(std::vector<glm::dvec3> positions);
    /// Marks the probes of a mesh, at places at most half as far apart as the two closest probes, but at most 64 along an edge.
    void add(const formats::TriangleMesh& mesh, const glm::dmat4& worldFromMesh);
    /// Returns for each probe whether a place uses it.
    const std::vector<bool>& isUsed() const { return isUsed_; }

private:
    void addTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);
    void addPlace(const glm::dvec3& place);

    std::vector<glm::dvec3> positions_;
    std::vector<bool> isUsed_;
    double spacing_ = 0;
};

/// A probe of the scene whose position is known.
struct PlacedProbe {
    std::string name;
    std::string role;                    ///< of the input with its position; unused if `position` is known
    std::string file;                    ///< name by which that input knows the probe
    std::optional<glm::dvec3> position;  ///< as the scene file states it
};
template <class Fields, Is<PlacedProbe> Self>
void describe(Fields& fields, Self& probe) {
    fields.required("name", probe.name, "name of the probe");
    fields.required("role", probe.role, "input with its position");
    fields.required("file", probe.file, "name of the probe in that input");
    fields.optional("position", probe.position, "world place by the scene file, which goes before that of the input");
}

/// Parameters of the action "probe-use". Its inputs are the meshes ("mesh0", ...) with the files beside them, and the files of positions.
struct ProbeUseParameters {
    std::vector<PlacedProbe> probes;
    std::vector<std::string> meshes;  ///< roles
};
template <class Fields, Is<ProbeUseParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("probes", parameters.probes, "probes with a position in the scene file or with an SH file");
    fields.required("meshes", parameters.meshes, "inputs that are meshes");
}

struct ProbeUseResult {
    std::vector<std::string> unused;  ///< names of probes
};
template <class Fields, Is<ProbeUseResult> Self>
void describe(Fields& fields, Self& result) {
    fields.required("unused", result.unused, "probes that are not among the four nearest of any place of the meshes");
}

/// Finds the unused probes. Probes of which neither scene file nor SH file states a position count as used, and so do all if there is no
/// mesh.
formats::Result<ActionOutcome> findUnusedProbes(const ActionContext& context);

}  // namespace lightcook::pipeline
