#include "pipeline/graph/work_rates.h"

#include <cmath>

#include "pipeline/document/json.h"
#include "pipeline/graph/files.h"

namespace lightcook::pipeline {
namespace {

constexpr const char *kTexels = "texels", *kSeconds = "seconds";
/// Of the texels of the asset that was measured: above, the rate is not that of texels.
constexpr double kLargestRatio = 16;

}  // namespace

WorkRates::WorkRates(std::filesystem::path file) : file_(std::move(file)) {
    const auto text = readFile(file_);
    if (!text) return;
    const Json json = parseJson(*text);
    if (!json.is_object()) return;
    const auto numberOf = [](const Json& entry, const char* key) {
        const auto found = entry.is_object() ? entry.find(key) : entry.end();
        return found != entry.end() && found->is_number() ? found->get<double>() : std::nan("");
    };
    for (const auto& [kind, entry] : json.items()) {
        const Measured measured{numberOf(entry, kTexels), numberOf(entry, kSeconds)};
        if (measured.texels > 0 && std::isfinite(measured.texels) && measured.seconds >= 0 && std::isfinite(measured.seconds))
            measured_[kind] = measured;
    }
}

void WorkRates::add(const std::string& kind, double texels, double seconds) {
    if (!(texels > 0)) return;
    measured_[kind] = {texels, seconds};
    isChanged_ = true;
}

std::optional<double> WorkRates::secondsOf(const std::string& kind, double texels) const {
    const auto found = measured_.find(kind);
    if (found == measured_.end() || texels > kLargestRatio * found->second.texels) return std::nullopt;
    return found->second.seconds * texels / found->second.texels;
}

void WorkRates::save() const {
    if (!isChanged_) return;
    Json json = Json::object();
    for (const auto& [kind, measured] : measured_) json[kind] = {{kTexels, measured.texels}, {kSeconds, measured.seconds}};
    (void)writeFile(file_, json.dump());
}

}  // namespace lightcook::pipeline
