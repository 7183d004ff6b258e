#include "pipeline/graph/work_rates.h"

#include <cmath>

#include "pipeline/document/json.h"
#include "pipeline/graph/files.h"

namespace lightcook::pipeline {

WorkRates::WorkRates(std::filesystem::path file) : file_(std::move(file)) {
    const auto text = readFile(file_);
    if (!text) return;
    const Json json = parseJson(*text);
    if (!json.is_object()) return;
    for (const auto& [kind, rate] : json.items())
        if (rate.is_number() && std::isfinite(rate.get<double>()) && rate.get<double>() >= 0) secondsPerTexel_[kind] = rate.get<double>();
}

void WorkRates::add(const std::string& kind, double texels, double seconds) {
    if (!(texels > 0)) return;
    secondsPerTexel_[kind] = seconds / texels;
    isChanged_ = true;
}

std::optional<double> WorkRates::secondsOf(const std::string& kind, double texels) const {
    const auto rate = secondsPerTexel_.find(kind);
    return rate == secondsPerTexel_.end() ? std::nullopt : std::optional(rate->second * texels);
}

void WorkRates::save() const {
    if (isChanged_) (void)writeFile(file_, Json(secondsPerTexel_).dump());
}

}  // namespace lightcook::pipeline
