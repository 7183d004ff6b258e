// Facts of a light map that its plausibility is judged by: one pass over its strips, as a cached action.
//
// Light arrives from the hemisphere of the surface. Its normal is the texel's N where the surface is flat; where N is smooth or bumped,
// light may come from below the horizon of N. So with w the direction, weighted by radiance, E the mean, and w.N >= -s:
//   f = E[w.N], -s <= f <= 1                         band 1 along the normal over sqrt(3) sh00
//   g = E[(3 (w.N)^2 - 1) / 2]                       band 2 along the normal over sqrt(5) sh00
//   (3 f^2 - 1) / 2 <= g <= (3 ((1 - s) f + s) - 1) / 2
// The lower bound of g is Jensen's inequality, the upper one (w.N + s) (w.N - 1) <= 0. A wrong sign convention, frame or choice of axes
// breaks the first line; bands that were convolved, or scaled by a curve, break the third. Each alternative is counted on the same texels.
// No noise of a baker that adds up samples of light breaks any: a sum of lights is a light. Rounding to halves does, and so do filters that
// work on each coefficient alone; light_map_facts.cpp has the tolerances.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "formats/light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/action.h"
#include "pipeline/lint/chart_scanner.h"
#include "pipeline/lint/stated_primaries.h"

namespace lightcook::pipeline {

/// Numbers of texels that break the inequalities of bands 1 and 2, under each reading of the file.
struct BandFacts {
    std::int64_t texels = 0;         ///< that were tested
    std::int64_t asDescribed = 0;    ///< break them as the scene file describes the map, beyond what filters of bakers do
    std::int64_t otherQuantity = 0;  ///< break them, beyond rounding, as irradiance instead of radiance, or the reverse
    std::int64_t decoded = 0;        ///< break them, beyond rounding, after a gamma curve of 2.2 is undone
};
template <class Fields, Is<BandFacts> Self>
void describe(Fields& fields, Self& facts) {
    fields.required("texels", facts.texels, "texels that were tested");
    fields.required("as_described", facts.asDescribed, "texels that no light of a hemisphere has, as the scene file describes the map");
    fields.required("other_quantity", facts.otherQuantity, "the same, as irradiance instead of radiance or the reverse");
    fields.required("decoded", facts.decoded, "the same, after a gamma curve of 2.2 is undone");
}

/// Numbers of texels of a map, or of some of its rows.
struct LightMapCounts {
    formats::LightMapCoverage coverage;
    std::int64_t covered = 0;
    std::int64_t black = 0;        ///< covered texels without any light
    std::int64_t tooDirected = 0;  ///< texels whose band 1 is longer than that of any light of their sh00 in the formula of the baker
    std::int64_t directional = 0;  ///< texels whose band 1 is not too short to have a direction
    std::array<std::int64_t, formats::BakeAxes::kChoices> behind{};  ///< of these, those that are lit from behind under each choice of axes
    std::int64_t behindInOtherFrame = 0;                             ///< the same with coefficients of the other frame
    BandFacts bands;

    void merge(const LightMapCounts& other);
};

struct LightMapFacts : LightMapCounts {
    int width = 0, height = 0;
    bool hasCoverage = false, hasNormals = false;
    bool hasMeshNormals = false;  ///< they are the mesh's, and not in the axes of the file
    BakeReading reading;
    std::optional<formats::StatedPrimaries> primaries;
    double key = 0;           ///< log-average luminance of the exit radiance of a white surface, where lit
    double meanRadiance = 0;  ///< mean luminance of the incident radiance over the hemisphere, where there is light
    ChartFacts charts;
    std::optional<double> tracedRatio;  ///< of the light of `ground_truth` to that of the map
    bool isTracedSpecular = false;      ///< it is of specular light
};
template <class Fields, Is<LightMapFacts> Self>
void describe(Fields& fields, Self& facts) {
    fields.required("width", facts.width, "width [texels]");
    fields.required("height", facts.height, "height [texels]");
    fields.required("has_coverage", facts.hasCoverage, "true if the file has coverage.Y");
    fields.required("has_normals", facts.hasNormals, "true if the file has normal.X/Y/Z, or the mesh has normals");
    fields.required("has_mesh_normals", facts.hasMeshNormals, "true if the normals are those of the mesh");
    fields.required("reading", facts.reading, "how the file was recognised");
    fields.optional("primaries", facts.primaries, "primaries that the file states");
    fields.required("inside", facts.coverage.inside, "texels with coverage.Y above 0.5");
    fields.required("without_normal", facts.coverage.withoutNormal, "of these, texels whose normal is shorter than 1/2");
    fields.required("odd_normals", facts.coverage.oddNormals, "of these, texels whose normal is far from unit length");
    fields.required("encoded_normals", facts.coverage.encodedNormals, "of these, texels whose normal is stored as a colour");
    fields.required("covered", facts.covered, "texels that count as covered");
    fields.required("smallest_coverage", facts.coverage.smallest, "smallest coverage.Y");
    fields.required("largest_coverage", facts.coverage.largest, "largest coverage.Y");
    fields.required("black", facts.black, "covered texels without any light");
    fields.required("key", facts.key, kNumberOrNull, "log-average luminance of the exit radiance of a white surface, where lit");
    fields.required("mean_radiance", facts.meanRadiance, kNumberOrNull,
                    "mean luminance of the incident radiance over the hemisphere, where there is light");
    fields.required("too_directed", facts.tooDirected, "texels whose band 1 is longer than that of any light");
    fields.required("directional", facts.directional, "texels whose light has a direction");
    fields.required("behind", facts.behind, "of these, texels that are lit from behind, for each choice of axes");
    fields.required("behind_in_other_frame", facts.behindInOtherFrame, "the same with coefficients of the other frame");
    fields.required("bands", facts.bands, "ratios of the SH bands");
    fields.required("charts", facts.charts, "charts");
    fields.optional("traced_ratio", facts.tracedRatio, "median ratio of the light of ground_truth to that of the map");
    fields.required("is_traced_specular", facts.isTracedSpecular, "true if it is of specular light");
}

/// Parameters of the action. Its inputs are those of the bake, and "ground_truth" if there is one.
struct LightMapLintParameters {
    formats::LightMapDescription description;
    std::string file;  ///< its name may say that it is one of a set
};
template <class Fields, Is<LightMapLintParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("description", parameters.description, "conventions of the light map");
    fields.required("file", parameters.file, "name of the file, without its folder");
}

/// Action "lint-light-map". Its result is LightMapFacts.
formats::Result<ActionOutcome> lintLightMap(const ActionContext& context);

}  // namespace lightcook::pipeline
