// Needs of a scene: the kinds of light and the ranges that its materials use. Everything else is not cooked.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "formats/pixel_format.h"
#include "pipeline/assets/light_map/content.h"
#include "pipeline/graph/action.h"
#include "pipeline/json/json_fields.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

struct Needs {
    bool specular = true;
    bool normalMap = true;
    Range m{0.1, 0.5};  ///< Beckmann roughness
    Range f0{0.04, 0.6};
    bool isRoughnessKnown = false;                      ///< a material states m, so that other roughness is unused
    std::map<std::string, LightMapContent> contents{};  ///< of light maps, by name
    std::set<std::string> unusedProbes{};               ///< names

    /// Returns true if the materials show where light comes from.
    bool needsDirections() const { return normalMap || specular; }
};

/// Layers of a texture that a skip saved, as large as its light map.
struct SkippedImages {
    formats::PixelFormat format = formats::PixelFormat::Bc7;
    int layers = 1;
};
/// Work that a skip saved, whose time is measured by WorkRates.
struct SkippedWork {
    std::string kind = {};  ///< an asset kind
    double texels = 0;      ///< of a light map: known once it is open
};

/// Something that is not cooked, or not cooked again, and the memory and time that this saved.
struct Skip {
    std::string what, why;
    std::uint64_t bytesSaved = 0;
    double secondsSaved = 0;  ///< the time that a reused result took, else that of `work`; NaN if it was never measured
    SkippedWork work = {};
    /// The light map whose size, known once it is open, decides bytesSaved: that of `images` less that of `instead`. Empty if bytesSaved is
    /// known.
    std::string lightMap = {};
    std::vector<SkippedImages> images = {}, instead = {};
};
template <class Fields, Is<Skip> Self>
void describe(Fields& fields, Self& skip) {
    fields.required("what", skip.what, "asset or action");
    fields.required("why", skip.why, "reason");
    fields.required("bytes_saved", skip.bytesSaved, "GPU memory that this saved [bytes]");
    fields.required(
        "seconds_saved", skip.secondsSaved, kNumberOrNull,
        "time that this saved, measured: of a reused result its own, else that of its kind on this machine; null if it was never measured");
}

/// Returns the union of the needs of all materials: those of the glTF (records of "materials" actions), overridden by the scene's own list.
/// "*" overrides every material. Without any material everything is needed, over the default ranges.
Needs resolveNeeds(const Scene& scene, const std::vector<const ActionRecord*>& meshMaterials);

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
