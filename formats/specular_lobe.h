// Specular lobes: the microfacet distribution, or Phong lobe, that cubemaps, tables, dominant light and shader of a scene share.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

#include "formats/vocabulary.h"
#include "lighting/area_specular.h"

namespace lightcook::formats {

using lighting::SpecularLobe;

struct SpecularLobeInfo {
    SpecularLobe id;
    std::string_view name;  ///< as in `lobe`, `--lobe` and the manifest
    std::string_view caption;
    /// The distribution of a Cook-Torrance lobe, which a whole scene may have. Empty for Phong lobes: tables alone have them.
    std::optional<lighting::NormalDistribution> distribution;
};

inline constexpr std::array kSpecularLobes = {
    SpecularLobeInfo{SpecularLobe::Beckmann, "beckmann", "Cook-Torrance with Beckmann's distribution",
                     lighting::NormalDistribution::Beckmann},
    SpecularLobeInfo{SpecularLobe::Ggx, "ggx", "Cook-Torrance with the GGX distribution; m is alpha", lighting::NormalDistribution::Ggx},
    SpecularLobeInfo{SpecularLobe::Phong, "phong", "exp(-tan^2 a / m^2) / (pi m^2 cos^3 a) around the reflected view", std::nullopt},
    SpecularLobeInfo{SpecularLobe::PhongPower, "phong-power", "(s + 1) / (2 pi) cos^s a around the reflected view, s = 2 / m^2 - 2",
                     std::nullopt},
};
static_assert(isCompleteTable(kSpecularLobes, SpecularLobe::PhongPower));

constexpr std::span<const SpecularLobeInfo> allSpecularLobes() {
    return kSpecularLobes;
}
/// Returns the lobes that a scene may have, in the order of lighting::NormalDistribution.
constexpr std::span<const SpecularLobeInfo> sceneLobes() {
    return std::span<const SpecularLobeInfo>(kSpecularLobes).first(2);
}
static_assert(sceneLobes()[0].distribution == lighting::NormalDistribution::Beckmann &&
              sceneLobes()[1].distribution == lighting::NormalDistribution::Ggx);

constexpr const SpecularLobeInfo& info(SpecularLobe lobe) {
    return kSpecularLobes[static_cast<std::size_t>(lobe)];
}
constexpr const SpecularLobeInfo& info(lighting::NormalDistribution distribution) {
    return sceneLobes()[static_cast<std::size_t>(distribution)];
}

}  // namespace lightcook::formats
