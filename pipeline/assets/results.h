// Results of cook and verify actions, as their records keep them and the report reads them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assets/chart_figures.h"
#include "pipeline/assets/cooked_asset.h"
#include "pipeline/assets/rendered_view_files.h"
#include "pipeline/assets/seam_figures.h"
#include "pipeline/assets/verdict.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Result of a cook action.
struct CookResult {
    CookedAsset asset;
    std::uint64_t bytesIn = 0;
    std::optional<Json> notes;  ///< counts and facts by name: the report has a caption for each
};
template <class Fields, Is<CookResult> Self>
void describe(Fields& fields, Self& result) {
    fields.required("asset", result.asset, "entry of the manifest");
    fields.required("bytes_in", result.bytesIn, "size of the source [bytes]");
    fields.optional("notes", result.notes, "counts and facts of the cook");
}

/// Light that the errors of an asset are a part of, for the error of the whole scene.
struct LightFigures {
    std::optional<double> diffuseRms, specularRms;     ///< RMS of the reference
    std::optional<double> ratioRms, ratioRelRms;       ///< of a cubemap over its area specular
    std::optional<std::vector<double>> moments;        ///< of a map's light around its normals, see LightMoments
    std::optional<double> texels;                      ///< that these moments are means of
    std::optional<std::vector<double>> kernelMoments;  ///< of the kernels that tables hold
    std::optional<std::vector<double>> errorMoments;   ///< of the errors of these kernels
    std::optional<std::string> bake;                   ///< source file, by which lights and meshes find their light map
};
template <class Fields, Is<LightFigures> Self>
void describe(Fields& fields, Self& light) {
    fields.optional("diffuse_rms", light.diffuseRms, kFigure, "RMS of the diffuse reference");
    fields.optional("specular_rms", light.specularRms, kFigure, "RMS of the specular reference");
    fields.optional("ratio_rms", light.ratioRms, kFigure, "RMS of the reference over the cubemap's area specular");
    fields.optional("ratio_rel_rms", light.ratioRelRms, kFigure, "rel_rms of that ratio");
    fields.optional("moments", light.moments, kNumberOrNull, "second moments of the light around the normals");
    fields.optional("texels", light.texels, kFigure, "texels that the moments are means of");
    fields.optional("kernel_moments", light.kernelMoments, kNumberOrNull, "second moments of the specular kernels");
    fields.optional("error_moments", light.errorMoments, kNumberOrNull, "second moments of the errors of these kernels");
    fields.optional("bake", light.bake, "source file of the light map");
}

/// Largest distances that quantization moved the vertices of a mesh.
struct MeshErrorFigures {
    double position = 0, normalRadians = 0, lightMapUv = 0;
};
template <class Fields, Is<MeshErrorFigures> Self>
void describe(Fields& fields, Self& error) {
    fields.required("position", error.position, kFigure, "largest distance [scene units]");
    fields.required("normal_radians", error.normalRadians, kFigure, "largest angle [radians]");
    fields.required("light_map_uv", error.lightMapUv, kFigure, "largest distance [UV units]");
}

/// A picture of the surroundings of a texel: reference, cooked and visible error side by side.
struct WorstPlacePicture {
    std::string file;
    std::array<int, 2> texel{};             ///< x and y
    double visible = 0;                     ///< visible error at the texel's own normal
    std::optional<glm::dvec3> normal = {};  ///< that normal
    glm::dvec3 reference{0}, found{0};      ///< exit radiance there
    std::optional<RenderedView> view = {};  ///< of a map with a mesh that has the texel
};
template <class Fields, Is<WorstPlacePicture> Self>
void describe(Fields& fields, Self& place) {
    fields.required("file", place.file, kFileInFolder, "reference, cooked and visible error side by side");
    fields.required("texel", place.texel, "x and y");
    fields.required("visible", place.visible, kFigure, "visible error at the texel's own normal");
    fields.optional("normal", place.normal, "that normal");
    fields.required("reference", place.reference, kNumberOrNull, "exit radiance of the bake: red, green, blue");
    fields.required("found", place.found, kNumberOrNull, "exit radiance of the cooked asset: red, green, blue");
    fields.optional("view", place.view, "the mesh around the texel, rendered");
}

/// The 4 x 4 block of a light map that errs most, at the normals of its texels.
struct BlockFigures {
    std::array<int, 2> block{};  ///< its first texel: x and y
    std::array<int, 2> texel{};  ///< its worst texel: x and y
    double visible = -1;         ///< mean visible error over the block; negative: no block
    bool isKnown() const { return visible >= 0; }
};
template <class Fields, Is<BlockFigures> Self>
void describe(Fields& fields, Self& block) {
    fields.required("block", block.block, "its first texel: x and y");
    fields.required("texel", block.texel, "its worst texel: x and y");
    fields.required("visible", block.visible, kFigure, "mean visible error over the block, at the normals of its texels");
}

/// Pictures of an asset, relative to its folder.
struct PreviewFiles {
    std::string reference, cooked, difference;
    std::optional<std::string> anyNormal = {};
    std::vector<WorstPlacePicture> worst = {};  ///< the largest visible error first
    std::vector<RenderedView> seams = {};       ///< of SeamFigures::worst, in their order

