// Verdicts: the errors of an asset's stages, held against its limit. docs/theory/error.md defines the figures.
#pragma once

#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "pipeline/document/json_fields.h"
#include "pipeline/limits/limits.h"
#include "verify/figures.h"
#include "verify/violation.h"

namespace lightcook::pipeline {

struct Verdict {
    std::vector<verify::StageError> stages;
    std::string metric = "rel_rms";  ///< of the limit on errors
    Limits limits;                   ///< of the last stage, and of every mip level
    bool passed = false;
    std::vector<verify::Violation> violations;  ///< faults that the figures of the whole asset would average away
};

/// Returns a verdict. It passes if the last stage keeps its limits, if all figures of all stages are finite, and if there is no violation.
/// A limit on a bound that is not known is a violation.
Verdict makeVerdict(std::vector<verify::StageError> stages, const Limits& limits, std::vector<verify::Violation> violations = {});

/// Returns the figures of a stage that limits may hold: rel_rms of both kinds of shading, then the visible errors of each.
std::vector<Figure> figuresOf(const verify::StageError& stage);

/// Returns "stage total" of a stage named "total"; a name that begins with the word stays ("stage 2").
std::string stageWords(const std::string& name);

/// Returns the 99th percentile of a stage's visible errors, the larger of diffuse and specular light. Empty without any.
std::optional<double> visibleP99(const verify::StageError& stage);
/// Returns the proven bound of a stage's visible errors, the larger of diffuse and specular light. Empty without any.
std::optional<double> visibleBound(const verify::StageError& stage);

/// Returns true if an asset has errors of a kind of shading, or of neither kind: then both are shown. Figures of 0 alone are no errors that
/// were measured: those of light that an asset does not affect are 0 too, but have no visible errors and no places.
bool hasShading(const std::vector<verify::StageError>& stages, verify::ErrorFigures verify::StageError::*shading);

/// Returns true if the bound of visible errors is known: of each kind of shading that has visible errors, and of one at least.
bool hasVisibleBound(const verify::StageError& stage);
/// Returns the violation of a limit on a bound that is not known.
verify::Violation unknownBound(const std::string& stage, double maxVisibleBound);

/// Returns true if all figures are finite.
bool isFinite(const verify::ErrorFigures& figures);

/// Returns true if a stage that encodes the residual of another adds to its error. The rounding of a second stage may exceed the error of a
/// first one that is almost exact.
/// before, after  rel_rms without the stage and with it
/// rounding       largest rel_rms that the codes of the stage have beside a first one that is exact
bool addsError(double before, double after, double rounding = 0);
/// Appends a violation if stage `after`, which encodes the residual of stage `before`, adds to the error: then it belongs to another asset.
/// rounding  as in addsError
void checkStage(const std::vector<verify::StageError>& stages, const std::string& before, const std::string& after, double rounding,
                std::vector<verify::Violation>& violations);

/// The members of an ErrorPlace that are known, as JSON has them.
struct ErrorPlaceFields {
    std::optional<int> mip;
    std::optional<std::string> face;
    std::optional<std::array<double, 2>> texel;
    std::optional<std::string> channel;
    std::optional<glm::dvec3> normal, view;
    std::optional<double> m, f0, reference, found, local;
};
template <class Fields, Is<ErrorPlaceFields> Self>
void describe(Fields& fields, Self& place) {
    fields.optional("mip", place.mip, "mip level");
    fields.optional("face", place.face, "face of a cubemap: +X, -X, +Y, -Y, +Z or -Z");
    fields.optional("texel", place.texel, "x and y; fractions lie between texel centres");
    fields.optional("channel", place.channel, "red, green or blue");
    fields.optional("normal", place.normal, "normal of the shading, or the reflected direction of a reflection map");
    fields.optional("view", place.view, "direction to the viewer");
    fields.optional("m", place.m, "Beckmann roughness");
    fields.optional("f0", place.f0, "reflectance at normal incidence");
    fields.optional("reference", place.reference, kNumberOrNull, "light of the bake");
    fields.optional("found", place.found, kNumberOrNull, "light of the cooked asset");
    fields.optional("local", place.local, kNumberOrNull, "local relative error");
}

template <>
struct FieldMirror<verify::ErrorPlace> {
    using Type = ErrorPlaceFields;
    static ErrorPlaceFields of(const verify::ErrorPlace& place);
    static verify::ErrorPlace from(const ErrorPlaceFields& fields);
};

/// The members of a VisiblePlace that are known, as JSON has them.
struct VisiblePlaceFields {
    std::optional<int> mip;
    std::optional<std::string> face;
    std::optional<std::int64_t> primitive, triangle;
    std::array<double, 2> texel{};
    glm::dvec3 normal{0};
    std::optional<glm::dvec3> view;
    std::optional<double> m, f0;
    glm::dvec3 reference{0}, found{0};
};
template <class Fields, Is<VisiblePlaceFields> Self>
void describe(Fields& fields, Self& place) {
    fields.optional("mip", place.mip, "mip level of a cubemap");
    fields.optional("face", place.face, "face of a cubemap: +X, -X, +Y, -Y, +Z or -Z");
    fields.optional("primitive", place.primitive, "triangle primitive of a mesh, counted from 0 in the order of the file");
    fields.optional("triangle", place.triangle, "triangle of that primitive, counted from 0");
    fields.required("texel", place.texel, "x and y; fractions lie between texel centres");
    fields.required("normal", place.normal, "normal of the shading, or the reflected direction of a cubemap or reflection map");
    fields.optional("view", place.view, "direction to the viewer");
    fields.optional("m", place.m, "roughness");
    fields.optional("f0", place.f0, "reflectance at normal incidence");
    fields.required("reference", place.reference, kNumberOrNull, "light of the source: red, green, blue");
    fields.required("found", place.found, kNumberOrNull, "light of the cooked asset: red, green, blue");
}

template <>
struct FieldMirror<verify::VisiblePlace> {
    using Type = VisiblePlaceFields;
    static VisiblePlaceFields of(const verify::VisiblePlace& place);
    static verify::VisiblePlace from(const VisiblePlaceFields& fields);
};

template <class Fields, Is<verify::VisibleFigures> Self>
void describe(Fields& fields, Self& figures) {
    fields.required("rms", figures.rms, kFigure, "root mean square");
    fields.required("p50", figures.p50, kFigure, "median");
    fields.required("p95", figures.p95, kFigure, "95th percentile");
    fields.required("p99", figures.p99, kFigure, "99th percentile");
    fields.required("p999", figures.p999, kFigure, "99.9th percentile");
    fields.required("max", figures.max, kFigure, "largest of the samples");
    fields.presentIf(figures.maxAt.isKnown(), "max_at", figures.maxAt, "place of the largest");
    fields.presentIf(!figures.histogram.empty(), "histogram", figures.histogram,
                     "numbers of samples: below 1/8, in each octave from 1/8 to 512, and from 512 up");
    fields.optional("bound", figures.bound, kFigure,
                    "proven upper bound for every place, normal or view, and allowed sampler; of the last stage");
    fields.presentIf(figures.boundAt.isKnown(), "bound_at", figures.boundAt, "place of the bound");
}

template <class Fields, Is<verify::ErrorFigures> Self>
void describe(Fields& fields, Self& figures) {
    fields.required("rel_rms", figures.relRms, kFigure, "RMS of the error over RMS of the reference");
    fields.required("p99", figures.p99, kFigure, "99th percentile of the local relative error");
    fields.required("max_sampled", figures.maxSampled, kFigure, "largest local relative error of a sample");
    fields.optional("max_bound", figures.maxBound, kFigure, "certified bound on the local relative error; absent: none is known");
    fields.presentIf(figures.sampledAt.isKnown(), "sampled_at", figures.sampledAt, "place of max_sampled");
    fields.presentIf(figures.boundAt.isKnown(), "bound_at", figures.boundAt, "place of max_bound");
    fields.optional("visible", figures.visible, "visible error, in just noticeable differences (Delta E ITP)");
}

template <class Fields, Is<verify::CentreFigures> Self>
void describe(Fields& fields, Self& figures) {
    fields.required("diffuse", figures.diffuse, "of Lambert shading");
    fields.required("specular", figures.specular, "of area-specular shading");
}

template <class Fields, Is<verify::StageError> Self>
void describe(Fields& fields, Self& stage) {
    fields.required("name", stage.name, "name of the stage, as the layout calls it");
    fields.required("seconds", stage.seconds, kFigure, "wall time of the verification, in the last stage");
    fields.object("error", "error after this stage", [&](auto& error) {
        error.required("diffuse", stage.diffuse, "of Lambert shading");
        error.required("specular", stage.specular, "of area-specular shading");
    });
    fields.optional("at_texels", stage.atTexels, "the same at texel centres alone, where the error is that of the surface");
}

template <class Fields, Is<verify::Violation> Self>
void describe(Fields& fields, Self& violation) {
    fields.required("place", violation.place, "place inside the asset");
    fields.required("found", violation.found, "value that was found");
    fields.required("expected", violation.expected, "value that was expected");
    fields.presentIf(violation.at.isKnown(), "at", violation.at, "worst sample there");
}

/// The members of a verdict, which a row of the report has beside others.
template <class Fields, Is<Verdict> Self>
void describe(Fields& fields, Self& verdict) {
    fields.required("stages", verdict.stages, atLeast(1), "errors after each stage; the last is the whole asset");
    fields.object("limit", "limit that the last stage is held to", [&](auto& limit) {
        limit.required("metric", verdict.metric, "figure that is limited");
        limit.optional("value", verdict.limits[Limit::Error], between(0, HUGE_VAL), "largest value that passes");
        describe(limit, verdict.limits, kFurtherAssetLimits);
    });
    fields.required("passed", verdict.passed, "true if the figures are within the limit and nothing is violated");
    fields.presentIf(!verdict.violations.empty(), "violations", verdict.violations,
                     "faults that the figures of the whole asset would average away");
}

}  // namespace lightcook::pipeline
