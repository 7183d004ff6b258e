// Error of a scene as one number: the errors of all assets as radiance, and the share of each asset. Member `whole` of report.json.
//
// A pixel shows the sum of four kinds of light, on a white surface with the scene's own roughness and F0:
//   diffuse      exit radiance of the light map
//   area         area specular of the light map, S, through the tables
//   analytic     highlight of the dominant light
//   environment  R S: a pre-divided cubemap, R, times the pixel's area specular, or a prefiltered one as it is, R S being its radiance.
//                A pixel sees one of several cubemaps, each with the same probability
// Each asset's error is its rel_rms times the RMS of the light that it is a part of. docs/theory/error.md explains the sums.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assets/asset_kind.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/report/report_row.h"

namespace lightcook::pipeline {

/// The four kinds of light, as ShadingError::lights has them.
inline constexpr std::array kLightNames = {"diffuse", "area_specular", "analytic_specular", "environment"};

/// A stage's share of the squared error if it were alone, so that the shares of stages do not add up.
struct StageShare {
    std::string name;
    double share = 0;
};
template <class Fields, Is<StageShare> Self>
void describe(Fields& fields, Self& stage) {
    fields.required("name", stage.name, "name of the stage");
    fields.required("share", stage.share, kFigure, "share of the squared error if the stage were alone: shares of stages do not add up");
}

/// One asset in one kind of shading.
struct ErrorPart {
    std::string asset;
    AssetKind kind = AssetKind::LightMap;
    std::string shading;
    double share = 0, relRms = 0, lightRms = 0;
    std::vector<StageShare> stages;
};
template <class Fields, Is<ErrorPart> Self>
void describe(Fields& fields, Self& part) {
    fields.required("asset", part.asset, "name of the asset");
    fields.required("kind", part.kind, "kind of asset");
    fields.required("shading", part.shading, "diffuse, area specular, analytic specular or environment");
    fields.required("share", part.share, kFigure, "share of the squared error");
    fields.required("rel_rms", part.relRms, kFigure, "rel_rms of the asset");
    fields.required("light_rms", part.lightRms, kFigure, "RMS of its light");
    fields.required("stages", part.stages, "shares of its stages");
}

/// Error of all light that the pixels of one light map, or of all, show. Figures that are not finite are null in JSON, as are the sums that
/// contain them. Shares add up to 1, or are all 0 if there is no error.
struct ShadingError {
    double relRms = 0, relRmsBound = 0, lightRms = 0;
    std::array<double, kLightNames.size()> lights{};  ///< RMS of each kind of light
    std::vector<ErrorPart> parts;                     ///< the largest share first
    std::string advice;                               ///< the largest part, and what lowers it if that is known
};
template <class Fields, Is<ShadingError> Self>
void describe(Fields& fields, Self& shading) {
    fields.required("rel_rms", shading.relRms, kFigure, "error of the shaded light, with independent parts");
    fields.required("rel_rms_bound", shading.relRmsBound, kFigure, "error if all parts add up");
    fields.required("light_rms", shading.lightRms, kFigure, "RMS of the shaded light");
    fields.object("lights", "RMS of each kind of light", [&](auto& lights) {
        for (std::size_t i = 0; i < kLightNames.size(); ++i)
            lights.required(kLightNames[i], shading.lights[i], kFigure, "RMS of this light");
    });
    fields.required("parts", shading.parts, "assets that take part, the largest share first");
    fields.presentIf(!shading.advice.empty(), "advice", shading.advice,
                     "the part with the largest share, and what lowers it if that is known; or that there is no error, or no finite one");
}

struct LightMapError {
    std::string name;
    double weight = 0;  ///< share of the covered texels
    ShadingError shading;
};
template <class Fields, Is<LightMapError> Self>
void describe(Fields& fields, Self& map) {
    fields.required("name", map.name, "name of the light map");
    fields.required("weight", map.weight, kFigure, "share of the covered texels");
    describe(fields, map.shading);
}

/// An asset that no light map's pixels show.
struct ApartError {
    std::string asset;
    AssetKind kind = AssetKind::LightMap;
    double relRms = 0;
};
template <class Fields, Is<ApartError> Self>
void describe(Fields& fields, Self& apart) {
    fields.required("asset", apart.asset, "name of the asset");
    fields.required("kind", apart.kind, "kind of asset");
    fields.required("rel_rms", apart.relRms, kFigure, "rel_rms of the asset");
}

struct SceneError {
    ShadingError shading;
    std::vector<LightMapError> lightMaps;  ///< empty if there is only one
    std::vector<ApartError> apart;
};
template <class Fields, Is<SceneError> Self>
void describe(Fields& fields, Self& whole) {
    describe(fields, whole.shading);
    fields.presentIf(!whole.lightMaps.empty(), "light_maps", whole.lightMaps, "the same for each light map, if there are several");
    fields.required("apart", whole.apart, "assets that light no surface of the light maps");
}

/// Computes the error of a scene from the rows of a report. Returns nothing if no light map has its RMS of light.
std::optional<SceneError> sceneError(const std::vector<ReportRow>& rows);

/// Returns one line with the number, its bound and the advice.
std::string lineOf(const SceneError& whole);

}  // namespace lightcook::pipeline
