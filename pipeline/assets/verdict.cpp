#include "pipeline/assets/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lightcook::pipeline {
namespace {

const std::vector<std::string> kFaces = {"+X", "-X", "+Y", "-Y", "+Z", "-Z"};
const std::vector<std::string> kChannels = {"red", "green", "blue"};

/// Returns the index of a name. Empty: there is none.
std::optional<int> indexOf(const std::vector<std::string>& names, const std::optional<std::string>& name) {
    const auto found = name ? std::ranges::find(names, *name) : names.end();
    return found == names.end() ? std::nullopt : std::optional(static_cast<int>(found - names.begin()));
}

/// Returns true if a kind of shading was measured.
bool wasMeasured(const verify::ErrorFigures& figures) {
    return figures.visible || figures.sampledAt.isKnown() || figures.boundAt.isKnown() || figures.relRms != 0 || figures.p99 != 0 ||
           figures.maxSampled != 0;
}

}  // namespace

std::string stageWords(const std::string& name) {
    return name.starts_with("stage ") ? name : "stage " + name;
}

std::optional<double> visibleP99(const verify::StageError& stage) {
    std::optional<double> largest;
    for (const verify::ErrorFigures* figures : {&stage.diffuse, &stage.specular})
        if (figures->visible && !(figures->visible->p99 <= largest.value_or(-1))) largest = figures->visible->p99;
    return largest;
}

std::optional<double> visibleBound(const verify::StageError& stage) {
    std::optional<double> largest;
    for (const verify::ErrorFigures* figures : {&stage.diffuse, &stage.specular})
        if (figures->visible && figures->visible->bound && !(*figures->visible->bound <= largest.value_or(-1)))
            largest = figures->visible->bound;
    return largest;
}

bool hasShading(const std::vector<verify::StageError>& stages, verify::ErrorFigures verify::StageError::*shading) {
    const auto other = shading == &verify::StageError::diffuse ? &verify::StageError::specular : &verify::StageError::diffuse;
    const auto measures = [&](verify::ErrorFigures verify::StageError::*kind) {
        return std::ranges::any_of(stages, [&](const verify::StageError& stage) { return wasMeasured(stage.*kind); });
    };
    return measures(shading) || !measures(other);
}

bool hasVisibleBound(const verify::StageError& stage) {
    const auto lacksBound = [](const verify::ErrorFigures& figures) { return figures.visible && !figures.visible->bound; };
    return visibleBound(stage) && !lacksBound(stage.diffuse) && !lacksBound(stage.specular);
}

verify::Violation unknownBound(const std::string& stage, double maxVisibleBound) {
    return {stage, "no proven bound of visible errors",
            fmt::format("one of at most {:.4g}, as max_visible_bound asks: limit samples by max_visible instead, or of charts with "
                        "fewer texels cook with charts_max_visible = 0",
                        maxVisibleBound)};
}

bool isFinite(const verify::ErrorFigures& figures) {
    return std::isfinite(figures.relRms) && std::isfinite(figures.p99) && std::isfinite(figures.maxSampled) &&
           (!figures.maxBound || std::isfinite(*figures.maxBound)) && (!figures.visible || std::isfinite(figures.visible->max));
}

VisiblePlaceFields FieldMirror<verify::VisiblePlace>::of(const verify::VisiblePlace& place) {
    VisiblePlaceFields fields;
    fields.texel = {place.x, place.y};
    fields.normal = place.normal;
    fields.reference = place.reference;
    fields.found = place.found;
    if (place.mip >= 0) fields.mip = place.mip;
    if (place.face >= 0) fields.face = kFaces.at(static_cast<std::size_t>(place.face));
    if (place.triangle) {
        fields.primitive = place.triangle->primitive;
        fields.triangle = place.triangle->index;
    }
    if (place.view != glm::dvec3(0)) fields.view = place.view;
    if (fields.view || fields.mip) {
        fields.m = place.m;
        fields.f0 = place.f0;
    }
    return fields;
}

verify::VisiblePlace FieldMirror<verify::VisiblePlace>::from(const VisiblePlaceFields& fields) {
    return {.x = fields.texel[0],
            .y = fields.texel[1],
            .mip = fields.mip.value_or(-1),
            .face = indexOf(kFaces, fields.face).value_or(-1),
            .triangle = fields.primitive && fields.triangle ? std::optional(verify::MeshTriangle{*fields.primitive, *fields.triangle})
                                                            : std::nullopt,
            .normal = fields.normal,
            .view = fields.view.value_or(glm::dvec3(0)),
            .m = fields.m.value_or(0),
            .f0 = fields.f0.value_or(0),
            .reference = fields.reference,
            .found = fields.found};
}

