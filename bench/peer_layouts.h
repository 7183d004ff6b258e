// Light-map layouts of other engines, for the benchmarks only. They follow the published descriptions, use our block encoders and the
// verifier's decoders, and decode to nine coefficients, so that one score measures all of them.
//
// Sources: Hu 2008, Lightmap compression in Halo 3 (GDC), and Halo 3's public shaders; Chen and Liu 2008, Lighting and Material of Halo 3;
// Godot 4.4, modules/lightmapper_rd; Unreal Engine's light-map shaders. Where a source leaves a choice open, the code says which one was
// made.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compress/light_map.h"
#include "formats/image.h"
#include "formats/light_map.h"

namespace lightcook::bench {

/// A whole light map with the statistics that encoders need.
struct Bake {
    formats::LightMapStrip strip;
    compress::LightMapMeasure measure;
    formats::Image<float> significance;  ///< 1 inside charts, else 0

    explicit Bake(formats::LightMapStrip whole);
    int width() const { return strip.sh.width(); }
    int height() const { return strip.sh.height(); }
};
/// Reads a light map. Throws std::runtime_error, which names the file, if it cannot be read.
Bake readBake(const std::filesystem::path& file);

/// A bake decoded from one layout. Texels outside charts hold any value.
struct PeerMaps {
    double bitsPerTexel = 0;
    formats::Image<lighting::ShRgb> ideal;  ///< decoded without any encoding loss: the error of the basis alone
    formats::Image<lighting::ShRgb> seen;   ///< decoded from the bytes: the whole error
};

struct PeerLayout {
    std::string name;  ///< for tables
    std::string what;  ///< engine and form, in words
    PeerMaps (*make)(const Bake& bake, int effort);
};
/// Returns the layouts in the order of their bits a texel. The last ones are references without block compression.
const std::vector<PeerLayout>& peerLayouts();

/// Encodes a map with a plan of ours and decodes it with the verifier's decoders. Throws std::runtime_error if the verifier refuses the
/// plan.
formats::Image<lighting::ShRgb> throughPlan(const compress::LightMapPlan& plan, const formats::LightMapStrip& strip, int effort);

/// Returns the light that Halo 3 as shipped decodes: bands 0 and 1 as stored, band 2 that of one light in the direction of band 1.
lighting::ShRgb withDominantLight(const lighting::ShRgb& linear, const glm::vec3& intensity);
/// Returns the intensity that Halo 3 stores for that light: the least-squares fit to all nine coefficients, at least 0.
glm::vec3 dominantIntensity(const lighting::ShRgb& sh);

}  // namespace lightcook::bench
