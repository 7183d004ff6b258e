#include "pipeline/assets/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace lightcook::pipeline {
namespace {

bool isFinite(const verify::ErrorFigures& figures) {
    return std::isfinite(figures.relRms) && std::isfinite(figures.p99) && std::isfinite(figures.maxSampled) &&
           std::isfinite(figures.maxBound);
}

}  // namespace

Json toJson(const verify::ErrorPlace& place) {
    constexpr std::array kFaces = {"+X", "-X", "+Y", "-Y", "+Z", "-Z"};
    constexpr std::array kChannels = {"red", "green", "blue"};
    Json json = Json::object();
    if (place.mip >= 0) json["mip"] = place.mip;
    if (place.face >= 0) json["face"] = kFaces.at(static_cast<std::size_t>(place.face));
    if (place.x >= 0) json["texel"] = {place.x, place.y};
    if (place.channel >= 0) json["channel"] = kChannels.at(static_cast<std::size_t>(place.channel));
    const auto direction = [&](const char* key, const glm::dvec3& v) {
        if (v != glm::dvec3(0)) json[key] = {v.x, v.y, v.z};
    };
    direction("normal", place.normal);
    direction("view", place.view);
    if (place.m > 0) json["m"] = place.m;
    if (place.view != glm::dvec3(0)) json["f0"] = place.f0;
    if (place.reference != 0 || place.found != 0) {
        json["reference"] = place.reference;
        json["found"] = place.found;
    }
    if (place.local != 0) json["local"] = place.local;
    return json;
}

Json toJson(const verify::ErrorFigures& figures) {
    Json json = {{"rel_rms", figures.relRms}, {"p99", figures.p99}, {"max_sampled", figures.maxSampled}, {"max_bound", figures.maxBound}};
    if (figures.sampledAt.isKnown()) json["sampled_at"] = toJson(figures.sampledAt);
    if (figures.boundAt.isKnown()) json["bound_at"] = toJson(figures.boundAt);
    return json;
}

Json toJson(const verify::StageError& stage) {
    return {{"name", stage.name},
            {"seconds", stage.seconds},
            {"error", {{"diffuse", toJson(stage.diffuse)}, {"specular", toJson(stage.specular)}}}};
}

Json verdict(const std::vector<verify::StageError>& stages, double maxError, const std::vector<verify::Violation>& violations) {
    Json result = {{"stages", Json::array()}, {"limit", {{"metric", "rel_rms"}, {"value", maxError}}}, {"passed", false}};
    bool passed = !stages.empty();
    for (const verify::StageError& stage : stages) {
        result["stages"].push_back(toJson(stage));
        passed = passed && isFinite(stage.diffuse) && isFinite(stage.specular);
    }
    result["passed"] =
        passed && violations.empty() && stages.back().diffuse.relRms <= maxError && stages.back().specular.relRms <= maxError;
    for (const verify::Violation& each : violations) {
        result["violations"].push_back({{"place", each.place}, {"found", each.found}, {"expected", each.expected}});
        if (each.at.isKnown()) result["violations"].back()["at"] = toJson(each.at);
    }
    return result;
}

std::optional<verify::BlockErrors::Block> checkBlocks(const verify::BlockErrors& blocks, const std::string& image, double maxError,
                                                      std::vector<verify::Violation>& violations, double leastMean) {
    const auto worst = blocks.worst(leastMean);
    const double allowed = verify::BlockErrors::allowed(maxError);
    if (!worst || worst->error <= allowed) return {};
    violations.push_back({fmt::format("{}block of texel ({}, {})", image, worst->x, worst->y),
                          fmt::format("an error of {:.3g} of its light", worst->error), fmt::format("at most {:.3g}", allowed)});
    return worst;
}

void checkStage(const std::vector<verify::StageError>& stages, const std::string& before, const std::string& after,
                std::vector<verify::Violation>& violations) {
    const auto first = std::ranges::find(stages, before, &verify::StageError::name);
    const auto second = std::ranges::find(stages, after, &verify::StageError::name);
    if (first == stages.end() || second == stages.end()) return;
    // A first stage that is all but right may lose to the rounding of a second one.
    constexpr double kSlack = 1.05, kLeast = 2e-4;
    const double errorBefore = std::max(first->diffuse.relRms, first->specular.relRms);
    const double errorAfter = std::max(second->diffuse.relRms, second->specular.relRms);
    if (errorAfter <= kSlack * errorBefore + kLeast) return;
    violations.push_back({"stage " + after, fmt::format("rel_rms {:.4g}", errorAfter),
                          fmt::format("no more than without it ({:.4g}): it belongs to something else", errorBefore)});
}

}  // namespace lightcook::pipeline
