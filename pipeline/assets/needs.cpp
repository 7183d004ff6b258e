#include "pipeline/assets/needs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "fit/environment_sh.h"
#include "formats/light_map_layout.h"
#include "formats/specular_lobe.h"
#include "pipeline/scene/cubemap_layout.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

constexpr double kSmallestShadedM = 0.005;  ///< the smallest that verify::LightMapVerifier takes

struct MaterialFacts {
    bool normalMap, specular;
    Range m, f0;
    double normalMapTilt = Needs().normalMapTilt;
};

MaterialFacts factsOf(const MaterialRecord& material) {
    return {material.hasNormalMap, material.isSpecular, {material.m[0], material.m[1]}, {material.f0[0], material.f0[1]}};
}

void lay(const MaterialEntry& entry, MaterialFacts& over) {
    if (entry.normalMap) over.normalMap = *entry.normalMap;
    if (entry.specular) over.specular = *entry.specular;
    if (entry.m) over.m = *entry.m;
    if (entry.f0) over.f0 = *entry.f0;
    if (entry.normalMapTilt) over.normalMapTilt = *entry.normalMapTilt;
}

Range unite(const Range& a, const Range& b) {
    return {std::min(a.low, b.low), std::max(a.high, b.high)};
}

}  // namespace

Needs resolveNeeds(const Scene& scene, const std::vector<MaterialRecord>& meshMaterials) {
    const Needs everything;
    const MaterialFacts unknown{everything.normalMap, everything.specular, everything.m, everything.f0};
    std::map<std::string, MaterialFacts> materials;
    for (const MaterialRecord& material : meshMaterials) {
        const MaterialFacts other = factsOf(material);
        const auto [place, isNew] = materials.emplace(material.name, other);
        if (isNew) continue;  // the same name in two meshes: both count
        place->second = {place->second.normalMap || other.normalMap, place->second.specular || other.specular,
                         unite(place->second.m, other.m), unite(place->second.f0, other.f0)};
    }
    const bool isStated =
        !materials.empty() || std::ranges::any_of(scene.materials, [](const MaterialEntry& each) { return each.m.has_value(); });
    if (materials.empty()) materials.emplace("", unknown);
    for (const MaterialEntry& entry : scene.materials) {
        if (entry.name == "*") {
            for (auto& [name, facts] : materials) lay(entry, facts);
        } else {
            lay(entry, materials.emplace(entry.name, unknown).first->second);
        }
    }
    Needs needs;
    needs.specular = needs.normalMap = false;
    needs.isRoughnessKnown = isStated;
    std::optional<Range> m, f0;
    double tilt = 0;
    for (const auto& [name, facts] : materials) {
        needs.normalMap = needs.normalMap || facts.normalMap;
        if (facts.normalMap) tilt = std::max(tilt, facts.normalMapTilt);
        if (!facts.specular) continue;
        needs.specular = true;
        m = m ? unite(*m, facts.m) : facts.m;
        f0 = f0 ? unite(*f0, facts.f0) : facts.f0;
    }
    needs.m = m.value_or(everything.m);
    needs.f0 = f0.value_or(everything.f0);
    if (needs.normalMap) needs.normalMapTilt = tilt;
    return needs;
}

verify::LightMapShading shadingOf(const Scene& scene, const Needs& needs) {
    verify::LightMapShading shading;
    shading.specular = needs.specular;
    shading.lobe = formats::info(scene.lobe).distribution.value_or(shading.lobe);
    // A mirror (m = 0) has no area specular: the verifier's smallest lobe stands for it.
    shading.m = samplesOf({std::max(needs.m.low, kSmallestShadedM), std::max(needs.m.high, kSmallestShadedM)}, shading.m);
    shading.f0 = samplesOf(needs.f0, shading.f0);
    if (!needs.needsDirections()) shading.normalCount = 1;
    shading.normalMapTilt = needs.normalMap ? needs.normalMapTilt : 0;
    return shading;
}

std::string lightMapLayoutFor(const Scene& scene, const Needs& needs, const LightMapEntry& entry) {
    const std::string asked = layoutAsked(scene.output);
    const auto known = formats::lightMapLayoutFromName(asked);
    const bool isForEngine = known && formats::info(*known).isForEngine;
    const formats::LightMapLayoutInfo& flat = formats::info(formats::LightMapLayout::Flat);
    const bool isFlatRead = !isForEngine && formats::mayTake(layoutsFor(scene.output, entry), flat);
    return needs.needsDirections() || asked == kAutoLayout || formats::isFlat(asked) || !isFlatRead ? asked : std::string(flat.name);
}

double largestExponentFor(const Needs& needs, const std::vector<double>& exponents) {
    const double sharpest = needs.m.low > 0 ? fit::phongExponent(needs.m.low) : exponents.back();
    const auto row = std::ranges::lower_bound(exponents, sharpest);
    return row == exponents.end() ? exponents.back() : *row;
}

int unreadLevelsOf(const Needs& needs, int size) {
    if (!needs.isRoughnessKnown) return 0;
    const int last = lastCubemapLevel(size);  // perceptual roughness grows evenly up to 1 there
    const int unread = static_cast<int>(std::floor(std::sqrt(needs.m.low) * last));
    return std::clamp(unread, 0, std::max(0, last - lastCubemapLevel(kLeastReadSize)));
}

TableRows tableRowsFor(const Needs& needs) {
    // A bilinear fetch at m between rows needs both; a range inside one row still needs two, since a table of one row has no slope.
    const int first = std::clamp(static_cast<int>(std::floor(needs.m.low * 16)) - 1, 0, 14);
    const int last = std::clamp(static_cast<int>(std::ceil(needs.m.high * 16)) - 1, first + 1, 15);
    return {first, last - first + 1};
}

std::vector<double> samplesOf(const Range& range, const std::vector<double>& usual) {
    std::vector<double> samples = {range.low, range.high};
    for (const double value : usual)
        if (value > range.low && value < range.high) samples.push_back(value);
    std::sort(samples.begin(), samples.end());
    samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
    return samples;
}

}  // namespace lightcook::pipeline
