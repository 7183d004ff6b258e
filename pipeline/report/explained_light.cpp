#include "pipeline/report/explained_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "fit/dominant_light.h"
#include "fit/light_search.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Thresholds for which the report counts texels with a larger residual.
constexpr std::array<double, 3> kLevels = {0.1, 0.25, 0.5};
constexpr std::size_t kWorstCount = 8;
/// Approximate number of texels to which two lights are fitted.
constexpr double kSecondLights = 1e4;

std::string levelName(double level) {
    return fmt::format("residual_over_{:.0f}_percent", 100 * level);
}

double energyOf(const lighting::ShRgb& sh) {
    double energy = 0;
    for (const glm::vec3& c : sh) energy += glm::dot(glm::dvec3(c), glm::dvec3(c));
    return energy;
}

/// Distribution of the residuals of one fit over many texels.
class ResidualStatistics {
public:
    void add(double unexplained, double energy) {
        const double residual = std::sqrt(unexplained);
        texels_ += 1;
        energy_ += energy;
        left_ += unexplained * energy;
        ++histogram_[std::min(histogram_.size() - 1, static_cast<std::size_t>(residual * kBins))];
        for (std::size_t i = 0; i < kLevels.size(); ++i) {
            if (residual <= kLevels[i]) continue;
            texelsOver_[i] += 1;
            energyOver_[i] += energy;
        }
    }
    void merge(const ResidualStatistics& other) {
        texels_ += other.texels_;
        energy_ += other.energy_;
        left_ += other.left_;
        for (std::size_t i = 0; i < histogram_.size(); ++i) histogram_[i] += other.histogram_[i];
        for (std::size_t i = 0; i < kLevels.size(); ++i) {
            texelsOver_[i] += other.texelsOver_[i];
            energyOver_[i] += other.energyOver_[i];
        }
    }
    double texels() const { return texels_; }
    double energy() const { return energy_; }
    Json toJson() const {
        Json json = {
            {"unexplained_energy", share(left_, energy_)}, {"median_residual", percentile(0.5)}, {"p99_residual", percentile(0.99)}};
        for (std::size_t i = 0; i < kLevels.size(); ++i)
            json[levelName(kLevels[i])] = {{"texels", share(texelsOver_[i], texels_)}, {"energy", share(energyOver_[i], energy_)}};
        return json;
    }

private:
    static constexpr std::size_t kBins = 1000;
    static double share(double part, double whole) { return whole > 0 ? part / whole : 0; }
    double percentile(double fraction) const {
        double below = 0;
        for (std::size_t i = 0; i < histogram_.size(); ++i) {
            below += static_cast<double>(histogram_[i]);
            if (below > 0 && below >= fraction * texels_) return (static_cast<double>(i) + 0.5) / static_cast<double>(kBins);
        }
        return 0;
    }

    double texels_ = 0, energy_ = 0, left_ = 0;
    std::array<std::int64_t, kBins + 1> histogram_{};
    std::array<double, kLevels.size()> texelsOver_{}, energyOver_{};
};

/// The texel with the largest squared error under the best light.
struct Worst {
    int x = 0, y = 0;
    double left = -1;  ///< squared error
    lighting::ShRgb sh{};
    glm::dvec3 hint{0, 0, 1};
};

struct BandFindings {
    ResidualStatistics closed, best, two;
    Worst worst;
};

glm::dvec3 closedDirection(const lighting::ShRgb& sh, const glm::vec3& normal, const glm::vec3& weights) {
    fit::DominantLightOptions options;
    options.luminanceWeights = weights;
    return glm::normalize(glm::dvec3(fit::dominantLight(sh, normal, options).direction));
}

BandFindings examine(const formats::LightMapStrip& band, const glm::vec3& weights, int secondLightEvery, bool hasAmbient) {
    BandFindings findings;
    for (int row = 0; row < band.sh.height(); ++row)
        for (int x = 0; x < band.sh.width(); ++x) {
            if (band.covered.at(x, row) == 0) continue;
            const lighting::ShRgb& sh = band.sh.at(x, row);
            const double energy = energyOf(sh);
            const glm::dvec3 hint = closedDirection(sh, band.normal.at(x, row), weights);
            findings.closed.add(fit::lightTowards(sh, hint, hasAmbient).unexplained, energy);
            const double unexplained = fit::bestLight(sh, hint, hasAmbient).unexplained;
            findings.best.add(unexplained, energy);
            const int y = band.firstRow + row;
            if (unexplained * energy > findings.worst.left) findings.worst = {x, y, unexplained * energy, sh, hint};
            if (x % secondLightEvery == 0 && y % secondLightEvery == 0)
                findings.two.add(fit::bestTwoLights(sh, hint, hasAmbient).unexplained, energy);
        }
    return findings;
}

Json toJson(const fit::LightFit& light) {
    return {{"direction", {light.direction.x, light.direction.y, light.direction.z}},
            {"intensity", {light.intensity.x, light.intensity.y, light.intensity.z}}};
}