    std::vector<std::string> all() const {
        std::vector<std::string> files = {reference, cooked, difference};
        if (anyNormal) files.push_back(*anyNormal);
        for (const WorstPlacePicture& place : worst) {
            files.push_back(place.file);
            if (place.view) files.insert(files.end(), {place.view->reference, place.view->cooked});
        }
        appendFiles(seams, files);
        return files;
    }
};
template <class Fields, Is<PreviewFiles> Self>
void describe(Fields& fields, Self& preview) {
    fields.required("reference", preview.reference, kFileInFolder, "the bake");
    fields.required("cooked", preview.cooked, kFileInFolder, "the cooked asset");
    fields.required("difference", preview.difference, kFileInFolder, "local relative error, or visible error");
    fields.optional("any_normal", preview.anyNormal, kFileInFolder, "visible error at the worst normal that a normal map can turn to");
    fields.presentIf(!preview.worst.empty(), "worst", preview.worst, "surroundings of the texels with the largest visible errors");
    fields.presentIf(!preview.seams.empty(), "seams", preview.seams, "the mesh around the worst seams, in their order");
}

/// Result of a verify action.
struct VerifyResult {
    Verdict verdict;
    std::optional<double> key;                  ///< log-average luminance of the exit radiance
    std::vector<verify::StageError> mips;       ///< of a light map: each level from 1 on
    std::vector<verify::StageError> mipBlends;  ///< between each of them and the larger level
    std::optional<LightFigures> light;
    std::optional<MeshErrorFigures> meshError;
    std::optional<PreviewFiles> preview;
    std::optional<SeamFigures> seams;
    std::optional<ChartSummary> charts;
    std::optional<BlockFigures> worstBlock;  ///< of a light map
    std::optional<Json> measures;            ///< figures of a kind of its own, by name: the report has a caption for each
    std::optional<Json> groundTruth;         ///< see ground_truth.h

    /// Returns the checks of the last stage, of every mip level and mix of two, and of the seams.
    std::vector<Check> checks(const Limits& limits) const {
        std::vector<Figure> figures;
        const auto add = [&](const std::vector<Figure>& more) { figures.insert(figures.end(), more.begin(), more.end()); };
        if (!verdict.stages.empty()) add(figuresOf(verdict.stages.back()));
        for (const std::vector<verify::StageError>* levels : {&mips, &mipBlends})
            for (const verify::StageError& level : *levels) add(figuresOf(level));
        if (seams) add(seams->figures());
        return judge(figures, limits);
    }
};
template <class Fields, Is<VerifyResult> Self>
void describe(Fields& fields, Self& result) {
    describe(fields, result.verdict);
    fields.presentIf(!result.mips.empty(), "mips", result.mips,
                     "errors of the mip levels of a light map, from level 1 on, each against the mean of the bake over its texels; the "
                     "limits hold for each");
    fields.presentIf(!result.mipBlends.empty(), "mip_blends", result.mipBlends,
                     "errors between each of these levels and the larger one, as a trilinear sampler mixes them; the limits on sampled "
                     "errors hold for each");
    fields.optional("key", result.key, kFigure, "log-average luminance of the exit radiance");
    fields.optional("light", result.light, "light that the errors are a part of");
    fields.optional("mesh_error", result.meshError, "how far quantization moved the vertices");
    fields.optional("preview", result.preview, "pictures");
    fields.optional("seams", result.seams, "steps of light at edges that charts share; of a light map");
    fields.optional("charts", result.charts, "memory and visible errors of the charts of a light map with a mesh");
    fields.optional("worst_block", result.worstBlock, "the 4 x 4 block of a light map that errs most");
    fields.optional("measures", result.measures, "further figures of the kind");
    fields.optional("ground_truth", result.groundTruth, "errors against traced light");
}

/// Errors of what a pixel shows of a light map and its dominant light together: result of action "verify-whole".
struct WholeFigures {
    verify::VisibleFigures visible;
    double relRms = 0;  ///< RMS of the error over that of the reference
    int places = 0;     ///< that were shaded
    Limits limits;      ///< on the whole
    std::vector<Check> checks() const {
        return judge({{Limit::WholeVisible, visible.p99, "whole", ""}, {Limit::WholeError, relRms, "whole", ""}}, limits);
    }
};
template <class Fields, Is<WholeFigures> Self>
void describe(Fields& fields, Self& whole) {
    fields.required("visible", whole.visible, "visible error, in just noticeable differences (Delta E ITP)");
    fields.required("rel_rms", whole.relRms, kFigure, "RMS of the error over that of the reference");
    fields.required("places", whole.places, kFigure, "places of the surface that were shaded");
    fields.optional("max_visible", whole.limits[Limit::WholeVisible], kFigure, "limit on the 99th percentile");
    fields.optional("max_error", whole.limits[Limit::WholeError], kFigure, "limit on rel_rms");
}

/// Returns the outcome of an action with a typed result.
template <Described Result>
ActionOutcome outcomeWith(const Result& result, std::vector<std::string> files = {}) {
    return {toJson(result), std::move(files)};
}

/// Reads the parameters of an action into the struct that describes them.
template <Described Parameters>
formats::Result<Parameters> parametersOf(const ActionContext& context) {
    return fromJson<Parameters>(context.action.parameters, context.action.id + ", parameters");
}

/// Returns the manifest entry of the asset that dependency `index` cooked.
inline formats::Result<CookedAsset> upstreamAsset(const ActionContext& context, std::size_t index = 0) {
    return fromJson<CookedAsset>(context.upstream.at(index)->result.value("asset", Json()), context.action.asset);
}

}  // namespace lightcook::pipeline
