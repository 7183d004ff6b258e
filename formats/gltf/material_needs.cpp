// A material is a list of specular lobes, each with a range of f0 and of the Beckmann roughness m. Its needs are the union of the ranges.
//
//   metallic-roughness    m = roughnessFactor^2, f0 = (1 - metallic) dielectric + metallic baseColor
//   specular-glossiness   m = (1 - glossinessFactor)^2, f0 = specularFactor
//   clear coat            m = clearcoatRoughnessFactor^2, f0 = 0.04 clearcoatFactor
//
// A texture multiplies its factor by a value of [0, 1]. It is not read: the range is that of any such texture.
//
// Sources: glTF 2.0 section 3.9 and appendix B; KHR_materials_specular: dielectric f0 = min(f0(ior) specularColorFactor, 1) specularFactor;
// KHR_materials_ior: f0(ior) = ((ior - 1) / (ior + 1))^2; KHR_materials_pbrSpecularGlossiness; KHR_materials_clearcoat.
#include "formats/gltf/material_needs.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "formats/file/one_line.h"

namespace lightcook::formats {
namespace {

constexpr const char *kUnlitExtension = "KHR_materials_unlit", *kIorExtension = "KHR_materials_ior",
                     *kSpecularExtension = "KHR_materials_specular", *kGlossinessExtension = "KHR_materials_pbrSpecularGlossiness",
                     *kClearcoatExtension = "KHR_materials_clearcoat";
/// Extensions that are read, and those that leave the reflection of a surface as it is.
constexpr std::array<std::string_view, 9> kWithoutWarning = {kUnlitExtension,
                                                             kIorExtension,
                                                             kSpecularExtension,
                                                             kGlossinessExtension,
                                                             kClearcoatExtension,
                                                             "KHR_materials_dispersion",
                                                             "KHR_materials_emissive_strength",
                                                             "KHR_materials_variants",
                                                             "KHR_materials_volume"};
/// Part of the name of every extension that changes how a surface reflects light.
constexpr std::string_view kOfMaterials = "_materials_";

constexpr double kClearcoatF0 = 0.04;

struct Range {
    double low = 0, high = 0;
};

/// Reflectance at normal incidence and Beckmann roughness.
struct Lobe {
    Range f0, m;
    bool isVisible = true;  ///< false: it reflects nothing, not even at grazing angles
};

Json member(const Json& object, const char* key) {
    return object.is_object() && object.contains(key) ? object[key] : Json::object();
}

double unit(double value) {
    return std::clamp(value, 0.0, 1.0);
}

Range unite(const Range& a, const Range& b) {
    return {std::min(a.low, b.low), std::max(a.high, b.high)};
}

Range squared(const Range& range) {
    return {range.low * range.low, range.high * range.high};
}

/// Returns the range of a factor times a texture.
Range textured(const Range& factor, bool hasTexture) {
    return {hasTexture ? 0 : factor.low, factor.high};
}

/// Returns the range of a factor of [0, 1] times a texture.
Range valueOf(const Json& owner, const char* factor, double absent, const char* texture) {
    const double value = unit(owner.value(factor, absent));
    return textured({value, value}, owner.contains(texture));
}

/// Returns the range of the three channels of a colour.
Range channelsOf(const Json& owner, const char* factor) {
    const Json color = member(owner, factor);
    if (!color.is_array() || color.size() < 3) return {1, 1};
    const auto [low, high] = std::minmax({color[0].get<double>(), color[1].get<double>(), color[2].get<double>()});
    return {low, high};
}

/// Returns the f0 of the part that is no metal.
Range dielectricF0(const Json& specular, double ior) {
    const double factor = specular.value("specularFactor", 1.0);
    const Range color = channelsOf(specular, "specularColorFactor");
    const double fromIor = (ior - 1) / (ior + 1) * ((ior - 1) / (ior + 1));
    return textured({unit(fromIor * color.low) * factor, unit(fromIor * color.high) * factor},
                    specular.contains("specularTexture") || specular.contains("specularColorTexture"));
}

Lobe metallicRoughnessLobe(const Json& material) {
    const Json extensions = member(material, "extensions"), specular = member(extensions, kSpecularExtension);
    const Json pbr = member(material, "pbrMetallicRoughness");
    const Range metallic = valueOf(pbr, "metallicFactor", 1, "metallicRoughnessTexture");
    const Range dielectric = dielectricF0(specular, member(extensions, kIorExtension).value("ior", 1.5));
    const Range metal = textured(channelsOf(pbr, "baseColorFactor"), pbr.contains("baseColorTexture"));
    // f0 is linear in each: its extremes lie at the ends of the ranges.
    Range f0{1, 0};
    for (const double share : {metallic.low, metallic.high})
        f0 = unite(f0, {unit((1 - share) * dielectric.low + share * metal.low), unit((1 - share) * dielectric.high + share * metal.high)});
    return {f0, squared(valueOf(pbr, "roughnessFactor", 1, "metallicRoughnessTexture")),
            metallic.high > 0 || specular.value("specularFactor", 1.0) > 0};
}

Lobe specularGlossinessLobe(const Json& extension) {
    constexpr const char* kTexture = "specularGlossinessTexture";
    const Range glossiness = valueOf(extension, "glossinessFactor", 1, kTexture);
    return {textured(channelsOf(extension, "specularFactor"), extension.contains(kTexture)),
            squared({1 - glossiness.high, 1 - glossiness.low})};
}

Lobe clearcoatLobe(const Json& extension) {
    const Range coat = valueOf(extension, "clearcoatFactor", 0, "clearcoatTexture");
    return {{kClearcoatF0 * coat.low, kClearcoatF0 * coat.high},
            squared(valueOf(extension, "clearcoatRoughnessFactor", 0, "clearcoatRoughnessTexture")),
            coat.high > 0};
}

/// Returns the lobes of a material, at least one. One with specular-glossiness and metallic-roughness has both: an engine that does not
/// know the former shows the latter.
std::vector<Lobe> lobesOf(const Json& material) {
    const Json extensions = member(material, "extensions");
    const bool hasGlossiness = extensions.contains(kGlossinessExtension);
    std::vector<Lobe> lobes;
    if (!hasGlossiness || material.contains("pbrMetallicRoughness")) lobes.push_back(metallicRoughnessLobe(material));
    if (hasGlossiness) lobes.push_back(specularGlossinessLobe(extensions[kGlossinessExtension]));
    if (extensions.contains(kClearcoatExtension)) lobes.push_back(clearcoatLobe(extensions[kClearcoatExtension]));
    return lobes;
}

}  // namespace

MaterialNeeds materialNeeds(const Json& material) {
    MaterialNeeds needs;
    needs.name = material.value("name", "");
    needs.unreadExtensions = unreadExtensions(material);
    const Json extensions = member(material, "extensions");
    if (extensions.contains(kUnlitExtension)) {
        needs.isSpecular = false;
        return needs;
    }
    needs.hasNormalMap = material.contains("normalTexture") || member(extensions, kClearcoatExtension).contains("clearcoatNormalTexture");
    std::vector<Lobe> lobes = lobesOf(material);
    needs.isSpecular = std::ranges::any_of(lobes, &Lobe::isVisible);
    // Without a visible lobe the ranges still count: the scene file may say `specular = true`.
    if (needs.isSpecular) std::erase_if(lobes, [](const Lobe& lobe) { return !lobe.isVisible; });
    Lobe all = lobes.front();
    for (const Lobe& lobe : lobes) all = {unite(all.f0, lobe.f0), unite(all.m, lobe.m)};
    needs.mMin = all.m.low;
    needs.mMax = all.m.high;
    needs.f0Min = all.f0.low;
    needs.f0Max = all.f0.high;
    return needs;
}

std::vector<std::string> unreadExtensions(const Json& material) {
    const Json extensions = member(material, "extensions");
    std::vector<std::string> names;
    if (extensions.contains(kUnlitExtension)) return names;  // nothing is reflected
    for (const auto& [name, extension] : extensions.items())
        if (name.find(kOfMaterials) != std::string::npos && std::ranges::find(kWithoutWarning, name) == kWithoutWarning.end())
            names.push_back(oneLine(name));
    return names;
}

}  // namespace lightcook::formats
