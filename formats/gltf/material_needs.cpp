// Sources: glTF 2.0 section 3.9 and appendix B; KHR_materials_specular: dielectric f0 = min(f0(ior) specularColorFactor, 1) specularFactor;
// KHR_materials_ior: f0(ior) = ((ior - 1) / (ior + 1))^2.
#include "formats/gltf/material_needs.h"

#include <algorithm>
#include <array>

namespace lightcook::formats {
namespace {

struct Range {
    double low = 0, high = 0;
};

Json member(const Json& object, const char* key) {
    return object.is_object() && object.contains(key) ? object[key] : Json::object();
}

Range rangeOf(const Json& factors, double absent) {
    Range range{absent, absent};
    if (!factors.is_array() || factors.size() < 3) return range;
    const auto [low, high] = std::minmax({factors[0].get<double>(), factors[1].get<double>(), factors[2].get<double>()});
    return {low, high};
}

double unit(double value) {
    return std::clamp(value, 0.0, 1.0);
}

/// f0 of the part that is no metal. A texture multiplies, so it can take anything down to zero.
Range dielectricF0(const Json& material) {
    const Json extensions = member(material, "extensions");
    const double ior = member(extensions, "KHR_materials_ior").value("ior", 1.5);
    const Json specular = member(extensions, "KHR_materials_specular");
    const double factor = specular.value("specularFactor", 1.0);
    const Range color = rangeOf(member(specular, "specularColorFactor"), 1.0);
    const double fromIor = (ior - 1) / (ior + 1) * ((ior - 1) / (ior + 1));
    Range f0{unit(fromIor * color.low) * factor, unit(fromIor * color.high) * factor};
    if (specular.contains("specularTexture") || specular.contains("specularColorTexture")) f0.low = 0;
    return f0;
}

}  // namespace

MaterialNeeds materialNeeds(const Json& material) {
    MaterialNeeds needs;
    needs.name = material.value("name", "");
    const Json extensions = member(material, "extensions");
    if (extensions.contains("KHR_materials_unlit")) {
        needs.isSpecular = false;
        return needs;
    }
    needs.hasNormalMap = material.contains("normalTexture");
    const Json pbr = member(material, "pbrMetallicRoughness");
    const bool hasTexture = pbr.contains("metallicRoughnessTexture");

    const double roughness = unit(pbr.value("roughnessFactor", 1.0));
    needs.mMax = roughness * roughness;
    needs.mMin = hasTexture ? 0.0 : needs.mMax;

    const Range dielectric = dielectricF0(material);
    Range metal = rangeOf(member(pbr, "baseColorFactor"), 1.0);
    if (pbr.contains("baseColorTexture")) metal.low = 0;
    const double metallic = unit(pbr.value("metallicFactor", 1.0));
    // f0 = (1 - metallic) dielectric + metallic metal is linear in each: its extremes lie at the ends of the ranges.
    needs.f0Min = 1;
    needs.f0Max = 0;
    for (const double share : {hasTexture ? 0.0 : metallic, metallic}) {
        needs.f0Min = std::min(needs.f0Min, unit((1 - share) * dielectric.low + share * metal.low));
        needs.f0Max = std::max(needs.f0Max, unit((1 - share) * dielectric.high + share * metal.high));
    }
    needs.isSpecular = metallic > 0 || member(extensions, "KHR_materials_specular").value("specularFactor", 1.0) > 0;
    return needs;
}

}  // namespace lightcook::formats