Json toJson(const Worst& worst, double wholeEnergy, bool hasAmbient) {
    const fit::TwoLights two = fit::bestTwoLights(worst.sh, worst.hint, hasAmbient);
    return {{"x", worst.x},
            {"y", worst.y},
            {"share_of_energy", energyOf(worst.sh) / wholeEnergy},
            {"residual_closed", std::sqrt(fit::lightTowards(worst.sh, worst.hint, hasAmbient).unexplained)},
            {"residual", std::sqrt(fit::bestLight(worst.sh, worst.hint, hasAmbient).unexplained)},
            {"residual_with_two", std::sqrt(two.unexplained)},
            {"first", toJson(two.first)},
            {"second", toJson(two.second)}};
}

std::string leftoverLine(const std::string& name, const Json& leftovers) {
    std::string line = fmt::format("{:<12}{:>11.2f}{:>9.1f}{:>9.1f}", name, 100 * leftovers.at("unexplained_energy").get<double>(),
                                   100 * leftovers.at("median_residual").get<double>(), 100 * leftovers.at("p99_residual").get<double>());
    for (const double level : kLevels) {
        const Json& over = leftovers.at(levelName(level));
        line += fmt::format("{:>9.1f} /{:>5.1f}", 100 * over.at("texels").get<double>(), 100 * over.at("energy").get<double>());
    }
    return line;
}

std::string lightText(const Json& light) {
    const auto triple = [](const Json& v) {
        return fmt::format("{:.3g} {:.3g} {:.3g}", v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>());
    };
    return fmt::format("({}) towards ({})", triple(light.at("intensity")), triple(light.at("direction")));
}

}  // namespace

Result<Json> explainDominant(const std::filesystem::path& file, const formats::LightMapDescription& description, bool hasAmbient,
                             const RunState& state) {
    SharedObjects shared;
    LC_TRY(source, shared.get<LightMapSources>().open(file, description));
    LightMapSource& bake = **source;
    const Action action{"", "", file.filename().string(), {}, {}, {}};
    const ActionContext context{action, {}, {}, {}, shared, state};
    const int every =
        std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(bake.width()) * bake.height() / kSecondLights))));
    const auto parts =
        mapInOrder<BandFindings>(bake.chunkCount(), context, "explain " + action.asset, [&](int index) -> Result<BandFindings> {
            LC_TRY(band, bake.chunk(index));
            return examine(**band, bake.luminanceWeights(), every, hasAmbient);
        });
    if (!parts) return tl::make_unexpected(parts.error());
    BandFindings total;
    std::vector<Worst> worst;
    for (const BandFindings& part : *parts) {
        total.closed.merge(part.closed);
        total.best.merge(part.best);
        total.two.merge(part.two);
        if (part.worst.left > 0) worst.push_back(part.worst);
    }
    std::stable_sort(worst.begin(), worst.end(), [](const Worst& a, const Worst& b) { return a.left > b.left; });
    if (worst.size() > kWorstCount) worst.resize(kWorstCount);
    Json json = {{"texels", static_cast<std::int64_t>(total.best.texels())},
                 {"ambient", hasAmbient},
                 {"closed_form", total.closed.toJson()},
                 {"best_light", total.best.toJson()},
                 {"two_lights", total.two.toJson()}};
    json["two_lights"]["texels_tried"] = static_cast<std::int64_t>(total.two.texels());
    // One worst texel for each strip of rows, so that they are spread over the map.
    json["worst_texels"] = Json::array();
    for (const Worst& each : worst) json["worst_texels"].push_back(toJson(each, total.best.energy(), hasAmbient));
    return json;
}

std::vector<std::string> linesOf(const Json& explanation) {
    std::vector<std::string> lines = {fmt::format("{} texels{}; percent", explanation.at("texels").get<std::int64_t>(),
                                                  explanation.at("ambient").get<bool>() ? ", beside ambient light" : ""),
                                      "            unexplained   median      p99   over 10 %       over 25 %       over 50 %",
                                      "                 energy residual residual  texels / energy"};
    for (const auto& [key, name] : {std::pair{"closed_form", "closed form"}, {"best_light", "best light"}, {"two_lights", "two lights"}})
        lines.push_back(leftoverLine(name, explanation.at(key)));
    lines.push_back(fmt::format("two lights: of {} texels", explanation.at("two_lights").at("texels_tried").get<std::int64_t>()));
    for (const Json& worst : explanation.at("worst_texels"))
        lines.push_back(fmt::format("texel {}, {}: closed form leaves {:.1f} %, the best light {:.1f} %, two {:.1f} %: {}, {}",
                                    worst.at("x").get<int>(), worst.at("y").get<int>(), 100 * worst.at("residual_closed").get<double>(),
                                    100 * worst.at("residual").get<double>(), 100 * worst.at("residual_with_two").get<double>(),
                                    lightText(worst.at("first")), lightText(worst.at("second"))));
    return lines;
}

}  // namespace lightcook::pipeline
