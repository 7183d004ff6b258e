// Needs of a scene: the kinds of light and the ranges that its materials use, and what its files hold. Everything else is not cooked.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/content.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/scene/scene.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

template <class Fields, Is<Range> Self>
void describe(Fields& fields, Self& range) {
    fields.required("low", range.low, between(0, 1), "the least");
    fields.required("high", range.high, between(0, 1), "the largest");
}

struct Needs {
    bool specular = true;
    bool normalMap = true;
    double normalMapTilt = 60;  ///< largest angle of a normal map's normal from the surface's [degrees]
    Range m{0.1, 0.5};          ///< Beckmann roughness
    Range f0{0.04, 0.6};
    bool isRoughnessKnown = false;                      ///< a material states m, so that other roughness is unused
    std::map<std::string, LightMapContent> contents{};  ///< of light maps, by name
    std::set<std::string> unusedProbes{};               ///< names

    /// Returns true if the materials show where light comes from.
    bool needsDirections() const { return normalMap || specular; }
};
template <class Fields, Is<Needs> Self>
void describe(Fields& fields, Self& needs) {
    fields.required("specular", needs.specular, "true if a material is specular");
    fields.required("normal_map", needs.normalMap, "true if a material has a normal map");
    fields.required("normal_map_tilt", needs.normalMapTilt, between(0, 90), "largest angle of a normal map's normal [degrees]");
    fields.required("m", needs.m, "roughness of the materials");
    fields.required("f0", needs.f0, "their reflectance at normal incidence");
    fields.required("is_roughness_known", needs.isRoughnessKnown, "true if a material states its roughness");
    fields.presentIf(!needs.contents.empty(), "contents", needs.contents, "what the light maps hold, by name");
    fields.presentIf(!needs.unusedProbes.empty(), "unused_probes", needs.unusedProbes, "probes that no surface uses");
}

/// Returns the union of the needs of all materials: those of the meshes, overridden by the scene's own list. "*" overrides every material.
/// If there is no material, everything is needed, over the default ranges.
Needs resolveNeeds(const Scene& scene, const std::vector<MaterialRecord>& meshMaterials);

/// Returns the materials that a scene's assets are shaded with.
verify::LightMapShading shadingOf(const Scene& scene, const Needs& needs);

/// Returns the largest Phong exponent whose row of a reflection map the needed roughness reads: the least of `exponents` that is at least
/// as sharp as the smoothest material, or the last.
double largestExponentFor(const Needs& needs, const std::vector<double>& exponents);

/// Returns the number of the largest levels of a prefiltered cubemap that no material reads: those sharper than its smoothest material.
/// Levels of kLeastReadSize texels and less are always kept.
/// size  of a face of the whole chain [texels]
int unreadLevelsOf(const Needs& needs, int size);
inline constexpr int kLeastReadSize = 4;

/// Returns the layout that the scene asks for. In place of a named one with directions that is "flat" if the materials need none and the
/// engine reads it.
std::string lightMapLayoutFor(const Scene& scene, const Needs& needs, const LightMapEntry& entry);

/// The rows of the 16-row table grid m = 1/16 .. 1 that cover the needed range: first and count.
struct TableRows {
    int first = 0, count = 16;
    double minimumM() const { return (first + 1) / 16.0; }
    double maximumM() const { return (first + count) / 16.0; }
};
TableRows tableRowsFor(const Needs& needs);

/// Returns the values at which the verifier shades: the usual ones inside a needed range, and the ends of the range.
std::vector<double> samplesOf(const Range& range, const std::vector<double>& usual);

}  // namespace lightcook::pipeline
