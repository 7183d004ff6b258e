#include "pipeline/report/failures.h"

#include <fmt/format.h>

#include <cmath>

namespace lightcook::pipeline {
namespace {

double figure(const Json& error, const char* key) {
    const auto found = error.find(key);
    return found != error.end() && found->is_number() ? found->get<double>() : std::nan("");
}

std::string vectorWords(const Json& v) {
    if (!v.is_array()) return "";
    std::string words;
    for (const Json& each : v)
        words += fmt::format("{}{:.4g}", words.empty() ? "" : ", ", each.is_number() ? each.get<double>() : std::nan(""));
    return "(" + words + ")";
}

/// Returns ": found 1.2, expected 0.9, off by 0.3, allowed 0.02".
std::string lightWords(const Json& at, double allowed) {
    const double found = figure(at, "found"), reference = figure(at, "reference");
    if (!std::isfinite(found) || !std::isfinite(reference)) return "";
    const std::string words = fmt::format(": found {:.4g}, expected {:.4g}, off by {:.4g}", found, reference, std::abs(found - reference));
    return std::isfinite(allowed) ? words + fmt::format(", allowed {:.4g}", allowed) : words;
}

/// Returns the difference of light at a place that is a local relative error of `limit`; NaN if the place has no figures.
double allowedAt(const Json& at, double limit) {
    const double local = figure(at, "local"), off = std::abs(figure(at, "found") - figure(at, "reference"));
    return local > 0 && std::isfinite(local) ? limit * off / local : std::nan("");
}

class Failures {
public:
    explicit Failures(const Json& asset) : asset_(asset) {}

    /// Adds a failure. subject: without the asset's name; at: a place of report.json, or null.
    void add(const std::string& subject, const std::string& detail, const Json& facts, const Json& at, double allowed) {
        Json failure = {{"asset", asset_.at("name")}, {"kind", asset_.at("kind")}};
        failure.update(facts);
        std::string text = detail;
        if (at.is_object()) {
            failure.update(at);
            failure.erase("local");
            if (std::isfinite(allowed)) failure["allowed"] = allowed;
            text += "; worst at " + placeWords(at) + lightWords(at, allowed);
        }
        failure["subject"] = asset_.at("name").get<std::string>() + ", " + subject;
        failure["detail"] = text;
        failure["message"] = failure["subject"].get<std::string>() + ": " + text;
        list.push_back(std::move(failure));
    }
    Json list = Json::array();

private:
    const Json& asset_;
};

/// Adds a failure for each kind of shading of a stage that is over the limit or has figures that are not finite.
void addStage(const Json& stage, double limit, bool isLast, Failures& failures) {
    const std::string name = stage.at("name").get<std::string>();
    for (const char* shading : {"diffuse", "specular"}) {
        const Json& error = stage.at("error").at(shading);
        bool isFinite = true;
        for (const char* key : {"rel_rms", "p99", "max_sampled", "max_bound"}) isFinite = isFinite && std::isfinite(figure(error, key));
        const double relRms = figure(error, "rel_rms");
        if (isFinite && !(isLast && relRms > limit)) continue;
        const auto at = error.find("sampled_at");
        failures.add(
            fmt::format("stage {}, {}", name, shading),
            fmt::format("found rel_rms {:.4g}, expected at most {:.4g}{}", relRms, limit, isFinite ? "" : " and every figure finite"),
            {{"stage", name}, {"shading", shading}, {"rel_rms", relRms}, {"limit", limit}}, at != error.end() ? *at : Json(),
            at != error.end() ? allowedAt(*at, limit) : std::nan(""));
    }
}

}  // namespace

std::string placeWords(const Json& at) {
    std::string words;
    if (!at.is_object()) return words;
    const auto add = [&](const std::string& more) { words += (words.empty() ? "" : ", ") + more; };
    for (const char* key : {"mip", "face", "texel", "channel", "normal", "view", "m", "f0"}) {
        const auto found = at.find(key);
        if (found == at.end()) continue;
        const std::string name = std::string(key) == "f0" ? "F0" : key;
        if (found->is_array()) add(name + " " + vectorWords(*found));
        if (found->is_number()) add(fmt::format("{} {:.4g}", name, found->get<double>()));
        if (found->is_string()) add((name == "channel" ? "" : name + " ") + found->get<std::string>());
    }
    return words;
}

Json failuresOf(const Json& asset) {
    Failures failures(asset);
    const double limit = asset.at("limit").at("value").get<double>();
    const Json& stages = asset.at("stages");
    for (const Json& each : asset.value("violations", Json::array())) {
        const std::string place = each.at("place").get<std::string>();
        const auto at = each.find("at");
        failures.add(place,
                     fmt::format("found {}, expected {}", each.at("found").get<std::string>(), each.at("expected").get<std::string>()),
                     {{"stage", stages.back().at("name")}, {"place", place}}, at != each.end() ? *at : Json(),
                     at != each.end() ? allowedAt(*at, limit) : std::nan(""));
    }
    for (const Json& stage : stages) addStage(stage, limit, &stage == &stages.back(), failures);
    return failures.list;
}

std::vector<formats::Error> errorsOf(const Json& failures) {
    std::vector<formats::Error> errors;
    for (const Json& each : failures)
        errors.push_back({formats::ErrorCode::Verification, each.at("subject").get<std::string>(), each.at("detail").get<std::string>()});
    return errors;
}

}  // namespace lightcook::pipeline
