// What a cooked light map is worth: every texel decoded through the shipped shader (compiled as C++), shaded, and held against the float
// bake; sampled and bounded, stage by stage. It knows layouts by their names and constants only: nothing of the encoder.
//
// Use, by bands of rows that may be worked on in any order and merged in a fixed one:
//   1. LightMapKey over the reference                   -> key
//   2. LightMapVerifier::create, verifyRows on each band -> LightMapErrors, merged, -> stages()
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/gpu_texture.h"
#include "formats/image.h"
#include "formats/light_map.h"
#include "verify/figures.h"

namespace lightcook::verify {

/// A light map as its manifest describes it.
struct CookedLightMap {
    std::string layout;  ///< "raw" "flat" "luvw" "luvw-linear" "ratio" "zh3" "basis-3" "basis-4" "basis-8" "basis-12" "basis-16"
    std::map<std::string, std::vector<float>> constants;  ///< as compress::LightMapPlan::constants
    int width = 0, height = 0;                            ///< [texels]
    /// Of each texture, in the order of LightMapVerifier::textures(): what a sampler is free to do with it goes into the bounds. Empty: an
    /// ideal sampler.
    std::vector<formats::PixelFormat> formats = {};
};

/// What the scene shades with. Sampled: every m, every F0, `viewCount` views (spherical Fibonacci points of the upper hemisphere). The
/// bound covers the whole ranges [min m, max m] x [min F0, max F0] and every view.
struct LightMapShading {
    bool specular = true;
    std::vector<double> m = {0.1, 0.25, 0.5};
    std::vector<double> f0 = {0.04, 0.6};
    int viewCount = 8;
    int normalCount = 32;
};

struct LightMapSampling {
    std::uint64_t seed = 1;
    int positionsPerQuad = 1;  ///< random positions between four covered texels; 0: none
    bool bounds = true;        ///< false: figures of the texel centres alone, nothing between them and nothing proven
};

/// Log-average luminance of the reference's exit radiance at the texels' own normals: the key of product.md.
class LightMapKey {
public:
    explicit LightMapKey(const glm::vec3& luminanceWeights = lighting::kRec709Luminance) : luminanceWeights_(luminanceWeights) {}
    /// Rows [firstRow, firstRow + rowCount), which the band must hold.
    void add(const formats::LightMapStrip& band, int firstRow, int rowCount);
    void merge(const LightMapKey& other);
    double key() const;  ///< 0 without covered texels
    std::int64_t coveredTexels() const { return coveredTexels_; }

private:
    glm::vec3 luminanceWeights_;
    double logLuminanceSum_ = 0;
    std::int64_t coveredTexels_ = 0;
};

/// Rows [firstRow, firstRow + height of the images) of every texture as decodeRows gives them, in the order of
/// LightMapVerifier::textures().
struct DecodedLightMapRows {
    int firstRow = 0;
    std::vector<std::vector<formats::Image<glm::vec4>>> textures;  ///< [texture][layer]
    /// blockSpans of each, for formats that have them, else no images: a decoder may take liberties with what lies between the ends.
    std::vector<std::vector<formats::Image<glm::vec4>>> spans = {};  ///< [texture][layer], or nothing at all
};

/// Partial errors of some rows.
class LightMapErrors {
public:
    struct Stage {
        std::string name;
        ErrorAccumulator diffuse, specular;
    };
    explicit LightMapErrors(std::vector<Stage> stages = {}) : accumulators(std::move(stages)) {}
    void merge(const LightMapErrors& other);
    /// In the order of encoding; "magnified" (between texels) is last but one, and the last, "total", is the asset's verdict: texel centres
    /// for relRms and p99, every sampled position for maxSampled, the proven maximum for maxBound. Seconds are 0: the caller measures time.
    std::vector<StageError> stages() const;

    std::vector<Stage> accumulators;
};

class LightMapVerifier {
public:
    struct TextureNeed {
        std::string name;
        int layerCount = 1;
    };

    /// Refuses unknown layouts, missing or wrongly sized constants, constants that are not finite, formats for other textures.
    /// key  of the reference (LightMapKey)
    static formats::Result<LightMapVerifier> create(const CookedLightMap& map, const LightMapShading& shading,
                                                    const LightMapSampling& sampling, double key);
    LightMapVerifier(LightMapVerifier&&) noexcept;
    LightMapVerifier& operator=(LightMapVerifier&&) noexcept;
    ~LightMapVerifier();

    /// The textures and layers of a layout with these constants; refuses what create refuses of them.
    static formats::Result<std::vector<TextureNeed>> texturesOf(const CookedLightMap& map);
    /// The textures and layers that the layout is made of.
    const std::vector<TextureNeed>& textures() const;
    /// Errors of rows [firstRow, firstRow + rowCount), and of the texel quads that begin in them: texels and reference must also hold the
    /// row below, where the map has one and bounds are asked for. Pure; safe to call from several threads.
    LightMapErrors verifyRows(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference, int firstRow, int rowCount) const;
    /// The proven maxima of one quad alone, whose top left texel is (x, y): what verifyRows takes into maxBound. All four texels must be
    /// covered and in texels and reference.
    struct QuadBound {
        double diffuse = 0, specular = 0;
    };
    QuadBound boundQuad(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference, int x, int y) const;
    /// No error at all, to merge into.
    LightMapErrors noErrors() const;
    /// What the shader sees at the texel centres of rows [firstRow, firstRow + rowCount): world frame, canonical phase. A flat map gives
    /// the constant environment of the same exit radiance.
    formats::Image<lighting::ShRgb> reconstruct(const DecodedLightMapRows& texels, int firstRow, int rowCount) const;

private:
    struct State;
    explicit LightMapVerifier(std::unique_ptr<const State> state);
    std::unique_ptr<const State> state_;
};

}  // namespace lightcook::verify
