#include "pipeline/report/whole_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pipeline/assets/lut/light_moments.h"
#include "pipeline/report/html.h"
#include "pipeline/report/page_parts.h"

namespace lightcook::pipeline {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
/// The verifier writes the largest double for a figure that exceeds every limit; sums must not use it.
constexpr double kNoFigure = 1e300;

constexpr std::array kLightNames = {"diffuse", "area_specular", "analytic_specular", "environment"};
enum Light { kDiffuse, kArea, kAnalytic, kEnvironment };
using Lights = std::array<double, kLightNames.size()>;

double square(double value) {
    return value * value;
}

double figure(const Json& object, const char* key) {
    const double value = number(member(object, key));
    return value < kNoFigure ? value : kNan;
}

Json finiteOrNull(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

const Json& errorOf(const Json& stage, const char* shading) {
    return stage.at("error").at(shading);
}
double relRmsOf(const Json& asset, const char* shading) {
    return figure(errorOf(asset.at("stages").back(), shading), "rel_rms");
}

bool isKind(const Json& asset, const char* kind) {
    return asset.at("kind") == kind;
}
double lightOf(const Json& asset, const char* key) {
    return asset.contains("light") ? figure(asset.at("light"), key) : kNan;
}

/// Returns error / light: 0 for no error without light, infinity for an error without light.
double relative(double squaredError, double squaredLight) {
    return squaredError == 0 ? 0 * squaredLight : std::sqrt(squaredError / squaredLight);
}

Moments momentsOf(const Json& asset, const char* key) {
    Moments moments;
    moments.fill(kNan);
    const Json& list = member(asset.at("light"), key);
    if (list.is_array() && list.size() == moments.size())
        for (std::size_t i = 0; i < moments.size(); ++i)
            if (list[i].is_number()) moments[i] = list[i].get<double>();
    return moments;
}
/// Returns the rel_rms of the light that the tables reflect of a light map.
double tablesRelRms(const Json& tables, const Json& map) {
    const Moments light = momentsOf(map, "moments");
    return relative(meanSquare(momentsOf(tables, "error_moments"), light), meanSquare(momentsOf(tables, "kernel_moments"), light));
}

/// One asset in one kind of shading. Members are squares, so that averages over light maps are sums.
struct Part {
    const Json* asset;
    const char* shading;  ///< the figures' kind of shading: "diffuse" or "specular"
    const char* name;     ///< of the shading, as reported
    double squaredError = 0, squaredLight = 0;
    bool isAlternative = false;  ///< a pixel has the error of only one of the alternatives
};

/// All light that the pixels of one light map, or of all light maps, show.
struct Shading {
    Lights squaredLights{};
    std::vector<Part> parts;
    double squaredBound = 0;

    double squaredLight() const {
        double sum = 0;
        for (const double light : squaredLights) sum += light;
        return sum;
    }
    double squaredError() const {
        double sum = 0;
        for (const Part& part : parts) sum += part.squaredError;
        return sum;
    }
    /// Upper bound: errors of one pixel add up at worst; of alternatives it has only one.
    void bound() {
        double sum = 0, alternatives = 0;
        for (const Part& part : parts) {
            if (part.isAlternative)
                alternatives += part.squaredError;
            else
                sum += std::sqrt(part.squaredError);
        }
        squaredBound = square(sum + std::sqrt(alternatives));
    }
    /// Adds the light of a part of all pixels, weighted by its share.
    void add(const Shading& other, double weight) {
        for (std::size_t i = 0; i < squaredLights.size(); ++i) squaredLights[i] += weight * other.squaredLights[i];
        squaredBound += weight * other.squaredBound;
        for (const Part& part : other.parts) {
            auto mine = std::ranges::find_if(
                parts, [&](const Part& each) { return each.asset == part.asset && std::string(each.name) == part.name; });
            if (mine == parts.end()) {
                parts.push_back({part.asset, part.shading, part.name, 0, 0, part.isAlternative});
                mine = parts.end() - 1;
            }
            mine->squaredError += weight * part.squaredError;
            mine->squaredLight += weight * part.squaredLight;
        }
    }
};

class Whole {
public:
    explicit Whole(const std::vector<Json>& assets) : assets_(assets) {
        for (const Json& asset : assets)
            if (isKind(asset, "light-map") && asset.contains("light"))
                lightMaps_.push_back(&asset);
            else if (isKind(asset, "lut") && asset.contains("light"))
                tables_.push_back(&asset);
            else if (isKind(asset, "cubemap") && asset.contains("light"))
                probes_.push_back(&asset);
        for (const Json* probe : probes_) squaredRatio_ += square(lightOf(*probe, "ratio_rms")) / static_cast<double>(probes_.size());
    }

    Json toJson() const {
        if (lightMaps_.empty()) return nullptr;
        std::vector<Shading> shadings;
        double texels = 0;
        for (const Json* map : lightMaps_) {
            shadings.push_back(shadingOf(*map));
            texels += lightOf(*map, "texels");
        }
        Shading scene;
        Json maps = Json::array();
        for (std::size_t i = 0; i < lightMaps_.size(); ++i) {
            // A map without covered texels shows nothing; if no map has any, all weigh the same.
            const double weight = texels > 0 ? lightOf(*lightMaps_[i], "texels") / texels : 1 / static_cast<double>(lightMaps_.size());
            scene.add(shadings[i], weight);
            Json entry = {{"name", lightMaps_[i]->at("name")}, {"weight", finiteOrNull(weight)}};
            entry.update(describe(shadings[i]));
            maps.push_back(entry);
        }
        Json whole = describe(scene);
        if (maps.size() > 1) whole["light_maps"] = maps;
        whole["apart"] = apart(scene);
        return whole;
    }

private:
    /// Returns the light map that a light or a mesh belongs to: the one with the same bake; of several, the one whose name theirs begins
    /// with.
    const Json* mapOf(const Json& asset) const {
        const auto bakeOf = [](const Json& each) { return each.contains("light") ? each.at("light").value("bake", "") : std::string(); };
        const Json* found = nullptr;
        bool isNamed = false;
        const std::string name = asset.at("name").get<std::string>();
        for (const Json* map : lightMaps_) {
            if (bakeOf(*map) != bakeOf(asset)) continue;
            const std::string mapName = map->at("name").get<std::string>();
            const bool begins = name.starts_with(mapName + "_");
            const bool isLonger = found != nullptr && mapName.size() > found->at("name").get_ref<const std::string&>().size();
            if (found != nullptr && (!begins || (isNamed && !isLonger))) continue;
            found = map;
            isNamed = begins;
        }
        return found;
    }

    Shading shadingOf(const Json& map) const {
        Shading shading;
        const auto add = [&](const Json& asset, const char* kind, const char* name, double relRms, double light,
                             bool isAlternative = false) {
            shading.parts.push_back({&asset, kind, name, square(relRms * light), square(light), isAlternative});
        };
        const double diffuse = lightOf(map, "diffuse_rms"), specular = lightOf(map, "specular_rms");
        shading.squaredLights[kDiffuse] = square(diffuse);
        add(map, "diffuse", "diffuse", relRmsOf(map, "diffuse"), diffuse);
        for (const Json& asset : assets_) {
            const bool isDominant = isKind(asset, "dominant");
            if ((!isDominant && !isKind(asset, "mesh")) || !asset.contains("light") || mapOf(asset) != &map) continue;
            const double light = lightOf(asset, isDominant ? "specular_rms" : "diffuse_rms");
            if (isDominant) shading.squaredLights[kAnalytic] += square(light);
            add(asset, isDominant ? "specular" : "diffuse", isDominant ? "analytic specular" : "diffuse",
                relRmsOf(asset, isDominant ? "specular" : "diffuse"), light);
        }
        if (specular != 0) {
            shading.squaredLights[kArea] = square(specular);
            shading.squaredLights[kEnvironment] = squaredRatio_ * square(specular);
            // An error of S is visible twice: directly, and in the environment's light R S.
            const double reflected = specular * (1 + std::sqrt(squaredRatio_));
            add(map, "specular", "area specular", relRmsOf(map, "specular"), reflected);
            for (const Json* tables : tables_) add(*tables, "specular", "area specular", tablesRelRms(*tables, map), reflected);
            for (const Json* probe : probes_)
                add(*probe, "specular", "environment", lightOf(*probe, "ratio_rel_rms"),
                    specular * lightOf(*probe, "ratio_rms") / std::sqrt(static_cast<double>(probes_.size())), true);
        }
        shading.bound();
        return shading;
    }

    /// Returns the share of each stage if it were alone, in proportion to its own rel_rms.
    static Json stagesOf(const Part& part, double share) {
        Json stages = Json::array();
        const double total = relRmsOf(*part.asset, part.shading);
        const Json& all = part.asset->at("stages");
        for (std::size_t i = 0; i + 1 < all.size(); ++i) {
            const double own = figure(errorOf(all[i], part.shading), "rel_rms");
            stages.push_back({{"name", all[i].at("name")}, {"share", finiteOrNull(own == 0 ? 0 : share * square(own / total))}});
        }
        return stages;
    }

    static Json describe(const Shading& shading) {
        const double error = shading.squaredError(), light = shading.squaredLight();
        Json lights;
        for (std::size_t i = 0; i < kLightNames.size(); ++i) lights[kLightNames[i]] = finiteOrNull(std::sqrt(shading.squaredLights[i]));
        std::vector<std::pair<double, Json>> parts;
        for (const Part& part : shading.parts) {
            const double share = error == 0 ? 0 : part.squaredError / error;
            parts.push_back({std::isfinite(share) ? share : -1,
                             {{"asset", part.asset->at("name")},
                              {"kind", part.asset->at("kind")},
                              {"shading", part.name},
                              {"share", finiteOrNull(share)},
                              {"rel_rms", finiteOrNull(relative(part.squaredError, part.squaredLight))},
                              {"light_rms", finiteOrNull(std::sqrt(part.squaredLight))},
                              {"stages", stagesOf(part, share)}}});
        }
        std::ranges::stable_sort(parts, std::ranges::greater{}, &std::pair<double, Json>::first);
        Json list = Json::array();
        for (auto& [share, part] : parts) list.push_back(std::move(part));
        return {{"rel_rms", finiteOrNull(relative(error, light))},
                {"rel_rms_bound", finiteOrNull(relative(shading.squaredBound, light))},
                {"light_rms", finiteOrNull(std::sqrt(light))},
                {"lights", lights},
                {"parts", list}};
    }

    Json apart(const Shading& scene) const {
        Json rows = Json::array();
        for (const Json& asset : assets_) {
            if (std::ranges::find(scene.parts, &asset, &Part::asset) != scene.parts.end()) continue;
            const double diffuse = relRmsOf(asset, "diffuse"), specular = relRmsOf(asset, "specular");
            const double worse = std::isnan(diffuse) || std::isnan(specular) ? kNan : std::max(diffuse, specular);
            rows.push_back({{"asset", asset.at("name")}, {"kind", asset.at("kind")}, {"rel_rms", finiteOrNull(worse)}});
        }
        return rows;
    }

    const std::vector<Json>& assets_;
    std::vector<const Json*> lightMaps_, tables_, probes_;
    double squaredRatio_ = 0;  ///< mean square of R over the cubemaps
};

/// Returns the way to reduce the error of a kind of asset, for more memory or time.
const char* remedyOf(const std::string& kind) {
    if (kind == "light-map") return "a richer light_map_layout, or more effort, buys most";
    if (kind == "dominant") return "more effort, or target \"float\", buys most";
    if (kind == "cubemap") return "more effort, or target \"float\", buys most";
    if (kind == "lut") return "finer tables (lut --views) cost a KiB or two and buy most";
    return "more bits (draco = false, or a stricter max_error) buy most";
}

}  // namespace

Json wholeError(const std::vector<Json>& assets) {
    return Whole(assets).toJson();
}

std::string adviceOf(const Json& whole) {
    const Json &parts = member(whole, "parts"), &first = parts.is_array() && !parts.empty() ? parts.front() : Json();
    const double relRms = figure(whole, "rel_rms"), share = figure(first, "share");
    if (!std::isfinite(relRms) || !std::isfinite(share)) return "A figure is not finite: there is no sum.";
    if (share == 0) return "There is no error.";
    const auto textOfKey = [&](const char* key) { return words(member(first, key)); };
    return fmt::format("{} of the error ({}) is {} of {} ({}): {}.", share > 0.5 ? "Most" : "The largest part", humanPercent(share),
                       textOfKey("shading"), textOfKey("asset"), textOfKey("kind"), remedyOf(textOfKey("kind")));
}

std::string lineOf(const Json& whole) {
    return fmt::format("whole shading: {} of its light (RMS), at most {}. {}", humanPercent(figure(whole, "rel_rms")),
                       humanPercent(figure(whole, "rel_rms_bound")), adviceOf(whole));
}

}  // namespace lightcook::pipeline
