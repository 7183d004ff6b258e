// What a scene's materials ask of its lighting, and so what need not be cooked.
#pragma once

#include <string>
#include <vector>

#include "pipeline/graph/action.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

struct Needs {
    bool specular = true;
    bool normalMap = true;
    Range m{0.1, 0.5};  ///< Beckmann's roughness
    Range f0{0.04, 0.6};
};

/// Something that is not cooked, or was not cooked again, and what that saved.
struct Skip {
    std::string what, why;
    std::uint64_t bytesSaved = 0;
    double secondsSaved = 0;  ///< as last measured for what is only reused, else an estimate from the rates in needs.cpp
    /// Where the saving grows with a light map whose size is not known until it was opened: its name, and bits a texel.
    std::string lightMap = {};
    double bitsPerTexel = 0;

    Json toJson() const;
};

/// The union of what every material needs. glTF materials (records of "materials" actions) first, then the scene's own list over them:
/// "*" speaks for every material, other names for that one. Without any material: everything is needed, over the default ranges.
Needs resolveNeeds(const Scene& scene, const std::vector<const ActionRecord*>& meshMaterials);

/// What the layout of light maps becomes under these needs: "flat" where neither normal maps nor specular ask for directions.
std::string lightMapLayoutFor(const Scene& scene, const Needs& needs);

/// The rows of the 16-row table grid m = 1/16 .. 1 that cover the needed range: first and count.
struct TableRows {
    int first = 0, count = 16;
    double minimumM() const { return (first + 1) / 16.0; }
    double maximumM() const { return (first + count) / 16.0; }
};
TableRows tableRowsFor(const Needs& needs);

/// m and F0 values at which the verifier shades: the usual ones inside the needed ranges, and the ranges' ends.
std::vector<double> samplesOf(const Range& range, const std::vector<double>& usual);

/// Estimated cost of an asset that is skipped, from rates measured on two cores of the reference machine.
double estimatedSeconds(const std::string& kind, double megapixels);

}  // namespace lightcook::pipeline
