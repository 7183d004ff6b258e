// Light-map layouts of other engines, for the bench alone: written from what is published of them, coded with our encoders, decoded with
// the verifier's own decoders, and turned back into nine coefficients so that one score serves all.
//
// Sources: Hu 2008, Lightmap compression in Halo 3 (GDC), and Halo 3's public shaders; Chen and Liu 2008, Lighting and Material of Halo 3;
// Godot 4.4, modules/lightmapper_rd; Unreal Engine's light-map shaders. What a source leaves open is named where it is decided.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compress/light_map.h"
#include "formats/image.h"
#include "formats/light_map.h"

namespace lightcook::bench {

/// A whole light map, and what encoders ask of one.
struct Bake {
    formats::LightMapStrip band;
    compress::LightMapMeasure measure;
    formats::Image<float> significance;  ///< 1 inside charts, else 0

    explicit Bake(formats::LightMapStrip whole);
    int width() const { return band.sh.width(); }
    int height() const { return band.sh.height(); }
};
/// Throws std::runtime_error with the file's name where it cannot be read.
Bake readBake(const std::filesystem::path& file);

/// A bake as one layout gives it back. Outside charts: anything.
struct PeerMaps {
    double bitsPerTexel = 0;
    formats::Image<lighting::ShRgb> ideal;  ///< the layout's form without any coding: what its basis loses
    formats::Image<lighting::ShRgb> seen;   ///< from the bytes: what basis and coding lose
};

struct PeerLayout {
    std::string name;  ///< for tables
    std::string what;  ///< for people: engine and form
    PeerMaps (*make)(const Bake& bake, int effort);
};
/// From few bits to many; the last ones are references without blocks.
const std::vector<PeerLayout>& peerLayouts();

/// A map through the blocks that a plan of ours gives and back by the verifier's decoders. Throws std::runtime_error where the verifier
/// refuses the plan.
formats::Image<lighting::ShRgb> throughPlan(const compress::LightMapPlan& plan, const formats::LightMapStrip& band, int effort);

/// Halo 3 as shipped: bands 0 and 1 as stored, band 2 that of one light in the direction of band 1.
lighting::ShRgb withDominantLight(const lighting::ShRgb& linear, const glm::vec3& intensity);
/// The intensity that it stores: the least-squares fit to all nine coefficients, never negative.
glm::vec3 dominantIntensity(const lighting::ShRgb& sh);

}  // namespace lightcook::bench