ErrorPlaceFields FieldMirror<verify::ErrorPlace>::of(const verify::ErrorPlace& place) {
    ErrorPlaceFields fields;
    if (place.mip >= 0) fields.mip = place.mip;
    if (place.face >= 0) fields.face = kFaces.at(static_cast<std::size_t>(place.face));
    if (place.x >= 0) fields.texel = {place.x, place.y};
    if (place.channel) fields.channel = kChannels.at(static_cast<std::size_t>(*place.channel));
    if (place.normal != glm::dvec3(0)) fields.normal = place.normal;
    if (place.view != glm::dvec3(0)) {
        fields.view = place.view;
        fields.f0 = place.f0;
    }
    if (place.m > 0) fields.m = place.m;
    if (place.reference != 0 || place.found != 0) {
        fields.reference = place.reference;
        fields.found = place.found;
    }
    if (place.local != 0) fields.local = place.local;
    return fields;
}

verify::ErrorPlace FieldMirror<verify::ErrorPlace>::from(const ErrorPlaceFields& fields) {
    verify::ErrorPlace place;
    place.mip = fields.mip.value_or(-1);
    place.face = indexOf(kFaces, fields.face).value_or(-1);
    if (fields.texel) {
        place.x = (*fields.texel)[0];
        place.y = (*fields.texel)[1];
    }
    place.channel = indexOf(kChannels, fields.channel);
    place.normal = fields.normal.value_or(glm::dvec3(0));
    place.view = fields.view.value_or(glm::dvec3(0));
    place.m = fields.m.value_or(0);
    place.f0 = fields.f0.value_or(0);
    place.reference = fields.reference.value_or(0);
    place.found = fields.found.value_or(0);
    place.local = fields.local.value_or(0);
    return place;
}

std::vector<Figure> figuresOf(const verify::StageError& stage) {
    std::vector<Figure> figures = {{Limit::Error, stage.diffuse.relRms, stage.name, "diffuse"},
                                   {Limit::Error, stage.specular.relRms, stage.name, "specular"}};
    const auto addVisible = [&](const verify::ErrorFigures& of, const char* shading) {
        if (!of.visible) return;
        figures.push_back({Limit::Visible, of.visible->p99, stage.name, shading});
        if (of.visible->bound) figures.push_back({Limit::VisibleBound, *of.visible->bound, stage.name, shading});
    };
    addVisible(stage.diffuse, "diffuse");
    addVisible(stage.specular, "specular");
    return figures;
}

Verdict makeVerdict(std::vector<verify::StageError> stages, const Limits& limits, std::vector<verify::Violation> violations) {
    const auto& maxVisibleBound = limits[Limit::VisibleBound];
    if (maxVisibleBound && !stages.empty() && !hasVisibleBound(stages.back()))
        violations.push_back(unknownBound(stageWords(stages.back().name), *maxVisibleBound));
    Verdict verdict;
    verdict.limits = limits;
    verdict.passed = !stages.empty() && violations.empty() && areKept(judge(figuresOf(stages.back()), limits));
    for (const verify::StageError& stage : stages) verdict.passed = verdict.passed && isFinite(stage.diffuse) && isFinite(stage.specular);
    verdict.stages = std::move(stages);
    verdict.violations = std::move(violations);
    return verdict;
}

bool addsError(double before, double after, double rounding) {
    // The first stage of even light is exact, and a second one rounds: 2.5e-4 was seen.
    constexpr double kSlack = 1.05, kLeast = 5e-4;
    return after > std::max(kSlack * before + kLeast, rounding);
}

void checkStage(const std::vector<verify::StageError>& stages, const std::string& before, const std::string& after, double rounding,
                std::vector<verify::Violation>& violations) {
    const auto first = std::ranges::find(stages, before, &verify::StageError::name);
    const auto second = std::ranges::find(stages, after, &verify::StageError::name);
    if (first == stages.end() || second == stages.end()) return;
    const double errorBefore = std::max(first->diffuse.relRms, first->specular.relRms);
    const double errorAfter = std::max(second->diffuse.relRms, second->specular.relRms);
    if (!addsError(errorBefore, errorAfter, rounding)) return;
    violations.push_back({stageWords(after), fmt::format("rel_rms {:.4g}", errorAfter),
                          fmt::format("no more than without it ({:.4g}): it belongs to something else", errorBefore)});
}

}  // namespace lightcook::pipeline
