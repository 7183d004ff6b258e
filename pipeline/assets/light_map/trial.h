// Trials: layouts of a light map, encoded and shaded without files, so that one can be chosen by error or by bytes.
//
// A trial of a map alone finds the cheapest layout within the limits. Layouts are measured in the order of their cost, on some rows of the
// map first (trial_rows.h). One whose error there is clearly above or below the limits is decided; others are measured on more rows, and in
// the end on all. The trial ends at the first that keeps the limits: those that cost more are not measured, but for one that the report can
// compare it with. Learned layouts of one plan are measured at once, the longest plan first: where the shortest layout of it misses the
// limits, so does one of fewer numbers.
// Where tiles may have detail, each layout is judged with it as well, from the errors of its tiles and from those of the detail: a layout
// that misses the limits keeps them with as much detail as they ask for.
// A complete trial measures every layout on all rows. A joint one (joint_trial.h) judges layouts by what a pixel shows of the map and its
// dominant light together.
#pragma once

#include <string>
#include <vector>

#include "formats/layout_cost.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Parameters of action "light-map-trial". Its inputs are "source", and "mesh" if the map has one.
struct TrialParameters {
    formats::LightMapDescription description;
    formats::Target target = formats::Target::Bc;
    TextureSettings textures;
    verify::LightMapShading shading;
    lighting::DisplaySettings display;
    formats::Objective objective = formats::Objective::Visible;
    bool isFlatTried = false;           ///< directions may not be needed
    bool hasDirections = true;          ///< false: bands 1 and 2 are zero, so layouts that store coefficient 0 as flat does are not tried
    formats::DecodeLimits decode = {};  ///< layouts over them are not tried
    formats::LayoutList layouts = {};   ///< that "auto" may take
    bool mips = false;                  ///< the bytes are those of a map with mip levels; errors are those of level 0
    Limits limits = {};                 ///< of kTrialLimits
    formats::LayoutCost cost = formats::LayoutCost::Bytes;
    bool isComplete = false;
    bool isDetailTried = false;              ///< tiles may have detail: layouts are judged with it, too
    std::optional<double> detailLimit = {};  ///< on visible errors of the map alone, that tiles get detail for
};
/// Limits that a trial decides by: a joint one by the last.
inline constexpr std::initializer_list<Limit> kTrialLimits = {Limit::Error, Limit::Visible, Limit::WholeVisible};
template <class Fields, Is<TrialParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("description", parameters.description, "conventions of the light map");
    fields.required("target", parameters.target, "target");
    fields.required("textures", parameters.textures, "settings of the files");
    fields.required("shading", parameters.shading, "materials that are shaded");
    fields.required("display", parameters.display, "display that visible errors are judged on");
    fields.required("objective", parameters.objective, "what encoders minimize");
    fields.required("is_flat_tried", parameters.isFlatTried, "true if band 0 alone may be enough");
    fields.presentIf(!parameters.hasDirections, "has_directions", parameters.hasDirections, "false if bands 1 and 2 are zero");
    fields.optional("max_fetches", parameters.decode.maxFetches, "limit on the texture fetches of a sample");
    fields.optional("max_decode_ops", parameters.decode.maxDecodeOps, "limit on the operations of a sample's decode");
    fields.optional("filter", parameters.decode.filter, "filter of the shader; that of each layout if absent");
    fields.optional("preferred_filter", parameters.decode.preferred, "the usual filter, in place of that of each layout");
    fields.presentIf(!parameters.layouts.empty(), "layouts", parameters.layouts, "layouts that may be chosen");
    fields.presentIf(parameters.mips, "mips", parameters.mips, "true for a map with mip levels");
    describe(fields, parameters.limits, kTrialLimits);
    fields.presentIf(parameters.cost != formats::LayoutCost::Bytes, "cost", parameters.cost, "what the choice keeps small");
    fields.presentIf(parameters.isDetailTried, "detail", parameters.isDetailTried, "true if layouts are judged with detail, too");
    fields.optional("detail_limit", parameters.detailLimit, "limit on visible errors that tiles get detail for");
    fields.presentIf(parameters.isComplete, "complete", parameters.isComplete, "true if every layout is measured on all rows");
}

/// Size, cost and error of one layout.
struct TrialCandidate {
    std::string layout;  ///< DetailedLayout::name
    std::uint64_t bytesGpu = 0;
    double bitsPerTexel = 0;
    double diffuse = 0, specular = 0;                ///< rel_rms
    double visibleDiffuse = 0, visibleSpecular = 0;  ///< 99th percentile of visible errors
    int fetches = 0;                                 ///< texture fetches of a sample
    int decodeOps = 0;                               ///< scalar multiply-adds of its decode
    std::uint64_t tableBytes = 0;                    ///< constants of the decode that are learned [bytes]
    bool isExcluded = false;                         ///< the scene's list of layouts lacks it: measured for comparison alone
    std::optional<double> seam = {};                 ///< SeamFigures::largestAdded, if it was verified: trials measure no seams
};
template <class Fields, Is<TrialCandidate> Self>
void describe(Fields& fields, Self& candidate) {
    fields.required("layout", candidate.layout, "layout; with detail `basis-4+lit@5`: as much of layout lit as keeps a visible error of 5");
    fields.required("bytes_gpu", candidate.bytesGpu, "GPU memory [bytes]");
    fields.required("bits_per_texel", candidate.bitsPerTexel, "GPU memory of a texel [bits]");
    fields.required("diffuse", candidate.diffuse, kFigure, "rel_rms of diffuse shading");
    fields.required("specular", candidate.specular, kFigure, "rel_rms of specular shading");
    fields.required("visible_diffuse", candidate.visibleDiffuse, kFigure, "99th percentile of visible errors of diffuse shading");
    fields.required("visible_specular", candidate.visibleSpecular, kFigure, "99th percentile of visible errors of specular shading");
    fields.required("fetches", candidate.fetches, "texture fetches of a sample");
    fields.required("decode_ops", candidate.decodeOps, "scalar multiply-adds of a sample's decode");
    fields.required("table_bytes", candidate.tableBytes, "learned constants of the decode [bytes]");
    fields.presentIf(candidate.isExcluded, "excluded", candidate.isExcluded, "true if the scene's list of layouts lacks it");
    fields.optional("seam", candidate.seam, "largest step that it adds to an edge; of layouts that were verified for the choice alone");
}

struct TrialResult {
    std::vector<TrialCandidate> candidates;  ///< by bytes
    double share = 1;                        ///< part of the map that each was tried on, at least
    bool isPruned = false;                   ///< layouts were left out that cost more than one within the limits
};
template <class Fields, Is<TrialResult> Self>
void describe(Fields& fields, Self& result) {
    fields.required("candidates", result.candidates, "layouts, the smallest first");
    fields.required("share", result.share, "part of the map that was tried");
    fields.presentIf(result.isPruned, "pruned", result.isPruned, "true if layouts were left out that cost more than one within the limits");
}

/// Tries the layouts that "auto" may take. Where the scene lists layouts, the others are measured too if that is cheap: on small maps, and
/// where the trial of a listed one has them as stages.
formats::Result<ActionOutcome> tryLightMap(const ActionContext& context);

}  // namespace lightcook::pipeline
